--- Irradiance at places of a scene's surfaces by paths, kept in a folder.

local places = require "spec.support.surface_places"
local ylm = require "ylm"

local truth = {}

local PLACES, PILOT, SEED = 500, 256, 1

local function slug(name) return (name:gsub("[^%w]+", "_")) end

--- Names a truth: other triangles or materials are another scene.
local function head_of(entry, scene)
  local area, count, albedo = 0, 0, 0
  for _, g in ipairs(scene.geometry) do
    area, count = area + g.mesh.area, count + #g.mesh
    local a = g.material and g.material.albedo
    for c = 1, type(a) == "table" and 3 or 0 do albedo = albedo + c * #g.mesh * a[c] end
  end
  return ("%s-%d-%.4g-%.4g-%d-%s"):format(slug(entry.name), count, area, albedo, #scene.lights, entry.quantity)
end

--- Traces paths for about `seconds`: rows [n][12] of places, normals, irradiance and its variance.
local function trace(entry, scene, seconds)
  local lit = assert(assert(scene:links { rays = 256 }):radiosity(nil, { light_samples = 64 }))
  local field = assert(lit:field { rays = 192, quantity = entry.quantity })
  local points, normals = places.draw(scene, field, PLACES, SEED, entry.box)
  local function probe(samples, seed)
    local E, V, report = scene:probe { points = points, normals = normals, samples = samples, seed = seed, progress = false,
      reflections = { entry.quantity == "all" and 0 or 1, "all" } }
    if not E then error(V) end
    return E, V, report
  end
  local _, _, pilot = probe(PILOT, 1)
  local samples = math.max(PILOT, math.floor(PILOT * seconds / math.max(0.01, pilot.seconds)))
  local E, V = probe(samples, 2)
  local rows = {}
  for i = 1, PLACES do
    rows[i] = {}
    for _, list in ipairs { points[i], normals[i] } do for a = 1, 3 do rows[i][#rows[i] + 1] = list[a] end end
    for _, list in ipairs { E, V } do for a = 1, 3 do rows[i][#rows[i] + 1] = list:get(i, a) end end
  end
  return rows
end

--- The truth of an entry of scenes.lua: { head, points, normals, E [n][3], mean, noise: rms standard error of luminance over
--- that }; head is a hash of the scene.
function truth.of(entry, scene, folder, seconds)
  local head = head_of(entry, scene)
  local path = folder .. "/" .. head .. ".npy"
  local file = io.open(path)
  if file then file:close() else assert(ylm.array(trace(entry, scene, seconds), "float"):save(path)) end
  local t, square, mean = { head = head, points = {}, normals = {}, E = {} }, 0, 0
  for i, x in ipairs(assert(ylm.load(path)):totable()) do
    t.points[i], t.normals[i], t.E[i] = { x[1], x[2], x[3] }, { x[4], x[5], x[6] }, { x[7], x[8], x[9] }
    -- channels share their paths: standard errors are added
    square = square + (0.2126 * math.sqrt(x[10]) + 0.7152 * math.sqrt(x[11]) + 0.0722 * math.sqrt(x[12])) ^ 2
    mean = mean + truth.luminance(t.E[i])
  end
  t.mean, t.noise = mean / #t.E, math.sqrt(square / #t.E) / (mean / #t.E)
  return t
end

function truth.luminance(c) return 0.2126 * c[1] + 0.7152 * c[2] + 0.0722 * c[3] end

return truth
