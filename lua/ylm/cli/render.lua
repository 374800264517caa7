--- ylm render scene.lua -o out.exr

local check = require "ylm.check"
local core = require "ylm.c.core"
local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local exposures = require "ylm.cli.exposures"

local choices = {
  by = { "rays", "grid", "sum" }, visibility = { "rays", "transfer", "none", "self" },
  gloss = core.choices "gloss", bounced = { "links", "virtual" }, shading = { "pixel", "vertices" },
  denoise = { "auto", "none", "oidn" },
}

--- Which ways an option is for, where it is not for all.
local only = {
  grid = { grid = true }, interpolation = { grid = true }, dering = { grid = true }, tolerance = { rays = true },
  noise = { rays = true }, denoise = { rays = true }, ["time-limit"] = { rays = true },
  ["sums-tolerance"] = { grid = true, sum = true },
}

--- Options of --bounced virtual: those of scene:virtual_lights, and of their sum.
local of_lights, of_virtual = { "count", "particles", "merge", "cell", "degree" }, { "shadows" }

--- Ends the command where an option is none of its choices.
local function check_choices(given)
  for _, name in ipairs { "by", "visibility", "gloss", "bounced", "shading", "denoise" } do
    local x, list, known = given[name], choices[name], given[name] == nil
    for _, choice in ipairs(list) do known = known or x == choice end
    if not known then
      local guess = check.guess(x, list)
      local words = table.concat(list, ", ", 1, #list - 1) .. " or " .. list[#list]
      local more = name == "by" and x == "paths" and ": paths are ylm pathtrace's" or ""
      status.stop(status.usage, "render: --%s is %s, got '%s'%s%s", name, words, x,
        guess and (" (did you mean %s?)"):format(guess) or "", more)
    end
  end
end

--- Was it said that rays shade glossy surfaces?
local function has_rays(given) return given.gloss == "auto" or given.gloss == "rays" end

--- The way that options mean: "rays", "grid" or "sum".
local function way_of(given)
  local v = given.visibility
  if given.by == nil and status.is_surfaces(given.grid) then return "rays" end
  return given.by or (given.grid or v and v ~= "rays") and "grid" or "rays"
end

--- Ends the command where --gloss does not fit its band, or the way.
local function check_gloss(given, by)
  local band = given["gloss-error"]
  if band and (band[1] < 0 or band[1] >= band[2]) then
    status.stop(status.usage, "render: --gloss-error is two numbers such as 0.01,0.03, the first from 0 to below the second")
  end
  if band and given.gloss and given.gloss ~= "auto" then
    status.stop(status.usage, "render: --gloss-error is for --gloss auto, this is %s: leave one out", given.gloss)
  end
  if by == "rays" and given.gloss == "sh" then
    status.stop(status.usage, "render: --gloss %s is for grids (--grid FILE, or --by grid): rays know materials", given.gloss)
  end
end

--- Ends the command where an option was given that the way has no use for.
local function refuse_idle(given, by)
  local names = {}
  for name in pairs(only) do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do
    local fits = only[name][by] or name == "grid" and status.is_surfaces(given.grid)
    if given[name] ~= nil and not fits then
      local fit = {}
      for way in pairs(only[name]) do fit[#fit + 1] = way end
      table.sort(fit)
      status.stop(status.usage, "render: --%s is for --by %s, this is by %s: leave it out", name, table.concat(fit, " and "), by)
    end
  end
  if given.visibility == "rays" and by == "sum" or given.visibility and given.visibility ~= "rays" and given.visibility ~= "none"
    and by == "rays" then
    status.stop(status.usage, "render: --visibility %s is not of pictures by %s: leave one out", given.visibility, by)
  end
  if by ~= "rays" and given["light-samples"] and not has_rays(given) then
    status.stop(status.usage, "render: --light-samples is for pictures by rays to the lamps (--by rays): leave it out")
  end
  if given.grid and given["sums-tolerance"] then
    status.stop(status.usage, "render: --sums-tolerance is for baking the scene's probes, --grid is baked: leave one out")
  end
  if given.tolerance and given.shading == "vertices" then
    status.stop(status.usage, "render: --tolerance is judged at what camera rays hit: leave --shading vertices out")
  end
end

--- Ends the command where options are given that light on surfaces has no use for.
local function check_surfaces(given, by)
  if not status.is_surfaces(given.grid) then return end
  if by == "grid" then
    status.stop(status.usage, "render: --by grid is of grids, %s is light on surfaces: leave --by out", given.grid)
  end
  for _, name in ipairs { "bounces", "bounced", "visibility" } do
    if given[name] and (name ~= "visibility" or given[name] == "transfer") then
      status.stop(status.usage, "render: --%s does not go with %s, which holds the light that bounces: leave one out", name,
        given.grid)
    end
  end
end

--- Is noise filtered? Of pictures by rays and links, unless options count shadow rays, or ask for what a filter does not go with.
local function filter_of(given, by)
  if given.denoise then return given.denoise end
  local plain = by == "rays" and not given.tolerance and not given["light-samples"] and given.shading ~= "vertices"
    and given.bounced ~= "virtual"
  return plain and "auto" or nil
end

--- Ends the command where options of virtual lights are given and these are not asked for.
local function check_virtual(given)
  for _, list in ipairs { of_lights, of_virtual } do
    for _, name in ipairs(list) do
      if given[name] ~= nil and given.bounced ~= "virtual" then
        status.stop(status.usage, "render: --%s is for --bounced virtual: leave it out, or ask for that", name)
      end
    end
  end
end

--- The virtual lights that options describe; nil: none are described, the picture makes its own.
local function lights_of(scene, given, bounces)
  local own, any = { bounces = bounces or "all", threads = given.threads, progress = report.progress(given) }, false
  for _, name in ipairs(of_lights) do
    own[name] = name == "degree" and tonumber(given.degree) or given[name]
    any = any or given[name] ~= nil
  end
  if not any or bounces == 0 then return nil end
  return status.need(scene:virtual_lights(own))
end

--- The options of scene:render but for grid and bounced.
local function options_of(given, by)
  return { by = by, size = given.size, samples = given.samples, threads = given.threads, progress = report.progress(given),
    light_samples = given["light-samples"], display = status.display("render", given.display), gloss = given.gloss,
    gloss_error = given["gloss-error"], sums_tolerance = given["sums-tolerance"], shading = given.shading,
    visibility = given.visibility, bounces = status.bounces("render", given.bounces), tolerance = given.tolerance,
    noise = given.noise, denoise = filter_of(given, by), time_limit = given["time-limit"],
    interpolation = given.interpolation, dering = status.dering("render", given.dering), bounced = given.bounced,
    virtual = given.shadows and { shadows = given.shadows } or nil }
end

return {
  summary = "renders a scene file: by rays to its lamps with all light that bounces, or by a grid of probes",
  usage = "SCENE.lua -o IMAGE",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the image: .exr, .png, .hdr or .pfm" },
    { "size", "-s", "WxH", "pixels, default that of the renderer" },
    { "samples", "-n", "N", "camera rays per pixel, default 16; more of them multiply rays to lamps and links too" },
    { "by", nil, "NAME", "how direct light is found: rays (default: true shadows, no probes), grid (the papers': --grid, or the "
      .. "scene's probes are baked) or sum (the reference of grids); paths: ylm pathtrace" },
    { "bounces", "-b", "NAME", "reflections after direct light: 0, 1 .. or all (default by rays)" },
    { "bounced", nil, "NAME", "how light that bounces is found: links (default) or virtual (lights of particles, which pass "
      .. "walls)" },
    { "count", nil, "N", "virtual: lights, at most; default 2000" },
    { "particles", nil, "N", "virtual: that are traced for them" },
    { "merge", nil, nil, "virtual: particles that land close to each other become one light" },
    { "cell", nil, "N", "virtual: with --merge, how close: the edge of a cell, scene units" },
    { "degree", nil, "NAME", "virtual: of what glossy surfaces send: auto (default), or 0 to 8" },
    { "shadows", nil, "NAME", "virtual: none (default) or centre, a ray from each point to each light" },
    { "tolerance", nil, "N", "of the picture, 0.02 for 2 %: chooses samples, light-samples and all about bounces, judges itself "
      .. "by paths, and says whether it is met" },
    { "noise", nil, "N", "of the picture, default 0.03 for 3 % of the light around each pixel: chooses shadow rays and links "
      .. "pixel by pixel, and says what was reached" },
    { "denoise", nil, "NAME", "by rays: auto (a filter where there is more noise; default without --light-samples), none, or "
      .. "oidn (Open Image Denoise, where it is installed)" },
    { "time-limit", nil, "N", "seconds: with --noise, end after about so long" },
    { "light-samples", nil, "N", "by rays: shadow rays per shading point, default 32" },
    { "visibility", nil, "NAME", "rays, transfer (by grid and sum: occlusion by direction), none or self" },
    { "gloss", nil, "NAME", "glossy surfaces, by a grid: auto (default, rays where harmonics are too few), sh, rays, matte" },
    { "gloss-error", nil, "A,B", "auto: the part of a lobe that harmonics may miss: rays from A on, alone from B on; default "
      .. "0.01,0.03" },
    { "grid", "-g", "FILE", "a grid baked before, or a .surfaces file; of indirect light: that light alone, and the lamps' by "
      .. "rays" },
    { "shading", nil, "NAME", "pixel (default) or vertices" },
    { "dering", nil, "N", "of a grid: width of the window against light below zero, in degrees, 0: none; default: chosen where "
      .. "needed" },
    { "interpolation", nil, "NAME", "of a grid: hermite, taylor or linear" },
    exposures.option,
    { "display", nil, "ADDRESS", "HOST:PORT of an image viewer (tev) that shows the picture while it is made" },
    { "sums-tolerance", nil, "N", "sum many lights by a tree, to this part of the light; default: exactly" },
    { "strict", nil, nil, "exit status 6 where a warning is given; the image is written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "render: -o FILE says where the image goes") end
    status.need_output("render", given.output, "exr", "png", "hdr", "pfm")
    check_choices(given)
    local by = way_of(given)
    check_surfaces(given, by)
    refuse_idle(given, by)
    check_gloss(given, by)
    local exposure = exposures.of("render", given)
    check_virtual(given)
    local options = options_of(given, by)
    local scene = status.load_scene(given[1])
    if status.is_surfaces(given.grid) then
      options.by, options.bounces = given.by or "rays", nil
      options.bounced = status.need(scene:surface_grid { file = given.grid })
    elseif given.grid then options.grid = status.need_kind("ylm.grid", "a grid", given.grid, ylm.load(given.grid))
    elseif by == "grid" and not scene.probes then
      status.stop(status.script, "%s: the scene has no probes; add some, or use --by rays", given[1])
    end
    if options.grid and options.grid.quantity == "indirect" and not given.by then
      options.by, options.bounced, options.grid, options.bounces = "rays", options.grid, nil, nil
      options.denoise = filter_of(given, "rays")
    end
    if given.bounced == "virtual" then
      local lights = lights_of(scene, given, options.bounces)
      if lights then options.bounced, options.bounces = lights, nil end
    end
    local image, facts = scene:render(options)
    status.need(image, facts)
    exposures.save(given, image, exposure)
    if facts.ended then report.say_noise(given, facts) end
    report.print(given, facts, report.names(facts, { "reference", "visibility", "gloss", "bounces", "omits", "met", "error" }))
    if facts.ended == "cancelled" then return status.cancelled end
    return status.of_warnings(given, facts.warnings)
  end,
}
