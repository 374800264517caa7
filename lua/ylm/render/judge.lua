--- scene:judge: files of probes beside paths, at surfaces of their scene.

local array = require "ylm.array"
local bricks = require "ylm.grid.probes"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local engine = require "ylm.grid.engine"
local form = require "ylm.form"
local judge_picture = require "ylm.render.judge_picture"
local options = require "ylm.render.options"
local places = require "ylm.grid.places"
local probe = require "ylm.render.probe"
local progress = require "ylm.progress"
local read = require "ylm.grid.engine_read"
local show = require "ylm.show"
local tracing = require "ylm.trace"
local transfer = require "ylm.transfer"
local where = require "ylm.grid.where"

local judge = {}

local HALF = 0.5 -- of validity: less lies in a body
local MOST_PLACES = 2 ^ 20 -- of a picture

local judge_options = options.list({
  { "quantity", "choice", of = { "indirect", "all" }, default = "indirect",
    about = "the light that the probes hold: 'indirect', what surfaces send back, or 'all'" },
  { "places", "integer", min = 100, max = 2 ^ 20, default = 1000, about = "of surfaces, by area" },
  { "samples", "integer", min = 64, max = 2 ^ 24, default = 2048, about = "paths from each" },
  { "bounds", "bounds", optional = true, about = "of .npy, the box of its cells; else of places: default the geometry's" },
  { "offset", "number", min = 0, max = 2, optional = true, unit = "cells", about = "of .npy, how far off the surface, along the "
    .. "normal, its engine looks up; default 0" },
  { "seed", "integer", min = 0, max = 2 ^ 53, default = 1, about = "of places and paths" },
  { "picture", "list", of = "integer", optional = true, unit = "places", about = "{ width, height }: also makes a picture of "
    .. "what the scene's camera sees, by paths, by the probes, and of the error between them" },
}, options.common)

--- The box around a scene's geometry.
local function box_of(s)
  local meshes = {}
  for i, g in ipairs(s.geometry) do meshes[i] = g.mesh end
  return where.bounds_of_meshes(meshes)
end

--- The light of paths, as ylm.grid.places takes it; or nil, message, code.
local function light_of(s, o)
  local links, message, code = transfer.of_scene(s, { threads = o.threads, progress = o.progress })
  if not links then return nil, message, code end
  local lit
  lit, message, code = links:radiosity(nil, { threads = o.threads, progress = o.progress })
  if not lit then return nil, message, code end
  local field
  field, message, code = lit:field { quantity = o.quantity, rays = 192, threads = o.threads }
  if not field then return nil, message, code end
  return { bounds = o.bounds or box_of(s),
    open = function(points)
      local validity, why, failed = field:validity(points)
      if not validity then return nil, why, failed end
      return validity:greater_equal(HALF)
    end,
    irradiance = function(points, normals)
      return probe.probe(s, { points = points, normals = normals, samples = o.samples, seed = o.seed, threads = o.threads,
        progress = o.progress, reflections = { o.quantity == "all" and 0 or 1, "all" } })
    end }
end

--- The luminance [n] that is read at places; or nil, message, code.
local function read_at(s, x, p, o)
  if x.grid then
    local E, message, code = x.grid:irradiance(p.points, p.normals, x.grid.sides and { scene = s } or nil)
    if not E then return nil, message, code end
    return places.luminance(E)
  end
  if x.bricks then return bricks.read_at(x.bricks, p) end
  local lattices, light = {}, array.zeros({ p.n }, "float")
  for k, g in ipairs(x.grids) do lattices[k] = g.lattice end
  for k, mask in ipairs(engine.shared_out(lattices, x.reader, p, x.boxed)) do
    local own, message, code = engine.look(lattices[k], x.reader, x.grids[k].probes, p, o.threads or 0)
    if not own then return nil, message, code end
    light = light + own * mask
  end
  return light
end

--- The probes that are judged: { grid } or those of a file. Or nil, message, code.
local function probes_of(x, o)
  if core.type(x) == "ylm.surface_grid" then return { grid = x } end
  if type(x) == "table" or core.type(x) == "ylm.grid" then
    if form.kind(x) ~= "ylm.grid" then return check.bad(1, "judge", "a file or a grid expected, got %s", check.describe(x)) end
    return { grid = x }
  end
  if type(x) ~= "string" or not read.is_name(x) then
    return check.bad(1, "judge",
      "a grid, light on surfaces, or a path ending in .ylmp, .three.json, .ktx2 or .npy expected, got %s", check.describe(x))
  end
  return read.file(x, o)
end

--- Refuses pictures that cannot be made.
local function check_picture(s, size)
  if not s.camera then return check.fail("judge: picture: scene %q has no camera", s.name or "?") end
  if #size ~= 2 or size[1] < 1 or size[2] < 1 or size[1] * size[2] > MOST_PLACES then
    return check.fail("judge: picture must be { width, height } with at most %d places", MOST_PLACES)
  end
end

describe "scene:judge" {
  about = "Judges probes beside paths: the irradiance that an engine reads from them at the scene's surfaces. Files are ylm's or "
    .. "others': '.ylmp', '.three.json', '.ktx2', '.npy'. Grids and light on surfaces are judged too.",
  arguments = { { "probes", "string|grid|surface_grid", "a file of probes, or a grid" }, { "options?", "table", "" } },
  options = judge_options,
  returns = { { "report", "table", "rms: over the mean; error: 99 % of places keep it, relative to the larger of theirs and the "
    .. "mean; leak: the mean of places that have less than 1 % of the mean, over it, or nil; worst: { at, normal, error, wanted, "
    .. "read: luminance }; places; mean; negative: the share of places with less than 0, which readers of .ylmp never have; "
    .. "noise: the standard error of paths, rms over the mean; bytes of the file; picture: an image, where asked for" } },
  errors = "raises on what are no probes, on bad options, and on a picture of a scene without camera; nil, message, code: 'EIO', "
    .. "'EFORMAT' (the file), 'EDOMAIN' (no surface lies within the bounds, or is seen in the picture), memory, cancelled",
  example = options.one_lamp .. [[
local grid = scene:bake { quantity = "all", probes = ylm.uniform_grid { cells = 4, lmax = 2 } }
local report = scene:judge(grid, { quantity = "all", places = 100, samples = 64 })
assert(report.rms > 0 and report.places <= 100)]],
}
function judge.judge(s, x, given)
  tracing.check_scene("judge", s)
  local o = form.options(2, "judge", judge_options, given)
  o.progress = progress.long(o.progress)
  if #s.geometry == 0 then return check.fail("judge: scene %q has no geometry, so no surfaces", s.name or "?") end
  if o.picture then check_picture(s, o.picture) end
  local probes, light, p, message, code
  probes, message, code = probes_of(x, o)
  if not probes then return nil, message, code end
  light, message, code = light_of(s, o)
  if not light then return nil, message, code end
  p, message, code = places.draw("judge", light, s, o.places, o.seed)
  if not p then return nil, message, code end
  local got
  got, message, code = read_at(s, probes, p, o)
  if not got then return nil, message, code end
  local report = engine.judge(p, got)
  local errors = places.luminance(p.variance:sqrt()) -- channels share their paths: standard errors are added
  report.noise = math.sqrt((errors * errors):mean()) / math.max(p.mean, 1e-300)
  report.mean, report.bytes, report.negative = p.mean, probes.bytes, got:less(0):sum() / p.n
  if o.picture then
    report.picture, message, code = judge_picture.of(s, o, light, function(q) return read_at(s, probes, q, o) end, p.mean)
    if not report.picture then return nil, message, code end
  end
  return show.report(report)
end

return judge
