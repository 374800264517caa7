--- Places that no judge of a surface grid has seen, their light by paths or by many rays to elements, and which of them miss a
-- tolerance: { draw, by_paths, by_elements, missed, hold }.

local ylm = require "ylm"
local core = require "ylm.c.core"
local irradiance = require "spec.support.irradiance"

local promise = {}

local SURE = 3.3 -- standard errors, 99.9 % of a place

local function lists(a)
  local rows = {}
  for i = 1, #a do rows[i] = { a:get(i, 1), a:get(i, 2), a:get(i, 3) } end
  return rows
end

--- n random places by area, which a promise of `light` is about: { points, normals, told }, lists; told is the light's answer.
-- `lit`: a radiosity of the scene's links.
function promise.draw(light, lit, n, seed)
  local points, normals, told = core.owned(light, "made").lib.surface_judges(light, lit, n, seed, 0)
  return { points = lists(points), normals = lists(normals), told = lists(told) }
end

--- Adds `samples` paths to the places of a list `which`.
local function add_paths(scene, places, which, samples, reflections, seed)
  local p, n = {}, {}
  for k, i in ipairs(which) do p[k], n[k] = places.points[i], places.normals[i] end
  local e, v = scene:probe { points = p, normals = n, samples = samples, reflections = reflections, seed = seed,
    progress = false }
  assert(e, v)
  for k, i in ipairs(which) do
    local share = samples / (places.paths[i] + samples)
    for c = 1, 3 do
      places.E[i][c] = (1 - share) * places.E[i][c] + share * e:get(k, c)
      places.V[i][c] = (1 - share) ^ 2 * places.V[i][c] + share ^ 2 * v:get(k, c)
    end
    places.paths[i] = places.paths[i] + samples
  end
end

--- Gives places E and V, their light by `samples` paths of each and its variance. `which`: of these alone; nil: of all.
function promise.by_paths(scene, places, quantity, samples, seed, which)
  if not places.E then
    places.E, places.V, places.paths = {}, {}, {}
    for i = 1, #places.points do places.E[i], places.V[i], places.paths[i] = { 0, 0, 0 }, { 0, 0, 0 }, 0 end
  end
  local all = {}
  for i = 1, #places.points do all[i] = i end
  add_paths(scene, places, which or all, samples, { quantity == "all" and 0 or 1, "all" }, seed)
  return places
end

--- Gives places E, their light by many rays to the elements of `lit`.
function promise.by_elements(places, lit, quantity, rays)
  local lifted = {}
  for i, p in ipairs(places.points) do
    local n = places.normals[i]
    lifted[i] = { p[1] + 1e-4 * n[1], p[2] + 1e-4 * n[2], p[3] + 1e-4 * n[3] }
  end
  local L = assert(ylm.light_field(8, lit:field { rays = rays, quantity = quantity }, lifted, { channels = "rgb" }))
  places.E = {}
  for i, n in ipairs(places.normals) do places.E[i] = irradiance.at(L, i, n) end
  return places
end

local function means(E)
  local mean = { 0, 0, 0 }
  for i = 1, #E do
    for c = 1, 3 do mean[c] = mean[c] + E[i][c] / #E end
  end
  return mean
end

--- The least and the most that place i is off, over the larger of its light and the mean, in the worst channel.
local function bounds(places, told, i, mean)
  local least, most = 0, 0
  for c = 1, 3 do
    local m = math.max(places.E[i][c], mean[c])
    local noise = places.V and SURE * math.sqrt(places.V[i][c]) or 0
    local d = math.abs(told[i][c] - places.E[i][c])
    if m > 0 then least, most = math.max(least, (d - noise) / m), math.max(most, (d + noise) / m) end
  end
  return least, most
end

--- How many places whose light is known are off by more than the tolerance for sure, and the rows of those that noise hides.
-- `told`: another answer than the places'.
function promise.missed(places, tolerance, told)
  local failed, open, mean = 0, {}, means(places.E)
  for i = 1, #places.E do
    local least, most = bounds(places, told or places.told, i, mean)
    if least > tolerance then failed = failed + 1
    elseif most > tolerance then open[#open + 1] = i end
  end
  return failed, open
end

--- The share of places by their best estimate that is off by more than the tolerance.
function promise.share(places, tolerance, told)
  local bare = { E = places.E, told = told or places.told }
  return promise.missed(bare, tolerance) / #places.E
end

--- Paths for places, doubled from `first` to `most` of each where noise hides whether it keeps the tolerance.
function promise.hold(scene, places, quantity, tolerance, first, most)
  local samples, seed, failed, open = first, 9001
  repeat
    promise.by_paths(scene, places, quantity, samples, seed, open)
    failed, open = promise.missed(places, tolerance)
    samples, seed = seed > 9001 and 2 * samples or samples, seed + 1
  until not open[1] or places.paths[open[1]] >= most
  return failed, open
end

--- The most of n that may be false where each is with a probability of at most `share`: more would refute that at 99 %.
function promise.allowed(n, share)
  local term, sum, k = (1 - share) ^ n, 0, 0
  while k <= n do
    sum = sum + term
    if sum >= 0.99 then return k end
    term, k = term * (n - k) / (k + 1) * share / (1 - share), k + 1
  end
  return n
end

return promise
