/* many.isa.c - virtual lights at a point, a vector of lights at a time, once per instruction set.
   many_plain.c has the plain form and the formulas. */
#include "ylm_simd.h"

#include "many_gloss.h"
#include "ylm_shade_rise.h"

ylm_many_weights_fn YLM_KERNEL(ylm_k_many_weights);
ylm_many_collect_fn YLM_KERNEL(ylm_k_many_collect);
ylm_many_collect_each_fn YLM_KERNEL(ylm_k_many_collect_each);
ylm_many_send_fn YLM_KERNEL(ylm_k_many_send);
ylm_many_gloss_fn YLM_KERNEL(ylm_k_many_gloss);

/* G_0 of Gaussian lights and points, and what e^(-l(l+1) s^2 / 2 d^2) is a product of. */
YLM_INLINE ylm_vf strength(const ylm_many_ask *a, int profile, ylm_vf r, ylm_vf d2, ylm_vf *decay) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf safe = most(d2, one * 1e-30f), inverse = 1 / safe, sg2 = r * r * 0.25f;
  *decay = one;
  if (profile == YLM_LIGHT_VIRTUAL_POINT) return ylm_vf_select(d2 > 0, inverse, one * 0);
  ylm_vf gauss = rise(2 * d2 / sg2) * inverse, far = rise(d2 * d2 * a->core) * inverse;
  gauss = ylm_vf_select(d2 <= 1e-30f, 2 / sg2, gauss);
  *decay = exponential(most(-sg2 * inverse, one * -88));
  return profile == YLM_LIGHT_VIRTUAL_FAR    ? far
         : profile == YLM_LIGHT_VIRTUAL_NEAR ? gauss - far
                                             : gauss;
}

/* sum over l of z_l G_l P_l(c), of Gaussian lights and points. */
YLM_INLINE ylm_vf by_degrees(const ylm_many_ask *a, int profile, ylm_vf r, ylm_vf d2, ylm_vf c) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf decay, G = strength(a, profile, r, d2, &decay);
  ylm_vf A = one, q = one, P0 = one, P1 = c, sum = one * a->zonal[0];
  for (int k = 1; k <= a->o->lmax; k++) {
    q *= decay;
    A *= q;
    sum += a->zonal[k] * A * P1;
    ylm_vf P2 = a->up[k] * c * P1 - a->down[k] * P0;
    P0 = P1, P1 = P2;
  }
  return G * sum;
}

YLM_INLINE ylm_vf by_cap(const ylm_many_ask *a, ylm_vf r, ylm_vf d2, ylm_vf c) {
  const ylm_vf one = (ylm_vf){0} + 1;
  ylm_vf m2 = most(d2, r * r), alpha = ylm_vf_sqrt(most(one * 0, 1 - r * r / m2));
  ylm_vf P0 = one, P1 = c, Q0 = one, Q1 = alpha, D0 = one * 0, D1 = one;
  ylm_vf sum = 2 * a->zonal[0] / (1 + alpha);
  for (int k = 1; k <= a->o->lmax; k++) {
    sum += a->zonal[k] * 2 / ((float)k * (float)(k + 1)) * D1 * P1;
    ylm_vf P2 = a->up[k] * c * P1 - a->down[k] * P0;
    ylm_vf Q2 = a->up[k] * alpha * Q1 - a->down[k] * Q0, D2 = D0 + (float)(2 * k + 1) * Q1;
    P0 = P1, P1 = P2, Q0 = Q1, Q1 = Q2, D0 = D1, D1 = D2;
  }
  return sum / m2;
}

YLM_INLINE void weigh(const ylm_many_lights *l, const ylm_many_ask *a, int profile, size_t first,
                      size_t n, const float x[3], const float N[3], float *w) {
  const ylm_vf one = (ylm_vf){0} + 1;
  bool soft = profile != YLM_LIGHT_VIRTUAL_CAP && profile != YLM_LIGHT_VIRTUAL_POINT;
  for (size_t k = 0; k < n; k += YLM_VF) {
    size_t i = first + k;
    ylm_vf vx = ylm_vf_load(l->at[0] + i) - x[0], vy = ylm_vf_load(l->at[1] + i) - x[1],
           vz = ylm_vf_load(l->at[2] + i) - x[2], r = ylm_vf_load(l->radius + i);
    ylm_vf d2 = vx * vx + vy * vy + vz * vz, up = vx * N[0] + vy * N[1] + vz * N[2];
    ylm_vf along = -(vx * ylm_vf_load(l->normal[0] + i) + vy * ylm_vf_load(l->normal[1] + i) +
                     vz * ylm_vf_load(l->normal[2] + i));
    ylm_vf safe = most(d2, one * 1e-30f), c = up / ylm_vf_sqrt(safe);
    ylm_vf D =
        soft ? ylm_vf_sqrt(most(d2 + r * r * (0.25f / 16), one * 1e-30f)) : ylm_vf_sqrt(safe);
    ylm_vf cosine = most(one * 0, ylm_vf_load(l->shift + i) + along / D), g;
    if (profile == YLM_LIGHT_VIRTUAL_CAP)
      g = cosine * by_cap(a, r, d2, c);
    else
      g = cosine * by_degrees(a, profile, r, d2, c);
    if (a->o->horizon == YLM_SHADE_HORIZON_GATE) g = ylm_vf_select(up < -r, one * 0, g);
    ylm_vf_store(w + k, g);
  }
}

