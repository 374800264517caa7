/* field.c - what surfaces send to points in space, as a light field. */
#include "gather.h"

#include "ylm_light_emitter.h"

/* A query, and the memory of each thread. */
typedef struct gather_job {
  const ylm_gather *g;
  const ylm_field_query *q;
  const void *points;
  double way[3]; /* of the scene's origin to that of the query */
  ylm_field_result *r;
  gather_want want;
  float *base;
  gather_slopes slopes;
  gather_sight **sight;
  gather_sums **sums;
  gather_direct **direct; /* where there are lamps */
} gather_job;

static ylm_status check_query(const ylm_field_query *q, size_t n, const void *points,
                              const ylm_field_result *r, ylm_error *e) {
  ylm_status s = ylm_field_check(q, n, points, r, YLM_TRANSFER_LMAX, "gathered light", e);
  if (s != YLM_OK) return s;
  for (size_t i = 0; i < 3 * n; i++)
    if (fabs(ylm_get(q->dtype, points, i)) > YLM_LIGHT_EXTENT)
      return ylm_fail(e, YLM_ERANGE, "point %zu is farther away than %g", i / 3 + 1,
                      YLM_LIGHT_EXTENT);
  return YLM_OK;
}

static gather_want want_of(const ylm_field_query *q) {
  bool metric = q->want & YLM_WANT_METRIC, hessian = q->want & YLM_WANT_HESSIAN;
  bool all = metric && q->metric_channels == 3;
  return (gather_want){.lmax = q->lmax,
                       .count = ylm_sh_count(q->lmax),
                       .channels = all ? 3 : q->channels,
                       .hessians = all || (hessian && q->channels == 3) ? 3 : metric || hessian,
                       .gradient = q->want & YLM_WANT_GRADIENT};
}

/* Number `at` of channel c, of luminance where `sum` has three and one is asked for. */
static double channel_of(const double *sum, int from, int to, int c, size_t wide, size_t at) {
  if (from == 1) return sum[at];
  if (to == 3) return sum[(size_t)c * wide + at];
  return YLM_LUMINANCE_R * sum[at] + YLM_LUMINANCE_G * sum[wide + at] +
         YLM_LUMINANCE_B * sum[2 * wide + at];
}

/* Writes sums [from][axes][count] to row `point` of an array [..][channels][count][axes]. */
static void put_rows(const gather_job *j, void *out, size_t point, const double *sum, int from,
                     size_t axes) {
  size_t count = j->want.count;
  for (int c = 0; c < j->q->channels; c++)
    for (size_t k = 0; k < count; k++)
      for (size_t a = 0; a < axes; a++)
        ylm_put(j->q->dtype, out,
                ((point * (size_t)j->q->channels + (size_t)c) * count + k) * axes + a,
                channel_of(sum, from, j->q->channels, c, axes * count, a * count + k));
}

static void put_metric(const gather_job *j, size_t point, const gather_sums *s) {
  const gather_want *w = &j->want;
  float hessian[6 * (YLM_TRANSFER_LMAX + 1) * (YLM_TRANSFER_LMAX + 1)];
  int channels = j->q->metric_channels;
  double lambda2 = 0, norm2 = 0;
  for (int c = 0; c < channels; c++) {
    for (size_t i = 0; i < 6 * w->count; i++)
      hessian[i] =
          (float)channel_of(ylm__gather_hessian(s), w->hessians, channels, c, 6 * w->count, i);
    lambda2 += (double)ylm_light_lambda2()(w->count, hessian);
    for (size_t i = 0; i < w->count; i++) {
      double x = channel_of(ylm__gather_value(s), w->channels, channels, c, w->count, i);
      norm2 += x * x;
    }
  }
  if (j->r->lambda) ylm_put(j->q->dtype, j->r->lambda, point, sqrt(lambda2));
  if (j->r->norm) ylm_put(j->q->dtype, j->r->norm, point, sqrt(norm2));
}

/* Bodies hold no light: within them the field has a value, and no derivatives. */
static void put(const gather_job *j, size_t point, const gather_sums *s) {
  const ylm_field_query *q = j->q;
  const gather_want *w = &j->want;
  if (q->want & YLM_WANT_VALUE)
    put_rows(j, j->r->value, point, ylm__gather_value(s), w->channels, 1);
  if (q->want & YLM_WANT_GRADIENT)
    put_rows(j, j->r->gradient, point, ylm__gather_gradient(s), w->channels, 3);
  if (q->want & YLM_WANT_HESSIAN)
    put_rows(j, j->r->hessian, point, ylm__gather_hessian(s), w->hessians, 6);
  if (q->want & YLM_WANT_METRIC) put_metric(j, point, s);
}

