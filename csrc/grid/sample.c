/* sample.c - interpolating batches of points: locate, group by cell, run the kernel. */
#include "grid.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define CHUNK ((size_t)1 << 18) /* points that are located, ordered and sampled together */
#define GRAIN 1024

sample_kernel *ylm__grid_kernel(void) {
  switch (ylm_isa_current()) {
#if defined(__x86_64__) || defined(__i386__)
  case YLM_ISA_sse2: return ylm_k_grid_sample_sse2;
  case YLM_ISA_avx2: return ylm_k_grid_sample_avx2;
  case YLM_ISA_avx512: return ylm_k_grid_sample_avx512;
#elif defined(__aarch64__)
  case YLM_ISA_neon: return ylm_k_grid_sample_neon;
#endif
  default: return ylm_k_grid_sample_reference;
  }
}

static void set_edge(const ylm_grid *g, uint32_t edge, sample_batch *b) {
  for (int a = 0; a < 3; a++) b->edge[a] = (float)(edge / g->scale[a]);
}

/* Points the batch's rows at the corners of a cell. */
void ylm__grid_set_cell(const ylm_grid *g, const ylm_grid_cell *c, sample_batch *b) {
  set_edge(g, ylm__grid_edge(g, c), b);
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < 8; k++) b->row[8 * r + k] = ylm__grid_row(g, c->corner[k], r);
}

void ylm__grid_interpolate(const ylm_grid *g, const ylm_grid_cell *c, const float t[3],
                           float *value, float *gradient) {
  const float *row[ROWS];
  for (int r = 0; r < 4; r++)
    for (int k = 0; k < 8; k++) row[8 * r + k] = ylm__grid_row(g, c->corner[k], r);
  ylm__grid_mix(g, row, ylm__grid_edge(g, c), t, value, gradient);
}

void ylm__grid_mix(const ylm_grid *g, const float *const row[ROWS], uint32_t edge, const float t[3],
                   float *value, float *gradient) {
  sample_batch b = {.points = 1,
                    .width = (int)g->width,
                    .derivatives = gradient != NULL,
                    .interpolation = YLM_GRID_HERMITE};
  set_edge(g, edge, &b);
  memcpy(b.row, row, sizeof b.row);
  b.value[0] = value;
  for (int a = 0; a < 3; a++) {
    b.t[a][0] = t[a];
    if (gradient) b.gradient[a][0] = gradient + (size_t)a * g->stride;
  }
  ylm__grid_kernel()(&b);
}

/* -- a chunk of points --------------------------------------------------------------- */

typedef struct sampling {
  const ylm_grid *g;
  const ylm_grid_query *q;
  const char *points;
  void *value, *gradient;
  sample_kernel *kernel;
  uint32_t *cell;  /* [n] the cell that is interpolated */
  float (*t)[3];   /* [n] fractions of its edges */
  uint8_t *away;   /* [n] outside of the bounds */
  uint32_t *order; /* [n] points by cell; NULL: as they come */
  float *scratch;  /* per thread: values and gradients of a batch */
  size_t scratch_size;
  _Atomic uint64_t outside, unbaked;
} sampling;

static void read_point(const sampling *s, size_t i, double p[3]) {
  if (s->q->point_dtype == YLM_DOUBLE)
    memcpy(p, s->points + i * 24, 24);
  else {
    float f[3];
    memcpy(f, s->points + i * 12, 12);
    for (int a = 0; a < 3; a++) p[a] = f[a];
  }
}

/* Finds cells and fractions of points begin .. end-1. */
static ylm_status locate(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  sampling *s = context;
  const ylm_grid *g = s->g;
  uint64_t outside = 0, unbaked = 0;
  for (size_t i = begin; i < end; i++) {
    double p[3], at[3];
    read_point(s, i, p);
    s->away[i] = !ylm__grid_coordinates(g, p, at);
    outside += s->away[i];
    uint32_t found = ylm__grid_leaf(g, at);
    const ylm_grid_cell *leaf = &g->cell[found], *c = leaf->detail ? leaf : &g->cell[leaf->source];
    double edge = ylm__grid_edge(g, c), inverse = 1 / edge;
    bool moved = false;
    for (int a = 0; a < 3; a++) {
      double t = (at[a] - c->origin[a]) * inverse;
      moved |= !(t >= 0 && t <= 1);
      s->t[i][a] = (float)(t < 0 ? 0 : t > 1 ? 1 : t);
    }
    unbaked += moved || !(leaf->flags & (YLM_GRID_BAKED | YLM_GRID_ADDED));
    s->cell[i] = leaf->detail ? found : leaf->source;
  }
  s->outside += outside;
  s->unbaked += unbaked;
  return YLM_OK;
}

