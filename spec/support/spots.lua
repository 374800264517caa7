--- Rooms in soft light with a lamp close above the floor: few pixels are bright, and have most of a picture's error.

local ylm = require "ylm"

local spots = {}

--- Numbers from 0 to 1, the same everywhere.
local function random(seed)
  local state = (seed * 48271 + 11) % 2147483647
  local function draw()
    state = (state * 16807) % 2147483647
    return state / 2147483647
  end
  for _ = 1, 5 do draw() end
  return draw
end

--- The scene of a number. Every third one has no room about it, every fourth another lamp near a wall.
function spots.scene(number)
  local draw = random(number)
  local white = ylm.matte { albedo = 0.6 }
  local geometry = { number % 3 == 0 and ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = white }
    or ylm.box { bounds = { { -2, 0, -2 }, { 2, 2.5, 2 } }, material = white },
    ylm.box { bounds = { { 0.3, 0.001, -1 }, { 0.8, 0.6, -0.5 } }, material = ylm.matte { albedo = { 0.3, 0.4, 0.6 } } } }
  local radius = 0.02 + 0.03 * draw()
  local height = radius * (1.5 + 2 * draw())
  local lights = { ylm.sphere_light { at = { -0.4, 2, 0.5 }, radius = 0.2, radiance = 10 },
    ylm.sphere_light { at = { 1.6 * draw() - 1.2, height, 1.2 * draw() - 0.6 }, radius = radius,
      radiance = 10 * 10 ^ draw() } }
  if number % 4 == 0 then
    lights[3] = ylm.sphere_light { at = { 2.4 * draw() - 1.2, 0.3 + draw(), -1.96 }, radius = 0.03, radiance = 100 * draw() }
  end
  return ylm.scene(("spot %d"):format(number)) { camera = ylm.camera { from = { 0.3, 1.3, 1.8 }, at = { -0.2, 0.2, -0.3 },
    fov = 60 }, geometry = geometry, lights = lights }
end

local function numbers(image, layer) return ylm.array(image:layer(layer), "double") end

--- How far a picture is from paths, over pixels that show no lamp: the squared error relative to the squared mean, the noise
-- of the paths taken off, and its standard error.
function spots.error(image, truth)
  local size = image.size
  local a, b, v = numbers(image, "radiance"), numbers(truth, "radiance"), numbers(truth, "variance")
  local seen = (numbers(image, "emitter"):equal(0) * numbers(image, "coverage")):reshape { size[2], size[1] }:totable()
  local square, noise, mean, n = 0, 0, 0, 0
  a, b, v = a:totable(), b:totable(), v:totable()
  for y = 1, size[2] do
    for x = 1, size[1] do
      if seen[y][x] > 0 then
        n = n + 1
        for c = 1, 3 do
          local d = (a[y][x][c] - b[y][x][c]) ^ 2 - v[y][x][c]
          square, mean = square + d / 3, mean + b[y][x][c] / 3
          noise = noise + (4 * math.max(0, d) * v[y][x][c] + 2 * v[y][x][c] ^ 2) / 3
        end
      end
    end
  end
  local scale = n / mean ^ 2
  return square * scale, math.sqrt(noise) * scale
end

return spots
