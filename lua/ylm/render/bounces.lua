--- Light that bounces in a picture: whether it is wanted, and by which way.

local check = require "ylm.check"
local choose = require "ylm.render.choose"
local core = require "ylm.c.core"
local devices = require "ylm.device"
local near = require "ylm.render.near"
local objects = require "ylm.transfer.object"
local tracing = require "ylm.trace"
local visibility = require "ylm.render.visibility"

local bounces = {}

--- The bounces of a picture that names none: all of scene:render by rays where there is something to send light on.
local function default_of(o, s, whole)
  if o.bounced ~= nil then return "all" end
  return whole and o.direct.name == "rays" and #s.geometry > 0 and #s.lights > 0 and "all" or 0
end

--- The way that o.bounced means; raises where it is none.
local function way_of(name, o)
  for _, way in ipairs(choose.bounced) do
    if way.wants(o) then return way end
  end
  local x = o.bounced
  return check.fail("%s: bounced must be 'links', 'virtual', what scene:links, links:radiosity or scene:surface_grid returned, a "
    .. "grid of indirect light or virtual lights, got %s%s", name, check.describe(x),
    core.has_field(x) and " of " .. visibility.quantity(x) or "")
end

--- Settles o.reflected of a picture of scene `s`, nil where nothing bounces, and o.near_lights. `whole`: of scene:render.
function bounces.settle(name, o, s, whole)
  if o.links then objects.check_scene(name, o.links, s) end
  if not o.direct.alone then
    local way, count = way_of(name, o), o.bounces
    if count == nil then count = default_of(o, s, whole) end
    local b = way.settle(name, o, s, count)
    if b then
      local held = o.grid ~= nil and visibility.quantity(o.grid)
      if held == "all" or held == "indirect" then
        return check.fail("%s: the grid holds bounces already: leave bounces and bounced out, or bake quantity = 'direct'", name)
      end
      devices.of(o.device):check_rays(name)
      b.record, b.unasked, o.reflected = way, o.bounces == nil and o.bounced == nil, b
    end
  end
  near.settle(name, o)
end

--- Other lamps than the view's: o.lit, traced, from o.lights, or those that light o.bounced. True, or nil, message, code.
function bounces.relight(name, p, o)
  local by = o.direct.name
  if o.lights ~= nil and (by == "rays" or by == "none") then
    local lit, message, code = tracing.relight(name, p.traced, o.lights)
    if not lit then return nil, message, code end
    tracing.check_bodies(name, lit)
    o.lit = lit
  elseif o.reflected and o.reflected.lit then
    o.lit = objects.made(o.reflected.lit).lit_by
  end
  return true
end

--- Completes the report of a picture in which nothing bounces, but for the light that its grid holds.
function bounces.omitted(o, report, image)
  local held = o.grid ~= nil and visibility.quantity(o.grid)
  report.bounces = (held == "all" or held == "indirect") and "those of the grid" or 0
  if core.type(image) == "ylm.image" then image.metadata.bounces = tostring(report.bounces) end
  if report.bounces == 0 then report.omits = 'light that bounces (bounces = 0; bounces = "all" has it)' end
  if held == "indirect" then report.omits = "direct light (scene:render { bounced = grid } has it)" end
end

--- Completes the times of a picture in which light bounces, and says how often.
function bounces.report(o, report, image)
  local b, seconds = o.reflected, report.seconds
  report.bounces = (b.grid or b.surfaces) and "those of the grid" or b.bounces
  report.bounced, image.metadata.bounces = b.record.name, tostring(report.bounces)
  seconds.bounces, seconds.bounced = b.prepared, b.seconds
  seconds.image = seconds.image - b.seconds
  seconds.total = seconds.total + (b.prepared or 0)
end

return bounces
