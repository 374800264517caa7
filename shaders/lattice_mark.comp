/* Marks the voxels of a uniform grid that hold shading points: a bit for each, x fastest. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(set = 0, binding = 0) readonly buffer Places { uint place[]; }; /* [n][3]: x and y, z, unused */
layout(set = 0, binding = 1) buffer Bits { uint bits[]; };

PUSH {
  uint first;
  uint n, nx, ny;
};

void main() {
  uint i = ylm_item(first);
  if (i >= n) return;
  uint xy = place[3 * i], v = (place[3 * i + 1] * ny + (xy >> 16)) * nx + (xy & 0xffff), own = 1u << (v & 31);
  if ((bits[v >> 5] & own) == 0) atomicOr(bits[v >> 5], own);
}
