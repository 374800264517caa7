-- Elements and links: how surfaces are cut, which sides count, where rays lead, and the files that keep it.

local bytes = require "spec.support.grid_bytes"
local core = require "ylm.c.core"
local elements = require "spec.support.elements"
local scratch = require "spec.support.scratch"
local with = require "spec.support.with"
local ylm = require "ylm"

local function scene(geometry, lights, camera)
  return ylm.scene "links" { geometry = geometry, lights = lights, camera = camera }
end

local floor = { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } }
local function lamp(at) return ylm.sphere_light { at = at, radius = 0.05, radiance = 10 } end

--- The part of links that lead to elements.
local function stays(t) return 1 - t.stats.escaped / t.stats.rays end

describe("scene:links", function()
  it("cuts triangles into k^2 equal elements, of edges of at most the spacing", function()
    local t = scene(ylm.quad(floor)):links { spacing = 0.25, rays = 4, sides = "front" }
    local e = t:elements()
    assert.equal(2 * 6 * 6, t.stats.elements) -- the diagonal, 1.41, in 6
    local x = { 0, 0, 0 }
    for i = 1, #e.area do
      assert.is_true(math.abs(e.area:get(i) - 1 / 72) < 1e-7)
      for a = 1, 3 do x[a] = x[a] + e.centre:get(i, a) / 72 end
    end
    assert.is_true(math.abs(x[1] - 0.5) < 1e-6 and math.abs(x[2]) < 1e-6 and math.abs(x[3] + 0.5) < 1e-6)
    assert.equal(144, scene(ylm.quad(floor)):links({ spacing = 0.25, rays = 4 }).stats.elements) -- both sides
  end)

  it("cuts to a hundredth of the diagonal, or as finely as max_elements lets it", function()
    local box = scene(ylm.box { scale = 2 })
    assert.is_true(math.abs(box:links({ rays = 4 }).stats.spacing - 2 * math.sqrt(3) / 100) < 1e-6)
    local few = box:links { rays = 4, max_elements = 1000 }
    assert.is_true(few.stats.elements <= 1000 and few.stats.elements > 600, few.stats.elements)
  end)

  it("cuts long triangles into strips: few elements, whose areas are the triangle's", function()
    local shapes = { needle = { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 0.02, 0 } },
      wedge = { { 0, 0, 0 }, { 4, 0, 0 }, { 0.05, 0.4, 0 } }, cap = { { 0, 0, 0 }, { 4, 0, 0 }, { 1.5, 0.3, 0 } } }
    local most = { needle = 20 * 2, wedge = 2 * 68, cap = 2 * 68 }
    for name, corners in pairs(shapes) do
      for turn = 0, 2 do -- each corner may be the first
        local mesh = ylm.mesh { vertices = corners, triangles = { { 1 + turn, 1 + (turn + 1) % 3, 1 + (turn + 2) % 3 } } }
        local t = scene(mesh):links { spacing = 0.25, rays = 4, sides = "front" }
        local e = t:elements()
        assert.is_true(t.stats.elements <= most[name], name .. ": " .. t.stats.elements .. " of 256")
        local area = 4 * corners[3][2] / 2
        assert.near(area, e.area:sum(), 1e-5 * area)
        for a = 1, 2 do -- their middles are about the triangle's
          local x = (e.centre[{ {}, a }] * e.area):sum() / area
          assert.near((corners[1][a] + corners[2][a] + corners[3][a]) / 3, x, 1e-5)
        end
        assert.is_true(e.area:max() <= 0.25 ^ 2 / 2)
      end
    end
  end)

  it("finds the element of a place in strips: links between two beams that face each other lead to what is near", function()
    local function beam(y, order)
      return ylm.mesh { vertices = { { 0, y, 0 }, { 6, y, 0 }, { 6, y, -0.1 }, { 0, y, -0.1 } }, triangles = order }
    end
    local t = scene({ beam(0, { { 1, 2, 3 }, { 1, 3, 4 } }), beam(0.02, { { 1, 3, 2 }, { 4, 3, 1 } }) })
      :links { spacing = 0.2, rays = 16, sides = "front" }
    local at, hits, sum, n = t:elements().centre, t:hits():totable(), 0, 0
    assert.is_true(t.stats.elements <= 2 * 2 * 70, t.stats.elements)
    for i, row in ipairs(hits) do
      for _, k in ipairs(row) do
        if k > 0 and k <= t.stats.elements then
          local x = math.abs(at:get(i, 1) - at:get(k, 1))
          sum, n = sum + x, n + 1
          assert.is_true(x < 0.7, ("from %.2f to %.2f"):format(at:get(i, 1), at:get(k, 1)))
        end
      end
    end
    assert.is_true(n > 1000 and sum / n < 0.1, ("%d, %.3f"):format(n, sum / math.max(n, 1)))
  end)

  it("counts elements of the albedo that their mesh has, tinted", function()
    local image = ylm.image { size = { 2, 1 }, layers = { { "radiance", 3 } } }
    image:layer "radiance":set(1, 1, 1, 1)
    local t = scene(ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 },
      material = ylm.matte { albedo = { 0.25, 0.5, 1 } } }):links { spacing = 2, rays = 4, sides = "front" }
    assert.same({ 0.25, 0.5, 1 }, t:elements().albedo:totable()[1])
  end)

  it("leaves out triangles without area, and meshes that do not occlude", function()
    local flat = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 2, 0, 0 } },
      triangles = { { 1, 2, 3 }, { 1, 2, 4 }, { 1, 1, 2 } } }
    local t = scene({ flat, ylm.quad(with(floor, { occludes = false })) }):links { spacing = 2, rays = 4 }
    assert.equal(2, t.stats.degenerate)
    assert.equal(2, t.stats.elements)
    assert.equal(0, scene {}:links({ rays = 4 }).stats.elements)
  end)
