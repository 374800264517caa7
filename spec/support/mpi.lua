--- Programs on several processes, as mpirun starts them; more than there are processors, in containers and as root too.
--
--     local run, missing = mpi.runner(folder)
--     local out, status, seconds = run(4, "lua", "print(1)")      -- "lua" or "sh" and a script, "ylm" and words
--
-- Each run ends within 60 seconds (spec/support/patience.lua), whatever happens.

local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

local mpi = {}

local ENVIRONMENT = "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
  .. "OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_hwloc_base_binding_policy=none "

--- Why there are no teams here; nil where there are.
function mpi.missing()
  if not scratch.shell "command -v mpirun >/dev/null" then return "mpirun is not installed" end
  if not scratch.shell "command -v timeout >/dev/null" then return "timeout is not installed" end
  if not pcall(require, "ylm.c.mpi") then return "ylm was built without MPI" end
end

--- The command that runs words of the tool, or a script of Lua or of the shell, on n processes; `environment` is set for mpirun.
function mpi.command(folder, n, what, words, environment)
  local program = tool.command:gsub("^", "env ") .. words
  if what == "lua" then
    program = ("%s %s"):format(os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder:write("script.lua", words)))
  elseif what == "sh" then
    program = "sh " .. scratch.quote(folder:write("script.sh", words))
  end
  return ("env -u OMP_NUM_THREADS -u YLM_THREADS %s %s timeout -k 5 %d mpirun -q -n %d %s"):format(ENVIRONMENT, environment or "",
    patience(60), n, program)
end

--- A function that runs a command; it returns its output, exit status and seconds.
function mpi.runner(folder)
  return function(...)
    local core = require "ylm.c.core"
    local begun = core.seconds()
    local out, status = scratch.capture(mpi.command(folder, ...))
    return out, status, core.seconds() - begun
  end
end

return mpi
