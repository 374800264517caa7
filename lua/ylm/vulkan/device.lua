--- A gpu as a device: see ylm/device/init.lua for what each method does.

local arrays = require "ylm.vulkan.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local grids = require "ylm.vulkan.grid"
local lights = require "ylm.vulkan.light"
local pictures = require "ylm.vulkan.image"
local binding = require "ylm.vulkan.binding"
local processor = require "ylm.device.processor"
local progress = require "ylm.progress"

local device = {}

local methods = {}
device.methods = methods

local metatable = { __index = methods }

--- The gpu as a device.
function device.of(gpu) return setmetatable({ gpu = gpu }, metatable) end

function methods.name(on) return on.gpu.name end

--- array:to(gpu).
function methods.array(on, a) return arrays.upload(on.gpu, 1, "to", a) end

--- grid:to(gpu).
function methods.grid(on, g, o) return grids.to(g, on.gpu, o) end

function methods.harmonics(on, lmax, points, out, o)
  if o.method ~= "solid" or o.kernel then
    return check.bad(3, "eval", "device goes with method 'solid' and without kernel")
  end
  local c, message, code = binding.use("eval", on.gpu)
  if not c then return nil, message, code end
  return check.result("eval", c.gpu_sh_eval(on.gpu, lmax, points, { y = out[1], dy = out[2], ddy = out[3], solid = o.solid,
    progress = progress.of(o.progress) }))
end

-- Lights ------------------------------------------------------------------------------

function lights.methods.__device(object) return device.of(lights.gpu_of(object)) end

function methods.is_open(_, object) return lights.is_open(object) end

function methods.lights(on, n, name, object, o) return lights.on(on.gpu, n, name, object, o.method) end

--- Raises where results of a device, which does not look at them itself, are not finite.
local function check_finite(name, points, results)
  for i = 1, 5 do
    local finite, where = true, nil
    if results[i] then finite, where = core.array_finite(results[i]) end
    if not finite then
      local wide = 1
      for axis, extent in ipairs(results[i].shape) do if axis > 1 then wide = wide * extent end end
      return check.fail("%s: the light field at point %d is beyond the range of %s", name,
        math.floor((where - 1) / wide) + 1, points.dtype)
    end
  end
end

function methods.evaluate(on, name, object, points, query)
  local L, dL, ddL, lambda, norm, inside, pairs = processor.evaluate(on, name, object, points, query)
  if L == nil then return nil, dL, ddL end
  check_finite(name, points, { L, dL, ddL, lambda, norm })
  return L, dL, ddL, lambda, norm, inside, pairs
end

-- Grids -------------------------------------------------------------------------------

function methods.points(_, n, name, what, points) return grids.points(n, name, what, points) end

function methods.positions(on, name, p)
  if p.stats.points == 0 then return processor.positions(on, name, p) end
  return pictures.positions(on.gpu, name, p)
end

function methods.check_bake(_, description, object)
  if type(object) == "function" then return check.bad(3, "bake", "device: a device sums lights, and no functions") end
  if description.dynamic then
    return check.bad(3, "bake", "device: a dynamic grid follows its lights on the processor")
  end
  if description.measure == "irradiance" then
    return check.bad(3, "bake", "device: measure = 'irradiance' is the processor's: leave device or measure out")
  end
  if (description.floor or 0) > 0 then
    return check.bad(3, "bake", "device: floor is the processor's: leave device or floor out")
  end
end

function methods.bake(on, form, object, occupied, o)
  local before = lights.times(object)
  local grid, copy, code = check.result("bake", binding.bound().gpu_grid_bake(form, object, occupied, o.seed,
    o.threads or 0, o.max_points, progress.of(o.progress)))
  if not grid then return nil, copy, code end
  if copy then grids.keep(grid, on.gpu, copy) end
  return grid, lights.times(object, before)
end

function methods.sample(on, ...) return grids.sample(on.gpu, ...) end

-- Pictures ----------------------------------------------------------------------------

function methods.check_rays(_, name)
  return check.bad(1, name, 'device: it traces no rays to lamps: leave it out, or name by = "grid"')
end

function methods.check_picture(_, name, o)
  if o.bodies then return check.bad(1, name, "device: bodies are drawn by the processor: leave device out") end
  if o.near_lights then return check.bad(1, name, "device: near lights are summed by the processor: leave device out") end
  if core.type(o.grid) ~= "ylm.grid" then
    return check.bad(1, name, "device: a baked grid expected, got %s", check.describe(o.grid))
  end
  if o.weight == "cosine" then
    return check.bad(1, name, "device: it shades grids of lights by transfer vectors, this one holds %q: leave device out",
      o.grid.quantity)
  end
  if o.dering then return check.bad(1, name, "device: it has no window against light below zero: leave device or dering out") end
  if o.ambient then return check.bad(1, name, "device: it finds no ambient occlusion: leave device or ambient out") end
  if o.grid.sides then
    return check.bad(1, name, "device: it knows no sides of walls, which this grid of %q light has: leave device out",
      o.grid.quantity)
  end
end

function methods.room(on, ...) return pictures.room(on.gpu, ...) end

function methods.shade(on, ...) return pictures.shade(on.gpu, ...) end

function methods.picture(on, ...) return pictures.picture(on.gpu, ...) end

return device
