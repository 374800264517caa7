-- Pages in a browser: bytes, and seconds from opening the file to its poster, its first picture and the one at rest.
--
--     make bench BENCH=page
--
-- Headless Chromium draws by SwiftShader, on processors; 640 x 360 pixels, medians of three. The poster is a picture from the
-- scene's camera that the file has. The first picture that the viewer draws has a sample for four pixels, the next one a sample a
-- pixel, the one at rest four.

local browser = require "spec.support.browser"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local quick = os.getenv "BENCH" == "quick"
local missing = browser.missing()
if missing then
  print(missing)
  return
end

local SIZE = quick and { 128, 72 } or { 640, 360 }
local folder = scratch.new()

local function median(list)
  table.sort(list)
  return list[math.ceil(#list / 2)]
end

--- When the poster was on the screen, by the browser's element timing.
local SEEN = [[new Promise(done => new PerformanceObserver(list => done(list.getEntries()[0].renderTime))
  .observe({ type: 'element', buffered: true }))]]

--- Seconds from the navigation to the first picture, to the one that the words ask for, and to the poster.
local function seconds(window, path, words)
  local first, drawn, poster = {}, {}, {}
  for i = 1, quick and 1 or 3 do
    window:visit(path, words)
    window:wait "ready"
    first[i] = window:eval "performance.getEntriesByName('first picture')[0].startTime" / 1000
    drawn[i], poster[i] = window:eval "performance.now()" / 1000, window:eval(SEEN) / 1000
  end
  return median(first), median(drawn), median(poster)
end

print "| scene | probes | MB | poster, s | first picture, s | a sample a pixel, s | picture at rest, s |"
print "| --- | --: | --: | --: | --: | --: | --: |"
for _, one in ipairs { { "two_lamps", 6 }, { "floor_lights", 8 } } do
  local scene = assert(ylm.load("examples/scenes/" .. one[1] .. ".lua"))
  local grid = assert(scene:bake { probes = ylm.adaptive_grid { lmax = 4, depth = quick and 3 or one[2], tolerance = 0.05 } })
  local path = folder.path .. "/" .. one[1] .. ".html"
  assert(grid:save(path, { scene = scene, limit = 100e6 }))
  local window = browser.open { size = SIZE, limit = 600 }
  local first, whole, poster = seconds(window, path, "bare&samples=1")
  local _, rest = seconds(window, path, "bare&still")
  window:close()
  print(("| %s | %d | %.1f | %.1f | %.1f | %.1f | %.1f |"):format(one[1], grid.stats.points, #scratch.text(path) / 1e6, poster,
    first, whole, rest))
end
folder:remove()
