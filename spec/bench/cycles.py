# The room of examples/scenes/room.lua for Blender's Cycles, which judges ylm's path tracer from outside.
#
#     blender -b --python-exit-code 1 --python spec/bench/cycles.py -- OUT.exr WIDTH HEIGHT SAMPLES SEED
#
# ylm's light model in Blender's terms: a flat lamp that emits to both sides is two area lamps back to back, at the same place;
# a sphere lamp is a mesh that emits and lets rays through (Blender 3.4's own are disks that turn to the place that they light);
# y is up in ylm, z in Blender. Paths have 64 bounces; nothing is clamped, nothing denoised. Blender's glossy surfaces reflect
# their colour at all angles: f0 = 1 in both.
import math
import sys

import bpy
from mathutils import Vector

out, width, height, samples, seed = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def place(p):
    return (p[0], -p[2], p[1])


def surface(name, alpha=None, colour=(0.75, 0.75, 0.75)):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    nodes, links = m.node_tree.nodes, m.node_tree.links
    nodes.clear()
    if alpha is None:
        s = nodes.new("ShaderNodeBsdfDiffuse")
        s.inputs["Roughness"].default_value = 0
    else:
        # GGX with single scattering; roughness is the root of alpha
        s = nodes.new("ShaderNodeBsdfGlossy")
        s.distribution = "GGX"
        s.inputs["Roughness"].default_value = math.sqrt(alpha)
    s.inputs["Color"].default_value = (*colour, 1)
    links.new(s.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return m


def mesh(name, vertices, faces, material, smooth=False):
    data = bpy.data.meshes.new(name)
    data.from_pydata([place(v) for v in vertices], [], faces)
    data.materials.append(material)
    for p in data.polygons:
        p.use_smooth = smooth
    o = bpy.data.objects.new(name, data)
    scene.collection.objects.link(o)
    return o


def quad(name, corner, u, v, material):
    c = [[corner[a] + s * u[a] + t * v[a] for a in range(3)] for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return mesh(name, c, [(0, 1, 2, 3)], material)


def sphere(name, at, radius, material):
    n, k = 192, 96
    vertices = [(at[0], at[1], at[2] + radius)]
    for i in range(1, k):
        t = math.pi * i / k
        vertices += [(at[0] + radius * math.sin(t) * math.cos(2 * math.pi * j / n),
                      at[1] + radius * math.sin(t) * math.sin(2 * math.pi * j / n),
                      at[2] + radius * math.cos(t)) for j in range(n)]
    vertices.append((at[0], at[1], at[2] - radius))
    faces = [(0, 1 + j, 1 + (j + 1) % n) for j in range(n)]
    for i in range(k - 2):
        a = 1 + i * n
        faces += [(a + j, a + n + j, a + n + (j + 1) % n, a + (j + 1) % n) for j in range(n)]
    last = len(vertices) - 1
    faces += [(last, last - n + (j + 1) % n, last - n + j) for j in range(n)]
    return mesh(name, vertices, faces, material, True)


white = surface("white")
quad("floor", (-1, 0, 1), (2, 0, 0), (0, 0, -2), white)
quad("ceiling", (-1, 2, -1), (2, 0, 0), (0, 0, 2), white)
quad("back", (-1, 0, -1), (2, 0, 0), (0, 2, 0), white)
quad("left", (-1, 0, 1), (0, 0, -2), (0, 2, 0), surface("red", None, (0.6, 0.1, 0.08)))
quad("right", (1, 0, -1), (0, 0, 2), (0, 2, 0), surface("green", None, (0.1, 0.45, 0.12)))
lo, hi = (0.2, 0, -0.5), (0.7, 0.6, 0)
corners = [(x, y, z) for x in (lo[0], hi[0]) for y in (lo[1], hi[1]) for z in (lo[2], hi[2])]
mesh("box", corners, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)], white)
sphere("rough", (-0.45, 0.4, -0.3), 0.4, surface("rough", 0.3, (1, 1, 1)))
sphere("metal", (0.15, 0.2, 0.45), 0.2, surface("metal", 0.1, (1, 1, 1)))

# The radiance of a square area lamp of Blender is its W over 4 A (a quarter, where pi would make them watts).
for name, turn in (("down", 0), ("up", math.pi)):
    lamp = bpy.data.lights.new(name, "AREA")
    lamp.shape, lamp.size = "SQUARE", 0.7
    lamp.energy = 4 * 0.49 * 8
    lamp.use_shadow = True
    o = bpy.data.objects.new(name, lamp)
    o.location = place((0, 1.8, 0))
    o.rotation_euler = (turn, 0, 0)
    scene.collection.objects.link(o)
# The sphere lamp shines from its outside and lets all rays through.
m = bpy.data.materials.new("ball")
m.use_nodes = True
nodes, links = m.node_tree.nodes, m.node_tree.links
nodes.clear()
side, outside, shine = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeEmission")
outside.operation, outside.inputs[0].default_value = "SUBTRACT", 1
links.new(side.outputs["Backfacing"], outside.inputs[1])
links.new(outside.outputs[0], shine.inputs["Strength"])
shine.inputs["Color"].default_value = (20, 14, 8, 1)
both = nodes.new("ShaderNodeAddShader")
links.new(shine.outputs[0], both.inputs[0])
links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], both.inputs[1])
links.new(both.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
sphere("ball", (-0.6, 1.2, 0.4), 0.1, m)

camera = bpy.data.cameras.new("camera")
camera.sensor_fit, camera.angle = "VERTICAL", math.radians(40)
o = bpy.data.objects.new("camera", camera)
o.location = place((0, 1, 3.4))
o.rotation_euler = (Vector(place((0, 1, 0))) - Vector(place((0, 1, 3.4)))).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(o)
scene.camera = o

scene.render.engine = "CYCLES"
c = scene.cycles
c.device, c.samples, c.seed = "CPU", int(samples), int(seed)
c.use_adaptive_sampling = c.use_denoising = False
c.sample_clamp_direct = c.sample_clamp_indirect = 0
c.max_bounces = c.diffuse_bounces = c.glossy_bounces = 64
c.blur_glossy, c.transparent_max_bounces = 0, 64
c.caustics_reflective = True
c.light_sampling_threshold = 0
c.pixel_filter_type = "BOX"
scene.render.threads_mode, scene.render.threads = "FIXED", 2
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = int(width), int(height), 100
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.view_settings.view_transform = "Standard"
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
