-- Texture coordinates for meshes without: what they cover, what stays, and hostile meshes.
-- `make check-long` unwraps 100,000 random meshes.

local ylm = require "ylm"
local charts_of = require "spec.support.charts"
local long = require "spec.support.long"

--- A grid of quads over the unit square: at(s, t) places its vertices.
local function sheet(nu, nv, at)
  local vertices, triangles = {}, {}
  for i = 0, nu do for j = 0, nv do vertices[#vertices + 1] = at(i / nu, j / nv) end end
  for i = 0, nu - 1 do
    for j = 0, nv - 1 do
      local a = i * (nv + 1) + j + 1
      triangles[#triangles + 1] = { a, a + nv + 1, a + nv + 2 }
      triangles[#triangles + 1] = { a, a + nv + 2, a + 1 }
    end
  end
  return vertices, triangles
end

local function mesh(vertices, triangles) return ylm.mesh({ vertices = vertices, triangles = triangles }).mesh end

local function good(flat, report)
  local wrong = charts_of(flat, report)
  assert(not wrong, wrong)
end

describe("mesh:unwrap", function()
  it("lays a box out as its six sides, whole, with all of the picture used but gutters", function()
    local flat, report = ylm.box { bounds = { { 0, 0, 0 }, { 3, 2, 1 } }, divide = 3 }.mesh:unwrap { texels = 100 * 100 }
    assert.same({ 6, 0, 0 }, { report.charts, report.curved, report.crowded })
    assert.is_true(math.abs(report.stretch - 1) < 1e-12 and report.share > 0.8, report.share)
    assert.is_true(report.width * report.height <= 100 * 100)
    good(flat, report)
  end)

  it("keeps triangles, places, normals, colours and first coordinates, and names the old vertices", function()
    local before = ylm.torus { radius = 1, tube = 0.4, divide = { 24, 12 } }.mesh
    local flat = before:unwrap()
    assert.equal(#before, #flat.mesh)
    local old, new = before:triangles():totable(), flat.mesh:triangles():totable()
    local vertices = flat.vertices:totable()
    for i = 1, #old do for k = 1, 3 do assert.equal(old[i][k], vertices[new[i][k]]) end end
    for _, what in ipairs { "vertices", "normals", "uvs" } do
      local a, b = before[what](before):totable(), flat.mesh[what](flat.mesh):totable()
      for i, from in ipairs(vertices) do assert.same(a[from], b[i]) end
    end
    local red = ylm.mesh({ vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } },
      colours = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } }).mesh:unwrap().mesh:colours()
    assert.same({ 1, 0, 0 }, red:totable()[1])
  end)

  it("stretches what can be unrolled by less than a thousandth", function()
    local flat, report = mesh(sheet(48, 4, function(s, t)
      return { math.cos(2.4 * s), math.sin(2.4 * s), t }
    end)):unwrap { angle = 80 }
    assert.same({ 1, 1 }, { report.charts, report.curved })
    assert.is_true(report.stretch < 1.001, report.stretch)
    good(flat, report)
  end)

  it("flattens a sphere with a stretch below 1.05, and uses 0.6 of the picture", function()
    local flat, report = ylm.sphere { divide = { 16, 8 } }.mesh:unwrap()
    assert.is_true(report.stretch < 1.05 and report.worst < 1.05 and report.share > 0.6 and report.charts < 20, tostring(report))
    good(flat, report)
  end)

  it("cuts a ramp that winds over itself where it would overlap", function()
    local flat, report = mesh(sheet(48, 1, function(s, t)
      local a, r = 6 * math.pi * s, 1 + t
      return { r * math.cos(a), r * math.sin(a), 0.3 * s }
    end)):unwrap()
    assert.is_true(report.charts >= 3 and report.charts <= 12, report.charts)
    good(flat, report)
  end)

  it("keeps gutters, and the density that is asked for to the texel", function()
    local box = ylm.box { bounds = { { 0, 0, 0 }, { 4, 2, 1 } } }.mesh
    local flat, report = box:unwrap { density = 8, gutter = 3 }
    assert.is_true(math.abs(report.density - 8) < 1e-9)
    local owner, uvs, triangles = {}, flat.uvs:totable(), flat.mesh:triangles():totable()
    for i, t in ipairs(triangles) do
      local low, high = { math.huge, math.huge }, { -math.huge, -math.huge }
      for k = 1, 3 do
        local at = { uvs[t[k]][1] * report.width, uvs[t[k]][2] * report.height }
        for a = 1, 2 do low[a], high[a] = math.min(low[a], at[a]), math.max(high[a], at[a]) end
      end
      owner[i] = { low, high, flat.charts:get(i) }
    end
    for i, a in ipairs(owner) do
      for j = i + 1, #owner do
        local b, apart = owner[j], 0
        for axis = 1, 2 do apart = math.max(apart, a[1][axis] - b[2][axis], b[1][axis] - a[2][axis]) end
        assert.is_true(a[3] == b[3] or apart > 3.99, apart) -- middles of the last texels are gutter + 1 apart
      end
    end
  end)

  it("gives the same bits for any number of threads, and again", function()
    local knot = ylm.knot { divide = { 48, 8 } }.mesh
    local one = knot:unwrap { threads = 1 }
    for _, threads in ipairs { 1, 2, 5 } do assert.equal(one.uvs:bytes(), knot:unwrap({ threads = threads }).uvs:bytes()) end
  end)

  it("names edges of three triangles, doubles and triangles without area, and ends charts there", function()
    local v = { { 0, 0, 0 }, { 1, 0, 0 }, { 0.5, 1, 0 }, { 0.5, -1, 0 }, { 0.5, 0, 1 }, { 2, 0, 0 } }
    local flat, report = mesh(v, { { 1, 2, 3 }, { 2, 1, 4 }, { 1, 2, 5 }, { 1, 2, 3 }, { 1, 2, 6 }, { 3, 3, 4 } }):unwrap()
    assert.same({ 4, 2 }, { report.charts, report.degenerate })
    assert.is_true(report.crowded >= 1)
    assert.same({ 0, 0 }, { flat.charts:get(5), flat.charts:get(6) })
    good(flat, report)
  end)

  it("stops where its progress function returns false", function()
    local flat, message, code = ylm.sphere({}).mesh:unwrap { progress = function() return false end }
    assert.same({ nil, "ECANCELLED" }, { flat, code })
    assert.is_string(message)
  end)
end)

describe("mesh:unwrap of hostile meshes", function()
  local random = require "spec.support.random"
  --- Kinds of meshes, each from a function random() of 0 .. 1: vertices and triangles.
  local kinds = {
    soup = function(r)
      local v, t = {}, {}
      for i = 1, 3 + math.floor(36 * r()) do v[i] = { r(), r(), r() } end
      local function any() return 1 + math.floor(#v * r()) end
      for i = 1, 1 + math.floor(24 * r()) do t[i] = { any(), any(), any() } end
      return v, t
    end,
    noise = function(r)
      local rough = 3 * r() ^ 3
      return sheet(1 + math.floor(4 * r()), 1 + math.floor(4 * r()), function(s, t) return { s, t, rough * r() } end)
    end,
    ramp = function(r)
      local turns, inner, rise = 20 * r(), r() - 0.1, 0.3 * r()
      return sheet(4 + math.floor(14 * r()), 1, function(s, t)
        local a = turns * s
        return { (inner + t) * math.cos(a), (inner + t) * math.sin(a), rise * s }
      end)
    end,
    strip = function(r) -- with half turns
      local halves = math.floor(4 * r())
      return sheet(10, 1, function(s, t)
        local a, b = 2 * math.pi * s, halves * math.pi * s
        local x = 1 + (t - 0.5) * math.cos(b)
        return { x * math.cos(a), x * math.sin(a), (t - 0.5) * math.sin(b) }
      end)
    end,
    fan = function(r)
      local v, t, n, turns = { { 0, 0, 3 * r() } }, {}, 3 + math.floor(12 * r()), 1 + math.floor(3 * r())
      for i = 1, n do
        local a = 2 * math.pi * turns * i / n
        v[i + 1] = { math.cos(a), math.sin(a), 0.2 * r() }
      end
      for i = 1, n do t[i] = { 1, i + 1, i % n + 2 } end
      return v, t
    end,
    lattice = function(r) -- few places: doubles, points and lines
      local v, t = {}, {}
      for i = 1, 12 do v[i] = { math.floor(3 * r()), math.floor(3 * r()), math.floor(2 * r()) } end
      for i = 1, 16 do t[i] = { 1 + math.floor(12 * r()), 1 + math.floor(12 * r()), 1 + math.floor(12 * r()) } end
      return v, t
    end,
    sliver = function(r)
      local thin = 10 ^ (-7 * r())
      return sheet(6, 3, function(s, t) return { s, thin * t, thin * r() } end)
    end,
  }
  local names = {}
  for name in pairs(kinds) do names[#names + 1] = name end
  table.sort(names)
  local scales = { 1, 1e-15, 1e12 }

  it("makes charts that overlap nowhere, or says why not", function()
    local made, refused = 0, 0
    for i = 1, long(90, 100000) do
      local r = random.minimal(7919 * i + 1)
      local name, by = names[i % #names + 1], scales[i % 11 == 0 and 2 or i % 13 == 0 and 3 or 1]
      local v, t = kinds[name](r)
      for _, p in ipairs(v) do for a = 1, 3 do p[a] = p[a] * by end end
      local texels = 16 + math.floor(4000 * r())
      local ok, flat, report, code = pcall(function() return mesh(v, t):unwrap { texels = texels, gutter = i % 3,
        angle = 20 + 60 * r(), stretch = 1.01 + r() } end)
      if ok and flat then
        local wrong = charts_of(flat, report)
        assert(not wrong, ("mesh %d, %s: %s"):format(i, name, wrong or ""))
        made = made + 1
      else
        local said = tostring(ok and report or flat)
        assert(said:find "do not fit into" and code == "ELIMIT" or said:find "has an area",
          ("mesh %d, %s: %s"):format(i, name, said))
        refused = refused + 1
      end
    end
    assert.is_true(made > 4 * refused, ("%d made, %d refused"):format(made, refused))
  end)
end)
