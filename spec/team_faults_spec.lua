--- Bakes in bricks by several processes where something breaks: processes that are killed, bytes that flip, disks that are full.

local kills = require "spec.support.kills"
local long = require "spec.support.long"
local mpi = require "spec.support.mpi"
local random = require "spec.support.random".minimal
local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

--- A lamp reaches over borders of bricks.
local SCENE = [[return scene "faults" {
  geometry = { sphere { at = { 0.3, 0.4, 0.1 }, radius = %g, divide = { 16, 8 } } },
  lights = { sphere_light { at = { 0.21, 0.1, 0 }, radius = 0.12, radiance = 5 },
    sphere_light { at = { -0.7, 0.3, 0.4 }, radius = 0.05, radiance = { 9, 4, 2 } } },
  probes = adaptive_grid { bounds = { { -1, -0.2, -1 }, { 1, 0.8, 1 } }, lmax = 2, depth = %d, threshold = %g, bricks = %d } }]]

local SECONDS = patience(10) -- for all processes to end, from the moment of a fault

describe("a bake in bricks that a team shares, where something breaks", function()
  local folder, run, scene, one
  setup(function()
    folder = scratch.new "/dev/shm" -- each file is written through to the disk
    run = mpi.runner(folder)
    scene = scratch.quote(folder:write("scene.lua",
      SCENE:format(long(0.3, 0.45), long(5, 8), long(0.05, 0.004), long(1, 3))))
    one = folder.path .. "/one.ylmd"
    if mpi.missing() then return end
    local out, status = scratch.capture(("%s bake %s -q -j 1 -o %s"):format(tool.command, scene, scratch.quote(one)))
    assert(status == 0, out)
  end)
  teardown(function() folder:remove() end)

  local function to(name) return folder.path .. "/" .. name end

  --- Checksums of the files in a folder.
  local function sums(path)
    return (scratch.capture(("cd %s && find . -type f ! -name '.*' | LC_ALL=C sort | xargs cksum"):format(scratch.quote(path))))
  end

  --- The work of every process: it leaves its number and its parent's, mpirun's, in a file, and bakes.
  local function process(path, before)
    return ("echo $$ $PPID >%s.$OMPI_COMM_WORLD_RANK\n%s\nexec env %sbake %s -q -j 1 -o %s"):format(scratch.quote(to "pid"),
      before or "", tool.command, scene, scratch.quote(path))
  end

  --- Bakes by n processes, and kills number `victim` (0 is mpirun) `moment` seconds after they have begun. Returns the status of
  -- mpirun and the seconds from it until the last process had ended.
  local function kill(n, victim, moment, path)
    local out = scratch.capture(([[
      pid=%s
      rm -f $pid.*
      %s >$pid.out 2>&1 &
      job=$!
      tries=0
      while [ $(cat $pid.[0-9] 2>/dev/null | wc -l) -lt %d ] && [ $((tries += 1)) -lt 1000 ]; do sleep 0.02; done
      sleep %.3f
      read %s <$pid.%d
      begun=$(date +%%s%%N)
      kill -9 $victim && echo killed
      wait $job
      echo status $?
      live() {
        for file in $pid.[0-9]; do
          read p q <$file
          case $(sed 's/.*) //; s/ .*//' /proc/$p/stat 2>/dev/null) in ''|Z) ;; *) return 0; esac
        done
        return 1
      }
      tries=0
      while live && [ $((tries += 1)) -lt 600 ]; do sleep 0.05; done
      echo seconds $((($(date +%%s%%N) - begun) / 1000000))
      cat $pid.out]]):format(scratch.quote(to "pid"), mpi.command(folder, n, "sh", process(path)), n, moment,
        victim == 0 and "p victim" or "victim p", math.max(0, victim - 1)))
    local status = assert(tonumber(out:match "status (%d+)"), out)
    assert(status == 0 or status == 137, out)
    return status, tonumber(out:match "seconds (%d+)") / 1000
  end

  it("ends with the same files after kills of any process and of mpirun, and does nothing again that was done", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local r, path, wanted = random(20), to "killed.ylmd", sums(one)
    local function bake(n)
      local out, status, seconds = run(n, "sh", process(path))
      assert.equal(0, status, out)
      assert.equal(wanted, sums(path))
      return seconds
    end
    local whole = long(0.4, bake(2))
    local killed, most, tries, slowest = 0, long(1, 20), 0, 0
    while killed < most do
      scratch.shell(("rm -rf %s; mkdir %s"):format(scratch.quote(path), scratch.quote(path)))
      local before, of_folder, status = {}, 0
      repeat -- up to three kills of a bake: of mpirun, the first process, another one
        local n = 2 + math.floor(long(1, 3) * r())
        local moment, victim = r() * whole, killed % 3
        if victim == 2 then victim = 2 + math.floor((n - 1) * r()) end
        local seconds
        status, seconds = kill(n, victim, moment, path)
        local now, files = kills.committed(path)
        if status == 137 then
          killed, of_folder, slowest = killed + 1, of_folder + 1, math.max(slowest, seconds)
          assert.is_nil(kills.done_again(before, now))
          assert(seconds < SECONDS, seconds)
          kills.say("kill %d of %d: %s of %d, after %.2f s (a bake takes %.2f s); %d files committed; all ended in %.2f s",
            killed, most, victim == 0 and "mpirun" or "process " .. victim, n, moment, whole, files, seconds)
        end
        before, tries = now, tries + 1
        assert(tries < 10 * most, "kills come too late")
      until status == 0 or of_folder == 3 or killed == most
      bake(1 + math.floor(3 * r()))
    end
    kills.say("%d kills, %d attempts; the last process had ended %.2f s after a kill at most", killed, tries, slowest)
  end)

  --- A folder whose bake was cancelled while bricks were joined: it has files of every kind.
  local function begun(name)
    local calls, loaded = 0, assert(ylm.load(folder.path .. "/scene.lua"))
    local grid, message = loaded:bake { folder = to(name), threads = 1, progress = function(_, _, stage)
      if stage == "joining" then calls = calls + 1 end
      return calls < 4
    end }
    assert.is_nil(grid)
    assert.equal("cancelled", message)
  end

  --- Flips a bit of a file.
  local function flip(path, part)
    local text = scratch.text(path)
    local at = math.min(#text, 1 + math.floor(part * #text))
    local file = assert(io.open(path, "wb"))
    file:write(text:sub(1, at - 1), string.char((text:byte(at) + 1) % 256), text:sub(at + 1))
    file:close()
  end

  --- A run by n processes that failed: one message, soon; returns it.
  local function one_message(out, status, seconds)
    assert(status ~= 0 and seconds < SECONDS, ("status %d after %.2f s: %s"):format(status, seconds, out))
    assert.equal(1, select(2, ("\n" .. out):gsub("\nylm: ", "")), out)
    return out
  end

  it("bakes anew the files of bricks that are damaged, or all end with one message and a call again does", function()
    if mpi.missing() then return pending(mpi.missing()) end
    begun "begun.ylmd"
    local wanted, path = sums(one), to "bytes.ylmd"
    local copy = ("rm -rf %s && cp -a %s %s"):format(scratch.quote(path), scratch.quote(to "begun.ylmd"), scratch.quote(path))
    for _, case in ipairs(long({ { "b", 0.6 } }, { { "a", 0.01 }, { "a", 0.6 }, { "b", 0.01 }, { "b", 0.6 }, { "c", 0.01 },
      { "c", 0.6 }, { "fill", 0.6 }, { "form", 0.6 },
      { "ylm", 0 } })) do
      assert(scratch.shell(copy))
      local kind = case[1]
      local file = kind:find "^f" and path .. "/" .. kind
        or scratch.lines(("ls -S %s/*/*.%s"):format(scratch.quote(path), kind))[1] -- the largest
      flip(file, case[2])
      local out, status, seconds = run(3, "sh", process(path))
      if status ~= 0 then one_message(out, status, seconds) end
      kills.say("%s flipped at %g: status %d after %.2f s: %s", kind, case[2], status, seconds, out:match "[^\n]*")
      if kind == "form" then
        assert(status ~= 0 and out:find("differs in", 1, true), out)
      else
        if status ~= 0 then
          assert(out:find("damaged", 1, true), out)
          out, status = run(2, "sh", process(path))
        end
        assert.equal(0, status, out)
        assert.equal(wanted, sums(path))
      end
    end
  end)

  it("ends for all with one message where a disk is full, and goes on when it is not", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local wanted, path = sums(one), to "full.ylmd"
    for _, case in ipairs(long({ { 2, "= 1" } }, { { 2, "= 0" }, { 3, "= 1" }, { 3, "-gt 0" }, { 3, "-ge 0" } })) do
      scratch.shell("rm -rf " .. scratch.quote(path))
      local out, status, seconds = run(case[1], "sh",
        process(path, ("trap '' XFSZ; [ $OMPI_COMM_WORLD_RANK %s ] && ulimit -f 40"):format(case[2])))
      one_message(out, status, seconds)
      assert(out:find("cannot be written: File too large", 1, true), out)
      kills.say("disk full for rank %s of %d: status %d after %.2f s: %s", case[2], case[1], status, seconds, out:match "[^\n]*")
      out, status = run(case[1], "sh", process(path))
      assert.equal(0, status, out)
      assert.equal(wanted, sums(path))
      assert.equal("", (scratch.capture(("find %s -name '*unfinished*'"):format(scratch.quote(path)))))
    end
  end)

  if long(false, true) then
    it("tells of damaged bricks where they are sampled, by one message of all", function()
      if mpi.missing() then return pending(mpi.missing()) end
      local path = to "sampled.ylmd"
      for _, name in ipairs { "index", "top.ylm", "brick" } do
        assert(scratch.shell(("rm -rf %s && cp -a %s %s"):format(scratch.quote(path), scratch.quote(one), scratch.quote(path))))
        local brick = scratch.lines(("ls -S %s/*/*.ylm"):format(scratch.quote(path)))[1]
        flip(name == "brick" and brick or path .. "/" .. name, 0.6)
        local out, status, seconds = run(3, "lua", ([[
          local ylm = require "ylm"
          local slices, team = {}, ylm.team()
          for i = 1, 12 do slices[i] = i end
          local results, message, code = team:each(slices, function(i)
            local points = {}
            local grid, message, code = ylm.load(%q, { cache = "16 MB" })
            if not grid then return nil, message, code end
            for k = 1, 200 do
              local t = k * 2.4
              points[k] = { 0.3 + 0.45 * math.cos(t), 0.4 + 0.4 * (i / 6 - 1), 0.1 + 0.45 * math.sin(t) * k / 200 }
            end
            local c, why, kind = grid:sample(points)
            grid:close()
            if not c then return nil, why, kind end
            return #c
          end)
          if team.rank == 1 then print(results and "sampled" or "ylm: " .. message, code) end
          os.exit(results and 0 or 3, true)]]):format(path))
        assert(one_message(out, status, seconds):find "is damaged.*ECHECKSUM", out)
        kills.say("%s flipped, sampled by 3: after %.2f s: %s", name, seconds, out:match "[^\n]*")
      end
    end)
  end
end)
