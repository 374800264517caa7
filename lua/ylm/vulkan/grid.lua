--- Grids in a device's memory: grid:to, and what the option `device` of grid:sample does.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local reference = require "ylm.describe"

local vulkan_grid = {}

local methods = {}
vulkan_grid.methods = methods

reference.object "gpu_grid" {
  about = "A grid's copy in a device's memory; grid:sample finds it by device = gpu.",
  methods = methods,
  fields = {
    { "bytes", "integer", "of the device's memory" },
    { "seconds", "number", "that copying took" },
  },
}

--- Grid -> { gpu -> copy }; copy -> seconds.
local copies = setmetatable({}, { __mode = "k" })
local seconds_of = setmetatable({}, { __mode = "k" })

local function binding() return assert(require "ylm.vulkan".__binding()) end

--- The copy of a grid on a device, made where there is none that is open; or nil, message, code.
-- Argument `n` of `name` is the device.
function vulkan_grid.copy_of(n, name, grid, gpu)
  local c, message, code = require "ylm.vulkan".__use(n, name, gpu)
  if not c then return nil, message, code end
  local by_gpu = copies[grid]
  if not by_gpu then
    by_gpu = setmetatable({}, { __mode = "k" })
    copies[grid] = by_gpu
  end
  local copy = by_gpu[gpu]
  if copy and c.gpu_grid_info(copy) then return copy end
  local seconds
  copy, seconds, code = check.result(name, c.gpu_grid_create(gpu, grid))
  if not copy then return nil, seconds, code end
  by_gpu[gpu] = copy
  seconds_of[copy] = seconds
  return copy
end

--- grid:to(gpu).
function vulkan_grid.to(grid, gpu)
  local by_gpu = copies[grid]
  local old = core.type(gpu) == "ylm.gpu" and by_gpu and by_gpu[gpu]
  if old and not binding().gpu_grid_current(old, grid) then
    by_gpu[gpu] = nil
    binding().gpu_grid_close(old)
  end
  return vulkan_grid.copy_of(1, "to", grid, gpu)
end

--- The copy that a bake on the device has left there.
function vulkan_grid.keep(grid, gpu, copy)
  copies[grid] = setmetatable({ [gpu] = copy }, { __mode = "k" })
  seconds_of[copy] = 0
end

--- Gives back the copies of a grid that has been closed.
function vulkan_grid.forget(grid)
  for _, copy in pairs(copies[grid] or {}) do binding().gpu_grid_close(copy) end
  copies[grid] = nil
end

--- Points on a device for argument `n` of `name`, which calls them `what`: they are open and [n][3]. Returns how many.
function vulkan_grid.check_points(n, name, what, points)
  local shape, _, _, is_open = binding().gpu_array_info(points)
  if not is_open then return check.bad(n, name, "%s: the array has been closed", what) end
  if #shape ~= 2 or shape[2] ~= 3 then
    return check.bad(n, name, "%s must be [n][3] on a device, got %s", what, tostring(points))
  end
  return shape[1]
end

--- The entries of `out` that are on a device are open float arrays of these shapes; they and others as two values.
function vulkan_grid.outputs(n, name, out, shapes)
  if core.type(out) == "ylm.gpu_array" then out = { out } end
  if type(out) ~= "table" or core.type(out) then return end
  local found = false
  for i = 1, #shapes do found = found or core.type(out[i]) == "ylm.gpu_array" end
  if not found then return end
  local extents = require "ylm.outputs".extents
  for i in pairs(out) do
    local a = out[i]
    if not shapes[i] then return check.bad(n, name, "out takes %d arrays, got an entry %s", #shapes, check.describe(i)) end
    if core.type(a) ~= "ylm.gpu_array" then
      return check.bad(n, name, "out[%d] must be on the device as the others are, got %s", i, check.describe(a))
    end
    local shape, dtype, _, is_open = binding().gpu_array_info(a)
    if not is_open then return check.bad(n, name, "out[%d]: the array has been closed", i) end
    if dtype ~= "float" or extents(shape) ~= extents(shapes[i]) then
      return check.bad(n, name, "out[%d] must be a float array of %s, got a %s array of %s", i, extents(shapes[i]), dtype,
        extents(shape))
    end
    if i == 2 and out[1] == a then return check.bad(n, name, "out[2] shares memory with out[1]") end
  end
  return out[1], out[2]
end

--- What grid:sample does with device = gpu: its results, or nil, message, code. New results are where the points are.
function vulkan_grid.sample(grid, points, o, interpolation, out1, out2, progress)
  local there = core.type(points) == "ylm.gpu_array" or core.type(out1 or out2) == "ylm.gpu_array"
  if o.dtype == "double" and (out1 or there) then
    return check.bad(2, "sample", "device: results are float, and out takes float arrays")
  end
  if (out1 or out2) and (points == out1 or points == out2) then
    return check.bad(2, "sample", "out shares memory with the points")
  end
  local copy, message, code = vulkan_grid.copy_of(2, "sample", grid, o.device)
  if not copy then return nil, message, code end
  local c, dc, outside, unbaked, seconds, stages = check.result("sample", binding().gpu_grid_sample(copy, grid, points,
    interpolation, o.derivatives, o.outside == "nan", progress, out1, out2))
  if c == nil then return nil, dc, outside end
  if o.dtype == "double" then c, dc = core.array_convert(c, "double"), dc and core.array_convert(dc, "double") end
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
  check.result("close", binding().gpu_grid_close(copy))
end

function methods.__index(copy, key)
  local method = methods[key]
  if method then return method end
  if key == "bytes" then return binding().gpu_grid_info(copy) end
  if key == "seconds" then return seconds_of[copy] end
end

function methods.__newindex(_, key)
  return check.fail("gpu_grid: cannot set %s", check.describe(key))
end

return vulkan_grid
