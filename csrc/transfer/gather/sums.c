/*
** sums.c - spherical harmonics of what a point sees, and their derivatives by the point.
**
**   L       = sum over cells of R int Y
**   grad L  = sum over borders of (R_high - R_low) m int Y dt / rho
**   H_ab L  = - sum over borders of (R_high - R_low) sym m_a int (grad Y - 3 s Y)_b dt / rho^2
**
** R the radiance of a cell; s the direction, m the normal of the border's great circle towards `high`, t along it;
** rho the distance of the nearer of both surfaces, at least `spacing`: a border is the silhouette of the nearer
** one, or lies on one surface, and moves with it. Light that is the same all around has no border.
**
** YLM_GATHER_POINTS: what fills a cell stays where it was hit and is seen in another direction and at
** another size; R less its mean, so that light that is the same all around has no gradient:
**
**   grad L  = - sum over cells of (R - mean) angle / rho ((n/(n.s) - 3 s) Y + grad Y)
**
** Derivatives of Y are sums of Y of the next degrees (slopes.c): what is summed is Y alone.
**
** Source   Jarosz et al. 2008, "Irradiance Gradients in the Presence of Participating Media and Occlusions";
**          Krivanek et al. 2005, "Radiance Caching for Efficient Global Illumination Computation";
**          Schwarzhaupt et al. 2012, "Practical Hessian-Based Error Control for Irradiance Caching"
*/
#include "calibration.h"
#include "gather.h"

#include "ylm_light.h"

/* Directions whose harmonics are summed with weights: to degree lmax, and to lmax + 1. */
typedef struct batch {
  size_t n, rows, more; /* multiples of 3 */
  float (*at)[3], *row; /* [GATHER_BATCH], weights [rows + more][..] */
  double *sum, *wide;   /* [rows][count], [more][wider] */
} batch;

struct gather_sums {
  const ylm_gather *g;
  gather_want want;
  size_t wider; /* (lmax+2)^2 */
  gather_rows_fn *rows;
  const float *base;
  const gather_slopes *slopes;
  uint16_t
      group; /* borders of this size and below count as if they were in the middle of their line */
  float *y;  /* [GATHER_BATCH][wider] */
  batch values, borders, points;
  double *value, *gradient, *hessian;
};

/* -- memory ------------------------------------------------------------------------------------ */

static bool make_batch(const gather_sums *s, batch *b, int rows, int more) {
  b->rows = ((size_t)rows + 2) / 3 * 3;
  b->more = ((size_t)more + 2) / 3 * 3;
  b->at = ylm_alloc(GATHER_BATCH, sizeof *b->at);
  b->row = ylm_alloc_zero(GATHER_BATCH * (b->rows + b->more), sizeof *b->row);
  b->sum = ylm_alloc(b->rows * s->want.count, sizeof *b->sum);
  b->wide = ylm_alloc(b->more * s->wider, sizeof *b->wide);
  return b->at && b->row && b->sum && b->wide;
}

static void free_batch(batch *b) {
  ylm_free(b->at);
  ylm_free(b->row);
  ylm_free(b->sum);
  ylm_free(b->wide);
}

/* Channels of gradients that borders give. */
static int border_channels(const gather_sums *s) {
  bool by_points = s->g->form.derivatives == YLM_GATHER_POINTS;
  return s->want.gradient && !by_points ? s->want.channels : 0;
}

/* Borders of the finest cells are taken four at a time where the basis hardly changes along them. */
static uint16_t group_of(const ylm_gather *g, int lmax) {
  double length = YLM_PI / 2 / (4 * g->lattice.base);
  return g->lattice.levels == 2 && lmax * length < SUMS_GROUPED ? 4 : 0;
}

