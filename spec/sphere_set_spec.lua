local ylm = require "ylm"

local sqrt = math.sqrt

--- The part of the places of a lattice in a box around the body that the spheres and inside(x, y, z) disagree about, of the body.
local function apart(at, radius, inside, half, n)
  local wrong, all = 0, 0
  at, radius = at:totable(), radius:totable()
  for i = 0, n - 1 do for j = 0, n - 1 do for k = 0, n - 1 do
    local x, y, z = half * (2 * (i + 0.37) / n - 1), half * (2 * (j + 0.41) / n - 1), half * (2 * (k + 0.43) / n - 1)
    local covered = false
    for s = 1, #radius do
      local p = at[s]
      if (x - p[1]) ^ 2 + (y - p[2]) ^ 2 + (z - p[3]) ^ 2 <= radius[s] ^ 2 then
        covered = true
        break
      end
    end
    local body = inside(x, y, z)
    if covered ~= body then wrong = wrong + 1 end
    if body then all = all + 1 end
  end end end
  return wrong / all
end

describe("ylm.sphere_set", function()
  it("has one sphere for a sphere", function()
    local at, radius, report = ylm.sphere_set(ylm.sphere { at = { 3, 4, 5 }, radius = 2, divide = { 64, 32 } }, { count = 1 })
    assert.same({ { 3, 4, 5 } }, at:totable())
    assert.is_near(2, radius:get(1), 0.02)
    assert.is_near(32 / 3 * math.pi, report.volume, 0.3)
    assert(report.outside + report.uncovered < 0.02 * report.volume)
  end)

  it("comes nearer with more spheres, as other places than its own say too", function()
    local function box(x, y, z) return math.max(math.abs(x), math.abs(y), math.abs(z)) <= 0.5 end
    local function ring(x, y, z) return (sqrt(x * x + y * y) - 1) ^ 2 + z * z <= 0.09 end
    for _, case in ipairs { { ylm.box {}, box, 0.7, { [8] = 0.2, [64] = 0.08 } },
      { ylm.torus { radius = 1, tube = 0.3, divide = { 96, 32 } }, ring, 1.4, { [16] = 0.14, [64] = 0.05 } } } do
      for count, bound in pairs(case[4]) do
        local at, radius, report = ylm.sphere_set(case[1], { count = count })
        local e = apart(at, radius, case[2], case[3], 22)
        assert(e < bound, ("%d spheres: %g"):format(count, e))
        assert.is_near(e, (report.outside + report.uncovered) / report.volume, 0.04)
        assert.equal(#radius, at.shape[1])
        assert.is_true(#radius <= count)
      end
    end
  end)

  it("is the same each time, whatever way the triangles turn, and of parts that overlap", function()
    local m = ylm.box {}.mesh
    local turned, two, corners = {}, {}, m:vertices():totable()
    for i, t in ipairs(m:triangles():totable()) do turned[i], two[i] = { t[1], t[3], t[2] }, t end
    local at, radius = ylm.sphere_set(m, { count = 20 })
    local again, other = ylm.sphere_set(ylm.mesh { vertices = m:vertices(), triangles = turned }, { count = 20 })
    assert.same(at:totable(), again:totable())
    assert.same(radius:totable(), other:totable())
    for i = 1, #m:vertices() do corners[#corners + 1] = { corners[i][1] + 0.5, corners[i][2], corners[i][3] } end
    for i = 1, #turned do
      two[#two + 1] = {}
      for k = 1, 3 do two[#two][k] = two[i][k] + #m:vertices() end
    end
    local centres, radii = ylm.sphere_set(ylm.mesh { vertices = corners, triangles = two }, { count = 64 })
    local e = apart(centres, radii, function(x, y, z)
      return math.abs(x - 0.25) <= 0.75 and math.abs(y) <= 0.5 and math.abs(z) <= 0.5
    end, 1.1, 22)
    assert(e < 0.12, e)
  end)

  it("says so where spheres do not stand for the body", function()
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message end)
    local _, _, report = ylm.sphere_set(ylm.box { scale = { 1, 1e-3, 1 } }, { count = 4 })
    ylm.on_warning(before)
    assert.same(said, report.warnings)
    assert.matches("4 spheres miss or add %d+ %% of the body's volume: more of them", said[1])
  end)

  it("reports how far it is, and stops where it is told to", function()
    local said = 0
    local at, message, code = ylm.sphere_set(ylm.knot {}, { count = 4096, progress = function(done, total, stage)
      said = said + 1
      assert(done <= total and stage == "spheres")
      return false
    end })
    assert.same({ nil, "cancelled", "ECANCELLED", 1 }, { at, message, code, said })
  end)
end)
