/*
** Results of the lights' sums at points, in the order in which a grid keeps them. Sums were asked for at the nearest
** float positions; the gradient carries the value to the lattice. A point's ratio is what a cell's metric is the mean
** of; -1: in a light.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(set = 0, binding = 0) readonly buffer Value { float value[]; };       /* [n][width] */
layout(set = 0, binding = 1) readonly buffer Gradient { float gradient[]; }; /* [n][width][3] */
layout(set = 0, binding = 2) readonly buffer Lambda { float lambda[]; };
layout(set = 0, binding = 3) readonly buffer Norm { float norm[]; };
layout(set = 0, binding = 4) readonly buffer Inside { uint inside[]; };
layout(set = 0, binding = 5) readonly buffer Keys { uvec2 key[]; };
layout(set = 0, binding = 6) readonly buffer Axes { vec2 axis[]; };
layout(set = 0, binding = 7) writeonly buffer Data { float data[]; };   /* [..][4][stride] */
layout(set = 0, binding = 8) writeonly buffer Extra { float extra[]; }; /* [..][3]: lambda, norm, 1 in a light */
layout(set = 0, binding = 9) writeonly buffer Ratio { float ratio[]; };
layout(set = 0, binding = 10) buffer Bad { uint bad; };

PUSH {
  uint first;
  uint n, begin, resolution;
  uint width, stride, relative;
  uint metric; /* whether it is there */
  uint row;    /* of the first point */
};

#include "gen/cells.glsl"

bool finite(float x) { return (floatBitsToUint(x) & 0x7f800000) != 0x7f800000; }

void main() {
  uint item = ylm_item(first), i = item / stride, c = item % stride, to = (row + i) * 4 * stride + c;
  if (i >= n) return;
  vec3 slope = vec3(0.0);
  float v = 0.0;
  if (c < width) {
    uvec3 at = unpacked(key[begin + i]);
    uint from = i * width + c;
    slope = vec3(gradient[3 * from], gradient[3 * from + 1], gradient[3 * from + 2]);
    vec3 lacks;
    for (uint a = 0; a < 3; a++) lacks[a] = axis[a * (resolution + 1) + at[a]].y;
    v = carried(value[from], lacks, slope);
    if (!finite(v) || !finite(slope.x) || !finite(slope.y) || !finite(slope.z)) atomicMax(bad, ~(begin + i));
  }
  data[to] = v;
  for (uint a = 0; a < 3; a++) data[to + (a + 1) * stride] = slope[a];
  if (c != 0) return;
  float l = metric != 0 ? lambda[i] : uintBitsToFloat(0x7fc00000), m = metric != 0 ? norm[i] : l;
  uint at = 3 * (begin + i);
  extra[at] = l;
  extra[at + 1] = m;
  extra[at + 2] = inside[i] != 0 ? 1.0 : 0.0;
  ratio[begin + i] = inside[i] != 0 ? -1.0 : point_ratio(l, m, relative != 0);
}
