-- A stranger's room by default settings: the bake, the picture by it, and FLIP to paths.
--
--     make bench BENCH=by_default    build/ylm run spec/bench/by_default.lua [folder of references] [paths of a pixel, in a half]
--
-- The room has a window, a clear sky and a sun (spec/support/window_room.lua). It is baked and rendered as by `ylm bake room.lua`
-- and `ylm render room.lua --grid room.surfaces`. The reference has a quarter of the picture's width, and its pixels are compared
-- with means of 4 x 4 of the picture. It is made in two halves, kept in the folder: FLIP between them says what their noise is
-- worth. FLIP is the paper's of radiance (hdr), and of the picture as it is shown at EXPOSURE (ldr).

local core = require "ylm.c.core"
local ylm = require "ylm"
local room = dofile "spec/support/window_room.lua"(ylm)

local folder, paths = arg[1] or "out/by_default", tonumber(arg[2] or 2048)
local WIDTH, HEIGHT, FINER, EXPOSURE = 320, 180, 4, -0.4
local MIBI = 2 ^ 20

ylm.on_warning(false) -- they are printed below
os.execute("mkdir -p " .. folder)

--- The results of f(), which raises what it returns as an error, with its times printed.
local function timed(what, f)
  local start, busy = core.seconds(), os.clock()
  local a, b = f()
  if not a then error(b) end
  print(("%-24s %6.1f s of processors, %6.1f s"):format(what, os.clock() - busy, core.seconds() - start))
  return a, b
end

--- An image of the layer radiance `rows` [h][w][3] alone.
local function image_of(rows)
  local image = ylm.image { size = { rows.shape[2], rows.shape[1] } }
  image:layer()[{ { 1, rows.shape[1] } }] = rows
  return image
end

--- The mean of FINER x FINER pixels each.
local function coarser(rows)
  local sum
  for y = 1, FINER do
    for x = 1, FINER do
      local part = rows[{ { y, rows.shape[1], FINER }, { x, rows.shape[2], FINER } }]
      sum = sum and sum + part or part
    end
  end
  return sum / FINER ^ 2
end

--- FLIP of radiance, and of what is shown.
local function flip(a, b)
  local _, hdr = image_of(a):flip(image_of(b))
  local function shown(rows) return image_of((rows * 2 ^ EXPOSURE):clamp(0, 1)) end
  local _, ldr = shown(a):flip(shown(b), { range = "ldr" })
  return hdr.mean, ldr.mean
end

local function half(k)
  local path = ("%s/half%d.exr"):format(folder, k)
  local kept = io.open(path, "rb")
  if kept then
    kept:close()
    return assert(ylm.load(path)):layer "radiance"
  end
  local image = timed("paths, half " .. k, function()
    return room:pathtrace { size = { WIDTH, HEIGHT }, samples = paths, seed = 1000 + k, progress = false }
  end)
  assert(image:save(path))
  return image:layer "radiance"
end

local light = timed("scene:bake()", function() return room:bake { progress = false } end)
local s = light.stats
print(("  %d corners, %.0f million rays, met %s; the elements' light %.3f, paths %.3f to %.3f"):format(s.corners, s.rays / 1e6,
  tostring(s.met), s.paths.field_error, s.paths.least, s.error))
local image, report = timed("scene:render", function()
  return room:render { bounced = light, denoise = "auto", size = { FINER * WIDTH, FINER * HEIGHT }, progress = false }
end)
print(("  noise %.3f (%.3f before the filter), least pixel %g, memory %.0f MiB"):format(report.noise,
  report.noise_before or report.noise, image:layer("radiance"):min(), report.bytes / MIBI))
local picture, one, two = coarser(image:layer "radiance"), half(1), half(2)
for _, row in ipairs { { "picture, first half", picture, one }, { "picture, second half", picture, two },
  { "picture, both halves", picture, (one + two) / 2 }, { "half, half", one, two } } do
  print(("%-24s FLIP %.4f (hdr), %.4f (ldr)"):format(row[1], flip(row[2], row[3])))
end
print(("%-24s %.4f, %.4f"):format("mean, of the paths", picture:mean(), ((one + two) / 2):mean()))
