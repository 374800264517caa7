--- Places for the rule by which paths judge irradiance, with paths that are drawn here: judged(seed, n, share, tolerance) ->
-- the verdict of promise.compare. Each place misses the tolerance, by nothing, with a chance of `share`; the others are off by a
-- fifth of it at most. A path brings light with a chance of BRIGHT, so that few paths may miss it, with noise of twice the mean.

local ylm = require "ylm"
local promise = require "ylm.render.promise"

local BRIGHT = 0.4

--- Random numbers from 0 to below 1, of a seed, that are the same in each Lua.
local function stream(seed)
  local x = seed * 7919 % 2147483647 + 1
  return function()
    x = x * 16807 % 2147483647
    return x / 2147483647
  end
end

--- The mean of `samples` paths, and its variance.
local function walk(random, samples)
  local sum, squares = 0, 0
  for _ = 1, samples do
    if random() < BRIGHT then
      local x = -math.log(1 - random()) / BRIGHT
      sum, squares = sum + x, squares + x * x
    end
  end
  local mean = sum / samples
  return mean, (squares / samples - mean * mean) / (samples - 1)
end

return function(seed, n, share, tolerance)
  local random, points, normals, told = stream(seed), {}, {}, {}
  for i = 1, n do
    local off = random() < share and tolerance or (2 * random() - 1) * tolerance / 5
    local E = 1 + (random() < 0.5 and off or -off)
    points[i], normals[i], told[i] = { i, 0, 0 }, { 0, 1, 0 }, { E, E, E }
  end
  local function probe(o)
    local E, variance = {}, {}
    for i = 1, #o.points do
      local mean, v = walk(random, o.samples)
      E[i], variance[i] = { mean, mean, mean }, { v, v, v }
    end
    return ylm.array(E), ylm.array(variance)
  end
  return assert(promise.compare(nil, points, normals, told, tolerance, "indirect",
    { seed = seed, progress = false, probe = probe }))
end
