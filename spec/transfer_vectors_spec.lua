-- Transfer vectors with bounces and transfer matrices: closed forms, distant light, and what they get wrong of local light.

local by_kernels = require "spec.support.by_kernels"
local elements = require "spec.support.elements"
local long = require "spec.support.long"
local relative = require "spec.support.vectors".relative
local ylm = require "ylm"

local pi = math.pi

local function near(x, truth, tolerance, what)
  assert.is_true(math.abs(x - truth) <= tolerance * math.abs(truth),
    ("%s: %.6g, not %.6g: off by %.2g of it"):format(what or "value", x, truth, math.abs(x / truth - 1)))
end

--- Channel c of row i of vectors T times coefficients L of light [3][count], as tables.
local function product(T, i, c, L)
  local sum, row = 0, T[i][c]
  for k = 1, #L[c] do sum = sum + row[k] * L[c][k] end
  return sum
end

--- The room of spec/support/elements.lua without a ceiling, a coloured box in it, and a camera that looks into it.
local function court(lights)
  local box = ylm.box { bounds = { { -0.6, 0, -0.6 }, { -0.1, 0.8, -0.1 } }, material = ylm.matte { albedo = { 0.7, 0.2, 0.1 } } }
  local s = elements.room({ 0.6, 0.7, 0.5 }, box, lights)
  table.remove(s.geometry, 2)
  s.camera = ylm.camera { from = { 0, 3.5, 1.2 }, at = { 0, 0, 0 }, fov = 50 }
  return s
end

local sky = ylm.environment_light { coefficients = { { 3, 0.2, 0.9, -0.4, 0.1, 0.2, -0.1, 0.3, 0.2 },
  { 2, 0.1, 0.5, 0.4, 0, 0.1, 0, -0.2, 0.1 }, { 4, 0, 1.2, 0, 0.2, 0, 0.3, 0, 0 } } }
local cut = { spacing = 0.25, rays = 64, lmax = 2 }

--- The coefficients of a light at points, [n][3][count] as tables.
local function light_at(light, points, lmax) return ylm.light_field(lmax, light, points, { dtype = "double" }):totable() end

