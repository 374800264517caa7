/* gather.c - radiance of shading points under virtual lights: each light asked at each point. */
#include "gather.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "ylm_sh.h"

#define GRAIN 64
#define MANY 256 /* samples of spheres, above which a point alone is work to report */

typedef struct job {
  const ylm_shade_view *view;
  const ylm_shade_gather_options *o;
  const gather_lights *lights;
  gather_ask ask;
  gather_kernels kernels;
  float *out;
  atomic_uint_fast64_t rays;
} job;

/* Memory of one block of points. */
typedef struct scratch {
  float w[GATHER_CHUNK];
  float u[GATHER_CHUNK][3];        /* directions in which light leaves, shorter than 1 */
  float I[3][GATHER_CHUNK];        /* intensities there */
  float *basis;                    /* [GATHER_CHUNK][(degree+1)^2] */
  ylm_trace_ray ray[GATHER_CHUNK]; /* to the middles of lights */
  uint16_t of[GATHER_CHUNK];
  uint64_t rays;
} scratch;

/* -- lights ----------------------------------------------------------------------- */

static void put(const gather_lights *l, size_t i) {
  const ylm_light_virtual_form *f = &l->form;
  bool turned = false;
  for (size_t k = 0; k < 3; k++) {
    l->at[k][i] = (float)f->at[3 * i + k];
    l->normal[k][i] = f->normal ? (float)f->normal[3 * i + k] : 0;
    turned = turned || l->normal[k][i] != 0;
    if (f->degree == 0)
      l->intensity[k][i] = (float)(f->emission[3 * i + k] / (double)YLM_SHADE_OPEN);
  }
  l->shift[i] = turned ? (f->shift ? (float)f->shift[i] : 0) : 1;
  l->radius[i] = f->radius ? (float)f->radius[i] : 0;
}

static ylm_status read_lights(const ylm_light_virtual *from, gather_lights *l) {
  ylm_light_virtual_get(from, &l->form);
  l->n = l->form.n;
  l->padded = (l->n + GATHER_CHUNK - 1) / GATHER_CHUNK * GATHER_CHUNK;
  float *p = l->memory = ylm_alloc_zero(11 * l->padded, sizeof *p);
  if (!p) return YLM_ENOMEM;
  for (int k = 0; k < 3; k++) {
    l->at[k] = p + (size_t)k * l->padded;
    l->normal[k] = p + (size_t)(3 + k) * l->padded;
    l->intensity[k] = p + (size_t)(8 + k) * l->padded;
  }
  l->shift = p + 6 * l->padded;
  l->radius = p + 7 * l->padded;
  for (size_t i = 0; i < l->n; i++) put(l, i);
  for (size_t i = l->n; i < l->padded; i++) l->radius[i] = 1;
  return YLM_OK;
}

/* -- points ----------------------------------------------------------------------- */

/* Drops lights that something hides from point p, whose weights w are known. */
static void look(const job *j, scratch *s, size_t p, size_t first, float *w) {
  const gather_lights *l = j->lights;
  const ylm_trace *trace = ylm_scene_trace(j->view->scene);
  const float *x = j->view->origin[p];
  size_t n = 0;
  for (size_t k = 0; k < GATHER_CHUNK; k++) {
    if (w[k] == 0) continue;
    ylm_trace_ray *ray = &s->ray[n];
    float d2 = 0;
    for (int a = 0; a < 3; a++) {
      ray->org[a] = x[a];
      ray->dir[a] = l->at[a][first + k] - x[a];
      d2 += ray->dir[a] * ray->dir[a];
    }
    float d = sqrtf(d2);
    if (!(d > 0)) continue;
    for (int a = 0; a < 3; a++) ray->dir[a] /= d;
    ray->near = 0;
    ray->far = fmaxf(0, d * (1 - 1e-4f) - ylm_trace_offset(trace));
    s->of[n++] = (uint16_t)k;
  }
  ylm_trace_occluded(trace, n, s->ray);
  for (size_t i = 0; i < n; i++)
    if (s->ray[i].far < 0) w[s->of[i]] = 0;
  s->rays += n;
}

