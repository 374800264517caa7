--- Grids in a device's memory: grid:to, and what the option `device` of grid:sample does.

local array = require "ylm.array"
local binding = require "ylm.vulkan.binding"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local outputs = require "ylm.outputs"
local progress = require "ylm.progress"
local reference = require "ylm.describe"

local vulkan_grid = {}

local methods = {}

reference.object "gpu_grid" {
  about = "A grid's copy in a device's memory; grid:sample finds it by device = gpu.",
  methods = methods,
  fields = {
    { "bytes", "integer", "of the device's memory" },
    { "seconds", "number", "that copying took" },
    { "packed", "table", "of a packed copy: error, that of the light in all (the sum of the grid's own and rounding; nil: the "
      .. "grid's is not known), rounding: 99 % of 16,384 random places err by less, largest: of these" },
  },
}

local bound = binding.bound


--- The copy of a grid on a device, made where there is none that is open, packed or not; or nil, message, code.
function vulkan_grid.copy_of(name, grid, gpu, packed)
  local c, message, code = binding.use(name, gpu)
  if not c then return nil, message, code end
  local both = core.between(grid, gpu)
  local copy = both.copy
  if copy and c.gpu_grid_info(copy) then return copy end
  local seconds
  copy, seconds, code = check.result(name, c.gpu_grid_create(gpu, grid, packed))
  if not copy then return nil, seconds, code end
  both.copy, core.own(copy).seconds = copy, seconds
  return copy
end

--- Whether a copy may stay where one is asked for that is packed, or is not; nil: either will do.
local function may_stay(copy, grid, packed)
  if not bound().gpu_grid_current(copy, grid) then return false end
  return packed == nil or packed == (copy.packed ~= nil)
end

--- grid:to(gpu, { packed }).
function vulkan_grid.to(grid, gpu, o)
  local both = core.between(grid, gpu)
  local old = both.copy
  if old and not may_stay(old, grid, o.packed) then
    both.copy = nil
    check.result("to", bound().gpu_grid_close(old))
  end
  return vulkan_grid.copy_of("to", grid, gpu, o.packed)
end

--- Keeps the copy that a bake on the device has left there.
function vulkan_grid.keep(grid, gpu, copy)
  core.between(grid, gpu).copy, core.own(copy).seconds = copy, 0
end

--- Points [n][3] for argument `n` of `name`, which calls them `what`, in a device's memory or the host's, and whether
-- they were one row.
function vulkan_grid.points(n, name, what, points)
  if core.type(points) ~= "ylm.gpu_array" then return array.points(n, name, points) end
  local shape, _, _, is_open = bound().gpu_array_info(points)
  if not is_open then return check.bad(n, name, "%s: the array has been closed", what) end
  if #shape ~= 2 or shape[2] ~= 3 then
    return check.bad(n, name, "%s must be [n][3] on a device, got %s", what, tostring(points))
  end
  return points, false
end

--- The entries of `out` that are on a device are open float arrays of these shapes; they and others as two values.
function vulkan_grid.outputs(n, name, out, shapes)
  if core.type(out) == "ylm.gpu_array" then out = { out } end
  if type(out) ~= "table" or core.type(out) then return end
  local found = false
  for i = 1, #shapes do found = found or core.type(out[i]) == "ylm.gpu_array" end
  if not found then return end
  local extents = outputs.extents
  for i in pairs(out) do
    local a = out[i]
    if not shapes[i] then return check.bad(n, name, "out takes %d arrays, got an entry %s", #shapes, check.describe(i)) end
    if core.type(a) ~= "ylm.gpu_array" then
      return check.bad(n, name, "out[%d] must be on the device as the others are, got %s", i, check.describe(a))
    end
    local shape, dtype, _, is_open = bound().gpu_array_info(a)
    if not is_open then return check.bad(n, name, "out[%d]: the array has been closed", i) end
    if dtype ~= "float" or extents(shape) ~= extents(shapes[i]) then
      return check.bad(n, name, "out[%d] must be a float array of %s, got a %s array of %s", i, extents(shapes[i]), dtype,
        extents(shape))
    end
    if i == 2 and out[1] == a then return check.bad(n, name, "out[2] shares memory with out[1]") end
  end
  return out[1], out[2]
end

--- grid:sample with device = gpu: its results, or nil, message, code. New results are where the points are.
function vulkan_grid.sample(gpu, grid, points, o, shapes, single)
  if o.flags then return check.bad(2, "sample", "flags: the processor finds them: leave device out") end
  local out1, out2 = vulkan_grid.outputs(2, "sample", o.out, shapes)
  if not (out1 or out2) then out1, out2 = outputs.of(2, "sample", o.out, o.dtype, shapes, points) end
  local there = core.type(points) == "ylm.gpu_array" or core.type(out1 or out2) == "ylm.gpu_array"
  if o.dtype == "double" and (out1 or there) then
    return check.bad(2, "sample", "device: results are float, and out takes float arrays")
  end
  if (out1 or out2) and (points == out1 or points == out2) then
    return check.bad(2, "sample", "out shares memory with the points")
  end
  local copy, message, code = vulkan_grid.copy_of("sample", grid, gpu)
  if not copy then return nil, message, code end
  local c, dc, outside, unbaked, seconds, stages = check.result("sample", bound().gpu_grid_sample(copy, grid, points, {
    interpolation = o.interpolation, derivatives = o.derivatives, outside = o.outside,
    progress = progress.of(o.progress), value = out1, gradient = out2 }))
  if c == nil then return nil, dc, outside end
  if o.dtype == "double" then c, dc = core.array_convert(c, "double"), dc and core.array_convert(dc, "double") end
  if single and not out1 and core.type(c) == "ylm.array" then c, dc = c[1], dc and dc[1] end
  return c, dc, { outside = outside, unbaked = unbaked, seconds = seconds, stages = stages }
end

describe "gpu_grid:close" {
  about = "Gives back the memory at once; the grid itself stays.",
  arguments = {},
  returns = {},
  errors = "raises from the progress function of a call that uses the copy",
  example = [[
local gpu = ylm.vulkan.open()
local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 },
  ylm.sphere_light { at = { 0, 2, 0 } })
if gpu then grid:to(gpu):close() end]],
}
function methods.close(copy)
  if core.type(copy) ~= "ylm.gpu_grid" then
    return check.fail("close: a gpu_grid expected before the colon, got %s", check.describe(copy))
  end
  check.result("close", bound().gpu_grid_close(copy))
end

--- The errors of a packed copy; nil: it is not packed.
local function packing_of(copy)
  local error, rounding, largest = bound().gpu_grid_packed(copy)
  return rounding and { error = error, rounding = rounding, largest = largest } or nil
end

function methods.__index(copy, key)
  local method = methods[key]
  if method then return method end
  if key == "bytes" then return bound().gpu_grid_info(copy) end
  if key == "packed" then return packing_of(copy) end
  if key == "seconds" then return core.owned(copy, "seconds") end
end

function methods.__newindex(_, key)
  return check.fail("gpu_grid: cannot set %s", check.describe(key))
end

binding.methods("ylm.gpu_grid", methods)

return vulkan_grid
