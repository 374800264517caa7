--- ylm run experiment.lua ARGUMENTS

local status = require "ylm.cli.status"

return {
  summary = "runs an experiment: any Lua program, trusted, with `arg` as usual",
  usage = "FILE.lua [ARGUMENTS]",
  least = 1,
  json = false,
  rest = true,
  run = function(given)
    local path = given[1]
    local chunk, message = loadfile(path)
    if not chunk then
      local file = io.open(path, "rb")
      if file then file:close() end
      status.stop(file and status.script or status.failed, message)
    end
    local arg = { [0] = path }
    for i = 2, #given do arg[i - 1] = given[i] end
    _G.arg = arg
    local code = chunk((table.unpack or unpack)(arg)) -- luacheck: ignore 113
    return type(code) == "number" and code or status.good
  end,
}
