local ylm = require "ylm"
local core = require "ylm.c.core"
local pictures = require "spec.support.pictures"
local scratch = require "spec.support.scratch"

--- Six times the volume that a mesh encloses; positive where triangles are counter-clockwise from outside.
local function volume(mesh)
  local v, sum = mesh:vertices():totable(), 0
  for _, t in ipairs(mesh:triangles():totable()) do
    local a, b, c = v[t[1]], v[t[2]], v[t[3]]
    sum = sum + a[1] * (b[2] * c[3] - b[3] * c[2]) + a[2] * (b[3] * c[1] - b[1] * c[3])
      + a[3] * (b[1] * c[2] - b[2] * c[1])
  end
  return sum / 6
end

describe("geometry", function()
  it("winds triangles counter-clockwise seen from outside", function()
    local pi = math.pi
    assert.near(4 / 3 * pi, volume(ylm.sphere { divide = { 96, 48 } }.mesh), 0.02)
    assert.near(6, volume(ylm.box { bounds = { { 0, 0, 0 }, { 1, 2, 3 } }, divide = 2 }.mesh), 1e-5)
    assert.near(2 * pi ^ 2 * 0.25 ^ 2, volume(ylm.torus { divide = { 96, 48 } }.mesh), 0.01)
    assert.is_true(volume(ylm.knot { divide = { 128, 16 } }.mesh) > 0)
    local quad = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }.mesh
    assert.same({ { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } }, quad:normals():totable())
  end)

  it("makes a knot of 300,000 triangles and more", function()
    assert.equal(384000, #ylm.knot { p = 2, q = 3, divide = { 3000, 64 } }.mesh)
  end)

  it("keeps arrays alive that were taken from a mesh", function()
    local normals = ylm.sphere { divide = { 8, 4 } }.mesh:normals()
    collectgarbage()
    collectgarbage()
    assert.is_true((core.array_finite(normals)))
  end)
end)

