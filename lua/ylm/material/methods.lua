--- The methods of materials of every kind: light between directions.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local object = require "ylm.material.object"
local outputs = require "ylm.outputs"

local methods = object.methods

require "ylm.describe".object "material" {
  about = "The reflection of a surface: matte, ggx, phong, abc and the other forms of materials make one. It does not "
    .. "change. Directions stand in the surface's frame, z its normal, x its tangent; wi points to where light comes from, wo "
    .. "to where it goes. Fields can be read as they were given.",
  methods = methods,
}

--- C's object; or nil, message, code.
local function open(name, m)
  if not object.is(m) then return check.fail("%s: a material expected before the colon, got %s", name, check.describe(m)) end
  return object.made(name, m)
end

local function rows_of(a) return core.array_info(a)[1] end

--- Argument n as directions [rows][3], and whether it is a single one.
local function directions(n, name, what, value)
  local a, single = array.rows(n, name, what, value, 3)
  local shape = core.array_info(a)
  if #shape > 2 then return check.bad(n, name, "%s: directions [n][3] expected, got %s", what, check.describe(a)) end
  if single then a = core.array_reshape(a, { 1, 3 }) end
  return a, single
end

--- wi and wo as arrays of rows, the number of pairs, and whether it is a single pair.
local function pair(name, wi, wo)
  local a, one = directions(1, name, "wi", wi)
  local b, other = directions(2, name, "wo", wo)
  local n, k = rows_of(a), rows_of(b)
  if n ~= k and n ~= 1 and k ~= 1 then
    return check.bad(2, name, "wo: %d rows, or one for all, expected, got %d", n, k)
  end
  return a, b, n == 1 and k or n, one and other
end

local out_option = { "out", "any", optional = true, about = "an array, or a list of them, that takes the result: float, of its "
  .. "shape" }
local options = { out_option }

describe "material:eval" {
  about = "The bidirectional reflectance f of pairs of directions.",
  arguments = { { "wi", "array|table", "[n][3], to where light comes from, any length but 0; or one for all" },
    { "wo", "array|table", "[n][3], to where it goes; or one for all" }, { "options?", "table", "" } },
  options = options,
  returns = { { "f", "array", "[n][3], sr^-1, 0 where one of the two is not above the surface; [3] of two single ones" } },
  errors = "raises on other shapes and on directions without length; nil, message, code: memory",
  example = [[
local f = ylm.matte { albedo = 0.5 }:eval({ 0, 0, 1 }, { 1, 0, 1 })
assert(math.abs(f:get(1) - 0.5 / math.pi) < 1e-7)]],
}
function methods.eval(m, wi, wo, given)
  local made, message, code = open("eval", m)
  if not made then return nil, message, code end
  local o = form.options(3, "eval", options, given)
  local a, b, n, single = pair("eval", wi, wo)
  local out = outputs.of(3, "eval", o.out, "float", { { n, 3 } })
  local f
  f, message, code = check.result("eval", core.material_eval(made, a, b, out))
  if not f then return nil, message, code end
  return single and not out and f[1] or f
end

describe "material:pdf" {
  about = "The density of material:sample.",
  arguments = { { "wi", "array|table", "[n][3]; or one for all" }, { "wo", "array|table", "[n][3]; or one for all" },
    { "options?", "table", "" } },
  options = options,
  returns = { { "pdf", "array|number", "[n], sr^-1; it integrates to 1 over wi above the surface; a number of single ones" } },
  errors = "raises on other shapes and on directions without length; nil, message, code: memory",
  example = [[
local p = ylm.matte {}:pdf({ 0, 0, 1 }, { 0, 0, 1 })
assert(math.abs(p - 1 / math.pi) < 1e-6)]],
}
function methods.pdf(m, wi, wo, given)
  local made, message, code = open("pdf", m)
  if not made then return nil, message, code end
  local o = form.options(3, "pdf", options, given)
  local a, b, n, single = pair("pdf", wi, wo)
  local out = outputs.of(3, "pdf", o.out, "float", { { n } })
  local p
  p, message, code = check.result("pdf", core.material_pdf(made, a, b, out))
  if not p then return nil, message, code end
  return single and not out and p:get(1) or p
