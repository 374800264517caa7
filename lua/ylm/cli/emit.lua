--- ylm emit scene.lua -o lights.ply

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

--- A value that is a number, or a word.
local function word_or_number(text) return text and (tonumber(text) or text) end

return {
  summary = "traces virtual lights of a scene file and writes them as points",
  usage = "SCENE.lua -o LIGHTS.ply",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the lights (.ply): places, normals, radii, intensities" },
    { "count", "-n", "N", "lights, at most" },
    { "particles", nil, "N", "that are traced, at least as many" },
    { "merge", nil, nil, "particles that land close to each other become one light" },
    { "cell", nil, "N", "with --merge, how close: the edge of a cell, scene units" },
    { "bounces", "-b", "NAME", "reflections of a particle: 1 (default), 2 .. or all" },
    { "distribution", nil, "NAME", "particles (default) or grid: a picture from each spot" },
    { "radius", nil, "NAME", "of a light: density, angle, footprint, neighbours, or a length" },
    { "scale", nil, "N", "multiplies radii" },
    { "degree", nil, "NAME", "of what glossy surfaces send: auto (default), or 0 to 8" },
    { "seed", nil, "N", "of all random numbers" },
    { "strict", nil, nil, "exit status 6 where a warning was given; the lights are written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    if not given.output then status.stop(status.usage, "emit: -o FILE says where the lights go") end
    status.need_output("emit", given.output, "ply")
    local bounces = status.bounces("emit", given.bounces)
    local scene = status.load_scene(given[1])
    local lights, facts = status.need(scene:virtual_lights { count = given.count, particles = given.particles,
      merge = given.merge, cell = given.cell, bounces = bounces, distribution = given.distribution,
      radius = word_or_number(given.radius), scale = given.scale, degree = word_or_number(given.degree), seed = given.seed,
      threads = given.threads, progress = report.progress(given) })
    status.need(require("ylm.emit").write(lights, given.output))
    report.print(given, facts, report.names(facts, { "lights", "particles", "power", "radius" }))
    return status.of_warnings(given, facts.warnings)
  end,
}
