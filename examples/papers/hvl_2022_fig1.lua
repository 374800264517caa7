-- Mezieres & Paulin 2022 (harmonics virtual lights), Fig. 1: an object of several materials in an atrium, by harmonics and by
-- points.
--
--     lua examples/papers/hvl_2022_fig1.lua [--width 360] [--lights 400] [--samples 256] [--mesh FILE] [--scene FILE]
--         [--out out] [--quick]
--
-- Writes hvl_2022_fig1.png. A knot stands in for the dragon, --mesh names another. GGX and matte stand-ins take the place of
-- materials 2, 6, 11 and 18 of Appendix C in the atrium, and of 12 on the object: no file of MERL or RGL is read. One bounce and
-- direct light; as in the paper virtual lights have no shadows, and paths have.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { width = 360, lights = 400, samples = 256, mesh = "", scene = "", out = "out", quick = false }
local quick = option.quick
local width = quick and 16 or option.width
local size = { width, math.floor(0.75 * width) }
ylm.on_warning(false)

local coat = ylm.ggx { alpha = 0.25, f0 = 0.05, base = { 0.5, 0.06, 0.05 } } -- for red phenolic
if option.mesh ~= "" then rooms.no_scene(option.scene, "--mesh stands in the atrium: give one of both") end
local scene = option.scene ~= "" and rooms.given(option.scene) or rooms.atrium {
  detail = quick and 0.3 or 1,
  stone = ylm.ggx { alpha = 0.5, f0 = 0.05, base = { 0.66, 0.58, 0.46 } }, -- for alumina oxide
  floor = ylm.ggx { alpha = 0.3, f0 = { 0.3, 0.25, 0.2 }, base = { 0.2, 0.17, 0.14 } }, -- for alum bronze
  cloths = { ylm.matte { albedo = { 0.05, 0.12, 0.42 } }, ylm.matte { albedo = { 0.5, 0.05, 0.06 } },
    ylm.matte { albedo = { 0.75, 0.73, 0.7 } } }, -- for the fabrics
  object = rooms.statue(option.mesh, { 0.4, 0, -0.3 }, 2.2, coat, function(m)
    return ylm.knot { p = 2, q = 3, at = { 0.4, 1.15, -0.3 }, scale = 0.85, tube = 0.2, rotate = { axis = { 0, 1, 0 },
      angle = 30 },
      divide = quick and { 40, 8 } or { 400, 40 }, material = m }
  end),
}
local view = assert(scene:prepare { size = size, samples = quick and 1 or 4 })
local function lights(profile)
  return rooms.placed(scene, quick and 36 or option.lights, { radius = "angle", profile = profile })
end
local caps = lights "cap"
local direct = assert(view:render {})
local truth = assert(scene:pathtrace { size = size, samples = quick and 16 or option.samples, reflections = { 2, 2 } })
local error_of = rooms.judge(direct, truth)

local row = common.table { { "method", "%-20s" }, { "lights", "%6d" }, { "ns a pair", "%9.1f" }, { "rms, %", "%7.1f" } }
local items = {}
for _, m in ipairs { { "harmonics, 5 bands", { virtual = { lmax = 4 } } }, { "points", { rival = { "vpl", clamp = "none" } } },
  { "points, clamped", { rival = { "vpl" } } } } do
  local o = m[2]
  o.bounced, o.layers = caps, false
  local image, ns = rooms.gather(view, o)
  local e = 100 * error_of(image)
  row { m[1], caps.count, ns, e }
  items[#items + 1] = { image = rooms.sum(direct, image), tone = "hable", exposure = 1.2, caption = ("%s: %.0f %%"):format(m[1],
    e) }
end
print "Materials: stand-ins by GGX, no file of MERL or RGL was read. The paper shows pictures and no errors: none stand beside."
print "rms: of the bounce, relative to its mean. Harmonics cost no more for tables than for formulas; points evaluate each"
print "material. Why: points have spikes beside columns; both pass walls, into galleries that paths leave dark."
if not quick then
  items[4] = { image = rooms.sum(direct, truth), tone = "hable", exposure = 1.2,
    caption = ("paths, %d a pixel"):format(option.samples) }
  common.save(ylm.figure { title = ("%s by %d virtual lights"):format(
    option.scene == "" and "An atrium" or option.scene, caps.count), rows = { { items[1], items[2] },
    { items[3],
    items[4] } }, caption = "After Fig. 1 of Mezieres & Paulin 2022, other rooms and stand-ins for materials." },
    option.out .. "hvl_2022_fig1.png")
end
