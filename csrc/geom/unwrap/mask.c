/* mask.c - the texels of a chart: those that bilinear look-ups in its triangles read. */
#include <math.h>

#include "unwrap.h"

/* A look-up reads no texel whose middle is so far away, along an axis. */
#define REACH (1 - 1e-5)

/* fmin and fmax of numbers, without a call. */
static double least(double a, double b) { return b < a ? b : a; }
static double most(double a, double b) { return b > a ? b : a; }

/* Extends low .. high by the x of an edge where y is from `bottom` to `top`. */
static void clip(const double p[2], const double q[2], double bottom, double top, double *low,
                 double *high) {
  double from = 0, to = 1, dy = q[1] - p[1];
  if (dy == 0) {
    if (p[1] < bottom || p[1] > top) return;
  } else {
    double a = (bottom - p[1]) / dy, b = (top - p[1]) / dy;
    from = most(from, least(a, b));
    to = least(to, most(a, b));
    if (from > to) return;
  }
  for (int k = 0; k < 2; k++) {
    double x = p[0] + (k ? to : from) * (q[0] - p[0]);
    *low = least(*low, x);
    *high = most(*high, x);
  }
}

void ylm__unwrap_set(unwrap_mask *m, size_t y, size_t from, size_t to) {
  uint64_t *row = m->bit + y * m->words;
  for (size_t w = from / 64; w <= to / 64; w++) {
    uint64_t bits = ~(uint64_t)0;
    if (w == from / 64) bits &= ~(uint64_t)0 << from % 64;
    if (w == to / 64) bits &= ~(uint64_t)0 >> (63 - to % 64);
    row[w] |= bits;
  }
}

/* Texels of one triangle. */
static void draw(unwrap_mask *m, double at[3][2]) {
  double low = least(at[0][1], least(at[1][1], at[2][1])),
         high = most(at[0][1], most(at[1][1], at[2][1]));
  long first = (long)most(0, ceil(low - REACH - 0.5)),
       last = (long)least((double)m->height - 1, floor(high + REACH - 0.5));
  for (long y = first; y <= last; y++) {
    double left = INFINITY, right = -INFINITY, middle = (double)y + 0.5;
    for (int k = 0; k < 3; k++)
      clip(at[k], at[(k + 1) % 3], middle - REACH, middle + REACH, &left, &right);
    double from = most(0, ceil(left - REACH - 0.5)),
           to = least((double)m->width - 1, floor(right + REACH - 0.5));
    if (from <= to) ylm__unwrap_set(m, (size_t)y, (size_t)from, (size_t)to);
  }
}

ylm_status ylm__unwrap_mask(const ylm_unwrap *u, const unwrap_chart *c, unwrap_mask *m) {
  size_t size[2];
  for (int a = 0; a < 2; a++) size[a] = (size_t)(c->scale[a] * c->size[a] + 0.5) + 1;
  m->width = size[c->turned];
  m->height = size[!c->turned];
  m->words = (m->width + 63) / 64;
  m->bit = ylm_alloc_zero(m->words * m->height, sizeof *m->bit);
  if (!m->bit) return YLM_ENOMEM;
  for (size_t i = c->first; i < c->first + c->triangles; i++) {
    double at[3][2];
    for (size_t k = 0; k < 3; k++)
      unwrap_texel(c, c->flat[u->corner[3 * (size_t)u->list[i] + k]], at[k]);
    draw(m, at);
  }
  return YLM_OK;
}
