--- Random sequences of updates, of all kinds of change, for the spec and the bench that hold `met` against fresh points.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"
local numbers = require "spec.support.random"

local updates = {}

local box = grids.box

--- A sphere light in the room, sometimes near the floor.
local function sphere(r, low)
  local radius = 0.02 + 0.06 * r()
  return { kind = "sphere", at = { 1.8 * r() - 0.9, low and 0.05 + radius + 0.1 * r() or 0.1 + 1.2 * r(), 1.8 * r() - 0.9 },
    radius = radius, radiance = { 4 + 12 * r(), 4 + 8 * r(), 4 + 8 * r() } }
end

local function flat(r)
  local kinds = { "polygon", "disk", "textured" }
  local light = sphere(r)
  light.kind, light.radius = kinds[math.floor(3 * r()) + 1], 0.05 + 0.1 * r()
  light.at[2], light.turn, light.seed = 0.4 + 0.8 * r(), 6 * r(), math.floor(1000 * r())
  light.method = r() < 0.5 and "sphere" or nil
  return light
end

--- Corners of a square about light.at, turned about x and y.
local function square(light)
  local c, s, size, at = math.cos(light.turn), math.sin(light.turn), light.radius, light.at
  local corners = {}
  for k, uv in ipairs { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } } do
    local u, v = uv[1] * size, uv[2] * size
    corners[k] = { at[1] + u * c, at[2] + u * s * 0.7 + v * 0.2, at[3] + v + u * s * 0.3 }
  end
  -- The fourth follows from the others, so that all lie in one plane.
  for a = 1, 3 do corners[4][a] = corners[1][a] + corners[3][a] - corners[2][a] end
  return corners
end

local make = {}

function make.sphere(light)
  return ylm.sphere_light { at = light.at, radius = light.radius, radiance = light.radiance }
end

function make.polygon(light)
  return ylm.polygon_light { vertices = square(light), radiance = light.radiance, method = light.method }
end

function make.disk(light)
  return ylm.disk_light { at = light.at, normal = { math.cos(light.turn), -1, math.sin(light.turn) }, radius = light.radius,
    radiance = light.radiance, method = light.method }
end

function make.textured(light)
  local r, corners, texels = numbers.spread(light.seed), square(light), {}
  for i = 1, 3 do
    texels[i] = {}
    for j = 1, 3 do texels[i][j] = { light.radiance[1] * r(), light.radiance[2] * r(), light.radiance[3] * r() } end
  end
  local u, v = {}, {}
  for a = 1, 3 do u[a], v[a] = corners[2][a] - corners[1][a], corners[4][a] - corners[1][a] end
  return ylm.textured_light { corner = corners[1], u = u, v = v, image = texels,
    method = light.method and "spheres" or "exact" }
end

--- Changes of the descriptions of lights, by name.
local changes = {}

