/*
** near.c - sums over the virtual lights near to points.
**
** Lights are sorted into cells of the size of their reach, cells into buckets by a hash. Points are sorted
** a run at a time along a curve through parts of cells. Points of one cell share the lights of its 27
** neighbours. As many at a time as a vector has lanes take, of these, the lights that may shine into their box.
*/
#include <stdatomic.h>
#include <string.h>

#include "near.h"
#include "ylm_sets.h"
#include "ylm_sh.h"

enum { RUN = 8192, FINE = 3 }; /* points; bits of a cell's parts along an axis */

typedef int64_t place[3];

/* Lights by the bucket of their cell. */
typedef struct buckets {
  size_t mask;
  uint32_t *first, *order; /* [mask+2], [n] */
  place *cell;             /* [n] of order */
  float *field;            /* [YLM__NEAR_FIELDS][n] of order */
  float *row;              /* [n][YLM__NEAR_ROW] of order; NULL: none are wanted */
} buckets;

typedef struct search {
  const ylm_light_virtual *lights;
  double size[3], origin[3]; /* of cells, whose edges are at least as long as lights shine */
  double reach;
  size_t n; /* points */
  buckets of_lights;
  const float *points, *normals;
  float *out, *zonal;
  size_t wide;      /* numbers of a point's result */
  size_t row;       /* of gradients: numbers from one of its rows to the next */
  uint8_t *touched; /* instead of `out`: whether lights may shine into the box about a point, */
  float half[3];    /* of these half edges */
  ylm__near_kernels kernels;
  ylm__virtual_plan plan;
  atomic_uint_fast64_t pairs;
} search;

/* Where x lies on an axis of parts of cells: whole numbers that a double has. */
static double part_of(const search *s, int a, double x) {
  return fmax(-9e15, fmin(9e15, floor((x - s->origin[a]) * ((1 << FINE) / s->size[a]))));
}

static void cell_of(const search *s, const double at[3], place cell) {
  for (int a = 0; a < 3; a++) cell[a] = (int64_t)part_of(s, a, at[a]) >> FINE;
}

static size_t bucket_of(const buckets *b, const place cell) {
  uint64_t h = 0;
  for (int a = 0; a < 3; a++) h = (h ^ (uint64_t)cell[a]) * 0x9e3779b97f4a7c15u;
  return (size_t)(h >> 32) & b->mask;
}

/* -- lights --------------------------------------------------------------------------------- */

static void put_light(const search *s, buckets *b, size_t to, size_t i) {
  const ylm_light_virtual *v = s->lights;
  b->order[to] = (uint32_t)i;
  cell_of(s, v->at + 3 * i, b->cell[to]);
  for (size_t a = 0; a < 3; a++) {
    b->field[a * v->n + to] = (float)v->at[3 * i + a];
    b->field[(3 + a) * v->n + to] = (float)v->normal[3 * i + a];
  }
  /* light all around has no front */
  b->field[6 * v->n + to] =
      v->normal[3 * i] == 0 && v->normal[3 * i + 1] == 0 && v->normal[3 * i + 2] == 0
          ? 1
          : (float)v->shift[i];
  if (!b->row) return;
  const float *lamp = v->seen + i * v->stride;
  float *row = b->row + (size_t)YLM__NEAR_ROW * to;
  for (size_t f = 0; f < YLM__NEAR_FIELDS; f++) row[f] = b->field[f * v->n + to];
  double width = v->radius[i] * YLM__GAUSS_WIDTH, soft = width * YLM__GAUSS_SOFT;
  row[7] = (float)(width * width);
  row[8] = (float)(2 / (width * width));
  row[9] = (float)(soft * soft);
  for (int c = 0; c < 3; c++) row[10 + c] = lamp[YLM__VIRTUAL_EMISSION + c];
}

