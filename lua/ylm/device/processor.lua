--- The processor as a device: see ylm/device/init.lua for what each method does.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local library = require "ylm.library"
local outputs = require "ylm.outputs"
local progress = require "ylm.progress"

local processor = { narrows = true } -- it takes points of double for results of float

--- Pictures name a device that made them, and the processor not.
function processor.name() return nil end

function processor.harmonics(_, lmax, points, out, o)
  return check.result("eval", library.rival(core.sh_eval, lmax, points, { y = out[1], dy = out[2], ddy = out[3], solid = o.solid,
    method = o.method, threads = o.threads, isa = o.kernel, progress = progress.of(o.progress) }))
end

--- Does it lie in the memory of another device?
local function is_elsewhere(x)
  local kind = core.type(x)
  return kind == "ylm.gpu_array" or kind == "ylm.gpu_lights"
end

-- Lights ------------------------------------------------------------------------------

function processor.is_open() return true end

function processor.lights(_, n, name, object, o, within)
  if o.method then
    return check.bad(n, name, is_elsewhere(object) and "method: gpu:lights has chosen it"
      or "method: a choice for computing on a device")
  end
  return within(name, object, o.tolerance or o.sums_tolerance, o.threads)
end

function processor.evaluate(_, name, object, points, query)
  return check.result(name, core.field_evaluate(object, points, query))
end

-- Grids -------------------------------------------------------------------------------

function processor.points(_, n, name, _, points)
  if is_elsewhere(points) then return nil end
  return array.points(n, name, points)
end

function processor.positions(_, name, p)
  return check.result(name, p.lib.shade_positions(p.view))
end

function processor.check_bake() end

function processor.bake(_, form, object, occupied, o)
  return check.result("bake", core.grid_bake(form, object, occupied, o.seed, o.threads or 0, o.max_points,
    progress.of(o.progress)))
end

function processor.sample(_, g, points, o, shapes, single)
  if o.flags then shapes[#shapes + 1] = { shapes[1][1] } end
  local value, gradient, flags = outputs.of(2, "sample", o.out, o.dtype, shapes, points)
  if o.derivatives == 0 then gradient, flags = nil, gradient end
  local c, dc, outside, unbaked, seconds = check.result("sample", core.grid_sample(g, points, {
    interpolation = o.interpolation, derivatives = o.derivatives, outside = o.outside, dtype = o.dtype,
    threads = o.threads, progress = progress.of(o.progress), value = value, gradient = gradient,
    normals = o.normals, walls = o.walls }))
  if c == nil then return nil, dc, outside end
  if o.flags then
    local message, code
    flags, message, code = check.result("sample", core.grid_flags(g, points, o.dtype, o.threads or 0, flags))
    if flags == nil then return nil, message, code end
  end
  if single and not value then c, dc, flags = c[1], dc and dc[1], flags and flags[1] end
  return c, dc, { outside = outside, unbaked = unbaked, seconds = seconds }, flags
end

-- Pictures ----------------------------------------------------------------------------

--- Radiance of a view under a dynamic grid: only what changed since the last time is sampled.
local function shade_again(name, p, o, bar)
  local before = core.owned(p.view, "shaded") -- what shading it again needs
  if not before then
    local handle, radiance, message, code
    handle, message, code = check.result(name, p.lib.shade_memory(p.view))
    if not handle then return nil, message, code end
    radiance, message, code = core.array_zeros({ p.stats.points, 3 }, "float")
    if not radiance then return nil, message, code end
    before = { handle = handle, radiance = radiance }
    core.own(p.view).shaded = before
  end
  return check.result(name, p.lib.shade_grid_again(p.view, before.handle, o.grid, o.interpolation, o.threads or 0, bar,
    before.radiance))
end

--- Radiance of a view under any object with a light field.
local function shade_field(name, p, o, bar)
  local start = core.seconds()
  local radiance, pairs, code = check.result(name, p.lib.shade_field(p.view, o.grid, o.weight, "float", o.threads or 0,
    bar))
  if not radiance then return nil, pairs, code end
  return radiance, { pairs = pairs, seconds = core.seconds() - start }
end

function processor.shade(_, name, p, o, bar)
  if core.type(o.grid) ~= "ylm.grid" then return shade_field(name, p, o, bar) end
  local radiance, outside, unbaked, seconds, fresh
  if o.grid.dynamic and o.weight == "transfer" and not o.window then
    radiance, outside, unbaked, seconds, fresh = shade_again(name, p, o, bar)
  else
    radiance, outside, unbaked, seconds = check.result(name, p.lib.shade_grid(p.view, o.grid, o.weight,
      o.interpolation, o.threads or 0, bar, { window = o.window }))
  end
  if not radiance then return nil, outside, unbaked end
  return radiance, { outside = outside, unbaked = unbaked, seconds = seconds, fresh = fresh }
end

function processor.check_rays() end

function processor.check_picture(_, name, o)
  if o.download == false then return processor.room(nil, name) end
end

function processor.room(_, name)
  return check.bad(1, name, "download: name the device that the picture is to stay on")
end

function processor.picture(device, name, p, o, layer, bar, compose)
  local radiance, done, code = (o.shade or device.shade)(device, name, p, o, bar)
  if not radiance then return nil, done, code end
  local ok, message
  ok, message, code = compose(name, p, radiance, o, layer)
  if not ok then return nil, message, code end
  return done
end

return processor
