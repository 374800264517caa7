--- Work of a state, for spec/support/states.c: bakes, bounces, pictures, files, errors, warnings, calls that are
-- cancelled. Returns checksums and messages, which are those of a state that is alone.
local folder, name, round = ...
local ylm = require "ylm"
local said, warned = {}, {}

local function say(what, value) said[#said + 1] = what .. "\t" .. tostring(value) end

--- Numbers of a file, 31 bits.
local function sum(path)
  local file = assert(io.open(path, "rb"))
  local n, text = 5381, file:read "a"
  file:close()
  for i = 1, #text do n = (n * 33 + text:byte(i)) & 0x7fffffff end
  return #text .. " bytes, " .. n
end

local function saved(what, object, ending)
  local path = ("%s/%s.%s"):format(folder, name, ending)
  assert(object:save(path))
  say(what, sum(path))
  if ending == "png" then return end
  local all = ("%s/all.%s"):format(folder, ending) -- of every state
  assert(object:save(all))
  assert(ylm.load(all)):close()
end

ylm.on_warning(function(message) warned[#warned + 1] = message end)
local scene = assert(ylm.load(folder .. "/scene.lua")) -- bounded in instructions, memory and time
local lamps = { ylm.sphere_light { at = { 0.2, 0.8, 0 }, radius = 0.1, radiance = { 9, 5, 2 } },
  ylm.photometric_light { photometry = ylm.photometry { cosine = 2, lumens = 90 }, at = { 0.3, 0.9, 0.1 }, efficacy = 179 } }
local points = {}
for i = 1, 400 do points[i] = { math.sin(i) * 0.9, math.cos(3 * i) * 0.9, math.sin(7 * i) * 0.9 } end
points = ylm.array(points, "float")

local grid = ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 3, metric = "absolute",
  threshold = 0.4 }, lamps, { threads = 2 })
saved("grid", grid, "ylm")
saved("sampled", grid:sample(points), "npy")
saved("light", ylm.light_field(6, lamps, points), "npy")
saved("harmonics", ylm.sh.product(ylm.sh.eval(3, points), ylm.sh.eval(3, points)), "npy")

local parts = {}
for _, part in ipairs(ylm.info().parts) do parts[part] = true end
if parts.scene then
  local links = scene:links { spacing = 0.3, rays = 32 }
  saved("bounced", links:radiosity():irradiance(), "npy")
  links:close()
end
if parts.scene and parts.codec then
  local picture = assert(scene:render { size = { 24, 18 }, bounces = 2 })
  for _, ending in ipairs { "pfm", "exr", "png" } do saved("picture", picture, ending) end
  saved("paths", scene:pathtrace { size = { 12, 9 }, samples = 2 }, "pfm")
end

local calls = 0
local nothing, message = ylm.light_field(9, lamps, ylm.zeros({ 60000, 3 }, "float"), { progress = function()
  calls = calls + 1
  return false
end })
say("cancelled", tostring(nothing) .. ", " .. tostring(message) .. ", " .. tostring(calls > 0))
say("refused", select(2, pcall(ylm.sphere_light, { at = { 0, 0, 0 }, radius = -1 })))
say("missing", (select(2, ylm.load(folder .. "/none.ylm")):gsub("^.*/", "")))
say("no picture", (select(2, ylm.load(folder .. "/bad.png")):gsub("^.*/", "")))
require "ylm.warning".say({}, "x", "%s warns", "a state")
say("warned", table.concat(warned, "; "))
say("points", grid.stats.points)
assert(round >= 0)
if round % 2 == 0 then grid:close() end
return table.concat(said, "\n")
