--- The light of a picture's shading points: options visibility, shading, and what the light of a grid is multiplied by.
--
--     visibility   light of lamps               a grid, or another field, of
--                                               lights       direct, indirect, all
--     "rays"       rays to the lamps            refused      cosine . L
--     "transfer"   T . L of the scene's probes  T . L        cosine . L
--     "self"       as "transfer", each surface in its own shadow alone: casters of shadowed light cast the others
--     "none"       cosine . L of these          cosine . L   cosine . L

local check = require "ylm.check"
local core = require "ylm.c.core"

local visibility = {}

--- The quantity that a field holds: "lights" (that nothing occludes), "direct", "indirect" or "all".
function visibility.quantity(field)
  return core.has_field(field) and (core.field_quantity(field)) or "lights"
end

--- Options of the ways that need them.
local of_transfer = { "transfer_samples", "occlusion_distance", "vectors_at" }

--- Raises where `given` has one of `names`, which options with o.visibility have no use for.
local function refuse(name, given, names, whose, o)
  for _, field in ipairs(names) do
    if type(given) == "table" and given[field] ~= nil then
      return check.fail("%s: %s is for %s, visibility is %q: name one that fits, or leave %s out", name, field, whose,
        o.visibility, field)
    end
  end
end

--- Settles o.visibility, "rays", "transfer" or "none"; `default` where none is given.
function visibility.settle(name, o, given, default)
  local v = o.visibility or default
  o.self = v == "self" -- "transfer", by rays that meet the own surface alone
  if o.self then v = "transfer" end
  o.visibility = v
  if o.visibility == "rays" then return refuse(name, given, of_transfer, 'visibility = "transfer"', o) end
end

--- Settles the options of a picture by o.grid, where there is one, or without: o.visibility as above. Returns
-- the quantity that the grid holds, or false.
function visibility.settle_picture(name, o, given)
  local held = o.grid ~= nil and visibility.quantity(o.grid)
  if held == "lights" and o.visibility == "rays" and not o.near_lights then
    return check.fail("%s: the grid holds lights without their shadows, which transfer vectors shade: name visibility = "
      .. '"transfer", or leave the grid out', name)
  end
  visibility.settle(name, o, given, (held == "lights" or not held) and not o.near_lights and "transfer" or "rays")
  if held and held ~= "lights" then o.visibility = "rays" end -- the grid knows all shadows
  if o.visibility == "rays" and not held then
    return check.fail('%s: by = "grid" without a grid bakes lights, which transfer vectors shade: visibility = "transfer", or '
      .. "give a grid", name)
  end
  return held
end

--- By what the prepared view p multiplies the light of a field: "transfer" or "cosine". Raises where it cannot. `near`: the
-- near parts of its lights are given, which are virtual and have no shadows.
function visibility.weight(name, p, field, near)
  local held = visibility.quantity(field)
  if held == "visibility" then return check.fail("%s: the grid holds visibility, which is no light", name) end
  if held ~= "lights" then return "cosine" end
  if p.options.visibility ~= "rays" then return "transfer" end
  if near then return "cosine" end
  return check.fail("%s: %s holds lights without their shadows, which transfer vectors shade, and the view has none: prepare it "
    .. 'with visibility = "transfer"', name, check.describe(field))
end

--- Raises where a prepared view has no transfer vectors.
function visibility.need_transfer(name, p)
  if p.options.visibility ~= "rays" then return end
  return check.fail('%s: the view has no transfer vectors: prepare it with visibility = "transfer"', name)
end

return visibility
