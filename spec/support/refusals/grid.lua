-- Refusals of ylm's grids: see spec/refusals_spec.lua.

local nan, inf = 0 / 0, 1 / 0
local box = { { -1, -1, -1 }, { 1, 1, 1 } }

local function lamp(ylm) return ylm.sphere_light { at = { 0, 3, 0 }, radius = 0.1, radiance = 1 } end

local function small(ylm)
  return ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1 }, lamp(ylm))
end

local function closed(ylm)
  local g = small(ylm)
  g:close()
  return g
end

--- f of a small grid in bricks.
local function in_bricks(f)
  return function(ylm)
    local folder = os.tmpname()
    os.remove(folder)
    local g = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 3, threshold = 100 }, lamp(ylm), { folder = folder .. ".ylmd" })
    os.execute("rm -r " .. folder .. ".ylmd")
    return f(g)
  end
end

local function adaptive(fields)
  return function(ylm) return ylm.adaptive_grid(fields) end
end

local function uniform(fields)
  return function(ylm) return ylm.uniform_grid(fields) end
end

local function bake(options, description)
  return function(ylm)
    return ylm.bake(ylm.adaptive_grid(description or { bounds = box, lmax = 1, depth = 2 }), lamp(ylm), options)
  end
end

local short = { bounds = { { 0, 0, 0 }, { 1, 1e-300, 1 } }, lmax = 1, depth = 1 }

--- An update of a dynamic grid.
local function update(lights, options)
  return function(ylm)
    local g = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1, dynamic = true }, lamp(ylm))
    return g:update(lights or lamp(ylm), options)
  end
end

local function sample(points, options)
  return function(ylm) return small(ylm):sample(points, options) end
end

