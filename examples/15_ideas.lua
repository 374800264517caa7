-- A figure for each idea of docs/math.md, docs/grids.md and docs/surfaces.md that no other example draws.
--
--     ylm run examples/15_ideas.lua [--out DIR] [--only NAME] [--quick]
--
-- Leaves idea_NAME.png in out/, of parts sides.png, and prints the numbers that the pages quote. NAME is tree, metrics, normals,
-- rims, texture, choice, measure, sides, parts, rectangles, charts, inside, continuity or moving. --quick draws small ones.

local ylm = require "ylm"
local core = require "ylm.c.core"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")
local option = common.options { out = "out", only = "", quick = false }
local quick = option.quick

local ideas, order, files = {}, {}, {}

--- Adds an idea: f() makes its picture, idea_NAME.png or another file.
local function idea(name, f, file)
  ideas[name], order[#order + 1], files[name] = f, name, file or "idea_" .. name .. ".png"
end

local function number(least, most) return quick and least or most end

--- Random numbers 0 .. 1, equal on all machines (Park and Miller 1988).
local state = 1
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- An image of an array [h][w][3].
local function image_of(pixels)
  local image = ylm.image { size = { pixels.shape[2], pixels.shape[1] } }
  core.array_fill(image:layer(), pixels:totable())
  return image
end

local half = { 470, 350 } -- a plot or a view beside another

-- docs/math.md ---------------------------------------------------------------------------------------

--- Many virtual lights: errors of their tree, and the lights and proxies that a point sums.
idea("tree", function()
  --- n lights that send as matte surfaces do, on the five sides of a box that is open above.
  local function lights(n)
    state = 1
    local at, normal, intensity = {}, {}, {}
    for i = 1, n do
      local u, v, wall = 2 * random() - 1, 2 * random() - 1, i % 5
      local axis, sign = wall < 4 and wall % 2 * 2 + 1 or 2, wall < 2 and 1 or wall < 4 and -1 or 1
      at[i], normal[i] = { u, v, v }, { 0, 0, 0 }
      at[i][axis == 1 and 3 or 1], at[i][axis], normal[i][axis] = u, -sign, sign
      intensity[i] = { 1 + random(), 1, 1 - 0.5 * random() }
    end
    return ylm.virtual_lights { at = at, normal = normal, radius = 1 / math.sqrt(n), intensity = intensity }
  end
  local points = {}
  for i = 1, number(200, 1000) do points[i] = { 1.8 * random() - 0.9, 1.8 * random() - 0.9, 1.8 * random() - 0.9 } end

  local many, asked, found = lights(number(5000, 50000)), {}, { {}, {}, {} }
  local exact = { ylm.light_field(4, many, points, { derivatives = 2, channels = "luminance" }) }
  for i, tolerance in ipairs { 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001 } do
    asked[i] = tolerance
    local sums = { ylm.light_field(4, many, points, { derivatives = 2, channels = "luminance", tolerance = tolerance }) }
    for k = 1, 3 do
      local errors = ylm.sh.relative_error(sums[k]:reshape { #points, 25 * ({ 1, 3, 6 })[k] },
        exact[k]:reshape { #points, 25 * ({ 1, 3, 6 })[k] }):totable()
      table.sort(errors)
      found[k][i] = math.max(1e-7, errors[math.floor(0.999 * #errors)])
    end
  end
  local counts, summed, all = {}, { {}, {} }, {}
  for i, n in ipairs(quick and { 1000, 10000 } or { 1000, 3000, 10000, 30000, 100000 }) do
    local set = lights(n)
    counts[i], all[i] = n, n
    for k, tolerance in ipairs { 0.1, 0.01 } do
      local _, _, _, report = ylm.light_field(4, set, points, { channels = "luminance", tolerance = tolerance })
      summed[k][i] = report.pairs / #points
    end
    print(("tree: %d lights, a point sums %.0f to 0.1, %.0f to 0.01"):format(n, summed[1][i], summed[2][i]))
  end
  return ylm.figure { rows = { {
    { image = ylm.plot { size = half, log = true, diagonal = "as asked", title = "Errors of the tree",
      x_label = "tolerance", y_label = "relative error of 99.9 % of points",
      series = { { x = asked, y = found[1], label = "value" }, { x = asked, y = found[2], label = "gradient" },
        { x = asked, y = found[3], label = "Hessian" } } } },
    { image = ylm.plot { size = half, log = true, title = "Its work",
      x_label = "virtual lights", y_label = "lights and proxies summed at a point",
      series = { { x = counts, y = all, label = "all of them", dash = "dashed", marker = "none" },
        { x = counts, y = summed[2], label = "to 0.01" }, { x = counts, y = summed[1], label = "to 0.1" } } } },
  } } }
end)

--- Images and metrics: four errors of one mean square, told apart by SSIM and FLIP.
idea("metrics", function()
  local size = quick and { 80, 48 } or { 232, 160 }
  local scene = ylm.scene "a knot and a ball" {
    camera = ylm.camera { from = { 0, 2.1, 4.4 }, at = { 0, 0.55, 0 }, fov = 36 },
    geometry = {
      ylm.quad { corner = { -6, 0, 6 }, u = { 12, 0, 0 }, v = { 0, 0, -12 }, divide = 16 },
      ylm.knot { at = { -0.7, 0.75, 0 }, radius = 0.45, material = ylm.matte { albedo = { 0.7, 0.25, 0.1 } } },
      ylm.sphere { at = { 0.9, 0.55, 0 }, radius = 0.55, material = ylm.matte { albedo = { 0.2, 0.4, 0.7 } } },
    },
    lights = { ylm.sphere_light { at = { -1.5, 3, 2.5 }, radius = 0.2, radiance = 50 },
      ylm.environment_light { radiance = 0.12 } },
  }
  local truth = assert(scene:render { size = size, samples = 16, bounces = 0 })
  local pixels = truth:layer()
  local mean = pixels:mean()

  -- Each error is scaled so that all have one mean square.
  local noise = ylm.sh.random(size[1] * size[2], 0, { seed = 3 }):reshape { size[2], size[1], 1 }
  local small = truth:resize { size[1] / 4, size[2] / 4 }
  local shifted = image_of(pixels)
  shifted:paste(truth:crop(1, 1, size[1] - 3, size[2]), 4, 1)
  local errors = {
    { "noise", pixels * noise }, { "blocks", small:resize(size):layer() - pixels },
    { "shifted", shifted:layer() - pixels }, { "brighter", pixels },
  }
  local wanted = 0.0125 * mean * mean
  local pictures, maps = {}, {}
  for i, each in ipairs(errors) do
    local factor = math.sqrt(wanted / (each[2] ^ 2):mean())
    local picture = image_of(pixels + factor * each[2])
    local judged = picture:compare(truth, { flip = "hdr" })
    print(("metrics: %-9s PSNR %.1f dB, SSIM %.3f, FLIP %.3f"):format(each[1], judged.psnr, judged.ssim, judged.flip))
    local map = picture:flip(truth)
    pictures[i] = { image = picture, tone = "hable", exposure = 1, caption = each[1] }
    maps[i] = { values = map:layer(), range = { 0, 0.5 }, map = "magma",
      caption = ("SSIM %.2f, FLIP %.2f"):format(judged.ssim, judged.flip) }
  end
  return ylm.figure { rows = { pictures, maps }, font = 15,
    bar = { range = { 0, 0.5 }, map = "magma", label = "FLIP of a pixel" } }
end)

--- Meshes: normals of triangles and of vertices, and a knot on its torus.
idea("normals", function()
  local clay = ylm.matte { albedo = { 0.8, 0.5, 0.3 } }
  local ball = ylm.sphere { radius = 1, divide = { 14, 7 } }.mesh
  local vertices, triangles = ball:vertices():totable(), ball:triangles():totable()
  local corners, apart, flat, first, of = {}, {}, {}, {}, {}
  for i, p in ipairs(vertices) do -- one vertex a place: the sphere's own are split along its seam
    local key = ("%.4f %.4f %.4f"):format(p[1] + 0, p[2] + 0, p[3] + 0):gsub("%-0%.0000", "0.0000")
    first[key] = first[key] or i
    of[i] = first[key]
  end
  for _, t in ipairs(triangles) do
    for k = 1, 3 do t[k] = of[t[k]] end
    local a, b, c = vertices[t[1]], vertices[t[2]], vertices[t[3]]
    local u, v = { b[1] - a[1], b[2] - a[2], b[3] - a[3] }, { c[1] - a[1], c[2] - a[2], c[3] - a[3] }
    local n = { u[2] * v[3] - u[3] * v[2], u[3] * v[1] - u[1] * v[3], u[1] * v[2] - u[2] * v[1] }
    local length = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2)
    if length > 1e-9 then
      for _, p in ipairs { a, b, c } do
        corners[#corners + 1], flat[#flat + 1] = p, { n[1] / length, n[2] / length, n[3] / length }
      end
      apart[#apart + 1] = { #corners - 2, #corners - 1, #corners }
    end
  end
  local function lit(mesh)
    return assert(ylm.scene "a ball" {
      camera = ylm.camera { from = { 0, 0.9, 4.2 }, at = { 0, 0, 0 }, fov = 32 },
      geometry = { mesh }, lights = { ylm.sphere_light { at = { -2, 3, 3 }, radius = 0.3, radiance = { 190, 180, 160 } },
        ylm.sphere_light { at = { 4, -1, 2 }, radius = 0.3, radiance = { 16, 22, 34 } } },
    }:render { by = "rays", bounces = 0, size = number({ 60, 60 }, { 300, 300 }), samples = 16, light_samples = 16,
      visibility = "none" })
  end
  local size = number({ 80, 60 }, { 340, 300 })
  return ylm.figure { rows = { {
    { image = lit(ylm.mesh { vertices = corners, triangles = apart, normals = flat, material = clay }),
      tone = "hable", exposure = 0.5, caption = "normals of 168 triangles" },
    { image = lit(ylm.mesh { vertices = vertices, triangles = triangles, material = clay }), tone = "hable", exposure = 0.5,
      caption = "their sums at vertices, weighted by area" },
    { image = ylm.view { meshes = {
        { ylm.knot { radius = 1, minor = 0.4, tube = 0.13 }, colour = { 0.9, 0.55, 0.15 } },
        { ylm.torus { radius = 1, tube = 0.4 }, colour = { 0.35, 0.5, 0.75 }, opacity = 0.3 } },
      direction = { 0.25, 0.55, 0.8 }, size = size, background = "white", frame = false },
      caption = "a knot, on the torus of its normals" },
  } } }
end)

--- Polygons and disks: a rim and its image on the sphere of directions; errors of the sphere of equal area.
idea("rims", function()
  local rim, image = {}, {}
  local corners = { { 2, -0.6, 1.1 }, { 2, -0.6, -0.9 }, { 2, 1.4, -0.9 }, { 2, 1.4, 1.1 } }
  for i = 1, 4 do
    local a, b = corners[i], corners[i % 4 + 1]
    for k = 0, 59 do
      local p = {}
      for c = 1, 3 do p[c] = a[c] + (b[c] - a[c]) * k / 60 end
      local d = math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2)
      rim[#rim + 1], image[#image + 1] = p, { 1.005 * p[1] / d, 1.005 * p[2] / d, 1.005 * p[3] / d }
    end
  end
  for i = 1, 4 do -- lines of sight of the corners
    for k = 2, 30 do rim[#rim + 1] = { corners[i][1] * k / 30, corners[i][2] * k / 30, corners[i][3] * k / 30 } end
  end
  for _, p in ipairs(image) do rim[#rim + 1] = p end
  local square = ylm.quad { corner = corners[1], u = { 0, 0, -2 }, v = { 0, 2, 0 } }
  local view = ylm.view { meshes = { { square, colour = { 1, 0.8, 0.3 }, opacity = 0.8 },
      { ylm.sphere { radius = 1 }, colour = { 0.45, 0.6, 0.85 }, opacity = 0.45 } }, points = rim,
    camera = ylm.camera { from = { 3.1, 1.9, 4.6 }, at = { 0.75, 0.15, 0 }, fov = 36 },
    size = half, background = "white", frame = false }

  local series = {}
  for i, case in ipairs { { "square, in front", 0 }, { "square, from 45 degrees", 45 }, { "square, from 75 degrees", 75 } } do
    local x, y, angle = {}, {}, math.rad(case[2])
    for k = 0, 20 do
      local d = 0.7 * 20 ^ (k / 20)
      local points = { { d * math.sin(angle), -d * math.cos(angle), 0 } }
      local function light(method)
        return ylm.polygon_light { vertices = { { -0.5, 0, -0.5 }, { 0.5, 0, -0.5 }, { 0.5, 0, 0.5 }, { -0.5, 0, 0.5 } },
          radiance = 1, method = method }
      end
      local options = { channels = "luminance", dtype = "double" }
      x[#x + 1] = d
      y[#y + 1] = ylm.sh.relative_error(ylm.light_field(4, light "sphere", points, options):reshape { 1, 25 },
        ylm.light_field(4, light "exact", points, options):reshape { 1, 25 }):get(1)
    end
    print(("rims: %s, error of the sphere at %.1f widths %.1f %%, at %.1f %.2f %%"):format(case[1], x[8], 100 * y[8], x[21],
      100 * y[21]))
    series[i] = { x = x, y = y, label = case[1], marker = "none" }
  end
  return ylm.figure { rows = { {
    { image = view, caption = "a square, its rim seen from the middle of the sphere" },
    { image = ylm.plot { size = half, log = true, series = series, legend = "bottom left", y_range = { 1e-4, 1 },
      x_label = "distance / width of the square", y_label = "relative error of coefficients, lmax 4" },
      caption = "the sphere of equal area in place of the rim" },
  } } }
end)

--- The texels of a window: sky above hills, bars across. Texels of one colour become one part.
local function window(side)
  local texels = {}
  for row = 1, side do
    texels[row] = {}
    for column = 1, side do
      local hill = 40 + 8 * math.sin(column / 9) + 4 * math.sin(column / 4 + 1)
      local c = row > hill and { 0.2, 0.5, 0.15 } or row > hill - 6 and { 0.6, 0.75, 0.95 } or { 0.25, 0.5, 1 }
      if (row - 14) ^ 2 + (column - 46) ^ 2 < 40 then c = { 8, 7, 5 } end
      if row % 32 < 2 or column % 32 < 2 then c = { 0, 0, 0 } end
      texels[row][column] = c
    end
  end
  return texels
end

--- Textured lights: the parts of an image, and errors of spheres in their place.
idea("texture", function()
  local side = 64
  local texels = window(side)
  local light = ylm.textured_light { corner = { -1, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, image = texels }

  -- The quadtree again, as csrc/light/image/texture.c has it, to draw it; its number of parts is the light's.
  local zoom = 5
  local picture, count = ylm.image { size = { side * zoom, side * zoom } }, 0
  picture:fill(1, 1, side * zoom, side * zoom, { 1, 1, 1 })
  local function one_colour(x0, y0, x1, y1)
    local first = texels[y0 + 1][x0 + 1]
    for y = y0 + 1, y1 do
      for x = x0 + 1, x1 do
        for c = 1, 3 do
          if texels[y][x][c] ~= first[c] then return nil end
        end
      end
    end
    return first
  end
  local function cut(x0, y0, x1, y1)
    local w, h = x1 - x0, y1 - y0
    local shaped = w <= side / 8 and h <= side / 8 and math.max(w / h, h / w) <= 2
    local colour = (shaped or w * h == 1) and one_colour(x0, y0, x1, y1)
    if colour then
      local line = colour[1] > 0 and 1 or 0 -- black parts are no lights
      count = count + line
      picture:fill(x0 * zoom + 1, y0 * zoom + 1, w * zoom - line, h * zoom - line, { math.min(1, colour[1]),
        math.min(1, colour[2]), math.min(1, colour[3]) })
      return
    end
    local x, y = math.floor((x0 + x1 + 1) / 2), math.floor((y0 + y1 + 1) / 2)
    if not (w > 1 and 2 * w > h) then x = x1 end
    if not (h > 1 and 2 * h > w) then y = y1 end
    cut(x0, y0, x, y)
    if x < x1 then cut(x, y0, x1, y) end
    if y < y1 then cut(x0, y, x, y1) end
    if x < x1 and y < y1 then cut(x, y, x1, y1) end
  end
  cut(0, 0, side, side)
  assert(count == light.count, "the quadtree drawn is not the light's")
  print(("texture: %d texels, %d parts"):format(side * side, count))

  local series = {}
  for i, case in ipairs { { "in front of the middle", 0 }, { "from 60 degrees", 60 } } do
    local x, y, angle = {}, {}, math.rad(case[2])
    for k = 0, 16 do
      local d = 0.15 * 40 ^ (k / 16)
      local points = { { 0.13 + d * math.sin(angle), 1.21, d * math.cos(angle) } }
      local function field(method)
        local options = { channels = "luminance", dtype = "double" }
        local panel = ylm.textured_light { corner = { -1, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 }, image = texels,
          method = method }
        return ylm.light_field(4, panel, points, options):reshape { 1, 25 }
      end
      x[#x + 1], y[#y + 1] = d / 2, ylm.sh.relative_error(field "spheres", field "exact"):get(1)
    end
    series[i] = { x = x, y = y, label = case[1], marker = "none" }
  end
  return ylm.figure { rows = { {
    { image = picture, tone = "srgb", caption = ("%d texels, %d parts of light"):format(side * side, count) },
    { image = ylm.plot { size = { 520, 320 }, log = true, series = series, legend = "bottom left",
      x_label = "distance / width of the image", y_label = "relative error, lmax 4" },
      caption = 'method = "spheres" beside exact parts' },
  } } }
end)

--- Lamps drawn from a tree: noise of four samples a point, by chance and by the tree.
idea("choice", function()
  local lamps = number(300, 2516)
  local at, radiance = common.spiral(lamps, 0.055, 0.12, 0.04, 60, 50)
  local radius = 0.006
  local scene = ylm.scene "a floor of lamps" {
    camera = ylm.camera { from = { 0, 3, 3.2 }, at = { 0, 0, 0.1 }, fov = 36 },
    geometry = { ylm.quad { corner = { -4, 0, 4 }, u = { 8, 0, 0 }, v = { 0, 0, -8 }, divide = 64 } },
    lights = { ylm.sphere_lights { at = at, radius = radius, radiance = radiance } },
  }
  local size = number({ 64, 48 }, { 250, 188 })
  local function cast(n)
    return assert(scene:render { by = "rays", bounces = 0, size = size, samples = 1, light_samples = n, visibility = "none",
      layers = true })
  end
  local drawn, truth = cast(4), cast(number(64, 1024))

  -- By chance: a lamp is one of N, and counts N times.
  state = 1
  local uniform = image_of(truth:layer())
  local place, out, mask = truth:layer "position", uniform:layer(), common.surface_mask(ylm, truth)
  local albedo = 0.75
  for y = 1, size[2] do
    for x = 1, size[1] do
      if mask:get(y, x) > 0 then
        local px, pz, sum = place:get(y, x, 1), place:get(y, x, 3), { 0, 0, 0 }
        for _ = 1, 4 do
          local i = 1 + math.floor(random() * lamps)
          local dx, dy, dz = at[i][1] - px, at[i][2], at[i][3] - pz
          local d2 = dx * dx + dy * dy + dz * dz
          local weight = lamps / 4 * albedo * radius * radius * dy / (d2 * math.sqrt(d2))
          for c = 1, 3 do sum[c] = sum[c] + weight * radiance[i][c] end
        end
        for c = 1, 3 do out:set(y, x, c, sum[c]) end
      end
    end
  end
  --- Root mean square error at surfaces over that of the truth.
  local function shown(image, caption)
    local wide = mask:reshape { size[2], size[1], 1 }
    local off = math.sqrt((((image:layer() - truth:layer()) * wide) ^ 2):sum() / ((truth:layer() * wide) ^ 2):sum())
    print(("choice: %s, rms error %.0f %%"):format(caption, 100 * off))
    return { image = image, tone = "hable", exposure = -1, caption = caption }
  end
  return ylm.figure { rows = { { shown(uniform, "by chance, 4 a point"), shown(drawn, "drawn from the tree, 4 a point"),
    { image = truth, tone = "hable", exposure = -1, caption = "1024 a point" } } } }
end)

-- docs/grids.md --------------------------------------------------------------------------------------

--- The error of irradiance: grids by either measure, and the error of irradiance at other points.
idea("measure", function()
  state = 1
  local lamps = {}
  for i = 1, 12 do
    local r, phi = 0.5 * math.sqrt(i), 2.39996 * i
    lamps[i] = ylm.sphere_light { at = { r * math.cos(phi), 0.3, r * math.sin(phi) }, radius = 0.05, radiance = 30 }
  end
  --- Points of a floor with its normal.
  local function places(n)
    local rows = {}
    for i = 1, n do rows[i] = { 4 * random() - 2, 0, 4 * random() - 2, 0, 1, 0 } end
    return ylm.array(rows)
  end
  local known, other = places(number(1000, 20000)), places(number(500, 3000))
  local n = #other
  local points = other[{ {}, { 1, 3 } }]
  local function irradiance(c) return ylm.sh.irradiance(c:reshape { n, 25 }, { 0, 1, 0 }) end
  local truth = irradiance(ylm.light_field(4, lamps, points, { channels = "luminance" }))
  local scale = (truth:abs() + truth:mean() + (truth:abs() - truth:mean()):abs()) * 0.5 -- the larger of each and the mean
  local asked, found, probes = {}, { {}, {} }, { {}, {} }
  for i, tolerance in ipairs { 0.1, 0.05, 0.02, 0.01 } do
    asked[i] = tolerance
    for k, measure in ipairs { "coefficients", "irradiance" } do
      local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -2, -0.5, -2 }, { 2, 1, 2 } }, lmax = 4, depth = 9,
        tolerance = tolerance, measure = measure, channels = "luminance" }, lamps, { occupied = known }))
      local errors = ((irradiance(grid:sample(points)) - truth):abs() / scale):totable()
      table.sort(errors)
      found[k][i], probes[k][i] = errors[math.ceil(0.99 * n)], grid.stats.points
      print(("measure: %s, tolerance %g: %d probes, irradiance within %.4f"):format(measure, tolerance, probes[k][i],
        found[k][i]))
    end
  end
  return ylm.figure { rows = { {
    { image = ylm.plot { size = half, log = true, diagonal = "as asked", title = "Irradiance",
      x_label = "tolerance", y_label = "error of irradiance at 99 % of points",
      series = { { x = asked, y = found[2], label = "by irradiance" },
        { x = asked, y = found[1], label = "by coefficients" } } } },
    { image = ylm.plot { size = half, log = true, title = "Probes", legend = "top right",
      x_label = "tolerance", y_label = "probes",
      series = { { x = asked, y = probes[2], label = "by irradiance" },
        { x = asked, y = probes[1], label = "by coefficients" } } } },
  } } }
end)

--- Surfaces where light jumps: light along a line through a wall, in a grid without sides and in one with them.
idea("sides", function()
  local wall, dark = 0.03, 0.15
  local lamp = ylm.sphere_light { at = { 0.2, 0.1, 2.2 }, radius = 0.1, radiance = 100 }
  local function field(points, lmax, channels)
    local L, dL, _, report = ylm.light_field(lmax, lamp, points, { derivatives = 1, metric = "luminance",
      channels = channels == 3 and "rgb" or "luminance" })
    local n = #points
    local weight = points[{ {}, { 3, 3 } }]:less(wall) * (dark - 1) + 1
    return L * weight:reshape { n, 1, 1 }, dL * weight:reshape { n, 1, 1, 1 }, report.lambda * weight:reshape { n }
  end
  local scene = ylm.scene "a wall" { lights = lamp,
    geometry = ylm.quad { corner = { -2, -2, wall }, u = { 4, 0, 0 }, v = { 0, 4, 0 } } }
  local form = ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 8, lmax = 0, channels = "luminance" }
  local without = ylm.bake(form, field, { quantity = "direct" })
  local with = ylm.bake(form, field, { quantity = "direct", scene = scene })
  local heights, points = {}, {}
  for i = 0, 400 do
    heights[i + 1] = -0.5 + i / 400
    points[i + 1] = { 0.12, 0.05, heights[i + 1] }
  end
  local truth = field(ylm.array(points), 0, 1):reshape { 401 }
  local ramp, step = without:sample(points):reshape { 401 }, with:sample(points, { scene = scene }):reshape { 401 }
  for i, name in ipairs { "without", "with" } do
    local off = ((i == 1 and ramp or step) / truth - 1):abs():totable()
    local largest = { 0, 0 }
    for k, z in ipairs(heights) do
      local side = z < wall and 1 or 2
      largest[side] = math.max(largest[side], off[k])
    end
    print(("sides: a grid %s sides is off by at most %.1f %% in the dark, %.1f %% in the light"):format(name, 100 * largest[1],
      100 * largest[2]))
  end
  local ghosts = with.stats.ghosts
  print(("sides: %d points, %d of them ghosts; %d without sides"):format(with.stats.points, ghosts, without.stats.points))
  return ylm.plot { size = { 760, 400 }, legend = "top left", x_range = { -0.5, 0.5 }, title = "Light across a wall",
    x_label = "distance along the wall's normal, voxels of 0.25, wall at 0.03", y_label = "coefficient 0,0",
    series = { { x = heights, y = truth:totable(), label = "light", width = 5, marker = "none", colour = { 0.75, 0.75, 0.75 } },
      { x = heights, y = ramp:totable(), label = "a grid without sides", dash = "dashed", width = 2, marker = "none" },
      { x = heights, y = step:totable(), label = "a grid with sides", width = 2, marker = "none" } } }
end)

--- Sides of walls: the parts of the leaves that a wall between two rooms crosses, and the light in them.
idea("parts", function()
  local white, red = ylm.matte { albedo = 0.7 }, ylm.matte { albedo = { 0.65, 0.2, 0.15 } }
  local bodies = { { { -0.06, 0.001, -1.499 }, { 0.06, 2.599, -0.4 } }, { { -0.06, 0.001, 0.5 }, { 0.06, 2.599, 1.499 } },
    { { 0.9, 0.001, -1.2 }, { 1.5, 0.7, -0.6 } } }
  local height, cut = 0.5, {} -- of the slice; bodies below it
  local geometry = { ylm.box { bounds = { { -3, 0, -1.5 }, { 3, 2.6, 1.5 } }, material = white } }
  for i, b in ipairs(bodies) do
    geometry[i + 1] = ylm.box { bounds = b, material = red }
    cut[i] = { ylm.box { bounds = { b[1], { b[2][1], height - 0.01, b[2][3] } } }, colour = 0.45 }
  end
  local grid = assert(ylm.scene "two rooms" { geometry = geometry,
    lights = ylm.sphere_light { at = { -1.4, 1.9, 0.3 }, radius = 0.15, radiance = { 40, 36, 30 } } }:bake {
    quantity = "indirect", bounces = number(1, 3), occupied = "everywhere",
    probes = ylm.uniform_grid { cells = { 13, 6, 7 }, lmax = 1 } })
  print(("parts: %d leaves of %d are crossed, with %d parts; %d points of %d are ghosts"):format(grid.stats.crossed_leaves,
    grid.stats.leaves, grid.stats.parts, grid.stats.ghosts, grid.stats.points))
  local far = 200 -- from above, nearly parallel: edges of voxels that lie below one another are one line
  local camera = ylm.camera { from = { 0.15, far, 0 }, at = { 0.15, 0, 0 }, up = { 0, 0, -1 },
    fov = 2 * math.deg(math.atan(1.56 / far)) }
  local function slice(quantity, range)
    return ylm.view { grid, quantity = quantity, range = range, slices = { { axis = "y", at = height } }, meshes = cut,
      levels = { opacity = 0.5 }, camera = camera, size = number({ 160, 160 }, { 470, 490 }), background = "white",
      frame = false }
  end
  return ylm.figure { rows = { {
    { image = slice "parts", caption = "two rooms from above: parts of the leaves that walls cross" },
    { image = slice("L00", { 0.02, 2 }), caption = "light: either side of the wall has its own" },
  } } }
end, "sides.png")

--- The surfaces that pixels of a picture see: { points, normals, pixel = { { x, y }, .. } }.
local function surfaces_of(seen)
  local position, normal, depth = seen:layer "position", seen:layer "normal", seen:layer "depth"
  local points, normals, pixel = {}, {}, {}
  for y = 1, seen.size[2] do
    for x = 1, seen.size[1] do
      if depth:get(y, x, 1) < math.huge then
        local k = #points + 1
        points[k], normals[k], pixel[k] = {}, {}, { x, y }
        for c = 1, 3 do points[k][c], normals[k][c] = position:get(y, x, c), normal:get(y, x, c) end
      end
    end
  end
  return { points = points, normals = normals, pixel = pixel }
end

--- Light on surfaces: the rectangles of a room, and the picture that they light.
idea("rectangles", function()
  local function matte(r, g, b) return ylm.matte { albedo = { r, g, b } } end
  local geometry = { ylm.box { bounds = { { -2, 0, -1.5 }, { 2, 2.4, 1.5 } }, material = matte(0.72, 0.7, 0.66) },
    ylm.box { bounds = { { -0.05, 0.001, -1.499 }, { 0.05, 1.8, 0.4 } }, material = matte(0.65, 0.2, 0.15) },
    ylm.box { bounds = { { 0.9, 0.001, -1 }, { 1.5, 0.6, -0.4 } }, material = matte(0.3, 0.4, 0.6) },
    ylm.sphere { at = { 0.8, 0.4, 0.7 }, radius = 0.4, material = matte(0.6, 0.6, 0.5) } }
  local scene = ylm.scene "a parted room" { geometry = geometry,
    camera = ylm.camera { from = { 1.9, 2.1, 1.4 }, at = { 0.2, 0.5, -0.3 }, fov = 75 },
    lights = ylm.sphere_light { at = { -1, 1.9, 0.2 }, radius = 0.12, radiance = { 60, 54, 45 } } }
  local light = assert(scene:surface_grid { tolerance = number(0.5, 0.1), judge = "field" })
  print(("rectangles: %d with %d corners keep %.3f; %.1f KB"):format(light.stats.rectangles, light.stats.corners,
    light.stats.error, light.stats.bytes / 1000))
  local size = number({ 96, 72 }, half)
  local picture = assert(scene:render { size = size, samples = number(4, 64), bounced = light })
  local surfaces = surfaces_of(assert(scene:render { size = size, samples = 1, bounces = 0 }))
  local _, of = light:irradiance(surfaces.points, surfaces.normals)
  local image = ylm.image { size = size }
  local layer = image:layer()
  for k, p in ipairs(surfaces.pixel) do
    local hue = of:get(k) * 0.618033988749895 % 1
    for c = 1, 3 do
      local wave = 0.5 + 0.5 * math.cos(2 * math.pi * (hue + c / 3))
      layer:set(p[2], p[1], c, 0.1 + 0.7 * wave)
    end
  end
  return ylm.figure { rows = { {
    { image = image, caption = "rectangles of a surface grid, tolerance 0.1" },
    { image = picture, caption = "light that bounces from it, lamps by rays" },
  } } }
end)

--- Lightmaps: the charts of a room, and the room by the picture that they read alone.
idea("charts", function()
  local function matte(r, g, b) return ylm.matte { albedo = { r, g, b } } end
  local geometry = { ylm.box { bounds = { { -2, 0, -1.5 }, { 2, 2.4, 1.5 } }, material = matte(0.72, 0.7, 0.66) },
    ylm.box { bounds = { { 0.9, 0.001, -1 }, { 1.5, 0.6, -0.4 } }, material = matte(0.3, 0.4, 0.6) },
    ylm.knot { p = 2, q = 3, radius = 0.5, minor = 0.22, tube = 0.11, divide = { 192, 16 }, at = { -0.5, 0.62, -0.1 },
      rotate = { axis = { 1, 0, 0 }, angle = 60 }, material = matte(0.75, 0.55, 0.25) } }
  local scene = ylm.scene "a knot in a room" { geometry = geometry,
    camera = ylm.camera { from = { 1.9, 1.9, 1.4 }, at = { -0.1, 0.6, -0.3 }, fov = 70 },
    lights = ylm.sphere_light { at = { 0.3, 2.1, 0.5 }, radius = 0.15, radiance = { 60, 54, 45 } } }
  local light = assert(scene:lightmap { texels = number(16384, 65536), rays = 16, light_samples = 8 })
  print(("charts: %d, %d x %d texels, share %.2f; 99 %% of the surface keep %.3f"):format(light.stats.charts,
    light.stats.width, light.stats.height, light.stats.share, light.stats.error))
  local size = number({ 96, 72 }, half)
  local seen = assert(scene:render { size = size, samples = 1, bounces = 0 })
  local surfaces = surfaces_of(seen)
  local E, of = light:irradiance(surfaces.points, surfaces.normals)
  local albedo = seen:layer "albedo"
  local coloured, lit = ylm.image { size = seen.size }, ylm.image { size = seen.size }
  for k, p in ipairs(surfaces.pixel) do
    local hue = of:get(k) * 0.618033988749895 % 1
    for c = 1, 3 do
      coloured:layer():set(p[2], p[1], c, 0.1 + 0.7 * (0.5 + 0.5 * math.cos(2 * math.pi * (hue + c / 3))))
      lit:layer():set(p[2], p[1], c, E:get(k, c) * albedo:get(p[2], p[1], c) / math.pi)
    end
  end
  return ylm.figure { rows = { {
    { image = coloured, caption = "charts of a lightmap" },
    { image = lit, caption = "light by look-ups in its picture alone" },
  } } }
end)

--- Corners in lights: what the grid holds at its points, by their distance from a lamp.
idea("inside", function()
  local lamp = ylm.sphere_light { at = { 0.02, 0.03, 0.01 }, radius = 0.3, radiance = 1 }
  local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 14, lmax = 0,
    channels = "luminance" }, lamp)
  local points = grid:points()
  local place, value, invalid = points.position:totable(), points.value:reshape { #points.position }:totable(),
    points.invalid:totable()
  local dots = { { x = {}, y = {} }, { x = {}, y = {} } }
  for i, p in ipairs(place) do
    local d = math.sqrt((p[1] - 0.02) ^ 2 + (p[2] - 0.03) ^ 2 + (p[3] - 0.01) ^ 2)
    if d < 0.9 then
      local set = dots[invalid[i] == 0 and 1 or 2]
      set.x[#set.x + 1], set.y[#set.y + 1] = d, value[i]
    end
  end
  local x, y = {}, {}
  for i = 0, 120 do
    x[i + 1] = 0.3001 + 0.6 * i / 120
    y[i + 1] = ylm.light_field(0, lamp, { { 0.02 + x[i + 1], 0.03, 0.01 } }, { channels = "luminance" }):get(1, 1, 1)
  end
  print(("inside: %d points of %d in the lamp"):format(grid.stats.invalid, grid.stats.points))
  return ylm.plot { size = { 760, 400 }, legend = "top right", x_range = { 0, 0.9 },
    title = "Light around and in a lamp of radius 0.3", x_label = "distance from the lamp's middle",
      y_label = "coefficient 0,0",
    series = { { x = x, y = y, label = "light", marker = "none", width = 3 },
      { x = dots[1].x, y = dots[1].y, label = "points, evaluated", width = 0, marker_size = 5 },
      { x = dots[2].x, y = dots[2].y, label = "points in the lamp, filled", width = 0, marker_size = 6 } } }
end)

--- Continuity across levels: samples along a line through voxels of several levels.
idea("continuity", function()
  local lamps = { ylm.sphere_light { at = { 0.13, 0.1, 0.07 }, radius = 0.1, radiance = 10 },
    ylm.sphere_light { at = { 0.8, 0.55, 0.2 }, radius = 0.05, radiance = 20 } }
  local function bake(continuous)
    return ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 0, depth = 6, threshold = 4,
      continuous = continuous, channels = "luminance" }, lamps)
  end
  local torn, whole = bake(false), bake(true)
  local x, points, n = {}, {}, 2000
  for i = 0, n do
    x[i + 1] = -0.6 + 1.2 * i / n
    points[i + 1] = { x[i + 1], -0.113, 0.363 }
  end
  local truth = ylm.light_field(0, lamps, points, { channels = "luminance" }):reshape { n + 1 }
  local function relative(grid)
    return (100 * (grid:sample(points):reshape { n + 1 } / truth - 1)):totable()
  end
  local a, b = relative(torn), relative(whole)
  local function jump(list)
    local most = 0
    for i = 2, #list do most = math.max(most, math.abs(list[i] - list[i - 1])) end
    return most
  end
  print(("continuity: largest step between samples %.3f %% without, %.3f %% with it; points %d, %d"):format(jump(a), jump(b),
    torn.stats.points, whole.stats.points))
  return ylm.plot { size = { 760, 400 }, legend = "bottom left", title = "A line through voxels of several sizes",
    x_label = "place", y_label = "error of samples [%]",
    series = { { x = x, y = a, label = "continuous = false", marker = "none", width = 2 },
      { x = x, y = b, label = "continuous = true, the default", marker = "none", width = 2 } } }
end)

--- Moving lights: light that changed, points brought up to date, and the error that is left.
idea("moving", function()
  local function lamps(x)
    local list = { ylm.sphere_light { at = { x, 0.35, 0.3 }, radius = 0.05, radiance = 20 } }
    for i = 1, 150 do
      local r, phi = 0.23 * math.sqrt(i), 2.39996 * i
      list[i + 1] = ylm.sphere_light { at = { r * math.cos(phi), 0.3, r * math.sin(phi) }, radius = 0.05, radiance = 20 }
    end
    return list
  end
  local floor = ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } }
  local grid = ylm.bake(ylm.adaptive_grid { lmax = 2, depth = 7, tolerance = 0.02, dynamic = true, channels = "luminance" },
    lamps(0.3), { geometry = floor })
  local side, points = number(80, 310), {}
  for row = 1, side do
    for column = 1, side do
      points[#points + 1] = { 4 * (column - 0.5) / side - 2, 0, 4 * (row - 0.5) / side - 2 }
    end
  end
  points = ylm.array(points)
  local function field(list) return ylm.light_field(2, list, points, { channels = "luminance" }):reshape { side * side, 9 } end
  local function sample() return grid:sample(points):reshape { side * side, 9 } end
  local before, old = field(lamps(0.3)), sample()
  local report = assert(grid:update(lamps(0.33)))
  local after, new = field(lamps(0.33)), sample()
  print(("moving: %d of %d points brought up to date, met %s, error %.4f"):format(report.points, grid.stats.points,
    tostring(report.met), report.error))
  local function map(list, caption) return { values = list:reshape { side, side, 1 }:clamp(1e-5), log = true,
    range = { 1e-4, 1 }, map = "magma", caption = caption } end
  local touched = (new - old):abs():max(2):greater(0)
  print(("moving: samples changed on %.0f %% of the floor"):format(100 * touched:mean()))
  return ylm.figure { font = 15, rows = { {
    map(ylm.sh.relative_error(before, after), "light that changed"),
    map(ylm.sh.relative_error(old, new), "samples that changed"),
    map(ylm.sh.relative_error(new, after), "error that is left"),
  } }, bar = { range = { 1e-4, 1 }, log = true, map = "magma", label = "relative; the tolerance is 0.02" } }
end)

if option.only ~= "" and not ideas[option.only] then error("--only: no picture " .. option.only, 0) end
for _, name in ipairs(order) do
  if option.only == "" or option.only == name then
    local picture = ideas[name]()
    if picture then common.save(picture, option.out .. files[name]) end
  end
end
