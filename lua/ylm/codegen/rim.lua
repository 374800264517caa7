--- The rims of exact flat lights, once for C (csrc/light/flat/gen/rim.h) and once for GLSL (shaders/gen/rim.glsl): angles, an
-- edge seen from a point, nodes along edges and ellipses, solid angles, a horizon's cut. docs/math.md "Polygons and disks".

local template = require "ylm.codegen.template"

local rim = {}

--- Lines of Horner's scheme in t for coefficients given as text, highest last.
local function horner(name, start, coefficients, step)
  local lines = { ("  real %s = %s;"):format(name, start) }
  for k = #coefficients, 1, -1 do lines[#lines + 1] = "  " .. step:format(name, coefficients[k], name) end
  return (table.concat(lines, "\n"):gsub("%(#1%.0 / #1%.0%)", "#1.0"))
end

--- Coefficients (-1)^k / (2k + from)! of the series of cos (0) and sin (1), k = 0 .. n-1.
local function series(from, n)
  local list, f = {}, 1.0
  for k = 0, n - 1 do
    if k > 0 then f = f * (2 * k + from - 1) * (2 * k + from) end
    list[k + 1] = ("%s(#1.0 / #%.0f.0)"):format(k % 2 == 1 and "-" or "", f)
  end
  return list
end

local odd = {}
for k = 0, 11 do odd[k + 1] = ("(#1.0 / #%d.0)"):format(2 * k + 1) end

