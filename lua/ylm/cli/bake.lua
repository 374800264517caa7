--- ylm bake scene.lua [-o grid.ylm | room.surfaces]

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local ROOM_DEPTH, MOST_DEEP = 7, 12 -- levels of voxels: where there is no ground, and on one that is wide

local quantities = { lights = true, direct = true, indirect = true, all = true }

--- Ends the command where --quantity is none, or does not fit beside other options.
local function check_quantity(given)
  local quantity = given.quantity
  if quantity and not quantities[quantity] then
    status.stop(status.usage, "bake: --quantity is lights, direct, indirect or all, got '%s'", quantity)
  end
  if given.bounces and quantity ~= "indirect" and quantity ~= "all" then
    status.stop(status.usage, "bake: --bounces is for --quantity indirect or all: leave it out, or name one")
  end
  if quantity and quantity ~= "lights" and given["sums-tolerance"] then
    status.stop(status.usage, "bake: --sums-tolerance is for --quantity lights, this is %s: leave it out", quantity)
  end
end

--- The file that a scene is baked into where none is named: the scene's, with another ending.
local function default_output(path, scene)
  return path:gsub("%.%w+$", "") .. (scene.probes and ".ylm" or ".surfaces")
end

--- Ends the command unless the output can be written; a folder of bricks is made, and goes on where it was.
local function check_output(given)
  if given.coefficients and not given.output:lower():find "%.vtu$" then
    status.stop(status.usage, "bake: --coefficients is of .vtu files: give -o NAME.vtu, or leave it out")
  end
  if given.output:lower():find "%.ylmd/*$" then return true end
  if given.tolerance and not status.is_surfaces(given.output) then
    status.stop(status.usage, "bake: --tolerance is of -o NAME.surfaces; a grid's is that of the scene's probes")
  end
  for _, name in ipairs { "fresh", "time" } do
    if given[name] then status.stop(status.usage, "bake: --%s is of bricks: give -o NAME.ylmd, or leave it out", name) end
  end
  status.need_output("bake", given.output, "ylm", "vtu", "ylmd", "surfaces")
  return false
end

--- Ends the command where --occupied is none, or options of the camera are given without it.
local function check_occupied(given)
  local where = given.occupied or "surfaces"
  if where ~= "surfaces" and where ~= "camera" and where ~= "vertices" and where ~= "everywhere" then
    status.stop(status.usage, "bake: --occupied is surfaces, camera, vertices or everywhere, got '%s'", where)
  end
  if where ~= "camera" and (given.size or given.samples) then
    status.stop(status.usage, "bake: --size and --samples are of the camera's view, --occupied is %s: leave them out, "
      .. "or give --occupied camera", where)
  end
end

--- Finds the light on the surfaces of a scene.
local function bake_surfaces(given, scene, bounces)
  for _, name in ipairs { "occupied", "size", "samples", "sums-tolerance", "small", "bytes" } do
    if given[name] then status.stop(status.usage, "bake: --%s is of grids (-o NAME.ylm), this is %s: leave it out", name,
      given.output) end
  end
  if require "ylm.team.launch".started() then
    status.stop(status.usage, "bake: %s is one process's work: leave mpirun or srun out, or bake a grid (-o NAME.ylm)",
      given.output)
  end
  if given.quantity == "lights" then
    status.stop(status.usage, "bake: --quantity of NAME.surfaces is direct, indirect (default) or all")
  end
  if #scene.geometry == 0 then status.stop(status.script, "%s: the scene has no surfaces", given[1]) end
  local light = status.need(scene:surface_grid { tolerance = given.tolerance, quantity = given.quantity, bounces = bounces,
    threads = given.threads, progress = report.progress(given) })
  status.need(light:save(given.output))
  local stats = light.stats
  report.print(given, stats, report.names(stats, { "met", "error" }))
  return status.of_warnings(given, { stats.warning })
end

local units = { [""] = 1, s = 1, m = 60, h = 3600 }

--- Seconds of "90", "90s", "55m" or "12h"; nil: no time was given.
local function seconds_of(text)
  if text == nil then return nil end
  local number, unit = text:match "^(%d*%.?%d+)(%a?)$"
  local seconds = number and units[unit] and tonumber(number) * units[unit]
  if not seconds or seconds <= 0 then
    status.stop(status.usage, "bake: --time is a time such as 90s, 55m or 12h, got '%s'", text)
  end
  return seconds
end

--- Results of a bake; the end of its time is a status of its own.
local function need_grid(grid, message, code)
  if not grid and code == "ELIMIT" and message:find("not finished", 1, true) then status.stop(status.unfinished, message) end
  return status.need(grid, message, code)
end

local PART = 0.6 -- of a tolerance, that interpolation takes where rounding takes the rest

--- The probes to bake instead of a scene's, where few bytes are asked for; and the options of grid:save.
local function few_bytes(given, scene)
  if not given.small and not given.bytes then return nil, nil end
  if given.small and given.bytes then status.stop(status.usage, "bake: --small or --bytes: each chooses the rounding") end
  if not given.output:lower():find "%.ylm$" then
    status.stop(status.usage, "bake: --%s is of -o NAME.ylm: leave it out", given.small and "small" or "bytes")
  end
  local small, probes = require "ylm.grid.small", scene.probes
  if not probes then
    status.stop(status.script, "%s: --%s needs probes of the scene's: probes = adaptive_grid { ... }", given[1],
      given.small and "small" or "bytes")
  end
  if given.bytes then
    local bytes = status.few_bytes("bake", given).bytes
    if require "ylm.form".kind(probes) == "uniform_grid" then return nil, { bytes = bytes } end
    return small.with_bytes(probes, bytes), nil
  end
  if not probes.tolerance then
    status.stop(status.script, "%s: --small needs a tolerance of the scene's probes: tolerance = 0.01", given[1])
  end
  return small.with_tolerance(probes, PART * probes.tolerance), { tolerance = probes.tolerance }
