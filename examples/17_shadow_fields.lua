-- Cost and errors of shadow fields: pictures and tables of docs/shadow_fields.md.
--
--     ylm run examples/17_shadow_fields.lua [--out DIR] [--only NAME] [--paths 262144] [--quick]
--
-- NAME is errors, slice, lobes or probes; each leaves shadow_NAME.png in out/, and prints the numbers that the page quotes.
--   errors  irradiance of a floor behind eight cubes and behind eight balls, all products and SHEXP, beside --paths paths a
--           place; and time
--   slice   the visibility around a knot from shells (Zhou et al. 2005) and from a grid of as many bytes: errors on a plane
--   lobes   the visibility along a line that passes a body, as lobes
--   probes  shadows of bodies that stand and float: voxels that probes refine
-- --quick draws small ones. Times are of one thread; lengths are metres.

local ylm = require "ylm"
local core = require "ylm.c.core"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")
local option = common.options { out = "out", only = "", threads = 2, paths = 262144, quick = false }
local quick = option.quick
ylm.on_warning(false)

local sh = ylm.sh
local pictures, order = {}, {}

--- Adds a picture: f() makes it.
local function picture(name, f) pictures[name], order[#order + 1] = f, name end

--- The first of two values where pictures are quick ones, else the second.
local function number(least, most) return quick and least or most end

--- Random numbers 0 .. 1, equal on all machines (Park and Miller 1988).
local state
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- Nine numbers, row by row, of a quaternion.
local function matrix(q)
  local a, b, c, d = q[1], q[2], q[3], q[4]
  local s = 2 / (a * a + b * b + c * c + d * d)
  return { 1 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c), s * (b * c + a * d), 1 - s * (b * b + d * d),
    s * (c * d - a * b), s * (b * d - a * c), s * (c * d + a * b), 1 - s * (b * b + c * c) }
end

-- Errors and times of products -------------------------------------------------------------------------

local BODIES = 8

--- Light of degree 2: what errors are of is the bodies.
local smooth = { math.sqrt(4 * math.pi), 0.3, 0.5, -0.4, 0.2, 0.1, -0.2, 0.15, 0.1 }
local function sky(lmax) return ylm.environment_light { coefficients = sh.resize(smooth, lmax) } end

