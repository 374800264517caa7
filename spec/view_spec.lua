-- Pictures in three dimensions, on fields that are known by formula.

local array = require "ylm.array"
local core = require "ylm.c.core"
local picture = require "ylm.picture"
local colours = require "spec.support.pixels"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local vtk = picture.vtk()
if not vtk then
  describe("ylm.view", function()
    it("draws", function() pending "VTK is not built in" end)
    it("says what to install", function()
      local pixels, message, code = ylm.view({ sh = { { 1 } } }):pixels()
      assert.is_nil(pixels)
      assert.equal("EMISSING", code)
      assert.truthy(message:find("libvtk9-dev", 1, true))
    end)
  end)
  return
end

local W, H = 160, 120
local dark = picture.themes.dark.background

--- A small picture, and its pixels.
local function draw(fields)
  fields.size = fields.size or { W, H }
  fields.supersample = fields.supersample or 1
  local v = ylm.view(fields)
  return assert(v:pixels()), v
end

local pixel, difference = colours.at, colours.difference

local function assert_colour(wanted, got, tolerance, what)
  assert(difference(wanted, got) <= (tolerance or 0.02), ("%s: (%.3f %.3f %.3f) wanted, got (%.3f %.3f %.3f)")
    :format(what or "colour", wanted[1], wanted[2], wanted[3], got[1], got[2], got[3]))
end

--- The part of the picture that is not background.
local function coverage(pixels, background)
  background = background or dark
  local t, n = pixels:totable(), 0
  for _, row in ipairs(t) do
    for _, p in ipairs(row) do if difference(p, background) > 0.02 then n = n + 1 end end
  end
  return n / (#t * #t[1])
end

local function map_colour(map, t)
  local c = core.figure_colours(array.array { { t } }, { 0, 0, 0 }, map, 0, 1, false)
  return { c:get(1, 1), c:get(1, 2), c:get(1, 3) }
end

--- f(x, y, z) at the voxels of an n^3 lattice over [-1, 1]^3.
local function lattice(n, f)
  local values = {}
  for k = 1, n do
    values[k] = {}
    for j = 1, n do
      values[k][j] = {}
      for i = 1, n do values[k][j][i] = f((2 * i - 1) / n - 1, (2 * j - 1) / n - 1, (2 * k - 1) / n - 1) end
    end
  end
  return { values = values, bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }
end

local camera = ylm.camera { from = { 0, 0, 6 }, at = { 0, 0, 0 }, fov = 40 }

--- Where the camera shows a point, from first principles: fov spans the height.
local function project(x, y, z)
  local k = H / 2 / math.tan(math.rad(20)) / (6 - z)
  return W / 2 + k * x, H / 2 - k * y
end

local lamp = ylm.sphere_light { at = { 0.3, 0.2, 0.4 }, radius = 0.05, radiance = { 4, 2, 1 } }
local box = { { -1, -1, -1 }, { 1, 1, 1 } }
local grids = {}
local function adaptive()
  grids.adaptive = grids.adaptive or assert(ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 3,
    metric = "relative", threshold = 4 }, lamp))
  return grids.adaptive
end
local function uniform()
  grids.uniform = grids.uniform or assert(ylm.bake(ylm.uniform_grid { bounds = box, cells = 4, lmax = 2 }, lamp))
  return grids.uniform
end

describe("ylm.view, convention", function()
  it("shows a point where the camera's formula says, right and up", function()
    for _, at in ipairs { { 0, 0, 0 }, { 1.2, 0, 0 }, { 0, 1, 0 }, { -1, -0.8, 1 } } do
      local pixels = draw { lights = ylm.sphere_light { at = at, radius = 0.1, radiance = { 1, 0, 0 } },
        camera = camera }
      local x, y = project(at[1], at[2], at[3])
      assert_colour({ 1, 0.15, 0.15 }, pixel(pixels, x, y), 0.02, ("light at %g %g %g"):format(at[1], at[2], at[3]))
      assert_colour(dark, pixel(pixels, W - x - (at[1] == 0 and 40 or 0), y), 0.01, "its mirror image")
    end
  end)

  it("tells positive lobes from negative: Y(1,0) is positive above", function()
    local pixels = draw { sh = { { 0, 0, 1, 0 } } }
    local above, below = pixel(pixels, W / 2, H * 0.3), pixel(pixels, W / 2, H * 0.7)
    assert(above[1] > above[3] + 0.2 and below[3] > below[1] + 0.2)
  end)

  it("draws Y(1,-1) towards the viewer, who stands at negative y, positive", function()
    local pixels = draw { sh = { { 0, 1, 0, 0 } }, direction = { 0, -1, 0 } }
    local middle = pixel(pixels, W / 2, H / 2)
    assert(middle[1] > middle[3] + 0.2)
  end)
end)

