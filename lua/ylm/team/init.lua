--- ylm.team: the processes that mpirun or srun has started, or this one alone.

local check = require "ylm.check"
local core = require "ylm.c.core"
local description = require "ylm.describe"
local describe = description.describe
local each = require "ylm.team.each"
local launch = require "ylm.team.launch"
local library = require "ylm.library"
local memory = require "ylm.memory"

local team = {}

local methods = {}
local metatable = { __index = methods, __kind = "team",
  __tostring = function(self) return ("ylm.team: process %d of %d"):format(self.rank, self.size) end }

description.object "team" {
  about = "Processes that share work, from ylm.team.",
  fields = { { "rank", "integer", "this process, 1 to size" }, { "size", "integer", "how many there are" } },
  methods = methods,
}

--- Why processes cannot work together: a mistake of the caller, since each alone would do all the work, and write the same
-- files.
local function stop(started, why, ...)
  return check.fail("team: started %d times by %s, but " .. why, started.size, started.by, ...)
end

--- The team that a launcher has started.
local function launched(started)
  local mpi, message, code = library.open("mpi",
    "ylm was built without MPI: install libopenmpi-dev and run make again (%s)")
  if not mpi then
    if code == "ENOMEM" then return nil, message, code end
    return stop(started, "%s", message)
  end
  local handle, threads
  handle, threads, code = mpi.begin()
  if not handle then return nil, threads, code end
  local _, size = core.team_info(handle)
  if size == 1 then
    return stop(started, "it is not the launcher of the MPI that ylm was built with (%s): take that one's", mpi.version())
  end
  mpi.set_threads(threads)
  return handle
end

local made

--- The team, where there is one already.
function team.made() return made end

--- Makes a new team with the next call, and then `other` again; for specs. Returns the one that was made.
function team.forget(other)
  local before = made
  made = other
  return before
end

--- Does a process go on alone: have the others not heard of its failure?
function team.is_alone() return launch.started() ~= nil and library.open("mpi", "%s").is_alone() end

--- true where `good` is on every process; else nil, message, code of the first where it is not.
function team.agree(self, good, message, code)
  return core.team_agree(self.handle, not good and (code or "EPEER") or nil, message)
end

--- The object of a team.
local function object(handle)
  local rank, size = core.team_info(handle)
  return setmetatable({ rank = rank, size = size, handle = handle }, metatable)
end

describe "team" {
  about = "The processes that run this program: all that mpirun or srun has started, or this one alone. Every process runs the "
    .. "whole script; functions that take the team, and its methods, divide their work. They are called in the same order on "
    .. "every process. No process may be started (io.popen, os.execute) from then on.",
  arguments = {},
  returns = { { "team", "team", "the same object every time; or nil, message, 'EPEER' | 'ENOMEM'" } },
  errors = "raises where a launcher has started several processes that cannot find one another: ylm was built without MPI, or "
    .. "with another MPI than the launcher's",
  example = [[
local team = ylm.team()
assert(team.rank == 1 and team.size == 1)                       -- unless mpirun has started more]],
}
function team.team()
  if made then return made end
  local started = launch.started()
  local handle, message, code = (started and launched or core.team_alone)(started)
  if not handle then return nil, message, code end
  made = object(handle)
  return made
end

describe "team:each" {
  about = "Calls a function for every case of a list, each case on one process, and gives every process all results, in the "
    .. "order of the cases. Cases are handed out one by one, so long ones need not be balanced.",
  arguments = {
    { "cases", "table", "a list, the same on every process; with a journal of numbers, strings, booleans, arrays and tables "
      .. "of these" },
    { "f", "function", "f(case, i) returns a number, a string, a boolean, an array or a table of these; nothing counts as true, "
      .. "and nil, message ends the sweep" },
    { "options?", "table", "see the options" },
  },
  options = each.options,
  returns = { { "results", "table", "one for each case; or nil, message, code: that of f, 'EIO' | 'EFORMAT' of the journal, "
    .. "'EPEER' where another process failed, 'ECANCELLED'" } },
  errors = "raises on bad arguments, on every process what f raises on one, within team:each; a process that the others do not "
    .. "hear within two seconds ends them all",
  example = [[
local team = ylm.team()
local counts = assert(team:each({ 0, 1, 4 }, function(lmax) return ylm.sh.count(lmax) end))
assert(counts[3] == 25)]],
}
function methods.each(self, ...)
  if type(self) ~= "table" or getmetatable(self) ~= metatable then
    return check.fail("each: a team expected before the colon, got %s", check.describe(self))
  end
  return each.run(self, ...)
end

team.launched = launch.started

memory.publish(methods)
memory.publish(team, { launched = true, made = true, forget = true, is_alone = true, agree = true })

return team
