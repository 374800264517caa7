--- shaders/gen/product.glsl: one light by the product rule, the form that the papers sum, for comparison.
--
-- Mezieres et al. 2022, Eqs. 11-12, and Iwasaki & Dobashi 2025, Eqs. 6 and 15: L = F(d) Y(v/d), differentiated factor by
-- factor, light by light. As in 2022 (Sec. 5.1) all that depends on an order m is found within m, so that the loops over
-- lights and orders can be exchanged: M_FIRST, M_LAST say which orders a dispatch sums. The papers' derivatives by
-- theta and phi divide by sin(theta); here Q_l^m(z) and Re, Im (x+iy)^m are differentiated as
-- polynomials of x, y, z. The part along the direction is taken off, which divides by nothing.

local emit = require "ylm.codegen.emit"
local expression = require "ylm.codegen.expression"
local harmonics = require "ylm.codegen.harmonics"
local recurrences = require "ylm.codegen.recurrences"

local parts = { "v", "x", "y", "z", "xx", "xy", "xz", "yy", "yz", "zz" } -- of each coefficient
local needs = { 0, 1, 1, 1, 2, 2, 2, 2, 2, 2 } -- derivatives that a part belongs to

--- F, F' and F'' of each degree: a light's coefficient is F_l(d) Y_lm, but for 2 pi.
local function radial(g, lmax)
  local alpha, es, u = g.variable "alpha", g.variable "es", g.variable "u"
  local slope, second = g.variable "slope", g.variable "second"
  local P, dP = { [0] = g.constant(1), alpha }, { [0] = g.constant(0), g.constant(1) }
  local F = {}
  for l = 2, lmax do
    P[l] = ((2 * l - 1) / l * alpha) * P[l - 1] - ((l - 1) / l) * P[l - 2]
    dP[l] = dP[l - 2] + (2 * l - 1) * P[l - 1]
  end
  for l = 0, lmax do
    F[l] = {
      l == 0 and g.variable "first" or (1 / (l * (l + 1))) * (es * dP[l]),
      -(P[l] * slope),
      P[l] * second - slope * (u * dP[l]),
    }
  end
  return F
end

--- The ten parts of F(d) Y(v/d), from the polynomial Y = Q(z) c(x, y) of the unit vector and its derivatives.
local function coefficient(g, F, Y, dY, ddY)
  local w = { g.variable "x", g.variable "y", g.variable "z" }
  local id = g.variable "id"
  local along = w[1] * dY[1] + w[2] * dY[2] + w[3] * dY[3]
  local A, B = F[1] * id, F[2]
  local out, slope = { F[1] * Y }, {}
  for i = 1, 3 do slope[i] = dY[i] - along * w[i] end
  for i = 1, 3 do out[1 + i] = A * slope[i] + (B * Y) * w[i] end
  -- A (P ddY P - along P - slope w^T - w slope^T) / d + B (slope w^T + w slope^T) / d + radial parts times Y
  local row, column = { 1, 1, 1, 2, 2, 3 }, { 1, 2, 3, 2, 3, 3 }
  local place = { { 1, 2, 3 }, { 2, 4, 5 }, { 3, 5, 6 } }
  local A2, B1 = A * id, B * id
  local t, cross = {}, {}
  for i = 1, 3 do
    t[i] = ddY[place[i][1]] * w[1] + ddY[place[i][2]] * w[2] + ddY[place[i][3]] * w[3]
  end
  local twice = w[1] * t[1] + w[2] * t[2] + w[3] * t[3]
  for i = 1, 3 do cross[i] = B1 * slope[i] - A2 * (t[i] + slope[i]) end
  local both = A2 * (twice + along) + (F[3] - B1) * Y
  local plain = B1 * Y - A2 * along
  for j = 1, 6 do
    local a, b = row[j], column[j]
    local h = A2 * ddY[j] + (w[a] * cross[b] + w[b] * cross[a]) + (w[a] * w[b]) * both
    out[4 + j] = a == b and h + plain or h
  end
  return out
end

--- Calls visit(m, side, l, number) for every coefficient in order: by order m, side, degree.
local function each(lmax, visit)
  local n = 0
  for m = 0, lmax do
    for side = 0, m > 0 and 1 or 0 do
      for l = m, lmax do
        visit(m, side, l, n)
        n = n + 1
      end
    end
  end
  return n
end