describe("ylm.view, on analytic fields:", function()
  it("a slice shows the map's colours where the numbers are", function()
    local pixels, v = draw { volume = lattice(32, function(x) return x end), slices = { { axis = "z", at = 0 } },
      range = { -1, 1 }, camera = camera, frame = false, bar = false }
    for _, x in ipairs { -0.9, -0.5, 0, 0.5, 0.9 } do
      local px, py = project(x, 0.2, 0)
      assert_colour(map_colour("viridis", (x + 1) / 2), pixel(pixels, px, py), 0.03, "slice at x = " .. x)
    end
    local side = 2 * H / 2 / math.tan(math.rad(20)) / 6
    local part = coverage(pixels)
    assert(math.abs(part - side * side / (W * H)) < 0.06 * part, "coverage " .. part)
    assert.same({}, v:bars())
  end)

  it("slices across x, y and z stand in their planes", function()
    local f = lattice(8, function() return 1 end)
    for axis, direction in pairs { x = { 1, 0, 0 }, y = { 0, 1, 0.001 }, z = { 0, 0, 1 } } do
      local face = draw { volume = f, slices = { { axis = axis } }, direction = direction, range = { 0, 2 },
        frame = false,
        bar = false }
      local other = axis == "x" and { 0, 0, 1 } or { 1, 0, 0 }
      local edge = draw { volume = f, slices = { { axis = axis } }, direction = other, range = { 0, 2 }, frame = false,
        bar = false, up = axis == "y" and { 0, 0, 1 } or nil }
      assert(coverage(face) > 0.3 and coverage(edge) < 0.03, axis)
    end
  end)

  it("an isosurface of r covers the disc of a sphere, in its colour", function()
    local r = 0.7
    local pixels = draw { volume = lattice(40, function(x, y, z) return math.sqrt(x * x + y * y + z * z) end),
      isosurfaces = { r }, range = { 0, 1 }, camera = camera, frame = false, bar = false }
    -- The silhouette of a sphere seen from distance d: a disc with tan = r / sqrt(d^2 - r^2).
    local radius = H / 2 / math.tan(math.rad(20)) * r / math.sqrt(36 - r * r)
    local wanted, part = math.pi * radius ^ 2 / (W * H), coverage(pixels)
    assert(math.abs(part - wanted) < 0.04 * wanted, ("%.4f wanted, got %.4f"):format(wanted, part))
    local lit, colour = pixel(pixels, W / 2, H / 2), map_colour("viridis", r)
    assert(lit[2] > lit[1] and lit[2] > 0.5 * colour[2] and lit[2] < 1.3 * colour[2])
  end)

  it("a cloud is dense where the field is, empty where it is nothing", function()
    local nan = 0 / 0
    local pixels = draw { volume = lattice(32, function(x, y, z)
      return x * x + y * y + z * z < 0.36 and 1 or nan
    end), range = { 0, 1 }, map = "viridis", camera = camera, frame = false, bar = false }
    local middle = pixel(pixels, W / 2, H / 2)
    assert_colour(map_colour("viridis", 1), middle, 0.12, "middle")
    assert_colour(dark, pixel(pixels, 5, 5), 0.01, "corner")
    local radius = H / 2 / math.tan(math.rad(20)) * 0.6 / math.sqrt(36 - 0.36)
    local wanted, part = math.pi * radius ^ 2 / (W * H), coverage(pixels)
    assert(math.abs(part - wanted) < 0.15 * wanted, ("%.4f wanted, got %.4f"):format(wanted, part))
  end)

  it("arrows begin at their points, end at their tips and have the colour of their length", function()
    local pixels = draw { glyphs = { at = { { -1, 0.5, 0 }, { -1, -0.5, 0 } }, along = { { 2, 0, 0 }, { 1, 0, 0 } } },
      range = { 1, 2 }, camera = camera, supersample = 2, bar = false }
    local function at(x, y) return pixel(pixels, project(x, y, 0)) end
    local long, short = map_colour("viridis", 1), map_colour("viridis", 0)
    local c, d = at(0, 0.5), at(-0.6, -0.5)
    assert(c[1] > 0.4 * long[1] and c[2] > 0.4 * long[2] and c[3] < c[2] / 2)
    assert(d[3] > 0.3 * short[3] and d[2] < 0.3)
    assert_colour(dark, at(0.4, -0.5), 0.01, "beyond the short one")
    assert_colour(dark, at(1.2, 0.5), 0.01, "beyond the long one")
    assert_colour(dark, at(-1.2, 0.5), 0.01, "before")
  end)

  it("streamlines of a constant field are straight and as long as the box", function()
    local flow = {}
    for k = 1, 4 do flow[k] = {} for j = 1, 4 do flow[k][j] = {} for i = 1, 4 do flow[k][j][i] = { 0, 3, 0 } end end end
    local pixels = draw { streamlines = { along = flow, bounds = box, count = 1, width = 8 }, camera = camera,
      frame = false,
      range = { 1, 4 }, bar = false, supersample = 2 }
    local rows = 0
    for _, row in ipairs(pixels:totable()) do
      for _, p in ipairs(row) do
        if difference(p, dark) > 0.05 then
          rows = rows + 1
          break
        end
      end
    end
    local length = 2 * H / 2 / math.tan(math.rad(20)) / 6
    -- The one seed stands up to 0.8 nearer or farther than the middle.
    assert(rows > 0.85 * length and rows < 1.2 * length, ("%d rows, %.1f wanted"):format(rows, length))
  end)

  it("streamlines of a rotation close to circles", function()
    local n, flow = 16, {}
    for k = 1, n do
      flow[k] = {}
      for j = 1, n do
        flow[k][j] = {}
        for i = 1, n do flow[k][j][i] = { -((2 * j - 1) / n - 1), (2 * i - 1) / n - 1, 0 } end
      end
    end
    local volume = assert(core.volume({ -1, -1, -1, 1, 1, 1 }, { n, n, n }, 3))
    core.volume_set(volume, ylm.array(flow))
    local shape = core.shape(3)
    core.shape_streamlines(shape, volume, ylm.array { { 0.6, 0, 0 } }, 0.01, 380, 2, 0.001, "viridis", 0, 1, false)
    local _, _, b = core.shape_info(shape)
    for _, k in ipairs { 1, 2, 4, 5 } do assert(math.abs(math.abs(b[k]) - 0.6) < 0.003, "extent " .. b[k]) end
    assert(math.abs(b[3]) < 0.002 and math.abs(b[6]) < 0.002)
  end)

  it("lobes of one size: r is |f| over its largest", function()
    local directions = core.figure_sphere(4)
    local basis = ylm.sh.eval(2, directions, { dtype = "double" })
    local c = ylm.array { { 0, 0, 1, 0, 0, 0, 0, 0, 0 } }
    local shape = core.shape(3)
    core.shape_lobes(shape, c, ylm.array { { 5, 6, 7 } }, ylm.array { 0.5 }, { 1, 0, 0 }, { 0, 0, 1 }, 4, basis, true)
    local points, cells, b = core.shape_info(shape)
    assert.equal(4 * 16 ^ 2 + 2, points)
    assert.equal(8 * 16 ^ 2, cells)
    assert(math.abs(b[6] - 7.5) < 1e-6 and math.abs(b[3] - 6.5) < 1e-6)
    assert(math.abs(b[4] - 5.25) < 0.002, "a sphere of half the height: " .. b[4])
  end)

  it("meshes have their colours, and let through what is behind as their opacity says", function()
    local wall = ylm.quad { corner = { -1, -1, 0 }, u = { 2, 0, 0 }, v = { 0, 2, 0 } }
    local light = ylm.sphere_light { at = { 0, 0, -1 }, radius = 0.3, radiance = { 0, 1, 0 } }
    local solid = draw { meshes = { { wall, colour = { 1, 0, 0 } } }, lights = light, camera = camera }
    local clear = draw { meshes = { { wall, colour = { 1, 0, 0 }, opacity = 0.5 } }, lights = light, camera = camera }
    local a, b = pixel(solid, W / 2, H / 2), pixel(clear, W / 2, H / 2)
    assert(a[1] > 0.5 and a[2] < 0.15, "opaque")
    assert(b[2] > 0.35 and b[1] > 0.3 and b[1] < a[1], ("translucent: %.2f %.2f"):format(b[1], b[2]))
  end)

  it("colours at vertices are interpolated", function()
    local wall = ylm.mesh { vertices = { { -1, -1, 0 }, { 1, -1, 0 }, { 1, 1, 0 }, { -1, 1, 0 } },
      triangles = { { 1, 2, 3 }, { 1, 3, 4 } } }
    local pixels = draw { camera = camera,
      meshes = { { wall, colours = { { 1, 0, 0 }, { 0, 0, 1 }, { 0, 0, 1 }, { 1, 0, 0 } } } } }
    local function at(x) return pixel(pixels, project(x, 0, 0)) end
    local l, m, r = at(-0.9), at(0), at(0.9)
    assert(l[1] > 5 * l[3] and r[3] > 5 * r[1] and math.abs(m[1] - m[3]) < 0.05)
  end)
end)

