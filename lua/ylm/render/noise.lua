--- Noise of pictures by rays and links: where a picture speaks of it, and how many rays leave less.

local core = require "ylm.c.core"
local warning = require "ylm.warning"

local noise = {}

noise.WANTED = 0.03 -- of a picture by rays, where nobody says one
noise.SLACK = 1.1 -- times the noise that is wanted: up to which it counts as reached
noise.SHARED = 1 / 3 -- of the noise that is wanted, above which that of elements is said
noise.LOUD, noise.FAIR = 0.05, 0.02 -- of a pixel: of which a picture warns, and which is advised

--- Shading points of a pixel that sees surfaces.
local function density(p)
  return math.max(1, p.stats.points * p.options.samples / math.max(1, p.stats.hits))
end

--- Noise in a pixel, from that of a shading point.
function noise.of_pixel(p, of_point) return of_point / math.sqrt(density(p)) end

--- The number of rays, or links, that brings the noise of `count` of them down to FAIR: it falls with their root.
function noise.enough(count, of_pixel) return count * (of_pixel / noise.FAIR) ^ 2 end

local function say(p, report, topic, ...)
  report.warnings[#report.warnings + 1] = warning.say(p.scene, topic, ...)
end

--- Says that shadow rays are few for the lamps, and how many leave little noise.
function noise.say_direct(p, report, count)
  local found = noise.of_pixel(p, report.direct_noise)
  if found <= noise.LOUD then return end
  local enough = 2 ^ math.ceil(math.log(noise.enough(count, found)) / math.log(2))
  local advice = enough <= core.limits.light_samples and ("set light_samples = %d for %.0f %%"):format(enough, 100 * noise.FAIR)
    or "more camera rays leave less"
  say(p, report, "light_samples", "scene %q: %d shadow rays of a shading point leave a noise of %.0f %% in direct light: %s",
    p.scene.name or "?", count, 100 * found, advice)
end

return noise