local function outputs_of(g, lmax)
  local x, y, z, zero = g.variable "x", g.variable "y", g.variable "z", g.constant(0)
  local F, c, s = radial(g, lmax), { [0] = g.constant(1) }, { [0] = zero }
  for m = 1, lmax do c[m], s[m] = harmonics.turn(x, y, c[m - 1], s[m - 1]) end
  local q, outputs = {}, {}
  each(lmax, function(m, side, l, n)
    if l == m then q[l] = { g.constant(1), zero, zero }
    elseif l == m + 1 then q[l] = { z, g.constant(1), zero }
    else
      local a, b, beta = q[l - 1], q[l - 2], recurrences.BETA(l - 1, m)
      q[l] = { z * a[1] - beta * b[1], a[1] + z * a[2] - beta * b[2], 2 * a[2] + z * a[3] - beta * b[3] }
    end
    -- derivatives of c_m and s_m by x and y
    local c0, s0 = c[m], s[m]
    local c1, s1 = m > 0 and m * c[m - 1] or zero, m > 0 and m * s[m - 1] or zero
    local c2, s2 = m > 1 and (m * (m - 1)) * c[m - 2] or zero, m > 1 and (m * (m - 1)) * s[m - 2] or zero
    local f, fx, fy, fxx, fxy = c0, c1, -s1, c2, -s2
    if side == 1 then f, fx, fy, fxx, fxy = s0, s1, c1, s2, c2 end
    local Q, dQ, ddQ = q[l][1], q[l][2], q[l][3]
    local made = coefficient(g, F[l], Q * f, { Q * fx, Q * fy, dQ * f },
      { Q * fxx, Q * fxy, dQ * fx, -(Q * fxx), dQ * fy, ddQ * f })
    for i in ipairs(parts) do
      outputs[#outputs + 1] = { node = made[i], form = ("p%d = %%s;%s"):format(i - 1,
        i == #parts and (" ADD(%d);"):format(n) or "") }
    end
  end)
  return outputs
end

local product = {}

--- Additions and multiplications per light, all orders in one pass, with 0, 1 or 2 derivatives.
function product.operations(lmax, derivatives)
  local nodes = {}
  for i, out in ipairs(outputs_of(expression.graph(), lmax)) do
    if needs[(i - 1) % #parts + 1] <= derivatives then nodes[#nodes + 1] = out.node end
  end
  return expression.count(nodes).total + #nodes
end

local function put(out, ...) out[#out + 1] = (...):format(select(2, ...)) end

function product.text(lmax)
  local outputs = outputs_of(expression.graph(), lmax)
  local out, count = {}, (lmax + 1) * (lmax + 1)
  put(out, "/* GENERATED by lua/ylm/codegen/product_glsl.lua; do not edit: make gen writes it anew.")
  put(out, "** One light by the product rule, for lmax 0 .. %d: the papers' form, for comparison.", lmax)
  put(out, "**   real, REAL(c)     float or double, and a constant of that type")
  put(out, "**   LMAX, DERIVATIVES specialisation constants; 0, 1 or 2 derivatives")
  put(out, "**   LMAX_MOST         the largest LMAX that the module is asked for: sums of more are left out")
  put(out, "**   M_FIRST, M_LAST   specialisation constants: the orders m that are summed here")
  put(out, "**   ADD(n)            adds p0 .. p9, the parts of a coefficient, to vn, xn, yn, zn, xxn .. zzn")
  local function of(l) return product.operations(l, 0), product.operations(l, 1), product.operations(l, 2) end
  put(out, "** Operations per light with 0, 1, 2 derivatives: lmax 4 %d, %d, %d;", of(4))
  put(out, ("** lmax %d %%d, %%d, %%d. */"):format(lmax), of(lmax))
  put(out, "#define HAS(derivatives, l) ((derivatives) <= DERIVATIVES && (l) <= LMAX)")
  put(out, "#define ORDER(m) (M_FIRST <= (m) && (m) <= M_LAST)")
  put(out, "")
  for n = 0, count - 1 do
    local row = {}
    for i, name in ipairs(parts) do row[i] = name .. n end
    put(out, "real %s;", table.concat(row, ", "))
  end
  put(out, "")
  put(out, "void clear_sums() {")
  for n = 0, count - 1 do put(out, "  %s%d = REAL(0.0lf);", table.concat(parts, n .. " = "), n) end
  put(out, "}")
  put(out, "")
  put(out, "/* Adds one light. x, y, z: its direction; id: 1/d; alpha: h/d; u: r^2/(d^2 h); es: radiance r^2/d^2;")
  put(out, "** first: es/(1+alpha), in a light twice the radiance (all else 0); slope: es/h;")
  put(out, "** second: slope (2/d + d/h^2). Gradients and Hessians are by the light's position. */")
  put(out, "void add_light(real x, real y, real z, real id, real alpha, real u, real es, real first, real slope,")
  put(out, "               real second) {")
  put(out, "  real p0, p1, p2, p3, p4, p5, p6, p7, p8, p9;")
  for _, line in ipairs(emit.statements(outputs, "shader")) do put(out, "  %s", line) end
  put(out, "}")
  put(out, "")
  put(out, "/* Hands each sum and its number to STORE(number, sum): by order, side, degree, part. */")
  put(out, "void store_sums() {")
  for n = 0, count - 1 do -- copies before the first branch: see moments_glsl.lua
    local row = {}
    for i, name in ipairs(parts) do row[i] = ("k%s%d = %s%d"):format(name, n, name, n) end
    put(out, "  real %s;", table.concat(row, ", "))
  end
  put(out, "  uint n = 0u;")
  each(lmax, function(m, _, l, n)
    for derivatives = 0, 2 do
      local stores = {}
      for i, name in ipairs(parts) do
        if needs[i] == derivatives then stores[#stores + 1] = ("STORE(n + %d, k%s%d);"):format(#stores, name, n) end
      end
      put(out, "  if (%d <= LMAX_MOST) {", l)
      put(out, "    if (HAS(%d, %d) && ORDER(%d)) { %s }", derivatives, l, m, table.concat(stores, " "))
      put(out, "    n += uint(HAS(%d, %d)) * %d;", derivatives, l, #stores)
      put(out, "  }")
    end
  end)
  put(out, "}")
  return table.concat(out, "\n") .. "\n"
end

return product
