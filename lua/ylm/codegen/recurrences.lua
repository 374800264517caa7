--- The recurrences that sums over lights are made with, of numbers or of nodes.
--
-- Weights: u_n = P'_(n+1)(alpha) / P'_(n+1)(1) with delta = 1 - alpha, from u_0 = 1, e_0 = 0, by
--     e_(n+1) = SLOWS(n) e_n - delta u_n,   u_(n+1) = u_n + STEP(n) e_(n+1);
-- P_k - alpha P'_k is, but for a factor, u_k + RHO(k) u_(k-2). Harmonics: monic Legendre polynomials of order m,
--     q_(k+1) = z q_k - BETA(k, m) q_(k-1),   BETA(k, m) = ABOVE(k, m) / BELOW(k),
-- times Re or Im of (x+iy)^m. docs/math.md.

local recurrences = {}

function recurrences.SLOWS(n) return n * (2 * n + 1) / ((n + 2) * (2 * n + 3)) end
function recurrences.STEP(n) return (2 * n + 3) / (n + 3) end
function recurrences.RHO(k) return k / (k + 1) end
function recurrences.ABOVE(k, m) return k * k - m * m end
function recurrences.BELOW(k) return 4 * k * k - 1 end
function recurrences.BETA(k, m) return recurrences.ABOVE(k, m) / recurrences.BELOW(k) end

--- e_(n+1), u_(n+1) from e_n, u_n.
function recurrences.weight(slows, step, delta, e, u)
  local next_e = slows * e - delta * u
  return next_e, u + step * next_e
end

--- The weight of a moment for Hessians, far = d/h^3, from u_k and u_(k-2).
function recurrences.bent(rho, u, before, far) return (u + rho * before) * far end

--- q_(k+1) from q_k and q_(k-1) where z has a second part: what it lost to rounding.
function recurrences.fine(beta, z, rest, q, before) return z * q + (rest * q - beta * before) end

--- The second part of z, times `grow`, of the unit vector x, y, z: by half of what its square
-- exceeds 1.
function recurrences.rest(grow, x, y, z) return -0.5 * grow * z * ((z - 1) * (z + 1) + (x * x + y * y)) end

return recurrences
