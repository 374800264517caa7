/*
** rotate_one.h - rotation of one vector by z-turns between quarter turns, for the unit's element
** type.
*/
#ifndef YLM_SH_ROTATE_ONE_H
#define YLM_SH_ROTATE_ONE_H

#include "ylm_real.h"

#define NUMBER real
#define STRAIGHT(name) one_##name
#define ANGLE(c, m) (c)[m]
#include "rotate.h"
#include "rotate_straight.h"

/* Numbers in 64 bytes, and the tables of the element type. */
#define FULL (64 / (int)sizeof(real))
#ifdef YLM_REAL_IS_FLOAT
#define PACKED packed_f
#define PANELS panels_f
#else
#define PACKED packed_d
#define PANELS panels_d
#endif

/* Cosines and sines of m times an angle, in class order: c[0][k] of 2k, c[1][k] of 2k+1. */
static void angle_table(int lmax, double c1, double s1, int row, real *c, real *s) {
  double cm = 1, sm = 0;
  for (int m = 0; m <= lmax; m++) {
    c[(m & 1) * row + m / 2] = (real)cm;
    s[(m & 1) * row + m / 2] = (real)sm;
    double next = cm * c1 - sm * s1;
    sm = cm * s1 + sm * c1;
    cm = next;
  }
}

/* x = Z x for one degree in class order. */
YLM_INLINE void turn(int row, int table_row, const real *c, const real *s, real *x) {
  for (int parity = 0; parity < 2; parity++) {
    real *a = x + 2 * parity * row, *b = a + row;
    const real *cp = c + parity * table_row, *sp = s + parity * table_row;
    for (int k = 0; k < row; k += LANES) {
      vreal ck = vreal_load(cp + k), sk = vreal_load(sp + k), ak = vreal_load(a + k),
            bk = vreal_load(b + k);
      vreal_store(a + k, ck * ak - sk * bk);
      vreal_store(b + k, sk * ak + ck * bk);
    }
  }
}

/* y = J x for one degree in class order. */
YLM_INLINE void quarter(int l, int row, const real *j, const real *x, real *y) {
  for (int c = 0; c < 4; c++) {
    int columns = class_columns(l, c), to = class_partner(l, c);
    for (int k = 0; k < row; k += LANES) {
      vreal even = vreal_set(0), odd = vreal_set(0);
      int i = 0;
      for (; i + 1 < columns; i += 2) {
        even += vreal_load(j + i * row + k) * vreal_set(x[c * row + i]);
        odd += vreal_load(j + (i + 1) * row + k) * vreal_set(x[c * row + i + 1]);
      }
      if (i < columns) even += vreal_load(j + i * row + k) * vreal_set(x[c * row + i]);
      vreal_store(y + to * row + k, even + odd);
    }
    j += columns * row;
  }
}

/* x = H x for one degree in class order. */
static void half(int l, int row, real *x) {
  for (int c = 0; c < 4; c++)
    for (int k = 0; k < row; k++) {
      int m = 2 * k + (c > 1);
      if (half_turn_sign(l, c & 1 ? -m : m) < 0) x[c * row + k] = -x[c * row + k];
    }
}

#define TABLE ((YLM_SH_ROTATE_LMAX / 2 + 1 + ROTATE_PAD) / ROTATE_PAD * ROTATE_PAD)

