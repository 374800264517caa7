--- ylm run experiment.lua ARGUMENTS

local check = require "ylm.check"
local status = require "ylm.cli.status"

--- The exit status that the results of an experiment mean; ends the command where they mean none or a failure.
local function status_of(path, result, message)
  if not result and type(message) == "string" then status.stop(status.failed, message) end -- nil, message, code
  if type(result) ~= "number" and result ~= false then return status.good end
  if result == 0 then return status.good end
  if check.is_integer(result) and result >= status.own_least and result <= status.own_most then return result end
  status.stop(status.script, "%s returned %s: an experiment returns nothing or 0 where it is good, "
    .. "else a status of its own from %d to %d", path, check.describe(result), status.own_least, status.own_most)
end

return {
  summary = "runs an experiment: any Lua program, trusted, with `arg` as usual",
  usage = "FILE.lua [ARGUMENTS]",
  notes = "The program's first result is the exit status: nothing, true or 0 for good, 7 to 125 as its own. Other "
    .. "numbers\nand false end with 3, since 1 to 6 and 130 mean what `ylm help` says; nil, message (of a save, say) "
    .. "ends with 1.",
  least = 1,
  json = false,
  rest = true,
  shared = true,
  run = function(given)
    local path = given[1]
    local chunk, message = loadfile(path)
    if not chunk then
      status.stop(message:find "^cannot " and status.failed or status.script, message)
    end
    local arg = { [0] = path }
    for i = 2, #given do arg[i - 1] = given[i] end
    _G.arg = arg
    return status_of(path, chunk((table.unpack or unpack)(arg))) -- luacheck: ignore 113
  end,
}
