/*
** Radiance of shading points under a grid: its interpolant, dotted with transfer vectors, and what materials make of it. A group has
** CHUNK points in the order of cells, an invocation for each; a cell's numbers (10 kB at lmax 4 in rgb) are read into
** shared memory once for the run of points in it. shaders/gen/interpolation.glsl has the 32 weights of the corners.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"
#include "grid.glsl"

layout(constant_id = 2) const uint CHANNELS = 3;
layout(constant_id = 5) const bool MATERIAL = false;

PUSH {
  uint first;
  uint n, spread, stride, part_rows, given, row, count; /* coefficients of a channel, of a transfer vector, of both */
  float unit[3];
};

#include "grid_data.glsl"

layout(set = 0, binding = 7) readonly buffer Transfer { float transfer[]; };  /* [n][row] */
layout(set = 0, binding = 8) readonly buffer Material { float material[]; };  /* [n][3]: rows of matte ones */
layout(set = 0, binding = 9) writeonly buffer Radiance { float radiance[]; }; /* [n][3] */

/* Fours of numbers of a coefficient; coefficients in shared memory at once. */
const uint FOURS = INTERPOLATION == 2 ? 2 : 8, PITCH = FOURS + 1, TILE = 80;
const uint MANY = 4; /* runs of a group: with more of them each invocation reads its own cell's numbers */

shared vec4 corners[TILE * PITCH];
float weight[32];

#include "grid_weights.glsl"
#include "gen/material.glsl"

/* Numbers begin .. begin+tile-1 of a cell, of all channels after one another, to shared memory. */
void load(uint k, uint begin, uint tile) {
  for (uint q = gl_LocalInvocationID.x; q < tile * FOURS * 4; q += CHUNK) {
    uint r = q / tile, at = q - r * tile, j = begin + at;
    corners[at * PITCH + r / 4][r % 4] = grid_data(cell[k].corner[r & 7], r >> 3, j / count * given + j % count);
  }
}

/* A point's radiance without shared memory, row by row of the cell's corners. */
vec3 directly(uint k, vec4 w[FOURS], uint at) {
  vec3 sum = vec3(0.0);
  for (uint r = 0; r < FOURS * 4; r++) {
    uint corner = cell[k].corner[r & 7];
    for (uint j = 0; j < count; j++) {
      float x = w[r / 4][r % 4] * transfer[at + j];
      for (uint c = 0; c < CHANNELS; c++) sum[c] += x * grid_data(corner, r >> 3, c * given + j);
    }
  }
  return sum;
}

void main() {
  uint lane = gl_LocalInvocationID.x, i, all = CHANNELS * count;
  uvec4 x = find(chunk(ylm_group(first)), lane, i);
  bool here = x.x != NONE;
  vec4 w[FOURS];
  vec3 sum = vec3(0.0);
  if (here) {
    weights(0, 0, x.x & ~AWAY, uintBitsToFloat(x.yzw));
    for (uint r = 0; r < FOURS; r++) w[r] = vec4(weight[4 * r], weight[4 * r + 1], weight[4 * r + 2], weight[4 * r + 3]);
  }
  barrier();
  bool many = runs() > MANY;
  if (many && here) sum = directly(x.x & ~AWAY, w, i * row);
  for (uint from = 0, to; !many && from < CHUNK; from = to) {
    to = end_of_run(from);
    uint k = cell_of[from];
    if (k == NONE) continue;
    for (uint begin = 0; begin < all; begin += TILE) {
      uint tile = min(TILE, all - begin);
      barrier();
      load(k, begin, tile);
      barrier();
      for (uint at = 0; lane >= from && lane < to && at < tile; at++) {
        uint c = (begin + at) / count;
        vec4 L = w[0] * corners[at * PITCH];
        for (uint r = 1; r < FOURS; r++) L += w[r] * corners[at * PITCH + r];
        sum[c] += transfer[i * row + begin + at - c * count] * (L.x + L.y + L.z + L.w);
      }
    }
  }
  if (!here) return;
  for (uint c = 0; c < 3; c++) {
    float s = sum[CHANNELS == 1 ? 0 : c];
    radiance[3 * i + c] = MATERIAL ? matte_radiance(s, material[3 * i + c]) : s;
  }
}
