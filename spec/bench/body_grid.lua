-- A body's adaptive grid against concentric shells, the form of Zhou et al. 2005: samples, memory, error. Bakes of bodies
-- by rays: places, seconds, error.
--
--     make bench BENCH=body_grid
--
-- Shells: directions of a cube map times logarithms of radii, interpolated linearly in all three. Errors are relative to
-- the norm of the visibility, at 2000 places whose logarithm of the distance is even; 99 % of them keep the error.

local ylm = require "ylm"
local core = require "ylm.c.core"

io.stdout:setvbuf "line"

local quick = os.getenv "BENCH" == "quick"
local LMAX, NEAR, FAR, PLACES = 9, 1.05, 6, quick and 200 or 2000
local COUNT = (LMAX + 1) ^ 2

local state = 11
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- n places from `NEAR` to `FAR` radii.
local function places(n, radius)
  local list = {}
  for i = 1, n do
    local z, phi = 2 * random() - 1, 2 * math.pi * random()
    local s, r = math.sqrt(1 - z * z), radius * NEAR * (FAR / NEAR) ^ random()
    list[i] = { r * s * math.cos(phi), r * s * math.sin(phi), r * z }
  end
  return list
end

local function row_of(table_, i)
  local row = table_[i]
  return type(row[1]) == "table" and row[1] or row
end

