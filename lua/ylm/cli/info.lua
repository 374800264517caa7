--- ylm info

local report = require "ylm.cli.report"

local order = { "version", "lua", "kernel", "kernels", "threads", "parts" }

return {
  summary = "versions, kernel sets, threads, what is built in",
  usage = "[--json]",
  run = function(given)
    local info = require "ylm".info()
    local all, seen, rest = {}, {}, {}
    for _, name in ipairs(order) do all[#all + 1], seen[name] = name, true end
    for name in pairs(info) do if not seen[name] then rest[#rest + 1] = name end end
    table.sort(rest)
    for _, name in ipairs(rest) do all[#all + 1] = name end
    report.print(given, info, all)
  end,
}
