--- The commands, in the order of the overview: the names of files beside this one.

local status = require "ylm.cli.status"

local commands = { "render", "pathtrace", "bake", "lightmap", "pack", "export", "page", "emit", "view", "live", "compare",
  "judge", "sh", "material", "photometry", "inverse_lighting", "run", "codegen", "bench", "info", "help" }

--- Is there such a command?
function commands.known(name)
  for _, command in ipairs(commands) do if command == name then return true end end
  return false
end

--- The command of that name: see cli/main.lua.
function commands.of(name) return require("ylm.cli." .. name) end

--- Writes what there is.
function commands.overview(stream)
  stream:write("ylm - spherical-harmonic lighting\n\n",
    "usage: ylm COMMAND ...    (ylm COMMAND --help for its options)\n\n")
  for _, name in ipairs(commands) do
    stream:write(("  %-10s  %s\n"):format(name, commands.of(name).summary))
  end
  stream:write("\nexit status: ", status.text, "\n")
end

return commands
