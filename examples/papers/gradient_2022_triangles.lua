-- Mezieres et al. 2022 (gradient), Figs. 15 and 17: triangles approximated by spheres times |cos gamma|, by number of
-- triangles, by band, by shape and by size, as coefficients. Pictures: gradient_2022_table4.lua.
--
--     lua examples/papers/gradient_2022_triangles.lua [folder for pictures] [quick]
--
-- A square light of edge 2 in the plane y = 2, cut into triangles, seen from points below. "Sphere" is the
-- sphere alone, "times cos" the paper's Eq. 26; both against the exact polygon.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local folder, quick = common.folder(arg[1] or "."), arg[2] == "quick"

local points = {}
for i = 0, quick and 2 or 5 do
  for j = 0, quick and 2 or 5 do points[#points + 1] = { -1.5 + 3 * i / 5, -0.5 + 0.2 * ((i + j) % 3),
    -1.5 + 3 * j / 5 } end
end
points = ylm.array(points)

--- 2 n^2 triangles of the square.
local function triangles(n)
  local list = {}
  for i = 0, n - 1 do
    for j = 0, n - 1 do
      local function p(a, b) return { -1 + 2 * (i + a) / n, 2, -1 + 2 * (j + b) / n } end
      list[#list + 1] = { p(0, 0), p(1, 0), p(0, 1) }
      list[#list + 1] = { p(1, 0), p(1, 1), p(0, 1) }
    end
  end
  return list
end

--- The field of triangles by a method: "exact", "sphere" (times cos) or "bare".
local function field(list, method, lmax)
  local lights = {}
  for i, v in ipairs(list) do
    if method == "bare" then
      local at, u, w = {}, {}, {}
      for a = 1, 3 do
        at[a] = (v[1][a] + v[2][a] + v[3][a]) / 3
        u[a], w[a] = v[2][a] - v[1][a], v[3][a] - v[1][a]
      end
      local n = { u[2] * w[3] - u[3] * w[2], u[3] * w[1] - u[1] * w[3], u[1] * w[2] - u[2] * w[1] }
      local area2 = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2)
      lights[i] = ylm.sphere_light { at = at, radius = math.sqrt(area2 / (2 * math.pi)), radiance = 1 }
    else lights[i] = ylm.polygon_light { vertices = v, method = method } end
  end
  return ylm.light_field(lmax, lights, points, { channels = "luminance", dtype = "double" })
end

--- Mean over the points of the relative L2 error.
local function error_of(a, b)
  local e, sum = ylm.sh.relative_error(a, b), 0
  for i = 1, #points do sum = sum + e[i] end
  return sum / #points
end

print "number of triangles (lmax 4, relative L2 error of the coefficients)"
print "  triangles      sphere   times cos     gain"
local x, bare, cosine = {}, {}, {}
for _, n in ipairs(quick and { 1, 4 } or { 1, 2, 4, 8, 12 }) do
  local list = triangles(n)
  local exact = field(list, "exact", 4)
  local a, b = error_of(field(list, "bare", 4), exact), error_of(field(list, "sphere", 4), exact)
  x[#x + 1], bare[#bare + 1], cosine[#cosine + 1] = #list, a, b
  print(("%11d %11.2e %11.2e %8.0f"):format(#list, a, b, a / b))
end
local ok, message = ylm.plot { series = { { x = x, y = bare, label = "sphere" }, { x = x, y = cosine,
  label = "times |cos|" } },
  log = true, legend = "bottom left",
  title = "A square light of triangles", x_label = "triangles", y_label = "relative L2 error" }
  :save(folder .. "/gradient_2022_triangles.png")
print(ok and "wrote gradient_2022_triangles.png" or "no picture: " .. tostring(message))

-- Fig. 15: per band, over the plane that the square lights, and one coefficient along a line of it.
local list = triangles(quick and 3 or 12)
local n = quick and 3 or 12
local plane = {}
for i = 0, n do
  for j = 0, n do plane[#plane + 1] = { -2 + 4 * i / n, 0, -2 + 4 * j / n } end
end
plane = ylm.array(plane, "double")
local everywhere = points
points = plane
local exact, rough = field(list, "exact", 9), field(list, "sphere", 9)
points = everywhere
print(("by band (%d triangles; mean absolute error of a coefficient over the plane below)"):format(#list))
print "  the paper prints 1e-8 for lights of unknown radiance, growing as the square of the band; here radiance is 1"
local bands, errors = {}, {}
for l = 0, 9 do
  local sum, size = 0, 0
  for i = 1, #plane do
    for k = l * l + 1, (l + 1) ^ 2 do
      sum = sum + math.abs(exact:get(i, 1, k) - rough:get(i, 1, k))
      size = size + math.abs(exact:get(i, 1, k))
    end
  end
  bands[l + 1], errors[l + 1] = l + 1, sum / #plane / (2 * l + 1)
  print(("%3d. band %10.2e  relative to the band's own mean %9.2e"):format(l + 1, errors[l + 1], sum / size))
end
local scaled = {}
for i, e in ipairs(errors) do scaled[i] = 1e5 * e end
local function report(name, saved, why)
  print(saved and ("wrote %s"):format(name) or ("no picture: %s"):format(tostring(why)))
end
report("gradient_2022_fig15d.png", ylm.plot { x = bands, y = scaled, x_label = "band", y_range = { 0, 10 },
  y_label = "mean absolute error of a coefficient, times 1e5", title = "Triangles by spheres times |cos|: error by band",
  caption = ("%d triangles of a square of edge 2, on the plane 2 below"):format(#list) }
  :save(folder .. "/gradient_2022_fig15d.png"))
local along, line = {}, {}
for i = 0, 60 do
  along[i + 1] = -3 + i / 10
  line[i + 1] = { along[i + 1], 0, 0.7 }
end
points = ylm.array(line, "double")
local coarse, series = triangles(2), {}
for _, method in ipairs { "exact", "sphere", "bare" } do
  local L, y = field(coarse, method, 4), {}
  for i = 1, #line do y[i] = L:get(i, 1, ylm.sh.index(4, 2)) end
  series[#series + 1] = { x = along, y = y, marker = "none", dash = method == "sphere" and "dashed" or "solid",
    label = ({ exact = "exact triangles", sphere = "sphere times |cos|", bare = "sphere alone" })[method] }
end
points = everywhere
report("gradient_2022_fig15bc.png", ylm.plot { series = series, x_label = "x on a line of the plane (scene units)",
  y_label = "coefficient (4, 2)", title = "One coefficient of 8 triangles and of what replaces them" }
  :save(folder .. "/gradient_2022_fig15bc.png"))

print "Fig. 17: by shape (one triangle of area 0.1 stretched; relative L2, lmax 4)"
for _, stretch in ipairs { 1, 2, 4, 8, 16 } do
  local h = math.sqrt(0.2 / stretch)
  local t = { { { -h * stretch / 2, 2, 0 }, { h * stretch / 2, 2, 0 }, { 0, 2, h } } }
  print(("%6d : 1 %11.2e"):format(stretch, error_of(field(t, "sphere", 4), field(t, "exact", 4))))
end

print "Fig. 17: by size (one equilateral triangle; relative L2, lmax 4)"
for _, edge in ipairs { 0.05, 0.1, 0.2, 0.5, 1, 2 } do
  local t = { { { -edge / 2, 2, 0 }, { edge / 2, 2, 0 }, { 0, 2, edge * math.sqrt(3) / 2 } } }
  print(("%8.2f %11.2e"):format(edge, error_of(field(t, "sphere", 4), field(t, "exact", 4))))
end
