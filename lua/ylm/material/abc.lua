--- The ABC model, and its published fits to the materials of the MERL database.

local check = require "ylm.check"
local fits = require "ylm.material.abc_fits"
local form = require "ylm.form"
local object = require "ylm.material.object"

local names = {}
for name in pairs(fits) do names[#names + 1] = name end
table.sort(names)

--- Fills in the fields that a fit gives, or refuses them beside one.
local function complete(m, fail)
  local wanted = { "kd", "a", "b", "c", "ior" }
  if m.fit then
    local fit = fits[m.fit]
    if not fit then
      local guess = check.guess(m.fit, names)
      return fail(("there is no fit '%s'%s"):format(check.short(m.fit), guess and (" (did you mean '%s'?)"):format(guess)
        or ("; there are " .. #names .. ", such as '" .. names[1] .. "'")))
    end
    for _, name in ipairs(wanted) do
      if m[name] then return fail(("fit gives %s: leave one of the two out"):format(name)) end
    end
    m.kd, m.a = { fit[1], fit[2], fit[3] }, { fit[4], fit[5], fit[6] }
    m.b, m.c, m.ior = fit[7], fit[8], fit[9]
    return
  end
  for _, name in ipairs(wanted) do
    if not m[name] then return fail(("field '%s' is missing (or give fit, the name of a published one)"):format(name)) end
  end
end

local abc = form.define("abc", {
  about = "A microfacet model whose lobes have long tails (Loew et al. 2012). Its fits to measured materials are as printed: "
    .. "their absolute scale is open by a factor of pi.",
  fields = {
    { "fit", "string", optional = true, about = "the name of a published fit, such as 'gold-metallic-paint', instead of "
      .. "the five fields that follow" },
    { "kd", "colour", min = 0, max = 1, optional = true, about = "albedo of the matte part" },
    { "a", "colour", min = 0, max = 1e6, optional = true, about = "the lobe's height" },
    { "b", "number", min = 0, max = 1e8, optional = true, about = "the lobe is narrow where b is large" },
    { "c", "number", min = 0, max = 100, optional = true, about = "how fast its tail falls" },
    { "ior", "number", min = 1, max = 1000, optional = true, about = "index of refraction" },
    { "scale", "number", min = 0, max = 100, default = 1, about = "multiplies all that is reflected; 1: as printed" },
  },
  material = function(m, fail)
    complete(m, fail)
    local kd, a = m.kd, m.a
    return { kd[1], kd[2], kd[3], a[1], a[2], a[3], m.b, m.c, m.ior, m.scale }
  end,
  numbers = 64,
  metatable = object.metatable(),
  build = object.builder "abc",
  example = 'abc { fit = "gold-metallic-paint" }',
})

return abc
