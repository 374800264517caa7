-- Mezieres et al. 2022 (harmonics virtual lights), Sec. 4.2, 5.2, 7 and Appendix C: materials as tables of spherical harmonics,
-- their memory, their rows and how far a look-up is from the material.
--
--     lua examples/papers/hvl_2022_materials.lua [--merl DIR] [--rgl DIR] [--bands 10] [--out DIR] [--quick]
--
-- Writes hvl_2022_materials.png: the materials of Appendix C on spheres. --merl and --rgl name folders with the data sets' files
-- (docs/material_files.md). Without MERL's files its materials are ABC fits as printed (Loew et al. 2012): shapes of lobes are
-- theirs, the absolute scale is open by a factor of pi. RGL's materials have no published fits; without files they are left out.
--
-- The paper's table is full rows at each degree of elevation, the nearest of which is taken. "nearest" is its error, "ours" that
-- of cubics between our rows, both where it is largest, relative to the slice, for views to 84 degrees. "missed" is the part of
-- a slice's norm that the bands cut off, of views at 0, 45 and 75 degrees: what no table of so many bands can have.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")

local option = common.options { merl = "", rgl = "", bands = 10, scene = "", out = "out", quick = false }
rooms.no_scene(option.scene, "materials are shown on spheres: --merl and --rgl name folders of them")
local out, quick = option.out, option.quick
local bands = quick and 5 or option.bands
local lmax, count = bands - 1, bands * bands
local clock = require "ylm.c.core".seconds

local function view(degrees)
  local a = math.rad(degrees)
  return { math.sin(a), 0, math.cos(a) }
end

--- The path of a file where it is there.
local function find(folder, name)
  local path = folder ~= "" and ("%s/%s"):format(folder, name)
  local file = path and io.open(path, "rb")
  if file then file:close() end
  return file and path
end

--- Largest error of the nearest of 90 rows, at 1, 2, .. degrees, halfway between these; relative to the slice.
local function nearest(table_)
  local rows, halves = {}, {}
  for i = 0, 84 do rows[i + 1] = view(i) end
  for i = 0, 83 do halves[i + 1] = view(i + 0.5) end
  local at, truth = table_:slices(rows), table_:slices(halves)
  local norm, worst = (truth ^ 2):sum { axis = { 2, 3 } }, 0
  for k = 1, 2 do
    local d = ((at[{ k, k + 83 }] - truth) ^ 2):sum { axis = { 2, 3 } }
    worst = math.max(worst, (d / (norm + norm:equal(0))):sqrt():max())
  end
  return worst
end

-- Memory ------------------------------------------------------------------------------------

local full, parabolic = 90 * count * 3 * 4, 128 * 128 * count * 3 * 4
local grey = ylm.ggx { alpha = 0.35, f0 = 0.9, compensate = false }:table { lmax = lmax }
local three = ylm.ggx { alpha = 0.35, f0 = { 1, 0.78, 0.34 }, base = { 0.1, 0.05, 0.02 } }:table { lmax = lmax }
print(("memory, %d bands, RGB floats                            KB     paper    ratio"):format(bands))
local function memory(what, bytes, paper)
  print(("  %-44s %12.1f  %8s  %7s"):format(what, bytes / 1000, paper and ("%g"):format(paper) or "-",
    paper and ("%.4f"):format(bytes / 1000 / paper) or "-"))
end
memory("isotropic, 90 full rows (the paper's table)", full, bands == 10 and 108 or nil)
memory("isotropic, ours, grey metal", grey.bytes, bands == 10 and 108 or nil)
memory("isotropic, ours, three functions", three.bytes, bands == 10 and 108 or nil)
memory("anisotropic, 90 x 360 full rows", 360 * full, bands == 10 and 388000 or nil)
memory("anisotropic, parabolic map of 128 x 128", parabolic, bands == 10 and 20000 or nil)
if not quick then
  local t = ylm.ggx { alpha = { 0.35, 0.7 }, f0 = { 1, 0.78, 0.34 }, compensate = false }:table { lmax = lmax }
  memory(("anisotropic, ours, %d x %d, %d functions"):format(t.rows, t.columns, t.functions), t.bytes, 388000)
  print(("    its error between rows and columns %.4f, made in %.1f s"):format(t.error, t.seconds))
end
print "Why they differ: 90 x 360 rows of 10 bands are 360 times 108 KB, 38.9 MB; the paper prints 388, ten times too much. Its"
print "  20 MB for the map is right: it saves a half. Ours has fewer rows, cubics between them, m >= 0 alone where a material"
print "  is isotropic, and one or two functions where channels are mixtures of them."

-- Materials of Appendix C ----------------------------------------------------------------------

local merl = { "alum-bronze", "alumina-oxide", "aluminium", "beige-fabric", "blue-acrylic", "blue-fabric", "blue-rubber",
  "gold-metallic-paint", "gold-paint", "green-plastic", "red-fabric2", "red-phenolic", "red-specular-plastic",
  "silver-metallic-paint", "silver-metallic-paint2", "teflon", "two-layer-gold", "white-fabric", "white-marble", "white-paint",
  "yellow-phenolic" }
local rgl = { "acrylic_felt_green", "acrylic_felt_orange", "acrylic_felt_pink", "acrylic_felt_purple", "acrylic_felt_white",
  "cardboard", "cc_iris_purple_gem", "ilm_l3_37_metallic", "ilm_solo_m_68", "ilm_solo_millenium_falcon", "irid_flake_paint2",
  "paper_blue", "paper_red", "paper_yellow", "satin_gold", "vch_frozen_amethyst" }

