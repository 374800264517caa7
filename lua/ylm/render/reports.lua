--- Fields of reports about pictures: name, unit (or type), what it says. `ylm help view:render` prints them.

local reports = {}

local all = {
  { "note", "string", "where nothing is to be shaded, or nothing shines" },
  { "notes", "string[]", "about files of the scene, where there are any" },
  { "warnings", "string[]", "what the picture does not keep" },
  { "seconds", "s", "by stage: scene, primary, transfer, occlusion, bounces, light, denoise (a part of light), bounced, image, "
    .. "judge; total" },
  { "points", "1", "shading points" },
  { "hits", "1", "camera rays that hit a surface" },
  { "pixels", "1", "of the picture" },
  { "bytes", "B", "memory of the view" },
  { "rays", "1", "that were traced, by kind: primary, occlusion, shadow, guides, targets, links, gloss, gloss_links, virtual; by "
    .. "paths nearest, lamps" },
  { "visibility", "word", "rays, transfer, self or none; grid: shadows are those that the grid holds; vectors" },
}

local by_rays = {
  { "light_samples", "1", "by rays: shadow rays of a shading point" },
  { "guides", "1", "by rays and paths: clusters of points that rays were guided by" },
  { "targets", "1", "by rays: groups of elements that links were aimed at; none where links that go as the cosine have little "
    .. "noise" },
  { "noise", "1", "by rays, of a picture with a noise that is wanted: what is left, root mean square over pixels, each relative "
    .. "to the light around it; ended is then noise, samples, pilot, time_limit, most rays, filter "
    .. "or cancelled" },
  { "noise_before", "1", "where it was filtered: what was left before" },
  { "elements_noise", "1", "by rays: what shadow rays of elements leave in the picture, in the measure of noise, which does not "
    .. "hold it: all pixels that see an element share it; of one sample" },
  { "denoise", "table", "where noise was filtered: what rays of their own at `pixels` random pixels find. z2: the squared "
    .. "distance of the picture from them over what the noise of both makes of it, 1 where nothing else is between them; bias: "
    .. "of the mean of the pixels, relative, with its standard error, uncertainty; unseen: the noise of direct light that they "
    .. "find beyond that of the halves, a part of report.noise; seconds" },
  { "direct_noise", "1", "by rays: what shadow rays leave at a shading point, root mean square over the mean" },
}

local by_coefficients = {
  { "transfer_samples", "1", "occlusion rays of a transfer vector" },
  { "noise", "1", "where these were chosen: the root mean square deviation that they leave in the radiance, relative to it plus "
    .. "a tenth of its mean" },
  { "occlusion", "table", "of the light that the scene's lamps bring: passing, the part of the picture's that occluders stop in "
    .. "the scene; missing, the part of the scene's that the picture lacks; passing_error, missing_error, their standard errors; "
    .. "points, rays, seconds. Measured once a view" },
  { "stages", "s", "of glossy points, of all threads: rows of tables, rotation, product, light, dot; of a device its own" },
  { "gloss", "word", "how glossy surfaces are shaded: auto, sh, rays, matte" },
  { "glossy", "table", "points; of these sh by harmonics and rays by rays, both where they are mixed; missed, the part of "
    .. "their lobes' norm that lmax misses, root mean square over those by harmonics; light_samples; noise, where these "
    .. "were chosen, of the mesh that has most" },
  { "gloss_bytes", "B", "memory of tables, which materials keep" },
  { "shadow", "table", "of shadowed light: what its stats count, of this picture" },
  { "pairs", "1", "light x point evaluations" },
  { "outside", "1", "shading points outside of the grid" },
  { "unbaked", "1", "shading points in voxels that are not baked" },
  { "fresh", "1", "of a dynamic grid: shading points that were sampled" },
  { "dering", "table", "before, after: the part of the picture's light below zero; width of the window; clipped: the part that "
    .. "became 0" },
  { "near", "table", "of near_lights: lights, core, pairs" },
  { "reference", "string", "by sum: of what it is the reference" },
}

local of_bounces = {
  { "bounces", "1", "reflections after direct light, or whose they are" },
  { "omits", "string", "light that the picture lacks" },
  { "bounced", "word", "how light that bounces was found: links, grid, virtual" },
  { "links", "1", "of a shading point" },
  { "bounced_noise", "1", "what links leave at a shading point, root mean square over the mean" },
  { "elements", "1", "that links meet" },
  { "elements_error", "1", "as lit.stats" },
  { "balance", "1", "as lit.stats" },
  { "bounced_glossy", "table", "of a grid that bounces are from: sh, rays, missed, as glossy" },
  { "virtual", "table", "lights, pairs, shadows, sums, emitted (the report of scene:virtual_lights), subset, singular: pairs of "
    .. "a shading point and a light without size at its place, which count as nothing; ns_per_pair; of 'stochastic' alpha, and "
    .. "kept, lights of a point in the mean; of far and near parts error, tolerance, grid, merged, tries; of a rival its name, "
    .. "limit, groups" },
  { "passing", "1", "of virtual lights without shadows: the part of their light that passes walls" },
}

local others = {
  { "ambient", "table", "method, radius (scene units)" },
  { "bodies", "table", "count, vertices, rays, seconds" },
  { "tolerance", "1", "that was asked for, by rays" },
  { "met", "boolean", "is it kept?" },
  { "error", "1", "of the picture, as it was judged" },
  { "chosen", "table", "samples, share, light_samples, rays, spacing, elements" },
  { "causes", "table", "of the error: pixels, direct, links, elements" },
  { "judged", "table", "pixels, samples, rays, uncertainty, most, sure, seconds" },
}

--- Fields about paths; noise is then theirs.
reports.of_paths = {
  { "samples", "1", "by paths: of a pixel or point, whole batches" },
  { "noise", "1", "by paths: the mean over pixels or points of the standard error relative to the value" },
  { "ended", "word", "by paths: samples, tolerance or time_limit" },
  { "paths", "1", "that were traced" },
  { "absorbed", "1", "paths that normals of vertices sent below a surface" },
  { "lost", "1", "contributions that were no finite numbers" },
}

local function joined(...)
  local list = {}
  for _, part in ipairs { ... } do
    for _, field in ipairs(part) do list[#list + 1] = field end
  end
  return list
end

--- Of every picture.
reports.fields = joined(all, by_rays, by_coefficients, of_bounces, others, reports.of_paths)

--- Of scene:probe.
reports.of_probe = joined({ { "note", "string", "where there are no lights" } }, reports.of_paths, {
  { "rays", "1", "nearest, lamps, shadow" },
  { "seconds", "s", "of all paths" },
})

--- The words for a report in the returns of an entry.
reports.text = "its fields are below"

return reports