--- Eight cubes, turned, and spheres in their place; places of a floor z = 0.
local function cubes()
  local at, turn, scale, floor, centres, radii, body = {}, {}, {}, {}, {}, {}, {}
  for i = 1, BODIES do
    local phi, r = 2 * math.pi * i / BODIES, 0.6 + 1.4 * random()
    at[i] = { r * math.cos(phi), r * math.sin(phi), 0.7 + 0.9 * random() }
    turn[i] = { random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5 }
    scale[i] = 0.35 + 0.3 * random()
  end
  for i = 1, number(6, 48) do floor[i] = { 4 * random() - 2, 4 * random() - 2, 0 } end
  local c, r = ylm.sphere_set(ylm.box {}, { count = number(4, 32) })
  c, r = c:totable(), r:totable()
  for i = 1, BODIES do
    local m = matrix(turn[i])
    for k = 1, #r do
      local p = {}
      for a = 1, 3 do
        p[a] = at[i][a] + scale[i] * (m[3 * a - 2] * c[k][1] + m[3 * a - 1] * c[k][2] + m[3 * a] * c[k][3])
      end
      centres[#centres + 1], radii[#radii + 1], body[#body + 1] = p, scale[i] * r[k], i
    end
  end
  local function casters(hides, surface)
    return ylm.casters { hides = hides, at = at, rotation = turn, scale = scale, surface = surface }
  end
  return { name = "cubes", shape = ylm.box {}, casters = casters, floor = floor, spheres = function()
    return ylm.sphere_casters { at = centres, radius = radii, body = body }
  end, count = #r }
end

--- Eight balls over a floor.
local function balls()
  local at, radius, body, floor = {}, {}, {}, {}
  for i = 1, BODIES do
    local phi, r = 2 * math.pi * i / BODIES, 0.6 + 1.4 * random()
    at[i], radius[i], body[i] = { r * math.cos(phi), r * math.sin(phi), 0.7 + 0.9 * random() }, 0.2 + 0.15 * random(), i
  end
  for i = 1, number(6, 48) do floor[i] = { 4 * random() - 2, 4 * random() - 2, 0 } end
  return { name = "balls", casters = function(hides, surface)
    return ylm.casters { hides = hides, at = at, scale = radius, surface = surface }
  end, floor = floor, spheres = function() return ylm.sphere_casters { at = at, radius = radius, body = body } end, count = 1 }
end

--- Microseconds of a place, one thread: f(points) for as many places as take a while, the best of three.
local function time(floor, f)
  local count, us = #floor, math.huge
  local function many(n)
    local list = {}
    for i = 1, n do list[i] = floor[(i - 1) % #floor + 1] end
    return ylm.array(list, "float")
  end
  local points = many(count)
  for round = 1, number(1, 4) do
    local begin = os.clock()
    f(points)
    us = math.min(us, (os.clock() - begin) * 1e6 / count)
    if round == 1 and not quick then
      count = math.max(count, math.min(4000, math.floor(3e5 / us)))
      points = many(count)
    end
  end
  return us
end

--- Irradiance of a case's floor by paths with bodies and without them: [n], the open one, the noise in % of it.
local function by_paths(case, hides, surface)
  local shade = ylm.shadowed { lights = sky(2), casters = case.casters(hides, surface) }
  local scene = ylm.scene(case.name) { geometry = { shade:surfaces() }, lights = { sky(2) } }
  local normals = {}
  for i = 1, #case.floor do normals[i] = { 0, 0, 1 } end
  local E, variance, report = assert(scene:probe { points = case.floor, normals = normals, reflections = { 0, 0 },
    samples = number(4096, option.paths), threads = option.threads })
  local open = sh.irradiance(ylm.array(smooth), { 0, 0, 1 })
  local truth, noise = {}, 0
  for i = 1, #case.floor do truth[i], noise = E:get(i, 1), noise + variance:get(i, 1) end
  print(("%s: %s paths a place, %.0f s; standard error %.3f %% of the light without bodies"):format(case.name,
    common.thousands(report.samples), report.seconds, 100 * math.sqrt(noise / #truth) / open))
  return truth, open, 100 * math.sqrt(noise / #truth) / open
end

--- { caption, colour, casters of lmax, options of ylm.shadowed, probes }, in the order of the legend.
local function methods(case)
  local field = case.shape and ylm.occluder { geometry = case.shape } or ylm.occluder { radius = 1 }
  local fields = {}
  local function grid(lmax)
    fields[lmax] = fields[lmax] or case.shape and assert(ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = number(5, 10),
      tolerance = number(0.2, 0.03), channels = "luminance" }, field, { threads = option.threads })) or field
    return case.casters(fields[lmax])
  end
  local function exact() return case.casters(field) end
  local list = { { "one rule", { 0.00, 0.45, 0.70 }, grid }, { "accurate", { 0.84, 0.37, 0 }, grid, { product = "accurate" } },
    { "recursive", { 0.80, 0.47, 0.65 }, grid, { product = "recursive" } } }
  if case.shape then list[#list + 1] = { "one rule, exact faces", { 0.34, 0.71, 0.91 }, exact } end
  list[#list + 1] = { "one rule, probes", { 0, 0.62, 0.45 }, grid, {}, true }
  list[#list + 1] = { case.shape and ("%d spheres a body"):format(case.count) or "at directions", { 0.90, 0.62, 0 },
    case.spheres }
  list[#list + 1] = { "SHEXP, HYB", { 0.35, 0.35, 0.35 }, case.spheres, { product = "exp" } }
  list[#list + 1] = { "SHEXP, PS-9", { 0.65, 0.65, 0.65 }, case.spheres, { product = "exp", exp = "PS" } }
  return list, field
end

--- Light at places by shadowed light, and microseconds of one; probes: of a floor of many vertices.
local function solved(method, lmax, case)
  local o = { lights = sky(lmax), casters = method[3](lmax) }
  for key, value in pairs(method[4] or {}) do o[key] = value end
  local shade = ylm.shadowed(o)
  local as = { channels = "luminance", threads = 1 }
  if not method[5] then
    return ylm.light_field(lmax, shade, case.floor, as), time(case.floor, function(points)
      ylm.light_field(lmax, shade, points, as)
    end)
  end
  local side, vertices = number(20, 174), {}
  for x = 0, side - 1 do
    for y = 0, side - 1 do vertices[#vertices + 1] = { 4.4 * x / (side - 1) - 2.2, 4.4 * y / (side - 1) - 2.2, 0 } end
  end
  vertices = ylm.array(vertices, "float")
  local begin = os.clock()
  local grid = assert(ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = number(5, 9), tolerance = 0.03, channels = "luminance",
    bounds = { { -2.5, -2.5, -0.1 }, { 2.5, 2.5, 4.9 } } }, shade, { occupied = vertices, threads = 1 }))
  grid:sample(vertices, { threads = 1 })
  return grid:sample(case.floor), (os.clock() - begin) * 1e6 / #vertices, grid.stats.points, #vertices
end

picture("errors", function()
  state = 7
  local plots = {}
  local line = common.table { { "bodies", "%-6s" }, { "n", "%2d" }, { "method", "%-21s" }, { "rms error %", "%11.3f" },
    { "most %", "%7.2f" }, { "us a place", "%10.2f" }, { "probes", "%6d" } }
  for _, case in ipairs { cubes(), balls() } do
    local list, field = methods(case)
    local surface = case.shape or ylm.sphere { radius = 1, divide = { 256, 128 } }
    local truth, open, noise = by_paths(case, field, surface)
    local series = {}
    for _, method in ipairs(list) do
      local x, y = {}, {}
      for _, lmax in ipairs(number({ 4 }, { 4, 9, 14 })) do
        local good, L, us, probes = pcall(solved, method, lmax, case)
        if good then
          local sum, most = 0, 0
          for i = 1, #truth do
            local c = {}
            for k = 1, (lmax + 1) ^ 2 do c[k] = L:get(i, 1, k) end
            local e = (sh.irradiance(c, { 0, 0, 1 }) - truth[i]) / open
            sum, most = sum + e * e, math.max(most, math.abs(e))
          end
          local rms = math.sqrt(math.max(1e-8, sum / #truth * 1e4 - noise ^ 2))
          line { case.name, lmax + 1, method[1], rms, 100 * most, us, probes }
          if rms < 50 then x[#x + 1], y[#y + 1] = us, rms end
        else
          line { case.name, lmax + 1, method[1] .. (tostring(L):match "diverge" and " diverges" or ": " .. tostring(L)) }
        end
      end
      if #x > 0 then series[#series + 1] = { x = x, y = y, label = method[1], colour = method[2] } end
    end
    plots[#plots + 1] = { image = ylm.plot { size = { 560, 500 }, log = true, series = series,
      title = ("Eight %s"):format(case.name), x_label = "microseconds a place, one thread",
      y_label = "rms error of irradiance [% of that without bodies]", legend = "top left",
      x_range = quick and nil or { 0.2, 1000 }, y_range = quick and nil or { 0.03, 50 } } }
  end
  return ylm.figure { rows = { plots }, caption = "Marks from left to right: n = 5, 10, 15. Probes: bake and look-ups of 30,276 "
    .. "vertices, in parts." }
end)

-- A slice around a knot ----------------------------------------------------------------------------------

local axes = { { 1, 2, 3 }, { 2, 3, 1 }, { 3, 1, 2 } }

--- A function of places: rows of a field from shells of 6 n^2 + 2 directions of a cube map and m radii, linear in all.
local function shells(field, lmax, n, m, near, far)
  local points, at = {}, {}
  for face = 1, 6 do
    local f, sign = axes[math.ceil(face / 2)], face % 2 == 1 and 1 or -1
    for j = 0, n do for i = 0, n do
      local w = {}
      w[f[1]], w[f[2]], w[f[3]] = sign, math.tan((2 * i / n - 1) * math.pi / 4), math.tan((2 * j / n - 1) * math.pi / 4)
      local length = math.sqrt(w[1] ^ 2 + w[2] ^ 2 + w[3] ^ 2)
      local name = ("%.6f %.6f %.6f"):format(w[1] / length + 2, w[2] / length + 2, w[3] / length + 2)
      if not at[name] then -- directions of edges are of several faces
        at[name] = #points
        for k = 0, m - 1 do
          local r = near * (far / near) ^ (k / (m - 1)) / length
          points[#points + 1] = { r * w[1], r * w[2], r * w[3] }
        end
      end
      at[(face * (n + 1) + j) * (n + 1) + i] = at[name]
    end end
  end
  local V = ylm.light_field(lmax, field, points, { channels = "luminance", threads = option.threads })
  local count = (lmax + 1) ^ 2
  V = V:reshape { #points, count }
  return function(where)
    local rows = {}
    for q, p in ipairs(where) do
      local most, axis = 0, 1
      for a = 1, 3 do if math.abs(p[a]) > most then most, axis = math.abs(p[a]), a end end
      local f = axes[axis]
      local face, place = 2 * axis - (p[axis] > 0 and 1 or 0), { (math.atan(p[f[2]] / most) * 4 / math.pi + 1) / 2 * n,
        (math.atan(p[f[3]] / most) * 4 / math.pi + 1) / 2 * n,
        math.log(math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2) / near) / math.log(far / near) * (m - 1) }
      local low, part = {}, {}
      for a = 1, 3 do
        low[a] = math.min((a == 3 and m or n + 1) - 2, math.max(0, math.floor(place[a])))
        part[a] = math.min(1, math.max(0, place[a] - low[a]))
      end
      local row
      for corner = 0, 7 do
        local b = { corner % 2, math.floor(corner / 2) % 2, math.floor(corner / 4) }
        local weight = 1
        for a = 1, 3 do weight = weight * (b[a] == 1 and part[a] or 1 - part[a]) end
        local term = V[1 + at[(face * (n + 1) + low[2] + b[2]) * (n + 1) + low[1] + b[1]] + low[3] + b[3]] * weight
        row = row and row + term or term
      end
      rows[q] = row
    end
    return ylm.stack(rows)
  end, #points
end

--- Pixels of places in a square picture on edges of a grid's voxels that are larger than `least`.
local function edges_of(grid, where, side, least)
  local edge = {}
  for y = 1, side do
    local last
    for x = 1, side do
      local cell = grid:locate(where[(y - 1) * side + x])
      local above = y > 1 and grid:locate(where[(y - 2) * side + x])
      local other = last and last ~= cell.index or above and above.index ~= cell.index
      if other and cell.size[1] > least then edge[(y - 1) * side + x] = true end
      last = cell.index
    end
  end
  return edge
end

picture("slice", function()
  local lmax, side, reach = 9, number(12, 150), 2.2
  local knot = ylm.knot { radius = 0.6, minor = 0.26, tube = 0.13, divide = number({ 40, 8 }, { 160, 16 }) }
  local body = ylm.occluder { geometry = knot, rays = number(12, 16), near = 0.1 }
  local far = 4 * body.radius
  local grid, message = ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = number(4, 9), tolerance = number(0.3, 0.05),
    channels = "luminance", continuous = false, bounds = { { -far, -far, -far }, { far, far, far } } }, body,
    { threads = option.threads })
  assert(grid, message)
  local rows = grid.stats.bytes / 4 / (lmax + 1) ^ 2 -- numbers of shells that take as many bytes
  local radii = number(5, 33)
  local n = math.floor(math.sqrt((rows / radii - 2) / 6) + 0.5)
  local near = 0.2 * body.radius
  local from_shells, samples = shells(body, lmax, n, radii, near, far)
  local where = {}
  for y = 1, side do
    for x = 1, side do
      where[#where + 1] = { reach * (2 * (x - 0.5) / side - 1), reach * (1 - 2 * (y - 0.5) / side), 0 }
    end
  end
  local V, _, _, report = ylm.light_field(lmax, body, where, { channels = "luminance", threads = option.threads })
  local count = (lmax + 1) ^ 2
  V = V:reshape { #where, count }
  local inside = report.inside:totable()
  local wide = math.ceil(0.1 * body.radius * side / (2 * reach))
  local judged = {} -- pixels as far from the knot as the tolerance of the grid holds, where shells are known
  for y = 1, side do
    for x = 1, side do
      local p = where[(y - 1) * side + x]
      local far_off = p[1] ^ 2 + p[2] ^ 2 >= near ^ 2
      for v = math.max(1, y - wide), math.min(side, y + wide) do
        for u = math.max(1, x - wide), math.min(side, x + wide) do
          far_off = far_off and (inside[(v - 1) * side + u] == 0 or (u - x) ^ 2 + (v - y) ^ 2 > wide ^ 2)
        end
      end
      judged[(y - 1) * side + x] = far_off
    end
  end
  local edge = edges_of(grid, where, side, 7 * 2 * reach / side)
  local names = { ("shells: %d directions, %d radii"):format(6 * n * n + 2, radii),
    ("grid, tolerance 0.05: %d probes"):format(grid.stats.points) }
  local line = common.table { { "form", "%-38s" }, { "samples", "%7d" }, { "MB", "%6.1f" }, { "mean error", "%10.4f" },
    { "error of 99 %", "%13.4f" }, { "largest", "%7.3f" } }
  local items = {}
  for k, found in ipairs { from_shells(where), grid:sample(where):reshape { #where, count } } do
    local d = (((found - V) ^ 2):sum(2):sqrt() / math.sqrt(4 * math.pi)):totable()
    local values, sorted, sum = {}, {}, 0
    for i = 1, #d do
      if judged[i] then sorted[#sorted + 1], sum = d[i], sum + d[i] end
      values[i] = inside[i] == 1 and 0 / 0 or k == 2 and edge[i] and 1 or math.max(d[i], 1e-5)
    end
    table.sort(sorted)
    line { names[k], k == 1 and samples or grid.stats.points, (k == 1 and samples * count * 4 or grid.stats.bytes) / 2 ^ 20,
      sum / #sorted, sorted[math.ceil(0.99 * #sorted)], sorted[#sorted] }
    local square = {}
    for y = 1, side do
      square[y] = {}
      for x = 1, side do square[y][x] = values[(y - 1) * side + x] end
    end
    items[k] = { values = square, caption = ("%s, error of 99 %%: %.3f"):format(names[k], sorted[math.ceil(0.99 * #sorted)]) }
  end
  return ylm.figure { rows = { items }, bar = { range = { 1e-3, 0.3 }, log = true, map = "magma",
    label = "error of V, part of the function 1" }, width = number(nil, 1100), font = 15 }
end)

-- Lobes along a line ----------------------------------------------------------------------------------------

picture("lobes", function()
  local block = ylm.box { scale = { 0.6, 0.8, 0.6 }, rotate = { axis = { 0, 1, 0 }, angle = 30 } }
  local body = ylm.occluder { geometry = block }
  local caster = ylm.caster { hides = body }
  local places = {}
  for i = -3, 3 do places[#places + 1] = { 0.72 * i, 0, 0.8 } end
  local divide = number({ 24, 12 }, { 160, 80 })
  local unit = ylm.sphere { radius = 1, divide = divide }.mesh
  local directions, triangles = unit:vertices(), unit:triangles()
  local dirs = directions:totable()
  local items = {}
  for _, lmax in ipairs(number({ 4, 9 }, { 4, 9, 14, 60 })) do
    local V = ylm.visibility(lmax, caster, places)
    local meshes = { { block, colour = { 0.55, 0.55, 0.58 }, opacity = 0.5 } }
    for i, p in ipairs(places) do
      local open, vertices, colours = sh.reconstruct(V[i]:totable(), directions):totable(), {}, {}
      for k, w in ipairs(dirs) do
        local v = math.max(0.03, open[k])
        vertices[k] = { p[1] + 0.3 * v * w[1], p[2] + 0.3 * v * w[2], p[3] + 0.3 * v * w[3] }
        local t = math.min(1, math.max(0, open[k]))
        colours[k] = { 0.08 + 0.87 * t, 0.22 + 0.44 * t, 0.55 - 0.39 * t }
      end
      meshes[#meshes + 1] = { ylm.mesh { vertices = vertices, triangles = triangles }, colours = colours }
      if lmax == 9 then
        print(("x = %5.2f: %.1f %% of all directions are open"):format(p[1], 100 * V:get(i, 1) / math.sqrt(4 * math.pi)))
      end
    end
    items[#items + 1] = { { image = ylm.view { meshes = meshes, size = number({ 240, 68 }, { 1000, 250 }), frame = false,
      background = "white", camera = ylm.camera { from = { 0, 4.7, -2.6 }, at = { 0, 0, 0.26 }, fov = 17.5 } },
      label = ("n = %d"):format(lmax + 1) } }
  end
  return ylm.figure { rows = items }
end)

-- Probes over a floor ---------------------------------------------------------------------------------------

picture("probes", function()
  local lmax, size = number(4, 9), number({ 64, 48 }, { 420, 320 })
  local function paint(r, g, b) return ylm.matte { albedo = { r, g, b } } end
  local edge = { 0.7, 0.7, 0.7 }
  local lights = { ylm.sphere_light { at = { 2.2, 3.6, 1.6 }, radius = 0.8, radiance = { 22, 19.5, 15.5 } },
    ylm.environment_light { radiance = { 0.10, 0.13, 0.19 } } }
  local ground = ylm.quad { corner = { -6, 0, 6 }, u = { 12, 0, 0 }, v = { 0, 0, -12 }, material = paint(0.72, 0.7, 0.66) }
  local cube = assert(ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = number(5, 10), tolerance = number(0.2, 0.03),
    channels = "luminance" }, ylm.occluder { geometry = ylm.box { scale = edge } }, { threads = option.threads }))
  local function ball(at, radius, material)
    return ylm.caster { hides = ylm.occluder { radius = radius }, at = at,
      surface = ylm.sphere { radius = radius, divide = { 48, 24 }, material = material } }
  end
  local under = ylm.caster { at = { 0, -0.502, 0 }, hides = ylm.occluder { geometry = ylm.box { scale = { 12, 1, 12 } } } }
  local all = ylm.shadowed { lights = lights, casters = { under, -- the floor hides the sky below bodies
    stands = ylm.caster { hides = cube, at = { -0.95, 0.35, 0.45 }, rotation = { axis = { 0, 1, 0 }, angle = 25 },
      surface = ylm.box { scale = edge, divide = 10, material = paint(0.7, 0.26, 0.14) } },
    floats = ball({ 0.9, 1.05, 0.1 }, 0.4, paint(0.2, 0.4, 0.66)), rests = ball({ 0.25, 0.3, 1.15 }, 0.3, paint(0.78, 0.6, 0.2)),
  } }
  local moving = all:without()
  local camera = ylm.camera { from = { 0, 4.2, 3.9 }, at = { -0.15, 0.15, 0.25 }, fov = 40 }
  local scene = ylm.scene "Probes over a floor" { geometry = ground, lights = lights, camera = camera }
  local truth = assert(ylm.scene "paths" { geometry = { ground, all:surfaces() }, lights = lights, camera = camera }
    :pathtrace { size = size, samples = number(16, 256), reflections = { 1, 1 }, threads = option.threads })
  local view = assert(scene:prepare { size = size, samples = number(1, 4), lmax = lmax, visibility = "none",
    threads = option.threads })
  local line = common.table { { "tolerance", "%9.3f" }, { "probes", "%7d" }, { "largest error at 99 %", "%21.4f" },
    { "least voxel [m]", "%15.4f" }, { "met", "%-3s" } }
  local shown
  for _, tolerance in ipairs(number({ 0.1 }, { 0.1, 0.03 })) do
    local grid = assert(ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = number(5, 9), tolerance = tolerance,
      bounds = { { -6.1, -0.1, -6.1 }, { 6.1, 12.1, 6.1 } } }, moving, { occupied = view, threads = option.threads }))
    local image = assert(view:render { grid = grid, bodies = all, threads = option.threads })
    local bare = assert(view:render { grid = grid, threads = option.threads })
    local levels, values, least = image:layer "level", {}, math.huge
    local drawn = ((image:layer "radiance" - bare:layer "radiance") ^ 2):sum(3):reshape { size[2], size[1] }:totable()
    for y = 1, size[2] do
      values[y] = {}
      for x = 1, size[1] do
        local wide = 12.2 / 2 ^ levels:get(y, x, 1)
        least = math.min(least, wide)
        values[y][x] = drawn[y][x] > 1e-9 and 0 / 0 or wide
      end
    end
    line { tolerance, grid.stats.points, grid.stats.error, least, grid.stats.met and "yes" or "no" }
    shown = { { image = truth, exposure = -0.5, caption = "paths" }, { image = image, exposure = -0.5,
      caption = ("%s probes, n = %d, tolerance %g"):format(common.thousands(grid.stats.points), lmax + 1, tolerance) },
      { values = values, caption = "edges of the voxels at the floor" } }
  end
  return ylm.figure { rows = { shown }, bar = { range = { 0.02, 1 }, log = true, map = "viridis", label = "edge of the voxel",
    unit = "m" } }
end)

if option.only ~= "" and not pictures[option.only] then error("--only: no picture " .. option.only, 0) end
for _, name in ipairs(order) do
  if option.only == "" or option.only == name then
    local begin = core.seconds()
    common.save(pictures[name](), option.out .. "shadow_" .. name .. ".png")
    print(("%s: %.0f s"):format(name, core.seconds() - begin))
  end
end