gather_sums *ylm__gather_sums_create(const ylm_gather *g, const gather_want *want,
                                     const float *base, const gather_slopes *slopes) {
  gather_sums *s = ylm_alloc_zero(1, sizeof *s);
  size_t count = want->count, channels = (size_t)want->channels;
  if (!s) return NULL;
  s->g = g;
  s->want = *want;
  s->wider = ylm_sh_count(want->lmax + 1);
  s->rows = ylm__gather_rows();
  s->base = base;
  s->slopes = slopes;
  s->group = group_of(g, want->lmax);
  s->y = ylm_alloc_zero(GATHER_BATCH * s->wider + GATHER_SPARE, sizeof *s->y);
  s->value = ylm_alloc(channels * count, sizeof *s->value);
  s->gradient = ylm_alloc(3 * channels * count, sizeof *s->gradient);
  s->hessian = ylm_alloc(6 * (size_t)want->hessians * count, sizeof *s->hessian);
  if (s->y && s->value && s->gradient && s->hessian &&
      make_batch(s, &s->values, want->channels, 0) &&
      make_batch(s, &s->borders, 3 * border_channels(s), 3 * want->hessians) &&
      make_batch(s, &s->points, 3 * want->channels, want->channels))
    return s;
  ylm__gather_sums_free(s);
  return NULL;
}

void ylm__gather_sums_free(gather_sums *s) {
  if (!s) return;
  ylm_free(s->y);
  ylm_free(s->value);
  ylm_free(s->gradient);
  ylm_free(s->hessian);
  free_batch(&s->values);
  free_batch(&s->borders);
  free_batch(&s->points);
  ylm_free(s);
}

const double *ylm__gather_value(const gather_sums *s) { return s->value; }
const double *ylm__gather_gradient(const gather_sums *s) { return s->gradient; }
const double *ylm__gather_hessian(const gather_sums *s) { return s->hessian; }

/* -- sums -------------------------------------------------------------------------------------- */

static void flush(gather_sums *s, batch *b) {
  int lmax = s->want.lmax + (b->more > 0);
  size_t stride = ylm_sh_count(lmax);
  if (!b->n) return;
  ylm_sh_eval(lmax, 0, false, YLM_FLOAT, b->n, b->at, s->y, NULL, NULL, 1, NULL);
  s->rows(b->n, b->rows, b->row, s->want.count, stride, s->y, b->sum);
  s->rows(b->n, b->more, b->row + b->rows * GATHER_BATCH, s->wider, stride, s->y, b->wide);
  b->n = 0;
}

/* Room for one direction more; its weights follow. */
static size_t add(gather_sums *s, batch *b, const float at[3]) {
  if (b->n == GATHER_BATCH) flush(s, b);
  memcpy(b->at[b->n], at, 12);
  return b->n++;
}

static void begin(gather_sums *s, batch *b) {
  b->n = 0;
  ylm_zero(b->sum, b->rows * s->want.count * sizeof *b->sum);
  ylm_zero(b->wide, b->more * s->wider * sizeof *b->wide);
}

static float luminance(const float x[3]) {
  return (float)YLM_LUMINANCE_R * x[0] + (float)YLM_LUMINANCE_G * x[1] +
         (float)YLM_LUMINANCE_B * x[2];
}

/* Channels of x, or its luminance. */
static void channels_of(int channels, const float x[3], float out[3]) {
  if (channels == 3)
    memcpy(out, x, 12);
  else
    out[0] = luminance(x);
}

/* Writes `scale` times x to the batch's column i. */
static void put_value(gather_sums *s, size_t i, const float x[3], float scale) {
  float w[3] = {0, 0, 0};
  channels_of(s->want.channels, x, w);
  for (int c = 0; c < s->want.channels; c++)
    s->values.row[(size_t)c * GATHER_BATCH + i] = scale * w[c];
}

static void sum_values(gather_sums *s, const gather_sight *v) {
  static const float none[3] = {0, 0, 0};
  size_t cells = s->g->lattice.cells, count = s->want.count;
  for (size_t i = 0; i < cells; i += GATHER_BATCH) {
    size_t n = cells - i < GATHER_BATCH ? cells - i : GATHER_BATCH;
    for (size_t k = 0; k < n; k++)
      put_value(s, k, ylm__gather_is_split(&v->cell[i + k]) ? none : v->radiance[i + k], 1);
    s->rows(n, 3, s->values.row, count, count, s->base + i * count, s->values.sum);
  }
  for (size_t i = cells; i < v->cells; i++)
    if (!ylm__gather_is_split(&v->cell[i]))
      put_value(s, add(s, &s->values, v->toward[i]), v->radiance[i], v->toward[i][3]);
  flush(s, &s->values);
}

