-- Xin et al. 2021, Table 2. Rows "PRT": frames a second of a glossy scene whose light, materials and view change in every
-- frame. Rows "SF": frames a second of shadow fields, whose casters move.
--
--     lua examples/papers/products_2021_table2.lua [--threads 2] [--frames 20] [--lamps 0] [--mesh FILE] [--casters 8] [--quick]
--
-- A frame is the shading pass over all vertices: slices of the materials towards the new camera (rows of tables, turned to the
-- world), times visibility, times the light there. Products are by ylm's quadrature, by Fourier series ("Our acc.") and by a
-- list of all integrals ("Trad."), in one run: the same vertices, materials, cameras and lights. The paper's GPU draws the
-- picture besides, which "drawn" adds here: camera rays of 640 x 480 pixels, one each.
--
-- The paper's meshes, lights and materials are not published: bodies here have as many vertices (--mesh takes a file of your own,
-- whose vertices then count). Light is an environment that turns; --lamps 4 adds lamps that circle. Materials are metals,
-- mixtures of two functions, so each vertex takes two products; tables are made before the first frame, as the paper's are. "by
-- CPU" is the threads over the processor time of a frame: frames a second on as many cores that do nothing else.

--
-- Rows "SF" shade as many points of a floor as the paper's scene has vertices, behind --casters balls (the paper does not say
-- how many bodies its scenes have), in light of an environment: at every point, as the paper does ("one rule", "recursive",
-- "accurate"), and at probes, which are baked anew in each frame, like those of the frame before ("probes"). At most 30,000
-- points are measured; fps is for all. --rows SF or PRT makes these alone.

local core = require "ylm.c.core"
local ylm = require "ylm"
local common = dofile((arg[0]:match "^(.*/)" or "./") .. "../common.lua")

local option = common.options { threads = 2, frames = 20, mesh = "", rays = 256, lamps = 0, casters = 8, rows = "",
  quick = false }
local quick = option.quick
ylm.on_warning(false) -- of lobes that the degree is too low for

local rows = {
  { "Lucy", 69994, 10, 14.9, 26.4, 92, 85 },
  { "Dragon & Bunny", 36613, 15, 3.0, 25.5, 98, 87 },
  { "Plants & Teapot", 34213, 15, 3.2, 26, 98, 87 },
}

--- A disk on the floor with so many vertices, as a fan.
local function fan(vertices, radius, material)
  local v, t = { { 0, -1, 0 } }, {}
  for i = 1, vertices - 1 do
    local a = 2 * math.pi * i / (vertices - 1)
    v[i + 1] = { radius * math.cos(a), -1, radius * math.sin(a) }
    t[i] = { 1, i % (vertices - 1) + 2, i + 1 }
  end
  return ylm.mesh { vertices = v, triangles = t, material = material }
end

local function metal(i)
  local warm = 0.5 + 0.5 * math.sin(i)
  return ylm.ggx { alpha = 0.4 + 0.05 * (i % 5), f0 = { 0.95, 0.6 + 0.3 * warm, 0.3 + 0.5 * warm } }
end
local metals = {}
for i = 1, quick and 2 or 8 do metals[i] = metal(i) end

--- A body of about so many vertices and a floor that has the rest.
local function scene_of(vertices)
  local geometry
  if option.mesh ~= "" then geometry = { ylm.mesh { file = option.mesh, material = metals[1] }, fan(64, 2.5, metals[2]) }
  else
    local across = math.floor(math.sqrt(vertices / 18))
    local along = math.floor((vertices - 64) / across)
    geometry = {
      ylm.knot { divide = { along - 1, across - 1 }, scale = 0.8, rotate = { axis = { 1, 0, 0 }, angle = 20 },
        material = metals[1] },
      fan(vertices - along * across, 2.5, metals[2]),
    }
  end
  return ylm.scene "table 2" { geometry = geometry, camera = ylm.camera { from = { 0, 1.5, 4 }, fov = 40 },
    lights = { ylm.environment_light { radiance = 0.5 } } }
end

--- Coefficients of an environment: a bright window, a warm ground, waves between.
local function environment(lmax)
  return ylm.sh.project(lmax, function(x, y, z)
    local window = math.exp(12 * (0.6 * x + 0.7 * y + 0.39 * z - 1))
    local ground = math.max(0, -y)
    return 6 * window + 0.3 * ground + 0.1, 5.5 * window + 0.2 * ground + 0.12, 5 * window + 0.1 * ground + 0.16 + 0.05 * z
  end)
