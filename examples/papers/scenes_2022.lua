--- Eight scenes in place of those of Mezieres et al. 2022 (gradient), which are not published: the same numbers of lights and
-- the same pictures' shapes, meshes made here. Loaded with dofile by gradient_2022_table3.lua, _table4.lua, _table5.lua,
-- _fig8.lua, _fig10.lua and _fig11.lua. Metres; y is up.

local ylm = require "ylm"

local scenes = {}

local floor_white = ylm.matte { albedo = 0.7 }

--- A coat over paint, of roughness alpha.
local function coat(colour, alpha) return ylm.ggx { alpha = alpha or 0.4, f0 = 0.12, base = colour } end

--- The triangles of a mesh whose vertex at azimuth u, elevation v (radians) is place(u, v), about the y axis.
local function round(place, divide, material, more)
  local around, rings = divide, math.floor(divide * 0.6)
  local vertices, triangles = {}, {}
  for k = 0, rings do
    local v = math.pi * (k / rings - 0.5)
    for i = 0, around - 1 do vertices[#vertices + 1] = place(2 * math.pi * i / around, v) end
  end
  for k = 0, rings - 1 do
    for i = 0, around - 1 do
      local a, b = k * around + i + 1, k * around + (i + 1) % around + 1
      if k > 0 then triangles[#triangles + 1] = { a, b + around, b } end
      if k < rings - 1 then triangles[#triangles + 1] = { a, a + around, b + around } end
    end
  end
  local form = { vertices = vertices, triangles = triangles, material = material }
  for key, value in pairs(more or {}) do form[key] = value end
  return ylm.mesh(form)
end

--- A sitting figure, 1.7 high, for a Buddha: radii by height, with folds.
function scenes.figure(divide, material, more)
  local at = { -- height, radius
    { 0, 0.02 }, { 0.02, 0.62 }, { 0.16, 0.68 }, { 0.3, 0.58 }, { 0.42, 0.42 }, { 0.7, 0.46 }, { 0.95, 0.44 }, { 1.1, 0.34 },
    { 1.18, 0.15 }, { 1.24, 0.15 }, { 1.36, 0.25 }, { 1.52, 0.23 }, { 1.63, 0.12 }, { 1.68, 0.1 }, { 1.72, 0.01 },
  }
  return round(function(u, v)
    local x = (v / math.pi + 0.5) * (#at - 1) + 1
    local i = math.min(math.floor(x), #at - 1)
    local t = x - i
    local p, q, r, s = at[math.max(i - 1, 1)], at[i], at[i + 1], at[math.min(i + 2, #at)]
    local function cubic(k)
      return q[k] + 0.5 * t * (r[k] - p[k] + t * (2 * p[k] - 5 * q[k] + 4 * r[k] - s[k] + t * (3 * (q[k] - r[k]) + s[k] - p[k])))
    end
    local h, radius = cubic(1), math.max(cubic(2), 0.005)
    local folds = h > 0.05 and h < 1.1 and 1 + 0.05 * math.sin(7 * u + 5 * h) * math.sin(math.pi * h / 1.1) or 1
    return { radius * folds * math.sin(u), h, 0.85 * radius * folds * math.cos(u) }
  end, divide, material, more)
end

--- A body with knobs, of radius about 0.7, for an Armadillo.
function scenes.beast(divide, material, more)
  local knobs = {} -- direction, height, width
  for i = 1, 34 do
    local z, phi = 2 * (i - 0.5) / 34 - 1, i * 2.39996322972865
    local r = math.sqrt(1 - z * z)
    knobs[i] = { r * math.cos(phi), z, r * math.sin(phi), i % 5 == 0 and 0.34 or 0.13, i % 5 == 0 and 0.05 or 0.03 }
  end
  return round(function(u, v)
    local d, r = { math.cos(v) * math.sin(u), math.sin(v), math.cos(v) * math.cos(u) }, 0.56
    for _, k in ipairs(knobs) do
      local c = d[1] * k[1] + d[2] * k[2] + d[3] * k[3]
      if c > 0.5 then r = r + k[4] * math.exp((c - 1) / k[5]) end
    end
    return { r * d[1], r * d[2], r * d[3] }
  end, divide, material, more)
end

--- A colour of hue h (turns) that adds up to 3/2.
local function hue(h)
  local c = {}
  for k = 0, 2 do c[k + 1] = 0.5 + 0.42 * math.cos(2 * math.pi * (h - k / 3)) end
  return c
end

--- n lamps at place(s, t, i), all together as bright as `power` lamps of radius and radiance 1; also as tables.
local function lamps(n, power, radius, place, colour)
  local at, radiance = {}, {}
  for i = 1, n do
    local s, t = (i - 0.5) / n, (i * 0.6180339887498949) % 1
    at[i] = place(s, t, i)
    local c = colour(s, t, i)
    for k = 1, 3 do c[k] = c[k] * power / (n * radius * radius) end
    radiance[i] = c
  end
  local list = { at = at, radius = radius, radiance = radiance }
  return ylm.sphere_lights(list), list
end

--- Lamps over a dome of radius r about (0, h, 0), none below the angle `low` over its equator.
local function dome(n, power, radius, r, h, low)
  return lamps(n, power, radius, function(s, t)
    local y = low + (1 - low) * s
    local q = math.sqrt(1 - y * y)
    return { r * q * math.cos(2 * math.pi * t), h + r * y, r * q * math.sin(2 * math.pi * t) }
  end, function(_, t) return hue(t) end)
end

--- A picture of k x k texels as lamps, one a texel of their area: columns are colours, with dark rings.
local function texels(k, power, corner, u, v)
  local width = math.sqrt(u[1] ^ 2 + u[2] ^ 2 + u[3] ^ 2) / k
  return lamps(k * k, power, width / math.sqrt(math.pi), function(_, _, i)
    local a, b, p = ((i - 1) % k + 0.5) / k, (math.floor((i - 1) / k) + 0.5) / k, {}
    for c = 1, 3 do p[c] = corner[c] + a * u[c] + b * v[c] end
    return p
  end, function(_, _, i)
    local a, b = ((i - 1) % k + 0.5) / k, (math.floor((i - 1) / k) + 0.5) / k
    local ring, c = 0.55 + 0.45 * math.cos(40 * math.sqrt((a - 0.5) ^ 2 + (b - 0.5) ^ 2)), hue(a)
    for channel = 1, 3 do c[channel] = c[channel] * ring end
    return c
  end)
end

--- Spheres times |cos gamma| for 2 k^2 triangles of a parallelogram (Sec. 4.4).
local function triangles(k, radiance, corner, u, v)
  local list = {}
  for i = 0, k - 1 do
    for j = 0, k - 1 do
      local function p(a, b)
        local q = {}
        for c = 1, 3 do q[c] = corner[c] + (i + a) / k * u[c] + (j + b) / k * v[c] end
        return q
      end
      for _, t in ipairs { { p(0, 0), p(1, 0), p(0, 1) }, { p(1, 0), p(1, 1), p(0, 1) } } do
        list[#list + 1] = ylm.polygon_light { vertices = t, method = "sphere", radiance = radiance }
      end
    end
  end
  return list
end

local function floor(half, material)
  return ylm.quad { corner = { -half, 0, half }, u = { 2 * half, 0, 0 }, v = { 0, 0, -2 * half },
    material = material or floor_white }
end

--- Floor, back and side walls, and a ceiling where `top`.
local function room(w, h, d, material, top)
  local m = material or floor_white
  return {
    ylm.quad { corner = { -w, 0, d }, u = { 2 * w, 0, 0 }, v = { 0, 0, -2 * d }, material = m },
    ylm.quad { corner = { -w, 0, -d }, u = { 2 * w, 0, 0 }, v = { 0, h, 0 }, material = m },
    ylm.quad { corner = { -w, 0, d }, u = { 0, 0, -2 * d }, v = { 0, h, 0 }, material = m },
    ylm.quad { corner = { w, 0, -d }, u = { 0, 0, 2 * d }, v = { 0, h, 0 }, material = m },
    top and ylm.quad { corner = { -w, h, -d }, u = { 2 * w, 0, 0 }, v = { 0, 0, 2 * d }, material = m } or nil,
  }
end

--- A box lo .. hi turned about y.
local function block(lo, hi, angle, material)
  local at, half = {}, {}
  for c = 1, 3 do at[c], half[c] = (lo[c] + hi[c]) / 2, (hi[c] - lo[c]) / 2 end
  return ylm.box { bounds = { { -half[1], -half[2], -half[3] }, half }, at = at,
    rotate = { axis = { 0, 1, 0 }, angle = angle or 0 }, material = material }
end

--- A table and four chairs.
local function furniture(x, z, material, seat)
  local list = { block({ x - 0.9, 0.7, z - 0.5 }, { x + 0.9, 0.76, z + 0.5 }, 0, material) }
  for _, a in ipairs { -0.8, 0.8 } do
    for _, b in ipairs { -0.4, 0.4 } do
      list[#list + 1] = block({ x + a - 0.04, 0, z + b - 0.04 }, { x + a + 0.04, 0.7, z + b + 0.04 }, 0, material)
    end
  end
  for _, c in ipairs { { -0.45, -0.85 }, { 0.45, -0.85 }, { -0.45, 0.85 }, { 0.45, 0.85 } } do
    local cx, cz, back = x + c[1], z + c[2], c[2] > 0 and 0.2 or -0.2
    list[#list + 1] = block({ cx - 0.22, 0.42, cz - 0.22 }, { cx + 0.22, 0.47, cz + 0.22 }, 0, seat)
    list[#list + 1] = block({ cx - 0.22, 0.47, cz + back - 0.025 }, { cx + 0.22, 0.95, cz + back + 0.025 }, 0, seat)
    for _, a in ipairs { -0.18, 0.18 } do
      for _, b in ipairs { -0.18, 0.18 } do
        list[#list + 1] = block({ cx + a - 0.025, 0, cz + b - 0.025 }, { cx + a + 0.025, 0.42, cz + b + 0.025 }, 0, seat)
      end
    end
  end
  return list
end

--- The figure (matte) and the beast (`glossy`) of Fig. 8 under `lights`.
function scenes.pair(detail, glossy, lights, camera)
  return ylm.scene "Armadillo & Buddha" {
    camera = camera or ylm.camera { from = { 0.3, 1.7, 6 }, at = { 0, 0.8, 0 }, fov = 29 },
    geometry = { floor(2.2), scenes.figure(detail, ylm.matte { albedo = { 0.75, 0.7, 0.62 } }, { at = { -0.85, 0, 0 } }),
      scenes.beast(detail, glossy, { at = { 0.8, 0.72, 0.1 } }) },
    lights = lights, probes = ylm.uniform_grid { cells = 7, lmax = 4 },
  }
end

scenes.dome = dome

--- Table 3: name, lights, figure, size in pixels, the printed columns (ms; MAE x 1000), what stands in, and a maker.
scenes.list = {
  { name = "Drone & Horse", figure = "1a", lights = 1793, size = { 1920, 1080 },
    printed = { 3.18, 5.30, 6.73, 0.9, 12.93, 139.11, 0.2022 }, here = "a knot and a ring in a yard",
    geometry = function(detail)
      return { floor(3), ylm.knot { at = { -0.9, 0.95, 0 }, scale = 0.55, rotate = { axis = { 1, 0, 0 }, angle = 70 },
        divide = { 6 * detail, detail }, material = coat({ 0.5, 0.25, 0.1 }) },
        ylm.torus { at = { 1.2, 0.62, 0.3 }, radius = 0.45, tube = 0.17, rotate = { axis = { 0, 1, 0 }, angle = 30 },
          divide = { 2 * detail, detail }, material = coat({ 0.3, 0.32, 0.35 }, 0.3) } }
    end,
    lights_of = function() return dome(1793, 20, 0.05, 4, 0.2, 0.6) end,
    camera = { from = { 0.4, 1.7, 5.4 }, at = { 0.1, 0.65, 0 }, fov = 30 } },
  { name = "Dragon", figure = "6", lights = 578, size = { 1920, 1080 },
    printed = { 0.84, 1.82, 12.41, 0.98, 15.21, 76.54, 0.2372 }, here = "a knot",
    geometry = function(detail)
      return { floor(2.5), ylm.knot { p = 3, q = 5, at = { 0, 0.9, 0 }, scale = 0.62, rotate = { axis = { 1, 0, 0 },
        angle = 65 },
        tube = 0.13, divide = { 8 * detail, detail }, material = coat({ 0.15, 0.45, 0.25 }) } }
    end,
    lights_of = function() return dome(578, 20, 0.08, 4, 0.2, 0.6) end,
    camera = { from = { 0, 1.6, 4.4 }, at = { 0, 0.75, 0 }, fov = 32 } },
  { name = "Perseverance", figure = "7", lights = 512, size = { 1920, 1080 },
    printed = { 0.86, 1.39, 10.17, 1.06, 12.62, 55.40, 0.1310 }, here = "a cart of boxes, rings and a mast",
    geometry = function(detail)
      local body, dark = coat { 0.7, 0.68, 0.62 }, coat({ 0.1, 0.1, 0.11 }, 0.35)
      local list = { floor(2.6, ylm.matte { albedo = { 0.62, 0.36, 0.22 } }), block({ -0.8, 0.5, -0.45 }, { 0.8, 0.85, 0.45 },
        0, body),
        block({ 0.3, 0.85, -0.1 }, { 0.42, 1.5, 0.02 }, 0, body), block({ 0.14, 1.45, -0.16 }, { 0.58, 1.68, 0.1 }, 20, body),
        block({ -0.75, 0.87, -0.4 }, { 0.1, 0.95, 0.4 }, 0, dark) }
      for _, x in ipairs { -0.85, 0, 0.85 } do
        for _, z in ipairs { -0.6, 0.6 } do
          list[#list + 1] = ylm.torus { at = { x, 0.28, z }, radius = 0.19, tube = 0.09, divide = { 2 * detail, detail },
            material = dark }
        end
      end
      return list
    end,
    lights_of = function() return dome(512, 20, 0.08, 4, 0.2, 0.6) end,
    camera = { from = { 2.2, 1.9, 4.2 }, at = { 0, 0.65, 0 }, fov = 30 } },
  { name = "Armadillo & Buddha", figure = "8", lights = 242, size = { 1000, 1000 },
    printed = { 0.34, 0.66, 10.51, 0.39, 11.56, 30.50, 0.1920 }, here = "a body with knobs, a lathed figure",
    lights_of = function() return scenes.dome(242, 20, 0.1, 4, 0.2, 0.65) end },
  { name = "Conference", figure = "9a", lights = 900, size = { 1920, 1080 },
    printed = { 1.49, 2.63, 11.53, 0.77, 15.65, 115.51, 0.9656 }, here = "a room, tables, a screen of 30 x 30 texels",
    geometry = function() return { room(3, 2.6, 2.6), furniture(-1.2, -0.3, coat { 0.3, 0.16, 0.08 }, coat({ 0.1, 0.12, 0.2 })),
      furniture(1.3, -0.3, coat { 0.3, 0.16, 0.08 }, coat { 0.1, 0.12, 0.2 }) } end,
    lights_of = function() return texels(30, 8, { -2.75, 0.7, 1.9 }, { 0, 0, -3 }, { 0, 1.5, 0 }) end,
    camera = { from = { 0.6, 1.75, 5.2 }, at = { 0, 1.0, 0 }, fov = 42 } },
  { name = "Living Room", figure = "9b", lights = 2500, size = { 1920, 1080 },
    printed = { 4.36, 7.84, 11.30, 0.88, 20.02, 325.07, 0.7445 }, here = "a room, a sofa, a screen of 50 x 50 texels",
    geometry = function(detail)
      local sofa = coat({ 0.25, 0.32, 0.4 }, 0.6)
      return { room(2.8, 2.6, 2.4), block({ -0.9, 0.1, -1.1 }, { 1.3, 0.5, -0.2 }, -8, sofa), block({ -0.9, 0.1, -1.35 },
        { 1.3, 0.95, -1.1 }, -8, sofa),
        block({ 0.5, 0.35, 0.3 }, { 1.6, 0.42, 1.0 }, -15, coat { 0.4, 0.25, 0.12 }), block({ 0.9, 0, 0.5 }, { 1.2, 0.35,
          0.8 }, -15, coat { 0.4, 0.25, 0.12 }),
        ylm.sphere { at = { 1.0, 0.6, 0.65 }, radius = 0.18, divide = { 2 * detail, detail }, material = coat({ 0.5, 0.1,
          0.1 }, 0.3) } }
    end,
    lights_of = function() return texels(50, 8, { -2.5, 0.7, 2.1 }, { 0, 0, -2.2 }, { 0, 1.5, 0 }) end,
    camera = { from = { -0.5, 1.6, 4.9 }, at = { 0, 0.9, 0 }, fov = 42 } },
  { name = "Fertility", figure = "11", lights = 800, size = { 1920, 735 },
    printed = { 1.46, 2.26, 28.56, 0.65, 31.47, 133.01, 0.0340 }, here = "five knots of five materials",
    lights_of = function() return dome(800, 34, 0.1, 5.2, 0.2, 0.55) end },
  { name = "White Room", figure = "12", lights = 722, size = { 1920, 1080 },
    printed = { 1.19, 2.07, 14.58, 1.21, 17.86, 119.49, 0.0779 }, here = "a white room, a panel of 19 x 19 x 2 triangles",
    geometry = function() return { room(2.6, 2.5, 2.2), furniture(0, -0.3, coat { 0.7, 0.7, 0.7 }, coat { 0.6, 0.6,
      0.6 }) } end,
    lights_of = function() return triangles(19, 9, { -0.7, 3.1, -0.7 }, { 1.4, 0, 0 }, { 0, 0, 1.4 }) end,
    camera = { from = { 0.7, 1.5, 4.6 }, at = { 0, 0.95, 0 }, fov = 42 } },
}

--- Five knots of five materials in a row, of Fig. 11.
function scenes.row(detail, materials, lights)
  local geometry = { ylm.quad { corner = { -5, 0, 3.4 }, u = { 10, 0, 0 }, v = { 0, 0, -5.6 }, material = floor_white } }
  for i, m in ipairs(materials) do
    geometry[#geometry + 1] = ylm.knot { at = { 1.42 * (i - 3), 0.72, 0 }, scale = 0.45, tube = 0.24,
      rotate = { axis = { 0, 1, 0 }, angle = 25 }, divide = { 6 * detail, detail }, material = m }
  end
  return ylm.scene "Fertility" { camera = ylm.camera { from = { 0, 1.35, 8.2 }, at = { 0, 0.66, 0 }, fov = 19 },
    geometry = geometry,
    lights = lights, probes = ylm.uniform_grid { cells = 7, lmax = 4 } }
end

--- Stand-ins for the five captured materials of Fig. 11: name of the file, name here, and a maker. Nothing of them is measured.
scenes.captured = {
  { "cm_toxic_green", "green coat", function() return ylm.ggx { alpha = 0.25, f0 = { 0.05, 0.35, 0.06 }, base = { 0.05, 0.3,
    0.02 } } end },
  { "paper_blue", "rough blue", function() return ylm.ggx { alpha = 0.7, f0 = 0.04, base = { 0.1, 0.2, 0.5 } } end },
  { "vch_frozen_amethyst", "frosted violet", function()
    return ylm.ggx { alpha = 0.4, f0 = { 0.45, 0.2, 0.5 }, base = { 0.1, 0.03, 0.15 } }
  end },
  { "satin_gold", "satin gold", function() return ylm.ggx { alpha = 0.35, f0 = { 0.9, 0.66, 0.28 } } end },
  { "cc_nothern_aurora", "two-coloured coat", function() -- its colour changes with the angle between the two directions
    return ylm.tabulated { f = function(i, o, dphi)
      local c = math.cos(i) * math.cos(o) + math.sin(i) * math.sin(o) * math.cos(dphi)
      local d = math.sqrt(math.max(0, (1 + c) / 2)) -- cosine to the half vector
      local h = math.min(1, (math.cos(i) + math.cos(o)) / math.max(1e-6, 2 * d)) -- of the half vector
      local q = h * h * (0.1225 - 1) + 1
      local lobe = 0.1225 / (math.pi * q * q) / math.max(1, 4 * (math.cos(i) + math.cos(o)) / 2) * 0.8
      local t = math.min(1, math.max(0, (d - 0.4) / 0.6))
      return lobe * (0.55 - 0.45 * t) + 0.01, lobe * (0.15 + 0.55 * t) + 0.02, lobe * 0.6 + 0.03
    end }
  end },
}

--- The scene of a row of `list`.
function scenes.make(case, detail)
  if case.figure == "8" then return scenes.pair(detail, coat({ 0.1, 0.2, 0.3 }, 0.35), (case.lights_of())) end
  if case.figure == "11" then
    local materials = {}
    for i, m in ipairs(scenes.captured) do
      materials[i] = i < 5 and m[3]() or ylm.ggx { alpha = 0.35, f0 = { 0.2, 0.5, 0.5 }, base = 0.03 }
    end
    return scenes.row(detail, materials, (case.lights_of()))
  end
  return ylm.scene(case.name) { camera = ylm.camera(case.camera), geometry = case.geometry(detail), lights = (case.lights_of()),
    probes = ylm.uniform_grid { cells = 7, lmax = 4 } }
end

return scenes