static void write_value(const sampling *s, size_t i, const float *v) {
  size_t w = s->g->width;
  double *d = s->value;
  if (s->q->dtype == YLM_DOUBLE)
    for (size_t j = 0; j < w; j++) d[i * w + j] = v[j];
}

static void write_gradient(const sampling *s, size_t i, const float *const g[3]) {
  size_t w = s->g->width;
  if (s->q->dtype == YLM_DOUBLE) {
    double *d = (double *)s->gradient + i * w * 3;
    for (size_t j = 0; j < w; j++)
      for (int a = 0; a < 3; a++) d[3 * j + (size_t)a] = g[a][j];
    return;
  }
  float *f = (float *)s->gradient + i * w * 3;
  for (size_t j = 0; j < w; j++)
    for (int a = 0; a < 3; a++) f[3 * j + (size_t)a] = g[a][j];
}

static void write_nan(const sampling *s, size_t i) {
  size_t w = s->g->width;
  bool wide = s->q->dtype == YLM_DOUBLE;
  for (size_t j = 0; j < w; j++) {
    if (wide)
      ((double *)s->value)[i * w + j] = NAN;
    else
      ((float *)s->value)[i * w + j] = NAN;
  }
  for (size_t j = 0; s->gradient && j < 3 * w; j++) {
    if (wide)
      ((double *)s->gradient)[i * 3 * w + j] = NAN;
    else
      ((float *)s->gradient)[i * 3 * w + j] = NAN;
  }
}

/* Samples the batch, whose points are index[0 ..], and puts the results where they belong. */
static void run_batch(const sampling *s, sample_batch *b, const size_t *index, float *scratch) {
  size_t w = s->g->width;
  bool wide = s->q->dtype == YLM_DOUBLE;
  for (int p = 0; p < b->points; p++) {
    b->value[p] = wide ? scratch + (size_t)p * w : (float *)s->value + index[p] * w;
    for (int a = 0; b->derivatives && a < 3; a++)
      b->gradient[a][p] = scratch + ((size_t)BATCH * (size_t)(a + 1) + (size_t)p) * w;
  }
  s->kernel(b);
  for (int p = 0; p < b->points; p++) {
    if (wide) write_value(s, index[p], b->value[p]);
    if (b->derivatives)
      write_gradient(
          s, index[p],
          (const float *const[3]){b->gradient[0][p], b->gradient[1][p], b->gradient[2][p]});
    if (s->q->nan_outside && s->away[index[p]]) write_nan(s, index[p]);
  }
}

/* One point of a leaf without data that evaluated points touch. */
static void sample_virtual(const sampling *s, sample_batch *b, size_t i, float *scratch) {
  const ylm_grid_cell *c = &s->g->cell[s->cell[i]];
  float *room = scratch + (size_t)BATCH * 4 * s->g->width + ROW_PADDING;
  uint32_t edge = ylm__grid_edge(s->g, c);
  virtual_cell v;
  double at[3];
  for (int a = 0; a < 3; a++) at[a] = c->origin[a] + (double)s->t[i][a] * edge;
  ylm__grid_virtual(s->g, s->cell[i], at, &v, room);
  set_edge(s->g, v.edge, b);
  memcpy(b->row, v.row, sizeof b->row);
  for (int a = 0; a < 3; a++) b->t[a][0] = (float)((at[a] - v.origin[a]) / v.edge);
  b->points = 1;
  run_batch(s, b, &i, scratch);
}

/* Samples places begin .. end-1 of the order, cell by cell. */
static ylm_status sample_range(void *context, size_t begin, size_t end, int worker) {
  sampling *s = context;
  sample_batch b = {.width = (int)s->g->width,
                    .derivatives = s->gradient != NULL,
                    .interpolation = s->q->interpolation};
  size_t index[BATCH];
  uint32_t last = YLM_GRID_NONE;
  float *scratch = s->scratch + (size_t)worker * s->scratch_size;
  for (size_t i = begin; i < end;) {
    uint32_t cell = s->cell[s->order ? s->order[i] : i];
    if (s->g->cell[cell].detail) {
      sample_virtual(s, &b, s->order ? s->order[i] : i, scratch);
      last = YLM_GRID_NONE;
      i++;
      continue;
    }
    if (cell != last) ylm__grid_set_cell(s->g, &s->g->cell[cell], &b);
    last = cell;
    b.points = 0;
    while (i < end && b.points < BATCH) {
      size_t k = s->order ? s->order[i] : i;
      if (s->cell[k] != cell) break;
      for (int a = 0; a < 3; a++) b.t[a][b.points] = s->t[k][a];
      index[b.points++] = k;
      i++;
    }
    run_batch(s, &b, index, scratch);
  }
  return YLM_OK;
}

