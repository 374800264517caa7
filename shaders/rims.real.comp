/*
** rims.real.comp - exact polygons and disks: the moments along their rims that csrc/light/flat/kernel.h describes. In
** double throughout, as on the processor, where edges cancel; points and sums are floats or doubles.
**
** A group has one point, one chunk of arcs and one slice of at most 64 harmonics, a sum of each kind and axis an invocation.
** Rounds: 32 invocations find an arc each; all find a node of these each; 16 nodes at a time, harmonics go through shared
** memory to the invocations that sum them. A rim that is too near for equal steps comes in panels, one a round. Ends
** that a horizon cuts add to Hessians in rounds of their own.
*/
#version 450
#extension GL_GOOGLE_include_directive : require
#ifdef YLM_DOUBLE
#define stored double
#else
#define stored float
#define YLM_DOUBLE
#endif
#include "ylm.glsl"

#define LMAX_IS_PUSHED /* drivers take seconds to compile this kernel: once for every lmax */
#include "lamps.glsl"
layout(constant_id = 2) const uint KINDS = 1;
layout(constant_id = 6) const bool CUT = false;  /* lights have horizons */
layout(constant_id = 7) const bool FINE = false; /* sums to 1e-16; else 1e-10 */

/* order, first degree, one beyond the last, first slot: cosines, then sines; as many an item as there may be */
layout(set = 0, binding = 4) readonly buffer Runs { uvec4 run[]; };
layout(set = 0, binding = 5) readonly buffer Betas { double beta[]; }; /* [m][l] */
layout(set = 0, binding = 6) readonly buffer Rules { double rule[]; }; /* [..]: nodes, reaches (fine, rough), places, weights */
layout(set = 0, binding = 7) readonly buffer Arcs { uvec2 arc_at[]; }; /* row of a light, edge; behind the last: along the horizon */

#define RUNS 10u
#define ARCS 32u
#define AT_ONCE 16u
#define SLOTS 64u
#define RULES 21u
#define MOST_NODES 96u
#define RULE_ROW (3u + 2u * MOST_NODES)
#define STEPS 96u

/* Sums of a kind and axis, and where they begin among an axis's; all of an axis. */
uint width(uint kind) { return (KINDS >> kind & 1) != 0 ? (LMAX + kind) * (LMAX + kind) : 0; }
uint offset(uint kind) { return (kind > 0 ? width(0) : 0) + (kind > 1 ? width(1) : 0); }
uint all_sums() { return offset(2) + width(2); }

#include "gen/rim.glsl"
#include "rims_seen.glsl"

shared uint begins[ARCS + 1u], left;
shared double direction[3][SLOTS], moment[3][SLOTS], inverse[SLOTS]; /* of nodes */
shared double harmonic[AT_ONCE * (SLOTS + 1u)];

double sum[9], cut[6];

/* Node `at` of all arcs, to place t; of cuts, that of arc `at`. */
void find_node(uint at, uint t, bool cutting) {
  node n;
  double weight = 0;
  n.s = rvec3(0, 0, 1), n.m = rvec3(0), n.inverse = 0;
  if (CUT && cutting) {
    if (at < ARCS && begins[at + 1] > begins[at]) n = node_of(at, 0, weight);
  } else if (at < begins[ARCS]) {
    uint a = 0;
    for (uint step = ARCS / 2; step > 0; step /= 2)
      if (begins[a + step] <= at) a += step;
    n = node_of(a, at - begins[a], weight);
    omega += weight * n.angle;
  }
  for (int i = 0; i < 3; i++) direction[i][t] = n.s[i], moment[i][t] = weight * n.m[i];
  inverse[t] = n.inverse;
}

/* Harmonics at AT_ONCE nodes from `from` on: invocations share the runs of a node. */
void find_harmonics(uint from, uint t) {
  uint n = t % AT_ONCE;
  rvec3 s = rvec3(direction[0][from + n], direction[1][from + n], direction[2][from + n]);
  for (uint r = t / AT_ONCE; r < RUNS; r += gl_WorkGroupSize.x / AT_ONCE) {
    uvec4 own = run[which * RUNS + r];
    if (own.z == 0) continue;
    double c = 1, i = 0, q = 1, before = 0;
    for (uint m = 0; m < own.x; m++) next_power(s.x, s.y, c, i, c, i);
    uint to = n * (SLOTS + 1) + own.w;
    for (uint l = own.x; l < own.z; l++) {
      if (l >= own.y) {
        harmonic[to] = c * q;
        if (own.x > 0) harmonic[to + own.z - own.y] = i * q;
        to++;
      }
      double above = rise(beta[own.x * (LMAX + 2) + l], s.z, q, before);
      before = q, q = above;
    }
  }
}

