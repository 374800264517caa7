/*
** rotate_straight.h - degrees 1 .. ROTATE_LOW of a rotation by straight-line code: g = Z(a) J Z(b) J Z(c) f.
**
** Included once for numbers of one vector and once for lanes of rows: NUMBER is real or vreal, STRAIGHT(name) a function's name,
** ANGLE(c, m) the cosine or sine of m times an angle. The degree l is a constant, so that arrays are registers; those of a
** degree begin at m = -l.
*/
#include "../gen/rotate_quarters.h"

#define ROTATE_LOW 6
#define ROTATE_WIDEST (2 * ROTATE_LOW + 1)

/* y = Z x. */
YLM_INLINE void STRAIGHT(about)(const int l, const real *c, const real *s, const NUMBER *x,
                                NUMBER *y) {
  y[l] = x[l];
#pragma GCC unroll 16
  for (int m = 1; m <= l; m++) {
    y[l + m] = ANGLE(c, m) * x[l + m] - ANGLE(s, m) * x[l - m];
    y[l - m] = ANGLE(s, m) * x[l + m] + ANGLE(c, m) * x[l - m];
  }
}

YLM_INLINE void STRAIGHT(quarter)(const int l, const NUMBER *x, NUMBER *y) {
  if (l == 1) STRAIGHT(quarter_1)(x, y);
  if (l == 2) STRAIGHT(quarter_2)(x, y);
  if (l == 3) STRAIGHT(quarter_3)(x, y);
  if (l == 4) STRAIGHT(quarter_4)(x, y);
  if (l == 5) STRAIGHT(quarter_5)(x, y);
  if (l == 6) STRAIGHT(quarter_6)(x, y);
}

/* g = Z(a) J Z(b) J x. */
YLM_INLINE void STRAIGHT(rest)(const int l, const real *ca, const real *sa, const real *cb,
                               const real *sb, const NUMBER *x, NUMBER *g) {
  NUMBER y[ROTATE_WIDEST], z[ROTATE_WIDEST], w[ROTATE_WIDEST];
  STRAIGHT(quarter)(l, x, y);
  STRAIGHT(about)(l, cb, sb, y, z);
  STRAIGHT(quarter)(l, z, w);
  STRAIGHT(about)(l, ca, sa, w, g);
}

#undef NUMBER
#undef STRAIGHT
#undef ANGLE
