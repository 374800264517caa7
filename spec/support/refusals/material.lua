-- Refusals of materials and their methods.

local nan, inf = 0 / 0, math.huge

--- Refusals of a form: { fields, says }, ...
local function form(name, cases)
  local out = {
    { call = function(ylm) return ylm[name]() end, says = name .. ": a table of named fields expected, got nil" },
    { call = function(ylm) return ylm[name] { 0.5 } end, says = "fields are given by name" },
    { call = function(ylm)
      local m = ylm.matte {}
      m.albedo = 1
    end, says = "material: cannot set 'albedo': a material does not change" },
  }
  for i, c in ipairs(cases) do
    out[i + 3] = { call = function(ylm)
      local m, message = ylm[name](c[1])
      return m, message
    end, says = c[2] }
  end
  return out
end

--- Refusals of a method: on something else, and with arguments.
local function method(name, cases)
  local out = { { call = function(ylm)
    local r, message = ylm.ggx {}[name]({}, {}, {})
    return r, message
  end, says = name .. ": a material expected before the colon, got a table" } }
  for i, c in ipairs(cases or {}) do
    out[i + 1] = { call = function(ylm)
      local m = ylm.ggx {}
      local r, message = m[name](m, c[1], c[2], c[3])
      return r, message
    end, says = c[4] }
  end
  return out
end

--- Such calls of a table of a material, made once.
local function table_method(name, cases)
  local t
  local out = { { call = function(ylm) return ylm.ggx {}:table { lmax = 1, rows = 4, error = 0 }[name]({}, {}, {}) end,
    says = name .. ": a material_table expected before the colon, got a table" } }
  for i, c in ipairs(cases) do
    out[i + 1] = { call = function(ylm)
      t = t or ylm.ggx {}:table { lmax = 1, rows = 4, error = 0 }
      return t[name](t, c[1], c[2])
    end, says = c[3] }
  end
  return out
end

local up = { 0, 0, 1 }