describe("links:vectors", function()
  it("has sqrt(4 pi) T_00 = pi (1 - s) / (1 - rho s) in a bowl: of elements, of vertices and of a view's points", function()
    local g, rho = 1.2, { 0.5, 0.9, 0 }
    local s, bowl = (1 - math.cos(g)) / 2, elements.bowl(g, 24, rho)
    local scene = ylm.scene "bowl" { geometry = { bowl }, camera = ylm.camera { from = { 0, 0.01, 1.5 }, at = { 0, 0, 0 },
      fov = 60 } }
    local t = scene:links { spacing = 0.2, rays = 128, lmax = 1 }
    local T, stats = t:vectors { residual = 1e-5 }
    local e, first = t:elements(), ylm.zeros({ #T, 3 }, "float")
    for i = 1, #T do for c = 1, 3 do first:set(i, c, T:get(i, c, 1) * math.sqrt(4 * pi)) end end
    local v, P = t:vectors { object = 1, residual = 1e-5 }, scene:prepare { size = { 24, 24 }, samples = 1 }:transfer {
      links = t, residual = 1e-5 }
    assert.equal(#bowl.mesh:vertices(), #v)
    for c = 1, 3 do
      local truth, of_vertices, of_points = pi * (1 - s) / (1 - rho[c] * s), 0, 0
      near(elements.mean(e, first, c), truth, 6e-3, "elements") -- facets see a little more of the sky
      for i = 1, #v do of_vertices = of_vertices + v:get(i, c, 1) * math.sqrt(4 * pi) / #v end
      for i = 1, #P do of_points = of_points + P:get(i, c, 1) * math.sqrt(4 * pi) / #P end
      near(of_vertices, truth, 0.02, "vertices")
      near(of_points, truth, 0.02, "points")
    end
    assert.is_true(stats.residual <= 1e-5 and stats.bounces > 3 and stats.shrink > 0)
  end)

  it("times the light of a sky is what radiosity finds, element by element, bounce by bounce", function()
    local t = court(sky):links(cut)
    local L = light_at(sky, { { 0, 0, 0 } }, 2)[1]
    for _, bounces in ipairs { 0, 1, 3, "all" } do
      local o = { bounces = bounces, direct = "field", residual = 1e-6, closure = false }
      local E = t:radiosity(sky, o):irradiance()
      local T = t:vectors { bounces = bounces, residual = 1e-6, closure = false }:totable()
      for i = 1, #E, 7 do
        for c = 1, 3 do assert.is_near(E:get(i, c), product(T, i, c, L), 2e-5 * math.abs(E:get(i, c)) + 1e-5) end
      end
    end
    local closed, with_rest = t:vectors {}
    local open, without = t:vectors { closure = false, residual = 1e-6 }
    assert(relative(closed, open) < 1e-3)
    assert.is_true(with_rest.closed and not without.closed and with_rest.bounces < without.bounces)
  end)

  it("is one channel, copied, where no albedo is coloured", function()
    local s = elements.room(0.5)
    table.remove(s.geometry, 2)
    local T = s:links(cut):vectors()
    for i = 1, #T, 11 do assert.equal(0, relative(T[i][1], T[i][3]) + relative(T[i][1], T[i][2])) end
    assert(T:get(1, 3, 1) > 0)
  end)

  it("and matrices do not depend on the number of threads", function()
    local s = court(sky)
    local t, view = s:links(cut), s:prepare { size = { 12, 8 }, samples = 1 }
    local function found(threads)
      local T, points = t:vectors { threads = threads }, view:transfer { links = t, threads = threads }
      return { T, points, (view:matrices { links = t, rays = 96, threads = threads }) }
    end
    local one = found(1)
    for _, threads in ipairs { 2, 7 } do
      for k, a in ipairs(found(threads)) do assert.equal(0, relative(a, one[k]), k) end
    end
  end)

  it("is cancelled, and leaves nothing behind", function()
    local s = court(sky)
    local t, view = s:links(cut), s:prepare { size = { 12, 8 }, samples = 1 }
    local cancel = { links = t, progress = function() return false end }
    local cancelled = { nil, "cancelled", "ECANCELLED" }
    assert.same(cancelled, { t:vectors { progress = cancel.progress } })
    assert.same(cancelled, { view:transfer(cancel) })
    cancel.bounces = 0
    assert.same(cancelled, { view:transfer(cancel) })
    assert.same(cancelled, { view:matrices(cancel) })
    local stages = {}
    view:matrices { links = t, rays = 16, progress = function(_, _, stage) stages[stage] = true end }
    assert.same({ bounces = true, matrices = true }, stages)
  end)

  it("is right for a sky, and wrong by more than a fifth for a lamp near a wall, which radiosity gets right", function()
    local lamp = ylm.sphere_light { at = { -0.8, 0.6, 0.3 }, radius = 0.05, radiance = { 60, 50, 40 } }
    local points, normals = {}, {}
    local s = court(lamp)
    local t = s:links { spacing = long(0.1, 0.05), rays = long(128, 512), lmax = 4, sides = "front" }
    local e, lit, T = t:elements(), t:radiosity(nil, { light_samples = 64 }), t:vectors():totable()
    local E, straight, T0 = lit:irradiance(), lit:irradiance "direct", t:vectors { bounces = 0 }:totable()
    local sums = { radiosity = { 0, 0, 0 }, vectors = { 0, 0, 0 }, bounced = { 0, 0, 0 }, wrong = { 0, 0, 0 } }
    for i = 1, #e.area, math.floor(#e.area / 110) do
      local n, x = {}, {}
      for a = 1, 3 do n[a], x[a] = e.normal:get(i, a), e.centre:get(i, a) end
      if x[1] * n[1] + (x[2] - 1) * n[2] + x[3] * n[3] < -0.9 then -- of a wall's inner side, or the floor
        points[#points + 1], normals[#normals + 1] = x, n
        local L = light_at(lamp, { x }, 4)[1]
        for c = 1, 3 do
          local direct, all = product(T0, i, c, L), product(T, i, c, L)
          sums.radiosity[c] = sums.radiosity[c] + E:get(i, c)
          sums.vectors[c] = sums.vectors[c] + all
          sums.bounced[c] = sums.bounced[c] + E:get(i, c) - straight:get(i, c)
          sums.wrong[c] = sums.wrong[c] + all - direct
        end
      end
    end
    local truth = s:probe { points = points, normals = normals, samples = long(1024, 16384) }
    assert.is_true(#points > 20)
    for c = 1, 3 do
      local sum = 0
      for i = 1, #points do sum = sum + truth:get(i, c) end
      near(sums.radiosity[c], sum, 0.01, "radiosity")
      assert.is_true(math.abs(sums.vectors[c] / sum - 1) > 0.2, "all light")
      assert.is_true(math.abs(sums.wrong[c] / sums.bounced[c] - 1) > 0.2, "what bounces")
    end
  end)
end)

describe("view:render by vectors", function()
  it("multiplies vectors, light and albedo at each point; its own vectors are the reference's picture", function()
    local s = court(sky)
    s.camera = ylm.camera { from = { 0, 3.5, 0.4 }, at = { 0, 0, 0 }, fov = 12 } -- sees no sky
    local view = s:prepare { size = { 12, 8 }, samples = 1, lmax = 2, visibility = "transfer", share = 0 }
    local own = view:render { vectors = view:transfer() }
    assert(relative(own:layer(), view:render { by = "sum" }:layer()) < 1e-6)
    local t = s:links(cut)
    local T = view:transfer { links = t }
    local image = view:render { vectors = T }
    local L, albedo = light_at(sky, { { 0, 0, 0 } }, 2)[1], view:points().albedo
    local sums, wanted, rows = { 0, 0, 0 }, { 0, 0, 0 }, T:totable()
    for i = 1, #rows do
      for c = 1, 3 do wanted[c] = wanted[c] + product(rows, i, c, L) * albedo:get(i, c) / pi end
    end
    for _, row in ipairs(image:layer():totable()) do
      for _, p in ipairs(row) do for c = 1, 3 do sums[c] = sums[c] + p[c] end end
    end
    assert.equal(96, #T)
    for c = 1, 3 do near(sums[c], wanted[c], 1e-5, "channel " .. c) end
  end)
end)

describe("view:matrices", function()
  it("cuts the sphere at the horizon in the open: the matrix of a hemisphere", function()
    local floor = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } }
    local s = ylm.scene "a floor" { geometry = floor, camera = ylm.camera { from = { 0, 2, 0 }, at = { 0, 0, 0 },
      up = { 0, 0, 1 }, fov = 20 } }
    local M = s:prepare { size = { 3, 3 }, samples = 1 }:matrices { links = s:links { rays = 4, lmax = 3 }, rays = 4096 }
    local half = ylm.sh.product_matrix(ylm.sh.cap(6, { 0, 1, 0 }, pi / 2), 3)
    for i = 1, #M do
      for c = 1, 3 do assert(relative(ylm.array(M[i][c], "double"), half) < 3e-3) end
    end
  end)

  it("times the clamped cosine are transfer vectors, straight and with bounces, to the noise of rays", function()
    local s = court(sky)
    local t, view = s:links(cut), s:prepare { size = { 12, 8 }, samples = 1 }
    local normal = view:points().normal
    local cosine = { pi, 2 * pi / 3, pi / 4, 0, -pi / 24, 0, pi / 64 } -- by degree
    for _, bounces in ipairs { 0, 2, "all" } do
      local M = view:matrices { links = t, bounces = bounces, lmax_out = 6, rays = 1024 }:totable()
      local T = view:transfer { links = t, bounces = bounces, rays = 1024 }
      local sum2, all2 = 0, 0
      for i = 1, #M do
        local Y, A = ylm.sh.eval(6, { { normal:get(i, 1), normal:get(i, 2), normal:get(i, 3) } })[1], {}
        for j = 1, 49 do A[j] = cosine[math.floor(math.sqrt(j - 1)) + 1] * Y:get(j) end
        for c = 1, 3 do
          for k = 1, 9 do
            local x = 0
            for j = 1, 49 do x = x + A[j] * M[i][c][j][k] end
            sum2, all2 = sum2 + (x - T:get(i, c, k)) ^ 2, all2 + T:get(i, c, k) ^ 2
          end
        end
      end
      assert(math.sqrt(sum2 / all2) < 0.03, ("%s: %g"):format(bounces, math.sqrt(sum2 / all2)))
    end
  end)

  it("is applied to the light of a sky by sh.apply", function()
    local s = court(sky)
    local t, view = s:links(cut), s:prepare { size = { 6, 4 }, samples = 1 }
    local M = view:matrices { links = t, lmax_out = 3, rays = 64 }
    local L = ylm.light_field(2, sky, { 0, 0, 0 })
    local incident = ylm.sh.apply(M, L)
    assert.same({ #M, 3, 16 }, incident.shape)
    local x = 0
    for k = 1, 9 do x = x + M:get(5, 2, 3, k) * L:get(2, k) end
    assert.is_near(x, incident:get(5, 2, 3), 1e-5)
  end)

  it("is the same by each set of kernels, to rounding", function()
    local script = [[
      local elements = require "spec.support.elements"
      local ylm, s = require "ylm", elements.room(0.7)
      table.remove(s.geometry, 2)
      s.camera = ylm.camera { from = { 0, 3, 1 }, at = { 0, 0, 0 }, fov = 50 }
      local t = assert(s:links { spacing = 1, rays = 16 })
      local sum, w = 0, 1
      for _, point in ipairs(s:prepare({ size = { 4, 4 }, samples = 1 }):matrices({ links = t, rays = 100 }):totable()) do
        for _, matrix in ipairs(point) do
          for _, row in ipairs(matrix) do for _, x in ipairs(row) do sum, w = sum + w * x, -1.01 * w % 2 end end
        end
      end
      io.write(("%.9g"):format(sum))]]
    local values = {}
    for _, isa in ipairs(ylm.info().kernels) do values[#values + 1] = by_kernels(isa, script)[1] end
    assert.equal(#ylm.info().kernels, #values)
    for _, x in ipairs(values) do near(x, values[1], 1e-4, "kernels") end
  end)
end)
