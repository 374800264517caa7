# Irradiance at places by Blender: EEVEE's irradiance volume, or Cycles' bake.
#
#     blender -b --python-exit-code 1 --python blender.py -- SCENE.json OUT.txt cycles QUANTITY SAMPLES
#     xvfb-run -a blender --python-exit-code 1 --python blender.py -- SCENE.json OUT.txt eevee QUANTITY NX,NY,NZ BOUNCES CUBE
#
# SCENE.json has meshes, lamps, panels, sky, points, normals, lo and hi (spec/bench/rivals/blender.lua). OUT.txt gets three
# numbers a place, then a line "SECONDS s BYTES b": processor seconds of the bake. y is up in ylm, z in Blender.
#
# Cycles bakes cards of 2 mm that no other ray sees. A point lamp of Cycles is a disk that turns to the place; a tenth of the
# radius at equal watts takes its error off.
#
# EEVEE bakes with -b missing, since it wants a window. The volume is read by cards that face a camera, all else hidden: their
# diffuse shader has the place's normal.
import json
import math
import os
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

path, out, kind, quantity, *settings = sys.argv[sys.argv.index("--") + 1:]
data = json.load(open(path))
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def place(p):
    return (p[0], -p[2], p[1])


def triples(numbers):
    return [numbers[k:k + 3] for k in range(0, len(numbers), 3)]


def processor():
    t = os.times()
    return t.user + t.system


def shader(name, kind, **inputs):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    nodes, links = m.node_tree.nodes, m.node_tree.links
    nodes.clear()
    s = nodes.new(kind)
    for key, value in inputs.items():
        s.inputs[key].default_value = value
    links.new(s.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return m, s


def add(name, vertices, faces, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([place(v) for v in vertices], [], faces)
    mesh.materials.append(material)
    o = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(o)
    return o


everything = []
for i, m in enumerate(data["meshes"]):
    colour = (*m["colour"], 1)
    if "alpha" in m and kind == "cycles":
        material, s = shader("m%d" % i, "ShaderNodeBsdfGlossy", Color=colour, Roughness=math.sqrt(m["alpha"]))
        s.distribution = "GGX"
    else:
        material, _ = shader("m%d" % i, "ShaderNodeBsdfDiffuse", Color=colour, Roughness=0)
    v = triples(m["positions"])
    everything.append(add("b%d" % i, v, [(k, k + 1, k + 2) for k in range(0, len(v), 3)], material))
for i, p in enumerate(data["panels"]):
    v = triples(p["corners"])
    material, s = shader("p%d" % i, "ShaderNodeEmission", Color=(*p["radiance"], 1), Strength=1)
    nodes, links = material.node_tree.nodes, material.node_tree.links  # rays pass lamps of ylm
    both = nodes.new("ShaderNodeAddShader")
    links.new(s.outputs[0], both.inputs[0])
    links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], both.inputs[1])
    links.new(both.outputs[0], [n for n in nodes if n.type == "OUTPUT_MATERIAL"][0].inputs["Surface"])
    material.blend_method, material.shadow_method, material.show_transparent_back = "BLEND", "NONE", True
    everything.append(add("panel%d" % i, v, [tuple(range(len(v)))], material))
for i, l in enumerate(data["lamps"]):
    lamp = bpy.data.lights.new("l%d" % i, "POINT")
    most = max(l["radiance"])
    lamp.color = [c / most for c in l["radiance"]]
    lamp.energy = 4 * math.pi ** 2 * l["radius"] ** 2 * most
    lamp.shadow_soft_size = l["radius"] * (0.1 if kind == "cycles" else 1)
    lamp.use_custom_distance = False
    if kind == "eevee":
        lamp.shadow_buffer_clip_start, lamp.shadow_buffer_bias = 0.02, 0.01
    o = bpy.data.objects.new("l%d" % i, lamp)
    o.location = place(l["at"])
    scene.collection.objects.link(o)
    everything.append(o)

