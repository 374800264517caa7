--- A voxel's interpolant as 32 weights, once for C (csrc/grid/gen/interpolation.h), once for GLSL
-- (shaders/gen/interpolation.glsl), and for pages in the GLSL of WebGL 2 and in JavaScript (ylm.codegen.page).
--
-- The interpolant is a sum over 8 corners of value, d/dx, d/dy, d/dz times a product of one
-- function per axis. Per axis and end i = 0, 1 of the edge, at fraction t:
--   L  linear          1-t, t
--   S  cubic correction of the value,      +- t(1-t)(1-2t)      (Hermite, else 0)
--   K  of the derivative, edge x           t(1-t)^2, -t^2(1-t)  (Hermite)
--                         edge x           t(1-t), -t(1-t)      (Taylor), 0 (linear)
-- and the weights are  value: LLL + SLL + LSL + LLS,  d/dx: KLL,  d/dy: LKL,  d/dz: LLK. Replacing one axis' L, S, K by
-- their derivatives gives the interpolant's gradient.

local emit = require "ylm.codegen.emit"
local expression = require "ylm.codegen.expression"

local interpolation = {}

--- In the order of ylm_grid_interpolation.
interpolation.kinds = { "hermite", "taylor", "linear" }

--- L, S, K of a kind for both ends, as nodes of t and edge.
function interpolation.values(g, kind)
  local t, edge, zero = g.variable "t", g.variable "edge", g.constant(0)
  local u = 1 - t
  local s, k, m = zero, zero, zero
  if kind == "hermite" then s, k, m = t * u * (u - t), edge * t * u * u, -(edge * t * t * u) end
  if kind == "taylor" then
    k = edge * t * u
    m = -k
  end
  return { l = { u, t }, s = { s, -s }, k = { k, m } }
end

--- Their derivatives along the axis, as nodes of t and rate = 1/edge.
function interpolation.slopes(g, kind)
  local t, rate, zero = g.variable "t", g.variable "rate", g.constant(0)
  local u = 1 - t
  local s, k, m = zero, zero, zero
  if kind == "hermite" then s, k, m = rate * (1 - 6 * t * u), u * (u - 2 * t), t * (t - 2 * u) end
  if kind == "taylor" then
    k = u - t
    m = -k
  end
  return { l = { -rate, rate }, s = { s, -s }, k = { k, m } }
end

--- The 32 weights; name(axis, function, end) is what a language calls a function's value. Corner c = i + 2j + 4k.
function interpolation.weights(g, name)
  local function f(axis, which, i) return g.variable(name(axis, which, i)) end
  local rows = {}
  for c = 0, 7 do
    local i, j, k = c % 2, math.floor(c / 2) % 2, math.floor(c / 4)
    local ll, xl, xy = f(1, "l", j) * f(2, "l", k), f(0, "l", i) * f(2, "l", k), f(0, "l", i) * f(1, "l", j)
    rows[c] = (f(0, "l", i) + f(0, "s", i)) * ll + (f(1, "s", j) * xl + f(2, "s", k) * xy)
    rows[8 + c] = f(0, "k", i) * ll
    rows[16 + c] = f(1, "k", j) * xl
    rows[24 + c] = f(2, "k", k) * xy
  end
  return rows
end

local languages = {
  glsl = {
    names = { "INTERPOLATION == 0", "INTERPOLATION == 1" },
    field = function(which, i) return ("f.%s[%d]"):format(which, i) end,
    of_axis = function(axis, which, i) return ("%s.%s[%d]"):format(("xyz"):sub(axis + 1, axis + 1), which, i) end,
    weight = "weight[at + %d] = %%s;",
    plain = "%s",
    about = "** INTERPOLATION: 0 Hermite, 1 Taylor, 2 linear. Weights go to weight[at ..].",
    axis = { "struct Axis {", "  float l[2], s[2], k[2];", "};" },
    values = { "Axis values(float t, float edge) {", "  Axis f;" },
    slopes = { "Axis slopes(float t, float edge) {", "  Axis f;", "  float rate = 1.0 / edge;" },
    done = { "  return f;" },
    corners = "void corner_weights(uint at, Axis x, Axis y, Axis z) {",
    finish = {},
  },
  element = {
    names = { "how == YLM_GRID_HERMITE", "how == YLM_GRID_TAYLOR" },
    field = function(which, i) return ("f->%s[%d]"):format(which, i) end,
    of_axis = function(axis, which, i) return ("%s->%s[%d]"):format(("xyz"):sub(axis + 1, axis + 1), which, i) end,
    weight = "w[%d * step] = %%s;",
    plain = "zero + (%s)",
    about = "** F: float, or a vector of floats. Weight of row r goes to w[r * step].",
    axis = { "typedef struct axis_functions {", "  F l[2], s[2], k[2];", "} axis_functions;" },
    values = { "static inline __attribute__((always_inline)) void axis_values(", "    axis_functions *f, F t, float edge, "
      .. "ylm_grid_interpolation how) {", "  F zero = t - t;" },
    slopes = { "static inline __attribute__((always_inline)) void axis_slopes(", "    axis_functions *f, F t, float edge, "
      .. "ylm_grid_interpolation how) {", "  F zero = t - t;", "  float rate = 1.0f / edge;" },
    done = {},
    corners = "static inline __attribute__((always_inline)) void weights(\n"
      .. "    const axis_functions *x, const axis_functions *y, const axis_functions *z, F *w, int step) {",
    finish = { "", "#undef F" },
  },
}