/* Intensities of lights whose emission has a degree, towards x. */
static ylm_status send(const job *j, scratch *s, const float x[3], size_t first) {
  const gather_lights *l = j->lights;
  const ylm_light_virtual_form *f = &l->form;
  size_t count = ylm_sh_count(f->degree),
         n = l->n - first < GATHER_CHUNK ? l->n - first : GATHER_CHUNK;
  bool soft = j->o->method == YLM_SHADE_HVL && f->profile != YLM_LIGHT_VIRTUAL_CAP &&
              f->profile != YLM_LIGHT_VIRTUAL_POINT;
  for (size_t k = 0; k < n; k++) {
    float d2 = soft ? l->radius[first + k] * l->radius[first + k] / 64 : 0;
    for (int a = 0; a < 3; a++) {
      s->u[k][a] = x[a] - l->at[a][first + k];
      d2 += s->u[k][a] * s->u[k][a];
    }
    float d = sqrtf(d2);
    for (int a = 0; a < 3; a++) s->u[k][a] = d > 0 ? s->u[k][a] / d : 0;
    if (!(d > 0) || (s->u[k][0] == 0 && s->u[k][1] == 0 && s->u[k][2] == 0)) s->u[k][2] = 1e-20f;
  }
  ylm_status status =
      ylm_sh_eval(f->degree, 0, true, YLM_FLOAT, n, s->u[0], s->basis, NULL, NULL, 1, NULL);
  memset(s->I, 0, sizeof s->I);
  for (size_t k = 0; status == YLM_OK && k < n; k++)
    for (size_t c = 0; c < 3; c++) {
      const double *b = f->emission + (3 * (first + k) + c) * count;
      double sum = 0;
      for (size_t q = 0; q < count; q++) sum += b[q] * (double)s->basis[k * count + q];
      s->I[c][k] = (float)sum;
    }
  return status;
}

static void weigh(const job *j, scratch *s, const gather_ask *a, size_t p, size_t first,
                  ylm_rng *rng) {
  const float *x = j->view->position[p], *N = j->view->normal[p];
  if (j->o->method != YLM_SHADE_VSL) {
    j->kernels.weights(j->lights, a, first, x, N, s->w);
    return;
  }
  for (size_t k = 0; k < GATHER_CHUNK; k++)
    s->w[k] = first + k < j->lights->n
                  ? (float)ylm__gather_sphere(j->lights, a, first + k, x, N, rng)
                  : 0;
}

/* Irradiance of point p. */
static ylm_status gather(const job *j, scratch *s, size_t p, uint64_t stream) {
  const gather_lights *l = j->lights;
  gather_ask a = j->ask;
  double sum[3] = {0, 0, 0};
  float albedo[3];
  ylm_rng rng;
  ylm__shade_albedo(j->view, p, albedo);
  a.reflectance =
      (float)(YLM_LUMINANCE_R * (double)albedo[0] + YLM_LUMINANCE_G * (double)albedo[1] +
              YLM_LUMINANCE_B * (double)albedo[2]) *
      0.318309886f;
  ylm_rng_seed(&rng, j->o->seed, stream);
  for (size_t first = 0; first < l->n; first += GATHER_CHUNK) {
    const float *I[3];
    weigh(j, s, &a, p, first, &rng);
    if (j->o->shadows) look(j, s, p, first, s->w);
    if (l->form.degree > 0) {
      ylm_status status = send(j, s, j->view->position[p], first);
      if (status != YLM_OK) return status;
    }
    for (int c = 0; c < 3; c++) I[c] = l->form.degree > 0 ? s->I[c] : l->intensity[c] + first;
    j->kernels.collect(s->w, I, sum);
  }
  for (size_t c = 0; c < 3; c++) j->out[3 * p + c] = (float)sum[c];
  return YLM_OK;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  int degree = j->lights->form.degree;
  scratch *s = ylm_alloc(1, sizeof *s);
  float *basis = degree > 0 ? ylm_alloc(GATHER_CHUNK, ylm_sh_count(degree) * sizeof *basis) : NULL;
  ylm_status status = s && (basis || degree == 0) ? YLM_OK : YLM_ENOMEM;
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  if (s) s->rays = 0, s->basis = basis;
  for (size_t i = begin; status == YLM_OK && i < end; i++)
    status = gather(j, s, i, ylm__shade_stream_next(j->view, &at));
  if (s) atomic_fetch_add_explicit(&j->rays, s->rays, memory_order_relaxed);
  ylm_free(s);
  ylm_free(basis);
  return status;
}

