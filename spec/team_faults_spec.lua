--- Bakes in bricks by several processes where something breaks: processes that are killed, bytes that flip, disks that are full.

local kills = require "spec.support.kills"
local long = require "spec.support.long"
local mpi = require "spec.support.mpi"
local random = require "spec.support.random".minimal
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

--- A lamp reaches over borders of bricks.
local SCENE = [[return scene "faults" {
  geometry = { sphere { at = { 0.3, 0.4, 0.1 }, radius = %g, divide = { 16, 8 } } },
  lights = { sphere_light { at = { 0.21, 0.1, 0 }, radius = 0.12, radiance = 5 },
    sphere_light { at = { -0.7, 0.3, 0.4 }, radius = 0.05, radiance = { 9, 4, 2 } } },
  probes = adaptive_grid { bounds = { { -1, -0.2, -1 }, { 1, 0.8, 1 } }, lmax = 2, depth = %d, threshold = %g, bricks = %d } }]]

local SECONDS = 10 -- for all processes to end, from the moment of a fault

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
end)
