--- Materials as tables of spherical harmonics: material:table.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local object = require "ylm.material.object"
local progress = require "ylm.progress"

local methods = object.methods
local tables = core.metatable "ylm.material_table"

local function facts_of(t) return core.owned(t, "facts") end

require "ylm.describe".object "material_table" {
  about = "A material's slices f wi.z in spherical harmonics, at rows of elevation of the view and, of anisotropic materials, "
    .. "at columns of azimuth. It does not change.",
  fields = {
    { "lmax", "number", "highest degree" }, { "rows", "number", "of elevation, from 0 to 89.5 degrees" },
    { "columns", "number", "of azimuth; 1 of isotropic materials" },
    { "functions", "number", "scalar functions that the three channels are mixtures of, 1 to 3" },
    { "error", "number", "halfway between rows and between columns, relative to the slice: the largest, to 84 degrees" },
    { "grazing", "number", "the same beyond 84 degrees" },
    { "bytes", "number", "" }, { "seconds", "number", "that it took" },
  },
}

tables.__index = function(t, key)
  local facts = facts_of(t)
  local fact = facts and facts[key]
  if fact ~= nil then return fact end
  return rawget(tables, key)
end
tables.__newindex = function(_, key)
  return check.fail("material_table: cannot set %s: a table does not change", check.describe(key))
end
tables.__tostring = function(t)
  local f = facts_of(t)
  return ("ylm.material_table lmax %d, %d rows, %d columns"):format(f.lmax, f.rows, f.columns)
end

local FIT_LMAX = 8
local options = {
  { "lmax", "integer", min = 0, max = core.limits.material_table_lmax, default = 8, about = "highest degree" },
  { "rows", "integer", min = 4, max = core.limits.material_table_rows, default = 32,
    about = "of elevation, doubled until `error` is kept" },
  { "columns", "integer", min = 4, max = core.limits.material_table_rows, default = 64,
    about = "of azimuth, a multiple of 4, doubled likewise; isotropic materials have one" },
  { "error", "number", min = 0, max = 1, default = 0.002,
    about = "largest relative error halfway between rows, of views to 84 degrees; 0: as many rows as are given" },
  { "cosine", "boolean", default = true, about = "false: slices of f alone" },
  { "fit", "boolean", default = false,
    about = "instead, the functions of degree lmax, 8 at most, which times the clamped cosine come nearest to f wi.z (least "
      .. "squares above the surface, a ridge of 1e-4): what virtual lights send; `missed` is their error at any degree" },
  form.threads, form.progress,
}

describe "material:table" {
  about = "The slices f wi.z of a material in spherical harmonics, for every view: what shading by harmonics multiplies light "
    .. "with.",
  arguments = { { "options?", "table", "" } },
  options = options,
  returns = { { "table", "material_table", "" } },
  errors = "raises on a bad option; nil, message, code: memory, cancelled",
  example = [[
local t = ylm.ggx { alpha = 0.4, f0 = { 1, 0.8, 0.3 }, compensate = false }:table { lmax = 6 }
assert(t.functions == 2 and t.error < 0.002)]],
  source = "Kautz, Sloan, Snyder 2002",
}
function methods.table(m, given)
  if not object.is(m) then return check.fail("table: a material expected before the colon, got %s", check.describe(m)) end
  local o = form.options(1, "table", options, given)
  local made, message, code = object.made("table", m)
  if not made then return nil, message, code end
  if o.fit and not o.cosine then return check.fail "table: fit and cosine = false exclude each other: leave one out" end
  if o.fit and o.lmax > FIT_LMAX then return check.fail("table: lmax of fits is at most %d, got %d", FIT_LMAX, o.lmax) end
  o.slice, o.fit, o.cosine = o.fit and "fit" or o.cosine and "cosine" or "bare", nil, nil
  o.progress = progress.of(o.progress)
  local t, facts
  t, facts, code = check.result("table", core.material_table(made, o))
  if not t then return nil, facts, code end
  core.own(t).facts = facts
  return t
end

--- The table and wo as rows.
local function open(name, t, n, wo)
  if core.type(t) ~= "ylm.material_table" then
    return check.fail("%s: a material_table expected before the colon, got %s", name, check.describe(t))
  end
  local a, single = array.rows(n, name, "wo", wo, 3)
  local shape = core.array_info(a)
  if #shape > 2 then return check.bad(n, name, "wo: directions [n][3] expected, got %s", check.describe(a)) end
  return single and core.array_reshape(a, { 1, 3 }) or a
end

describe "material_table:slices" {
  about = "The coefficients of slices, in the surface's frame, cubic between rows and columns.",
  arguments = { { "wo", "array|table", "[n][3], to where light goes, above the surface, any length but 0" } },
  returns = { { "F", "array", "float [n][3][(lmax+1)^2]: radiance towards wo is its product with light's coefficients" } },
  errors = "raises on directions without length or below the surface; nil, message, code: memory",
  example = [[
local t = ylm.matte { albedo = 0.5 }:table { lmax = 2 }
local F = t:slices { 0, 0, 1 }
assert(math.abs(F:get(1, 1, 1) * math.sqrt(4 * math.pi) - 0.5) < 1e-4)]],
}
function tables.slices(t, wo)
  return check.result("slices", core.material_table_slices(t, open("slices", t, 1, wo)))
end

describe "material_table:missed" {
  about = "The part of a slice's norm that coefficients up to a degree miss.",
  arguments = { { "lmax", "integer", "from 0 to the table's" }, { "wo", "array|table", "[n][3]" } },
  returns = { { "error", "array", "float [n]" } },
  errors = "raises as slices",
  example = [[
local t = ylm.ggx { alpha = 0.5, f0 = 1 }:table { lmax = 8 }
assert(t:missed(4, { 0, 0, 1 }):get(1) > t:missed(8, { 0, 0, 1 }):get(1))]],
}
function tables.missed(t, lmax, wo)
  if core.type(t) ~= "ylm.material_table" then
    return check.fail("missed: a material_table expected before the colon, got %s", check.describe(t))
  end
  check.integer(1, "missed", "lmax", lmax, 0, facts_of(t).lmax)
  return check.result("missed", core.material_table_missed(t, lmax, open("missed", t, 2, wo)))
end

memory.publish(tables)

return tables