local functions = {
  [[
/* The angle of (cosine, sine), cosine >= 0: three halvings, then the series. */
INLINE real angle_of(real cosine, real sine) {
  real t = sine / (#1.0 + cosine);
  t = t / (#1.0 + ROOT(#1.0 + t * t));
  t = t / (#1.0 + ROOT(#1.0 + t * t));
  real u = t * t;
]] .. horner("s", "SET(#1.0 / #25.0)", odd, "%s = %s - u * %s;") .. [[

  return #8.0 * t * s;
}]],
  [[
/* The angle of (re, im), im >= 0; 0 of (0, 0). */
INLINE real argument(real re, real im) {
  real size = ROOT(re * re + im * im);
  size = CHOOSE(size > #0.0, size, SET(#1.0));
  real a = angle_of(MAGNITUDE(re) / size, im / size);
  return CHOOSE(re < #0.0, HALFTURN - a, a);
}]],
  [[
/* Half the angle of (cosine, sine), sine > 0, accurate relative to itself. */
INLINE real half_angle(real cosine, real sine) {
  real sum = ROOT(#0.5 * (#1.0 + MAGNITUDE(cosine))), other = #0.5 * sine / sum;
  mask sharp = cosine > #0.0;
  return angle_of(CHOOSE(sharp, sum, other), CHOOSE(sharp, other, sum));
}]],
  [[
/* Of |t| <= pi/2, by the series. */
INLINE turned turn(real t) {
  turned a;
  real u = t * t;
]] .. horner("c", "SET(-(#1.0 / #1124000727777607680000.0))", series(0, 11), "%s = %s + u * %s;") .. "\n"
    .. horner("s", "SET(-(#1.0 / #25852016738884976640000.0))", series(1, 11), "%s = %s + u * %s;") .. [[

  a.cosine = c;
  a.sine = s * t;
  return a;
}]],
  [[
/* The edge from v to w = v + e, which are r0 and r1 away; e is `length` long. */
INLINE arc arc_of(VECTOR v, VECTOR w, real r0, real r1, VECTOR e, real length) {
  arc a;
  VECTOR n = CROSS(v, e); /* = v x w, with less cancellation */
  real ln = ROOT(DOT(n, n)), h = ln / length;
  a.along = SCALE(e, #1.0 / length);
  a.normal = SCALE(n, #1.0 / ln);
  a.foot = CROSS(a.along, a.normal);
  a.near = #1.0 / h;
  /* edges cancel where a polygon is small: the angle needs its relative accuracy, not the place */
  a.span = half_angle(DOT(v, w) / (r0 * r1), ln / (r0 * r1));
  a.middle = angle_of(h / r0, DOT(v, a.along) / r0) + a.span;
  return a;
}]],
  [[
/* Its node at x, -1 .. 1. */
INLINE node arc_node(arc a, real x) {
  node n;
  turned t = turn(a.middle + a.span * x);
  n.s = PLUS(SCALE(a.foot, t.cosine), SCALE(a.along, t.sine));
  n.m = a.normal;
  n.inverse = t.cosine * a.near;
  n.angle = SET(#0.0);
  return n;
}]],
  [[
/* The node at (cosine, sine) of the rim c + u cos + v sin, seen from the side of `facing`. */
INLINE node rim_node(VECTOR c, VECTOR u, VECTOR v, VECTOR facing, real cosine, real sine) {
  node n;
  VECTOR y = PLUS(c, PLUS(SCALE(u, cosine), SCALE(v, sine)));
  VECTOR m = CROSS(y, PLUS(SCALE(v, cosine), SCALE(u, -sine)));
  n.inverse = #1.0 / ROOT(DOT(y, y));
  n.s = SCALE(y, n.inverse);
  n.m = SCALE(m, n.inverse * n.inverse);
  n.angle = DOT(facing, n.m) / (#1.0 + DOT(facing, n.s));
  return n;
}]],
  [[
/* The complex number whose argument is half the solid angle of the triangle a b c, that far away; across = (b-a) x (c-a),
   so that the determinant does not cancel (Van Oosterom & Strackee 1983). */
INLINE number triangle(VECTOR a, VECTOR b, VECTOR c, real ra, real rb, real rc, VECTOR across) {
  number z;
  z.re = #1.0 + DOT(a, b) / (ra * rb) + DOT(b, c) / (rb * rc) + DOT(c, a) / (rc * ra);
  z.im = DOT(across, a) / (ra * rb * rc);
  return z;
}]],
}

local structures = {
  { "turned", "/* An angle's. */", { "real cosine, sine" } },
  { "number", "/* A complex one. */", { "real re, im" } },
  { "arc", "/* An edge: its great circle's normal, the foot of the perpendicular and the edge as directions; one over the\n"
    .. "   foot's distance; half the angle, and that of its middle from the foot. */",
    { "VECTOR normal, foot, along", "real near, span, middle" } },
  { "node", "/* Of a rim: its direction s, m without a weight, 1/rho, and n.m/(1 + n.s) of ellipses. */",
    { "VECTOR s, m", "real inverse, angle" } },
}

local languages = {
  kernel = {
    real = "V", mask = "VI", constant = "%s",
    inline = "YLM_INLINE ",
    words = { VECTOR = "v3", SET = "set", ROOT = "ylm_vd_sqrt", CHOOSE = "ylm_vd_select",
      MAGNITUDE = "absolute", DOT = "dot", CROSS = "cross", SCALE = "scale", PLUS = "plus", HALFTURN = "YLM_PI" },
    open = "typedef struct %s {", close = "} %s;",
    about = "** V, VI: vectors of doubles, of masks; v3: three. set, absolute, dot, cross, scale, plus: functions.",
    before = {},
  },
  shader = {
    real = "real", mask = "bool", constant = "REAL(%slf)",
    inline = "",
    words = { VECTOR = "rvec3", SET = "real", ROOT = "sqrt", CHOOSE = "choose", MAGNITUDE = "abs", DOT = "dot",
      CROSS = "cross", SCALE = "scale", PLUS = "plus", HALFTURN = "REAL(PI)" },
    open = "struct %s {", close = "};",
    about = "** real: float or double. choose is a function of shaders/ylm.glsl.",
    before = { "rvec3 scale(rvec3 a, real s) { return a * s; }", "rvec3 plus(rvec3 a, rvec3 b) { return a + b; }", "" },
  },
}

--- The file's text: "kernel" (C) or "shader" (GLSL).
function rim.text(name)
  local language = languages[name]
  local out = {
    "/*",
    "** GENERATED by lua/ylm/codegen/rim.lua; do not edit: make gen writes it anew.",
    "** The rims of exact flat lights: docs/math.md \"Polygons and disks\".",
    language.about,
    "*/",
  }
  for _, line in ipairs(language.before) do out[#out + 1] = line end
  for _, s in ipairs(structures) do
    out[#out + 1] = s[2]
    out[#out + 1] = language.open:format(s[1])
    for _, field in ipairs(s[3]) do out[#out + 1] = "  " .. template.fill(field, language) .. ";" end
    out[#out + 1] = language.close:format(s[1])
  end
  for _, text in ipairs(functions) do
    out[#out + 1] = ""
    out[#out + 1] = template.fill(text:gsub("INLINE ", language.inline), language)
  end
  return table.concat(out, "\n") .. "\n"
end

return rim
