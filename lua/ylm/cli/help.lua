--- ylm help WORD

local arguments = require "ylm.cli.arguments"
local status = require "ylm.cli.status"

--- How a command is used, in words.
local function usage_of(name, commands)
  return (arguments.usage(name, commands.of(name)):gsub("%s+$", ""))
end

--- The commands whose usage speaks of `word`, as rows of help.matches, last first.
local function commands_with(word, commands)
  local list = {}
  for i = #commands, 1, -1 do
    local name = commands[i]
    if usage_of(name, commands):lower():find(word:lower(), 1, true) then
      list[#list + 1] = { "ylm " .. name, commands.of(name).summary }
    end
  end
  return list
end

--- The text that helps on `word`; nil, message where nothing speaks of it.
local function text_of(word, commands)
  local help = require "ylm.help"
  if word == "all" then return help.overview() end
  local text, message = help.text(word)
  if commands.known(word) then
    return usage_of(word, commands) .. (text and "\n\n" .. ("-"):rep(72) .. "\n" .. text or "")
  end
  return text or word:find "%S" and help.matches(word, commands_with(word, commands)), message
end

return {
  summary = "help on a form, a function, a method or any other word; 'ylm help all' lists what there is",
  usage = "[WORD]",
  least = 0,
  json = false,
  most = 1,
  shared = true,
  run = function(given, commands)
    if not given[1] then return commands.overview(io.stdout) end
    local text, message = text_of(given[1], commands)
    if not text then status.stop(status.usage, message) end
    io.stdout:write(text, "\n")
  end,
}
