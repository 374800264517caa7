--- ylm info [FILE]

local report = require "ylm.cli.report"

local order = { "version", "lua", "kernel", "kernels", "threads", "parts" }

return {
  summary = "versions, kernel sets, threads, what is built in; or what a file holds",
  usage = "[FILE] [--json]    FILE: a scene (.lua, .glb), light on surfaces (.surfaces), or what ylm.load reads: a grid (.ylm, "
    .. ".ylmd), an array, an image, a mesh, a material, a lamp's photometry",
  most = 1,
  run = function(given)
    if given[1] then return require "ylm.cli.info_file"(given) end
    local info = require "ylm".info()
    report.print(given, info, report.names(info, order))
  end,
}
