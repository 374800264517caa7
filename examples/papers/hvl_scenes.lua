--- Rooms in place of those of Mezieres & Paulin 2022 (harmonics virtual lights), whose files are not part of ylm: a Cornell box,
-- an atrium of two storeys for Sponza, a room with a table for the breakfast room. Loaded with dofile by the scripts hvl_*.lua
-- and by examples/13_virtual_lights.lua. Metres; y is up.

local form = require "ylm.form"
local ylm = require "ylm"

local rooms = {}

-- Meshes -------------------------------------------------------------------------------------

local function add(a, b) return { a[1] + b[1], a[2] + b[2], a[3] + b[3] } end

--- An empty mesh, filled by the functions below and made by rooms.mesh.
local function empty() return { vertices = {}, triangles = {} } end

--- Adds nu x nv cells whose corners are place(u, v), u and v 0 to 1.
local function sheet(m, nu, nv, place)
  local first = #m.vertices
  for j = 0, nv do
    for i = 0, nu do m.vertices[#m.vertices + 1] = place(i / nu, j / nv) end
  end
  for j = 0, nv - 1 do
    for i = 0, nu - 1 do
      local a = first + j * (nu + 1) + i + 1
      local b = a + nu + 1
      m.triangles[#m.triangles + 1] = { a, a + 1, b + 1 }
      m.triangles[#m.triangles + 1] = { a, b + 1, b }
    end
  end
end

--- Adds the parallelogram at `corner` along u and v.
local function slab(m, corner, u, v)
  sheet(m, 1, 1, function(s, t)
    return { corner[1] + s * u[1] + t * v[1], corner[2] + s * u[2] + t * v[2], corner[3] + s * u[3] + t * v[3] }
  end)
end

--- Adds the box lo .. hi.
local function box(m, lo, hi)
  local x, y, z = { hi[1] - lo[1], 0, 0 }, { 0, hi[2] - lo[2], 0 }, { 0, 0, hi[3] - lo[3] }
  slab(m, lo, y, x)
  slab(m, lo, x, z)
  slab(m, lo, z, y)
  slab(m, add(lo, z), x, y)
  slab(m, add(lo, y), z, x)
  slab(m, add(lo, x), y, z)
end

--- Adds what a profile of { height, radius } describes about a vertical axis at `at`.
local function lathe(m, at, profile, around)
  local n = #profile - 1
  sheet(m, around, n, function(u, v)
    local p, a = profile[math.floor(v * n + 0.5) + 1], 2 * math.pi * u
    return { at[1] + p[2] * math.cos(a), at[2] + p[1], at[3] + p[2] * math.sin(a) }
  end)
end

local function made(m, material) return ylm.mesh { vertices = m.vertices, triangles = m.triangles, material = material } end

--- Triangles of a scene.
function rooms.triangles(scene)
  local n = 0
  for _, g in ipairs(scene.geometry) do n = n + #g.mesh end
  return n
end

-- The Cornell box ------------------------------------------------------------------------------

--- A box of 2 m: `blocks` (a material, or false for none), `walls` (left, right, others), `lamp`: "panel", or "spot" for a lamp
-- of one place.
function rooms.cornell(o)
  o = o or {}
  local w = o.walls or {}
  local white = w[3] or ylm.matte { albedo = 0.74 }
  local red = w[1] or ylm.matte { albedo = { 0.63, 0.06, 0.05 } }
  local green = w[2] or ylm.matte { albedo = { 0.14, 0.45, 0.09 } }
  local function wall(corner, u, v, material)
    return ylm.quad { corner = corner, u = u, v = v, divide = 4, material = material }
  end
  local geometry = {
    wall({ -1, 0, 1 }, { 2, 0, 0 }, { 0, 0, -2 }, o.floor or white),
    wall({ -1, 2, -1 }, { 2, 0, 0 }, { 0, 0, 2 }, white),
    wall({ -1, 0, -1 }, { 2, 0, 0 }, { 0, 2, 0 }, white),
    wall({ -1, 0, 1 }, { 0, 0, -2 }, { 0, 2, 0 }, red),
    wall({ 1, 0, -1 }, { 0, 0, 2 }, { 0, 2, 0 }, green),
  }
  if o.blocks ~= false then
    local material = o.blocks or white
    geometry[6] = ylm.box { at = { -0.34, 0.6, -0.3 }, scale = { 0.58, 1.2, 0.58 }, rotate = { axis = { 0, 1, 0 }, angle = 18 },
      material = material }
    geometry[7] = ylm.box { at = { 0.36, 0.3, 0.32 }, scale = { 0.58, 0.6, 0.58 }, rotate = { axis = { 0, 1, 0 }, angle = -17 },
      material = material }
  end
  local lamp = ylm.polygon_light { vertices = { { -0.25, 1.98, -0.25 }, { 0.25, 1.98, -0.25 }, { 0.25, 1.98, 0.25 },
    { -0.25, 1.98, 0.25 } }, radiance = { 17, 14, 9 }, horizon = { 0, 1, 0 } } -- it shines downwards
  if o.lamp == "spot" then
    lamp = ylm.spot_light { at = { 0, 1.95, 0.6 }, to = o.to or { -0.5, 0, -0.6 }, angle = 80, intensity = { 9, 7.5, 5 } }
  end
  return ylm.scene "Cornell box" {
    camera = ylm.camera { from = { 0, 1, 3.6 }, at = { 0, 0.97, 0 }, fov = 37.5 }, geometry = geometry, lights = lamp,
  }
end

-- The atrium -----------------------------------------------------------------------------------

local COLUMN = { { 0, 0.26 }, { 0.12, 0.26 }, { 0.16, 0.22 }, { 0.24, 0.17 }, { 0.6, 0.17 }, { 0.8, 0.15 }, { 0.88, 0.17 },
  { 0.94, 0.24 }, { 1, 0.28 } } -- the first three and the last three: in metres of height; between: in parts of it

--- A column from height y on, h high.
local function column(m, x, z, y, h, around)
  local profile = {}
  for i, p in ipairs(COLUMN) do
    local at
    if i <= 4 then at = p[1] elseif i >= 7 then at = h - (1 - p[1]) * 2 else at = 0.24 + (h - 0.5) * p[1] end
    profile[i] = { at, p[2] }
  end
  lathe(m, { x, y, z }, profile, around)
end

--- A wall with a round opening between columns at a and b (x, z), from height `spring` to `top`.
local function arch(m, a, b, spring, top, cells)
  local dx, dz = b[1] - a[1], b[2] - a[2]
  local s = math.sqrt(dx * dx + dz * dz)
  dx, dz = dx / s, dz / s
  local w = s / 2 - 0.24
  local function curve(u) -- along, up
    local t = (u * cells - 1) / (cells - 2)
    if t < 0 then return -s / 2, 0 elseif t > 1 then return s / 2, 0 end
    return -w * math.cos(math.pi * t), w * math.sin(math.pi * t)
  end
  local function at(along, up, across)
    return { (a[1] + b[1]) / 2 + along * dx - across * dz, up, (a[2] + b[2]) / 2 + along * dz + across * dx }
  end
  for _, side in ipairs { -0.15, 0.15 } do
    sheet(m, cells, 1, function(u, v)
      local along, up = curve(side < 0 and u or 1 - u)
      return at(along, spring + up + v * (top - spring - up), side)
    end)
  end
  sheet(m, cells, 1, function(u, v)
    local along, up = curve(u)
    return at(along, spring + up, 0.15 - 0.3 * v)
  end)
end

local X, Z, DEEP, UP, ROOF = 5, 2.5, 2, 3.7, 6.9 -- of the court and its galleries

--- A court with galleries of two storeys behind columns and arches, open above; cloths hang from the upper one.
-- o: stone, floor, wall (materials), cloths (a list of them), object (geometry, at the middle of the floor), lamps, camera,
-- detail (1: about 20,000 triangles).
function rooms.atrium(o)
  o = o or {}
  local detail = o.detail or 1
  local around, cells = math.max(5, math.floor(18 * detail)), math.max(6, math.floor(20 * detail))
  local stone, floor, wall = empty(), empty(), empty()
  slab(floor, { -X - DEEP, 0, Z + DEEP }, { 2 * (X + DEEP), 0, 0 }, { 0, 0, -2 * (Z + DEEP) })
  for _, side in ipairs { -1, 1 } do
    slab(wall, { -X - DEEP, 0, side * (Z + DEEP) }, { 2 * (X + DEEP), 0, 0 }, { 0, ROOF, 0 })
    slab(wall, { side * (X + DEEP), 0, -Z - DEEP }, { 0, 0, 2 * (Z + DEEP) }, { 0, ROOF, 0 })
  end
  for _, y in ipairs { UP, ROOF } do
    for _, side in ipairs { -1, 1 } do
      local z, x = side * (Z + DEEP / 2), side * (X + DEEP / 2)
      box(wall, { -X - DEEP, y - 0.3, z - DEEP / 2 - 0.1 }, { X + DEEP, y, z + DEEP / 2 + 0.1 })
      box(wall, { x - DEEP / 2 - 0.1, y - 0.3, -Z + 0.1 }, { x + DEEP / 2 + 0.1, y, Z - 0.1 })
    end
  end
  local rim = {} -- of the court: places of columns, in order
  for i = 0, 5 do rim[#rim + 1] = { -X + 2 * i, -Z } end
  rim[#rim + 1] = { X, 0 }
  for i = 5, 0, -1 do rim[#rim + 1] = { -X + 2 * i, Z } end
  rim[#rim + 1] = { -X, 0 }
  for i, p in ipairs(rim) do
    local q = rim[i % #rim + 1]
    for _, s in ipairs { { 0, 2.1 }, { UP, 1.55 } } do
      column(stone, p[1], p[2], s[1], s[2], around)
      arch(stone, p, q, s[1] + s[2], s[1] == 0 and UP - 0.3 or ROOF - 0.3, cells)
    end
    local dx, dz, n = q[1] - p[1], q[2] - p[2], 6 -- a rail with n posts before the upper gallery
    local rx, rz = dx == 0 and 0.05 or 0, dz == 0 and 0.05 or 0
    box(stone, { math.min(p[1], q[1]) - rx, UP + 0.72, math.min(p[2], q[2]) - rz },
      { math.max(p[1], q[1]) + rx, UP + 0.8, math.max(p[2], q[2]) + rz })
    for k = 1, n do
      local x, z = p[1] + dx * k / (n + 1), p[2] + dz * k / (n + 1)
      box(stone, { x - 0.035, UP, z - 0.035 }, { x + 0.035, UP + 0.72, z + 0.035 })
    end
  end
  local sand = ylm.matte { albedo = { 0.72, 0.64, 0.52 } }
  local geometry = { made(floor, o.floor or ylm.matte { albedo = { 0.5, 0.46, 0.4 } }), made(stone, o.stone or sand),
    made(wall, o.wall or ylm.matte { albedo = { 0.7, 0.66, 0.6 } }) }
  local cloths = o.cloths or { ylm.matte { albedo = { 0.6, 0.07, 0.05 } }, ylm.matte { albedo = { 0.1, 0.32, 0.1 } },
    ylm.matte { albedo = { 0.07, 0.14, 0.45 } } }
  local at = { { -4, -1 }, { 0, -1 }, { 4, -1 }, { -2, 1 }, { 2, 1 } } -- middle, side
  for i, c in ipairs(at) do
    local m, n = empty(), math.max(4, math.floor(28 * detail))
    sheet(m, n, n, function(u, v)
      local wave = 0.1 * math.sin(5.5 * math.pi * u + i) * (0.35 + 0.65 * v) + 0.03 * math.sin(13 * u + 9 * v)
      return { c[1] + (u - 0.5) * (1.5 - 0.12 * math.sin(math.pi * v)), UP + 0.68 - 2.2 * v,
        c[2] * (Z - 0.32) + wave }
    end)
    geometry[#geometry + 1] = made(m, cloths[(i - 1) % #cloths + 1])
  end
  if o.object then geometry[#geometry + 1] = o.object end
  return ylm.scene "atrium" {
    camera = o.camera or ylm.camera { from = { -4.6, 1.75, 0.5 }, at = { 3.2, 2.55, -0.5 }, fov = 62 }, geometry = geometry,
    lights = o.lamps or ylm.spot_light { at = { -1.5, 9.5, 2.4 }, to = { 0.6, 0, -1.6 }, angle = 40,
      intensity = { 420, 370, 290 } },
  }
end

-- The room with a table --------------------------------------------------------------------------

--- A closed room with a round table, four chairs, a vase and bowls, pictures on the wall.
-- o: table, chairs, floor, wall, things, frame (materials), lamps, detail.
function rooms.table_room(o)
  o = o or {}
  local around = math.max(8, math.floor(48 * (o.detail or 1)))
  local shell, ground, desk, seats, vase, bowl, frame = empty(), empty(), empty(), empty(), empty(), empty(), empty()
  slab(ground, { -2.2, 0, 2.2 }, { 4.4, 0, 0 }, { 0, 0, -4 })
  slab(shell, { -2.2, 2.6, -1.8 }, { 4.4, 0, 0 }, { 0, 0, 4 })
  slab(shell, { -2.2, 0, -1.8 }, { 4.4, 0, 0 }, { 0, 2.6, 0 })
  slab(shell, { 2.2, 0, 2.2 }, { -4.4, 0, 0 }, { 0, 2.6, 0 })
  slab(shell, { -2.2, 0, 2.2 }, { 0, 0, -4 }, { 0, 2.6, 0 })
  slab(shell, { 2.2, 0, -1.8 }, { 0, 0, 4 }, { 0, 2.6, 0 })
  lathe(desk, { 0, 0, 0 }, { { 0, 0.02 }, { 0.01, 0.36 }, { 0.05, 0.3 }, { 0.12, 0.07 }, { 0.6, 0.06 }, { 0.69, 0.2 }, { 0.7,
    0.6 },
    { 0.71, 0.78 }, { 0.735, 0.8 }, { 0.76, 0.78 }, { 0.762, 0.4 }, { 0.762, 0.02 } }, around)
  for k = 0, 3 do
    local a = math.pi * (k / 2 + 0.25)
    local c, s = math.cos(a), math.sin(a)
    local function turned(m, before)
      for i = before + 1, #m.vertices do
        local v = m.vertices[i]
        m.vertices[i] = { v[1] * c - v[3] * s + 0.95 * c, v[2], v[1] * s + v[3] * c + 0.95 * s }
      end
    end
    local before = #seats.vertices
    box(seats, { -0.21, 0.42, -0.21 }, { 0.21, 0.46, 0.21 })
    for _, x in ipairs { -0.18, 0.18 } do
      for _, z in ipairs { -0.18, 0.18 } do box(seats, { x - 0.02, 0, z - 0.02 }, { x + 0.02, 0.42, z + 0.02 }) end
    end
    for _, thick in ipairs { 0, 0.03 } do
      sheet(seats, math.max(4, around / 4), 2, function(u, v)
        local t = (thick > 0 and 1 - u or u) * 2 - 1
        return { 0.22 - 0.08 * t * t + 0.05 * v + thick, 0.5 + 0.45 * v, 0.21 * t }
      end)
    end
    turned(seats, before)
  end
  lathe(vase, { -0.16, 0.762, -0.1 }, { { 0, 0.05 }, { 0.03, 0.09 }, { 0.1, 0.13 }, { 0.17, 0.12 }, { 0.24, 0.06 }, { 0.29,
    0.05 },
    { 0.33, 0.08 }, { 0.31, 0.05 }, { 0.25, 0.04 } }, around)
  for _, p in ipairs { { 0.25, 0.15 }, { -0.3, 0.36 }, { 0.35, -0.3 } } do
    lathe(bowl, { p[1], 0.762, p[2] }, { { 0, 0.06 }, { 0.01, 0.07 }, { 0.05, 0.13 }, { 0.08, 0.155 }, { 0.08, 0.145 }, { 0.04,
      0.1 },
      { 0.015, 0.02 } }, around)
  end
  for _, x in ipairs { -1.2, 0.1, 1.4 } do box(frame, { x - 0.3, 1.25, -1.79 }, { x + 0.3, 2.0, -1.75 }) end
  local wood = ylm.ggx { alpha = 0.35, f0 = 0.05, base = { 0.38, 0.2, 0.1 } }
  return ylm.scene "table room" {
    camera = o.camera or ylm.camera { from = { 0.7, 1.65, 2.15 }, at = { -0.05, 0.75, -0.3 }, fov = 58 },
    geometry = { made(ground, o.floor or ylm.matte { albedo = { 0.42, 0.3, 0.2 } }),
      made(shell, o.wall or ylm.matte { albedo = { 0.75, 0.72, 0.66 } }), made(desk, o.table or wood),
      made(seats, o.chairs or wood), made(vase, o.things or ylm.ggx { alpha = 0.3, f0 = 0.05, base = { 0.1, 0.2, 0.45 } }),
      made(bowl, o.things or ylm.matte { albedo = { 0.75, 0.7, 0.6 } }), made(frame, o.frame or ylm.matte { albedo = { 0.5, 0.14,
        0.1 } }) },
    lights = o.lamps or ylm.spot_light { at = { 1.7, 2.4, 1.8 }, to = { -0.5, 0.9, -0.8 }, angle = 70, intensity = { 26, 23,
      19 } },
  }
end

-- Two bodies before a wall ----------------------------------------------------------------------

--- GGX stand-ins for the paper's materials 5, 9, 13 and 14: blue acrylic, gold paint, red specular plastic, silver paint.
function rooms.paints()
  return ylm.ggx { alpha = 0.25, f0 = 0.04, base = { 0.05, 0.14, 0.4 } },
    ylm.ggx { alpha = 0.4, f0 = { 0.6, 0.42, 0.16 }, base = { 0.12, 0.08, 0.02 } },
    ylm.ggx { alpha = 0.2, f0 = 0.05, base = { 0.45, 0.05, 0.04 } },
    ylm.ggx { alpha = 0.35, f0 = { 0.5, 0.5, 0.52 }, base = { 0.12, 0.12, 0.13 } }
end

--- Meshes for the bunny and Suzanne (o.bunny, o.suzanne: files) on a floor before a wall, under a spot.
function rooms.pair(o)
  local blue, gold, red, silver = rooms.paints()
  local bodies = dofile((arg[0]:match "^(.*/)" or "./") .. "scenes_2022.lua")
  local detail = o.detail or 48
  return ylm.scene "two bodies" {
    camera = ylm.camera { from = { 0.2, 1.5, 4.2 }, at = { 0, 0.62, 0 }, fov = 36 },
    geometry = {
      ylm.quad { corner = { -2.4, 0, 2 }, u = { 4.8, 0, 0 }, v = { 0, 0, -3.2 }, material = o.floor or silver },
      ylm.quad { corner = { -2.4, 0, -1.2 }, u = { 4.8, 0, 0 }, v = { 0, 2.4, 0 }, material = o.wall or red },
      rooms.statue(o.bunny or "", { -0.6, 0, 0.1 }, 1.15, blue, function(m)
        return bodies.beast(detail, m, { at = { -0.6, 0.62, 0.1 }, scale = 0.85 })
      end),
      rooms.statue(o.suzanne or "", { 0.65, 0, 0 }, 1, gold, function(m)
        return bodies.figure(detail, m, { at = { 0.65, 0, 0 }, scale = 0.65 })
      end),
    },
    lights = ylm.spot_light { at = { 1.6, 2.6, 2.2 }, to = { -0.15, 0.25, -0.4 }, angle = 62, intensity = 22 },
  }
end

-- Pictures and their time ---------------------------------------------------------------------

--- The image of virtual lights alone, o.bounced, each at each point, by options of view:render; and the nanoseconds of the
-- processor, all threads together, of a pair of a light and a point.
function rooms.gather(view, o)
  o.by, o.virtual = "none", o.virtual or {}
  if not o.rival then o.virtual.sums = "all" end
  local start = os.clock()
  local image, report = view:render(o)
  local ns = 1e9 * (os.clock() - start)
  if not image then error(report, 0) end
  return image, report.virtual.pairs > 0 and ns / report.virtual.pairs or 0
end

--- Direct light (an image) and a bounce (another) as a new image, times `factor`, and no more than `most`; and its mean.
function rooms.sum(direct, bounce, factor, most)
  local value = (factor or 1) * (ylm.array(bounce:layer(), "double") + direct:layer())
  if most then value = value:clamp(0, most) end
  local out = ylm.image { size = direct.size }
  out:layer()[{}] = value
  return out, value:mean()
end

-- Errors beside paths --------------------------------------------------------------------------

--- A function of an image, or of radiances [h][w][3]: its root mean square error beside `truth`, paths with their variance,
-- relative to the truth's mean and less its noise. Pixels at edges of things are left out: those where a neighbour of `image`
-- (a picture with layers normal and position) has another normal or is far. Also the noise, and how many pixels count.
function rooms.judge(image, truth)
  local normal, position = ylm.array(image:layer "normal", "double"), ylm.array(image:layer "position", "double")
  local w, h = image.size[1], image.size[2]
  local seen = 1 - image:layer "coverage":less(0.999):reshape { h, w }
  seen = seen * (1 - image:layer "emitter":greater(0):reshape { h, w })
  local function span(d, n) return { math.max(1, 1 - d), math.min(n, n - d) }, { math.max(1, 1 + d), math.min(n, n + d) } end
  for dy = -1, 1 do
    for dx = -1, 1 do
      local y, y1 = span(dy, h)
      local x, x1 = span(dx, w)
      local here, there = { y, x }, { y1, x1 }                        -- pixels, and their neighbours
      local n, to = normal[here], position[there] - position[here]
      local dot, off, far = (n * normal[there]):sum(3), (n * to):sum(3), (to ^ 2):sum(3)
      seen[here] = seen[here] * (1 - dot:less(0.94)) * (1 - (off ^ 2):greater(0.06 * far + 1e-12))
    end
  end
  local function of(pixels) return ylm.array(pixels:select(seen), "double") end
  local wanted, noise = of(truth:layer()), of(truth:layer "variance"):mean()
  local mean = wanted:mean()
  return function(pixels)
    local square = ((of(pixels.layers and pixels:layer() or pixels) - wanted) ^ 2):mean()
    return math.sqrt(math.max(0, square - noise)) / mean
  end, math.sqrt(noise) / mean, #wanted
end

-- Irradiance at points -------------------------------------------------------------------------

--- At most n of a view's points, evenly chosen: { position, normal } as arrays.
function rooms.some(points, n)
  local rows = { 1, -1, math.max(1, math.floor(#points.position / n)) }
  local last = #points.position - (#points.position - 1) % rows[3]
  rows[2] = last
  return { position = points.position[rows], normal = points.normal[rows] }
end

--- Irradiance [n][3] of coefficients [n][3][..], each by its normal.
function rooms.irradiance(L, normal)
  local lmax = math.floor(math.sqrt(L.shape[3]) + 0.5) - 1
  local factor = {} -- of the clamped cosine, by coefficient: from the irradiance of a zonal lobe of its degree at its axis
  for l = 0, lmax do
    local one = ylm.zeros { (lmax + 1) ^ 2 }
    one:set(l * l + l + 1, 1)
    local f = ylm.sh.irradiance(one, { 0, 0, 1 }) / math.sqrt((2 * l + 1) / (4 * math.pi))
    for k = l * l + 1, (l + 1) ^ 2 do factor[k] = f end
  end
  local basis = ylm.array(ylm.sh.eval(lmax, normal), "double") * factor
  return (basis:reshape { #normal, 1, #factor } * L):sum(3)
end

--- Root mean square difference of two arrays of irradiance, relative to the mean of the second.
function rooms.rms(E, truth) return math.sqrt(((E - truth) ^ 2):mean()) / truth:mean() end

-- A user's own -----------------------------------------------------------------------------------

--- The scene of a file, or of `otherwise` where the name is empty.
function rooms.given(path, otherwise, ...)
  if path == "" then return rooms[otherwise](...) end
  local scene, message = ylm.load(path)
  if not scene then error(message, 0) end
  return scene
end

--- Stops where the script was given a scene and has no use for one; why: a sentence.
function rooms.no_scene(path, why)
  if path ~= "" then error("--scene: " .. why, 0) end
end

--- Lights of a scene at `count` places: by a grid, the paper's map, where all lamps are spots, else by particles. o: what else
-- scene:virtual_lights takes.
function rooms.placed(scene, count, o)
  local spots = #scene.lights > 0
  for _, l in ipairs(scene.lights) do spots = spots and form.kind(l) == "spot_light" end
  o.count, o.distribution = count, spots and "grid" or "particles"
  local lights, report = scene:virtual_lights(o)
  if not lights then error(report, 0) end
  if lights.count == 0 then error(report.note or "the scene leaves no virtual light", 0) end
  return lights
end

--- The scene of a file again, with other materials: those of the list in turn.
function rooms.painted(path, materials)
  local scene = rooms.given(path)
  for i, g in ipairs(scene.geometry) do g.material = materials[(i - 1) % #materials + 1] end
  return scene
end

--- A mesh of a file, made to stand on `at` with `height`; where the name is empty, otherwise().
function rooms.statue(path, at, height, material, otherwise)
  if path == "" then return otherwise(material) end
  local mesh = ylm.mesh { file = path, material = material }
  local lo, hi = mesh.mesh.bounds[1], mesh.mesh.bounds[2]
  local s = height / (hi[2] - lo[2])
  return ylm.mesh { file = path, material = material, scale = s,
    at = { at[1] - s * (lo[1] + hi[1]) / 2, at[2] - s * lo[2], at[3] - s * (lo[3] + hi[3]) / 2 } }
end

return rooms
