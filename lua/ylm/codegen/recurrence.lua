--- One step of the recurrences for any lmax, once for C (csrc/sh/gen/recurrence.h) and once for GLSL
-- (shaders/gen/recurrence.glsl): the formulas of harmonics.lua with the table's coefficients as variables. The loops over
-- degrees and orders, and where values wait, are csrc/sh/eval/sh_kernel.h's and shaders/sh_recurrence.real.comp's own.

local functions = require "ylm.codegen.functions"
local harmonics = require "ylm.codegen.harmonics"

local recurrence = {}

--- An accessor for harmonics.rise: the functions of order q-1, q, q+1, where q is 0.
local function near(g, below, same, above)
  local list = { [-1] = below, [0] = same, [1] = above }
  return function(q) return list[q] or g.constant(0) end
end

--- Second derivatives: d/dx of the gradients' x and y, d/dz of x, y, z.
local function twice(g, e, A, B, low, up, same)
  local function of(i)
    local c = near(g, low and low[i], same[i], up[i])
    return (harmonics.rise(e, A, B, c, near(g), 0))
  end
  local x, y, z = of(1), of(2), of(3)
  return { x[1], y[1], x[3], nil, y[3], z[3] }
end

recurrence.functions = {
  { name = "sh_one_minus", about = "1 - |z| of a unit vector, exact also near the poles; g: the sign of z.",
    inputs = { "g", "x", "y", "z" }, outputs = { "o" },
    make = function(_, v) return { harmonics.pole(v.g, v.x, v.y, v.z) } end },
  { name = "sh_turn", about = "Cosine and sine of order q = l from those of l-1.",
    scalars = { "a" }, inputs = { "x", "y", "c", "s" }, outputs = { "cosine", "sine" },
    make = function(_, v) return { harmonics.turn(v.a * v.x, v.a * v.y, v.c, v.s) } end },
  { name = "sh_plain", about = "Cosine and sine of degree l, order q < l from those of l-1 (c, s) and l-2 (cb, sb).",
    scalars = { "a", "b" }, inputs = { "z", "c", "s", "cb", "sb" }, outputs = { "cosine", "sine" },
    make = function(_, v)
      return { harmonics.step(v.a, v.b, v.z, 1, v.c, v.cb), harmonics.step(v.a, v.b, v.z, 1, v.s, v.sb) }
    end },
  { name = "sh_solid", about = "The same of solid harmonics; r2 = |v|^2.",
    scalars = { "a", "b" }, inputs = { "z", "r2", "c", "s", "cb", "sb" }, outputs = { "cosine", "sine" },
    make = function(_, v)
      return { harmonics.step(v.a, v.b, v.z, v.r2, v.c, v.cb), harmonics.step(v.a, v.b, v.z, v.r2, v.s, v.sb) }
    end },
  { name = "sh_stable", about = "The same near the poles, with differences D (cd, sd); o: 1 - |z| times z's sign g.",
    scalars = { "a", "b", "c1" }, inputs = { "g", "o", "c", "s", "cd", "sd" },
    outputs = { "cosine", "sine", "cosine_d", "sine_d" },
    make = function(_, v)
      local c, cd = harmonics.stable_step(v.a, v.b * v.g, v.c1 * v.g, v.o, v.c, v.cd)
      local s, sd = harmonics.stable_step(v.a, v.b * v.g, v.c1 * v.g, v.o, v.s, v.sd)
      return { c, s, cd, sd }
    end },
  { name = "sh_gradient_zero", about = "The solid harmonic's gradient, order 0: from order 0 (c) and 1 below.",
    scalars = { "e", "B" }, inputs = { "c", "cu", "su" }, vectors = { h = 3 }, outputs = { "h" },
    make = function(g, v)
      return (harmonics.rise(v.e, 0, v.B, near(g, nil, v.c, v.cu), near(g, nil, nil, v.su), 0))
    end },
  { name = "sh_gradient_cosine", about = "Of a cosine of order q > 0: from orders q-1 (cl, sl), q, q+1 (cu, su) below.",
    scalars = { "e", "A", "B" }, inputs = { "c", "cl", "sl", "cu", "su" }, vectors = { h = 3 }, outputs = { "h" },
    make = function(g, v)
      return (harmonics.rise(v.e, v.A, v.B, near(g, v.cl, v.c, v.cu), near(g, v.sl, nil, v.su), 0))
    end },
  { name = "sh_gradient_sine", about = "Of a sine.",
    scalars = { "e", "A", "B" }, inputs = { "s", "cl", "sl", "cu", "su" }, vectors = { h = 3 }, outputs = { "h" },
    make = function(g, v)
      return (select(2, harmonics.rise(v.e, v.A, v.B, near(g, v.cl, nil, v.cu), near(g, v.sl, v.s, v.su), 0)))
    end },
  { name = "sh_hessian_zero", about = "The solid harmonic's xx xy xz . yz zz, order 0, from gradients of degree l-1.",
    scalars = { "e", "B" }, inputs = { "up", "same" }, vectors = { up = 3, same = 3, h = 6 }, outputs = { "h" },
    make = function(g, v) return twice(g, v.e, 0, v.B, nil, v.up, v.same) end },
  { name = "sh_hessian", about = "Of an order q > 0: from gradients of orders q-1, q+1, q below, cosines or sines all.",
    scalars = { "e", "A", "B" }, inputs = { "low", "up", "same" }, vectors = { low = 3, up = 3, same = 3, h = 6 },
    outputs = { "h" },
    make = function(g, v) return twice(g, v.e, v.A, v.B, v.low, v.up, v.same) end },
  { name = "sh_yy", about = "What its Hessian lacks.",
    inputs = { "xx", "zz" }, outputs = { "yy" },
    make = function(_, v) return { harmonics.harmonic_yy(v.xx, v.zz) } end },
  { name = "sh_surface", about = "The gradient of Y(v/|v|) from the solid harmonic's; p = Y/|v|, w = v/|v|.",
    scalars = { "l" }, inputs = { "p", "w", "u" }, vectors = { w = 3, u = 3, h = 3 }, outputs = { "h" },
    make = function(_, v)
      local t = v.l * v.p
      return harmonics.project(v.u, { t * v.w[1], t * v.w[2], t * v.w[3] })
    end },
  { name = "sh_surface_twice",
    about = "The Hessian of Y(v/|v|) from the solid harmonic's (s) and Y's gradient u; lwd = l w/|v|, inverse = 1/|v|.",
    scalars = { "l" }, inputs = { "inverse", "p", "w", "lwd", "u", "s" },
    vectors = { w = 3, lwd = 3, u = 3, s = 6, h = 6 }, outputs = { "h" },
    make = function(_, v)
      local t, U, double = v.l * v.p, {}, {}
      local share = harmonics.share(v.l) * t
      for i = 1, 3 do U[i], double[i] = v.u[i] + share * v.w[i], v.lwd[i] + v.lwd[i] end
      return harmonics.project_twice(v.s, -1 - v.l, U, t * v.inverse, v.lwd, double)
    end },
}

local about = {
  lanes = "** real: an element; vreal: a vector of lanes, which are points.",
  shader = "** real, rvec3: of float or double.",
}

--- The file's text in a language of emit: "lanes" (C) or "shader" (GLSL).
function recurrence.text(name)
  local out = {
    "/*",
    "** GENERATED by lua/ylm/codegen/recurrence.lua; do not edit: make gen writes it anew.",
    "** Steps of the recurrences of spherical harmonics, with the coefficients a b e A B b' c' of csrc/sh/eval/sh_kernel.h.",
    about[name],
    "** Formulas: Iwasaki & Dobashi 2025, Eqs. 10-17, Sec. 4.3; docs/math.md \"Evaluating the basis\".",
    "*/",
  }
  functions.append(out, recurrence.functions, name)
  return table.concat(out, "\n") .. "\n"
end

return recurrence
