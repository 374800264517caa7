--- Shapes in the picture of a live window: levels, lobes, gradients, the picked cell, a ring around the chosen lamp.

local array = require "ylm.array"
local core = require "ylm.c.core"
local layers = require "ylm.view.layers"
local drawing = require "ylm.view.drawing"
local numbers = require "ylm.view.numbers"
local picture = require "ylm.picture"
local quantities = require "ylm.grid.quantities"
local space = require "ylm.live.space"

local overlays = {}

local LOBES = 256 -- the most
local ARROWS = 800

local ring_colour, cell_colour = { 1, 0.62, 0.16 }, { 0.25, 1, 0.55 }

local function doubles(rows)
  local a = assert(core.array_zeros({ #rows, #rows[1] }, "double"))
  core.array_fill(a, rows)
  return a
end

--- A flat ring of `width` pixels around a lamp, that faces the camera, just before the lamp's middle.
local function add_ring(stage, f, lamp, least)
  local _, _, z = space.project(f, lamp.at)
  if not z then return end
  local pixel = 2 * z * f.tall / f.height
  local inner = math.max(1.25 * lamp.radius, 6 * pixel)
  local outer = inner + 3 * pixel
  local centre = space.plus(f.from, space.minus(lamp.at, f.from), math.max(least / z, 1 - lamp.radius / z))
  local points, index, colour, n = {}, {}, {}, 48
  for k = 0, n - 1 do
    local c, s = math.cos(2 * math.pi * k / n), math.sin(2 * math.pi * k / n)
    for _, r in ipairs { inner, outer } do
      points[#points + 1] = space.plus(space.plus(centre, f.right, r * c), f.up, r * s)
      colour[#colour + 1] = ring_colour
    end
    local a, b = 2 * k + 1, 2 * ((k + 1) % n) + 1
    index[#index + 1] = { a, a + 1, b }
    index[#index + 1] = { b, a + 1, b + 1 }
  end
  local shape = core.shape(3)
  drawing.run(core.shape_mesh(shape, doubles(points), nil, doubles(colour), doubles(index), 1))
  drawing.surface(stage, shape, { ambient = 1, diffuse = 0, specular = 0 })
end

--- The edges of one box.
local function add_box(stage, origin, size)
  local shape = core.shape(2)
  drawing.run(core.shape_edges(shape, doubles { { cell_colour[1], cell_colour[2], cell_colour[3], 1 } }, doubles { origin },
    doubles { size }))
  drawing.lines(stage, shape, 2)
end

--- A mask [n] of these rows.
local function mask_of(n, rows)
  local mask = array.zeros({ n }, "double")
  for _, i in ipairs(rows) do if i >= 1 and i <= n then mask:set(i, 1) end end
  return mask
end

--- The mask of at most LOBES points nearest to p, and how far they are apart.
local function nearest(position, p)
  local list, n = core.array_totable(position), position.shape[1]
  local order = {}
  for i = 1, n do
    local q = list[i]
    order[i] = { (q[1] - p[1]) ^ 2 + (q[2] - p[2]) ^ 2 + (q[3] - p[3]) ^ 2, i }
  end
  table.sort(order, function(a, b) return a[1] < b[1] or a[1] == b[1] and a[2] < b[2] end)
  local rows = {}
  for k = 1, math.min(LOBES, n) do rows[k] = order[k][2] end
  local reach = n > 0 and math.sqrt(order[#rows][1]) or 1
  return mask_of(n, rows), math.max(reach, 1e-6) * 1.1 / math.max(1, #rows) ^ (1 / 3)
end

local function cell_at(grid, p)
  local cell = grid:locate(p)
  return cell and not cell.outside and cell or nil
end

--- The kinds of overlays that are on, as a word: nothing is built where it is the same as before.
function overlays.wanted(s)
  local o = s.settings
  return (o.levels and "l" or "") .. (o.lobes and "b" or "") .. (o.gradients and "g" or "") .. (s.picked and "p" or "")
    .. (s.chosen and "c" or "")
end

--- A scene of VTK with all that is on, seen by the camera; nil where nothing is on; or nil, message, code. `least`: the
-- nearest depth that is seen.
function overlays.build(s, grid, least)
  if overlays.wanted(s) == "" then return nil end
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local scene
  scene, message, code = vtk.scene()
  if not scene then return nil, message, code end
  local o, width, height = s.settings, s:picture_size()
  local v = { frame = false, quantity = "level", levels = grid and o.levels and { occupied = true, opacity = 0.45 } or nil }
  local stage = { vtk = vtk, scene = scene, view = v, theme = picture.themes.dark }
  if grid and (o.levels or o.lobes or o.gradients or s.picked) then
    v.subject, v.source = grid, quantities.open(grid)
    if o.lobes then
      local mask, spacing = nearest(v.source.position(), s.camera.at)
      v.lobes = { mask = mask, spacing = spacing }
    end
    if o.gradients then v.glyphs = { count = ARROWS } end
  end
  if v.subject then
    local ok
    ok, message, code = numbers.prepare(v)
    if not ok then return nil, message, code end
  end
  local ok
  ok, message, code = layers.fill(stage)
  if not ok then return nil, message, code end
  ok, message, code = layers.try(function()
    if grid and s.picked then
      local cell = cell_at(grid, s.picked.position)
      if cell then
        add_box(stage, cell.origin, cell.size)
        local corners = {}
        for i, row in ipairs(cell.corners or {}) do corners[i] = row end
        v.lobes = { mask = mask_of(v.source.position().shape[1], corners), spacing = math.min(cell.size[1], cell.size[2],
          cell.size[3]) * 0.8 }
        layers.lobes(stage, v)
      end
    end
    local lamp = s.chosen and s.lamps[s.chosen]
    if lamp then add_ring(stage, space.frame(s.camera, width, height), lamp, least) end
  end)
  if not ok then return nil, message, code end
  local c = s.camera
  vtk.scene_camera(scene, c.from, c.at, c.up, c.fov)
  return scene
end

return overlays
