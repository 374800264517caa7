/* probe.c - light that arrives at points: from all sides as spherical harmonics, or on a surface. */
#include "path.h"
#include "ylm_sh.h"

static float norm_of(const float v[3]) { return sqrtf(ylm_dot3(v, v)); }

/* The unit normal of an item; NULL: it has none. */
static const float *normal_of(const path_job *j, uint64_t item, float out[3]) {
  if (!j->normals) return NULL;
  double n[3];
  for (int a = 0; a < 3; a++) n[a] = (double)j->normals[item][a];
  ylm_unit3(n);
  for (int a = 0; a < 3; a++) out[a] = (float)n[a];
  return out;
}

/* A direction: uniform over the sphere, or as the cosine about the normal. */
static void direction_of(const path_state *p, const float *normal, float out[3]) {
  double z = normal ? sqrt(1 - p->chosen[0]) : 1 - 2 * p->chosen[0];
  double r = sqrt(fmax(0, 1 - z * z)), angle = 2 * YLM_PI * p->chosen[1];
  float d[3] = {(float)(r * cos(angle)), (float)(r * sin(angle)), (float)z}, a[3], b[3];
  if (!normal) {
    memcpy(out, d, 12);
    return;
  }
  ylm_scene_basis(normal, a, b);
  for (int k = 0; k < 3; k++) out[k] = d[0] * a[k] + d[1] * b[k] + d[2] * normal[k];
}

/* The density of path i's first direction, and of another that it may have. */
static float density_of(const path_tile *t, size_t i, const float *normal,
                        const float direction[3]) {
  if (!normal) return (float)(1 / (4 * YLM_PI));
  uint32_t cluster = t->start[i / YLM_PATH_BATCH];
  float cosine = fmaxf(0, ylm_dot3(normal, direction)) * (float)(1 / YLM_PI);
  if (cluster == PATH_UNKNOWN) return cosine;
  float guided = ylm__path_guided_density(t->job->known, cluster, direction);
  return (1 - GUIDED_PART) * cosine + GUIDED_PART * guided;
}

/* The first direction of path i, and its throughput. */
static void set_out(path_tile *t, size_t i, const float *normal) {
  path_state *p = &t->path[i];
  float *d = t->rays.ray[i].dir, u[2] = {(float)p->chosen[0], (float)p->chosen[1]}, part = 1;
  uint32_t cluster = t->start[i / YLM_PATH_BATCH];
  bool guided = cluster != PATH_UNKNOWN && p->chosen[2] < (double)GUIDED_PART;
  bool found = guided && ylm__path_guided(t->job->known, cluster, u, d);
  if (!found) direction_of(p, normal, d);
  if (cluster != PATH_UNKNOWN) {
    float cosine = fmaxf(0, ylm_dot3(normal, d)) * (float)(1 / YLM_PI);
    part = guided == found && cosine > 0 ? cosine / density_of(t, i, normal, d) : 0;
  }
  for (int c = 0; c < 3; c++) p->throughput[c] = part, p->radiance[c] = 0;
}

/* Finds the clusters of the points of all pairs, and how much light is usual there. */
static void look_up(path_tile *t) {
  const path_job *j = t->job;
  for (size_t k = 0; k < t->pairs; k++) {
    float normal[3], known[3], usual = 0;
    const float *n = normal_of(j, t->item[k], normal);
    t->start[k] = n ? ylm__path_cluster(j->known, j->points[t->item[k]], n) : PATH_UNKNOWN;
    if (t->start[k] != PATH_UNKNOWN) {
      ylm__path_expected(j, t->start[k], 0, known);
      usual = ylm__path_luminance(known) * (float)(1 / YLM_PI);
    }
    for (size_t i = 0; i < YLM_PATH_BATCH; i++) t->path[k * YLM_PATH_BATCH + i].usual = usual;
  }
}

