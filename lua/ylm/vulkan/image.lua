--- Pictures on a device: what the option `device` of scene:render does. A view's points, and what its pixels are made of,
-- are copied once; a frame shades the points, filters them into pixels, draws lamps over them, and stays there or comes back.

local binding = require "ylm.vulkan.binding"
local check = require "ylm.check"
local core = require "ylm.c.core"
local light = require "ylm.light"
local memory = require "ylm.memory"
local vulkan_grid = require "ylm.vulkan.grid"

local vulkan_image = {}

local bound = binding.bound

-- A view and a device have in common `copies`: position, transfer, material, and picture, radiance where the device filters;
-- and `positions` on that device: bakes ask for these alone.

local FAR = "device: it rounds positions to float, and the scene lies far from the origin: leave device out, or move it near 0"

--- The points of the view p on the host; or nil, message, code: where the device would round them.
local function places(name, p)
  local here, message, code = check.result(name, p.lib.shade_positions(p.view))
  if here and here.dtype ~= "float" then return check.result(name, nil, FAR, "ERANGE") end
  return here, message, code
end

--- The points of the view p on a device, copied once; where there is no room for them the host's array. Or nil, message, code.
function vulkan_image.positions(gpu, name, p)
  local c, message, code = binding.use(name, gpu)
  if not c then return nil, message, code end
  local both = core.between(p.view, gpu)
  if both.positions then return both.positions end
  local here, there
  here, message, code = places(name, p)
  if not here then return nil, message, code end
  there, message, code = memory.attempt(c.gpu_upload, gpu, here)
  if not there and (code == "ENOMEM" or code == "ELIMIT") then return here end
  if not there then return check.result(name, nil, message, code) end
  both.positions = there
  return there
end

--- Copies arrays by name; where memory runs out what was made is given back: nil, message, code.
local function upload(gpu, arrays)
  local there = {}
  for key, a in pairs(arrays) do
    local copy, message, code = memory.attempt(bound().gpu_upload, gpu, a)
    if not copy then
      for _, made in pairs(there) do bound().gpu_array_close(made) end
      return nil, message, code
    end
    there[key] = copy
  end
  return there
end

--- The pixels of a view on a device: picture, and radiance for those points; or nil, message, code.
local function pixels_on(gpu, p)
  local entries, message, code = p.lib.shade_entries(p.view)
  if not entries then return nil, message, code end
  local size, points, c = p.options.size, p.stats.points, bound()
  local picture, radiance
  picture, message, code = memory.attempt(c.gpu_picture_create, gpu, size[1], size[2], points, entries)
  if not picture then return nil, message, code end
  radiance, message, code = memory.attempt(c.gpu_array_new, gpu, { points, 3 }, "float")
  if not radiance then
    c.gpu_picture_close(picture)
    return nil, message, code
  end
  return { picture = picture, radiance = radiance }
end

--- The points of a view as arrays of the host's: position, transfer, material; or nil, message, code.
local function points_of(name, p)
  local position, transfer, material, message, code
  position, message, code = places(name, p)
  if not position then return nil, message, code end
  transfer, message, code = p.lib.shade_transfer(p.view)
  if not transfer then return nil, message, code end
  material, message, code = p.lib.shade_materials(p.view)
  if not material then return nil, message, code end
  return { position = position, transfer = transfer, material = material }
end

--- The copies of a view on a device. Without room for its points they stay the host's, and are copied in each call;
-- without room for its pixels the host filters, and message and code say why.
local function view_on(name, gpu, p)
  local both = core.between(p.view, gpu)
  if both.copies then return both.copies end
  local arrays, message, code = check.result(name, points_of(name, p))
  if not arrays then return nil, message, code end
  local position, there, pixels
  position, message, code = vulkan_image.positions(gpu, name, p)
  if not position then return nil, message, code end
  if core.type(position) == "ylm.gpu_array" then
    there, message, code = upload(gpu, { transfer = arrays.transfer, material = arrays.material })
  end
  if there then
    there.position = position
    pixels, message, code = pixels_on(gpu, p)
  end
  if code == "EDEVICE" or code == "ECLOSED" then return check.result(name, nil, message, code) end
  there = there or arrays
  if pixels then there.picture, there.radiance = pixels.picture, pixels.radiance
  else there.message, there.code = message, code end
  both.copies = there
  return there