describe("shapes", function()
  it("are similar where only the first size is given: the others follow it", function()
    for _, make in ipairs { ylm.torus, ylm.knot } do
      local one = make { divide = { 24, 6 } }.mesh:vertices()
      for _, radius in ipairs { 0.01, 0.25, 4096 } do
        local other = make { radius = radius, divide = { 24, 6 } }.mesh:vertices()
        assert.near(0, (other / radius - one):abs():max(), 1e-6)
      end
    end
    assert.near(0.3, ylm.knot { radius = 0.4, minor = 0.2, tube = 0.1, divide = { 400, 8 } }.mesh.bounds[2][3], 1e-3)
    assert.truthy(require "ylm.help".text("knot"):find("default 0.4 radius", 1, true))
  end)

  it("have unit normals that point out of them", function()
    for _, shape in ipairs { ylm.sphere {}, ylm.torus {}, ylm.knot {}, ylm.box { divide = 3 } } do
      local v, n = shape.mesh:vertices():totable(), shape.mesh:normals():totable()
      local worst = 0
      for _, t in ipairs(shape.mesh:triangles():totable()) do
        local a, b, c = v[t[1]], v[t[2]], v[t[3]]
        local x, y = {}, {}
        for k = 1, 3 do x[k], y[k] = b[k] - a[k], c[k] - a[k] end
        local face = { x[2] * y[3] - x[3] * y[2], x[3] * y[1] - x[1] * y[3], x[1] * y[2] - x[2] * y[1] }
        local m = n[t[1]]
        local dot = face[1] * m[1] + face[2] * m[2] + face[3] * m[3]
        local length = math.sqrt(face[1] ^ 2 + face[2] ^ 2 + face[3] ^ 2)
        worst = math.max(worst, 1 - dot / length, math.abs(m[1] ^ 2 + m[2] ^ 2 + m[3] ^ 2 - 1))
      end
      assert.is_true(worst < 0.2, tostring(shape.mesh) .. ": " .. worst)
    end
  end)

  it("are as large as they should be", function()
    assert.near(4 * math.pi * 4, ylm.sphere { radius = 2, divide = { 200, 100 } }.mesh.area, 0.02)
    assert.near(4 * math.pi ^ 2 * 0.3, ylm.torus { radius = 1, tube = 0.3, divide = { 200, 100 } }.mesh.area, 0.02)
    local quad = ylm.quad { corner = { 0, 0, 0 }, u = { 4, 0, 0 }, v = { 0, 0, -3 }, divide = { 5, 7 } }
    assert.near(12, quad.mesh.area, 1e-5)
    assert.same({ { -1, -2, -3 }, { 1, 2, 3 } }, ylm.box { bounds = { { -1, -2, -3 }, { 1, 2, 3 } } }.mesh.bounds)
  end)

  it("scale, then rotate, then move; a matrix does all of it", function()
    local one = ylm.quad { corner = { 1, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 },
      scale = 2, rotate = { axis = { 0, 0, 1 }, angle = 90 }, at = { 0, 0, 5 } }
    local v = one.mesh:vertices()
    assert.near(0, v:get(1, 1), 1e-6)
    assert.near(2, v:get(1, 2), 1e-6)
    assert.near(5, v:get(1, 3), 1e-6)
    local two = ylm.quad { corner = { 1, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 },
      matrix = { { 0, -2, 0, 0 }, { 2, 0, 0, 0 }, { 0, 0, 2, 5 } } }
    assert.near(0, (core.array_distance(one.mesh:vertices(), two.mesh:vertices())), 1e-6)
    local twice = ylm.box { rotate = { { axis = { 0, 0, 1 }, angle = 90 }, { axis = { 1, 0, 0 }, angle = 90 } },
      bounds = { { 0, 0, 0 }, { 1, 2, 3 } } }
    local wanted = { { -2, -3, 0 }, { 0, 0, 1 } }
    for i = 1, 2 do
      for k = 1, 3 do assert.near(wanted[i][k], twice.mesh.bounds[i][k], 1e-6) end
    end
  end)

  it("stay right side out when they are mirrored, and keep normals perpendicular when they are stretched", function()
    local mirrored = ylm.sphere { scale = { -1, 2, 1 }, divide = { 64, 32 } }
    assert.near(8 / 3 * math.pi, volume(mirrored.mesh), 0.05)
    local slanted = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 1 }, v = { 0, 1, 0 }, scale = { 1, 1, 2 } }
    local n = slanted.mesh:normals():totable()[1]
    assert.near(0, n[1] + 2 * n[3], 1e-6)
  end)

  it("carry material and occludes", function()
    local material = ylm.matte {}
    local box = ylm.box { material = material, occludes = false }
    assert.equal(material, box.material)
    assert.is_false(box.occludes)
    assert.is_true(ylm.box {}.occludes)
  end)
end)

