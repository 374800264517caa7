--- ylm render scene.lua -o out.exr

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local methods = { grid = "render", reference = "reference", raycast = "raycast" }

return {
  summary = "renders a scene file, baking its probes first",
  usage = "SCENE.lua -o IMAGE",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the image: .exr, .png, .hdr or .pfm" },
    { "size", "-s", "WxH", "pixels, default that of the renderer" },
    { "samples", "-n", "N", "per pixel" },
    { "method", "-m", "NAME", "grid (default), reference (no interpolation) or raycast" },
    { "grid", "-g", "FILE", "a grid baked before; without it the scene's probes are baked" },
    { "shading", nil, "NAME", "pixel or vertex" },
    { "interpolation", nil, "NAME", "hermite, taylor or linear" },
    { "exposure", nil, "N", "of a .png, in stops" },
    { "light_tolerance", nil, "N", "sum many lights by a tree, to this part of the light; default: exactly" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "render: -o FILE says where the image goes") end
    status.need_output("render", given.output, "exr", "png", "hdr", "pfm")
    local method = given.method or "grid"
    if not methods[method] then
      status.stop(status.usage, "render: --method is grid, reference or raycast, got '%s'", method)
    end
    local scene = status.need_scene(ylm.load_scene(given[1]))
    local options = { size = given.size, samples = given.samples, threads = given.threads,
      progress = report.progress(given) }
    if method ~= "raycast" then options.light_tolerance = given.light_tolerance end
    if method == "grid" then
      options.shading, options.interpolation = given.shading, given.interpolation
      if given.grid then options.grid = status.need_kind("ylm.grid", "a grid", given.grid, ylm.load(given.grid))
      elseif not scene.probes then
        status.stop(status.script, "%s: the scene has no probes; add some, or use --method reference", given[1])
      end
    end
    local image, facts = scene[methods[method]](scene, options)
    status.need(image, facts)
    status.need(image:save(given.output, given.exposure and { exposure = given.exposure } or nil))
    if type(facts) == "table" then report.print(given, facts) end
  end,
}
