--- A room of edge 2 that one quad parts, turned anyhow and 0.03 off the middle, a lamp on one side of it; triangles of the room
-- run under the quad: sealed(ylm, turn) -> scene, dark, lit. Either is { points, normals }, places in the room on that side.

local turned = require "spec.support.turned"

local PLACES, OFF, BEYOND = 400, 0.03, 3
local BIT = 0.002 -- places that are nearer to the quad are left out: a bit above a surface is beyond it where it leans

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- Place k of a sequence: on a face of the room, or on one side of the quad; its normal, and how far it is on the lamp's side.
local function place(k, n, u, v)
  local a, b, p, normal = 2 * (k * 0.618034 % 1) - 1, 2 * (k * 0.754878 % 1) - 1, {}, { 0, 0, 0 }
  local face = k % 7
  if face < 6 then
    local axis, side = face % 3 + 1, face < 3 and 1 or -1
    p[axis], p[axis % 3 + 1], p[(axis + 1) % 3 + 1], normal[axis] = side, a, b, -side
    return p, normal, dot(p, n) - OFF
  end
  local side = k % 2 * 2 - 1
  for c = 1, 3 do p[c], normal[c] = OFF * n[c] + 1.7 * (a * u[c] + b * v[c]), side * n[c] end
  return p, normal, side
end

return function(ylm, turn)
  local n, u, v = turned(turn)
  local corner, lamp, u2, v2 = {}, {}, {}, {}
  for a = 1, 3 do
    corner[a], lamp[a] = OFF * n[a] - BEYOND * (u[a] + v[a]), 0.6 * n[a]
    u2[a], v2[a] = 2 * BEYOND * u[a], 2 * BEYOND * v[a]
  end
  local grey = ylm.matte { albedo = 0.5 }
  local scene = ylm.scene "a sealed room" {
    geometry = { ylm.box { scale = 2, material = grey }, ylm.quad { corner = corner, u = u2, v = v2, material = grey } },
    lights = ylm.sphere_light { at = lamp, radius = 0.1, radiance = 40 },
  }
  local dark, lit, k = { points = {}, normals = {} }, { points = {}, normals = {} }, 0
  while #dark.points < PLACES do
    k = k + 1
    local p, normal, off = place(k, n, u, v)
    if math.max(math.abs(p[1]), math.abs(p[2]), math.abs(p[3])) <= 1 and math.abs(off) > BIT then
      local list = off > 0 and lit or dark
      list.points[#list.points + 1], list.normals[#list.normals + 1] = p, normal
    end
  end
  return scene, dark, lit
end