static ylm_status sort_lights(search *s) {
  buckets *b = &s->of_lights;
  size_t room = 64, n = s->lights->n;
  place cell;
  while (room < n / 2) room *= 2;
  *b = (buckets){.mask = room - 1};
  b->first = ylm_alloc_zero(room + 2, sizeof *b->first);
  b->order = ylm_alloc(n, sizeof *b->order);
  b->cell = ylm_alloc(n, sizeof *b->cell);
  b->field = ylm_alloc(n, YLM__NEAR_FIELDS * sizeof *b->field);
  if (!b->first || !b->order || !b->cell || !b->field) return YLM_ENOMEM;
  if (s->normals && s->lights->degree == 0) {
    b->row = ylm_alloc(n, YLM__NEAR_ROW * sizeof *b->row);
    if (!b->row) return YLM_ENOMEM;
  }
  for (size_t i = 0; i < n; i++) {
    cell_of(s, s->lights->at + 3 * i, cell);
    b->first[bucket_of(b, cell) + 2]++;
  }
  for (size_t k = 2; k < room + 2; k++) b->first[k] += b->first[k - 1];
  for (size_t i = 0; i < n; i++) {
    cell_of(s, s->lights->at + 3 * i, cell);
    put_light(s, b, b->first[bucket_of(b, cell) + 1]++, i);
  }
  return YLM_OK;
}

static void release(buckets *b) {
  ylm_free(b->first);
  ylm_free(b->order);
  ylm_free(b->cell);
  ylm_free(b->field);
  ylm_free(b->row);
}

/* -- points --------------------------------------------------------------------------------- */

/* A worker's run of points, and the lights of a cell of it. */
typedef struct worker {
  place part[RUN], least;
  uint64_t key[2][RUN];
  uint32_t order[2][RUN];
  ylm__near_lights near;
  uint32_t *list; /* [near.room] */
  void *scratch;
  uint64_t pairs;
} worker;

/* Sorts a run along the curve: numbers from `begin` on to order[0]. */
static void sort_points(const search *s, worker *w, size_t begin, size_t n) {
  uint64_t all = 0;
  for (int a = 0; a < 3; a++) w->least[a] = INT64_MAX;
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      w->part[i][a] = (int64_t)part_of(s, a, (double)s->points[3 * (begin + i) + (size_t)a]);
      if (w->part[i][a] < w->least[a]) w->least[a] = w->part[i][a];
    }
  for (int a = 0; a < 3; a++) w->least[a] &= -((int64_t)1 << FINE);
  for (size_t i = 0; i < n; i++) {
    w->key[0][i] = 0, w->order[0][i] = (uint32_t)i;
    for (int a = 0; a < 3; a++)
      w->key[0][i] |= ylm_spread3((uint64_t)(w->part[i][a] - w->least[a])) << a;
    all |= w->key[0][i];
  }
  for (int shift = 0; shift < 64 && all >> shift; shift += 8) {
    uint32_t at[257] = {0};
    for (size_t i = 0; i < n; i++) at[(w->key[0][i] >> shift & 255) + 1]++;
    for (int k = 1; k < 257; k++) at[k] += at[k - 1];
    for (size_t i = 0; i < n; i++) {
      uint32_t to = at[w->key[0][i] >> shift & 255]++;
      w->key[1][to] = w->key[0][i], w->order[1][to] = w->order[0][i];
    }
    memcpy(w->key[0], w->key[1], n * sizeof *w->key[0]);
    memcpy(w->order[0], w->order[1], n * sizeof *w->order[0]);
  }
}

/* Room for a light more, and for a vector behind it. */
static bool reserve(worker *w) {
  ylm__near_lights *l = &w->near;
  if (l->n + 16 < l->room) return true;
  size_t more = l->room ? 2 * l->room : 512;
  uint32_t *number = ylm_alloc(more, sizeof *number), *list = ylm_alloc(more, sizeof *list);
  float *field = ylm_alloc(more, YLM__NEAR_FIELDS * sizeof *field);
  if (!number || !list || !field) {
    ylm_free(number);
    ylm_free(list);
    ylm_free(field);
    return false;
  }
  if (l->n) memcpy(number, l->number, l->n * sizeof *number);
  for (size_t f = 0; f < YLM__NEAR_FIELDS; f++) {
    if (l->n) memcpy(field + f * more, l->field[f], l->n * sizeof *field);
  }
  ylm_free(l->number);
  ylm_free(l->field[0]);
  ylm_free(w->list);
  l->number = number, w->list = list, l->room = more;
  for (size_t f = 0; f < YLM__NEAR_FIELDS; f++) l->field[f] = field + f * more;
  return true;
}

