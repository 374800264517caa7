--- The zonal rival of Mezieres et al. 2022 (gradient), Table 4 and Fig. 10: lobes that are symmetric about the mirror direction
-- and lamps that are symmetric about theirs meet in lmax + 1 products a lamp, with the cosine taken at the lamp's centre.
-- Loaded with dofile by gradient_2022_table4.lua and gradient_2022_fig10.lua.

local ylm = require "ylm"

local zonal = {}

--- Lobes of a material's slice f, without its cosine: function(cosine of the view) -> z_0 .. z_lmax for red, green, blue.
-- z_l = sqrt(4 pi / (2l+1)) sum over m of F_lm Y_lm(r), r the mirror direction; of elevations of a degree each.
function zonal.lobes(material, lmax)
  local wo, mirror = {}, {}
  for i = 0, 89 do
    local a = math.rad(i)
    wo[i + 1], mirror[i + 1] = { math.sin(a), 0, math.cos(a) }, { -math.sin(a), 0, math.cos(a) }
  end
  local slices = material:table({ lmax = lmax, cosine = false }):slices(wo):totable()
  local Y, lobes = ylm.sh.eval(lmax, mirror):totable(), {}
  for i = 1, #wo do
    local z = { {}, {}, {} }
    for l = 0, lmax do
      for c = 1, 3 do
        local sum = 0
        for k = l * l + 1, (l + 1) ^ 2 do sum = sum + slices[i][c][k] * Y[i][k] end
        z[c][l] = math.sqrt(4 * math.pi / (2 * l + 1)) * sum
      end
    end
    lobes[i] = z
  end
  return function(cosine) return lobes[math.min(90, math.floor(math.deg(math.acos(math.min(1, cosine))) + 1.5))] end
end

--- Radiance towards `eye` from a place with normal n: of a lobe, or matte where `lobes` is an albedo.
-- lamps = { at = , radius = , radiance = }; Eqs. 9 and 10 of the paper for a lamp's coefficients.
function zonal.shade(lmax, lamps, x, n, eye, lobes)
  local wo, out = {}, { 0, 0, 0 }
  local length = math.sqrt((eye[1] - x[1]) ^ 2 + (eye[2] - x[2]) ^ 2 + (eye[3] - x[3]) ^ 2)
  for c = 1, 3 do wo[c] = (eye[c] - x[c]) / length end
  local facing = wo[1] * n[1] + wo[2] * n[2] + wo[3] * n[3]
  local r = { 2 * facing * n[1] - wo[1], 2 * facing * n[2] - wo[2], 2 * facing * n[3] - wo[3] }
  local z = type(lobes) == "function" and lobes(math.max(0, facing))
  local radius = lamps.radius
  for i, at in ipairs(lamps.at) do
    local a, b, c = at[1] - x[1], at[2] - x[2], at[3] - x[3]
    local d2 = a * a + b * b + c * c
    local d = math.sqrt(d2)
    local cosine = (a * n[1] + b * n[2] + c * n[3]) / d
    if cosine > 0 then
      local e = lamps.radiance[i]
      if not z then -- the cap's solid angle
        local s = 2 * cosine * (1 - math.sqrt(1 - radius * radius / d2))
        for k = 1, 3 do out[k] = out[k] + s * lobes[k] * e[k] end
      else
        local u, alpha = (a * r[1] + b * r[2] + c * r[3]) / d, math.sqrt(1 - radius * radius / d2)
        local p0, p1, q0, q1 = 1, u, 1, alpha -- P_l(u), P_l+1(u); P_l(alpha), P_l+1(alpha)
        local before, s1, s2, s3 = 1, 0, 0, 0 -- before: P_l-1(alpha), of l = 0 such that the difference is 1 - alpha
        for l = 0, lmax do
          local cap = math.sqrt(math.pi / (2 * l + 1)) * (before - q1) * p0
          s1, s2, s3 = s1 + z[1][l] * cap, s2 + z[2][l] * cap, s3 + z[3][l] * cap
          p0, p1 = p1, ((2 * l + 3) * u * p1 - (l + 1) * p0) / (l + 2)
          before, q0, q1 = q0, q1, ((2 * l + 3) * alpha * q1 - (l + 1) * q0) / (l + 2)
        end
        out[1], out[2], out[3] = out[1] + cosine * s1 * e[1], out[2] + cosine * s2 * e[2], out[3] + cosine * s3 * e[3]
      end
    end
  end
  return out
end

return zonal
