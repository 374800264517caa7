/* emission.h - jets of the light that virtual lights send, lane by lane, for the unit's element type. Private to
   the folder.

   A jet is 1, gradient, Hessian xx xy xz yy yz zz, of which `order` says how far it goes. */
#ifndef YLM_LIGHT_VIRTUAL_EMISSION_H
#define YLM_LIGHT_VIRTUAL_EMISSION_H

#include "distance.h"

enum { PARTS = YLM__VIRTUAL_PARTS };

/* A point as a light sees it: u, 1/D, n.u, the cosine and the normal, both 0 behind the light. */
typedef struct seen {
  vreal u[3], inverse, along, cosine, normal[3];
} seen;

/* Jets by v of P(u) = cosine B(u) from those of B by u. */
YLM_INLINE void turn(const seen *s, const int order, const vreal *B, vreal *E, const int step) {
  const vreal *u = s->u, *n = s->normal, *g = B + 1, *H = B + 4;
  E[0] = s->cosine * B[0];
  if (order < 1) return;
  vreal e[3], Hu[3], ue, uHu;
  for (int a = 0; a < 3; a++) e[a] = n[a] * B[0] + s->cosine * g[a];
  ue = u[0] * e[0] + u[1] * e[1] + u[2] * e[2];
  for (int a = 0; a < 3; a++) E[(1 + a) * step] = (u[a] * ue - e[a]) * s->inverse;
  if (order < 2) return;
  static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  vreal M[6], scale = s->inverse * s->inverse;
  for (int i = 0; i < 6; i++)
    M[i] = n[row[i]] * g[column[i]] + g[row[i]] * n[column[i]] + s->cosine * H[i];
  Hu[0] = M[0] * u[0] + M[1] * u[1] + M[2] * u[2];
  Hu[1] = M[1] * u[0] + M[3] * u[1] + M[4] * u[2];
  Hu[2] = M[2] * u[0] + M[4] * u[1] + M[5] * u[2];
  uHu = u[0] * Hu[0] + u[1] * Hu[1] + u[2] * Hu[2];
  for (int a = 0; a < 3; a++) Hu[a] += e[a];
  for (int i = 0; i < 6; i++) {
    int a = row[i], b = column[i];
    vreal x = M[i] - Hu[a] * u[b] - u[a] * Hu[b] + u[a] * u[b] * (uHu + 3 * ue);
    E[(4 + i) * step] = (a == b ? x - ue : x) * scale;
  }
}

/* Number q of an emission in a channel: red, green, blue, luminance. */
YLM_INLINE real number_of(const real *lamp, int q, int channel) {
  const real *rgb = lamp + YLM__VIRTUAL_EMISSION + 3 * q;
  if (channel < 3) return rgb[channel];
  return (real)YLM_LUMINANCE_R * rgb[0] + (real)YLM_LUMINANCE_G * rgb[1] +
         (real)YLM_LUMINANCE_B * rgb[2];
}

/* Jets by u of an emission of degree 1 or 2. */
YLM_INLINE void quadratic(const vreal u[3], const int order, const int degree, const real *lamp,
                          const int channel, vreal *B) {
#define NUMBER(q) number_of(lamp, q, channel)
  B[0] = NUMBER(0) + NUMBER(1) * u[0] + NUMBER(2) * u[1] + NUMBER(3) * u[2];
  for (int a = 0; a < 3 && order > 0; a++) B[1 + a] = vreal_set(NUMBER(1 + a));
  for (int i = 0; i < 6 && order > 1; i++) B[4 + i] = vreal_set(0);
  if (degree < 2) return;
  const real last = -NUMBER(4) - NUMBER(7);
  vreal s[3];
  s[0] = NUMBER(4) * u[0] + NUMBER(5) * u[1] + NUMBER(6) * u[2];
  s[1] = NUMBER(5) * u[0] + NUMBER(7) * u[1] + NUMBER(8) * u[2];
  s[2] = NUMBER(6) * u[0] + NUMBER(8) * u[1] + last * u[2];
  B[0] += s[0] * u[0] + s[1] * u[1] + s[2] * u[2];
  for (int a = 0; a < 3 && order > 0; a++) B[1 + a] += 2 * s[a];
  for (int i = 0; i < 6 && order > 1; i++) B[4 + i] = vreal_set(2 * (i < 5 ? NUMBER(4 + i) : last));
#undef NUMBER
}

