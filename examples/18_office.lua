-- Three lamps of a catalogue in one office: how many of each it takes for 500 lx, what they draw, how even their light is.
--
--     ylm run examples/18_office.lua [--out DIR] [--width N] [--samples N] [--paths N]
--
-- Writes the lamps as panel.ies, linear.ldt and downlight.ies with their curves, reads them, and leaves office.png: the curves,
-- the office under each, and the illuminance of the desks' plane. The table's figures are by paths, all bounces included: the
-- mean and the least of a grid of places on the plane, 0.5 m from the walls. Metres, degrees, lm, cd and lx; y is up.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 300, samples = 16, paths = 1024 }

local WIDE, DEEP, HIGH, DESK = 7.2, 4.8, 2.8, 0.75 -- the room and the plane of the desks
local WANTED = 500                                  -- lx
local NX, NZ = 13, 9                                -- places of the plane

-- The lamps --------------------------------------------------------------------------------------

--- A lobe about an angle to the axis.
local function lobe(gamma, middle, width) return math.exp(-((gamma - middle) / width) ^ 2) end

local catalogue = {
  { file = "panel.ies", name = "Panel 600", lumens = 3600, watts = 30, opening = { shape = "rectangle", size = { 0.6, 0.6 } },
    intensity = function(g) return g < math.pi / 2 and math.cos(g) ^ 1.4 or 0 end },
  { file = "linear.ldt", name = "Linear 1200", lumens = 5200, watts = 38, opening = { shape = "rectangle", size = { 0.08, 1.2 } },
    intensity = function(g, c)
      if g > math.pi / 2 then return 0.25 * math.sin(2 * (g - math.pi / 2)) end
      return math.cos(g) * (0.9 + 1.5 * math.cos(c) ^ 2 * lobe(g, 0.75, 0.35))
    end },
  { file = "downlight.ies", name = "Downlight 60", lumens = 2000, watts = 17, opening = { shape = "disk", radius = 0.08 },
    intensity = function(g) return g < math.pi / 2 and lobe(g, 0, 0.62) * math.cos(g) or 0 end },
}

--- The lamp of a file that is written for this example.
local function photometry(entry)
  local made = ylm.photometry { intensity = entry.intensity, lumens = entry.lumens, watts = entry.watts, opening = entry.opening,
    text = { luminaire = entry.name, LUMINAIRE = entry.name } }
  assert(made:save(option.out .. entry.file))
  return assert(ylm.load(option.out .. entry.file))
end

-- The office -------------------------------------------------------------------------------------

local floor, wall, ceiling = ylm.matte { albedo = 0.2 }, ylm.matte { albedo = 0.5 }, ylm.matte { albedo = 0.7 }
local wood = ylm.matte { albedo = { 0.45, 0.33, 0.22 } }

local function quad(corner, u, v, material) return ylm.quad { corner = corner, u = u, v = v, material = material } end