end

--- The probes of a grid of a scene that has none: voxels of a 128th of its extents. Where it stands on a ground, they are of what
-- stands there, as high as that.
local function room_probes(scene)
  local core, all = require "ylm.trace".without_grounds("bake", scene)
  local depth, bounds = ROOM_DEPTH, nil
  if core then
    local own, whole = {}, {}
    for k = 1, 3 do
      own[k], whole[k] = core[2][k] - core[1][k], all[2][k] - all[1][k]
      while whole[k] > own[k] * 2 ^ (depth - ROOM_DEPTH) and depth < MOST_DEEP do depth = depth + 1 end
    end
    bounds = { {}, {} }
    for k = 1, 3 do
      local more = math.max(whole[k] * 1e-4, (own[k] * 2 ^ (depth - ROOM_DEPTH) - whole[k]) / 2)
      bounds[1][k], bounds[2][k] = all[1][k] - more, all[2][k] + more
    end
  elseif all then status.need(nil, all)
  end
  return require "ylm".adaptive_grid { lmax = 2, depth = depth, tolerance = 0.1, bounds = bounds }
end

return {
  summary = "bakes the probes of a scene file into a grid; of one without probes the light on its surfaces",
  usage = "SCENE.lua [-o GRID.ylm | LIGHT.surfaces]",
  notes = "mpirun or srun with this command share the work among their processes (docs/cluster.md).",
  least = 1,
  shared = true,
  options = {
    { "output", "-o", "FILE", "light on the scene's surfaces (.surfaces), a grid (.ylm), or .vtu for ParaView; .ylmd: a folder "
      .. "of bricks, for grids larger than memory, which a second call goes on with; default: the scene's name with .ylm, or "
      .. ".surfaces where it has no probes" },
    { "tolerance", nil, "N", "with NAME.surfaces: of irradiance at 99 % of the surface; default 0.1" },
    { "small", nil, nil, "with -o NAME.ylm: few bytes: the tolerance of the scene's probes holds for what is decoded" },
    { "bytes", nil, "SIZE", "with -o NAME.ylm: few bytes: the least error in at most so many (2MB, 500kB)" },
    { "coefficients", nil, nil, "with -o NAME.vtu: also all coefficients of points" },
    { "fresh", nil, nil, "with -o NAME.ylmd: begin anew, whatever is there" },
    { "time", nil, "TIME", "with -o NAME.ylmd: begin no brick that would take longer (90s, 55m, 12h); exit status 75 where "
      .. "bricks are left" },
    { "quantity", nil, "NAME", "what the grid holds: lights (nothing occludes them; default of a scene with probes), direct "
      .. "(with shadows), indirect (what surfaces send back; default of a scene without probes) or all" },
    { "bounces", "-b", "NAME", "of --quantity indirect and all: reflections after direct light, 1, 2 .. or all (default)" },
    { "occupied", nil, "NAME", "where light is needed: surfaces (default), camera, vertices or everywhere" },
    { "size", "-s", "WxH", "with --occupied camera: of its image, default that of render" },
    { "samples", "-n", "N", "with --occupied camera: rays per pixel" },
    { "sums-tolerance", nil, "N", "sum many lights by a tree, to this part of the light; default: exactly" },
    { "strict", nil, nil, "exit status 6 where the tolerance is not met; the grid is written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    local scene
    if not given.output then
      scene = status.load_scene(given[1])
      given.output = default_output(given[1], scene)
      report.say(given, "ylm: bakes into %s", given.output)
    end
    local in_bricks = check_output(given)
    local time_limit = seconds_of(given.time)
    check_occupied(given)
    check_quantity(given)
    local bounces = status.bounces("bake", given.bounces)
    scene = scene or status.load_scene(given[1])
    if status.is_surfaces(given.output) then return bake_surfaces(given, scene, bounces) end
    if not scene.probes and #scene.geometry == 0 then
      status.stop(status.script, "%s: the scene has no probes to bake (probes = adaptive_grid { ... })", given[1])
    end
    local probes, few = few_bytes(given, scene)
    if not probes and not scene.probes then
      probes, given.quantity = room_probes(scene), given.quantity or "indirect"
    end
    local team = status.need(ylm.team())
    local grid = need_grid(scene:bake { folder = in_bricks and given.output or nil, fresh = given.fresh, time_limit = time_limit,
      team = team.size > 1 and team or nil, quantity = given.quantity, bounces = bounces, occupied = given.occupied,
      probes = probes, size = given.size, samples = given.samples, sums_tolerance = given["sums-tolerance"],
      threads = given.threads,
      progress = report.progress(given) })
    local good, message, code = true, nil, nil
    if team.rank == 1 and not in_bricks then
      good, message, code = grid:save(given.output, few or given.coefficients and { coefficients = true } or nil)
    end
    status.need(require "ylm.team".agree(team, good, message, code))
    local stats, rounded = grid.stats, few and message or grid.small
    stats.quantity = grid.quantity
    if rounded then
      local bytes = few and message.bytes or #require "ylm.c.core".owned(grid, "few")
      stats.file_bytes, stats.rounding = bytes, rounded.rounding
      if few then stats.error, stats.met = rounded.error, not few.tolerance or rounded.error <= few.tolerance end
    end
    report.print(given, stats, report.names(stats, { "met", "error", "quantity" }))
    return status.of_warnings(given, { stats.warning })
  end,
}
