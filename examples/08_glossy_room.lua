-- A room of stand-ins for measured materials: ABC fits of five of MERL's, and a floor that shines.
--
--     ylm run examples/08_glossy_room.lua [--out DIR] [--width N] [--samples N]
--
-- Writes glossy_room.png: by spherical harmonics, by harmonics and rays (the default), by paths of one reflection. Prints their
-- errors, as 08_glossy.lua does. The fits are as printed (Loew et al. 2012): their absolute scale is open by a factor of pi.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 320, samples = 256, lmax = 8 }
local size = { option.width, math.floor(0.6 * option.width) }

local wall = ylm.matte { albedo = 0.7 }
local function ball(x, z, radius, fit)
  return ylm.sphere { at = { x, radius, z }, radius = radius, divide = { 192, 96 },
    material = ylm.abc { fit = fit, scale = math.pi } }
end
local room = ylm.scene "stand-ins" {
  camera = ylm.camera { from = { 0, 1.05, 3.4 }, at = { 0, 0.72, 0 }, fov = 40 },
  geometry = {
    ylm.quad { corner = { -1.4, 0, 1.4 }, u = { 2.8, 0, 0 }, v = { 0, 0, -2.8 },
      material = ylm.ggx { alpha = 0.25, f0 = 0.08, base = { 0.32, 0.22, 0.14 } } },
    ylm.quad { corner = { -1.4, 0, -1.4 }, u = { 2.8, 0, 0 }, v = { 0, 2, 0 }, material = wall },
    ylm.quad { corner = { -1.4, 0, 1.4 }, u = { 0, 0, -2.8 }, v = { 0, 2, 0 }, material = wall },
    ylm.quad { corner = { 1.4, 0, -1.4 }, u = { 0, 0, 2.8 }, v = { 0, 2, 0 }, material = wall },
    ball(-0.95, -0.35, 0.38, "gold-metallic-paint"), ball(-0.15, -0.6, 0.42, "nickel"), ball(0.75, -0.4, 0.4, "blue-acrylic"),
    ball(-0.45, 0.45, 0.25, "red-metallic-paint"), ball(0.4, 0.5, 0.27, "specular-maroon-phenolic"),
  },
  lights = {
    ylm.polygon_light { vertices = { { -0.5, 1.98, -0.5 }, { 0.5, 1.98, -0.5 }, { 0.5, 1.98, 0.3 }, { -0.5, 1.98, 0.3 } },
      radiance = 6 },
    ylm.sphere_light { at = { -1.1, 1.5, 0.9 }, radius = 0.1, radiance = { 30, 22, 12 } },
  },
}

--- 1 where a place is on a wall, else 0: walls are matte, all else glosses.
local function is_matte(at)
  return (at[{ {}, {}, 1 }]:abs():greater(1.399) + at[{ {}, {}, 3 }]:less(-1.399)):clamp(0, 1)
end

--- The errors of common.errors at surfaces, matte = true, false: those that are matte, that gloss.
local function errors(image, truth, matte)
  return common.errors(image, truth, matte ~= nil and function(at) return is_matte(at):equal(matte and 1 or 0) end)
end

ylm.on_warning(false)
local truth, judged = assert(room:pathtrace { size = size, samples = option.samples, reflections = { 0, 1 } })
local print_row = common.table { { "", "%-34s" }, { "rms %", "%6.1f" }, { "95 %", "%6.1f" }, { "gloss", "%6.1f" },
  { "95 %", "%6.1f" }, { "matte", "%6.1f" }, { "s", "%6.1f" } }
local pictures = {}
local function judge(label, caption, image, report)
  local rms, quantile = errors(image, truth)
  local gloss, gloss95 = errors(image, truth, false)
  print_row { label, rms, quantile, gloss, gloss95, (errors(image, truth, true)), report.seconds.total }
  pictures[#pictures + 1] = { image = image, tone = "hable", exposure = 1, caption = caption }
end
local o = { size = size, samples = 16, lmax = option.lmax, visibility = "transfer", occlusion_distance = 1 }
local function with(more)
  for name, value in pairs(o) do more[name] = value end
  return more
end
for _, gloss in ipairs { "matte", "sh", "auto" } do
  judge(('reference, gloss = "%s", lmax %d'):format(gloss, option.lmax), ('gloss = "%s", lmax %d'):format(gloss, option.lmax),
    assert(room:render(with { by = "sum", gloss = gloss })))
end
judge("render: rays, 64 light samples", "scene:render, by rays", assert(room:render { size = size, samples = 16,
  light_samples = 64, bounces = 0 }))
print(("truth: %d paths a pixel, noise %.1f %%, %.1f s"):format(truth.metadata.samples, 100 * judged.noise, judged.seconds.total))
pictures[#pictures + 1] = { image = truth, tone = "hable", exposure = 1, caption = ("paths of one reflection, %d a pixel"):format(
  truth.metadata.samples) }
common.save(ylm.figure { rows = { { pictures[1], pictures[2], pictures[3] }, { pictures[4], pictures[5] } },
  title = "Direct light in a room of ABC fits, as printed times pi" }, option.out .. "glossy_room.png")
