-- Grids of indirect light in whole scenes: one that refines itself, for the surfaces that a camera sees, beside a uniform one of
-- as many rays. Both are looked up at shading points, and judged by light gathered there along many links.
--
--     build/ylm run spec/bench/indirect_grids.lua [tolerance]

local places = require "spec.support.surface_places"
local ylm = require "ylm"
local scenes = require "spec.support.bounce_scenes"

local TOLERANCE, RAYS, LINKS = tonumber(arg[1]) or 0.1, 1536, 1024
local SIZE = { 96, 54 }

--- The green channel of a picture, pixel by pixel.
local function pixels(image)
  local layer, out = image:layer "radiance", {}
  for y = 1, SIZE[2] do
    for x = 1, SIZE[1] do out[#out + 1] = layer:get(y, x, 2) end
  end
  return out
end

--- rms of a - b over the mean of b - direct.
local function error_of(a, b, direct)
  local square, mean = 0, 0
  for i = 1, #b do square, mean = square + (a[i] - b[i]) ^ 2, mean + b[i] - direct[i] end
  return math.sqrt(square / #b) / (mean / #b)
end

for _, entry in ipairs(scenes) do
  local scene = entry.make(ylm)
  local t = assert(scene:links { spacing = 0.1, rays = 128 })
  local lit = assert(t:radiosity())
  local view = assert(scene:prepare { size = SIZE, samples = 1, links = t, rays = LINKS })
  local function picture(indirect)
    return pixels(assert(view:render { bounced = indirect, light_samples = 1, layers = false }))
  end
  local direct, truth = picture(nil), picture(lit)
  local function bake(probes)
    local field = lit:field { rays = RAYS }
    local grid = assert(ylm.bake(probes, field, { occupied = view, bounds = t.bounds }))
    return grid, field.stats.rays
  end
  local box = places.box_of(scene)
  local ok, adaptive, rays = pcall(bake, ylm.adaptive_grid { bounds = box, lmax = 2, tolerance = TOLERANCE, depth = 7 })
  if not ok then print(entry.name .. ": " .. tostring(adaptive))
  else
    local size = {}
    for a = 1, 3 do size[a] = box[2][a] - box[1][a] end
    local function uniform(points)
      local edge, cells = (size[1] * size[2] * size[3] / points) ^ (1 / 3), {}
      for a = 1, 3 do cells[a] = math.max(1, math.floor(size[a] / edge + 0.5)) end
      return bake(ylm.uniform_grid { bounds = box, lmax = 2, cells = cells })
    end
    --- A uniform grid with about so many of what `count` counts: voxels without surfaces in sight have no probes.
    local function like(wanted, count)
      local points, even, even_rays = adaptive.stats.points, nil, nil
      for _ = 1, 4 do
        even, even_rays = uniform(points)
        local have = count(even, even_rays)
        if math.abs(have / wanted - 1) < 0.08 then break end
        points = points * wanted / have
      end
      return even, even_rays
    end
    local fine = error_of(picture(adaptive), truth, direct)
    local function say(name, even, even_rays)
      local coarse = error_of(picture(even), truth, direct)
      print(("  uniform, as many %s: %6d probes, %9d rays: %.4f; the adaptive one is better by %.1f dB"):format(name,
        even.stats.points, even_rays, coarse, 20 * math.log(coarse / fine) / math.log(10)))
    end
    print(("%s: indirect light at %d pixels, beside %d links; rms over its mean"):format(entry.name, #truth, LINKS))
    print(("  adaptive, tolerance %g: %6d probes, %9d rays (verification included), met %s (%.3f): %.4f"):format(TOLERANCE,
      adaptive.stats.points, rays, tostring(adaptive.stats.met), adaptive.stats.error, fine))
    say("probes", like(adaptive.stats.points, function(even) return even.stats.points end))
    say("rays", like(rays, function(_, n) return n end))
  end
end
