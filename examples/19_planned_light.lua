-- Light that is asked for, and lamps that are found for it: an office, a painted wall, six lamps in place of sixty.
--
--     ylm run examples/19_planned_light.lua [--out DIR] [--only office|wall|lamps] [--evaluations N] [--paths N] [--width N]
--
-- The office wants 500 lx and a uniformity of 0.6 of twenty lamps that crowd on one side. The wall wants a letter of spots that
-- may lean, move along their rails and dim. The gallery is lit by sixty lamps; six are moved, and grow, until the lightmap of its
-- floor, and its walls, have nearly the same light. Each part prints the figures that paths find, and leaves maps with isolux
-- lines: planned_office.png, planned_wall.png, planned_lamps.png. The office is also written as planned_office.lua. Metres, lm,
-- cd, lx; y is up.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", only = "", evaluations = 40, paths = 4096, width = 420 }

local function matte(albedo) return ylm.matte { albedo = albedo } end

--- A box of { x0, x1, y0, y1, z0, z1 }.
local function box(b, material)
  return ylm.box { bounds = { { b[1], b[3], b[5] }, { b[2], b[4], b[6] } }, material = material, sides = "front" }
end

local function wanted(name) return option.only == "" or option.only == name end

local row = common.table { { "part", "%-8s" }, { "lamps", "%5d" }, { "evaluations", "%11d" }, { "seconds", "%7.1f" },
  { "klm", "%5.1f" }, { "mean lx", "%7.0f" }, { "U0", "%5.2f" }, { "rms", "%5.2f" }, { "rms before", "%10.2f" },
  { "met", "%5s" } }

local function say(part, plan, report)
  local t = report.targets[1]
  row { part, #plan.lights, report.evaluations, report.seconds, report.lumens / 1000, t.mean, t.uniformity, t.rms or 0,
    t.before.rms or 0, tostring(report.met) }
  common.save(plan:figure { width = option.width }, option.out .. "planned_" .. part .. ".png")
end

-- An office ----------------------------------------------------------------------------------------

