--- Lights of a scene for a live window: spheres as rows that move, everything else, which stays.
--
-- A row is { at, radius, radiance, number }: number is the light's place in the scene's list, where each sphere of
-- `sphere_lights` counts as one (lua/ylm/scene/like.lua).

local array = require "ylm.array"
local core = require "ylm.c.core"
local form = require "ylm.form"
local light = require "ylm.light"
local sphere = require "ylm.light.sphere"

local lamps = {}

--- Rows of spheres, the other lights, and how many numbers there are.
function lamps.of(s)
  local rows, others, number = {}, {}, 0
  for _, l in ipairs(s.lights) do
    local kind = form.kind(l)
    if kind == "sphere_light" then
      number = number + 1
      rows[#rows + 1] = { at = { l.at[1], l.at[2], l.at[3] }, radius = l.radius,
        radiance = { l.radiance[1], l.radiance[2], l.radiance[3] }, number = number }
    elseif kind == "sphere_lights" then
      local at, radius, radiance = light.arrays(light.pack(1, "live", l))
      at, radius, radiance = core.array_totable(at), core.array_totable(radius), core.array_totable(radiance)
      for i = 1, l.count do
        rows[#rows + 1] = { at = at[i], radius = radius[i], radiance = radiance[i], number = number + i }
      end
      number = number + l.count
    else
      number = number + 1
      others[#others + 1] = l
    end
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
