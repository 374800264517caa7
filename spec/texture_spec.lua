-- Albedo that varies over surfaces: textures at texture coordinates, colours of vertices, and the materials of OBJ files; the
-- same in every renderer.

local ylm = require "ylm"
local core = require "ylm.c.core"
local device = require "spec.support.gpu"
local form = require "ylm.form"
local material = require "ylm.material"
local pictures = require "spec.support.pictures"
local scratch = require "spec.support.scratch"
local ways = require "spec.support.ways"

local can_trace = pcall(require, "ylm.c.scene")

--- An image of w x h texels, each channel of which is f(row, column, channel).
local function image_of(w, h, f)
  local image = ylm.image { size = { w, h } }
  local layer = image:layer()
  for y = 1, h do
    for x = 1, w do
      for c = 1, 3 do layer:set(y, x, c, f(y, x, c)) end
    end
  end
  return image
end

--- Texels without order, from 0 to 1.
local function noise(y, x, c) return (y * 37 + x * 101 + c * 59 + x * y * 7) % 97 / 96 end

--- The bilinear interpolant of texels f of w x h, repeated, v upwards, as its definition has it.
local function bilinear(f, w, h, u, v, c)
  local x, y = u * w - 0.5, (1 - v) * h - 0.5
  local i, j = math.floor(x), math.floor(y)
  local s, t = x - i, y - j
  local function at(row, column) return f(row % h + 1, column % w + 1, c) end
  return (1 - t) * ((1 - s) * at(j, i) + s * at(j, i + 1)) + t * ((1 - s) * at(j + 1, i) + s * at(j + 1, i + 1))
end

--- A square from (0, 0) to (1, 1), seen from the front, whose texture coordinates are a + b x.
local function square(a, b, m, colours)
  local uvs = {}
  for i, p in ipairs { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } } do uvs[i] = { a[1] + b[1] * p[1], a[2] + b[2] * p[2] } end
  return ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
    uvs = uvs, material = m, colours = colours }
end

--- A scene of geometry in a lamp of radiance 1 that is all around it: radiance is albedo.
local function inside(geometry)
  return ylm.scene "in a lamp" {
    camera = ylm.camera { from = { 0.5, 0.5, 2 }, at = { 0.5, 0.5, 0 }, fov = 28 },
    geometry = geometry,
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 50, radiance = 1 },
  }
end

local options = { size = { 24, 24 }, samples = 1, visibility = "none", lmax = 2 }

--- The largest difference of two arrays.
local function apart(a, b) return (core.array_distance(a, b)) end

