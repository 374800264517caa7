--- Functions in GLSL, C and Lua that evaluate coefficients of a convention: for ylm sh.
--
-- A basis function without phase is K Q(z) c(x, y), with Q the m-th derivative of a Legendre polynomial and c + i s = (x + iy)^m.

local sh_code = {}

local pi = math.pi

--- Coefficients, constant first, of the m-th derivative of P_l.
local function legendre(l, m)
  local before, p = { 0 }, { 1 }
  for k = 1, l do -- k P_k = (2k-1) z P_(k-1) - (k-1) P_(k-2)
    local next_p = {}
    for i = 0, k do next_p[i + 1] = ((2 * k - 1) * (p[i] or 0) - (k - 1) * (before[i + 1] or 0)) / k end
    before, p = p, next_p
  end
  for _ = 1, m do
    local d = {}
    for i = 2, #p do d[i - 1] = (i - 1) * p[i] end
    p = d
  end
  return p
end

--- The constant of the basis function of degree l and order |m|.
local function constant(l, m)
  local k = (2 * l + 1) / (4 * pi) * (m > 0 and 2 or 1)
  for i = l - m + 1, l + m do k = k / i end
  return math.sqrt(k)
end

local function number(x)
  local text = ("%.9g"):format(x)
  return text:find "[.e]" and text or text .. ".0"
end

--- factor times a polynomial in z, by Horner's rule in z or z^2, as text; nil: 1.
local function polynomial(p, factor)
  local odd = #p % 2 == 0
  local first, out = odd and 2 or 1, nil
  for i = #p, first, -2 do
    out = out and ("(%s * zz %s %s)"):format(out, p[i] < 0 and "-" or "+", number(math.abs(p[i] * factor)))
      or number(p[i] * factor)
  end
  return odd and out .. " * z" or out
end

--- Names of (x + iy)^m: real parts c1, c2, .., imaginary parts s1, s2, ..
local function power_name(m)
  if m == 0 then return nil end
  local k = math.abs(m)
  return k == 1 and (m > 0 and "x" or "y") or (m > 0 and "c" or "s") .. k
end