/* Aims path i at a lamp; whether that may bring light. */
static bool aim(path_tile *t, uint32_t i, const float *normal) {
  path_lights *l = &t->lights;
  uint32_t lamp;
  float measure = 1;
  if (!ylm_scene_choose(t->lamps, t->rays.lit[i], normal)) return false;
  if (t->job->o->strategy == YLM_PATH_MATERIAL) return false;
  double pdf =
      ylm_scene_sample(t->lamps, t->path[i].light, &l->ray[l->n], l->radiance[l->n], &lamp);
  if (!(pdf > 0)) return false;
  if (normal) measure = ylm_dot3(normal, l->ray[l->n].dir);
  if (!(measure > 0)) return false;
  if (t->job->o->strategy == YLM_PATH_BOTH)
    measure *= ylm__path_balance((float)pdf, density_of(t, i, normal, l->ray[l->n].dir));
  for (int c = 0; c < 3; c++)
    t->straight[i][c] = (float)((double)(measure * l->radiance[l->n][c]) / pdf);
  memcpy(t->toward[i], l->ray[l->n].dir, 12);
  ylm_scene_start(&l->ray[l->n], t->rays.ray[i].org);
  l->of[l->n++] = i;
  return true;
}

/* Lamps without any reflection, by both kinds of rays. */
static void light_start(path_tile *t) {
  static const float none[3] = {0, 0, 0};
  t->lights.n = 0;
  ylm__path_look(t);
  for (uint32_t i = 0; i < t->rays.n; i++) {
    float n[3], x[3];
    const float *normal = normal_of(t->job, t->item[i / YLM_PATH_BATCH], n);
    const ylm_trace_ray *ray = &t->rays.ray[i];
    if (!aim(t, i, normal)) memset(t->straight[i], 0, 12);
    if (t->job->o->strategy == YLM_PATH_LIGHTS) continue;
    ylm__path_meet(t, i, density_of(t, i, normal, ray->dir), x);
    for (int c = 0; c < 3; c++) x[c] *= t->path[i].throughput[c];
    ylm__path_add(t, t->path[i].radiance, x);
  }
  ylm_trace_occluded(t->job->trace, t->lights.n, t->lights.ray);
  t->counts.shadow_rays += t->lights.n;
  for (size_t k = 0; k < t->lights.n; k++) {
    float *x = t->straight[t->lights.of[k]], sum[3] = {0, 0, 0};
    if (!(t->lights.ray[k].far < 0)) ylm__path_add(t, sum, x);
    memcpy(x, t->lights.ray[k].far < 0 ? none : sum, 12);
  }
}

static void begin(path_tile *t) {
  static const float up[3] = {0, 0, 1};
  size_t n = t->rays.n = t->pairs * YLM_PATH_BATCH;
  look_up(t);
  for (size_t i = 0; i < n; i++) {
    uint64_t item = t->item[i / YLM_PATH_BATCH];
    ylm_trace_ray *ray = &t->rays.ray[i];
    float normal[3];
    const float *about = normal_of(t->job, item, normal);
    memcpy(t->rays.lit[i], t->job->points[item], 12);
    memcpy(ray->org, t->job->origin ? t->job->origin[item] : t->job->points[item], 12);
    set_out(t, i, about);
    ray->near = 0;
    ray->far = INFINITY;
    t->rays.of[i] = (uint32_t)i;
    memcpy(t->first[i], ray->dir, 12);
    memcpy(t->toward[i], up, 12);
    memset(t->straight[i], 0, 12);
  }
  ylm_trace_nearest(t->job->trace, n, t->rays.ray, false, t->rays.hit);
  t->counts.nearest_rays += n;
  if (t->job->o->first <= 0) light_start(t);
}

static void finish_irradiance(path_tile *t, size_t k, double *values) {
  memset(values, 0, 3 * sizeof *values);
  for (size_t i = k * YLM_PATH_BATCH; i < (k + 1) * YLM_PATH_BATCH; i++)
    for (int c = 0; c < 3; c++)
      values[c] +=
          (YLM_PI * (double)t->path[i].radiance[c] + (double)t->straight[i][c]) / YLM_PATH_BATCH;
}

/* Adds radiance from one direction, whose basis functions are y. */
static void project(size_t count, const float *y, const float radiance[3], double scale,
                    double *values) {
  for (int c = 0; c < 3; c++)
    for (size_t q = 0; q < count; q++)
      values[(size_t)c * count + q] += scale * (double)radiance[c] * (double)y[q];
}

