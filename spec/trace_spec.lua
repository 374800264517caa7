local ylm = require "ylm"
local core = require "ylm.c.core"
local lib = require "ylm.c.scene"
local light = require "ylm.light"

local none = {}

--- A traced scene of geometry and lamps {x, y, z, radius}.
local function traced(geometry, lamps)
  local meshes, materials, occludes = {}, {}, {}
  for i, g in ipairs(geometry) do
    meshes[i], materials[i], occludes[i] = g.mesh, core.material_create("matte", { 1, 1, 1 }), g.occludes
  end
  local lights = {}
  for i, l in ipairs(lamps or none) do lights[i] = ylm.sphere_light { at = { l[1], l[2], l[3] }, radius = l[4], radiance = 1 } end
  return assert(lib.scene_create(meshes, materials, occludes, light.set(assert(light.pack(1, "spec", lights)))))
end

--- Rays { origin, direction, far } as the array that scene_trace takes.
local function rays(list)
  local rows = {}
  for i, r in ipairs(list) do
    rows[i] = { r[1][1], r[1][2], r[1][3], r[2][1], r[2][2], r[2][3], 0, r[3] or 1e30 }
  end
  return ylm.array(rows, "float")
end

local function floor(fields)
  local f = { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } }
  for k, v in pairs(fields or none) do f[k] = v end
  return ylm.quad(f)
end

describe("tracing", function()
  it("finds the nearest triangle with its distance, weights and winding normal, from either side", function()
    local s = traced { floor(), floor { at = { 0, 1, 0 } } }
    local hits = lib.scene_trace(s, rays { { { 0.2, 5, 0.3 }, { 0, -2, 0 } }, { { 0.2, -3, 0.3 }, { 0, 1, 0 } } })
    assert.same({ 2, 1 }, { hits:get(1, 1), hits:get(2, 1) })
    assert.near(2, hits:get(1, 3), 1e-6)
    assert.near(3, hits:get(2, 3), 1e-6)
    for i = 1, 2 do
      local n = { hits:get(i, 6), hits:get(i, 7), hits:get(i, 8) }
      assert.is_true(n[2] > 0 and n[1] == 0 and n[3] == 0)
    end
    -- The hit's place from the weights of the corners.
    local mesh = floor { at = { 0, 1, 0 } }.mesh
    local t, v = mesh:triangles()[hits:get(1, 2)], mesh:vertices()
    local u, w = hits:get(1, 4), hits:get(1, 5)
    local weights, p = { 1 - u - w, u, w }, { 0, 0, 0 }
    for k = 1, 3 do for a = 1, 3 do p[a] = p[a] + weights[k] * v:get(t[k], a) end end
    assert.near(0.2, p[1], 1e-6)
    assert.near(1, p[2], 1e-6)
    assert.near(0.3, p[3], 1e-6)
  end)

  it("sees lamps, and they occlude nothing", function()
    local s = traced({ floor() }, { { 0, 2, 0, 0.5 }, { 0.4, 1, 0, 0.1 } })
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 } }, { { 0.4, 1.4, 0 }, { 0, -1, 0 } }, { { 0.9, 5, 0 }, { 0, -1, 0 } } }
    local hits = lib.scene_trace(s, r)
    assert.same({ -1, -1, 1 }, { hits:get(1, 1), hits:get(2, 1), hits:get(3, 1) })
    assert.same({ 1, 2 }, { hits:get(1, 2), hits:get(2, 2) })
    assert.near(2.5, hits:get(1, 3), 1e-5)
    local down = { 0, -1, 0 }
    local up = rays { { { 0, 0.1, 0 }, { 0, 1, 0 } }, { { 0, 5, 0 }, down, 4.9 }, { { 0, 5, 0 }, down, 5.1 } }
    assert.same({ 0, 0, 1 }, lib.scene_trace(s, up, true):totable())
  end)

  it("sees what does not occlude, and lets light through it", function()
    local s = traced { floor { occludes = false, at = { 0, 1, 0 } }, floor() }
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 }, 4.5 }, { { 0, 5, 0 }, { 0, -1, 0 }, 5.5 } }
    assert.equal(1, lib.scene_trace(s, r):get(1, 1))
    assert.same({ 0, 1 }, lib.scene_trace(s, r, true):totable())
  end)

  it("misses everything in an empty scene", function()
    local s = traced {}
    local r = rays { { { 0, 5, 0 }, { 0, -1, 0 } } }
    assert.equal(0, lib.scene_trace(s, r):get(1, 1))
    assert.same({ 0 }, lib.scene_trace(s, r, true):totable())
    assert.same({ { 0, 0, 0 }, { 0, 0, 0 } }, { lib.scene_bounds(s) })
  end)

  it("knows the box around all meshes", function()
    local lo, hi = lib.scene_bounds(traced({ floor(), floor { at = { 3, 1, 0 } } }, { { 9, 9, 9, 1 } }))
    assert.same({ { -1, 0, -1 }, { 4, 1, 1 } }, { lo, hi })
  end)
end)
