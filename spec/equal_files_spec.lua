-- Equal runs write equal files: no times, no addresses, nothing in the order of a hash.

local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local lua = os.getenv "YLM_LUA" or "lua5.4"

local scene = [[
return scene "a lamp" {
  camera = camera { from = { 3, 2, 3 }, at = { 0, 0, 0 }, fov = 45 },
  geometry = { quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 4 } },
  lights = { sphere_light { at = { -0.8, 0.5, 0.9 }, radius = 0.08, radiance = { 40, 30, 18 } } },
  probes = adaptive_grid { lmax = 2, depth = 3, tolerance = 0.05 },
}]]

--- Saves a grid, and pictures by every method, with the second argument before their names.
local program = [[
local ylm = require "ylm"
local folder, run = ...
local scene = assert(ylm.load(folder .. "/scene.lua"))
local function save(x, name) assert(x:save(folder .. "/" .. run .. name)) end
local size = { 12, 8 }
local grid = assert(scene:bake { occupied = "camera", size = size })
save(grid, ".ylm")
local picture = assert(scene:render { size = size, grid = grid, layers = true })
for _, ending in ipairs { ".exr", ".png", ".hdr", ".pfm" } do save(picture, ending) end
save(assert(scene:render { bounces = 0, size = size, light_samples = 64 }), "_raycast.exr")
save(assert(scene:render { by = "sum", size = size }), "_reference.exr")
]]

local names = { ".ylm", ".exr", ".png", ".hdr", ".pfm", "_raycast.exr", "_reference.exr" }

describe("files of equal runs", function()
  it("are equal in bytes: grids, and images of every method", function()
    local folder = scratch.new()
    finally(function() folder:remove() end)
    folder:write("scene.lua", scene)
    local path = folder:write("run.lua", program)
    for run = 1, 3 do -- Lua 5.4 walks tables in an order of its own in every process
      local out, code = scratch.capture(("YLM_LUA=%s LUA_PATH= LUA_CPATH= %s run %s %s %d"):format(lua,
        scratch.quote(build .. "/ylm"), scratch.quote(path), scratch.quote(folder.path), run))
      assert.equal(0, code, out)
    end
    for _, name in ipairs(names) do
      local first = assert(folder:read("1" .. name))
      for run = 2, 3 do assert(first == folder:read(run .. name), name) end
    end
  end)
end)
