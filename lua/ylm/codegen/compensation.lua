--- A sum that loses nothing to rounding, but for what is below its last bit twice, once for C
-- (csrc/light/moments/gen/compensation.h) and once for GLSL (shaders/gen/compensation.glsl): sums over many lights are added up
-- in parts.

local common = require "ylm.codegen.common"

local compensation = {}

compensation.functions = {
  { about = "Adds a part to a total; `lost`: by how much it was too large. Source: Kahan 1965.", text = [[
void add_part(real part, inout real total, inout real lost) {
  exact real x = part - @lost;
  exact real next = @total + x;
  exact real kept = next - @total;
  exact real rest = kept - x;
  @lost = rest;
  @total = next;
}]] },
}

--- The file's text in a language of common.lua.
function compensation.text(name)
  return common.text(name, "compensation", { "Sums with compensation." }, compensation.functions)
end

return compensation
