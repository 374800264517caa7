--- The layers of a view: what each needs, its numbers, and how it gets into the scene.

local bodies = require "ylm.view.bodies"
local check = require "ylm.check"
local core = require "ylm.c.core"
local memory = require "ylm.memory"
local drawing = require "ylm.view.drawing"
local fields = require "ylm.view.fields"
local numbers = require "ylm.view.numbers"
local picture = require "ylm.picture"

local layers = { check = require "ylm.view.check", prepare = numbers.prepare, lobes = bodies.lobes }

--- The edges of the bounds, where no cells are drawn.
local function add_frame(stage, v)
  local b = numbers.bounds(v) or v.flow and v.flow.bounds
  if not b or not v.frame or v.levels then return end
  local origin, size = core.array_zeros({ 1, 3 }, "double"), core.array_zeros({ 1, 3 }, "double")
  core.array_fill(origin, { { b[1], b[2], b[3] } })
  core.array_fill(size, { { b[4] - b[1], b[5] - b[2], b[6] - b[3] } })
  local colour = core.array_zeros({ 1, 4 }, "double")
  core.array_fill(colour, { picture.with_alpha(stage.theme.dim, 0.8) })
  local shape = core.shape(2)
  drawing.run(core.shape_edges(shape, colour, origin, size))
  drawing.lines(stage, shape, 1)
end

local order = { "scene", "surfaces", "meshes", "boxes", "slices", "isosurfaces", "glyphs", "streamlines", "lobes", "sh", "volume",
  "levels", "lights", "points" }

--- Calls f; what a C call in it ran into comes back as nil, message, code.
function layers.try(f)
  local ok, problem = memory.pcall(f)
  if ok then return true end
  if type(problem) == "table" then
    if core.status(problem[2]) == "caller" then return check.fail("view: %s", problem[1]) end
    return nil, problem[1], problem[2]
  end
  error(problem, 0)
end

--- Puts all layers of stage.view into stage.scene. Returns true, or nil, message, code.
function layers.fill(stage)
  local v = stage.view
  stage.boxes, stage.shapes = {}, {}
  return layers.try(function()
    for _, name in ipairs(order) do if v[name] then (fields[name] or bodies[name])(stage, v) end end
    add_frame(stage, v)
  end)
end

return layers
