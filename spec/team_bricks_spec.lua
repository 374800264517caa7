-- Bakes in bricks by several processes: the files of one, also where processes were killed in between.

local mpi = require "spec.support.mpi"
local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

--- A floor, a lamp that reaches over borders of bricks, another one.
local SCENE = [[return scene "floor" {
  geometry = { quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
    sphere { at = { 0.3, 0.4, 0.1 }, radius = 0.3, divide = { 16, 8 } } },
  lights = { sphere_light { at = { 0.21, 0.1, 0 }, radius = 0.12, radiance = 5 },
    sphere_light { at = { -0.7, 0.3, 0.4 }, radius = 0.05, radiance = { 9, 4, 2 } } },
  probes = adaptive_grid { lmax = 2, depth = 7, threshold = 0.05, bricks = 2 } }]]

--- Checksums of the files in a folder.
local function sums(path)
  return (scratch.capture(("cd %s && find . -type f ! -name '.*' | LC_ALL=C sort | xargs cksum"):format(scratch.quote(path))))
end

describe("a bake in bricks that a team shares", function()
  local folder, run, scene, one
  setup(function()
    folder = scratch.new()
    run = mpi.runner(folder)
    scene = scratch.quote(folder:write("scene.lua", SCENE))
    one = folder.path .. "/one.ylmd"
    if mpi.missing() then return end
    local out, status = scratch.capture(("%s bake %s -q -j 1 -o %s"):format(tool.command, scene, scratch.quote(one)))
    assert(status == 0, out)
  end)
  teardown(function() folder:remove() end)

  it("is the same command with the same files, on any number of processes and threads", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local wanted = sums(one)
    assert(select(2, wanted:gsub("%.ylm\n", "")) > 20, wanted)
    for _, case in ipairs { { 4, 1 }, { 2, 2 } } do
      local path = folder.path .. ("/%d.ylmd"):format(case[1])
      local out, status = run(case[1], "ylm", ("bake %s --json -j %d -o %s"):format(scene, case[2], scratch.quote(path)))
      assert(status == 0 and out:find "^{.*}\n$", out)
      assert.equal(wanted, sums(path))
    end
  end)

  it("is refused at once where processes name two folders", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local out = run(2, "lua", ([[
      local ylm = require "ylm"
      local team = ylm.team()
      local ok, grid, message = pcall(ylm.bake, ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 0, depth = 3,
        threshold = 1, bricks = 1 }, ylm.sphere_light { at = { 0, 2, 0 } }, { team = team, folder = %q .. team.rank .. ".ylmd" })
      if team.rank == 2 then print(tostring(ok and message or grid)) end]]):format(folder.path .. "/two"))
    assert.matches("process 2 was called with another name of the folder of bricks %(to, %-o%) than process 1", out)
  end)

  it("goes on after a kill, with other processes, to the same files", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local path = folder.path .. "/killed.ylmd"
    local script = folder:write("kill.lua", ([[
      local ylm = require "ylm"
      local team = ylm.team()
      local scene = assert(ylm.load(%q))
      local calls = 0
      assert(scene:bake { folder = %q, team = team, threads = 1, progress = function(_, _, stage)
        if stage == "bricks" then calls = calls + 1 end
        if calls == 4 then os.execute "kill -9 $PPID" end
        return true
      end })]]):format(folder.path .. "/scene.lua", path))
    local out, status, seconds = run(3, "ylm", "run " .. scratch.quote(script))
    assert(status ~= 0 and seconds < patience(20), out)
    assert(not io.open(path .. "/index"), out)
    out, status = run(2, "ylm", ("bake %s -q -o %s"):format(scene, scratch.quote(path)))
    assert.equal(0, status, out)
    assert.equal(sums(one), sums(path))
  end)

  it("ends when its time is over, with status 75, and goes on; another scene's folder is refused", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local path = folder.path .. "/late.ylmd"
    local words = ("bake %s -q -o %s"):format(scene, scratch.quote(path))
    local out, status = run(2, "ylm", words .. " --time 0.000001s")
    assert(status == 75 and select(2, out:gsub("not finished: the time is over; a call again goes on", "")) == 1, out)
    out, status = run(2, "ylm", words)
    assert.equal(0, status, out)
    assert.equal(sums(one), sums(path))
    local other = folder:write("other.lua", (SCENE:gsub("threshold = 0.05", "threshold = 0.06")))
    out, status = run(2, "ylm", ("bake %s -q -o %s"):format(scratch.quote(other), scratch.quote(path)))
    assert(status ~= 0 and select(2, out:gsub("another bake, which differs in 'threshold'", "")) == 1, out)
  end)

  it("is written for ParaView by all, a file for each process with a piece for each brick", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local script = folder:write("pieces.lua", ([[
      local ylm = require "ylm"
      local team = ylm.team()
      local grid = assert(ylm.load(%q))
      assert(grid:save(%q, { team = team }))
      if team.rank > 1 then return end
      assert(grid:save(%q))
      assert(assert(ylm.load(%q)):save(%q))
      print(grid.stats.bricks)]]):format(one, folder.path .. "/all.pvtu", folder.path .. "/lone.pvtu", one .. "/00/00.ylm",
      folder.path .. "/brick.vtu"))
    local out, status = run(3, "ylm", "run " .. scratch.quote(script))
    assert.equal(0, status, out)
    local bricks = tonumber(out:match "^(%d+)")
    --- The arrays of all files of a .pvtu, the number of files, of pieces, of cells.
    local function content(name)
      local text, data, files, pieces, cells = folder:read(name), {}, 0, 0, 0
      for source in text:gmatch 'Piece Source="([^"]+)"' do
        local head, arrays = assert(folder:read(source)):match '^(.-)<AppendedData encoding="raw">\n_(.*)\n</AppendedData>'
        files, data[#data + 1] = files + 1, arrays
        for n in head:gmatch 'NumberOfCells="(%d+)"' do pieces, cells = pieces + 1, cells + tonumber(n) end
      end
      assert(text:find('<PDataArray type="Float64" Name="Points" NumberOfComponents="3"/>', 1, true), text)
      assert(text:find('Name="level"', 1, true) and text:find('Name="L00"', 1, true))
      return table.concat(data), files, pieces, cells
    end
    local data, files, pieces, cells = content "all.pvtu"
    assert.same({ 3, bricks + 1 }, { files, pieces })
    local again, alone = content "lone.pvtu"
    assert.equal(math.ceil((bricks + 1) / 64), alone)
    assert.is_true(data == again)
    local brick = folder:read "brick.vtu":match '<AppendedData encoding="raw">\n_(.*)\n</AppendedData>'
    assert.is_true(data:sub(1, #brick) == brick)
    local built, vtk = pcall(require, "ylm.c.vtk")
    if not built then return end
    local seen = assert(vtk.describe(folder.path .. "/all.pvtu"))
    assert.equal(seen, vtk.describe(folder.path .. "/lone.pvtu"))
    assert.equal(cells, tonumber(seen:match "^vtkUnstructuredGrid %d+ (%d+)\n"), seen)
  end)

  it("is what the model of clusters measures (examples/cluster)", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local out, status = run(2, "ylm", "run examples/cluster/model.lua --quick --out " .. scratch.quote(folder.path))
    assert(status == 0 and out:find "measured by 2 processes: [%d.]+ s; the model says [%d.]+ s", out)
    assert.equal(3, select(2, out:gsub("\n +1024 processes +%d+ s  efficiency +%d+ %%", "")), out)
    out, status = run(2, "ylm", "run examples/cluster/sweep.lua")
    assert.equal(0, status, out)
    assert.equal(6, select(2, out:gsub(" lamps to 0%.%d+: +%d+ points, error 0%.%d+\n", "")), out)
  end)
end)
