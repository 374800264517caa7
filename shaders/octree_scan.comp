/*
** Prefix sums of f(x[i]): the sum of all before i. By blocks of 1024: phase 0 sums each block, phase 1 adds up from
** where its block begins; the blocks' sums have been scanned in between, by the same kernel. In place where x is the
** result. The sum of all goes to count[slot].
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

layout(constant_id = 1) const uint KIND = 0;  /* f: 0 x itself, 1 its bits under `mask`, 2 whether entry i is its own */
layout(constant_id = 2) const uint PHASE = 0;

#include "gen/layout.glsl"

const uint LANES = SCAN_LANES, EACH = SCAN_EACH, FRESH = 0x80000000, NOWHERE = 0xffffffff;

layout(set = 0, binding = 0) buffer X { uint x[]; };
layout(set = 0, binding = 1) buffer Before { uint before[]; };
layout(set = 0, binding = 2) buffer Blocks { uint block[]; };
layout(set = 0, binding = 3) buffer Counts { uint count[]; };

PUSH {
  uint first;
  uint n, mask, blocks; /* blocks 1: `block` is not read */
  uint slot;            /* NOWHERE: the sum is not wanted */
};

shared uint part[LANES];

uint f(uint i) {
  uint v = i < n ? x[i] : 0;
  if (KIND == 1) return bitCount(v & mask);
  if (KIND == 2) return i < n && v == (FRESH | i) ? 1 : 0;
  return v;
}

void main() {
  uint group = ylm_group(first), lane = gl_LocalInvocationID.x, begin = group * LANES * EACH + lane * EACH, sum = 0;
  uint v[EACH];
  for (uint k = 0; k < EACH; k++) {
    v[k] = f(begin + k);
    sum += v[k];
  }
  part[lane] = sum;
  barrier();
  if (PHASE == 0) {
    if (lane != 0) return;
    for (uint q = 1; q < LANES; q++) sum += part[q];
    block[group] = sum;
    return;
  }
  sum = blocks > 1 ? block[group] : 0;
  for (uint q = 0; q < lane; q++) sum += part[q];
  for (uint k = 0; k < EACH && begin + k < n; k++) {
    before[begin + k] = sum;
    sum += v[k];
    if (begin + k == n - 1 && slot != NOWHERE) count[slot] = sum;
  }
}
