-- Spherical harmonics as lobes: a light function, its projections, a window, a rotation, a product
-- (Figs. 5-10 of Green 2003, "Spherical Harmonic Lighting: The Gritty Details").
--
--     lua examples/05_lobes.lua [folder for pictures]
--
-- Writes lobes_projection.png, lobes_rotation.png and lobes_product.png, and prints what they show.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")

local folder = common.folder(arg[1] or ".")

--- Pictures need VTK; without it the numbers are printed all the same.
local function save(vectors, labels, title, name)
  local ok, message = ylm.view { sh = vectors, labels = labels, title = title, size = { 1280, 480 } }:save(folder
    .. "/" .. name)
  print(ok and ("wrote " .. folder .. "/" .. name) or ("no picture: " .. tostring(message)))
end

-- Two lights at right angles to each other: Green's example, with the "-3" inside.
local function light(x, y, z)
  local theta = math.acos(math.max(-1, math.min(1, z)))
  local phi = (math.atan2 or math.atan)(y, x)
  return math.max(0, 5 * math.cos(theta) - 4) + math.max(0, -4 * math.sin(theta - math.pi) * math.cos(phi - 2.5) - 3)
end

-- Figs. 6-8: projections of more and more bands, and the window that takes the ringing away.
local c, report = ylm.sh.project(5, light, { samples = 100000 })
print(("two lights, projected by quadrature (error %.1e):"):format(report.error))
print((ylm.sh.summary(c)))
local vectors, labels = {}, {}
for lmax = 0, 5 do
  vectors[#vectors + 1] = ylm.sh.resize(ylm.sh.resize(c, lmax), 5):totable()
  labels[#labels + 1] = lmax + 1 .. " bands"
end
vectors[#vectors + 1] = ylm.sh.window(c, "hann"):totable()
labels[#labels + 1] = "Hann window"
save(vectors, labels, "Two lights", "lobes_projection.png")

local _, cost = ylm.sh.dering(c, { minimum = -0.02 })
print(("deringing to -0.02: minimum %.3f before, contrast lost %.0f %%"):format(cost.before.minimum,
  100 * cost.contrast_lost))

-- Rotation: the same function turned about y.
vectors, labels = {}, {}
for degrees = 0, 180, 30 do
  vectors[#vectors + 1] = ylm.sh.rotate(c, { axis = { 0, 1, 0 }, angle = math.rad(degrees) }):totable()
  labels[#labels + 1] = degrees .. " degrees"
end
save(vectors, labels, "Turned about y", "lobes_rotation.png")

-- Figs. 9, 10: a mask that is Y(2,2), its transfer matrix, and what it makes of the light.
local mask = { 0, 0, 0, 0, 0, 0, 0, 0, 1 }
local M = ylm.sh.transfer(mask, 4)
print "entries of the transfer matrix of Y(2,2) that are not zero (Fig. 9):"
for i = 1, 25 do
  local row = {}
  for j = 1, 25 do row[j] = math.abs(M:get(i, j)) > 1e-12 and "#" or "." end
  print("  " .. table.concat(row))
end
local four = ylm.sh.resize(c, 4)
save({ four:totable(), ylm.sh.resize(mask, 4):totable(), ylm.sh.transfer_apply(M, four):totable() },
  { "light", "Y(2,2)", "product" }, "A light behind a mask", "lobes_product.png")
