-- A room that one quad seals gets no light, in any turn of the quad: by elements, in grids with sides, on surfaces.

local ylm = require "ylm"
local quietly = require "spec.support.quietly"
local irradiance = require "spec.support.irradiance"
local long = require "spec.support.long"
local sealed = require "spec.support.sealed_rooms"

local LEAK = 1e-4 -- of the mean of the lit side

--- Places a bit above the surfaces.
local function lifted(places)
  local out = {}
  for i, p in ipairs(places.points) do
    local n = places.normals[i]
    out[i] = { p[1] + 1e-3 * n[1], p[2] + 1e-3 * n[2], p[3] + 1e-3 * n[3] }
  end
  return out
end

local function mean_of(light, places)
  local sum = 0
  for _, e in ipairs(light(places)) do sum = sum + math.abs(e) / #places.points end
  return sum
end

local function stays_dark(name, turn, light, dark, lit)
  local bright = mean_of(light, lit)
  assert.is_true(bright > 0.1, bright)
  local leak = mean_of(light, dark) / bright
  assert.is_true(leak < LEAK, ("%s, turn %d: %g of the mean"):format(name, turn, leak))
end

describe("a room that one quad seals", function()
  it("stays dark", function()
    for turn = long(17, 1), 20, long(4, 1) do
      local scene, dark, lit = sealed(ylm, turn)
      local links = scene:links { rays = long(32, 256), spacing = long(0.2, 0.035) }
      local surfaces = quietly(function()
        return scene:surface_grid { tolerance = long(0.3, 0.1), judge = "field", links = links }
      end)
      stays_dark("on surfaces", turn, function(places)
        local E, out = surfaces:irradiance(places.points, places.normals), {}
        for i = 1, #places.points do out[i] = E:get(i, 2) end
        return out
      end, dark, lit)
      local grid = quietly(function()
        return scene:bake { probes = ylm.uniform_grid { lmax = 2, cells = { 7, 7, 7 } }, quantity = "indirect", judge = "field",
          links = links }
      end)
      stays_dark("in a grid", turn, function(places)
        local L, out = grid:sample(lifted(places), { normals = places.normals, scene = scene }), {}
        for i, n in ipairs(places.normals) do out[i] = irradiance.at(L, i, n)[2] end
        return out
      end, dark, lit)
    end
  end)
end)
