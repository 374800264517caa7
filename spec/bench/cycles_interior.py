# A room under an overcast sky, from a .glb, for Blender's Cycles: beside pictures of ylm that take as long.
#
#     blender -b --python-exit-code 1 --python spec/bench/cycles_interior.py -- ROOM.glb OUT.exr WIDTH HEIGHT SAMPLES SEED PORTAL
#
# spec/bench/cycles_interior.lua writes the room, runs this and compares. Surfaces are matte; the world is the CIE's overcast sky of
# luminance 20; PORTAL 1 tells Cycles where the window is, which its users do by hand. Nothing is clamped; Debian's Blender 3.4 has
# no denoiser for processors. Prints the processor seconds of the render itself.
import math
import os
import sys

import bpy
import numpy
from mathutils import Vector

room, out, width, height, samples, seed, portal = sys.argv[sys.argv.index("--") + 1:]
numpy.bool = bool  # Blender 3.4's reader of glTF asks for the old name
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=room)
scene = bpy.context.scene
for o in list(scene.objects):
    if o.type in ("LIGHT", "CAMERA"):
        bpy.data.objects.remove(o)


def place(p):
    return (p[0], -p[2], p[1])


for m in bpy.data.materials:
    nodes, links = m.node_tree.nodes, m.node_tree.links
    colour = [n for n in nodes if n.type == "BSDF_PRINCIPLED"][0].inputs["Base Color"].default_value[:]
    nodes.clear()
    s = nodes.new("ShaderNodeBsdfDiffuse")
    s.inputs["Roughness"].default_value = 0
    s.inputs["Color"].default_value = colour
    links.new(s.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])

world = scene.world = bpy.data.worlds.new("sky")
world.use_nodes = True
nodes, links = world.node_tree.nodes, world.node_tree.links
nodes.clear()
at, parts = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeSeparateXYZ")
links.new(at.outputs["Generated"], parts.inputs[0])
above, level = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeMath")
above.operation, above.inputs[1].default_value = "GREATER_THAN", 0
links.new(parts.outputs["Z"], above.inputs[0])
level.operation = "MULTIPLY_ADD"
level.inputs[1].default_value, level.inputs[2].default_value = 2 * 20 / 3, 20 / 3
links.new(parts.outputs["Z"], level.inputs[0])
both, shine = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeBackground")
both.operation = "MULTIPLY"
links.new(above.outputs[0], both.inputs[0])
links.new(level.outputs[0], both.inputs[1])
links.new(both.outputs[0], shine.inputs["Strength"])
shine.inputs["Color"].default_value = (1, 1, 1, 1)
links.new(shine.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])

if portal == "1":
    lamp = bpy.data.lights.new("window", "AREA")
    lamp.shape, lamp.size, lamp.size_y = "RECTANGLE", 0.6, 0.7
    lamp.cycles.is_portal = True
    o = bpy.data.objects.new("window", lamp)
    o.location = place((2.19, 1.45, 0))
    o.rotation_euler = Vector((-1, 0, 0)).to_track_quat("-Z", "Z").to_euler()
    scene.collection.objects.link(o)

camera = bpy.data.cameras.new("camera")
camera.sensor_fit, camera.angle = "VERTICAL", math.radians(65)
o = bpy.data.objects.new("camera", camera)
o.location = place((-1.6, 1.5, 1.2))
o.rotation_euler = (Vector(place((0.8, 0.8, -0.5))) - Vector(place((-1.6, 1.5, 1.2)))).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(o)
scene.camera = o

scene.render.engine = "CYCLES"
c = scene.cycles
c.device, c.samples, c.seed = "CPU", int(samples), int(seed)
c.use_adaptive_sampling = c.use_denoising = False
c.sample_clamp_direct = c.sample_clamp_indirect = 0
c.max_bounces = c.diffuse_bounces = 64
c.pixel_filter_type = "BOX"
scene.render.threads_mode, scene.render.threads = "FIXED", 2
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = int(width), int(height), 100
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.render.image_settings.color_mode = "RGB"
scene.view_settings.view_transform = "Standard"
scene.render.filepath = out
before = os.times()
bpy.ops.render.render(write_still=True)
after = os.times()
print("PROCESSOR %.2f" % (after.user + after.system - before.user - before.system))
