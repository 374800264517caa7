-- Directions count, not their lengths: whatever takes a direction takes it at any length that a number has.

local core = require "ylm.c.core"
local ylm = require "ylm"
local vector = require "ylm.vector"

local scales = { 1e-170, 2 ^ -1070, 5, 1e160, 1e308 }

--- Calls f(t), t = { x, y, z } -> the vector times a scale, at length 1 and all others; the array that it returns
-- has to be the same.
local function same(f, tolerance)
  local function by(scale)
    return f(function(x, y, z) return { x * scale, y * scale, z * scale } end)
  end
  local wanted = by(1)
  for _, scale in ipairs(scales) do
    local difference = core.array_distance(by(scale), wanted)
    assert(difference <= (tolerance or 1e-14), ("at %g: off by %g"):format(scale, difference))
  end
end

describe("a direction", function()
  it("is scaled to length 1 without a rounding that its length causes", function()
    for _, v in ipairs { { 3, 4, 0 }, { 1, 1, 1 }, { -2, 0.25, 7 } } do
      local length = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
      local unit = vector.unit(v)
      for a = 1, 3 do assert.equal(v[a] / length, unit[a]) end
    end
    assert.same({ 0, 0, -1 }, vector.unit { 0, 0, -2 ^ -1074 })
    assert.same({ 1, 0, 0 }, vector.unit { 1.7976931348623157e308, 0, 0 })
  end)

  it("is a disk's normal and a flat light's horizon", function()
    local x = { { 0.3, 0.2, 0 }, { -1, 0.4, 0.5 } }
    same(function(v)
      return (ylm.light_field(3, ylm.disk_light { at = { 0, 0, 1 }, normal = v(1, 0, 1), radius = 0.5 }, x,
        { dtype = "double" }))
    end)
    same(function(v)
      return (ylm.light_field(3, ylm.disk_light { at = { 0, 0, 1 }, normal = { 0, 0, 1 }, radius = 0.5,
        horizon = v(1, 0, 0.5) }, x, { dtype = "double" }))
    end)
    same(function(v)
      local packed = require("ylm.light").pack(1, "spec", ylm.disk_light { at = { 0, 0, 1 }, normal = v(1, 1, 0.5) })
      return (select(2, require("ylm.light").patches(packed)))
    end)
  end)

  it("is up, in cameras and in views", function()
    local view_camera = require "ylm.view.camera"
    same(function(v)
      local function reach(directions) -- of the box from (-1, -1, -1) to (1, 2, 3)
        local out = {}
        for i, d in ipairs(directions) do
          out[i] = math.max(-d[1], d[1]) + math.max(-d[2], 2 * d[2]) + math.max(-d[3], 3 * d[3])
        end
        return out
      end
      local fitted = view_camera.fit(reach, 320, 200, v(1, 0.5, 0.25), v(0, 1, 0.5))
      return (ylm.array { fitted.from, fitted.at, fitted.up })
    end, 1e-13)
    same(function(v)
      local scene = ylm.scene "up" { camera = ylm.camera { from = { 0, 1, 3 }, up = v(0.25, 1, 0) },
        geometry = { ylm.box {} }, lights = { ylm.sphere_light { at = { 0, 3, 0 } } } }
      return scene:render({ by = "sum", size = { 8, 6 }, samples = 1, transfer_samples = 1, lmax = 1 }):layer()
    end)
    local near = ylm.camera { from = { 0, 0, 0 }, at = { 0, 0, 1e-170 } }
    assert.equal(1e-170, near.at[3])
  end)

  it("is the zenith and the sun, an axis, what harmonics are turned to and taken at", function()
    local c = { 1, 2, 3, 4 }
    same(function(v) return (ylm.sh.sky(2, { kind = "clear", zenith = v(0, 1, 1), sun = v(0, 1, 0), nodes = 8 })) end)
    same(function(v) return (ylm.sh.sky(2, { zenith = v(0, 1, 1) })) end)
    same(function(v) return (ylm.sh.rotate(c, { axis = v(1, 0, 0.5), angle = 1 })) end)
    same(function(v) return (ylm.sh.rotate(c, { quaternion = { v(1, 0, 1)[1], 0, v(1, 0, 1)[3], 0 } })) end)
    same(function(v) return ylm.sh.zonal({ 0, 1, 0.5 }, v(1, 0, 0.25)) end)
    same(function(v) return ylm.sh.irradiance(c, { v(1, 0.5, 0) }) end)
    same(function(v) return (ylm.sh.reconstruct(c, { v(1, 0.5, -0.25) })) end)
    same(function(v)
      return (ylm.sh.project(1, { directions = { v(1, 1, 0.5), v(-1, -1, -0.5) }, values = { 1, 2 } }))
    end)
  end)

  it("is what a quadrilateral faces and what shapes turn about", function()
    for _, scale in ipairs { 1e-30, 1e30 } do
      local quad = ylm.quad { corner = { 0, 0, 0 }, u = { scale, 0, 0 }, v = { 0, scale, 0 } }
      assert.same({ 0, 0, 1 }, quad.mesh:normals()[1]:totable())
    end
    same(function(v)
      return ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 },
        rotate = { axis = v(1, 0.5, 0), angle = 40 } }.mesh:normals()
    end, 1e-7)
  end)

  it("is refused in a sentence where it is none", function()
    local nan, inf = 0 / 0, 1 / 0
    for _, bad in ipairs { { 0, 0, 0 }, { nan, 0, 1 }, { inf, 0, 0 } } do
      for _, f in ipairs {
        function() ylm.disk_light { at = { 0, 0, 0 }, normal = bad } end,
        function() ylm.camera { from = { 0, 0, 1 }, up = bad } end,
        function() ylm.sh.sky(2, { zenith = bad }) end,
        function() ylm.quad { corner = { 0, 0, 0 }, u = bad, v = { 0, 1, 0 } } end,
        function() ylm.sh.rotate({ 1, 2, 3, 4 }, { axis = bad, angle = 1 }) end,
        function() ylm.textured_light { corner = { 0, 0, 0 }, u = bad, v = { 0, 1, 0 }, image = { { 1 } } } end,
      } do
        local ok, message = pcall(f)
        assert.is_false(ok)
        assert.matches("vector_spec.lua:%d+: ", message)
      end
    end
    local ok, message = pcall(ylm.camera, { from = { 0, 0, 1e16 } })
    assert(not ok and message:find("from is too far out (the limit is 1e15)", 1, true), message)
    ok, message = pcall(ylm.quad, { corner = { 0, 0, 0 }, u = { 1e160, 0, 0 }, v = { 0, 1, 0 } })
    assert(not ok and message:find("coordinates are not finite", 1, true), message)
  end)
end)
