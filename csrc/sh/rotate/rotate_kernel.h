/* rotate_kernel.h - the kernels of rotate.isa.c for one element type; included twice. */

#include "../gen/rotate_low.h"

/* Cosines and sines of m times an angle, in class order: c[0][k] of 2k, c[1][k] of 2k+1. */
static void FN(angle_table)(int lmax, double c1, double s1, int row, T *c, T *s) {
  double cm = 1, sm = 0;
  for (int m = 0; m <= lmax; m++) {
    c[(m & 1) * row + m / 2] = (T)cm;
    s[(m & 1) * row + m / 2] = (T)sm;
    double next = cm * c1 - sm * s1;
    sm = cm * s1 + sm * c1;
    cm = next;
  }
}

/* x = Z x for one degree in class order. */
YLM_INLINE void FN(turn)(int row, int table_row, const T *c, const T *s, T *x) {
  for (int parity = 0; parity < 2; parity++) {
    T *a = x + 2 * parity * row, *b = a + row;
    const T *cp = c + parity * table_row, *sp = s + parity * table_row;
    for (int k = 0; k < row; k += LANES) {
      V ck = LOAD(cp + k), sk = LOAD(sp + k), ak = LOAD(a + k), bk = LOAD(b + k);
      STORE(a + k, ck * ak - sk * bk);
      STORE(b + k, sk * ak + ck * bk);
    }
  }
}

/* y = J x for one degree in class order. */
YLM_INLINE void FN(quarter)(int l, int row, const T *j, const T *x, T *y) {
  for (int c = 0; c < 4; c++) {
    int columns = class_columns(l, c), to = class_partner(l, c);
    for (int k = 0; k < row; k += LANES) {
      V even = SET(0), odd = SET(0);
      int i = 0;
      for (; i + 1 < columns; i += 2) {
        even += LOAD(j + i * row + k) * SET(x[c * row + i]);
        odd += LOAD(j + (i + 1) * row + k) * SET(x[c * row + i + 1]);
      }
      if (i < columns) even += LOAD(j + i * row + k) * SET(x[c * row + i]);
      STORE(y + to * row + k, even + odd);
    }
    j += columns * row;
  }
}

/* x = H x for one degree in class order. */
static void FN(half)(int l, int row, T *x) {
  for (int c = 0; c < 4; c++)
    for (int k = 0; k < row; k++) {
      int m = 2 * k + (c > 1);
      if (half_turn_sign(l, c & 1 ? -m : m) < 0) x[c * row + k] = -x[c * row + k];
    }
}

#define TABLE ((YLM_SH_ROTATE_LMAX / 2 + 1 + ROTATE_PAD) / ROTATE_PAD * ROTATE_PAD)

/* Degrees first .. lmax of one vector: g = Z(a) J Z(b) J Z(c) f, degree by degree; g may be f. */
static void FN(degrees)(const ylm_sh_rotator *p, int first, int lmax, const ylm__angles *a,
                        const T *f, T *g) {
  T c[3][2 * TABLE] __attribute__((aligned(64))), s[3][2 * TABLE] __attribute__((aligned(64)));
  T x[4 * TABLE] __attribute__((aligned(64))), y[4 * TABLE] __attribute__((aligned(64)));
  int last = rotate_row(lmax);
  for (int i = a->turn == TURN_FLAT ? 2 : 0; i < 3; i++) {
    memset(c[i], 0, 2 * (size_t)last * sizeof(T));
    memset(s[i], 0, 2 * (size_t)last * sizeof(T));
    FN(angle_table)(lmax, a->c[i], a->s[i], last, c[i], s[i]);
  }
  for (int l = first; l <= lmax; l++) {
    int row = rotate_row(l);
    const T *fl = f + l * (l + 1);
    T *gl = g + l * (l + 1);
    memset(x, 0, 4 * (size_t)row * sizeof(T));
    x[0] = fl[0];
    for (int m = 1; m <= l; m++) {
      T *at = x + 2 * (m & 1) * row + m / 2;
      at[0] = fl[m];
      at[row] = fl[-m];
    }
    FN(turn)(row, last, c[2], s[2], x);
    switch (a->turn) {
    case TURN_FLAT: break;
    case TURN_HALF:
      FN(half)(l, row, x);
      FN(turn)(row, last, c[0], s[0], x);
      break;
    case TURN_QUARTER:
      memcpy(y, x, 4 * (size_t)row * sizeof(T));
      FN(quarter)(l, row, p->PACKED + p->packed_at[l], y, x);
      FN(turn)(row, last, c[0], s[0], x);
      break;
    default:
      FN(quarter)(l, row, p->PACKED + p->packed_at[l], x, y);
      FN(turn)(row, last, c[1], s[1], y);
      FN(quarter)(l, row, p->PACKED + p->packed_at[l], y, x);
      FN(turn)(row, last, c[0], s[0], x);
    }
    gl[0] = x[0];
    for (int m = 1; m <= l; m++) {
      const T *at = x + 2 * (m & 1) * row + m / 2;
      gl[m] = at[0];
      gl[-m] = at[row];
    }
  }
}
#undef TABLE

/* One vector. */
static void FN(one)(const ylm_sh_rotator *p, int lmax, const ylm__angles *a, const T *f, T *g) {
  if (a->turn == TURN_GENERAL && lmax <= ROTATE_LOW) {
    const T cs[6] = {(T)a->c[0], (T)a->s[0], (T)a->c[1], (T)a->s[1], (T)a->c[2], (T)a->s[2]};
    FN(rotate_low)[lmax](cs, f, g);
    return;
  }
  FN(degrees)(p, 0, lmax, a, f, g);
}
