--- Small functions for C and GLSL from one list of their parameters and formulas.
--
--     { name = "sh_turn", about = "..", scalars = { "a" }, inputs = { "x", "w" }, vectors = { w = 3 }, outputs = { "s" },
--       make = function(g, v) return { v.a * v.x + v.w[1] } end }
--
-- `scalars` are the same at all points; `inputs` are numbers, or arrays where `vectors` has their
-- length. `outputs` are all numbers or one array. make(graph, nodes by name) returns their nodes in
-- order, and, as a second result, the nodes that are to be computed first. A single number is what
-- the function returns.

local emit = require "ylm.codegen.emit"
local expression = require "ylm.codegen.expression"

local functions = {}

local function arrays(text) return { [3] = text, [6] = text, [10] = text } end

local languages = {
  -- C for lanes (csrc/sh/eval/sh_simd.h).
  lanes = {
    name = "%s", head = "YLM_INLINE %s %s(%s) {", number_type = "vreal",
    scalar = "real %s", number = "vreal %s", vector = arrays "const vreal *%s",
    out_number = "vreal *%s", out_vector = arrays "vreal *%s", result = "*%s",
  },
  -- C in double.
  double = {
    name = "%s", head = "static inline %s %s(%s) {", number_type = "double",
    scalar = "double %s", number = "double %s", vector = arrays "const double *%s",
    out_number = "double *%s", out_vector = arrays "double *%s", result = "*%s",
  },
  shader = {
    name = "%s", head = "%s %s(%s) {", number_type = "real",
    scalar = "real %s", number = "real %s",
    vector = { [3] = "rvec3 %s", [6] = "real %s[6]", [10] = "real %s[10]" },
    out_number = "out real %s",
    out_vector = { [3] = "out rvec3 %s", [6] = "inout real %s[6]", [10] = "inout real %s[10]" }, result = "%s",
  },
}

--- Appends a line, wrapped at commas into lines of at most 100 columns.
function functions.wrap(out, line)
  while #line > 100 do
    local at = line:sub(1, 100):match "^.*(), "
    out[#out + 1] = line:sub(1, at)
    line = "    " .. line:sub(at + 2)
  end
  out[#out + 1] = line
end

--- Appends one function in a language: "lanes" or "double" (C), or "shader" (GLSL).
local function define(out, f, name)
  local language, g, v, words, results = languages[name], expression.graph(), {}, {}, {}
  local sizes = f.vectors or {}
  for _, x in ipairs(f.scalars or {}) do
    v[x] = g.variable(x, true)
    words[#words + 1] = language.scalar:format(x)
  end
  for _, x in ipairs(f.inputs) do
    local size = sizes[x]
    words[#words + 1] = (size and language.vector[size] or language.number):format(x)
    if size then
      v[x] = {}
      for i = 1, size do v[x][i] = g.variable(("%s[%d]"):format(x, i - 1)) end
    else v[x] = g.variable(x) end
  end
  local size, made, early = sizes[f.outputs[1]], f.make(g, v)
  local alone = not size and #f.outputs == 1
  for i, x in ipairs(alone and {} or f.outputs) do
    words[#words + 1] = (size and language.out_vector[size] or language.out_number):format(x)
    if not size then results[i] = { node = made[i], form = language.result:format(x) .. " = %s;" } end
  end
  for i = 1, size or 0 do
    if made[i] then
      results[#results + 1] = { node = made[i], form = ("%s[%d] = %%s;"):format(f.outputs[1], i - 1) }
    end
  end
  if alone then results[1] = { node = made[1], form = "return %s;" } end
  out[#out + 1] = "/* " .. f.about .. " */"
  functions.wrap(out, language.head:format(alone and language.number_type or "void", language.name:format(f.name),
    table.concat(words, ", ")))
  for _, line in ipairs(emit.statements(results, name, nil, { exact = true, early = early })) do out[#out + 1] = "  " .. line end
  out[#out + 1] = "}"
end

--- Appends all functions of a list to the lines `out`, an empty line before each but the first of a file.
function functions.append(out, list, name)
  for _, f in ipairs(list) do
    if #out > 0 and not out[#out]:find "%*/$" then out[#out + 1] = "" end
    define(out, f, name)
  end
end

return functions
