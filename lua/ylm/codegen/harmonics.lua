--- The one description of the formulas: values, gradients and Hessians of spherical harmonics.
--
-- Iwasaki & Dobashi 2025, Eqs. 10-17 and Sec. 4.3, with derivatives of solid harmonics by the ladder
--     dS_lq/dx = A S_(l-1)(q-1) + B S_(l-1)(q+1),  dS_lq/dz = e S_(l-1)q
-- (docs/math.md, "Evaluating the basis"). Products A S, B S are shared between x and y derivatives
-- of cosine and sine. l Y w and the vector U are shared among the six components of a Hessian.

local recurrences = require "ylm.codegen.recurrences"

local harmonics = {}

--- Normalisation of the monic polynomial in z that belongs to degree l, order q: S_lq = N q^(z) c_q.
function harmonics.norm(l, q)
  local n = math.sqrt(1 / (4 * math.pi))
  for m = 1, q do n = -n * math.sqrt((2 * m + 1) / (2 * m) * (m == 1 and 2 or 1)) end
  for k = q + 1, l do n = n * math.sqrt((4 * k * k - 1) / (k * k - q * q)) end
  return n
end

--- The coefficients e, A, B of the ladder from degree l-1 to l.
local function ladder(l, q)
  local rho = math.sqrt((2 * l + 1) / (2 * l - 1))
  local e = rho * math.sqrt((l - q) * (l + q))
  local A = -0.5 * rho * math.sqrt((l + q - 1) * (l + q) * (q == 1 and 2 or 1))
  local B = 0.5 * rho * math.sqrt((l - q - 1) * (l - q) * (q == 0 and 2 or 1))
  return e, A, B
end

--- The coefficients a, b, e, A, B, b', c' of csrc/sh/eval/sh_kernel.h: the recurrence in l and the ladder.
function harmonics.coefficients(l, q)
  local n, e, A, B = 2 * l + 1, ladder(l, q)
  A, B = A + 0, B + 0 -- no negative zeros
  if q == l then return -math.sqrt(l == 1 and 3 or n / (n - 1)), 0, 0, A, B, 0, 0 end
  local d = (l - q) * (l + q)
  local b = l == q + 1 and 0 or math.sqrt(n * (l - 1 - q) * (l - 1 + q) / ((n - 4) * d))
  local a, c = math.sqrt(n * (n - 2) / d), math.sqrt(n / (n - 2)) * math.sqrt((l + q) / (l - q))
  return a, b, e, A, B, a - c, c
end

--- c_(m+1), s_(m+1) from c_m, s_m: (x + iy)(c + is).
function harmonics.turn(x, y, c, s) return x * c - y * s, x * s + y * c end

--- The degree above in a recurrence in z, from f of one degree below and `before` of two: a z f - b r2 before.
function harmonics.step(a, b, z, r2, f, before) return (a * z) * f - (b * r2) * before end

--- o = 1 - |z| of a unit vector, exact also near the poles; g: the sign of z.
function harmonics.pole(g, x, y, z) return (x * x + y * y) / (g * z + 1) end

--- harmonics.step from f and its difference d, which keeps its digits near the poles, with o = 1 - |z|: the new f and d.
function harmonics.stable_step(a, b, c, o, f, d)
  local difference = b * d - (a * o) * f
  return c * f + difference, difference
end

--- c_m = r^m cos(m phi), s_m = r^m sin(m phi) for m = 0 .. lmax (2025, Eq. 14).
local function azimuths(g, lmax, x, y)
  local c, s = { [0] = g.constant(1) }, { [0] = g.constant(0) }
  for m = 1, lmax do c[m], s[m] = harmonics.turn(x, y, c[m - 1], s[m - 1]) end
  return c, s
end

--- Monic polynomials p[l][q] in z (and r2 = |v|^2 for solid harmonics).
local function polynomials(g, lmax, z, r2)
  local p = {}
  for l = 0, lmax do
    p[l] = {}
    for q = 0, l do
      if l == q then p[l][q] = g.constant(1)
      elseif l == q + 1 then p[l][q] = z
      else
        p[l][q] = harmonics.step(1, recurrences.BETA(l - 1, q), z, r2, p[l - 1][q], p[l - 2][q])
      end
    end
  end
  return p
