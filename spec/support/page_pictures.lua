-- docs/images/page.png, from a page in headless Chromium: `make page-pictures`.

local browser = require "spec.support.browser"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

assert(not browser.missing(), browser.missing())
local folder = scratch.new()
local scene = assert(ylm.load "examples/scenes/two_lamps.lua")
local grid = assert(scene:bake { probes = ylm.adaptive_grid { lmax = 4, depth = 6, tolerance = 0.05 } })
assert(grid:save(folder.path .. "/a.html", { scene = scene, poster = false, exposure = 1 }))

local W, H = 480, 270
local window = browser.open { size = { W, H }, limit = 600 }
window:visit(folder.path .. "/a.html", "bare&still")

local sheet = ylm.image { size = { 2 * W, 2 * H } }
local function shot(x, y, words)
  window:wait "ready"
  sheet:paste(assert(ylm.load(window:screenshot(folder.path .. "/shot.png"))), x, y)
  sheet:text(x + 10, y + 10, words, { colour = { 1, 1, 1 }, scale = 2 })
end

shot(1, 1, "the grid")
window:go "bare&still&lines"
shot(W + 1, 1, "edges of the octree")
window:go "bare&still&mode=error"
shot(1, H + 1, "error x 100")
window:go "bare&still&lobes"
window:wait "ready"
window:mouse("mousePressed", 143, 173)
for i = 1, 4 do window:mouse("mouseMoved", 143 + 4 * i, 173 - 14 * i) end
window:mouse("mouseReleased", 159, 117)
shot(W + 1, H + 1, "a lamp dragged, lobes")
assert(#window.said == 0, window.said[1])
window:close()
assert(sheet:save "docs/images/page.png")
folder:remove()