local list, missing = {}, {}
for i, name in ipairs(merl) do
  local path = find(option.merl, name .. ".binary")
  if not quick or i % 8 == 0 then
    list[#list + 1] = { name, path and "MERL" or "ABC fit", path and ylm.merl { file = path } or ylm.abc { fit = name } }
  end
end
for _, name in ipairs(rgl) do
  local path = find(option.rgl, name .. "_rgb.bsdf")
  if path then list[#list + 1] = { name, "RGL", ylm.rgl { file = path } } else missing[#missing + 1] = name end
end

print(("\nAppendix C, tables of %d bands; the paper's 90 full rows take %.0f KB and know each degree"):format(bands,
  full / 1000))
local row = common.table { { "material", "%-24s" }, { "from", "%-7s" }, { "rows", "%4d" }, { "functions", "%9d" }, { "KB",
  "%6.1f" },
  { "ratio", "%5.2f" }, { "ours", "%7.4f" }, { "nearest of 90", "%13.4f" }, { "missed 0", "%8.3f" }, { "45", "%5.3f" },
  { "75", "%5.3f" }, { "seconds", "%7.2f" } }
local bytes, least, most = 0, math.huge, 0
for _, m in ipairs(list) do
  local start = clock()
  local t = assert(m[3]:table { lmax = lmax })
  local seconds = clock() - start
  local missed = t:missed(lmax, { view(0), view(45), view(75) })
  local rough = nearest(t)
  least, most, bytes = math.min(least, rough / t.error), math.max(most, rough / t.error), bytes + t.bytes
  row { m[1], m[2], t.rows, t.functions, t.bytes / 1000, t.bytes / full, t.error, rough, missed:get(1), missed:get(2),
    missed:get(3), seconds }
end
print(("%d materials: %.0f KB, full rows %.0f KB (ratio %.2f); the nearest of 90 rows is %.1f to %.0f times as far off"):format(
  #list,
  bytes / 1000, #list * full / 1000, bytes / #list / full, least, most))
if #missing > 0 then
  print(("left out, no file in --rgl and no published fit: %d of RGL's 16 (%s ..)"):format(#missing, missing[1]))
end
print "Why they differ: rows are doubled until a look-up halfway between them is within 0.002; cubics do that with 32 of them,"
print "  three degrees apart, where the nearest row has the error of half a degree. What bands cut off is larger than either for"
print "  all that shines: that is the paper's limit and ours, and the rings in the picture."

-- A picture, and what a change of materials costs -------------------------------------------------

local across, divide = math.min(#list, 7), quick and { 16, 8 } or { 160, 80 }
local geometry, down = {}, math.ceil(#list / across)
geometry[1] = ylm.quad { corner = { -12, 0, 12 }, u = { 24, 0, 0 }, v = { 0, 0, -40 }, material = ylm.matte { albedo = 0.35 } }
for i, m in ipairs(list) do
  local x, y = (i - 1) % across, math.floor((i - 1) / across)
  geometry[i + 1] = ylm.sphere { at = { 1.05 * (x - (across - 1) / 2), 0.46, 1.45 * (y - (down - 1) / 2) }, radius = 0.45,
    divide = divide, material = m[3] }
end
local scene = ylm.scene "materials" {
  camera = ylm.camera { from = { 0, 5.2, 8.2 }, at = { 0, 0.25, 0.12 }, fov = 25 }, geometry = geometry,
  lights = { ylm.sphere_light { at = { -4, 6, 4 }, radius = 1, radiance = 70 }, ylm.sphere_light { at = { 5, 5, -1 },
    radius = 0.8,
    radiance = { 60, 50, 40 } }, ylm.sphere_light { at = { 0, 6, -6 }, radius = 1, radiance = { 30, 38, 50 } } },
}
ylm.on_warning(false)
local o = { size = quick and { 32, 14 } or { 1120, 500 }, samples = quick and 1 or 16, lmax = lmax, visibility = "transfer",
  transfer_samples = quick and 16 or 128, gloss = "sh", occlusion_distance = 1.2 }
local prepared = assert(scene:prepare(o))
local picture, how = prepared:render { by = "sum" }
local plain = { geometry[1] }
for i = 2, #geometry do plain[i] = ylm.sphere { at = geometry[i].at, radius = 0.45, divide = divide, material = list[1][3] } end
local same = ylm.scene "one material" { camera = scene.camera, geometry = plain, lights = scene.lights }
local _, other = assert(same:prepare(o)):render { by = "sum" }
print(("\nFig. 9, materials change, the time does not: %d materials %.2f s, one %.2f s (ratio %.2f; the paper's 1)"):format(
  #list, how.seconds.light, other.seconds.light, how.seconds.light / other.seconds.light))
local m = picture:compare(picture, { mask = common.surface_mask(ylm, picture) })
common.save(ylm.figure { title = ("Materials of Appendix C, %d bands"):format(bands),
  rows = { { { image = picture, tone = "srgb", exposure = 1.2 - math.log(m.peak) / math.log(2) } } },
  caption = "By rows from the left: " .. (function()
    local names = {}
    for i, item in ipairs(list) do names[i] = item[1] end
    return table.concat(names, ", ")
  end)() .. (find(option.merl, "teflon.binary") and "." or ". ABC fits, as printed: not measured data.")
    .. " Rings are what the bands cut off; no window damps them." }, out .. "hvl_2022_materials.png")
