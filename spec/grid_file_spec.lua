--- grid:save and ylm.load of grids.

local core = require "ylm.c.core"
local ylm = require "ylm"
local grids = require "spec.support.grids"

local box, lamp, lamps, occupied = grids.box, grids.lamp, grids.lamps, grids.occupied

describe("grid files", function()
  local function scratch(name) return os.tmpname() .. name end
  local grid_file = require "ylm.grid"

  local function same(a, b)
    for _, pair in ipairs { { a:points(), b:points() }, { a:cells(), b:cells() } } do
      for name, array in pairs(pair[1]) do
        if name ~= "error" and name ~= "residual" then assert.equal(0, (core.array_distance(array, pair[2][name])),
          name) end
      end
    end
    assert.equal(0, core.array_distance(a:sample(occupied), b:sample(occupied)))
    -- where the time of a bake went is known to the grid that was baked only
    local lost = { bytes = true, occupancy_seconds = true, lattice_seconds = true, residual_seconds = true,
      continuity_seconds = true }
    for key, value in pairs(a.stats) do
      if not lost[key] and value == value then assert.equal(value, b.stats[key], key) end
    end
  end

  local grid = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 2, depth = 5, tolerance = 0.02 }, lamps,
    { occupied = occupied })

  it("keep everything, in either byte order", function()
    local path = scratch ".ylm"
    for _, order in ipairs { "native", "swapped" } do
      assert.is_true(grid:save(path, { byte_order = order }))
      same(grid, assert(grid_file.load(path)))
    end
    local file = assert(io.open(path, "rb"))
    assert.equal(grid_file.magic, file:read(8))
    file:close()
    os.remove(path)
    local uniform = ylm.bake(ylm.uniform_grid { bounds = box, cells = { 3, 2, 5 }, lmax = 1 }, lamp,
      { occupied = occupied })
    assert.is_true(uniform:save(path))
    same(uniform, assert(grid_file.load(path)))
    os.remove(path)
  end)

  it("are written for ParaView too", function()
    local path = scratch ".vtu"
    assert.is_true(grid:save(path))
    local file = assert(io.open(path, "rb"))
    assert.is_truthy(file:read(200):find("UnstructuredGrid", 1, true))
    file:close()
    os.remove(path)
    assert.is_nil((grid:save "/no/such/folder/grid.vtu"))
  end)

  it("are what ylm.load knows by content", function()
    local path = scratch ".ylm"
    assert.is_true(grid:save(path))
    same(grid, assert(ylm.load(path)))
    os.remove(path)
  end)

  it("refuse every truncation and every flipped bit", function()
    for _, swapped in ipairs { false, true } do
      local small = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 0, channels = "luminance" }, lamp)
      assert.equal(0, core.grid_accepted_damage(core.grid_encode(small, swapped)))
    end
    local octree = ylm.bake(ylm.adaptive_grid { bounds = box, lmax = 0, depth = 1, threshold = 0,
      channels = "luminance" }, lamp)
    assert.equal(0, core.grid_accepted_damage(core.grid_encode(octree, false)))
  end)

  it("refuse what is no grid, in words", function()
    local path = scratch ".ylm"
    local file = assert(io.open(path, "wb"))
    file:write("P6 3 3 255 something else")
    file:close()
    local g, message, code = grid_file.load(path)
    assert.is_nil(g)
    assert.equal("EFORMAT", code)
    assert.is_true(message:find("not a grid file", 1, true) ~= nil)
    os.remove(path)
    g, message, code = grid_file.load(path)
    assert.is_nil(g)
    assert.equal("EIO", code)
    assert.is_true(message:find(path, 1, true) ~= nil)
    g, message, code = grid_file.load("/")
    assert.is_nil(g)
    assert.equal("EIO", code)
    assert.is_string(message)
  end)

  it("keep the old file where the new one cannot be written", function()
    local path = scratch ".ylm"
    assert.is_true(grid:save(path))
    local ok, message, code = grid:save("/proc/ylm.ylm")
    assert.is_nil(ok)
    assert.is_string(message)
    assert.equal("EIO", code)
    assert(grid_file.load(path))
    os.remove(path)
  end)
end)
