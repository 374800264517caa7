/*
** near.c - sums over the virtual lights near to points.
**
** Lights are sorted into cells of the size of their reach, cells into buckets by a hash. Points of one
** cell share the lights of its 27 neighbours, and are summed as many at a time as a vector has lanes.
*/
#include <string.h>

#include "plan.h"
#include "ylm_sh.h"

typedef int64_t place[3];

/* Numbers sorted by the bucket of their cell. */
typedef struct buckets {
  size_t n, mask;
  uint32_t *first, *order; /* [mask+2], [n] */
} buckets;

typedef struct search {
  const ylm_light_virtual *lights;
  double size;
  buckets of_lights, of_points;
  const float *points, *normals;
  float *out, *zonal;
  size_t wide; /* numbers of a point's result */
  int lanes;
  ylm__virtual_near_fn *kernel;
  ylm__virtual_plan plan;
} search;

static void cell_of(double size, const double at[3], place cell) {
  for (int a = 0; a < 3; a++) cell[a] = (int64_t)fmax(-4e18, fmin(4e18, floor(at[a] / size)));
}

static void cell_of_point(const search *s, size_t i, place cell) {
  double at[3] = {(double)s->points[3 * i], (double)s->points[3 * i + 1],
                  (double)s->points[3 * i + 2]};
  cell_of(s->size, at, cell);
}

static size_t bucket_of(const buckets *b, const place cell) {
  uint64_t h = 0;
  for (int a = 0; a < 3; a++) h = (h ^ (uint64_t)cell[a]) * 0x9e3779b97f4a7c15u;
  return (size_t)(h >> 32) & b->mask;
}

/* Sorts; `cell` finds that of a number. */
typedef void cell_fn(const search *s, size_t i, place cell);
static void cell_of_light(const search *s, size_t i, place cell) {
  cell_of(s->size, s->lights->at + 3 * i, cell);
}

static ylm_status sort(const search *s, size_t n, cell_fn *find, buckets *b) {
  size_t room = 64;
  place cell;
  while (room < n / 2) room *= 2;
  *b = (buckets){.n = n, .mask = room - 1};
  b->first = ylm_alloc_zero(room + 2, sizeof *b->first);
  b->order = ylm_alloc(n, sizeof *b->order);
  if (!b->first || !b->order) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    find(s, i, cell);
    b->first[bucket_of(b, cell) + 2]++;
  }
  for (size_t k = 2; k < room + 2; k++) b->first[k] += b->first[k - 1];
  for (size_t i = 0; i < n; i++) {
    find(s, i, cell);
    b->order[b->first[bucket_of(b, cell) + 1]++] = (uint32_t)i;
  }
  return YLM_OK;
}

static void release(buckets *b) {
  ylm_free(b->first);
  ylm_free(b->order);
}

/* A worker's lists. */
typedef struct worker {
  uint32_t *list, *mine; /* lights; points of one cell */
  size_t room, room_mine;
  void *scratch;
} worker;

static bool append(uint32_t **list, size_t *room, size_t n, uint32_t x) {
  if (n == *room) {
    size_t more = *room ? 2 * *room : 256;
    uint32_t *p = ylm_realloc(*list, n * sizeof *p, more, sizeof *p);
    if (!p) return false;
    *list = p, *room = more;
  }
  (*list)[n] = x;
  return true;
}

/* The lights of a cell and its neighbours, in their order; how many, or SIZE_MAX without memory. */
static size_t gather(const search *s, worker *w, const place cell) {
  size_t n = 0;
  for (int i = 0; i < 27; i++) {
    place near = {cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1}, own;
    size_t k = bucket_of(&s->of_lights, near);
    for (uint32_t j = s->of_lights.first[k]; j < s->of_lights.first[k + 1]; j++) {
      uint32_t light = s->of_lights.order[j];
      cell_of_light(s, light, own);
      if (memcmp(own, near, sizeof own)) continue;
      if (!append(&w->list, &w->room, n, light)) return SIZE_MAX;
      n++;
    }
  }
  return n;
}

/* Sums for n points of a cell. */
static ylm_status sum_cell(const search *s, worker *w, size_t n, const place cell) {
  size_t lights = gather(s, w, cell);
  if (lights == SIZE_MAX) return YLM_ENOMEM;
  for (size_t i = 0; i < n && lights; i += (size_t)s->lanes) {
    float at[16][3], normal[16][3];
    int lanes = n - i < (size_t)s->lanes ? (int)(n - i) : s->lanes;
    ylm__virtual_near job = {.list = w->list,
                             .n = lights,
                             .lanes = lanes,
                             .points = (const float(*)[3])at,
                             .normals = s->normals ? (const float(*)[3])normal : NULL,
                             .zonal = s->zonal,
                             .reach = (float)s->size};
    for (int k = 0; k < lanes; k++) {
      size_t point = w->mine[i + (size_t)k];
      memcpy(at[k], s->points + 3 * point, sizeof at[k]);
      if (s->normals) memcpy(normal[k], s->normals + 3 * point, sizeof normal[k]);
      job.out[k] = s->out + s->wide * point;
    }
    ylm_status status = s->kernel(&s->plan, &job, &w->scratch);
    if (status != YLM_OK) return status;
  }
  return YLM_OK;
}