/* -- all -------------------------------------------------------------------------- */

static ylm_status check(const ylm_shade_gather_options *o, const gather_lights *l, ylm_error *e) {
  if (o->lmax < 0 || o->lmax > YLM_SHADE_GATHER_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_SHADE_GATHER_LMAX,
                    o->lmax);
  if (o->method == YLM_SHADE_VPL && o->clamp != YLM_SHADE_CLAMP_NONE && !(o->limit > 0))
    return ylm_fail(e, YLM_ERANGE, "limit must be above 0, got %g", o->limit);
  if (o->compensate < 0 || o->compensate > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "compensate must be from 0 to 65536, got %d", o->compensate);
  if (o->compensate && (o->method != YLM_SHADE_VPL || o->clamp == YLM_SHADE_CLAMP_NONE))
    return ylm_fail(e, YLM_EINVAL, "compensate is for points with a clamp");
  if (o->method != YLM_SHADE_VSL) return YLM_OK;
  if (o->samples < 1 || o->samples > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "samples must be from 1 to 65536, got %d", o->samples);
  for (size_t i = 0; i < l->n; i++)
    if (!(l->radius[i] > 0))
      return ylm_fail(e, YLM_EDOMAIN, "light %zu has no radius: it is no sphere", i + 1);
  return YLM_OK;
}

static ylm_status make_ask(gather_ask *a, const gather_lights *l) {
  const ylm_shade_gather_options *o = a->o;
  double zonal[YLM_SHADE_GATHER_LMAX + 1], R2 = l->form.core * l->form.core;
  ylm_status s = ylm_material_cosine(o->lmax, zonal);
  for (int k = 0; s == YLM_OK && k <= o->lmax; k++)
    a->zonal[k] = (float)(zonal[k] * (2 * k + 1) / (4 * 3.14159265358979323846) *
                          (o->window ? o->window[k] : 1));
  a->core = R2 > 0 ? (float)(1 / (R2 * R2)) : 0;
  return s;
}

ylm_status ylm_shade_gather_virtual(const ylm_shade_view *v, const ylm_light_virtual *from,
                                    const ylm_shade_gather_options *o, float *out,
                                    ylm_shade_gather_report *report, ylm_error *e) {
  double begun = ylm_seconds();
  size_t where;
  gather_lights l = {0};
  job j = {.view = v,
           .o = o,
           .lights = &l,
           .ask = {.o = o},
           .kernels = ylm__gather_kernels(o),
           .out = out};
  ylm_status s = read_lights(from, &l);
  if (s == YLM_OK) s = check(o, &l, e);
  if (s == YLM_OK) s = make_ask(&j.ask, &l);
  if (s == YLM_OK)
    s = ylm_parallel(v->points, o->method == YLM_SHADE_VSL && o->samples > MANY ? 1 : GRAIN,
                     o->threads, run, &j, o->progress, "virtual lights");
  uint64_t rays = j.rays;
  if (s == YLM_OK && o->compensate) s = ylm__gather_compensate(v, &j.ask, out, &rays, e);
  if (s == YLM_OK) ylm__shade_reflect(v, 0, v->points, out);
  if (s == YLM_OK && !ylm_all_finite(YLM_FLOAT, out, 3 * v->points, &where))
    s = ylm_fail(e, YLM_ERANGE,
                 "the light at shading point %zu is beyond the range of float: lower the lights' "
                 "intensity",
                 where / 3 + 1);
  ylm_free(l.memory);
  *report = (ylm_shade_gather_report){(uint64_t)v->points * l.n, rays, ylm_seconds() - begun};
  return s;
}