describe("textures", function()
  it("are bilinear between the centres of texels, repeat, and grow upwards", function()
    if not can_trace then pending "no Embree" end
    local w, h = 5, 3
    for _, m in ipairs { { { 0, 0 }, { 1, 1 } }, { { -1.25, 3.5 }, { 2.75, -1.5 } }, { { 100.3, -7.1 }, { 0.9, 4 } } } do
      local a, b = m[1], m[2]
      local points = inside(square(a, b, ylm.matte { albedo = image_of(w, h, noise) })):prepare(options):points()
      local albedo, position, worst = points.albedo:totable(), points.position:totable(), 0
      assert(#albedo > 400)
      for i, p in ipairs(position) do
        for c = 1, 3 do
          local wanted = bilinear(noise, w, h, a[1] + b[1] * p[1], a[2] + b[2] * p[2], c)
          worst = math.max(worst, math.abs(wanted - albedo[i][c]))
        end
      end
      assert(worst < 2e-4, worst) -- float coordinates near 100 are 4e-6 apart, texels up to 5 of them
    end
  end)

  it("have at a texel's centre its number, and (0, 0) is the bottom left corner", function()
    local mesh = square({ 0.1, 1 / 6 }, { 0.2, 1 / 3 }, nil).mesh -- corners are centres of texels
    local image = image_of(5, 3, noise)
    local albedo = material.at_vertices("spec", ylm.matte { albedo = image }, mesh):totable()
    for i, texel in ipairs { { 3, 1 }, { 3, 2 }, { 2, 2 }, { 2, 1 } } do
      for c = 1, 3 do assert.near(noise(texel[1], texel[2], c), albedo[i][c], 2e-6) end
    end
    local mean, sum = material.albedo("spec", ylm.matte { albedo = image }), 0
    for y = 1, 3 do for x = 1, 5 do sum = sum + noise(y, x, 2) / 15 end end
    assert.near(sum, mean[2], 1e-6)
  end)

  it("count in every renderer at every point", function()
    if not can_trace then pending "no Embree" end
    local s = inside(square({ 0, 0 }, { 1, 1 }, ylm.matte { albedo = image_of(8, 8, noise) }))
    local view = s:prepare(options)
    local truth = view:render { by = "sum" }:layer "albedo"
    local grid = s:bake { probes = ylm.uniform_grid { cells = { 1, 1, 1 }, lmax = 2 } }
    local first, last = truth:get(12, 6, 1), truth:get(12, 18, 1)
    assert(math.abs(first - last) > 0.1)
    for name, image in pairs {
      reference = (view:render { by = "sum" }), double = (view:render { by = "sum", dtype = "double" }),
      grid = (view:render { grid = grid }), raycast = (view:render { by = "rays", light_samples = 4 }),
      field = (view:render { grid = ylm.sphere_lights { at = { { 0, 0, 0 } }, radius = 50, radiance = 1 }.lights }),
    } do
      assert(apart(truth, image:layer()) < 3e-6, name)
    end
    if s.pathtrace then
      local mean = s:render { by = "sum", size = { 24, 24 }, samples = 64, share = 10, visibility = "none",
        lmax = 2 }:layer "albedo"
      local paths = s:pathtrace { size = { 24, 24 }, samples = 64, bounces = 0 }:layer()
      local product, power = 0, 0
      for y = 1, 24 do
        for x = 1, 24 do
          product, power = product + mean:get(y, x, 1) * paths:get(y, x, 1), power + mean:get(y, x, 1) ^ 2
        end
      end
      assert.near(1, product / power, 0.02) -- without the texture 1.6
    end
    local found = device.choose()
    if found then
      local gpu = assert(device.open())
      assert(apart(truth, (view:render { grid = grid, device = gpu }):layer()) < 1e-5)
      gpu:close()
    end
  end)

  it("are means over the samples of a shading point, and the vertices' where vertices are shaded", function()
    if not can_trace then pending "no Embree" end
    local checker = image_of(64, 64, function(y, x) return (x + y) % 2 end)
    local s = inside(square({ 0, 0 }, { 1, 1 }, ylm.matte { albedo = checker }))
    local image = s:render { by = "sum", size = { 2, 2 }, samples = 256, share = 10, visibility = "none", lmax = 2 }
    assert.near(0.5, image:layer "albedo":get(1, 1, 1), 0.05)
    assert.near(image:layer "albedo":get(1, 1, 1), image:layer():get(1, 1, 1), 1e-5)
    local smooth = inside(square({ 0.25, 0.25 }, { 0.5, 0.5 }, ylm.matte { albedo = image_of(2, 2, noise) }))
    local by_vertex = { size = { 24, 24 }, samples = 1, shading = "vertices", lmax = 2, visibility = "none" }
    local points = smooth:prepare(by_vertex):points()
    assert.equal(4, #points.albedo)
    assert.near(noise(2, 1, 1), points.albedo:get(1, 1), 1e-6)
    assert(apart(smooth:render(ways.sum(by_vertex)):layer "albedo", smooth:render(ways.sum(options)):layer "albedo") < 1e-6)
  end)

  it("are taken from the image when the material is made, and multiplied by albedo where they come from a file", function()
    local folder = scratch.new()
    local path = folder.path .. "/half.png"
    local decoded = ((128 / 255 + 0.055) / 1.055) ^ 2.4 -- of the byte 128
    local image = image_of(1, 1, function() return decoded end)
    assert(image:save(path))
    local m = ylm.matte { albedo = image }
    image:layer():set(1, 1, 1, 0.9)
    assert.near(decoded, material.albedo("spec", m)[1], 1e-6)
    local file = ylm.matte { file = path, albedo = { 1, 0.5, 0 } }
    local a = material.albedo("spec", file)
    assert.near(decoded, a[1], 1e-6)
    assert.near(a[1] / 2, a[2], 1e-6)
    assert.equal(0, a[3])
    assert.same({ 0.5, 0.5, 0.5 }, material.albedo("spec", ylm.matte {}))
    folder:remove()
  end)

  it("are refused where a number is outside of 0 to 1, and where a mesh has no texture coordinates", function()
    local function refuses(says, f, ...)
      local ok, message = pcall(f, ...)
      assert(not ok and message:find(says, 1, true), tostring(message))
    end
    local bright = image_of(3, 2, function(y, x, c) return y == 2 and x == 3 and c == 2 and 1.5 or 0.5 end)
    refuses("albedo: row 2, column 3: green must be from 0 to 1, got 1.5", ylm.matte, { albedo = bright })
    bright:layer():set(2, 3, 2, 0 / 0)
    refuses("row 2, column 3: green must be from 0 to 1", ylm.matte, { albedo = bright })
    refuses("albedo must be a number or {r, g, b}, finite >= 0 and <= 1, or a ylm.image, got 2", ylm.matte, { albedo = 2 })
    local good = image_of(2, 2, noise)
    refuses("not both", ylm.matte, { albedo = good, file = "a.png" })
    local bare = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }
    bare.material = ylm.matte { albedo = good }
    refuses("the material has a texture, and the mesh no texture coordinates (uvs; of an OBJ file vt)", ylm.mesh, bare)
    if can_trace then
      bare.material = nil
      local s = inside { ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }, ylm.mesh(bare) }
      s.geometry[2].material = ylm.matte { albedo = good }
      refuses("mesh 2: a texture needs texture coordinates (uvs), the mesh has none", s.prepare, s, options)
      s.geometry[2].name = "lid"
      refuses("mesh 2, 'lid': a texture needs texture coordinates (uvs), the mesh has none", s.prepare, s, options)
    end
    good:close()
    refuses("the image has been closed", ylm.matte, { albedo = good })
    local none, message, code = ylm.matte { file = "no such file.png" }
    assert(none == nil and code == "EIO" and message:find("no such file.png", 1, true))
  end)
end)

