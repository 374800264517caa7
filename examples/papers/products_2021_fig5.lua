-- Xin et al. 2021, Fig. 5 (c, d): products of real visibility maps, against the products of the maps themselves.
--
--     lua examples/papers/products_2021_fig5.lua [--out DIR] [--mesh FILE] [--quick]
--
-- Writes products_2021_fig5.png (maps, products at n = 5 and 10, differences), products_2021_fig5_error.png (error by n).
--
-- Two points on bodies: each sees the sky past its own body and past three others, four maps of 0 and 1. Maps are cast by camera
-- rays into six faces of a cube, one body at a time, and projected to order n. Products are of these projections: exact to
-- order n ("accurate", by quadrature; the Fourier series agrees to 1e-6), and two at a time, cut off in between ("recursive",
-- which lists of integrals do too). Truth is the product of the maps, which no order holds: even its own projection is off
-- ("cut"). The paper's maps are not published, and its text has none of the figure's numbers; it says that the accurate product
-- is nearer to the truth than the recursive one in all examples. --mesh puts a file of your own in place of the first body.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { out = "out", mesh = "", quick = false }
local quick, folder = option.quick, option.out
local TOP = quick and 6 or 20
local size = quick and { 48, 24 } or { 256, 128 }
local side = quick and 16 or 128

local function body(parameters)
  if option.mesh ~= "" then return ylm.mesh { file = option.mesh, scale = parameters.scale, at = parameters.at } end
  return ylm.knot { divide = quick and { 60, 8 } or { 400, 32 }, scale = parameters.scale, at = parameters.at,
    rotate = { axis = { 1, 0, 0 }, angle = 50 } }
end

--- Where the two points stand, what they see, and the direction that their surface faces.
local examples = {
  { label = "c", at = { 0, 0.02, 0 }, bodies = {
    ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 } },
    body { scale = 0.75, at = { 0.9, 0.6, 0.2 } },
    ylm.torus { radius = 0.7, tube = 0.3, at = { -0.7, 0.6, 0.4 }, rotate = { axis = { 1, 0, 1 }, angle = 60 } },
    ylm.sphere { radius = 0.7, at = { 0.3, 0.7, -0.8 } },
  } },
  { label = "d", at = { 0, 0, 0 }, bodies = {
    ylm.torus { radius = 0.35, tube = 0.3, at = { 0, 0, -0.1 } },
    body { scale = 0.7, at = { 0, 1, 0.4 } },
    ylm.box { bounds = { { 0.4, -0.6, -0.5 }, { 1, 0.9, 0.9 } } },
    ylm.knot { divide = quick and { 60, 8 } or { 300, 24 }, p = 3, q = 2, scale = 0.6, at = { -0.8, 0.3, -0.5 } },
  } },
}

local faces = {
  { { 1, 0, 0 }, { 0, 1, 0 } }, { { -1, 0, 0 }, { 0, 1, 0 } }, { { 0, 1, 0 }, { 0, 0, 1 } }, { { 0, -1, 0 }, { 0, 0, 1 } },
  { { 0, 0, 1 }, { 0, 1, 0 } }, { { 0, 0, -1 }, { 0, 1, 0 } },
}
local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end
local function cross(a, b) return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] } end

local sheet = ylm.image { size = size }
local direction, angle = sheet:directions { up = "y" }
local d = direction:totable()

--- The visibility of the sky past one body: 0 or 1 for each direction.
local function map_of(shape, at)
  local seen, out = {}, {}
  for i, f in ipairs(faces) do
    local to = { at[1] + f[1][1], at[2] + f[1][2], at[3] + f[1][3] }
    local scene = ylm.scene "map" { geometry = { shape }, lights = {},
      camera = ylm.camera { from = at, at = to, up = f[2], fov = 90 } }
    seen[i] = assert(scene:prepare { size = { side, side }, samples = 1 }):render { by = "rays", light_samples = 1 }
    seen[i] = seen[i]:layer "coverage":totable()
  end
  for k, v in ipairs(d) do
    local best, forward = 1, -1
    for i, f in ipairs(faces) do if dot(f[1], v) > forward then best, forward = i, dot(f[1], v) end end
    local f = faces[best]
    local right = cross(f[1], f[2])
    local x = math.floor((1 + dot(right, v) / forward) / 2 * side) + 1
    local y = math.floor((1 - dot(f[2], v) / forward) / 2 * side) + 1
    out[k] = 1 - seen[best][math.min(side, math.max(1, y))][math.min(side, math.max(1, x))][1]
  end
  return ylm.array(out)
end

--- Coefficients to order TOP of values at all directions.
local function project(values)
  return ylm.sh.project(TOP - 1, { directions = direction, values = values, weights = angle })
end