void YLM_KERNEL(ylm_k_many_weights)(const ylm_many_lights *l, const ylm_many_ask *a, size_t first,
                                    size_t n, const float x[3], const float N[3], float *w) {
  switch (l->form.profile) {
  case YLM_LIGHT_VIRTUAL_CAP: weigh(l, a, YLM_LIGHT_VIRTUAL_CAP, first, n, x, N, w); break;
  case YLM_LIGHT_VIRTUAL_POINT: weigh(l, a, YLM_LIGHT_VIRTUAL_POINT, first, n, x, N, w); break;
  case YLM_LIGHT_VIRTUAL_FAR: weigh(l, a, YLM_LIGHT_VIRTUAL_FAR, first, n, x, N, w); break;
  case YLM_LIGHT_VIRTUAL_NEAR: weigh(l, a, YLM_LIGHT_VIRTUAL_NEAR, first, n, x, N, w); break;
  default: weigh(l, a, YLM_LIGHT_VIRTUAL_GAUSS, first, n, x, N, w);
  }
}

void YLM_KERNEL(ylm_k_many_collect)(size_t n, const float *w, const float *const I[3],
                                    double sum[3]) {
  ylm_vf s[3] = {{0}, {0}, {0}};
  for (size_t k = 0; k < n; k += YLM_VF) {
    ylm_vf one = ylm_vf_load(w + k);
    for (int c = 0; c < 3; c++) s[c] += one * ylm_vf_load(I[c] + k);
  }
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < YLM_VF; i++) sum[c] += (double)s[c][i];
}

void YLM_KERNEL(ylm_k_many_collect_each)(size_t n, const float (*w)[YLM_MANY_CHUNK],
                                         const float *const I[3], double sum[3]) {
  ylm_vf s[3] = {{0}, {0}, {0}};
  for (size_t k = 0; k < n; k += YLM_VF)
    for (int c = 0; c < 3; c++) s[c] += ylm_vf_load(w[c] + k) * ylm_vf_load(I[c] + k);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < YLM_VF; i++) sum[c] += (double)s[c][i];
}

/* -- emission ------------------------------------------------------------------------ */

/* The intensity of a vector of lights, whose emission begins at b, in directions u. */
YLM_INLINE void send(const ylm_many_series *s, int top, const float *b, const ylm_vf u[3],
                     ylm_vf out[3]) {
  const ylm_vf zero = {0};
  ylm_vf re = zero + 1, im = zero, r2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
  size_t begin = 0;
  for (int c = 0; c < 3; c++) out[c] = zero;
  for (int m = 0; m <= top; m++) {
    size_t k = begin;
    ylm_vf before = zero, p = zero + s->first[m], plus[3] = {zero, zero, zero},
           minus[3] = {zero, zero, zero};
    for (int q = m; q <= top; q++, k++) {
      const float *at = b + k * 6 * YLM_MANY_LOBES;
      for (int c = 0; c < 3; c++) plus[c] += p * ylm_vf_load(at + 2 * c * YLM_MANY_LOBES);
      if (m > 0)
        for (int c = 0; c < 3; c++) minus[c] += p * ylm_vf_load(at + (2 * c + 1) * YLM_MANY_LOBES);
      ylm_vf next = s->a[k] * u[2] * p - s->b[k] * r2 * before;
      before = p, p = next;
    }
    for (int c = 0; c < 3; c++) out[c] += re * plus[c] + im * minus[c];
    begin += (size_t)(s->lmax + 1 - m);
    ylm_vf next = re * u[0] - im * u[1];
    im = re * u[1] + im * u[0], re = next;
  }
}

