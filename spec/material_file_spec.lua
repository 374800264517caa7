-- Files of measured materials: MERL's and RGL's formats, by files that specs write. The tables of the latter are closed forms.

local core = require "ylm.c.core"
local files = require "spec.support.brdf_files"
local random = require "spec.support.random".spread
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

local pi = math.pi
local atan2 = math.atan2 or math.atan -- luacheck: ignore 143
local unpack_number = string.unpack -- luacheck: ignore 143

local folder
setup(function() folder = scratch.new() end)
teardown(function() folder:remove() end)

local function path(name) return folder.path .. "/" .. name end

--- n directions within an angle of the normal.
local function directions(r, n, most)
  local list, least = {}, math.cos(most)
  for i = 1, n do
    local z = least + (1 - least) * r()
    local phi, s = 2 * pi * r(), math.sqrt(1 - z * z)
    list[i] = { s * math.cos(phi), s * math.sin(phi), z }
  end
  return list
end

--- n triples of numbers from 0, below 1.
local function triples(r, n)
  local list = {}
  for i = 1, n do list[i] = { r(), r(), r() } end
  return list
end

--- The largest difference of lists of numbers or of rows, each number's over the larger of `floor` and the truth.
local function worst(truth, list, floor)
  local most = 0
  for i, t in ipairs(truth) do
    local x = list[i]
    if type(t) == "table" then most = math.max(most, worst(t, x, floor))
    else
      local off = math.abs(x - t) / math.max(floor, math.abs(t))
      most = off <= most and most or off -- NaN becomes the largest
    end
  end
  return most
end

local function times(row, x) return { row[1] * x, row[2] * x, row[3] * x } end

--- theta_h and theta_d of a pair.
local function half_angles(wi, wo)
  local h, v = {}, {}
  for a = 1, 3 do h[a], v[a] = wi[a] + wo[a], wi[a] - wo[a] end
  local length = math.sqrt(h[1] ^ 2 + h[2] ^ 2 + h[3] ^ 2)
  return math.acos(math.min(1, h[3] / length)), math.asin(math.min(1, math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2) / 2))
end

--- Directions, numbers of cells in elevation and azimuth.
local function cell_of(w, rows, columns)
  local row = math.min(rows - 1, math.floor(rows * (1 - w[3])))
  return row * columns + math.floor(columns * (atan2(w[2], w[1]) / (2 * pi) + 1)) % columns
end

