--- ylm export scene.lua -o room.three.json

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local LMAX, TOLERANCE = 2, 0.1 -- of a bake that the scene's probes do not describe

--- { nx, ny, nz } of "12x6x6"; nil: no cells were given.
local function cells_of(text)
  if text == nil then return nil end
  local x, y, z = text:match "^(%d+)x(%d+)x(%d+)$"
  if not x then status.stop(status.usage, "export: --cells is three numbers such as 12x6x6, got '%s'", text) end
  return { tonumber(x), tonumber(y), tonumber(z) }
end

--- The grid that is exported: from its file, or baked.
local function grid_of(ylm, given, scene)
  if given.grid then
    if given.quantity then status.stop(status.usage, "export: --quantity is of a bake, --grid is baked: leave one out") end
    return status.need_kind("ylm.grid", "a grid", given.grid, ylm.load(given.grid))
  end
  return (status.need(scene:bake { probes = scene.probes or ylm.adaptive_grid { lmax = LMAX, tolerance = TOLERANCE },
    quantity = given.quantity or "indirect", threads = given.threads, progress = report.progress(given) }))
end

--- Warnings of a grid that is read beside a scene: a list.
local function warnings_of(grid, scene, r)
  local list, trace = { r.warning }, require "ylm.trace".trace("export", scene)
  list[#list + 1] = trace and grid.prints and require "ylm.render.prints".warn(grid, scene, trace) or nil
  return list
end

return {
  summary = "a scene's probes as files of engines, fitted to what these read at its surfaces",
  usage = "SCENE.lua -o PROBES.ylmp|PROBES.three.json|PROBES.ktx2|PROBES.npy",
  least = 1, most = 1,
  options = {
    { "output", "-o", "FILE", "the file: .ylmp (ylm's look-up in shaders), .three.json (three.js), .ktx2 (Bevy), .npy (others)" },
    { "grid", "-g", "FILE", "a grid baked before (.ylm); default: the scene's probes are baked" },
    { "quantity", nil, "NAME", "of the bake: indirect (default), direct, all or lights" },
    { "cells", nil, "XxYxZ", "numbers of probes along the axes" },
    { "bytes", nil, "SIZE", "instead: the finest that take at most so many (32kB)" },
    { "tolerance", nil, "N", "instead: the coarsest that err by at most this at 99 % of the surface; default 0.05" },
    { "grids", nil, "N", "with .three.json: at most so many grids, which walls part; default 6" },
    { "anyway", nil, nil, "write the file also where the tolerance is not met" },
    { "strict", nil, nil, "exit status 6 where a warning is given; the file is written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "export: -o FILE says where the probes go") end
    status.need_output("export", given.output, "ylmp", "three.json", "ktx2", "npy")
    local o = { cells = cells_of(given.cells), bytes = status.bytes("export", given.bytes), tolerance = given.tolerance,
      grids = given.grids, anyway = given.anyway, threads = given.threads }
    local scene = status.load_scene(given[1])
    if #scene.geometry == 0 then status.stop(status.script, "%s: the scene has no surfaces", given[1]) end
    o.scene = scene
    local grid = grid_of(ylm, given, scene)
    local r = status.need(grid:export(given.output, o))
    local results = { bytes = r.bytes, probes = r.probes, grids = #r.grids, error = r.error, rms = r.surfaces.rms,
      leak = r.surfaces.leak }
    report.print(given, results, report.names(results, { "bytes", "error" }))
    return status.of_warnings(given, warnings_of(grid, scene, r))
  end,
}