local function pick(r, lights) return lights[math.floor(r() * #lights) + 1] end

function changes.step(r, lights)
  local light = pick(r, lights)
  for a = 1, 3 do light.at[a] = light.at[a] + 0.1 * (r() - 0.5) end
  light.at[2] = math.max(light.at[2], 0.06 + light.radius)
end

function changes.jump(r, lights)
  local light = pick(r, lights)
  light.at = sphere(r).at
end

--- The lamp goes to the surface, some of them into it.
function changes.dive(r, lights)
  local light = pick(r, lights)
  light.at = { 1.6 * r() - 0.8, 0.03 + 0.1 * r(), 1.6 * r() - 0.8 }
end

function changes.grow(r, lights)
  local light = pick(r, lights)
  light.radius = light.radius * (0.6 + r())
end

function changes.flare(r, lights)
  local light, factor = pick(r, lights), math.exp(4 * (r() - 0.5))
  for c = 1, 3 do light.radiance[c] = light.radiance[c] * factor end
end

function changes.colour(r, lights)
  pick(r, lights).radiance = { 15 * r(), 15 * r(), 15 * r() }
end

function changes.turn(r, lights)
  local light = pick(r, lights)
  light.turn, light.seed = (light.turn or 0) + r(), (light.seed or 0) + 1
end

function changes.insert(r, lights)
  table.insert(lights, math.floor(r() * #lights) + 1, r() < 0.5 and sphere(r, r() < 0.4) or flat(r))
end

function changes.remove(r, lights)
  if #lights > 2 then table.remove(lights, math.floor(r() * #lights) + 1) else changes.insert(r, lights) end
end

function changes.several(r, lights)
  for _ = 1, 3 do changes.step(r, lights) end
  changes.colour(r, lights)
end

function changes.many(r, lights)
  for _, light in ipairs(lights) do
    for a = 1, 3 do light.at[a] = light.at[a] + 0.02 * (r() - 0.5) end
  end
end

--- All go out; the next change brings them back.
function changes.dark(_, lights)
  for _, light in ipairs(lights) do light.off = true end
end

local names = { "step", "step", "jump", "dive", "grow", "flare", "colour", "turn", "insert", "remove", "several", "many",
  "dark" }

--- A canopy of small lamps that stand, so that a lamp that moves is not all of the light.
local function canopy(n)
  local all = {}
  for k = 1, n do
    local radius, a = 1.5 * math.sqrt(k / n), 2.4 * k
    all[k] = ylm.sphere_light { at = { radius * math.cos(a), 1.3, radius * math.sin(a) }, radius = 0.03,
      radiance = { 3, 2 + k % 3, 4 } }
  end
  return all
end

--- A random scene: shading points, lights that may change, tolerance and so on; and its random numbers.
function updates.scene(seed)
  local r = numbers.spread(seed)
  for _ = 1, 10 do r() end
  local scene = { random = r, lights = {}, stand = canopy(r() < 0.5 and 0 or 40), depth = 6,
    tolerance = ({ 0.05, 0.02, 0.05 })[math.floor(3 * r()) + 1], lmax = 1 + math.floor(3 * r()) }
  for k = 1, 2 + math.floor(3 * r()) do
    scene.lights[k] = r() < 0.7 and sphere(r, r() < 0.4) or flat(r)
  end
  scene.occupied = grids.shading_points(20000, seed)
  return scene
end

--- All lights of a scene as they are.
function updates.lights(scene)
  local all = {}
  for k, light in ipairs(scene.stand) do all[k] = light end
  for _, light in ipairs(scene.lights) do
    if not light.off then all[#all + 1] = make[light.kind](light) end
  end
  return all
end

--- Changes a scene's lights; the name of what happened.
function updates.change(scene)
  local r, lights = scene.random, scene.lights
  local was_dark = false
  for _, light in ipairs(lights) do was_dark, light.off = was_dark or light.off, nil end
  local name = names[math.floor(r() * #names) + 1]
  if name == "dark" and (was_dark or #scene.stand > 0 and r() < 0.5) then name = "step" end
  changes[name](r, lights)
  return name
end

function updates.bake(scene, dynamic)
  return assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = scene.lmax, depth = scene.depth,
    tolerance = scene.tolerance, dynamic = dynamic }, updates.lights(scene),
    { occupied = scene.occupied, threads = 1 }))
end

--- n occupied points of a scene that nobody else draws, in float.
function updates.judges(scene, n, seed)
  local r, points = numbers.minimal(seed), {}
  for i = 1, n do
    local p = scene.occupied[math.floor(r() * #scene.occupied) + 1]
    points[i] = { p[1], p[2], p[3] }
  end
  return ylm.array(points, "float")
end

--- The relative errors of a grid at such points, but for those in lights, sorted.
function updates.errors(scene, grid, judges)
  local exact, _, _, report = ylm.light_field(scene.lmax, updates.lights(scene), judges,
    { dtype = "float", threads = 1 })
  local sampled, e = grid:sample(judges, { threads = 1 }), {}
  for i = 1, #judges do
    if report.inside[i] == 0 then
      local _, d, norm = core.array_distance(sampled[i], exact[i])
      e[#e + 1] = d == 0 and 0 or d / norm
    end
  end
  table.sort(e)
  return e
end

--- The part of sorted errors that is above a tolerance.
function updates.failing(errors, tolerance)
  local n = #errors
  while n > 0 and errors[n] > tolerance do n = n - 1 end
  return #errors > 0 and 1 - n / #errors or 0
end

--- Runs the random updates of a seed, each with a fresh bake beside, on one thread, and calls see { name, report, grid,
-- fresh, scene, failing: part of n judges at which the grid's error is above its tolerance, quantile: of 99 % of these }.
function updates.run(seed, steps, n, see)
  local scene = updates.scene(seed)
  local judges, grid = updates.judges(scene, n, 77 * seed + 5), updates.bake(scene, true)
  for _ = 1, steps do
    local name = updates.change(scene)
    local report = assert(grid:update(updates.lights(scene), { threads = 1 }))
    local e = updates.errors(scene, grid, judges)
    see { name = name, report = report, grid = grid, fresh = updates.bake(scene), scene = scene, judges = judges,
      failing = updates.failing(e, scene.tolerance), quantile = grids.quantile(e, 0.99) or 0 }
  end
end

return updates
