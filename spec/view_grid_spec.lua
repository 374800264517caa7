-- Pictures of grids: edges, slices, lights, colour bars.

local colours = require "spec.support.pixels"
local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"
local views = require "spec.support.views"
local ylm = require "ylm"

if not views.vtk "ylm.view of grids" then return end

local pixel = colours.at
local draw, assert_colour, coverage, map_colour = views.draw, views.assert_colour, views.coverage, views.map_colour
local lattice, project, adaptive, uniform = views.lattice, views.project, views.adaptive, views.uniform
local camera, dark = views.camera, views.dark

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

  it("its levels stand first; of what is said about colours a cloud", function()
    local g = adaptive()
    for quantity, more in pairs { level = {}, error = { range = { 1e-3, 1 } }, norm = { quantity = "norm" } } do
      more[1], more.size, more.supersample = g, { 160, 100 }, 1
      local v = ylm.view(more)
      assert.equal(quantity, v:bars()[1].quantity)
      assert.equal(quantity ~= "level", v.volume == true)
      assert.is_true(v.levels)
    end
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
    local x, y = project(p[1], p[2], p[3], v:window())
    local t = math.log(L00 / bar.range[1]) / math.log(bar.range[2] / bar.range[1])
    assert_colour(map_colour(bar.map, math.max(0, math.min(1, t))), pixel(pixels, x, y), 0.06, "L00")
  end)

  it("parts of a grid with sides have colours; light in a slice jumps at a wall, as grid:sample says", function()
    local walls = require "spec.support.walls"
    local scene = ylm.scene "a wall" { lights = walls.lamp,
      geometry = { ylm.quad { corner = { -2, -2, walls.height }, u = { 4, 0, 0 }, v = { 0, 4, 0 } } } }
    local form = ylm.uniform_grid { bounds = walls.box, cells = { 3, 3, 5 }, lmax = 1, channels = "luminance" }
    local g = ylm.bake(form, walls.field, { quantity = "direct", scene = scene })
    assert.equal(18, g.stats.parts)
    local cells, crossed = g:cells(), 0
    for i = 1, #cells.parts do
      crossed = crossed + cells.crossed[i]
      assert.equal(cells.crossed[i] == 1 and 2 or 0, cells.parts[i])
    end
    assert.equal(9, crossed)
    local pixels, v = draw { g, quantity = "parts", slices = { { axis = "y", at = 0.3 } }, frame = false, bar = false }
    assert.same({ 1, 2 }, v.scale.range)
    assert(coverage(pixels) > 0.03)
    local n, b = 32, { -1.1, 0.3, -1, 1.1, 0.3, 1.2 }
    local function column(quantity)
      local volume = assert(core.volume(b, { n, 1, n }, 1))
      local values = quantity and g:points().value
      values = values and core.figure_mix(values, values.shape[1], { 0 }, { 1 }, 1)
      core.volume_fill_parts(volume, g, values and values:reshape { values.shape[1] })
      return core.volume_values(volume)
    end
    local parts, light, two = column(), column "L00", {}
    for k = 1, n do
      local z, x = -1 + 2.2 * (k - 0.5) / n, -1.1 + 2.2 * 15.5 / n
      local part, L = parts:get(k, 1, 16, 1), light:get(k, 1, 16, 1)
      if g:locate({ x, 0.3, z }).crossed then
        local side = z > walls.height and "above" or "below"
        if math.abs(z - walls.height) > 0.08 then
          two[side] = two[side] or part
          assert.equal(two[side], part)
          assert.near(g:sample({ { x, 0.3, z } }):get(1, 1, 1), L, 1e-5 * L)
        end
      else assert(part ~= part and L ~= L) end
    end
    assert(two.above and two.below and two.above ~= two.below)
    local folder = scratch.new()
    assert(g:save(folder.path .. "/sides.vtu"))
    assert.truthy(scratch.text(folder.path .. "/sides.vtu"):find('Name="parts"', 1, true))
    folder:remove()
    local arrows = draw { g, glyphs = { count = 30 }, frame = false, bar = false }
    assert(coverage(arrows) > 0.01)
    local real = require "ylm.view.drawing".spread(g:points().position, { -1.1, -1.1, -1, 1.1, 1.1, 1.2 }, 1000,
      core.array_convert(g:points().ghost, "double"))
    local ghost = g:points().ghost
    for i = 1, #ghost do assert(ghost[i] == 0 or real[i] == 0) end
    for more, words in pairs { isosurfaces = "numbers of parts have no order", boxes = "boxes show a quantity of cells" } do
      local ok, message = pcall(function() return assert(ylm.view { g, quantity = "parts", [more] = true }:pixels()) end)
      assert.is_false(ok)
      assert.truthy(tostring(message):find(words, 1, true), message)
    end
    local ok, message = pcall(function() return assert(ylm.view { uniform(), quantity = "parts", slices = true }:pixels()) end)
    assert.is_false(ok)
    assert.truthy(tostring(message):find("parts are of a grid with sides", 1, true), message)
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

  it("the same picture comes twice", function()
    local a = draw { adaptive(), volume = true, levels = true }
    local b = draw { adaptive(), volume = true, levels = true }
    assert.equal(0, (core.array_distance(a, b)))
  end)
end)
