-- glTF 2.0: what files of every kind become, and what is refused with which sentence.

local gltf = require "spec.support.gltf"
local library = require "ylm.library"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local codec = library.open("codec", "%s")
if not codec or select(3, codec.gltf_read { path = "/nonexistent", file_size = 0, triangles = 0, texels = 0, scene = 0,
  images = false }) == "EMISSING" then
  describe("glTF files without jansson", function()
    it("says what to install", function()
      local m, message, code = ylm.gltf { file = "room.glb" }
      assert.is_nil(m)
      assert.equal("EMISSING", code)
      assert.truthy(message:find(codec and "libjansson-dev" or "libylm_codec", 1, true), message)
      pending "jansson is not installed"
    end)
  end)
  return
end

describe("glTF files", function()
  local folder, with_jpeg
  setup(function()
    folder = scratch.new()
    with_jpeg = select(3, ylm.load(folder:write("x.jpg", "\255\216\255"))) == "EFORMAT"
  end)
  teardown(function() folder:remove() end)

  --- A grey JPEG of 8 x 8 pixels, 200 of 255.
  local jpeg = "/9j/2wBDAAgGBgcGBQgHBwcJCQgKDBQNDAsLDBkSEw8UHRofHh0aHBwgJC4nICIsIxwcKDcpLDAxNDQ0Hyc5PTgyPC4zNDL/wAALCAAIAAgBAREA"
    .. "/8QAFAABAAAAAAAAAAAAAAAAAAAAB//EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8ASH//2Q=="

  local square = { -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0 }

  --- Loads a file of these bytes.
  local function load(text, options, name)
    return ylm.load(folder:write(name or "model.gltf", text), options)
  end

  --- The model of a file whose nodes are these and whose mesh has one primitive.
  local function model(f, primitive, nodes, more)
    more = more or {}
    more.meshes, more.nodes = { { primitives = { primitive } } }, nodes or { { mesh = 0 } }
    return assert(load(f:text(more)))
  end

  local function near(a, b, tolerance)
    assert(math.abs(a - b) <= (tolerance or 1e-6) * math.max(1, math.abs(b)), ("%.9g is not %.9g"):format(a, b))
  end

  --- Area and bounds of a model's one piece.
  local function measures(m, area, lo, hi)
    near(m.geometry[1].mesh.area, area)
    for i = 1, 3 do
      near(m.geometry[1].mesh.bounds[1][i], lo[i])
      near(m.geometry[1].mesh.bounds[2][i], hi[i])
    end
  end

  it("reads the same from .gltf and .glb, with indices of 8, 16 and 32 bits or none", function()
    for _, component in ipairs { 5121, 5123, 5125, false } do
      local f = gltf.new()
      local list = square
      if not component then list = { -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0 } end
      local primitive = { attributes = { POSITION = f:accessor("VEC3", 5126, list) } }
      if component then primitive.indices = f:accessor("SCALAR", component, { 0, 1, 2, 0, 2, 3 }) end
      local more = { meshes = { { primitives = { primitive } } }, nodes = { { mesh = 0 } } }
      for name, text in pairs { ["a.gltf"] = f:text(more), ["a.glb"] = f:binary(more) } do
        local m = assert(load(text, nil, name))
        measures(m, 4, { -1, -1, 0 }, { 1, 1, 0 })
        assert.equal(2, m.report.triangles)
        assert.equal(1, m.geometry[1].mesh:normals():get(1, 3))
      end
    end
  end)

  it("reads strips and fans, and leaves lines and points out with a sentence", function()
    local f = gltf.new()
    local strip = f:accessor("VEC3", 5126, { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0 })
    local fan = f:accessor("VEC3", 5126, { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 })
    local m = assert(load(f:text { nodes = { { mesh = 0 } }, meshes = { { primitives = {
      { attributes = { POSITION = strip }, mode = 5 }, { attributes = { POSITION = fan }, mode = 6 },
      { attributes = { POSITION = fan }, mode = 1 } } } } }))
    assert.equal(2, #m.geometry)
    near(m.geometry[1].mesh.area, 1.5)
    near(m.geometry[2].mesh.area, 1)
    for _, g in ipairs(m.geometry) do
      for i = 1, #g.mesh:vertices() do assert.equal(1, g.mesh:normals():get(i, 3)) end
    end
    assert.equal("model.gltf: mesh 0: primitives of points or lines left out: 1", m.report.notes[1])
  end)

  it("multiplies transforms down the nodes; a mirror turns triangles round", function()
    local f = gltf.new()
    local primitive = { attributes = { POSITION = f:accessor("VEC3", 5126, square), NORMAL = f:accessor("VEC3", 5126,
      { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 }) }, indices = f:accessor("SCALAR", 5123, { 0, 1, 2, 0, 2, 3 }) }
    local h = math.sqrt(0.5)
    local m = model(f, primitive, { { children = { 1 }, translation = { 10, 0, 0 }, rotation = { 0, h, 0, h } },
      { mesh = 0, name = "wall", scale = { 2, -3, 1 }, translation = { 0, 0, 5 } } })
    measures(m, 24, { 15, -3, -2 }, { 15, 3, 2 })
    local mesh = m.geometry[1].mesh
    near(mesh:normals():get(1, 1), 1)
    local p, t = mesh:vertices():totable(), mesh:triangles():totable()[1]
    local a, b, c = p[t[1]], p[t[2]], p[t[3]]
    assert((b[2] - a[2]) * (c[3] - a[3]) - (b[3] - a[3]) * (c[2] - a[2]) > 0)
    assert.equal("wall", m.geometry[1].name)
    m = model(f, primitive, { { mesh = 0, matrix = { 0, 0, -2, 0, 0, -3, 0, 0, 1, 0, 0, 0, 15, 0, 0, 1 } } })
    measures(m, 24, { 15, -3, -2 }, { 15, 3, 2 })
  end)

  it("reads views with strides, bytes that are normalised, and elements that differ", function()
    local f = gltf.new()
    local view = f:view(gltf.bytes(5126, { 0, 0, 0, 9, 2, 0, 0, 9, 0, 2, 0, 9 }), 16)
    f.accessors[1] = { type = "VEC3", componentType = 5126, count = 3, bufferView = view }
    measures(model(f, { attributes = { POSITION = 0 } }), 2, { 0, 0, 0 }, { 2, 2, 0 })
    f = gltf.new()
    local m = model(f, { attributes = { POSITION = f:accessor("VEC3", 5122, { 0, 0, 0, 32767, 0, 0, 0, -32768, 0 },
      { normalized = true }) } }, { { mesh = 0, scale = { 4, 4, 4 } } }, { extensionsRequired = { "KHR_mesh_quantization" } })
    measures(m, 8, { 0, -4, 0 }, { 4, 0, 0 })
    for _, base in ipairs { false, true } do
      f = gltf.new()
      local indices = f:view(gltf.bytes(5121, { 1, 2 }))
      local values = f:view(gltf.bytes(5126, { 3, 0, 0, 0, 3, 0 }))
      f:accessor("VEC3", 5126, base and { 0, 0, 0, 7, 7, 7, 8, 8, 8 } or {}, { count = 3, sparse = { count = 2,
        indices = { bufferView = indices, componentType = 5121 }, values = { bufferView = values } } })
      measures(model(f, { attributes = { POSITION = 0 } }), 4.5, { 0, 0, 0 }, { 3, 3, 0 })
    end
  end)

  --- Area, volume, number of triangles and bounds of meshes.
  local function sums_of(geometry)
    local sum = { area = 0, volume = 0, triangles = 0, lo = { math.huge, math.huge, math.huge },
      hi = { -math.huge, -math.huge, -math.huge } }
    for _, g in ipairs(geometry) do
      local b, p = g.mesh.bounds, g.mesh:vertices():totable()
      sum.area, sum.triangles = sum.area + g.mesh.area, sum.triangles + #g.mesh
      for a = 1, 3 do sum.lo[a], sum.hi[a] = math.min(sum.lo[a], b[1][a]), math.max(sum.hi[a], b[2][a]) end
      for _, t in ipairs(g.mesh:triangles():totable()) do
        local u, v, w = p[t[1]], p[t[2]], p[t[3]]
        sum.volume = sum.volume + (u[1] * (v[2] * w[3] - v[3] * w[2]) + u[2] * (v[3] * w[1] - v[1] * w[3])
          + u[3] * (v[1] * w[2] - v[2] * w[1])) / 6
      end
    end
    return sum
  end

  it("finds the triangles, areas, bounds and volumes that VTK's reader finds", function()
    local vtk = require "ylm.picture".vtk()
    if not vtk then pending "VTK is not built in" end
    local corners, sides = {}, {}
    for i = 0, 7 do
      corners[#corners + 1], corners[#corners + 2], corners[#corners + 3] = i % 2, math.floor(i / 2) % 2, math.floor(i / 4)
    end
    for _, s in ipairs { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 4, 6, 2 }, { 1, 3, 7, 5 } } do
      for _, k in ipairs { 1, 2, 3, 1, 3, 4 } do sides[#sides + 1] = s[k] end
    end
    local scattered, h = {}, math.sqrt(0.5)
    for i, k in ipairs(sides) do
      for a = 1, 3 do scattered[3 * i - 3 + a] = corners[3 * k + a] end
    end
    --- A box; `component`: of its indices, or nil.
    local function box(f, component, more)
      local primitive = { attributes = { POSITION = f:accessor("VEC3", 5126, component and corners or scattered) } }
      if component then primitive.indices = f:accessor("SCALAR", component, sides) end
      for key, x in pairs(more or {}) do primitive[key] = x end
      return primitive
    end
    local turned = { { children = { 1 }, translation = { 1, 2, 3 }, rotation = { 0, h, 0, h } },
      { mesh = 0, scale = { 2, -3, 0.5 }, translation = { 0, 0, 5 }, children = { 2 } }, { mesh = 0, scale = { 0.1, 0.2, 0.3 } } }
    local cases = {
      bare = function(f) return { box(f) } end,
      bytes = function(f) return { box(f, 5121) }, turned end,
      shorts = function(f) return { box(f, 5123), box(f, 5123) }, { { mesh = 0, matrix = { 0, 0, -2, 0, 0, -3, 0, 0, 1, 0, 0, 0,
        15, 0, 0, 1 } } } end,
      integers = function(f) return { box(f, 5125) }, turned end,
      strips = function(f)
        local list = f:accessor("VEC3", 5126, { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5, 0, 2, 0 })
        return { { attributes = { POSITION = list }, mode = 5 }, { attributes = { POSITION = list }, mode = 6 } }
      end,
      interleaved = function(f)
        local view = f:view(gltf.bytes(5126, { 0, 0, 0, 9, 2, 0, 0, 9, 0, 2, 0.1, 9 }), 16)
        f.accessors[1] = { type = "VEC3", componentType = 5126, count = 3, bufferView = view }
        return { { attributes = { POSITION = 0 } } }
      end,
      sparse = function(f)
        local indices, values = f:view(gltf.bytes(5123, { 1, 2 })), f:view(gltf.bytes(5126, { 3, 0, 0, 0, 3, 0 }))
        local more = { count = 2, indices = { bufferView = indices, componentType = 5123, byteOffset = 0 },
          values = { bufferView = values, byteOffset = 0 } }
        return { { attributes = { POSITION = f:accessor("VEC3", 5126, { 0, 0, 0, 7, 7, 7, 8, 8, 8 }, { sparse = more }) } } }
      end,
    }
    for name, make in pairs(cases) do
      for _, ending in ipairs { ".gltf", ".glb" } do
        local f = gltf.new()
        local primitives, nodes = make(f)
        local all = { meshes = { { primitives = primitives } }, nodes = nodes or { { mesh = 0 } }, scene = 0,
          scenes = { { nodes = { 0 } } } }
        local path = folder:write(name .. ending, ending == ".glb" and f:binary(all) or f:text(all))
        local text, m = assert(vtk.describe(path)), assert(ylm.load(path))
        local sum = sums_of(m.geometry)
        local n, bounds = text:match "^glTF %d+ (%d+)\nbounds ([^\n]*)\n"
        assert.equal(tonumber(n), sum.triangles, name)
        local i = 0
        for x in bounds:gmatch "%S+" do
          i = i + 1
          near(i <= 3 and sum.lo[i] or sum.hi[i - 3], tonumber(x))
        end
        assert.equal(6, i)
        near(sum.area, tonumber(text:match "area (%S+)"))
        near(math.abs(sum.volume), math.abs(tonumber(text:match "volume (%S+)")))
      end
    end
  end)

  it("makes colours of vertices, matte and coated materials", function()
    local f = gltf.new()
    local position = f:accessor("VEC3", 5126, { 0, 0, 0, 1, 0, 0, 0, 1, 0 })
    for _, c in ipairs { { "VEC3", 5126, { 0.5, 0, 1, 0.5, 0, 1, 0.5, 0, 1 } },
      { "VEC4", 5121, { 51, 0, 255, 9, 51, 0, 255, 9, 51, 0, 255, 9 }, 0.2 },
      { "VEC3", 5123, { 13107, 0, 65535, 13107, 0, 65535, 13107, 0, 65535 }, 0.2 } } do
      local g = model(f, { attributes = { POSITION = position,
        COLOR_0 = f:accessor(c[1], c[2], c[3], { normalized = c[2] ~= 5126 }) } }).geometry[1]
      near(g.mesh:colours():get(2, 1), c[4] or 0.5)
      assert.equal(1, g.mesh:colours():get(3, 3))
    end
    local function material(m)
      return model(f, { attributes = { POSITION = position }, material = 0 }, nil, { materials = { m } }).geometry[1]
    end
    local plain = material { pbrMetallicRoughness = { metallicFactor = 0, baseColorFactor = { 0.5, 0.25, 0, 1 } },
      doubleSided = true }
    assert.same({ 0.5, 0.25, 0 }, plain.material.albedo)
    assert.equal("both", plain.sides)
    local coated = material({ pbrMetallicRoughness = { metallicFactor = 0.5, roughnessFactor = 0.5,
      baseColorFactor = { 1, 0.5, 0, 1 } } }).material
    near(coated.alpha[1], 0.25)
    near(coated.f0[1], 0.52)
    near(coated.base[2], 0.25)
    assert.is_false(material({ alphaMode = "BLEND", pbrMetallicRoughness = { baseColorFactor = { 1, 1, 1, 0.3 } } }).occludes)
    assert.is_nil(material { alphaMode = "MASK", pbrMetallicRoughness = { baseColorFactor = { 1, 1, 1, 0.3 } } })
  end)

  it("makes textures of PNG and JPEG images, at the places that the file says", function()
    local image = ylm.image { size = { 2, 2 } }
    for i, c in ipairs { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 } } do
      image:fill((i - 1) % 2 + 1, math.floor((i - 1) / 2) + 1, 1, 1, c)
    end
    assert(image:save(folder.path .. "/four.png", { tone = "srgb" }))
    local bytes = scratch.text(folder.path .. "/four.png")
    local f = gltf.new()
    local attributes = { POSITION = f:accessor("VEC3", 5126, square), TEXCOORD_1 = f:accessor("VEC2", 5126,
      { 0, 1, 1, 1, 1, 0, 0, 0 }) }
    local indices, view = f:accessor("SCALAR", 5121, { 0, 1, 2, 0, 2, 3 }), f:view(bytes)
    local function textured(info, source, options)
      info.index, info.texCoord = 0, 1
      local text = f:text { nodes = { { mesh = 0 } }, meshes = { { primitives = { { attributes = attributes, indices = indices,
        material = 0 } } } }, textures = { { source = 0 } }, images = { source },
        materials = { { pbrMetallicRoughness = { metallicFactor = 0, baseColorTexture = info } } } }
      return assert(load(text, options))
    end
    local m = textured({}, { bufferView = view, mimeType = "image/png" })
    local uvs = m.geometry[1].mesh:uvs():totable()
    assert.same({ 0, 0 }, uvs[1]) -- the lower left corner: v is upwards
    local layer = ylm.scene "x" { like = m, camera = ylm.camera { from = { 0, 0, 3 } },
      lights = ylm.environment_light { radiance = 1 } }:render { size = { 2, 2 }, bounces = 0 }:layer()
    assert(layer:get(1, 1, 1) > 1.3 * layer:get(1, 1, 2) and layer:get(2, 1, 3) > 1.3 * layer:get(2, 1, 1), tostring(layer))
    near(require "ylm.material".albedo("spec", textured({}, { uri = "four.png" }, { textures = "mean" }).geometry[1].material)[1],
      0.5)
    m = textured({ extensions = { KHR_texture_transform = { offset = { 0.5, 0 }, scale = { 2, 1 } } } }, { bufferView = view })
    assert.same({ 2.5, 1 }, m.geometry[1].mesh:uvs():totable()[3])
    if with_jpeg then
      local grey = textured({}, { uri = "data:image/jpeg;base64," .. jpeg }).geometry[1].material
      near(require "ylm.material".albedo("spec", grey)[1], ((200 / 255 + 0.055) / 1.055) ^ 2.4)
      for n = 1, #jpeg / 4 - 2 do
        local cut = textured({}, { uri = "data:image/jpeg;base64," .. jpeg:sub(1, 4 * n) })
        assert(#cut.report.notes == 1, n)
      end
    end
    local none = textured({}, { uri = "data:image/png;base64," .. gltf.base64(bytes:sub(1, 40)) })
    assert.truthy(none.report.notes[1]:find("image 0: truncated or damaged: the factors stand alone", 1, true))
    none = textured({}, { uri = "data:image/webp;base64,AAAA" })
    assert.truthy(none.report.notes[1]:find("image 0 is neither PNG nor JPEG", 1, true))
  end)

  describe("reads textures", function()
    --- A model of 8 x 8 squares of side 1 with an image: { image =, material =, sampler =, options =, uv = f(x, y), rgba = }.
    local function tiled(more)
      local f, list, uvs, indices = gltf.new(), {}, {}, {}
      for j = 0, 8 do for i = 0, 8 do
        list[#list + 1], list[#list + 2], list[#list + 3] = i, j, 0
        local u, v = i / 8, j / 8
        if more.uv then u, v = more.uv(i, j) end
        uvs[#uvs + 1], uvs[#uvs + 2] = u, v
        if i < 8 and j < 8 then
          local k = 9 * j + i
          for _, c in ipairs { k, k + 1, k + 10, k, k + 10, k + 9 } do indices[#indices + 1] = c end
        end
      end end
      local material = { pbrMetallicRoughness = { metallicFactor = 0, baseColorTexture = { index = 0 } } }
      for key, x in pairs(more.material or {}) do material[key] = x end
      local attributes = { POSITION = f:accessor("VEC3", 5126, list), TEXCOORD_0 = f:accessor("VEC2", 5126, uvs),
        COLOR_0 = more.rgba and f:accessor("VEC4", 5126, more.rgba) }
      local primitive = { attributes = attributes, indices = f:accessor("SCALAR", 5123, indices), material = 0 }
      return assert(load(f:text { nodes = { { mesh = 0 } }, materials = { material }, images = { { uri = more.image } },
        samplers = { more.sampler or { magFilter = 9728 } }, textures = { { source = 0, sampler = 0 } },
        meshes = { { primitives = { primitive } } } }, more.options))
    end

    --- Saves an image of 8 x 8 texels; f(column, row) -> colour.
    local function paint(name, f)
      local image = ylm.image { size = { 8, 8 } }
      for y = 1, 8 do for x = 1, 8 do image:fill(x, y, 1, 1, f(x, y)) end end
      assert(image:save(folder.path .. "/" .. name, { tone = "linear" }))
      return ylm.load(folder.path .. "/" .. name):layer()
    end

    it("as means weighted by area and as at most n groups of triangles, which keep the mean", function()
      local layer = paint("many.png", function(x, y) return { x / 8, y / 8, (x * y % 3) / 2 } end)
      local wanted = {}
      for c = 1, 3 do
        local sum = 0
        for y = 1, 8 do for x = 1, 8 do sum = sum + layer:get(y, x, c) end end
        wanted[c] = sum / 64
      end
      for _, n in ipairs { "mean", 16 } do
        local m = tiled { image = "many.png", options = { textures = n } }
        local sum, area = { 0, 0, 0 }, 0
        assert(#m.geometry <= (n == 16 and 16 or 1) and (n ~= 16 or #m.geometry > 12), #m.geometry)
        for _, piece in ipairs(m.geometry) do
          local albedo = piece.material.albedo
          area = area + piece.mesh.area
          for c = 1, 3 do sum[c] = sum[c] + albedo[c] * piece.mesh.area end
        end
        near(area, 64)
        for c = 1, 3 do near(sum[c] / area, wanted[c], 1e-6) end
        assert.is_nil(require "ylm.material.texture".of(m.geometry[1].material))
      end
      -- Two halves of two colours are two groups, however many there may be.
      paint("two.png", function(x) return x > 4 and { 1, 0, 0 } or { 0, 0, 1 } end)
      local m = tiled { image = "two.png", options = { textures = 256 } }
      assert.equal(2, #m.geometry)
      assert.equal(0, m.geometry[1].material.albedo[2])
      near(m.geometry[1].mesh.area, 32)
      for _, wrong in ipairs { 0, 257, 2.5, "all" } do
        assert.has_error(function() tiled { image = "two.png", options = { textures = wrong } } end)
      end
    end)

    it("that go on beyond their borders as the sampler says", function()
      local row = paint("row.png", function(x) return { x / 8, 0, 0 } end)
      --- A model that shows the third texel right of 0 .. 1, and the fourth below.
      local function beyond(wrap, textures)
        return tiled { image = "row.png", sampler = { wrapS = wrap, wrapT = wrap }, options = { textures = textures },
          uv = function(x, y) return 1 + (x + 16) / 64, 1 + (y + 24) / 64 end }
      end
      for wrap, column in pairs { [10497] = 3, [33071] = 8, [33648] = 6 } do
        local red = row:get(1, column, 1)
        near(beyond(wrap, "mean").geometry[1].material.albedo[1], red, 1e-6)
        local layer = ylm.scene "x" { like = beyond(wrap), camera = ylm.camera { from = { 4, 4, 9 }, at = { 4, 4, 0 }, fov = 1 },
          lights = ylm.environment_light { radiance = 1 } }:render { size = { 1, 1 }, bounces = 0 }:layer()
        near(layer:get(1, 1, 1), red, 1e-2)
      end
      local _, message, code = load(gltf.new():text { materials = { { pbrMetallicRoughness = { baseColorTexture = {
        index = 0 } } } }, textures = { { source = 0, sampler = 0 } }, images = { { uri = "row.png" } },
        samplers = { { wrapS = 7 } } })
      assert.equal("EFORMAT", code)
      assert.truthy(message:find("/samplers/0/wrapS: 10497, 33071 or 33648 expected", 1, true), message)
    end)

    it("whose alpha cuts triangles off, or lets light through", function()
      -- Alpha is that of vertices: 1 left of x = 4, 0 from there on.
      local rgba = {}
      for _ = 0, 8 do for x = 0, 8 do
        for _, c in ipairs { 1, 1, 1, x < 4 and 1 or 0 } do rgba[#rgba + 1] = c end
      end end
      paint("white.png", function() return { 1, 1, 1 } end)
      local m = tiled { image = "white.png", rgba = rgba, material = { alphaMode = "MASK" } }
      near(m.geometry[1].mesh.area, 3 * 8 + 4) -- triangles with two corners of three on the left stay
      assert.equal(28 * 2, #m.geometry[1].mesh)
      assert.equal("model.gltf: mesh 0: triangles left out, because their alpha is below the cutoff: 72", m.report.notes[1])
      m = tiled { image = "white.png", rgba = rgba, material = { alphaMode = "MASK", alphaCutoff = 2 } }
      assert.equal(0, #m.geometry)
      for _, alpha in ipairs { 0.4, 0.6 } do
        for i = 4, #rgba, 4 do rgba[i] = alpha end
        m = tiled { image = "white.png", rgba = rgba, material = { alphaMode = "BLEND" } }
        assert.equal(alpha > 0.5, m.geometry[1].occludes)
      end
      -- Alpha of the image: a column of eight is opaque.
      local bytes = gltf.base64(gltf.png(8, 8, function(x) return 255, 255, 255, x == 1 and 255 or 0 end))
      m = tiled { image = "data:image/png;base64," .. bytes, material = { alphaMode = "MASK" } }
      near(m.geometry[1].mesh.area, 8)
      m = tiled { image = "data:image/png;base64," .. bytes, material = { alphaMode = "BLEND" } }
      assert.is_false(m.geometry[1].occludes)
    end)
  end)

  describe("makes polygon lights", function()
    --- The model of a surface of these triangles that emits.
    local function glowing(list, indices, more, options)
      local f = gltf.new()
      local material = { emissiveFactor = { 1, 0.5, 0.25 }, doubleSided = true,
        extensions = { KHR_materials_emissive_strength = { emissiveStrength = 8 } } }
      for key, x in pairs(more or {}) do material[key] = x end
      return assert(load(f:text { nodes = { { mesh = 0 } }, materials = { material }, meshes = { { primitives = {
        { attributes = { POSITION = f:accessor("VEC3", 5126, list) }, indices = f:accessor("SCALAR", 5123, indices),
          material = 0 } } } } }, options))
    end

    it("of an open surface, which is joined to one polygon", function()
      local list, indices = {}, {}
      for j = 0, 4 do for i = 0, 4 do
        list[#list + 1], list[#list + 2], list[#list + 3] = i / 2, 2, j / 2
        if i < 4 and j < 4 then
          local k = 5 * j + i
          for _, c in ipairs { k, k + 5, k + 1, k + 1, k + 5, k + 6 } do indices[#indices + 1] = c end
        end
      end end
      local m = glowing(list, indices)
      assert.equal(0, #m.geometry)
      assert.equal(1, #m.lights)
      assert.equal(4, #m.lights[1].vertices)
      assert.same({ 8, 4, 2 }, m.lights[1].radiance)
      assert.equal(0, m.report.lost)
      local points = { { 1, 0, 1 }, { -3, 0.3, 2 } }
      local direct = ylm.polygon_light { vertices = { { 0, 2, 0 }, { 0, 2, 2 }, { 2, 2, 2 }, { 2, 2, 0 } },
        radiance = { 8, 4, 2 } }
      local error = ylm.sh.relative_error(ylm.light_field(4, m.lights, points), ylm.light_field(4, direct, points))
      while type(error) == "userdata" do error = error:max() end
      assert(error < 1e-6, error)
    end)

    it("of a closed box, with half of the radiance: half of its sides face a point", function()
      local list, indices = {}, {}
      for i = 0, 7 do
        list[#list + 1], list[#list + 2], list[#list + 3] = i % 2, math.floor(i / 2) % 2, math.floor(i / 4)
      end
      for _, side in ipairs { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 4, 6, 2 }, { 1, 3, 7, 5 } } do
        for _, k in ipairs { 1, 2, 3, 1, 3, 4 } do indices[#indices + 1] = side[k] end
      end
      local m = glowing(list, indices, { doubleSided = false })
      assert.equal(6, #m.lights)
      assert.same({ 4, 2, 1 }, m.lights[1].radiance)
      assert.truthy(m.report.notes[1]:find("closed surfaces that emit", 1, true))
      -- A ray through the box crosses two of its sides: the flux at a far point is that of its outline.
      local L = ylm.light_field(0, m.lights, { { 0.5, 0.5, 100 } }, { dtype = "double" }):totable()[1][1][1]
      near(L, 8 / math.sqrt(4 * math.pi) / 99.5 ^ 2, 0.01)
      m = glowing(list, indices, nil, { emitters = 2 })
      assert.equal(2, #m.lights)
      near(m.report.lost, 2 / 3)
      assert.equal(1, #glowing(list, indices, nil, { emitters = 0 }).geometry)
    end)

    it("of the bright triangles of a texture", function()
      local image = ylm.image { size = { 2, 1 } }
      image:fill(1, 1, 1, 1, { 1, 1, 1 })
      assert(image:save(folder.path .. "/half.png"))
      local f = gltf.new()
      local m = assert(load(f:text { nodes = { { mesh = 0 } }, textures = { { source = 0 } }, images = { { uri = "half.png" } },
        materials = { { emissiveFactor = { 1, 1, 1 }, emissiveTexture = { index = 0 } } }, meshes = { { primitives = { {
          attributes = { POSITION = f:accessor("VEC3", 5126, { 0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 3, 0, 0, 2, 1, 0 }),
            TEXCOORD_0 = f:accessor("VEC2", 5126, { 0, 0, 0.4, 0, 0, 0.4, 0.6, 0, 0.9, 0, 0.6, 0.4 }) }, material = 0 } } } } }))
      assert.equal(1, #m.lights)
      assert.equal(1, #m.geometry)
      assert.equal(1, #m.geometry[1].mesh)
      assert.truthy(m.report.notes[1]:find("surfaces that emit to both sides, and to one in the file: 1", 1, true))
    end)
  end)

  it("makes spheres of points, of the same intensity; spots, suns and cameras", function()
    local m = assert(load(gltf.new():text {
      nodes = { { translation = { 0, 2, 0 }, extensions = { KHR_lights_punctual = { light = 0 } } },
        { translation = { 1, 2, 0 }, rotation = { -math.sqrt(0.5), 0, 0, math.sqrt(0.5) },
          extensions = { KHR_lights_punctual = { light = 1 } } },
        { extensions = { KHR_lights_punctual = { light = 2 } } }, { camera = 0, translation = { 0, 1, 5 } }, { camera = 1 } },
      cameras = { { type = "perspective", name = "front", perspective = { yfov = math.rad(40), znear = 0.1 } },
        { type = "orthographic", orthographic = { xmag = 1, ymag = 1, zfar = 1, znear = 0 } } },
      extensions = { KHR_lights_punctual = { lights = { { type = "point", intensity = 12, color = { 1, 0.5, 0.25 } },
        { type = "spot", intensity = 3, range = 9, spot = { innerConeAngle = 0.2, outerConeAngle = 0.4 } },
        { type = "directional", intensity = 5 } } } } }, { lamp_radius = 0.01 }))
    local d2 = 0.5 ^ 2 + 4 + 0.25 ^ 2
    local L = ylm.light_field(0, m.lights[1], { { 0.5, 0, 0.25 } }, { dtype = "double" }):totable()[1]
    for c, colour in ipairs { 1, 0.5, 0.25 } do near(L[c][1] * math.sqrt(4 * math.pi), 12 * colour / d2, 1e-3) end
    local r = m.lights[1].radius
    near(math.pi * r * r * m.lights[1].radiance[2], 6)
    near(m.lights[2].to[2], 1)
    near(m.lights[2].angle, math.deg(0.8))
    near(m.lights[3].direction[3], 1)
    assert.same({ 5, 5, 5 }, m.lights[3].irradiance)
    near(m.camera.fov, 40)
    assert.same({ 0, 1, 4 }, m.camera.at)
    assert.equal(m.camera, m.cameras.front)
    assert.equal(1, #m.cameras)
    assert.equal(3, #m.report.notes)
  end)

  it("is what scenes are like, in scripts, in scene files and on the command line", function()
    local f = gltf.new()
    local text = f:binary { meshes = { { primitives = { { attributes = { POSITION = f:accessor("VEC3", 5126, square) } } } } },
      nodes = { { mesh = 0 }, { extensions = { KHR_lights_punctual = { light = 0 } } } },
      extensions = { KHR_lights_punctual = { lights = { { type = "point" } } } } }
    local path = folder:write("room.glb", text)
    local scene = assert(ylm.load(folder:write("a.lua",
      "return scene 'a' { like = gltf { file = 'room.glb', lamp_radius = 0.1 }, moved = { { at = { 0, 5, 0 } } } }")))
    assert.equal(1, #scene.geometry)
    assert.same({ 0, 5, 0 }, scene.lights[1].at)
    assert.equal(0.1, scene.lights[1].radius)
    assert.equal(1, #assert(ylm.load(folder:write("b.lua", "return scene 'b' { like = 'room.glb' }"))).lights)
    assert.equal(1, #assert(ylm.load(path)).geometry)
    assert.equal("scene", require "ylm.form".kind(ylm.load(path)))
    local none, message, code = ylm.load(folder.path .. "/a.lua", { triangles = 0 })
    assert.is_nil(none)
    assert.equal("ELIMIT", code)
    assert.truthy(message:find("more than", 1, true), message)
  end)

  describe("and scene:save", function()
    local lights = {
      ylm.sphere_light { at = { 0.1, 2, 1 / 3 }, radius = 0.07, radiance = { 3, 1 / 7, 0 } },
      ylm.spot_light { at = { 0, 2, 0 }, to = { 1, 1, 5 }, angle = 50, blend = 0.3, intensity = { 1, 2, 3 } },
      ylm.sun_light { direction = { 1, 2, 3 }, angle = 2, irradiance = { 4, 5, 6 } },
      ylm.polygon_light { vertices = { { 0, 3, 0 }, { 1 / 3, 3, 0 }, { 1, 3, 1 }, { 0, 3, 1 } }, radiance = { 30, 20, 10 },
        horizon = { 0, 1, 0 } },
      ylm.disk_light { at = { 0, 4, 0.1 }, normal = { 1, 2, 3 }, radius = 0.3, radiance = 1 / 3 },
    }
    local scene = ylm.scene "All of it" {
      camera = ylm.camera { from = { 3, 2, 1 }, at = { 0.3, 0.2, 0.1 }, up = { 0.1, 1, 0 }, fov = 37 },
      geometry = {
        ylm.torus { material = ylm.matte { albedo = { 0.1, 1 / 3, 0.9 } }, sides = "both" },
        ylm.box { material = ylm.ggx { alpha = 0.3, f0 = { 1, 0.7, 0.3 } }, occludes = false },
        ylm.sphere { divide = { 8, 4 }, material = ylm.phong { exponent = 30 } },
        ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 },
          material = ylm.ggx { f0 = 0.04, base = { 0.5, 0.2, 0 } } },
        ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } },
          colours = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } },
      },
      lights = { lights,
        ylm.sphere_lights { at = { { 1, 1, 1 }, { 2, 2, 2 } }, radius = 0.1, radiance = { { 1, 2, 3 }, { 4, 5, 6 } } },
        ylm.environment_light { radiance = { 1, 1 / 3, 0.2 }, scale = 2 } },
      background = { 0.1, 0.2, 0.3 },
    }

    local function check_same(again)
      assert.equal("0.1 0.2 0.3", ("%.6g %.6g %.6g"):format((table.unpack or unpack)(again.background))) -- luacheck: ignore 113
      for _, name in ipairs { "from", "at", "up" } do assert.same(scene.camera[name], again.camera[name]) end
      near(again.camera.fov, 37)
      assert.equal(#scene.geometry, #again.geometry)
      for i, piece in ipairs(scene.geometry) do
        local other = again.geometry[i]
        assert.equal(piece.mesh:vertices():bytes(), other.mesh:vertices():bytes())
        assert.equal(piece.mesh:triangles():bytes(), other.mesh:triangles():bytes())
        assert.equal(piece.occludes, other.occludes)
        assert.equal(piece.sides, other.sides)
        if piece.material then
          local albedo = require "ylm.material".albedo
          local a, b = albedo("spec", piece.material), albedo("spec", other.material)
          for c = 1, 3 do near(b[c], a[c]) end
        end
      end
      assert.equal(scene.geometry[5].mesh:colours():bytes(), again.geometry[5].mesh:colours():bytes())
      local order = { 1, 2, 3, 6, 7, 4, 5 } -- flat lamps, which are surfaces, come last
      for i, k in ipairs { 1, 2, 3, 4, 5 } do
        local a, b = lights[k], nil
        for n, place in ipairs(order) do if place == i then b = again.lights[n] end end
        for _, field in ipairs(require "ylm.form".defined[require "ylm.form".kind(a)].fields) do
          assert.same(a[field[1]], b[field[1]], field[1])
        end
      end
      assert.same({ 4, 5, 6 }, again.lights[5].radiance)
      assert.equal(8, #again.lights)
      local sky, phong = again.lights[8], again.geometry[3].material
      assert.same({ 1, 1 / 3, 0.2, 2 }, { sky.radiance[1], sky.radiance[2], sky.radiance[3], sky.scale })
      assert.equal("phong", require "ylm.form".kind(phong))
      assert.equal(30, phong.exponent)
    end

    it("bring lamps back exactly, positions to the bit, materials to 1e-6", function()
      for _, name in ipairs { "a.glb", "a.gltf", "b c.gltf" } do
        local path = folder.path .. "/" .. name
        local ok, notes = scene:save(path, { separate = name == "b c.gltf" })
        assert.is_true(ok)
        assert.same({ "materials of kind phong, written as their nearest ggx: 1",
          "skies, in extras.ylm, which other programs do not read: 1" }, notes)
        check_same(assert(ylm.load(path)))
      end
    end)

    it("say in one line what is left out; strict refuses, and writes nothing", function()
      local said, path, all = {}, folder.path .. "/said.glb", ylm.scene "All of it" { like = scene }
      local before = ylm.on_warning(function(line) said[#said + 1] = line end)
      local ok, message, code = all:save(path, { strict = true })
      assert.same({}, said)
      assert.is_nil(ok)
      assert.equal("ELIMIT", code)
      assert.matches("said.glb is not written, since glTF would lack (strict): materials of kind phong", message, 1, true)
      assert.is_nil((io.open(path)))
      for _ = 1, 2 do assert(all:save(path)) end
      local plain = ylm.scene "plain" { lights = { lights[1] } }
      assert(plain:save(path, { strict = true }))
      ylm.on_warning(before)
      assert.equal(1, #said)
      assert.matches('said.glb, glTF of scene "All of it", lacks or simplifies: materials of kind phong', said[1], 1, true)
      assert.is_nil(said[1]:find "\n")
    end)

    it("bring skies back: of the CIE and of coefficients exactly, images as their coefficients", function()
      local image = ylm.image { size = { 8, 4 } }
      for x = 1, 8 do image:layer "radiance":set(2, x, 2, x) end
      local skies = {
        ylm.environment_light { sky = { kind = "clear", sun = { 1, 2, 1 }, zenith = { 0, 1, 0 }, luminance = 3 }, lmax = 6 },
        ylm.environment_light { coefficients = { { 1, 0.2, 0.1, 1 / 3 }, { 2, 0, 0, 0 }, { 1, 0, 0.5, 0 } }, scale = 0.7 },
        ylm.environment_light { image = image, lmax = 5 },
      }
      local path = folder.path .. "/skies.gltf"
      local _, notes = assert(ylm.scene "skies" { lights = skies }:save(path))
      assert.same({ "skies, in extras.ylm, which other programs do not read: 3",
        "images of skies, written as their coefficients of degree 5: 1" }, notes)
      local again = assert(ylm.load(path))
      for i, sky in ipairs(skies) do
        local a, b = ylm.light_field(1, sky, { 0, 0, 0 }), ylm.light_field(1, again.lights[i], { 0, 0, 0 })
        assert.equal(0, (a - b):abs():max())
      end
      assert.equal("clear", again.lights[1].seen.kind)
      local text = scratch.text(path)
      for lost, change in pairs { [3] = { '"scale"', '"radiance":7,"scale"' },
        [1] = { '"coefficients":%[%[1,', '"coefficients":["x",[1,' } } do
        local m = assert(load((text:gsub(change[1], change[2]))))
        assert.matches("skies of extras.ylm left out, because they are none: " .. lost, m.report.notes[1], 1, true)
      end
      local twice = assert(load(text, { light_scale = 2 }))
      local one, two = ylm.light_field(1, skies[2], { 0, 0, 0 }), ylm.light_field(1, twice.lights[2], { 0, 0, 0 })
      assert.near(0, (one * 2 - two):abs():max(), 1e-12)
    end)

    it("write Phong's lobe as the GGX lobe that differs least from it", function()
      --- Sums over directions of the squared difference of two lobes times cosine, and of the first's square, at one angle.
      local function sums(n, a, angle)
        local e, w, wx, wz, reach = 0, 0, math.sin(angle), math.cos(angle), math.min(math.pi / 2, 6 / math.sqrt(n + 1))
        local function lambda(c) return (math.sqrt(1 + a * a * (1 - c * c) / (c * c)) - 1) / 2 end
        for i = 0, 39 do
          for k = 0, 15 do
            local r, p = (i + 0.5) / 40 * reach, (k + 0.5) * math.pi / 8
            local x, y = math.sin(r) * math.cos(p) * wz - math.cos(r) * wx, math.sin(r) * math.sin(p)
            local z = math.cos(r) * wz + math.sin(r) * math.cos(p) * wx
            if z > 0 then
              local h = (z + wz) / math.sqrt((x + wx) ^ 2 + y * y + (z + wz) ^ 2)
              local phong = (n + 2) / (2 * math.pi) * math.cos(r) ^ n * z
              local d = a * a / (math.pi * (h * h * (a * a - 1) + 1) ^ 2) / (1 + lambda(z) + lambda(wz)) / (4 * wz)
              e, w = e + (phong - d) ^ 2 * math.sin(r), w + phong ^ 2 * math.sin(r)
            end
          end
        end
        return e, w
      end
      local function difference(n, a)
        local e, w = 0, 0
        for degrees = 0, 60, 15 do
          if degrees ~= 15 then
            local x, y = sums(n, a, math.rad(degrees))
            e, w = e + x, w + y
          end
        end
        return math.sqrt(e / w)
      end
      for _, n in ipairs { 20, 100, 1000 } do
        local path = folder.path .. "/phong.gltf"
        local shiny = ylm.phong { exponent = n, specular = 0.5, base = 0 }
        assert(ylm.scene "phong" { geometry = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 },
          material = shiny } }:save(path))
        local text = scratch.text(path):gsub('"extras":{"ylm":{"kind":"phong".-}}', '"extras":{}')
        local read = assert(load(text)).geometry[1].material
        assert.equal("ggx", require "ylm.form".kind(read))
        assert.near(0.5, read.f0[1], 1e-6)
        local at = difference(n, read.alpha[1])
        assert(at < 0.45 and difference(n, math.sqrt(2 / (n + 2))) > 0.55, at)
        for _, factor in ipairs { 0.7, 1.4 } do assert(difference(n, factor * read.alpha[1]) > at, n) end
      end
    end)

    it("look the same", function()
      local lit = ylm.scene "lit" { camera = scene.camera, geometry = { scene.geometry[1], scene.geometry[2], scene.geometry[4] },
        lights = { lights[1], lights[4] } }
      assert(lit:save(folder.path .. "/lit.glb"))
      local function look(of) return of:render { by = "sum", size = { 24, 16 }, visibility = "none" }:layer() end
      local a, d = look(lit), look(assert(ylm.load(folder.path .. "/lit.glb")))
      d = d - a
      assert((d * d):mean() <= 1e-6 * a:max() ^ 2, (d * d):mean()) -- 60 dB
      assert(a:max() > 0.1)
    end)

    it("leave what another program has changed", function()
      local path = folder.path .. "/a.gltf"
      assert(ylm.scene "x" { lights = { lights[1], lights[4] } }:save(path))
      local text = scratch.text(path)
      local m = assert(load((text:gsub('"intensity":[%d.e-]+', '"intensity":7', 1):gsub('"emissiveStrength":30',
        '"emissiveStrength":60'))))
      near(math.pi * m.lights[1].radius ^ 2 * m.lights[1].radiance[1], 7)
      assert.equal(0.07, m.lights[1].radius)
      assert.equal(2, #m.lights) -- the surface emits, and is no lamp of ylm any more
      assert.equal(4, #m.lights[2].vertices)
      assert.same({ 60, 40, 20 }, m.lights[2].radiance)
      m = assert(load((text:gsub('"translation":%[[^%]]*%]', '"translation":[5,6,7]', 1))))
      assert.same({ 5, 6, 7 }, m.lights[1].at)
      assert.same({ 3, 1 / 7, 0 }, m.lights[1].radiance)
    end)

    it("pass the validator without errors and warnings", function()
      local modules = os.getenv "YLM_NODE_MODULES"
      local there_too = "command -v node >/dev/null && test -d " .. scratch.quote((modules or "") .. "/gltf-validator")
      if not modules or not scratch.shell(there_too) then
        pending "YLM_NODE_MODULES with npm's gltf-validator, and node, are wanted"
      end
      folder:write("v.js", ([[
const v = require('%s/gltf-validator'), fs = require('fs');
const bytes = f => new Uint8Array(fs.readFileSync(f));
(async () => { for (const f of process.argv.slice(2)) {
  const r = await v.validateBytes(bytes(f), { uri: f,
    externalResourceFunction: u => Promise.resolve(bytes(decodeURIComponent(u))) });
  console.log(r.issues.numErrors, r.issues.numWarnings, r.issues.messages.filter(m => m.severity < 2).map(m => m.code).join());
} })();
]]):format(modules))
      assert(scene:save(folder.path .. "/a.glb"))
      assert(scene:save(folder.path .. "/a.gltf"))
      assert(scene:save(folder.path .. "/b c.gltf", { separate = true }))
      assert(ylm.scene "nothing" {}:save(folder.path .. "/n.glb"))
      local out = scratch.capture(("cd %s && node v.js a.glb a.gltf 'b c.gltf' n.glb"):format(scratch.quote(folder.path)))
      assert.equal(("0 0 \n"):rep(4), out:sub(-1) == "\n" and out or out .. "\n")
    end)
  end)

  describe("refuses", function()
    --- The text is refused with this code and a message that holds `says`.
    local function refuses(code, says, text, name)
      local m, message, got = load(text, nil, name)
      assert.is_nil(m)
      assert(message:find(says, 1, true), message)
      assert.equal(code, got, message)
    end

    local mesh = { meshes = { { primitives = { { attributes = { POSITION = 0 }, indices = 1 } } } }, nodes = { { mesh = 0 } } }

    --- A file of one mesh with a change.
    local function changed(change)
      local f = gltf.new()
      f:accessor("VEC3", 5126, square)
      f:accessor("SCALAR", 5123, { 0, 1, 2 })
      if change then change(f) end
      return f:text(mesh)
    end

    it("what is cut, no JSON, or of another version", function()
      assert(load(changed()))
      refuses("EFORMAT", "not JSON", "")
      refuses("EFORMAT", "not JSON", changed():sub(1, 100))
      refuses("EFORMAT", "not JSON", '{"a":1,"a":2}')
      refuses("EFORMAT", "not JSON", '{"a":1e400}')
      refuses("EFORMAT", "the JSON is no object", "[]")
      refuses("EFORMAT", "/asset: no glTF file: a version is missing", "{}")
      refuses("EVERSION", "/asset: version 1.0, 2 is known", '{"asset":{"version":"1.0"}}')
      refuses("EFORMAT", "KHR_draco_mesh_compression is needed, and not known; write the file again without compression",
        '{"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]}')
      local binary = gltf.container('{"asset":{"version":"2.0"}}', "abcd")
      assert(load(binary, nil, "b.glb"))
      for n = 4, #binary - 1 do
        assert.is_nil((load(binary:sub(1, n), nil, "cut.glb")))
      end
      refuses("EFORMAT", "truncated: 60 bytes are said, 59 are there", binary:sub(1, -2), "cut.glb")
      refuses("ELIMIT", "the JSON nests more than 64 deep", ("["):rep(100000))
      refuses("EFORMAT", "/nodes/3: an object expected", '{"asset":{"version":"2.0"},"nodes":[{},{},{},7]}')
    end)

    it("bytes that are not there, and numbers that name nothing", function()
      refuses("EFORMAT", "/buffers/0: buffer 0 has 54 bytes, 60 are said", (changed():gsub('"byteLength":54', '"byteLength":60')))
      refuses("EFORMAT", "/bufferViews/1: bytes 48 to 58 of a buffer of 54",
        changed(function(f) f.views[2].byteLength = 10 end))
      refuses("EFORMAT", "/accessors/0: 5 elements from byte 0 on do not fit a view of 48 bytes",
        changed(function(f) f.accessors[1].count = 5 end))
      refuses("EFORMAT", "do not fit a view", changed(function(f) f.accessors[1].count = 2 ^ 31 end))
      refuses("EFORMAT", "count must be 1 or more", changed(function(f) f.accessors[1].count = 2 ^ 52 end))
      refuses("EFORMAT", "/accessors/0/byteOffset: an integer of 0 or more expected",
        changed(function(f) f.accessors[1].byteOffset = 2 ^ 60 end))
      refuses("EFORMAT", "/bufferViews/0/byteOffset", changed(function(f) f.views[1].byteOffset = -8 end))
      refuses("EFORMAT", "/accessors/0/bufferView: view 9 of 2", changed(function(f) f.accessors[1].bufferView = 9 end))
      refuses("EFORMAT", "byteStride from 4 to 252", changed(function(f) f.views[1].byteStride = 2 end))
      refuses("EFORMAT", "/meshes/0/primitives/0/indices: accessor 1 of 1", changed(function(f) f.accessors[2] = nil end))
      refuses("EFORMAT", "/meshes/0/primitives/0/indices: index 2 is 9, there are 4 vertices",
        changed(function(f) f.data = f.data:sub(1, 52) .. "\9\0" .. f.data:sub(55) end))
      refuses("EFORMAT", "POSITION: finite numbers expected",
        changed(function(f) f.data = gltf.float(0 / 0) .. f.data:sub(5) end))
      refuses("EFORMAT", "type VEC9 of componentType 5126 is not known", changed(function(f) f.accessors[1].type = "VEC9" end))
      refuses("ELIMIT", "elements without a view", changed(function(f)
        f.accessors[1].bufferView, f.accessors[1].count = nil, 2 ^ 24
      end))
      refuses("EFORMAT", "/accessors/0/sparse/indices: index 1 is 1: rising ones below 4 expected", changed(function(f)
        f.accessors[1].sparse = { count = 2, indices = { bufferView = f:view "\1\1", componentType = 5121 },
          values = { bufferView = 0 } }
      end))
      refuses("EFORMAT", "base64", (changed():gsub("base64,....", "base64,A_*A")))
    end)

    it("nodes that are below themselves, below two, or too deep", function()
      local function nodes(list, more)
        local all = { nodes = list }
        for key, value in pairs(more or {}) do all[key] = value end
        return gltf.new():text(all)
      end
      refuses("EFORMAT", "the node is below itself", nodes { { children = { 1 } }, { children = { 0 } } })
      refuses("EFORMAT", "/nodes/1/children/0: node 2 is a child of node 0 too",
        nodes { { children = { 2 } }, { children = { 2 } }, { name = "x" } })
      refuses("EFORMAT", "/scenes/0/nodes/0: the number of a node without a parent expected",
        nodes({ { children = { 1 } }, { name = "x" } }, { scenes = { { nodes = { 1 } } } }))
      refuses("EFORMAT", "/scene: scene 4 of 1", nodes({ { name = "x" } }, { scene = 4, scenes = { { nodes = { 0 } } } }))
      local deep = {}
      for i = 1, 300 do deep[i] = { children = i < 300 and { i } or nil, name = "x" } end
      refuses("ELIMIT", "nodes nest more than 256 deep", nodes(deep))
      refuses("EFORMAT", "/nodes/0: its place is beyond 1e12", nodes { { translation = { 1e13, 0, 0 } } })
      refuses("EFORMAT", "/nodes/0/scale: 3 numbers expected", nodes { { scale = { 1, 2 } } })
    end)

    it("files outside of the folder, and those that are missing", function()
      local function uri(text) return (changed():gsub("data:[^\"]*", (text:gsub("%%", "%%%%")))) end
      refuses("EIO", "/buffers/0/uri: none.bin: no such file", uri "none.bin")
      for _, name in ipairs { "../x.bin", "/etc/passwd", "file:///etc/passwd", "http://a/b", "a%2f..%2f..%2fx", "%00", "a%zz",
        "..", "a\\\\b" } do
        refuses("EFORMAT", "a file in the folder of this one expected", uri(name))
      end
      scratch.shell("ln -s /etc/passwd " .. scratch.quote(folder.path .. "/link.bin"))
      refuses("EIO", "a link that leads out of the folder", uri "link.bin")
      refuses("EFORMAT", "base64 alone is read", uri "data:text/plain,abc")
      local f = gltf.new()
      f:accessor("VEC3", 5126, square)
      folder:write("my data.bin", f.data)
      assert(load(f:json({ meshes = { { primitives = { { attributes = { POSITION = 0 } } } } }, nodes = { { mesh = 0 } } },
        "my%20data.bin")))
    end)

    it("more than it may hold", function()
      local instances = { { children = { 1, 2, 3, 4 } } }
      for i = 2, 5 do instances[i] = { mesh = 0 } end
      local f = gltf.new()
      f:accessor("VEC3", 5126, square)
      f:accessor("SCALAR", 5123, { 0, 1, 2 })
      local several = folder:write("several.gltf", f:text { meshes = mesh.meshes, nodes = instances })
      assert.equal(4, assert(ylm.load(several)).report.triangles)
      local none, says, why = ylm.load(several, { triangles = 3 })
      assert.is_nil(none)
      assert.equal("ELIMIT", why)
      assert.truthy(says:find("more than 3 triangles", 1, true), says)
      -- An image that says it is large: 14 GB were to be taken.
      local large = { materials = { { pbrMetallicRoughness = { baseColorTexture = { index = 0 } } } },
        textures = { { source = 0 } },
        images = { { uri = "data:image/png;base64," .. gltf.base64(gltf.png(60000, 60000, nil, 0)) } } }
      local bomb = assert(load(gltf.new():text(large)))
      assert.truthy(bomb.notes[1]:find("image 0: 60000 x 60000 pixels: images are limited to", 1, true), bomb.notes[1])
      assert.truthy(bomb.notes[1]:find("the factors stand alone", 1, true), bomb.notes[1])
      local path = folder:write("many.gltf", changed())
      local m, message, code = ylm.load(path, { triangles = 0 })
      assert.is_nil(m)
      assert.truthy(message:find("more than", 1, true), message)
      assert.equal("ELIMIT", code)
    end)
  end)
end)