--- Samples of a material towards an eye fall into cells of equal solid angle as its density says.
local function check_samples(m, wo, r)
  local n, rows, columns, fine = 5000, 6, 8, 12
  local expected, found, where = {}, {}, {}
  for i = 0, rows * columns - 1 do expected[i], found[i] = 0, 0 end
  for y = 0, rows * fine - 1 do
    local z = 1 - (y + 0.5) / (rows * fine)
    local s = math.sqrt(1 - z * z)
    for x = 0, columns * fine - 1 do
      local phi = 2 * pi * (x + 0.5) / (columns * fine)
      where[#where + 1] = { s * math.cos(phi), s * math.sin(phi), z }
    end
  end
  local density = m:pdf(where, wo):totable()
  local area, sum = 2 * pi / #where, 0
  for i, w in ipairs(where) do
    local c = cell_of(w, rows, columns)
    expected[c], sum = expected[c] + density[i] * area, sum + density[i] * area
  end
  local u = triples(r, n)
  local wi, weight, pdf = m:sample(wo, u)
  local f, p = m:eval(wi, wo):totable(), m:pdf(wi, wo):totable()
  wi, weight, pdf = wi:totable(), weight:totable(), pdf:totable()
  local absorbed = n
  local densities, weights = { {}, {} }, { {}, {} }
  for i = 1, n do
    if pdf[i] > 0 then
      local c, k = cell_of(wi[i], rows, columns), n - absorbed + 1
      absorbed, found[c] = absorbed - 1, found[c] + 1
      densities[1][k], densities[2][k] = p[i], pdf[i]
      weights[1][k], weights[2][k] = times(f[i], wi[i][3] / p[i]), weight[i]
    end
  end
  assert.near(0, worst(densities[1], densities[2], 1e-6), 1e-3)
  assert.near(0, worst(weights[1], weights[2], 1e-3), 1e-3)
  assert.near(1, sum + absorbed / n, 0.01)
  local chi2, freedom = 0, -1
  for i, share in pairs(expected) do
    if share * n > 10 then chi2, freedom = chi2 + (found[i] - share * n) ^ 2 / (share * n), freedom + 1 end
  end
  assert(freedom > 8 and chi2 < freedom + 5 * math.sqrt(2 * freedom), ("chi^2 %g of %d"):format(chi2, freedom))
end

local function refuses(says, f, ...)
  local m, message, code = f(...)
  assert.is_nil(m)
  assert.equal("EFORMAT", code)
  assert(message:find(says), message .. "\ndoes not match " .. says)
end

-- MERL ----------------------------------------------------------------------------------------

local BYTES, BINS = 34992012, 90 * 90 * 180

--- Number of a bin in its plane, counted from 0.
local function bin(theta_h, theta_d, phi_d) return phi_d + 180 * (theta_d + 90 * theta_h) end

--- The double of a bin in a file's bytes.
local function number_at(bytes, colour, i) return (unpack_number("<d", bytes, 13 + 8 * (colour * BINS + i))) end

--- The directions of a bin's centre.
local function centre(theta_h, theta_d, phi_d, phis)
  local th, td, pd = ((theta_h + 0.5) / 90) ^ 2 * pi / 2, (theta_d + 0.5) / 90 * pi / 2, (phi_d + 0.5) / 180 * pi
  assert(phi_d < (phis or 180))
  local d = files.direction(td, pd)
  local c, s = math.cos(th), math.sin(th)
  return { c * d[1] + s * d[3], d[2], c * d[3] - s * d[1] }, { s * d[3] - c * d[1], -d[2], c * d[3] + s * d[1] }
end

--- A copy of a file with numbers of bins changed: { { colour, bin, number }, .. }.
local function changed(from, to, changes)
  assert(scratch.shell("cp " .. scratch.quote(path(from)) .. " " .. scratch.quote(path(to))))
  local file = assert(io.open(path(to), "r+b"))
  for _, change in ipairs(changes) do
    file:seek("set", 12 + 8 * (change[1] * BINS + change[2]))
    file:write(string.pack("<d", change[3])) -- luacheck: ignore 143
  end
  file:close()
  return path(to)
end

describe("MERL's files", function()
  local grey, gloss, linear, nearest
  setup(function()
    assert(ylm.matte { albedo = { 0.5, 0.3, 0.1 } }:save(path "matte.binary"))
    gloss = ylm.ggx { alpha = 0.3, f0 = { 0.9, 0.5, 0.2 }, compensate = false }
    assert(gloss:save(path "ggx.binary"))
    grey = assert(ylm.load(path "matte.binary"))
    linear = ylm.merl { file = path "ggx.binary" }
    nearest = ylm.merl { file = path "ggx.binary", interpolation = "nearest" }
  end)

  it("have three extents and three planes of doubles, in units of their own", function()
    local bytes = folder:read "matte.binary"
    assert.equal(BYTES, #bytes)
    assert.same({ 90, 90, 180, 13 }, { unpack_number("<i4i4i4", bytes) })
    local scale = { [0] = 1 / 1500, 1.15 / 1500, 1.66 / 1500 }
    for c = 0, 2 do
      assert.near((0.5 - 0.2 * c) / pi, number_at(bytes, c, bin(3, 40, 90)) * scale[c], 1e-7)
      assert.equal(-1, number_at(bytes, c, bin(89, 80, 0)))
    end
  end)

  --- Places of a pair among the bins, as the data's own definition has it: d = R_y(-theta_h) R_z(-phi_h) wi.
  local function places(wi, wo)
    local h = { wi[1] + wo[1], wi[2] + wo[2], wi[3] + wo[3] }
    local length = math.sqrt(h[1] ^ 2 + h[2] ^ 2 + h[3] ^ 2)
    local theta, phi = math.acos(h[3] / length), atan2(h[2], h[1])
    local x, y = math.cos(phi) * wi[1] + math.sin(phi) * wi[2], math.cos(phi) * wi[2] - math.sin(phi) * wi[1]
    local d = { math.cos(theta) * x - math.sin(theta) * wi[3], y, math.sin(theta) * x + math.cos(theta) * wi[3] }
    return { (atan2(d[2], d[1]) % pi) * 180 / pi, math.acos(d[3]) * 180 / pi, 90 * math.sqrt(theta * 2 / pi) }
  end

  it("are looked up by half vector and difference, in the bin or between centres", function()
    local function one(x) return string.pack("<d", x) end -- luacheck: ignore 143
    local planes, row = { {}, {}, {} }, {}
    for i = 1, 180 do row[i] = one(1500 * i) end
    for i = 1, 90 do planes[2][i], planes[3][i] = one(1500 / 1.15 * i):rep(180), one(1500 / 1.66 * i):rep(16200) end
    planes[1] = table.concat(row):rep(8100)
    planes[2], planes[3] = table.concat(planes[2]):rep(90), table.concat(planes[3])
    local file = folder:write("places.binary", folder:read "matte.binary":sub(1, 12) .. table.concat(planes))
    local r, near, between, truth = random(17), {}, {}, {}
    local wi, wo = directions(r, 2000, 1.5), directions(r, 2000, 1.5)
    local bins = ylm.merl { file = file, interpolation = "nearest" }:eval(wi, wo):totable()
    local centres = ylm.merl { file = file }:eval(wi, wo):totable()
    for i = 1, 2000 do
      local at = places(wi[i], wo[i])
      local inside = at[1] > 0.5 and at[1] < 179.5
      for c = 1, 3 do
        local edge = math.abs(at[c] - math.floor(at[c] + 0.5))
        if edge > 1e-4 then near[#near + 1] = bins[i][c] - 1 - math.floor(at[c]) end
        if at[c] > 0.5 and inside then truth[#truth + 1], between[#between + 1] = at[c] + 0.5, centres[i][c] end
      end
    end
    assert(#near > 5900 and #truth > 5900)
    for i, x in ipairs(near) do if math.abs(x) > 1e-3 then error("off by a bin: " .. i .. " " .. x) end end
    assert.near(0, worst(truth, between, 1), 1e-4)
  end)

  it("give a matte surface back, wherever both directions are above it", function()
    local r = random(11)
    local wi, wo = directions(r, 4000, 1.5), directions(r, 4000, 1.5)
    local truth = {}
    for i = 1, 4000 do truth[i] = { 0.5 / pi, 0.3 / pi, 0.1 / pi } end
    assert.near(0, worst(truth, grey:eval(wi, wo):totable(), 0), 1e-6)
    assert.same({ 0, 0, 0 }, grey:eval({ 0, 0.6, -0.8 }, { 0, 0, 1 }):totable())
    assert.near(0.5, grey:albedo { 0.7 }:get(1, 1), 1e-3)
  end)

  it("are the same numbers when they are read and saved again, to 1e-6", function()
    assert(linear:save(path "again.binary"))
    local first, second = folder:read "ggx.binary", folder:read "again.binary"
    assert.equal(#first, #second)
    local a, b = {}, {}
    for i = 0, 3 * BINS - 1, 97 do a[#a + 1], b[#b + 1] = number_at(first, 0, i), number_at(second, 0, i) end
    assert.near(0, worst(a, b, 1e-9), 1e-6)
    for _, d in ipairs { { 0, 0, 0 }, { 30, 20, 77 }, { 45, 30, 179 } } do
      local wi, wo = centre(d[1], d[2], d[3])
      local truth = number_at(first, 0, bin(d[1], d[2], d[3])) / 1500
      assert.near(truth, nearest:eval(wi, wo):get(1), 1e-6 * truth)
      assert.near(truth, linear:eval(wi, wo):get(1), 1e-3 * truth)
    end
  end)

  it("hold GGX to 2 % by linear interpolation, which is better than the nearest bin", function()
    local r, wi, wo = random(5), {}, {}
    for _, pair in ipairs(triples(r, 6000)) do
      local one, other = directions(r, 1, 1.3)[1], directions(r, 1, 1.3)[1]
      local theta_h, theta_d = half_angles(one, other)
      if pair[1] > 0.3 and theta_h < pi / 3 and theta_d < 75 * pi / 180 then wi[#wi + 1], wo[#wo + 1] = one, other end
    end
    assert(#wi > 2000)
    local truth, a, b = gloss:eval(wi, wo):totable(), linear:eval(wi, wo):totable(), nearest:eval(wi, wo):totable()
    local errors, largest = { 0, 0 }, 0
    for i, f in ipairs(truth) do
      largest = math.max(largest, math.abs(a[i][1] - f[1]) / f[1])
      errors[1], errors[2] = errors[1] + (a[i][1] - f[1]) ^ 2, errors[2] + (b[i][1] - f[1]) ^ 2
    end
    assert(largest < 0.02, largest)
    assert(errors[1] < errors[2] / 25, errors[1] / errors[2])
  end)

  it("are reciprocal, and do not change with a turn about the normal", function()
    local r = random(8)
    local wi, wo = directions(r, 500, 1.5), directions(r, 500, 1.5)
    local turned = { {}, {} }
    for i = 1, 500 do
      for k, w in ipairs { wi[i], wo[i] } do turned[k][i] = { 0.6 * w[1] - 0.8 * w[2], 0.8 * w[1] + 0.6 * w[2], w[3] } end
    end
    local f, g, h = linear:eval(wi, wo):totable(), linear:eval(wo, wi):totable(), linear:eval(turned[1], turned[2]):totable()
    assert.near(0, worst(f, g, 1e-6), 1e-4)
    assert.near(0, worst(f, h, 1e-6), 1e-3)
  end)

  it("are sampled as their density says", function()
    local r = random(3)
    for _, wo in ipairs { { 0, 0, 1 }, { -0.3, 0.9, 0.3162 } } do check_samples(linear, wo, r) end
  end)

  it("stand in for a bin that is not measured: the next below in theta_d, or the others around a place", function()
    local changes = {}
    for c = 0, 2 do changes[c + 1] = { c, bin(20, 31, 50), -1 } end
    changes[4] = { 0, bin(20, 30, 50), 1500 }
    for p = 0, 179 do changes[#changes + 1] = { 1, bin(70, 0, p), -1 } end
    local file = changed("matte.binary", "holes.binary", changes)
    local wi, wo = centre(20, 31, 50)
    assert.near(1, ylm.merl { file = file, interpolation = "nearest" }:eval(wi, wo):get(1), 1e-6)
    local holed = ylm.merl { file = file }
    wi, wo = centre(20, 31, 50.5)
    assert.near(0.5 / pi, holed:eval(wi, wo):get(1), 1e-3)
    wi, wo = centre(70.4, 0, 10)
    assert.near(0.5 / pi, holed:eval(wi, wo):get(1), 1e-3)
    assert.near(0, ylm.merl { file = file, interpolation = "nearest" }:eval(wi, wo):get(1), 1e-6)
    assert(holed:check().negative > grey:check().negative)
  end)

  it("may have 360 bins in phi_d, and are then not reciprocal", function()
    local file = assert(io.open(path "around.binary", "wb"))
    file:write(string.pack("<i4i4i4", 90, 90, 360)) -- luacheck: ignore 143
    for c = 0, 2 do
      file:seek("set", 12 + 8 * (c * 2 * BINS + 200 + 360 * (40 + 90 * 10)))
      file:write(string.pack("<d", 1500)) -- luacheck: ignore 143
    end
    file:seek("set", 11 + 48 * BINS)
    file:write "\0"
    file:close()
    local wi, wo = centre(10, 40, 200, 360)
    local m = ylm.merl { file = path "around.binary", interpolation = "nearest" }
    assert.near(1.66, m:eval(wi, wo):get(3), 1e-6)
    assert.equal(0, m:eval(wo, wi):get(3))
    assert.near(1, ylm.merl { file = path "around.binary" }:eval(wi, wo):get(1), 1e-3)
    os.remove(path "around.binary")
  end)

  it("are refused by what is wrong with them", function()
    local function merl(bytes) return ylm.merl { file = folder:write("bad.binary", bytes) } end
    local pack = string.pack -- luacheck: ignore 143
    refuses("the file ends within its header", merl, "")
    refuses("the file ends within its header", merl, "Z\0\0\0Z\0\0\0\180\0\0")
    refuses("its numbers are big%-endian", merl, pack(">i4i4i4", 90, 90, 180))
    refuses("90 x 90 x 181 bins .* 90 x 90 x 180 or 360 expected", merl, pack("<i4i4i4", 90, 90, 181))
    refuses("90 x %-90 x 180 bins", merl, pack("<i4i4i4", 90, -90, 180))
    refuses("36 bytes, but 90 x 90 x 180 bins take 34992012", merl, pack("<i4i4i4", 90, 90, 180) .. ("x"):rep(24))
    local function one(colour, i, x)
      return function() return ylm.merl { file = changed("matte.binary", "bad.binary", { { colour, i, x } }) } end
    end
    refuses("the green number at theta_h 4, theta_d 3, phi_d 2 is %-?nan", one(1, bin(3, 2, 1), 0 / 0))
    refuses("the blue number at theta_h 90, theta_d 90, phi_d 180 is %-inf", one(2, BINS - 1, -math.huge))
    local file = assert(io.open(path "bad.binary", "wb"))
    file:write(pack("<i4i4i4", 90, 90, 180), (pack("<d", -1):rep(3 * BINS)))
    file:close()
    refuses("nothing is measured: every bin has a negative number", ylm.load, path "bad.binary")
  end)
end)

-- RGL -----------------------------------------------------------------------------------------

local function rgl(fields, damage)
  return ylm.rgl { file = folder:write("a.bsdf", files.tensor(fields, damage)) }
end

describe("RGL's files", function()
  it("of constant tables are closed forms: f cos = colour / 4, and the density", function()
    local m = assert(rgl(files.constant_fields { 0.5, 0.4, 0.3 }))
    local r = random(2)
    local wi, wo = directions(r, 500, 1.5), directions(r, 500, 1.5)
    local f, p = m:eval(wi, wo):totable(), m:pdf(wi, wo):totable()
    local truth, density = {}, {}
    for i = 1, 500 do
      local theta_h, theta_d = half_angles(wi[i], wo[i])
      truth[i] = times({ 0.5 / 4, 0.4 / 4, 0.3 / 4 }, 1 / wi[i][3])
      density[i] = 1 / (4 * math.cos(theta_d) * 2 * pi ^ 2 * math.sqrt(theta_h * 2 / pi) * math.sin(theta_h))
    end
    assert.near(0, worst(truth, f, 0), 1e-6)
    assert.near(0, worst(density, p, 0), 2e-5)
    assert.same({ 0, 0, 0 }, m:eval({ 0, 0.6, -0.8 }, { 0, 0, 1 }):totable())
    assert.same({ 0, 0, 0 }, m:eval({ 0, 0, 1 }, { 0, 0.6, -0.8 }):totable())
  end)

  it("hold the value alone where jacobian is 0", function()
    local fields = files.constant_fields { 0.5, 0.4, 0.3 }
    fields[9][4] = "\0"
    assert.near(0.5, rgl(fields):eval({ 0.6, 0, 0.8 }, { 0, 0, 1 }):get(1) * 0.8, 1e-6)
  end)

  it("give GGX back: to 2 % where the eye is at a node, to 5 % between", function()
    local m = assert(rgl(files.ggx_fields { alpha = 0.3, f0 = 0.9, thetas = 16, phis = 1, size = 64, fine = 32 }))
    local r, errors = random(4), { 0, 0 }
    for i = 1, 10 do
      local between = i % 2
      local wo = files.direction((i - 1 + between / 2) / 15 * 0.49 * pi, 0.3 * i)
      local wi = directions(r, 200, 1.2)
      local truth = {}
      for k, w in ipairs(wi) do truth[k] = times({ 1, 1, 1 }, files.ggx.f({ 0.3, 0.3 }, 0.9, w, wo)) end
      errors[1 + between] = math.max(errors[1 + between], worst(truth, m:eval(wi, wo):totable(), 0))
    end
    assert(errors[1] < 0.02 and errors[2] < 0.05, table.concat(errors, " "))
    for _, wo in ipairs { { 0, 0, 1 }, { -0.3, 0.9, 0.3162 } } do check_samples(m, wo, r) end
  end)

  it("are warped forth by samples and back by lookups: places agree to 1e-5", function()
    local fields = files.constant_fields({ 1, 1, 1 }, 5, 3)
    local r, rgb, vndf = random(6), fields[8][4], fields[6][4]
    for i = 1, #vndf do vndf[i], fields[7][4][i] = 0.5 + r(), 0.2 + r() end
    for t = 0, 2 do
      for k = 0, 24 do rgb[t * 75 + k + 1], rgb[t * 75 + 25 + k + 1] = 1 + k % 5 / 4, 1 + math.floor(k / 5) / 4 end
    end
    local m = assert(rgl(fields))
    local wo, forth, back = directions(r, 2000, 1.4), {}, {}
    local wi, weight, pdf = m:sample(wo, triples(r, 2000))
    local f, w, z = m:eval(wi, wo):totable(), weight:totable(), wi:totable()
    for i, p in ipairs(pdf:totable()) do
      if p > 0 and half_angles(z[i], wo[i]) > 0.02 then
        forth[#forth + 1], back[#back + 1] = times(w[i], 1 / w[i][3]), times(f[i], 1 / f[i][3])
      end
    end
    assert(#forth > 800, #forth)
    assert.near(0, worst(forth, back, 1), 1e-5)
  end)

  it("may be anisotropic, measured around, half or a quarter around, and turned", function()
    local form = { alpha = { 0.3, 0.6 }, f0 = 0.9, thetas = 8, phis = 17, size = 24, fine = 12 }
    local around = assert(rgl(files.ggx_fields(form)))
    local swapped = { rgl = ylm.rgl { file = path "a.bsdf", rotate = 90 }, alpha = { 0.6, 0.3 } }
    assert.equal(false, core.material_isotropic(require "ylm.material.object".made("spec", around)))
    form.phis, form.first, form.last = 9, 0, pi
    local half = assert(rgl(files.ggx_fields(form)))
    form.phis, form.first, form.last = 5, -pi, -pi / 2
    local quarter = assert(rgl(files.ggx_fields(form)))
    local r = random(9)
    local wi, wo = directions(r, 300, 0.9), directions(r, 300, 0.9)
    for _, case in ipairs { { rgl = around, alpha = form.alpha }, { rgl = half, alpha = form.alpha },
      { rgl = quarter, alpha = form.alpha }, swapped } do
      local sum = 0
      for i, f in ipairs(case.rgl:eval(wi, wo):totable()) do
        local truth = files.ggx.f(case.alpha, 0.9, wi[i], wo[i])
        sum = sum + math.abs(f[1] - truth) / truth
      end
      assert(sum / 300 < 0.02, sum / 300)
      check_samples(case.rgl, { 0.5, -0.3, 0.8124 }, r)
    end
  end)

  it("are refused by the field that is wrong, and when cut anywhere", function()
    --- Fields of constant tables, changed; refused with these words.
    local function refused(says, change, damage)
      local fields = files.constant_fields({ 0.5, 0.4, 0.3 }, 3)
      local by_name = {}
      for i, field in ipairs(fields) do by_name[field[1]], by_name[i] = field, field end
      if change then fields = change(by_name, fields) or fields end
      refuses(says, rgl, fields, damage)
    end
    local whole = files.tensor(files.constant_fields({ 0.5, 0.4, 0.3 }, 3))
    local function bytes(text) return ylm.rgl { file = folder:write("b.bsdf", text) } end
    refuses("does not begin with 'tensor_file'", bytes, "tensor_fil\0\0" .. whole:sub(13))
    for n = 0, #whole - 8, 23 do
      local m, message = bytes(whole:sub(1, n))
      assert(m == nil and message:find "b.bsdf: ", message)
    end
    local old = { bytes(whole:sub(1, 12) .. "\2\0" .. whole:sub(15)) }
    assert.same({ "EVERSION", "version 2.0, only 1.0 is known" }, { old[3], old[2]:match "version .*" })
    for i, name in ipairs { "phi_i", "theta_i", "ndf", "sigma", "vndf", "luminance", "rgb", "jacobian" } do
      refused("field '" .. name .. "' is missing", function(by_name) by_name[name][1] = "other" end)
      refused("field '" .. name .. "' lies outside of the file", nil,
        function(field) if field[1] == name then return 1e6 end end)
      refused("field '" .. name .. "' lies within the header", nil,
        function(field) if field[1] == name then return 20 end end)
      refused("field '" .. name .. "' lies outside of the file", nil, function(field)
        if field[1] ~= name then return end
        local shape = {}
        for a = 1, #field[3] do shape[a] = 2 ^ 40 end
        return 1000, shape
      end)
      if i < 8 then
        refused("field '" .. name .. "' has elements of type f64, f32 expected", function(by_name)
          by_name[name][2], by_name[name][4] = "f64", by_name[name][4] and ("\0"):rep(1600)
        end)
        refused("field '" .. name .. "' has [12] axes, [1245] expected", function(by_name)
          by_name[name][3] = #by_name[name][3] == 1 and { 1, 1 } or { #by_name[name][4] }
        end)
        refused("number 1 of field '" .. name .. "' is not finite", function(by_name) by_name[name][4][1] = 0 / 0 end)
      end
    end
    refused("field 'ndf' has elements of type 99, which is not known", function(by_name) by_name.ndf[2] = 99 end)
    refused("field 'ndf' has 9 axes, at most 8", function(by_name) by_name.ndf[3] = { 1, 1, 1, 1, 1, 1, 1, 1, 9 } end)
    refused("name has characters that are no ASCII text", function(by_name) by_name.ndf[1] = "n\27f" end)
    refused("field 'theta_i' must increase, but number 2 is 0 after 0", function(by_name) by_name.theta_i[4][2] = 0 end)
    refused("field 'phi_i' goes from 0 to 2", function(by_name, fields)
      by_name.phi_i[3], by_name.phi_i[4] = { 3 }, { 0, 1, 2 }
      for _, name in ipairs { "vndf", "luminance", "rgb" } do
        local numbers = by_name[name][4]
        by_name[name][3][1] = 3
        for i = 1, 2 * #numbers do numbers[#numbers + 1] = numbers[i] end
      end
      return fields
    end)
    refused("field 'vndf' must have extents %[phi_i%]%[theta_i%]", function(by_name) by_name.vndf[3] = { 2, 1, 3, 3 } end)
    refused("field 'rgb' must have the extents of luminance", function(by_name) by_name.rgb[3] = { 1, 2, 9, 3, 1 } end)
    refused("field 'vndf' has no positive density at phi_i 1, theta_i 2", function(by_name)
      for i = 10, 18 do by_name.vndf[4][i] = i % 2 - 1 end
    end)
    refused("number 4 of field 'ndf' is 1e%+30", function(by_name) by_name.ndf[4][4] = 1e30 end)
    refused("use the _rgb.bsdf, this one has wavelengths", function(by_name)
      by_name.rgb[1], by_name.description[1] = "spectra", "wavelengths"
    end)
  end)
end)

-- Functions, the sandbox, the tool ---------------------------------------------------------------

describe("a tabulated material", function()
  it("is what its function says", function()
    local function f(theta_i, theta_o, dphi)
      local x = theta_i * theta_o
      return 0.15 - 0.05 * x, 0.1 + 0.02 * x * math.cos(dphi), 0.1 * x
    end
    local m = ylm.tabulated { f = f }
    local r = random(7)
    local wi, wo = directions(r, 500, 1.2), directions(r, 500, 1.2)
    local truth = {}
    for i, a in ipairs(wi) do
      local b = wo[i]
      local dphi = atan2(b[1] * a[2] - b[2] * a[1], a[1] * b[1] + a[2] * b[2])
      truth[i] = { f(math.acos(a[3]), math.acos(b[3]), dphi) }
    end
    assert.near(0, worst(truth, m:eval(wi, wo):totable(), 1), 2e-3)
    local energy = m:check().energy
    assert(energy > 0.3 and energy < 0.7, energy)
  end)
end)

describe("materials of files in scene files", function()
  local function try(text, limits) return ylm.load(folder:write("scene.lua", text), limits) end

  local function scene(material)
    return "return scene 'x' { geometry = sphere { material = " .. material .. " } }"
  end

  it("are found beside the scene, and nowhere else", function()
    folder:write("const.bsdf", files.tensor(files.constant_fields { 0.5, 0.4, 0.3 }))
    local s = assert(try(scene "rgl { file = 'const.bsdf' }"))
    assert.near(0.7854, s.geometry[1].material:albedo { 1 }:get(1, 1), 0.01)
    for _, name in ipairs { "../const.bsdf", "/etc/passwd", "none.bsdf" } do
      local none, message = try(scene("rgl { file = '" .. name .. "' }"))
      assert(none == nil and message:find "scene.lua:1: rgl: file: ", message)
    end
  end)

  it("are bounded, each and together; functions are none of them", function()
    local bytes = #folder:read "const.bsdf"
    local function refused(says, code, text, limits)
      local none, message, got = try(text, limits)
      assert(none == nil and message:find(says), message)
      assert.equal(code, got)
    end
    refused("const.bsdf has more than", "ELIMIT", scene "rgl { file = 'const.bsdf' }", { file_size = bytes - 1 })
    local two = "local m = rgl { file = 'const.bsdf' }\n" .. scene "rgl { file = 'const.bsdf' }"
    assert(try(two, { material_bytes = 2 * bytes }))
    refused("scene.lua:2: rgl: more than %d+ material_bytes", "ELIMIT", two, { material_bytes = 2 * bytes - 1 })
    refused("there is no 'tabulated' in a scene file", "EFORMAT", scene "tabulated { f = function() return 1 end }")
    refused("short.bsdf: the file ends within its header", "EFORMAT", scene "merl { file = 'short.bsdf' }",
      folder:write("short.bsdf", "Z") and {})
  end)
end)

describe("ylm material", function()
  it("prints what a file holds and checks it", function()
    local run = tool.runner(folder)
    local out, code = run("material " .. scratch.quote(path "const.bsdf"))
    assert.equal(0, code)
    for _, words in ipairs { "kind +rgl", "isotropic +true", "theta_i +2", "energy +[01]%.", "reciprocity +%d" } do
      assert(out:find(words), out)
    end
    local same
    same, code = run("info " .. scratch.quote(path "const.bsdf"))
    assert.equal(0, code)
    assert.equal(out, same)
    local err = select(3, run("material " .. scratch.quote(folder:write("x.ply", "ply\n"))))
    assert(err:find "x.ply: not a material", err)
  end)
end)