/* Adds the light of lamps at the point of a thread's sight. */
static ylm_status light(const gather_job *j, int worker, gather_sums *s, bool *inside) {
  ylm_gather *g = (ylm_gather *)j->g;
  const gather_sight *v = j->sight[worker];
  gather_direct **d = &j->direct[worker];
  double mean = YLM_LUMINANCE_R * (double)v->mean[0] + YLM_LUMINANCE_G * (double)v->mean[1] +
                YLM_LUMINANCE_B * (double)v->mean[2];
  if (!*d) *d = ylm__gather_direct_create(g, g->lamps, &j->want);
  if (!*d) return YLM_ENOMEM;
  ylm_status status = ylm__gather_direct_light(*d, v->at, 4 * YLM_PI * mean, s, inside, NULL);
  atomic_fetch_add_explicit(&g->shadow_rays, ylm__gather_direct_rays(*d), memory_order_relaxed);
  return status;
}

static ylm_status evaluate_range(void *context, size_t begin, size_t end, int worker) {
  const gather_job *j = context;
  ylm_gather *g = (ylm_gather *)j->g; /* its counters */
  gather_sight **v = &j->sight[worker];
  gather_sums **s = &j->sums[worker];
  if (!*v) *v = ylm__gather_sight_create(g);
  if (!*s) *s = ylm__gather_sums_create(g, &j->want, j->base, &j->slopes);
  if (!*v || !*s) return YLM_ENOMEM;
  for (size_t i = begin; i < end; i++) {
    float at[3];
    for (size_t a = 0; a < 3; a++)
      at[a] = (float)(ylm_get(j->q->dtype, j->points, 3 * i + a) + j->way[a]);
    ylm_status status = ylm__gather_look(*v, at);
    if (status != YLM_OK) return status;
    bool inside = (*v)->buried > 0.5f;
    ylm__gather_sum(*s, *v);
    if (g->lamps) {
      status = light(j, worker, *s, &inside);
      if (status != YLM_OK) return status;
    }
    if (inside) ylm__gather_flatten(*s);
    put(j, i, *s);
    if (j->r->inside) j->r->inside[i] = inside;
    if (j->r->validity) j->r->validity[i] = 1 - (*v)->buried;
    atomic_fetch_add_explicit(&g->points, 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&g->rays, (*v)->rays, memory_order_relaxed);
    atomic_fetch_add_explicit(&g->invalid, inside, memory_order_relaxed);
  }
  return YLM_OK;
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  const ylm_gather *g = f->self;
  ylm_status s = check_query(q, n, points, r, e);
  if (s != YLM_OK || n == 0) return s;
  size_t threads = (size_t)ylm_threads(q->threads);
  gather_job j = {.g = g, .q = q, .points = points, .r = r, .want = want_of(q)};
  const double *own = ylm_scene_origin(g->scene);
  for (int a = 0; a < 3; a++) j.way[a] = (q->origin ? q->origin[a] : 0) - (own ? own[a] : 0);
  j.base = ylm__gather_base(&g->lattice, q->lmax);
  j.sight = ylm_alloc_zero(threads, sizeof *j.sight);
  j.sums = ylm_alloc_zero(threads, sizeof *j.sums);
  j.direct = ylm_alloc_zero(threads, sizeof *j.direct);
  s = ylm__gather_slopes_create(q->lmax, &j.slopes);
  if (!j.base || !j.sight || !j.sums || !j.direct) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel(n, 1, (int)threads, evaluate_range, &j, q->progress, "gather");
  for (size_t i = 0; i < threads; i++) {
    if (j.sight) ylm__gather_sight_free(j.sight[i]);
    if (j.sums) ylm__gather_sums_free(j.sums[i]);
    if (j.direct) ylm__gather_direct_free(j.direct[i]);
  }
  ylm_free(j.base);
  ylm__gather_slopes_free(&j.slopes);
  ylm_free(j.sight);
  ylm_free(j.sums);
  ylm_free(j.direct);
  r->pairs += n;
  return s == YLM_OK ? ylm_light_finite(q, n, points, r, e) : s;
}

/* -- objects ------------------------------------------------------------------------------------ */

static ylm_status check_form(const ylm_gather_form *f, ylm_error *e) {
  if (f->base < YLM_GATHER_LEAST || f->base > YLM_GATHER_MOST)
    return ylm_fail(e, YLM_ERANGE, "base must be from %d to %d, got %d", YLM_GATHER_LEAST,
                    YLM_GATHER_MOST, f->base);
  if (f->levels < 0 || f->levels > 2)
    return ylm_fail(e, YLM_ERANGE, "levels must be from 0 to 2, got %d", f->levels);
  if (!(f->contrast >= 0) || !isfinite(f->contrast))
    return ylm_fail(e, YLM_ERANGE, "contrast must be a number that is not negative, got %g",
                    f->contrast);
  if (!(f->spacing >= 0) || !isfinite(f->spacing))
    return ylm_fail(e, YLM_ERANGE, "spacing must be a distance, got %g", f->spacing);
  if (!(f->parts & YLM_GATHER_ALL) || (f->parts & ~YLM_GATHER_ALL))
    return ylm_fail(e, YLM_ERANGE, "parts must be indirect, direct or all, got %d", (int)f->parts);
  return YLM_OK;
}

