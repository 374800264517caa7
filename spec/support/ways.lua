--- Options of pictures by one way, from tables that specs share.

local ways = {}

local function copy(o)
  local out = {}
  for key, value in pairs(o or {}) do out[key] = value end
  return out
end

--- By the sum of all lights' coefficients.
function ways.sum(o)
  local out = copy(o)
  out.by = "sum"
  return out
end

--- By rays to the lamps alone, 64 of a point.
function ways.rays(o)
  local out = copy(o)
  out.by, out.bounces, out.light_samples = "rays", 0, out.light_samples or 64
  if out.shadows == false then out.shadows, out.visibility = nil, "none" end
  return out
end

local of_sum = { "lmax", "zonal", "window", "horizon", "shadows", "subset", "tile", "alpha", "sums", "tolerance" }
local of_rival = { vpl = { "clamp", "limit", "compensate" }, vsl = { "samples", "strategy" }, vsgl = { "groups" } }

--- Of a prepared view: virtual lights alone. `o` has lights, method ("hvl", or a rival) and options of both side by side.
function ways.virtual(o)
  local out, virtual = copy(o), {}
  out.by, out.bounced, out.lights, out.method = "none", out.lights, nil, nil
  local rival = of_rival[o.method] and { o.method }
  for _, key in ipairs(rival and of_rival[o.method] or {}) do rival[key], out[key] = out[key], nil end
  for _, key in ipairs(of_sum) do virtual[key], out[key] = out[key], nil end
  out.rival, out.virtual = rival or nil, next(virtual) and virtual or nil
  return out
end

return ways
