--- Tools of the specs of pictures in three dimensions: small pictures, their colours, a camera, fields and grids.

local array = require "ylm.array"
local busted = require "busted"
local colours = require "spec.support.pixels"
local core = require "ylm.c.core"
local picture = require "ylm.picture"
local ylm = require "ylm"

local views = {}

--- VTK's binding; without it nil, and a pending spec of that name.
function views.vtk(name)
  local vtk = picture.vtk()
  if not vtk then
    busted.describe(name, function() busted.it("draws", function() busted.pending "VTK is not built in" end) end)
  end
  return vtk
end

local W, H = 160, 120
views.width, views.height = W, H
views.dark = picture.themes.dark.background

--- A small picture, and its pixels.
function views.draw(fields)
  fields.size = fields.size or { W, H }
  fields.supersample = fields.supersample or 1
  local v = ylm.view(fields)
  return assert(v:pixels()), v
end

function views.assert_colour(wanted, got, tolerance, what)
  assert(colours.difference(wanted, got) <= (tolerance or 0.02), ("%s: (%.3f %.3f %.3f) wanted, got (%.3f %.3f %.3f)")
    :format(what or "colour", wanted[1], wanted[2], wanted[3], got[1], got[2], got[3]))
end

--- The part of the picture that is not background.
function views.coverage(pixels, background)
  background = background or views.dark
  local t, n = pixels:totable(), 0
  for _, row in ipairs(t) do
    for _, p in ipairs(row) do if colours.difference(p, background) > 0.02 then n = n + 1 end end
  end
  return n / (#t * #t[1])
end

function views.map_colour(map, t)
  local c = core.figure_colours(array.array { { t } }, { 0, 0, 0 }, map, 0, 1, false)
  return { c:get(1, 1), c:get(1, 2), c:get(1, 3) }
end

--- f(x, y, z) at the voxels of an n^3 lattice over [-1, 1]^3.
function views.lattice(n, f)
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

views.camera = ylm.camera { from = { 0, 0, 6 }, at = { 0, 0, 0 }, fov = 40 }

--- Where the camera shows a point, from first principles: fov spans the height of the window {x, y, w, h}, default: of the
-- picture.
function views.project(x, y, z, window)
  local left, top, w, h = 0, 0, W, H
  if window then left, top, w, h = window[1], window[2], window[3], window[4] end
  local k = h / 2 / math.tan(math.rad(20)) / (6 - z)
  return left + w / 2 + k * x, top + h / 2 - k * y
end

views.lamp = ylm.sphere_light { at = { 0.3, 0.2, 0.4 }, radius = 0.05, radiance = { 4, 2, 1 } }
views.box = { { -1, -1, -1 }, { 1, 1, 1 } }
local grids = {}

function views.adaptive()
  grids.adaptive = grids.adaptive or assert(ylm.bake(ylm.adaptive_grid { bounds = views.box, lmax = 2, depth = 3,
    metric = "relative", threshold = 4 }, views.lamp))
  return grids.adaptive
end
function views.uniform()
  grids.uniform = grids.uniform or assert(ylm.bake(ylm.uniform_grid { bounds = views.box, cells = 4, lmax = 2 }, views.lamp))
  return grids.uniform
end

return views