/* Degrees first .. lmax of one vector: g = Z(a) J Z(b) J Z(c) f, degree by degree; g may be f. */
static void degrees(const ylm_sh_rotator *p, int first, int lmax, const ylm__angles *a,
                    const real *f, real *g) {
  real c[3][2 * TABLE] __attribute__((aligned(64))), s[3][2 * TABLE] __attribute__((aligned(64)));
  real x[4 * TABLE] __attribute__((aligned(64))), y[4 * TABLE] __attribute__((aligned(64)));
  int last = rotate_row(lmax);
  for (int i = a->turn == TURN_FLAT ? 2 : 0; i < 3; i++) {
    memset(c[i], 0, 2 * (size_t)last * sizeof(real));
    memset(s[i], 0, 2 * (size_t)last * sizeof(real));
    angle_table(lmax, a->c[i], a->s[i], last, c[i], s[i]);
  }
  for (int l = first; l <= lmax; l++) {
    int row = rotate_row(l);
    const real *fl = f + l * (l + 1);
    real *gl = g + l * (l + 1);
    memset(x, 0, 4 * (size_t)row * sizeof(real));
    x[0] = fl[0];
    for (int m = 1; m <= l; m++) {
      real *at = x + 2 * (m & 1) * row + m / 2;
      at[0] = fl[m];
      at[row] = fl[-m];
    }
    turn(row, last, c[2], s[2], x);
    switch (a->turn) {
    case TURN_FLAT: break;
    case TURN_HALF:
      half(l, row, x);
      turn(row, last, c[0], s[0], x);
      break;
    case TURN_QUARTER:
      memcpy(y, x, 4 * (size_t)row * sizeof(real));
      quarter(l, row, p->PACKED + p->packed_at[l], y, x);
      turn(row, last, c[0], s[0], x);
      break;
    default:
      quarter(l, row, p->PACKED + p->packed_at[l], x, y);
      turn(row, last, c[1], s[1], y);
      quarter(l, row, p->PACKED + p->packed_at[l], y, x);
      turn(row, last, c[0], s[0], x);
    }
    gl[0] = x[0];
    for (int m = 1; m <= l; m++) {
      const real *at = x + 2 * (m & 1) * row + m / 2;
      gl[m] = at[0];
      gl[-m] = at[row];
    }
  }
}

/* Degrees 0 .. lmax, a constant, by straight-line code. cs: cosine and sine of a+pi, b+pi, c. */
YLM_INLINE void one_low(const int lmax, const real *restrict cs, const real *restrict f,
                        real *restrict g) {
  real c[3][ROTATE_LOW + 1], s[3][ROTATE_LOW + 1], x[ROTATE_WIDEST];
#pragma GCC unroll 3
  for (int i = 0; i < 3; i++) {
    c[i][1] = cs[2 * i], s[i][1] = cs[2 * i + 1];
#pragma GCC unroll 6
    for (int m = 2; m <= lmax; m++) {
      const int a = m / 2, b = m - a;
      c[i][m] = c[i][a] * c[i][b] - s[i][a] * s[i][b];
      s[i][m] = c[i][a] * s[i][b] + s[i][a] * c[i][b];
    }
  }
  g[0] = f[0];
#pragma GCC unroll 6
  for (int l = 1; l <= lmax; l++) {
    one_about(l, c[2], s[2], f + l * l, x);
    one_rest(l, c[0], s[0], c[1], s[1], x, g + l * l);
  }
}

#define ONE_LOW(lmax)                                                                              \
  static void one_low_##lmax(const real *restrict cs, const real *restrict f, real *restrict g) {  \
    one_low(lmax, cs, f, g);                                                                       \
  }
ONE_LOW(0)
ONE_LOW(1)
ONE_LOW(2)
ONE_LOW(3)
ONE_LOW(4)
ONE_LOW(5)
ONE_LOW(6)
static void (*const one_lows[ROTATE_LOW + 1])(const real *restrict, const real *restrict,
                                              real *restrict) = {
    one_low_0, one_low_1, one_low_2, one_low_3, one_low_4, one_low_5, one_low_6};

/* One vector. */
static void one(const ylm_sh_rotator *p, int lmax, const ylm__angles *a, const real *f, real *g) {
  if (a->turn == TURN_GENERAL && lmax <= ROTATE_LOW) {
    const real cs[6] = {(real)a->c[0], (real)a->s[0], (real)a->c[1],
                        (real)a->s[1], (real)a->c[2], (real)a->s[2]};
    one_lows[lmax](cs, f, g);
    return;
  }
  degrees(p, 0, lmax, a, f, g);
}

#endif