end)

describe("sides of surfaces", function()
  local shapes = { box = ylm.box {}, sphere = ylm.sphere {}, torus = ylm.torus {}, knot = ylm.knot {} }

  it("are the outer ones of closed meshes, whose texture coordinates have seams", function()
    for name, shape in pairs(shapes) do
      local t = scene(shape):links { spacing = 9, rays = 4 }
      assert.same({ 1, 0 }, { t.stats.closed, t.stats.rooms }, name)
      assert.equal(#shape.mesh - t.stats.degenerate, t.stats.elements, name)
    end
  end)

  it("are the inner ones where a lamp, a camera or a place is inside, both where others are outside", function()
    local eye = ylm.camera { from = { 0.1, 0.2, 0.3 }, at = { 1, 1, 1 } }
    local outside = ylm.camera { from = { 3, 3, 3 } }
    local function look(...)
      local s = scene(...):links({ spacing = 9, rays = 4 }).stats
      return { s.rooms, s.elements }
    end
    assert.same({ 1, 12 }, look(ylm.box {}, lamp { 0, 0, 0 }))
    assert.same({ 1, 12 }, look(ylm.box {}, nil, eye))
    assert.same({ 0, 12 }, look(ylm.box {}, lamp { 0, 2, 0 }, outside))
    assert.same({ 1, 24 }, look(ylm.box {}, lamp { 0, 0, 0 }, outside))
    assert.equal(1, scene(ylm.box {}):links({ spacing = 9, rays = 4, inside = { { 0, 0, 0 } } }).stats.rooms)
    -- A body in a room: the room's inner side, the body's outer one.
    assert.same({ 1, 24 }, look({ ylm.box { scale = 3 }, ylm.box {} }, lamp { 1, 1, 1 }))
    -- A disk in the ceiling of a room.
    local disk = ylm.disk_light { at = { 0, 0.5, 0 }, normal = { 0, 1, 0 }, radius = 0.1, radiance = 1 }
    assert.equal(1, look(ylm.box {}, disk)[1])
  end)

  it("are chosen for all meshes, or each", function()
    local function count(o, quad) return scene(ylm.quad(with(floor, quad))):links(with({ spacing = 9, rays = 4 },
      o)).stats.elements end
    assert.equal(4, count {})
    assert.equal(2, count { sides = "back" })
    assert.equal(2, count({}, { sides = "front" }))
    assert.equal(4, count({ sides = "front" }, { sides = "both" }))
  end)

  it("turn: of a mesh whose triangles run clockwise the back is outside", function()
    local turned = ylm.mesh { vertices = ylm.box({}).mesh:vertices(), triangles = (function()
      local list = ylm.box({}).mesh:triangles():totable()
      for i, t in ipairs(list) do list[i] = { t[1], t[3], t[2] } end
      return list
    end)() }
    local e = scene(turned):links({ spacing = 9, rays = 4 }):elements()
    for i = 1, #e.area do
      local out = 0
      for a = 1, 3 do out = out + e.centre:get(i, a) * e.normal:get(i, a) end
      assert.is_true(out > 0.1)
    end
  end)
end)

describe("links", function()
  local function squares(other)
    return scene { ylm.quad(with(floor, { sides = "front" })), ylm.quad(with(other, { sides = "front" })) }
  end

  it("of two unit squares: a fifth stays, facing at distance 1 or at right angles", function()
    local facing = squares { corner = { 0, 1, -1 }, u = { 1, 0, 0 }, v = { 0, 0, 1 } }:links { spacing = 0.1, rays = 64,
      lmax = 0 }
    local edge = squares { corner = { 0, 0, -1 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }:links { spacing = 0.1, rays = 64,
      lmax = 0 }
    for _, case in ipairs { { facing, 0.19982 }, { edge, 0.20004 } } do
      local sigma = math.sqrt(0.2 * 0.8 / case[1].stats.rays)
      assert.is_true(math.abs(stays(case[1]) - case[2]) < 4 * sigma, stays(case[1]))
    end
  end)

  it("are as dense as the cosine: r^2 / (1 + r^2) of them within r at distance 1", function()
    local t = scene {
      ylm.quad { corner = { -0.01, 0, 0.01 }, u = { 0.02, 0, 0 }, v = { 0, 0, -0.02 }, sides = "front" },
      ylm.quad { corner = { -3, 1, -3 }, u = { 6, 0, 0 }, v = { 0, 0, 6 }, sides = "front" },
    }:links { spacing = 0.25, rays = 512, lmax = 0 }
    local e, links = t:elements(), t:hits():totable()[1]
    for _, r in ipairs { 0.5, 1, 2 } do
      local within = 0
      for _, k in ipairs(links) do
        if e.centre[k] and e.centre:get(k, 1) ^ 2 + e.centre:get(k, 3) ^ 2 < r * r then within = within + 1 end
      end
      assert.is_true(math.abs(within / 512 - r * r / (1 + r * r)) < 0.03, r .. ": " .. within / 512)
    end
  end)

  it("of a closed room all stay, though rays begin in its corners", function()
    local t = elements.room(0.5):links { spacing = 0.3, rays = 64, sides = "front" }
    assert.same({ 0, 0 }, { t.stats.escaped, t.stats.dead })
  end)

  it("are in the order of their numbers, and another seed finds others", function()
    local room = elements.room(0.5)
    local function links(seed) return room:links({ spacing = 0.7, rays = 16, seed = seed }):hits():totable() end
    local one, differ = links(1), 0
    for i, row in ipairs(links(2)) do
      for k = 1, 16 do
        if k > 1 then assert.is_true(row[k] >= row[k - 1]) end
        if row[k] ~= one[i][k] then differ = differ + 1 end
      end
    end
    assert.is_true(differ > 4 * #one, differ)
  end)

  it("that begin inside of a body give their slots to others: a floor without the foot of a table", function()
    local table_box = ylm.box { bounds = { { -0.4, 0, -0.3 }, { 0.5, 0.7, 0.2 } } }
    local t = elements.room(0.5, table_box):links { spacing = 0.15, rays = 64, sides = "auto" }
    local area = elements.integral(t:elements(), nil, nil, 1)
    assert.is_true(t.stats.dead > 20 and t.stats.buried > 0)
    assert.is_true(math.abs(area - (4 + 4 - 0.9 * 0.5)) < 0.02, area) -- its upper side less the foot, its lower side
  end)

  it("do not depend on the number of threads", function()
    local room = elements.room(0.5, ylm.box { at = { 0, 1, 0 }, scale = 0.3 })
    local function found(threads)
      local t = room:links { spacing = 0.5, rays = 16, threads = threads }
      return t:hits():totable()
    end
    local one = found(1)
    assert.same(one, found(2))
    assert.same(one, found(7))
  end)

  it("are cancelled", function()
    for _, last in ipairs { "elements", "links" } do
      local stages = {}
      local t, message, code = elements.room(0.5):links { spacing = 0.1, progress = { function(_, _, stage)
        stages[stage] = true
        return stage ~= last
      end, every = 1e-6 } }
      assert.same({ nil, "cancelled", "ECANCELLED" }, { t, message, code })
      assert.same({ elements = true, links = last == "links" or nil }, stages)
    end
  end)
end)

describe("a .links file", function()
  local folder = scratch.new()
  local path = folder.path .. "/room.links"
  local room = elements.room({ 0.5, 0.6, 0.7 }, ylm.box { scale = 0.5, at = { 0, 0.26, 0 } })
  local t = room:links { spacing = 0.5, rays = 16, lmax = 2 }
  assert(t:save(path))
  local whole = folder:read "room.links"
  teardown(function() folder:remove() end)

  local function read(s, text)
    folder:write("other.links", text)
    return s:links { file = folder.path .. "/other.links" }
  end

  it("holds all: links, elements and light are those that were saved", function()
    local again = read(room, whole)
    assert.same(t:hits():totable(), again:hits():totable())
    for _, name in ipairs { "centre", "normal", "albedo", "area", "mesh" } do
      assert.same(t:elements()[name]:totable(), again:elements()[name]:totable(), name)
    end
    for name, value in pairs(t.stats) do
      if name ~= "seconds" then assert.equal(value, again.stats[name], name) end
    end
    assert.same(t:radiosity():leaving():totable(), again:radiosity():leaving():totable())
    local light = ylm.environment_light { radiance = 1 }
    local direct = { direct = "field", bounces = 0 }
    assert.same(t:radiosity(light, direct):irradiance():totable(), again:radiosity(light, direct):irradiance():totable())
    assert(again:save(folder.path .. "/again.links"))
    assert.equal(whole, folder:read "again.links")
  end)

  it("knows another albedo, which is not in it", function()
    local white = elements.room(0.9, ylm.box { scale = 0.5, at = { 0, 0.26, 0 } })
    assert.is_true(math.abs(read(white, whole):elements().albedo:get(1, 1) - 0.9) < 1e-6)
  end)

  --- The number of `width` bytes at `at`, from 1, little-endian.
  local function number(at, width)
    local x = 0
    for i = width, 1, -1 do x = 256 * x + whole:byte(at + i - 1) end
    return x
  end

  it("is read in either byte order", function()
    if number(9, 4) ~= 0x01020304 then return pending "this machine is big-endian" end
    local out, at = { whole:sub(1, 8) }, 9
    local function turn(width, n)
      for _ = 1, n do
        out[#out + 1] = whole:sub(at, at + width - 1):reverse()
        at = at + width
      end
    end
    local meshes, links, row = number(33, 4), number(29, 4), number(25, 4)
    local triangles, count = number(41, 8), number(49, 8)
    for _, s in ipairs { { 4, 2 }, { 8, 1 }, { 4, 4 }, { 8, 5 }, { 8, 1 }, { 8, 8 }, { 1, meshes }, { 2, 4 * triangles },
      { 4, count },
      { 4, count * links }, { 4, count * row * row } } do
      turn(s[1], s[2])
      if at > 153 then while (at - 1) % 8 ~= 0 do turn(1, 1) end end
    end
    assert.equal(#whole - 8, at - 1)
    local swapped = table.concat(out)
    local again = assert(read(room, swapped .. bytes.crc(swapped):reverse()))
    assert.same(t:radiosity():leaving():totable(), again:radiosity():leaving():totable())
  end)

  --- The bytes with `text` at `at`, from 0, and a checksum that fits.
  local function forged(at, text)
    local body = whole:sub(1, at) .. text .. whole:sub(at + #text + 1, -9)
    return body .. core.team_crc(body):gsub("..", function(hex) return string.char(tonumber(hex, 16)) end):reverse()
  end

  it("is refused where its checksum fits, and its numbers cannot be", function()
    if number(9, 4) ~= 0x01020304 then return pending "this machine is big-endian" end
    local meshes, triangles, count, links, row = number(33, 4), number(41, 8), number(49, 8), 16, 3
    local at, sizes = { 152 }, { meshes, 8 * triangles, 4 * count, 4 * count * links, 4 * count * row * row }
    for i, size in ipairs(sizes) do at[i + 1] = at[i] + math.ceil(size / 8) * 8 end
    local huge, ten, nan = "\76\110\79\110", "\0\0\32\65", "\0\0\192\127"
    for what, case in pairs {
      ["a side"] = { at[1], "\4" }, ["the cut of a triangle"] = { at[2], "\1\0" }, ["an element"] = { at[3], nan },
      ["an element "] = { at[3], "\0\0\0\1" }, ["a count "] = { at[3], "\0\0\0\63" }, -- 2e-38; 0.5: no ray was buried
      ["a link"] = { at[4], "\255\255\255\0" },
      ["a transfer vector"] = { at[5], huge }, ["a transfer vector "] = { at[5] + 4, huge },
      ["a transfer vector  "] = { at[5] + 8, ten }, ["a transfer vector   "] = { at[5], "\0\0\0\63" }, -- 0.5: no link is open
      ["a count"] = { 96 + 3 * 8, "\1" }, -- dead elements
    } do
      local x, message, code = read(room, (forged(case[1], case[2])))
      assert.is_nil(x, what)
      local said = "other.links: " .. what:gsub(" *$", "") .. " of the links cannot be"
      assert(code == "EFORMAT" and message:find(said, 1, true), what .. ": " .. tostring(message))
    end
    assert.truthy(read(room, (forged(0, ""))))
  end)

  it("is refused where it is damaged, cut short, newer, no links, or of another scene", function()
    local function refused(damaged, code, text, s)
      local x, message, got = read(s or room, damaged)
      assert.is_nil(x)
      assert(got == code and message:find(text), tostring(message) .. " " .. tostring(got))
    end
    local random = 12345
    for _ = 1, 60 do
      random = (random * 1103515245 + 12345) % 2 ^ 31
      local at = 1 + math.floor(random / 2 ^ 31 * #whole)
      local x, message = read(room, whole:sub(1, at - 1) .. string.char((whole:byte(at) + 1) % 256) .. whole:sub(at + 1))
      assert.is_nil(x)
      assert(message:find "other.links: ", message)
    end
    refused(whole:sub(1, -2), "EFORMAT", "cut short")
    refused(whole:sub(1, 20), "EFORMAT", "no links")
    refused("", "EFORMAT", "no links")
    refused(whole:sub(1, 12) .. "\3\0\0\0" .. whole:sub(17), "EVERSION", "of version 3, this ylm reads up to 2")
    local other = elements.room(0.5)
    assert.has_error(function() read(other, whole) end)
    local ok, message = pcall(read, other, whole)
    assert(not ok and message:find "the links are of another scene", message)
  end)
end)
