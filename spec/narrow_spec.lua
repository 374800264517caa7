-- Kernels of most processors, where this one has wider ones: those of AVX2, but for sums of lights, as spec/narrow compiles them.
-- Specs run with them in processes of their own.

local scratch = require "spec.support.scratch"
local quote = scratch.quote
local build = os.getenv "YLM_BUILD" or "build"

--- Spec files, and a pattern of names where not all are run.
local specs = {
  { "kernels" }, { "sh_product" }, { "sh_rotate" }, { "virtual_kernel" }, { "virtual_lights" }, { "light_disk" },
  { "grid_sample", "every kernel set" }, { "small_grid", "every kernel set" },
  { "virtual_tree", "every kernel set" }, { "virtual_gloss", "plain code" },
  { "virtual_near", "far and near parts" }, { "shadow_fields", "each instruction set" },
  { "transfer_vectors", "each set of kernels" }, { "radiosity", "each set of kernels" },
  { "shade", "all instruction sets" }, { "choose", "every instruction set" }, { "glossy", "kernel" },
  { "material_kinds", "kernel" }, { "path", "bit for bit, by" },
}

describe("kernels for vectors of 32 bytes", function()
  if scratch.text(build .. "/include/ylm_built_sets.h"):match "^/%* (.-) %*/" ~= "avx512" then
    it("are run by all specs", function() pending "this build has none wider alone" end)
    return
  end

  setup(function()
    local out, status = scratch.capture("env -u LD_PRELOAD BUILD=" .. quote(build) .. " spec/narrow")
    assert(status == 0 and not out:find "warning", out)
    assert(scratch.shell("test -e " .. quote(build) .. "/narrow/lib/libylm.so"))
  end)

  for _, spec in ipairs(specs) do
    it("pass spec/" .. spec[1] .. "_spec.lua" .. (spec[2] and (": " .. spec[2]) or ""), function()
      local out, status = scratch.capture(table.concat({ "LD_LIBRARY_PATH=" .. quote(build) .. "/narrow/lib",
        os.getenv "YLM_LUA" or "lua", "spec/support/run/busted.lua -o plainTerminal",
        spec[2] and "--filter=" .. quote(spec[2]) or "", ("spec/%s_spec.lua"):format(spec[1]) }, " "))
      assert(status == 0 and out:find "[1-9]%d* success", out)
    end)
  end
end)
