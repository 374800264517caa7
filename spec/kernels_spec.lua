-- All kernel sets find the reference's light at random settings: degrees, types, and numbers of lights and points that no kernel
-- is cut for.

local by_kernels = require "spec.support.by_kernels"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

describe("kernels", function()
  local program = scratch.text "spec/support/random_light.lua"

  for seed = 1, long(1, 20) do
    it("agree with the reference's at random settings, seed " .. seed, function()
      local want
      for _, isa in ipairs(ylm.info().kernels) do -- the reference first
        local got, at, results = by_kernels(isa, ("local SEED = %d\n%s"):format(seed, program)), 1, 0
        want = want or got
        assert.equal(#want, #got, isa)
        while at < #want do
          local n, bound = want[at], want[at + 1]
          for i = at, at + 1 + n do
            assert(math.abs(got[i] - want[i]) <= bound, ("%s, result %d, number %d of %d: %.12g for %.12g"):format(isa, results,
              i - at - 1, n, got[i], want[i]))
          end
          at, results = at + 2 + n, results + 1
        end
        assert(results > 50, results)
      end
    end)
  end
end)
