/*
** sample.c - interpolating many points: chunk by chunk they are located, grouped by cell, and go
** through the kernel. Chunks share nothing, so that threads do not wait for one another; what comes
** out does not depend on how points are cut into chunks.
*/
#include "../grid.h"
#include "calibration.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

typedef struct sampling {
  const ylm_grid *g;
  const ylm_grid_query *q;
  const char *points;
  void *value, *gradient;
  sample_kernel *kernel;
  struct chunk *chunk; /* of each thread */
  _Atomic uint64_t outside, unbaked;
} sampling;

/* Work of a thread. Arrays lie in one block of memory, that of `scratch`. */
typedef struct chunk {
  size_t first;            /* point of the whole */
  uint32_t *cell;          /* [n] the cell that is interpolated */
  float (*t)[3];           /* [n] fractions of its edges */
  uint8_t *away;           /* [n] outside of the bounds */
  uint32_t *order, *other; /* [n] room for points by cell, twice */
  float *scratch;          /* values and gradients of a batch */
} chunk;

static void read_point(const sampling *s, size_t i, double p[3]) {
  if (s->q->point_dtype == YLM_DOUBLE)
    memcpy(p, s->points + i * 24, 24);
  else {
    float f[3];
    memcpy(f, s->points + i * 12, 12);
    for (int a = 0; a < 3; a++) p[a] = f[a];
  }
  for (int a = 0; s->q->origin && a < 3; a++) p[a] += s->q->origin[a];
}

/* The part of a sided leaf that answers for a point: its number behind those of all cells, or, where the leaf has none, the
   number behind all parts. */
static uint32_t find_part(const ylm_grid *g, const ylm_grid_side *side, const double p[3],
                          const float normal[3], const ylm_grid_walls *walls) {
  size_t part = side->parts ? ylm__side_look(g, side, p, normal, walls) : g->sides.parts;
  return (uint32_t)(g->cells + part);
}

/* Does a place lie in a body, of which `cell` answers for it? */
static bool is_buried(const ylm_grid *g, uint32_t cell, const double p[3]) {
  if (cell < g->cells) return false;
  size_t part = cell - g->cells;
  if (part == g->sides.parts) return true;
  return !ylm__side_is_free(g, ylm__grid_side_of(g, g->sides.leaf[part]), p);
}

/* The cell that answered last, where its leaf's neighbours have no say: points in the leaf's box have fractions of that cell. */
typedef struct again {
  leaf_cursor leaf;
  bool known;
  uint32_t cell;
  int flags;
  double origin[3], inverse;
} again;

static void keep_again(const ylm_grid *g, const ylm_grid_cell *c, uint32_t cell, int flags,
                       again *k) {
  uint32_t edge = ylm__grid_edge(g, c);
  k->known = !g->contents.root_level;
  k->cell = cell;
  k->flags = flags;
  k->inverse = 1 / (double)edge;
  for (int a = 0; a < 3; a++) {
    k->origin[a] = c->origin[a];
    k->known &= k->leaf.low[a] >= k->origin[a] && k->leaf.high[a] <= k->origin[a] + edge;
  }
}

/* Fractions of the cell that answered last, if the point is in that leaf and the bounds. */
static inline bool find_again(const ylm_grid *g, const again *k, const double p[3], float t[3]) {
  const double *b = g->contents.form.bounds;
  bool same = k->known;
  for (int a = 0; a < 3; a++) {
    double at = (p[a] - b[a]) * g->scale[a];
    same &= (p[a] <= b[a + 3]) & (at >= k->leaf.low[a]) & (at < k->leaf.high[a]);
    t[a] = (float)edge_fraction(at, k->origin[a], k->inverse);
  }
  return same;
}

/* The cell that answers for a point, and fractions of its edges; YLM_GRID_SAMPLE_OUTSIDE and _UNBAKED. */
static inline int find_cell(const ylm_grid *g, again *k, const double p[3], const float normal[3],
                            const ylm_grid_walls *walls, uint32_t *cell, float t[3]) {
  if (find_again(g, k, p, t)) {
    *cell = k->cell;
    return k->flags;
  }
  double at[3];
  bool outside = !ylm__grid_coordinates(g, p, at);
  uint32_t found = ylm__grid_leaf_again(g, &k->leaf, at);
  const ylm_grid_cell *leaf = &g->cell[found], *c = leaf->detail ? leaf : &g->cell[leaf->source];
  const ylm_grid_side *side = ylm__grid_side_of(g, found);
  k->known = false;
  if (side) {
    *cell = find_part(g, side, p, normal, walls);
    bool away = ylm__grid_fractions(g, leaf, at, t);
    return (outside ? YLM_GRID_SAMPLE_OUTSIDE : 0) | (away ? YLM_GRID_SAMPLE_UNBAKED : 0);
  }
  bool moved = ylm__grid_fractions(g, c, at, t);
  bool unbaked = !(leaf->flags & (YLM_GRID_BAKED | YLM_GRID_ADDED));
  *cell = leaf->detail ? found : leaf->source;
  keep_again(g, c, *cell, unbaked ? YLM_GRID_SAMPLE_UNBAKED : 0, k);
  return (outside ? YLM_GRID_SAMPLE_OUTSIDE : 0) | (moved || unbaked ? YLM_GRID_SAMPLE_UNBAKED : 0);
}