local function multiply(factors, options)
  local list = { (table.unpack or unpack)(factors) } -- luacheck: ignore
  list[#list + 1] = options
  return ylm.sh.product((table.unpack or unpack)(list)) -- luacheck: ignore
end

--- Root of the integral of (f - g)^2 over that of g^2.
local function distance(f, g) return math.sqrt((angle * (f - g) ^ 2):sum() / (angle * g ^ 2):sum()) end

--- The norm of a - b over that of b, coefficients both.
local function apart(a, b)
  return math.sqrt(((a - b) ^ 2):sum() / (b ^ 2):sum())
end

local function rows_of(values) return values:reshape { size[2], size[1] } end

local function difference(a, b) return (a - b):abs() end

local function shown(values, caption, range)
  return { values = rows_of(values), caption = caption, range = range or { 0, 1 }, map = "grey" }
end

local rows, series = {}, {}
local nearer, cases, gain, loss = 0, 0, 0, 0 -- of the accurate product against the recursive one
for _, e in ipairs(examples) do
  local maps, factors, input = {}, {}, {}
  for i, shape in ipairs(e.bodies) do
    maps[i] = map_of(shape, e.at)
    factors[i] = project(maps[i])
    input[i] = shown(maps[i], i == 1 and ("(%s) visibility past its own body"):format(e.label) or ("past body %d"):format(i))
  end
  local truth = maps[1] * maps[2] * maps[3] * maps[4]
  rows[#rows + 1] = input
  local whole = project(truth)
  local line = common.table { { "example", "%-7s" }, { "n", "%3d" }, { "recursive %", "%11.1f" }, { "accurate %", "%10.1f" },
    { "cut of the truth %", "%18.1f" }, { "recursive/accurate", "%18.2f" }, { "coefficients: recursive %", "%25.1f" },
    { "accurate %", "%10.1f" }, { "Fourier - quadrature", "%20.1e" } }
  local x, errors = {}, { recursive = {}, accurate = {}, cut = {} }
  for n = 3, TOP do
    local cut = {}
    for i, c in ipairs(factors) do cut[i] = ylm.sh.resize(c, n - 1) end
    local exact, recursive = multiply(cut, { method = "quadrature" }), multiply(cut, { method = "recursive" })
    local kept = ylm.sh.resize(whole, n - 1)
    local f = { ylm.sh.reconstruct(recursive, direction), ylm.sh.reconstruct(exact, direction),
      ylm.sh.reconstruct(kept, direction) }
    local r, a, c = distance(f[1], truth), distance(f[2], truth), distance(f[3], truth)
    local fourier = multiply(cut, { method = "fourier", dtype = "float" })
    nearer, cases = nearer + (a < r and 1 or 0), cases + 1
    gain, loss = math.max(gain, 1 - a / r), math.max(loss, a / r - 1)
    x[#x + 1] = n
    table.insert(errors.recursive, 100 * r)
    table.insert(errors.accurate, 100 * a)
    table.insert(errors.cut, 100 * c)
    if n == 5 or n == 10 or n == TOP or n == 3 then
      line { e.label, n, 100 * r, 100 * a, 100 * c, r / a, 100 * apart(recursive, kept), 100 * apart(exact, kept),
        apart(fourier, exact) }
    end
    if n == 5 or n == 10 then
      rows[#rows + 1] = { shown(f[1], ("n = %d, recursive: %.0f %%"):format(n, 100 * r)),
        shown(f[2], ("n = %d, accurate: %.0f %%"):format(n, 100 * a)), shown(truth, "product of the maps"),
        shown(difference(f[1], truth), "recursive - truth"), shown(difference(f[2], truth), "accurate - truth") }
    end
  end
  for _, name in ipairs { "recursive", "accurate", "cut" } do
    local label = name == "cut" and "the truth, cut at n" or name
    series[#series + 1] = { x = x, y = errors[name], label = ("(%s) %s"):format(e.label, label) }
  end
end

common.save(ylm.figure { title = "Products of four visibility maps", rows = rows,
  caption = "Maps of the whole sphere, latitude over longitude, the zenith on top; 0 black, 1 white. Percents: root mean square "
    .. "over the sphere, relative to the product of the maps." }, folder .. "products_2021_fig5.png")
common.save(ylm.plot { series = series, title = "Products of four visibility maps", x_label = "SH order n",
  legend = "top right",
  y_label = "error against the product of the maps, %" }, folder .. "products_2021_fig5_error.png")
print "Percents are root mean square over the sphere, relative to the product of the maps."
print(("The accurate product is nearer than the recursive one in %d of %d cases, by %.1f %% at most, farther by %.1f %% at most: "
  .. "these maps\nare 0 or 1, so that a product is near to each of its factors where it is not 0. All three keep what n cuts of "
  .. "the maps, which is\nmost of the error. The paper names no numbers for its two examples; those of random coefficients are "
  .. "in Table 1."):format(nearer, cases, 100 * gain, 100 * loss))
