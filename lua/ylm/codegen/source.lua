--- Whole source files: banner, guards, one function for each set of outputs.

local emit = require "ylm.codegen.emit"
local expression = require "ylm.codegen.expression"
local harmonics = require "ylm.codegen.harmonics"
local scd = require "ylm.codegen.scd"

local source = {}

local builders = { solid = harmonics.build, scd = scd.build }

--- Outputs of a request { lmax, derivatives, solid, unit, method }.
function source.outputs(request)
  return builders[request.method or "solid"](expression.graph(), request.lmax, request)
end

local function roots(outputs)
  local list = {}
  for i, out in ipairs(outputs) do list[i] = out.node end
  return list
end

--- Operations of a request, as expression.count.
function source.count(request) return expression.count(roots(source.outputs(request))) end

local function counted(c)
  local text = ("%d additions, %d multiplications"):format(c.adds, c.muls)
  if c.divs > 0 then text = text .. (", %d divisions"):format(c.divs) end
  if c.sqrts > 0 then text = text .. (", %d square roots"):format(c.sqrts) end
  return text
end

local arrays = { "Y", "dY", "ddY" }
local widths = { 1, 3, 6 }

--- The function's name: the one asked for, or ylm_sh_<lmax>_<derivatives>.
local function name_of(request)
  return request.name or ("ylm_%s_%d_%d"):format(request.solid and "solid" or "sh", request.lmax, request.derivatives)
end

local function needs_length(request)
  return not request.solid and not request.unit and request.method ~= "scd" and request.derivatives > 0
end

local heads = {}

--- x, y, z: the unit vector (solid: the vector); s: 1/|v|, where it is needed; lmax: a request of any degree (below) has it.
function heads.c(request)
  local parameters = { "YLM_T x", "YLM_T y", "YLM_T z" }
  if request.any then table.insert(parameters, 1, "const int lmax") end
  if request.stable then parameters[#parameters + 1] = "YLM_T g, YLM_T o" end
  if needs_length(request) then parameters[#parameters + 1] = "YLM_T s" end
  for k = 1, request.derivatives + 1 do parameters[#parameters + 1] = "YLM_T *restrict " .. arrays[k] end
  local inline = request.any and "inline __attribute__((always_inline))" or "inline"
  return { "static " .. inline .. " void " .. name_of(request) .. "(" .. table.concat(parameters, ", ") .. ") {" }
end

--- v: any vector but 0; it is normalised here.
function heads.glsl(request)
  local count, parameters = (request.lmax + 1) * (request.lmax + 1), { "vec3 v" }
  for k = 1, request.derivatives + 1 do
    parameters[#parameters + 1] = ("out float %s[%d]"):format(arrays[k], widths[k] * count)
  end
  local lines = { "void " .. name_of(request) .. "(" .. table.concat(parameters, ", ") .. ") {" }
  if request.solid or request.unit then lines[2] = "  float x = v.x, y = v.y, z = v.z;"
  else
    lines[2] = "  float s = inversesqrt(dot(v, v));"
    lines[3] = "  float x = v.x * s, y = v.y * s, z = v.z * s;"
  end
  return lines
end

--- For emit.statements: before the first output of a degree above `lmax`, the name of a variable, a function returns.
function source.leaves(lmax)
  return function(out)
    local l = math.floor(math.sqrt(out.index) + 0.5)
    if out.array == "Y" and l > 0 and l * l == out.index then return ("if (%s < %d) return;"):format(lmax, l) end
  end
end

--- The lines of one function, with a comment that counts its operations. request.any: it takes the lmax, up to the request's.
function source.function_lines(request, language)
  local outputs = source.outputs(request)
  local what = ({ "values", "values and gradients", "values, gradients and Hessians" })[request.derivatives + 1]
  local operations = counted(expression.count(roots(outputs)))
  local lines = { ("/* %s, degrees 0 .. %d: %s */"):format(what, request.lmax, operations) }
  for _, line in ipairs(heads[language](request)) do lines[#lines + 1] = line end
  if language == "c" then
    -- what a function of low degree does not use
    if request.lmax < 1 then
      lines[#lines + 1] = "  (void)x, (void)y, (void)z" .. (needs_length(request) and ", (void)s;" or ";")
    elseif request.stable and request.derivatives == 0 then lines[#lines + 1] = "  (void)z;" end
  end
  local before = request.any and source.leaves "lmax"
  for _, line in ipairs(emit.statements(outputs, language, before)) do lines[#lines + 1] = "  " .. line end
  lines[#lines + 1] = "}"
  return lines
end

local preamble = {
  c = {
    "#ifndef YLM_T /* element type: double, float, or vectors of them with YLM_K, YLM_SET to match */",
    "#define YLM_T double",
    "#define YLM_K(c) (c)   /* a constant */",
    "#define YLM_SET(c) (c) /* a constant as a YLM_T */",
    "#define YLM_SQRT __builtin_sqrt",
    "#endif",
    "",
  },
  glsl = {},
}

local notes = {
  c = {
    sh = "x, y, z: the unit vector v/|v|; s: 1/|v|. Derivatives are those of Y(v/|v|) at v.",
    stable = "x, y, z: the unit vector v/|v|; s: 1/|v|; g: the sign of z; o: 1 - |z|. Derivatives: of Y(v/|v|) at v.",
    unit = "x, y, z: a unit vector. Derivatives are those of Y(v/|v|) at |v| = 1.",
    solid = "x, y, z: any vector. Solid harmonics |v|^l Y(v/|v|).",
  },
  glsl = {
    sh = "v: any vector but 0. Derivatives are those of Y(v/|v|) at v.",
    unit = "v: a unit vector. Derivatives are those of Y(v/|v|) at |v| = 1.",
    solid = "v: any vector. Solid harmonics |v|^l Y(v/|v|).",
  },
}

local any = "lmax: degrees up to it, a constant in a call: compilers leave out the others."

--- A whole file with the functions of `requests`, as text.
function source.file(requests, language, about)
  local first = requests[1]
  local kind = first.solid and "solid" or (first.unit or first.method == "scd") and "unit"
    or first.stable and "stable" or "sh"
  local lines = {
    "/*",
    "** GENERATED by lua/ylm/codegen (make gen); do not edit.",
    "** " .. (about or "Spherical harmonics: real, orthonormal, with the Condon-Shortley phase; index l*(l+1)+m."),
    "** " .. notes[language][kind],
    "** Y [count], dY [count][3], ddY [count][6]: xx xy xz yy yz zz.",
    "** Formulas: Iwasaki & Dobashi 2025, Eqs. 10-17, Sec. 4.3; docs/math.md \"Evaluating the basis\".",
    "*/",
  }
  if first.any then table.insert(lines, 5, "** " .. any) end
  for _, line in ipairs(preamble[language]) do lines[#lines + 1] = line end
  for i, request in ipairs(requests) do
    if i > 1 then lines[#lines + 1] = "" end
    for _, line in ipairs(source.function_lines(request, language)) do lines[#lines + 1] = line end
  end
  return table.concat(lines, "\n") .. "\n"
end

return source
