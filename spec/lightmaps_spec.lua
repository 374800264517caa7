-- scene:lightmap: pictures of irradiance with coordinates of their own, as somebody reads them who has only the files.

local ylm = require "ylm"
local core = require "ylm.c.core"
local images = require "ylm.image"
local long = require "spec.support.long"
local random = require "spec.support.random"
local scratch = require "spec.support.scratch"

local white = ylm.matte { albedo = 0.5 }
local links = ylm.links { spacing = 0.5, rays = 16 }
local lamp = ylm.sphere_light { at = { 0.2, 0.3, 0 }, radius = 0.05, radiance = 100 }
--- The light of the lamp on a wall of the box from -1 to 1, at x with the normal n.
local function truth(x, n)
  local d, square, cosine = {}, 0, 0
  for a = 1, 3 do
    d[a] = lamp.at[a] - x[a]
    square, cosine = square + d[a] * d[a], cosine + d[a] * n[a]
  end
  return math.pi * 0.05 ^ 2 * 100 * cosine / square ^ 1.5
end

local function box(fields)
  return ylm.scene "a box" { geometry = { ylm.box { scale = 2, material = white } }, lights = fields and fields.lights or lamp,
    links = links }
end

--- A bilinear look-up at u, v of the texture coordinates, v upwards.
local function look_up(layer, size, u, v)
  local x, y = u * size[1] - 0.5, (1 - v) * size[2] - 0.5
  local i, j, sum = math.floor(x), math.floor(y), 0
  for k = 0, 3 do
    local a, b = i + k % 2, j + math.floor(k / 2)
    local w = (1 - math.abs(x - a)) * (1 - math.abs(y - b))
    a, b = math.max(0, math.min(size[1] - 1, a)), math.max(0, math.min(size[2] - 1, b))
    if w > 0 then sum = sum + w * layer:get(b + 1, a + 1, 1) end
  end
  return sum
end