describe("mesh", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local function obj(text, crease) return ylm.mesh { file = folder:write("a.obj", text), crease = crease } end

  it("reads OBJ: all kinds of corners, negative indices, polygons, lines that go on", function()
    local corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\n"
    for _, face in ipairs { "f 1 2 3 4", "f 1/1 2/2 3/1 4/2", "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/1/1 3/2/1 4/2/1",
      "f -4 -3 -2 -1", "f -4/-2/-1 2/1/1 3/2/1 4/2/1", "f 1 2 \\\n 3 4", "f  1\t2   3 4  # quad", "f 1 2 3 4\r" } do
      local m = obj(corners .. "g x\nusemtl y\ns 1\n" .. face .. "\n").mesh
      assert.equal(2, #m)
      assert.near(1, m.area, 1e-6)
      assert.near(1, m:normals():get(1, 3), 1e-6)
    end
    local m = obj(corners .. "f 1/1 2/2 3/1 4/2").mesh
    assert.same({ { 0, 0 }, { 1, 1 }, { 0, 0 }, { 1, 1 } }, m:uvs():totable())
    assert.is_nil(obj(corners .. "f 1 2 3").mesh:uvs())
  end)

  it("makes one vertex of each combination of indices, and smooths across seams of texture coordinates", function()
    local m = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nf 1/1 2/1 3/1\nf 1/2 3/1 4/1\n", 180).mesh
    assert.equal(5, #m:vertices())
    local n = m:normals():totable()
    assert.same(n[1], n[4]) -- the first corner of both faces: one position, two texture coordinates
    assert.near(math.sqrt(0.5), n[1][1], 1e-6)
  end)

  describe("without normals", function()
    -- Two squares that meet at the y axis, the second one lowered by an angle.
    local function bent(degrees)
      local x, z = math.cos(math.rad(degrees)), -math.sin(math.rad(degrees))
      return ("v -1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv %.9g 0 %.9g\nv %.9g 1 %.9g\n"):format(x, z, x, z)
    end
    local faces = "f 1 2 3 4\nf 2 5 6 3\n"
    -- How many vertices, and the largest angle between a triangle's normal and those of its corners, in degrees.
    local function bend(mesh)
      local v, n, largest = mesh:vertices():totable(), mesh:normals():totable(), 0
      for _, t in ipairs(mesh:triangles():totable()) do
        local a, b, c, x, y = v[t[1]], v[t[2]], v[t[3]], {}, {}
        for k = 1, 3 do x[k], y[k] = b[k] - a[k], c[k] - a[k] end
        local flat = { x[2] * y[3] - x[3] * y[2], x[3] * y[1] - x[1] * y[3], x[1] * y[2] - x[2] * y[1] }
        local length = math.sqrt(flat[1] ^ 2 + flat[2] ^ 2 + flat[3] ^ 2)
        for _, i in ipairs(t) do
          local dot = (flat[1] * n[i][1] + flat[2] * n[i][2] + flat[3] * n[i][3]) / length
          largest = math.max(largest, math.deg(math.acos(math.min(1, dot))))
        end
      end
      return #v, largest
    end
    -- That many vertices, and triangles that are flat (angle 0) or smooth by that angle at least.
    local function assert_bent(vertices, angle, mesh)
      local n, found = bend(mesh)
      assert.equal(vertices, n)
      if angle == 0 then assert.near(0, found, 0.05) else assert(found > angle - 0.05, found) end
    end

    it("is smooth up to the crease angle, and has an edge beyond it, whose vertices are split", function()
      assert_bent(6, 19.5, obj(bent(39) .. faces).mesh)
      assert_bent(8, 0, obj(bent(41) .. faces).mesh)
      assert_bent(8, 0, obj(bent(39) .. faces, 38).mesh)
      assert_bent(6, 60, obj(bent(120) .. faces, 180).mesh)
      assert_bent(8, 0, obj(bent(1) .. faces, 0).mesh)
      assert_bent(6, 0, obj(bent(0) .. faces, 0).mesh)
    end)

    it("keeps the given vertices first, and copies texture coordinates and colours", function()
      local given = { { -1, 0, 0 }, { 0, 0, 0 }, { 0, 1, 0 }, { 0, 0, -1 }, { 9, 9, 9 } }
      local uvs, colours = {}, {}
      for i = 1, 5 do uvs[i], colours[i] = { i / 8, -i / 8 }, { i / 8, 0, 1 } end
      local made = { vertices = given, triangles = { { 1, 2, 3 }, { 2, 4, 3 } }, uvs = uvs, colours = colours, crease = 60 }
      local m = ylm.mesh(made).mesh
      assert_bent(7, 0, m)
      local v, uv, colour, t = m:vertices():totable(), m:uvs():totable(), m:colours():totable(), m:triangles():totable()
      for i = 1, 5 do assert.same(given[i], v[i]) end
      assert.same({ { 1, 2, 3 }, { 6, 4, 7 } }, t)
      for copy, of in pairs { [6] = 2, [7] = 3 } do
        for _, rows in ipairs { v, uv, colour } do assert.same(rows[of], rows[copy]) end
      end
      made.crease = nil
      assert_bent(5, 45, ylm.mesh(made).mesh)
    end)

    it("takes the smoothing groups of OBJ before the angle", function()
      assert_bent(6, 45, obj(bent(90) .. "s 1\n" .. faces).mesh)
      assert_bent(8, 0, obj(bent(20) .. "s 1\nf 1 2 3 4\ns 2\nf 2 5 6 3\n").mesh)
      assert_bent(8, 0, obj(bent(20) .. "s off\n" .. faces).mesh)
      assert_bent(8, 0, obj(bent(20) .. "s 0\n" .. faces).mesh)
      assert_bent(6, 10, obj(bent(20) .. "s 99999999999\n" .. faces).mesh) -- no group: by angle
      assert_bent(8, 0, obj(bent(20) .. "s 1\nf 1 2 3 4\ns off\nf 2 5 6 3\n").mesh)
    end)

    it("has edges where two triangles turn opposite ways; others at the same edge stay smooth", function()
      local v = "v -1 0 0\nv 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 -1\n"
      assert_bent(5, 0, obj(v .. "f 1 2 3\nf 2 4 3\n").mesh)
      assert_bent(5 + 2, 0, obj(v .. "f 1 2 3\nf 2 3 4\n").mesh)
      assert_bent(5 + 2, 0, obj(v .. "f 1 2 3\nf 2 5 3\nf 2 4 3\n").mesh)
      assert_bent(5, 0, obj(v .. "f 1 2 3\nf 1 2 3\n").mesh)
      local many = {}
      for i = 1, 40 do many[i] = i % 2 == 0 and "f 1 2 3\n" or "f 2 5 3\n" end
      assert_bent(5 + 2, 0, obj(v .. table.concat(many)).mesh)
    end)

    it("makes twenty-four vertices of a box of eight, with the normals of its faces", function()
      local corners = {}
      local quads = { { 1, 2, 4, 3 }, { 5, 7, 8, 6 }, { 1, 5, 6, 2 }, { 3, 4, 8, 7 }, { 1, 3, 7, 5 }, { 2, 6, 8, 4 } }
      for i = 0, 7 do corners[i + 1] = ("v %d %d %d"):format(math.floor(i / 4), math.floor(i / 2) % 2, i % 2) end
      for i, q in ipairs(quads) do quads[i] = "f " .. table.concat(q, " ") end
      local m = obj(table.concat(corners, "\n") .. "\n" .. table.concat(quads, "\n") .. "\n").mesh
      assert_bent(24, 0, m)
      assert.near(1, volume(m), 1e-6)
    end)
  end)

  it("reads PLY in text and in both byte orders, and skips what it does not know", function()
    local head = "ply\nformat %s 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
      .. "property float z\nproperty uchar red\nelement thing 1\nproperty list uchar short numbers\n"
      .. "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    local text = head:format "ascii" .. "0 0 0 1\n1 0 0 2\n1 1 0 3\n0 1 0 4\n2 7 -8\n4 0 1 2 3\n"
    local one = "\63\128\0\0"
    local zero = "\0\0\0\0"
    local big = head:format "binary_big_endian"
      .. zero .. zero .. zero .. "\1" .. one .. zero .. zero .. "\2" .. one .. one .. zero .. "\3"
      .. zero .. one .. zero .. "\4" .. "\2\0\7\255\248" .. "\4" .. zero .. "\0\0\0\1\0\0\0\2\0\0\0\3"
    one = "\0\0\128\63"
    local little = head:format "binary_little_endian"
      .. zero .. zero .. zero .. "\1" .. one .. zero .. zero .. "\2" .. one .. one .. zero .. "\3"
      .. zero .. one .. zero .. "\4" .. "\2\7\0\248\255" .. "\4" .. zero .. "\1\0\0\0\2\0\0\0\3\0\0\0"
    for _, bytes in ipairs { text, big, little } do
      local m = ylm.mesh { file = folder:write("a.ply", bytes) }.mesh
      assert.equal(2, #m)
      assert.same({ { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } }, m:vertices():totable())
      assert.same({ { 1, 2, 3 }, { 1, 3, 4 } }, m:triangles():totable())
      assert.equal("int32", m:triangles().dtype)
    end
  end)

  it("comes back from PLY as it was", function()
    local knot = ylm.knot { divide = { 40, 8 } }.mesh
    assert.is_true(knot:save(folder.path .. "/k.ply"))
    local same = assert(ylm.load(folder.path .. "/k.ply"))
    assert.equal(0, (core.array_distance(knot:vertices(), same:vertices())))
    assert.equal(0, (core.array_distance(knot:uvs(), same:uvs())))
    assert.equal(0, (knot:triangles() - same:triangles()):abs():max())
    assert.near(0, (core.array_distance(knot:normals(), same:normals())), 1e-6)
  end)

  it("comes from arrays, with normals of its own making", function()
    local m = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }.mesh
    assert.same({ { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } }, m:normals():totable())
  end)

  it("names the line of what it cannot read", function()
    local v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    for text, says in pairs {
      [v .. "f 1 2\n"] = "a.obj:4: a face has 2 corners",
      [v .. "\nf 1 2 7\nf 1 2 3\n"] = "a.obj:5: a face refers to vertex 7, the file has 3",
      [v .. "f 1 2 -4\n"] = "a.obj:4: a face refers to vertex %-4, 3 are there so far",
      [v .. "f 1 2 0\n"] = "a.obj:4: a face refers to vertex 0",
      [v .. "f 1/1 2/1 3/1\n"] = "a.obj:4: a face refers to texture coordinate 1, the file has 0",
      [v .. "f 1 2 x\n"] = "a.obj:4: a vertex index expected",
      [v .. "f 1/2/3/4 2 3\n"] = "a.obj:4: a face has corners v, v/vt",
      ["v 0 0\n"] = "a.obj:1: 'v' wants 3 numbers, number 3 is none",
      ["v 0 nan 0\n"] = "a.obj:1: 'v' wants 3 numbers, number 2 is none",
      ["v 0 1e39 0\n"] = "a.obj:1: number 2 of 'v' is too large",
      ["\n\n%!PS\n"] = "a.obj:3: not a statement",
      ["v 0 0 0\n"] = "a.obj: not an OBJ file with faces",
      [""] = "a.obj: not an OBJ file with faces",
      ["ply\n"] = "the header has no end",
      ["ply\nformat ascii 2.0\nelement vertex x\n"] = "a.obj:3: bad count 'x'",
      ["ply\nformat xml 1.0\n"] = "a.obj:2: unknown format 'xml'",
      ["ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n"] = "vertices need x, y and z",
      ["ply\nformat binary_little_endian 1.0\nelement vertex 99999999\nproperty float x\nproperty float y\n"
        .. "property float z\nend_header\n0"] = "truncated: the header promises more",
      ["ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        .. "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 1\n"] =
        "a.obj:11: face 1 refers to vertex 1 %(from 0%), there are 1",
    } do
      local m, message, code = obj(text)
      assert.is_nil(m)
      assert.truthy(message:find(says), message .. " does not match " .. says)
      assert.equal("EFORMAT", code)
    end
  end)

  it("survives truncation and altered bytes", function()
    local name = folder.path .. "/s.ply"
    assert.is_true(ylm.sphere { divide = { 8, 4 } }.mesh:save(name))
    local refused = 0
    pictures.spoil(folder:read "s.ply", 300, 3, function(bad, what)
      folder:write("bad.ply", bad)
      local m, message = ylm.mesh { file = folder.path .. "/bad.ply" }
      assert(m == nil or not what:find "truncated", what)
      if not m then
        refused = refused + 1
        assert(message:find("bad.ply", 1, true), message)
      end
    end)
    assert.is_true(refused > 300)
  end)

  it("leaves an existing file as it was when the disk is full", function()
    local name = folder.path .. "/kept.ply"
    assert.is_true(ylm.box {}.mesh:save(name))
    local before = folder:read "kept.ply"
    local out = pictures.on_full_disk(scratch, ([[print(require "ylm".knot {}.mesh:save(%q))]]):format(name))
    assert.truthy(out:find "^nil\t.*cannot be written: .*\tEIO", out)
    assert.equal(before, folder:read "kept.ply")
  end)
end)
