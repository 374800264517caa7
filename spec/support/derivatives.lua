--- A light's value and derivatives in double, and how far these are from differences.

local ylm = require "ylm"

local derivatives = {}

--- Luminance coefficients at points in double, and derivatives up to that order.
function derivatives.field(lmax, light, x, order)
  return ylm.light_field(lmax, light, x, { derivatives = order, channels = "luminance", dtype = "double" })
end

--- Value, gradient and Hessian at x in double, each as a flat table.
function derivatives.at(lmax, light, x)
  local list = { ylm.light_field(lmax, light, ylm.array({ x }, "double"), { derivatives = 2, channels = "luminance" }) }
  for k = 1, 3 do list[k] = list[k]:totable()[1][1] end
  return list
end

--- The relative errors of gradient and Hessian against sixth-order differences of value and gradient at step h.
function derivatives.errors(lmax, light, x, h)
  local here, weights = derivatives.at(lmax, light, x), { 45 / 60, -9 / 60, 1 / 60 }
  local error, norm = { 0, 0 }, { 0, 0 }
  local place = { { 1, 2, 3 }, { 2, 4, 5 }, { 3, 5, 6 } }
  for a = 1, 3 do
    local near = {}
    for s = -3, 3 do
      local p = { x[1], x[2], x[3] }
      p[a] = p[a] + s * h
      near[s] = derivatives.at(lmax, light, p)
    end
    local function difference(get)
      local d = 0
      for s = 1, 3 do d = d + weights[s] * (get(near[s]) - get(near[-s])) / h end
      return d
    end
    for k = 1, (lmax + 1) ^ 2 do
      error[1] = error[1] + (here[2][k][a] - difference(function(n) return n[1][k] end)) ^ 2
      norm[1] = norm[1] + here[2][k][a] ^ 2
      for b = 1, 3 do
        local H = here[3][k][place[a][b]]
        error[2] = error[2] + (H - difference(function(n) return n[2][k][b] end)) ^ 2
        norm[2] = norm[2] + H ^ 2
      end
    end
  end
  return math.sqrt(error[1] / norm[1]), math.sqrt(error[2] / norm[2])
end

return derivatives
