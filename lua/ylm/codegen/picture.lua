--- Pixels from shaded points, and lamps drawn over them, once for C (csrc/shade/gen/picture.h) and once for GLSL
-- (shaders/gen/picture.glsl).

local common = require "ylm.codegen.common"

local picture = {}

picture.functions = {
  { about = "A sum, and a share of something more.", text = [[
float with_share(float sum, float share, float more) { return sum + share * more; }]] },
  { about = "Something drawn over what is there, covering a share of it.", text = [[
float drawn_over(float there, float share, float over) { return there + share * (over - there); }]] },
  { about = "Where a place of the image, in pixels, is between -1 and 1: to the right, and upwards.", text = [[
real to_the_right(real x, real width) { return #2.0 * x / width - #1.0; }]] },
  { about = "Upwards.", text = [[
real upwards(real y, real height) { return #1.0 - #2.0 * y / height; }]] },
  { about = "A component of the ray there.", text = [[
real ray_along(real forward, real right, real up, real x, real y) { return forward + x * right + y * up; }]] },
  { about = "The chord between the directions of u, of that length, and of a unit vector. In float a cosine would lose it.",
    text = [[
real chord_between(vector u, real length_of_u, vector unit) {
  FINE
  real cosine = (u[0] * unit[0] + u[1] * unit[1] + u[2] * unit[2]) / length_of_u;
  return ROOT(#2.0 * (cosine < #1.0 ? #1.0 - cosine : #0.0));
  COARSE
  real x = u[0] / length_of_u - unit[0], y = u[1] / length_of_u - unit[1], z = u[2] / length_of_u - unit[2];
  return ROOT(x * x + y * y + z * z);
  END
}]] },
  { about = "How much of the pixel in direction u lies on a disc: by the distance of its centre from the rim. to, chord: the "
      .. "direction of the\n   disc's centre and the chord of half the angle it fills, for angles: lamps are small, and what "
      .. "is far off is not covered by\n   either; height: of a pixel at distance 1.", text = [[
real disc_share(vector u, vector to, real chord, real height) {
  real far = ROOT(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  real off = chord_between(u, far, to), pixel = height / (far * ROOT(far));
  real radius = chord / pixel, inside = radius - off / pixel + #0.5;
  inside = inside < #0.0 ? #0.0 : inside > #1.0 ? #1.0 : inside;
  return radius < #0.5 ? inside * #4.0 * radius * radius : inside;
}]] },
  { about = "What a part of a pixel, of that weight and depth, adds to what hides a lamp.", text = [[
real hides(real weight, real depth, real lamp_depth) { return depth < lamp_depth ? weight : #0.0; }]] },
  { about = "The part that shows nothing nearer.", text = [[
real open_share(real hidden) { return hidden < #1.0 ? #1.0 - hidden : #0.0; }]] },
}

--- The file's text in a language of common.lua.
function picture.text(name)
  return common.text(name, "picture", { "Filtering of shading points into pixels; lamps drawn over a picture." },
    picture.functions)
end

return picture
