--- Irradiance from coefficients, summed in Lua: what grids are compared with.

local ylm = require "ylm"

local irradiance = {}

--- Irradiance {r, g, b} at point i of coefficients [n][3][count] on a surface with normal n.
function irradiance.at(L, i, normal)
  local lmax = math.floor(math.sqrt(L.shape[3]) + 0.5) - 1
  local Y = ylm.sh.eval(lmax, normal)
  local A = { [0] = math.pi, 2 * math.pi / 3, math.pi / 4, 0, -math.pi / 24, 0, math.pi / 64, 0, -math.pi / 128 }
  local E = { 0, 0, 0 }
  for c = 1, 3 do
    for l = 0, lmax do
      for m = -l, l do
        local k = ylm.sh.index(l, m)
        E[c] = E[c] + A[l] * Y[k] * L[i][c][k]
      end
    end
  end
  return E
end

--- Errors of coefficients against exact ones at points with normals, as a tolerance of irradiance measures them.
function irradiance.errors(L, exact, normals)
  local truth, mean, errors = {}, { 0, 0, 0 }, {}
  for i, normal in ipairs(normals) do
    truth[i] = irradiance.at(exact, i, normal)
    for c = 1, 3 do mean[c] = mean[c] + math.abs(truth[i][c]) / #normals end
  end
  for i, normal in ipairs(normals) do
    local E, worst = irradiance.at(L, i, normal), 0
    for c = 1, 3 do
      worst = math.max(worst, math.abs(E[c] - truth[i][c]) / math.max(math.abs(truth[i][c]), mean[c]))
    end
    errors[i] = worst
  end
  return errors
end

return irradiance
