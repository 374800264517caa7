--- ylm bench: the benchmarks of the build tree.

local status = require "ylm.cli.status"

return {
  summary = "ns per point and per light-point pair, in a build tree (make bench)",
  usage = "",
  json = false,
  run = function()
    local root = os.getenv "YLM_ROOT"
    if not root or root == "" then status.stop(status.failed, "bench runs from a build tree: use build/ylm") end
    local ok, _, code = os.execute(("make -s -C '%s' bench"):format(root:gsub("'", "'\\''")))
    if ok == true or ok == 0 then return status.good end
    return type(code) == "number" and code ~= 0 and status.failed or status.failed
  end,
}