end

--- Results of `polynomials`, times a constant for each l, q, in a form that keeps its digits near the
-- poles: R_l(|z|) is 1 at |z| = 1, and only differences are computed, from o = 1 - |z| (given exactly):
--     d_l = (A-1) d_(l-1) - A o R_(l-1),   R_l = R_(l-1) + d_l,   A = (2l-1)/(l+q)
-- g is the sign of z. Returns p[l][q] and the constants by which it is to be multiplied.
local function stable_polynomials(g, lmax, sign, o)
  local p, n = {}, {}
  for l = 0, lmax do p[l], n[l] = {}, {} end
  for q = 0, lmax do
    local R, d, pole = g.constant(1), g.constant(0), 1
    p[q][q], n[q][q] = R, 1
    for l = q + 1, lmax do
      local A = (2 * l - 1) / (l + q)
      R, d = harmonics.stable_step(A, A - 1, 1, o, R, d)
      -- the monic polynomial's value at the pole: q^_l(1) = q^_(l-1)(1) (l+q) / (2l-1)
      pole = pole * (l + q) / (2 * l - 1)
      p[l][q], n[l][q] = (l + q) % 2 == 1 and sign * R or R, pole
    end
  end
  return p, n
end

--- Values of degree l as { [m] = node }, m = -l .. l.
local function values(p, n, c, s, l)
  local f = {}
  for q = 0, l do
    local e = (harmonics.norm(l, q) * (n and n[l][q] or 1)) * p[l][q]
    f[q] = e * c[q]
    if q > 0 then f[-q] = e * s[q] end
  end
  return f
end

--- d/dx, d/dy, d/dz of the cosine and of the sine of order q from the degree below: c(q), s(q) are its functions, 0 where
-- there is none.
function harmonics.rise(e, A, B, c, s, q)
  return { A * c(q - 1) + B * c(q + 1), B * s(q + 1) - A * s(q - 1), e * c(q) },
    { A * s(q - 1) + B * s(q + 1), A * c(q - 1) - B * c(q + 1), e * s(q) }
end

--- d/dx and d/dy and d/dz of degree l from the functions `f` of degree l-1 (by m): { [m] = {x, y, z} }.
local function climb(g, l, f)
  local zero = g.constant(0)
  local function c(q) return q >= 0 and q < l and f[q] or zero end
  local function s(q) return q > 0 and q < l and f[-q] or zero end
  local out = {}
  for q = 0, l do
    local e, A, B = ladder(l, q)
    out[q], out[-q] = harmonics.rise(e, A, B, c, s, q)
    if q == 0 then out[0] = harmonics.rise(e, A, B, c, s, 0) end
  end
  return out
end

--- One component of gradients, or functions times a factor, by m.
local function map(t, f)
  local out = {}
  for m, v in pairs(t) do out[m] = f(v) end
  return out
end

--- Hessians of the solid harmonics of degree l from the gradients of degree l-1: xx xy xz yy yz zz.
local function climb_twice(g, l, gradients)
  local by_x = climb(g, l, map(gradients, function(v) return v[1] end))
  local by_y = climb(g, l, map(gradients, function(v) return v[2] end))
  local by_z = climb(g, l, map(gradients, function(v) return v[3] end))
  local out = {}
  for m = -l, l do
    local xx, zz = by_x[m][1], by_z[m][3]
    out[m] = { xx, by_x[m][2], by_x[m][3], harmonics.harmonic_yy(xx, zz), by_y[m][3], zz }
  end
  return out
end

--- The gradient of Y(v/|v|) from that of the solid harmonic; tw = l Y / |v| times the unit vector.
function harmonics.project(gradient, tw)
  return { gradient[1] - tw[1], gradient[2] - tw[2], gradient[3] - tw[3] }
end