end

describe "material:sample" {
  about = "Directions that light may come from, dense where much of what leaves towards wo comes from.",
  arguments = { { "wo", "array|table", "[n][3], to where light goes; or one for all" },
    { "u", "array|table", "[n][3] numbers from 0, below 1" }, { "options?", "table", "" } },
  options = options,
  returns = { { "wi", "array", "[n][3]" }, { "weight", "array", "[n][3], f wi.z over the density: its mean is the albedo" },
    { "pdf", "array", "[n], the density, sr^-1; 0: light is absorbed" } },
  errors = "raises on other shapes, directions without length and numbers out of range; nil, message, code: memory",
  example = [[
local wi, weight, pdf = ylm.ggx { alpha = 0.2 }:sample({ 0, 0, 1 }, { { 0.3, 0.6, 0.1 } })
assert(wi.shape[1] == 1 and weight:get(1, 1) >= 0 and pdf:get(1) > 0)]],
  source = "Heitz 2018; Dupuy & Benyoub 2023",
}
function methods.sample(m, wo, u, given)
  local made, message, code = open("sample", m)
  if not made then return nil, message, code end
  local o = form.options(3, "sample", options, given)
  local numbers = array.rows(2, "sample", "u", u, 3, "float")
  if #core.array_info(numbers) == 1 then numbers = core.array_reshape(numbers, { 1, 3 }) end
  local b, n = directions(1, "sample", "wo", wo), rows_of(numbers)
  if rows_of(b) ~= n and rows_of(b) ~= 1 then
    return check.bad(1, "sample", "wo: %d rows as in u, or one for all, expected, got %d", n, rows_of(b))
  end
  return check.result("sample", core.material_sample(made, b, numbers, outputs.of(3, "sample", o.out, "float",
    { { n, 3 }, { n, 3 }, { n } })))
end

local albedo_options = {
  { "azimuth", "number", min = -360, max = 360, default = 0, unit = "degrees", about = "of the directions, from the tangent" },
}

--- Directions at cosines to the normal and an azimuth in degrees, [n][3].
local function at_cosines(cosines, azimuth)
  local list, c, s = {}, math.cos(math.rad(azimuth)), math.sin(math.rad(azimuth))
  for i, z in ipairs(cosines) do
    local r = math.sqrt(math.max(0, 1 - z * z))
    list[i] = { r * c, r * s, z }
  end
  return array.array(list)
end

describe "material:albedo" {
  about = "The directional-hemispherical reflectance: the integral of f wi.z over wi, which is what leaves towards a direction "
    .. "where light of radiance 1 comes from everywhere.",
  arguments = { { "cosines", "array|table|number", "[n], of the direction's angle to the normal, above 0, to 1" },
    { "options?", "table", "" } },
  options = albedo_options,
  returns = { { "albedo", "array", "[n][3]" } },
  errors = "raises on cosines out of range; nil, message, code: memory",
  example = [[
local a = ylm.ggx { alpha = 0.5, f0 = 1 }:albedo { 1, 0.5 }
assert(math.abs(a:get(2, 1) - 1) < 2e-3)]],
}
function methods.albedo(m, cosines, given)
  local made, message, code = open("albedo", m)
  if not made then return nil, message, code end
  local o = form.options(2, "albedo", albedo_options, given)
  if type(cosines) == "number" then cosines = { cosines } end
  local list = core.array_totable((array.rows(1, "albedo", "cosines", cosines)))
  for i, z in ipairs(list) do
    if not (check.is_number(z) and z > 0 and z <= 1) then
      return check.bad(1, "albedo", "cosines: element %d must be a number > 0 and <= 1, got %s", i, check.describe(z))
    end
  end
  return check.result("albedo", core.material_reflectance(made, at_cosines(list, o.azimuth)))
end

local degrees_options = {
  { "error", "number", above = 0, max = 0.9, default = 0.1, about = "the part of a slice's norm that may be missed" },
  { "most", "integer", min = 0, max = core.limits.material_degrees, default = 60, about = "no higher degree is looked for" },
}

