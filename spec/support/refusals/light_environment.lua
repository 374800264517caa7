-- Refusals of environment lights: see spec/refusals_spec.lua.

local nan = 0 / 0

local function sky(t) return function(ylm) return ylm.environment_light(t) end end

return {
  environment_light = {
    { call = sky {}, says = "give one of radiance, coefficients, image, file and sky" },
    { call = sky { radiance = 1, file = "a.exr" }, says = "got radiance and file" },
    { call = sky { radianse = 1 }, says = "did you mean 'radiance'" },
    { call = sky { radiance = nan }, says = "radiance must be a number or {r, g, b}, finite" },
    { call = sky { radiance = 1, lmax = 3 }, says = "lmax is for an image, a file or a sky" },
    { call = sky { radiance = 1, scale = 1e400 }, says = "scale must be a number" },
    { call = sky { coefficients = { 1, 2, 3 } }, says = "%[%(lmax%+1%)^2%] or %[3%]%[%(lmax%+1%)^2%], lmax at most 100, got 3" },
    { call = sky { coefficients = { { 1 }, { 2 } } }, says = "got 2x1" },
    { call = sky { coefficients = "x" }, says = "a table of numbers or an array expected" },
    { call = sky { coefficients = { nan } }, says = "it is not finite" },
    { call = sky { image = 3 }, says = "image must be a ylm.image, got 3" },
    { call = sky { file = "" }, says = "file must be a file name" },
    { call = sky { file = "no such file.exr" }, says = "no such file" },
    { call = function(ylm) return ylm.environment_light { image = ylm.image { size = { 3, 3 } } } end,
      says = "twice as wide as high" },
    { call = function(ylm)
      local image = ylm.image { size = { 4, 2 } }
      image:layer():set(2, 3, 1, -1)
      return ylm.environment_light { image = image }
    end, says = "image: pixel %(3, 2%) is negative" },
    { call = sky { sky = { kind = "clear" } }, says = "sky: a clear sky needs sun" },
    { call = sky { sky = { kind = "cloudy" } }, says = "sky: kind must be one of" },
    { call = function(ylm)
      local low = ylm.environment_light { image = ylm.image { size = { 4, 2 } }, lmax = 1 }
      return ylm.light_field(3, low, { 0, 0, 0 })
    end, says = "projected to lmax 1 %(lmax = in environment_light%), and asked for at lmax 3" },
    { call = function(ylm)
      return ylm.light_field(3, ylm.environment_light { coefficients = { 1, 2, 3, 4 } }, { 0, 0, 0 })
    end, says = "an environment light is known to lmax 1, and asked for at lmax 3" },
  },
}