return {
  ggx = form("ggx", {
    { { alhpa = 1 }, "did you mean 'alpha'" }, { { alpha = 0 }, "alpha must be a number from 0.001 to 1, or two" },
    { { alpha = 1.01 }, "alpha must be .* got 1.01" }, { { alpha = nan }, "alpha must be" },
    { { alpha = { 0.1, 0 } }, "alpha must be .* got {0.1, 0}" }, { { alpha = { 0.1 } }, "alpha must be" },
    { { alpha = { 0.1, 0.2, 0.3 } }, "alpha must be" }, { { f0 = -0.1 }, "f0 must be a number or {r, g, b}" },
    { { f0 = { 1, 1, 1.5 } }, "f0 must be .* <= 1" }, { { base = 2 }, "base must be" }, { { base = inf }, "base must be" },
    { { compensate = 1 }, "compensate must be true or false" },
  }),
  phong = form("phong", {
    { { exponent = -1 }, "exponent must be a number >= 0 and <= 100000, got %-1" },
    { { exponent = 2e5 }, "exponent must be" }, { { exponent = nan }, "exponent must be" },
    { { specular = 2 }, "specular must be" }, { { base = -1 }, "base must be" },
    { { specular = 0.6, base = { 0.1, 0.5, 0.1 } },
      "phong: base %+ specular must not be more than 1, .* their green is 1.1" },
  }),
  abc = form("abc", {
    { {}, "field 'kd' is missing %(or give fit" }, { { kd = 1, a = 1, b = 1, c = 1 }, "field 'ior' is missing" },
    { { fit = "gold-metalic-paint" }, "no fit 'gold%-metalic%-paint' %(did you mean 'gold%-metallic%-paint'%?%)" },
    { { fit = "x" }, "no fit 'x'; there are 100" }, { { fit = "chrome", b = 2 }, "fit gives b: leave one of the two out" },
    { { kd = 1, a = 1, b = 1, c = 1, ior = 0.9 }, "ior must be a number >= 1" },
    { { fit = "chrome", scale = -1 }, "scale must be" }, { { kd = 2, a = 1, b = 1, c = 1, ior = 2 }, "kd must be" },
  }),
  ["material:eval"] = method("eval", {
    { nil, up, nil, "#1.*wi: a table of numbers or an array expected, got nil" },
    { up, { 1, 2 }, nil, "#2.*wo: rows of 3 numbers expected" },
    { { up, up }, { up, up, up }, nil, "#2.*wo: 2 rows, or one for all, expected, got 3" },
    { { up, { 0, 0, 0 } }, up, nil, "eval: wi: row 2 has no direction" }, { up, { 0, nan, 1 }, nil, "wo: row 1 has no direction" },
    { up, up, { out = 5 }, "out must be an array" }, { up, up, 5, "a table of options expected" },
  }),
  ["material:pdf"] = method("pdf", {
    { up, 5, nil, "#2.*wo: a table of numbers" }, { { up, up }, { up, up, up }, nil, "wo: 2 rows, or one for all" },
    { { inf, 0, 0 }, up, nil, "wi: row 1 has no direction" }, { up, up, { outs = 1 }, "no field 'outs'" },
  }),
  ["material:sample"] = method("sample", {
    { up, nil, nil, "#2.*u: a table of numbers" }, { up, { { 0.1, 0.2 } }, nil, "u: rows of 3 numbers" },
    { up, { { 0, 0, 0 }, { 0, 1, 0 } }, nil, "u: row 2 has 1: numbers from 0, below 1" },
    { up, { { 0, nan, 0 } }, nil, "u: row 1" }, { { up, up }, { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }, nil, "wo: 3 rows as in u" },
    { { 0, 0, 0 }, { 0, 0, 0 }, nil, "wo: row 1 has no direction" },
  }),
  ["material:albedo"] = method("albedo", {
    { nil, nil, nil, "cosines: a table of numbers" }, { { 1, 0 }, nil, nil, "cosines: element 2 must be a number > 0 and <= 1, got 0" },
    { 1.5, nil, nil, "element 1 must be" }, { { nan }, nil, nil, "element 1 must be" },
    { 1, { azimuth = 400 }, nil, "azimuth must be a number >= %-360 and <= 360" },
  }),
  ["material:degrees"] = method("degrees", {
    { { error = 0 }, nil, nil, "error must be a number > 0" }, { { error = 1 }, nil, nil, "error must be" },
    { { most = 101 }, nil, nil, "most must be an integer" }, { 5, nil, nil, "a table of options expected" },
  }),
  ["material:slice"] = method("slice", {
    { { angle = 91 }, nil, nil, "angle must be a number >= 0 and <= 90" }, { { count = 1 }, nil, nil, "count must be" },
    { { cosine = 1 }, nil, nil, "cosine must be true or false" },
  }),
  ["material:lobe"] = method("lobe", {
    { { divide = 4 }, nil, nil, "divide must be an integer >= 8" }, { { scale = 0 }, nil, nil, "scale must be a number > 0" },
    { { angles = 1 }, nil, nil, "did you mean 'angle'" },
  }),
  ["material:table"] = method("table", {
    { { lmax = 61 }, nil, nil, "lmax must be an integer" }, { { rows = 3 }, nil, nil, "rows must be an integer" },
    { { error = -1 }, nil, nil, "error must be" }, { { row = 9 }, nil, nil, "no field 'row' %(did you mean 'rows'%?%)" },
    { { cosine = 1 }, nil, nil, "cosine must be true or false" },
  }),
  ["material_table:slices"] = table_method("slices", {
    { nil, nil, "#1.*wo: a table of numbers" }, { { 0, 0, -1 }, nil, "row 1 is below the surface" },
    { { { 0, 0, 1 }, { 0, nan, 1 } }, nil, "row 2 has no direction" },
  }),
  ["material_table:missed"] = table_method("missed", {
    { 2, { 0, 0, 1 }, "lmax" }, { 0, 5, "#2.*wo: a table of numbers" }, { 0, { 0, 0, 0 }, "row 1 has no direction" },
  }),
  ["material:check"] = method("check"),
}
