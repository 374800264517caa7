--- The command-line tool of the build, under the Lua that runs the specs:
--
--     local ylm = tool.runner(folder)
--     local out, status, err = ylm "info --json"

local lacking = require "spec.support.run.lacking"
local scratch = require "spec.support.scratch"

local tool = {}

--- Its name for a shell.
tool.path = scratch.quote((os.getenv "YLM_BUILD" or "build") .. "/ylm")

--- The beginning of a shell command; `words` of the tool follow.
tool.command = ("YLM_LUA=%s LUA_PATH= LUA_CPATH= %s "):format(os.getenv "YLM_LUA" or "lua5.4", tool.path)

--- A function of the tool's words, and of where its stdout goes instead: returns stdout, exit status, stderr, which a folder
-- (scratch.new) takes. `environment` stands before the command.
function tool.runner(folder, environment)
  return function(words, to)
    local out, status = scratch.capture(("%s %s%s %s 2>%s"):format(environment or "", tool.command, words, to and ">" .. to or "",
      scratch.quote(folder.path .. "/stderr")))
    local err = folder:read "stderr"
    lacking.read(out .. err)
    return out, status, err
  end
end

return tool