/* Finds cells and fractions of a chunk's n points. */
static void locate(sampling *s, chunk *k, size_t n) {
  const ylm_grid *g = s->g;
  uint64_t outside = 0, unbaked = 0;
  again cursor = {.leaf = {.leaf = YLM_GRID_NONE}};
  for (size_t i = 0; i < n; i++) {
    double p[3];
    read_point(s, k->first + i, p);
    const float *normal = s->q->normals ? s->q->normals[k->first + i] : NULL;
    int flags = find_cell(g, &cursor, p, normal, s->q->walls, &k->cell[i], k->t[i]);
    k->away[i] = (flags & YLM_GRID_SAMPLE_OUTSIDE) != 0;
    outside += k->away[i];
    unbaked += (flags & YLM_GRID_SAMPLE_UNBAKED) != 0;
  }
  s->outside += outside;
  s->unbaked += unbaked;
}

/* -- results ----------------------------------------------------------------------------------- */

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

/* Numbers of a batch's results that do not stand where they are wanted: gradients behind values. */
static size_t batch_numbers(const sampling *s) {
  size_t rows = s->gradient ? 4 : s->q->dtype == YLM_DOUBLE ? 1 : 0;
  return BATCH * rows * s->g->width;
}

/* Samples the batch, whose points are index[0 ..], and puts the results where they belong. */
static void run_batch(const sampling *s, const chunk *k, sample_batch *b, const size_t *index) {
  size_t w = s->g->width;
  bool wide = s->q->dtype == YLM_DOUBLE;
  float *scratch = k->scratch;
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
    if (s->q->nan_outside && k->away[index[p] - k->first]) write_nan(s, index[p]);
  }
}

/* One point of a leaf without data that evaluated points touch. */
static void sample_virtual(const sampling *s, const chunk *k, sample_batch *b, size_t i) {
  float *room = k->scratch + batch_numbers(s) + ROW_PADDING;
  ylm__grid_set_virtual(s->g, k->cell[i], k->t[i], room, b);
  i += k->first;
  run_batch(s, k, b, &i);
}

/* Points the batch's rows at the corners of a cell, or of a part. */
static void set_any(const ylm_grid *g, uint32_t cell, sample_batch *b) {
  if (cell < g->cells) {
    ylm__grid_set_cell(g, &g->cell[cell], b);
    return;
  }
  size_t part = cell - g->cells;
  bool dark = part == g->sides.parts;
  ylm__grid_set_edge(g, dark ? 1 : ylm__grid_edge(g, &g->cell[g->sides.leaf[part]]), b);
  for (int r = 0; r < ROWS; r++)
    b->row[r] = dark ? g->sides.dark : ylm__grid_row(g, g->sides.node[part][r & 7], 0);
}

/* Samples a chunk's n points in an order, or as they come, cell by cell. */
static void sample_cells(const sampling *s, const chunk *k, size_t n, const uint32_t *order) {
  sample_batch b = {.width = (int)s->g->width,
                    .derivatives = s->gradient != NULL,
                    .interpolation = ylm__grid_interpolation(s->g, s->q->interpolation)};
  size_t index[BATCH];
  uint32_t last = YLM_GRID_NONE;
  for (size_t i = 0; i < n;) {
    uint32_t first = order ? order[i] : (uint32_t)i, cell = k->cell[first];
    if (cell < s->g->cells && s->g->cell[cell].detail) {
      sample_virtual(s, k, &b, first);
      last = YLM_GRID_NONE;
      i++;
      continue;
    }
    if (cell != last) set_any(s->g, cell, &b);
    last = cell;
    b.points = 0;
    while (i < n && b.points < BATCH) {
      uint32_t p = order ? order[i] : (uint32_t)i;
      if (k->cell[p] != cell) break;
      for (int a = 0; a < 3; a++) b.t[a][b.points] = k->t[p][a];
      index[b.points++] = k->first + p;
      i++;
    }
    run_batch(s, k, &b, index);
  }
}

