--- mesh:unwrap: texture coordinates for a mesh that has none.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local progress = require "ylm.progress"
local show = require "ylm.show"

local unwrap = {}

--- Options of charts, which scene:lightmap shares.
unwrap.fields = {
  { "gutter", "integer", min = 0, max = 64, default = 1, unit = "texels", about = "between the texels of two charts, at least" },
  { "angle", "number", min = 1, max = 80, default = 60, unit = "degrees", shelf = "experiments",
    about = "between a triangle's normal and the mean of its chart's, at most" },
  { "stretch", "number", min = 1.001, max = 10, default = 1.05, shelf = "experiments",
    about = "of a chart at most, root mean square; 1: none. A chart with more is cut in two" },
}

local options = {
  { "texels", "integer", min = 16, max = 2 ^ 28, default = 2 ^ 16, about = "of the whole picture, gutters included, at most" },
  { "density", "number", above = 0, max = 1e30, optional = true, unit = "texels per scene unit",
    about = "instead of texels; the picture is then as large as it takes" },
}
for _, field in ipairs(unwrap.fields) do options[#options + 1] = field end
options[#options + 1] = form.threads
options[#options + 1] = form.progress

describe "mesh:unwrap" {
  about = "Texture coordinates for a mesh: charts grown over triangles that face about the same way, flattened with little "
    .. "stretch, and packed into one picture. No two charts share a texel of bilinear look-ups, and none covers a place twice. "
    .. "The mesh stays as it is; the new one has its triangles in their order, its normals, colours and first texture "
    .. "coordinates. Vertices are split where charts end. Triangles without area get a point. Results are the same for any "
    .. "number of threads.",
  arguments = { { "options?", "table", "see the options" } },
  options = options,
  returns = {
    { "flat", "table", "mesh: the new mesh; uvs: float [n][2], u to the right, v upwards, 0 to 1; vertices: int32 [n], which of "
      .. "the old vertices each was; charts: int32 [m], of each triangle, 0: none" },
    { "report", "table", "triangles; charts; curved: charts that are not nearly flat; degenerate: triangles without area; "
      .. "crowded: edges of more than two triangles, or of two that face opposite ways, where charts end; stretch: root mean "
      .. "square over the area, of which 1 is none; worst: of the chart with the most; width, height; density: texels per scene "
      .. "unit; share: of all texels, those that charts are looked up from; seconds" },
  },
  errors = "raises on what is not a mesh, on a bad option, and where no triangle has an area; nil, message, code: memory, "
    .. "cancelled, and 'ELIMIT' where the charts do not fit into the texels, or a picture of 16384 texels a side",
  example = [[
local torus = ylm.torus { radius = 1, tube = 0.3 }.mesh
local flat, report = torus:unwrap { texels = 128 * 128 }
assert(#flat.mesh == #torus and #flat.uvs == #flat.vertices)
assert(report.width * report.height <= 128 * 128 and report.stretch < 1.05 and report.share > 0.6)]],
  source = "Liu et al. 2008 for flattening; Sander et al. 2001 for stretch",
}
--- The method, of a mesh that has been checked.
function unwrap.unwrap(mesh, given)
  local o, start = form.options(1, "unwrap", options, given), core.seconds()
  local made, uvs, vertices, charts, report = check.result("unwrap", core.mesh_unwrap(mesh, { angle = o.angle,
    stretch = o.stretch, gutter = o.gutter, texels = o.texels, density = o.density, threads = o.threads,
    progress = progress.of(o.progress) }))
  if not made then return nil, uvs, vertices end
  report.seconds = core.seconds() - start
  return { mesh = made, uvs = uvs, vertices = vertices, charts = charts }, show.report(report)
end

return unwrap
