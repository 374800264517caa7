-- Mezieres et al. 2022 (gradient), Figs. 15 and 17: triangles approximated by spheres times |cos gamma|, by number of
-- triangles, by band, by shape and by size, as coefficients. Pictures, those of Fig. 17 too: gradient_2022_table4.lua.
--
--     lua examples/papers/gradient_2022_triangles.lua [--out DIR] [--quick]
--
-- A square light of edge 2 in the plane y = 2, cut into triangles, seen from points below. "Sphere" is the
-- sphere alone, "times cos" the paper's Eq. 26; both against the exact polygon.

local ylm = require "ylm"
local here = arg[0]:match "^(.*/)" or "./"
local common, triangles = dofile(here .. "../common.lua"), dofile(here .. "triangles_2022.lua")

local option = common.options { out = "out", quick = false }
local out, quick = option.out, option.quick

local points = {}
for i = 0, quick and 2 or 5 do
  for j = 0, quick and 2 or 5 do points[#points + 1] = { -1.5 + 3 * i / 5, -0.5 + 0.2 * ((i + j) % 3),
    -1.5 + 3 * j / 5 } end
end
points = ylm.array(points)

--- 2 n^2 triangles of the square.
local function square(n)
  return triangles.cut(n, n, function(x, z) return { -1 + 2 * x, 2, -1 + 2 * z } end)
end

--- The field of triangles at points by a method: "exact", "sphere" (times cos) or "bare".
local function field(list, method, lmax, at)
  return ylm.light_field(lmax, triangles.lights(list, method, 1), at or points, { channels = "luminance", dtype = "double" })
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
  local list = square(n)
  local exact = field(list, "exact", 4)
  local a, b = error_of(field(list, "bare", 4), exact), error_of(field(list, "sphere", 4), exact)
  x[#x + 1], bare[#bare + 1], cosine[#cosine + 1] = #list, a, b
  print(("%11d %11.2e %11.2e %8.0f"):format(#list, a, b, a / b))
end
common.save(ylm.plot { series = { { x = x, y = bare, label = "sphere" }, { x = x, y = cosine,
  label = "times |cos|" } },
  log = true, legend = "bottom left",
  title = "A square light of triangles", x_label = "triangles", y_label = "relative L2 error" },
  out .. "gradient_2022_triangles.png")

-- Fig. 15: per band, over the plane that the square lights, and one coefficient along a line of it.
local list = square(quick and 3 or 12)
local n = quick and 3 or 12
local plane = {}
for i = 0, n do
  for j = 0, n do plane[#plane + 1] = { -2 + 4 * i / n, 0, -2 + 4 * j / n } end
end
plane = ylm.array(plane, "double")
--- Absolute errors summed over the coefficients of each band, mean over the plane; and those of the coefficients.
local function by_band(lights)
  local exact, rough, errors, sizes = field(lights, "exact", 9, plane), field(lights, "sphere", 9, plane), {}, {}
  for l = 0, 9 do
    local sum, size = 0, 0
    for i = 1, #plane do
      for k = l * l + 1, (l + 1) ^ 2 do
        sum = sum + math.abs(exact:get(i, 1, k) - rough:get(i, 1, k))
        size = size + math.abs(exact:get(i, 1, k))
      end
    end
    errors[l + 1], sizes[l + 1] = sum / #plane, size / #plane
  end
  return errors, sizes
end

-- The paper prints 1e-8, growing as the square of the band, for lights that it does not describe. One small triangle has
-- both. Its second moments are not the sphere's. Y's second derivatives turn them into errors that grow with l on top
-- of the solid angle's, and a band has 2l+1 coefficients. In pairs that make up squares the second moments cancel; what
-- is left of many triangles is the solid angle's, and grows as 2l+1 does.
local of_one = by_band { triangles.equilateral(0.05, 0, 2, 0) }
local of_square, sizes = by_band(list)
print(("Fig. 15d: by band (absolute errors summed over a band, mean over the plane below; radiance 1; the paper: 1e-8)\n"
  .. "          triangle of edge 0.05   %d triangles of a square   relative to the band"):format(#list))
local bands, square_law = {}, {}
for b = 1, 10 do
  bands[b], square_law[b] = b, of_one[1] * b * b
  print(("%3d. band %22.2e %26.2e %22.2e"):format(b, of_one[b], of_square[b], of_square[b] / sizes[b]))
end
print(("band 10 over band 1: %.0f for the one triangle (the square of the band: 100), %.0f for %d"):format(
  of_one[10] / of_one[1], of_square[10] / of_square[1], #list))
common.save(ylm.plot { log = true, legend = "top left", x_label = "band",
  series = { { x = bands, y = of_square, label = ("%d triangles of a square of edge 2"):format(#list) },
    { x = bands, y = of_one, label = "one triangle of edge 0.05" },
    { x = bands, y = square_law, label = "square of the band", dash = "dashed", marker = "none" } },
  y_label = "absolute error of a band, summed", title = "Triangles by spheres times |cos|: error by band",
  y_range = { 1e-9, 1 }, caption = "mean over the plane 2 below, radiance 1" },
  out .. "gradient_2022_fig15d.png")
local along, line = {}, {}
for i = 0, 60 do
  along[i + 1] = -3 + i / 10
  line[i + 1] = { along[i + 1], 0, 0.7 }
end
local coarse, series = square(2), {}
for _, method in ipairs { "exact", "sphere", "bare" } do
  local L, y = field(coarse, method, 4, line), {}
  for i = 1, #line do y[i] = L:get(i, 1, ylm.sh.index(4, 2)) end
  series[#series + 1] = { x = along, y = y, marker = "none", dash = method == "sphere" and "dashed" or "solid",
    label = ({ exact = "exact triangles", sphere = "sphere times |cos|", bare = "sphere alone" })[method] }
end
common.save(ylm.plot { series = series, x_label = "x on a line of the plane (scene units)",
  y_label = "coefficient (4, 2)", title = "One coefficient of 8 triangles and of what replaces them" },
  out .. "gradient_2022_fig15bc.png")

print "Fig. 17: by shape (one triangle of area 0.1 stretched; relative L2, lmax 4)"
for _, stretch in ipairs { 1, 2, 4, 8, 16 } do
  local t = { triangles.stretched(0.1, stretch, 0, 2, 0) }
  print(("%6d : 1 %11.2e"):format(stretch, error_of(field(t, "sphere", 4), field(t, "exact", 4))))
end

print "Fig. 17: by size (one equilateral triangle; relative L2, lmax 4)"
for _, edge in ipairs { 0.05, 0.1, 0.2, 0.5, 1, 2 } do
  local t = { triangles.equilateral(edge, 0, 2, 0) }
  print(("%8.2f %11.2e"):format(edge, error_of(field(t, "sphere", 4), field(t, "exact", 4))))
end
