-- scene:surface_grid: irradiance on surfaces between corners of rectangles.

local ylm = require "ylm"
local core = require "ylm.c.core"
local json = require "spec.support.json"
local long = require "spec.support.long"
local parted = require "spec.support.parted_rooms"
local picture = require "ylm.picture"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

--- A box of half edge 1 from within, a lamp, and a wall that parts it but for a gap.
local function room(more)
  local geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.3 } } }
  for _, g in ipairs(more or {}) do geometry[#geometry + 1] = g end
  return ylm.scene "a room" { geometry = geometry,
    camera = ylm.camera { from = { 0.8, 0.6, 0.9 }, at = { -0.3, -0.4, -0.3 }, fov = 80 },
    lights = ylm.sphere_light { at = { 0.5, 0.4, 0 }, radius = 0.15, radiance = 20 } }
end

local function wall(lo, hi)
  return ylm.box { bounds = { lo or { -0.04, -0.99, -0.99 }, hi or { 0.04, 0.3, 0.6 } }, material = ylm.matte { albedo = 0.3 } }
end

--- Places on the floor of a room, and the normals there.
local function floor_places(n)
  local points, normals = {}, {}
  for i = 0, n - 1 do
    for k = 0, n - 1 do
      points[#points + 1], normals[#normals + 1] = { -0.95 + 1.9 * i / (n - 1), -1, -0.95 + 1.9 * k / (n - 1) }, { 0, 1, 0 }
    end
  end
  return points, normals
end

--- Places on the floor, even by area; none beneath the wall, which covers them: no promise is about such places.
local function open_places(n)
  local points, normals = {}, {}
  for i = 0, n - 1 do
    local p = { 2 * ((0.5 + 0.7548776662466927 * i) % 1) - 1, -1, 2 * ((0.5 + 0.5698402909980532 * i) % 1) - 1 }
    if not (math.abs(p[1]) < 0.04 and p[3] < 0.6) then points[#points + 1], normals[#normals + 1] = p, { 0, 1, 0 } end
  end
  return points, normals
end

--- The results of f(), and the warnings that it says.
local function listen(f)
  local said = {}
  local before = ylm.on_warning(function(line) said[#said + 1] = line end)
  local results = { f() }
  ylm.on_warning(before)
  return results[1], said, results[2], results[3]
end

describe("a surface grid", function()
  local scene = room { wall() }
  local links = scene:links { rays = 32, spacing = 0.2 }
  local light = listen(function() return assert(scene:surface_grid { tolerance = 0.1, links = links, judge = "field" }) end)

  it("keeps its tolerance of the light of elements at places of its own", function()
    assert.is_true(light.stats.met, light.stats.error)
    assert.equal("indirect", light.quantity)
    assert.equal(0.1, light.tolerance)
    assert.is_true(light.stats.verified >= 2000)
    assert.is_true(light.stats.corners < 2000, light.stats.corners)
    local lit = links:radiosity(nil, { seed = 7 })
    local points, normals = open_places(long(250, 500))
    local E = light:irradiance(points, normals)
    local lifted = {}
    for i, p in ipairs(points) do lifted[i] = { p[1], p[2] + 1e-4, p[3] } end
    local L = ylm.light_field(8, lit:field { rays = 12288 }, lifted)
    local Y, cosine, mean, wrong = ylm.sh.eval(8, normals), { [0] = 1, 2 / 3, 1 / 4, 0, -1 / 24, 0, 1 / 64, 0, -1 / 128 }, 0, 0
    local exact = {}
    for i = 1, #points do
      exact[i] = 0
      for l = 0, 8 do
        for k = l * l + 1, (l + 1) ^ 2 do exact[i] = exact[i] + math.pi * cosine[l] * Y:get(i, k) * L:get(i, 1, k) end
      end
      mean = mean + exact[i] / #points
    end
    for i = 1, #points do
      if math.abs(E:get(i, 1) - exact[i]) > 0.1 * math.max(mean, exact[i]) then wrong = wrong + 1 end
    end
    -- of all surfaces 1 % may fail; of the floor, which the wall darkens, a little more
    assert.is_true(wrong <= 0.015 * #points, ("%d of %d places are wrong"):format(wrong, #points))
  end)

  it("does not depend on threads", function()
    local one, two = os.tmpname(), os.tmpname()
    for threads, name in pairs { one, two } do
      local g = listen(function()
        return scene:surface_grid { tolerance = 0.06, corners = long(150, 300), links = links, judge = "field", threads = threads,
          rays = 4 } -- so noisy that all places are asked again
      end)
      assert.is_true(g:save(name))
    end
    local function body(name)
      local file = assert(io.open(name, "rb"))
      local bytes = file:read "*a"
      file:close()
      os.remove(name)
      return bytes:sub(144 + 1, -9) -- the header holds seconds, the end its checksum
    end
    local a = body(one)
    assert.is_true(#a > 1000)
    assert.equal(a, body(two))
  end)

  it("is not negative, and continuous on a surface", function()
    local points, normals = {}, {}
    for i = 0, 2000 do
      local t = i / 2000
      points[#points + 1], normals[#normals + 1] = { 0.1 + 0.85 * t, -1, -0.9 + 1.7 * t }, { 0, 1, 0 }
    end
    local E, mean = light:irradiance(points, normals), 0
    for i = 1, #points do mean = mean + E:get(i, 1) / #points end
    for i = 2, #points do
      assert.is_true(E:get(i, 1) >= 0)
      assert.is_true(math.abs(E:get(i, 1) - E:get(i - 1, 1)) < 0.03 * mean)
    end
  end)

  it("brings no light into a sealed room, wherever its wall stands", function()
    for turn = 2, 20, long(20, 6) do
      local at, slope, thick = -0.3 + 0.037 * turn, 0.6 * math.sin(1.7 * turn) * (turn % 4 > 0 and 1 or 0),
        ({ 0.05, 0.01, 0.001 })[turn % 3 + 1]
      local s = parted(ylm, at, thick, 0.5 * slope)
      local g = listen(function()
        return assert(s:surface_grid { tolerance = 0.3, judge = "field", links = s:links { rays = 64, spacing = 0.2 } })
      end)
      local points, normals, bright, bright_normals = {}, {}, {}, {}
      for i = 0, 30 do
        for k = 0, 30 do
          local z = -0.98 + 1.96 * k / 30
          local wall_at = at + 0.5 * slope * z
          points[#points + 1], normals[#normals + 1] = { -1 + (wall_at + 1) * (0.005 + 0.99 * i / 30), -1, z }, { 0, 1, 0 }
          local x = wall_at + thick + (1 - wall_at - thick) * (0.02 + 0.96 * i / 30)
          bright[#bright + 1], bright_normals[#bright_normals + 1] = { x, -1, z }, { 0, 1, 0 }
        end
      end
      local dark, lit, most, mean = g:irradiance(points, normals), g:irradiance(bright, bright_normals), 0, 0
      for i = 1, #points do most, mean = math.max(most, dark:get(i, 1)), mean + lit:get(i, 1) / #points end
      assert.is_true(mean > 0)
      assert.is_true(most < 1e-4 * mean, ("turn %d: %g of the mean"):format(turn, most / mean))
    end
  end)

  it("has both sides of one quad apart", function()
    local part = ylm.quad { corner = { 0.0312, -1, -1 }, u = { 0, 0, 2 }, v = { 0, 1.3, 0 },
      material = ylm.matte { albedo = 0.5 } }
    local s = room { part }
    local g = listen(function()
      return assert(s:surface_grid { tolerance = 0.4, judge = "field", links = s:links { rays = 64, spacing = 0.2 } })
    end)
    local E = g:irradiance({ { 0.0312, -0.6, 0 }, { 0.0312, -0.6, 0 } }, { { 1, 0, 0 }, { -1, 0, 0 } })
    assert.is_true(E:get(1, 1) > 0 and E:get(2, 1) > 0)
    assert.is_true(math.abs(E:get(1, 1) / E:get(2, 1) - 1) > 0.1, E:get(1, 1) .. " " .. E:get(2, 1))
  end)

  it("is saved, and read beside its scene", function()
    local name = os.tmpname()
    assert.is_true(light:save(name))
    local again = assert(scene:surface_grid { file = name })
    for _, key in ipairs { "corners", "rectangles", "rows", "charts", "error", "verified", "failed", "rays", "rounds" } do
      assert.equal(light.stats[key], again.stats[key], key)
    end
    assert.equal("indirect", again.quantity)
    assert.equal(0.1, again.tolerance)
    local points, normals = floor_places(9)
    assert.same(light:irradiance(points, normals):totable(), again:irradiance(points, normals):totable())
    local ok, message = pcall(function() return room({}):surface_grid { file = name } end)
    assert.is_false(ok)
    assert.truthy(message:find "another scene")
    os.remove(name)
  end)

  it("refuses files that are cut or changed", function()
    local name = os.tmpname()
    light:save(name)
    local file = assert(io.open(name, "rb"))
    local bytes = file:read "*a"
    file:close()
    local function try(text)
      local out = assert(io.open(name, "wb"))
      out:write(text)
      out:close()
      local g, message, code = scene:surface_grid { file = name }
      assert.is_nil(g)
      assert.is_string(message)
      return code
    end
    for at = 0, 160 do assert.equal("EFORMAT", try(bytes:sub(1, at))) end
    assert.equal("EFORMAT", try(bytes:sub(1, -2)))
    assert.equal("EFORMAT", try(bytes .. "x"))
    for at = 200, #bytes, 977 do
      assert.equal("ECHECKSUM", try(bytes:sub(1, at - 1) .. string.char((bytes:byte(at) + 1) % 256) .. bytes:sub(at + 1)))
    end
    os.remove(name)
  end)

  it("lights pictures as links do", function()
    local view = scene:prepare { size = { 48, 32 }, samples = 4 }
    local ours = assert(view:render { by = "none", bounced = light })
    local theirs = assert(view:render { by = "none", bounced = links:radiosity(), rays = 1024 })
    local a, b, apart, mean = ours:layer "radiance", theirs:layer "radiance", 0, 0
    for y = 1, 32 do
      for x = 1, 48 do
        apart, mean = apart + math.abs(a:get(y, x, 1) - b:get(y, x, 1)), mean + b:get(y, x, 1)
      end
    end
    assert.is_true(apart < 0.03 * mean, apart / mean)
    local image, report = scene:render { size = { 24, 16 }, samples = 2, bounced = light }
    assert.is_not_nil(image)
    assert.equal("surfaces", report.bounced)
    assert.equal("those of the grid", report.bounces)
    assert.equal(0, #report.warnings)
  end)

  it("has no noise in pictures whose other noise is filtered", function()
    local size = { 64, 48 }
    local image, report = scene:render { size = size, samples = 4, bounced = light, light_samples = 4, denoise = "auto" }
    assert.same({ "surfaces", "samples" }, { report.bounced, report.ended })
    assert.is_true(report.noise < report.noise_before)
    local d = report.denoise
    assert.is_true(d.z2 < 4, d.z2)
    assert.is_true(math.abs(d.bias) < 4 * d.uncertainty + 0.003, d.bias)
    local bounced = scene:prepare({ size = size, samples = 4 }):render { by = "none", bounced = light }
    local direct = image:layer "raw" - bounced:layer "radiance"
    assert.is_true(direct:min() > -1e-5, direct:min()) -- whole in the layer raw
    local ok, why = pcall(function() return scene:render { size = size, bounced = "virtual", denoise = "auto" } end)
    assert.is_false(ok)
    assert.truthy(why:find("along links or from a grid", 1, true), why)
  end)

  it("is not dimmer where its places have more noise", function()
    local points, normals = floor_places(9)
    local function mean(rays)
      local g = listen(function()
        return scene:surface_grid { tolerance = 0.5, rays = rays, links = links, judge = "field", corners = 200 }
      end)
      return g:irradiance(points, normals):mean()
    end
    local few, many = mean(4), mean(long(96, 256))
    assert.is_true(math.abs(few / many - 1) < 0.01, few / many - 1)
  end)

  it("is what scene:bake makes where there are no probes", function()
    local baked = listen(function() return scene:bake { links = links, judge = "field" } end)
    assert.equal("ylm.surface_grid", core.type(baked))
    local points, normals = floor_places(5)
    assert.same(baked:irradiance(points, normals):totable(), light:irradiance(points, normals):totable())
    for name, value in pairs { occupied = "everywhere", sums_tolerance = 0.1, quantity = "lights", size = { 8, 8 } } do
      local ok, why = pcall(function() return scene:bake { [name] = value } end)
      assert.is_false(ok)
      assert.truthy(why:find(name, 1, true) and why:find("is of probes", 1, true), why)
    end
  end)

  it("says where a picture's scene is another", function()
    local moved = ylm.scene "moved" { like = scene,
      lights = ylm.sphere_light { at = { -0.5, 0.4, 0 }, radius = 0.15, radiance = 20 } }
    local _, said, report = listen(function() return moved:render { size = { 24, 16 }, samples = 2, bounced = light } end)
    assert.truthy(report.warnings[1]:find "lights than scene")
    assert.equal(said[1], report.warnings[1])
    local ok, message = pcall(function() return room({}):render { size = { 24, 16 }, bounced = light } end)
    assert.is_false(ok)
    assert.truthy(message:find "other geometry")
  end)

  it("takes a budget, and says that it is spent", function()
    local g, said = listen(function()
      return assert(scene:surface_grid { tolerance = 0.03, corners = 200, links = links, judge = "field" })
    end)
    assert.is_true(g.stats.spent)
    assert.is_false(g.stats.met)
    assert.is_true(g.stats.corners <= 220, g.stats.corners)
    assert.truthy(said[1]:find "corners are spent")
    assert.equal(said[1], g.stats.warning)
  end)

  it("is judged by paths", function()
    local g = listen(function() return assert(scene:surface_grid { tolerance = 0.3, links = links }) end)
    local paths = g.stats.paths
    assert.is_true(paths.field_met)
    assert.is_true(g.stats.error >= paths.field_error)
    assert.equal(g.stats.error <= 0.3, g.stats.met)
    assert.is_true(paths.least <= g.stats.error)
  end)

  it("asks no more paths where these cannot show its tolerance", function()
    if long(true, false) then return end -- 10^6 paths
    local g, said = listen(function() return assert(scene:surface_grid { tolerance = 0.004, corners = 300, links = links }) end)
    local paths = g.stats.paths
    assert.is_false(g.stats.met)
    assert.is_true(paths.undecided > 0.5 * g.stats.verified, paths.undecided)
    local rounds = paths.paths / (256 * g.stats.verified)
    assert.is_true(rounds > 1.8 and rounds <= 2, rounds) -- but for places that are black
    assert.truthy(said[1]:find "paths are too noisy to say more", said[1])
  end)

  it("takes other light on the rectangles that it has", function()
    local function lamp(x, radiance) return ylm.sphere_light { at = { x, 0.4, 0 }, radius = 0.15, radiance = radiance } end
    --- The first and last corners of all rectangles, in an order of their own.
    local function rectangles_of(g)
      local corners, list = g:rectangles(), {}
      for i = 1, #corners do
        local words = {}
        for a = 1, 3 do words[a], words[a + 3] = corners:get(i, 1, a), corners:get(i, 4, a) end
        list[i] = table.concat(words, " ")
      end
      table.sort(list)
      return list
    end
    local g = listen(function() return assert(scene:surface_grid { tolerance = 0.3, links = links, judge = "field" }) end)
    local corners, points, normals = rectangles_of(g), floor_places(5)
    local function change(lights)
      local before = g:irradiance(points, normals)
      local report = listen(function() return assert(g:update(lights)) end)
      assert.equal(report, g.stats)
      assert.same(corners, rectangles_of(g))
      local after, most, least, off, mean = g:irradiance(points, normals), 0, math.huge, 0, 0
      for i = 1, #points do mean = mean + before:get(i, 1) / #points end
      for i = 1, #points do
        off = math.max(off, math.abs(after:get(i, 1) - before:get(i, 1)) / math.max(before:get(i, 1), mean))
        local x = after:get(i, 1) / before:get(i, 1)
        most, least = math.max(most, x), math.min(least, x)
      end
      return least, most, off
    end
    local _, _, off = change()
    assert.is_true(off < 0.4, off) -- other places, the same tolerance
    assert.is_true(g.stats.met)
    local least, most = change(lamp(0.5, 40))
    assert.is_true(math.abs(least - 2) < 1e-3 and math.abs(most - 2) < 1e-3)
    least, most = change(lamp(-0.5, 40)) -- behind the wall
    assert.is_true(least < 0.6 and most > 1.5, least .. " " .. most)
    local name, kept = os.tmpname(), g:irradiance(points, normals)
    assert.is_true(g:save(name))
    local ok, message, code = g:update(lamp(0.5, 20), { progress = function() return false end })
    assert.same({ message = "cancelled", code = "ECANCELLED" }, { ok, message = message, code = code })
    assert.is_true(g:irradiance(points, normals):same(kept))
    if long(false, true) then -- makes links
      local loaded = scene:surface_grid { file = name }
      assert.is_number(listen(function() return assert(loaded:update(lamp(-0.5, 40))) end).error)
      assert.same(corners, rectangles_of(loaded))
    end
    os.remove(name)
  end)

  it("tells what its file holds", function()
    local name = os.tmpname()
    assert.is_true(light:save(name))
    local folder = scratch.new()
    local out, status = tool.runner(folder)("info " .. name .. " --json")
    local told = json.read(out)
    assert.equal(0, status)
    for _, key in ipairs { "corners", "rectangles", "charts", "rows", "error", "met", "verified", "rays" } do
      assert.equal(light.stats[key], told[key], key)
    end
    assert.same({ "light on surfaces", "indirect", 0.1 }, { told.kind, told.quantity, told.tolerance })
    local file = assert(io.open(name, "rb"))
    assert.equal(#file:read "*a", told.bytes)
    file:close()
    local nothing, why, code = ylm.load(name)
    assert.is_nil(nothing)
    assert.equal("EFORMAT", code)
    assert.truthy(why:find("scene:surface_grid { file = }", 1, true))
    local _, refused, names = tool.runner(folder)("view " .. name .. " -o out.png")
    assert.is_true(refused ~= 0)
    assert.truthy(names:find "name the scene's file too", names)
    local cut = assert(io.open(name, "wb"))
    cut:write "\137YLMsurf and no more than that"
    cut:close()
    local _, failed, err = tool.runner(folder)("info " .. name)
    assert.is_true(failed ~= 0)
    assert.truthy(err:find "light on surfaces" or err:find "cut short", err)
    os.remove(name)
    folder:remove()
  end)

  it("is what the command bakes where there are no probes, and other commands refuse it", function()
    local folder = scratch.new()
    local run = tool.runner(folder)
    folder:write("room.lua", [[
      return scene "a room" { geometry = box { scale = 2, material = matte { albedo = 0.5 } },
        camera = camera { from = { 0.8, 0.6, 0.9 }, at = { -0.3, -0.4, -0.3 }, fov = 80 },
        links = links { rays = 16, spacing = 0.5 },
        lights = sphere_light { at = { 0.5, 0.4, 0 }, radius = 0.15, radiance = 20 } }]])
    local path = scratch.quote(folder.path .. "/room.lua")
    local surfaces = scratch.quote(folder.path .. "/room.surfaces")
    local _, status, err = run("bake " .. path .. " --tolerance 0.5")
    assert.equal(0, status, err)
    assert.truthy(err:find("bakes into " .. folder.path .. "/room.surfaces", 1, true), err)
    local out = scratch.quote(folder.path .. "/room.png")
    _, status, err = run("render " .. path .. " --grid " .. surfaces .. " -s 32x24 -n 4 -o " .. out)
    assert.equal(0, status, err)
    assert.truthy(err:find "noise is", err) -- filtered where there is some
    local wanted = {
      ["bake " .. path .. " --small"] = "--small is of grids",
      ["page " .. path .. " --grid " .. surfaces .. " -o a.html"] = "light on surfaces, and not a grid",
      ["export " .. path .. " --grid " .. surfaces .. " -o a.npy"] = "light on surfaces, and not a grid",
      ["render " .. path .. " --grid " .. surfaces .. " --by grid -o a.png"] = "--by grid is of grids",
      ["render " .. path .. " --grid " .. surfaces .. " --bounces 1 -o a.png"] = "--bounces does not go with",
    }
    for words, says in pairs(wanted) do
      _, status, err = run(words)
      assert.is_true(status ~= 0, words)
      assert.truthy(err:find(says, 1, true), words .. ": " .. err)
    end
    _, status, err = tool.runner(folder, "OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0")("bake " .. path .. " -o " .. surfaces)
    assert.equal(2, status)
    assert.truthy(err:find("one process's work", 1, true), err)
    folder:remove()
  end)

  it("is seen in the colours of its rectangles", function()
    local made, why = pcall(ylm.view, { surfaces = 7 })
    assert.is_false(made)
    assert.truthy(why:find("or a lightmap (scene:lightmap), got 7", 1, true), why)
    if not picture.vtk() then return pending "VTK is not built in" end
    local pixels, colours, n = assert(ylm.view { surfaces = light, size = { 64, 48 }, supersample = 1 }:pixels()), {}, 0
    for y = 1, 48 do
      for x = 1, 64 do
        local key = {}
        for c = 1, 3 do key[c] = math.floor(16 * pixels:get(y, x, c)) end
        key = table.concat(key, " ")
        if not colours[key] then colours[key], n = true, n + 1 end
      end
    end
    assert.is_true(n > 20, n)
  end)

  it("lies on round bodies, and on many small planes", function()
    local bodies = room { ylm.sphere { at = { -0.4, -0.5, 0 }, radius = 0.35, divide = { 32, 16 } },
      ylm.torus { at = { 0.4, -0.7, 0.3 }, radius = 0.2, tube = 0.08, divide = { 24, 12 } } }
    local g = listen(function() return assert(bodies:surface_grid { tolerance = 0.2, judge = "field",
      links = bodies:links { rays = 64, spacing = 0.2 } }) end)
    assert.is_true(g.stats.met)
    local view = bodies:prepare { size = { 64, 48 }, samples = 1 }
    assert.is_not_nil(view:render { by = "none", bounced = g })
  end)

  it("has direct light too", function()
    local open = ylm.scene "a floor" {
      geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
      lights = ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 10 } }
    local g = listen(function()
      return assert(open:surface_grid { tolerance = 0.05, quantity = "direct", judge = "field", light_samples = 64 })
    end)
    local E = g:irradiance({ { 0, 0, 0 }, { 0.6, 0, 0.2 } }, { { 0, 1, 0 }, { 0, 1, 0 } })
    for i, d in ipairs { 1, 1.4 } do -- pi L r^2 cos / d^2 of a sphere above the plane
      local exact = math.pi * 10 * 0.01 * (1 / math.sqrt(d)) / d
      assert.is_true(math.abs(E:get(i, 1) / exact - 1) < 0.06, E:get(i, 1) / exact)
    end
    local ok, message = pcall(function()
      return ylm.scene "seen" { like = open, camera = ylm.camera { from = { 0, 1, 2 }, at = { 0, 0, 0 } } }:render { bounced = g,
        size = { 8, 8 } }
    end)
    assert.is_false(ok)
    assert.truthy(message:find "direct light already")
  end)

  it("refuses what it cannot do, and names it", function()
    local function refused(pattern, f, ...)
      local ok, message = pcall(f, ...)
      assert.is_false(ok)
      assert.truthy(message:find(pattern), message)
    end
    refused("no geometry", function()
      return ylm.scene "nothing" { lights = ylm.sphere_light { at = { 0, 0, 0 } } }:surface_grid()
    end)
    refused("tolerance", function() return scene:surface_grid { tolerance = -1 } end)
    refused("corners", function() return scene:surface_grid { corners = 1 } end)
    refused("normals expected", function() return light:irradiance({ { 0, -1, 0 } }, { { 0, 1, 0 }, { 0, 1, 0 } }) end)
    refused("leave one out", function() return scene:render { bounced = light, bounces = 2, size = { 8, 8 } } end)
    refused("point 2 lies on no surface", function()
      return light:irradiance({ { 0.5, -1, 0 }, { 0.3, 0.3, 0.3 } }, { { 0, 1, 0 }, { 0, 1, 0 } })
    end)
    refused("engines read grids", function() return light:export("x.npy", { scene = scene }) end)
    refused("points in space take grids", function() return light:sample({ { 0, 0, 0 } }) end)
    refused("html is of grids", function() return light:save "x.html" end)
    local name = os.tmpname()
    light:save(name)
    local closed = scene:surface_grid { file = name }
    os.remove(name)
    closed:close()
    refused("has been closed", function() return closed:irradiance({ { 0, -1, 0 } }, { { 0, 1, 0 } }) end)
    assert.equal("ylm.surface_grid (closed)", tostring(closed))
  end)

  it("is cancelled without harm", function()
    local g, _, code = scene:surface_grid { tolerance = 0.01, links = links, judge = "field",
      progress = function() return false end }
    assert.is_nil(g)
    assert.equal("ECANCELLED", code)
  end)

  it("takes meshes as they come", function()
    local hostile = {
      needles = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0.5, 1e-7, 0 } }, triangles = { { 1, 2, 3 } } },
      points = { vertices = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }, triangles = { { 1, 2, 3 } } },
      twice = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 }, { 1, 2, 3 }, { 1, 3, 2 } } },
      fan = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { -1, 0, 0 } },
        triangles = { { 1, 2, 3 }, { 1, 2, 4 }, { 1, 2, 5 } } },
    }
    local function lit(name, geometry)
      local s = ylm.scene(name) { lights = ylm.sphere_light { at = { 0.3, 0.8, 0.6 }, radius = 0.1 }, geometry = geometry }
      local g = listen(function()
        return assert(s:surface_grid { tolerance = 0.5, judge = "field", corners = 100, rays = 16,
          links = s:links { spacing = 1, rays = 16 } })
      end)
      assert.is_true(g.stats.error >= 0, name) -- and is a number
      g:close()
    end
    local all = { ylm.box { scale = 4 } }
    for name, mesh in pairs(hostile) do
      mesh.material = ylm.matte { albedo = 0.5 }
      all[#all + 1] = ylm.mesh(mesh)
      if long(false, true) then
        lit(name, { ylm.box { scale = 4 }, ylm.mesh(mesh) })
        lit(name, { ylm.mesh(mesh) })
      end
    end
    lit("all in a box", all)
  end)

  it("is an object of the library", function()
    assert.equal("ylm.surface_grid", core.type(light))
    assert.truthy(tostring(light):find "corners")
    local corners, values = light:rectangles()
    assert.equal(light.stats.rectangles, corners.shape[1])
    assert.same({ light.stats.rectangles, 4, 3 }, { values.shape[1], values.shape[2], values.shape[3] })
  end)
end)