/* Red, green, blue, and the inverse of a distance. */
typedef float four __attribute__((vector_size(16)));

/* Borders on one line: sums of (R_high - R_low)/rho and /rho^2. */
typedef struct line_sum {
  four once, twice;
  bool any;
} line_sum;

static void add_pair(const gather_sight *v, const gather_border *b, line_sum *sum) {
  four low, high;
  memcpy(&low, v->radiance[b->low], 16);
  memcpy(&high, v->radiance[b->high], 16);
  four d = high - low;
  float part = low[3] > high[3] ? low[3] : high[3];
  if ((d[0] == 0 && d[1] == 0 && d[2] == 0) || part == 0) return;
  sum->any = true;
  d *= part;
  sum->once += d;
  sum->twice += d * part;
}

/* Adds a border of `length` at a direction. */
static void add_border(gather_sums *s, const float at[3], const float m[3], float length,
                       const line_sum *sum) {
  float *row = s->borders.row + add(s, &s->borders, at);
  int channels = border_channels(s), hessians = s->want.hessians;
  four once = sum->once * length, twice = sum->twice * length;
  float x[4];
  memcpy(x, &once, sizeof x);
  if (channels == 1) x[0] = luminance(x);
  for (int c = 0; c < channels; c++)
    for (int a = 0; a < 3; a++, row += GATHER_BATCH) *row = x[c] * m[a];
  memcpy(x, &twice, sizeof x);
  if (hessians == 1) x[0] = luminance(x);
  for (int c = 0; c < hessians; c++)
    for (int a = 0; a < 3; a++, row += GATHER_BATCH) *row = x[c] * m[a];
}

/* A border whose cells are not split. */
static void sum_pair(gather_sums *s, const gather_sight *v, const gather_border *b,
                     const gather_line *line) {
  line_sum sum = {{0}, {0}, false};
  gather_line own;
  float at[2][3];
  add_pair(v, b, &sum);
  if (!sum.any) return;
  if (!line) {
    ylm__gather_line(&s->g->lattice, b, &own);
    line = &own;
  }
  if ((float)(s->want.lmax * (s->want.lmax + 1)) * line->length * line->length < SUMS_LONG) {
    add_border(s, line->at, line->across, line->length, &sum);
    return;
  }
  ylm__gather_gauss(&s->g->lattice, b, at);
  for (int k = 0; k < 2; k++) add_border(s, at[k], line->across, line->length / 2, &sum);
}

/* Four borders of the finest cells on one line, as if they were in its middle. */
static void sum_group(gather_sums *s, const gather_sight *v, const gather_border b[4]) {
  line_sum sum = {{0}, {0}, false};
  gather_line own;
  gather_border whole = b[0];
  for (int q = 0; q < 4; q++) add_pair(v, &b[q], &sum);
  if (!sum.any) return;
  whole.size *= 4;
  ylm__gather_line(&s->g->lattice, &whole, &own);
  add_border(s, own.at, own.across, own.length / 4, &sum);
}

static void visit(gather_sight *v, int n, const gather_border *b, const gather_line *line,
                  void *context) {
  gather_sums *s = context;
  if (n == 4 && 4 * b->size <= s->group) {
    sum_group(s, v, b);
    return;
  }
  for (int i = 0; i < n; i++) {
    gather_border part[4];
    if (!ylm__gather_is_parted(v, &b[i])) {
      sum_pair(s, v, &b[i], line);
      continue;
    }
    for (uint32_t q = 0; q < 4; q++) part[q] = ylm__gather_quarter(v, &b[i], q);
    visit(v, 4, part, NULL, s);
  }
}

/* A cell whose hit point stays where it is. */
static void add_point(gather_sums *s, const gather_sight *v, size_t i, const float at[3],
                      float angle) {
  const gather_cell *cell = &v->cell[i];
  int channels = s->want.channels;
  if (cell->element >= s->g->elements) return;
  float d[3], x[3];
  for (int c = 0; c < 3; c++) d[c] = v->radiance[i][c] - v->mean[c];
  const float *n = s->g->normal[cell->element];
  float cosine = n[0] * at[0] + n[1] * at[1] + n[2] * at[2],
        near = fmaxf(cell->distance, s->g->spacing);
  cosine = copysignf(fmaxf(fabsf(cosine), SUMS_GRAZING), cosine);
  float *row = s->points.row + add(s, &s->points, at), *more = row + 3 * channels * GATHER_BATCH;
  channels_of(channels, d, x);
  for (int c = 0; c < channels; c++, more += GATHER_BATCH) {
    *more = -x[c] * angle / near;
    for (int a = 0; a < 3; a++, row += GATHER_BATCH) *row = *more * n[a] / cosine;
  }
}