-- WebGL 2 has unsigned numbers, and makes no unsigned one of 1.
languages.essl = {}
for key, value in pairs(languages.glsl) do languages.essl[key] = value end
languages.essl.weight = "weight[at + %du] = %%s;"

languages.js = {
  names = { "INTERPOLATION === 0", "INTERPOLATION === 1" },
  field = languages.glsl.field,
  of_axis = languages.glsl.of_axis,
  weight = "weight[%d] = %%s;",
  plain = "%s",
  about = "** INTERPOLATION: 0 Hermite, 1 Taylor, 2 linear. Weights go to weight[0 ..].",
  axis = {},
  values = { "function values(t, edge) {", "  const f = { l: [0, 0], s: [0, 0], k: [0, 0] };" },
  slopes = { "function slopes(t, edge) {", "  const f = { l: [0, 0], s: [0, 0], k: [0, 0] }, rate = 1.0 / edge;" },
  done = { "  return f;" },
  corners = "function corner_weights(weight, x, y, z) {",
  finish = {},
}

--- Does a node depend on t?
local function varies(n)
  local yes = false
  expression.walk({ n }, function(x) yes = yes or x.name == "t" end)
  return yes
end

local function append(out, lines, indent)
  for _, line in ipairs(lines) do out[#out + 1] = (indent or "") .. line end
end

--- A function that sets L, S, K for each kind.
local function axis_function(out, name, language, functions, head)
  append(out, head)
  for i, kind in ipairs(interpolation.kinds) do
    local f, outputs = functions(expression.graph(), kind), {}
    for _, which in ipairs { "l", "s", "k" } do
      for e = 0, 1 do
        local node = f[which][e + 1]
        local form = node.op ~= "constant" and not varies(node) and language.plain or "%s"
        outputs[#outputs + 1] = { node = node, form = language.field(which, e) .. " = " .. form .. ";" }
      end
    end
    out[#out + 1] = i == 1 and ("  if (%s) {"):format(language.names[1])
      or language.names[i] and ("  } else if (%s) {"):format(language.names[i]) or "  } else {"
    append(out, emit.statements(outputs, name), "    ")
  end
  out[#out + 1] = "  }"
  append(out, language.done)
  out[#out + 1] = "}"
  out[#out + 1] = ""
end

--- The file's text in a language of emit: "element" (C), "glsl", "essl" or "js".
function interpolation.text(name)
  local language, outputs, nodes = languages[name], {}, {}
  local rows = interpolation.weights(expression.graph(), language.of_axis)
  for r = 0, 31 do
    outputs[r + 1] = { node = rows[r], form = language.weight:format(r) }
    nodes[r + 1] = rows[r]
  end
  local count = expression.count(nodes)
  local out = {
    "/* GENERATED by lua/ylm/codegen/interpolation.lua; do not edit: make gen writes it anew.",
    "** A voxel's interpolant as 32 weights: of the corners' values, then of their derivatives by x, y, z. Of axis functions",
    "** L (linear), S (cubic correction), K (of the derivative) the weights are LLL + SLL + LSL + LLS, KLL, LKL, LLK; with",
    "** one axis' functions replaced by their slopes, those of the interpolant's derivative. Corner c = i + 2j + 4k.",
    language.about,
    ("** The weights take %d additions and %d multiplications. */"):format(count.adds, count.muls),
  }
  append(out, language.axis)
  out[#out + 1] = ""
  axis_function(out, name, language, interpolation.values, language.values)
  axis_function(out, name, language, interpolation.slopes, language.slopes)
  out[#out + 1] = language.corners
  append(out, emit.statements(outputs, name), "  ")
  out[#out + 1] = "}"
  append(out, language.finish)
  return table.concat(out, "\n") .. "\n"
end

return interpolation
