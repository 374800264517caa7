-- A room from an OBJ file with its materials: textures on floor and walls, a lamp in the ceiling, colours of vertices.
--
--     ylm run examples/08_textured_room.lua [--out DIR] [--width N] [--samples N] [--rays N]
--
-- Writes room.obj, room.mtl and two textures into out/, reads them back, and leaves textured_room.png there: the room by rays
-- to the lamp, by spherical harmonics, and its albedo.

local ylm = require "ylm"

local here = arg[0]:match "^(.*/)" or "./"
local common = dofile(here .. "common.lua")
local option = common.options { out = "out", width = 480, samples = 16, rays = 64 }

-- Textures ------------------------------------------------------------------------------------------

--- An image whose texel (x, y), both from 0 to 1 and y upwards, is the colour f(x, y).
local function texture(name, side, f)
  local image = ylm.image { size = { side, side } }
  local texels = image:layer()
  for row = 1, side do
    for column = 1, side do
      local c = f((column - 0.5) / side, 1 - (row - 0.5) / side)
      for k = 1, 3 do texels:set(row, column, k, c[k]) end
    end
  end
  assert(image:save(option.out .. name))
end

--- A number from 0 to 1 that belongs to two integers.
local function grain(i, j) return (math.sin(i * 12.9898 + j * 78.233) * 43758.5453) % 1 end

local function mixed(a, b, t)
  return { a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t, a[3] + (b[3] - a[3]) * t }
end

--- Bricks: eight courses, four bricks in each, every other course shifted by half of one.
texture("bricks.png", 256, function(x, y)
  local course = math.floor(8 * y)
  local across = 4 * x + (course % 2) / 2
  local u, v = across % 1, 8 * y % 1
  if u < 0.04 or v < 0.09 then return { 0.62, 0.6, 0.55 } end
  return mixed({ 0.45, 0.13, 0.07 }, { 0.62, 0.25, 0.14 }, grain(math.floor(across) % 4, course))
end)

--- Planks: eight along y, each with a grain of its own.
texture("planks.png", 256, function(x, y)
  local plank = math.floor(8 * y)
  if 8 * y % 1 < 0.05 then return { 0.12, 0.07, 0.04 } end
  local wave = math.sin(40 * y + 2 * math.sin(6.2832 * (x + grain(plank, 1))) + 30 * grain(plank, 2))
  return mixed({ 0.36, 0.22, 0.11 }, { 0.52, 0.34, 0.18 }, 0.5 + 0.3 * wave + 0.2 * (grain(plank, 3) - 0.5))
end)

-- Files ---------------------------------------------------------------------------------------------

local obj = { "mtllib room.mtl" }

--- A rectangle of a material, corner + s u + t v, along which its texture is repeated so many times.
local function rectangle(material, corner, u, v, across, up)
  obj[#obj + 1] = "usemtl " .. material
  for _, k in ipairs { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } } do
    local p = {}
    for i = 1, 3 do p[i] = corner[i] + k[1] * u[i] + k[2] * v[i] end
    obj[#obj + 1] = ("v %g %g %g"):format(p[1], p[2], p[3])
    obj[#obj + 1] = ("vt %g %g"):format(k[1] * across, k[2] * up)
  end
  obj[#obj + 1] = "f -4/-4 -3/-3 -2/-2 -1/-1"
end

local function write(name, lines)
  local file = assert(io.open(option.out .. name, "w"))
  file:write(table.concat(lines, "\n"), "\n")
  file:close()
end

rectangle("planks", { -2, 0, 2 }, { 4, 0, 0 }, { 0, 0, -4 }, 2, 2)
rectangle("bricks", { -2, 0, -2 }, { 4, 0, 0 }, { 0, 2.5, 0 }, 4, 2.5)
rectangle("bricks", { -2, 0, 2 }, { 0, 0, -4 }, { 0, 2.5, 0 }, 4, 2.5)
rectangle("green paint", { 2, 0, -2 }, { 0, 0, 4 }, { 0, 2.5, 0 }, 1, 1)
rectangle("white paint", { -2, 2.5, -2 }, { 4, 0, 0 }, { 0, 0, 4 }, 1, 1)
rectangle("lamp", { -0.6, 2.4, -0.6 }, { 1.2, 0, 0 }, { 0, 0, 1.2 }, 1, 1)
write("room.obj", obj)
write("room.mtl", { "newmtl planks", "map_Kd planks.png", "newmtl bricks", "map_Kd bricks.png",
  "newmtl green paint", "Kd 0.15 0.4 0.2", "newmtl white paint", "Kd 0.75", "newmtl lamp", "Ke 9 8 6.5" })

-- The room ------------------------------------------------------------------------------------------

--- A ball with a colour at each vertex.
local function ball(at, radius)
  local plain = ylm.sphere { radius = radius, at = at, divide = { 96, 48 } }.mesh
  local colours = {}
  local phase = (plain:uvs() * { 3, 2 }):sum(2) * (2 * math.pi)
  for i = 1, #phase do
    local t = 0.5 + 0.5 * math.sin(phase[i])
    colours[i] = mixed({ 0.9, 0.75, 0.2 }, { 0.1, 0.25, 0.7 }, t)
  end
  return ylm.mesh { vertices = plain:vertices(), triangles = plain:triangles(), normals = plain:normals(), colours = colours,
    material = ylm.matte { albedo = 1 } }
end

local room = assert(ylm.mesh { file = option.out .. "room.obj" })
local scene = ylm.scene "textured room" {
  camera = ylm.camera { from = { 0.5, 1.35, 4.6 }, at = { -0.1, 1.1, 0 }, fov = 44 },
  geometry = { room, ball({ -0.7, 0.6, -0.4 }, 0.6), ball({ 0.8, 0.4, 0.5 }, 0.4) },
}
for _, note in ipairs(scene.notes) do print(note) end

local size = { option.width, math.floor(option.width * 0.75) }
local rays = assert(scene:render { bounces = 0, size = size, samples = option.samples, light_samples = option.rays })
local harmonics = assert(scene:render { by = "sum", size = size, samples = option.samples, occlusion_distance = 1.5 })
common.save(ylm.figure {
  rows = { {
    { image = rays, tone = "hable", exposure = 1, caption = "by rays" },
    { image = harmonics, tone = "hable", exposure = 1, caption = "by the sum of lights" },
    { image = rays, layer = "albedo", caption = "albedo" },
  } },
}, option.out .. "textured_room.png")
