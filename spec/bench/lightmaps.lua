-- Lightmaps: charts of meshes; errors beside even texels at equal bytes, seams, seconds by stage; a promise at 10,000 places.
--
--     make bench BENCH=lightmaps
--     build/ylm run spec/bench/lightmaps.lua [charts | texels [SCENE] | noise | misses | tolerance | promise]
--
-- "rms" and "99 %" are of irradiance relative to the mean, and to the larger of the place's and the mean, at 2,048 fresh places
-- by 16 times as many rays as a place of the fit has, to elements and lamps. "dB" is what texels spread by light gain over even
-- ones in rms; "parts" divides large charts. "noise" parts the error of the tree's room in noise, by two seeds, and the rest.
-- "misses" counts places of the room with a window that are off, by paths. "tolerance" asks for 0.03 of that room.
-- The promise is judged again by up to 4,096 paths of 10,000 places of another seed.

local ylm = require "ylm"
local core = require "ylm.c.core"
local promise = require "spec.support.surface_promise"

local what = arg and arg[1]
ylm.on_warning(false)

local function charts()
  print "charts: mesh, triangles, charts, stretch, of the worst, share of the picture, seconds"
  for _, case in ipairs {
    { "box", ylm.box {} }, { "sphere", ylm.sphere {} }, { "torus", ylm.torus {} }, { "knot", ylm.knot {} },
    { "knot, many", ylm.knot { divide = { 4000, 125 } } },
  } do
    local _, r = assert(case[2].mesh:unwrap { texels = 65536 })
    print(("  %-12s %8d %5d  %.4f %.4f  %.3f  %6.2f"):format(case[1], r.triangles, r.charts, r.stretch, r.worst, r.share,
      r.seconds))
  end
end

--- A knot on a floor under a lamp.
local function curved()
  local white = ylm.matte { albedo = 0.7 }
  return ylm.scene "a knot on a floor" {
    geometry = { ylm.knot { radius = 0.6, minor = 0.25, tube = 0.1, divide = { 192, 16 }, at = { 0, 0.5, 0 }, material = white },
      ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 }, material = white, sides = "front" } },
    lights = ylm.sphere_light { at = { 0.8, 2.2, 0.6 }, radius = 0.15, radiance = 100 },
  }
end

