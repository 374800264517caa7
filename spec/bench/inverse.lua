-- Derivatives by lamps and inverse lighting: errors, rays, links that are read; evaluations and seconds until an office is met.
--
--     make bench BENCH=inverse
--     build/ylm run spec/bench/inverse.lua [derivatives | levels | office | letter | lightmap]
--
-- The office is spec/support/office.lua: 12 x 8 m, desks, cupboards, partitions, twenty lamps. "off" is the error of the
-- derivative of the mean illuminance by one lamp's place over its norm, against central differences of 4 cm at 400 rays. "read"
-- is the links that value and derivatives read over those of the value. "cpu" is processor time of all threads; seconds are of
-- the clock. The letter is a Y of 900 lx on 250 lx of the desks' plane, by places, levels and directions of 20 narrow lamps; the
-- lightmap is the light of 20 lamps that others, elsewhere and of other levels, are to send again.

local ylm = require "ylm"
local office = require "spec.support.office"

local what = arg and arg[1]
local lights = office.lamps(ylm)

local function derivatives()
  local t = office.scene(ylm, lights):links { spacing = 1, rays = 64, lmax = 0 }
  local desk = t:receivers { plane = office.desk }
  local function mean(list, samples, rim)
    local lit = t:radiosity(list, { derivatives = true, light_samples = samples, rim = rim })
    return lit, lit:importance { { desk, weights = desk.weights } }
  end
  local truth = {}
  for _, k in ipairs { 6, 10, 15 } do
    truth[k] = {}
    for a = 1, 3 do
      local function at(h)
        local p = { lights[k].at[1], lights[k].at[2], lights[k].at[3] }
        p[a] = p[a] + h
        local l = ylm.photometric_light { photometry = lights[k].photometry, at = p, opening = lights[k].opening }
        return select(2, mean({ l }, 400, 0)).value
      end
      truth[k][a] = (at(0.04) - at(-0.04)) / 0.08
    end
  end
  print "derivatives: rays, rim, off of lamps 6, 10, 15 (%), rays over those of the value, read"
  for _, n in ipairs { { 16, 8 }, { 16, 16 }, { 64, 64 } } do
    local lit, importance = mean(lights, n[1], n[2])
    local d, off = importance:derivatives(), {}
    for _, k in ipairs { 6, 10, 15 } do
      local square, error = 0, 0
      for a = 1, 3 do
        square, error = square + truth[k][a] ^ 2, error + (truth[k][a] - d.position:get(k, a)) ^ 2
      end
      off[#off + 1] = ("%5.1f"):format(100 * (error / square) ^ 0.5)
    end
    local s = lit.stats
    local forward = s.bounces * t.stats.elements * t.stats.links + desk.count * 256
    print(("  %3d %3d  %s  %.3f  %.2f"):format(n[1], n[2], table.concat(off, " "), s.rays / (s.rays - s.rim_rays),
      (forward + importance.link_reads) / forward))
  end
end

local function plan(name, scene, vary)
  local cpu = os.clock()
  local _, r = assert(scene:inverse_lighting { vary = vary,
    targets = { { plane = office.desk, mean = { least = 500 }, uniformity = 0.6 } } })
  local t = r.targets[1]
  print(("  %-7s %5s %4d %7.1f %7.1f  %6.1f %.3f  %6.1f %.3f  %.3f  %5.1f %5.1f"):format(name, tostring(r.met), r.evaluations,
    r.seconds, os.clock() - cpu, t.before.mean, t.before.uniformity, t.mean, t.uniformity, t.noise,
    r.lumens_before / 1000, r.lumens / 1000))
  io.stdout:flush()
end

if not what or what == "derivatives" then derivatives() end
if not what or what == "levels" or what == "office" then
  print "plans: met, evaluations, seconds, cpu; lx and U0 before by links, after by paths; noise of a place; klm before, after"
end
if not what or what == "levels" then
  plan("levels", office.scene(ylm, office.lamps(ylm, { dim = 0.8 })), { { dim = { 0, 1.5 } } })
end
if not what or what == "office" then
  local crowded = office.lamps(ylm, { box = { -5.5, 0.5, -3.5, 3.5 }, opening = { shape = "sphere", radius = 0.1 }, height = 2.8,
    dim = 0.8 })
  plan("office", office.scene(ylm, crowded), { { lights = "panel", position = { "x", "z" }, dim = { 0, 1.5 },
    within = { { -5.7, 0, -3.7 }, { 5.7, 3, 3.7 } } } })
end

--- The distance from (x, y) to the segment from a to b.
local function far(x, y, a, b)
  local dx, dy = b[1] - a[1], b[2] - a[2]
  local t = math.max(0, math.min(1, ((x - a[1]) * dx + (y - a[2]) * dy) / (dx * dx + dy * dy)))
  return ((x - a[1] - t * dx) ^ 2 + (y - a[2] - t * dy) ^ 2) ^ 0.5
end

--- The letter on 11 x 7 m, its edges 0.3 m wide, as rows from the top.
local function letter()
  local rows, middle = {}, { 0, 0.3 }
  for r = 1, 36 do
    rows[r] = {}
    for c = 1, 56 do
      local x, y = 11 * (c - 0.5) / 56 - 5.5, 7 * (r - 0.5) / 36 - 3.5
      local d = math.min(far(x, y, middle, { 0, 3 }), far(x, y, middle, { -3.2, -2.8 }), far(x, y, middle, { 3.2, -2.8 }))
      rows[r][c] = 250 + 650 / (1 + math.exp((d - 0.6) / 0.16))
    end
  end
  return rows
end

local BOX = { { -5.7, 0, -3.7 }, { 5.7, 3, 3.7 } }

--- Searches for the shape of light on the desks, and prints its course.
local function shape(name, scene, o)
  local cpu = os.clock()
  o.price, o.evaluations = "none", 35
  local found, r = assert(scene:inverse_lighting(o))
  local row, least = { ("  %-8s"):format(name) }, math.huge
  for k, entry in ipairs(found.trace) do
    least = math.min(least, entry.targets[1].rms)
    if k == 1 or k == 10 or k == 20 or k == 32 or k == 35 then row[#row + 1] = ("%.4f"):format(least) end
  end
  print(("%s  %.4f  %5.1f"):format(table.concat(row, " "), r.targets[1].rms, os.clock() - cpu))
end

if not what or what == "letter" or what == "lightmap" then
  print "shapes: the least rms of what is wanted until evaluation 1, 10, 20, 32, 35 by links, that of the end by paths; cpu"
end
if not what or what == "letter" then
  local narrow = office.lamps(ylm, { photometry = ylm.photometry { cosine = 2, lumens = 3600 }, height = 2.8, dim = 0.8,
    opening = { shape = "disk", radius = 0.1 } })
  shape("letter", office.scene(ylm, narrow), { judge = 1024, spacing = 1, receiver_rays = 256, receiver_samples = 32,
    vary = { { position = { "x", "z" }, within = BOX, dim = { 0, 3 }, direction = 70 } },
    targets = { { plane = office.desk, image = letter() } } })
end
if not what or what == "lightmap" then
  local known = office.lamps(ylm, { opening = { shape = "sphere", radius = 0.1 }, height = 2.8 })
  local others, state = {}, 7
  local function random()
    state = state * 16807 % 2147483647
    return state / 2147483647
  end
  for k, l in ipairs(known) do
    local dim, x, z = 0.7 + 0.6 * random(), 1.2 * (random() - 0.5), 1.2 * (random() - 0.5)
    others[k] = ylm.photometric_light { photometry = l.photometry, opening = l.opening, dim = dim,
      at = { math.max(-5.7, math.min(5.7, l.at[1] + x)), 2.8, math.max(-3.7, math.min(3.7, l.at[3] + z)) } }
  end
  local scene = office.scene(ylm, others)
  local links = scene:links { spacing = 1, rays = 64, lmax = 0 }
  local desk = links:receivers { plane = office.desk, rays = 256, light_samples = 32 }
  shape("lightmap", scene, { links = links, judge = 1024, vary = { { position = { "x", "z" }, within = BOX, dim = { 0, 2 } } },
    targets = { { receivers = desk, wanted = desk:illuminance(links:radiosity(known, { derivatives = true })) } } })
end