void add_nodes(uint from, uint t, bool cutting) {
  for (uint n = 0; n < AT_ONCE; n++) {
    double y = harmonic[n * (SLOTS + 1) + t];
    rvec3 m = rvec3(moment[0][from + n], moment[1][from + n], moment[2][from + n]);
    if (CUT && cutting) {
      if (begins[from + n + 1] == begins[from + n]) continue;
      rvec3 up = rvec3(arcs[6][from + n], arcs[7][from + n], arcs[8][from + n]);
      cut[0] += y * 2 * m.x * up.x, cut[1] += y * (m.x * up.y + m.y * up.x), cut[2] += y * (m.x * up.z + m.z * up.x);
      cut[3] += y * 2 * m.y * up.y, cut[4] += y * (m.y * up.z + m.z * up.y), cut[5] += y * 2 * m.z * up.z;
      continue;
    }
    for (int k = 0; k < 3; k++) {
      if ((KINDS >> k & 1) != 0)
        for (int a = 0; a < 3; a++) sum[3 * k + a] += m[a] * y;
      y *= inverse[from + n];
    }
  }
}

/* Sums of slot t. */
void store(uint t) {
  for (uint r = 0; r < RUNS; r++) {
    uvec4 own = run[which * RUNS + r];
    uint degrees = own.z - own.y, slots = own.x > 0 ? 2 * degrees : degrees;
    if (own.z == 0 || t < own.w || t >= own.w + slots) continue;
    bool sine = t >= own.w + degrees;
    uint l = own.y + (t - own.w) % degrees, j = sine ? l * (l + 1) - own.x : l * (l + 1) + own.x;
    for (uint k = 0; k < 3; k++)
      for (uint a = 0; a < 3 && (KINDS >> k & 1) != 0 && l + 1 <= LMAX + k; a++)
        partial[store_at + (parts + a * all_sums() + offset(k) + j) * stride] = stored(sum[3 * k + a]);
    for (uint q = 0; q < 6 && CUT && (KINDS & 4) != 0 && l <= LMAX; q++)
      partial[store_at + (parts + 3 * all_sums() + 1 + q * (LMAX + 1) * (LMAX + 1) + j) * stride] = stored(cut[q]);
  }
}

void main() {
  uint group = ylm_group(first), t = gl_LocalInvocationID.x, i = group % points;
  uint row = group / points / items, channel = channel_first + row / chunks;
  which = group / points % items;
  uint begin = (chunk_first + row % chunks) * chunk, end = min(begin + chunk, lamps);
  rvec3 at = rvec3(point[3 * i], point[3 * i + 1], point[3 * i + 2]);
  for (int k = 0; k < 9; k++) sum[k] = 0;
  for (int k = 0; k < 6; k++) cut[k] = 0;
  omega = 0;
  for (uint tile_first = begin; tile_first < end; tile_first += ARCS) {
    bool owner = t < ARCS && tile_first + t < end, more = owner, cutting = false;
    panel = uvec2(0);
    for (;;) {
      uint nodes = 0;
      if (more) nodes = find_arc(at, arc_at[tile_first + t], channel, t, cutting, i, more);
      if (t == 0) left = 0;
      if (t < ARCS) begins[t + 1] = nodes;
      barrier();
      if (more) left = 1;
      if (t == 0) {
        begins[0] = 0;
        for (uint k = 0; k < ARCS; k++) begins[k + 1] += begins[k];
      }
      barrier();
      uint all = cutting && begins[ARCS] > 0 ? ARCS : begins[ARCS];
      bool again = left != 0;
      for (uint base = 0; base < all; base += SLOTS) {
        find_node(base + t, t, cutting);
        barrier();
        for (uint from = 0; from < SLOTS && base + from < all; from += AT_ONCE) {
          find_harmonics(from, t);
          barrier();
          add_nodes(from, t, cutting);
          barrier();
        }
      }
      barrier();
      if (again) continue;
      if (!CUT || (KINDS & 4) == 0 || cutting) break;
      cutting = true;
      more = owner;
    }
  }
  harmonic[t] = omega;
  barrier();
  store_at = row * sums * stride + i;
  store(t);
  if (which == 0 && t == 0) {
    for (uint k = 1; k < gl_WorkGroupSize.x; k++) omega += harmonic[k];
    partial[store_at + (parts + 3 * all_sums()) * stride] = stored(omega);
  }
}
