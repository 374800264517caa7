--- The largest absolute eigenvalue of a symmetric 3x3 matrix, once for C (csrc/light/moments/gen/eigenvalue.h) and once for GLSL
-- (shaders/gen/eigenvalue.glsl).
--
-- q is the mean of the trace; B = (H - q)/p is scaled so that the squares of its elements sum to 6.
-- The extreme eigenvalues are q + 2p cos(acos(r)/3) and q - 2p cos(acos(-r)/3), r = det(B)/2 (Smith
-- 1961). With t = sqrt((1+r)/2) the first cosine is cos(2/3 acos(t)), smooth in t: a Chebyshev
-- interpolant in u = 2t - 1 stands in for it. Where two eigenvalues are alike 1-|r| has lost its
-- digits, but 6(1-r^2) is the sum of the squares of B^2 - rB - 2.

local template = require "ylm.codegen.template"

--- Coefficients of powers of u: interpolation of degree 9 (to 4e-9) and 20 (to 1e-15).
local third = {
  single = { 0.766044443, 0.247409067, -0.0155091689, 0.00246634011, -0.000504279435, 0.000116495476, -2.84967340e-05,
    7.3851101e-06, -2.49732176e-06, 7.1227402e-07 },
  double = { 0.7660444431189779, 0.24740906632284712, -0.015509188436479752, 0.002466352815327989,
    -0.000504124691375387, 0.00011642544964303237, -2.891993276519552e-05, 7.5411011213028505e-06,
    -2.035895290512516e-06, 5.640626796428738e-07, -1.5944028400288515e-07, 4.607182479821059e-08,
    -1.3595880766041157e-08, 3.6162572749631748e-09, -8.22254314453013e-10, 6.375020298321488e-10,
    -4.1134878791124913e-10, -1.1124320309363611e-10, 1.3821345135056616e-10, 3.4040482432828866e-11,
    -3.151308192173019e-11 },
}

