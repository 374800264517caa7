/*
** A picture from the radiance of shading points, as ylm_shade_compose makes it: what a pixel shows of lamps, its share of the
** background, and its entries' shares of surfaces. One item a pixel.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(constant_id = 1) const bool CORNERS = false; /* entries are places on triangles, shading points their corners */

layout(set = 0, binding = 0) readonly buffer First { uint first_entry[]; }; /* [pixels + 1] */
layout(set = 0, binding = 1) readonly buffer Shown { vec4 shown[]; };       /* lamps, share of the background */
layout(set = 0, binding = 2) readonly buffer Weights { float weight[]; };   /* [entries] */
layout(set = 0, binding = 3) readonly buffer Radiance { float radiance[]; }; /* [points][3] */
layout(set = 0, binding = 4) readonly buffer Corners { uint corner[]; };    /* [entries][3] */
layout(set = 0, binding = 5) readonly buffer Parts { float part[]; };       /* [entries][3] */
layout(set = 0, binding = 6) writeonly buffer Image { float image[]; };     /* [pixels][3] */
PUSH {
  uint first;
  uint begin, end; /* pixels */
  float background[3];
};

#include "gen/picture.glsl"

vec3 more(vec3 sum, float share, vec3 x) {
  for (int c = 0; c < 3; c++) sum[c] = with_share(sum[c], share, x[c]);
  return sum;
}

vec3 at_point(uint i) { return vec3(radiance[3 * i], radiance[3 * i + 1], radiance[3 * i + 2]); }

vec3 at_entry(uint i) {
  if (!CORNERS) return at_point(i);
  vec3 sum = vec3(0.0);
  for (uint k = 3 * i; k < 3 * i + 3; k++) sum = more(sum, part[k], at_point(corner[k]));
  return sum;
}

void main() {
  uint p = begin + ylm_item(first);
  if (p >= end) return;
  vec4 x = shown[p];
  vec3 sum = more(x.xyz, x.w, vec3(background[0], background[1], background[2]));
  for (uint i = first_entry[p]; i < first_entry[p + 1]; i++) sum = more(sum, weight[i], at_entry(i));
  for (int c = 0; c < 3; c++) image[3 * p + c] = sum[c];
}