--- "c2 = x * x - y * y" and the like, to order `most`; each is { name, text }.
local function powers(most)
  local list = {}
  for k = 2, most do
    local c, s = power_name(k - 1), power_name(1 - k)
    list[#list + 1] = { "c" .. k, ("x * %s - y * %s"):format(c, s) }
    list[#list + 1] = { "s" .. k, ("x * %s + y * %s"):format(s, c) }
  end
  return list
end

--- System -> the factor of a basis function without phase, for its l, m and (filament) its own constant.
local function phase(_, m) return m % 2 == 0 and 1 or -1 end
local function one() return 1 end
local factors = {
  ylm = phase, ["3dgs"] = phase, mrtrix = phase, dipy = phase, plain = one, ["three.js"] = one, e3nn = one,
  n3d = function() return math.sqrt(1 / (4 * pi)) end,
  sn3d = function(l) return math.sqrt((2 * l + 1) / (4 * pi)) end,
  ["e3nn-component"] = function() return math.sqrt(4 * pi) end,
  ["e3nn-norm"] = function(l) return math.sqrt(4 * pi / (2 * l + 1)) end,
  filament = function(l, m) return 1 / (constant(l, math.abs(m)) * (l == 2 and m == 0 and 0.5 or l == 2 and math.abs(m) == 1 and 3
    or l == 2 and m == 2 and 3 or l == 2 and 6 or 1)) end,
}

--- Can code be written for this system?
function sh_code.knows(system) return factors[system] ~= nil end

--- The basis of a system to lmax in the order of its coefficients: texts in x, y, z, and the powers that these use.
function sh_code.basis(system, lmax)
  local out, is_even = {}, system == "mrtrix" or system == "dipy"
  for l = 0, lmax, is_even and 2 or 1 do
    for m = -l, l do
      local own = system == "dipy" and -m or m
      local k = factors[system](l, own) * constant(l, math.abs(own))
      local text, power = polynomial(legendre(l, math.abs(own)), k), power_name(own)
      local whole = power and ("%s * %s"):format(text, power) or text
      whole = whole:gsub("^1%.0 %* ", "")
      out[#out + 1] = whole
    end
  end
  return out, powers(lmax)
end

--- Lines that declare x, y, z of a direction and the powers; declare(name, text) is one.
local function declarations(system, lmax, direction, declare)
  local lines, order = {}, system:find "^e3nn" and { 3, 1, 2 } or { 1, 2, 3 }
  for i, name in ipairs { "x", "y", "z" } do lines[i] = declare(name, direction[order[i]]) end
  if lmax > 1 then lines[#lines + 1] = declare("zz", "z * z") end
  local _, list = sh_code.basis(system, lmax)
  for _, power in ipairs(list) do lines[#lines + 1] = declare(power[1], power[2]) end
  return lines
end

--- { r, g, b } rows in the order of the coefficients, as text.
local function rows(list, open, close)
  local out = {}
  for i, c in ipairs(list) do
    out[i] = ("%s%s, %s, %s%s"):format(open, number(c[1]), number(c[2]), number(c[3]), close)
  end
  return out
end

local function comment(lines, mark)
  local out = {}
  for i, line in ipairs(lines) do out[i] = mark .. " " .. line end
  return out
end

local function join(...)
  local out = {}
  for _, list in ipairs { ... } do
    for _, line in ipairs(type(list) == "table" and list or { list }) do out[#out + 1] = line end
  end
  return table.concat(out, "\n") .. "\n"
end

--- GLSL: an array sh of vec3, and vec3 sh_evaluate(vec3 n).
function sh_code.glsl(list, system, lmax, about)
  local basis, terms = sh_code.basis(system, lmax), {}
  for i, text in ipairs(basis) do terms[i] = ("    sh[%d] * (%s)%s"):format(i - 1, text, i < #basis and " +" or ";") end
  return join(comment(about, "//"), ("const vec3 sh[%d] = vec3[%d]("):format(#list, #list),
    "  " .. table.concat(rows(list, "vec3(", ")"), ",\n  ") .. ");", "", "vec3 sh_evaluate(vec3 n) {",
    declarations(system, lmax, { "n.x", "n.y", "n.z" }, function(name, text) return ("  float %s = %s;"):format(name, text) end),
    "  return", terms, "}")
end

--- C: an array sh, and void sh_evaluate(const float n[3], float rgb[3]).
function sh_code.c(list, system, lmax, about)
  local basis, terms = sh_code.basis(system, lmax), {}
  for i, text in ipairs(basis) do
    terms[i] = ("      (float)(%s)%s"):format(text, i < #basis and "," or "};")
  end
  return join(comment(about, "//"), ("static const float sh[%d][3] = {"):format(#list),
    "  " .. table.concat(rows(list, "{", "}"), ",\n  ") .. "};", "",
    "static inline void sh_evaluate(const float n[3], float rgb[3]) {",
    declarations(system, lmax, { "n[0]", "n[1]", "n[2]" }, function(name, text)
      return ("  const float %s = %s;"):format(name, text)
    end), "  const float basis[] = {", terms,
    "  rgb[0] = rgb[1] = rgb[2] = 0;", ("  for (int i = 0; i < %d; i++)"):format(#list),
    "    for (int c = 0; c < 3; c++) rgb[c] += sh[i][c] * basis[i];", "}")
end

--- Lua: a module with coefficients and evaluate(x, y, z) -> r, g, b.
function sh_code.lua(list, system, lmax, about)
  local basis, terms = sh_code.basis(system, lmax), {}
  for i, text in ipairs(basis) do terms[i] = ("    %s%s"):format(text, i < #basis and "," or " }") end
  return join(comment(about, "--"), "local sh = {", "  " .. table.concat(rows(list, "{ ", " }"), ",\n  ") .. " }", "",
    "local function evaluate(nx, ny, nz)",
    declarations(system, lmax, { "nx", "ny", "nz" }, function(name, text) return ("  local %s = %s"):format(name, text) end),
    "  local basis = {", terms, "  local r, g, b = 0, 0, 0",
    "  for i, c in ipairs(sh) do r, g, b = r + c[1] * basis[i], g + c[2] * basis[i], b + c[3] * basis[i] end",
    "  return r, g, b", "end", "", "return { coefficients = sh, evaluate = evaluate }")
end

return sh_code
