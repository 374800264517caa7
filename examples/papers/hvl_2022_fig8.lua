-- Mezieres & Paulin 2022 (harmonics virtual lights), Fig. 8: how 400 and 100 lights cover what the lamp shines on, by the rule of
-- their radius: 0.25 for all, r1 (Eq. 23), r2 (Eqs. 24-26), and two of ylm's, by footprint and by density.
--
--     lua examples/papers/hvl_2022_fig8.lua [--width 200] [--scene FILE] [--out out] [--quick]
--
-- Writes hvl_2022_fig8.png. A Cornell box of 2 m stands in for the paper's room; the scene needs a spot_light. "times" is the
-- area of all discs over that of the texels they stand for; "uncovered" the part of the lit pixels in no disc, "overlap" the
-- discs over a lit pixel in the mean. A disc covers points within its radius whose normal is within 60 degrees of its own.
-- Factors (k) are 1.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { width = 200, scene = "", out = "out", quick = false }
local quick = option.quick
local width = quick and 32 or option.width
local size = { width, width }
ylm.on_warning(false)

local scene = rooms.given(option.scene, "cornell", { lamp = "spot" })
local view = assert(scene:prepare { size = size, samples = 1 })
local direct = assert(view:render {})
local pixels = size[1] * size[2]
local function flat(layer) return ylm.array(direct:layer(layer):reshape { pixels, 3 }, "double") end
local lit = flat "radiance":sum(2):greater(0)
local position, normal = flat "position", flat "normal"

--- Discs over each lit pixel as a picture, the uncovered part of them, and the mean overlap.
local function coverage(at, n, radius)
  local over = ylm.zeros { pixels }
  for i = 1, #at do
    over = over + ((position - at[i]) ^ 2):sum(2):less(radius[i] ^ 2) * (normal * n[i]):sum(2):greater(0.5)
  end
  local function column(a) return a:reshape { pixels, 1 } end
  local t = column(((over - 1) / 9):clamp(0, 1))
  local bare, dark = column(over:equal(0)), column(1 - lit)
  local map = ylm.array { 0.88, 0.93, 0.98 } - t * { 0.85, 0.75, 0.5 }
  map = map * (1 - bare) + bare * { 0.85, 0.2, 0.1 }
  map = map * (1 - dark) + dark * { 0.1, 0.1, 0.1 }
  return map:reshape { size[2], size[1], 3 }, 100 * (lit * over:equal(0)):sum() / lit:sum(), (lit * over):sum() / lit:sum()
end

local row = common.table { { "radius", "%-16s" }, { "lights", "%6d" }, { "median", "%6.3f" }, { "largest", "%7.3f" }, { "times",
  "%6.2f" },
  { "uncovered, %", "%12.1f" }, { "overlap", "%7.2f" } }
local rows = {}
for i, count in ipairs { 400, 100 } do
  local at, facing
  local function radii(rule)
    local lights = assert(scene:virtual_lights { distribution = "grid", count = count, radius = rule,
      scale = type(rule) == "string" and 1 or nil })
    local radius
    at, facing, radius = lights:arrays()
    return radius
  end
  local footprint = radii "footprint"
  rows[i] = {}
  for _, rule in ipairs { { "0.25", radii(0.25) }, { "r1, Eq. 23", radii "neighbours" }, { "r2, Eq. 26", radii "angle" },
    { "footprint", footprint }, { "density", radii "density" } } do
    local map, bare, overlap = coverage(at, facing, rule[2])
    local sorted = rule[2]:totable()
    table.sort(sorted)
    row { rule[1], #at, sorted[math.ceil(#sorted / 2)], sorted[#sorted], (rule[2] ^ 2):sum() / (footprint ^ 2):sum(), bare,
      overlap }
    rows[i][#rows[i] + 1] = { image = map, caption = ("%s: %.0f %% bare, %.1f over"):format(rule[1], bare, overlap) }
  end
end
print(("%d lit pixels. Sets of equal numbers of lights stand at the same places."):format(lit:sum()))
print "r1 and r2 cover the same surface several times over, and more where the light falls askew; footprint once, by"
print "construction, with some bare corners of texels: its default factor is 1.5. A fixed radius suits one number of lights."
if not quick then
  common.save(ylm.figure { title = "What discs of virtual lights cover, by the rule of their radius", rows = rows,
    caption = "Above 400 lights, below 100, factors 1. Grey: not lit by the lamp; red: bare; light to dark blue: 1 to 10 discs. "
      .. "After Mezieres & Paulin 2022, Fig. 8." },
    option.out .. "hvl_2022_fig8.png")
end
