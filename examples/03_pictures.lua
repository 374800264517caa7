-- Every kind of picture that ylm.view, ylm.plot and ylm.figure make, of one small scene.
--
--     ylm run examples/03_pictures.lua [--out out/pictures] [--only NAME]
--
-- Metres, degrees, W sr^-1 m^-2; y is up.

local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "common.lua")
local option = common.options { out = "out/pictures", only = "" }
local out = option.out

--- Draws a picture, unless another one is wanted alone.
local function save(picture, name)
  if option.only == "" or option.only == name then common.save(picture, out .. name .. ".png") end
end

-- A knot over a floor, and a spiral of lamps that nearly touch it ------------------

local at, radiance = common.spiral(600, 0.1, 0.06, 0.02, 6, 5)
local lamps = ylm.sphere_lights { at = at, radius = 0.02, radiance = radiance }
local knot = ylm.knot { at = { 0, 1.15, 0 }, radius = 0.62, tube = 0.17, divide = { 600, 48 } }
local floor = ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 },
  material = ylm.matte { albedo = 0.4 } }
local scene = ylm.scene "A knot over lamps" {
  camera = ylm.camera { from = { 3.9, 2.4, 4.6 }, at = { 0, 0.55, 0 }, fov = 38 },
  geometry = { floor, knot },
  lights = lamps,
}

local places = {}
for i = 0, 90 do for j = 0, 90 do places[#places + 1] = { -3 + i / 15, 0, -3 + j / 15 } end end
local on_knot = knot.mesh:vertices()[{ 9, -1, 9 }]
local points = ylm.zeros { #places + #on_knot, 3 }
points[{ 1, #places }] = places
points[{ #places + 1, -1 }] = on_knot
local grid_bounds = { { -3.1, -0.1, -3.1 }, { 3.1, 2.6, 3.1 } }
local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = grid_bounds, lmax = 4, depth = 6, metric = "relative",
  threshold = 6 }, lamps, { occupied = points }))

-- The grid -----------------------------------------------------------------------------------

save(ylm.view { grid, quantity = "error", volume = true, levels = true, slices = { axis = "y", at = 0 }, lights = lamps,
  meshes = { { knot, opacity = 0.25 } }, title = "Hessian error of the adaptive grid",
  caption = "Estimate of each leaf: cloud, slice through the floor, wireframe of the levels; lamps in their colours." },
  "hessian_error")
save(ylm.view { grid, quantity = "error", boxes = { occupied = true }, background = "white",
  title = "Leaves that hold shading points" }, "boxes")
save(ylm.view { grid, quantity = "level", levels = { occupied = true }, title = "Levels of the octree" }, "levels")
save(ylm.view { grid, glyphs = { count = 2500 }, lights = lamps, title = "Gradient of the light field",
  caption = "Arrows point to more light; length and colour grow with the magnitude." }, "gradients")
save(ylm.view { grid, streamlines = { count = 250 }, lights = lamps, title = "Streamlines of ∇L₀₀" }, "streamlines")
save(ylm.view { grid, lobes = { count = 220 }, lights = lamps, title = "What the probes remember, lmax 4",
  caption = "Radius |L(ω)|, each scaled to its largest value. Orange: positive. Blue: negative." }, "lobes")
local whole = assert(ylm.bake(ylm.uniform_grid { bounds = grid_bounds, cells = { 32, 16, 32 }, lmax = 2 }, lamps))
save(ylm.view { whole, quantity = "norm", isosurfaces = { 0.5, 1, 2, 4 }, range = { 0.3, 5 }, background = "white",
  title = "Surfaces of equal ‖L‖" }, "isosurfaces")
save(ylm.view { whole, quantity = "L00", slices = { { axis = "y", at = 0.3 }, { axis = "x", at = 0 } },
  title = "L₀₀ on two planes" }, "slices")
assert(grid:save(out .. "grid.vtu"))

-- Spherical harmonics beside each other --------------------------------------------------------

local basis, labels = {}, {}
for l = 0, 3 do
  for m = -l, l do
    local c = {}
    for i = 1, 16 do c[i] = 0 end
    c[ylm.sh.index(l, m)] = 1
    basis[#basis + 1], labels[#labels + 1] = c, ("l = %d, m = %d"):format(l, m)
  end
end
save(ylm.view { sh = basis, labels = labels, title = "Real spherical harmonics up to degree 3" }, "basis")

-- A plot -----------------------------------------------------------------------------------------

local n, uniform, adaptive = {}, {}, {}
for i = 1, 12 do n[i], uniform[i], adaptive[i] = 2 ^ (i + 5), 3 * 2 ^ (-i / 3), 2 * 2 ^ (-i) end
save(ylm.plot { log = true, x_label = "grid points", y_label = "relative error", title = "Slopes of -1/3 and -1",
  legend = "bottom left",
  series = { { x = n, y = uniform, label = "uniform" }, { x = n, y = adaptive, label = "adaptive" } } },
  "plot")

-- A figure: three views by the scene's own camera, wiped into one ---------------------------------

local panels = {
  ylm.view { scene = scene, lights = true, bar = false },
  ylm.view { grid, scene = scene, lights = true, quantity = "level", levels = { occupied = true }, bar = false },
  ylm.view { grid, scene = scene, opacity = 0.3, quantity = "error", volume = true, bar = false, frame = false },
}
local crop = { 560, 300, 200, 112 }
save(ylm.figure {
  background = "dark", title = "One camera, three views",
  rows = {
    { { wipe = panels, labels = { "surfaces", "octree", "Hessian error" }, mark = crop } },
    { { image = panels[1], crop = crop, caption = "surfaces" }, { image = panels[2], crop = crop, caption = "octree" },
      { image = panels[3], crop = crop, caption = "Hessian error" } },
  },
}, "figure")