describe("colours of vertices", function()
  local folder = scratch.new()
  teardown(function() folder:remove() end)

  local function ply(kind, rows)
    local head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    for _, name in ipairs { "red", "green", "blue", "alpha" } do head = head .. ("property %s %s\n"):format(kind, name) end
    head = head .. "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    folder:write("a.ply", head .. "0 0 0 " .. rows[1] .. "\n1 0 0 " .. rows[2] .. "\n0 1 0 " .. rows[3] .. "\n3 0 1 2\n")
    return ylm.mesh { file = folder.path .. "/a.ply" }
  end

  it("are read from PLY: bytes are sRGB-encoded, floats linear, other types are no colours", function()
    local c = ply("uchar", { "255 128 0 255", "0 0 0 0", "10 20 30 40" }).mesh:colours():totable()
    assert.near(1, c[1][1], 1e-6)
    assert.near(((128 / 255 + 0.055) / 1.055) ^ 2.4, c[1][2], 1e-6)
    assert.near(10 / 255 / 12.92, c[3][1], 1e-7)
    c = ply("float", { "1 0.5 0 1", "0.25 0 0 1", "0 0 0 1" }).mesh:colours():totable()
    assert.same({ { 1, 0.5, 0 }, { 0.25, 0, 0 }, { 0, 0, 0 } }, c)
    c = ply("ushort", { "65535 0 0 1", "0 0 0 0", "0 0 0 0" }).mesh:colours():totable()
    assert.near(1, c[1][1], 1e-6)
    assert.is_nil(ply("int", { "1 0 0 1", "0 0 0 1", "0 0 0 1" }).mesh:colours())
    local none, message, code = ply("float", { "1 0.5 0 1", "0.25 7 0 1", "0 0 0 1" })
    assert.same({ nil, "EFORMAT" }, { none, code })
    assert.truthy(message:find("a.ply:15: vertex 2: green must be from 0 to 1, got 7", 1, true), message)
  end)

  it("are saved and read again as they are, and refused beyond 0 to 1", function()
    local m = square({ 0, 0 }, { 1, 1 }, nil, { { 1, 0, 0.1 }, { 0, 1, 0.2 }, { 0.3, 0.7, 1 }, { 0, 0, 0 } }).mesh
    assert(m:save(folder.path .. "/b.ply"))
    local again = assert(ylm.load(folder.path .. "/b.ply"))
    assert.same(m:colours():totable(), again:colours():totable())
    local ok, message = pcall(square, { 0, 0 }, { 1, 1 }, nil, { { 1, 0, 0 }, { 0, 1.25, 0 }, { 0, 0, 0 }, { 0, 0, 0 } })
    assert(not ok and message:find("colours: row 2 has 1.25", 1, true), message)
    ok = pcall(square, { 0, 0 }, { 1, 1 }, nil, { { 1, 0, 0 } })
    assert.is_false(ok)
  end)

  it("multiply the material's albedo, and its texture", function()
    if not can_trace then pending "no Embree" end
    local c = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 } }
    local plain = inside(square({ 0, 0 }, { 1, 1 }, ylm.matte { albedo = 0.8 }, c)):prepare(options)
    local points = plain:points()
    local position, albedo = points.position:totable(), points.albedo:totable()
    for i, p in ipairs(position) do
      local x, y = p[1], p[2]
      local red = y < x and 1 - x or 1 - y + (y - x) -- corners 1 2 3 below the diagonal, 1 3 4 above
      assert.near(0.8 * red, albedo[i][1], 1e-5)
    end
    assert(apart(plain:render { by = "sum" }:layer "albedo", plain:render { by = "rays", light_samples = 4 }:layer()) < 3e-6)
    local both = inside(square({ 0, 0 }, { 1, 1 }, ylm.matte { albedo = image_of(1, 1, function() return 0.25 end) }, c))
    local darker = both:prepare(options):points().albedo:totable()
    for i = 1, #darker do assert.near(albedo[i][2] / 0.8 * 0.25, darker[i][2], 1e-6) end
  end)
