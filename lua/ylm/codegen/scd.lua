--- Spherical-coordinate derivatives (SCD): the method that Iwasaki & Dobashi 2025 compare with.
--
-- Mezieres et al. 2022, Eqs. 7, 8, 17, 21-23 ("Sloan's like"), carried to second derivatives: Q, its first
-- and second derivatives T, TT by theta from recurrences; then the chain rule to x, y, z. At unit length.
-- The chain rule divides by sin(theta): singular where x = y = 0. Here it is built to be counted
-- and compared.

local scd = {}

local function norm_of(l, q)
  local n = (2 * l + 1) / (4 * math.pi) * (q > 0 and 2 or 1)
  for i = l - q + 1, l + q do n = n / i end
  return math.sqrt(n)
end

--- Normalised Q, T, TT, as tables [q] of one degree; `rows` are those of degrees l-1 and l-2.
local function polynomials(g, l, z, st, above, second)
  local row = { Q = {}, T = {}, TT = {} }
  for q = 0, l do
    local n = norm_of(l, q)
    if q == l then
      local double_factorial = 1
      for i = 1, q do double_factorial = double_factorial * (1 - 2 * i) end
      row.Q[q], row.T[q], row.TT[q] = g.constant(n * double_factorial), g.constant(0), g.constant(0)
    else
      local a = (2 * l - 1) / (l - q) * n / norm_of(l - 1, q)
      local Q1, T1, TT1 = above.Q[q], above.T[q], above.TT[q]
      local aQ, aT = a * Q1, a * T1
      local Q, T, TT = z * aQ, z * aT - st * aQ, a * (z * TT1) - 2 * (st * aT) - z * aQ
      if q < l - 1 then
        local b = (l + q - 1) / (l - q) * n / norm_of(l - 2, q)
        Q, T, TT = Q - b * second.Q[q], T - b * second.T[q], TT - b * second.TT[q]
      end
      row.Q[q], row.T[q], row.TT[q] = Q, T, TT
    end
  end
  return row
end

--- Derivatives of theta and phi by x, y, z: first [1..3], second [1..6].
local function jacobian(g, x, y, z, st)
  local one = g.constant(1)
  local i = one / st           -- 1 / sin(theta)
  local i2 = i * i
  local cx, cy = x * i, y * i  -- cos(phi), sin(phi)
  local zx, zy = z * cx, z * cy
  local theta = { zx, zy, -st }
  local phi = { -(cy * i), cx * i, g.constant(0) }
  local cot = z * i
  local xx, yy, xy = cx * cx, cy * cy, cx * cy
  local z2 = z * z
  local theta2 = {
    cot * (yy - 2 * (st * st) * xx), -(cot * xy) * (1 + 2 * (st * st)), (1 - 2 * z2) * cx,
    cot * (xx - 2 * (st * st) * yy), (1 - 2 * z2) * cy, 2 * (z * st),
  }
  local phi2 = { 2 * (xy * i2), (yy - xx) * i2, g.constant(0), -(2 * (xy * i2)), g.constant(0), g.constant(0) }
  return theta, phi, theta2, phi2
end

local pairs_of = { { 1, 1 }, { 1, 2 }, { 1, 3 }, { 2, 2 }, { 2, 3 }, { 3, 3 } }

--- As harmonics.build, for unit vectors only.
function scd.build(g, lmax, options)
  local x, y, z = g.variable "x", g.variable "y", g.variable "z"
  local order = options.derivatives or 0
  local zero = g.constant(0)
  local st = g.sqrt(x * x + y * y)
  local theta, phi, theta2, phi2 = jacobian(g, x, y, z, st)
  local tt, tp, pp = {}, {}, {}
  for i, ab in ipairs(pairs_of) do
    local a, b = ab[1], ab[2]
    tt[i] = theta[a] * theta[b]
    tp[i] = theta[a] * phi[b] + theta[b] * phi[a]
    pp[i] = phi[a] * phi[b]
  end
  local cot = z / st
  local c, s = { [0] = g.constant(1) }, { [0] = zero }
  for m = 1, lmax do
    c[m] = x * c[m - 1] - y * s[m - 1]
    s[m] = x * s[m - 1] + y * c[m - 1]
  end
  local outputs = {}
  local function out(array, index, e) outputs[#outputs + 1] = { array = array, index = index, node = e } end
  local above, second
  for l = 0, lmax do
    local row = polynomials(g, l, z, st, above, second)
    for m = -l, l do
      local q = math.abs(m)
      local k = l * (l + 1) + m
      local f, other = m < 0 and s[q] or c[q], m < 0 and c[q] or (q > 0 and s[q] or zero)
      local sign = -m -- d/dphi Y_l^m = -m Y_l^-m
      local Q, T, TT = row.Q[q], row.T[q], row.TT[q]
      local Pt = q * (cot * Q) + T
      local Y = Q * f
      out("Y", k, Y)
      if order > 0 then
        local Yt, Yp = Pt * f, sign * (Q * other)
        for i = 1, 3 do out("dY", 3 * k + i - 1, Yt * theta[i] + Yp * phi[i]) end
        if order > 1 then
          local Ptt = ((q * (q - 1)) * (cot * cot) - q) * Q + (2 * q) * (cot * T) + TT
          local Ytt, Ytp, Ypp = Ptt * f, sign * (Pt * other), (-q * q) * Y
          for i = 1, 6 do
            out("ddY", 6 * k + i - 1,
              Ytt * tt[i] + Ytp * tp[i] + Ypp * pp[i] + Yt * theta2[i] + Yp * phi2[i])
          end
        end
      end
    end
    second, above = above, row
  end
  return outputs
end

return scd
