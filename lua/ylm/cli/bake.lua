--- ylm bake scene.lua -o grid.ylm

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local parts_known = { lights = true, direct = true, indirect = true, all = true }

--- Ends the command where --parts is none, or does not fit beside other options.
local function check_parts(given)
  local parts = given.parts
  if parts and not parts_known[parts] then
    status.stop(status.usage, "bake: --parts is lights, direct, indirect or all, got '%s'", parts)
  end
  if given.bounces and parts ~= "indirect" and parts ~= "all" then
    status.stop(status.usage, "bake: --bounces is for --parts indirect or all: leave it out, or name one")
  end
  if parts and parts ~= "lights" and given.light_tolerance then
    status.stop(status.usage, "bake: --light_tolerance is for --parts lights, these are %s: leave it out", parts)
  end
end

return {
  summary = "bakes the probes of a scene file into a grid",
  usage = "SCENE.lua -o GRID.ylm",
  least = 1,
  shared = true,
  options = {
    { "output", "-o", "FILE", "the grid (.ylm), or .vtu for ParaView" },
    { "parts", nil, "NAME", "what the grid holds: lights (default: nothing occludes them), direct (with shadows), indirect (what "
      .. "surfaces send back) or all" },
    { "bounces", "-b", "NAME", "of --parts indirect and all: reflections after direct light, 1, 2 .. or all (default)" },
    { "occupied", nil, "NAME", "where light is needed: surfaces (default), camera, vertices or everywhere" },
    { "size", "-s", "WxH", "with --occupied camera: of its image, default that of render" },
    { "samples", "-n", "N", "with --occupied camera: rays per pixel" },
    { "light_tolerance", nil, "N", "sum many lights by a tree, to this part of the light; default: exactly" },
    { "strict", nil, nil, "exit status 6 where the tolerance is not met; the grid is written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "bake: -o FILE says where the grid goes") end
    status.need_output("bake", given.output, "ylm", "vtu")
    local where = given.occupied or "surfaces"
    if where ~= "surfaces" and where ~= "camera" and where ~= "vertices" and where ~= "everywhere" then
      status.stop(status.usage, "bake: --occupied is surfaces, camera, vertices or everywhere, got '%s'", where)
    end
    if where ~= "camera" and (given.size or given.samples) then
      status.stop(status.usage, "bake: --size and --samples are of the camera's view, --occupied is %s: leave them out, "
        .. "or give --occupied camera", where)
    end
    check_parts(given)
    local bounces = status.bounces("bake", given.bounces)
    local scene = status.need_scene(ylm.load_scene(given[1]))
    if not scene.probes then
      status.stop(status.script, "%s: the scene has no probes to bake (probes = adaptive_grid { ... })", given[1])
    end
    local team = status.need(ylm.team())
    local grid = status.need(scene:bake { team = team.size > 1 and team or nil, parts = given.parts, bounces = bounces,
      occupied = given.occupied, size = given.size, samples = given.samples, light_tolerance = given.light_tolerance,
      threads = given.threads, progress = report.progress(given) })
    local good, message, code = true, nil, nil
    if team.rank == 1 then good, message, code = grid:save(given.output) end
    status.need(require "ylm.team".agree(team, good, message, code))
    local stats = grid.stats
    stats.quantity = grid.quantity
    report.print(given, stats, report.names(stats, { "met", "error", "quantity" }))
    return status.of_warnings(given, { stats.warning })
  end,
}