end)

describe("materials of OBJ files", function()
  local folder = scratch.new()
  teardown(function() folder:remove() end)
  local said
  before_each(function()
    said = {}
    ylm.on_warning(function(message) said[#said + 1] = message end)
  end)
  after_each(function() ylm.on_warning() end)

  local corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"

  --- The mesh of an OBJ file and its library.
  local function obj(text, library, more)
    folder:write("a.obj", text)
    if library then folder:write("a.mtl", library) end
    local fields = { file = folder.path .. "/a.obj" }
    for k, v in pairs(more or {}) do fields[k] = v end
    return ylm.mesh(fields)
  end

  it("make a part for each name, with albedo, texture and light, and keep the mesh whole", function()
    folder:write("my lib.mtl", "# CRLF\r\nnewmtl left half\r\nKa 1 1 1\r\nKd 0.9 \\\r\n 0.1 0.2\r\nillum 2\r\n"
      .. "newmtl right\r\nKd 0.5\r\nmap_Kd -s 2 2 2 -clamp on my tex.png\r\nnewmtl lamp\r\nKe 4 5 6\r\n")
    assert(image_of(2, 2, noise):save(folder.path .. "/my tex.png", { bits = 16 }))
    local m = assert(obj("mtllib my lib.mtl\n" .. corners .. "usemtl left half\nf -4/-4 -3/-3 -1/-1\nusemtl unused\n"
      .. "usemtl right\nf 2/2 3/3 4/4\nusemtl lamp\nv 0 0 3\nv 1 0 3\nv 1 1 3\nv 0 1 3\nf 5 6 7 8\n"
      .. "usemtl left half\nf 1/1 2/2 4/4\n", nil, { at = { 0, 0, 1 } }))
    assert.same({ 5, 2 }, { #m.mesh, #m.parts })
    assert.same({ "left half", 2, "right", 1 }, { m.parts[1].name, #m.parts[1].mesh, m.parts[2].name, #m.parts[2].mesh })
    local left, right = material.albedo("spec", m.parts[1].material), m.parts[2].material
    assert.near(0.1, left[2], 1e-7)
    assert.same({ 0.5, 0.5, 0.5 }, right.albedo)
    local seen = material.at_vertices("spec", right, m.parts[2].mesh)
    assert.near(0.5 * bilinear(noise, 2, 2, 1, 0, 1), seen:get(1, 1), 2e-5) -- 16 bits of sRGB
    assert.same({ { 0, 0, 1 }, { 1, 0, 1 }, { 0, 1, 1 } }, m.parts[1].mesh:vertices():totable())
    assert.same({}, said)
    local notes = table.concat(m.notes, "\n")
    assert.truthy(notes:find("my lib.mtl: 4 statements are not read: Ka, illum, -s, -clamp", 1, true), notes)
    local lamps = "a.obj: 2 triangles of materials with Ke emit light to both sides as polygon lights"
    assert.truthy(notes:find(lamps, 1, true), notes)

    local s = ylm.scene "of a file" { geometry = { ylm.box {}, { m } },
      camera = ylm.camera { from = { 0.5, 0.5, 3 }, at = { 0.5, 0.5, 0 } } }
    assert.same({ 3, 2 }, { #s.geometry, #s.lights })
    assert.same({ { 0, 0, 4 }, { 1, 0, 4 }, { 1, 1, 4 } }, s.lights[1].vertices)
    assert.same({ 4, 5, 6 }, s.lights[2].radiance)
    assert.same(m.notes, s.notes)
    if not can_trace then return end
    local image, report = s:render { bounces = 0, size = { 16, 16 }, samples = 1, light_samples = 4 }
    assert.same(s.notes, report.notes)
    local albedo = image:layer "albedo"
    assert.near(0.9, albedo:get(12, 5, 1), 1e-6)
    assert(math.abs(albedo:get(5, 12, 1) - albedo:get(5, 12, 2)) > 1e-3)
  end)

  it("give a file of one material that one, and a file without a library nothing", function()
    local m = assert(obj("mtllib a.mtl\n" .. corners .. "usemtl x\nf 1 2 3\n", "newmtl x\nKd 0.25\n"))
    assert.same({ nil, 1, "x" }, { m.parts, #m.mesh, m.name })
    assert.same({ 0.25, 0.25, 0.25 }, m.material.albedo)
    m = assert(obj(corners .. "usemtl x\nf 1 2 3\nusemtl y\nf 1 2 4\n"))
    assert.is_nil(m.parts or m.material or m.notes)
    m = assert(obj("mtllib none.mtl\n" .. corners .. "usemtl x\nf 1 2 3\nusemtl y\nf 1 2 4\n"))
    assert.same({ nil, nil, 1, 1, 2 }, { m.parts, m.material, #m.notes, #said, #m.mesh })
    m = assert(obj("mtllib a.mtl\n" .. corners .. "usemtl x\nf 1 2 3\n", "newmtl x\nKd 0.25\n",
      { material = ylm.matte { albedo = 1 } }))
    assert.same({ 1, 1, 1 }, m.material.albedo)
    m = assert(obj("mtllib a.mtl\n" .. corners .. "f 1 2 3\nusemtl x\nf 1 2 4\n", "newmtl x\nKd 0\n"))
    assert.same({ nil, { 0, 0, 0 } }, { m.parts[1].material, m.parts[2].material.albedo })
    assert.equal(2, #ylm.load(folder.path .. "/a.obj", { materials = true }).parts)
    assert.equal(2, #ylm.load(folder.path .. "/a.obj"))
  end)

  it("are phong where they have highlights, and reflect no more than arrives", function()
    local m = assert(obj("mtllib a.mtl\n" .. corners .. "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\nusemtl c\nf 2 3 4\n",
      "newmtl a\nKd 0.5 0.4 0.3\nKs 0.25 0.1 0\nNs 96\nnewmtl b\nKd 1 0.5 0\nKs 0.5 0.75 0.25\nnewmtl c\nKd 0.5\nKs 0\n"))
    local a, b, c = m.parts[1].material, m.parts[2].material, m.parts[3].material
    assert.same({ "phong", "phong", "matte" }, { form.kind(a), form.kind(b), form.kind(c) })
    local function near(wanted, got)
      for i = 1, 3 do assert.near(wanted[i], got[i], 2e-6) end
    end
    near({ 0.5, 0.4, 0.3 }, a.base)
    near({ 0.25, 0.1, 0 }, a.specular)
    assert.same({ 96, 0 }, { a.exponent, b.exponent })
    near({ 2 / 3, 1 / 3, 0 }, b.base)
    near({ 1 / 3, 1 / 2, 1 / 6 }, b.specular)
    assert.same(1, #m.notes)
    assert.truthy(m.notes[1]:find("a.mtl:5: material 'b': Kd + Ks is above 1: both are multiplied by 0.667", 1, true),
      m.notes[1])
  end)

  it("are told where they are missing, with a guess", function()
    local m = assert(obj("mtllib a.mtl none.mtl\n" .. corners .. "usemtl wal\nf 1 2 3\nusemtl wall\nf 1 2 4\n",
      "newmtl wall\nKd 1 0 0\nmap_Kd none.png\n"))
    assert.equal(2, #m.parts)
    assert.same({ 1, 0, 0 }, m.parts[2].material.albedo)
    local all = table.concat(said, "\n")
    assert.equal(3, #said, all)
    assert.truthy(all:find("a.obj:1: mtllib 'none.mtl' is not read: ", 1, true), all)
    assert.truthy(all:find("a.obj:10: no material 'wal' (did you mean 'wall'?)", 1, true), all)
    assert.truthy(all:find("a.mtl:3: map_Kd 'none.png' is not read, and Kd stands alone: ", 1, true), all)
    assert.same(said[1], m.notes[1])
  end)

  it("name the line of what they cannot read", function()
    for text, says in pairs {
      ["newmtl x\nKd 0.5 -1 0\n"] = "a.mtl:2: number 2 of Kd must be from 0 to 1, got -1",
      ["newmtl x\nKd 0.5 nan 0\n"] = "a.mtl:2: Kd wants three numbers, or one for all",
      ["newmtl x\nKd\n"] = "a.mtl:2: Kd wants three numbers",
      ["newmtl x\n\nKs 0 0 1e999\n"] = "a.mtl:3: number 3 of Ks must be from 0 to 1, got inf",
      ["newmtl x\nNs -5\n"] = "a.mtl:2: number 1 of Ns must be from 0 to 100000, got -5",
      ["newmtl x\nNs 1e9\n"] = "a.mtl:2: number 1 of Ns must be from 0 to 100000, got 1e+09",
      ["newmtl x\nKe 1 1 -1\n"] = "a.mtl:2: number 3 of Ke must be from 0 to 1e+30, got -1",
      ["Kd 1 1 1\n"] = "a.mtl:1: Kd before the first newmtl",
      ["newmtl \n"] = "a.mtl:1: newmtl wants a name",
      ["newmtl x\nmap_Kd -clamp on\n"] = "a.mtl:2: map_Kd wants a name",
      ["newmtl x\0y\n"] = "a.mtl:1: the name after newmtl has a zero byte",
      ["\137PNG"] = "a.mtl:1: not a statement of an MTL file",
    } do
      local m, message, code = obj("mtllib a.mtl\n" .. corners .. "usemtl x\nf 1/1 2/2 3/3\n", text)
      assert.is_nil(m)
      assert.truthy(message:find(says, 1, true), message .. " does not match " .. says)
      assert.equal("EFORMAT", code)
    end
    assert(image_of(2, 2, noise):save(folder.path .. "/t.png"))
    local ok, message = pcall(obj, "mtllib a.mtl\n" .. corners .. "usemtl x\nf 1 2 3\n", "newmtl x\nmap_Kd t.png\n")
    assert(not ok and message:find("material 'x' has a texture, and the mesh no texture coordinates", 1, true), message)
    local bright = image_of(2, 2, function() return 2 end)
    assert(bright:save(folder.path .. "/t.exr"))
    local m, why, code = obj("mtllib a.mtl\n" .. corners .. "usemtl x\nf 1/1 2/2 3/3\n", "newmtl x\nmap_Kd t.exr\n")
    assert.is_nil(m)
    assert.equal("EFORMAT", code)
    assert.truthy(why:find("a.mtl:2: map_Kd 't.exr': ", 1, true) and why:find("row 1, column 1: red must be", 1, true), why)
  end)

  it("survive truncation and altered bytes", function()
    local text = "newmtl x\nKd 0.5 0.25 0\nKs 0.1\nNs 10\nKe 0 0 0\nmap_Kd -o 1 t.png\nd 1\nnewmtl y z\nKd 1\n"
    local read = 0
    pictures.spoil(text, 200, 5, function(bad)
      folder:write("bad.mtl", bad)
      local list, message, code = core.mtl_read(folder.path .. "/bad.mtl", 0)
      if list then read = read + 1
      else assert(code == "EFORMAT" and message:find "bad.mtl:%d+: ", message) end
    end)
    assert(read > 50, read)
  end)

  it("may be thousands", function()
    local lines, library = { "mtllib a.mtl", corners }, {}
    for i = 1, 3000 do
      lines[#lines + 1] = ("usemtl m%d\nf 1 2 3"):format(i)
      library[i] = ("newmtl m%d\nKd %.4f"):format(i, i / 3000)
    end
    local m = assert(obj(table.concat(lines, "\n"), table.concat(library, "\n")))
    assert.equal(3000, #m.parts)
    assert.near(0.5, m.parts[1500].material.albedo[1], 1e-6)
  end)

  it("of a stranger's scene lie in the folder of what names them, within its limits", function()
    local inner = folder.path .. "/inner"
    assert(scratch.shell("mkdir -p " .. inner))
    assert(image_of(64, 64, noise):save(inner .. "/t.png"))
    assert(image_of(2, 2, noise):save(folder.path .. "/outside.png"))
    folder:write("inner/a.obj", "mtllib a.mtl\n" .. corners .. "usemtl x\nf 1/1 2/2 3/3\n")
    folder:write("inner/scene.lua", "return scene 'x' { geometry = { mesh { file = 'a.obj' }, "
      .. "quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, material = matte { file = 't.png' } } } }")
    local function try(library, limits)
      folder:write("inner/a.mtl", library)
      return ylm.load(inner .. "/scene.lua", limits)
    end
    local s = assert(try "newmtl x\nmap_Kd t.png\n")
    assert(material.texture(s.geometry[1].material) and material.texture(s.geometry[2].material))
    for library, says in pairs {
      ["newmtl x\nmap_Kd ../outside.png\n"] = "a.mtl:2: map_Kd '../outside.png': a path inside the scene's folder expected",
      ["newmtl x\nmap_Kd " .. folder.path .. "/outside.png\n"] = "a path inside the scene's folder expected",
      ["newmtl x\nmap_Kd ..\\outside.png\n"] = "a path inside the scene's folder expected",
    } do
      local none, message, code = try(library)
      assert.same({ nil, "EFORMAT" }, { none, code })
      assert.truthy(message:find(says, 1, true), message)
    end
    local function limited(library, limits)
      local none, message, code = try(library, limits)
      assert(none == nil and code == "ELIMIT", message)
    end
    limited("newmtl x\nmap_Kd t.png\n", { texels = 5000 })
    limited("newmtl x\nmap_Kd t.png\n" .. ("# long\n"):rep(500), { file_size = 3000 })
    s = assert(try "newmtl x\nKe 1\n")
    assert.same({ 1, 1 }, { #s.geometry, #s.lights })
    limited("newmtl x\nKe 1\n", { numbers = 300 })
  end)

  it("are what examples/08_textured_room.lua shows", function()
    if not can_trace then pending "no Embree" end
    local out, status = scratch.capture(("%s examples/08_textured_room.lua --out %s --width 24 --samples 1 --rays 2"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    assert(status == 0 and out:find("2 triangles of materials with Ke emit", 1, true), out)
  end)
end)
