--- ylm render scene.lua -o out.exr

local check = require "ylm.check"
local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

--- The methods of a scene; without --method it is rendered as --visibility, or a grid, says.
local methods = { default = "render", grid = "render", reference = "reference", raycast = "raycast" }

--- Which methods an option is for, where it is not for all.
local only = {
  grid = { "default", "grid" }, interpolation = { "default", "grid" }, shading = { "default", "grid", "reference" },
  gloss = { "default", "grid", "reference" }, ["gloss-error"] = { "default", "grid", "reference" },
  visibility = { "default", "grid", "reference" }, ["light-tolerance"] = { "default", "grid", "reference" },
  ["light-samples"] = { "default", "raycast" }, bounces = { "default", "grid" }, tolerance = { "default" },
  indirect = { "default", "grid" }, dering = { "default", "grid" },
  display = { "default", "grid", "raycast" },
}

local visibilities = { "rays", "transfer", "none", "self" }
local glosses = { "auto", "sh", "rays", "matte" }

local MOST_STOPS = 60 -- of image:save

--- Was it said that rays shade surfaces that gloss?
local function has_rays(given) return given.gloss == "auto" or given.gloss == "rays" end

--- Ends the command where --gloss is no way to shade, or does not fit its band.
local function check_gloss(given)
  local known = given.gloss == nil
  for _, name in ipairs(glosses) do known = known or given.gloss == name end
  if not known then
    local guess = check.guess(given.gloss, glosses)
    status.stop(status.usage, "render: --gloss is auto, sh, rays or matte, got '%s'%s", given.gloss,
      guess and (" (did you mean %s?)"):format(guess) or "")
  end
  local band = given["gloss-error"]
  if band and (band[1] < 0 or band[1] >= band[2]) then
    status.stop(status.usage, "render: --gloss-error is two numbers such as 0.01,0.03, the first from 0 to below the second")
  end
  if band and given.gloss and given.gloss ~= "auto" then
    status.stop(status.usage, "render: --gloss-error is for --gloss auto, this is %s: leave one out", given.gloss)
  end
end

