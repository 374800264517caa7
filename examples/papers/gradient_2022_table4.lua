-- Mezieres et al. 2022 (gradient), Table 4 (with Fig. 12) and Fig. 16: pictures under a square light that is cut into
-- triangles, each replaced by a sphere or by a sphere times |cos gamma|, against the exact triangles.
--
--     lua examples/papers/gradient_2022_table4.lua [folder for pictures] [quick]
--
-- The paper's pictures show an Armadillo and a Buddha (288, 512, 800 lights) and a white room (722) on a GPU; its
-- scenes, lights and material are not published. Here: a knot and a ball in a corner of a room, the same numbers of
-- triangles (2 n^2 of a square), 5 bands, no visibility as there, diffuse surfaces throughout. So magnitudes are what
-- can be compared, not digits: MAE of radiance, times 1000, where the largest value is 1. Bare spheres are off by about
-- 1 - |cos gamma|, which is the layout's and nothing else's; the factor's gain is what the paper claims ("two orders").
-- "interp." is an 8^3 grid, by Hermite, against exact triangles in the same grid.

local ylm = require "ylm"

local folder, quick = arg and arg[1] or ".", arg and arg[2] == "quick"
local size = quick and { 40, 30 } or { 240, 180 }

--- 2 nx ny triangles of a square of edge 1.6 above the corner, facing down and towards it, as corners.
local function triangles(nx, ny)
  local list = {}
  local function p(s, t) return { -0.8 + 1.6 * s, 2.3 + 0.5 * t, 0.2 + 1.5 * t } end
  for i = 0, nx - 1 do
    for j = 0, ny - 1 do
      local function q(a, b) return p((i + a) / nx, (j + b) / ny) end
      list[#list + 1] = { q(0, 0), q(1, 0), q(0, 1) }
      list[#list + 1] = { q(1, 0), q(1, 1), q(0, 1) }
    end
  end
  return list
end

--- What replaces triangles: "exact", "sphere" (times |cos gamma|) or "bare" (the sphere alone).
local function lights(list, method)
  local out = {}
  for i, v in ipairs(list) do
    if method == "bare" then
      local at, u, w = {}, {}, {}
      for a = 1, 3 do
        at[a] = (v[1][a] + v[2][a] + v[3][a]) / 3
        u[a], w[a] = v[2][a] - v[1][a], v[3][a] - v[1][a]
      end
      local n = { u[2] * w[3] - u[3] * w[2], u[3] * w[1] - u[1] * w[3], u[1] * w[2] - u[2] * w[1] }
      local area = math.sqrt(n[1] ^ 2 + n[2] ^ 2 + n[3] ^ 2) / 2
      out[i] = ylm.sphere_light { at = at, radius = math.sqrt(area / math.pi), radiance = 3 }
    else out[i] = ylm.polygon_light { vertices = v, method = method, radiance = 3 } end
  end
  return out
end

local white, red = ylm.matte { albedo = 0.7 }, ylm.matte { albedo = { 0.6, 0.2, 0.1 } }
local geometry = {
  ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -3.5 }, material = white },
  ylm.quad { corner = { -2, 0, -1.5 }, u = { 4, 0, 0 }, v = { 0, 3, 0 }, material = white },
  ylm.knot { at = { -0.5, 0.62, 0 }, scale = 0.3, material = red },
  ylm.sphere { at = { 0.75, 0.4, 0.2 }, radius = 0.4, material = white },
}

local probes = ylm.uniform_grid { cells = { 7, 7, 7 }, lmax = 4 }

--- The picture without interpolation and, with `grid`, the one by an 8^3 grid.
local function pictures(list, method, lmax, grid)
  local scene = ylm.scene "square of triangles" {
    camera = ylm.camera { from = { 0.3, 1.3, 3.4 }, at = { 0, 0.6, 0 }, fov = 42 },
    geometry = geometry, lights = lights(list, method), probes = probes,
  }
  local view = scene:prepare { size = size, samples = quick and 1 or 4, lmax = lmax, visibility = "none" }
  local exact = view:reference { layers = false }
  return exact, grid and (view:render { grid = scene:bake { occupied = "everywhere" }, layers = false })
end

--- 1000 times the mean absolute error where the largest value of the truth is 1.
local function mae(image, truth)
  local m = image:compare(truth)
  return 1000 * m.mae / m.peak
end

local function show(image, name, peak)
  local ok, message = image:save(folder .. "/" .. name, { exposure = -math.log(peak) / math.log(2), tone = "srgb" })
  print(ok and "wrote " .. name or "no picture: " .. tostring(message))
end

local printed = {
  [288] = { 15.86, 0.096, 15.93, 0.215 }, [512] = { 15.76, 0.068, 15.83, 0.165 },
  [800] = { 15.67, 0.121, 15.75, 0.174 }, [722] = { 62.08, 0.129, 62.13, 0.176 },
}

print "Table 4: MAE x 1000 against exact triangles (paper's figure behind)"
print "  lights           spheres   triangles approx.    spheres interp.    approx. interp."
for _, n in ipairs(quick and { 4 } or { 12, 16, 20, 19 }) do
  local list = triangles(n, n)
  local truth, truth_grid = pictures(list, "exact", 4, true)
  local bare, bare_grid = pictures(list, "bare", 4, true)
  local rough, rough_grid = pictures(list, "sphere", 4, true)
  local row = { mae(bare, truth), mae(rough, truth), mae(bare_grid, truth_grid), mae(rough_grid, truth_grid) }
  local p = printed[#list] or {}
  for i = 1, 4 do row[i] = ("%9.3f (%s)"):format(row[i], p[i] and ("%.3f"):format(p[i]) or "-") end
  print(("%8d %s"):format(#list, table.concat(row, " ")))
  if n == 19 or quick then
    local peak = truth:compare(truth).peak
    show(truth, "gradient_2022_fig12_exact.png", peak)
    show(bare:difference(truth, { scale = 100 }), "gradient_2022_fig12_spheres_x100.png", peak)
    show(rough:difference(truth, { scale = 100 }), "gradient_2022_fig12_approximation_x100.png", peak)
  end
end

print "Fig. 16: 36 triangles, by bands: MAE x 1000 of the approximation (the paper: about the same from 5 to 9 bands)"
local few = triangles(6, 3)
for bands = 1, quick and 3 or 9 do
  local truth, rough = pictures(few, "exact", bands - 1), pictures(few, "sphere", bands - 1)
  print(("%3d bands %9.3f"):format(bands, mae(rough, truth)))
end
