--- ylm run experiment.lua ARGUMENTS, ylm run -e CODE ARGUMENTS

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

--- The program of a file, or that of -e, whose lines know `ylm`; nil, message where it is none.
local function program_of(given)
  if not given.execute then return loadfile(given[1]) end
  return (loadstring or load)("local ylm = require 'ylm' " .. given.execute, "=-e") -- luacheck: ignore 113
end

--- The list `arg` of a program: its name at 0, then what follows it on the command line.
local function arguments_of(given)
  local arg = { [0] = given.execute and "-e" or given[1] }
  local first = given.execute and 1 or 2
  for i = first, #given do arg[i - first + 1] = given[i] end
  return arg
end

return {
  summary = "runs an experiment: any Lua program, trusted, with `arg` as usual",
  usage = "FILE.lua [ARGUMENTS] | -e CODE [ARGUMENTS]",
  notes = "The program's first result is the exit status: nothing, true or 0 for good, 7 to 125 as its own. Other "
    .. "numbers\nand false end with 3, since 1 to 6 and 130 mean what `ylm help` says; nil, message (of a save, say) "
    .. "ends with 1.\nLines that it prints go on at once, into a pipe too.",
  options = { { "execute", "-e", "CODE", "runs the words of CODE instead of a file; `ylm` is there", last = true } },
  examples = { "ylm run -e 'print(ylm.sh.count(4))'" },
  json = false,
  rest = true,
  shared = true,
  run = function(given)
    if not given.execute and not given[1] then status.stop(status.usage, "run: expected: FILE.lua, or -e CODE") end
    local chunk, message = program_of(given)
    if not chunk then
      status.stop(message:find "^cannot " and status.failed or status.script, message)
    end
    io.stdout:setvbuf "line"
    local arg = arguments_of(given)
    _G.arg = arg
    return status_of(arg[0], chunk((table.unpack or unpack)(arg))) -- luacheck: ignore 113
  end,
}
