-- Materials as lobes and slices: GGX of three roughnesses, a published fit, and what degree they need.
--
--     ylm run examples/09_materials.lua [--out out]
--
-- Writes material_lobes.png, material_slices.png and material_degrees.png.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")

local out = common.options({ out = "out" }).out

local materials = {
  { "ggx, alpha 0.5", ylm.ggx { alpha = 0.5, f0 = { 1, 0.78, 0.34 } }, { 0.85, 0.62, 0.20 } },
  { "ggx, alpha 0.25", ylm.ggx { alpha = 0.25, f0 = { 1, 0.78, 0.34 } }, { 0.80, 0.35, 0.15 } },
  { "ggx, alpha 0.12 and 0.5", ylm.ggx { alpha = { 0.12, 0.5 }, f0 = 0.9 }, { 0.25, 0.50, 0.75 } },
  { "ABC fit, as printed", ylm.abc { fit = "gold-metallic-paint" }, { 0.45, 0.30, 0.60 } },
}

--- A lobe moved in x, and a plate under it.
local function placed(mesh, x, colour)
  local moved = ylm.mesh { vertices = mesh:vertices() + { x, 0, 0 }, triangles = mesh:triangles(), normals = mesh:normals() }
  return { moved, colour = colour }
end

local pictures, angles = {}, { 0, 45, 75 }
for _, row in ipairs(materials) do
  local items = {}
  for _, angle in ipairs(angles) do
    local wo = math.rad(angle)
    local plate = ylm.quad { corner = { -1.1, -0.7, 0 }, u = { 2.2, 0, 0 }, v = { 0, 1.4, 0 }, divide = 2 }
    local arrow = ylm.box { at = { 0.6 * math.sin(wo), 0, 0.6 * math.cos(wo) }, scale = { 0.02, 0.02, 1.2 },
      rotate = { axis = { 0, 1, 0 }, angle = angle } }
    items[#items + 1] = { image = ylm.view { meshes = { { plate, colour = 0.82 }, { arrow, colour = 0.15 },
      placed(row[2]:lobe { angle = angle }, 0, row[3]) }, background = "white", size = { 420, 330 }, frame = false,
      camera = ylm.camera { from = { 0.6, -4.4, 1.7 }, at = { 0, 0, 0.45 }, up = { 0, 0, 1 }, fov = 30 } },
      caption = ("%s, seen from %d°"):format(row[1], angle) }
  end
  pictures[#pictures + 1] = items
end
common.save(ylm.figure { rows = pictures, title = "Lobes f cos, each scaled to its largest value", caption = "The bar points "
  .. "to the eye. The fit is that of gold-metallic-paint (Loew et al. 2012); its absolute scale is open by a factor of π." },
  out .. "material_lobes.png")

-- Slices in the plane of incidence: polar, distance from the origin is f cos.
local series = {}
for _, row in ipairs(materials) do
  local at, values = row[2]:slice { angle = 45, count = 721 }
  local x, y = {}, {}
  for i = 1, #at do
    x[i], y[i] = values:get(i, 2) * math.sin(math.rad(at[i])), values:get(i, 2) * math.cos(math.rad(at[i]))
  end
  local c = row[3]
  series[#series + 1] = { x = x, y = y, label = row[1], colour = c, marker = "none", width = 2 }
end
common.save(ylm.plot { series = series, title = "Slices in the plane of incidence, seen from 45 degrees on the right",
  x_label = "f cos, sr⁻¹", y_label = "f cos, sr⁻¹", legend = "top right", size = { 1100, 760 },
  x_range = { -1.6, 0.5 }, y_range = { 0, 1.25 } }, out .. "material_slices.png")

-- The degree that 10 % of a slice's norm needs.
series = {}
for i, alpha in ipairs { 1, 0.5, 0.35, 0.25, 0.18 } do
  local degrees, x, y = ylm.ggx { alpha = alpha, f0 = 1 }:degrees { error = 0.1, most = 60 }, {}, {}
  for k, l in ipairs(degrees) do
    if l < math.huge then x[#x + 1], y[#y + 1] = 5 * (k - 1), l end
  end
  series[i] = { x = x, y = y, label = ("alpha %g"):format(alpha), marker = "circle" }
end
common.save(ylm.plot { series = series, title = "lmax at which a slice of GGX misses 10 % of its norm",
  x_label = "view, degrees from the normal", y_label = "lmax" }, out .. "material_degrees.png")
