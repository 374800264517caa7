--- Isotropic materials that a function describes: its values fill the bins of MERL's files.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local memory = require "ylm.memory"
local object = require "ylm.material.object"

--- Every so many bins the function is asked with both directions exchanged, too.
local EXCHANGED = 13

--- Values that exchanged directions have may differ by this part of the larger.
local TOLERANCE = 1e-3

local function place(theta_i, theta_o, dphi)
  return ("theta_i = %.6g, theta_o = %.6g, dphi = %.6g"):format(theta_i, theta_o, dphi)
end

local function is_good(x) return type(x) == "number" and x >= 0 and x < math.huge end

--- f's values as three numbers; one stands for all.
local function asked(f, fail, theta_i, theta_o, dphi)
  local r, g, b = f(theta_i, theta_o, dphi)
  if g == nil and b == nil then g, b = r, r end
  if is_good(r) and is_good(g) and is_good(b) then return r, g, b end
  local wrong = r
  if is_good(r) then wrong = g end
  if is_good(r) and is_good(g) then wrong = b end
  return fail(("f must return finite numbers that are not negative, got %s at %s"):format(check.describe(wrong),
    place(theta_i, theta_o, dphi)))
end

local function apart(a, b) return math.abs(a - b) > TOLERANCE * math.max(a, b) end

--- Fails unless f has these values where the directions are exchanged.
local function check_exchanged(f, fail, theta_i, theta_o, dphi, r, g, b)
  local r2, g2, b2 = asked(f, fail, theta_o, theta_i, -dphi)
  if apart(r, r2) or apart(g, g2) or apart(b, b2) then
    return fail(("f must be the same with both directions exchanged, but is {%.6g, %.6g, %.6g} at %s and "
      .. "{%.6g, %.6g, %.6g} at %s"):format(r, g, b, place(theta_i, theta_o, dphi), r2, g2, b2,
      place(theta_o, theta_i, -dphi)))
  end
end

--- The values of the bins at theta_h, counted from 0; -1 where a direction is not above the surface.
local function row(f, fail, theta_h)
  local angles = core.material_bin_angles(theta_h)
  for i = 1, #angles, 3 do
    local theta_i, theta_o, dphi = angles[i], angles[i + 1], angles[i + 2]
    local r, g, b = -1, -1, -1
    if theta_i >= 0 then
      r, g, b = asked(f, fail, theta_i, theta_o, dphi)
      if (theta_h + (i - 1) / 3) % EXCHANGED == 0 then
        check_exchanged(f, fail, theta_i, theta_o, dphi, r, g, b)
      end
    end
    angles[i], angles[i + 1], angles[i + 2] = r, g, b
  end
  return angles
end

local tabulated = form.define("tabulated", {
  about = "An isotropic reciprocal material that a function describes. The function fills a table like MERL's when the material "
    .. "is made, which takes a second.",
  fields = {
    { "f", "function", about = "f(theta_i, theta_o, dphi) returns sr^-1, a number or red, green, blue: the angles of the "
      .. "light's direction and the eye's from the normal, and azimuth of the light less azimuth of the eye, in radians" },
  },
  trusted = true, -- functions are no data: scene files do not have it
  material = function(values, fail)
    local theta_h, theta_d, phi_d = core.material_bins()
    local bins = array.zeros({ theta_h, theta_d, phi_d, 3 }, "float")
    local fill = memory.users(function()
      for i = 0, theta_h - 1 do core.material_fill_bins(bins, i, row(values.f, fail, i)) end
    end)
    fill()
    local made, message, code = core.material_tabulate(bins)
    if not made then return nil, message, code end
    return {}, made
  end,
  metatable = object.metatable(),
  build = object.builder "tabulated",
  example = "tabulated { f = function() return 0.5 / math.pi end }",
})

return tabulated