static void sum_points(gather_sums *s, const gather_sight *v) {
  const gather_lattice *l = &s->g->lattice;
  for (size_t i = 0; i < v->cells; i++) {
    if (ylm__gather_is_split(&v->cell[i])) continue;
    bool own = i >= l->cells;
    add_point(s, v, i, own ? v->toward[i] : l->direction[i], own ? v->toward[i][3] : l->angle[i]);
  }
  flush(s, &s->points);
}

/* -- results ----------------------------------------------------------------------------------- */

static void take_gradient(gather_sums *s) {
  size_t count = s->want.count;
  const batch *b = border_channels(s) ? &s->borders : &s->points;
  memcpy(s->gradient, b->sum, 3 * (size_t)s->want.channels * count * sizeof *s->gradient);
  for (size_t c = 0; b == &s->points && c < (size_t)s->want.channels; c++)
    for (size_t i = 0; i < s->slopes->n; i++) {
      gather_term t = s->slopes->term[i];
      s->gradient[(3 * c + (size_t)t.axis) * count + t.of] +=
          t.factor * b->wide[c * s->wider + t.from];
    }
}

static void take_hessian(gather_sums *s) {
  static const uint8_t place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  size_t count = s->want.count;
  ylm_zero(s->hessian, 6 * (size_t)s->want.hessians * count * sizeof *s->hessian);
  for (size_t c = 0; c < (size_t)s->want.hessians; c++) {
    const double *sum = s->borders.wide + 3 * c * s->wider;
    double *h = s->hessian + 6 * c * count;
    for (size_t i = 0; i < s->slopes->n; i++) {
      gather_term t = s->slopes->term[i];
      for (int a = 0; a < 3; a++)
        h[place[a][t.axis] * count + t.of] -=
            (a == t.axis ? 1 : 0.5) * t.factor * sum[(size_t)a * s->wider + t.from];
    }
  }
}

void ylm__gather_sum(gather_sums *s, gather_sight *v) {
  bool by_points = s->want.gradient && !border_channels(s);
  begin(s, &s->values);
  begin(s, &s->borders);
  sum_values(s, v);
  ylm_copy(s->value, s->values.sum, (size_t)s->want.channels * s->want.count * sizeof *s->value);
  if (s->borders.rows + s->borders.more) {
    ylm__gather_borders(v, visit, s);
    flush(s, &s->borders);
  }
  if (by_points) {
    begin(s, &s->points);
    sum_points(s, v);
  }
  if (s->want.gradient) take_gradient(s);
  if (s->want.hessians) take_hessian(s);
}

void ylm__gather_flatten(gather_sums *s) {
  size_t count = s->want.count;
  ylm_zero(s->gradient, 3 * (size_t)s->want.channels * count * sizeof *s->gradient);
  ylm_zero(s->hessian, 6 * (size_t)s->want.hessians * count * sizeof *s->hessian);
}

void ylm__gather_add(gather_sums *s, const double *value, const double *gradient,
                     const double *hessian) {
  size_t count = s->want.count, channels = (size_t)s->want.channels;
  static const double weight[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  for (size_t i = 0; i < channels * count; i++) s->value[i] += value[i];
  for (size_t c = 0; c < channels; c++)
    for (size_t k = 0; k < count; k++) {
      for (size_t a = 0; s->want.gradient && a < 3; a++)
        s->gradient[(3 * c + a) * count + k] += gradient[(c * count + k) * 3 + a];
      if (!s->want.hessians) continue;
      bool mixed = channels == 3 && s->want.hessians == 1;
      for (size_t a = 0; a < 6; a++)
        s->hessian[(6 * (mixed ? 0 : c) + a) * count + k] +=
            (mixed ? weight[c] : 1) * hessian[(c * count + k) * 6 + a];
    }
}