/*
** Jets by u of an emission of any degree, for `channels` channels from `first` on. Of order m it is
** Q(z, s) times Re and Im (x+iy)^m, s = |u|^2, and Q is found by recurrence with its derivatives.
*/
YLM_INLINE void any_degree(const seen *p, const int order, int degree, const double *beta,
                           const real *lamp, const int first, const int channels,
                           vreal B[4][PARTS]) {
  static const int parts[3] = {1, 4, 10}, slopes[3] = {1, 3, 6};
  vreal x = p->u[0], y = p->u[1], z = p->u[2], s = x * x + y * y + z * z;
  vreal A[3] = {vreal_set(1)}, I[3] = {vreal_set(0)}; /* (x+iy)^m, ^(m-1), ^(m-2) */
  const int n = slopes[order];
  for (int k = first; k < first + channels; k++)
    for (int i = 0; i < parts[order]; i++) B[k][i] = vreal_set(0);
  A[1] = A[2] = I[1] = I[2] = vreal_set(0);
  for (int m = 0; m <= degree; m++) {
    vreal Q[2][4][6], q[6], old[6]; /* Q, by z, by s, by zz, zs, ss */
    for (int k = first; k < first + channels; k++)
      for (int i = 0; i < n; i++) Q[0][k][i] = Q[1][k][i] = vreal_set(0);
    for (int i = 0; i < 6; i++) q[i] = old[i] = vreal_set(0);
    q[0] = vreal_set(1);
    for (int l = m; l <= degree; l++) {
      for (int side = 0; side < (m ? 2 : 1); side++)
        for (int k = first; k < first + channels; k++) {
          real b = number_of(lamp, l * (l + 1) + (side ? -m : m), k);
          for (int i = 0; i < n; i++) Q[side][k][i] += b * q[i];
        }
      const real t = l > m ? (real)beta[l * (YLM_LIGHT_VIRTUAL_DEGREE + 1) + m] : 0;
      vreal next[6];
      next[0] = z * q[0] - t * (s * old[0]);
      if (order > 0) {
        next[1] = q[0] + z * q[1] - t * (s * old[1]);
        next[2] = z * q[2] - t * (old[0] + s * old[2]);
      }
      if (order > 1) {
        next[3] = 2 * q[1] + z * q[3] - t * (s * old[3]);
        next[4] = q[2] + z * q[4] - t * (old[1] + s * old[4]);
        next[5] = z * q[5] - t * (2 * old[2] + s * old[5]);
      }
      for (int i = 0; i < n; i++) old[i] = q[i], q[i] = next[i];
    }
    const real f = (real)m, f2 = (real)(m * (m - 1));
    for (int side = 0; side < (m ? 2 : 1); side++) {
      /* T of the plane: it, by x, by y, by xx, xy */
      vreal T = side ? I[0] : A[0], Tx = f * (side ? I[1] : A[1]), Ty = f * (side ? A[1] : -I[1]);
      vreal Txx = f2 * (side ? I[2] : A[2]), Txy = f2 * (side ? A[2] : -I[2]);
      for (int k = first; k < first + channels; k++) {
        const vreal *w = Q[side][k];
        vreal *b = B[k];
        b[0] += T * w[0];
        if (order < 1) continue;
        const vreal s2 = 2 * w[2];
        b[1] += Tx * w[0] + T * s2 * x;
        b[2] += Ty * w[0] + T * s2 * y;
        b[3] += T * (w[1] + s2 * z);
        if (order < 2) continue;
        const vreal ss = 4 * w[5];
        b[4] += Txx * w[0] + 2 * Tx * s2 * x + T * (s2 + ss * x * x);
        b[5] += Txy * w[0] + s2 * (Tx * y + Ty * x) + T * ss * x * y;
        b[6] += Tx * (w[1] + s2 * z) + T * x * (2 * w[4] + ss * z);
        b[7] += 2 * Ty * s2 * y - Txx * w[0] + T * (s2 + ss * y * y);
        b[8] += Ty * (w[1] + s2 * z) + T * y * (2 * w[4] + ss * z);
        b[9] += T * (w[3] + 4 * w[4] * z + s2 + ss * z * z);
      }
    }
    A[2] = A[1], I[2] = I[1], A[1] = A[0], I[1] = I[0];
    vreal re = A[0] * x - I[0] * y;
    I[0] = A[0] * y + I[0] * x;
    A[0] = re;
  }
}

/* Where a light looks, of eps^2 = soft2: false where no lane is in front of it. */
YLM_INLINE bool look(const real *lamp, real soft2, const vreal v[3], vreal d2, seen *s) {
  const real *n = lamp + YLM__VIRTUAL_NORMAL;
  vreal dot = n[0] * v[0] + n[1] * v[1] + n[2] * v[2], D2 = d2 + soft2;
  const real shift = lamp[YLM__VIRTUAL_SHIFT];
  const bool round = n[0] == 0 && n[1] == 0 && n[2] == 0;
  if (!round && shift == 0 && !any(dot < 0)) return false;
  D2 = choose(D2 > 0, D2, vreal_set(1));
  s->inverse = inverse_root(D2);
  s->along = -dot * s->inverse;
  for (int a = 0; a < 3; a++) s->u[a] = -v[a] * s->inverse;
  vreal c = round ? vreal_set(1) : shift + s->along;
  vmask front = c > 0;
  if (shift != 0 && !any(front)) return false;
  s->cosine = keep_lanes(front, c);
  for (int a = 0; a < 3; a++) s->normal[a] = keep_lanes(front, vreal_set(n[a]));
  return true;
}

/* Jets of `channels` channels from `first` on to E [part][channel]. */
YLM_INLINE void send(const seen *s, const int order, int degree, const double *beta,
                     const real *lamp, const int first, const int channels, vreal *E) {
  static const int parts[3] = {1, 4, 10};
  vreal B[PARTS], all[4][PARTS];
  if (degree == 0) { /* one jet serves all */
    vreal one[PARTS];
    for (int i = 0; i < PARTS; i++) B[i] = vreal_set(i == 0);
    turn(s, order, B, one, 1);
    for (int i = 0; i < parts[order]; i++)
      for (int k = 0; k < channels; k++)
        E[i * channels + k] = one[i] * number_of(lamp, 0, first + k);
    return;
  }
  if (degree > 2) any_degree(s, order, degree, beta, lamp, first, channels, all);
  for (int k = 0; k < channels; k++) {
    if (degree <= 2) quadratic(s->u, order, degree, lamp, first + k, B);
    turn(s, order, degree <= 2 ? B : all[first + k], E + k, channels);
  }
}

#endif