/* The lights of a cell and its neighbours, in their order. */
static ylm_status gather(const search *s, worker *w, const place cell) {
  const buckets *b = &s->of_lights;
  ylm__near_lights *l = &w->near;
  l->n = 0;
  for (int i = 0; i < 27; i++) {
    place near = {cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1};
    size_t k = bucket_of(b, near);
    for (uint32_t j = b->first[k]; j < b->first[k + 1]; j++) {
      if (memcmp(b->cell[j], near, sizeof near)) continue;
      if (!reserve(w)) return YLM_ENOMEM;
      l->number[l->n] = b->row ? j : b->order[j];
      for (size_t f = 0; f < YLM__NEAR_FIELDS; f++)
        l->field[f][l->n] = b->field[f * s->lights->n + j];
      l->n++;
    }
  }
  for (size_t f = 0; l->n && f < YLM__NEAR_FIELDS; f++)
    memset(l->field[f] + l->n, 0, 16 * sizeof(float));
  return YLM_OK;
}

static ylm__near_box box_of(const search *s, int n, float (*at)[3]) {
  ylm__near_box b = {.reach = (float)s->reach};
  for (int a = 0; a < 3; a++) {
    float least = at[0][a], most = least;
    for (int k = 1; k < n; k++) least = fminf(least, at[k][a]), most = fmaxf(most, at[k][a]);
    b.middle[a] = least + 0.5f * (most - least);
    b.half[a] = fmaxf(most - b.middle[a], b.middle[a] - least);
    b.slack += 1e-6f * (fabsf(b.middle[a]) + b.half[a] + b.reach);
  }
  for (int a = 0; a < 3; a++) b.half[a] += b.slack + s->half[a];
  return b;
}

/* Says which of n boxes of a run, about points of one cell, lights may shine into. */
static ylm_status touch_cell(const search *s, worker *w, size_t begin, size_t n,
                             const uint32_t *order) {
  for (size_t i = 0; i < n; i++) {
    float at[1][3];
    size_t point = begin + order[i];
    memcpy(at[0], s->points + 3 * point, sizeof at[0]);
    ylm__near_box box = box_of(s, 1, at);
    s->touched[point] = s->kernels.cull(&w->near, &box, w->list) > 0;
  }
  return YLM_OK;
}

/* Sums for n points of a run, of one cell, whose lights are known. */
static ylm_status sum_cell(const search *s, worker *w, size_t begin, size_t n,
                           const uint32_t *order) {
  for (size_t i = 0; i < n; i += (size_t)s->kernels.lanes) {
    float at[16][3], normal[16][3];
    int lanes = n - i < (size_t)s->kernels.lanes ? (int)(n - i) : s->kernels.lanes;
    ylm__virtual_near job = {.list = w->list,
                             .lanes = lanes,
                             .points = (const float(*)[3])at,
                             .normals = s->normals ? (const float(*)[3])normal : NULL,
                             .zonal = s->zonal,
                             .rows = s->of_lights.row,
                             .row = s->row,
                             .reach = (float)s->reach};
    for (int k = 0; k < lanes; k++) {
      size_t point = begin + order[i + (size_t)k];
      memcpy(at[k], s->points + 3 * point, sizeof at[k]);
      if (s->normals) memcpy(normal[k], s->normals + 3 * point, sizeof normal[k]);
      job.out[k] = s->out + s->wide * point;
    }
    ylm__near_box box = box_of(s, lanes, at);
    job.n = s->kernels.cull(&w->near, &box, w->list);
    if (!job.n) continue;
    w->pairs += job.n * (uint64_t)lanes;
    ylm_status status =
        (s->normals ? s->kernels.irradiance : s->kernels.value)(&s->plan, &job, &w->scratch);
    if (status != YLM_OK) return status;
  }
  return YLM_OK;
}

static bool same_cell(const place a, const place b) {
  return a[0] >> FINE == b[0] >> FINE && a[1] >> FINE == b[1] >> FINE &&
         a[2] >> FINE == b[2] >> FINE;
}