end

--- Adds the times of stages to others.
local function add(stages, more)
  for name, t in pairs(more) do
    local s = stages[name]
    if not s then stages[name] = t
    else
      s.seconds, s.longest, s.dispatches = s.seconds + t.seconds, math.max(s.longest, t.longest), s.dispatches + t.dispatches
    end
  end
end

--- The gpu_array that o.out names, or a new one: [height][width][3]; or nil, message, code.
function vulkan_image.room(gpu, name, p, o)
  local c, message, code = binding.use(name, gpu)
  if not c then return nil, message, code end
  local shape = { p.options.size[2], p.options.size[1], 3 }
  if o.truth then return check.bad(1, name, "truth needs an image on the host: it cannot be combined with download = false") end
  if not o.out then return check.result(name, c.gpu_array_new(gpu, shape, "float")) end
  return (vulkan_grid.outputs(1, name, o.out, { shape }))
    or check.bad(1, name, "out: a gpu_array expected, got %s", check.describe(o.out))
end

--- The device filters what the host has shaded on it: true, or nil, message, code.
local function filter(name, p, o, v, radiance, image, bar, stages)
  local discs, ok, times, code
  if o.lamps then
    discs, times, code = check.result(name, p.lib.shade_discs(p.view, light.lamps(name, o.lamps)))
    if not discs and times then return nil, times, code end
  end
  ok, times, code = check.result(name, bound().gpu_picture_make(v.picture, radiance, p.scene.background or { 0, 0, 0 },
    discs, image, bar))
  if not ok then return nil, times, code end
  add(stages, times)
  return true
end

--- The radiance of the prepared view p by a grid (the options o of view:render), the host's array or the device's;
-- and { outside, unbaked, seconds, stages }; or nil, message, code.
function vulkan_image.shade(gpu, name, p, o, bar)
  local copy, message, code = vulkan_grid.copy_of(name, o.grid, gpu)
  if not copy then return nil, message, code end
  local v
  v, message, code = view_on(name, gpu, p)
  if not v then return nil, message, code end
  local to = v.radiance
  if not to then
    to, message = core.array_zeros({ p.stats.points, 3 }, "float")
    if not to then return nil, message, "ENOMEM" end
  end
  local radiance, outside, unbaked, seconds, stages = check.result(name, bound().gpu_grid_shade(copy, o.grid, {
    points = v.position, transfer = v.transfer, material = v.material, interpolation = o.interpolation, progress = bar,
    radiance = to }))
  if not radiance then return nil, outside, unbaked end
  return radiance, { outside = outside, unbaked = unbaked, seconds = seconds, stages = stages }
end

--- Writes the picture of p to `image` [h][w][3], the host's or a device's: what shade says of it; or nil, message, code.
-- `compose` filters on the host.
function vulkan_image.picture(gpu, name, p, o, image, bar, compose)
  local start = core.seconds()
  local copy, message, code = vulkan_grid.copy_of(name, o.grid, gpu)
  if not copy then return nil, message, code end
  local v
  v, message, code = view_on(name, gpu, p)
  if not v then return nil, message, code end
  if not v.picture and core.type(image) == "ylm.gpu_array" then return nil, v.message, v.code end
  local radiance, done
  radiance, done, code = vulkan_image.shade(gpu, name, p, o, bar)
  if not radiance then return nil, done, code end
  local ok
  if v.picture then
    ok, message, code = filter(name, p, o, v, radiance, image, bar, done.stages)
    done.seconds = core.seconds() - start
  else ok, message, code = compose(name, p, radiance, o, image) end
  if not ok then return nil, message, code end
  return done
end

return vulkan_image
