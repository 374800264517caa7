--- Constants of the recurrences that moments are made with: csrc/light/moments_kernel.h has them for C.
--
-- Weights: u_n = P'_(n+1)(alpha) / P'_(n+1)(1) with delta = 1 - alpha, from u_0 = 1, e_0 = 0, by
--     e_(n+1) = SLOWS(n) e_n - delta u_n,   u_(n+1) = u_n + STEP(n) e_(n+1);
-- P_k - alpha P'_k is, but for a factor, u_k + RHO(k) u_(k-2). Harmonics: monic Legendre polynomials of order m,
--     q_(k+1) = z q_k - BETA(k, m) q_(k-1),
-- times Re or Im of (x+iy)^m. DESIGN section 4; docs/math.md.

local recurrences = {}

function recurrences.SLOWS(n) return n * (2 * n + 1) / ((n + 2) * (2 * n + 3)) end
function recurrences.STEP(n) return (2 * n + 3) / (n + 3) end
function recurrences.RHO(k) return k / (k + 1) end
function recurrences.BETA(k, m) return (k * k - m * m) / (4 * k * k - 1) end

return recurrences