static ylm_status sum_run(const search *s, worker *w, size_t begin, size_t n) {
  sort_points(s, w, begin, n);
  for (size_t i = 0, end; i < n; i = end) {
    const int64_t *own = w->part[w->order[0][i]];
    place cell = {own[0] >> FINE, own[1] >> FINE, own[2] >> FINE};
    for (end = i + 1; end < n && same_cell(w->part[w->order[0][end]], own);) end++;
    ylm_status status = gather(s, w, cell);
    if (status == YLM_OK && w->near.n)
      status = (s->touched ? touch_cell : sum_cell)(s, w, begin, end - i, w->order[0] + i);
    if (status != YLM_OK) return status;
  }
  return YLM_OK;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker_) {
  search *s = context;
  worker *w = ylm_alloc_zero(1, sizeof *w);
  ylm_status status = w ? YLM_OK : YLM_ENOMEM;
  (void)worker_;
  for (size_t k = begin; k < end && status == YLM_OK; k++) {
    size_t first = k * RUN;
    status = sum_run(s, w, first, s->n - first < RUN ? s->n - first : RUN);
  }
  if (!w) return status;
  atomic_fetch_add_explicit(&s->pairs, w->pairs, memory_order_relaxed);
  ylm_free(w->near.number);
  ylm_free(w->near.field[0]);
  ylm_free(w->list);
  ylm_free(w->scratch);
  ylm_free(w);
  return status;
}

/* -- kernels -------------------------------------------------------------------------------- */

static const ylm__near_kernels none = {0};
static YLM_KERNEL_CHOICE(const ylm__near_kernels, kernels_now, ylm__near_kernels, &none);

/* -- all ------------------------------------------------------------------------------------ */

/* The reference: the whole field of the lights, to no distance. */
static ylm_status run_plainly(search *s, const ylm_field_query *q, size_t n, ylm_error *e) {
  size_t count = ylm_sh_count(q->lmax);
  float *L = ylm_alloc(3 * count * n, sizeof *L), *Y = ylm_alloc(count * n, sizeof *Y);
  ylm_field_result r = {.value = L};
  ylm_status status = L && Y ? YLM_OK : ylm_no_memory(e);
  if (status == YLM_OK)
    status = ylm_light_virtual_evaluate(s->lights, YLM_ISA_reference, q, n, s->points, &r, e);
  if (status == YLM_OK && s->normals)
    status = ylm_sh_eval(q->lmax, 0, false, YLM_FLOAT, n, s->normals, Y, NULL, NULL, 1, e);
  for (size_t i = 0; i < n && status == YLM_OK; i++)
    for (size_t c = 0; c < 3; c++)
      for (size_t k = 0; k < count; k++) {
        float x = L[(3 * i + c) * count + k];
        int l = (int)sqrt((double)k + 0.5);
        if (s->normals)
          s->out[3 * i + c] += x * Y[i * count + k] * (float)ylm_sh_cosine_factor(l);
        else
          s->out[(3 * i + c) * count + k] += x;
      }
  ylm_free(L);
  ylm_free(Y);
  return status;
}

static ylm_status sum(search *s, const ylm_field_query *q, const ylm_progress *progress,
                      ylm_error *e) {
  ylm_status status = ylm__virtual_plan_create(&s->plan, s->lights, q);
  if (status == YLM_OK) status = sort_lights(s);
  if (status == YLM_OK)
    status = ylm_parallel((s->n + RUN - 1) / RUN, 1, q->threads, run, s, progress, "near lights");
  ylm__virtual_plan_free(&s->plan);
  release(&s->of_lights);
  return status == YLM_OK ? status : ylm_fail_plain(e, status);
}

static double length_of(const float v[3]) {
  return sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
}

