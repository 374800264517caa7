-- Bakes that a team divides: the grid of one process, to the bit.

local mpi = require "spec.support.mpi"
local scratch = require "spec.support.scratch"

local SCRIPT = [[
local ylm = require "ylm"
local team = ylm.team()
local core = require "ylm.c.core"
local rank_seed = 7
local function random()
  rank_seed = (rank_seed * 16807) % 2147483647
  return rank_seed / 2147483647
end
local function lamps(n)
  local at, radius, radiance = {}, {}, {}
  for i = 1, n do
    at[i], radius[i] = { 2 * random() - 1, 1.2 + random(), 2 * random() - 1 }, 0.02 + 0.05 * random()
    radiance[i] = { 10 * random(), 10 * random(), 10 * random() }
  end
  return ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
end
local panel = ylm.polygon_light { vertices = { { -0.5, 1.5, -0.5 }, { 0.5, 1.5, -0.5 }, { 0, 1.5, 0.6 } }, radiance = 3 }
local floor = {}
for i = 0, 20 do for j = 0, 20 do floor[#floor + 1] = { i / 10 - 1, -0.5, j / 10 - 1 } end end
local bounds = { { -1, -0.6, -1 }, { 1, 0.4, 1 } }
local function analytic(points, lmax, channels)
  local n = points.shape[1]
  local value = ylm.zeros({ n, channels, (lmax + 1) ^ 2 }, "float")
  local slope = ylm.zeros({ n, channels, (lmax + 1) ^ 2, 3 }, "float")
  for i = 1, n do value:set(i, 1, 1, 1 + points:get(i, 1)) slope:set(i, 1, 1, 1, 1) end
  return value, slope
end
local wall = ylm.quad { corner = { -2, -0.37, -2 }, u = { 0, 0, 4 }, v = { 4, 0, 0 } }
local few, many = lamps(40), lamps(400)
local bakes = {
  { ylm.adaptive_grid { bounds = bounds, lmax = 3, depth = 5, tolerance = 0.05, channels = "rgb" }, few, { occupied = floor } },
  { ylm.adaptive_grid { bounds = bounds, lmax = 2, depth = 4, threshold = 2 }, { few, panel }, {} },
  { ylm.uniform_grid { bounds = bounds, cells = { 24, 20, 24 }, lmax = 2 }, many, { sums_tolerance = 0.05 } },
  { ylm.adaptive_grid { bounds = bounds, lmax = 2, depth = 3, threshold = 0.5 }, analytic, {} },
  { ylm.adaptive_grid { bounds = bounds, lmax = 1, depth = 4, tolerance = 0.1 }, analytic, { quantity = "direct",
    geometry = wall, scene = ylm.scene "a wall" { geometry = { wall }, lights = panel } } }, -- with sides
}
for i, one in ipairs(bakes) do
  one[3].team, one[3].threads = team.size > 1 and team or nil, THREADS
  local grid = assert(ylm.bake(one[1], one[2], one[3]))
  local mine = core.team_crc(core.grid_encode(grid)) .. " " .. grid.stats.points .. " " .. grid.stats.pairs
  for _, other in ipairs(assert(core.team_exchange(team.handle, mine))) do assert(other == mine, other .. " " .. mine) end
  if team.rank == 1 then print(i, mine) end
end
]]

describe("a bake that a team divides", function()
  local folder, run
  setup(function()
    folder = scratch.new()
    run = mpi.runner(folder)
  end)
  teardown(function() folder:remove() end)

  it("is that of one process, on any number of processes and threads", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local one, status = scratch.capture(("%s %s"):format(os.getenv "YLM_LUA" or "lua5.4",
      scratch.quote(folder:write("one.lua", (SCRIPT:gsub("THREADS", "1"))))))
    assert.equal(0, status, one)
    assert.equal(5, select(2, one:gsub("\n", "")), one)
    for _, case in ipairs { { 2, 2 }, { 3, 1 } } do
      local out
      out, status = run(case[1], "lua", (SCRIPT:gsub("THREADS", tostring(case[2]))))
      assert.equal(0, status, out)
      assert.equal(one, out)
    end
  end)

  it("is refused where processes were called differently, and ends for all where one ends it", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local out = run(3, "lua", [[
      local ylm = require "ylm"
      local team = ylm.team()
      local function bake(more, at, options)
        local fields = { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 2, depth = 4, threshold = 0.3 }
        for name, value in pairs(more) do fields[name] = value end
        options.team = team
        local ok, grid, message, code = pcall(ylm.bake, ylm.adaptive_grid(fields),
          ylm.sphere_light { at = { 0, 2, at }, radius = 0.1 }, options)
        local said = tostring(ok and message or grid):gsub("^[^:]*:%d+: ", "")
        if team.rank == 2 then print(ok and tostring(code) or "raised", said) end
      end
      bake({ lmax = team.rank == 3 and 3 or 2 }, 0, {})
      bake({}, team.rank == 2 and 0.1 or 0, {})
      bake({}, 0, { seed = team.rank })
      bake({}, 0, { progress = function() return team.rank ~= 1 end })
      bake({}, 0, { max_points = 100 })
      bake({ dynamic = true }, 0, {})
      bake({ threshold = 5 }, 0, {})]])
    assert.equal("raised\tbake: process 3 was called with another lmax than process 1\n"
      .. "raised\tbake: process 2 was called with another light field than process 1\n"
      .. "raised\tbake: process 2 was called with another seed than process 1\n"
      .. "ECANCELLED\tcancelled\n", out:match "^[^\n]*\n[^\n]*\n[^\n]*\n[^\n]*\n")
    assert(out:find("ELIMIT\t[^\n]*100[^\n]*\nraised\t[^\n]*dynamic = true is followed by one process[^\n]*\n"
      .. "nil\tylm.grid adaptive"), out)
  end)

  it("is the same command with the same file", function()
    if mpi.missing() then return pending(mpi.missing()) end
    local scene = scratch.quote(folder:write("scene.lua", [[return scene "floor" {
      geometry = { quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
      lights = { sphere_light { at = { 0.2, 0.5, 0 }, radius = 0.1, radiance = 5 } },
      probes = adaptive_grid { lmax = 3, depth = 5, tolerance = 0.02 } }]]))
    local two = folder.path .. "/two.ylm"
    local out, status = run(2, "ylm", ("bake %s -o %s --json"):format(scene, scratch.quote(two)))
    assert.equal(0, status, out)
    assert(out:find '"met":true' and select(2, out:gsub("\n", "")) == 1, out)
    out, status = scratch.capture(("%s bake %s -q -o %s"):format(require "spec.support.tool".command, scene,
      scratch.quote(folder.path .. "/one.ylm")))
    assert.equal(0, status, out)
    assert(folder:read "one.ylm" == folder:read "two.ylm")
  end)
end)