describe("ylm.view, of grids:", function()
  it("edges of a lattice of n^3 cells are 3 n (n+1)^2", function()
    local n, origin, size = 3, {}, {}
    for k = 0, n - 1 do for j = 0, n - 1 do for i = 0, n - 1 do
      origin[#origin + 1], size[#size + 1] = { i / n, j / n, k / n }, { 1 / n, 1 / n, 1 / n }
    end end end
    local shape = core.shape(2)
    core.shape_edges(shape, ylm.array { { 1, 1, 1, 1 } }, ylm.array(origin), ylm.array(size))
    assert.equal(3 * n * (n + 1) ^ 2, select(2, core.shape_info(shape)))
  end)

  it("fine edges on coarse ones are left out", function()
    -- A cube of edge 2 beside eight of edge 1: 12 + 54 edges, of which 4 + 8 lie on the shared face's rim.
    local origin, size, level = { { 0, 0, 0 } }, { { 2, 2, 2 } }, { 1 }
    for k = 0, 1 do for j = 0, 1 do for i = 0, 1 do
      origin[#origin + 1], size[#size + 1], level[#level + 1] = { 2 + i, j, k }, { 1, 1, 1 }, 2
    end end end
    local shape = core.shape(2)
    core.shape_edges(shape, ylm.array { { 1, 1, 1, 1 } }, ylm.array(origin), ylm.array(size), ylm.array(level))
    assert.equal(12 + 54 - 8, select(2, core.shape_info(shape)))
  end)

  it("every layer draws something, every quantity has its bar", function()
    local g = adaptive()
    local empty = coverage((draw { g, levels = true, bar = false,
      camera = ylm.camera { from = { 0, 0, 50 }, at = { 0, 0, 99 } } }))
    assert.equal(0, empty)
    for name, fields in pairs {
      volume = { g, volume = true, frame = false }, slices = { g, slices = { { axis = "z", at = 0.4 } },
        frame = false },
      levels = { g, levels = true }, boxes = { g, boxes = true, frame = false },
      isosurfaces = { g, quantity = "norm", isosurfaces = 2, frame = false }, glyphs = { g, glyphs = true,
        frame = false },
      streamlines = { g, streamlines = { count = 30, width = 3 }, frame = false },
      lobes = { g, lobes = { count = 30 }, frame = false },
    } do
      fields.bar = false
      assert(coverage((draw(fields))) > 0.01, name .. " is not seen")
    end
    for _, quantity in ipairs { "error", "level", "norm", "lambda", "L00", "gradient" } do
      local _, v = draw { g, quantity = quantity, slices = { { axis = "z", at = 0.4 } } }
      local bar = v:bars()[1]
      assert.equal(quantity, bar.quantity)
      assert(bar.range[1] < bar.range[2] and (not bar.log or bar.range[1] > 0), quantity)
    end
  end)

  it("the bar's range is that of the leaves", function()
    local g = adaptive()
    local _, v = draw { g, quantity = "level", slices = true }
    local cells, lo, hi = g:cells(), math.huge, -math.huge
    local level, leaf = cells.level:totable(), cells.leaf:totable()
    for i, l in ipairs(level) do
      if leaf[i] ~= 0 then lo, hi = math.min(lo, l), math.max(hi, l) end
    end
    assert.same({ lo, hi }, v:bars()[1].range)
    assert.is_false(v:bars()[1].log)
  end)

  it("a slice of L00 shows what grid:sample says at its points", function()
    local g = uniform()
    local p = { -0.5, 0.5, 0.5 } -- a corner of the lattice
    local sample = g:sample({ p })
    local value = core.array_totable(core.array_convert(sample, "double"))
    local rgb = value[1]
    local L00 = rgb[2] and 0.2126 * rgb[1][1] + 0.7152 * rgb[2][1] + 0.0722 * rgb[3][1] or rgb[1][1]
    local pixels, v = draw { g, quantity = "L00", slices = { { axis = "z", at = 0.5 } }, camera = camera, bar = true,
      frame = false }
    local bar = v:bars()[1]
    local x, y = project(p[1], p[2], p[3])
    local t = math.log(L00 / bar.range[1]) / math.log(bar.range[2] / bar.range[1])
    assert_colour(map_colour(bar.map, math.max(0, math.min(1, t))), pixel(pixels, x, y), 0.06, "L00")
  end)

  it("shows the lights that a grid was baked from", function()
    local source = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.3, radiance = { 10, 8, 6 } }
    local g = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 1, lmax = 1 }, source)
    local function drawn(lights)
      return (draw { g, levels = true, lights = lights, size = { 96, 72 } })
    end
    assert.equal(0, core.array_distance(drawn(true), drawn(source)))
    assert.is_true(core.array_distance(drawn(true), drawn(false)) > 0)
  end)

  it("has a bar and a title at any size that it takes", function()
    for _, size in ipairs { { 16, 16 }, { 32, 32 }, { 64, 48 }, { 400, 16 }, { 16, 400 } } do
      local pixels = draw { volume = lattice(4, function(x) return x end), slices = true, size = size,
        range = { 2, 5 }, label = "x", unit = "m", title = "t", caption = "c" }
      assert(pixels, table.concat(size, "x"))
    end
  end)

  it("the bar's ends have the colours of the map's ends", function()
    local pixels, v = draw { volume = lattice(4, function(x) return x end), slices = true, size = { 320, 240 },
      range = { 2, 5 },
      label = "x", unit = "m", title = "t", caption = "c" }
    local bar = v:bars()[1]
    assert.same({ 2, 5 }, bar.range)
    assert.equal("x", bar.label)
    assert.equal("m", bar.unit)
    local b = bar.box
    assert_colour(map_colour("viridis", 1), pixel(pixels, b[1] + b[3] / 2, b[2] + 1), 0.03, "top")
    assert_colour(map_colour("viridis", 0), pixel(pixels, b[1] + b[3] / 2, b[2] + b[4] - 1), 0.03, "bottom")
    assert_colour(map_colour("viridis", 0.5), pixel(pixels, b[1] + b[3] / 2, b[2] + b[4] / 2), 0.02, "middle")
    assert_colour(dark, pixel(pixels, 2, 238), 0.01, "corner")
  end)

  it("ticks of logarithmic bars are powers of ten", function()
    local ticks, labels = picture.ticks(2e-4, 3, true, 6)
    local named = {}
    for i, label in ipairs(labels) do if label ~= "" then named[#named + 1] = label end assert(ticks[i] >= 2e-4
      and ticks[i] <= 3) end
    assert.same({ "10⁻³", "10⁻²", "10⁻¹", "10⁰" }, named)
    assert.same({ "0", "0.5", "1" }, select(2, picture.ticks(0, 1, false, 3)))
    assert.same({ "2", "3", "4" }, select(2, picture.ticks(2, 4, false, 9, true)))
  end)

  it("the same picture comes twice", function()
    local a = draw { adaptive(), volume = true, levels = true }
    local b = draw { adaptive(), volume = true, levels = true }
    assert.equal(0, (core.array_distance(a, b)))
  end)