static ylm_status near_sums(search *s, int lmax, size_t n, int threads,
                            const ylm_progress *progress, uint64_t *pairs, ylm_error *e) {
  ylm_field_query q = {.lmax = lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 3,
                       .dtype = YLM_FLOAT,
                       .threads = threads};
  size_t where;
  if (s->lights->profile != YLM_LIGHT_VIRTUAL_NEAR)
    return ylm_fail(e, YLM_EINVAL, "lights of profile 'near' are summed nearby, and these are '%s'",
                    ylm_light_virtual_profile_name(s->lights->profile));
  if (lmax < 0 || lmax > YLM_LIGHT_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be 0 .. %d, got %d", YLM_LIGHT_LMAX, lmax);
  if (!ylm_all_finite(YLM_FLOAT, s->points, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "point %zu is not finite", where / 3 + 1);
  for (where = 0; s->normals && where < n; where++) {
    double length = length_of(s->normals + 3 * where);
    if (!(fabs(length - 1) <= 1e-3))
      return ylm_fail(e, YLM_EDOMAIN, "normal %zu must have length 1, its length is %g", where + 1,
                      length);
  }
  if (pairs) *pairs = 0;
  if (!n || !s->lights->n) return YLM_OK;
  s->n = n;
  s->reach = YLM_LIGHT_VIRTUAL_REACH * s->lights->core;
  for (int a = 0; a < 3; a++) s->size[a] = s->reach;
  s->kernels = *kernels_now();
  ylm_status status = s->kernels.lanes ? sum(s, &q, progress, e) : run_plainly(s, &q, n, e);
  if (pairs) *pairs = s->kernels.lanes ? (uint64_t)s->pairs : (uint64_t)n * s->lights->n;
  if (status == YLM_OK && !ylm_all_finite(YLM_FLOAT, s->out, n * s->wide, &where))
    status = ylm_fail(e, YLM_ERANGE, "the light at point %zu is beyond the range of float",
                      where / s->wide + 1);
  return status;
}

ylm_status ylm_light_virtual_near_irradiance(const ylm_light_virtual *lights, int lmax, size_t n,
                                             const float *points, const float *normals, int threads,
                                             const ylm_progress *progress, float *out,
                                             uint64_t *pairs, ylm_error *e) {
  float zonal[YLM_LIGHT_LMAX + 1];
  search s = {.lights = lights,
              .points = points,
              .normals = normals,
              .out = out,
              .zonal = zonal,
              .wide = 3};
  for (int l = 0; l <= lmax && l <= YLM_LIGHT_LMAX; l++)
    zonal[l] = (float)(ylm_sh_cosine_factor(l) * (2 * l + 1) / (4 * YLM_PI));
  return near_sums(&s, lmax, n, threads, progress, pairs, e);
}

ylm_status ylm_light_virtual_near_value(const ylm_light_virtual *lights, int lmax, size_t n,
                                        const float *points, int threads,
                                        const ylm_progress *progress, float *out, uint64_t *pairs,
                                        ylm_error *e) {
  search s = {.lights = lights, .points = points, .out = out};
  if (lmax >= 0 && lmax <= YLM_LIGHT_LMAX) s.wide = 3 * ylm_sh_count(lmax);
  return near_sums(&s, lmax, n, threads, progress, pairs, e);
}

/* -- middle parts --------------------------------------------------------------------------- */

/* Runs a search for parts of lights between two cores. */
static ylm_status between(search *s, int lmax, int want, int threads, const ylm_progress *progress,
                          uint64_t *pairs) {
  ylm_field_query q = {.lmax = lmax,
                       .channels = 3,
                       .want = want,
                       .metric_channels = 3,
                       .dtype = YLM_FLOAT,
                       .threads = threads};
  s->reach = YLM_LIGHT_VIRTUAL_REACH * s->lights->outer;
  s->kernels = *kernels_now();
  if (!s->n || !s->lights->n) return YLM_OK;
  ylm_status status = sum(s, &q, progress, NULL);
  if (pairs) *pairs += (uint64_t)s->pairs;
  return status;
}

/* Cells for that reach, in which those of a lattice are nested. */
static void set_cells(search *s, const ylm__near_lattice *l) {
  const double reach = YLM_LIGHT_VIRTUAL_REACH * s->lights->outer;
  for (int a = 0; a < 3; a++) {
    s->origin[a] = l->origin[a];
    s->size[a] = l->edge[a] * ceil(reach / l->edge[a]);
    s->half[a] = (float)(0.5 * l->edge[a]);
  }
}

ylm_status ylm__near_touch(const ylm_light_virtual *lights, const ylm__near_lattice *lattice,
                           size_t n, const float *points, int threads, const ylm_progress *progress,
                           uint8_t *touched) {
  search s = {.lights = lights, .n = n, .points = points, .touched = touched};
  set_cells(&s, lattice);
  memset(touched, 0, n);
  return between(&s, 0, YLM_WANT_VALUE, threads, progress, NULL);
}

ylm_status ylm__near_rows(const ylm_light_virtual *lights, const ylm__near_lattice *lattice,
                          int lmax, size_t n, const float *points, int threads,
                          const ylm_progress *progress, float *rows, size_t row, uint64_t *pairs) {
  search s = {.lights = lights, .n = n, .points = points, .out = rows, .wide = 4 * row, .row = row};
  set_cells(&s, lattice);
  memset(s.half, 0, sizeof s.half);
  return between(&s, lmax, YLM_WANT_VALUE | YLM_WANT_GRADIENT, threads, progress, pairs);
}