local room = {
  quad({ 0, 0, DEEP }, { WIDE, 0, 0 }, { 0, 0, -DEEP }, floor), quad({ 0, HIGH, 0 }, { WIDE, 0, 0 }, { 0, 0, DEEP }, ceiling),
  quad({ 0, 0, 0 }, { WIDE, 0, 0 }, { 0, HIGH, 0 }, wall), quad({ WIDE, 0, DEEP }, { -WIDE, 0, 0 }, { 0, HIGH, 0 }, wall),
  quad({ 0, 0, DEEP }, { 0, 0, -DEEP }, { 0, HIGH, 0 }, wall), quad({ WIDE, 0, 0 }, { 0, 0, DEEP }, { 0, HIGH, 0 }, wall),
}
for _, x in ipairs { 1.8, 3.6, 5.4 } do
  for _, z in ipairs { 1.5, 3.3 } do
    room[#room + 1] = ylm.box { bounds = { { x - 0.8, 0.7, z - 0.4 }, { x + 0.8, 0.73, z + 0.4 } }, material = wood }
  end
end

local camera = ylm.camera { from = { 0.3, 1.7, DEEP - 0.2 }, at = { 4.4, 1, 1.4 }, fov = 75 }

--- Columns and rows of n lamps, as square as the room is; nil where a row would be more than twice as dense as a column.
local function layout(n)
  local best, columns = math.log(2), nil
  for c = 1, n do
    if n % c == 0 then
      local ratio = math.abs(math.log(WIDE / c / (DEEP / (n / c))))
      if ratio < best then best, columns = ratio, c end
    end
  end
  return columns, columns and n / columns
end

local function office(lamp, n)
  local columns, rows = layout(n)
  local lights = {}
  for i = 1, columns do
    for k = 1, rows do
      lights[#lights + 1] = ylm.photometric_light { photometry = lamp, temperature = 5000,
        at = { WIDE * (i - 0.5) / columns, HIGH - 0.06, DEEP * (k - 0.5) / rows } }
    end
  end
  return ylm.scene "office" { camera = camera, geometry = room, lights = lights }
end

-- Its light --------------------------------------------------------------------------------------

local points, normals = {}, {}
for k = 1, NZ do
  for i = 1, NX do
    points[#points + 1] = { 0.5 + (WIDE - 1) * (i - 1) / (NX - 1), DESK, 0.5 + (DEEP - 1) * (k - 1) / (NZ - 1) }
    normals[#normals + 1] = { 0, 1, 0 }
  end
end

--- Illuminances of the plane [NZ][NX], their mean, the least over the mean.
local function illuminances(scene, samples)
  local E = assert(scene:probe { points = points, normals = normals, samples = samples, seed = 1 })
  local lx = (E * { 0.2126, 0.7152, 0.0722 }):sum(2)
  local least, mean = lx:min(), lx:mean()
  return ylm.array(lx:totable(), "float"):reshape { NZ, NX }, mean, least / mean
end

--- The fewest lamps for the mean that is wanted: about so many by one lamp's share, then by trial.
local function fewest(lamp)
  local _, mean = illuminances(office(lamp, 6), option.paths / 4)
  local n = math.max(1, math.floor(6 * WANTED / mean))
  while not layout(n) or select(2, illuminances(office(lamp, n), option.paths / 4)) < WANTED do n = n + 1 end
  return n
end

local row = common.table { { "lamp", "%-14s" }, { "lamps", "%5d" }, { "lm", "%7.0f" }, { "W", "%5.0f" }, { "W/m2", "%5.1f" },
  { "mean lx", "%7.0f" }, { "U0", "%5.2f" }, { "W/m2 for 100 lx", "%15.2f" } }

--- The polar curve as an image, by way of a file; nil without VTK.
local function curve(lamp, entry)
  local path = option.out .. entry.file:gsub("%.%w+$", ".png")
  local plot = lamp:plot { title = entry.name, size = { option.width, option.width }, background = "dark" }
  return plot:save(path) and assert(ylm.load(path)) or nil
end

local curves, pictures, maps = {}, {}, {}
for i, entry in ipairs(catalogue) do
  local lamp = photometry(entry)
  local n = fewest(lamp)
  local scene = office(lamp, n)
  local map, mean, uniformity = illuminances(scene, option.paths)
  local watts = n * lamp.watts
  local each = watts / (WIDE * DEEP)
  row { entry.name, n, n * lamp.lumens, watts, each, mean, uniformity, each / mean * 100 }
  curves[i] = { image = curve(lamp, entry), caption = ("%s: %.0f lm, %.0f W"):format(entry.file, lamp.lumens, lamp.watts) }
  pictures[i] = { image = assert(scene:render { size = { option.width, math.floor(option.width * 0.7) }, samples = option.samples,
    light_samples = 32, seed = 1 }), tone = "hable", exposure = -6.2, caption = ("%d lamps"):format(n) }
  maps[i] = { values = map, caption = ("%.0f lx, U0 %.2f, %.0f W"):format(mean, uniformity, watts) }
end

if curves[1].image then
  common.save(ylm.figure { title = "An office by three lamps, for " .. WANTED .. " lx", rows = { curves, pictures, maps },
    bar = { range = { 0, 900 }, map = "viridis", label = "illuminance of the desks' plane, lx" },
    caption = "Intensities in cd per 1000 lm. Illuminances by paths with all bounces, 0.5 m from the walls." },
    option.out .. "office.png")
end