return {
  adaptive_grid = {
    { call = function(ylm) return ylm.adaptive_grid { threshold = 0.1, measure = "irradiance" } end,
      says = "measure is what a tolerance is of: give a tolerance, or leave measure out" },
    { call = function(ylm) return ylm.adaptive_grid { measure = "irradiance", dynamic = true } end,
      says = "a dynamic grid keeps a tolerance of coefficients" },
    { call = function(ylm) return ylm.adaptive_grid() end, says = "a table of named fields expected, got nil" },
    { call = adaptive { boundz = box }, says = "did you mean 'bounds'" },
    { call = adaptive { bounds = { { 0, 0, 0 }, { 0, 1, 1 } } }, says = "bounds must be .* x0 < x1.*%(axis 1 goes from 0 to 0%)" },
    { call = adaptive { bounds = { { 0, 0, 0 }, { 1, nan, 1 } } }, says = "bounds must be" },
    { call = adaptive { bounds = { { 0, 0, 0 }, { 1, inf, 1 } } }, says = "bounds must be" },
    { call = adaptive { bounds = { { 0, 0, 0 }, { 1, 1e300, 1 } } }, says = "bounds must be .* none beyond 1e15" },
    { call = adaptive { lmax = -1 }, says = "lmax must be an integer >= 0 and <= 100, got %-1" },
    { call = adaptive { lmax = 1e6 }, says = "lmax must be an integer" },
    { call = adaptive { lmax = 1.5 }, says = "lmax must be an integer" },
    { call = adaptive { depth = 17 }, says = "depth must be an integer >= 0 and <= 16" },
    { call = adaptive { depth = nan }, says = "depth must be an integer" },
    { call = adaptive { tolerance = 0 }, says = "tolerance must be a number > 0" },
    { call = adaptive { tolerance = inf }, says = "tolerance must be a number" },
    { call = adaptive { threshold = -1 }, says = "threshold must be a number >= 0" },
    { call = adaptive { tolerance = 0.1, threshold = 1 }, says = "either tolerance or threshold, not both" },
    { call = adaptive { metric = "relativ", threshold = 1 }, says = "did you mean 'relative'" },
    { call = adaptive { channels = "luminance", metric_channels = "rgb" }, says = "needs channels = 'rgb'" },
    { call = adaptive { continuous = 1 }, says = "continuous must be true or false" },
    { call = adaptive { dynamic = 1 }, says = "dynamic must be true or false" },
  },
  uniform_grid = {
    { call = uniform { bounds = box }, says = "field 'cells' is missing" },
    { call = uniform { cells = 0 }, says = "cells must be voxels along each axis" },
    { call = uniform { cells = { 8, 8 } }, says = "cells must be voxels along each axis" },
    { call = uniform { cells = { 8, 8, nan } }, says = "cells must be voxels along each axis" },
    { call = uniform { cells = { 1e6, 1e6, 1e6 } }, says = "cells are too many" },
    { call = uniform { cells = 2, threshold = 1 }, says = "no field 'threshold'" },
    { call = uniform { cells = 2, channels = "luminance", metric_channels = "rgb" }, says = "needs channels = 'rgb'" },
  },
  bake = {
    { call = function(ylm)
      return ylm.bake(ylm.adaptive_grid { bounds = box, tolerance = 0.1, measure = "irradiance" }, lamp(ylm),
        { occupied = { { 0, 0, 0 } } })
    end, says = "irradiance needs normals: occupied = a view, 'camera' or an array %[n%]%[6%]" },
    { call = bake { occupied = { { 0, 0, 0, 0, 0, 0 } } }, says = "occupied: row 1 has no normal" },
    { call = bake { quantity = "direct" }, says = "quantity: this light field holds lights, not direct: leave it out" },
    { call = bake { quantity = "shadows" }, says = "quantity must be" },
    { call = bake({}, short), says = "bounds: axis 2 is only 1e%-300 long; the least is 1e%-30" },
    { call = function(ylm)
      return ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1, dynamic = true }, small(ylm))
    end, says = "dynamic = true follows sphere lights and flat lights, this is baked from another light field" },
    { call = function(ylm)
      return ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1, dynamic = true }, lamp(ylm),
        { sums_tolerance = 1e-2 })
    end, says = "dynamic = true sums its lights exactly: leave sums_tolerance out" },
    { call = bake({ sums_tolerance = 0 }), says = "sums_tolerance must be a number >= 1e%-06 and <= 0.5, got 0" },
    { call = function(ylm) return ylm.bake() end, says = "an adaptive_grid or a uniform_grid expected, got nil" },
    { call = function(ylm) return ylm.bake(lamp(ylm), lamp(ylm)) end,
      says = "an adaptive_grid or a uniform_grid expected" },
    { call = function(ylm) return ylm.bake(ylm.adaptive_grid {}, lamp(ylm)) end, says = "no bounds" },
    { call = bake({ occupied = { { 1, 2, 3 } } }, {}), says = "no bounds" },
    { call = bake { occupied = {} }, says = "occupied: at least one point expected" },
    { call = bake { occupied = { { 1, 2 } } }, says = "rows of 3 numbers expected" },
    { call = bake { occupied = { { 0, 0, 0 }, { 1, 2, nan } } }, says = "row 2 is not finite" },
    { call = bake { occupied = 3 }, says = "a table of numbers or an array expected, got 3" },
    { call = bake { ocupied = { { 0, 0, 0 } } }, says = "did you mean 'occupied'" },
    { call = bake { geometry = {} }, says = "geometry must be a mesh, a shape or a list of them, got" },
    { call = bake { geometry = "bunny.ply" }, says = "geometry must be a mesh" },
    { call = function(ylm) return bake { geometry = { ylm.sphere {}, 5 } } (ylm) end,
      says = "geometry%[2%] must be a mesh or a shape, got 5" },
    { call = function(ylm) return bake { geometry = ylm.sphere {}, occupied = { { 0, 0, 0 } } } (ylm) end,
      says = "geometry is for occupied = 'surfaces', occupied gives points: leave one out" },
    { call = bake { occupied = "surfaces" }, says = "occupied = 'surfaces' needs geometry" },
    { call = bake { occupied = "camera" }, says = "occupied must be 'surfaces' or points, got" },
    { call = function(ylm)
        local sphere = ylm.sphere {}
        sphere.mesh:vertices():set(2, 1, nan)
        return bake { geometry = sphere } (ylm)
      end, says = "surfaces: vertex 2 of mesh 1 is not finite" },
    { call = function(ylm) return bake { geometry = ylm.sphere { at = { 9, 9, 9 } } } (ylm) end,
      says = "surfaces: no triangle lies within the bounds" },
    { call = bake { threads = 0 }, says = "threads must be an integer >= 1" },
    { call = bake { progress = 3 }, says = "progress must be a function" },
    { call = bake { max_points = 9 }, says = "more than 9 points" },
    { call = bake { progress = function() return false end }, says = "cancelled" },
    { call = bake { progress = function() error("stop here at refusals/x.lua:1: ", 0) end }, says = "stop here" },
    { call = function(ylm) return ylm.bake(ylm.adaptive_grid { bounds = box }, closed(ylm)) end, says = "closed" },
    { call = function(ylm) return ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2 }, small(ylm)) end,
      says = "coefficients up to lmax 1, 2 is wanted" },
  },
  ["grid:update"] = {
    { call = function(ylm) return small(ylm):update "lamp" end, says = "lights? expected" },
    { call = function(ylm) return small(ylm):update(lamp(ylm), { tolerance = 0.1 }) end,
      says = "tolerance is of grids with dynamic = true: leave it out" },
    { call = function(ylm) return small(ylm):update(lamp(ylm), { octree = "grow" }) end,
      says = "octree must be one of 'follow', 'keep'" },
    { call = function(ylm) return small(ylm):update(lamp(ylm), { occupied = { { 0, 0, 0 } } }) end,
      says = "occupied is of octree = 'follow': the points stay: leave it out" },
    { call = function(ylm) return small(ylm):update(lamp(ylm), { quantity = "all" }) end,
      says = "quantity: this light field holds lights, not all: leave it out" },
    { call = function(ylm)
      local g = small(ylm)
      return g:update(g)
    end, says = "a grid cannot be updated from itself" },
    { call = function(ylm)
      local g = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1, dynamic = true }, lamp(ylm))
      return g:update(lamp(ylm), { octree = "keep" })
    end, says = "a grid with dynamic = true follows its lights: 'follow', or leave it out" },
    { call = function(ylm) return closed(ylm):update(lamp(ylm)) end, says = "the grid has been closed" },
    { call = update "lamp", says = "lights? expected" },
    { call = update(nil, { tolerance = -1 }), says = "tolerance must be a number >= 0" },
    { call = update(nil, { tolerance = nan }), says = "tolerance must be a number" },
    { call = update(nil, { tolerence = 1 }), says = "did you mean 'tolerance'" },
    { call = update(nil, { threads = 0 }), says = "threads must be an integer" },
    { call = function(ylm)
      local g = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1, dynamic = true }, lamp(ylm))
      return g:update(small(ylm))
    end, says = "a dynamic grid follows sphere lights and flat lights" },
  },
  ["grid:irradiance"] = {
    { call = function(ylm) return small(ylm):irradiance({ { 0, 0 } }, { { 0, 1, 0 } }) end, says = "rows of 3 numbers expected" },
    { call = function(ylm) return small(ylm):irradiance({ { 0, 0, 0 } }, {}) end, says = "one for each of 1 points expected" },
    { call = function(ylm) return small(ylm):irradiance({ { 0, 0, 0 } }, { { 0, 1, 0 } }, { thread = 1 }) end,
      says = "did you mean 'threads'" },
  },
  ["grid:sample"] = {
    { call = sample(), says = "points: a table of numbers or an array expected, got nil" },
    { call = sample { { 1, 2 } }, says = "rows of 3 numbers expected" },
    { call = sample { { 0, inf, 0 } }, says = "row 1 is not finite" },
    { call = sample({ { 0, 0, 0 } }, { interpolation = "cubic" }), says = "interpolation must be one of" },
    { call = sample({ { 0, 0, 0 } }, { derivatives = 2 }), says = "derivatives must be an integer >= 0 and <= 1" },
    { call = sample({ { 0, 0, 0 } }, { outside = "wrap" }), says = "outside must be one of" },
    { call = sample({ { 0, 0, 0 } }, { threads = 1e9 }), says = "threads must be an integer" },
    { call = sample({ { 0, 0, 0 } }, { flags = 1 }), says = "flags must be true or false" },
    { call = sample({ { 0, 0, 0 } }, { out = 3 }), says = "out must be an array" },
    { call = function(ylm)
        return small(ylm):sample({ { 0, 0, 0 } }, { flags = true, out = { nil, ylm.zeros({ 2 }, "float") } })
      end, says = "out%[2%] must be a float array of 1, got a float array of 2" },
    { call = function(ylm) return small(ylm):sample({ { 0, 0, 0 } }, { out = ylm.zeros({ 2, 3, 4 }, "float") }) end,
      says = "out%[1%] must be a float array of 1x3x4, got a float array of 2x3x4" },
    { call = function(ylm) return small(ylm):sample({ { 0, 0, 0 } }, { out = ylm.zeros { 1, 3, 4 } }) end,
      says = "out%[1%] must be a float array of 1x3x4, got a double array" },
    { call = function(ylm) return small(ylm):sample({ { 0, 0, 0 } }, { out = { nil, ylm.zeros { 1, 3, 4, 3 } } }) end,
      says = "out takes 1 array %(see derivatives%), got an entry 2" },
    { call = function(ylm)
        local out = ylm.zeros({ 1, 3, 4 }, "float")
        out:close()
        return small(ylm):sample({ { 0, 0, 0 } }, { out = out })
      end, says = "out%[1%]: the array has been closed" },
    { call = function(ylm)
        local room = ylm.zeros({ 48 }, "float")
        return small(ylm):sample(room:reshape { 16, 3 }, { out = room })
      end, says = "must be a float array of 16x3x4" },
    { call = function(ylm) -- four points and the results of four points, in the same memory
        local room = ylm.zeros({ 4, 3, 4 }, "float")
        return small(ylm):sample(room[1]:reshape { 4, 3 }, { out = room })
      end, says = "out%[1%] shares memory with the points" },
    { call = function(ylm) return closed(ylm):sample { { 0, 0, 0 } } end, says = "sample: the grid has been closed" },
  },
  ["grid:points"] = { { call = function(ylm) return closed(ylm):points() end,
    says = "points: the grid has been closed" } },
  ["grid:cells"] = {
    { call = function(ylm) return closed(ylm):cells() end, says = "cells: the grid has been closed" },
    { call = function(ylm) return small(ylm):cells { leaves = true } end, says = "no field 'leaves'" },
  },
  ["grid:locate"] = {
    { call = function(ylm) return small(ylm):locate() end, says = "three numbers {x, y, z} expected, got nil" },
    { call = function(ylm) return small(ylm):locate { 0, nan, 0 } end, says = "three numbers" },
    { call = function(ylm) return closed(ylm):locate { 0, 0, 0 } end, says = "locate: the grid has been closed" },
  },
  ["grid:export"] = {
    { call = function(ylm) return small(ylm):export() end,
      says = "a path ending in .ylmp, .three.json, .ktx2 or .npy expected, got nil" },
    { call = function(ylm) return small(ylm):export("a.ylm") end, says = "a path ending in .ylmp" },
    { call = function(ylm) return small(ylm):export("a.npy", { cells = 4 }) end, says = "cells must be { nx, ny, nz }" },
    { call = function(ylm) return small(ylm):export("a.npy", { cells = { 2, 2, 2 }, tolerance = 1 }) end, says = "not both" },
    { call = function(ylm) return small(ylm):export("a.npy", { points = { { 0, 0 } } }) end, says = "3" },
    { call = function(ylm) return small(ylm):export("a.ylmp", { lmax = 3 }) end, says = "lmax of .ylmp is 1 or 2" },
    { call = function(ylm) return small(ylm):export("a.npy", { bits = 8 }) end, says = "bits are of .ylmp" },
    { call = function(ylm) return small(ylm):export("/no/such/folder/a.npy") end, says = "cannot be created" },
    { call = function(ylm) return closed(ylm):export("a.npy") end, says = "export: the grid has been closed" },
  },
  ["grid:save"] = {
    { call = function(ylm) return small(ylm):save() end, says = "a path expected, got nil" },
    { call = function(ylm) return small(ylm):save("") end, says = "a path expected" },
    { call = function(ylm) return small(ylm):save("grid.txt") end, says = "a path ending in .ylm, .vtu or .html expected" },
    { call = function(ylm) return small(ylm):save("/no/such/folder/grid.ylm") end, says = "cannot be created" },
    { call = function(ylm) return small(ylm):save("/dev/full.ylm/x.ylm") end, says = "cannot be created" },
    { call = function(ylm) return small(ylm):save("x.ylm", { byte_order = "swapped" }) end,
      says = "no field 'byte_order'" },
    { call = function(ylm) return small(ylm):save("x.ylm", { tolerance = 0.1, bytes = 1e6 }) end,
      says = "one of tolerance, bytes and step" },
    { call = function(ylm) return small(ylm):save("x.ylm", { tolerance = 0.6 }) end, says = "tolerance must be" },
    { call = function(ylm) return small(ylm):save("x.ylm", { tolerance = 0 / 0 }) end, says = "tolerance must be" },
    { call = function(ylm) return small(ylm):save("x.ylm", { bytes = "many" }) end, says = "bytes must be a number of bytes" },
    { call = function(ylm) return small(ylm):save("x.ylm", { bytes = 10 }) end, says = "at the coarsest step of rounding" },
    { call = function(ylm) return small(ylm):save("x.ylm", { step = 2 }) end, says = "step must be" },
    { call = function(ylm) return closed(ylm):save("x.ylm") end, says = "save: the grid has been closed" },
    { call = function(ylm) return closed(ylm):save("x.html") end, says = "save: the grid has been closed" },
    { call = function(ylm) return small(ylm):save("x.html", { scene = 1 }) end, says = "scene must be a scene, got 1" },
    { call = function(ylm) return small(ylm):save("x.html", { poster = "x" }) end, says = "poster must be an image, or false for none" },
    { call = function(ylm) return small(ylm):save("x.html", { precision = "double" }) end, says = "precision must be one of 'half'" },
    { call = function(ylm) return small(ylm):save("x.html", { precision = "half", tolerance = 0.1 }) end,
      says = "tolerance is of precision = 'few': leave one out" },
    { call = function(ylm) return small(ylm):save("x.html", { size = 3 }) end, says = "size must be { width, height }" },
    { call = function(ylm) return small(ylm):save("x.html", { limit = 1000 }) end, says = "page: .* MB, the limit is 0.0 MB" },
    { call = function(ylm) return small(ylm):save("/no/such/folder/x.html") end, says = "cannot be created" },
  },
  ["grid_set:sample"] = {
    { call = in_bricks(function(g) return g:sample() end), says = "points: a table of numbers or an array expected, got nil" },
    { call = in_bricks(function(g) return g:sample { { 0, nan, 0 } } end), says = "row 1 is not finite" },
    { call = in_bricks(function(g) return g:sample({ { 0, 0, 0 } }, { device = 1 }) end), says = "no field 'device'" },
    { call = in_bricks(function(g) return g:sample({ { 0, 0, 0 } }, { derivatives = 2 }) end), says = "derivatives must be" },
    { call = in_bricks(function(g) g:close() return g:sample { { 0, 0, 0 } } end), says = "sample: the grid has been closed" },
  },
  ["grid_set:save"] = {
    { call = in_bricks(function(g) return g:save "grid.vtu" end), says = "a path ending in .ylm, .ylmd or .pvtu expected" },
    { call = in_bricks(function(g) return g:save "few.ylmd" end), says = "a folder is written in few bytes" },
    { call = in_bricks(function(g) return g:save("grid.ylm", { cache = 1 }) end), says = "no field 'cache'" },
    { call = in_bricks(function(g) g:close() return g:save "grid.ylm" end), says = "save: the grid has been closed" },
  },
  ["grid_set:close"] = { { call = in_bricks(function(g) return g.close(3) end), says = "a grid in bricks expected" } },
  ["grid:close"] = { { call = function(ylm) return closed(ylm):close() end,
    says = "close: the grid has been closed" } },
}