local function office()
  local room = { ylm.box { bounds = { { -6, 0, -4 }, { 6, 3, 4 } }, material = matte(0.5) } }
  for _, x in ipairs { -4.2, -1.4, 1.4, 4.2 } do
    for _, z in ipairs { -2.4, 0, 2.4 } do
      room[#room + 1] = box({ x - 0.8, x + 0.8, 0.7, 0.74, z - 0.4, z + 0.4 }, matte(0.4))
    end
  end
  for _, x in ipairs { -2.8, 2.8 } do room[#room + 1] = box({ x - 0.03, x + 0.03, 0, 1.5, -3.2, 3.2 }, matte(0.5)) end
  local lamp, lights = ylm.photometry { cosine = 1, lumens = 3600, watts = 30 }, {}
  for i = 1, 5 do
    for k = 1, 4 do
      lights[#lights + 1] = ylm.photometric_light { photometry = lamp, at = { -6 + 1.1 * i, 2.8, -4 + 1.6 * k }, dim = 0.8,
        name = "panel", opening = { shape = "disk", radius = 0.2 } }
    end
  end
  local scene = ylm.scene "An office: 500 lx and U0 0.6" { geometry = room, lights = lights,
    camera = ylm.camera { from = { -5.5, 2.2, 3.6 }, at = { 2, 0.6, -1 }, fov = 70 } }
  local plan, report = assert(scene:inverse_lighting { evaluations = option.evaluations, judge = option.paths, apart = 1,
    vary = { { lights = "panel", position = { "x", "z" }, within = { { -5.7, 0, -3.7 }, { 5.7, 3, 3.7 } }, dim = { 0, 1.5 } } },
    targets = { { plane = { at = { 0, 0.75, 0 }, size = { 11, 7 } }, mean = { least = 500 }, uniformity = 0.6 } } })
  say("office", plan, report)
  assert(plan:save(option.out .. "planned_office.lua"))
end

-- A painted wall -----------------------------------------------------------------------------------

--- The distance from (x, y) to the segment from a to b.
local function far(x, y, a, b)
  local dx, dy = b[1] - a[1], b[2] - a[2]
  local t = math.max(0, math.min(1, ((x - a[1]) * dx + (y - a[2]) * dy) / (dx * dx + dy * dy)))
  return math.sqrt((x - a[1] - t * dx) ^ 2 + (y - a[2] - t * dy) ^ 2)
end

--- The letter Y on 4.4 x 2.4 m, as rows from the top.
local function letter()
  local rows, middle = {}, { 2.2, 1.1 }
  for r = 1, 24 do
    rows[r] = {}
    for c = 1, 44 do
      local x, y = c / 10 - 0.05, r / 10 - 0.05
      local d = math.min(far(x, y, middle, { 2.2, 2.1 }), far(x, y, middle, { 1.2, 0.3 }), far(x, y, middle, { 3.2, 0.3 }))
      rows[r][c] = 0.2 + 0.8 / (1 + math.exp((d - 0.22) / 0.06))
    end
  end
  return rows
end

local function wall()
  local spot, lights = ylm.photometry { cosine = 120, lumens = 800, opening = { shape = "disk", radius = 0.05 } }, {}
  for k = 1, 2 do
    for i = 1, 12 do
      local x = -2.75 + 5.5 * (i - 0.5) / 12
      lights[#lights + 1] = ylm.photometric_light { photometry = spot, at = { x, 2.9, 1 + 0.8 * k }, to = { x, 1.5, 0 },
        dim = 0.5 }
    end
  end
  local scene = ylm.scene "A wall painted by 24 spots" { lights = lights,
    geometry = ylm.box { bounds = { { -3, 0, 0 }, { 3, 3, 5 } }, material = matte(0.3) } }
  local plan, report = assert(scene:inverse_lighting { evaluations = math.floor(option.evaluations * 1.5), price = "none",
    judge = math.floor(option.paths / 16), spacing = 0.7, receiver_rays = 256, receiver_samples = 16,
    vary = { { direction = 50, dim = { 0, 2 }, position = { "x" }, within = { { -2.9, 0, 0 }, { 2.9, 3, 5 } } } },
    targets = { { image = letter(),
      plane = { at = { 0, 1.5, 0.001 }, size = { 4.4, 2.4 }, normal = { 0, 0, 1 }, spacing = 0.15 } } } })
  say("wall", plan, report)
end

-- Six lamps in place of sixty ------------------------------------------------------------------------

local function lamps()
  local geometry = { ylm.box { bounds = { { -5, 0, -2.5 }, { 5, 3.2, 2.5 } }, material = matte(0.6) },
    ylm.quad { corner = { -4.9, 0.01, 2.4 }, u = { 9.8, 0, 0 }, v = { 0, 0, -4.8 }, divide = 8, material = matte(0.4),
      sides = "front" },
    box({ -0.15, 0.15, 0, 2.2, -0.6, 2.5 }, matte(0.5)), box({ 2.6, 3.4, 0, 1, -0.4, 0.4 }, matte(0.5)) }
  local small, large = ylm.photometry { cosine = 1, lumens = 300 }, ylm.photometry { cosine = 1, lumens = 3000 }
  local function lit_by(photometry, nx, nz, radius)
    local list = {}
    for i = 1, nx do
      for k = 1, nz do
        list[#list + 1] = ylm.photometric_light { photometry = photometry,
          at = { -5 + 10 * (i - 0.5) / nx, 3, -2.5 + 5 * (k - 0.5) / nz }, opening = { shape = "disk", radius = radius } }
      end
    end
    return list
  end
  local before = ylm.scene "Six lamps in place of sixty" { geometry = geometry, lights = lit_by(large, 3, 2, 0.3) }
  local links = assert(before:links { spacing = 0.7, rays = 64, lmax = 0 })
  local sixty = links:radiosity(lit_by(small, 12, 5, 0.05), { derivatives = true })
  local floor = links:receivers { mesh = 2, size = { 39, 19 }, rays = 512, light_samples = 64 }
  local walls = links:receivers { mesh = 1 }
  local plan, report = assert(before:inverse_lighting { links = links, evaluations = option.evaluations,
    judge = math.floor(option.paths / 16), price = "none",
    vary = { { position = { "x", "y", "z" }, within = { { -4.9, 2, -2.4 }, { 4.9, 3.1, 2.4 } }, dim = { 0, 3 },
      size = { 0.5, 6 } } },
    targets = { { receivers = floor, wanted = floor:illuminance(sixty) },
      { receivers = walls, wanted = walls:illuminance(sixty) } } })
  say("lamps", plan, report)
end

for _, part in ipairs { { "office", office }, { "wall", wall }, { "lamps", lamps } } do
  if wanted(part[1]) then part[2]() end
end
