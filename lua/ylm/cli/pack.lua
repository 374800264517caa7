--- ylm pack big.ylmd -o big.ylm

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

return {
  summary = "a grid in bricks, a folder, as one file",
  usage = "GRID.ylmd -o GRID.ylm",
  least = 1, most = 1,
  options = {
    { "output", "-o", "FILE", "the file (.ylm); the grid has to fit into memory" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "pack: -o FILE says where the file goes") end
    status.need_output("pack", given.output, "ylm")
    local set = status.need_kind("ylm.grid_set", "a grid in bricks (a folder name.ylmd)", given[1], ylm.load(given[1]))
    status.need(set:save(given.output, { threads = given.threads, progress = report.progress(given) }))
    local stats = set.stats
    report.print(given, { bricks = stats.bricks, points = stats.points }, { "bricks", "points" })
  end,
}