--- Ends the command where an option was given that `method` has no use for.
local function refuse_idle(given, method)
  local names = {}
  for name in pairs(only) do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do
    local fits = given[name] == nil
    local fit = {}
    for _, one in ipairs(only[name]) do
      fits = fits or one == method or name == "light-samples" and has_rays(given)
      if one ~= "default" then fit[#fit + 1] = one end
    end
    if not fits then
      status.stop(status.usage, "render: --%s is for --method %s, this is %s: leave it out", name,
        table.concat(fit, " and "), method)
    end
  end
  if given.grid and given["light-tolerance"] then
    status.stop(status.usage, "render: --light-tolerance is for baking the scene's probes, --grid is baked: leave one out")
  end
end

--- The visibility that the options mean; nil: the default of scene:render or scene:reference. Ends the command where they
-- do not fit together.
local function visibility_of(given, method)
  local v = given.visibility
  if v then
    local known = false
    for _, name in ipairs(visibilities) do known = known or v == name end
    if not known then
      local guess = check.guess(v, visibilities)
      status.stop(status.usage, "render: --visibility is rays, transfer, none or self, got '%s'%s", v,
        guess and (" (did you mean %s?)"):format(guess) or "")
    end
    if v == "rays" and method ~= "default" then
      status.stop(status.usage, "render: --visibility rays is for pictures without --method %s: leave one out", method)
    end
  elseif method == "grid" and not given.grid then v = "transfer" end
  local by_rays = not given.grid and (v or "rays") == "rays" and method == "default"
  for _, name in ipairs { "interpolation", "light-tolerance" } do
    if by_rays and given[name] then
      status.stop(status.usage, "render: --%s is for grids (--grid FILE, or --visibility transfer): leave it out", name)
    end
  end
  if by_rays and (given.gloss == "sh" or given.gloss == "matte") then
    status.stop(status.usage, "render: --gloss %s is for grids (--grid FILE, or --visibility transfer): rays know materials",
      given.gloss)
  end
  if method == "default" and not by_rays and given["light-samples"] and not has_rays(given) then
    status.stop(status.usage, "render: --light-samples is for pictures by rays to the lamps (--visibility rays, "
      .. "--method raycast): leave it out")
  end
  return v
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

--- Options of --indirect virtual, by their names in the table `indirect` of scene:render.
local of_virtual = { "count", "particles", "merge", "cell", "degree", "shadows" }

--- Ends the command where --indirect is no way to find bounces.
local function check_indirect(given)
  local x = given.indirect
  for _, name in ipairs(of_virtual) do
    if given[name] ~= nil and x ~= "virtual" then
      status.stop(status.usage, "render: --%s is for --indirect virtual: leave it out, or ask for that", name)
    end
  end
  if x == nil or x == "links" or x == "virtual" then
    if x == "links" and not given.bounces then
      status.stop(status.usage, "render: --indirect links: --bounces says how many")
    end
    return
  end
  local guess = check.guess(x, { "links", "virtual" })
  status.stop(status.usage, "render: --indirect is links or virtual, got '%s'%s", x,
    guess and (" (did you mean %s?)"):format(guess) or "")
end

--- The options of scene:render, scene:reference or scene:raycast.
local function options_of(given, method)
  local options = { size = given.size, samples = given.samples, threads = given.threads, progress = report.progress(given) }
  options.light_samples = given["light-samples"]
  if method ~= "reference" then options.display = status.display("render", given.display) end
  if method == "raycast" then return options end
  options.gloss, options.gloss_error = given.gloss, given["gloss-error"]
  options.light_tolerance, options.shading = given["light-tolerance"], given.shading
  options.visibility = visibility_of(given, method)
  options.bounces, options.tolerance = status.bounces("render", given.bounces), given.tolerance
  if given.indirect == "virtual" then
    options.indirect = { method = "virtual" }
    for _, name in ipairs(of_virtual) do options.indirect[name] = given[name] end
    options.indirect.degree = tonumber(given.degree) or given.degree
  end
  if given.tolerance and (given.grid or options.visibility and options.visibility ~= "rays") then
    status.stop(status.usage, "render: --tolerance chooses how light is found, by rays: leave --%s out",
      given.grid and "grid" or "visibility")
  end
  if given.tolerance and given.shading == "vertex" then
    status.stop(status.usage, "render: --tolerance is judged at what camera rays hit: leave --shading vertex out")
  end
  if method ~= "reference" then
    options.interpolation, options.dering = given.interpolation, status.dering("render", given.dering)
  end
  return options
end

return {
  summary = "renders a scene file: by rays to its lamps, or by a grid of probes",
  usage = "SCENE.lua -o IMAGE",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the image: .exr, .png, .hdr or .pfm" },
    { "size", "-s", "WxH", "pixels, default that of the renderer" },
    { "samples", "-n", "N", "camera rays per pixel" },
    { "visibility", nil, "NAME", "rays (default: true shadows, no probes) or transfer (the papers': the scene's probes are "
      .. "baked), none, self" },
    { "bounces", "-b", "NAME", "reflections after direct light: 0 (default), 1 .. or all" },
    { "indirect", nil, "NAME", "how bounces are found: links (default) or virtual (lights of particles, which pass walls); "
      .. "virtual without --bounces is one" },
    { "count", nil, "N", "virtual: lights, at most; default 2000" },
    { "particles", nil, "N", "virtual: that are traced for them" },
    { "merge", nil, nil, "virtual: particles that land close to each other become one light" },
    { "cell", nil, "N", "virtual: with --merge, how close: the edge of a cell, scene units" },
    { "degree", nil, "NAME", "virtual: of what surfaces that gloss send: auto (default), or 0 to 8" },
    { "shadows", nil, "NAME", "virtual: none (default) or centre, a ray from each point to each light" },
    { "tolerance", nil, "N", "of the picture, 0.02 for 2 %: chooses samples, light-samples and all about bounces, judges itself "
      .. "by paths, and says whether it is met" },
    { "light-samples", nil, "N", "rays, raycast: shadow rays per shading point, default 32; raycast: 64" },
    { "gloss", nil, "NAME", "surfaces that gloss, by a grid: auto (default, rays where harmonics are too few), sh, rays, "
      .. "matte" },
    { "gloss-error", nil, "A,B", "auto: the part of a lobe that harmonics may miss: rays from A on, alone from B on; default "
      .. "0.01,0.03" },
    { "method", "-m", "NAME", "instead: grid (as --visibility transfer), reference (of grids, no interpolation) or raycast (no "
      .. "harmonics)" },
    { "grid", "-g", "FILE", "a grid baked before" },
    { "shading", nil, "NAME", "pixel (default) or vertex; not of raycast" },
    { "dering", nil, "N", "of a grid: width of the window against light below zero, in degrees, 0: none; default: chosen where "
      .. "needed" },
    { "interpolation", nil, "NAME", "of a grid: hermite, taylor or linear" },
    { "exposure", nil, "N", "of a .png, in stops" },
    { "display", nil, "ADDRESS", "HOST:PORT of an image viewer (tev) that shows the picture while it is made; not of reference" },
    { "light-tolerance", nil, "N", "sum many lights by a tree, to this part of the light; default: exactly" },
    { "strict", nil, nil, "exit status 6 where a warning is given; the image is written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "render: -o FILE says where the image goes") end
    status.need_output("render", given.output, "exr", "png", "hdr", "pfm")
    local method = given.method or "default"
    if not methods[method] or given.method == "default" then
      status.stop(status.usage, "render: --method is grid, reference or raycast, got '%s'", method)
    end
    refuse_idle(given, method)
    check_gloss(given)
    check_exposure(given)
    check_indirect(given)
    local options = options_of(given, method)
    local scene = status.need_scene(ylm.load_scene(given[1]))
    if given.grid then options.grid = status.need_kind("ylm.grid", "a grid", given.grid, ylm.load(given.grid))
    elseif methods[method] == "render" and options.visibility and options.visibility ~= "rays" and not scene.probes then
      status.stop(status.script, "%s: the scene has no probes; add some, or use --visibility rays", given[1])
    end
    local image, facts = scene[methods[method]](scene, options)
    status.need(image, facts)
    status.need(image:save(given.output, given.exposure and { exposure = given.exposure } or nil))
    report.print(given, facts, report.names(facts, { "reference", "visibility", "gloss", "bounces", "omits", "met", "error" }))
    return status.of_warnings(given, facts.warnings)
  end,
}