--- f(x, n, E, at) at `count` random places of a piece's triangles, E as the picture has it at these coordinates.
local function visit(piece, image, count, f)
  local r, layer = random.minimal(4711), image:layer "irradiance"
  local triangles, vertices, normals = piece.mesh:triangles(), piece.mesh:vertices(), piece.mesh:normals()
  for _ = 1, count do
    local t, u, v = 1 + math.floor(#triangles * r()), r(), r()
    if u + v > 1 then u, v = 1 - u, 1 - v end
    local w, x, n, at = { 1 - u - v, u, v }, { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0 }
    for k = 1, 3 do
      local of = triangles:get(t, k)
      for a = 1, 3 do
        x[a], n[a] = x[a] + w[k] * vertices:get(of, a), n[a] + w[k] * normals:get(of, a)
      end
      for a = 1, 2 do at[a] = at[a] + w[k] * piece.uvs:get(of, a) end
    end
    f(x, n, look_up(layer, image.size, at[1], at[2]), at)
  end
end

--- Corners of triangles that lie within an edge of another one, and the area of all.
local function gaps(mesh)
  local triangles, vertices, found, area = mesh:triangles(), mesh:vertices(), 0, 0
  local function place(i) return { vertices:get(i, 1), vertices:get(i, 2), vertices:get(i, 3) } end
  local function apart(a, b) return { b[1] - a[1], b[2] - a[2], b[3] - a[3] } end
  local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end
  for t = 1, #triangles do
    local p = { place(triangles:get(t, 1)), place(triangles:get(t, 2)), place(triangles:get(t, 3)) }
    local a, b = apart(p[1], p[2]), apart(p[1], p[3])
    area = area + 0.5 * math.sqrt(math.max(0, dot(a, a) * dot(b, b) - dot(a, b) ^ 2))
    for k = 1, 3 do
      local edge = apart(p[k], p[k % 3 + 1])
      local length = math.sqrt(dot(edge, edge))
      for i = 1, #vertices do
        local to = apart(p[k], place(i))
        local along = dot(to, edge) / length
        local beside = math.sqrt(math.max(0, dot(to, to) - along ^ 2))
        if along > 1e-3 and along < length - 1e-3 and beside < 1e-4 then found = found + 1 end
      end
    end
  end
  return found, area
end

describe("scene:lightmap", function()
  it("has the light of a lamp on the walls of a box, to 2 % at 99 of 100 places", function()
    local light = box():lightmap { texels = 4096, quantity = "direct", rays = 4, light_samples = 8 }
    local pieces, image, misses = light:pieces(), light:image(), 0
    assert.same({ 1, 1, true }, { #pieces, pieces[1].number, pieces[1].back })
    visit(pieces[1], image, 1000, function(x, n, E)
      if math.abs(E / truth(x, n) - 1) > 0.02 then misses = misses + 1 end
      local here, chart = light:irradiance({ x }, { n })
      assert.is_true(math.abs(here:get(1, 1) - E) < 1e-3 * E and chart:get(1) >= 1 and chart:get(1) <= light.stats.charts)
    end)
    assert.is_true(misses <= 10, misses)
    assert.is_true(light.stats.error < 0.02 and light.stats.met == nil, light.stats.error)
    assert.is_true(light.stats.width * light.stats.height <= 4096 and light.stats.bytes <= 6 * 4096)
  end)

  it("keeps a tolerance, and says so, or warns", function()
    local light = box():lightmap { tolerance = 0.1, rays = 16, light_samples = 8, judge = "field" }
    assert.is_true(light.stats.met and light.stats.error <= 0.1 and light.stats.verified > 2000)
    local warned
    ylm.on_warning(function(sentence) warned = sentence end)
    local poor = box({ lights = ylm.sphere_light { at = { 0.5, -0.9, 0 }, radius = 0.01, radiance = 1e4 } }):lightmap {
      tolerance = 0.01, texels = 256, rays = 4, light_samples = 2, judge = "field", quantity = "direct" }
    ylm.on_warning(nil)
    assert.is_false(poor.stats.met)
    assert.is_true(poor.stats.spent)
    assert.truthy(warned:find "tolerance 0.01 is not met" and warned:find "texels are spent")
    local misses = poor.stats.misses
    assert.equal(poor.stats.failed, misses.edges + misses.bodies + misses.noise)
    assert.truthy(warned:find(("of %d places that miss 0.01 by elements"):format(poor.stats.failed), 1, true))
  end)

  it("asks noisy places again for a tolerance", function()
    local noise = {}
    ylm.on_warning(false)
    for _, tolerance in ipairs { false, 0.02 } do
      local scene = ylm.scene "a lamp behind a block" { geometry = { ylm.box { scale = 2, material = white },
        ylm.box { bounds = { { -0.4, -0.4, -0.4 }, { 0.2, -0.2, 0.3 } }, material = white } }, links = links,
        lights = ylm.sphere_light { at = { 0, 0.6, 0 }, radius = 0.3, radiance = 10 } }
      noise[tolerance] = scene:lightmap({ tolerance = tolerance or nil, texels = 1024, rays = 8, light_samples = 2,
        quantity = "direct", judge = "field" }).stats.noise
    end
    ylm.on_warning(nil)
    assert.is_true(noise[0.02] < 0.5 * noise[false], ("%.4g, once %.4g"):format(noise[0.02], noise[false]))
  end)

  it("gives charts where light bends more texels, and misses less than even ones", function()
    local walls = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = white } }
    for i = 0, 4 do
      walls[#walls + 1] = ylm.quad { corner = { -2, i + 3, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = white,
        sides = "back" }
    end
    local scene = ylm.scene "one floor near a lamp" { geometry = walls,
      lights = ylm.sphere_light { at = { 0, 0.15, 0 }, radius = 0.02, radiance = 1000 } }
    local rms = {}
    for _, spread in ipairs { "even", "light" } do
      rms[spread] = scene:lightmap({ texels = 3000, spread = spread, quantity = "direct", rays = 4,
        light_samples = 4 }).stats.rms
    end
    assert.is_true(rms.light < 0.7 * rms.even, ("%.4g, even %.4g"):format(rms.light, rms.even))
  end)

  it("divides a floor near a lamp into charts of their own density, which files read as look-ups do", function()
    local scene = ylm.scene "a floor near a lamp" {
      geometry = ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 }, material = white, sides = "front" },
      lights = ylm.sphere_light { at = { 1.1, 0.2, -0.6 }, radius = 0.02, radiance = 1000 } }
    local rms = {}
    for _, parts in ipairs { false, true } do
      local light = scene:lightmap { texels = 2048, parts = parts, quantity = "direct", rays = 4, light_samples = 4 }
      local piece = light:pieces()[1]
      rms[parts] = light.stats.rms
      if parts then assert.is_true(light.stats.charts > 4 and #piece.mesh > 2) else assert.equal(2, #piece.mesh) end
      local open, area = gaps(piece.mesh)
      assert.is_true(open == 0 and math.abs(area - 36) < 1e-3 and #piece.mesh < 100, open)
      visit(piece, light:image(), 200, function(x, n, E)
        local here = light:irradiance({ x }, { n }):get(1, 1)
        assert.is_true(math.abs(x[2]) < 1e-6 and math.abs(here - E) < 2e-3 * E + 1e-4, ("%g %g"):format(here, E))
      end)
    end
    assert.is_true(rms[true] < 0.4 * rms[false], ("%.4g, whole %.4g"):format(rms[true], rms[false]))
  end)

  it("leaves no corner within an edge where a divided floor meets a strip that is whole", function()
    local piece = assert(ylm.scene "a floor and a kerb" { geometry = ylm.mesh { material = white,
      vertices = { { -3, 0, 3 }, { 3, 0, 3 }, { 3, 0, -3 }, { -3, 0, -3 }, { -3, 0.02, -3 }, { 3, 0.02, -3 } },
      triangles = { { 1, 2, 3 }, { 1, 3, 4 }, { 4, 3, 6 }, { 4, 6, 5 } } },
      lights = ylm.sphere_light { at = { 1.1, 0.2, -2.6 }, radius = 0.02, radiance = 1000 }, links = links }
      :lightmap { texels = 2048, quantity = "direct", rays = 4, light_samples = 1 }):pieces()[1]
    local open, area = gaps(piece.mesh)
    assert.is_true(open == 0 and math.abs(area - 36.12) < 1e-3 and #piece.mesh > 10, open)
  end)

  it("cuts no triangles that lie over each other, whose parts would be charts each", function()
    local light = assert(ylm.scene "three floors in one place" { geometry = ylm.mesh { material = white,
      vertices = { { 0, 0, 0 }, { 0, 0, 3 }, { 3, 0, 3 }, { 3, 0, 0 } },
      triangles = { { 1, 2, 3 }, { 1, 3, 4 }, { 1, 2, 3 }, { 1, 3, 4 }, { 1, 2, 3 }, { 1, 3, 4 } } },
      lights = ylm.sphere_light { at = { 1, 0.3, 1 }, radius = 0.05, radiance = 100 }, links = links }
      :lightmap { texels = 2048, quantity = "direct", rays = 4, light_samples = 1 })
    assert.is_true(light.stats.charts >= 6 and light.stats.charts <= 12, light.stats.charts)
  end)

  it("agrees across seams of a sphere to 2 %, and better in mip maps where gutters are wide", function()
    local scene, jumps = ylm.scene "a ball" { geometry = { ylm.sphere { divide = { 24, 12 }, material = white } },
      links = links, lights = ylm.sphere_light { at = { 3, 2, 1 }, radius = 0.2, radiance = 100 } }, {}
    for _, gutter in ipairs { 1, 4 } do
      local light = scene:lightmap { texels = 6144, rays = 4, light_samples = 2, gutter = gutter }
      assert.is_true(light.stats.seams > 20)
      assert.is_true(light.stats.jump < 0.02, light.stats.jump)
      jumps[gutter] = light.stats.jump_1
    end
    assert.is_true(jumps[4] < 0.2 and jumps[4] < 0.5 * jumps[1], jumps[1] .. " " .. jumps[4])
  end)

  it("has the flow of light, by which tilted normals read a lamp's light to 4 %", function()
    local light = box():lightmap { texels = 4096, quantity = "direct", rays = 4, light_samples = 8, directional = true }
    local image, misses, n = light:image(), 0, 0
    local flow = { image:layer "flow_x", image:layer "flow_y", image:layer "flow_z" }
    visit(light:pieces()[1], image, 300, function(x, normal, E, at)
      local tilted, length = { normal[1] + 0.3, normal[2] - 0.2, normal[3] + 0.25 }, 0
      for a = 1, 3 do length = length + tilted[a] ^ 2 end
      for a = 1, 3 do
        tilted[a] = tilted[a] / math.sqrt(length)
        E = E + (tilted[a] - normal[a]) * look_up(flow[a], image.size, at[1], at[2])
      end
      local wanted = truth(x, tilted)
      n = n + 1
      if math.abs(E - wanted) > 0.04 * math.max(wanted, 0.3) then misses = misses + 1 end
    end)
    assert.is_true(misses <= 0.02 * n, misses)
    assert.equal(24 * light.stats.width * light.stats.height, light.stats.bytes)
    local folder = scratch.new()
    local _, facts = assert(light:save(folder.path .. "/room.exr"))
    assert.same({ "room.exr", "room_x.exr", "room_y.exr", "room_z.exr" }, facts.files)
    assert.is_true(ylm.load(folder.path .. "/room_y.exr"):layer "irradiance":same(flow[2], 0))
    folder:remove()
  end)

  it("averages where light is smooth: less noise than each texel by itself", function()
    local rms = {}
    for _, smooth in ipairs { false, true } do
      rms[smooth] = box():lightmap({ texels = 2048, rays = 8, light_samples = 2, quantity = "indirect",
        smooth = smooth }).stats.rms
    end
    assert.is_true(rms[true] < 0.8 * rms[false], ("%.4g, alone %.4g"):format(rms[true], rms[false]))
  end)

  it("is not dimmer where its places have more noise", function()
    if not long(false, true) then return pending "make check-long" end
    local scene = ylm.scene "a lamp on a shelf" { geometry = { ylm.box { scale = 2, material = white },
      ylm.box { bounds = { { -0.5, 0.5, -0.5 }, { 0.5, 0.55, 0.5 } }, material = white } },
      lights = ylm.sphere_light { at = { 0, 0.8, 0 }, radius = 0.1, radiance = 100 } }
    local points, normals = {}, {}
    for i = 1, 400 do
      points[i], normals[i] = { i % 20 * 0.09 - 0.85, -1, math.floor((i - 1) / 20) * 0.09 - 0.85 }, { 0, 1, 0 }
    end
    local function mean(rays, seeds)
      local sum = 0
      for seed = 1, seeds do
        local E = scene:lightmap({ texels = 1024, rays = rays, seed = seed }):irradiance(points, normals)
        for i = 1, #points do sum = sum + E:get(i, 2) / #points / seeds end
      end
      return sum
    end
    local off = mean(16, 8) / mean(64, 8) - 1 -- to 1 %
    assert(math.abs(off) < 0.03, off)
  end)

  it("has the sides of meshes that have light, and no light in bodies", function()
    local light = ylm.scene "a plate and a block in it" { geometry = {
      ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = white },
      ylm.box { bounds = { { -0.5, -0.5, -0.5 }, { 0.5, 0.5, 0.5 } }, material = white } },
      links = links, lights = ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.2, radiance = 100 } }
      :lightmap { texels = 512, rays = 16 }
    local sides = {}
    for i, piece in ipairs(light:pieces()) do sides[i] = piece.number .. (piece.back and " back" or " front") end
    assert.same({ "1 front", "1 back", "2 front" }, sides)
  end)

  it("gives the same bits for any number of threads", function()
    local one
    for _, threads in ipairs { 1, 3 } do
      local bytes = box():lightmap({ texels = 600, rays = 4, threads = threads }):image():layer "irradiance":bytes()
      one = one or bytes
      assert.equal(one, bytes)
    end
  end)

  --- A bake that goes on in a file, and stops at a stage of its progress, or never.
  local function resumed(path, stop, fields)
    fields = fields or {}
    return box { lights = fields.lights }:lightmap { texels = 600, rays = fields.rays or 4, directional = true, resume = path,
      progress = { function(_, _, stage) return stage ~= stop end, every = 1e-6 } }
  end

  it("goes on where it was interrupted, or damaged, with the bits of a bake that was not", function()
    local folder = scratch.new()
    local path, whole = folder.path .. "/box.part", box():lightmap { texels = 600, rays = 4, directional = true }
    local _, _, code = resumed(path, "texels")
    local bytes = folder:read "box.part"
    assert.equal("ECANCELLED", code)
    assert.is_true(#bytes > 5000)
    for _, kept in ipairs { bytes, bytes:sub(1, -7) .. "x", bytes:sub(1, 5000) } do
      folder:write("box.part", kept)
      local light = assert(resumed(path))
      for _, layer in ipairs { "irradiance", "flow_x" } do
        assert.equal(whole:image():layer(layer):bytes(), light:image():layer(layer):bytes())
      end
      assert.equal(whole.stats.places, light.stats.places)
      assert.is_nil(folder:read "box.part")
    end
    folder:remove()
  end)

  it("goes on from no other bake's file, nor from what is none, nor while another writes it", function()
    local folder, busy = scratch.new(), nil
    local path = folder.path .. "/box.part"
    assert.is_nil((resumed(path, "texels")))
    assert.error_matches(function() resumed(path, nil, { rays = 8 }) end, "of another bake, of rays 4; this is of rays 8")
    assert.error_matches(function()
      resumed(path, nil, { lights = ylm.sphere_light { at = { 0.1, 0.3, 0 }, radius = 0.05, radiance = 100 } })
    end, "of another bake, of lights")
    assert(box():lightmap { texels = 64, rays = 4, resume = folder.path .. "/b.part", progress = { function(_, _, stage)
      if stage == "lightmap" and not busy then
        busy = select(2, pcall(box().lightmap, box(), { texels = 64, rays = 4, resume = folder.path .. "/b.part" }))
      end
      return true
    end, every = 1e-6 } })
    assert.truthy(tostring(busy):find "b.part: another bake writes it")
    folder:write("box.part", "something else")
    local _, _, code = resumed(path)
    assert.same({ "EFORMAT", "something else" }, { code, folder:read "box.part" })
    folder:remove()
  end)

  it("stops where its progress function returns false", function()
    for _, stage in ipairs { "unwrap", "lightmap", "texels" } do
      local seen
      local light, _, code = box():lightmap { texels = 512, rays = 8, progress = { function(_, _, at)
        seen = seen or at == stage
        return not seen
      end, every = 1e-6 } }
      assert.same({ nil, "ECANCELLED", true }, { light, code, seen })
    end
  end)
end)

describe("lightmap:save", function()
  local all
  setup(function() all = box():lightmap { texels = 512, rays = 4 } end)

  it("writes glTF whose second coordinates read the picture beside it", function()
    local folder = scratch.new()
    local light = box():lightmap { texels = 1024, rays = 8, quantity = "indirect" }
    assert.is_true(light:save(folder.path .. "/room.glb"))
    local bytes = folder:read "room.glb"
    assert.truthy(bytes:find '"TEXCOORD_1"' and bytes:find '"file":"room.exr"' and bytes:find '"quantity":"indirect"')
    local again, message, code = ylm.load(folder.path .. "/room.glb")
    if code ~= "EMISSING" then -- jansson
      assert(again, message)
      assert.same({ 1, 12, 1 }, { #again.geometry, #again.geometry[1].mesh, #again.lights })
    end
    local picture = ylm.load(folder.path .. "/room.exr")
    assert.is_true(picture:layer("irradiance"):same(light:image():layer "irradiance", 0))
    assert(light:save(folder.path .. "/room.obj"))
    local mesh = ylm.mesh({ file = folder.path .. "/room.obj" }).mesh
    local piece = light:pieces()[1]
    assert.equal(#piece.mesh, #mesh)
    local here, there = mesh:triangles(), piece.mesh:triangles()
    for t = 1, #mesh do
      for k = 1, 3 do
        for a = 1, 2 do
          local off = mesh:uvs():get(here:get(t, k), a) - piece.uvs:get(there:get(t, k), a)
          assert.is_true(math.abs(off) < 1e-7, off)
        end
      end
    end
    folder:remove()
  end)

  it("writes .png of a range, which the file has beside or inside, and light that any viewer shows", function()
    local folder = scratch.new()
    local light = all
    local _, facts = assert(light:save(folder.path .. "/room.glb", { picture = "png" }))
    assert.same({ "room.glb", "room.png" }, facts.files)
    local picture = assert(images.read(folder.path .. "/room.png", true))
    local rgbm, E, size = picture:layer "radiance", light:image():layer "irradiance", picture.size
    assert.same(light:image().size, size)
    for row = 1, size[2] do
      for column = 1, size[1] do
        local most = math.max(E:get(row, column, 1), E:get(row, column, 2), E:get(row, column, 3))
        for c = 1, 3 do
          local x = rgbm:get(row, column, 4) * rgbm:get(row, column, c)
          assert.is_true(math.abs(facts.range * x * x - E:get(row, column, c)) <= most / 100 + 1e-5 * facts.range)
        end
      end
    end
    local function json_of(name) return folder:read(name):match "JSON(.*)BIN" end
    assert.truthy(json_of "room.glb":find('"range":' .. ("%.17g"):format(facts.range), 1, true))
    assert.falsy(json_of "room.glb":find '"images"')
    _, facts = assert(light:save(folder.path .. "/one.glb", { embed = true, lit = true, exposure = 1.5 }))
    assert.same({ { "one.glb" }, 1.5, 0 }, { facts.files, facts.exposure, facts.lamps })
    local text = json_of "one.glb"
    assert.truthy(text:find '"baseColorTexture":{"index":1,"texCoord":1}' and text:find '"KHR_materials_unlit":{}'
      and text:find '"extensionsUsed":%["KHR_materials_unlit"%]' and text:find '"texture":0' and text:find '"shown":1')
    assert.equal(2, select(2, folder:read "one.glb":gsub("\137PNG\r\n", "")))
    folder:remove()
  end)

  it("writes .ktx2 with the halves of the picture, which the file names", function()
    local folder = scratch.new()
    local _, facts = assert(all:save(folder.path .. "/room.glb", { picture = "ktx2" }))
    assert.same({ "room.glb", "room.ktx2" }, facts.files)
    assert.truthy(folder:read "room.glb":find('"file":"room.ktx2"', 1, true))
    local bytes, image = folder:read "room.ktx2", all:image()
    local function word(at) return ylm.array.frombytes(bytes:sub(at, at + 3), { 1 }, "int32"):get(1) end
    assert.same({ 97, image.size[1], image.size[2], 0 }, { word(13), word(21), word(25), word(29) })
    local halves = ylm.array.frombytes(bytes:sub(word(81) + 1), { image.size[2], image.size[1], 4 }, "float16")
    local texels = core.array_convert(halves, "float")
    assert.is_true(texels[{ {}, {}, { 1, 3 } }]:same(image:layer "irradiance", 0))
    assert.is_true(texels[{ {}, {}, 4 }]:min() == 1)
    folder:remove()
  end)

  it("leaves lamps out that the picture has already", function()
    local folder = scratch.new()
    assert(all:save(folder.path .. "/room.gltf"))
    local scene, message, code = ylm.load(folder.path .. "/room.gltf")
    folder:remove()
    if code == "EMISSING" then return pending(message) end
    assert(scene, message)
    assert.equal(0, #scene.lights)
  end)
end)

describe("a lightmap", function()
  it("is seen by ylm.view in the colours of its charts, or of what they miss", function()
    local parts = " " .. table.concat(ylm.info().parts, " ") .. " "
    if not parts:find " vtk " then return pending "libylm_vtk is not built" end
    local light, colours = box():lightmap { texels = 256, rays = 4 }, {}
    for _, shown in ipairs { "number", "error" } do
      local view = ylm.view { surfaces = light, charts = shown, size = { 160, 120 }, supersample = 1,
        camera = ylm.camera { from = { 0.3, 0.2, 0.9 }, at = { 0, 0, -1 }, fov = 90 } }
      local rgb, seen, count = view:pixels(), {}, 0
      for y = 1, 120, 4 do
        for x = 1, 120, 4 do
          local key = ("%.2f %.2f %.2f"):format(rgb:get(y, x, 1), rgb:get(y, x, 2), rgb:get(y, x, 3))
          if not seen[key] then seen[key], count = true, count + 1 end
        end
      end
      colours[shown] = count
      assert.equal(shown == "error" and 1 or 0, #view:bars())
    end
    assert.is_true(colours.number >= 4 and colours.error >= 3, colours.number .. " " .. colours.error)
  end)

  it("says what it is, and that it is closed", function()
    local light = box():lightmap { texels = 256, rays = 4 }
    assert.equal("ylm.lightmap", core.type(light))
    assert.truthy(tostring(light):find 'of "a box": all light, 6 charts')
    light:close()
    assert.equal("ylm.lightmap (closed)", tostring(light))
  end)
end)
