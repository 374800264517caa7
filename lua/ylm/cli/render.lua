--- ylm render scene.lua -o out.exr

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local methods = { grid = "render", reference = "reference", raycast = "raycast" }

--- Which methods an option is for, where it is not for all.
local only = {
  grid = { "grid" }, interpolation = { "grid" }, shading = { "grid", "reference" }, light_tolerance = { "grid", "reference" },
  ["light-samples"] = { "raycast" },
}

local MOST_STOPS = 60 -- of image:save

--- Ends the command where an option was given that `method` has no use for.
local function refuse_idle(given, method)
  local names = {}
  for name in pairs(only) do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do
    local fits = given[name] == nil
    for _, one in ipairs(only[name]) do fits = fits or one == method end
    if not fits then
      status.stop(status.usage, "render: --%s is for --method %s, this is %s: leave it out", name,
        table.concat(only[name], " and "), method)
    end
  end
  if given.grid and given.light_tolerance then
    status.stop(status.usage, "render: --light_tolerance is for baking the scene's probes, --grid is baked: leave one out")
  end
end

--- Ends the command where --exposure is out of range or the image has none.
local function check_exposure(given)
  local stops = given.exposure
  if not stops then return end
  if math.abs(stops) > MOST_STOPS then
    status.stop(status.usage, "render: --exposure is from -%d to %d stops, got %g", MOST_STOPS, MOST_STOPS, stops)
  end
  if not given.output:lower():find "%.png$" then
    status.stop(status.usage, "render: --exposure is of a .png: %s holds radiance as it is", given.output)
  end
end

--- The options of scene:render, scene:reference or scene:raycast.
local function options_of(given, method)
  local options = { size = given.size, pixel_samples = given.samples, threads = given.threads, progress = report.progress(given) }
  if method == "raycast" then options.light_samples = given["light-samples"]
  else options.light_tolerance, options.shading = given.light_tolerance, given.shading end
  if method == "grid" then options.interpolation = given.interpolation end
  return options
end

return {
  summary = "renders a scene file, baking its probes first",
  usage = "SCENE.lua -o IMAGE",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the image: .exr, .png, .hdr or .pfm" },
    { "size", "-s", "WxH", "pixels, default that of the renderer" },
    { "samples", "-n", "N", "camera rays per pixel" },
    { "method", "-m", "NAME", "grid (default), reference (no interpolation) or raycast (no harmonics)" },
    { "light-samples", nil, "N", "raycast: shadow rays per shading point" },
    { "grid", "-g", "FILE", "a grid baked before; without it the scene's probes are baked" },
    { "shading", nil, "NAME", "grid, reference: pixel or vertex" },
    { "interpolation", nil, "NAME", "grid: hermite, taylor or linear" },
    { "exposure", nil, "N", "of a .png, in stops" },
    { "light_tolerance", nil, "N", "sum many lights by a tree, to this part of the light; default: exactly" },
    { "strict", nil, nil, "exit status 6 where a warning is given; the image is written" },
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
    refuse_idle(given, method)
    check_exposure(given)
    local scene = status.need_scene(ylm.load_scene(given[1]))
    local options = options_of(given, method)
    if given.grid then options.grid = status.need_kind("ylm.grid", "a grid", given.grid, ylm.load(given.grid))
    elseif method == "grid" and not scene.probes then
      status.stop(status.script, "%s: the scene has no probes; add some, or use --method reference", given[1])
    end
    local image, facts = scene[methods[method]](scene, options)
    status.need(image, facts)
    status.need(image:save(given.output, given.exposure and { exposure = given.exposure } or nil))
    report.print(given, facts)
    return status.of_warnings(given, facts.warnings)
  end,
}
