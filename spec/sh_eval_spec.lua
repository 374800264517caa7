local ylm = require "ylm"
local vectors = require "spec.support.vectors"

describe("ylm.sh.eval", function()
  it("follows the convention: Y(1,-1), Y(1,0), Y(1,1) are sqrt(3/4pi) times -y, z, -x", function()
    local c = math.sqrt(3 / (4 * math.pi))
    local Y = ylm.sh.eval(1, { 0.48, -0.6, 0.64 })
    local wanted = { math.sqrt(1 / (4 * math.pi)), 0.6 * c, 0.64 * c, -0.48 * c }
    for i = 1, 4 do assert.is_near(wanted[i], Y[i], 1e-15) end
  end)

  it("agrees with the reference vectors to 1e-13, poles and unnormalised vectors included", function()
    for _, set in ipairs(vectors.sh "spec/data/sh_basis.txt") do
      local worst = vectors.compare(set, { ylm.sh.eval(set.lmax, set.points, { derivatives = 2 }) })
      for k = 1, 3 do assert(worst[k] < 1e-13, ("order %d: %g"):format(k - 1, worst[k])) end
    end
  end)
end)
