-- ylm.photometry: tables between their nodes, their flux, curves, and what is refused. Files: photometry_file_spec.

local refused = require "spec.support.raises"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

--- A smooth lamp that is tilted and different in every plane, of a direction of length 1.
local function smooth(x, y, z) return 100 * math.exp(2 * (0.3 * x + 0.5 * z)) + 20 * (x * x - y * y) + 10 * x * y * z + 60 end

local function of_angles(g, c) return smooth(math.sin(g) * math.cos(c), math.sin(g) * math.sin(c), math.cos(g)) end

--- Its table at these steps in degrees.
local function sampled(step, around, interpolation)
  local v, h, cd = {}, {}, {}
  for g = 0, 180, step do v[#v + 1] = g end
  for c = 0, 360 - around, around do
    local row = {}
    for i, g in ipairs(v) do row[i] = of_angles(math.rad(g), math.rad(c)) end
    h[#h + 1], cd[#cd + 1] = c, row
  end
  return ylm.photometry { vertical = v, horizontal = h, candela = cd, interpolation = interpolation }
end

--- n directions, a quarter of them near the poles.
local function directions(n)
  local list = {}
  for i = 1, n do
    local z, c = 1 - 2 * ((i * 0.6180339887498949) % 1), 2.399963 * i * i
    if i % 4 == 0 then z = (i % 8 == 0 and 1 or -1) * math.cos(0.12 * ((i * 0.7548776662) % 1)) end
    local r = math.sqrt(math.max(0, 1 - z * z))
    list[i] = { r * math.cos(c), r * math.sin(c), z }
  end
  return list
end

describe("photometry", function()
  it("has the flux of a power of the cosine, which is 2 pi/(n+1) of its peak", function()
    for _, case in ipairs { { 1, 5, 1e-6 }, { 2, 5, 1e-6 }, { 4, 5, 4e-6 }, { 32, 5, 2e-4 }, { 8, 2.5, 1e-6 },
      { 64, 1, 1e-6 } } do
      local n, step, v, row = case[1], case[2], {}, {}
      for i = 0, 90 / step do v[i + 1], row[i + 1] = step * i, math.cos(math.rad(step * i)) ^ n end
      row[#row] = 0
      local p = ylm.photometry { vertical = v, horizontal = { 0 }, candela = { row } }
      assert.is_true(math.abs(p.lumens * (n + 1) / (2 * math.pi) - 1) < case[3], ("%d: %g"):format(n, p.lumens))
    end
    local p = ylm.photometry { cosine = 4, lumens = 3600 }
    assert.is_true(math.abs(p.lumens - 3600) < 1e-6)
    assert.is_true(math.abs(p.peak - 3600 * 5 / (2 * math.pi)) < 0.01)
    local half = p:flux { from = 30, to = 60 } + p:flux { to = 30 } + p:flux { from = 60 }
    assert.is_true(math.abs(half - 3600) < 1e-6)
  end)

  it("has the flux that its intensities have all around, to 1e-6, cut-offs included", function()
    local function cut(gamma, c) return gamma < 1 and 100 * (1.2 + math.cos(c)) * math.exp(-((gamma - 0.6) / 0.2) ^ 2) or 0 end
    local v, h, cd, ways, weights = {}, {}, {}, {}, {}
    for i = 0, 18 do v[i + 1] = 5 * i end
    for k = 0, 11 do
      h[k + 1], cd[k + 1] = 30 * k, {}
      for i = 0, 18 do cd[k + 1][i + 1] = cut(math.rad(5 * i), math.rad(30 * k)) end
    end
    local nodes = { { -0.906179845938664, 0.236926885056189 }, { -0.538469310105683, 0.478628670499366 },
      { 0, 0.568888888888889 }, { 0.538469310105683, 0.478628670499366 }, { 0.906179845938664, 0.236926885056189 } }
    for i = 0, 71 do -- four parts of each interval
      for _, node in ipairs(nodes) do
        local gamma = math.rad(1.25 * (i + 0.5 + node[1] / 2))
        for k = 1, 120 do
          local c = math.rad(3 * k - 1.5)
          ways[#ways + 1] = { math.sin(gamma) * math.cos(c), math.sin(gamma) * math.sin(c), math.cos(gamma) }
          weights[#ways] = math.rad(1.25) * node[2] / 2 * math.rad(3) * math.sin(gamma)
        end
      end
    end
    local p = ylm.photometry { vertical = v, horizontal = h, candela = cd }
    local sum = (p:intensity(ways) * ylm.array(weights, "double")):sum()
    assert.is_true(math.abs(sum / p.lumens - 1) < 1e-6, ("%.9g, %.9g"):format(sum, p.lumens))
  end)

  it("comes nearer to a smooth lamp than lines do, poles included", function()
    local spline, lines, ways = sampled(5, 15), sampled(5, 15, "linear"), directions(400)
    local a, b, worst = spline:intensity(ways), lines:intensity(ways), { 0, 0 }
    for i, w in ipairs(ways) do
      local wanted = smooth(w[1], w[2], w[3])
      worst[1], worst[2] = math.max(worst[1], math.abs(a:get(i) - wanted)), math.max(worst[2], math.abs(b:get(i) - wanted))
    end
    assert.is_true(worst[1] < 0.02 and worst[2] > 20 * worst[1], ("%g, by lines %g"):format(worst[1], worst[2]))
  end)

  it("has derivatives of the function that is constant along rays, as differences have them", function()
    local p, place, h = sampled(5, 15), { { 1, 2, 3 }, { 2, 4, 5 }, { 3, 5, 6 } }, 1e-5
    for _, w in ipairs(directions(80)) do
      local _, g, H = p:intensity(w, { derivatives = 2 })
      for a = 1, 3 do
        local up, down = { w[1], w[2], w[3] }, { w[1], w[2], w[3] }
        up[a], down[a] = w[a] + h, w[a] - h
        local fu, gu = p:intensity(up, { derivatives = 1 })
        local fd, gd = p:intensity(down, { derivatives = 1 })
        assert.is_true(math.abs((fu - fd) / (2 * h) - g:get(a)) < 1e-5)
        local lu, ld = math.sqrt(1 + 2 * h * w[a] + h * h), math.sqrt(1 - 2 * h * w[a] + h * h)
        for b = 1, 3 do
          local difference = (gu:get(b) / lu - gd:get(b) / ld) / (2 * h)
          assert.is_true(math.abs(difference - H:get(place[a][b])) < 1e-4, ("%g, %g"):format(difference, H:get(place[a][b])))
        end
      end
    end
  end)

  it("does not ring beside a cut-off, and counts nothing as negative there", function()
    local v, row = {}, {}
    for i = 0, 18 do v[i + 1], row[i + 1] = 5 * i, i <= 9 and 1000 or 0 end
    local p = ylm.photometry { vertical = v, horizontal = { 0 }, candela = { row } }
    assert.equal(0, p:check().clipped)
    for g = 0, 90 do
      local I = p:intensity { math.sin(math.rad(g)), 0, math.cos(math.rad(g)) }
      assert.is_true(I >= 0 and I <= 1001, ("%d: %g"):format(g, I))
    end
  end)

  it("says what it holds", function()
    local facts = ylm.photometry { cosine = 1, lumens = 1000, watts = 10 }:check()
    assert.is_true(math.abs(facts.beam[1] - 120) <= 0.5 and math.abs(facts.field[2] - 168.5) <= 0.5, facts.field[2])
    assert.is_true(math.abs(facts.efficacy - 100) < 1e-6)
    assert.equal(1, facts.downward)
    local all_around = ylm.photometry { intensity = function() return 1 end }
    assert.is_true(math.abs(all_around:check().downward - 0.5) < 1e-9)
    assert.is_true(math.abs(all_around.lumens - 4 * math.pi) < 1e-9)
  end)

  it("is an image of the sphere, whose sum over solid angles is the flux", function()
    local p = sampled(5, 15)
    local image = p:image { size = { 128, 64 } }
    local _, solid = image:directions()
    local flux = (image:layer():reshape { 64 * 128 } * solid):sum()
    assert.is_true(math.abs(flux / p.lumens - 1) < 1e-3, flux)
  end)

  it("draws polar curves, as pixels and as lines", function()
    local p = ylm.photometry { cosine = 2, lumens = 1000 }
    local plot, folder = p:plot { title = "A lamp", size = { 240, 240 } }, scratch.new()
    local pixels, message, code = plot:pixels()
    if code == "EMISSING" then return pending(message) end
    assert.same({ 240, 240, 3 }, pixels.shape)
    for _, ending in ipairs { "png", "svg", "pdf" } do assert(plot:save(folder.path .. "/polar." .. ending)) end
    local text = folder:read "polar.svg"
    for _, word in ipairs { "A lamp", "C0–C180", "C90–C270", "cd/klm", "90°" } do assert.truthy(text:find(word, 1, true),
      word) end
    folder:remove()
  end)

  it("refuses what is no table", function()
    local function made(o) return function() return assert(ylm.photometry(o)) end end
    refused("give one of file, candela", made {})
    refused("got cosine and candela", made { cosine = 1, candela = { { 1, 1 } } })
    refused("vertical is missing", made { candela = { { 1, 1 } }, horizontal = { 0 } })
    refused("candela must be %[1%]%[3%]", made { vertical = { 0, 45, 90 }, horizontal = { 0 }, candela = { { 1, 1 } } })
    refused("angles must increase: 45 follows 90", made { vertical = { 0, 90, 45 }, horizontal = { 0 }, candela = { { 1, 1,
      1 } } })
    refused("must be from 0 to 1e%+20 cd, got %-1", made { vertical = { 0, 90 }, horizontal = { 0 }, candela = { { 1, -1 } } })
    refused("must be from 0 to 180, got 190", made { vertical = { 0, 190 }, horizontal = { 0 }, candela = { { 1, 1 } } })
    refused("lumens: all intensities are 0", made { vertical = { 0, 90 }, horizontal = { 0 }, candela = { { 0, 0 } },
      lumens = 5 })
    refused("tilt is for a file", made { cosine = 1, tilt = 3 })
    refused("watts is for tables", made { file = "x.ies", watts = 3 })
    refused("intensity must return a number", made { intensity = function() return "bright" end })
    refused("does not change, make another", function() ylm.photometry { cosine = 1 }.lumens = 3 end)
    refused("ends in .ies or .ldt", function() ylm.photometry { cosine = 1 }:save "lamp.txt" end)
    refused("planes must be 1 to 4 angles", function() ylm.photometry { cosine = 1 }:plot { planes = {} } end)
    local p, message, code = ylm.photometry { file = "no such lamp.ies" }
    assert.is_nil(p)
    assert.equal("EIO", code, message)
  end)
end)
