--- Lights of a scene for a live window: spheres as rows that move, everything else, which stays.
--
-- A row is { at, radius, radiance, number }: number is the light's place in the scene's list, where each light of
-- many counts as one (lua/ylm/scene/like.lua).

local array = require "ylm.array"
local light = require "ylm.light"
local sphere = require "ylm.light.sphere"

local lamps = {}

--- Rows of spheres, the other lights, and how many numbers there are.
function lamps.of(s)
  local rows, others, number = {}, {}, 0
  for _, l in ipairs(s.lights) do
    local as_light = light.form_of(l)
    local spheres = as_light and as_light.spheres and as_light.spheres(l)
    for i, one in ipairs(spheres or {}) do
      local at, c = one.at, one.radiance
      rows[#rows + 1] = { at = { at[1], at[2], at[3] }, radius = one.radius, radiance = { c[1], c[2], c[3] },
        number = number + i }
    end
    if not spheres then others[#others + 1] = l end
    number = number + light.rows(l)
  end
  return rows, others, number
end

local cache = {}
cache.__index = cache

--- Keeps arrays of rows, of which only those that change are written.
function lamps.cache() return setmetatable({ rows = {}, n = -1 }, cache) end

local function write(self, i, row)
  local at, c = row.at, row.radiance
  for a = 1, 3 do
    self.at:set(i, a, at[a])
    self.radiance:set(i, a, c[a])
  end
  self.radius:set(i, row.radius)
  self.rows[i] = row
end

--- The rows as one light; the same object as long as they are the same.
function cache.light(self, rows)
  local n, fresh = #rows, false
  if n ~= self.n then
    self.n, self.rows, fresh = n, {}, true
    if n > 0 then
      self.at, self.radius = array.zeros({ n, 3 }, "double"), array.zeros({ n }, "double")
      self.radiance = array.zeros({ n, 3 }, "double")
    end
  end
  for i = 1, n do
    if self.rows[i] ~= rows[i] then
      write(self, i, rows[i])
      fresh = true
    end
  end
  if fresh or not self.made then
    if n == 0 then self.made = sphere.sphere_lights { at = {} }
    else self.made = sphere.sphere_lights { at = self.at, radius = self.radius, radiance = self.radiance } end
  end
  return self.made
end

return lamps