/* Sorts by cell, stable, 11 bits at a time, 8 where counts would cost more than few points. Returns `order` or `other`. */
static uint32_t *sort_by_cell(size_t n, const uint32_t *cell, uint32_t *order, uint32_t *other) {
  enum { MOST = 1 << 11 };
  const int bits = n < MOST ? 8 : 11;
  const uint32_t digits = 1u << bits;
  uint32_t *from = order, *to = other, all = 0;
  for (size_t i = 0; i < n; i++) {
    from[i] = (uint32_t)i;
    all |= cell[i];
  }
  for (int shift = 0; shift < 32 && all >> shift; shift += bits) {
    uint32_t count[MOST + 1];
    memset(count, 0, (digits + 1) * sizeof *count);
    for (size_t i = 0; i < n; i++) count[(cell[from[i]] >> shift & (digits - 1)) + 1]++;
    for (uint32_t k = 0; k < digits; k++) count[k + 1] += count[k];
    for (size_t i = 0; i < n; i++) to[count[cell[from[i]] >> shift & (digits - 1)]++] = from[i];
    uint32_t *swap = from;
    from = to;
    to = swap;
  }
  return from;
}

/* The order in which points are best sampled; NULL: as they are, neighbours mostly share a cell. */
static const uint32_t *order_points(const chunk *k, size_t n) {
  size_t changes = 0;
  for (size_t i = 1; i < n; i++) changes += k->cell[i] != k->cell[i - 1];
  return changes * 8 > n ? sort_by_cell(n, k->cell, k->order, k->other) : NULL;
}

static ylm_status sample_chunk(void *context, size_t begin, size_t end, int worker) {
  sampling *s = context;
  chunk *k = &s->chunk[worker];
  k->first = begin;
  locate(s, k, end - begin);
  sample_cells(s, k, end - begin, order_points(k, end - begin));
  return YLM_OK;
}

/* -- memory ------------------------------------------------------------------------------------ */

static void free_chunks(sampling *s, int threads) {
  for (int i = 0; s->chunk && i < threads; i++) ylm_free(s->chunk[i].scratch);
  ylm_free(s->chunk);
}

/* Memory of chunks of n points. */
static ylm_status make_chunks(sampling *s, int threads, size_t n) {
  size_t scratch = batch_numbers(s) + VIRTUAL_ROWS * s->g->stride + 2 * ROW_PADDING;
  size_t point = sizeof *s->chunk->t + 3 * sizeof(uint32_t) + 1;
  s->chunk = ylm_alloc_zero((size_t)threads, sizeof *s->chunk);
  for (int i = 0; s->chunk && i < threads; i++) {
    chunk *k = &s->chunk[i];
    k->scratch = ylm_alloc(scratch * sizeof *k->scratch + n * point, 1);
    if (!k->scratch) return YLM_ENOMEM;
    k->t = (void *)(k->scratch + scratch);
    k->cell = (void *)(k->t + n);
    k->order = k->cell + n;
    k->other = k->order + n;
    k->away = (void *)(k->other + n);
  }
  return s->chunk ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_grid_sample(const ylm_grid *g, const ylm_grid_query *q, size_t n, const void *points,
                           void *value, void *gradient, ylm_grid_report *report, ylm_error *e) {
  double begin = ylm_seconds();
  int threads = ylm_threads(q->threads);
  size_t share = n / (4 * (size_t)threads), size = share < SAMPLE_LEAST  ? SAMPLE_LEAST
                                                   : share > SAMPLE_MOST ? SAMPLE_MOST
                                                                         : share;
  if (size > n) size = n ? n : 1;
  if ((n + size - 1) / size < (size_t)threads) threads = (int)((n + size - 1) / size);
  if (threads < 1) threads = 1;
  sampling s = {.g = g,
                .q = q,
                .points = points,
                .value = value,
                .gradient = gradient,
                .kernel = ylm__grid_kernel()};
  ylm_status status = make_chunks(&s, threads, size);
  if (status == YLM_OK)
    status = ylm_parallel(n, size, threads, sample_chunk, &s, q->progress, "sampling");
  free_chunks(&s, threads);
  if (report) *report = (ylm_grid_report){s.outside, s.unbaked, ylm_seconds() - begin};
  return status == YLM_OK ? YLM_OK : ylm_fail_plain(e, status);
}

/* -- what is counted, point by point -------------------------------------------------------- */

typedef struct flagging {
  const ylm_grid *g;
  ylm_dtype dtype, type;
  const void *points;
  void *flags;
} flagging;

static ylm_status flag_points(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const flagging *f = context;
  again cursor = {.leaf = {.leaf = YLM_GRID_NONE}};
  for (size_t i = begin; i < end; i++) {
    double p[3];
    uint32_t cell;
    float t[3];
    for (size_t a = 0; a < 3; a++) p[a] = ylm_get(f->dtype, f->points, 3 * i + a);
    int flags = find_cell(f->g, &cursor, p, NULL, NULL, &cell, t);
    if (is_buried(f->g, cell, p)) flags |= YLM_GRID_SAMPLE_BURIED;
    ylm_put(f->type, f->flags, i, flags);
  }
  return YLM_OK;
}

ylm_status ylm_grid_flags(const ylm_grid *g, size_t n, ylm_dtype dtype, const void *points,
                          ylm_dtype type, void *flags, int threads) {
  flagging f = {g, dtype, type, points, flags};
  return ylm_parallel(n, SAMPLE_LEAST, threads, flag_points, &f, NULL, NULL);
}