/* Sorts points by cell (stable, 16 bits at a time) where neighbours mostly differ. */
static void order_points(sampling *s, size_t n, uint32_t *order, uint32_t *other) {
  size_t changes = 0;
  s->order = NULL;
  for (size_t i = 1; i < n; i++) changes += s->cell[i] != s->cell[i - 1];
  if (changes * 8 <= n) return;
  static const int bits = 12;
  uint32_t *from = order, *to = other;
  for (size_t i = 0; i < n; i++) from[i] = (uint32_t)i;
  for (int shift = 0; shift < 32 && s->g->cells >> shift; shift += bits) {
    size_t count[(1 << 12) + 1] = {0};
    uint32_t mask = (1u << bits) - 1;
    for (size_t i = 0; i < n; i++) count[(s->cell[from[i]] >> shift & mask) + 1]++;
    for (uint32_t k = 0; k <= mask; k++) count[k + 1] += count[k];
    for (size_t i = 0; i < n; i++) to[count[s->cell[from[i]] >> shift & mask]++] = from[i];
    uint32_t *swap = from;
    from = to;
    to = swap;
  }
  s->order = from;
}

/* One chunk: n points from `first` on. */
static ylm_status sample_chunk(sampling *s, size_t n, uint32_t *order, uint32_t *other) {
  ylm_status status = ylm_parallel(n, GRAIN, s->q->threads, locate, s, NULL, NULL);
  if (status != YLM_OK) return status;
  order_points(s, n, order, other);
  return ylm_parallel(n, GRAIN, s->q->threads, sample_range, s, NULL, NULL);
}

