--- Which boxes the surface of a sphere meets, once for C (csrc/light/flat/gen/crossing.h) and once for GLSL
-- (shaders/gen/crossing.glsl): both in double, with the same roundings.

local common = require "ylm.codegen.common"

local crossing = {}

crossing.functions = {
  { about = "Does the surface |p - c| = r meet the box? Squared distances to its nearest and farthest point decide.", text = [[
bool sphere_meets(vector c, real r, vector lo, vector hi) {
  exact real nearest = #0.0, farthest = #0.0, r2 = r * r;
  for (int a = 0; a < 3; a++) {
    exact real x = lo[a] - c[a], y = c[a] - hi[a], beyond = x > y ? x : y, across = x > y ? y : x;
    exact real away = beyond > #0.0 ? beyond : #0.0, away2 = away * away, across2 = across * across;
    nearest = nearest + away2;
    farthest = farthest + across2;
  }
  return nearest <= r2 && r2 <= farthest;
}]] },
  { about = "The middle of a box's edge.", text = [[
real box_middle(real lo, real hi) {
  exact real sum = lo + hi, middle = #0.5 * sum;
  return middle;
}]] },
  { about = "Half of it, and a rounding error more: lights on a face of the box meet it.", text = [[
real box_reach(real lo, real hi) {
  exact real width = hi - lo, reach = #0.5 * width, size = ABS(box_middle(lo, hi)) + reach, more = #1e-14 * size;
  exact real all = reach + more;
  return all;
}]] },
  { about = "sphere_meets of a box by its middle and reach.", text = [[
bool sphere_meets_wide(vector c, real r, vector middle, vector reach) {
  exact real nearest = #0.0, farthest = #0.0, r2 = r * r;
  for (int a = 0; a < 3; a++) {
    exact real apart = middle[a] - c[a], d = ABS(apart), beyond = d - reach[a], across = d + reach[a];
    exact real away = beyond > #0.0 ? beyond : #0.0, away2 = away * away, across2 = across * across;
    nearest = nearest + away2;
    farthest = farthest + across2;
  }
  return nearest <= r2 && r2 <= farthest;
}]] },
}

--- The file's text in a language of common.lua.
function crossing.text(name)
  return common.text(name, "crossing", { "Boxes that the surface of a sphere light meets." }, crossing.functions)
end

return crossing
