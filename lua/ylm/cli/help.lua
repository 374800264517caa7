--- ylm help WORD

local status = require "ylm.cli.status"

return {
  summary = "help on a form, a function or a method; 'ylm help all' lists them",
  usage = "WORD",
  least = 0,
  json = false,
  most = 1,
  run = function(given)
    local help = require "ylm.help"
    local word = given[1]
    if word == "all" then
      io.stdout:write(help.overview(), "\n")
      return status.good
    end
    local text, message = help.text(word)
    local is_command, command = pcall(require, "ylm.cli." .. word)
    if not text and is_command and command.summary then
      text = require "ylm.cli.arguments".usage(word, command):gsub("%s+$", "")
    end
    if not text then status.stop(status.usage, message) end
    io.stdout:write(text, "\n")
  end,
}
