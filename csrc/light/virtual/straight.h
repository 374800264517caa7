/*
** straight.h - sums over virtual lights, degree by degree, for the unit's element type; plan.h has what is summed.
**
** gen/degrees.h, which is included before, has the sums of each degree in the words below: passes
** over a tile of lights, and the rows whose sums share the registers in each. Private to the
** folder.
*/
#ifndef YLM_LIGHT_VIRTUAL_STRAIGHT_H
#define YLM_LIGHT_VIRTUAL_STRAIGHT_H

#include "plan.h"
#include "ylm_real.h"

/* -- harmonics ------------------------------------------------------------------------------ */

#define RISE(at, below, under, l, m)                                                               \
  t[at] = (real)((2.0 * (l)-1) / (((l) + (m)) * ((l) - (m)))) * z * t[below] -                     \
          (real)(1.0 / (((l) + (m)) * ((l) - (m)))) * t[under];
#define TURN(c, s, c0, s0, l)                                                                      \
  t[c] = (x * t[c0] - y * t[s0]) * (real)(0.5 / (l));                                              \
  t[s] = (x * t[s0] + y * t[c0]) * (real)(0.5 / (l));
#define UPTO(l)                                                                                    \
  if (top < (l)) return;

YLM_INLINE void one_harmonics(int top, vreal x, vreal y, vreal z, vreal *t) { HARMONICS }

static void harmonics(int top, int n, const void *directions, size_t step, void *to, size_t width) {
  const vreal *w = directions;
  vreal *t = to;
  for (int j = 0; j < n; j++, w += step, t += width) one_harmonics(top, w[0], w[1], w[2], t);
}
#undef UPTO

/* -- passes --------------------------------------------------------------------------------- */

/* A pass has sums of `count` rows in a, from row `first` on; t, e: harmonics and factors of light j. */
#define PASS(first, count)                                                                         \
  {                                                                                                \
    vreal *to = sums + WIDE * (first), a[WIDE * (count)];
#define LIGHTS                                                                                     \
  for (int j = 0; j < n; j++) {                                                                    \
    const vreal *t = rows + (size_t)j * width, *e = t + factors;
#define DONE }
#define END }
#define CLOSE }
#define THREE(X, i, l, k) X(i, l, k, 0) X(i, l, k, 1) X(i, l, k, 2)
#define UPTO(l)                                                                                    \
  if (lmax < (l)) return;

#define SUM(name)                                                                                  \
  static void name(int lmax, int n, const void *lights, size_t width, size_t factors, void *all) { \
    const vreal *rows = lights;                                                                    \
    vreal *sums = all;

#define TAKE_3(i, k)                                                                               \
  a[WIDE * (i) + (k)] = to[WIDE * (i) + (k)], a[WIDE * (i) + (k) + 1] = to[WIDE * (i) + (k) + 1],  \
                 a[WIDE * (i) + (k) + 2] = to[WIDE * (i) + (k) + 2];
#define GIVE_3(i, k)                                                                               \
  to[WIDE * (i) + (k)] = a[WIDE * (i) + (k)], to[WIDE * (i) + (k) + 1] = a[WIDE * (i) + (k) + 1],  \
                  to[WIDE * (i) + (k) + 2] = a[WIDE * (i) + (k) + 2];

/* Values: sums [row][3]; factors: colours [3], then those of degrees. */
#define WIDE 3
#define TAKE(i) TAKE_3(i, 0)
#define GIVE(i) GIVE_3(i, 0)
#define ROW(i, l, at)                                                                              \
  {                                                                                                \
    const vreal r = t[at] * e[3 + (l)];                                                            \
    THREE(VALUE, i, l, 0)
#define VALUE(i, l, k, c) a[3 * (i) + (c)] += r * e[c];
SUM(sum_values) VALUES
}
#undef WIDE
#undef TAKE
#undef GIVE
#undef ROW
#undef VALUE

/* Values and gradients: sums [row][12]; factors: the distance, then of degrees colours [3] and gradients. */
#define WIDE 12
#define TAKE(i) TAKE_3(i, 0) TAKE_3(i, 3) TAKE_3(i, 6) TAKE_3(i, 9)
#define GIVE(i) GIVE_3(i, 0) GIVE_3(i, 3) GIVE_3(i, 6) GIVE_3(i, 9)
#define ROW(i, l, at)                                                                              \
  {                                                                                                \
    const vreal r = t[at], far = r * e[0];                                                         \
    THREE(VALUE, i, l, 0)
#define COLOUR(l, c) e[1 + 12 * (l) + (c)]
#define VALUE(i, l, k, c) a[12 * (i) + (c)] += far * COLOUR(l, c);

/* Lights whose colours differ by a factor: the gradient of its logarithm [3]. */
#define TIMES(i, l, k, c) a[12 * (i) + 3 + 3 * (k) + (c)] += row * COLOUR(l, c);
#define SLOPE(i, l, k, X)                                                                          \
  {                                                                                                \
    const vreal row = r * e[4 + 12 * (l) + (k)] + (X);                                             \
    THREE(TIMES, i, l, k)                                                                          \
  }
#define FREE(i, l, k)                                                                              \
  {                                                                                                \
    const vreal row = r * e[4 + 12 * (l) + (k)];                                                   \
    THREE(TIMES, i, l, k)                                                                          \
  }
SUM(sum_one) GRADIENTS
}
#undef TIMES
#undef SLOPE
#undef FREE

/* Lights whose colours differ in more: the gradient's part along the harmonic, [3][3]. */
#define ALONG(i, l, k, c) a[12 * (i) + 3 + 3 * (k) + (c)] += r * e[4 + 12 * (l) + 3 * (k) + (c)];
#define ACROSS(i, l, k, c) a[12 * (i) + 3 + 3 * (k) + (c)] += across * COLOUR(l, c);
#define FREE(i, l, k) THREE(ALONG, i, l, k)
#define SLOPE(i, l, k, X)                                                                          \
  {                                                                                                \
    const vreal across = X;                                                                        \
    THREE(ALONG, i, l, k)                                                                          \
    THREE(ACROSS, i, l, k)                                                                         \
  }
SUM(sum_each) GRADIENTS
}
#undef WIDE
#undef TAKE
#undef GIVE

/* Second derivatives of what lights send alike in all directions: factors [k][3]. */
#define WIDE 1
#define TAKE(i) a[i] = to[i];
#define GIVE(i) to[i] = a[i];
#define BEND(i, at, k, kind) a[i] += t[at] * e[3 * (k) + (kind)];
#undef UPTO
#define UPTO(k)                                                                                    \
  if (lmax + 2 < (k)) return;
#define BENDS_OF(k)                                                                                \
  if ((k) <= lmax - 2) {                                                                           \
    BENDS_##k##_3                                                                                  \
  } else if ((k) <= lmax) {                                                                        \
    BENDS_##k##_2                                                                                  \
  } else {                                                                                         \
    BENDS_##k##_1                                                                                  \
  }
SUM(sum_bends) BENDS
}

extern const ylm__virtual_straight YLM_REAL_KERNEL(ylm__virtual_straight);
const ylm__virtual_straight YLM_REAL_KERNEL(ylm__virtual_straight) = {harmonics, sum_values,
                                                                      sum_one, sum_each, sum_bends};

#endif
