-- Refusals of light from samples: see spec/refusals_spec.lua.

local nan = 0 / 0

local function sampled(t) return function(ylm) return ylm.sampled_light(t) end end
local function rows(n, width)
  local out = {}
  for i = 1, n do
    out[i] = {}
    for k = 1, width do out[i][k] = i + k end
  end
  return out
end
local one = { { 0, 0, 0 } }

return {
  sampled_light = {
    { call = sampled {}, says = "field 'at' is missing" },
    { call = sampled { at = one }, says = "give one of lights and coefficients" },
    { call = sampled { at = one, lights = {}, coefficients = rows(1, 4) }, says = "lights and coefficients, not both" },
    { call = sampled { at = one, lmax = 2, coefficients = rows(1, 4) }, says = "lmax is for lights" },
    { call = sampled { at = {}, lights = {} }, says = "at: 1 to 4096 places expected, got 0" },
    { call = sampled { at = { { 0, 0 } }, lights = {} }, says = "rows of 3 numbers expected" },
    { call = sampled { at = { { 0, 0, nan } }, lights = {} }, says = "row 1 is not finite" },
    { call = sampled { at = { { 0, 0, 1e16 } }, lights = {} }, says = "point 1 is beyond 1e%+15" },
    { call = sampled { at = { { 0, 0, -1e16 } }, coefficients = { { 1 } } }, says = "sample 1 is not finite, or is too far out" },
    { call = sampled { at = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 0 } }, lights = {} },
      says = "samples 1 and 3 are at one place" },
    { call = sampled { at = one, lights = 3 }, says = "a light or a list of lights expected" },
    { call = sampled { at = one, lights = {}, power = 1 }, says = "power must be a number >= 2" },
    { call = sampled { at = one, lights = {}, lmax = 101 }, says = "lmax must be .*<= 100" },
    { call = sampled { at = one, coefficients = rows(2, 4) }, says = "coefficients must be %[1%]" },
    { call = sampled { at = one, coefficients = rows(1, 5) }, says = "coefficients must be %[1%]" },
    { call = sampled { at = one, coefficients = { { nan } } }, says = "sample 1: a coefficient is not finite" },
    { call = function(ylm)
      return ylm.light_field(5, ylm.sampled_light { at = one, lights = {} }, one)
    end, says = "a sampled light is known to lmax 4, and asked for at lmax 5" },
  },
}
