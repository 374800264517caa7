/*
** Which of the voxels `asked` the surface of a sphere crosses, as csrc/light/crosses.c says, to the bit; of spheres that
** stand for flat lights, as csrc/light/polygon_shape.c does. A group asks 64 of them about a chunk of spheres.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "octree.glsl"

layout(constant_id = 1) const bool FLAT = false;

layout(set = 0, binding = 0) readonly buffer Spheres { dvec4 sphere[]; }; /* centre, radius */
layout(set = 0, binding = 1) readonly buffer Asked { uint asked[]; };
layout(set = 0, binding = 2) readonly buffer Voxels { uvec4 voxel[]; };
layout(set = 0, binding = 3) readonly buffer Axes { double axis[]; }; /* [3][resolution + 1] */
layout(set = 0, binding = 4) buffer States { uint state[]; };

PUSH {
  uint first;
  uint n, edge, resolution;
  uint spheres, chunk;
};

/* Squared distances to the box's nearest and farthest point decide. */
bool meets(dvec4 s, double lo[3], double hi[3]) {
  precise double near = 0.0lf, far = 0.0lf, r2 = s.w * s.w;
  for (uint a = 0; a < 3; a++) {
    precise double x = lo[a] - s[a], y = s[a] - hi[a];
    precise double away = max(max(x, y), 0.0lf), across = min(x, y), away2 = away * away, across2 = across * across;
    near = near + away2;
    far = far + across2;
  }
  return near <= r2 && r2 <= far;
}

/* The same of a box larger by a rounding error. */
bool meets_larger(dvec4 s, double lo[3], double hi[3]) {
  precise double near = 0.0lf, far = 0.0lf, r2 = s.w * s.w;
  for (uint a = 0; a < 3; a++) {
    precise double sum = lo[a] + hi[a], width = hi[a] - lo[a], c = 0.5lf * sum, h = 0.5lf * width;
    precise double size = abs(c) + h, more = 1e-14lf * size, half_edge = h + more;
    precise double d = abs(c - s[a]), away = max(0.0lf, d - half_edge), across = d + half_edge;
    precise double away2 = away * away, across2 = across * across;
    near = near + away2;
    far = far + across2;
  }
  return near <= r2 && r2 <= far;
}

void main() {
  uint blocks = (n + gl_WorkGroupSize.x - 1) / gl_WorkGroupSize.x, group = ylm_group(first);
  uint i = (group % blocks) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
  if (i >= n) return;
  uint w = asked[i], begin = (group / blocks) * chunk, end = min(begin + chunk, spheres);
  uvec3 c = unpacked(voxel[w].xy);
  double lo[3], hi[3];
  for (uint a = 0; a < 3; a++) {
    uint at = a * (resolution + 1) + c[a];
    lo[a] = axis[at];
    hi[a] = axis[at + edge];
  }
  bool crossed = false;
  for (uint k = begin; k < end; k++) { /* no early end: groups take as long as was foreseen */
    bool met = FLAT ? meets_larger(sphere[k], lo, hi) : meets(sphere[k], lo, hi);
    crossed = crossed || met;
  }
  if (crossed) atomicOr(state[w], CROSSED);
}