/* The points of a bucket, cell by cell. */
static ylm_status sum_bucket(const search *s, worker *w, size_t bucket) {
  const buckets *b = &s->of_points;
  uint32_t *order = b->order, end = b->first[bucket + 1];
  for (uint32_t begin = b->first[bucket]; begin < end;) {
    place cell, own;
    size_t n = 0;
    uint32_t left = end;
    cell_of_point(s, order[begin], cell);
    for (uint32_t j = begin; j < left;) {
      cell_of_point(s, order[j], own);
      if (memcmp(own, cell, sizeof own) == 0) {
        if (!append(&w->mine, &w->room_mine, n++, order[j])) return YLM_ENOMEM;
        j++;
        continue;
      }
      uint32_t other = order[j]; /* of another cell: to the end, for later */
      order[j] = order[--left];
      order[left] = other;
    }
    ylm_status status = sum_cell(s, w, n, cell);
    if (status != YLM_OK) return status;
    begin += (uint32_t)n;
  }
  return YLM_OK;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker_) {
  const search *s = context;
  worker w = {0};
  ylm_status status = YLM_OK;
  (void)worker_;
  for (size_t k = begin; k < end && status == YLM_OK; k++) status = sum_bucket(s, &w, k);
  ylm_free(w.list);
  ylm_free(w.mine);
  ylm_free(w.scratch);
  return status;
}

/* The reference: the whole field of the lights, to no distance. */
static ylm_status run_plainly(search *s, const ylm_field_query *q, size_t n, ylm_error *e) {
  size_t count = ylm_sh_count(q->lmax);
  float *L = ylm_alloc(3 * count * n, sizeof *L), *Y = ylm_alloc(count * n, sizeof *Y);
  ylm_field_result r = {.value = L};
  ylm_status status = L && Y ? YLM_OK : ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
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

static ylm_status sum(search *s, const ylm_field_query *q, size_t n, ylm_error *e) {
  ylm_status status = ylm__virtual_plan_create(&s->plan, s->lights, q);
  if (status == YLM_OK) status = sort(s, s->lights->n, cell_of_light, &s->of_lights);
  if (status == YLM_OK) status = sort(s, n, cell_of_point, &s->of_points);
  if (status == YLM_OK)
    status = ylm_parallel(s->of_points.mask + 1, 8, q->threads, run, s, NULL, "lights");
  ylm__virtual_plan_free(&s->plan);
  release(&s->of_lights);
  release(&s->of_points);
  return status == YLM_OK ? status : ylm_fail(e, status, "%s", ylm_status_text(status));
}

static double length_of(const float v[3]) {
  return sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
}

static ylm_status near_sums(search *s, int lmax, size_t n, int threads, ylm_error *e) {
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
  if (n >= UINT32_MAX) return ylm_fail(e, YLM_ERANGE, "%zu points are too many", n);
  if (!n || !s->lights->n) return YLM_OK;
  s->size = YLM_LIGHT_VIRTUAL_REACH * s->lights->core;
  s->kernel = ylm__virtual_near_kernel(ylm_isa_current(), &s->lanes);
  ylm_status status = s->kernel ? sum(s, &q, n, e) : run_plainly(s, &q, n, e);
  if (status == YLM_OK && !ylm_all_finite(YLM_FLOAT, s->out, n * s->wide, &where))
    status = ylm_fail(e, YLM_ERANGE, "the light at point %zu is beyond the range of float",
                      where / s->wide + 1);
  return status;
}

ylm_status ylm_light_virtual_near_irradiance(const ylm_light_virtual *lights, int lmax, size_t n,
                                             const float *points, const float *normals, int threads,
                                             float *out, ylm_error *e) {
  float zonal[YLM_LIGHT_LMAX + 1];
  search s = {.lights = lights,
              .points = points,
              .normals = normals,
              .out = out,
              .zonal = zonal,
              .wide = 3};
  for (int l = 0; l <= lmax && l <= YLM_LIGHT_LMAX; l++)
    zonal[l] = (float)(ylm_sh_cosine_factor(l) * (2 * l + 1) / (4 * M_PI));
  return near_sums(&s, lmax, n, threads, e);
}

ylm_status ylm_light_virtual_near_value(const ylm_light_virtual *lights, int lmax, size_t n,
                                        const float *points, int threads, float *out,
                                        ylm_error *e) {
  search s = {.lights = lights, .points = points, .out = out};
  if (lmax >= 0 && lmax <= YLM_LIGHT_LMAX) s.wide = 3 * ylm_sh_count(lmax);
  return near_sums(&s, lmax, n, threads, e);
}
