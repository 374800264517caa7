/* levels.isa.c - interpolation in cells of levels, once per instruction set. */
#define YLM_REAL_IS_FLOAT
#include "levels.h"

#include "../../moments/lanes.h"

enum {
  ROWS = 32,
  MOST = 256,
  RUN = 5
}; /* weights; numbers of a row; points that share what is summed */

/*
** Functions of an axis at both ends: linear, its cubic correction, and that of the slope. Weights of the corners' values,
** then of their slopes by x, y, z: what is linear along all axes is exact, and quadratic.
*/
#define INTERPOLATION(F, axis, axis_of, weigh)                                                     \
  typedef struct axis {                                                                            \
    F l[2], s[2], k[2];                                                                            \
  } axis;                                                                                          \
  YLM_INLINE axis axis_of(F t, const float edge) {                                                 \
    const F r = 1 - t, bend = t * r * (r - t);                                                     \
    return (axis){{r, t}, {bend, -bend}, {edge * r * r * t, -edge * t * t * r}};                   \
  }                                                                                                \
  YLM_INLINE void weigh(const axis *x, const axis *y, const axis *z, F *w) {                       \
    for (int c = 0; c < 8; c++) {                                                                  \
      const int i = c & 1, j = c >> 1 & 1, k = c >> 2;                                             \
      const F yz = y->l[j] * z->l[k], x0 = x->l[i];                                                \
      w[c] = (x0 + x->s[i]) * yz + x0 * (y->s[j] * z->l[k] + y->l[j] * z->s[k]);                   \
      w[8 + c] = x->k[i] * yz;                                                                     \
      w[16 + c] = x0 * z->l[k] * y->k[j];                                                          \
      w[24 + c] = x0 * y->l[j] * z->k[k];                                                          \
    }                                                                                              \
  }
INTERPOLATION(float, axis, axis_of, weigh)
INTERPOLATION(vreal, axes, axes_of, weigh_lanes)

/* Slopes of these functions. */
static axis slope_of(float t, float edge) {
  const float r = 1 - t, rate = 1 / edge, bend = rate * (1 - 6 * t * r);
  return (axis){{-rate, rate}, {bend, -bend}, {r * (r - 2 * t), t * (t - 2 * r)}};
}

/* Sums of rows by weights, `vectors` at a time. */
YLM_INLINE void add_rows(const ylm__level_cell *c, const float w[ROWS], size_t first,
                         const int vectors, vreal *sum) {
  for (int v = 0; v < vectors; v++) sum[v] = vreal_set(0);
  for (size_t r = 0; r < ROWS; r++) {
    if (w[r] == 0) continue;
    const float *row = c->row[r & 7] + (r >> 3) * c->stride + first;
    for (int v = 0; v < vectors; v++) sum[v] += w[r] * vreal_load(row + v * LANES);
  }
}

YLM_INLINE void mix_one(const ylm__level_cell *c, const float w[ROWS], float *to) {
  for (size_t i = 0; i < c->stride;) {
    vreal sum[5];
    const size_t left = (c->stride - i) / LANES;
    const int vectors = left >= 5 ? 5 : 1;
    if (vectors == 5)
      add_rows(c, w, i, 5, sum);
    else
      add_rows(c, w, i, 1, sum);
    for (int v = 0; v < vectors; v++, i += LANES) vreal_store(to + i, sum[v]);
  }
}

ylm__level_mix_fn YLM_KERNEL(ylm__level_mix);

void YLM_KERNEL(ylm__level_mix)(const ylm__level_cell *c, const float t[3], float *to) {
  axis value[3], slope[3];
  for (int a = 0; a < 3; a++)
    value[a] = axis_of(t[a], c->edge[a]), slope[a] = slope_of(t[a], c->edge[a]);
  for (size_t d = 0; d < 4; d++) {
    float w[ROWS];
    weigh(d == 1 ? slope : value, d == 2 ? slope + 1 : value + 1, d == 3 ? slope + 2 : value + 2,
          w);
    mix_one(c, w, to + d * c->stride);
  }
}

/* A row's numbers times the cosine's. */
YLM_INLINE float product(const float *row, const float *cosine, size_t wide) {
  vreal sum = vreal_set(0);
  float all = 0;
  for (size_t k = 0; k < wide; k += LANES) sum += vreal_load(row + k) * vreal_load(cosine + k);
  for (int i = 0; i < LANES; i++) all += sum[i];
  return all;
}

/* A point alone: coefficients first. */
static void shine_one(const ylm__level_cell *c, const ylm__level_points *p, size_t i, float *out) {
  float w[ROWS], room[MOST + YLM__LEVEL_PAD];
  const axis x = axis_of(p->t[0][i], c->edge[0]), y = axis_of(p->t[1][i], c->edge[1]),
             z = axis_of(p->t[2][i], c->edge[2]);
  weigh(&x, &y, &z, w);
  mix_one(c, w, room);
  memset(room + c->stride, 0, YLM__LEVEL_PAD * sizeof *room);
  for (size_t k = 0; k < 3; k++)
    out[3 * p->which[i] + k] += product(room + k * p->count, p->cosine + i * p->wide, p->wide);
}

/* Points that share a normal: irradiance of the corners first. */
static void shine_alike(const ylm__level_cell *c, const ylm__level_points *p, size_t i, size_t end,
                        float *out) {
  float E[ROWS][3];
  vreal w[ROWS];
  for (size_t r = 0; r < ROWS; r++)
    for (size_t k = 0; k < 3; k++)
      E[r][k] = product(c->row[r & 7] + (r >> 3) * c->stride + k * p->count,
                        p->cosine + i * p->wide, p->wide);
  for (; i < end; i += LANES) {
    vreal sum[3] = {vreal_set(0), vreal_set(0), vreal_set(0)};
    const axes x = axes_of(vreal_load(p->t[0] + i), c->edge[0]),
               y = axes_of(vreal_load(p->t[1] + i), c->edge[1]),
               z = axes_of(vreal_load(p->t[2] + i), c->edge[2]);
    weigh_lanes(&x, &y, &z, w);
    for (size_t r = 0; r < ROWS; r++)
      for (size_t k = 0; k < 3; k++) sum[k] += w[r] * E[r][k];
    for (size_t j = 0; j < LANES && i + j < end; j++)
      for (size_t k = 0; k < 3; k++) out[3 * p->which[i + j] + k] += sum[k][j];
  }
}

ylm__level_shine_fn YLM_KERNEL(ylm__level_shine);

void YLM_KERNEL(ylm__level_shine)(const ylm__level_cell *c, const ylm__level_points *p,
                                  float *out) {
  for (size_t i = 0, end; i < p->n; i = end) {
    end = i + p->run[i];
    if (end - i >= RUN)
      shine_alike(c, p, i, end, out);
    else
      for (size_t k = i; k < end; k++) shine_one(c, p, k, out);
  }
}
