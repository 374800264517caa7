--- Options that the ways to render a scene have in common.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local light = require "ylm.light"

local options = {}

--- Shadow rays per shading point, where nobody says how many: their noise is measured in docs/performance.md.
options.LIGHT_SAMPLES = 32
--- Camera rays of a pixel, likewise.
options.SAMPLES = 16

--- How many times as many rays as usual a shading point has, by options of its view: as camera rays are more than usual, where
-- they share shading points.
function options.multiple(view)
  return view.share > 0 and math.max(1, view.samples / options.SAMPLES) or 1
end

options.common = {
  form.threads,
  { "progress", "progress", optional = true,
    about = "called as f(done, total, stage), returning false cancels; { f, every = seconds }: so often, default 0.1; true draws "
      .. "a bar, as work of more than two seconds does on a terminal; false draws none" },
}

--- Arguments 1 and 2 of a method `name`: places on surfaces, and a normal of each.
function options.places_with_normals(name, points, normals)
  local x = array.places(1, name, points)
  local n = array.points(2, name, normals, "float", "normals")
  if #x ~= #n then return check.bad(2, name, "%d normals expected, one a point, got %d", #x, #n) end
  return x, n
end

function options.list(...)
  local all = {}
  for _, fields in ipairs { ... } do
    for _, field in ipairs(fields) do all[#all + 1] = field end
  end
  return all
end

--- The names of the fields of lists, as a set.
function options.names(...)
  local set = {}
  for _, field in ipairs(options.list(...)) do set[field[1]] = true end
  return set
end

function form.types.image_size(x)
  local function good(n) return check.is_integer(n) and n >= 1 and n <= core.limits.image_side end
  if type(x) == "table" and #x == 2 and good(x[1]) and good(x[2]) then return { x[1], x[2] } end
  return nil, ("{ width, height }, integers from 1 to %d"):format(core.limits.image_side)
end

--- A positive number, infinity included.
function form.types.distance(x)
  if type(x) == "number" and x > 0 then return x end
  return nil, "a number > 0 (math.huge: no end)"
end

options.view_fields = {
  { "size", "image_size", default = { 1280, 720 }, unit = "pixels", about = "{ width, height }" },
  { "samples", "integer", min = 1, max = core.limits.camera_samples, default = options.SAMPLES,
    about = "camera rays per pixel, stratified; above 16 shading points have as many times more rays to lamps and links, "
      .. "unless their numbers are given or share is 0" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
  { "share", "number", min = 0, default = 1.5, unit = "pixel widths",
    about = "samples of a pixel that hit one mesh this near to each other, normals within 10 degrees, "
      .. "are shaded as one; 0: every sample is shaded" },
}

--- Shades what camera rays hit, or vertices.
options.shading_fields = {
  { "shading", "choice", of = { "pixel", "vertices" }, default = "pixel",
    about = "shade what camera rays hit, or the vertices of the triangles they hit (colours are interpolated)" },
}

--- The option visibility with these choices.
local function visibility_field(of)
  return { "visibility", "choice", of = of, optional = true,
    about = "'rays': rays to the lamps, whose shadows are true (default by rays, and of a prepared view); 'transfer': occlusion "
      .. "rays by direction, projected into transfer vectors, as the papers do (default by sum, and of a grid of lights); "
      .. "'none': no occlusion; 'self': 'transfer' whose rays meet the own surface alone, for shadowed light, whose casters are "
      .. "the others (ylm.shadowed)" }
end
options.visibility = visibility_field { "rays", "transfer", "none", "self" }
options.visibility_of_rays = visibility_field { "rays", "none" }
options.visibility_of_sum = visibility_field { "transfer", "none", "self" }

--- About transfer vectors.
options.vector_fields = {
  { "vectors_at", "choice", of = { "points", "vertices" }, default = "points", shelf = "experiments",
    about = "'transfer': where transfer vectors are found: at shading points, or at vertices, between which they are "
      .. "interpolated" },
  { "transfer_samples", "integer", min = 1, max = core.limits.light_samples, optional = true, shelf = "experiments",
    about = "'transfer': occlusion rays per transfer vector; default: 128, 256 from vertices, doubled until the noise that they "
      .. "leave under the scene's lights is at most 2 %, at most 2048 (report.transfer_samples, report.noise)" },
  { "occlusion_distance", "distance", optional = true, unit = "scene units", shelf = "experiments",
    about = "'transfer': how far occlusion rays reach, wherever the lamps are: light passes what is farther, and "
      .. "what is nearer darkens lamps before it too; default: a tenth of the diagonal of the scene's bounding box" },
}

options.lmax_field = { "lmax", "integer", min = 0, max = core.limits.lmax, optional = true,
  about = "highest degree of light and transfer; default: the grid's, the probes', or 4" }

--- How a prepared view shades: all of it.
options.prepare_fields = options.list(options.shading_fields, { options.visibility }, options.vector_fields,
  { options.lmax_field })

options.layer_fields = {
  { "layers", "boolean", default = true,
    about = "also normal, position, depth, albedo, coverage, emitter, and of a grid level and error" },
  { "truth", "object", of = "ylm.image", optional = true, shelf = "comparison",
    about = "an image of the same size: adds the layer true_error, |radiance - truth|" },
}

--- How a grid is looked up.
options.sample_fields = {
  { "interpolation", "choice", of = core.choices "interpolation", default = "hermite",
    shelf = "experiments", about = "of the grid" },
}

options.grid_fields = options.list({
  { "grid", "any", optional = true, about = "what scene:bake or ylm.bake returned; of a prepared view also lights, asked at "
    .. "every point" },
}, options.sample_fields, {
  { "device", "gpu", optional = true, shelf = "experiments",
    about = "a gpu of ylm.vulkan.open samples the grid, shades and filters; report.stages has its times" },
})

--- Elements that rays of glossy surfaces find, where a grid's degree is too low.
options.element_field = { "links", "object", of = "ylm.links", optional = true, shelf = "experiments",
  about = "by a grid: elements, what scene:links returned, that rays of glossy surfaces find where the grid's degree is too "
    .. "low for their lobes" }

options.sums_field = light.tolerance_option "sums_tolerance"

options.light_samples = { "light_samples", "integer", min = 1, max = core.limits.light_samples, optional = true,
  about = "by rays: shadow rays per shading point, default " .. options.LIGHT_SAMPLES .. ", of more than 16 samples twice as "
    .. "many as these; of surfaces with narrow lobes per mesh in a pixel, and as many again by the material, in batches of 16, "
    .. "of which there are two at least. By grid and by sum: rays to lamps from the points of a "
    .. "glossy mesh in a pixel, and as many by the material; default: " .. options.LIGHT_SAMPLES
    .. " to 16384, most where they vary most, as few as leave a noise of 1 % in each mesh's radiance (report.glossy)" }

options.guides = { "guides", "boolean", default = true, shelf = "experiments",
  about = "by rays, shadow rays of matte points, and of pictures by paths those of all points, learn from a pilot which lamps "
    .. "and which parts of the sky are seen from where; of paths also directions of reflection at points that gloss little, and "
    .. "where paths end; with noise or denoise links learn which elements send light: no bias, less noise; false: they do not" }

options.lights_field = { "lights", "any", optional = true,
  about = "lights in place of the scene's. By rays they may move; default with bounced = lit: those of lit. By sum and by "
    .. "vectors a light, a list of lights, or what has a light field, as shadowed light" }

options.dtype_field = { "dtype", "choice", of = core.choices "dtype", default = "float", shelf = "comparison",
  about = "in which light is summed" }

--- Light that bounces.
options.bounce_fields = {
  { "bounces", "bounces", optional = true,
    about = "reflections after direct light: 0, 1, 2 .. or 'all'. Default: 'all' of scene:render by rays and by paths, where a "
      .. "scene has surfaces and lights, and wherever bounced is named; else 0, which the report says" },
  { "bounced", "any", optional = true,
    about = "how light that bounces is found: 'links' (default), along rays to surfaces; 'virtual', by virtual lights; or what "
      .. "finds it: what scene:links, t:radiosity or scene:surface_grid returned, a grid of indirect light, or virtual lights "
      .. "(scene:virtual_lights); with near_lights a grid of the far parts of these" },
}

--- The seed of a picture of a prepared view.
options.seed_field = { "seed", "integer", min = 0, max = core.limits.seed, optional = true, shelf = "experiments",
  about = "of rays to lamps, and of estimates by virtual lights; default: that of the view" }

--- A scene for examples.
options.one_lamp = [[
local scene = ylm.scene "one lamp" {
  camera = ylm.camera { from = { 0, 3, 4 } },
  geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 } },
  links = ylm.links { spacing = 0.5, rays = 16 }, -- how surfaces are cut where light bounces
}
]]

return options
