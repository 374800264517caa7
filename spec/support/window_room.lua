--- A furnished room with a window, a clear sky and a sun, of some 12,000 triangles: window_room(ylm) -> scene. With a second
-- argument, a function of an albedo, its materials are what that makes.

local material_of

local function matte(ylm, r, g, b) return (material_of or ylm.matte) { albedo = { r, g, b } } end

--- A body between two corners.
local function body(ylm, lo, hi, material) return ylm.box { bounds = { lo, hi }, material = material } end

--- Walls, floor and ceiling as one box from within a shell of boxes; the wall at x = 2.5 has a window.
local function shell(ylm, list)
  local wall, floor = matte(ylm, 0.74, 0.72, 0.68), matte(ylm, 0.42, 0.3, 0.2)
  local function add(lo, hi, material) list[#list + 1] = body(ylm, lo, hi, material or wall) end
  add({ -2.7, -0.2, -2.2 }, { 2.7, 0, 2.2 }, floor)
  add({ -2.7, 2.6, -2.2 }, { 2.7, 2.8, 2.2 }, matte(ylm, 0.82, 0.82, 0.8))
  add({ -2.7, 0, -2.2 }, { -2.5, 2.6, 2.2 })
  add({ -2.5, 0, -2.2 }, { 2.5, 2.6, -2 })
  add({ -2.5, 0, 2 }, { 2.5, 2.6, 2.2 })
  add({ 2.5, 0, -2.2 }, { 2.7, 0.9, 2.2 })
  add({ 2.5, 2.2, -2.2 }, { 2.7, 2.6, 2.2 })
  add({ 2.5, 0.9, -2.2 }, { 2.7, 2.2, -0.8 })
  add({ 2.5, 0.9, 0.8 }, { 2.7, 2.2, 2.2 })
  add({ 2.56, 0.9, -0.03 }, { 2.62, 2.2, 0.03 }, matte(ylm, 0.8, 0.8, 0.8)) -- a bar of the window
end

local function furniture(ylm, list)
  local wood, cloth = matte(ylm, 0.5, 0.33, 0.2), matte(ylm, 0.25, 0.35, 0.5)
  local function add(lo, hi, material) list[#list + 1] = body(ylm, lo, hi, material) end
  add({ 0.4, 0.7, -0.5 }, { 1.6, 0.74, 0.5 }, wood) -- a table
  for _, x in ipairs { 0.45, 1.49 } do
    for _, z in ipairs { -0.45, 0.39 } do add({ x, 0, z }, { x + 0.06, 0.7, z + 0.06 }, wood) end
  end
  add({ -2.3, 0, -0.9 }, { -1.5, 0.42, 0.9 }, cloth) -- a sofa
  add({ -2.45, 0, -0.9 }, { -2.25, 0.85, 0.9 }, cloth)
  for _, z in ipairs { -1.1, 0.9 } do add({ -2.45, 0, z }, { -1.5, 0.6, z + 0.2 }, cloth) end
  for k = 0, 4 do add({ -1, 0.1 + 0.4 * k, -2 }, { 0.6, 0.13 + 0.4 * k, -1.7 }, wood) end -- shelves
  add({ -1.03, 0, -2 }, { -1, 1.9, -1.7 }, wood)
  add({ 0.6, 0, -2 }, { 0.63, 1.9, -1.7 }, wood)
  for k = 0, 3 do -- books
    local x, n = -0.98, 0
    while x < 0.3 do
      n = n + 1
      local width, height = 0.025 + 0.02 * ((7 * n + 3 * k) % 5) / 4, 0.2 + 0.08 * ((5 * n + k) % 4) / 3
      list[#list + 1] = body(ylm, { x, 0.131 + 0.4 * k, -1.98 }, { x + width, 0.131 + 0.4 * k + height, -1.78 },
        matte(ylm, 0.2 + 0.1 * ((n + k) % 6), 0.2 + 0.08 * ((2 * n + k) % 7), 0.15 + 0.1 * ((3 * n) % 5)))
      x = x + width + 0.002
    end
  end
  list[#list + 1] = ylm.sphere { radius = 0.13, divide = { 48, 24 }, at = { 0.8, 0.871, 0.1 },
    material = matte(ylm, 0.7, 0.3, 0.2) }
  list[#list + 1] = ylm.sphere { radius = 0.09, divide = { 48, 24 }, at = { 1.1, 0.831, -0.2 },
    material = matte(ylm, 0.3, 0.6, 0.25) }
  list[#list + 1] = ylm.torus { radius = 0.28, tube = 0.09, divide = { 64, 32 }, at = { -0.4, 0.0905, 0.9 },
    rotate = { axis = { 1, 0, 0 }, angle = 90 }, material = matte(ylm, 0.6, 0.55, 0.2) }
end

return function(ylm, make)
  local list = {}
  material_of = make
  shell(ylm, list)
  furniture(ylm, list)
  return ylm.scene "a room with a window" {
    camera = ylm.camera { from = { -2.1, 1.5, 1.7 }, at = { 0.9, 0.8, -0.5 }, fov = 75 },
    geometry = list,
    lights = { ylm.sun_light { direction = { 2, 1.2, 0.5 }, irradiance = { 60, 54, 44 } },
      ylm.environment_light { sky = { kind = "clear", zenith = { 0, 1, 0 }, sun = { 2, 1.2, 0.5 }, luminance = 2 } } },
  }
end