static void finish_probe(path_tile *t, size_t k, double *values) {
  size_t first = k * YLM_PATH_BATCH, count = ylm_sh_count(t->job->lmax);
  float *chosen = t->basis, *aimed = t->basis + YLM_PATH_BATCH * count;
  ylm_zero(values, t->job->values * sizeof *values);
  ylm_sh_eval(t->job->lmax, 0, false, YLM_FLOAT, YLM_PATH_BATCH, t->first + first, chosen, NULL,
              NULL, 1, NULL);
  ylm_sh_eval(t->job->lmax, 0, false, YLM_FLOAT, YLM_PATH_BATCH, t->toward + first, aimed, NULL,
              NULL, 1, NULL);
  for (size_t i = 0; i < YLM_PATH_BATCH; i++) {
    project(count, chosen + i * count, t->path[first + i].radiance, 4 * YLM_PI / YLM_PATH_BATCH,
            values);
    project(count, aimed + i * count, t->straight[first + i], 1.0 / YLM_PATH_BATCH, values);
  }
}

static ylm_status check_points(size_t n, const float (*points)[3], const float (*normals)[3],
                               ylm_error *e) {
  size_t where;
  ylm_status s = ylm_trace_check(YLM_FLOAT, n, points, "point", e);
  if (s != YLM_OK || !normals) return s;
  if (!ylm_all_finite(YLM_FLOAT, normals, 3 * n, &where))
    return ylm_fail(e, YLM_EDOMAIN, "normal %zu is not finite", where / 3 + 1);
  for (size_t i = 0; i < n; i++)
    if (!(norm_of(normals[i]) > 0)) return ylm_fail(e, YLM_EDOMAIN, "normal %zu is zero", i + 1);
  return YLM_OK;
}

/* Few points share a tile with their batches. */
static ylm_status run(path_job *j, ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e) {
  ylm_status s = check_points(j->items, j->points, j->normals, e);
  j->batches_per_tile = j->items > 0 && j->items < PATH_PAIRS ? PATH_PAIRS / j->items : 1;
  return s == YLM_OK ? ylm__path_run(j, sum, stats, e) : s;
}

/* Where rays of surfaces' points start; NULL without memory. */
static float (*origins_of(const path_job *j))[3] {
  float(*origin)[3] = ylm_alloc(j->items, sizeof *origin), n[3];
  for (uint64_t i = 0; origin && i < j->items; i++)
    ylm_scene_ray_origin(j->scene, j->points[i], normal_of(j, i, n), origin[i]);
  return origin;
}

ylm_status ylm_path_probe(const ylm_scene *scene, size_t n, const float (*points)[3], int lmax,
                          const ylm_path_options *o, ylm_path_sum *sum, ylm_path_stats *stats,
                          ylm_error *e) {
  static const path_kind kind = {"probes", begin, finish_probe};
  if (lmax < 0 || lmax > YLM_PATH_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_PATH_LMAX, lmax);
  path_job j = {.kind = &kind,
                .scene = scene,
                .o = o,
                .items = n,
                .values = 3 * ylm_sh_count(lmax),
                .points = points,
                .lmax = lmax};
  return run(&j, sum, stats, e);
}

ylm_status ylm_path_irradiance(const ylm_scene *scene, size_t n, const float (*points)[3],
                               const float (*normals)[3], const ylm_path_options *o,
                               ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e) {
  static const path_kind kind = {"irradiance", begin, finish_irradiance};
  path_job j = {.kind = &kind,
                .scene = scene,
                .o = o,
                .items = n,
                .values = 3,
                .points = points,
                .normals = normals};
  ylm_status s = check_points(n, points, normals, e);
  if (s != YLM_OK) return s;
  float(*origin)[3] = origins_of(&j);
  if (!origin) return YLM_ENOMEM;
  j.origin = (const float(*)[3])origin;
  s = run(&j, sum, stats, e);
  ylm_free(origin);
  return s;
}
