-- ylm.team: processes that share work, and what they do when one of them fails.

local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

local function squares(n)
  local list = {}
  for i = 1, n do list[i] = i end
  return list
end

describe("ylm.team, alone", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  it("is process 1 of 1, the same object every time", function()
    local team = ylm.team()
    assert.same({ 1, 1, "ylm.team: process 1 of 1" }, { team.rank, team.size, tostring(team) })
    assert.equal(team, ylm.team())
  end)

  it("gives results in the order of the cases, of every kind that it takes", function()
    local a = ylm.array({ { 1, 2.5 }, { -1e-30, 1e30 } }, "float")
    local cases = { { x = 1 }, "a\nb;", 3, false, a }
    local results = assert(ylm.team():each(cases, function(case, i)
      if i == 2 then return end
      return { i, case, deep = { { case } }, [2.5] = 1 / 0, nan = 0 / 0, negative = -1 / 0, third = 1 / 3 }
    end))
    assert.equal(5, #results)
    assert.is_true(results[2])
    assert.same({ 1, 1, 1 / 0, -1 / 0, 1 / 3 }, { results[1][1], results[1].deep[1][1].x, results[1][2.5], results[1].negative,
      results[1].third })
    assert(results[1].nan ~= results[1].nan and results[4][2] == false)
    local b = results[5][2]
    assert.same({ a.shape, a.dtype, a:totable() }, { b.shape, b.dtype, b:totable() })
    local kind = math.type -- luacheck: ignore 143
    if kind then assert.same({ "integer", "float" }, { kind(results[3][1]), kind(results[3].third) }) end
    assert.same({}, ylm.team():each({}, error))
  end)

  it("tells of cases, and ends where progress returns false", function()
    local told = {}
    assert(ylm.team():each(squares(3), function() return 1 end, { progress = function(done, total, stage)
      told[#told + 1] = ("%d/%d %s"):format(done, total, stage)
    end }))
    assert.same({ "0/3 cases", "1/3 cases", "2/3 cases", "3/3 cases" }, told)
    assert.same({ nil, "cancelled", "ECANCELLED" },
      { ylm.team():each(squares(3), function() return 1 end, { progress = function(done) return done < 1 end }) })
  end)

  it("hands back the failure of a case, and raises its error", function()
    local results, message, code = ylm.team():each(squares(3), function(i)
      if i == 2 then return nil, "no such file", "EIO" end
      return i
    end)
    assert.same({ nil, "case 2: no such file", "EIO" }, { results, message, code })
    local raised = {}
    local ok, got = pcall(function() ylm.team():each({ 1 }, function() error(raised) end) end)
    assert(not ok and got == raised)
    assert.has_error(function() ylm.team():each({ 1 }, function() return ylm.team():each({ 1 }, print) end) end)
    assert.same({ 1 }, ylm.team():each({ 1 }, function(i) return i end)) -- works again
  end)

  it("keeps results in a journal, and does the cases that it lacks", function()
    local path, calls = folder.path .. "/sweep.journal", 0
    local function f(case)
      calls = calls + 1
      if case.n == 4 and calls == 4 then error "power cut" end
      return { n = case.n, text = "case 0 0 0\n", array = ylm.array { case.n } }
    end
    local cases = {}
    for n = 1, 5 do cases[n] = { n = n, at = { 0, n } } end
    local function run(list)
      calls = 0
      return ylm.team():each(list or cases, f, { journal = path })
    end
    assert(not pcall(run))
    local results = assert(run())
    assert.equal(2, calls)
    for n = 1, 5 do assert(results[n].n == n and results[n].array[1] == n and results[n].text == "case 0 0 0\n") end
    assert(run() and calls == 0)
    assert(run { cases[5], { n = 7 }, cases[1] } and calls == 1) -- others are added, in any order
    local text = folder:read "sweep.journal"
    -- what a killed process has left
    folder:write("sweep.journal", text:sub(1, -4))
    assert(run(cases))
    assert(calls <= 1)
    -- parts of a job of three processes, the second of which had no case
    folder:write("sweep.journal", "")
    folder:write("sweep.journal.2", "ylm jou")
    folder:write("sweep.journal.3", text)
    calls = 0
    assert(run { cases[1], { n = 7 } })
    assert(calls == 0 and not folder:read "sweep.journal.2" and not folder:read "sweep.journal.3")
    -- a flipped byte costs its entry
    text = folder:read "sweep.journal"
    local at = text:find "n1;" or text:find "i1;"
    folder:write("sweep.journal", text:sub(1, at) .. "9" .. text:sub(at + 2))
    calls = 0
    assert(run { cases[1], cases[2], cases[3], cases[5], { n = 7 } })
    assert(calls >= 1 and calls <= 2)
  end)

  it("says what is wrong with a journal", function()
    local path = folder:write("other.journal", "something else\n")
    assert.same({ nil, path .. ": not a journal of team:each", "EFORMAT" },
      { ylm.team():each({ 1 }, print, { journal = path }) })
    folder:write("other.journal", "ylm journal 2\n")
    assert.equal("EVERSION", select(3, ylm.team():each({ 1 }, print, { journal = path })))
    assert.equal("EIO", select(3, ylm.team():each({ 1 }, print, { journal = folder.path .. "/none/x" })))
    assert.equal("EIO", select(3, ylm.team():each({ 1 }, print, { journal = folder.path })))
    assert.equal("something else\n", folder:write("other.journal", "something else\n") and folder:read "other.journal")
  end)
end)

describe("a program that a launcher has started", function()
  local folder, run
  setup(function()
    folder = scratch.new()
    run = function(environment, words)
      local out, status = scratch.capture(("env %s %s %s"):format(environment, tool.command, words))
      return out, status
    end
  end)
  teardown(function() folder:remove() end)

  it("stops where ylm was built without MPI, or with another one's", function()
    local script = folder:write("script.lua", 'package.preload["ylm.c.mpi"] = function() error("no libmpi.so", 0) end\n'
      .. 'require "ylm".team()\n')
    for rank = 0, 1 do
      local out, status = run("OMPI_COMM_WORLD_SIZE=8 OMPI_COMM_WORLD_RANK=" .. rank, "run " .. script)
      assert.equal(3, status, out)
      assert.equal(rank == 0 and "ylm: " .. script .. ":2: team: started 8 times by mpirun, but ylm was built without MPI: "
        .. "install libopenmpi-dev and run make again (no libmpi.so)\n" or "", out)
    end
    if not pcall(require, "ylm.c.mpi") then return end
    folder:write("script.lua", 'require "ylm".team()\n')
    local out, status = run("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 PMI_SIZE=4 PMI_RANK=0", "run " .. script)
    assert(status == 3 and out:find("started 4 times by mpirun, but it is not the launcher of the MPI that ylm was built with (",
      1, true), out)
  end)

  it("says that a command is one process's work, once", function()
    for rank = 0, 1 do
      local out, status = run("SLURM_STEP_NUM_TASKS=8 SLURM_PROCID=" .. rank, "info")
      assert.equal(2, status)
      assert.equal(rank == 0 and "ylm: info: started 8 times by srun, but this command is one process's work; ylm bake and "
        .. "ylm run are shared\n" or "", out)
    end
    local out, status = run("OMPI_COMM_WORLD_SIZE=1 OMPI_COMM_WORLD_RANK=0", "info")
    assert(status == 0 and out:find "version", out)
  end)
end)

describe("processes that mpirun has started", function()
  local mpi = require "spec.support.mpi"
  local folder, run
  setup(function()
    folder = scratch.new()
    run = mpi.runner(folder)
  end)
  teardown(function() folder:remove() end)

  --- A script on n processes, by the tool: output, status, seconds.
  local function script(n, text)
    local path = folder:write("experiment.lua", 'local ylm = require "ylm"\nlocal team = ylm.team()\n' .. text)
    return run(n, "ylm", "run " .. scratch.quote(path))
  end

  it("do each case once, and all have the results", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local journal = folder.path .. "/sweep.journal"
    local out, status = script(4, ([[
      local cases = {}
      for i = 1, 40 do cases[i] = i end
      local results = assert(team:each(cases, function(i)
        local until_then = require "ylm.c.core".seconds() + 0.005
        while require "ylm.c.core".seconds() < until_then do end
        return { square = i * i, by = team.rank, a = ylm.array { i } }
      end, { journal = %q }))
      local by, text = {}, {}
      for i, r in ipairs(results) do
        assert(r.square == i * i and r.a[1] == i)
        by[r.by] = true
        text[i] = r.by
      end
      local processes = 0
      for _ in pairs(by) do processes = processes + 1 end
      assert(processes > 1)
      local same = assert(team:each({ 1, 2, 3, 4, 5 }, function() return table.concat(text) end))
      for i = 1, 5 do assert(same[i] == table.concat(text)) end
      if team.rank == 1 then print(team.size, #results, ylm.info().threads >= 1) end
    ]]):format(journal))
    assert.equal("4\t40\ttrue\n", out)
    assert.equal(0, status)
    local text = folder:read "sweep.journal"
    assert(text and not folder:read "sweep.journal.2" and not folder:read "sweep.journal.4")
    assert.equal(40, select(2, text:gsub("case %x+ %d+ %x+\n", "")))
  end)

  it("all end with one message where one of them fails", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local out, status, seconds = script(3, [[
      team:each({ 1, 2, 3, 4, 5, 6 }, function(i)
        if i == 3 then error("that is wrong") end
        return i
      end)]])
    assert(status == 3 and seconds < patience(5), out)
    assert.equal(1, select(2, out:gsub("that is wrong", "")), out)
    -- others are far away
    out, status, seconds = script(3, ([[
      if team.rank == 3 then error "alone" end
      local core = require "ylm.c.core"
      local until_then = core.seconds() + %d
      while core.seconds() < until_then do end]]):format(patience(30)))
    assert(status == 3 and seconds < patience(8), out)
    assert.equal(1, select(2, out:gsub("alone", "")), out)
    -- a mistake that all make
    out, status, seconds = script(3, 'error "all make it"')
    assert(status == 3 and seconds < patience(5), out)
    assert.equal(1, select(2, out:gsub("all make it", "")), out)
  end)

  it("hear of failures, of other arguments, and of processes that have ended", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local out, status = script(3, [[
      local function say(...) if team.rank == 2 then print(...) end end
      say(team:each({ 1, 2, 3 }, function(i) if i == 3 then return nil, "full", "EIO" end return i end))
      local ok, message = pcall(function() team:each(team.rank == 3 and { 1 } or {}, print) end)
      say((message:gsub("^[^:]*:%d+: ", "")))
      ok, message = pcall(function() team:each({ 1, 2, 3, 4 }, function() error("raised", 0) end) end)
      say(message)
      say(#assert(team:each({ 1, 2 }, function(i) return i end)))
      if team.rank == 3 then os.exit(0, true) end
      local result, text, code = team:each({ 1 }, function(i) return i end)
      local core = require "ylm.c.core"
      local until_then = core.seconds() + 0.3
      while team.rank == 2 and core.seconds() < until_then do end -- the others have come to their ends
      say(result, text, code)]])
    out = out:gsub("process %d: case 3", "case 3"):gsub("process %d: raised", "raised")
    assert.equal("nil\tcase 3: full\tEIO\neach: process 3 was called with another number of cases than process 1\nraised\n2\n"
      .. "nil\tprocess 3 has ended while others wait for it\tEPEER\n", out)
    assert(status ~= 0)
  end)

  it("are killed together, and go on where they were", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local journal = folder.path .. "/killed.journal"
    local text = ([[
      local done, cases = 0, {}
      for i = 1, 30 do cases[i] = i end
      local results = assert(team:each(cases, function(i)
        local core = require "ylm.c.core"
        local until_then = core.seconds() + 0.03
        while core.seconds() < until_then do end
        done = done + 1
        if %%s and team.rank == 2 and done == 2 then os.execute("kill -9 $PPID") end
        return i / 3
      end, { journal = %q }))
      local same = true
      for i = 1, 30 do same = same and results[i] == i / 3 end
      if team.rank == 1 then print(done < 30, same) end
    ]]):format(journal)
    local out, status, seconds = script(3, text:format "true")
    assert(status ~= 0 and seconds < patience(10), out)
    local kept = folder:read "killed.journal.2"
    assert.equal(1, select(2, kept:gsub("case %x+", "")))
    out, status = script(2, text:format "false")
    assert.equal(0, status, out)
    assert(out == "true\ttrue\n" and not folder:read "killed.journal.2", out)
  end)
end)
