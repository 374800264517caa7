--- Five interiors that a first picture may be of: interiors(ylm) -> { { name, scene }, .. }. Metres; y is up.

local function matte(ylm, r, g, b) return ylm.matte { albedo = { r, g or r, b or r } } end

local function body(ylm, lo, hi, material) return ylm.box { bounds = { lo, hi }, material = material } end

--- Walls of a room of this size that stands on y = 0, without those that are named.
local function shell(ylm, list, size, without)
  local x, y, z, t = size[1] / 2, size[2], size[3] / 2, 0.2
  local wall, floor, top = matte(ylm, 0.7, 0.69, 0.66), matte(ylm, 0.45, 0.35, 0.26), matte(ylm, 0.8)
  local parts = { floor = { { -x, -t, -z }, { x, 0, z }, floor }, top = { { -x, y, -z }, { x, y + t, z }, top },
    left = { { -x - t, -t, -z - t }, { -x, y + t, z + t }, wall }, right = { { x, -t, -z - t }, { x + t, y + t, z + t }, wall },
    back = { { -x, -t, -z - t }, { x, y + t, -z }, wall }, front = { { -x, -t, z }, { x, y + t, z + t }, wall } }
  for _, name in ipairs { "floor", "top", "left", "right", "back", "front" } do
    if name ~= without then list[#list + 1] = body(ylm, parts[name][1], parts[name][2], parts[name][3]) end
  end
end

--- A wall at x = at with an opening between two corners of (y, z).
local function wall_with(ylm, list, at, height, width, lo, hi)
  local wall, z = matte(ylm, 0.7, 0.69, 0.66), width / 2
  local function add(y0, y1, z0, z1) list[#list + 1] = body(ylm, { at, y0, z0 }, { at + 0.2, y1, z1 }, wall) end
  if lo[1] > 0 then add(0, lo[1], -z, z) end
  add(hi[1], height, -z, z)
  add(lo[1], hi[1], -z, lo[2])
  add(lo[1], hi[1], hi[2], z)
end

--- An overcast sky through a small window.
local function overcast(ylm)
  local list = {}
  shell(ylm, list, { 4, 2.5, 3 }, "right")
  wall_with(ylm, list, 2, 2.5, 3, { 1.1, -0.3 }, { 1.8, 0.3 })
  list[#list + 1] = body(ylm, { 0.3, 0, -0.9 }, { 1.1, 0.72, 0.1 }, matte(ylm, 0.5, 0.33, 0.2))
  list[#list + 1] = ylm.sphere { radius = 0.16, at = { 0.7, 0.881, -0.4 }, divide = { 48, 24 },
    material = matte(ylm, 0.3, 0.5, 0.6) }
  list[#list + 1] = body(ylm, { -1.9, 0, -1.45 }, { -0.6, 1.8, -1.1 }, matte(ylm, 0.6, 0.5, 0.4))
  return ylm.scene "an overcast sky through a small window" {
    camera = ylm.camera { from = { -1.6, 1.5, 1.2 }, at = { 0.8, 0.8, -0.5 }, fov = 65 }, geometry = list,
    lights = { ylm.environment_light { sky = { kind = "overcast", zenith = { 0, 1, 0 }, luminance = 20 } } },
  }
end

--- A lamp in a shade that is open above and below.
local function shade(ylm)
  local list, cloth = {}, matte(ylm, 0.75, 0.65, 0.5)
  shell(ylm, list, { 4, 2.5, 3 })
  list[#list + 1] = body(ylm, { 0.4, 0, -0.9 }, { 1.4, 0.7, -0.1 }, matte(ylm, 0.5, 0.33, 0.2))
  local x, y, z, r, h = 0.9, 1.05, -0.5, 0.14, 0.22
  for _, side in ipairs { { -1, 0 }, { 1, 0 }, { 0, -1 }, { 0, 1 } } do
    local a, b = side[1] * r, side[2] * r
    local u, v = side[2] ~= 0 and r or 0.005, side[1] ~= 0 and r or 0.005
    list[#list + 1] = body(ylm, { x + a - u, y, z + b - v }, { x + a + u, y + h, z + b + v }, cloth)
  end
  list[#list + 1] = body(ylm, { x - 0.02, 0.7, z - 0.02 }, { x + 0.02, 1.08, z + 0.02 }, matte(ylm, 0.4))
  list[#list + 1] = body(ylm, { -1.8, 0, -1 }, { -0.9, 0.45, 0.6 }, matte(ylm, 0.3, 0.4, 0.5))
  return ylm.scene "a lamp in its shade" {
    camera = ylm.camera { from = { -1.2, 1.4, 1.35 }, at = { 0.7, 0.9, -0.6 }, fov = 65 }, geometry = list,
    lights = { ylm.sphere_light { at = { x, y + 0.12, z }, radius = 0.04, radiance = { 700, 560, 380 } } },
  }
end

--- A corridor with one door to a court under the sun.
local function corridor(ylm)
  local list, stone = {}, matte(ylm, 0.6, 0.57, 0.5)
  shell(ylm, list, { 1.6, 2.5, 8 }, "right")
  wall_with(ylm, list, 0.8, 2.5, 8, { 0, -1.4 }, { 2.1, -0.5 })
  list[#list + 1] = body(ylm, { 0.8, -0.2, -5 }, { 7, 0, 4 }, stone)
  list[#list + 1] = body(ylm, { 7, -0.2, -5 }, { 7.3, 6, 4 }, stone)
  list[#list + 1] = body(ylm, { 1, 0, -5.3 }, { 7.3, 6, -5 }, stone)
  list[#list + 1] = body(ylm, { -0.75, 0, -2.6 }, { -0.4, 0.8, -1.9 }, matte(ylm, 0.4, 0.25, 0.15))
  return ylm.scene "a corridor with a door to a court" {
    camera = ylm.camera { from = { 0.1, 1.5, 3.2 }, at = { 0, 1.1, -2 }, fov = 60 }, geometry = list,
    lights = { ylm.sun_light { direction = { 1, 1.6, 0.3 }, irradiance = { 120, 110, 95 } },
      ylm.environment_light { sky = { kind = "clear", zenith = { 0, 1, 0 }, sun = { 1, 1.6, 0.3 }, luminance = 4 } } },
  }
end

--- The room with a window as Blender's materials are by default, of roughness 0.5.
local function plastic(ylm)
  local function of(o) return ylm.ggx { alpha = 0.25, f0 = 0.04, base = o.albedo } end
  return dofile "spec/support/window_room.lua"(ylm, of)
end

return function(ylm)
  return { { "window", dofile "spec/support/window_room.lua"(ylm) }, { "overcast", overcast(ylm) }, { "shade", shade(ylm) },
    { "corridor", corridor(ylm) }, { "plastic", plastic(ylm) } }
end
