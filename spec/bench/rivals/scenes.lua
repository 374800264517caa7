--- Ten scenes by which probes for engines are judged: { name, make(ylm) -> scene, quantity, closed, box }.
--
-- `quantity` is the light that probes hold: "indirect" where an engine draws its lamps itself, "all" where a sky or panels light
-- the scene. `closed` is a box that no light reaches, `box` that of the probes where it is not that of the geometry.

local scenes = {}

local function add(name, quantity, make, more)
  local entry = { name = name, make = make, quantity = quantity }
  for key, value in pairs(more or {}) do entry[key] = value end
  scenes[#scenes + 1] = entry
end

--- Makes bodies: body(lo, hi, albedo) is one between two corners, seen from outside of it.
local function bodies(ylm)
  local list = {}
  return list, function(lo, hi, albedo)
    list[#list + 1] = ylm.box { bounds = { lo, hi }, sides = "front", material = ylm.matte { albedo = albedo } }
  end
end

--- A room between two corners, seen from within.
local function shell(ylm, lo, hi, albedo)
  return ylm.box { bounds = { lo, hi }, sides = "back", material = ylm.matte { albedo = albedo } }
end

--- A scene of another file, where it stands beside others by name.
local function borrowed(file, name)
  return function(ylm)
    for _, entry in ipairs(require(file)) do if entry.name == name then return entry.make(ylm) end end
  end
end

local RED, GREY = { 0.65, 0.12, 0.1 }, 0.7

-- Two rooms with walls of 4 cm, a gap between them, and a closet that nothing lights.
add("rooms", "indirect", function(ylm)
  local list, body = bodies(ylm)
  list[1] = shell(ylm, { -3, 0, -1.5 }, { 3, 2.6, 1.5 }, GREY)
  body({ 0.3, 0.001, -1.499 }, { 0.34, 2.599, 0.2 }, RED)
  body({ 0.3, 0.001, 0.9 }, { 0.34, 2.599, 1.499 }, RED)
  body({ -2.2, 0.001, -0.9 }, { -1.5, 0.8, -0.3 }, { 0.3, 0.5, 0.65 })
  body({ 1.9, 0.001, 0.46 }, { 2.999, 2.599, 0.5 }, GREY) -- the closet: two walls in a corner
  body({ 1.86, 0.001, 0.46 }, { 1.9, 2.599, 1.499 }, GREY)
  return ylm.scene "rooms" { camera = ylm.camera { from = { -2.7, 1.6, 1.2 }, at = { 0.5, 1, -0.2 }, fov = 75 }, geometry = list,
    lights = { ylm.sphere_light { at = { -1.2, 1.9, 0.4 }, radius = 0.1, radiance = { 90, 84, 76 } } } }
end, { closed = { { 1.9, 0, 0.5 }, { 3, 2.6, 1.5 } } })

-- A court with thick walls under a uniform sky: a roof on posts, and a closed shed.
add("court", "all", function(ylm)
  local list, body = bodies(ylm)
  body({ -3, -0.1, -3 }, { 3, 0, 3 }, { 0.5, 0.48, 0.45 })
  body({ -3, 0, -3 }, { -2.8, 2.4, 3 }, RED)
  body({ 2.8, 0, -3 }, { 3, 2.4, 3 }, GREY)
  body({ -2.8, 0, -3 }, { 2.8, 2.4, -2.8 }, GREY)
  body({ -2.8, 0, 2.8 }, { 2.8, 2.4, 3 }, GREY)
  body({ -2.8, 2, -2.8 }, { 0, 2.06, -1.2 }, GREY) -- the roof
  for _, x in ipairs { -2.6, -1.4, -0.2 } do body({ x, 0, -1.4 }, { x + 0.12, 2, -1.28 }, GREY) end
  body({ -0.6, 0, 0.3 }, { 0.1, 0.7, 1 }, { 0.3, 0.5, 0.65 })
  body({ 1.2, 0, 1.2 }, { 1.26, 1.8, 2.8 }, GREY) -- the shed
  body({ 1.26, 0, 1.2 }, { 2.8, 1.8, 1.26 }, GREY)
  body({ 1.2, 1.8, 1.2 }, { 2.8, 1.86, 2.8 }, GREY)
  return ylm.scene "court" { camera = ylm.camera { from = { 2.4, 1.7, -0.4 }, at = { -1.2, 0.8, -1 }, fov = 75 }, geometry = list,
    lights = { ylm.environment_light { radiance = 1 } } }
end, { closed = { { 1.26, 0, 1.26 }, { 2.8, 1.8, 2.8 } }, box = { { -3, 0, -3 }, { 3, 2.6, 3 } } })

-- Lamps on one side of a closed wall.
add("two_rooms", "indirect", function(ylm)
  local list, body = bodies(ylm)
  list[1] = shell(ylm, { -3.3, 0, -2 }, { 3.3, 2.6, 2 }, { 0.74, 0.72, 0.68 })
  body({ -0.1, 0.001, -1.999 }, { 0.1, 2.599, 1.999 }, { 0.74, 0.72, 0.68 })
  for _, x in ipairs { -2, 2 } do body({ x - 0.6, 0.001, -1.2 }, { x + 0.1, 0.7, -0.5 }, { 0.62, 0.3, 0.2 }) end
  local lamps = {}
  for row = 0, 2 do
    for column = 0, 2 do
      for _, y in ipairs { 1.1, 1.8 } do
        lamps[#lamps + 1] = ylm.sphere_light { at = { -2.6 + column, y, -1.2 + 1.2 * row }, radius = 0.05,
          radiance = { 42, 33, 22 } }
      end
    end
  end
  return ylm.scene "two_rooms" { camera = ylm.camera { from = { -3, 1.6, 1.7 }, at = { -1.2, 0.9, -0.5 }, fov = 75 },
    geometry = list, lights = lamps }
end, { closed = { { 0.1, 0, -2 }, { 3.3, 2.6, 2 } } })

-- Gloss beside matte surfaces.
add("room", "indirect", function(ylm)
  local list = { shell(ylm, { -1, 0, -1 }, { 1, 2, 1 }, 0.75),
    ylm.box { bounds = { { 0.2, 0.001, -0.5 }, { 0.7, 0.6, 0 } }, sides = "front", material = ylm.matte { albedo = 0.75 } },
    ylm.box { bounds = { { -0.99, 0.001, -0.8 }, { -0.95, 1.6, 0.8 } }, sides = "front", material = ylm.matte { albedo = RED } },
    ylm.sphere { at = { -0.45, 0.4, -0.3 }, radius = 0.39, divide = { 48, 24 }, sides = "front",
      material = ylm.ggx { alpha = 0.3, f0 = 0.9 } } }
  return ylm.scene "room" { camera = ylm.camera { from = { 0.85, 1.2, 0.9 }, at = { -0.3, 0.7, -0.5 }, fov = 75 },
    geometry = list,
    lights = { ylm.sphere_light { at = { -0.4, 1.5, 0.4 }, radius = 0.1, radiance = { 20, 17, 14 } } } }
end)

-- A sky through a window, in a furnished room.
add("window", "all", function(ylm)
  local room = dofile "spec/support/window_room.lua"(ylm)
  return ylm.scene "window" { camera = room.camera, geometry = room.geometry, lights = { room.lights[2] } }
end, { box = { { -2.5, 0, -2 }, { 2.6, 2.6, 2 } } })

-- 2,516 lamps above a floor.
add("floor_lights", "indirect", borrowed("spec.support.bounce_scenes", "knot and lamps in a room"))

-- Panels alone light a room with partitions.
add("panels", "all", function(ylm)
  local lamps, list, body = {}, bodies(ylm)
  list[1] = shell(ylm, { -4, 0, -2.5 }, { 4, 2.7, 2.5 }, { 0.72, 0.7, 0.66 })
  for i = -1, 1 do body({ 2 * i - 0.02, 0.001, -2.499 }, { 2 * i + 0.02, 1.8, 0.6 }, { 0.4, 0.55, 0.6 }) end
  for i = 0, 3 do body({ 2 * i - 3.7, 0.72, -2.3 }, { 2 * i - 2.4, 0.76, -1.6 }, { 0.5, 0.35, 0.22 }) end
  for i = 0, 3 do
    local x = 2 * i - 3.6
    lamps[i + 1] = ylm.polygon_light { vertices = { { x, 2.65, -0.4 }, { x + 1.2, 2.65, -0.4 }, { x + 1.2, 2.65, 0 },
      { x, 2.65, 0 } }, radiance = i == 2 and { 2, 3, 5 } or { 5, 4.6, 4 } }
  end
  return ylm.scene "panels" { camera = ylm.camera { from = { -3.7, 1.6, 2.2 }, at = { 0, 1, -1 }, fov = 75 }, geometry = list,
    lights = lamps }
end)

-- 40 blades of 5 mm before a bright wall.
add("louvres", "indirect", function(ylm)
  local list, body = bodies(ylm)
  list[1] = shell(ylm, { -2, 0, -1.5 }, { 2, 2.4, 1.5 }, GREY)
  for i = 0, 39 do
    local y = 0.1 + 0.055 * i
    list[#list + 1] = ylm.box { bounds = { { -0.0025, -0.04, -1.4 }, { 0.0025, 0.04, 1.4 } }, at = { 0.3, y, 0 },
      rotate = { axis = { 0, 0, 1 }, angle = 50 }, sides = "front", material = ylm.matte { albedo = 0.6 } }
  end
  body({ -1.4, 0.001, -0.7 }, { -0.7, 0.6, 0.1 }, RED)
  return ylm.scene "louvres" { camera = ylm.camera { from = { -1.8, 1.4, 1.2 }, at = { 0.3, 1, 0 }, fov = 75 }, geometry = list,
    lights = { ylm.sphere_light { at = { 1.3, 1.8, 0.5 }, radius = 0.1, radiance = { 60, 54, 45 } } } }
end)

-- Five floors that light reaches from the top.
add("stairs", "indirect", function(ylm)
  local list, body = bodies(ylm)
  list[1] = shell(ylm, { -2, 0, -1.5 }, { 2, 7.5, 1.5 }, { 0.76, 0.74, 0.7 })
  for i = 1, 4 do
    local y, left = 1.5 * i, i % 2 == 0
    body({ left and -1.999 or -0.8, y - 0.08, -1.499 }, { left and 0.8 or 1.999, y, 1.499 }, { 0.6, 0.58, 0.55 })
  end
  for i = 0, 4 do body({ 0.9, 1.5 * i + 0.001, -0.6 }, { 1.3, 1.5 * i + 0.6, -0.2 }, RED) end
  return ylm.scene "stairs" { camera = ylm.camera { from = { -1.7, 7, 1.2 }, at = { 0.4, 6.2, -0.2 }, fov = 75 }, geometry = list,
    lights = { ylm.sphere_light { at = { -1, 7, 0.4 }, radius = 0.12, radiance = { 80, 74, 64 } } } }
end)

-- Clutter under its sphere lamp alone: programs without flat lamps draw the other one as a surface, whose light probes hold.
add("clutter", "indirect", function(ylm)
  local all = borrowed("spec.support.bounce_scenes", "200 bodies and thin parts")(ylm)
  return ylm.scene "clutter" { camera = all.camera, geometry = all.geometry, lights = { all.lights[1] } }
end)

return scenes
