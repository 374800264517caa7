/*
** Lamps drawn over a picture, the farthest first, as ylm_shade_draw_lamps does. A group is a tile of 8 x 8 pixels
** with the lamps that may touch it.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "gen/layout.glsl"

struct Tile {
  uint x, y, begin, end; /* its first pixel; of the list of discs */
};

layout(set = 0, binding = 0) readonly buffer First { uint first_entry[]; }; /* [pixels + 1] */
layout(set = 0, binding = 1) readonly buffer Weights { float weight[]; };   /* [entries] */
layout(set = 0, binding = 2) readonly buffer Depths { float depth[]; };     /* [entries] */
layout(set = 0, binding = 3) readonly buffer Camera { real right[3], up[3], forward[3], pixel; };
layout(set = 0, binding = 4) readonly buffer Discs { real disc[]; }; /* [discs][DISC] */
layout(set = 0, binding = 5) readonly buffer Tiles { Tile tile[]; };
layout(set = 0, binding = 6) readonly buffer List { uint list[]; };
layout(set = 0, binding = 7) buffer Image { float image[]; }; /* [height][width][3] */
PUSH {
  uint first;
  uint width, height;
};

/* Of a disc: the direction to it, its depth, the chord of half the angle it fills, its radiance, the box of its pixels. */
const uint DISC = 12, DEPTH = 3, HALF = 4, RADIANCE = 5, BOX = 8;

#include "gen/picture.glsl"

/* The part of a pixel that shows nothing nearer than `far`. */
real open_part(uint p, real far) {
  real hidden = REAL(0);
  for (uint i = first_entry[p]; i < first_entry[p + 1]; i++)
    hidden += hides(real(weight[i]), real(depth[i]), far);
  return open_share(hidden);
}

void main() {
  Tile t = tile[ylm_group(first)];
  uint lane = gl_LocalInvocationID.x, x = t.x + lane % PIXEL_TILE, y = t.y + lane / PIXEL_TILE, p = y * width + x;
  if (x >= width || y >= height) return;
  real across = to_the_right(real(x) + REAL(0.5), real(width)), along = upwards(real(y) + REAL(0.5), real(height));
  rvec3 u;
  for (int a = 0; a < 3; a++) u[a] = ray_along(forward[a], right[a], up[a], across, along);
  vec3 sum = vec3(image[3 * p], image[3 * p + 1], image[3 * p + 2]);
  for (uint i = t.begin; i < t.end; i++) {
    uint d = list[i] * DISC;
    if (real(x) < disc[d + BOX] || real(x) >= disc[d + BOX + 1] || real(y) < disc[d + BOX + 2] ||
        real(y) >= disc[d + BOX + 3])
      continue;
    real share = disc_share(u, rvec3(disc[d], disc[d + 1], disc[d + 2]), disc[d + HALF], pixel);
    if (share > 0) share *= open_part(p, disc[d + DEPTH]);
    for (uint c = 0; share > 0 && c < 3; c++) sum[c] = drawn_over(sum[c], float(share), float(disc[d + RADIANCE + c]));
  }
  for (int c = 0; c < 3; c++) image[3 * p + c] = sum[c];
}