end

--- Everything that changes in frame f.
local function frame(f, sky)
  local a, lamps = 0.05 * f, {}
  for i = 1, option.lamps do
    local b = 1.6 * i - 2 * a
    lamps[i] = ylm.sphere_light { at = { 2.5 * math.cos(b), 1 + 0.5 * math.sin(3 * b), 2.5 * math.sin(b) }, radius = 0.3,
      radiance = { 8, 7, 6 } }
  end
  return {
    camera = ylm.camera { from = { 4 * math.sin(a), 1.5, 4 * math.cos(a) }, fov = 40 },
    materials = { metals[f % #metals + 1], metals[(f + 3) % #metals + 1] },
    grid = { ylm.environment_light { coefficients = ylm.sh.rotate(sky, { axis = { 0, 1, 0 }, angle = a }) }, lamps },
    threads = option.threads,
  }
end

--- Frames a second of `count` frames by view[method], by the clock and by processor time, and the shares of stages.
local function measure(view, sky, product, count, method)
  local sums, clock, processor = {}, 0, 0
  for f = 0, count do -- the first one makes plans
    local o = frame(f, sky)
    o.product = product
    if method == "render" then o.layers = false end
    local start, began = core.seconds(), os.clock()
    local _, report = assert(view[method](view, o))
    if f > 0 or count == 0 then
      clock, processor = clock + core.seconds() - start, processor + os.clock() - began
      for stage, s in pairs(report.stages) do sums[stage] = (sums[stage] or 0) + s end
    end
  end
  local busy, frames = 0, math.max(1, count)
  for _, s in pairs(sums) do busy = busy + s end
  for stage, s in pairs(sums) do sums[stage] = 100 * s / busy end
  return frames / clock, frames * option.threads / processor, sums
end

local function prt()
  local line = common.table { { "scene", "%-16s" }, { "vertices", "%8d" }, { "n", "%3d" }, { "product", "%-8s" },
    { "fps", "%8.2f" }, { "by CPU", "%8.2f" }, { "product %", "%9.0f" }, { "rows", "%5.0f" }, { "turn", "%5.0f" },
    { "light", "%5.0f" },
    { "dot", "%5.0f" }, { "paper fps (%)", "%-13s" }, { "fps/paper", "%9.2f" } }
  if quick then table.remove(rows, 2) end
  for _, row in ipairs(rows) do
    local name, vertices, n, list_fps, own_fps, list_share, own_share = row[1], row[2], row[3], row[4], row[5], row[6], row[7]
    if quick then vertices, n = math.floor(vertices / 100), math.floor(n / 2) end
    local scene, sky = scene_of(vertices), environment(n - 1)
    local view = assert(scene:prepare { relight = "all", size = quick and { 16, 12 } or { 640, 480 }, samples = 1, lmax = n - 1,
      occlusion_distance = math.huge, transfer_samples = quick and 16 or option.rays, threads = option.threads })
    local points = view.stats.points
    for i = 1, #metals, 2 do -- tables, which materials keep
      assert(view:radiance { grid = scene.lights[1], materials = { metals[i], metals[i + 1] }, threads = option.threads })
    end
    local function show(product, count, paper, share)
      local drawn = product == "drawn"
      local fps, by_processor, s = measure(view, sky, drawn and "auto" or product, count, drawn and "render" or "radiance")
      line { name, points, n, product == "auto" and "ylm" or product, fps, by_processor, s.product, s.rows, s.rotation, s.light,
        s.dot, ("%.1f (%d)"):format(paper, share), fps / paper }
    end
    show("auto", quick and 1 or option.frames, own_fps, own_share)
    show("drawn", quick and 1 or option.frames, own_fps, own_share)
    show("fourier", quick and 0 or 2, own_fps, own_share)
    show("list", 0, list_fps, list_share)
  end
  print "Shares of stages are of the time of all threads. The paper's frames are of its graphics card; on one processor, list"
  print "over Fourier is what its method gains, and Fourier over ylm what products by quadrature, sixteen at a time, gain on it."
end

-- Shadow fields ----------------------------------------------------------------------------------

local moving = {
  { "Spider & Scorpion", 30238, 10, 12, 13.8, 24 }, { "Ball & DNA", 24410, 15, 1.4, 6.3, 13 },
  { "Chess board", 14018, 15, 2.6, 11.2, 24 }, { "Dragon in Hall", 335823, 15, 0.1, 0.5, 0.9 },
  { "Spheres", 73753, 10, 4.9, 5.7, 9.4 }, { "Spheres", 73753, 15, 0.4, 2.1, 4.3 },
}
local MEASURED = 30000

--- Points of a floor 6 m wide.
local function floor_points(count)
  local list, side = {}, math.ceil(math.sqrt(count))
  for i = 0, count - 1 do list[i + 1] = { 6 * (i % side) / side - 3, 0, 6 * math.floor(i / side) / side - 3 } end
  return ylm.array(list, "float")
end

--- Places of the casters in a frame.
local function balls(f)
  local at = {}
  for i = 1, option.casters do
    local a = 2 * math.pi * i / option.casters + 0.02 * f
    at[i] = { 1.6 * math.cos(a), 0.7 + 0.2 * math.sin(3 * a), 1.6 * math.sin(a) }
  end
  return at
end

--- Seconds of a frame by the clock and of its processor time, the least of `frames`, and probes.
local function frame_of(shade, n, points, probes, frames)
  local least, least_cpu, grid = math.huge, math.huge, nil
  for f = 0, frames do
    local start, began = core.seconds(), os.clock()
    shade:move { balls = { at = balls(f) } }
    if probes then
      if grid then assert(grid:update(shade, { octree = "follow", threads = option.threads }))
      else
        grid = assert(ylm.bake(ylm.adaptive_grid { lmax = n - 1, depth = 7, tolerance = 0.05, channels = "luminance" }, shade,
          { occupied = points, threads = option.threads }))
      end
      assert(grid:sample(points, { threads = option.threads }))
    else assert(ylm.light_field(n - 1, shade, points, { channels = "luminance", threads = option.threads })) end
    if f > 0 then least, least_cpu = math.min(least, core.seconds() - start), math.min(least_cpu, os.clock() - began) end
  end
  return least, least_cpu, grid and grid.stats.points
end

local function shadow_fields()
  local line = common.table { { "scene", "%-18s" }, { "vertices", "%8d" }, { "n", "%3d" }, { "casters", "%7d" },
    { "product", "%-9s" }, { "fps", "%8.2f" }, { "by CPU", "%8.2f" }, { "M points/s", "%10.3f" },
    { "probes", "%6d" }, { "paper fps", "%9.1f" },
    { "CPU/paper", "%9.2f" } }
  for k, row in ipairs(moving) do
    if quick and k > 1 then break end
    local name, vertices, n = row[1], quick and 300 or row[2], quick and 4 or row[3]
    local sky = ylm.environment_light { coefficients = ylm.sh.resize(environment(n - 1)[1], n - 1) }
    local points = floor_points(math.min(vertices, MEASURED))
    for _, case in ipairs { { "one rule", {}, row[6] }, { "recursive", { product = "recursive" }, row[6] },
      { "accurate", { product = "accurate" }, row[5] }, { "probes", {}, row[6], true } } do
      local o = { lights = sky, cull = 0,
        casters = { balls = ylm.casters { hides = ylm.occluder { radius = 0.35 }, at = balls(0) } } }
      for key, value in pairs(case[2]) do o[key] = value end
      if option.casters > 15 and case[1] == "accurate" then o = nil end
      if o then
        local at = case[4] and vertices > MEASURED and floor_points(vertices) or points -- probes: all vertices are sampled
        local seconds, processor, probes = frame_of(ylm.shadowed(o), n, at, case[4],
          case[1] == "accurate" and 1 or math.min(3, option.frames))
        local fps, by_processor = #at / vertices / seconds, #at / vertices / processor * option.threads
        line { name, vertices, n, option.casters, case[1], fps, by_processor, by_processor * vertices / 1e6, probes, case[3],
          by_processor / case[3] }
      end
    end
  end
  print "The paper's frames are of its graphics card and draw the picture, too, and have casters whose number it does not give."
  print "'one rule' and 'probes' stand beside 'Our recur.'. Errors of the products are in products_2021_fig7.lua to _fig9.lua."
  print "'by CPU', and what follows from it, is the threads over the processor time: cores that do nothing else."
end

if option.rows ~= "SF" then prt() end
if option.rows ~= "PRT" then shadow_fields() end
