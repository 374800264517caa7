--- Devices compute. The processor is one, and so is the object that the option `device` names; no caller asks which it is.
--
-- A device is an object with these methods (`n`, `name`: the argument that is refused, the function that refuses it; o: the
-- options of that function). Each returns nil, message, code where the world fails it.
--
--     device:name()                                            for the metadata of pictures; nil: nothing is said
--     device:harmonics(lmax, points, out, o)                   sh.eval into the arrays `out` -> true
--     device:lights(n, name, object, o, within)                what has the light field there, whether made for this call
--     device:is_open(object)                                   may these lights be used?
--     device:evaluate(name, object, points, query)            core.field_evaluate, its results looked at
--     device:points(n, name, what, points)                     points [n][3], whether one row; nil: they lie elsewhere
--     device:positions(name, p)                                where the prepared view p asks for light
--     device:check_bake(description, lights)                   raises where the device bakes no such grid
--     device:bake(form, object, occupied, o)                   grid, times of its stages
--     device:sample(g, points, o, shapes, single)              what grid:sample returns
--     device:check_rays(name)                                  raises where the device traces no rays to lamps
--     device:check_picture(name, o)                            raises where the device makes no such picture
--     device:room(name, p, o)                                  where a picture that stays on the device is written
--     device:shade(name, p, o, bar)                            radiance of shading points, by o.weight ("transfer",
--                                                              "cosine"); { seconds, outside, unbaked, .. }
--     device:picture(name, p, o, layer, bar, compose)          writes a picture to `layer` -> that table

local core = require "ylm.c.core"
local processor = require "ylm.device.processor"

local devices = {}

--- The device that `x` is (the option `device`), or that its numbers lie on; the processor for everything else.
function devices.of(x)
  local device_of = core.type(x) and getmetatable(x).__device
  return device_of and device_of(x) or processor
end

-- Copies of grids on devices ------------------------------------------------------------

--- A function that gives back the copies that a grid has on devices now, also of one that has been closed since.
function devices.forgetting(grid)
  local pairs_of = {}
  for i, gpu in ipairs(core.partners(grid)) do pairs_of[i] = core.between(grid, gpu) end
  return function()
    for _, both in ipairs(pairs_of) do
      if both.copy then both.copy:close() end
      both.copy = nil
    end
  end
end

return devices
