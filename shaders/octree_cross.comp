/*
** Which of the voxels `asked` the surface of a sphere crosses, to the bit as the processor says it (csrc/light/boxes.c, of
** spheres that stand for flat lights flat/shape.c). A group asks 64 of them about a chunk of spheres.
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

#include "gen/crossing.glsl"

void main() {
  uint blocks = (n + gl_WorkGroupSize.x - 1) / gl_WorkGroupSize.x, group = ylm_group(first);
  uint i = (group % blocks) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
  if (i >= n) return;
  uint w = asked[i], begin = (group / blocks) * chunk, end = min(begin + chunk, spheres);
  uvec3 c = unpacked(voxel[w].xy);
  dvec3 lo, hi, middle, reach;
  for (uint a = 0; a < 3; a++) {
    uint at = a * (resolution + 1) + c[a];
    lo[a] = axis[at];
    hi[a] = axis[at + edge];
    middle[a] = box_middle(lo[a], hi[a]);
    reach[a] = box_reach(lo[a], hi[a]);
  }
  bool crossed = false;
  for (uint k = begin; k < end; k++) { /* no early end: groups take as long as was foreseen */
    dvec4 s = sphere[k];
    bool met = FLAT ? sphere_meets_wide(s.xyz, s.w, middle, reach) : sphere_meets(s.xyz, s.w, lo, hi);
    crossed = crossed || met;
  }
  if (crossed) atomicOr(state[w], CROSSED);
}
