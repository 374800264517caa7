--- Light of probes that a scene's camera sees: irradiance at the surfaces behind W x H pixels, for pictures beside each other.

local ylm = require "ylm"

local seen = {}
seen.__index = seen

seen.size = { 144, 96 }
local SAMPLES = 512 -- paths a pixel

--- { points, normals, pixels [n], all_points: those of the truth, then these, all_normals }; its paths are kept in the folder.
function seen.of(entry, scene, truth, folder)
  local w, h = seen.size[1], seen.size[2]
  local view = assert(scene:prepare { size = seen.size, samples = 1, progress = false })
  local function layer(name, channels) return view:layer(name):reshape { w * h, channels }:totable() end
  local position, normal, covered = layer("position", 3), layer("normal", 3), layer("coverage", 1)
  local emits = layer("emitter", 1)
  view:close()
  local s = setmetatable({ points = {}, normals = {}, pixels = {}, all_points = {}, all_normals = {}, name = folder .. "/"
    .. entry.name .. ".seen.", from = #truth.points }, seen)
  for i = 1, w * h do
    if covered[i][1] > 0.5 and emits[i][1] < 0.5 then
      table.insert(s.points, position[i])
      table.insert(s.normals, normal[i])
      table.insert(s.pixels, i)
    end
  end
  for _, name in ipairs { "points", "normals" } do
    local all = s["all_" .. name]
    for _, list in ipairs { truth[name], s[name] } do for _, x in ipairs(list) do all[#all + 1] = x end end
  end
  local file = io.open(s.name .. "paths.npy")
  if file then file:close()
  else
    s:keep("paths", assert(scene:probe { points = s.points, normals = s.normals, samples = SAMPLES, progress = false,
      reflections = { entry.quantity == "all" and 0 or 1, "all" } }):totable(), 0)
  end
  return s
end

--- Keeps the light of a name: rows of `E` after the first `from`, as pixels [h][w][3]; -1 where nothing is seen.
function seen:keep(name, E, from)
  local rows = {}
  for i = 1, seen.size[1] * seen.size[2] do rows[i] = { -1, -1, -1 } end
  for k, pixel in ipairs(self.pixels) do rows[pixel] = E[(from or self.from) + k] end
  assert(ylm.array(rows, "float"):save(self.name .. name:gsub("[^%w]+", "_") .. ".npy"))
end

return seen