/* Reserves the memory of a chunk of n points. */
static ylm_status begin_sampling(sampling *s, size_t n, uint32_t **order, uint32_t **other) {
  s->kernel = ylm__grid_kernel();
  s->cell = ylm_alloc(n, sizeof *s->cell);
  s->t = ylm_alloc(n, sizeof *s->t);
  s->away = ylm_alloc(n, 1);
  *order = ylm_alloc(n, sizeof **order);
  *other = ylm_alloc(n, sizeof **other);
  s->scratch_size = (size_t)BATCH * 4 * s->g->width + VIRTUAL_ROWS * s->g->stride + 2 * ROW_PADDING;
  s->scratch = ylm_alloc((size_t)ylm_threads(s->q->threads), s->scratch_size * sizeof(float));
  bool ok = s->cell && s->t && s->away && *order && *other && s->scratch;
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_grid_sample(const ylm_grid *g, const ylm_grid_query *q, size_t n, const void *points,
                           void *value, void *gradient, ylm_grid_report *report, ylm_error *e) {
  double begin = ylm_seconds();
  size_t w = g->width, size = ylm_dtype_size(q->dtype), row = 3 * ylm_dtype_size(q->point_dtype);
  sampling s = {.g = g, .q = q};
  uint32_t *order = NULL, *other = NULL;
  ylm_status status = begin_sampling(&s, n < CHUNK ? n : CHUNK, &order, &other);
  for (size_t i = 0; i < n && status == YLM_OK;) {
    size_t now = n - i < CHUNK ? n - i : CHUNK;
    s.points = (const char *)points + i * row;
    s.value = (char *)value + i * w * size;
    s.gradient = gradient ? (char *)gradient + i * w * 3 * size : NULL;
    status = sample_chunk(&s, now, order, other);
    i += now;
    if (status == YLM_OK) status = ylm_report(q->progress, i, n, "sampling");
  }
  ylm_free(s.cell);
  ylm_free(s.t);
  ylm_free(s.away);
  ylm_free(s.scratch);
  ylm_free(order);
  ylm_free(other);
  if (report) *report = (ylm_grid_report){s.outside, s.unbaked, ylm_seconds() - begin};
  return status == YLM_OK ? YLM_OK : ylm_fail(e, status, "%s", ylm_status_text(status));
}

/* -- the grid as a light field ---------------------------------------------------------- */

/* Lambda at a point: trilinear between the corners. */
static double sample_lambda(const ylm_grid *g, const double p[3]) {
  double at[3], sum = 0;
  ylm__grid_coordinates(g, p, at);
  const ylm_grid_cell *c = &g->cell[g->cell[ylm__grid_leaf(g, at)].source];
  double edge = ylm__grid_edge(g, c);
  for (int k = 0; k < 8; k++) {
    double w = 1;
    for (int a = 0; a < 3; a++) {
      double t = (at[a] - c->origin[a]) / edge;
      t = t < 0 ? 0 : t > 1 ? 1 : t;
      w *= k >> a & 1 ? t : 1 - t;
    }
    sum += w * (double)g->lambda[c->corner[k]];
  }
  return sum;
}

/* Turns a row of the grid's coefficients into one of the query's: fewer degrees, other channels. */
static void convert_row(const ylm_grid *g, const ylm_field_query *q, const float *from, int step,
                        void *to, size_t at) {
  static const double weight[3] = {0.2126, 0.7152, 0.0722};
  int count = (q->lmax + 1) * (q->lmax + 1), own = g->view.count, channels = g->view.form.channels;
  for (int c = 0; c < q->channels; c++)
    for (int j = 0; j < count; j++)
      for (int d = 0; d < step; d++) {
        double x = 0;
        for (int k = 0; k < channels; k++) {
          double share = channels == q->channels ? k == c : channels == 1 ? 1 : weight[k];
          if (share > 0) x += share * (double)from[(k * own + j) * step + d];
        }
        size_t i = (at * (size_t)(q->channels * count) + (size_t)(c * count + j)) * (size_t)step +
                   (size_t)d;
        if (q->dtype == YLM_DOUBLE)
          ((double *)to)[i] = x;
        else
          ((float *)to)[i] = (float)x;
      }
}

static void put(const ylm_field_query *q, void *to, size_t i, double x) {
  if (q->dtype == YLM_DOUBLE)
    ((double *)to)[i] = x;
  else
    ((float *)to)[i] = (float)x;
}

/* The query's results from sampled rows. */
static void convert(const ylm_grid *g, const ylm_field_query *q, size_t n, const void *points,
                    const float *value, const float *gradient, ylm_field_result *r) {
  size_t w = g->width;
  for (size_t i = 0; i < n; i++) {
    if (q->want & YLM_WANT_VALUE) convert_row(g, q, value + i * w, 1, r->value, i);
    if (q->want & YLM_WANT_GRADIENT) convert_row(g, q, gradient + i * w * 3, 3, r->gradient, i);
    if (r->inside) r->inside[i] = 0;
    if (!(q->want & YLM_WANT_METRIC)) continue;
    double sum = 0, p[3];
    for (size_t j = 0; j < w; j++) sum += (double)value[i * w + j] * (double)value[i * w + j];
    for (size_t a = 0; a < 3; a++)
      p[a] = q->dtype == YLM_DOUBLE ? ((const double *)points)[3 * i + a]
                                    : (double)((const float *)points)[3 * i + a];
    if (r->norm) put(q, r->norm, i, sqrt(sum));
    if (r->lambda) put(q, r->lambda, i, sample_lambda(g, p));
  }
}

ylm_status ylm__grid_evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                              const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_grid *g = f->self;
  if (q->lmax > g->view.form.lmax)
    return ylm_fail(e, YLM_ERANGE, "the grid has coefficients up to lmax %d, %d is wanted",
                    g->view.form.lmax, q->lmax);
  if (q->want & YLM_WANT_HESSIAN) return ylm_fail(e, YLM_EINVAL, "a grid has no Hessians");
  size_t w = g->width, block = n < 16384 ? n : 16384;
  bool slopes = q->want & YLM_WANT_GRADIENT;
  float *value = ylm_alloc(block, w * sizeof *value);
  float *gradient = slopes ? ylm_alloc(block, 3 * w * sizeof *gradient) : NULL;
  ylm_status s = value && (gradient || !slopes) ? YLM_OK : YLM_ENOMEM;
  ylm_grid_query own = {.point_dtype = q->dtype, .dtype = YLM_FLOAT, .threads = q->threads};
  for (size_t i = 0; i < n && s == YLM_OK; i += block) {
    size_t now = n - i < block ? n - i : block, size = ylm_dtype_size(q->dtype);
    size_t k = i * (size_t)(q->channels * (q->lmax + 1) * (q->lmax + 1)) * size;
    const char *p = (const char *)points + 3 * i * size;
    ylm_field_result part = {.value = r->value ? (char *)r->value + k : NULL,
                             .gradient = r->gradient ? (char *)r->gradient + 3 * k : NULL,
                             .lambda = r->lambda ? (char *)r->lambda + i * size : NULL,
                             .norm = r->norm ? (char *)r->norm + i * size : NULL,
                             .inside = r->inside ? r->inside + i : NULL};
    s = ylm_grid_sample(g, &own, now, p, value, gradient, NULL, e);
    if (s == YLM_OK) convert(g, q, now, p, value, gradient, &part);
    if (s == YLM_OK) s = ylm_report(q->progress, i + now, n, "sampling");
  }
  ylm_free(value);
  ylm_free(gradient);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "no memory to sample %zu points", n) : s;
}

const ylm_field *ylm_grid_field(const ylm_grid *g) { return &g->field; }
