--- An office of 12 x 8 x 3 m: 12 desks, 4 cupboards, 3 partitions, and 20 lamps in its ceiling.
--
--     local office = require "spec.support.office"
--     local scene = office.scene(ylm, office.lamps(ylm))

local office = { desk = { at = { 0, 0.76, 0 }, size = { 11, 7 } } }

--- Boxes of { x0, x1, y0, y1, z0, z1 }.
local function furniture()
  local desks, cupboards, partitions = {}, {}, {}
  for _, x in ipairs { -4.2, -1.4, 1.4, 4.2 } do
    for _, z in ipairs { -2.4, 0, 2.4 } do desks[#desks + 1] = { x - 0.8, x + 0.8, 0.7, 0.74, z - 0.4, z + 0.4 } end
  end
  for _, x in ipairs { -5.6, 5.6 } do
    for _, z in ipairs { -3, 3 } do cupboards[#cupboards + 1] = { x - 0.25, x + 0.25, 0, 2, z - 0.6, z + 0.6 } end
  end
  for _, x in ipairs { -2.8, 0, 2.8 } do partitions[#partitions + 1] = { x - 0.03, x + 0.03, 0, 1.5, -3.2, 3.2 } end
  return desks, cupboards, partitions
end

--- Lamps of a photometry (default: a cosine of 3600 lm), 5 columns and 4 rows of the box { x0, x1, z0, z1 }.
function office.lamps(ylm, o)
  o = o or {}
  local box, list = o.box or { -6, 6, -4, 4 }, {}
  local photometry = o.photometry or ylm.photometry { cosine = 1, lumens = 3600 }
  for i = 1, 5 do
    for k = 1, 4 do
      list[#list + 1] = ylm.photometric_light { photometry = photometry, dim = o.dim, name = ("panel %d%d"):format(i, k),
        opening = o.opening or { shape = "rectangle", size = { 0.6, 0.6 } },
        at = { box[1] + (box[2] - box[1]) * (i - 0.5) / 5, o.height or 2.95, box[3] + (box[4] - box[3]) * (k - 0.5) / 4 } }
    end
  end
  return list
end

function office.scene(ylm, lights)
  local function matte(a) return ylm.matte { albedo = a } end
  local floor, wall, ceiling, wood, cloth = matte(0.2), matte(0.5), matte(0.7), matte(0.4), matte(0.5)
  local g = {
    ylm.quad { corner = { -6, 0, 4 }, u = { 12, 0, 0 }, v = { 0, 0, -8 }, material = floor, sides = "front" },
    ylm.quad { corner = { -6, 3, -4 }, u = { 12, 0, 0 }, v = { 0, 0, 8 }, material = ceiling, sides = "front" },
    ylm.quad { corner = { -6, 0, -4 }, u = { 12, 0, 0 }, v = { 0, 3, 0 }, material = wall, sides = "front" },
    ylm.quad { corner = { 6, 0, 4 }, u = { -12, 0, 0 }, v = { 0, 3, 0 }, material = wall, sides = "front" },
    ylm.quad { corner = { -6, 0, 4 }, u = { 0, 0, -8 }, v = { 0, 3, 0 }, material = wall, sides = "front" },
    ylm.quad { corner = { 6, 0, -4 }, u = { 0, 0, 8 }, v = { 0, 3, 0 }, material = wall, sides = "front" },
  }
  local desks, cupboards, partitions = furniture()
  for _, part in ipairs { { wood, desks }, { wall, cupboards }, { cloth, partitions } } do
    for _, b in ipairs(part[2]) do
      g[#g + 1] = ylm.box { bounds = { { b[1], b[3], b[5] }, { b[2], b[4], b[6] } }, material = part[1], sides = "front" }
    end
  end
  return ylm.scene "office" { geometry = g, lights = lights or office.lamps(ylm),
    camera = ylm.camera { from = { -5.2, 2.2, 3.7 }, at = { 2.5, 0.5, -1.2 }, fov = 70 } }
end

return office
