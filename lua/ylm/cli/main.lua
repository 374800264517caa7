--- The command-line tool: `ylm COMMAND ...`. One file per command in this folder.
--
-- A command file returns
--     { summary = "one line",
--       usage   = "FILE -o FILE",
--       options = { { "output", "-o", "FILE", "what it is" }, { "log", nil, nil, "a switch" }, ... },
--       run     = function(given) return exit status end }
-- where given holds the options by name and the other arguments as a list. Results go to stdout,
-- messages to stderr. `--json` makes results machine-readable.

local arguments = require "ylm.cli.arguments"
local status = require "ylm.cli.status"

local commands = { "render", "bake", "view", "compare", "run", "codegen", "bench", "info", "help" }

local function say(...)
  io.stderr:write("ylm: ", ...)
  io.stderr:write("\n")
end

local function overview(stream)
  stream:write("ylm - spherical-harmonic lighting\n\n",
    "usage: ylm COMMAND ...    (ylm COMMAND --help for its options)\n\n")
  for _, name in ipairs(commands) do
    stream:write(("  %-8s  %s\n"):format(name, require("ylm.cli." .. name).summary))
  end
  stream:write("\nexit status: ", status.text, "\n")
end

--- Runs the command line `given`; returns the exit status.
local function main(given)
  local name = table.remove(given, 1)
  if name == nil then
    overview(io.stderr)
    return status.usage
  end
  if name == "--help" or name == "-h" or (name == "help" and #given == 0) then
    overview(io.stdout)
    return status.good
  end
  if name == "--version" then name = "info" end
  local known = false
  for _, command in ipairs(commands) do known = known or command == name end
  if not known then
    local guess = require "ylm.check".guess(name, commands)
    say(("no command '%s'%s"):format(name,
      guess and (" (did you mean '%s'?)"):format(guess) or "; ylm help lists them"))
    return status.usage
  end
  local command = require("ylm.cli." .. name)
  local options, message = arguments.parse(command, given)
  if not options then
    say(name, ": ", message)
    io.stderr:write(arguments.usage(name, command))
    return status.usage
  end
  if options.help then
    io.stdout:write(arguments.usage(name, command))
    return status.good
  end
  local good, complaint = require "ylm.c.core".environment()
  if not good then
    say(complaint)
    return status.usage
  end
  options.command = name
  if options.quiet then require "ylm.warning".on_warning(false) end
  local ok, result = xpcall(function() return command.run(options) end, function(raised)
    return type(raised) == "table" and raised or status.raised(raised)
  end)
  if ok then return result or status.good end
  say(result.message)
  return result.status
end

local code = main { ... }
io.stdout:flush()
os.exit(code, true)
