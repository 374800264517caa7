-- Pictures in three dimensions, on fields that are known by formula.

local colours = require "spec.support.pixels"
local core = require "ylm.c.core"
local picture = require "ylm.picture"
local views = require "spec.support.views"
local ylm = require "ylm"

if not picture.vtk() then
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

local pixel, difference = colours.at, colours.difference
local W, H = views.width, views.height
local draw, assert_colour, coverage, map_colour = views.draw, views.assert_colour, views.coverage, views.map_colour
local lattice, project = views.lattice, views.project
local camera, box, dark = views.camera, views.box, views.dark

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
    core.shape_streamlines(shape, volume, { seeds = ylm.array { { 0.6, 0, 0 } }, step = 0.01, room = 380, fewest = 2,
      radius = 0.001 }, "viridis", 0, 1, false)
    local _, _, b = core.shape_info(shape)
    for _, k in ipairs { 1, 2, 4, 5 } do assert(math.abs(math.abs(b[k]) - 0.6) < 0.003, "extent " .. b[k]) end
    assert(math.abs(b[3]) < 0.002 and math.abs(b[6]) < 0.002)
  end)

  it("lobes of one size: r is |f| over its largest", function()
    local directions = core.figure_sphere(4)
    local basis = ylm.sh.eval(2, directions, { dtype = "double" })
    local c = ylm.array { { 0, 0, 1, 0, 0, 0, 0, 0, 0 } }
    local shape = core.shape(3)
    core.shape_lobes(shape, { coefficients = c, centre = ylm.array { { 5, 6, 7 } }, scale = ylm.array { 0.5 },
      positive = { 1, 0, 0 }, negative = { 0, 0, 1 }, detail = 4, basis = basis, fit = true })
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
