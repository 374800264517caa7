--- Options that the ways to render a scene have in common.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local light = require "ylm.light"

local options = {}

--- Shadow rays per shading point, where nobody says how many: their noise is measured in docs/performance.md.
options.LIGHT_SAMPLES = 32

options.common = {
  form.threads,
  { "progress", "progress", optional = true,
    about = "called as f(done, total, stage), returning false cancels; { f, every = seconds }: so often, default 0.1; true draws "
      .. "a bar, as work of more than two seconds does on a terminal; false draws none" },
}

function options.list(...)
  local all = {}
  for _, fields in ipairs { ... } do
    for _, field in ipairs(fields) do all[#all + 1] = field end
  end
  return all
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
  { "samples", "integer", min = 1, max = core.limits.camera_samples, default = 16, about = "camera rays per pixel, stratified" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
  { "share", "number", min = 0, default = 1.5, unit = "pixel widths",
    about = "samples of a pixel that hit one mesh this near to each other, normals within 10 degrees, "
      .. "are shaded as one; 0: every sample is shaded" },
}

options.transfer_fields = {
  { "shading", "choice", of = { "pixel", "vertex" }, default = "pixel",
    about = "shade what camera rays hit, or the vertices of the triangles they hit (colours are interpolated)" },
  { "visibility", "choice", of = { "rays", "transfer", "none", "self" }, optional = true,
    about = "'rays': rays to the lamps, whose shadows are true (default without a grid of lights); 'transfer': occlusion rays "
      .. "by direction, projected into transfer vectors, as the papers do; 'none': no occlusion; 'self': 'transfer' whose rays "
      .. "meet the own surface alone, for shadowed light, whose casters are the others (ylm.shadowed)" },
  { "vectors_at", "choice", of = { "points", "vertices" }, default = "points",
    about = "'transfer': where transfer vectors are found: at shading points, or at vertices, between which they are "
      .. "interpolated" },
  { "transfer_samples", "integer", min = 1, max = core.limits.light_samples, optional = true,
    about = "'transfer': occlusion rays per transfer vector; default: 128, 256 from vertices, doubled until the noise that they "
      .. "leave under the scene's lights is at most 2 %, at most 2048 (report.transfer_samples, report.noise)" },
  { "occlusion_distance", "distance", optional = true, unit = "scene units",
    about = "'transfer': how far occlusion rays reach, wherever the lamps are: light passes what is farther, and "
      .. "what is nearer darkens lamps before it too; default: a tenth of the diagonal of the scene's bounding box" },
  { "lmax", "integer", min = 0, max = core.limits.lmax, optional = true,
    about = "highest degree of light and transfer; default: the grid's, the probes', or 4" },
}

options.layer_fields = {
  { "layers", "boolean", default = true,
    about = "also normal, position, depth, albedo, coverage, emitter, and of a grid level and error" },
  { "truth", "object", of = "ylm.image", optional = true,
    about = "an image of the same size: adds the layer true_error, |radiance - truth|" },
}

options.grid_fields = {
  { "grid", "any", optional = true, about = "what scene:bake or ylm.bake returned; of a prepared view also lights, asked at "
    .. "every point" },
  { "interpolation", "choice", of = { "hermite", "taylor", "linear" }, default = "hermite",
    about = "of the grid" },
  { "bias", "number", min = 0, max = core.limits.grid_bias, optional = true,
    about = "of a grid whose light jumps at surfaces: factor of the distance at which it is looked up beside them, in "
      .. "thicknesses of a voxel, at most half of the way to the next surface; 0: at the points themselves. Default: the "
      .. "grid's (grid.bias); report.bias = { mean, largest }, scene units" },
  { "device", "gpu", optional = true,
    about = "a gpu of ylm.vulkan.open samples the grid, shades and filters; report.stages has its times" },
}

-- Of the bake that a render by transfer vectors without a grid makes first.
options.baked_fields = { light.tolerance_option "light_tolerance" }

-- Of pictures by rays to the lamps.
options.direct_fields = {
  { "light_samples", "integer", min = 1, max = core.limits.light_samples, optional = true,
    about = "'rays': shadow rays per shading point, default " .. options.LIGHT_SAMPLES .. "; where surfaces gloss per mesh in a "
      .. "pixel, and as many again by the material. With gloss = 'auto' or 'rays': of these surfaces, as scene:reference" },
}

options.reference_fields = {
  { "dtype", "choice", of = { "float", "double" }, default = "float", about = "in which light is summed" },
  light.tolerance_option "light_tolerance",
  { "lights", "any", optional = true,
    about = "what is summed in place of the scene's lights: a light, a list of lights, or what has a light field, as "
      .. "shadowed light" },
}

options.ray_fields = {
  { "light_samples", "integer", min = 1, max = core.limits.light_samples, default = 64,
    about = "shadow rays per shading point; where a surface is not matte as many rays again by its material, in batches of "
      .. "16, of which there are two at least" },
  { "shadows", "boolean", default = true, about = "false: nothing occludes" },
}

-- Of raycast, which makes its own views.
options.noise_fields = {
  { "variance", "boolean", default = false,
    about = "samples are cast as 16 pictures with random numbers of their own, one camera ray each at least: their mean, and "
      .. "the layer variance, that of it" },
}

--- A scene for examples.
options.one_lamp = [[
local scene = ylm.scene "one lamp" {
  camera = ylm.camera { from = { 0, 3, 4 } },
  geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1, radiance = 50 } },
}
]]

--- Fields of every report.
options.report_text = "note (where nothing is to be shaded), notes (about files of the scene, where there are any), "
  .. "warnings (a list of sentences: what the picture does not keep), "
  .. "seconds (by stage: scene, primary, transfer, light, image; total), rays, points, hits, pixels; "
  .. "by rays to lamps direct_noise: what shadow rays leave at a shading point, root mean square over the mean; by links "
  .. "indirect_noise, that of the light that bounces, and elements_error (as lit.stats); "
  .. "transfer_samples, and where they were chosen noise: the root mean square deviation that they leave in the radiance, "
  .. "relative to it plus a tenth of its mean; "

--- Fields of reports about pictures by transfer vectors.
options.transfer_text = options.report_text .. "stages (of points that gloss, seconds of all threads: rows of tables, rotation, "
  .. "product, light, dot); gloss (of surfaces that gloss: auto, sh, rays, matte; but for matte glossy: "
  .. "points, of these sh by harmonics and rays by rays, both where they are mixed, and missed, the part of their lobes' norm "
  .. "that lmax misses, root mean square over those by harmonics; light_samples and, where they were chosen, which makes these "
  .. "the mean of pixels, noise, root mean square over that of the radiance, of the mesh that has most (noise_of says so); "
  .. " rays.gloss and "
  .. "seconds.gloss_rays; gloss_bytes, memory of tables, which materials keep, and seconds.gloss, a part of transfer: that "
  .. "those took which were not there); "
  .. "visibility (rays, transfer, none; grid: the shadows are those that the grid "
  .. "holds); by transfer vectors occlusion (of the light that the scene's lamps bring: passing, the part of the "
  .. "picture's that occluders stop in the scene, missing, the part of the scene's that the picture lacks, their standard "
  .. "errors passing_error and missing_error, points, rays; measured once a view, in seconds.occlusion); "
  .. "of shadowed light shadow: what its stats count, of this picture; "

return options
