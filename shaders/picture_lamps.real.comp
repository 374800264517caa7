/*
** Lamps drawn over a picture, the farthest first, as csrc/shade's ylm_shade_draw_lamps. A group is a tile of 8 x 8 pixels
** with the lamps that may touch it.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

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

/* How much of the pixel lies on the disc: by the distance of its centre from the rim. Chords stand for angles; they are
   lengths of differences, as those of cosines would be lost in float. */
real covered(uint d, rvec3 u) {
  real far = length(u), size = pixel / (far * sqrt(far));
  real off = length(u / far - rvec3(disc[d], disc[d + 1], disc[d + 2])), radius = disc[d + HALF] / size;
  real inside = clamp(radius - off / size + REAL(0.5), REAL(0), REAL(1));
  return radius < REAL(0.5) ? inside * 4 * radius * radius : inside;
}

/* The part of a pixel that shows nothing nearer than `far`. */
real open_part(uint p, real far) {
  real hidden = REAL(0);
  for (uint i = first_entry[p]; i < first_entry[p + 1]; i++)
    if (real(depth[i]) < far) hidden += real(weight[i]);
  return hidden < 1 ? 1 - hidden : REAL(0);
}

void main() {
  Tile t = tile[ylm_group(first)];
  uint lane = gl_LocalInvocationID.x, x = t.x + lane % 8, y = t.y + lane / 8, p = y * width + x;
  if (x >= width || y >= height) return;
  real across = 2 * (real(x) + REAL(0.5)) / real(width) - 1, along = 1 - 2 * (real(y) + REAL(0.5)) / real(height);
  rvec3 u;
  for (int a = 0; a < 3; a++) u[a] = forward[a] + across * right[a] + along * up[a];
  vec3 sum = vec3(image[3 * p], image[3 * p + 1], image[3 * p + 2]);
  for (uint i = t.begin; i < t.end; i++) {
    uint d = list[i] * DISC;
    if (real(x) < disc[d + BOX] || real(x) >= disc[d + BOX + 1] || real(y) < disc[d + BOX + 2] ||
        real(y) >= disc[d + BOX + 3])
      continue;
    real share = covered(d, u);
    if (share > 0) share *= open_part(p, disc[d + DEPTH]);
    vec3 colour = vec3(disc[d + RADIANCE], disc[d + RADIANCE + 1], disc[d + RADIANCE + 2]);
    if (share > 0) sum += float(share) * (colour - sum);
  }
  for (int c = 0; c < 3; c++) image[3 * p + c] = sum[c];
}
