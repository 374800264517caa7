-- Updates in which memory runs out at every request in turn: once, and from there on.
--
--     LD_PRELOAD=failure.so lua5.4 spec/support/update_memory.lua STRIDE
--
-- Every STRIDE-th request is tried; with 1 also uniform grids, and more changes.
-- A failed update leaves the grid as it was, or spent. A grid that is not spent takes the update afterwards. Prints a line
-- for each defect, and counts last; its exit status is 1 where there was a defect.

local failure = require "failure"
local core = require "ylm.c.core"
local light = require "ylm.light"
local ylm = require "ylm"

local box = { { -1, -1, -1 }, { 1, 1, 1 } }
local floor = {}
for i = 0, 15 do
  for k = 0, 15 do floor[#floor + 1] = { i / 8 - 0.93, -0.9, k / 8 - 0.93 } end
end
floor = ylm.array(floor, "double")

local function lamp(x, y, z) return ylm.sphere_light { at = { x, y, z }, radius = 0.05, radiance = { 10, 8, 6 } } end

local stride = tonumber(arg[1] or 1)
local panel = ylm.polygon_light { vertices = { { -0.2, 0.8, -0.2 }, { 0.2, 0.8, -0.2 }, { 0, 0.8, 0.3 } }, radiance = 5 }

--- Lights before, and after the update: one moves across the floor; a lamp dives into it and a panel appears; dark.
local stand = { lamp(0.6, 0.5, 0.6), lamp(-0.6, 0.5, 0.5), lamp(0, 0.9, -0.6) }
local function with(...) return { stand[1], stand[2], stand[3], ... } end
local changes = {
  { "moved", with(lamp(-0.5, -0.7, 0)), with(lamp(0.5, -0.75, 0.1)) },
  { "nudged", with(lamp(-0.5, -0.6, 0)), with(lamp(-0.49, -0.6, 0)) },
  { "dived", with(lamp(0, 0, 0)), with(lamp(0.3, -0.89, 0.2), panel) },
  { "dark", with(lamp(-0.5, -0.6, 0)), {} },
}

local function adaptive(fields)
  fields.bounds, fields.lmax, fields.dynamic, fields.depth = box, 1, true, fields.depth or 4
  return ylm.adaptive_grid(fields)
end
local descriptions = {
  { "by a threshold", adaptive { threshold = 6 } },
  { "by a tolerance", adaptive { tolerance = 0.05, depth = 5 } },
  { "uniform", ylm.uniform_grid { bounds = box, cells = 3, lmax = 1, dynamic = true } },
}

local everywhere = {}
for i = 1, 200 do everywhere[i] = { (i * 0.37) % 2 - 1, (i * 0.61) % 2 - 1, (i * 0.83) % 2 - 1 } end
everywhere = ylm.array(everywhere, "double")

local defects, failures, spent = 0, 0, 0

--- The largest difference of what two grids sample.
local function samples_differ(a, b)
  return math.max((core.array_distance(a:sample(floor), b:sample(floor))),
    (core.array_distance(a:sample(everywhere), b:sample(everywhere))))
end

--- The largest difference of what two grids sample, and of their points' data.
local function difference(a, b)
  local pa, pb, d = a:points(), b:points(), samples_differ(a, b)
  if #pa.position ~= #pb.position then return math.huge end
  for _, name in ipairs { "position", "value", "gradient", "lambda", "norm" } do
    d = math.max(d, (core.array_distance(pa[name], pb[name])))
  end
  return d
end

--- One update while requests a to b fail, and the same afterwards; `before` and `after` are what it should have led to.
-- Returns how many requests there were.
local function try(where, bake, now, before, after, a, b)
  local function defect(text, ...)
    defects = defects + 1
    io.write(("DEFECT %s, requests %d to %d fail: "):format(where, a, b), text:format(...), "\n")
  end
  local grid = bake()
  collectgarbage()
  failure.arm(a, b)
  local ok, report, message, code = pcall(grid.update, grid, now, { threads = 1 })
  local requests = failure.requests()
  failure.arm(0)
  if not ok then defect("raised %s", tostring(report))
  elseif report then
    if samples_differ(grid, after) > 0 then defect "succeeded, but is no update" end
  else
    failures = failures + 1
    if code ~= "ENOMEM" or type(message) ~= "string" then defect("nil, %s, %s", tostring(message), tostring(code)) end
    if tostring(grid) == "ylm.grid (spent)" then
      spent = spent + 1
      for _, call in ipairs { function() grid:sample(floor) end, function() grid:update(now) end,
        function() return grid.stats end, function() ylm.light_field(1, grid, floor) end } do
        local good, says = pcall(call)
        if good or not tostring(says):find("is spent", 1, true) then defect("spent, but %s", tostring(says)) end
      end
      grid:close()
      return requests
    end
    if difference(grid, before) > 0 then defect "is not as it was" end
    if grid.stats.update then defect "counts an update" end
    assert(grid:update(now, { threads = 1 }))
    if difference(grid, after) > 0 then defect "is not what an update leads to afterwards" end
  end
  return requests
end

-- Lights are packed before: grid:update is what runs out of memory.
for _, change in ipairs(changes) do change[3] = light.field(1, "update", change[3]) end

if stride > 1 then
  table.remove(descriptions)
  table.remove(changes, 3)
end
for _, d in ipairs(descriptions) do
  for _, change in ipairs(changes) do
    local where = d[1] .. ", " .. change[1]
    local function bake() return assert(ylm.bake(d[2], change[2], { occupied = floor, threads = 1 })) end
    local before, after = bake(), bake()
    assert(after:update(change[3], { threads = 1 }))
    local requests, first = try(where, bake, change[3], before, after, 1e9, 1e9), failures
    for a = 1, requests, stride do
      try(where, bake, change[3], before, after, a, a)
      try(where, bake, change[3], before, after, a, 1e9)
    end
    io.write(("%-24s %3d requests, %3d failures\n"):format(where, requests, failures - first))
  end
end
io.write(("%d failures, %d spent, %d defects\n"):format(failures, spent, defects))
os.exit(defects == 0 and 0 or 1)
