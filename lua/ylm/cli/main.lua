--- The command-line tool: `ylm COMMAND ...`. One file per command in this folder.
--
-- A command file returns
--     { summary = "one line",
--       usage   = "FILE -o FILE",
--       options = { { "output", "-o", "FILE", "what it is" }, { "log", nil, nil, "a switch" }, ... },
--       run     = function(given, commands) return exit status end }
-- where given holds the options by name and the other arguments as a list, and commands is cli/commands.lua. Results go to
-- stdout, messages to stderr. `--json` makes results machine-readable.

local arguments = require "ylm.cli.arguments"
local check = require "ylm.check"
local commands = require "ylm.cli.commands"
local core = require "ylm.c.core"
local launch = require "ylm.team.launch"
local progress = require "ylm.progress"
local status = require "ylm.cli.status"
local text = require "ylm.text"

--- Has mpirun or srun started several? The first alone speaks of what all of them find.
local started = launch.started()
local silent = started ~= nil and started.rank > 1

local function write(...)
  progress.leave()
  io.stderr:write("ylm: ", (table.concat({ ... }):gsub("[^\n\t]+", text.shown)), "\n")
end

local function say(...)
  if not silent then write(...) end
end

--- Says why a command has failed: once, by the first process, or by the one that the others do not hear.
local function tell(message)
  say(message)
  local team = started and require "ylm.team".made()
  if not team then return end
  local _, _, code = require "ylm.team".agree(team, nil, message, "EINVAL")
  if silent and code ~= "EPEER" and require "ylm.team".is_alone() then write("process ", team.rank, ": ", message) end
end

--- Words that stand for a command.
local words = { ["--help"] = "help", ["-h"] = "help", ["--version"] = "info" }

--- Runs the command line `given`; returns the exit status.
local function main(given)
  local name = table.remove(given, 1)
  if name == nil then
    commands.overview(io.stderr)
    return status.usage
  end
  name = words[name] or name
  if name == "help" and #given == 0 then -- whatever the environment says
    commands.overview(io.stdout)
    return status.good
  end
  if not commands.known(name) then
    local guess = check.guess(name, commands)
    say(("no command %s%s"):format(check.describe(name),
      guess and (" (did you mean '%s'?)"):format(guess) or "; ylm help lists them"))
    return status.usage
  end
  local command = commands.of(name)
  local options, message = arguments.parse(command, given)
  if not options then
    say(name, ": ", message)
    io.stderr:write(arguments.brief(name, command))
    return status.usage
  end
  if options.help then
    io.stdout:write(arguments.usage(name, command))
    return status.good
  end
  local good, complaint = core.environment()
  if not good then
    say(complaint)
    return status.usage
  end
  if started and not command.shared then
    say(("%s: started %d times by %s, but this command is one process's work; ylm bake and ylm run are shared"):format(name,
      started.size, started.by))
    return status.usage
  end
  options.command, options.silent = name, silent
  options.quiet = options.quiet or silent
  if options.quiet then require "ylm.warning".on_warning(false) end
  local ok, result = xpcall(function() return command.run(options, commands) end, function(raised)
    return status.raised(raised, name, command)
  end)
  if ok then return result or status.good end
  tell(result.message)
  return result.status
end

core.process_watch()
local code = main { ... }
progress.leave()
local written, complaint = core.process_flush()
if not written then
  say(complaint)
  if code == status.good then code = status.failed end
end
os.exit(code, true)
