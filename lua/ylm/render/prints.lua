--- Fingerprints of what a grid was baked from, beside those of the scene that it lights.

local core = require "ylm.c.core"
local warning = require "ylm.warning"

local prints = {}

local PARTS = { "geometry", "materials", "lights" }

--- Quantity -> the parts of a scene that such light depends on.
local needed = {
  lights = { lights = true },
  direct = { geometry = true, lights = true },
  indirect = { geometry = true, materials = true, lights = true },
  all = { geometry = true, materials = true, lights = true },
}

--- The fingerprints of a traced scene that are `wanted`, a set of parts. They are made once.
local function of_traced(t, wanted)
  local known = t.prints or {}
  t.prints = known
  if wanted.lights and not known.lights then known.lights = t.lib.scene_print_lights(t.handle) end
  if (wanted.geometry or wanted.materials) and not known.geometry then
    known.geometry, known.materials = t.lib.scene_print(t.handle)
  end
  local out = {}
  for part in pairs(wanted) do out[part] = known[part] end
  return out
end

--- Of all fingerprints of a scene the ones that such light depends on.
function prints.needed(all, quantity)
  local out = {}
  for part in pairs(needed[quantity]) do out[part] = all[part] end
  return out
end

--- The fingerprints that a grid of such light of a traced scene carries.
function prints.of(t, quantity) return of_traced(t, needed[quantity]) end

--- The words for parts of a scene: "geometry, materials and lights".
local function words(list)
  if #list == 1 then return list[1] end
  return table.concat(list, ", ", 1, #list - 1) .. " and " .. list[#list]
end

--- Says that a grid holds light of another scene than s, traced as t: the sentence, or nil where it does not, or nobody knows.
-- `apart`: a set of parts that are not compared.
function prints.warn(grid, s, t, apart)
  local kind = core.type(grid)
  local own = (kind == "ylm.grid" or kind == "ylm.grid_set") and grid.prints
    or kind == "ylm.surface_grid" and core.owned(grid, "made").prints
  if not own then return nil end
  local there, other = of_traced(t, own), {}
  for _, part in ipairs(PARTS) do
    if own[part] ~= there[part] and not (apart and apart[part]) then other[#other + 1] = part end
  end
  if #other == 0 then return nil end
  local path = core.owned(grid, "path")
  return warning.say(grid, "prints " .. table.concat(other, " "), "%s was baked from other %s than scene %q has: the light is "
    .. "not the scene's; bake it anew, or give the scene it is of", path and "grid " .. path or "the grid", words(other),
    s.name or "?")
end

--- Says that a grid of the options of a picture, or of radiance, holds light of another scene; a list of the sentences.
-- Lights and materials that options name in place of the scene's are not compared.
function prints.say(p, o)
  local apart, said = { lights = o.lights ~= nil, materials = o.materials ~= nil }, {}
  local bounced = o.reflected and (o.reflected.grid or o.reflected.surfaces) or nil
  for _, grid in ipairs { o.grid or false, bounced } do said[#said + 1] = prints.warn(grid, p.scene, p.traced, apart) end
  return said
end

return prints