world = scene.world = bpy.data.worlds.new("world")
world.use_nodes = True
nodes, links = world.node_tree.nodes, world.node_tree.links
nodes.clear()
background = nodes.new("ShaderNodeBackground")
background.inputs["Color"].default_value = (0, 0, 0, 1)
links.new(background.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
if "sky" in data:
    sky, pixels = triples(data["sky"]), []
    for y in range(31, -1, -1):
        for x in range(64):
            pixels += [*sky[64 * y + x], 1]
    image = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    image.colorspace_settings.name = "Linear"
    image.pixels = pixels
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    links.new(texture.outputs[0], background.inputs["Color"])

points = [Vector(place(p)) for p in data["points"]]
normals = [Vector(place(n)) for n in data["normals"]]


def side(n):
    return n.cross(Vector((1, 0, 0) if abs(n.x) < 0.7 else (0, 1, 0))).normalized()


def cards(name, places, directions, size, material):
    """Squares of an edge at places, that look along directions."""
    vertices, faces = [], []
    for p, n in zip(places, directions):
        u = side(n)
        v = n.cross(u)
        faces.append(tuple(range(len(vertices), len(vertices) + 4)))
        vertices += [p + size / 2 * (s * u + t * v) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.materials.append(material)
    o = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(o)
    return o


def cycles(samples):
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.device, c.samples, c.seed = "CPU", samples, 1
    c.use_adaptive_sampling = c.use_denoising = False
    c.sample_clamp_direct = c.sample_clamp_indirect = 0
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transparent_max_bounces = 64
    c.blur_glossy, c.light_sampling_threshold = 0, 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    material, s = shader("cards", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1), Roughness=0)
    o = cards("cards", points, normals, 0.002, material)
    for what in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(o, "visible_" + what, False)
    edge = math.ceil(math.sqrt(len(points)))
    uv = o.data.uv_layers.new()
    for k in range(len(points)):
        x, y = k % edge, k // edge
        for j, (s, t) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
            uv.data[4 * k + j].uv = ((x + s) / edge, (y + t) / edge)
    image = bpy.data.images.new("baked", 4 * edge, 4 * edge, float_buffer=True)
    image.colorspace_settings.name = "Linear"
    nodes = material.node_tree.nodes
    target = nodes.new("ShaderNodeTexImage")
    target.image = image
    nodes.active = target
    bpy.context.view_layer.objects.active = o
    o.select_set(True)
    began, rows = processor(), [[0, 0, 0] for _ in points]

    def bake(what, sign):
        bpy.ops.object.bake(type="DIFFUSE", pass_filter=what, margin=0, use_clear=True)
        pixels = image.pixels[:]
        for k, row in enumerate(rows):
            x, y = 4 * (k % edge), 4 * (k // edge)
            at = [4 * (4 * edge * (y + j) + x + i) for i in range(4) for j in range(4)]
            for c in range(3):
                row[c] += sign * math.pi * sum(pixels[a + c] for a in at) / 16

    bake({"DIRECT", "INDIRECT"}, 1)
    if quantity == "indirect":  # "INDIRECT" alone is black in 3.4
        bake({"DIRECT"}, -1)
    return rows, processor() - began, 12 * len(points)


def eevee(cells, bounces, cube):
    scene.render.engine = "BLENDER_EEVEE"
    e = scene.eevee
    e.light_threshold, e.use_soft_shadows, e.use_gtao = 0, False, False
    e.shadow_cube_size, e.use_shadow_high_bitdepth = "1024", True
    e.gi_diffuse_bounces, e.gi_cubemap_resolution, e.gi_irradiance_smoothing = bounces, cube, 0
    e.gi_glossy_clamp = 0
    e.taa_render_samples = 1
    lo, hi = Vector(place(data["lo"])), Vector(place(data["hi"]))
    probe = bpy.data.lightprobes.new("volume", "GRID")
    probe.grid_resolution_x, probe.grid_resolution_y, probe.grid_resolution_z = cells[0], cells[2], cells[1]
    probe.clip_start, probe.clip_end, probe.influence_distance, probe.falloff = 0.02, 100, 1, 0
    o = bpy.data.objects.new("volume", probe)
    o.location = (lo + hi) / 2
    o.scale = [abs(hi[a] - lo[a]) / 2 for a in range(3)]
    scene.collection.objects.link(o)
    began = processor()
    bpy.ops.scene.light_cache_bake()
    used = processor() - began
    said = e.gi_cache_info
    for b in everything:
        b.hide_render = b.hide_viewport = True
    view = Vector((0.47, 0.61, 0.64)).normalized()
    u = side(view)
    v = view.cross(u)
    middle = (lo + hi) / 2
    size, extent = 2048, 1.2 * (hi - lo).length
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", extent, 3 * extent
    eye = bpy.data.objects.new("camera", camera)
    eye.matrix_world = Matrix(((u.x, v.x, view.x, 0), (u.y, v.y, view.y, 0), (u.z, v.z, view.z, 0), (0, 0, 0, 1)))
    eye.location = middle + extent * view
    scene.collection.objects.link(eye)
    scene.camera = eye
    r = scene.render
    r.resolution_x = r.resolution_y = size
    r.resolution_percentage, r.filter_size = 100, 0.01
    r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Standard"
    r.filepath = out + ".exr"
    pixel, width = extent / size, 5
    at = []
    for p in points:
        d = p - middle
        at.append((int(size / 2 + d.dot(u) / pixel), int(size / 2 + d.dot(v) / pixel)))
    rows, left = [None] * len(points), list(range(len(points)))
    while left:  # cards that would hide others wait for the next picture
        now, taken, later = [], set(), []
        for k in left:
            around = {(at[k][0] + i, at[k][1] + j) for i in range(-4, 5) for j in range(-4, 5)}
            if around & taken:
                later.append(k)
            else:
                taken |= {(at[k][0] + i, at[k][1] + j) for i in range(-2, 3) for j in range(-2, 3)}
                now.append(k)
        material, s = shader("cards", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1), Roughness=0)
        attribute = material.node_tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = "n"
        material.node_tree.links.new(attribute.outputs["Vector"], s.inputs["Normal"])
        o = cards("cards", [points[k] for k in now], [view] * len(now), width * pixel, material)
        layer = o.data.attributes.new("n", "FLOAT_VECTOR", "POINT")
        for j, k in enumerate(now):
            for c in range(4):
                layer.data[4 * j + c].vector = normals[k]
        bpy.ops.render.render(write_still=True)
        picture = bpy.data.images.load(out + ".exr")
        pixels = numpy.empty(4 * size * size, numpy.float32)
        picture.pixels.foreach_get(pixels)
        for k in now:
            b = 4 * (at[k][1] * size + at[k][0])
            rows[k] = [math.pi * float(x) for x in pixels[b:b + 3]]
        bpy.data.images.remove(picture)
        bpy.data.objects.remove(o)
        left = later
    return rows, used, said  # "0 Ref. Cubemaps, 180 Irr. Samples (1.4 MiB in memory)"


def finish():
    rows, used, size = cycles(int(settings[0])) if kind == "cycles" else \
        eevee([int(x) for x in settings[0].split(",")], int(settings[1]), settings[2])
    with open(out, "w") as f:
        for row in rows:
            f.write("%.7g %.7g %.7g\n" % tuple(row))
        f.write("SECONDS %.2f BYTES %s\n" % (used, size))
    if kind == "eevee":
        bpy.ops.wm.quit_blender()


if kind == "cycles":
    finish()
else:  # a window draws once before anything is baked
    def later():
        try:
            finish()
        except Exception:
            import traceback
            traceback.print_exc()
            os._exit(1)
    bpy.app.timers.register(later, first_interval=0.5)
