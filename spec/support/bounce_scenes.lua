--- Three scenes by which bounces are judged against the path tracer: { name, make(ylm) -> scene }.

local scenes = {}

local function add(name, make) scenes[#scenes + 1] = { name = name, make = make } end

--- Numbers from 0 to 1, the same everywhere.
local function random(seed)
  local state = seed
  return function()
    state = (state * 16807) % 2147483647
    return state / 2147483647
  end
end

-- The knot of the demo and its 2,516 lamps, in a room with a ceiling.
add("knot and lamps in a room", function(ylm)
  local demo = assert(ylm.load "examples/scenes/floor_lights.lua")
  local geometry = { ylm.box { bounds = { { -5.6, -0.001, -5.6 }, { 5.6, 3.8, 5.6 } },
    material = ylm.matte { albedo = { 0.62, 0.6, 0.55 } } } }
  geometry[2] = ylm.knot { at = { 0, 1.25, 0 }, p = 2, q = 3, radius = 0.75, minor = 0.38, tube = 0.21, divide = { 350, 28 },
    material = ylm.matte { albedo = { 0.74, 0.70, 0.66 } } }
  return ylm.scene "knot and lamps in a room" { camera = ylm.camera { from = { 3.9, 1.85, 5.4 }, at = { 0, 1.15, 0 }, fov = 48 },
    geometry = geometry, lights = demo.lights }
end)

-- A lamp in one of two rooms; the camera is in the other, which light reaches through a door.
add("two rooms and a door", function(ylm)
  local white, red = ylm.matte { albedo = { 0.7, 0.7, 0.7 } }, ylm.matte { albedo = { 0.65, 0.2, 0.15 } }
  local function wall(lo, hi) return ylm.box { bounds = { lo, hi }, material = red } end
  return ylm.scene "two rooms and a door" { camera = ylm.camera { from = { 2.7, 1.6, 1.3 }, at = { 0, 1.1, -0.2 }, fov = 70 },
    geometry = { ylm.box { bounds = { { -3, 0, -1.5 }, { 3, 2.6, 1.5 } }, material = white },
      wall({ -0.06, 0.001, -1.499 }, { 0.06, 2.599, -0.4 }), wall({ -0.06, 0.001, 0.5 }, { 0.06, 2.599, 1.499 }),
      wall({ -0.06, 2, -0.3999 }, { 0.06, 2.599, 0.4999 }),
      ylm.box { bounds = { { 0.9, 0.001, -1.2 }, { 1.5, 0.7, -0.6 } }, material = ylm.matte { albedo = { 0.2, 0.5, 0.3 } } } },
    lights = { ylm.sphere_light { at = { -1.4, 1.9, 0.3 }, radius = 0.15, radiance = { 40, 36, 30 } } } }
end)

-- 200 bodies, of which 50 are rods as thin as a finger.
add("200 bodies and thin parts", function(ylm)
  local draw, geometry = random(7), {}
  geometry[1] = ylm.box { bounds = { { -3, 0, -3 }, { 3, 3, 3 } }, material = ylm.matte { albedo = { 0.65, 0.65, 0.6 } } }
  local function colour() return ylm.matte { albedo = { 0.2 + 0.6 * draw(), 0.2 + 0.6 * draw(), 0.2 + 0.6 * draw() } } end
  for i = 0, 149 do
    local x, z = -2.6 + 5.2 * (i % 15) / 14, -2.7 + 3.9 * math.floor(i / 15) / 9
    local r = 0.06 + 0.09 * draw()
    local y = r + 0.002 + 0.8 * draw() ^ 3
    local at = { x + 0.1 * (draw() - 0.5), y, z + 0.1 * (draw() - 0.5) }
    if i % 3 == 0 then geometry[#geometry + 1] = ylm.sphere { at = at, radius = r, divide = { 24, 12 }, material = colour() }
    else
      geometry[#geometry + 1] = ylm.box { bounds = { { -r, -r, -r }, { r, r, r } }, at = at, rotate = { axis = { 0, 1, 0 },
        angle = 90 * draw() }, material = colour() }
    end
  end
  for i = 0, 49 do
    local x, z, t = -2.8 + 5.6 * ((i * 0.618034) % 1), -2.8 + 4.2 * ((i * 0.754878) % 1), 0.012
    geometry[#geometry + 1] = ylm.box { bounds = { { x - t, 0.002, z - t }, { x + t, 1 + 1.2 * draw(), z + t } },
      material = colour() }
  end
  return ylm.scene "200 bodies and thin parts" {
    camera = ylm.camera { from = { 0.6, 1.9, 2.9 }, at = { 0, 0.6, -0.8 }, fov = 55 }, geometry = geometry, lights = {
      ylm.sphere_light { at = { -1.6, 2.6, -0.5 }, radius = 0.12, radiance = { 40, 34, 26 } },
      ylm.polygon_light { vertices = { { 1, 2.9, -1.5 }, { 1, 2.9, 0 }, { 2, 2.9, 0 }, { 2, 2.9, -1.5 } },
        radiance = { 3, 4, 6 } } } }
end)

return scenes