end)

describe("grid:save \"grid.vtu\"", function()
  local folder
  before_each(function() folder = scratch.new() end)
  after_each(function() folder:remove() end)

  it("is what VTK's own reader finds", function()
    local g, path = uniform(), folder.path .. "/grid.vtu"
    assert(g:save(path))
    local text = assert(vtk.describe(path))
    assert.truthy(text:find("vtkUnstructuredGrid 125 64\nbounds -1 -1 -1 1 1 1\ntype 12\n", 1, true), text)
    for _, line in ipairs { "point L00 1 125", "point gradient L00 3 125", "point lambda 1 125", "point norm 1 125",
      "cell level 1 64", "cell error 1 64" } do
      assert.truthy(text:find("\n" .. line .. " ", 1, true), line .. " is missing in\n" .. text)
    end
    local least, largest = text:match "point norm 1 125 (%S+) (%S+)"
    local lo, hi = core.figure_range(core.array_convert(g:points().norm, "double"))
    assert(math.abs(least - lo) < 1e-6 * hi and math.abs(largest - hi) < 1e-6 * hi)
  end)

  it("leaves an existing file alone where it cannot be written", function()
    local path = folder:write("grid.vtu", "old")
    assert(scratch.shell("chmod 500 " .. scratch.quote(folder.path)))
    local ok, message, code = uniform():save(folder.path .. "/sub/grid.vtu")
    assert.is_nil(ok)
    assert.equal("EIO", code)
    assert(message)
    scratch.shell("chmod 700 " .. scratch.quote(folder.path))
    assert.equal("old", folder:read "grid.vtu", path)
  end)

  it("is refused by VTK where it is cut off, as our message", function()
    local path = folder.path .. "/grid.vtu"
    assert(uniform():save(path))
    local bytes = folder:read "grid.vtu"
    folder:write("grid.vtu", bytes:sub(1, #bytes - 3000))
    local text, message = vtk.describe(path)
    assert(text == nil and message:find("VTK", 1, true), tostring(message))
  end)
end)

describe("shapes and volumes as files", function()
  it("are what VTK's own reader finds", function()
    local folder = scratch.new()
    local shape = core.shape(3)
    core.shape_spheres(shape, ylm.array { { 1, 2, 3 } }, ylm.array { 0.5 }, ylm.array { { 1, 0, 0 } }, 3)
    assert(core.shape_save(shape, folder.path .. "/ball.vtp"))
    local text = assert(vtk.describe(folder.path .. "/ball.vtp"))
    assert.truthy(text:find("vtkPolyData 258 512\nbounds 0.5 1.5 2.5 1.5 2.5 3.5\n", 1, true), text)
    local volume = assert(core.volume({ 0, 0, 0, 2, 1, 1 }, { 4, 2, 2 }, 1))
    core.volume_set(volume, ylm.zeros { 2, 2, 4 })
    assert(core.volume_save(volume, folder.path .. "/v.vti", "a < \"b\""))
    text = assert(vtk.describe(folder.path .. "/v.vti"))
    assert.truthy(text:find("vtkImageData 16 ", 1, true), text)
    assert.truthy(text:find("point a < \"b\" 1 16 0 0", 1, true), text)
    folder:remove()
  end)
end)

describe("ylm.view, where it draws", function()
  local lua = os.getenv "YLM_LUA" or "lua5.4"

  --- Runs a script under another environment; returns what it prints and its status.
  local function run(environment, script)
    local folder = scratch.new()
    local path = folder:write("draw.lua", script)
    local text, status = scratch.capture(environment .. " " .. lua .. " " .. scratch.quote(path))
    folder:remove()
    return text, status
  end

  local script = [[
local ylm = require "ylm"
local p, message, code = ylm.view({ sh = { { 1, 0, 0, 0 } }, size = { 64, 48 } }):pixels()
print(p and p:get(24, 32, 1) > 0.4 and "drawn" or code, message)]]

  it("needs no display", function()
    local text, status = run("env -u DISPLAY YLM_VTK_WINDOW=egl", script)
    assert.equal(0, status, text)
    assert.truthy(text:find "^drawn", text)
  end)

  it("starts an X server of its own where EGL is missing, and ends it", function()
    if not scratch.shell("command -v Xvfb >/dev/null") then return pending "Xvfb is not installed" end
    local text, status = run("env -u DISPLAY YLM_VTK_WINDOW=xvfb", script .. [[

local pipe = io.popen "env -u LD_PRELOAD ps -o args= -C Xvfb | wc -l"
print("servers", (pipe:read "*a"):match "%d+")
pipe:close()]])
    assert.equal(0, status, text)
    assert.truthy(text:find "^drawn", text)
  end)

  it("says what to install where there is nothing", function()
    local text, status = run("env -u DISPLAY YLM_VTK_WINDOW=none", script)
    assert.equal(0, status, text)
    assert.truthy(text:find "^EMISSING.*install libegl1", text)
  end)

  it("opens no window without a display", function()
    local text, status = run("env -u DISPLAY", [[
local ok, message, code = require "ylm".view({ sh = { { 1, 0, 0, 0 } } }):show()
print(ok, code, message)]])
    assert.equal(0, status, text)
    assert.truthy(text:find "^nil%s+EMISSING%s+no display", text)
  end)

  local has_ffi, ffi = pcall(require, "ffi")
  if has_ffi then
    it("leaves no OpenGL context current", function()
      pcall(ffi.cdef, "void *eglGetCurrentContext(void);")
      draw { sh = { { 1, 0, 0, 0 } } }
      assert(ffi.load("libEGL.so.1").eglGetCurrentContext() == nil)
    end)
  end

end)
