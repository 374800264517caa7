-- Virtual lights by all methods beside paths: root mean square errors at equal numbers of lights, and at equal time.
--
--     lua examples/papers/hvl_methods.lua [--room cornell] [--scene FILE] [--width 96] [--most 4096] [--samples 1024] [--quick]
--
-- Writes hvl_methods_lights.png and hvl_methods_time.png. One bounce, without direct light; rays to the middles of lights.
-- Rooms: cornell, atrium, table_room. Errors are relative to the mean, over pixels off edges, less the noise of the truth
-- (--samples paths). Time is that of the processor, all threads together, for emission and gathering. "links" are ylm's other
-- bounce, "paths" the truth's own method.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common, rooms = dofile(here .. "../common.lua"), dofile(here .. "hvl_scenes.lua")
local option = common.options { room = "cornell", scene = "", width = 96, most = 4096, samples = 1024, out = "out",
  quick = false }
local quick = option.quick
local width, most, samples = quick and 16 or option.width, quick and 16 or option.most, quick and 32 or option.samples
local clock = os.clock -- of the processor, all threads together: others that run beside do not count
ylm.on_warning(false)

local scene = rooms.given(option.scene, option.room)
local size = { width, option.room == "cornell" and width or math.floor(0.75 * width) }
local view = assert(scene:prepare { size = size, samples = 4 })
local truth = assert(scene:pathtrace { size = size, samples = samples, reflections = { 2, 2 } })
local direct = assert(view:render {})
local error_of, noise, seen = rooms.judge(direct, truth)
print(("%d of %d pixels count; noise of the truth %.1f %%"):format(seen, size[1] * size[2], 100 * noise))

local row = common.table { { "method", "%-22s" }, { "lights", "%6d" }, { "rms, %", "%7.2f" }, { "processor s", "%11.3f" } }
local series, lights_series, time_series = {}, {}, {}
local looks = { links = { dash = "dashed", colour = { 0, 0, 0 }, marker = "square" },
  paths = { dash = "dotted", colour = { 0.4, 0.4, 0.4 }, marker = "diamond" } }

--- Adds a result, an image or its radiances, of n lights (nil: no lights).
local function say(name, n, image, seconds)
  local e = 100 * error_of(image)
  local s = series[name]
  if not s then
    s = { { x = {}, y = {}, label = name }, { x = {}, y = {}, label = name } }
    for key, value in pairs(looks[name] or {}) do s[2][key] = value end
    series[name] = s
    if n then lights_series[#lights_series + 1] = s[1] end
    time_series[#time_series + 1] = s[2]
  end
  if n then s[1].x[#s[1].x + 1], s[1].y[#s[1].y + 1] = n, e end
  s[2].x[#s[2].x + 1], s[2].y[#s[2].y + 1] = seconds, e
  row { name, n, e, seconds }
  return e
end

local last = {}
local count = 16
while count <= most do
  local start = clock()
  local gauss = assert(scene:virtual_lights { count = count })
  local emission = clock() - start
  local many = assert(scene:virtual_lights { count = 16 * count })
  local cap = assert(scene:virtual_lights { count = count, profile = "cap" })
  for _, m in ipairs {
    { "points", gauss, { rival = { "vpl", clamp = "none" } } }, { "points, clamped", gauss, { rival = { "vpl" } } },
    { "clamped, compensated", gauss, { rival = { "vpl", compensate = quick and 1 or 8 } } },
    { "spheres", cap, { rival = { "vsl" } } },
    { "spherical Gaussians", many, { rival = { "vsgl", groups = count } } }, { "harmonics, cap", cap, {} }, { "harmonics, gauss",
      gauss, {} },
  } do
    if m[1] ~= "spheres" or count <= 1024 then
      local o = m[3]
      o.by, o.bounced, o.virtual, o.layers = "none", m[2], { shadows = "centre" }, false
      start = clock()
      local image = assert(view:render(o))
      last[m[1]] = say(m[1], count, image, emission + clock() - start)
    end
  end
  count = 4 * count
end
local elements = not quick and assert(scene:links { lmax = 0 })
for _, links in ipairs(quick and {} or { 16, 64, 256, 1024 }) do
  local linked = assert(scene:prepare { size = size, samples = 4, rays = links, links = elements })
  local start = clock()
  local image = assert(linked:render { bounces = 1 })
  local seconds = clock() - start
  say("links", nil, image:layer() - direct:layer(), seconds)
end
for _, n in ipairs(quick and { 16 } or { 16, 64, 256 }) do
  local start = clock()
  local image = assert(scene:pathtrace { size = size, samples = n, reflections = { 2, 2 }, seed = 2 })
  say("paths", nil, image, clock() - start)
end

print(("order with %d lights: clamped %.1f %%, harmonics %.1f %%, points %.1f %%"):format(count / 4, last["points, clamped"],
  last["harmonics, gauss"], last.points))
print "Why: from some hundred lights on methods agree, and their error is that of the lights: where these lie, and their hard"
print "shadows. Below, spikes of points and the darkness of clamps and profiles at corners tell them apart."
if not quick then
  local name = option.scene == "" and option.room:gsub("_", " ") or option.scene
  common.save(ylm.plot { title = "One bounce by virtual lights: " .. name, series = lights_series, log = true,
    y_range = { 1.5, 130 }, x_label = "lights",
    y_label = "root mean square error, % of the mean", legend = "bottom left",
    caption = ("%d x %d pixels, beside %d paths each. Rays to the middles of lights."):format(size[1], size[2], samples) },
    option.out .. "hvl_methods_lights.png")
  common.save(ylm.plot { title = "One bounce by time: " .. name, series = time_series, log = true,
    y_range = { 0.3, 130 },
    x_label = "processor seconds of emission and gathering",
    y_label = "root mean square error, % of the mean", legend = "bottom left",
    caption = "Links find their elements before, once for a scene that stands; the rest begins anew." },
    option.out .. "hvl_methods_time.png")
end
