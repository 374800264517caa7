--- The zonal rival of Mezieres et al. 2022 (gradient), Fig. 10, for all surfaces, matte ones too (view:render { by = "sum",
-- method = "zonal" } takes the glossy ones). Lobes are symmetric about the mirror direction, lamps about theirs. They meet in
-- lmax + 1 products a lamp, with the cosine taken at the lamp's centre. The sum is that of libylm_rival. Loaded with dofile by
-- gradient_2022_fig10.lua.

local ylm = require "ylm"

local zonal = {}

local ROWS = 91 -- of elevation, 0 to 90 degrees

--- Legendre moments of a material f about the mirror direction, [ROWS][3][lmax+1]: integral of f P_l(r . wi). A matte one is
-- taken as the same from everywhere, below the surface too.
local function lobe(material, lmax)
  local wo, mirror, moments = {}, {}, ylm.zeros { ROWS, 3, lmax + 1 }
  if not material.alpha then
    moments[{ {}, {}, 1 }] = 4 * ylm.array(material.albedo)
    return moments
  end
  for i = 1, ROWS do
    local a = math.rad(math.min(i - 1, 89.9))
    wo[i], mirror[i] = { math.sin(a), 0, math.cos(a) }, { -math.sin(a), 0, math.cos(a) }
  end
  local slices = material:table({ lmax = lmax, cosine = false }):slices(wo)
  local Y = ylm.sh.eval(lmax, mirror):reshape { ROWS, 1, (lmax + 1) ^ 2 }
  for l = 0, lmax do
    local degree = { l * l + 1, (l + 1) ^ 2 }
    moments[{ {}, {}, l + 1 }] = 4 * math.pi / (2 * l + 1) * (slices[{ {}, {}, degree }] * Y[{ {}, {}, degree }]):sum(3)
  end
  return moments
end

--- A shader of a prepared view by sphere lights { at, radius, radiance }: function() -> radiance of its points [n][3].
-- `materials` are those of the scene's objects, in their order. nil: libylm_rival is not there.
function zonal.shader(view, lamps, materials, lmax, threads)
  local there, rival = pcall(require, "ylm.c.rival")
  if not there then return nil end
  local points, lobes, radii, eye = view:points(), {}, {}, view.scene.camera.from
  for i, m in ipairs(materials) do lobes[i] = lobe(m, lmax) end
  for i = 1, #lamps.at do radii[i] = lamps.radius end
  local object = ylm.array(points.object, "float") - 1
  local places = { points.position, points.normal, object, eye[1], eye[2], eye[3] }
  local lights = { ylm.array(lamps.at, "float"), ylm.array(radii, "float"), ylm.array(lamps.radiance, "float") }
  local out = ylm.zeros({ #object, 3 }, "float")
  lobes = ylm.stack(lobes)
  return function() return assert(rival.zonal(places, lmax, lobes, lights, threads or 0, out)) end
end

return zonal
