--- ylm info

local report = require "ylm.cli.report"

local order = { "version", "lua", "kernel", "kernels", "threads", "parts" }

return {
  summary = "versions, kernel sets, threads, what is built in",
  usage = "[--json]",
  run = function(given)
    local info = require "ylm".info()
    report.print(given, info, report.names(info, order))
  end,
}