void YLM_KERNEL(ylm_k_many_send)(const ylm_many_lights *l, bool soft, size_t first, size_t n,
                                 const float x[3], float (*I)[YLM_MANY_CHUNK]) {
  const ylm_vf one = (ylm_vf){0} + 1;
  const size_t block = l->series->entries * 6 * YLM_MANY_LOBES;
  for (size_t k = 0; k < n; k += YLM_VF) {
    size_t i = first + k, of = i / YLM_MANY_LOBES;
    ylm_vf u[3], d2 = soft ? ylm_vf_load(l->radius + i) : one * 0, out[3];
    d2 *= d2 * (0.25f / 16);
    for (int a = 0; a < 3; a++) {
      u[a] = x[a] - ylm_vf_load(l->at[a] + i);
      d2 += u[a] * u[a];
    }
    ylm_vf by = 1 / ylm_vf_sqrt(most(d2, one * 1e-30f));
    for (int a = 0; a < 3; a++) u[a] *= by;
    send(l->series, l->top[of], l->lobe + of * block + i % YLM_MANY_LOBES, u, out);
    for (int c = 0; c < 3; c++) ylm_vf_store(I[c] + k, out[c]);
  }
}

/* -- receivers that gloss ------------------------------------------------------------ */

/* G_l of lights, l to lmax. */
YLM_INLINE void degrees(const ylm_many_ask *a, int profile, ylm_vf r, ylm_vf d2, ylm_vf *G) {
  const ylm_vf one = (ylm_vf){0} + 1;
  const int lmax = a->o->lmax;
  if (profile == YLM_LIGHT_VIRTUAL_CAP) {
    ylm_vf m2 = most(d2, r * r), alpha = ylm_vf_sqrt(most(one * 0, 1 - r * r / m2)), by = 2 / m2;
    ylm_vf Q0 = one, Q1 = alpha, D0 = one * 0, D1 = one;
    G[0] = by / (1 + alpha);
    for (int k = 1; k <= lmax; k++) {
      G[k] = by * (1 / ((float)k * (float)(k + 1))) * D1;
      ylm_vf Q2 = a->up[k] * alpha * Q1 - a->down[k] * Q0, D2 = D0 + (float)(2 * k + 1) * Q1;
      Q0 = Q1, Q1 = Q2, D0 = D1, D1 = D2;
    }
    return;
  }
  ylm_vf decay, g = strength(a, profile, r, d2, &decay), A = one, q = one;
  G[0] = g;
  for (int k = 1; k <= lmax; k++) {
    q *= decay;
    A *= q;
    G[k] = g * A;
  }
}

/* Sums over degrees and orders of rows times G and harmonics at w. */
YLM_INLINE void by_orders(const ylm_many_receiver *r, int functions, bool halves, const ylm_vf *G,
                          const ylm_vf w[3], ylm_vf out[3]) {
  const ylm_vf zero = {0};
  const ylm_many_series *s = r->series;
  const float *row = r->row;
  ylm_vf re = zero + 1, im = zero;
  size_t k = 0, entries = s->entries;
  for (int f = 0; f < functions; f++) out[f] = zero;
  for (int m = 0; m <= s->lmax; m++) {
    ylm_vf before = zero, p = zero + s->first[m], plus[3] = {zero, zero, zero},
           minus[3] = {zero, zero, zero};
    for (int q = m; q <= s->lmax; q++, k++) {
      ylm_vf t = p * G[q];
      for (int f = 0; f < functions; f++) plus[f] += row[(size_t)(2 * f) * entries + k] * t;
      if (!halves)
        for (int f = 0; f < functions; f++) minus[f] += row[(size_t)(2 * f + 1) * entries + k] * t;
      ylm_vf next = s->a[k] * w[2] * p - s->b[k] * before;
      before = p, p = next;
    }
    for (int f = 0; f < functions; f++)
      out[f] += halves ? re * plus[f] : re * plus[f] + im * minus[f];
    ylm_vf next = re * w[0] - im * w[1];
    im = re * w[1] + im * w[0], re = next;
  }
}

/* The sum over degrees of the cosine's harmonics times G and P_l(c). */
YLM_INLINE ylm_vf by_cosine(const ylm_many_ask *a, const ylm_vf *G, ylm_vf c) {
  ylm_vf P0 = (ylm_vf){0} + 1, P1 = c, sum = a->zonal[0] * G[0];
  for (int k = 1; k <= a->o->lmax; k++) {
    sum += a->zonal[k] * G[k] * P1;
    ylm_vf P2 = a->up[k] * c * P1 - a->down[k] * P0;
    P0 = P1, P1 = P2;
  }
  return sum;
}

