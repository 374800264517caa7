--- From the radiance of shading points to an image with layers and metadata, and the report beside it.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local image = require "ylm.image"
local show = require "ylm.show"
local tracing = require "ylm.trace"

local pictures = {}

--- The radiance of shading points with all that is added to direct light, which is changed by what lies over it; `radiance`:
-- false for none. Or nil, message, code.
local function completed(name, p, radiance, o)
  local steps = {}
  for _, step in ipairs { o.glossy or false, o.nearby or false } do steps[#steps + 1] = step or nil end
  for _, over in ipairs(o.over or {}) do steps[#steps + 1] = over.radiance and { add = over.radiance } or nil end
  for _, step in ipairs(radiance and steps or {}) do
    local all, message, code = step.add(name, p, o, radiance)
    if not all then return nil, message, code end
    radiance = all
  end
  local b = o.reflected
  if not b then return radiance end
  local start = core.seconds()
  local all, message, code
  if b.gathered then all = radiance and p.lib.shade_add(b.gathered, radiance) or b.gathered
  else all, message, code = b.record.radiance(name, p, o, radiance or nil) end
  if not all then return nil, message, code end
  b.seconds = core.seconds() - start
  return all
end

--- Writes the layer radiance from that of shading points [points][3]: what is added to it, and what lies over it.
function pictures.compose(name, p, radiance, o, layer)
  local lib, view, threads = p.lib, p.view, o.threads or 0
  local all, message, code = completed(name, p, radiance, o)
  if not all then return nil, message, code end
  if o.seen then assert(check.result(name, lib.shade_resolve(view, all, nil, false, threads, o.seen))) end
  if o.direct and o.direct.bare then return check.result(name, lib.shade_resolve(view, all, nil, false, threads, layer)) end
  assert(check.result(name, lib.shade_compose(view, all, p.scene.background or { 0, 0, 0 }, threads, layer)))
  for _, over in ipairs(o.over or {}) do
    if over.draw then
      local ok
      ok, message, code = over.draw(name, p, o, layer)
      if not ok then return nil, message, code end
    end
  end
  return true
end

--- The image `out` where it has a size and layers { name, channels }; those that are missing are added.
local function with_layers(name, out, size, layers)
  if core.type(out) ~= "ylm.image" then
    return check.bad(1, name, "out: an image of %dx%d expected, got %s", size[1], size[2], check.describe(out))
  end
  if out.size[1] ~= size[1] or out.size[2] ~= size[2] then
    return check.bad(1, name, "out: an image of %dx%d expected, got one of %dx%d", size[1], size[2], out.size[1],
      out.size[2])
  end
  local _, there = out:layers()
  for _, layer in ipairs(layers) do
    if there[layer[1]] and there[layer[1]] ~= layer[2] then
      return check.bad(1, name, "out: layer %s has %d channels, %d are wanted", layer[1], there[layer[1]], layer[2])
    end
    if not there[layer[1]] then
      local ok, message, code = out:add(layer[1], layer[2])
      if not ok then return nil, message, code end
    end
  end
  return out
end

local VIEW_LAYERS = { { "normal", 3 }, { "position", 3 }, { "depth", 1 }, { "albedo", 3 }, { "coverage", 1 }, { "emitter", 1 } }

--- The layers that options ask for, { name, channels }; `cells`: of a grid.
local function layers_of(o, cells)
  local layers = { { "radiance", 3 } }
  if o.layers then
    for _, layer in ipairs(VIEW_LAYERS) do layers[#layers + 1] = layer end
    if o.glossy then layers[#layers + 1] = { "gloss", 1 } end
    if o.openness then layers[#layers + 1] = { "ambient", 1 } end
    if cells then
      layers[#layers + 1] = { "level", 1 }
      layers[#layers + 1] = { "error", 1 }
    end
  end
  if o.truth then layers[#layers + 1] = { "true_error", 3 } end
  return layers
end

--- Levels and errors of the grid's cells at shading points, where layers are asked for, nil else; or false, message, code.
local function cells_of(p, o)
  if not o.layers or core.type(o.grid) ~= "ylm.grid" then return nil end
  local level, error = p.lib.shade_grid_cells(p.view, o.grid, o.threads or 0)
  if not level then return false, error, "ENOMEM" end
  return { level = level, error = error }
end

--- Writes the layers of surfaces.
local function write_layers(name, p, o, out, cells)
  local lib, view, threads = p.lib, p.view, o.threads or 0
  local function done(...) return assert(check.result(name, ...)) end
  for _, layer in ipairs(VIEW_LAYERS) do done(lib.shade_layer(view, layer[1], threads, out:layer(layer[1]))) end
  if o.glossy then done(lib.shade_resolve(view, o.glossy.share, nil, true, threads, out:layer "gloss")) end
  if o.openness then done(lib.shade_resolve(view, o.openness, { 1 }, true, threads, out:layer "ambient")) end
  if cells then
    done(lib.shade_resolve(view, cells.level, nil, true, threads, out:layer "level"))
    done(lib.shade_resolve(view, cells.error, nil, true, threads, out:layer "error"))
  end
end

--- An image with the layers asked for; `radiance` [points][3], false for none, or what writes that layer:
-- function(layer) -> true.
function pictures.picture(name, p, radiance, o)
  local cells, message, code = cells_of(p, o)
  if cells == false then return nil, message, code end
  local out
  if o.out then out, message, code = with_layers(name, o.out, p.options.size, layers_of(o, cells))
  else out, message, code = image.image { size = p.options.size, layers = layers_of(o, cells) } end
  if not out then return nil, message, code end
  local ok
  if type(radiance) == "function" then ok, message, code = radiance(out:layer "radiance")
  else ok, message, code = pictures.compose(name, p, radiance, o, out:layer "radiance") end
  if not ok then return nil, message, code end
  if o.layers then write_layers(name, p, o, out, cells) end
  if o.truth then pictures.true_error(out, o.truth) end
  return out
end

local convention = "real orthonormal, Condon-Shortley phase, index l(l+1)+m"

--- Writes how an image came about into its metadata: no times, so that equal runs are equal files.
function pictures.sign(out, p, method, report, extra)
  local m, o = out.metadata, p.options
  m.software, m.version = "ylm", (core.info())
  m.scene, m.method = p.scene.name or "", method
  m.lmax, m.convention = o.lmax, convention
  m.samples, m.seed, m.shading, m.visibility = o.samples, o.seed, o.shading, o.self and "self" or o.visibility
  if o.visibility ~= "rays" then
    m.transfer_samples, m.occlusion_distance = o.transfer_samples, tostring(o.occlusion_distance)
  end
  if report.gloss and report.gloss ~= "matte" then m.gloss = report.gloss end
  m.points = report.points
  if report.occlusion then
    m.light_passing, m.light_missing = ("%.3g"):format(report.occlusion.passing), ("%.3g"):format(report.occlusion.missing)
  end
  for key, value in pairs(extra or {}) do if value ~= nil then m[key] = tostring(value) end end
end

--- The report that all methods begin with; seconds.light is that of asking for light and shading.
function pictures.new_report(p)
  local st = p.stats
  return show.report {
    note = st.points == 0 and "the camera sees no geometry: nothing to shade" or nil,
    notes = p.scene.notes,
    warnings = { p.traced.shortfall },
    visibility = p.options.self and "self" or p.options.visibility,
    points = st.points, hits = st.hits, pixels = st.pixels, bytes = st.bytes,
    rays = { primary = st.primary_rays, occlusion = st.occlusion_rays },
    transfer_samples = st.transfer_samples, noise = st.noise,
    seconds = { scene = st.scene_seconds, primary = st.primary_seconds, transfer = st.transfer_seconds },
  }
end

--- Completes times: layers since `start` without light; total of everything that this picture needed.
function pictures.finish(report, start, light_seconds)
  local s = report.seconds
  s.light = light_seconds
  s.image = core.seconds() - start - light_seconds
  s.total = s.scene + s.primary + s.transfer + (s.occlusion or 0) + s.light + s.image
  return report
end

describe "true_error" {
  shelf = "comparison",
  about = "Adds to an image the layer true_error: |radiance - truth's radiance|, per channel.",
  arguments = { { "image", "image", "" }, { "truth", "image", "of the same size, e.g. by = 'sum'" } },
  returns = { { "image", "image", "the first argument" } },
  errors = "raises where the sizes differ or a layer is missing",
  example = [[
local a, b = ylm.image { size = { 4, 2 } }, ylm.image { size = { 4, 2 } }
a:layer():set(1, 1, 1, 0.5)
assert(ylm.true_error(a, b):layer "true_error":get(1, 1, 1) == 0.5)]],
}
function pictures.true_error(picked, truth)
  for n, x in ipairs { picked or false, truth or false } do
    if core.type(x) ~= "ylm.image" then
      return check.bad(n, "true_error", "an image expected, got %s", check.describe(x))
    end
  end
  local a, b = picked.size, truth.size
  if a[1] ~= b[1] or a[2] ~= b[2] then
    return check.bad(2, "true_error", "an image of %dx%d expected, got %dx%d", a[1], a[2], b[1], b[2])
  end
  local lib, message, code = tracing.library()
  if not lib then return nil, message, code end
  local _, channels = picked:layers()
  local out
  if channels.true_error then out = picked:layer "true_error"
  else
    out, message, code = picked:add("true_error", 3)
    if not out then return nil, message, code end
  end
  assert(check.result("true_error", lib.shade_difference(picked:layer "radiance", truth:layer "radiance", out)))
  return picked
end

--- Raises where the option truth is an image of another size than the view.
function pictures.check_truth(name, p, o)
  if not o.truth then return end
  local size = o.truth.size
  if size[1] ~= p.options.size[1] or size[2] ~= p.options.size[2] then
    return check.fail("%s: truth must be an image of %dx%d, got %dx%d", name, p.options.size[1], p.options.size[2],
      size[1], size[2])
  end
end

return pictures
