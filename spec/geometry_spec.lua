local ylm = require "ylm"
local core = require "ylm.c.core"

--- Six times the volume that a mesh encloses; positive where triangles are counter-clockwise from outside.
local function volume(mesh)
  local v, sum = mesh:vertices():totable(), 0
  for _, t in ipairs(mesh:triangles():totable()) do
    local a, b, c = v[t[1]], v[t[2]], v[t[3]]
    sum = sum + a[1] * (b[2] * c[3] - b[3] * c[2]) + a[2] * (b[3] * c[1] - b[1] * c[3])
      + a[3] * (b[1] * c[2] - b[2] * c[1])
  end
  return sum / 6
end

describe("geometry", function()
  it("winds triangles counter-clockwise seen from outside", function()
    local pi = math.pi
    assert.near(4 / 3 * pi, volume(ylm.sphere { divide = { 96, 48 } }.mesh), 0.02)
    assert.near(6, volume(ylm.box { bounds = { { 0, 0, 0 }, { 1, 2, 3 } }, divide = 2 }.mesh), 1e-5)
    assert.near(2 * pi ^ 2 * 0.25 ^ 2, volume(ylm.torus { divide = { 96, 48 } }.mesh), 0.01)
    assert.is_true(volume(ylm.knot { divide = { 128, 16 } }.mesh) > 0)
    local quad = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }.mesh
    assert.same({ { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } }, quad:normals():totable())
  end)

  it("makes a knot of 300,000 triangles and more", function()
    assert.equal(384000, #ylm.knot { p = 2, q = 3, divide = { 3000, 64 } }.mesh)
  end)

  it("keeps arrays alive that were taken from a mesh", function()
    local normals = ylm.sphere { divide = { 8, 4 } }.mesh:normals()
    collectgarbage()
    collectgarbage()
    assert.is_true((core.array_finite(normals)))
  end)
end)
