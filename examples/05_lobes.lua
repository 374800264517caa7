-- Spherical harmonics as lobes: a light function, its projections, a window, a rotation, a product
-- (Figs. 5-10 of Green 2003, "Spherical Harmonic Lighting: The Gritty Details").
--
--     lua examples/05_lobes.lua [--out DIR] [--width N] [--samples N]
--
-- Writes lobes_bands.png (Fig. 5), lobes_projection.png (Figs. 6-8), lobes_rotation.png and lobes_product.png
-- (Fig. 10), and prints what they show and the matrix of Fig. 9. Orange is positive, blue negative.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")

local option = common.options { out = "out", width = 1280, samples = 100000 }
local out = option.out

--- Pictures need VTK; without it the numbers are printed all the same.
local function save(vectors, labels, title, name, height)
  local size = { option.width, math.floor((height or 480) * option.width / 1280) }
  common.save(ylm.view { sh = ylm.stack(vectors), labels = labels, title = title, size = size, direction = { 0, -1, 0.1 } },
    out .. name)
end

-- Fig. 5: the first five bands, a band to a row: 45 places, those beyond a band empty.
local bands, names = {}, {}
for l = 0, 4 do
  for m = -4, 4 do
    local c = ylm.zeros { 25 }
    if math.abs(m) <= l then c:set(ylm.sh.index(l, m), 1) end
    bands[#bands + 1] = c
    names[#names + 1] = math.abs(m) <= l and ("%d, %d"):format(l, m) or ""
  end
end
save(bands, names, "The first five bands, each Y(l, m)", "lobes_bands.png", 800)

-- Two lights at right angles to each other: Green's example, with the "-3" inside.
local function light(x, y, z)
  local theta = math.acos(math.max(-1, math.min(1, z)))
  local phi = (math.atan2 or math.atan)(y, x)
  return math.max(0, 5 * math.cos(theta) - 4) + math.max(0, -4 * math.sin(theta - math.pi) * math.cos(phi - 2.5) - 3)
end

-- Fig. 7: the light itself, nearly; Figs. 6, 8: projections of more and more bands, and the window against ringing.
local c, report = ylm.sh.project(5, light, { samples = option.samples })
print(("two lights, projected by quadrature (error %.1e):"):format(report.error))
print((ylm.sh.summary(c)))
local WHOLE = 30
local vectors, labels = { (ylm.sh.project(WHOLE, light, { samples = option.samples })) }, { "the light" }
for lmax = 0, 5 do
  vectors[#vectors + 1] = ylm.sh.resize(ylm.sh.resize(c, lmax), WHOLE)
  labels[#labels + 1] = lmax == 0 and "1 band" or lmax + 1 .. " bands"
end
vectors[#vectors + 1] = ylm.sh.resize(ylm.sh.window(c, "hann"), WHOLE)
labels[#labels + 1] = "Hann window"
save(vectors, labels, "Two lights", "lobes_projection.png")

local _, cost = ylm.sh.dering(c, { minimum = -0.02 })
print(("deringing to -0.02: minimum %.3f before, contrast lost %.0f %%"):format(cost.before.minimum,
  100 * cost.contrast_lost))

-- Rotation: the same function turned about y.
vectors, labels = {}, {}
for degrees = 0, 180, 30 do
  vectors[#vectors + 1] = ylm.sh.rotate(c, { axis = { 0, 1, 0 }, angle = math.rad(degrees) })
  labels[#labels + 1] = degrees .. " degrees"
end
save(vectors, labels, "Turned about y", "lobes_rotation.png")

-- Figs. 9, 10: a mask that is Y(2,2), the matrix of its products, and what it makes of the light.
local mask = { 0, 0, 0, 0, 0, 0, 0, 0, 1 }
local M = ylm.sh.product_matrix(mask, 4)
print "entries of the matrix of products with Y(2,2) that are not zero (Fig. 9):"
for i = 1, 25 do
  local row = {}
  for j = 1, 25 do row[j] = math.abs(M:get(i, j)) > 1e-12 and "#" or "." end
  print("  " .. table.concat(row))
end
local four = ylm.sh.resize(c, 4)
save({ four, ylm.sh.resize(mask, 4), ylm.sh.apply(M, four) },
  { "light", "Y(2,2)", "product" }, "A light behind a mask", "lobes_product.png")