static ylm_status fill(ylm_gather *g) {
  ylm_status s = ylm__gather_lattice_create(g->form.base, g->form.levels, true, &g->lattice);
  if (s != YLM_OK) return s;
  g->most = ylm__gather_most(&g->lattice);
  if (g->form.derivatives == YLM_GATHER_POINTS) {
    g->normal = ylm_alloc(g->elements, sizeof *g->normal);
    if (!g->normal) return YLM_ENOMEM;
    ylm_transfer_elements(g->transfer, NULL, (float *)g->normal, NULL, NULL, NULL);
  }
  if (g->form.parts & YLM_GATHER_DIRECT)
    s = ylm__gather_light(g, g->form.lamps ? g->form.lamps : g->scene, &g->lamps);
  if (s == YLM_OK && g->form.remember) s = ylm__gather_memory_create(&g->memory);
  return s;
}

/* A field of `form`, which has been checked but for its base. */
static ylm_status create(const ylm_radiosity *r, const ylm_gather_form *form, ylm_gather **out) {
  ylm_gather *g = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  g->field = (ylm_field){.self = g,
                         .evaluate = evaluate,
                         .quantity = form->parts == YLM_GATHER_ALL      ? YLM_QUANTITY_all
                                     : form->parts == YLM_GATHER_DIRECT ? YLM_QUANTITY_direct
                                                                        : YLM_QUANTITY_indirect,
                         .tells_validity = true,
                         .relative = true};
  g->form = *form;
  g->radiosity = r;
  g->transfer = ylm_radiosity_transfer(r);
  g->scene = ylm_transfer_scene(g->transfer);
  g->elements = ylm_transfer_count(g->transfer);
  g->spacing = (float)(form->spacing > 0 ? form->spacing : ylm_transfer_made(g->transfer)->spacing);
  ylm_status s = fill(g);
  if (s == YLM_OK)
    *out = g;
  else
    ylm_gather_free(g);
  return s;
}

ylm_gather_form ylm_gather_defaults(void) {
  return (ylm_gather_form){.base = 16,
                           .levels = 2,
                           .contrast = 0.2,
                           .parts = YLM_GATHER_INDIRECT,
                           .derivatives = YLM_GATHER_POINTS,
                           .tolerance = 0.03};
}

/* Some lamps have no light field. */
static ylm_status check_lamps(const ylm_scene *lamps, ylm_error *e) {
  ylm_light_emitter lamp;
  for (size_t i = 0; i < ylm_scene_lamps_all(lamps); i++) {
    const char *why =
        ylm_scene_emitter(lamps, i, &lamp) ? ylm_light_emitter_fieldless(&lamp) : NULL;
    if (why)
      return ylm_fail(e, YLM_EINVAL,
                      "%s; quantity = 'indirect' has the light that it sends by way of surfaces",
                      why);
  }
  return YLM_OK;
}

ylm_status ylm_gather_lamps(ylm_gather *g, const ylm_scene *scene, ylm_error *e) {
  gather_lamps *lamps = NULL;
  if (!(g->form.parts & YLM_GATHER_DIRECT)) return YLM_OK;
  ylm_status s = check_lamps(scene, e);
  if (s != YLM_OK) return s;
  s = ylm__gather_light(g, scene, &lamps);
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  ylm__gather_dark(g->lamps);
  g->lamps = lamps;
  g->form.lamps = scene;
  return YLM_OK;
}

ylm_status ylm_gather_create(const ylm_radiosity *r, const ylm_gather_form *form, ylm_gather **out,
                             ylm_error *e) {
  *out = NULL;
  ylm_status s = check_form(form, e);
  if (s == YLM_OK && (form->parts & YLM_GATHER_DIRECT))
    s = check_lamps(form->lamps ? form->lamps : ylm_transfer_scene(ylm_radiosity_transfer(r)), e);
  return s == YLM_OK ? create(r, form, out) : s;
}

ylm_status ylm__gather_finer(const ylm_gather *g, ylm_gather **out) {
  ylm_gather_form form = g->form;
  form.base *= 2;
  form.remember = false;
  form.derivatives = YLM_GATHER_CELLS;
  return create(g->radiosity, &form, out);
}

void ylm_gather_free(ylm_gather *g) {
  if (!g) return;
  ylm__gather_lattice_free(&g->lattice);
  ylm__gather_memory_free(g->memory);
  ylm__gather_dark(g->lamps);
  ylm_free(g->normal);
  ylm_free(g);
}

const ylm_field *ylm_gather_field(const ylm_gather *g) { return &g->field; }

void ylm_gather_look(const ylm_gather *g, ylm_gather_stats *stats) {
  *stats = (ylm_gather_stats){.points = g->points,
                              .rays = g->rays,
                              .shadow_rays = g->shadow_rays,
                              .invalid = g->invalid,
                              .bytes = g->memory ? ylm__gather_memory_bytes(g->memory) : 0};
}
