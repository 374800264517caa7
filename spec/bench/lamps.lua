--- Tools of the benchmarks of Vulkan: random numbers in 0 .. 1, equal on every machine, lamps by them, and a clock that is up.

local ylm = require "ylm"

local lamps = {}

local state = 4321

function lamps.random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- n small sphere lights over a square of edge 4, `lowest` above the floor and up to 1.5 higher.
function lamps.over_floor(n, lowest)
  local random, at, radius, radiance = lamps.random, {}, {}, {}
  for i = 1, n do
    at[i], radius[i] = { 4 * random() - 2, lowest + 1.5 * random(), 4 * random() - 2 }, 0.01 + 0.02 * random()
    radiance[i] = { 20 * random(), 20 * random(), 20 * random() }
  end
  return ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
end

--- Keeps a GPU at work for half a second. One that waits lowers its clock (an H200 from 1980 to 345 MHz) and is slow afterwards.
function lamps.wake(gpu)
  if gpu.type ~= "cpu" then gpu:peak() end
end

return lamps
