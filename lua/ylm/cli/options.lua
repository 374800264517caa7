--- Commands with their options as rows, for the man page and the completions of shells.

local arguments = require "ylm.cli.arguments"
local commands = require "ylm.cli.commands"

local options = {}

--- Adds the option that `words` begin with ("-o, --output FILE") to `list`, unless it is there.
local function add(list, seen, words, about)
  local short, long, value = words:match "^(%-%a), %-%-([%w-]+) ?(%S*)"
  if not long then long, value = words:match "^%-%-([%w-]+) ?(%S*)" end
  if not long or seen[long] then return end
  seen[long] = true
  if not value:find "^[%w|,]+$" then value = nil end
  list[#list + 1] = { long, short, value, about }
end

--- The options that the usage of a command speaks of which parses its own.
local function of_text(text)
  local list, seen = {}, {}
  for words, about in text:gmatch "\n  (%-.-)  +([^\n]*)" do add(list, seen, words, about) end
  for name, value in text:gmatch "%-%-(%l[%l-]*) ?(%u*)" do add(list, seen, ("--%s %s"):format(name, value), "") end
  return list
end

--- All commands: rows of { name, summary, options, declaration }, options as arguments.declared has them.
function options.read()
  local list = {}
  for i, name in ipairs(commands) do
    local command = commands.of(name)
    local own = command.text and of_text(command.text()) or arguments.declared(command)
    list[i] = { name = name, summary = command.summary, options = own, command = command }
  end
  return list
end

--- Is the value of an option a file? Kinds of values are the words of its usage.
function options.is_file(option) return option[3] == "FILE" or option[3] == "DIR" or option[3] == "PREFIX" end

--- The names between which an option of a kind such as c|glsl chooses; nil for other kinds.
function options.choices(option)
  local kind = option[3] or ""
  if not kind:find "|" then return nil end
  local list = {}
  for word in kind:gmatch "[^|]+" do list[#list + 1] = word end
  return list
end

return options
