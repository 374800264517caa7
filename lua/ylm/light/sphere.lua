--- Spheres that emit: ylm.sphere_light, ylm.sphere_lights.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local numbers = require "ylm.light.numbers"
local pack = require "ylm.light.pack"

local sphere = {}

local EXTENT = core.limits.extent

sphere.sphere_light = form.define("sphere_light", {
  shelf = "everyday",
  about = "A sphere that emits the same radiance everywhere and in every direction.",
  fields = {
    { "at", "point", unit = "scene units", about = "centre" },
    { "radius", "number", min = 0, max = EXTENT, default = 0.1, unit = "scene units",
      about = "a radius of 0 emits nothing" },
    { "radiance", "colour", default = 1, unit = "W sr^-1 m^-2",
      about = "number or {r, g, b}, linear Rec. 709; may be negative" },
    pack.photometric,
  },
  build = function(values, fail)
    for i = 1, 3 do
      if math.abs(values.at[i]) > EXTENT then
        return fail(("at is too far out (the limit is %s)"):format(check.limit_text(EXTENT)))
      end
    end
    return setmetatable(values, form.defined.sphere_light.metatable)
  end,
  light = {
    kind = "sphere",
    photometric = true,
    record = function(l, out)
      local n, c, at = #out, l.radiance, l.at
      out[n + 1], out[n + 2], out[n + 3], out[n + 4], out[n + 5], out[n + 6], out[n + 7] =
        c[1], c[2], c[3], at[1], at[2], at[3], l.radius
    end,
    spheres = function(l) return { l } end,
    gltf = function(w, l) w:sphere(l) end,
  },
  example = "sphere_light { at = {0, 2, 0}, radius = 0.1, radiance = {10, 8, 6} }",
})

-- Many of them ------------------------------------------------------------------------

local function build_lights(values, fail)
  local at, shape = numbers("at", values.at, "[n][3] numbers", function(s)
    return #s == 1 and s[1] == 0 or #s == 2 and s[2] == 3
  end, fail)
  local n = shape[1]
  form.take_numbers({ 4, n }, fail) -- besides `at`, whatever radius and radiance are
  local function one_each(s) return #s == 1 and (s[1] == 1 or s[1] == n) end
  local radius = numbers("radius", values.radius, ("a number or one for each of the %d lights"):format(n), one_each, fail)
  local radiance = numbers("radiance", values.radiance,
    ("a number, {r, g, b}, or one for each of the %d lights"):format(n), function(s)
      return one_each(s) or #s == 1 and s[1] == 3 or #s == 2 and s[1] == n and s[2] == 3
    end, fail)
  local packed, message, code = core.lights_spheres(at, radius, radiance)
  if not packed then
    if core.status(code) == "caller" then return fail(message) end
    return nil, message, code
  end
  return setmetatable({ lights = packed, count = n, photometric = values.photometric }, form.defined.sphere_lights.metatable)
end

--- The lights of arrays as rows.
local function rows_of(l)
  local at, radius, radiance = check.result("lights", core.lights_surfaces(l.lights, 1))
  if not at then return nil, radius, radiance end
  at, radius, radiance = core.array_totable(at), core.array_totable(radius), core.array_totable(radiance)
  local rows = {}
  for i = 1, l.count do rows[i] = { at = at[i], radius = radius[i], radiance = radiance[i] } end
  return rows
end

sphere.sphere_lights = form.define("sphere_lights", {
  shelf = "everyday",
  about = "Many sphere lights as one object, from arrays: fast to make and to use.",
  fields = {
    { "at", "any", unit = "scene units", about = "centres: an array or table [n][3]; empty: darkness" },
    { "radius", "any", default = 0.1, unit = "scene units", about = "[n] numbers, or one for all; 0 emits nothing" },
    { "radiance", "any", default = 1, unit = "W sr^-1 m^-2",
      about = "[n][3] linear Rec. 709 or [n], or a number or {r, g, b} for all; may be negative" },
    pack.photometric,
  },
  build = build_lights,
  light = {
    photometric = true,
    rows = function(l) return l.count end,
    row = "sphere_light",
    join = function(rows)
      local arrays = { at = {}, radius = {}, radiance = {} }
      for i, row in ipairs(rows) do arrays.at[i], arrays.radius[i], arrays.radiance[i] = row.at, row.radius, row.radiance end
      return sphere.sphere_lights(arrays)
    end,
    spheres = rows_of,
    gltf = function(w, l)
      local rows, message, code = rows_of(l)
      for _, row in ipairs(rows or {}) do w:sphere(row) end
      if not rows then return nil, message, code end
    end,
  },
  example = "sphere_lights { at = { {0, 2, 0}, {1, 2, 0} }, radius = { 0.1, 0.2 }, radiance = 10 }",
})

return sphere
