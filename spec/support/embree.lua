--- Pictures and rates of one build, and pictures of two builds compared (spec/embree).
--
--     build/ylm run spec/support/embree.lua make FOLDER         # pictures as FOLDER/*.npy; rates on stdout
--     build/ylm run spec/support/embree.lua compare FOLDER FOLDER
--     build/ylm run spec/support/embree.lua none FOLDER         # without Embree: what is refused, and image files
--
-- `compare` and `none` end with "N passed, N failed".

local ylm = require "ylm"

-- Root mean square differences of two pictures relative to that of the picture. One path of 80,000 may turn elsewhere where
-- compilers differ, as those of Debian 12 and 13 do.
local LEAST, OF_PATHS = 1e-6, 1e-4
local size = { 96, 54 }
local what, folder, other = arg[1], arg[2], arg[3]
local passed, failed = 0, 0

local function check(good, ...)
  if good then passed = passed + 1 else failed = failed + 1 end
  print((good and "" or "FAILED: ") .. string.format(...))
end

local function scenes()
  local next_one, names = 0, { "two_lamps", "two_rooms", "floor_lights", "window" }
  return function()
    next_one = next_one + 1
    local name = names[next_one]
    if name then return name, assert(ylm.load("examples/scenes/" .. name .. ".lua")) end
  end
end

local function make()
  ylm.on_warning(false)
  print(("%-32s %10s"):format("picture, " .. table.concat(size, " x "), "seconds"))
  for name, scene in scenes() do
    local pictures = {
      rays = function() return scene:render { bounces = 0, size = size, samples = 4, light_samples = 16, layers = false } end,
      hits = function() return scene:render { by = "sum", size = size, samples = 4, visibility = "none" } end,
      transfer = function() return scene:render { by = "sum", size = size, samples = 4, visibility = "transfer",
        layers = false } end,
      paths = function() return scene:pathtrace { size = size, samples = 16, bounces = 2, layers = false } end,
    }
    for _, kind in ipairs { "hits", "rays", "transfer", "paths" } do
      local image, report = assert(pictures[kind]())
      local file = ("%s/%s_%s"):format(folder, name, kind)
      assert(image:layer():save(file .. ".npy"))
      if kind == "hits" then assert(image:layer("position"):save(file .. "_position.npy")) end
      print(("%-32s %10.3f"):format(name .. ", " .. kind, report.seconds.total))
    end
  end
end

--- The root mean square of an array.
local function rms(a)
  return math.sqrt((a * a):mean())
end

local function compare()
  local list = assert(io.popen("ls " .. folder))
  for file in list:lines() do
    local a, b = ylm.load(folder .. "/" .. file), ylm.load(other .. "/" .. file)
    if not a or not b then check(false, "%s is not in both folders", file)
    else
      local d = rms(a - b) / rms(a)
      check(d <= (file:find "paths" and OF_PATHS or LEAST), "%-36s differs by %.2g of its root mean square", file, d)
    end
  end
  list:close()
end

local function none()
  for name, scene in scenes() do
    for _, verb in ipairs { "render", "pathtrace", "links", "lightmap", "prepare", "surface_grid", "virtual_lights" } do
      local result, message, code = scene[verb](scene)
      check(result == nil and code == "EMISSING" and message:find "libembree%-dev", "%s:%s: %s", name, verb, tostring(message))
    end
  end
  local image = ylm.image { size = { 16, 8 }, layers = { { "radiance", 3 } } }
  local codec = table.concat(ylm.info().parts, " "):find "codec"
  for _, kind in ipairs(codec and { "exr", "png", "hdr", "pfm" } or {}) do
    local file = folder .. "/x." .. kind
    local saved, message = image:save(file)
    check(saved and ylm.load(file), "%s: %s", kind, saved and "saved and loaded" or tostring(message))
  end
end

({ make = make, compare = compare, none = none })[what]()
if what ~= "make" then print(("%d passed, %d failed"):format(passed, failed)) end
os.exit(failed == 0 and 0 or 1)
