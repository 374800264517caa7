local by_kernels = require "spec.support.by_kernels"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local randoms = require "spec.support.random"
local relative = require "spec.support.vectors".relative

local sh, sqrt, pi = ylm.sh, math.sqrt, math.pi
local ONE = sqrt(4 * pi)

local seed = tonumber(os.getenv "YLM_SEED") or 20261123
local random = randoms.from(seed % 65521 + 1)

--- n places at a distance from the origin.
local function around(n, near, far) return randoms.around(random, n, near, far) end

--- A closed mesh from corners and triangles.
local function solid(corners, triangles)
  return ylm.mesh { vertices = corners, triangles = triangles }
end

local function tetrahedron()
  return solid({ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1.2, 0 }, { 0, 0, 0.8 } },
    { { 1, 3, 2 }, { 1, 2, 4 }, { 2, 3, 4 }, { 3, 1, 4 } })
end

local function prism(n)
  local corners, triangles = { { 0, 0, -0.4 }, { 0, 0, 0.4 } }, {}
  for i = 0, n - 1 do
    local x, y = math.cos(2 * pi * i / n), math.sin(2 * pi * i / n)
    corners[#corners + 1], corners[#corners + 2] = { x, y, -0.4 }, { x, y, 0.4 }
  end
  for i = 0, n - 1 do
    local a, b, c, d = 3 + 2 * i, 4 + 2 * i, 3 + 2 * ((i + 1) % n), 4 + 2 * ((i + 1) % n)
    for _, t in ipairs { { a, c, d }, { a, d, b }, { 1, c, a }, { 2, b, d } } do triangles[#triangles + 1] = t end
  end
  return solid(corners, triangles)
end

local function cube() return ylm.box {} end

--- The largest distance of two arrays, over the largest number of the second.
local function apart(a, b)
  local most, size = 0, 0
  local function walk(x, y)
    if type(x) == "number" then
      most, size = math.max(most, math.abs(x - y)), math.max(size, math.abs(y))
    else
      for i = 1, #x do walk(x[i], y[i]) end
    end
  end
  walk(a:totable(), b:totable())
  return most / size
end

local function field(lmax, object, points, derivatives, dtype, threads)
  return ylm.light_field(lmax, object, points, { derivatives = derivatives or 0, channels = "luminance",
    dtype = dtype or "double", threads = threads })
end

--- Derivatives of f(points) by central differences: [n][..][3].
local function differences(f, points, h)
  local out = {}
  for axis = 1, 3 do
    local up, down = {}, {}
    for i, p in ipairs(points) do
      up[i], down[i] = { p[1], p[2], p[3] }, { p[1], p[2], p[3] }
      up[i][axis], down[i][axis] = p[axis] + h, p[axis] - h
    end
    out[axis] = (f(up) - f(down)) * (0.5 / h)
  end
  return out
end

--- Component `axis` of derivatives [..][3] of n points, as rows.
local function component(d, axis)
  local list = d:totable()
  local function walk(x)
    if type(x[1]) == "number" then return x[axis] end
    local out = {}
    for i = 1, #x do out[i] = walk(x[i]) end
    return out
  end
  return ylm.array(walk(list), "double")
end

--- The largest error of gradients against differences, over the largest of these.
local function gradient_error(f, gradients, points, h)
  local most = 0
  for axis, d in ipairs(differences(f, points, h or 1e-4)) do
    most = math.max(most, apart(component(gradients, axis), d))
  end
  return most
end

describe("ylm.occluder", function()
  it("and the light of its shape are all there is: V + L = sqrt(4 pi) in Y(0,0)", function()
    local ball, lamp = ylm.occluder { at = { 1, 2, 3 }, radius = 0.7 }, ylm.sphere_light { at = { 1, 2, 3 }, radius = 0.7 }
    local points = around(10, 0, 8)
    local V, dV, ddV = field(6, ball, points, 2)
    local L, dL, ddL = field(6, lamp, points, 2)
    local sum = (V + L):totable()
    for i = 1, #points do
      for k = 1, 49 do assert.is_near(k == 1 and ONE or 0, sum[i][1][k], 1e-14) end
    end
    assert.is_true(apart(dV, dL * -1) < 1e-14 and apart(ddV, ddL * -1) < 1e-14)
    assert.is_near(pi * 0.49, ball.area, 1e-12)
  end)

  it("sums the outline of a solid: half of its faces, in their planes and on lines of edges too, each point by itself", function()
    local corners = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1.25, 0 }, { 0, 0, 0.75 } }
    local body, faces = ylm.occluder { geometry = solid(corners, { { 1, 3, 2 }, { 1, 2, 4 }, { 2, 3, 4 }, { 3, 1, 4 } }) }, {}
    for i = 1, 4 do
      local v = {}
      for k = 1, 4 do if k ~= i then v[#v + 1] = corners[k] end end
      faces[i] = ylm.polygon_light { vertices = v, radiance = 0.5 }
    end
    local points = around(9, 1.5, 4)
    for _, p in ipairs { { -1, 0, 0 }, { 2, 0, 0 }, { 0.3, -0.5, 0 }, { 3, 3, 0 }, { 0, 0, 9 }, { 3000, 0, 1 } } do
      points[#points + 1] = p
    end
    local V, dV, ddV = field(5, body, points, 2)
    local L, dL, ddL = field(5, faces, points, 2)
    for i = 1, #points do
      local one = sh.resize({ ONE }, 5)
      assert.is_true(apart(V[i][1] + L[i][1], one) < 1e-14)
      assert.is_true(apart(dV[i], dL[i] * -1) < 1e-10 and apart(ddV[i], ddL[i] * -1) < 1e-10)
      local alone = field(5, body, { points[i] }, 2)
      assert.equal(0, apart(alone[1], V[i]))
    end
  end)

  it("is dark inside, and says so", function()
    for _, body in ipairs { ylm.occluder { radius = 1 }, ylm.occluder { geometry = cube() } } do
      local V, dV, _, report = ylm.light_field(3, body, { { 0.1, 0.2, 0 }, { 3, 0, 0 } },
        { derivatives = 1, metric = "luminance" })
      assert.same({ 1, 0 }, report.inside:totable())
      for k = 1, 16 do assert.equal(0, V:get(1, 1, k)) assert.equal(0, dV:get(1, 2, k, 1)) end
      assert.equal(0, report.lambda[1])
      assert.is_true(V:get(2, 1, 1) > 3 and report.norm[2] > 3 and report.lambda[2] > 0)
    end
  end)

  it("of solids is what rays meet: cube, tetrahedron, prism", function()
    for name, shape in pairs { cube = cube(), tetrahedron = tetrahedron(), prism = prism(12) } do
      local body = ylm.occluder { geometry = shape }
      local planes = {}
      local mesh = shape.mesh
      local p, t = mesh:vertices():totable(), mesh:triangles():totable()
      for i, tri in ipairs(t) do
        local a, b, c = p[tri[1]], p[tri[2]], p[tri[3]]
        local u, v = { b[1] - a[1], b[2] - a[2], b[3] - a[3] }, { c[1] - a[1], c[2] - a[2], c[3] - a[3] }
        local n = { u[2] * v[3] - u[3] * v[2], u[3] * v[1] - u[1] * v[3], u[1] * v[2] - u[2] * v[1] }
        planes[i] = { n[1], n[2], n[3], n[1] * a[1] + n[2] * a[2] + n[3] * a[3] }
      end
      for _, x in ipairs(around(2, 1.6, 2.5)) do
        local rays = sh.project(4, function(a, b, c)
          local from, to = 0, math.huge
          for _, n in ipairs(planes) do
            local along = n[1] * a + n[2] * b + n[3] * c
            local left = n[4] - n[1] * x[1] - n[2] * x[2] - n[3] * x[3]
            if along > 0 then to = math.min(to, left / along)
            elseif along < 0 then from = math.max(from, left / along)
            elseif left < 0 then return 1 end
          end
          return from < to and 0 or 1
        end, { samples = 6000 })
        local V = field(4, body, { x })
        local e = relative(ylm.array(V:totable()[1][1], "double"), rays)
        assert(e < 0.02, ("%s: %g, seed %g"):format(name, e, seed))
      end
    end
  end)

  it("of solids has gradients and Hessians", function()
    for _, shape in ipairs { cube(), tetrahedron(), prism(12) } do
      local body = ylm.occluder { geometry = shape }
      local points = around(4, 1.5, 3)
      local _, dV, ddV = field(5, body, points, 2)
      local e = gradient_error(function(p) return (field(5, body, p)) end, dV, points)
      assert(e < 1e-6, ("gradient %g, seed %g"):format(e, seed))
      local rows = differences(function(p) return (select(2, field(5, body, p, 1))) end, points, 1e-4)
      for k, pair in ipairs { { 1, 1 }, { 1, 2 }, { 1, 3 }, { 2, 2 }, { 2, 3 }, { 3, 3 } } do
        local d = apart(component(ddV, k), component(rows[pair[1]], pair[2]))
        assert(d < 1e-5, ("Hessian %d: %g, seed %g"):format(k, d, seed))
      end
    end
  end)

  it("of a box is that of its faces, whatever way its triangles turn, and has the surface's quarter as area", function()
    local box = cube()
    assert.is_near(1.5, ylm.occluder({ geometry = box }).area, 1e-6)
    local m = box.mesh
    local turned = {}
    for i, t in ipairs(m:triangles():totable()) do turned[i] = { t[1], t[3], t[2] } end
    local other = ylm.occluder { geometry = solid(m:vertices(), turned) }
    local points = around(3, 1, 4)
    assert.equal(0, apart(field(4, other, points), field(4, ylm.occluder { geometry = box }, points)))
  end)
end)

--- V [..] of casters as light_field has it.
local function open_part(lmax, casters, points, options)
  options = options or {}
  options.dtype = options.dtype or "double"
  return ylm.visibility(lmax, casters, points, options)
end

local ball = ylm.occluder { radius = 0.5 }
local block = ylm.occluder { geometry = cube() }
local turn = { { axis = { 1, 2, 3 }, angle = 40 }, { axis = { 0, 0, 1 }, angle = 100 } }

describe("ylm.visibility", function()
  it("of nothing is 1 everywhere", function()
    local points = { { 1, 2, 3 } }
    for _, V in ipairs { open_part(3, {}, points), open_part(3, ylm.sphere_casters { at = {}, radius = 1 }, points) } do
      for k = 1, 16 do assert.is_near(k == 1 and ONE or 0, V:get(1, k), 1e-14) end
    end
  end)

  it("of one body is that body's, where it stands: moved, turned, scaled", function()
    local points = around(12, 3, 6)
    local at = { 0.3, -0.4, 0.2 }
    local c = ylm.caster { hides = block, at = at, rotation = turn, scale = 1.7 }
    local V, dV = open_part(6, c, points, { derivatives = 1 })
    local m = ylm.sh.rotation(6, turn[1].axis and { axis = turn[1].axis, angle = math.rad(40) })
    local back, second = {}, { axis = { 0, 0, 1 }, angle = math.rad(100) }
    local function unturn(p, axis, angle)
      local l = sqrt(axis[1] ^ 2 + axis[2] ^ 2 + axis[3] ^ 2)
      local x, y, z, s, k = axis[1] / l, axis[2] / l, axis[3] / l, math.sin(-angle), math.cos(-angle)
      local d = (x * p[1] + y * p[2] + z * p[3]) * (1 - k)
      return { p[1] * k + (y * p[3] - z * p[2]) * s + x * d, p[2] * k + (z * p[1] - x * p[3]) * s + y * d,
        p[3] * k + (x * p[2] - y * p[1]) * s + z * d }
    end
    for i, p in ipairs(points) do
      local q = unturn({ p[1] - at[1], p[2] - at[2], p[3] - at[3] }, second.axis, second.angle)
      q = unturn(q, turn[1].axis, math.rad(40))
      back[i] = { q[1] / 1.7, q[2] / 1.7, q[3] / 1.7 }
    end
    local own = field(6, block, back)
    local rows = {}
    for i = 1, #points do rows[i] = own:totable()[i][1] end
    local expected = sh.rotate(sh.rotate(ylm.array(rows, "double"), m), second)
    assert.is_true(apart(V, expected) < 1e-12, "seed " .. seed)
    local e = gradient_error(function(p) return (open_part(6, c, p)) end, dV, points)
    assert(e < 1e-6, ("%g, seed %g"):format(e, seed))
  end)

  it("of casters as arrays, with quaternions, is that of casters one by one, to the bit", function()
    local half = math.rad(35)
    local q = { math.cos(half), 0, math.sin(half), 0 }
    local many = ylm.casters { hides = block, at = { { 2, 0, 0 }, { -2, 0.2, 0 } }, rotation = { q, { 2, 0, 0, 0 } },
      scale = { 1, 0.8 } }
    local one = ylm.caster { hides = block, at = { 2, 0, 0 }, rotation = { axis = { 0, 1, 0 }, angle = 70 } }
    local two = ylm.caster { hides = block, at = { -2, 0.2, 0 }, scale = 0.8 }
    local points = around(20, 0, 1)
    assert.is_true(apart(open_part(5, many, points), open_part(5, { one, two }, points)) < 1e-14)
    assert.equal(0, apart(open_part(5, { two, one }, points), open_part(5, { one, two }, points)))
  end)

  it("of bodies side by side is 1 less what each hides, to rounding", function()
    local a, b = { 2, 0, 0 }, { -2, 1, 0 }
    local points = around(10, 0, 0.3)
    local V = open_part(7, { ylm.caster { hides = ball, at = a }, ylm.caster { hides = ball, at = b } }, points)
    local A = open_part(7, ylm.caster { hides = ball, at = a }, points)
    local B = open_part(7, ylm.caster { hides = ball, at = b }, points)
    local one = {}
    for i = 1, 10 do one[i] = sh.resize({ ONE }, 7):totable() end
    assert.is_true(apart(V, A + B - ylm.array(one, "double")) < 1e-13)
  end)

  it("of a quarter turn is that of the body, turned, to rounding", function()
    local box, points, back = ylm.occluder { geometry = ylm.box { scale = { 1, 0.6, 0.8 } } }, around(6, 2, 4), {}
    for i, p in ipairs(points) do back[i] = { p[2], -p[1], p[3] } end
    local quarter = { axis = { 0, 0, 1 }, angle = 90 }
    local V = open_part(6, ylm.caster { hides = box, rotation = quarter }, points)
    local W = sh.rotate(open_part(6, ylm.caster { hides = box }, back), { axis = { 0, 0, 1 }, angle = pi / 2 })
    assert(apart(V, W) < 1e-14, "seed " .. seed)
  end)

  it("of two equal bodies is that of one, to what its degree cuts off", function()
    local points = around(6, 1.5, 4)
    for _, lmax in ipairs { 4, 9, 14 } do
      local one = open_part(lmax, ylm.caster { hides = block }, points)
      local two = open_part(lmax, { ylm.caster { hides = block }, ylm.caster { hides = block } }, points)
      local V, off = one:totable(), ((two - one) ^ 2):sum(2):sqrt():totable()
      for i = 1, 6 do
        local cut = ONE * V[i][1] -- the norm of a function that is 0 or 1, squared
        for k = 1, (lmax + 1) ^ 2 do cut = cut - V[i][k] ^ 2 end
        assert(off[i] < sqrt(cut), ("lmax %d: %g, %g, seed %g"):format(lmax, off[i], sqrt(cut), seed))
      end
    end
  end)

  it("multiplies: one rule near the exact product, exact where its degree is, whatever the order and the threads", function()
    local list, reversed = {}, {}
    for i = 1, 6 do
      local p = { math.cos(i) * 1.3, math.sin(i) * 1.3, (i - 3) * 0.15 }
      list[i] = ylm.caster { hides = i % 2 == 0 and ball or block, at = p, scale = 0.6, rotation = { axis = p, angle = 50 * i } }
    end
    for i = 1, 6 do reversed[i] = list[7 - i] end
    local points = around(40, 0, 0.2)
    for lmax, bound in pairs { [4] = 0.02, [9] = 0.004 } do
      local exact = open_part(lmax, list, points, { product = "accurate" })
      local V = open_part(lmax, list, points, { layers = false })
      assert(relative(V, exact) < bound, ("lmax %d: %g"):format(lmax, relative(V, exact)))
      assert(relative(open_part(lmax, list, points), exact) < 0.05)
      assert(relative(open_part(lmax, list, points, { product = "recursive" }), exact) < 0.05)
      assert.is_true(relative(open_part(lmax, list, points, { rule = 8, layers = false }), exact) < 1e-12)
      assert.equal(0, apart(open_part(lmax, reversed, points), open_part(lmax, list, points)))
      assert.equal(0, apart(open_part(lmax, list, points, { threads = 3 }), open_part(lmax, list, points, { threads = 1 })))
      assert.is_true(relative(open_part(lmax, list, points, { dtype = "float" }), open_part(lmax, list, points)) < 1e-5)
    end
  end)

  it("has gradients, whatever the product", function()
    local list = { ylm.caster { hides = block, at = { 1.5, 0, 0 }, rotation = turn },
      ylm.caster { hides = ball, at = { 1.6, 1, 0.2 } },
      ylm.sphere_casters { at = { { -1.5, 0, 0 }, { -1.6, 0.4, 0 } }, radius = 0.4 } }
    local points = around(8, 0, 0.3)
    for _, product in ipairs { "rule", "accurate", "recursive" } do
      local o = { product = product, cull = 0 }
      local _, dV = open_part(5, list, points, { product = product, cull = 0, derivatives = 1 })
      local e = gradient_error(function(p) return (open_part(5, list, p, o)) end, dV, points, 1e-5)
      assert(e < 1e-4, ("%s: %g, seed %g"):format(product, e, seed))
    end
  end)

  it("of spheres by exponentials is near the product, has gradients, and knows spheres alone", function()
    local list = { ylm.caster { hides = ball, at = { 0.1, 2, 0 }, rotation = turn, scale = 0.8 },
      ylm.sphere_casters { at = { { -2, 0, 0 }, { 2, 0.4, 0 } }, radius = 0.4 } }
    local points = around(6, 0, 0.2)
    local product = open_part(4, list, points, { product = "accurate", cull = 0 })
    for _, case in ipairs { { "PS", 0.02 }, { "OL", 0.03 }, { "HYB", 0.03 } } do
      local o = { product = "exp", exp = case[1], cull = 0 }
      local V, dV = open_part(4, list, points, { product = "exp", exp = case[1], cull = 0, derivatives = 1 })
      assert(relative(V, product) < case[2], ("%s: %g, seed %g"):format(case[1], relative(V, product), seed))
      local float = open_part(4, list, points, { product = "exp", exp = case[1], cull = 0, dtype = "float" })
      assert.is_true(relative(float, V) < 1e-5)
      local e = gradient_error(function(p) return (open_part(4, list, p, o)) end, dV, points, 1e-5)
      assert(e < 1e-4, ("%s: %g, seed %g"):format(case[1], e, seed))
    end
    local inside = open_part(4, list, { { -2, 0, 0 }, { -2.1, 0.1, 0.1 } }, { product = "exp", derivatives = 1 })
    for k = 1, 25 do assert.equal(0, inside:get(1, k)) assert.equal(0, inside:get(2, k)) end
    local function says(words, ...)
      local good, message = pcall(open_part, ...)
      assert.is_false(good)
      assert.is_truthy(message:find(words, 1, true), message)
    end
    local o = { product = "exp" }
    says("caster 1 is no sphere, and product 'exp' knows spheres only", 4, ylm.caster { hides = block }, points, o)
    says("lmax of logarithms must be from 0 to 20, got 21", 21, list, points, o)
    says("exp is of product 'exp', not of 'rule': leave one out", 4, list, points, { exp = "PS" })
    says("terms are of exp = 'PS': leave them out", 4, list, points, { product = "exp", terms = 5 })
    local crowd, at = {}, {}
    for i = 1, 40 do at[i] = { 0.7 * math.cos(i), 0.7 * math.sin(i), 0.3 + 0.01 * i } end
    crowd[1] = ylm.sphere_casters { at = at, radius = 0.6 }
    says("diverges near {0, 0, -0.3}, where casters look too large: exp = 'HYB' does not", 14, crowd, { { 0, 0, -0.3 } },
      { product = "exp", exp = "PS", terms = 30 })
    assert.is_true(open_part(14, crowd, { { 0, 0, -0.3 } }, o):get(1, 1) < ONE)
  end)

  it("of spheres of one body is their union: one in another hides nothing more", function()
    local points = around(10, 2, 3)
    local one = ylm.sphere_casters { at = { { 0, 0, 0 }, { 0, 0, 0 } }, radius = 0.8 }
    local two = ylm.sphere_casters { at = { { 0, 0, 0 }, { 0, 0, 0 } }, radius = { 0.8, 0.5 } }
    assert.equal(0, apart(open_part(6, two, points), open_part(6, one, points)))
    -- spheres at directions come near to spheres in closed form, as parts of a body and alone
    for rule, bounds in pairs { [3] = { 0.02, 0.018 }, [12] = { 0.003, 0.003 } } do
      local exact = open_part(6, ylm.caster { hides = ylm.occluder { radius = 0.8 } }, points)
      for k, casters in ipairs { one, ylm.sphere_casters { at = { { 0, 0, 0 } }, radius = 0.8 } } do
        local e = relative(open_part(6, casters, points, { rule = rule }), exact)
        assert(e < bounds[k], ("rule %d, case %d: %g"):format(rule, k, e))
      end
    end
  end)

  it("of spheres of any size, in any direction, poles included, is in float what it is in double", function()
    local axes = { { 0, 0, 1 }, { 0, 0, -1 }, { -1, 0, 0 }, { -1, 1e-9, 0 }, { -1, -1e-9, 0 }, { 1, 0, 0 } }
    for _, at in ipairs { around(12, 1, 1), axes } do
      local radius, body = {}, {}
      for i = 1, #at do radius[i], body[i] = 0.9 * 10 ^ (-3 * random()), 1 + i % 4 end
      local spheres = ylm.sphere_casters { at = at, radius = radius, body = body }
      for rule = 2, 6, 2 do
        local o = { rule = rule, cull = 0, derivatives = 1 }
        local V, dV = open_part(5, spheres, { { 0, 0, 0 } }, o)
        o.dtype = "float"
        local F, dF = open_part(5, spheres, { { 0, 0, 0 } }, o)
        assert(apart(F, V) < 1e-4 and apart(dF, dV) < 1e-3, ("rule %d, seed %g"):format(rule, seed))
      end
    end
  end)

  it("of spheres is that of the plain form by each instruction set", function()
    local program = [[
      local ylm = require "ylm"
      local spheres = ylm.sphere_casters { at = { { 1, 0, 0.2 }, { 1.2, 0.3, 0.1 }, { -1, 0, 0 } }, radius = { 0.4, 0.4, 0.3 },
        body = { 1, 1, 2 } }
      for _, lmax in ipairs { 1, 2, 7 } do
        local V, dV = ylm.visibility(lmax, spheres, { 0.1, 0.2, 0.3 }, { derivatives = 1, cull = 0 })
        for k = 1, (lmax + 1) ^ 2 do print(V:get(k), dV:get(k, 1), dV:get(k, 3)) end
      end
    ]]
    local want
    for _, isa in ipairs(ylm.info().kernels) do
      local got = by_kernels(isa, program)
      assert.equal(3 * 77, #got, isa)
      want = want or got
      for i = 1, #want do assert.near(want[i], got[i], 2e-4, isa .. " " .. i) end
    end
  end)

  it("of lone spheres, however small, hides as much as they do", function()
    for radius, bound in pairs { [0.02] = 0.1, [0.1] = 0.1, [0.3] = 0.05, [1] = 0.01 } do
      local places = around(60, 1.4, 1.4) -- seen from there
      local function hidden(casters) return ONE - open_part(4, casters, places, { cull = 0 })[{ {}, 1 }]:mean() end
      local e = hidden(ylm.sphere_casters { at = { { 0, 0, 0 } }, radius = radius })
        / hidden(ylm.caster { hides = ylm.occluder { radius = radius } }) - 1
      assert(math.abs(e) < bound, ("radius %g: %g, seed %g"):format(radius, e, seed))
    end
  end)
end)

--- Irradiance of an upward normal (z) by coefficients [n][1][..].
local function irradiance(L, i)
  return sh.irradiance(L:totable()[i][1], { 0, 0, 1 })
end

describe("ylm.shadowed", function()
  local sky = ylm.environment_light { radiance = 1 }

  it("has a ball over a floor in even light as a closed form has it, to 1e-3, at nodes to 8e-3", function()
    for k, casters in ipairs { ylm.caster { hides = ball, at = { 0, 0, 1.5 } },
      ylm.sphere_casters { at = { { 0, 0, 1.5 } }, radius = 0.5 } } do
      local shade = ylm.shadowed { lights = sky, casters = casters }
      local points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 2, 0 } }
      local L = field(9, shade, points)
      for i, p in ipairs(points) do
        local d2 = p[1] ^ 2 + p[2] ^ 2 + 2.25
        local e = irradiance(L, i) / pi - (1 - 0.25 / d2 * 1.5 / sqrt(d2))
        assert(math.abs(e) < (k == 1 and 1e-3 or 8e-3), ("place %d: %g"):format(i, e))
      end
    end
  end)

  it("comes nearer to that closed form with more degrees", function()
    local shade = ylm.shadowed { lights = sky, casters = ylm.caster { hides = ball, at = { 0, 0, 1.5 } } }
    for lmax, bound in pairs { [2] = 1e-2, [4] = 4e-3, [9] = 1e-3, [14] = 3e-4 } do
      local e = irradiance(field(lmax, shade, { { 0, 0, 0 } }), 1) / pi - (1 - 0.25 / 2.25)
      assert(math.abs(e) < bound, ("lmax %d: %g"):format(lmax, e))
    end
  end)

  it("without casters is the light itself, and adds up over lamps", function()
    local lamps = { ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.4, radiance = { 3, 2, 1 } },
      ylm.polygon_light { vertices = { { 2, 0, 2 }, { 3, 0, 2 }, { 3, 1, 3 } }, radiance = { 1, 2, 3 } }, sky }
    local points = around(20, 0, 1)
    local o = { derivatives = 1, dtype = "double" }
    local L, dL = ylm.light_field(5, ylm.shadowed { lights = lamps, casters = {} }, points, o)
    local M, dM = ylm.light_field(5, lamps, points, o)
    assert.equal(0, apart(L, M))
    assert.equal(0, apart(dL, dM))
    local casters = { ylm.caster { hides = ball, at = { 0, 0.4, 1.8 } },
      ylm.caster { hides = block, at = { 1.6, 0.3, 1.7 }, scale = 0.5 } }
    local all, sum = ylm.light_field(5, ylm.shadowed { lights = lamps, casters = casters }, points, o), nil
    for _, lamp in ipairs(lamps) do
      local one = ylm.light_field(5, ylm.shadowed { lights = lamp, casters = casters }, points, o)
      sum = sum and sum + one or one
    end
    assert.is_true(apart(all, sum) < 1e-12)
  end)

  it("of a lamp does not know what stands behind it, and darkens as a body comes before it", function()
    local lamp = ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.2, radiance = 10 }
    local points = around(20, 0, 0.4)
    local plain = field(6, lamp, points)
    local behind = ylm.shadowed { lights = lamp, casters = { b = ylm.caster { hides = ball, at = { 0.2, 0, 4.5 } } } }
    assert.equal(0, apart(field(6, behind, points), plain))
    behind:move { b = { at = { 3, 0, 0 } } } -- beside
    assert.equal(0, apart(field(6, behind, points), plain))
    local before
    for _, x in ipairs { 1.6, 1.2, 0.8, 0.4, 0 } do
      behind:move { b = { at = { x, 0, 1.5 } } }
      local now = irradiance(field(9, behind, { { 0, 0, 0 } }), 1)
      if before then assert(now < before + 0.03, ("%g: %g after %g"):format(x, now, before)) end
      before = now
    end
    assert(before < 0.05 * irradiance(field(9, lamp, { { 0, 0, 0 } }), 1), before)
  end)

  it("has gradients, of lamps too, and the same light whatever the batch and the threads", function()
    local shade = ylm.shadowed { cull = 0,
      lights = { sky, ylm.sphere_light { at = { 0.2, 0, 3 }, radius = 0.3, radiance = { 9, 5, 2 } } },
      casters = { ylm.caster { hides = block, at = { 0.5, 0.2, 1.5 }, rotation = turn, scale = 0.6 },
        ylm.caster { hides = ball, at = { -0.6, 0.2, 1.2 } }, ylm.sphere_casters { at = { { 0.3, 0.6, 1.2 } }, radius = 0.2 } } }
    local points = around(100, 0, 0.4)
    local L, dL = field(5, shade, points, 1)
    local e = gradient_error(function(p) return (field(5, shade, p)) end, dL, points, 1e-5)
    assert(e < 1e-4, ("%g, seed %g"):format(e, seed))
    assert.equal(0, apart(field(5, shade, points, 1, "double", 3), L))
    local turned = {}
    for i = 1, 100 do turned[i] = points[101 - i] end
    local R, same = field(5, shade, turned, 1):totable(), L:totable()
    for i = 1, 100 do assert.same(same[i], R[101 - i]) end
  end)

  it("is the same, to the bit, in any order of many points, whatever stands before their neighbours", function()
    local casters = {}
    for i = 1, 6 do
      casters[i] = ylm.caster { hides = i % 2 == 0 and ball or block, at = { 0.6 * i - 2, i % 2, 1.5 }, scale = 0.5 }
    end
    local shade = ylm.shadowed { lights = sky, casters = casters }
    local points, shuffled, at = around(320, 0, 2), {}, {}
    for i = 1, 320 do
      at[i] = (i * 131) % 320 + 1
      shuffled[i] = points[at[i]]
    end
    for _, dtype in ipairs { "float", "double" } do
      local L = ylm.light_field(9, shade, points, { dtype = dtype }):totable()
      local S = ylm.light_field(9, shade, shuffled, { dtype = dtype }):totable()
      for i = 1, 320 do assert.same(L[at[i]], S[i]) end
      local first = ylm.light_field(9, shade, { points[7] }, { dtype = dtype }):totable()
      assert.same(L[7], first[1])
    end
  end)

  it("is dark in a body, and baked like any light, to its tolerance at fresh places", function()
    local shade = ylm.shadowed { lights = { sky, ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.5, radiance = 4 } },
      casters = { ylm.caster { hides = ball, at = { 0, 0, 1 } }, ylm.caster { hides = block, at = { 1, 0, 0.8 }, scale = 0.5 } } }
    local _, _, _, report = ylm.light_field(3, shade, { { 0, 0, 1 }, { 0, 0, 0 } })
    assert.same({ 1, 0 }, report.inside:totable())
    local function floor(n)
      local list = {}
      for i = 1, n do list[i] = { 3 * random() - 1.5, 3 * random() - 1.5, 0.02 * random() } end
      return ylm.array(list, "float")
    end
    local grid = ylm.bake(ylm.adaptive_grid { lmax = 4, depth = 7, tolerance = 0.05, channels = "luminance" }, shade,
      { occupied = floor(1500) })
    assert.equal("lights", grid.quantity)
    assert.is_true(grid.stats.met)
    local places, wrong = floor(1000), 0
    local truth, sampled = field(4, shade, places, 0, "float"), grid:sample(places)
    for _, x in ipairs(sh.relative_error(sampled, truth):totable()) do
      if (type(x) == "table" and x[1] or x) > 0.05 then wrong = wrong + 1 end
    end
    assert(wrong <= 20, ("%d of 1000 places miss it, seed %g"):format(wrong, seed))
  end)

  it("keeps what it is made of while it is asked: a progress function cannot close a body", function()
    local body = ylm.occluder { radius = 1 }
    local shade = ylm.shadowed { lights = sky, casters = ylm.caster { hides = body, at = { 2, 0, 2 } } }
    local said
    assert(ylm.light_field(4, shade, ylm.zeros { 2000, 3 }, { threads = 1, progress = function()
      said = select(2, pcall(body.close, body))
    end }))
    assert.matches("in use by a call that has not returned", said)
    body:close()
  end)

  it("is kept by a list that it stands in: a progress function cannot close it", function()
    local shade = ylm.shadowed { lights = sky, casters = {} }
    local said
    assert(ylm.light_field(4, { shade, ylm.sphere_light { at = { 0, 0, 4 } } }, ylm.zeros { 2000, 3 }, { threads = 1,
      progress = function() said = select(2, pcall(shade.close, shade)) end }))
    assert.matches("in use by a call that has not returned", said)
    shade:close()
  end)

  it("tells how much there was to multiply, and says that a caster is known to fewer degrees", function()
    local box = { { -9, -9, -9 }, { 9, 9, 9 } }
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 8, lmax = 2, channels = "luminance" },
      ylm.occluder { radius = 1 })
    local shade = ylm.shadowed { lights = sky, cull = 0, casters = { soft = ylm.caster { hides = grid, at = { 0, 0, 3 } },
      ylm.caster { hides = ball, at = { 3, 0, 0 } }, ylm.caster { hides = ball, at = { 2, 0, 0 } } } }
    assert.same({ points = 0, casters = 0, products = 0, factors = 0, seconds = 0 }, shade.stats)
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message end)
    local _, _, _, report = ylm.light_field(2, shade, { { 0, 0, 0 } })
    assert.is_nil(report.warnings)
    for _ = 1, 2 do report = select(4, ylm.light_field(4, shade, { { 0, 0, 0 }, { 0, 0, 0.1 } })) end
    ylm.on_warning(before)
    assert.same(said, report.warnings)
    assert.equal(1, #said)
    assert.matches("caster 'soft' is known to lmax 2, and light of lmax 4 is .*bake its grid with lmax = 4", said[1])
    local stats = shade.stats
    assert.equal(5, stats.points)
    assert.equal(15, stats.casters) -- all three at each point
    assert.equal(5, stats.products)
    assert.equal(10, stats.factors) -- of one layer and the ball behind another
    assert.is_true(stats.seconds > 0)
  end)

  it("says so in lists of lights and behind light behind bodies too, and grids tell what their bake took", function()
    local box = { { -9, -9, -9 }, { 9, 9, 9 } }
    local grid = ylm.bake(ylm.uniform_grid { bounds = box, cells = 8, lmax = 2, channels = "luminance" },
      ylm.occluder { radius = 1 })
    local shade = ylm.shadowed { lights = sky, casters = { soft = ylm.caster { hides = grid, at = { 0, 0, 3 } } } }
    local lamp = ylm.sphere_light { at = { 0, 0, 5 }, radius = 0.1, radiance = 10 }
    local nested = ylm.shadowed { lights = { lamp, shade }, casters = { ylm.caster { hides = ball, at = { 3, 0, 0 } } } }
    local before = ylm.on_warning(false)
    for _, list in ipairs { { lamp, shade }, { { shade }, lamp }, nested, { nested, lamp } } do
      local _, _, _, report = ylm.light_field(4, list, { { 0, 0, 0 } })
      assert.equal(1, #report.warnings)
      assert.matches("caster 'soft' is known to lmax 2", report.warnings[1])
      local baked = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 }, list)
      assert.equal(27, baked.stats.shadow.points)
      assert.is_true(baked.stats.shadow.products > 26 and baked.stats.shadow.seconds > 0)
      local corner = { { -1, 0, 1 } }
      local e = relative(baked:sample(corner), ylm.light_field(1, list, corner))
      assert(e < 1e-5, e)
    end
    ylm.on_warning(before)
    assert.is_nil(grid.stats.shadow)
    local rest = shade:without()
    assert.equal(8, ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1 }, rest).stats.shadow.points)
  end)

  it("of grids has a floor: the dark is refined less, and other measures have none", function()
    local lamp = ylm.sphere_light { at = { 0, 0, 3 }, radius = 0.2 }
    local function points(floor)
      return ylm.bake(ylm.adaptive_grid { bounds = { { -2, -2, 0 }, { 2, 2, 2 } }, lmax = 2, depth = 5, tolerance = 0.01,
        floor = floor }, lamp).stats
    end
    local without, with = points(), points(0.5)
    assert.is_true(with.met and with.points < without.points / 2)
    assert.equal(without.points, points(0).points)
    for _, other in ipairs { { threshold = 0.1 }, { tolerance = 0.1, measure = "irradiance" }, { dynamic = true } } do
      other.floor = 1
      assert.matches("floor is of a tolerance of coefficients", select(2, pcall(ylm.adaptive_grid, other)))
    end
  end)

  it("takes grids of bodies, near and beyond their bounds", function()
    local grid = ylm.bake(ylm.adaptive_grid { lmax = 4, depth = 9, tolerance = 0.05, channels = "luminance" }, block)
    assert.equal("visibility", grid.quantity)
    assert.is_true(grid.stats.met)
    local at = { 0.2, 0, 0 }
    local exact = ylm.caster { hides = block, at = at, rotation = turn }
    local gridded = ylm.caster { hides = grid, at = at, rotation = turn }
    for _, r in ipairs { 1.5, 4, 15, 16.5, 40 } do
      local points = around(40, r, r)
      local e = relative(open_part(4, gridded, points), open_part(4, exact, points))
      assert(e < 0.03, ("at %g: %g"):format(r, e))
    end
    local folder = scratch.new()
    grid:save(folder.path .. "/bodies.ylm")
    local again = assert(ylm.load(folder.path .. "/bodies.ylm"))
    folder:remove()
    assert.is_near(0.75 ^ 0.5, again.body.radius, 1e-6)
    assert.is_near(1.5, again.body.area, 1e-6)
    assert.same(grid.body, again.body)
    assert.equal(ONE, again.floor)
    local loaded = ylm.caster { hides = again, at = at, rotation = turn }
    local points = around(40, 1.5, 30)
    assert.equal(0, apart(open_part(4, loaded, points), open_part(4, gridded, points)))
  end)
end)