--- The error that 99 % of the places keep.
local function error_of(rows, truth)
  local errors = {}
  for i = 1, #truth do
    local d, s, a, b = 0, 0, row_of(rows, i), row_of(truth, i)
    for k = 1, COUNT do d, s = d + (a[k] - b[k]) ^ 2, s + b[k] ^ 2 end
    errors[i] = math.sqrt(d / s)
  end
  table.sort(errors)
  return errors[math.ceil(0.99 * #errors)]
end

local axes = { { 1, 2, 3 }, { 2, 3, 1 }, { 3, 1, 2 } }

--- Face 1 to 6 of a direction, and its place on it, -1 to 1 each.
local function on_cube(p)
  local most, axis = 0, 1
  for a = 1, 3 do if math.abs(p[a]) > most then most, axis = math.abs(p[a]), a end end
  local f = axes[axis]
  return 2 * axis - (p[axis] > 0 and 1 or 0), math.atan(p[f[2]] / most) * 4 / math.pi, math.atan(p[f[3]] / most) * 4 / math.pi
end

local function clamped(x, n)
  local at = math.min(n - 1, math.max(0, math.floor(x)))
  return at, x - at
end

--- Visibility at places from shells of 6 n^2 + 2 directions and m radii.
local function by_shells(body, radius, n, m, where)
  local points, at = {}, {}
  for face = 1, 6 do
    local f, sign = axes[math.ceil(face / 2)], face % 2 == 1 and 1 or -1
    for j = 0, n do for i = 0, n do
      local w = {}
      w[f[1]], w[f[2]], w[f[3]] = sign, math.tan((2 * i / n - 1) * math.pi / 4), math.tan((2 * j / n - 1) * math.pi / 4)
      local length = math.sqrt(w[1] ^ 2 + w[2] ^ 2 + w[3] ^ 2)
      for k = 0, m - 1 do
        local r = radius * NEAR * (FAR / NEAR) ^ (k / (m - 1)) / length
        points[#points + 1] = { r * w[1], r * w[2], r * w[3] }
        at[((face * (n + 1) + j) * (n + 1) + i) * m + k] = #points
      end
    end end
  end
  local V = ylm.light_field(LMAX, body, points, { channels = "luminance" })
  local rows, cache = {}, {}
  local function sample(index)
    cache[index] = cache[index] or row_of({ V[index]:totable() }, 1)
    return cache[index]
  end
  for q, p in ipairs(where) do
    local face, x, y = on_cube(p)
    local r = math.log(math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2) / (radius * NEAR)) / math.log(FAR / NEAR) * (m - 1)
    local i, u = clamped((x + 1) / 2 * n, n)
    local j, v = clamped((y + 1) / 2 * n, n)
    local k, t = clamped(r, m - 1)
    local row = {}
    for c = 1, COUNT do row[c] = 0 end
    for corner = 0, 7 do
      local a, b, d = corner % 2, math.floor(corner / 2) % 2, math.floor(corner / 4)
      local weight = (a == 1 and u or 1 - u) * (b == 1 and v or 1 - v) * (d == 1 and t or 1 - t)
      local from = sample(at[((face * (n + 1) + j + b) * (n + 1) + i + a) * m + k + d])
      for c = 1, COUNT do row[c] = row[c] + weight * from[c] end
    end
    rows[q] = row
  end
  return rows, (6 * n * n + 2) * m
end

local function print_row(...) print(("| %s |"):format(table.concat({ ... }, " | "))) end

local body = ylm.occluder { geometry = ylm.box {} }
local radius = body.radius
local where = places(PLACES, radius)
local truth = ylm.light_field(LMAX, body, where, { channels = "luminance" }):totable()

print(("A cube, n = %d, from %g to %g radii, %d places. MB of coefficients, and of grids as they lie in memory."):format(LMAX + 1,
  NEAR, FAR, PLACES))
print()
print_row("form", "samples", "MB of coefficients", "MB", "error of 99 %")
print_row("---", "--:", "--:", "--:", "--:")
for _, shape in ipairs(quick and { { 4, 6 } } or { { 8, 16 }, { 16, 33 }, { 24, 33 }, { 32, 48 } }) do
  local rows, n = by_shells(body, radius, shape[1], shape[2], where)
  local mb = n * COUNT * 4 / 2 ^ 20
  print_row(("shells, 6 x %d² + 2 directions, %d radii"):format(shape[1], shape[2]), ("%d"):format(n), ("%.1f"):format(mb),
    ("%.1f"):format(mb), ("%.4f"):format(error_of(rows, truth)))
end
local box = { { -FAR * radius, -FAR * radius, -FAR * radius }, { FAR * radius, FAR * radius, FAR * radius } }
for _, tolerance in ipairs(quick and { 0.2 } or { 0.1, 0.05, 0.03, 0.02 }) do
  for _, continuous in ipairs { true, false } do
    local grid = ylm.bake(ylm.adaptive_grid { lmax = LMAX, depth = 9, tolerance = tolerance, channels = "luminance", bounds = box,
      continuous = continuous }, body, { occupied = places(20000, radius) })
    print_row(("grid, tolerance %g%s"):format(tolerance, continuous and "" or ", not continuous"),
      ("%d"):format(grid.stats.points), ("%.1f"):format(grid.stats.points * 4 * COUNT * 4 / 2 ^ 20),
      ("%.1f"):format(grid.stats.bytes / 2 ^ 20), ("%.4f"):format(error_of(grid:sample(where):totable(), truth)))
  end
end

local cases = { { "cube, exact", ylm.box {}, nil, 0.03, 10, 0.02 }, { "cube", ylm.box {}, 32, 0.03, 10, 0.02 },
  { "torus 0.6, 0.2", ylm.torus { radius = 0.6, tube = 0.2 }, 32, 0.05, 11, 0.05 },
  { "sphere of 102,400 triangles", ylm.sphere { radius = 0.6, divide = { 320, 160 } }, 64, 0.03, 10, 0.02 } }
if quick then cases = { { "cube", ylm.box {}, 8, 0.3, 5, 0.5 } } end
print()
print(("Bakes to 20 radii, n = %d. Seconds by the clock, threads as set, and of the processor."):format(LMAX + 1))
print()
print_row("body", "rays", "tolerance", "near", "probes", "MB", "met", "error", "noise", "seconds", "processor")
print_row("---", "--:", "--:", "--:", "--:", "--:", "---", "--:", "--:", "--:", "--:")
for _, c in ipairs(cases) do
  local hides, missing = ylm.occluder { geometry = c[2], rays = c[3], near = c[6] }
  if hides then
    local start, clock = os.clock(), core.seconds()
    local grid = ylm.bake(ylm.adaptive_grid { lmax = LMAX, depth = c[5], tolerance = c[4], channels = "luminance" }, hides)
    local seconds, by_clock = os.clock() - start, core.seconds() - clock
    print_row(c[1], c[3] and tostring(c[3]) or "", tostring(c[4]), tostring(c[6]), ("%d"):format(grid.stats.points),
      ("%.0f"):format(grid.stats.bytes / 2 ^ 20), grid.stats.met and "yes" or "no", ("%.3f"):format(grid.stats.error),
      ("%.4f"):format(hides:noise(LMAX)), ("%.1f"):format(by_clock), ("%.1f"):format(seconds))
  else
    print(missing)
  end
end