--- The formulas; `languages` says what its words are.
local body = [[
  real top = LARGER(LARGER(LARGER(SIZE(h0), SIZE(h1)), LARGER(SIZE(h2), SIZE(h3))), LARGER(SIZE(h4), SIZE(h5)));
  top = LARGER(top, ALL(TINY));
  real down = #1.0 / top, a = h0 * down, b = h1 * down, c = h2 * down;
  real d = h3 * down, e = h4 * down, f = h5 * down;
  real q = (a + d + f) * #0.33333333333333333;
  a -= q;
  d -= q;
  f -= q;
  real p = ROOT((a * a + d * d + f * f + #2.0 * (b * b + c * c + e * e)) * #0.16666666666666667);
  real up = #1.0 / LARGER(p, ALL(TINY));
  a *= up, b *= up, c *= up, d *= up, e *= up, f *= up;
  real aa = a * a + b * b + c * c, dd = b * b + d * d + e * e, ff = c * c + e * e + f * f;
  real ab = a * b + b * d + c * e, ac = a * c + b * e + c * f, de = b * c + d * e + e * f;
  real r = (aa * a + dd * d + ff * f + #2.0 * (ab * b + ac * c + de * e)) * #0.16666666666666667;
  aa -= r * a + #2.0, dd -= r * d + #2.0, ff -= r * f + #2.0;
  ab -= r * b, ac -= r * c, de -= r * e;
  /* sqrt(1 - r^2); sqrt((1+|r|)/2) and sqrt((1-|r|)/2), halves of the angle acos(|r|) */
  real s = ROOT((aa * aa + dd * dd + ff * ff + #2.0 * (ab * ab + ac * ac + de * de)) * #0.16666666666666667);
  real wide = ROOT(#0.5 + #0.5 * SMALLER(SIZE(r), ALL(#1.0))), narrow = SMALLER(#0.5 * s / wide, ALL(#1.0));
  mask positive = r > #0.0;
  real high = THIRD(#2.0 * CHOOSE(positive, wide, narrow) - #1.0);
  real low = THIRD(#2.0 * CHOOSE(positive, narrow, wide) - #1.0);
  return LARGER(SIZE(q + #2.0 * p * high), SIZE(q - #2.0 * p * low)) * top;
]]

local languages = {
  glsl = {
    words = { LARGER = "max", SMALLER = "min", SIZE = "abs", ROOT = "sqrt", THIRD = "third", CHOOSE = "choose",
      ALL = "" },
    real = "real", mask = "bool", constant = "REAL(%slf)",
    double = "#ifdef YLM_DOUBLE", third = "real third(real u) {", first = "  real s = %s;",
    head = {
      "#ifdef YLM_DOUBLE",
      "#define TINY 1e-280lf",
      "#else",
      "#define TINY 1e-30",
      "#endif",
    },
    start = "real largest_eigenvalue(real h0, real h1, real h2, real h3, real h4, real h5) {",
    about = "",
  },
  c = {
    words = { LARGER = "larger", SMALLER = "smaller", SIZE = "magnitude", ROOT = "vreal_sqrt", THIRD = "third",
      CHOOSE = "choose", ALL = "(vreal){0} + " },
    real = "vreal", mask = "vmask", constant = "(real)%s",
    double = "#ifndef YLM_REAL_IS_FLOAT", third = "static inline vreal third(vreal u) {", first = "  vreal s = (vreal){0} + %s;",
    head = {},
    start = "static inline vreal largest_eigenvalue(const vreal *h) {\n"
      .. "  const vreal h0 = h[0], h1 = h[1], h2 = h[2], h3 = h[3], h4 = h[4], h5 = h[5];",
    about = "\n** Included by csrc/light/moments/lanes.h for lanes, and by csrc/light/metric.c for doubles.",
  },
}

--- Additions and multiplications: of the body, and of both polynomials.
local function operations(coefficients)
  local _, n = body:gsub(" [%+%-%*]=? ", "")
  return n + 2 * 2 * (#coefficients - 1)
end

local function number(language, x)
  for _, format in ipairs { "%.9g", "%.15g" } do
    if (format):format(x) + 0 == x then return language.constant:format((format):format(x)) end
  end
  return language.constant:format(("%.17g"):format(x))
end

--- Horner's scheme as statements.
local function horner(out, language, coefficients)
  out[#out + 1] = language.first:format(number(language, coefficients[#coefficients]))
  for i = #coefficients - 1, 1, -1 do out[#out + 1] = ("  s = s * u + %s;"):format(number(language, coefficients[i])) end
  out[#out + 1] = "  return s;"
end

--- The file's text in a language, "c" or "glsl".
return function(name)
  local language = languages[name]
  local out = {
    "/* GENERATED by lua/ylm/codegen/eigenvalue.lua; do not edit: make gen writes it anew.",
    "** The largest absolute eigenvalue of the symmetric matrix xx xy xz yy yz zz; 0 for zero. Two that are alike: r is",
    "** near 1 or -1 and 1-|r| has lost its digits, but B = (H - q)/p then nearly solves B^2 - rB - 2 = 0, and 6(1-r^2) is",
    "** the sum of the squares of that matrix's elements. Source: Smith 1961, \"Eigenvalues of a symmetric 3x3 matrix\"",
    ("** Additions and multiplications: %d in float, %d in double; 3 divisions, 3 square roots.%s */")
      :format(operations(third.single), operations(third.double), language.about),
  }
  for _, line in ipairs(language.head) do out[#out + 1] = line end
  out[#out + 1] = ""
  out[#out + 1] = "/* cos(2/3 acos((1+u)/2)), Chebyshev interpolation: to 4e-9, 1e-15 */"
  out[#out + 1] = language.third
  out[#out + 1] = language.double
  horner(out, language, third.double)
  out[#out + 1] = "#else"
  horner(out, language, third.single)
  out[#out + 1] = "#endif\n}\n"
  out[#out + 1] = language.start
  out[#out + 1] = template.fill(body, language) .. "}"
  return table.concat(out, "\n") .. "\n"
end
