-- Shadows in probes, frame by frame: eight cubes turn over a floor, the light behind them is baked for its vertices, each bake
-- like the last, and all vertices are shaded.
--
--     make bench BENCH=shadow_frames
--
-- A frame is move, bake, radiance of all vertices; the first is left out. Beside it stand a bake that is like none, and light
-- asked at all vertices. Errors are those of the last frame: vertices whose light in the grid misses the tolerance.

local ylm = require "ylm"
local core = require "ylm.c.core"

local quick = os.getenv "BENCH" == "quick"
local BODIES, FRAMES, TOLERANCE = 8, quick and 3 or 24, 0.05

local function places(frame)
  local at, turns = {}, {}
  for i = 1, BODIES do
    local phi = 2 * math.pi * i / BODIES + 0.03 * frame
    at[i] = { 1.8 * math.cos(phi), 0.9 + 0.1 * (i % 3), 1.8 * math.sin(phi) }
    turns[i] = { math.cos(0.3 * i + 0.02 * frame), math.sin(0.3 * i + 0.02 * frame), 0.2, 0.1 }
  end
  return { many = { at = at, rotation = turns } }
end

local function good(x, message) return assert(x, message), message end

--- A floor of side^2 vertices under an overcast sky and a lamp, as a view that shades all of them.
local function floor(side, lmax)
  local scene = ylm.scene "floor" { camera = ylm.camera { from = { 0, 5, 6 } },
    geometry = { ylm.quad { corner = { -3, 0, 3 }, u = { 6, 0, 0 }, v = { 0, 0, -6 }, divide = side - 1 } },
    lights = {} }
  return good(scene:prepare { size = { 32, 18 }, samples = 1, relight = "all", visibility = "none", lmax = lmax })
end

print(("Frames of %d cubes over a floor, tolerance %g, rgb, threads as set."):format(BODIES, TOLERANCE))
print()
print "| n | vertices | way | probes | bake ms | shade ms | processor ms | frames a second | misses % |"
print "| --: | --: | --- | --: | --: | --: | --: | --: | --: |"

for _, case in ipairs { { 9, quick and 40 or 174 }, { 14, quick and 40 or 580 } } do
  local lmax, side = case[1], case[2]
  local view = floor(side, lmax)
  local cube = good(ylm.bake(ylm.adaptive_grid { lmax = lmax, depth = quick and 6 or 10, tolerance = 0.03,
    channels = "luminance" }, ylm.occluder { geometry = ylm.box { scale = 0.6 } }))
  local shade = ylm.shadowed { lights = ylm.environment_light { sky = { kind = "clear", sun = { 1, 0.8, 0.3 } } },
    casters = { many = ylm.casters { hides = cube, at = places(0).many.at } } }
  local probes = ylm.adaptive_grid { bounds = { { -3.1, -0.1, -3.1 }, { 3.1, 6.1, 3.1 } }, lmax = lmax, depth = 9,
    tolerance = TOLERANCE }
  for _, way in ipairs { "probes, each like the last", "probes, anew", "at every vertex" } do
    local bake, all, clock, frames, grid = 0, 0, 0, 0, nil
    for frame = 0, way == "at every vertex" and 3 or FRAMES do
      local start, cpu, baked = core.seconds(), os.clock(), 0
      shade:move(places(frame))
      if way ~= "at every vertex" then
        local new = good(ylm.bake(probes, shade, { occupied = view, like = way:find "like" and grid or nil }))
        if grid then grid:close() end
        grid, baked = new, core.seconds() - start
      end
      good(view:radiance { grid = grid or shade })
      if frame > 0 then
        frames, bake, all, clock = frames + 1, bake + baked, all + core.seconds() - start, clock + os.clock() - cpu
      end
    end
    local misses = "-"
    if grid then
      local some = {}
      for i = 1, 2000 do some[i] = { (i * 0.6180339887 % 1) * 6 - 3, 0, (i * 0.7548776662 % 1) * 6 - 3 } end
      local e, failed = ylm.sh.relative_error(grid:sample(some), ylm.light_field(lmax, shade, some)), 0
      for _, x in ipairs(e:totable()) do if (type(x) == "table" and x[1] or x) > TOLERANCE then failed = failed + 1 end end
      misses = ("%.2f"):format(100 * failed / #some)
    end
    print(("| %d | %d | %s | %s | %.1f | %.1f | %.1f | %.1f | %s |"):format(lmax + 1, side * side, way,
      grid and grid.stats.points or "-", 1e3 * bake / frames, 1e3 * (all - bake) / frames, 1e3 * clock / frames, frames / all,
      misses))
  end
end
