-- Whether surface grids that say `met` keep their tolerance: at fresh places, and by many seeds of the judge.
--
--     build/ylm run spec/bench/surface_promise.lua held [scene: a pattern] [tolerance] [places] [paths of a place at most]
--     build/ylm run spec/bench/surface_promise.lua seeds [field | paths] [tolerance] [seeds] [places] [paths of a place]
--
-- "held": a grid that paths have judged, and 10,000 places of another seed by up to 65,536 paths of each: places that miss the
-- tolerance for sure (3.3 standard errors), and those that noise hides. "seeds": 200 grids of a small parted room, each with a
-- seed of its own, and the share of 4,000 places at which it misses the tolerance, by 12,288 rays to elements or by paths.

local ylm = require "ylm"
local promise = require "spec.support.surface_promise"

local PROMISED = 0.01
local what = arg[1] or "held"

ylm.on_warning(false)

local function held(pattern, tolerance, n, most)
  local entries = {}
  for _, entry in ipairs(require "spec.support.walled_scenes") do entries[#entries + 1] = entry end
  for _, entry in ipairs(require "spec.support.bounce_scenes") do
    entries[#entries + 1] = { name = entry.name, make = entry.make, quantity = "indirect" }
  end
  for _, entry in ipairs(entries) do
    if entry.name:find(pattern) then
      local scene = entry.make(ylm)
      local links = assert(scene:links { rays = 256 })
      local light = assert(scene:surface_grid { tolerance = tolerance, quantity = entry.quantity, links = links,
        progress = false })
      print(("%s, tolerance %g: %d corners, met %s, error %.4f, %d of %d places fail"):format(entry.name, tolerance,
        light.stats.corners, tostring(light.stats.met), light.stats.error, light.stats.failed, light.stats.verified))
      local places = promise.draw(light, links:radiosity(), n, 4242)
      local failed, open = promise.hold(scene, places, entry.quantity, tolerance, 256, most)
      local paths = 0
      for i = 1, #places.points do paths = paths + places.paths[i] end
      print(("  %d fresh places, %.0f million paths: %d fail for sure, noise hides %d; by the best estimate %.4f fail"):format(
        #places.points, paths / 1e6, failed, #open, promise.share(places, tolerance)))
      io.stdout:flush()
    end
  end
end

local function seeds(by, tolerance, count, n, samples)
  local scene = ylm.scene "a parted room" { lights = ylm.sphere_light { at = { 0.5, 0.4, 0 }, radius = 0.15, radiance = 20 },
    geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
      ylm.box { bounds = { { -0.04, -0.99, -0.99 }, { 0.04, 0.3, 0.6 } }, material = ylm.matte { albedo = 0.6 } } } }
  local links = assert(scene:links { rays = 64, spacing = 0.15 })
  local any = assert(scene:surface_grid { tolerance = 0.5, links = links, judge = "field", progress = false })
  local places = promise.draw(any, links:radiosity(), n, 777)
  if by == "field" then promise.by_elements(places, links:radiosity(nil, { light_samples = 64 }), "indirect", 12288)
  else promise.by_paths(scene, places, "indirect", samples, 5) end
  local points, normals = ylm.array(places.points), ylm.array(places.normals, "float")
  local met, wrong, shares = 0, 0, {}
  for seed = 1, count do
    local light = assert(scene:surface_grid { tolerance = tolerance, links = links, judge = by, progress = false, seed = seed })
    local E, told = assert(light:irradiance(points, normals)), {}
    for i = 1, #places.points do told[i] = { E:get(i, 1), E:get(i, 2), E:get(i, 3) } end
    shares[seed] = promise.share(places, tolerance, told)
    if light.stats.met then
      met = met + 1
      if shares[seed] > PROMISED then wrong = wrong + 1 end
    end
    light:close()
  end
  table.sort(shares)
  print(("a parted room, judged by %s, tolerance %g: met for %d of %d seeds, of which %d have more than 1 %% of %d places "
    .. "above it"):format(by, tolerance, met, count, wrong, #places.points))
  print(("  allowed: %d (99 %%); shares %.4f to %.4f, median %.4f"):format(promise.allowed(met, PROMISED), shares[1],
    shares[count], shares[math.ceil(count / 2)]))
end

if what == "seeds" then
  seeds(arg[2] or "field", tonumber(arg[3]) or 0.1, tonumber(arg[4]) or 200, tonumber(arg[5]) or 4000, tonumber(arg[6]) or 4096)
else
  held(arg[2] or "rooms", tonumber(arg[3]) or 0.1, tonumber(arg[4]) or 10000, tonumber(arg[5]) or 65536)
end
