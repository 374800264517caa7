--- Scenes in place of those of Xin et al. 2021, Figs. 7 to 9, which are not published, and the comparison of methods on them.
-- Loaded with dofile by products_2021_fig7.lua, _fig8.lua, _fig9.lua and _table2.lua. Metres; y is up.
--
-- A case is { name, n, camera, still (geometry), light, casters, spheres, note }: `casters` stand for the bodies in products,
-- by name, with the surfaces that are drawn; `spheres` = { at, radius, body } stand for them in SHEXP and, as unions, at
-- directions.

local core = require "ylm.c.core"
local ylm = require "ylm"

local shadows = {}

local function paint(r, g, b) return ylm.matte { albedo = { r, g, b } } end
local clay = paint(0.74, 0.72, 0.68)

--- A closed prism of n sides from p to q, as a mesh; `divide` gives its length more vertices.
local function rod(p, q, radius, n, divide, material)
  local d, length = {}, 0
  for k = 1, 3 do
    d[k] = q[k] - p[k]
    length = length + d[k] ^ 2
  end
  length = math.sqrt(length)
  for k = 1, 3 do d[k] = d[k] / length end
  local a = math.abs(d[2]) < 0.9 and { 0, 1, 0 } or { 1, 0, 0 }
  local u = { d[2] * a[3] - d[3] * a[2], d[3] * a[1] - d[1] * a[3], d[1] * a[2] - d[2] * a[1] }
  local l = math.sqrt(u[1] ^ 2 + u[2] ^ 2 + u[3] ^ 2)
  for k = 1, 3 do u[k] = u[k] / l end
  local v = { d[2] * u[3] - d[3] * u[2], d[3] * u[1] - d[1] * u[3], d[1] * u[2] - d[2] * u[1] }
  local corners, triangles = { p, q }, {}
  for j = 0, divide do
    for i = 0, n - 1 do
      local c, s, t, at = radius * math.cos(2 * math.pi * i / n), radius * math.sin(2 * math.pi * i / n), j / divide * length, {}
      for k = 1, 3 do at[k] = p[k] + d[k] * t + u[k] * c + v[k] * s end
      corners[#corners + 1] = at
    end
  end
  for i = 0, n - 1 do
    local k = (i + 1) % n
    for j = 0, divide - 1 do
      local w, x, y, z = 3 + j * n + i, 3 + j * n + k, 3 + (j + 1) * n + i, 3 + (j + 1) * n + k
      triangles[#triangles + 1], triangles[#triangles + 2] = { w, x, z }, { w, z, y }
    end
    triangles[#triangles + 1], triangles[#triangles + 2] = { 1, 3 + k, 3 + i }, { 2, 3 + divide * n + i, 3 + divide * n + k }
  end
  return ylm.mesh { vertices = corners, triangles = triangles, material = material }
end

--- The meshes of shapes as one.
local function joined(list)
  local vertices, triangles = {}, {}
  for _, shape in ipairs(list) do
    local first = #vertices
    for _, p in ipairs(shape.mesh:vertices():totable()) do vertices[#vertices + 1] = p end
    for _, t in ipairs(shape.mesh:triangles():totable()) do
      triangles[#triangles + 1] = { t[1] + first, t[2] + first, t[3] + first }
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles }
end

local function ball(at, radius, material, divide)
  divide = divide or 32
  return ylm.caster { hides = ylm.occluder { radius = 1 }, at = at, scale = radius,
    surface = ylm.sphere { radius = 1, divide = { divide, math.floor(divide / 2) }, material = material } }
end

local function sky(n)
  return ylm.environment_light { coefficients = ylm.sh.project(n - 1, function(x, y, z)
    local sun = 9 * math.exp(14 * ((0.55 * x + 0.75 * y + 0.36 * z) / math.sqrt(0.9946) - 1))
    local up = 0.16 + 0.2 * math.max(0, y)
    return up + sun, up + 0.92 * sun, 1.25 * up + 0.75 * sun
  end) }
end

local function floor(half)
  return ylm.quad { corner = { -half, 0, half }, u = { 2 * half, 0, 0 }, v = { 0, 0, -2 * half }, material = clay }
end

--- Many balls over a floor, for Fig. 9.
function shadows.balls(count)
  local casters, at, radius, body = {}, {}, {}, {}
  for i = 1, count do
    local a, r = 2.39996 * i, 1.75 * math.sqrt((i - 0.3) / count)
    local size = 0.14 + 0.13 * ((i * 7) % 5) / 4
    local p = { r * math.cos(a), size + 0.05 + 0.3 * ((i * 3) % 4) / 3, r * math.sin(a) }
    local hue = i * 0.7
    casters["ball" .. i] = ball(p, size, paint(0.4 + 0.3 * math.cos(hue), 0.34 + 0.25 * math.cos(hue + 2),
      0.36 + 0.3 * math.cos(hue + 4)))
    at[i], radius[i], body[i] = p, size, i
  end
  return { name = "Spheres", camera = { from = { 0.3, 4.1, 4.6 }, at = { 0.05, 0.15, 0 }, fov = 30 }, still = { floor(24) },
    casters = casters, spheres = { at = at, radius = radius, body = body }, light = sky }
end

--- A body and legs, and a tail with a sting, of convex parts: Fig. 7 (a), "Spider & Scorpion".
function shadows.spider(count)
  local parts, casters, meshes = {}, {}, {}
  local dark, rust = paint(0.24, 0.2, 0.2), paint(0.55, 0.2, 0.1)
  local function leg(p, q, r, material)
    local d, length = { q[1] - p[1], q[2] - p[2], q[3] - p[3] }, 0
    for k = 1, 3 do length = length + d[k] ^ 2 end
    length = math.sqrt(length)
    local low, high = { 0, 0, -length / 2 }, { 0, 0, length / 2 } -- in a frame of its own its faces are flat to rounding
    parts[#parts + 1] = rod(p, q, r, 6, 1)
    casters["leg" .. #parts] = ylm.caster { hides = ylm.occluder { geometry = rod(low, high, r, 6, 1) },
      surface = rod(low, high, r, 6, 6, material), at = { (p[1] + q[1]) / 2, (p[2] + q[2]) / 2, (p[3] + q[3]) / 2 },
      rotation = { axis = { -d[2], d[1], 1e-12 }, angle = math.deg(math.acos(d[3] / length)) } }
  end
  local x = -0.85
  for side = -1, 1, 2 do
    for i = 1, 4 do
      local a = side * (0.4 + 0.52 * (i - 1) + 0.25)
      local knee = { x + 0.62 * math.sin(a), 0.72, 0.62 * math.cos(a) }
      leg({ x + 0.14 * math.sin(a), 0.42, 0.14 * math.cos(a) }, knee, 0.035, dark)
      leg(knee, { x + 1.05 * math.sin(a), 0.03, 1.05 * math.cos(a) }, 0.025, dark)
    end
  end
  casters.body = ball({ x, 0.42, 0 }, 0.24, dark)
  casters.head = ball({ x, 0.40, 0.3 }, 0.15, dark)
  local last
  for i = 0, 7 do -- a tail that bends over
    local t = i / 7
    local p = { 0.95, 0.22 + 0.75 * math.sin(2.3 * t), 0.5 - 0.5 * t - 0.45 * math.sin(2.6 * t) }
    if last then leg(last, p, 0.09 - 0.055 * t, rust) end
    last = p
  end
  casters.tail = ball({ 0.95, 0.22, 0.55 }, 0.2, rust)
  meshes[1] = ylm.sphere { radius = 0.24, at = { x, 0.42, 0 } }
  meshes[2] = ylm.sphere { radius = 0.15, at = { x, 0.40, 0.3 } }
  meshes[3] = ylm.sphere { radius = 0.2, at = { 0.95, 0.22, 0.55 } }
  for _, part in ipairs(parts) do meshes[#meshes + 1] = part end
  local at, radius, report = ylm.sphere_set(joined(meshes), { count = count })
  return { name = "in place of Spider & Scorpion", camera = { from = { 0.2, 3.2, 4.2 }, at = { 0, 0.25, 0 }, fov = 34 },
    still = { floor(24) }, casters = casters, spheres = { at = at, radius = radius }, report = report, light = sky }
end

--- A ball beside a double helix of balls that overlap: Fig. 7 (b), "Ball & DNA".
function shadows.helix(pairs_of)
  local casters, at, radius, body = {}, {}, {}, {}
  local blue, gold, grey = paint(0.16, 0.34, 0.6), paint(0.8, 0.56, 0.14), paint(0.75, 0.74, 0.72)
  local function add(p, r, material, group)
    at[#at + 1], radius[#at + 1], body[#at + 1] = p, r, group
    casters["ball" .. #at] = ball(p, r, material, 20)
  end
  for i = 1, pairs_of do
    local t = (i - 1) / (pairs_of - 1)
    local a, y = 2.4 * math.pi * t, 0.28 + 1.5 * t
    for side = 0, 1 do
      local b = a + math.pi * side
      add({ 0.65 + 0.42 * math.cos(b), y, 0.42 * math.sin(b) }, 0.13, side == 0 and blue or gold, 1)
    end
  end
  add({ -0.75, 0.5, 0.1 }, 0.42, grey, 2)
  return { name = "in place of Ball & DNA", camera = { from = { 0.1, 3.3, 4.6 }, at = { 0, 0.55, 0 }, fov = 36 },
    still = { floor(24) }, casters = casters, spheres = { at = at, radius = radius, body = body }, light = sky }
end

--- A body of spheres between columns, for Fig. 8, "Dragon in Hall"; geometry may be a mesh of one's own, about 1.6 high.
function shadows.hall(geometry, count)
  local still = { floor(24) }
  for i = -1, 1 do
    for side = -1, 1, 2 do
      still[#still + 1] = ylm.box { at = { 1.7 * side, 0.9, 1.3 * i - 0.3 }, scale = { 0.26, 1.8, 0.26 }, material = clay }
    end
  end
  local at, radius, report = ylm.sphere_set(geometry, { count = count })
  return { name = "in place of Dragon in Hall", camera = { from = { 0.2, 3.4, 5.0 }, at = { 0, 0.55, -0.1 }, fov = 36 },
    still = still, spheres = { at = at, radius = radius }, report = report, light = sky, body = geometry }
end

shadows.paint = paint

-- Methods --------------------------------------------------------------------------------------------

--- The casters of SHEXP and of unions: spheres.
local function spheres_of(case)
  return ylm.sphere_casters { at = case.spheres.at, radius = case.spheres.radius, body = case.spheres.body }
end

local function many(case)
  local count = 0
  for _ in pairs(case.casters or {}) do count = count + 1 end
  return count
end

--- { caption, options of ylm.shadowed, casters, probes }: the methods that a case has.
local function methods(case)
  local list = {}
  local function add(caption, o, casters, probes) list[#list + 1] = { caption, o, casters, probes } end
  if case.casters then
    if many(case) <= 15 then add("accurate", { product = "accurate" }, case.casters)
    else add("accurate (rule 12)", { rule = 12, layers = false }, case.casters) end
    add("recursive", { product = "recursive" }, case.casters)
    add("one rule", {}, case.casters)
    add("one rule, probes", {}, case.casters, true)
  end
  if not case.apart then
    add("spheres as unions", {}, spheres_of(case))
    if not case.casters then add("unions, probes", {}, spheres_of(case), true) end
  end
  add("SHEXP, HYB", { product = "exp" }, spheres_of(case))
  add("SHEXP, PS-9", { product = "exp", exp = "PS" }, spheres_of(case))
  return list
end

--- 1 where a picture shows a floor.
local function floor_mask(truth)
  local p, covered = truth:layer "position", truth:layer "coverage"
  return covered[{ {}, {}, 1 }]:greater(0.999) * p[{ {}, {}, 2 }]:less(2e-3) * (p[{ {}, {}, 2 }] * -1):less(2e-3)
end

--- Draws a case by all methods beside paths; o: size, n, paths, samples, threads, tolerance. Returns rows of a figure, and
-- results { caption, rms in % of the unshadowed, seconds, points, probes }.
function shadows.compare(case, o)
  local light, camera = case.light(o.n), ylm.camera(case.camera)
  -- bodies are drawn alike by all methods; the floor is in the way of their light from below
  local seen = { ylm.caster { hides = ylm.occluder { geometry = ylm.box { scale = { 16, 1, 16 } } }, at = { 0, -0.502, 0 } } }
  for name, caster in pairs(case.casters or {}) do seen[name] = caster end
  if case.body then seen.body = ylm.caster { hides = ylm.occluder { radius = 1e-3 }, surface = case.body } end
  local drawn = ylm.shadowed { lights = light, casters = seen }
  local bodies = assert(drawn:surfaces())
  local full = ylm.scene(case.name) { camera = camera, geometry = { case.still, bodies }, lights = { light } }
  local truth, told = assert(full:pathtrace { size = o.size, samples = o.paths, reflections = { 1, 1 }, threads = o.threads })
  local still = ylm.scene(case.name) { camera = camera, geometry = case.still, lights = { light } }
  local view = assert(still:prepare { size = o.size, samples = o.samples, lmax = o.n - 1, visibility = "transfer",
    occlusion_distance = math.huge, transfer_samples = o.rays, threads = o.threads })
  local open = assert(view:render { grid = light, threads = o.threads })
  local mask = floor_mask(truth)
  local function root(x) return math.sqrt((x * x):mean()) end
  local unshadowed = root(open:layer "radiance":select(mask))
  local want = truth:layer "radiance":select(mask)
  local noise = math.sqrt(truth:layer "variance":select(mask):mean()) / unshadowed
  local exposure = -math.log(3 * unshadowed) / math.log(2) + 0.5
  local function shown(image, caption) return { image = image, caption = caption, exposure = exposure, tone = "srgb" } end
  local pictures, errors, results = { shown(truth, ("paths, %.0f s"):format(told.seconds.total)) },
    { shown(open, "without bodies in the way") }, {}
  for _, method in ipairs(methods(case)) do
    local caption, options, casters, probes = method[1], {}, method[3], method[4]
    for key, value in pairs(method[2]) do options[key] = value end
    options.lights, options.casters = light, casters
    local shade = assert(ylm.shadowed(options))
    local start, grid = core.seconds(), nil
    if probes then
      local message
      grid, message = ylm.bake(ylm.adaptive_grid { lmax = o.n - 1, depth = o.depth or 8, tolerance = o.tolerance or 0.03 }, shade,
        { occupied = view, threads = o.threads })
      assert(grid, message)
    end
    local baked = core.seconds() - start
    local good, image, report = pcall(view.render, view, { grid = grid or shade, bodies = drawn, threads = o.threads })
    if good and image then
      local miss = image:layer "radiance":select(mask) - want
      local seconds = baked + report.seconds.light
      local rms = math.sqrt(math.max(0, root(miss) ^ 2 / unshadowed ^ 2 - noise ^ 2))
      results[#results + 1] = { caption, 100 * rms, seconds, report.points, grid and grid.stats.points }
      pictures[#pictures + 1] = shown(image, ("%s: %.2g s"):format(caption, seconds))
      errors[#errors + 1] = shown(image:difference(truth, { scale = 10 }),
        ("%s: 10 x error, rms %.2g %%"):format(caption, 100 * rms))
    else
      results[#results + 1] = { caption .. (tostring(image):match " diverges" or ": " .. tostring(image)) }
    end
  end
  return pictures, errors, results, 100 * noise
end

return shadows
