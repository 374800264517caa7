--- Rooms whose light is known in closed form: { name, samples for a noise of 2 %, long for 0.2 %,
-- measure(ylm, samples) -> estimate, standard error, truth }.
-- docs/paths.md "How it is checked" has the formulas.

local closed = { cases = {} }

local pi = math.pi

local function add(name, samples, long, measure)
  closed.cases[#closed.cases + 1] = { name = name, samples = samples, long = long, measure = measure }
end

--- Mean over points, channel 2, and its standard error; weights (default equal) add up to 1.
local function mean(E, v, weights)
  local n, sum, variance = #E, 0, 0
  for i = 1, n do
    local w = weights and weights[i] or 1 / n
    sum, variance = sum + w * E:get(i, 2), variance + w * w * v:get(i, 2)
  end
  return sum, math.sqrt(variance)
end

-- Spheres seen from inside ----------------------------------------------------------------

local RADIUS, RADIANCE, RHO = 0.1, 10, 0.5
local WITHIN = 1 - 5e-4 -- where points are: facets are within the sphere

local function globe(ylm, a)
  return ylm.scene "globe" {
    geometry = { ylm.sphere { radius = 1, divide = { 192, 96 }, material = ylm.matte { albedo = RHO } } },
    lights = { ylm.sphere_light { at = { 0, 0, a }, radius = RADIUS, radiance = RADIANCE } },
  }
end

--- Places on the sphere with cosine c from the z axis, in the middle of facets, and normals inwards.
local function places(c)
  local points, normals = {}, {}
  local theta = pi / 96 * (math.floor(math.acos(c) / (pi / 96)) + 0.5)
  for i = 1, 16 do
    local u = 2 * pi * (12 * i + 0.5) / 192
    local d = { math.sin(theta) * math.cos(u), math.sin(theta) * math.sin(u), math.cos(theta) }
    points[i], normals[i] = { WITHIN * d[1], WITHIN * d[2], WITHIN * d[3] }, { -d[1], -d[2], -d[3] }
  end
  return points, normals, math.cos(theta)
end

--- A sphere with a lamp off its centre, n places of it with normals inwards, and the bounced light of all of them.
function closed.globe(ylm, n)
  local points, normals = {}, {}
  for k = 1, n do
    local theta = pi / 96 * (math.floor(math.acos(1 - 2 * (k - 0.5) / n) / (pi / 96)) + 0.5)
    local u = 2 * pi * (math.floor(192 * (k * 0.618034 % 1)) + 0.5) / 192
    local d = { math.sin(theta) * math.cos(u), math.sin(theta) * math.sin(u), math.cos(theta) }
    points[k], normals[k] = { WITHIN * d[1], WITHIN * d[2], WITHIN * d[3] }, { -d[1], -d[2], -d[3] }
  end
  return globe(ylm, 0.5), points, normals, RHO / (1 - RHO) * pi * RADIANCE * RADIUS ^ 2
end

for order, samples in pairs { [0] = { 1024, 1024 }, { 1024, 1024 }, { 1024, 2048 }, [5] = { 4096, 400000 } } do
  add(("order %d of a sphere around a lamp: rho^%d"):format(order, order), samples[1], samples[2], function(ylm, n)
    local points, normals = places(0.3)
    local E, v = globe(ylm, 0):probe { points = points, normals = normals, samples = n, reflections = { order, order } }
    local m, e = mean(E, v)
    return m, e, pi * RADIANCE * RADIUS ^ 2 * RHO ^ order / (order == 0 and WITHIN ^ 2 or 1)
  end)
end

add("all orders of it: 1 / (1 - rho)", 1024, 1024, function(ylm, samples)
  local points, normals = places(-0.6)
  local E, v = globe(ylm, 0):probe { points = points, normals = normals, samples = samples }
  local m, e = mean(E, v)
  return m, e, pi * RADIANCE * RADIUS ^ 2 / (1 - RHO)
end)

for _, c in ipairs { 0.9, -0.5 } do
  add(("direct light of a lamp off the centre, cosine %g"):format(c), 256, 512, function(ylm, samples)
    local points, normals, cosine = places(c)
    local E, v = globe(ylm, 0.5):probe { points = points, normals = normals, samples = samples, bounces = 0 }
    local m, e = mean(E, v)
    return m, e, pi * RADIANCE * RADIUS ^ 2 * (WITHIN - 0.5 * cosine) / (WITHIN ^ 2 + 0.25 - WITHIN * cosine) ^ 1.5
  end)
  add(("bounced light of a lamp off the centre, cosine %g: uniform"):format(c), 2048, 4096, function(ylm, samples)
    local points, normals = places(c)
    local E, v = globe(ylm, 0.5):probe { points = points, normals = normals, samples = samples, reflections = { 1, "all" } }
    local m, e = mean(E, v)
    return m, e, RHO / (1 - RHO) * pi * RADIANCE * RADIUS ^ 2
  end)
end

for l = 0, 2 do
  add(("coefficient %d, 0 of bounced light at the centre, lamp off it"):format(l), 32768,
    ({ 65536, 1400000, 3200000 })[l + 1], function(ylm, samples)
    local a, e = 0.5, RADIANCE * RADIUS ^ 2
    local c, v = globe(ylm, a):probe { points = { { 0, 0, 0 } }, lmax = 2, samples = samples, reflections = { 1, "all" } }
    local truth = RHO * e * (l + 1) * a ^ l * math.sqrt(4 * pi / (2 * l + 1))
    if l == 0 then truth = truth + math.sqrt(4 * pi) * RHO * e * RHO / (1 - RHO) end
    local i = l * (l + 1) + 1
    return c:get(1, 2, i), math.sqrt(v:get(1, 2, i)), truth
  end)
end

-- Under a sky --------------------------------------------------------------------------------

--- The part of a sphere below z = -cos(g) about its pole, open to the sky.
local function bowl(ylm, g)
  local around, rings, vertices, triangles, normals = 192, 64, {}, {}, {}
  for k = 0, rings do
    local t = g * k / rings
    for i = 0, around - 1 do
      local u = 2 * pi * i / around
      local d = { math.sin(t) * math.cos(u), math.sin(t) * math.sin(u), -math.cos(t) }
      vertices[#vertices + 1], normals[#normals + 1] = d, { -d[1], -d[2], -d[3] }
    end
  end
  for k = 0, rings - 1 do
    for i = 0, around - 1 do
      local a, b = k * around + i + 1, k * around + (i + 1) % around + 1
      triangles[#triangles + 1] = { a, a + around, b + around }
      if k > 0 then triangles[#triangles + 1] = { a, b + around, b } end
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles, normals = normals, material = ylm.matte { albedo = RHO } }
end

add("a bowl under a uniform sky, all bounces", 1024, 1536, function(ylm, samples)
  local g = 1.2
  local s = (1 - math.cos(g)) / 2
  local scene = ylm.scene "bowl" { geometry = { bowl(ylm, g) }, lights = { ylm.environment_light { radiance = 1 } } }
  local points, normals = {}, {}
  for i = 1, 16 do
    local t, u = g * (math.floor(64 * (i - 0.5) / 16) + 0.5) / 64, 2 * pi * (12 * i + 0.5) / 192
    local d = { math.sin(t) * math.cos(u), math.sin(t) * math.sin(u), -math.cos(t) }
    points[i] = { 0.9995 * d[1], 0.9995 * d[2], 0.9995 * d[3] }
    normals[i] = { -d[1], -d[2], -d[3] }
  end
  local E, v = scene:probe { points = points, normals = normals, samples = samples }
  local m, e = mean(E, v)
  return m, e, pi * (1 - s) / (1 - RHO * s)
end)

add("a white furnace: a knot of albedo 1 under a uniform sky", 512, 512, function(ylm, samples)
  local knot = ylm.knot { p = 2, q = 3, radius = 1, minor = 0.4, tube = 0.2, material = ylm.matte { albedo = 1 } }
  local scene = ylm.scene "furnace" {
    camera = ylm.camera { from = { 0, -4, 1 }, up = { 0, 0, 1 }, fov = 40 }, geometry = { knot },
    lights = { ylm.environment_light { radiance = 1 } },
  }
  local image = scene:pathtrace { size = { 16, 12 }, samples = samples, layers = false }
  local x, v, sum, variance = image:layer "radiance", image:layer "variance", 0, 0
  for i = 1, 12 do
    for k = 1, 16 do sum, variance = sum + x:get(i, k, 2) / 192, variance + v:get(i, k, 2) / 192 ^ 2 end
  end
  return sum, math.sqrt(variance) + 1e-6, 1
end)

-- Boxes --------------------------------------------------------------------------------------

--- Nodes and weights of Gauss' rule of n points on 0 .. 1.
local function gauss(n)
  local x, w = {}, {}
  for i = 1, n do
    local z, slope = math.cos(pi * (i - 0.25) / (n + 0.5)), nil
    for _ = 1, 50 do
      local p0, p1 = 1, z
      for k = 2, n do p0, p1 = p1, ((2 * k - 1) * z * p1 - (k - 1) * p0) / k end
      slope = n * (z * p1 - p0) / (z * z - 1)
      z = z - p1 / slope
    end
    x[i], w[i] = (1 - z) / 2, 1 / ((1 - z * z) * slope * slope)
  end
  return x, w
end

--- Places of a parallelogram with their shares of its area.
local function spread(corner, u, v, normal, n, into)
  local x, w = gauss(n)
  for i = 1, n do
    for k = 1, n do
      local p = {}
      for a = 1, 3 do p[a] = corner[a] + x[i] * u[a] + x[k] * v[a] end
      table.insert(into.points, p)
      table.insert(into.normals, normal)
      table.insert(into.weights, w[i] * w[k])
    end
  end
end

local faces = { -- of the unit cube: corner, u, v, inward normal
  { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, { { 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, -1 } },
  { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 }, { 0, 1, 0 } }, { { 0, 1, 0 }, { 1, 0, 0 }, { 0, 0, 1 }, { 0, -1, 0 } },
  { { 0, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 0 } }, { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { -1, 0, 0 } },
}

local function cube(ylm, lights, albedo)
  return ylm.scene "cube" { lights = lights,
    geometry = { ylm.box { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, material = ylm.matte { albedo = albedo } } } }
end

add("the energy of a closed room: flux / (1 - rho)", 512, 512, function(ylm, samples)
  local r, e = 0.15, 2
  local scene = cube(ylm, { ylm.sphere_light { at = { 0.4, 0.55, 0.5 }, radius = r, radiance = e } }, 0.6)
  local all = { points = {}, normals = {}, weights = {} }
  for _, f in ipairs(faces) do spread(f[1], f[2], f[3], f[4], 6, all) end
  local E, v = scene:probe { points = all.points, normals = all.normals, samples = samples }
  local m, error = mean(E, v, all.weights)
  return m, error, 4 * pi * pi * r * r * e / (1 - 0.6)
end)

for _, case in ipairs { { "floor", faces[1], 0.1998248957 }, { "wall", faces[3], 0.2000437761 } } do
  add("the form factor of a ceiling and a " .. case[1], 256, 512, function(ylm, samples)
    local ceiling = ylm.polygon_light { vertices = { { 0, 0, 1 }, { 1, 0, 1 }, { 1, 1, 1 }, { 0, 1, 1 } }, radiance = 1 }
    local all = { points = {}, normals = {}, weights = {} }
    spread(case[2][1], case[2][2], case[2][3], case[2][4], 10, all)
    local scene = ylm.scene "ceiling" { lights = { ceiling } }
    local E, v = scene:probe { points = all.points, normals = all.normals, samples = samples, bounces = 0 }
    local m, error = mean(E, v, all.weights)
    return m, error, pi * case[3]
  end)
end

return closed
