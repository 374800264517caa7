--- Who has started this process: mpirun, srun, or nobody. The environment says so.

local launch = {}

--- Variables of launchers: how many processes there are, and which this is, from 0.
local launchers = {
  { "mpirun", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK" }, -- Open MPI
  { "mpirun", "PMI_SIZE", "PMI_RANK" },                         -- MPICH, Intel MPI
  { "srun", "SLURM_STEP_NUM_TASKS", "SLURM_PROCID" },
}

local function integer(name)
  local text = os.getenv(name)
  return text and text:find "^%d+$" and tonumber(text) or nil
end

--- { by = "mpirun" | "srun", size =, rank = from 1 } where a launcher has started several processes; else nil.
function launch.started()
  for _, names in ipairs(launchers) do
    local size = integer(names[2])
    if size and size > 1 then return { by = names[1], size = size, rank = (integer(names[3]) or 0) + 1 } end
  end
  local rank = integer "PMIX_RANK" -- of a launcher that says no more
  if rank and rank > 0 then return { by = "a launcher", size = rank + 1, rank = rank + 1 } end
end

return launch
