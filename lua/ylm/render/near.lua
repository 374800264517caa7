--- Near parts of virtual lights (lights:split) in pictures by a grid of the far parts: option near_lights.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local progress = require "ylm.progress"
local visibility = require "ylm.render.visibility"
local warning = require "ylm.warning"

local near = {}

near.fields = {
  { "near_lights", "object", of = "virtual_lights", optional = true, shelf = "experiments",
    about = "of a picture by a grid of the far parts of virtual lights (lights:split): their near parts, summed at every "
      .. "shading point; where a view has transfer vectors, as coefficients" },
}

--- Raises where o.near_lights is no near part, or there is no grid for it.
function near.settle(name, o)
  local x = o.near_lights
  if not x then return end
  if x.profile ~= "near" then
    return check.fail("%s: near_lights is the near part of lights:split, these lights are of profile '%s'%s", name, x.profile,
      x.profile == "far" and ": that is what the grid is baked of" or "")
  end
  local grid = o.grid
  if o.reflected and o.reflected.grid then grid = o.reflected.grid end
  if grid == nil then
    return check.fail("%s: near lights lack their far parts: give grid = scene:bake { lights = far, .. }, or leave "
      .. "near_lights out", name)
  end
  if visibility.quantity(grid) ~= "lights" then
    return check.fail("%s: near_lights: the grid holds %s light, no far parts of virtual lights: leave one out", name,
      visibility.quantity(grid))
  end
end

--- Sums near parts at the shading points, added to `radiance`: it and { pairs, seconds }; or nil, message, code.
function near.add(name, p, lights, weight, lmax, o, radiance)
  return check.result(name, p.lib.shade_near(p.view, lights.lights, weight, lmax, radiance, o.threads or 0,
    progress.resolve(o.progress)))
end

--- The degree of the light of a grid, or another field, in a picture.
function near.degree(p, grid)
  return core.type(grid) == "ylm.grid" and grid.lmax or p.options.lmax
end

--- The entry o.nearby of a picture by o.grid: { add =, pairs =, seconds = }, or nil.
function near.of_grid(o)
  if not o.near_lights or o.reflected and o.reflected.grid then return nil end
  local x = {}
  function x.add(name, p, options, radiance)
    local out, facts, code = near.add(name, p, o.near_lights, o.weight, near.degree(p, o.grid), options, radiance)
    if not out then return nil, facts, code end
    x.pairs, x.seconds = facts.pairs, facts.seconds
    return out
  end
  return x
end

--- Says that virtual lights have no shadows; `passing`: the part of their light in the picture that passes walls, where it is
-- known.
function near.say_walls(p, report, passing)
  local much = passing and ("%.0f %% of their light here passes them, whatever their number: "):format(100 * passing) or ""
  report.warnings[#report.warnings + 1] = warning.say(p.scene, "virtual walls", "scene %q: virtual lights shine through walls: "
    .. "%sshadows = 'centre' has a ray to each, links (bounces = ..) have true shadows", p.scene.name or "?", much)
end

--- Completes report and metadata of a picture with near lights.
function near.report(p, o, report, image)
  local lights = o.near_lights
  if not lights then return end
  local x = o.nearby or o.reflected.nearby
  report.near = { lights = lights.count, core = lights.core, pairs = x.pairs }
  report.seconds.near = x.seconds
  if o.nearby then report.seconds.image = report.seconds.image - x.seconds end
  if p.options.visibility == "rays" then near.say_walls(p, report) end
  if core.type(image) == "ylm.image" then
    image.metadata.near = ("%d lights, core %.6g"):format(lights.count, lights.core)
  end
end

--- Is it a set of virtual lights, or a list that holds one?
function near.is_virtual(lights)
  if form.kind(lights) == "virtual_lights" then return true end
  for _, l in ipairs(type(lights) == "table" and form.kind(lights) == nil and lights or {}) do
    if form.kind(l) == "virtual_lights" then return true end
  end
  return false
end

return near
