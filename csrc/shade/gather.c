/* gather.c - radiance of shading points under virtual lights: each light asked at each point. */
#include "gather_gloss.h"

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
  gather_gloss *gloss; /* NULL: all points are matte */
  float *out;
  atomic_uint_fast64_t rays;
} job;

/* Memory of one block of points. */
typedef struct scratch {
  float w[4][GATHER_CHUNK];        /* of functions or channels; of a matte base */
  float I[3][GATHER_CHUNK];        /* intensities towards the point */
  float to[GATHER_CHUNK][3];       /* directions to lights */
  float f[GATHER_CHUNK][3];        /* reflectances there */
  float *row;                      /* [ylm__gather_gloss_room] */
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

/* Puts emission of a degree as kernels want it. */
static ylm_status put_lobes(gather_lights *l) {
  const ylm_light_virtual_form *f = &l->form;
  const gather_series *s = l->series;
  size_t block = s->entries * 6 * GATHER_LOBES, count = ylm_sh_count(f->degree);
  l->lobe = ylm_alloc_zero(l->padded / GATHER_LOBES, block * sizeof *l->lobe);
  l->top = ylm_alloc_zero(l->padded / GATHER_LOBES, 1);
  if (!l->lobe || !l->top) return YLM_ENOMEM;
  for (size_t i = 0; i < l->n; i++) {
    float *to = l->lobe + i / GATHER_LOBES * block + i % GATHER_LOBES;
    uint8_t *top = &l->top[i / GATHER_LOBES];
    for (size_t c = 0; c < 3; c++)
      for (int q = 0; q <= f->degree; q++)
        for (int m = -q; m <= q; m++) {
          double b = f->emission[(3 * i + c) * count + (size_t)(q * (q + 1) + m)];
          size_t k = ylm__gather_entry(f->degree, q, m < 0 ? -m : m);
          to[(6 * k + 2 * c + (m < 0)) * GATHER_LOBES] = (float)b;
          if (b != 0 && q > *top) *top = (uint8_t)q;
        }
  }
  return YLM_OK;
}

static ylm_status read_lights(const ylm_light_virtual *from, const ylm_shade_gather_options *o,
                              const gather_series *s, gather_lights *l) {
  bool grouped = o->method == YLM_SHADE_VSGL;
  ylm_light_virtual_get(from, &l->form);
  l->n = grouped ? o->groups : l->form.n;
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
  for (size_t i = 0; i < l->n && !grouped; i++) put(l, i);
  if (grouped) {
    ylm_status status = ylm__gather_parts(from, o->groups, &l->n, l);
    if (status != YLM_OK) return status;
    l->form.degree = 0;
  }
  for (size_t i = l->n; i < l->padded; i++) l->radius[i] = 1;
  l->series = s;
  return l->form.degree > 0 ? put_lobes(l) : YLM_OK;
}

/* -- points ----------------------------------------------------------------------- */

/* Drops lights that something hides from point p, whose weights are known, `rows` of each. */
static void look(const job *j, scratch *s, size_t p, size_t first, int rows) {
  const gather_lights *l = j->lights;
  const ylm_trace *trace = ylm_scene_trace(j->view->scene);
  const float *x = j->view->origin[p];
  size_t n = 0;
  for (size_t k = 0; k < GATHER_CHUNK; k++) {
    bool counts = false;
    for (int f = 0; f < rows; f++) counts = counts || s->w[f][k] != 0;
    if (!counts) continue;
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
    for (int f = 0; s->ray[i].far < 0 && f < rows; f++) s->w[f][s->of[i]] = 0;
  s->rays += n;
}

/* Intensities of lights from `first` on towards point p. */
static void send(const job *j, scratch *s, size_t p, size_t first, const float *I[3]) {
  const gather_lights *l = j->lights;
  bool degree = l->form.degree > 0;
  bool soft = j->o->method == YLM_SHADE_HVL && l->form.profile != YLM_LIGHT_VIRTUAL_CAP &&
              l->form.profile != YLM_LIGHT_VIRTUAL_POINT;
  if (degree) j->kernels.send(l, soft, first, j->view->position[p], s->I);
  for (int c = 0; c < 3; c++) I[c] = degree ? s->I[c] : l->intensity[c] + first;
}

static void weigh(const job *j, const gather_ask *a, size_t p, size_t first, ylm_rng *rng,
                  float *w) {
  const float *x = j->view->position[p], *N = j->view->normal[p];
  if (j->o->method != YLM_SHADE_VSL) {
    j->kernels.weights(j->lights, a, first, x, N, w);
    return;
  }
  for (size_t k = 0; k < GATHER_CHUNK; k++)
    w[k] = first + k < j->lights->n ? (float)ylm__gather_sphere(j->lights, a, first + k, x, N, rng)
                                    : 0;
}

static void start_random(const job *j, uint64_t stream, ylm_rng *rng) {
  ylm_rng_seed(rng, j->o->seed, stream);
}

/* Irradiance of point p. */
static void gather(const job *j, scratch *s, size_t p, uint64_t stream) {
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
  start_random(j, stream, &rng);
  for (size_t first = 0; first < l->n; first += GATHER_CHUNK) {
    const float *I[3];
    weigh(j, &a, p, first, &rng, s->w[0]);
    if (j->o->shadows) look(j, s, p, first, 1);
    send(j, s, p, first, I);
    j->kernels.collect(s->w[0], I, sum);
  }
  for (size_t c = 0; c < 3; c++) j->out[3 * p + c] = (float)sum[c];
}

/* -- points that gloss ------------------------------------------------------------ */

static float luminous(const float x[3]) {
  return (float)(YLM_LUMINANCE_R * (double)x[0] + YLM_LUMINANCE_G * (double)x[1] +
                 YLM_LUMINANCE_B * (double)x[2]);
}

/* Weights of points: the matte ones times f, which bounds of all but the light are of too. */
static void reflect_points(const job *j, scratch *s, const gather_ask *ask,
                           const gather_receiver *r, const float tint[3], size_t p, size_t first) {
  const gather_lights *l = j->lights;
  const float *x = j->view->position[p];
  gather_ask a = *ask;
  ylm_shade_gather_options free_of_bounds = *j->o;
  bool whole = j->o->clamp == YLM_SHADE_CLAMP_WHOLE;
  uint16_t of[GATHER_CHUNK];
  size_t n = 0;
  if (whole) free_of_bounds.clamp = YLM_SHADE_CLAMP_NONE, a.o = &free_of_bounds;
  j->kernels.weights(l, &a, first, x, j->view->normal[p], s->w[0]);
  for (size_t k = 0; k < GATHER_CHUNK; k++) {
    s->w[1][k] = s->w[2][k] = 0;
    if (s->w[0][k] == 0) continue;
    float d2 = 0;
    for (int c = 0; c < 3; c++) {
      s->to[n][c] = l->at[c][first + k] - x[c];
      d2 += s->to[n][c] * s->to[n][c];
    }
    for (int c = 0; c < 3; c++) s->to[n][c] /= sqrtf(d2);
    of[n++] = (uint16_t)k;
  }
  ylm__gather_eval(r, n, (const float(*)[3])s->to, s->f);
  for (size_t i = 0; i < n; i++) {
    float g = s->w[0][of[i]];
    for (int c = 0; c < 3; c++) s->f[i][c] *= tint[c];
    float f = luminous(s->f[i]);
    if (whole && f * g > (float)j->o->limit) g = (float)j->o->limit / f;
    for (int c = 0; c < 3; c++) s->w[c][of[i]] = g * s->f[i][c];
  }
}

/* Weights of lights from `first` on in s->w, by channels or functions of the receiver; how many rows. */
static int weigh_gloss(const job *j, scratch *s, const gather_receiver *r, const float tint[3],
                       size_t p, size_t first, ylm_rng *rng) {
  const gather_lights *l = j->lights;
  const float *x = j->view->position[p], *N = j->view->normal[p];
  if (j->o->method == YLM_SHADE_VPL) {
    reflect_points(j, s, &j->ask, r, tint, p, first);
    return 3;
  }
  if (j->o->method == YLM_SHADE_VSL) {
    for (size_t k = 0; k < GATHER_CHUNK; k++) {
      double one[3] = {0, 0, 0};
      if (first + k < l->n) ylm__gather_sphere_gloss(l, &j->ask, r, first + k, x, rng, one);
      for (int c = 0; c < 3; c++) s->w[c][k] = (float)one[c] * tint[c];
    }
    return 3;
  }
  j->kernels.gloss(l, &j->ask, r, first, x, s->w);
  bool paper = j->o->method == YLM_SHADE_HVL && j->o->horizon == YLM_SHADE_HORIZON_PAPER;
  for (size_t k = 0; paper && k < GATHER_CHUNK; k++) {
    float part = first + k < l->n ? (float)ylm__gather_above(l, first + k, x, N) : 0;
    for (int f = 0; f < r->functions; f++) s->w[f][k] *= part;
  }
  if (r->zonal) {
    j->kernels.weights(l, &j->ask, first, x, N, s->w[3]);
    for (int c = 0; c < 3; c++)
      for (size_t k = 0; k < GATHER_CHUNK; k++)
        s->w[c][k] = tint[c] * (s->w[c][k] + r->base[c] * s->w[3][k]);
  }
  return r->functions;
}

/* Radiance of point p, which glosses. */
static ylm_status gather_gloss_point(const job *j, scratch *s, size_t p, uint64_t stream) {
  const gather_lights *l = j->lights;
  double sum[3][3] = {{0}}, out[3] = {0, 0, 0};
  float tint[3] = {1, 1, 1};
  gather_receiver r;
  ylm_rng rng;
  ylm__shade_tint(j->view, p, 1, tint);
  start_random(j, stream, &rng);
  ylm_status status = ylm__gather_receive(j->gloss, j->view, p, s->row, &r);
  for (size_t first = 0; status == YLM_OK && first < l->n; first += GATHER_CHUNK) {
    const float *I[3];
    int rows = weigh_gloss(j, s, &r, tint, p, first, &rng);
    if (j->o->shadows) look(j, s, p, first, rows);
    send(j, s, p, first, I);
    if (!r.mix)
      j->kernels.collect_each((const float(*)[GATHER_CHUNK])s->w, I, out);
    else
      for (int f = 0; f < rows; f++) j->kernels.collect(s->w[f], I, sum[f]);
  }
  for (int c = 0; r.mix && c < 3; c++)
    for (int f = 0; f < r.functions; f++)
      out[c] += (double)tint[c] * (double)r.mix[c][f] * sum[f][c];
  for (size_t c = 0; c < 3; c++) j->out[3 * p + c] = (float)out[c];
  return status;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  scratch *s = ylm_alloc(1, sizeof *s);
  float *row = j->gloss ? ylm_alloc(ylm__gather_gloss_room(j->gloss), sizeof *row) : NULL;
  ylm_status status = s && (row || !j->gloss) ? YLM_OK : YLM_ENOMEM;
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  if (s) s->rays = 0, s->row = row;
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    uint64_t stream = ylm__shade_stream_next(j->view, &at);
    if (ylm__gather_glosses(j->gloss, j->view, i))
      status = gather_gloss_point(j, s, i, stream);
    else
      gather(j, s, i, stream);
  }
  if (s) atomic_fetch_add_explicit(&j->rays, s->rays, memory_order_relaxed);
  ylm_free(s);
  ylm_free(row);
  return status;
}

/* From irradiance to radiance at points that do not gloss. */
static void reflect(const job *j, float *out) {
  const ylm_shade_view *v = j->view;
  for (size_t i = 0, behind; i < v->points; i = behind) {
    bool glosses = ylm__gather_glosses(j->gloss, v, i);
    for (behind = i + 1; behind < v->points && ylm__gather_glosses(j->gloss, v, behind) == glosses;)
      behind++;
    if (!glosses) ylm__shade_reflect(v, i, behind - i, out + 3 * i);
  }
}

/* -- all -------------------------------------------------------------------------- */

static ylm_status check(const ylm_shade_gather_options *o, const ylm_light_virtual_form *f,
                        ylm_error *e) {
  if (o->lmax < 0 || o->lmax > YLM_SHADE_GATHER_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_SHADE_GATHER_LMAX,
                    o->lmax);
  if (o->method == YLM_SHADE_VPL && o->clamp != YLM_SHADE_CLAMP_NONE && !(o->limit > 0))
    return ylm_fail(e, YLM_ERANGE, "limit must be above 0, got %g", o->limit);
  if (o->compensate < 0 || o->compensate > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "compensate must be from 0 to 65536, got %d", o->compensate);
  if (o->compensate && (o->method != YLM_SHADE_VPL || o->clamp == YLM_SHADE_CLAMP_NONE))
    return ylm_fail(e, YLM_EINVAL, "compensate is for points with a clamp");
  if (o->method == YLM_SHADE_VSGL && f->n > 0 && (o->groups < 1 || o->groups > f->n))
    return ylm_fail(e, YLM_ERANGE, "groups must be from 1 to %zu, the lights, got %zu", f->n,
                    o->groups);
  if (o->method != YLM_SHADE_VSL) return YLM_OK;
  if (o->samples < 1 || o->samples > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "samples must be from 1 to 65536, got %d", o->samples);
  for (size_t i = 0; i < f->n; i++)
    if (!(f->radius && f->radius[i] > 0))
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
  gather_series series = {0};
  job j = {.view = v,
           .o = o,
           .lights = &l,
           .ask = {.o = o},
           .kernels = ylm__gather_kernels(o),
           .out = out};
  ylm_light_virtual_form form;
  ylm_light_virtual_get(from, &form);
  ylm_status s = ylm__gather_series(form.degree, &series);
  if (s == YLM_OK) s = check(o, &form, e);
  if (s == YLM_OK) s = read_lights(from, o, &series, &l);
  if (s == YLM_OK) s = make_ask(&j.ask, &l);
  if (s == YLM_OK) s = ylm__gather_gloss(v, o, &j.gloss, e);
  if (s == YLM_OK)
    s = ylm_parallel(v->points, o->method == YLM_SHADE_VSL && o->samples > MANY ? 1 : GRAIN,
                     o->threads, run, &j, o->progress, "virtual lights");
  uint64_t rays = j.rays, singular = 0;
  if (s == YLM_OK && (o->method == YLM_SHADE_VPL || form.profile == YLM_LIGHT_VIRTUAL_POINT))
    s = ylm__gather_singular(v, &l, &singular);
  if (s == YLM_OK && o->compensate) s = ylm__gather_compensate(v, &j.ask, j.gloss, out, &rays, e);
  if (s == YLM_OK) reflect(&j, out);
  if (s == YLM_OK && !ylm_all_finite(YLM_FLOAT, out, 3 * v->points, &where))
    s = ylm_fail(e, YLM_ERANGE,
                 "the light at shading point %zu is beyond the range of float: lower the lights' "
                 "intensity",
                 where / 3 + 1);
  ylm_free(l.memory);
  ylm_free(l.lobe);
  ylm_free(l.top);
  ylm__gather_series_free(&series);
  ylm__gather_gloss_free(j.gloss);
  *report = (ylm_shade_gather_report){.pairs = (uint64_t)v->points * l.n,
                                      .rays = rays,
                                      .singular = singular,
                                      .lights = l.n,
                                      .seconds = ylm_seconds() - begun};
  return s;
}
