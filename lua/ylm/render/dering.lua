--- Windows against light below zero: coefficients cut at a degree ring, and pictures made of them have black places.
--
-- Radiance is linear in the light's coefficients, so the pictures of its degrees alone make that of any window.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local warning = require "ylm.warning"
local window = require "ylm.sh.window"

local dering = {}

local MOST = 0.001            -- of a picture's light that may be below zero without a word
local WIDEST, NARROWEST = 8, 0.5 -- of windows that are tried, in degrees: times lmax + 1, and at the end
local STEP, HALVINGS = 0.9, 12

function form.types.dering(x)
  if type(x) == "boolean" or check.is_number(x) and x > 0 and x < math.huge then return x end
  return nil, "true, false, or the width of a Hann window, a number of degrees above 0"
end

dering.fields = {
  { "dering", "dering", optional = true,
    about = "of a grid's light: true: the widest Hann window that leaves at most 0.1 % of the picture's light below zero, which "
      .. "is chosen by default too; a number: a window of that width in degrees, for films; false: none. report.dering = "
      .. "{ before, after: the part of the light below zero; width }" },
}

--- The part of the light of radiance [points][3] that is below zero.
local function below(radiance)
  local all = radiance:clamp(-math.huge, 0):sum()
  local lit = radiance:clamp(0, math.huge):sum()
  return all < 0 and -all / (lit - all) or 0
end

--- Radiance by a window's factors; or nil, message, code.
local function shade(device, name, p, o, bar, factors)
  o.window = factors
  local radiance, done, code = device:shade(name, p, o, bar)
  o.window = nil
  return radiance, done, code
end

--- Radiance of each degree alone, a list from degree 0 on; or nil, message, code.
local function parts_of(device, name, p, o, bar)
  local parts = {}
  for l = 0, o.grid.lmax do
    local one = {}
    for k = 0, o.grid.lmax do one[k + 1] = k == l and 1 or 0 end
    local radiance, message, code = shade(device, name, p, o, bar, one)
    if not radiance then return nil, message, code end
    parts[l + 1] = radiance
  end
  return parts
end

--- The sum of parts by a window.
local function mixed(parts, width)
  local factors, sum = window.factors("hann", width, #parts - 1), parts[1] * 1
  for l = 2, #parts do
    if factors[l] ~= 0 then sum = sum + parts[l] * factors[l] end
  end
  return sum
end

--- The widest window of which a part of MOST is below zero, or nil: there is none.
local function widest(parts)
  local wide, narrow = WIDEST * #parts, nil
  while wide > NARROWEST and not narrow do
    local next_width = wide * STEP
    if below(mixed(parts, next_width)) <= MOST then narrow = next_width else wide = next_width end
  end
  for _ = 1, narrow and HALVINGS or 0 do
    local middle = (narrow + wide) / 2
    if below(mixed(parts, middle)) <= MOST then narrow = middle else wide = middle end
  end
  return narrow
end

--- Radiance of the shading points of p under o.grid by a window where it is needed, and what device:shade says, with `dering`
-- = { before, after, width }; or nil, message, code.
local function dering_shade(device, name, p, o, bar)
  local radiance, done, code = device:shade(name, p, o, bar)
  if not radiance or core.type(o.grid) ~= "ylm.grid" then return radiance, done, code end
  local before = below(radiance)
  local found = { before = before, after = before }
  done.dering = found
  if o.dering == false or o.grid.lmax == 0 or type(o.dering) ~= "number" and before <= MOST then return radiance, done end
  local damped, message
  if type(o.dering) == "number" then
    found.width = o.dering
    damped, message, code = shade(device, name, p, o, bar, window.factors("hann", o.dering, o.grid.lmax))
  else
    damped, message, code = parts_of(device, name, p, o, bar)
    if damped then
      found.width = widest(damped)
      damped = found.width and mixed(damped, found.width) or radiance
    end
  end
  if not damped then return nil, message, code end
  found.after = below(damped)
  return damped, done
end

--- Radiance of the shading points of p under o.grid, and what device:shade says, with `dering` = { before, after, width,
-- clipped }; or nil, message, code. In grids with sides what a window leaves below zero becomes 0.
function dering.shade(device, name, p, o, bar)
  local radiance, done, code = dering_shade(device, name, p, o, bar)
  local found = radiance and done.dering
  if not found or o.dering == false or not o.grid.sides or found.after == 0 then return radiance, done, code end
  found.clipped, found.after = found.after, 0
  return radiance:clamp(0, math.huge), done
end

--- The share below zero of a picture that a device made, which has no windows; nil where it stays there.
function dering.of_device(o, layer)
  if core.type(layer) ~= "ylm.array" or core.type(o.grid) ~= "ylm.grid" then return nil end
  local share = below(layer)
  return { before = share, after = share, bare = true }
end

--- Says how much of a picture's light was below zero, and what became of it.
function dering.report(p, o, report, found)
  report.dering = found
  if not found or found.before <= MOST then return end
  local begin = ("scene %q: %.2g %% of the picture's light was below zero, since harmonics of degree %d ring: "):format(
    p.scene.name or "?", 100 * found.before, o.grid.lmax)
  local rest
  if found.width then
    rest = ("a window of width %.2f leaves %.2g %% (dering = false: none)"):format(found.width, 100 * found.after)
  elseif found.bare then rest = "a device has no window against it, render without device"
  elseif o.dering == false then rest = "a higher lmax rings less, dering = true damps it"
  else rest = "no window helps, voxels are too large for the light: set a smaller tolerance or more depth" end
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "dering", "%s%s", begin, rest)
end

return dering
