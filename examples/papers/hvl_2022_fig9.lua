-- Mezieres & Paulin 2022 (harmonics virtual lights), Fig. 9: two rooms whose materials change, and the time does not.
--
--     lua examples/papers/hvl_2022_fig9.lua [--width 240] [--lights 400] [--bands 5] [--scene FILE] [--out out] [--quick]
--
-- Writes hvl_2022_fig9.png. The atrium stands in for Sponza, the room with a table for the breakfast room; three sets of
-- materials each: matte ones, which need irradiance alone, and two of GGX, of which the paper's Sec. 4.2 makes tables.
-- --scene takes geometry and lamps of a file in place of both rooms, and gives its meshes these materials in turn.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { width = 240, lights = 400, bands = 5, scene = "", out = "out", quick = false }
local quick = option.quick
local width, bands = quick and 16 or option.width, quick and 3 or option.bands
local size = { width, math.floor(0.7 * width) }
ylm.on_warning(false)

local function coat(alpha, f0, base) return ylm.ggx { alpha = alpha, f0 = f0, base = base } end
local function matte(r, g, b) return ylm.matte { albedo = { r, g, b } } end

local sets = {
  { "matte", {}, { table = matte(0.38, 0.2, 0.1), chairs = matte(0.3, 0.16, 0.08), things = matte(0.1, 0.2, 0.45) } },
  { "plastics", { stone = coat(0.3, 0.05, { 0.5, 0.4, 0.3 }), floor = coat(0.25, 0.06, { 0.2, 0.2, 0.24 }),
    wall = coat(0.5, 0.04, { 0.6, 0.56, 0.5 }), cloths = { coat(0.6, 0.04, { 0.5, 0.05, 0.04 }), coat(0.6, 0.04, { 0.05, 0.3,
      0.08 }),
      coat(0.6, 0.04, { 0.05, 0.1, 0.4 }) } },
    { table = coat(0.2, 0.05, { 0.35, 0.04, 0.03 }), chairs = coat(0.3, 0.05, { 0.04, 0.2, 0.3 }), floor = coat(0.3, 0.05, { 0.3,
      0.2, 0.12 }),
      wall = coat(0.5, 0.04, { 0.6, 0.58, 0.5 }), things = coat(0.25, 0.05, { 0.5, 0.45, 0.35 }), frame = coat(0.4, 0.05, { 0.4,
        0.1, 0.08 }) } },
  { "metals", { stone = coat(0.35, { 0.9, 0.68, 0.32 }, 0), floor = coat(0.3, { 0.5, 0.5, 0.52 }, 0.05),
    wall = coat(0.45, { 0.7, 0.62, 0.5 }, 0.1), cloths = { coat(0.4, { 0.8, 0.2, 0.12 }, 0.02), coat(0.4, { 0.3, 0.7, 0.4 },
      0.02),
      coat(0.4, { 0.3, 0.4, 0.8 }, 0.02) } },
    { table = coat(0.3, { 0.95, 0.7, 0.35 }, 0), chairs = coat(0.35, { 0.6, 0.6, 0.62 }, 0.02), floor = coat(0.4, { 0.4, 0.3,
      0.25 }, 0.1),
      wall = coat(0.5, { 0.6, 0.58, 0.5 }, 0.15), things = coat(0.3, { 0.9, 0.4, 0.3 }, 0), frame = coat(0.4, { 0.5, 0.2, 0.15 },
        0.05) } },
}
local row = common.table { { "room", "%-11s" }, { "materials", "%-9s" }, { "lights", "%6d" }, { "ns a pair", "%9.1f" },
  { "beside plastics", "%15.2f" } }
local rows, ratios = {}, {}
local own = option.scene ~= ""
for k, room in ipairs(own and { "scene" } or { "table_room", not quick and "atrium" or nil }) do
  rows[k] = {}
  local cases = {}
  for i = quick and 2 or 1, 3 do
    local set = sets[i]
    local scene
    if own then
      local list, names = {}, {}
      for name in pairs(set[3]) do names[#names + 1] = name end
      table.sort(names)
      for _, name in ipairs(names) do list[#list + 1] = set[3][name] end
      scene = rooms.painted(option.scene, list)
    else
      scene = rooms[room](common.adding_to(set[4 - k]) { detail = quick and 0.3 or 1 })
    end
    cases[i] = { scene = scene, view = assert(scene:prepare { size = size, samples = quick and 1 or 4, gloss = "sh",
      lmax = bands - 1 }),
      lights = assert(scene:virtual_lights { count = quick and 40 or option.lights, particles = 4 * option.lights }),
        ns = math.huge }
  end
  for _ = 1, quick and 1 or 3 do -- in turns, so that what else the machine does meets all
    for _, c in pairs(cases) do
      local image, ns = rooms.gather(c.view, { bounced = c.lights, virtual = { lmax = bands - 1 } })
      c.image, c.ns = image, math.min(c.ns, ns)
    end
  end
  for i = quick and 2 or 1, 3 do
    local c = cases[i]
    row { room, sets[i][1], c.lights.count, c.ns, c.ns / cases[2].ns }
    if i == 3 then ratios[#ratios + 1] = ("%.2f"):format(c.ns / cases[2].ns) end
    local out, mean = rooms.sum(assert(c.view:render { layers = false }), c.image)
    rows[k][i] = { image = out, tone = "hable", exposure = math.log(0.35 / mean) / math.log(2),
      caption = ("%s, %.1f ns a pair"):format(
      sets[i][1], c.ns) }
  end
end
print(("metals beside plastics: %s times the time of the processor (the paper: no difference)"):format(table.concat(ratios,
  " and ")))
print "Materials: GGX of our own, no file of MERL or RGL was read."
print "Why: a table of a material is read once a point, whatever it holds. Matte surfaces need a sum for each band, not N^2 of"
print "them."
if not quick then
  common.save(ylm.figure { title = "Materials change, the time does not", rows = rows,
    caption = ("%d virtual lights, %d bands. After Fig. 9 of Mezieres & Paulin 2022; other rooms, GGX for measured materials.")
      :format(option.lights, bands) }, option.out .. "hvl_2022_fig9.png")
end
