/*
** special.h - sums of the moment kernel of one lmax, by its plans; see moments.h. Private to csrc/light.
**
** gen/moments_L.h, which is included before, defines LMAX. For each set of kinds s it defines the
** plans PLAN_s and PLAN_RGB_s, in the words below: passes over a tile, and the columns that share
** the registers in each.
*/
#ifndef YLM_LIGHT_MOMENTS_SPECIAL_H
#define YLM_LIGHT_MOMENTS_SPECIAL_H

#include "kernel.h"

/* X(0) .. X(n-1). */
#define EACH_1(X) X(0)
#define EACH_2(X) EACH_1(X) X(1)
#define EACH_3(X) EACH_2(X) X(2)
#define EACH_4(X) EACH_3(X) X(3)
#define EACH_5(X) EACH_4(X) X(4)
#define EACH_6(X) EACH_5(X) X(5)
#define EACH_7(X) EACH_6(X) X(6)
#define EACH_8(X) EACH_7(X) X(7)
#define EACH_9(X) EACH_8(X) X(8)
#define EACH_10(X) EACH_9(X) X(9)
#define EACH_11(X) EACH_10(X) X(10)
#define EACH_12(X) EACH_11(X) X(11)
#define EACH_13(X) EACH_12(X) X(12)
#define EACH_14(X) EACH_13(X) X(13)
#define EACH_15(X) EACH_14(X) X(14)
#define EACH_16(X) EACH_15(X) X(15)
#define EACH_17(X) EACH_16(X) X(16)
#define EACH_18(X) EACH_17(X) X(17)
#define EACH_19(X) EACH_18(X) X(18)
#define EACH_20(X) EACH_19(X) X(19)
#define EACH_21(X) EACH_20(X) X(20)
#define EACH_22(X) EACH_21(X) X(21)
#define EACH_23(X) EACH_22(X) X(22)
#define EACH_24(X) EACH_23(X) X(23)

/*
** The parts of plans; all is written out, since the compiler takes far longer to unroll loops.
** A pass over a tile keeps `count` sums of each channel in a, from `first` on: channel by channel
** in memory, together in a. COLUMN begins the column (m, side), side 0 the real and 1 the imaginary
** part, and RESUME goes on with what CUT left in `state`. SIDES runs the passes of one column for
** either side, whose sums are `apart`. ADD_s adds the products of degree k for the kinds of s to
** the sums from i on; UP takes the polynomial q from degree k to k+1.
*/
#define SIDES(apart) for (int side = 0; side < 2; side++, sums += (apart)) {
#define END_SIDES                                                                                  \
  }                                                                                                \
  sums = all;
#define PASS(first, count)                                                                         \
  {                                                                                                \
    vreal *total = sums + (first), a[CHANNELS * (count)], q, before;                               \
    EACH_##count(TAKE);                                                                            \
    for (int j = 0; j < n; j++) {                                                                  \
      const vreal *g = geometry + j * GEOMETRY_SLOTS, z = g[0], low = g[GEOMETRY_SLOTS - 1];       \
      const vreal *w = weights + j * WEIGHT_SLOTS, *e = emission + 3 * j;                          \
      vreal *saved = state + 2 * j;                                                                \
      (void)saved, (void)e, (void)z, (void)low;
#define COLUMN(m, side) q = (m) == 0 ? (vreal){0} + 1 : g[2 * (m)-1 + (side)], before = (vreal){0};
#define RESUME q = saved[0], before = saved[1];
#define CUT saved[0] = q, saved[1] = before;
#define UP(k, m)                                                                                   \
  if ((m) < FINE(LMAX)) {                                                                          \
    before *= SLOW(k, m);                                                                          \
    TOGETHER(before, q);                                                                           \
    before -= low * q;                                                                             \
    q = KEEP(k, m) * q + before;                                                                   \
  } else {                                                                                         \
    vreal next = (k) == 0 ? z : (k) == (m) ? z * q : rise(BETA(k, m), z, q, before);               \
    before = q, q = next;                                                                          \
  }
#define ADD_1(i, k) ADD(i, w[k])
#define ADD_2(i, k) ADD(i, w[LMAX + 1 + (k)])
#define ADD_3(i, k) ADD_1(i, k) ADD_2(i + 1, k)
#define ADD_4(i, k) ADD(i, w[2 * LMAX + 3 + (k)])
#define ADD_5(i, k) ADD_1(i, k) ADD_4(i + 1, k)
#define ADD_6(i, k) ADD_2(i, k) ADD_4(i + 1, k)
#define ADD_7(i, k) ADD_1(i, k) ADD_2(i + 1, k) ADD_4(i + 2, k)
#define END(count)                                                                                 \
  (void)before;                                                                                    \
  }                                                                                                \
  EACH_##count(GIVE);                                                                              \
  }

#define CHANNELS 1
#define TAKE(i) a[i] = total[i];
#define GIVE(i) total[i] = a[i];
#define ADD(i, weight) a[i] += q * weight;
#define SUM(set)                                                                                   \
  static void sum_##set(int n, const vreal *geometry, const vreal *weights, vreal *state,          \
                        vreal *all) {                                                              \
    const vreal *emission = NULL;                                                                  \
    vreal *sums = all;                                                                             \
    PLAN_##set                                                                                     \
  }
YLM__KIND_SETS(SUM)
#undef CHANNELS
#undef TAKE
#undef GIVE
#undef ADD
#undef SUM

#define CHANNELS 3
#define TAKE(i)                                                                                    \
  a[3 * i] = total[i], a[3 * i + 1] = total[stride + i], a[3 * i + 2] = total[2 * stride + i];
#define GIVE(i)                                                                                    \
  total[i] = a[3 * i], total[stride + i] = a[3 * i + 1], total[2 * stride + i] = a[3 * i + 2];
#define ADD(i, weight)                                                                             \
  {                                                                                                \
    vreal term = q * weight;                                                                       \
    a[3 * (i)] += e[0] * term, a[3 * (i) + 1] += e[1] * term, a[3 * (i) + 2] += e[2] * term;       \
  }
#define SUM(set)                                                                                   \
  static void sum_rgb_##set(int n, const vreal *geometry, const vreal *weights,                    \
                            const vreal *emission, vreal *state, vreal *all, int stride) {         \
    vreal *sums = all;                                                                             \
    PLAN_RGB_##set                                                                                 \
  }
YLM__KIND_SETS(SUM)
#undef CHANNELS
#undef TAKE
#undef GIVE
#undef ADD
#undef SUM
#undef SIDES
#undef END_SIDES
#undef PASS
#undef COLUMN
#undef RESUME
#undef CUT
#undef UP
#undef ADD_1
#undef ADD_2
#undef ADD_3
#undef ADD_4
#undef ADD_5
#undef ADD_6
#undef ADD_7
#undef END

static void sum(int lmax, int kinds, int n, const void *geometry, const void *weights, void *state,
                void *sums) {
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set) sum_##set(n, geometry, weights, state, sums);
  YLM__KIND_SETS(X)
#undef X
}

static void sum_rgb(int lmax, int kinds, int n, const void *geometry, const void *weights,
                    const void *emission, void *state, void *sums, int stride) {
  (void)lmax;
#define X(set)                                                                                     \
  if (kinds == set) sum_rgb_##set(n, geometry, weights, emission, state, sums, stride);
  YLM__KIND_SETS(X)
#undef X
}

YLM__MOMENT_KERNEL

#endif