describe "material:degrees" {
  about = "The degree of spherical harmonics that the slices f wi.z of a material need, for views 0, 5, .. 85 degrees from the "
    .. "normal towards the tangent.",
  arguments = { { "options?", "table", "" } },
  options = degrees_options,
  returns = { { "degrees", "table", "18 integers; math.huge where a higher degree than `most` is needed" } },
  errors = "raises on a bad option; nil, message, code: memory",
  example = "assert(ylm.ggx { alpha = 0.5, f0 = 1, compensate = false }:degrees { error = 0.1, most = 4 }[1] == 3)",
}
function methods.degrees(m, given)
  local made, message, code = open("degrees", m)
  if not made then return nil, message, code end
  local o = form.options(1, "degrees", degrees_options, given)
  local angles, list = {}
  for i = 0, 17 do angles[i + 1] = math.rad(5 * i) end
  list, message, code = check.result("degrees", core.material_degrees(made, o.error, o.most, angles))
  if not list then return nil, message, code end
  for i, l in ipairs(list) do if l > o.most then list[i] = math.huge end end
  return list
end

--- n pairs of directions above the surface, from a sequence that fills the space: two arrays [n][3].
local function scattered(n)
  local a, b = {}, {}
  for i = 1, n do
    local u = {}
    for k = 1, 4 do u[k] = (0.5 + i * 1.1673039782614187 ^ -k) % 1 end
    for k, list in ipairs { a, b } do
      local z, turn = 1 - u[2 * k - 1], 2 * math.pi * u[2 * k]
      local r = math.sqrt(1 - z * z)
      list[i] = { r * math.cos(turn), r * math.sin(turn), z }
    end
  end
  return array.array(a), array.array(b)
end

local PAIRS = 4096

--- The largest difference of f from f with exchanged directions, over the larger of the two, and the share of negative f.
local function compare(made)
  local a, b = scattered(PAIRS)
  local there = core.array_totable(core.material_eval(made, a, b))
  local back = core.array_totable(core.material_eval(made, b, a))
  local worst, negative = 0, 0
  for i, f in ipairs(there) do
    for c = 1, 3 do
      local larger = math.max(math.abs(f[c]), math.abs(back[i][c]))
      if larger > 0 then worst = math.max(worst, math.abs(f[c] - back[i][c]) / larger) end
    end
    if math.min(f[1], f[2], f[3]) < 0 then negative = negative + 1 end
  end
  return worst, negative / PAIRS
end

describe "material:check" {
  about = "Tests a material: whether it reflects more light than comes, and equally in both directions.",
  arguments = {},
  returns = { { "facts", "table", "energy (the largest albedo of 20 views, 80 where it is anisotropic; more than 1 is more than "
    .. "comes), least (the smallest), reciprocity (the largest relative difference of f with exchanged directions, of 4,096 "
    .. "pairs), negative (the share of them whose f is negative; of a MERL table, of bins that are), isotropic" } },
  errors = "nil, message, code: memory",
  example = [[
local facts = ylm.ggx { alpha = { 0.1, 0.9 }, f0 = 1 }:check()
assert(facts.reciprocity < 1e-4 and facts.energy > 1.05)]],
}
function methods.check(m)
  local made, message, code = open("check", m)
  if not made then return nil, message, code end
  local facts, cosines = { energy = 0, least = math.huge, isotropic = core.material_isotropic(made) }, {}
  for i = 1, 20 do cosines[i] = i / 20 end
  for azimuth = 0, facts.isotropic and 0 or 135, 45 do
    local a = core.array_totable(core.material_reflectance(made, at_cosines(cosines, azimuth)))
    for _, c in ipairs(a) do
      facts.energy, facts.least = math.max(facts.energy, c[1], c[2], c[3]), math.min(facts.least, c[1], c[2], c[3])
    end
  end
  facts.reciprocity, facts.negative = compare(made)
  facts.negative = core.material_facts(made).negative or facts.negative
  return facts
end

return methods