--- Stairs and pillars under a skylight, with a lamp beneath the stairs. No constant of density.c or divide.c was chosen by it.
local function hall()
  local white, stone, wood = ylm.matte { albedo = 0.75 }, ylm.matte { albedo = { 0.5, 0.48, 0.45 } },
    ylm.matte { albedo = { 0.45, 0.3, 0.2 } }
  local list = {}
  local function add(lo, hi, material) list[#list + 1] = ylm.box { bounds = { lo, hi }, material = material } end
  add({ -3.2, -0.2, -2.2 }, { 3.2, 0, 2.2 }, stone)
  add({ -3.2, 0, -2.2 }, { -3, 4, 2.2 }, white)
  add({ 3, 0, -2.2 }, { 3.2, 4, 2.2 }, white)
  add({ -3, 0, -2.2 }, { 3, 4, -2 }, white)
  add({ -3, 0, 2 }, { 3, 4, 2.2 }, white)
  add({ -3.2, 4, -2.2 }, { -1, 4.2, 2.2 }, white) -- the roof around the skylight
  add({ 1.2, 4, -2.2 }, { 3.2, 4.2, 2.2 }, white)
  add({ -1, 4, -2.2 }, { 1.2, 4.2, -0.6 }, white)
  add({ -1, 4, 0.6 }, { 1.2, 4.2, 2.2 }, white)
  for i = 1, 9 do add({ -2.6 + 0.35 * i, 0.24 * i - 0.06, -1.9 }, { -2.2 + 0.35 * i, 0.24 * i, -0.7 }, wood) end
  for i = 0, 2 do
    add({ -1.95 + 1.8 * i, 0, 0.95 }, { -1.65 + 1.8 * i, 4, 1.25 }, stone)
  end
  list[#list + 1] = ylm.sphere { radius = 0.3, divide = { 32, 16 }, at = { 1.9, 0.301, -0.9 }, material = wood }
  return ylm.scene "a hall with stairs" { geometry = list,
    lights = { ylm.sun_light { direction = { 0.3, 2, -0.25 }, irradiance = { 50, 46, 40 } },
      ylm.environment_light { sky = { kind = "clear", zenith = { 0, 1, 0 }, sun = { 0.3, 2, -0.25 }, luminance = 2 } },
      ylm.sphere_light { at = { 0.3, 0.9, -1.3 }, radius = 0.06, radiance = { 300, 220, 140 } } } }
end

local scenes = {
  { "room", function() return ylm.load "examples/scenes/room.lua" end, {} },
  { "window", function() return require "spec.support.window_room"(ylm) end, { spacing = 0.15 } },
  { "knot", curved, {} },
  { "hall", hall, { spacing = 0.2 } },
}

local function row(name, texels, spread, s, gain)
  print(("  %-7s %6d %-5s  %.4f %s  %.4f  %.3f  %5d %.4f %.2f  %5.1f %5.1f %5.1f %5.1f"):format(name, texels, spread, s.rms,
    gain and ("%5.1f"):format(gain) or "     ", s.error, s.jump, s.charts, s.stretch, s.share, s.chart_seconds, s.pack_seconds,
    s.light_seconds, s.fit_seconds))
  io.stdout:flush()
end

--- The rows of a scene.
local function rows_of(case)
  local scene = case[2]()
  local links = assert(scene:links { lmax = 0, spacing = case[3].spacing })
  for _, n in ipairs { 16384, 65536 } do
    local even
    for _, spread in ipairs { "even", "light", "parts" } do
      local s = assert(scene:lightmap { texels = n, spread = spread == "even" and "even" or "light", parts = spread == "parts",
        links = links, rays = 32, light_samples = 16, progress = false }).stats
      row(case[1], n, spread, s, even and 20 * math.log(even / s.rms) / math.log(10))
      even = even or s.rms
    end
  end
end

local function texels()
  print "texels: scene, texels, spread, rms, dB, 99 %, jump, charts, stretch, share; seconds of charts, packing, light, fits"
  for _, case in ipairs(scenes) do
    if not (arg and arg[2]) or arg[2] == case[1] then rows_of(case) end
  end
end

local function lists(a)
  local rows = {}
  for i = 1, #a do rows[i] = { a:get(i, 1), a:get(i, 2), a:get(i, 3) } end
  return rows
end

--- A box room with a block in it.
local function blocked()
  return ylm.scene "a block in a room" {
    geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
      ylm.box { bounds = { { -0.6, -1, -0.2 }, { -0.1, -0.4, 0.5 } }, material = ylm.matte { albedo = { 0.7, 0.4, 0.2 } } } },
    lights = ylm.sphere_light { at = { 0.3, 0.6, 0.2 }, radius = 0.25, radiance = 10 },
  }
end

--- How much of the error of the tree's room is noise of texels, which differs from seed to seed.
local function noise()
  print "noise: texels, links and shadow rays, spread, rms, its noise, the rest"
  local scene = ylm.load "examples/scenes/room.lua"
  local links = assert(scene:links { lmax = 0 })
  for _, case in ipairs { { 16384, 32, 16 }, { 65536, 32, 16 }, { 65536, 256, 128 } } do
    for _, spread in ipairs { "even", "light" } do
      local told, rms, square, mean = {}, 0, 0, 0
      for seed = 1, 2 do
        local map = assert(scene:lightmap { texels = case[1], rays = case[2], light_samples = case[3], seed = seed,
          spread = spread, links = links, progress = false })
        local _, _, E = core.owned(map, "made").lib.map_judges(map, links:radiosity(), 8000, 4242)
        told[seed], rms = E, rms + map.stats.rms ^ 2 / 2
      end
      for i = 1, #told[1] do
        square = square + (told[1]:get(i, 2) - told[2]:get(i, 2)) ^ 2 / 2 / #told[1]
        mean = mean + told[1]:get(i, 2) / #told[1]
      end
      local own = square / mean ^ 2
      print(("  %6d %3d %3d  %-5s  %.4f %.4f %.4f"):format(case[1], case[2], case[3], spread, math.sqrt(rms), math.sqrt(own),
        math.sqrt(math.max(0, rms - own))))
      io.stdout:flush()
    end
  end
end

--- How many places of the room with a window are off by how much, told by paths.
local function misses()
  print "misses: texels, error of 99 %; shares of 6,000 places that are off by more than 0.02, 0.03, 0.05, 0.1; paths' noise"
  local scene = require "spec.support.window_room"(ylm)
  local links = assert(scene:links { lmax = 0, spacing = 0.15 })
  for _, n in ipairs { 65536, 262144 } do
    local map = assert(scene:lightmap { texels = n, links = links, progress = false })
    local points, normals, told = core.owned(map, "made").lib.map_judges(map, links:radiosity(), 6000, 4242)
    local places = { points = lists(points), normals = lists(normals), told = lists(told) }
    promise.by_paths(scene, places, "all", 1024, 7)
    local off, mean, square = {}, 0, 0
    for _, E in ipairs(places.E) do mean = mean + E[2] / #places.E end
    for _, V in ipairs(places.V) do square = square + V[2] / mean ^ 2 / #places.V end
    for _, most in ipairs { 0.02, 0.03, 0.05, 0.1 } do off[#off + 1] = ("%.4f"):format(promise.share(places, most)) end
    print(("  %6d %.4f  %s  %.4f"):format(n, map.stats.error, table.concat(off, " "), math.sqrt(square)))
    io.stdout:flush()
  end
end

--- The cost of a tolerance in the room with a window, with the sun and the sky and without.
local function asked()
  print "tolerance: quantity, tolerance, met, error by paths, by elements; texels; places and rays, millions; misses of the last"
  print "  picture at edges of light, under bodies, of noise; processor seconds, with the paths that judge"
  local scene = require "spec.support.window_room"(ylm)
  local links = assert(scene:links { lmax = 0, spacing = 0.15 })
  for _, quantity in ipairs { "indirect", "all" } do
    local start = os.clock()
    local s = assert(scene:lightmap { tolerance = 0.03, quantity = quantity, links = links, progress = false }).stats
    print(("  %-8s 0.03 %-5s %.4f %.4f %7d  %5.2f %6.0f  %d %d %d  %5.0f"):format(quantity, tostring(s.met), s.error,
      s.paths.field_error, s.width * s.height, s.places / 1e6, s.rays / 1e6, s.misses.edges, s.misses.bodies, s.misses.noise,
      os.clock() - start))
    if s.warning then print("    " .. s.warning) end
    io.stdout:flush()
  end
end

local function kept()
  print "promise: quantity, tolerance, texels, met, error; places that fail for sure, that noise hides"
  for _, case in ipairs { { "all", 0.05 }, { "all", 0.03 } } do
    local scene = blocked()
    local links = assert(scene:links { rays = 256, lmax = 0, spacing = 0.06 })
    local map = assert(scene:lightmap { tolerance = case[2], quantity = case[1], links = links, progress = false })
    local points, normals, told = core.owned(map, "made").lib.map_judges(map, links:radiosity(), 10000, 4242)
    local places = { points = lists(points), normals = lists(normals), told = lists(told) }
    local failed, open = promise.hold(scene, places, case[1], case[2], 256, 4096)
    print(("  %-8s %.2f %7d %s %.4f  %d and %d of %d"):format(case[1], case[2], map.stats.width * map.stats.height,
      tostring(map.stats.met), map.stats.error, failed, #open, #places.points))
    io.stdout:flush()
  end
end

if not what or what == "charts" then charts() end
if not what or what == "texels" then texels() end
if not what or what == "noise" then noise() end
if not what or what == "misses" then misses() end
if not what or what == "tolerance" then asked() end
if not what or what == "promise" then kept() end
