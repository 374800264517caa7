-- Bounced light on glossy surfaces, by rays of their materials and as matte ones, against the path tracer: a room with a
-- floor, a metal ball and a lacquered one of GGX.
--
--     build/ylm run spec/bench/gloss_bounced.lua [width] [samples of the judge] [spacing] [links] [alpha]
--
-- error: sqrt(max(0, sum (a-b)^2 - va) / sum b^2) over pixels without lamps, b the judge and va its variance. once: light of one
-- bounce alone, against paths of reflections = { 2, 2 }; all: the whole picture, against { 1, "all" }. rays: gloss = "auto";
-- matte: gloss = "matte", the mean albedo.

local ylm = require "ylm"

local width, samples = tonumber(arg[1] or 96), tonumber(arg[2] or 1024)
local spacing, links = tonumber(arg[3] or 0.05), tonumber(arg[4] or 64)
local alphas = arg[5] and { tonumber(arg[5]) } or { 0.1, 0.3, 0.6 }
local size = { width, math.floor(width * 9 / 16) }

local function room(alpha)
  local function wall(corner, u, v, albedo)
    return ylm.quad { corner = corner, u = u, v = v, material = ylm.matte { albedo = albedo } }
  end
  return ylm.scene "a glossy room" {
    camera = ylm.camera { from = { 0, 1.25, 3.7 }, at = { 0, 0.85, 0 }, fov = 42 },
    geometry = {
      ylm.quad { corner = { -2, 0, 4 }, u = { 4, 0, 0 }, v = { 0, 0, -6 },
        material = ylm.ggx { alpha = alpha, f0 = 0.5, base = 0.15 } },
      wall({ -2, 2.5, -2 }, { 4, 0, 0 }, { 0, 0, 6 }, 0.75), wall({ -2, 0, -2 }, { 4, 0, 0 }, { 0, 2.5, 0 }, 0.75),
      wall({ -2, 0, 4 }, { 4, 0, 0 }, { 0, 2.5, 0 }, 0.75),
      wall({ -2, 0, 4 }, { 0, 0, -6 }, { 0, 2.5, 0 }, { 0.7, 0.08, 0.06 }),
      wall({ 2, 0, -2 }, { 0, 0, 6 }, { 0, 2.5, 0 }, { 0.08, 0.25, 0.7 }),
      ylm.sphere { at = { -0.85, 0.5, -0.5 }, radius = 0.5, material = ylm.ggx { alpha = alpha, f0 = { 1, 0.78, 0.34 } } },
      ylm.sphere { at = { 0.3, 0.38, 0.35 }, radius = 0.38, material = ylm.ggx { alpha = alpha, f0 = 0.04,
        base = { 0.1, 0.5, 0.2 } } },
      ylm.sphere { at = { 1.1, 0.55, -0.7 }, radius = 0.55, material = ylm.matte { albedo = 0.7 } },
    },
    lights = { ylm.sphere_light { at = { 0, 1.95, 0.2 }, radius = 0.25, radiance = { 15, 14, 12 } } },
  }
end

local function numbers(image, layer) return ylm.array(image:layer(layer or "radiance"), "double") end

--- The error and the judge's noise, relative to the judge's root mean square; `less`: taken from a.
local function compare(a, b, lamp, less)
  local dark = lamp:equal(0):reshape { size[2], size[1] }
  local y = numbers(b):select(dark)
  local d = ((less and numbers(a) - numbers(less) or numbers(a)):select(dark) - y)
  local square, noise, all = (d ^ 2):sum(), numbers(b, "variance"):select(dark):sum(), (y ^ 2):sum()
  return 100 * math.sqrt(math.max(0, square - noise) / all), 100 * math.sqrt(noise / all)
end

print(("%dx%d, judge of %d samples, spacing %g, %d links, 16 camera rays"):format(size[1], size[2], samples, spacing, links))
local HEAD, ROW = "%-6s %9s | %8s %8s %8s | %8s %8s %8s | %8s %8s %8s",
  "%-6g %9d | %7.2f%% %7.2f%% %7.2f%% | %7.2f%% %7.2f%% %7.2f%% | %8.2f %8.2f %8.1f"
print(HEAD:format("alpha", "points", "once", "matte", "noise", "all", "matte", "noise", "s", "s matte", "s paths"))
for _, alpha in ipairs(alphas) do
  local scene = room(alpha)
  local once = assert(scene:pathtrace { size = size, samples = samples, reflections = { 2, 2 }, layers = false })
  local all, judged = assert(scene:pathtrace { size = size, samples = samples, reflections = { 1, "all" }, layers = false })
  local t = assert(scene:links { spacing = spacing, rays = 128 })
  local function picture(bounces, gloss)
    return assert(scene:render { size = size, light_samples = 64, rays = bounces ~= 0 and links or nil, bounces = bounces,
      bounced = bounces ~= 0 and t or nil, gloss = gloss })
  end
  local direct = picture(0)
  local lamp, found = numbers(direct, "emitter"), {}
  for i, gloss in ipairs { "auto", "matte" } do
    local whole, report = picture("all", gloss)
    local one = compare(picture(1, gloss), once, lamp, direct)
    found[i] = { once = one, all = compare(whole, all, lamp), seconds = report.seconds.total, points = report.points }
  end
  local _, noise_once = compare(once, once, lamp)
  local _, noise = compare(all, all, lamp)
  print(ROW:format(alpha, found[1].points, found[1].once, found[2].once, noise_once, found[1].all, found[2].all, noise,
    found[1].seconds, found[2].seconds, judged.seconds.total))
end