--- The part of tw that goes with dY into U, below.
function harmonics.share(l) return (l - 2) / (2 * l) end

--- yy of a solid harmonic's Hessian, whose trace is 0.
function harmonics.harmonic_yy(xx, zz) return -xx - zz end

--- The Hessian of Y(v/|v|): HS - t2 I - l (U wd^T + wd U^T), U = dY + (l-2)/(2l) tw, wd = w / |v|.
-- `lwd` is l wd, `lwd2` twice that, t2 = l Y / |v|^2; the trace is `trace` t2, trace = -(l+1).
function harmonics.project_twice(h, trace, U, t2, lwd, lwd2)
  local xx = h[1] - t2 - U[1] * lwd2[1]
  local zz = h[6] - t2 - U[3] * lwd2[3]
  return {
    xx,
    h[2] - U[1] * lwd[2] - U[2] * lwd[1],
    h[3] - U[1] * lwd[3] - U[3] * lwd[1],
    trace * t2 - xx - zz,
    h[5] - U[2] * lwd[3] - U[3] * lwd[2],
    zz,
  }
end

--- All outputs for degrees 0 .. lmax, as a list of { array = "Y" | "dY" | "ddY", index =, node = }.
-- options: derivatives 0..2; solid: |v|^l Y of the vector x, y, z; else x, y, z is the unit vector and
-- the variable s is 1/|v| (unit = true: |v| is 1, and s is not used).
-- stable: variables g, o are the sign of z and 1 - |z|; then float keeps its digits near the poles.
function harmonics.build(g, lmax, options)
  local x, y, z = g.variable "x", g.variable "y", g.variable "z"
  local solid, order = options.solid, options.derivatives or 0
  local scale = (solid or options.unit) and g.constant(1) or g.variable "s"
  local r2 = solid and x * x + y * y + z * z or g.constant(1)
  local w = { x, y, z }
  local c, s = azimuths(g, lmax, x, y)
  local p, at_pole
  if options.stable then p, at_pole = stable_polynomials(g, lmax, g.variable "g", g.variable "o")
  else p = polynomials(g, lmax, z, r2) end
  local outputs, below, gradients_below = {}, nil, nil
  local function out(array, index, e) outputs[#outputs + 1] = { array = array, index = index, node = e } end
  local zero = g.constant(0)
  for l = 0, lmax do
    local f = values(p, at_pole, c, s, l)
    local scaled = map(f, function(v) return v * scale end)
    local gradients, hessians, lwd, lwd2
    local function scaled_vector(k) return { k * (x * scale), k * (y * scale), k * (z * scale) } end
    if order > 1 and not solid then lwd, lwd2 = scaled_vector(l), scaled_vector(2 * l) end
    if order > 0 then gradients = l == 0 and { [0] = { zero, zero, zero } } or climb(g, l, below) end
    if order > 1 then
      hessians = l < 2 and map(f, function() return { zero, zero, zero, zero, zero, zero } end)
        or climb_twice(g, l, gradients_below)
    end
    for m = -l, l do
      local k = l * (l + 1) + m
      out("Y", k, f[m])
      local dy, t, tw
      if order > 0 then
        t = l * scaled[m]
        tw = { t * w[1], t * w[2], t * w[3] }
        dy = (solid or l == 0) and gradients[m] or harmonics.project(gradients[m], tw)
        for i = 1, 3 do out("dY", 3 * k + i - 1, dy[i]) end
      end
      if order > 1 then
        local h = hessians[m]
        if not solid and l > 0 then
          local U = {}
          for i = 1, 3 do U[i] = dy[i] + harmonics.share(l) * tw[i] end
          h = harmonics.project_twice(h, -(l + 1), U, t * scale, lwd, lwd2)
        end
        for i = 1, 6 do out("ddY", 6 * k + i - 1, h[i]) end
      end
    end
    below = scaled
    gradients_below = order > 1 and map(gradients, function(v) return { v[1] * scale, v[2] * scale, v[3] * scale } end)
  end
  return outputs
end

return harmonics