/* Sums over degrees of three lobes times G and P_l(c). */
YLM_INLINE void by_zones(const ylm_many_ask *a, const ylm_many_receiver *r, const ylm_vf *G,
                         ylm_vf c, ylm_vf out[3]) {
  const int lmax = a->o->lmax;
  const float *z = r->lobes;
  size_t row = (size_t)lmax + 1;
  ylm_vf P0 = (ylm_vf){0} + 1, P1 = c;
  for (int f = 0; f < 3; f++) out[f] = z[(size_t)f * row] * G[0];
  for (int k = 1; k <= lmax; k++) {
    ylm_vf t = G[k] * P1;
    for (int f = 0; f < 3; f++) out[f] += z[(size_t)f * row + (size_t)k] * t;
    ylm_vf P2 = a->up[k] * c * P1 - a->down[k] * P0;
    P0 = P1, P1 = P2;
  }
}

YLM_INLINE void gloss(const ylm_many_lights *l, const ylm_many_ask *a, const ylm_many_receiver *r,
                      int profile, int functions, bool halves, size_t first, size_t n,
                      const float x[3], float (*w)[YLM_MANY_CHUNK]) {
  const ylm_vf one = (ylm_vf){0} + 1;
  const bool soft = profile != YLM_LIGHT_VIRTUAL_CAP && profile != YLM_LIGHT_VIRTUAL_POINT;
  ylm_vf G[YLM_MATERIAL_TABLE_LMAX + 1];
  for (size_t k = 0; k < n; k += YLM_VF) {
    size_t i = first + k;
    ylm_vf v[3], u[3], out[3], d2 = one * 0, along = one * 0, R = ylm_vf_load(l->radius + i);
    for (int b = 0; b < 3; b++) {
      v[b] = ylm_vf_load(l->at[b] + i) - x[b];
      d2 += v[b] * v[b];
      along -= v[b] * ylm_vf_load(l->normal[b] + i);
    }
    ylm_vf safe = most(d2, one * 1e-30f), by = 1 / ylm_vf_sqrt(safe);
    ylm_vf D = soft ? 1 / ylm_vf_sqrt(most(d2 + R * R * (0.25f / 16), one * 1e-30f)) : by;
    ylm_vf cosine = most(one * 0, ylm_vf_load(l->shift + i) + along * D);
    for (int b = 0; b < 3; b++)
      u[b] = (v[0] * r->axis[b][0] + v[1] * r->axis[b][1] + v[2] * r->axis[b][2]) * by;
    if (a->o->horizon == YLM_SHADE_HORIZON_GATE)
      cosine = ylm_vf_select(u[2] * (safe * by) < -R, one * 0, cosine);
    degrees(a, profile, R, d2, G);
    /* nothing but degree 0 where there is no direction */
    u[2] = ylm_vf_select(d2 > 0, u[2], one);
    for (int q = 1; q <= a->o->lmax; q++) G[q] = ylm_vf_select(d2 > 0, G[q], one * 0);
    if (r->zonal) {
      ylm_vf c = (v[0] * r->lobe[0] + v[1] * r->lobe[1] + v[2] * r->lobe[2]) * by;
      by_zones(a, r, G, least(c, one), out);
      for (int f = 0; f < 3; f++) out[f] *= most(u[2], one * 0);
      if (r->based) {
        ylm_vf matte = by_cosine(a, G, u[2]);
        for (int f = 0; f < 3; f++) out[f] += r->base[f] * matte;
      }
    } else
      by_orders(r, functions, halves, G, u, out);
    for (int f = 0; f < functions; f++) ylm_vf_store(w[f] + k, cosine * out[f]);
  }
}

/* The profiles apart, then functions. */
#define PROFILES(functions, halves)                                                                \
  switch (l->form.profile) {                                                                       \
  case YLM_LIGHT_VIRTUAL_CAP:                                                                      \
    gloss(l, a, r, YLM_LIGHT_VIRTUAL_CAP, functions, halves, first, n, x, w);                      \
    break;                                                                                         \
  case YLM_LIGHT_VIRTUAL_GAUSS:                                                                    \
    gloss(l, a, r, YLM_LIGHT_VIRTUAL_GAUSS, functions, halves, first, n, x, w);                    \
    break;                                                                                         \
  default: gloss(l, a, r, l->form.profile, functions, halves, first, n, x, w);                     \
  }

void YLM_KERNEL(ylm_k_many_gloss)(const ylm_many_lights *l, const ylm_many_ask *a,
                                  const ylm_many_receiver *r, size_t first, size_t n,
                                  const float x[3], float (*w)[YLM_MANY_CHUNK]) {
  if (r->zonal || r->functions == 3) {
    PROFILES(3, r->halves)
  } else if (r->functions == 2) {
    PROFILES(2, r->halves)
  } else
    PROFILES(1, r->halves)
}
