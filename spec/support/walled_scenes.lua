--- Five scenes with walls, by which grids of light that jumps at surfaces are judged: { name, make(ylm) -> scene, .. }.
--
-- `quantity` is the light that is judged ("all": sky and bounces), `sealed` the box of a room that no light reaches. Surfaces
-- say which of their sides reflect, so that places in walls are known as such without a lamp or a camera in every room.

local scenes = {}

local function add(name, make, more)
  local entry = { name = name, make = make, quantity = "indirect" }
  for key, value in pairs(more or {}) do entry[key] = value end
  scenes[#scenes + 1] = entry
end

--- Numbers from 0 to 1, the same everywhere.
local function random(seed)
  local state = seed
  return function()
    state = (state * 16807) % 2147483647
    return state / 2147483647
  end
end

--- The faces between open and solid cells of a lattice of planes, seen from the open ones: a mesh without gaps, whose triangles
-- end at each wall. open(i, j, k) also answers for cells around the lattice; these have no faces of their own.
local function carved(ylm, planes, open, material)
  local vertices, rows, triangles = {}, {}, {}
  local function vertex(c)
    local key = c[1] .. " " .. c[2] .. " " .. c[3]
    if not rows[key] then
      vertices[#vertices + 1] = { planes[1][c[1]], planes[2][c[2]], planes[3][c[3]] }
      rows[key] = #vertices
    end
    return rows[key]
  end
  --- The face of a cell across `axis`, at its lower (0) or upper (1) side.
  local function face(cell, axis, upper)
    local u, v, corners = axis % 3 + 1, (axis + 1) % 3 + 1, {}
    for k, step in ipairs { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } } do
      local c = { cell[1], cell[2], cell[3] }
      c[axis], c[u], c[v] = c[axis] + upper, c[u] + step[1], c[v] + step[2]
      corners[k] = vertex(c)
    end
    if upper == 1 then corners[2], corners[4] = corners[4], corners[2] end
    triangles[#triangles + 1] = { corners[1], corners[2], corners[3] }
    triangles[#triangles + 1] = { corners[1], corners[3], corners[4] }
  end
  for i = 1, #planes[1] - 1 do
    for j = 1, #planes[2] - 1 do
      for k = 1, #planes[3] - 1 do
        for axis = 1, open(i, j, k) and 3 or 0 do
          for upper = 0, 1 do
            local beside = { i, j, k }
            beside[axis] = beside[axis] + 2 * upper - 1
            if not open(beside[1], beside[2], beside[3]) then face({ i, j, k }, axis, upper) end
          end
        end
      end
    end
  end
  return ylm.mesh { vertices = vertices, triangles = triangles, crease = 30, sides = "front", material = material }
end

--- A body between two corners.
local function body(ylm, lo, hi, colour, more)
  local box = { bounds = { lo, hi }, sides = "front", material = ylm.matte { albedo = colour } }
  for key, value in pairs(more or {}) do box[key] = value end
  return ylm.box(box)
end

--- A room between two corners, seen from within.
local function room(ylm, lo, hi, colour)
  return ylm.box { bounds = { lo, hi }, sides = "back", material = ylm.matte { albedo = colour } }
end

-- Two rooms, a door, walls of 0.06, and a third room that is sealed and has no lamp. The camera is in the room without a lamp.
add("rooms", function(ylm)
  local xs, ys, zs = { -3, -0.47, -0.41, 1.55, 1.61, 3 }, { 0, 2, 2.6 }, { -1.5, -0.4, 0.5, 1.5 }
  local function open(i, j, k)
    if i < 1 or i > 5 or j < 1 or j > 2 or k < 1 or k > 3 or i == 4 then return false end
    return i ~= 2 or (j == 1 and k == 2)
  end
  return ylm.scene "rooms" { camera = ylm.camera { from = { 1.3, 1.6, 1.2 }, at = { -0.6, 1.1, -0.2 }, fov = 75 },
    geometry = { carved(ylm, { xs, ys, zs }, open, ylm.matte { albedo = { 0.7, 0.68, 0.62 } }),
      body(ylm, { -2.6, 0.001, -1.2 }, { -2, 0.8, -0.5 }, { 0.65, 0.2, 0.15 }),
      body(ylm, { 0.5, 0.001, -1.2 }, { 1.1, 0.7, -0.6 }, { 0.2, 0.5, 0.3 }),
      body(ylm, { 2, 0.001, 0.2 }, { 2.5, 0.6, 0.8 }, { 0.3, 0.3, 0.6 }) },
    lights = { ylm.sphere_light { at = { -1.7, 1.9, 0.3 }, radius = 0.15, radiance = { 40, 36, 30 } } } }
end, { sealed = { { 1.58, -1, -2 }, { 4, 3, 2 } } })

-- 30 turned boxes, 7 of them thin panels; most stand on the floor, some hang. Bodies may touch.
add("furniture", function(ylm)
  local draw, geometry, put = random(11), {}, {}
  geometry[1] = room(ylm, { -2.2, 0, -2.2 }, { 2.2, 2.6, 2.2 }, { 0.68, 0.66, 0.6 })
  local function colour() return { 0.2 + 0.6 * draw(), 0.2 + 0.6 * draw(), 0.2 + 0.6 * draw() } end
  --- A place on the floor for a body of radius r: the first of 200 that keeps away from all others.
  local function place(r)
    local x, z
    for _ = 1, 200 do
      x, z = (4.2 - 2 * r) * (draw() - 0.5), (4.2 - 2 * r) * (draw() - 0.5)
      local free = true
      for _, p in ipairs(put) do free = free and (p[1] - x) ^ 2 + (p[2] - z) ^ 2 > (0.85 * (p[3] + r)) ^ 2 end
      if free then break end
    end
    put[#put + 1] = { x, z, r }
    return x, z
  end
  for i = 1, 30 do
    local half = { 0.08 + 0.16 * draw(), 0.1 + 0.35 * draw(), 0.08 + 0.16 * draw() }
    if i <= 7 then half = { 0.3 + 0.25 * draw(), 0.4 + 0.4 * draw(), 0.02 } end
    local x, z = place(math.sqrt(half[1] ^ 2 + half[3] ^ 2))
    local y, turn = half[2] + 0.002, { { axis = { 0, 1, 0 }, angle = 180 * draw() } }
    if i > 24 then
      turn[2] = { axis = { draw() - 0.5, 0, draw() - 0.5 }, angle = 50 * draw() }
      y = 1.1 + 0.8 * draw()
    end
    geometry[#geometry + 1] = body(ylm, { -half[1], -half[2], -half[3] }, half, colour(), { at = { x, y, z }, rotate = turn })
  end
  return ylm.scene "furniture" { camera = ylm.camera { from = { 2, 1.9, 2 }, at = { 0, 0.6, 0 }, fov = 70 }, geometry = geometry,
    lights = { ylm.sphere_light { at = { -0.7, 2.2, -0.6 }, radius = 0.12, radiance = { 40, 34, 26 } },
      ylm.sphere_light { at = { 1.5, 1.9, 1.4 }, radius = 0.08, radiance = { 14, 20, 30 } } } }
end)

-- Four walls and an arcade along one of them, under a sky. Outer sides of walls are left out: nothing sees them.
add("court", function(ylm)
  local xs, ys = { -2.7, -2.55, -2.35 }, { 0, 1.75, 1.9, 2.4, 2.6 }
  for i = 1, 4 do xs[#xs + 1], xs[#xs + 2] = -2.35 + 1.15 * i - 0.2, -2.35 + 1.15 * i end
  xs[#xs + 1] = 2.4
  local zs, last = { -2.4, -2.25, -1.2, -1, 2.15, 2.3 }, #xs - 1
  --- Pillars stand between each two arches; the row k == 3 has them, k == 2 is the walk behind, both below a roof at j == 2.
  local function open(i, j, k)
    if j >= 4 then return true end
    if j < 1 or i <= 1 or i >= last or k <= 1 or k >= 5 then return false end
    if k >= 4 or j == 3 then return true end
    if j == 2 then return false end
    return k == 2 or i % 2 == 1
  end
  return ylm.scene "court" { camera = ylm.camera { from = { 1.9, 1.5, 1.9 }, at = { -0.4, 0.9, -1.2 }, fov = 75 },
    geometry = { carved(ylm, { xs, ys, zs }, open, ylm.matte { albedo = { 0.62, 0.55, 0.45 } }),
      body(ylm, { -0.4, 0.001, -0.2 }, { 0.4, 0.6, 0.6 }, { 0.5, 0.5, 0.52 }) },
    lights = { ylm.environment_light { lmax = 8,
      sky = { kind = "partly cloudy", zenith = { 0, 1, 0 }, sun = { 0.5, 0.7, 0.5 } } } } }
end, { quantity = "all" })

-- Eight niches on each side of a corridor, with panels of 0.04 between them. Two lamps, of which few niches see both.
add("corridor", function(ylm)
  local xs, wide = {}, (6 - 7 * 0.04) / 8
  for i = 0, 7 do xs[#xs + 1], xs[#xs + 2] = -3 + i * (wide + 0.04), -3 + i * (wide + 0.04) + wide end
  local ys, zs = { 0, 2.2 }, { -1.25, -0.6, 0.6, 1.25 }
  local function open(i, j, k)
    if i < 1 or i > 15 or j ~= 1 or k < 1 or k > 3 then return false end
    return k == 2 or i % 2 == 1
  end
  return ylm.scene "corridor" { camera = ylm.camera { from = { 2.8, 1.5, 0.2 }, at = { 0, 1, 0 }, fov = 70 },
    geometry = { carved(ylm, { xs, ys, zs }, open, ylm.matte { albedo = { 0.66, 0.64, 0.6 } }),
      body(ylm, { -0.9, 0.001, -0.2 }, { -0.6, 0.9, 0.1 }, { 0.65, 0.2, 0.15 }) },
    lights = { ylm.sphere_light { at = { -2.1, 1.8, 0.1 }, radius = 0.1, radiance = { 40, 34, 26 } },
      ylm.sphere_light { at = { 1.3, 1.7, -0.9 }, radius = 0.08, radiance = { 20, 26, 34 } } } }
end)

-- A smooth body in an empty room.
add("ball", function(ylm)
  return ylm.scene "ball" { camera = ylm.camera { from = { 1.8, 1.6, 1.8 }, at = { 0, 1, 0 }, fov = 65 },
    geometry = { room(ylm, { -2, 0, -2 }, { 2, 2.6, 2 }, { 0.65, 0.62, 0.55 }),
      ylm.sphere { at = { 0.2, 0.95, -0.1 }, radius = 0.8, divide = { 96, 48 }, sides = "front",
        material = ylm.matte { albedo = { 0.7, 0.4, 0.3 } } } },
    lights = { ylm.sphere_light { at = { -1.3, 2.1, 0.9 }, radius = 0.12, radiance = { 40, 36, 30 } } } }
end)

return scenes
