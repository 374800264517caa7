--- ylm bench: the benchmarks of the build tree.

local status = require "ylm.cli.status"

--- Do the results of os.execute say that SIGINT ended it? In 5.1 they are the status alone, as wait() has it.
local function interrupted(ok, what, code)
  if type(ok) == "number" then return ok == 2 or ok == 130 * 256 end
  return what == "signal" and code == 2 or what == "exit" and code == 130
end

return {
  summary = "ns per point and per light-point pair, in a build tree (make bench)",
  usage = "",
  json = false,
  run = function()
    local root = os.getenv "YLM_ROOT"
    if not root or root == "" then status.stop(status.failed, "bench runs from a build tree: use build/ylm") end
    local ok, what, code = os.execute(("make -s -C '%s' bench"):format(root:gsub("'", "'\\''")))
    if ok == true or ok == 0 then return status.good end
    if interrupted(ok, what, code) then status.stop(status.cancelled, "interrupted") end
    return status.failed
  end,
}
