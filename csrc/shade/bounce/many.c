/* many.c - radiance of shading points under virtual lights: each light asked at each point. */
#include "many_gloss.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "ylm_sh.h"

#define GRAIN 64
#define ALPHA_POINTS 64
#define MANY 256 /* samples of spheres, above which a point alone is work to report */

typedef struct job {
  const ylm_shade_view *view;
  const ylm_shade_gather_options *o;
  const ylm_many_lights *lights;
  ylm_many_ask ask;
  ylm_many_kernels kernels;
  many_gloss *gloss; /* NULL: all points are matte */
  float *out;
  atomic_uint_fast64_t rays, pairs, kept;
} job;

/* Memory of one block of points. */
typedef struct scratch {
  float w[4][YLM_MANY_CHUNK];        /* of functions or channels; of a matte base */
  float I[3][YLM_MANY_CHUNK];        /* intensities towards the point */
  float to[YLM_MANY_CHUNK][3];       /* directions to lights */
  float f[YLM_MANY_CHUNK][3];        /* reflectances there */
  float keep[YLM_MANY_CHUNK];        /* factors of lights, where few are kept */
  float *row;                        /* [ylm__many_gloss_room] */
  ylm_trace_ray ray[YLM_MANY_CHUNK]; /* to the middles of lights */
  uint16_t of[YLM_MANY_CHUNK];
  uint64_t rays, pairs, kept;
  size_t begin, end; /* lights that the point asks */
  many_walk walk;    /* along them, where few are kept */
} scratch;

static _Atomic(const ylm_shade_rival *) known;

void ylm_shade_rival_set(const ylm_shade_rival *rival) { atomic_store(&known, rival); }

/* -- lights ----------------------------------------------------------------------- */

/* Puts light i in place `to`. */
static void put(const ylm_many_lights *l, size_t i, size_t to) {
  const ylm_light_virtual_form *f = &l->form;
  bool turned = false;
  for (size_t k = 0; k < 3; k++) {
    l->at[k][to] = (float)f->at[3 * i + k];
    l->normal[k][to] = f->normal ? (float)f->normal[3 * i + k] : 0;
    turned = turned || l->normal[k][to] != 0;
    if (f->degree == 0)
      l->intensity[k][to] = (float)(f->emission[3 * i + k] / (double)YLM_SHADE_OPEN);
  }
  l->shift[to] = turned ? (f->shift ? (float)f->shift[i] : 0) : 1;
  l->radius[to] = f->radius ? (float)f->radius[i] : 0;
}

/* Puts emission of a degree of light i in place `to` as kernels want it. */
static void put_lobes(const ylm_many_lights *l, size_t i, size_t place) {
  const ylm_light_virtual_form *f = &l->form;
  size_t block = l->series->entries * 6 * YLM_MANY_LOBES, count = ylm_sh_count(f->degree);
  float *to = l->lobe + place / YLM_MANY_LOBES * block + place % YLM_MANY_LOBES;
  uint8_t *top = &l->top[place / YLM_MANY_LOBES];
  for (size_t c = 0; c < 3; c++)
    for (int q = 0; q <= f->degree; q++)
      for (int m = -q; m <= q; m++) {
        double b = f->emission[(3 * i + c) * count + (size_t)(q * (q + 1) + m)];
        size_t k = ylm_many_entry(f->degree, q, m < 0 ? -m : m);
        to[(6 * k + 2 * c + (m < 0)) * YLM_MANY_LOBES] = (float)b;
        if (b != 0 && q > *top) *top = (uint8_t)q;
      }
}

/* The luminance of light i; of a degree its root mean square over directions. */
static float bright(const ylm_many_lights *l, size_t i) {
  const ylm_light_virtual_form *f = &l->form;
  size_t count = ylm_sh_count(f->degree);
  double I[3];
  for (size_t c = 0; c < 3; c++) {
    double sum = 0;
    for (size_t q = 0; q < count; q++)
      sum += f->emission[(3 * i + c) * count + q] * f->emission[(3 * i + c) * count + q];
    I[c] = sqrt(sum) / (double)YLM_SHADE_OPEN;
  }
  return (float)ylm_luminance_size(I);
}

static ylm_status make_room(ylm_many_lights *l, const ylm_shade_gather_options *o) {
  size_t side = o->subset == YLM_SHADE_INTERLEAVED ? (size_t)o->tile : 1,
         g = l->groups = side * side;
  l->n = o->method == YLM_SHADE_VSGL ? o->groups : l->form.n;
  l->padded = (l->n + YLM_MANY_CHUNK - 1) / YLM_MANY_CHUNK * YLM_MANY_CHUNK;
  if (g > 1) {
    l->begin = ylm_alloc(g + 1, sizeof *l->begin);
    if (!l->begin) return YLM_ENOMEM;
    l->padded = 0;
    for (size_t k = 0; k <= g; k++) {
      size_t own = l->n > k ? (l->n - k + g - 1) / g : 0;
      l->begin[k] = l->padded;
      if (k < g) l->padded += (own + YLM_MANY_LOBES - 1) / YLM_MANY_LOBES * YLM_MANY_LOBES;
    }
    l->n = l->padded;
  }
  float *p = l->memory = ylm_alloc_zero(12 * l->padded, sizeof *p);
  if (!p) return YLM_ENOMEM;
  for (int k = 0; k < 3; k++) {
    l->at[k] = p + (size_t)k * l->padded;
    l->normal[k] = p + (size_t)(3 + k) * l->padded;
    l->intensity[k] = p + (size_t)(8 + k) * l->padded;
  }
  l->shift = p + 6 * l->padded;
  l->radius = p + 7 * l->padded;
  if (o->subset == YLM_SHADE_STOCHASTIC) l->bright = p + 11 * l->padded;
  for (size_t i = 0; i < l->padded; i++) l->radius[i] = 1;
  if (l->form.degree == 0) return YLM_OK;
  l->lobe = ylm_alloc_zero(l->padded / YLM_MANY_LOBES,
                           l->series->entries * 6 * YLM_MANY_LOBES * sizeof *l->lobe);
  l->top = ylm_alloc_zero(l->padded / YLM_MANY_LOBES, 1);
  return l->lobe && l->top ? YLM_OK : YLM_ENOMEM;
}

static ylm_status read_lights(const ylm_light_virtual *from, const ylm_shade_gather_options *o,
                              const ylm_shade_rival *rival, const ylm_many_series *s,
                              ylm_many_lights *l) {
  ylm_light_virtual_get(from, &l->form);
  l->series = s;
  ylm_status status = make_room(l, o);
  if (status == YLM_OK && o->method == YLM_SHADE_VSGL) {
    l->form.degree = 0;
    return rival->parts(from, o->groups, &l->n, l);
  }
  for (size_t i = 0; status == YLM_OK && i < l->form.n; i++) {
    size_t to = l->begin ? l->begin[i % l->groups] + i / l->groups : i;
    put(l, i, to);
    if (l->form.degree > 0) put_lobes(l, i, to);
    if (l->bright) l->bright[to] = bright(l, i);
  }
  return status;
}

/* -- points ----------------------------------------------------------------------- */

/* Drops lights that something hides from point p, whose weights are known, `rows` of each. */
static void look(const job *j, scratch *s, size_t p, size_t first, size_t lights, int rows) {
  const ylm_many_lights *l = j->lights;
  const ylm_trace *trace = ylm_scene_trace(j->view->scene);
  const float *x = j->view->origin[p];
  size_t n = 0;
  for (size_t k = 0; k < lights; k++) {
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
    float d = sqrtf(d2), at[3];
    if (!(d > 0)) continue;
    for (int a = 0; a < 3; a++) ray->dir[a] /= d, at[a] = l->at[a][first + k];
    ray->near = 0;
    ray->far = fmaxf(0, d * (1 - 1e-4f) - ylm_trace_offset(trace, at));
    s->of[n++] = (uint16_t)k;
  }
  ylm_trace_occluded(trace, n, s->ray);
  for (size_t i = 0; i < n; i++)
    for (int f = 0; s->ray[i].far < 0 && f < rows; f++) s->w[f][s->of[i]] = 0;
  s->rays += n;
}

/* Intensities of lights from `first` on towards point p. */
static void send(const job *j, scratch *s, size_t p, size_t first, size_t n, const float *I[3]) {
  const ylm_many_lights *l = j->lights;
  bool degree = l->form.degree > 0;
  bool soft = j->o->method == YLM_SHADE_HVL && l->form.profile != YLM_LIGHT_VIRTUAL_CAP &&
              l->form.profile != YLM_LIGHT_VIRTUAL_POINT;
  if (degree) j->kernels.send(l, soft, first, n, j->view->position[p], s->I);
  for (int c = 0; c < 3; c++) I[c] = degree ? s->I[c] : l->intensity[c] + first;
}

/* A bound of the light of light i as a sphere at x. */
static double sphere_bound(const ylm_many_lights *l, size_t i, const float x[3]) {
  double d2 = 0, r2 = (double)l->radius[i] * (double)l->radius[i];
  for (int k = 0; k < 3; k++) {
    double v = (double)l->at[k][i] - (double)x[k];
    d2 += v * v;
  }
  return 2 / fmax(d2, 2 * r2) * (1 + (double)l->shift[i]) * (double)l->bright[i];
}

/* The factor of light i, as a sphere: 0 leaves it out. */
static float keep_sphere(const job *j, scratch *s, size_t i, const float x[3]) {
  const ylm_many_lights *l = j->lights;
  float factor = 1;
  bool none =
      l->shift[i] == 0 && l->normal[0][i] == 0 && l->normal[1][i] == 0 && l->normal[2][i] == 0;
  if (i >= l->n || none) return 0; /* padding */
  if (l->bright) factor = ylm__many_keep(&s->walk, sphere_bound(l, i, x));
  s->kept += factor > 0;
  return factor;
}

/* Leaves lights from `first` on out by their weights, `rows` of each. */
static void thin(const job *j, scratch *s, size_t first, size_t n, int rows) {
  const float *bright = j->lights->bright;
  for (size_t k = 0; bright && k < n; k++) {
    float most = 0;
    for (int f = 0; f < rows; f++) most = fmaxf(most, fabsf(s->w[f][k]));
    if (most == 0) continue;
    float factor = ylm__many_keep(&s->walk, (double)most * (double)bright[first + k]);
    s->kept += factor > 0;
    for (int f = 0; f < rows; f++) s->w[f][k] *= factor;
  }
}

/* Factors of lights from `first` on, as spheres at x; NULL: all are 1. */
static const float *keep_spheres(const job *j, scratch *s, size_t first, size_t n,
                                 const float x[3]) {
  if (!j->lights->bright) return NULL;
  for (size_t k = 0; k < n; k++) s->keep[k] = keep_sphere(j, s, first + k, x);
  for (size_t k = n; k < YLM_MANY_CHUNK; k++) s->keep[k] = 0;
  return s->keep;
}

static void weigh(const job *j, scratch *s, const ylm_many_ask *a, size_t p, size_t first, size_t n,
                  const uint32_t seed[2]) {
  const float *x = j->view->position[p], *N = j->view->normal[p];
  if (j->o->method != YLM_SHADE_VSL) {
    j->kernels.weights(j->lights, a, first, n, x, N, s->w[0]);
    thin(j, s, first, n, 1);
    return;
  }
  const float *keep = keep_spheres(j, s, first, n, x);
  j->kernels.spheres(j->lights, a, first, n, x, N, seed, keep, s->w[0]);
}

/* Sets out for point p: its random numbers, and the lights that it asks. */
static void start(const job *j, scratch *s, size_t pixel, uint64_t stream, bool all,
                  uint32_t seed[2]) {
  const ylm_many_lights *l = j->lights;
  ylm_rng rng;
  ylm_rng_seed(&rng, j->o->seed, stream);
  s->begin = 0, s->end = l->n;
  s->walk.alpha = j->ask.alpha;
  if (l->bright) s->walk.upto = j->ask.alpha * ylm_rng_double(&rng);
  for (int k = 0; k < 2; k++) seed[k] = ylm_rng_u32(&rng);
  size_t group = l->begin && !all ? ylm__many_group(j->view, j->o->tile, pixel) : 0;
  if (l->begin && !all) s->begin = l->begin[group], s->end = l->begin[group + 1];
  s->pairs += l->begin && !all ? (l->form.n + l->groups - 1 - group) / l->groups : l->n;
}

/* Lights from `first` on that go into one call of a kernel. */
static size_t chunk(const job *j, const scratch *s, size_t first) {
  return j->lights->begin && s->end - first < YLM_MANY_CHUNK ? s->end - first : YLM_MANY_CHUNK;
}

/* Irradiance of point p. */
static void gather(const job *j, scratch *s, size_t p, size_t pixel, uint64_t stream) {
  ylm_many_ask a = j->ask;
  double sum[3] = {0, 0, 0};
  float albedo[3];
  uint32_t seed[2];
  ylm__shade_albedo(j->view, p, albedo);
  a.reflectance =
      (float)(YLM_LUMINANCE_R * (double)albedo[0] + YLM_LUMINANCE_G * (double)albedo[1] +
              YLM_LUMINANCE_B * (double)albedo[2]) *
      0.318309886f;
  start(j, s, pixel, stream, false, seed);
  for (size_t first = s->begin, n; first < s->end; first += n) {
    const float *I[3];
    n = chunk(j, s, first);
    weigh(j, s, &a, p, first, n, seed);
    if (j->o->shadows) look(j, s, p, first, n, 1);
    send(j, s, p, first, n, I);
    j->kernels.collect(n, s->w[0], I, sum);
  }
  for (size_t c = 0; c < 3; c++)
    j->out[3 * p + c] = (float)(j->lights->begin ? sum[c] * (double)j->lights->groups : sum[c]);
}

/* -- points that gloss ------------------------------------------------------------ */

static float luminous(const float x[3]) {
  return (float)(YLM_LUMINANCE_R * (double)x[0] + YLM_LUMINANCE_G * (double)x[1] +
                 YLM_LUMINANCE_B * (double)x[2]);
}

/* Weights of points: the matte ones times f, which bounds of all but the light are of too. */
static void reflect_points(const job *j, scratch *s, const ylm_many_ask *ask,
                           const ylm_many_receiver *r, const float tint[3], size_t p, size_t first,
                           size_t lights) {
  const ylm_many_lights *l = j->lights;
  const float *x = j->view->position[p];
  ylm_many_ask a = *ask;
  ylm_shade_gather_options free_of_bounds = *j->o;
  bool whole = j->o->clamp == YLM_SHADE_CLAMP_WHOLE;
  uint16_t of[YLM_MANY_CHUNK];
  size_t n = 0;
  if (whole) free_of_bounds.clamp = YLM_SHADE_CLAMP_NONE, a.o = &free_of_bounds;
  j->kernels.weights(l, &a, first, lights, x, j->view->normal[p], s->w[0]);
  for (size_t k = 0; k < lights; k++) {
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
  ylm__many_eval(r, n, (const float(*)[3])s->to, s->f);
  for (size_t i = 0; i < n; i++) {
    float g = s->w[0][of[i]];
    for (int c = 0; c < 3; c++) s->f[i][c] *= tint[c];
    float f = luminous(s->f[i]);
    if (whole && f * g > (float)j->o->limit) g = (float)j->o->limit / f;
    for (int c = 0; c < 3; c++) s->w[c][of[i]] = g * s->f[i][c];
  }
}

/* Weights of lights from `first` on in s->w, by channels or functions of the receiver; how many rows. */
static int weigh_gloss(const job *j, scratch *s, const ylm_many_receiver *r, const float tint[3],
                       size_t p, size_t first, size_t n, const uint32_t seed[2]) {
  const ylm_many_lights *l = j->lights;
  const float *x = j->view->position[p], *N = j->view->normal[p];
  if (j->o->method == YLM_SHADE_VPL) {
    reflect_points(j, s, &j->ask, r, tint, p, first, n);
    return 3;
  }
  if (j->o->method == YLM_SHADE_VSL) {
    const float *keep = keep_spheres(j, s, first, n, x);
    j->kernels.spheres_gloss(l, &j->ask, r, first, n, x, seed, keep, s->w);
    for (int c = 0; c < 3; c++)
      for (size_t k = 0; k < n; k++) s->w[c][k] *= tint[c];
    return 3;
  }
  j->kernels.gloss(l, &j->ask, r, first, n, x, s->w);
  bool paper = j->o->method == YLM_SHADE_HVL && j->o->horizon == YLM_SHADE_HORIZON_PAPER;
  for (size_t k = 0; paper && k < n; k++) {
    float part = first + k < l->n ? (float)ylm__many_above(l, first + k, x, N) : 0;
    for (int f = 0; f < r->functions; f++) s->w[f][k] *= part;
  }
  if (j->o->method == YLM_SHADE_VSGL && r->based) {
    j->kernels.weights(l, &j->ask, first, n, x, N, s->w[3]);
    for (int c = 0; c < 3; c++)
      for (size_t k = 0; k < n; k++) s->w[c][k] += r->base[c] * s->w[3][k];
  }
  for (int c = 0; r->zonal && c < 3; c++)
    for (size_t k = 0; k < n; k++) s->w[c][k] *= tint[c];
  return r->functions;
}

/* Radiance of point p, which glosses. */
static ylm_status gather_gloss_point(const job *j, scratch *s, size_t p, size_t pixel,
                                     uint64_t stream) {
  double sum[3][3] = {{0}}, out[3] = {0, 0, 0};
  float tint[3] = {1, 1, 1};
  ylm_many_receiver r;
  uint32_t seed[2];
  ylm__shade_tint(j->view, p, 1, tint);
  start(j, s, pixel, stream, true, seed);
  ylm_status status = ylm__many_receive(j->gloss, j->view, p, s->row, &r);
  for (size_t first = s->begin, n; status == YLM_OK && first < s->end; first += n) {
    const float *I[3];
    n = chunk(j, s, first);
    int rows = weigh_gloss(j, s, &r, tint, p, first, n, seed);
    if (j->o->method != YLM_SHADE_VSL) thin(j, s, first, n, rows);
    if (j->o->shadows) look(j, s, p, first, n, rows);
    send(j, s, p, first, n, I);
    if (!r.mix)
      j->kernels.collect_each(n, (const float(*)[YLM_MANY_CHUNK])s->w, I, out);
    else
      for (int f = 0; f < rows; f++) j->kernels.collect(n, s->w[f], I, sum[f]);
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
  float *row = j->gloss ? ylm_alloc(ylm__many_gloss_room(j->gloss), sizeof *row) : NULL;
  ylm_status status = s && (row || !j->gloss) ? YLM_OK : YLM_ENOMEM;
  shade_stream at = ylm__shade_stream_at(j->view, begin);
  if (s) s->rays = s->pairs = s->kept = 0, s->row = row;
  for (size_t i = begin; status == YLM_OK && i < end; i++) {
    uint64_t stream = ylm__shade_stream_next(j->view, &at);
    if (ylm__many_glosses(j->gloss, j->view, i))
      status = gather_gloss_point(j, s, i, at.pixel, stream);
    else
      gather(j, s, i, at.pixel, stream);
  }
  if (s) {
    atomic_fetch_add_explicit(&j->rays, s->rays, memory_order_relaxed);
    atomic_fetch_add_explicit(&j->pairs, s->pairs, memory_order_relaxed);
    atomic_fetch_add_explicit(&j->kept, s->kept, memory_order_relaxed);
  }
  ylm_free(s);
  ylm_free(row);
  return status;
}

/* From irradiance to radiance at points that do not gloss. */
static void reflect(const job *j, float *out) {
  const ylm_shade_view *v = j->view;
  for (size_t i = 0, behind; i < v->points; i = behind) {
    bool glosses = ylm__many_glosses(j->gloss, v, i);
    for (behind = i + 1; behind < v->points && ylm__many_glosses(j->gloss, v, behind) == glosses;)
      behind++;
    if (!glosses) ylm__shade_reflect(v, i, behind - i, out + 3 * i);
  }
}

/* -- all -------------------------------------------------------------------------- */

static ylm_status check_subset(const ylm_shade_view *v, const ylm_shade_gather_options *o,
                               ylm_error *e) {
  if (o->subset != YLM_SHADE_ALL && o->method == YLM_SHADE_VSGL)
    return ylm_fail(e, YLM_EINVAL, "groups of lights are asked all: subset is of single ones");
  if (o->subset == YLM_SHADE_STOCHASTIC && (!(o->alpha >= 0) || !isfinite(o->alpha)))
    return ylm_fail(e, YLM_ERANGE, "alpha must be above 0, got %g", o->alpha);
  if (o->subset != YLM_SHADE_INTERLEAVED) return YLM_OK;
  if (o->tile < 2 || o->tile > YLM_SHADE_TILE)
    return ylm_fail(e, YLM_ERANGE, "tile must be from 2 to %d, got %d", YLM_SHADE_TILE, o->tile);
  if (v->corner || v->number)
    return ylm_fail(e, YLM_EINVAL, "pixels are interleaved: the view has none of its own");
  return YLM_OK;
}

static ylm_status check(const ylm_shade_gather_options *o, const ylm_light_virtual_form *f,
                        ylm_error *e) {
  if (o->lmax < 0 || o->lmax > YLM_SHADE_GATHER_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_SHADE_GATHER_LMAX,
                    o->lmax);
  if (o->method == YLM_SHADE_VPL && o->clamp != YLM_SHADE_CLAMP_NONE && !(o->limit > 0))
    return ylm_fail(e, YLM_ERANGE, "limit must be above 0, got %g", o->limit);
  if (o->compensate < 0 || o->compensate > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "compensate must be from 0 to %d, got %d", YLM_SCENE_SAMPLES,
                    o->compensate);
  if (o->compensate && (o->method != YLM_SHADE_VPL || o->clamp == YLM_SHADE_CLAMP_NONE))
    return ylm_fail(e, YLM_EINVAL, "compensate is for points with a clamp");
  if (o->method == YLM_SHADE_VSGL && f->n > 0 && (o->groups < 1 || o->groups > f->n))
    return ylm_fail(e, YLM_ERANGE, "groups must be from 1 to %zu, the lights, got %zu", f->n,
                    o->groups);
  if (o->method != YLM_SHADE_VSL) return YLM_OK;
  if (o->samples < 1 || o->samples > YLM_SCENE_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "samples must be from 1 to %d, got %d", YLM_SCENE_SAMPLES,
                    o->samples);
  for (size_t i = 0; i < f->n; i++)
    if (!(f->radius && f->radius[i] > 0))
      return ylm_fail(e, YLM_EDOMAIN, "light %zu has no radius: it is no sphere", i + 1);
  return YLM_OK;
}

static ylm_status make_ask(ylm_many_ask *a, const ylm_many_lights *l) {
  const ylm_shade_gather_options *o = a->o;
  double zonal[YLM_SHADE_GATHER_LMAX + 1], R2 = l->form.core * l->form.core;
  ylm_status s = ylm_material_cosine(o->lmax, zonal);
  for (int k = 0; s == YLM_OK && k <= o->lmax; k++)
    a->zonal[k] = (float)(zonal[k] * (2 * k + 1) / (4 * YLM_PI) * (o->window ? o->window[k] : 1));
  for (int k = 0; k <= o->lmax; k++) {
    float by = 1.0f / (float)(k + 1);
    a->up[k] = (float)(2 * k + 1) * by;
    a->down[k] = (float)k * by;
  }
  a->core = R2 > 0 ? (float)(1 / (R2 * R2)) : 0;
  return s;
}

/* The bound above which lights are kept: with it YLM_SHADE_KEPT are, in the mean over some points. */
static ylm_status choose_alpha(job *j) {
  const ylm_shade_view *v = j->view;
  size_t points = v->points < ALPHA_POINTS ? v->points : ALPHA_POINTS;
  double sum = 0;
  scratch *s = ylm_alloc_zero(1, sizeof *s);
  if (!s) return YLM_ENOMEM;
  for (size_t i = 0; i < points; i++) {
    size_t p = i * v->points / points;
    for (size_t first = 0; first < j->lights->n; first += YLM_MANY_CHUNK) {
      bool sphere = j->o->method == YLM_SHADE_VSL;
      if (!sphere)
        j->kernels.weights(j->lights, &j->ask, first, YLM_MANY_CHUNK, v->position[p], v->normal[p],
                           s->w[0]);
      for (size_t k = 0; k < YLM_MANY_CHUNK && first + k < j->lights->n; k++)
        sum += sphere ? sphere_bound(j->lights, first + k, v->position[p])
                      : (double)(fabsf(s->w[0][k]) * j->lights->bright[first + k]);
    }
  }
  j->ask.alpha = points > 0 ? sum / (double)points / YLM_SHADE_KEPT : 0;
  ylm_free(s);
  return YLM_OK;
}

/* Whether a question is one of libylm_rival.so. */
static bool is_rival(const ylm_shade_gather_options *o) {
  return o->method != YLM_SHADE_HVL || o->subset == YLM_SHADE_INTERLEAVED;
}

/* The table of libylm_rival.so, where the question is one of it; else NULL. */
static ylm_status find_rival(const ylm_shade_gather_options *o, const ylm_shade_rival **out,
                             ylm_error *e) {
  *out = is_rival(o) ? atomic_load(&known) : NULL;
  if (*out || !is_rival(o)) return YLM_OK;
  return ylm_fail(e, YLM_EMISSING,
                  "this way to ask virtual lights needs libylm_rival: call "
                  "ylm_shade_rival_set(ylm_rival_many())");
}

static size_t first_point(const ylm_shade_view *v, size_t pixel) { return v->pixel[pixel].first; }

/* A view as rivals see it. */
static ylm_many_host host_of(const ylm_shade_view *v, const many_gloss *gloss) {
  return (ylm_many_host){.view = v,
                         .gloss = gloss,
                         .scene = v->scene,
                         .trace = ylm_scene_trace(v->scene),
                         .points = v->points,
                         .size = {(size_t)v->image[0], (size_t)v->image[1]},
                         .eye = v->frame.from,
                         .origin = (const float(*)[3])v->origin,
                         .normal = (const float(*)[3])v->normal,
                         .mesh = v->mesh,
                         .first = first_point,
                         .stream = ylm__shade_stream,
                         .albedo = ylm__shade_albedo,
                         .tint = ylm__shade_tint,
                         .glosses = ylm__many_glosses,
                         .receive = ylm__many_receive,
                         .eval = ylm__many_eval,
                         .basis = ylm_scene_basis,
                         .nearest = ylm_trace_nearest,
                         .surfaces = ylm_scene_surfaces,
                         .places = ylm_path_places};
}

ylm_status ylm_shade_gather_virtual(const ylm_shade_view *v, const ylm_light_virtual *from,
                                    const ylm_shade_gather_options *o, float *out,
                                    ylm_shade_gather_report *report, ylm_error *e) {
  double begun = ylm_seconds();
  size_t where;
  ylm_many_lights l = {0};
  ylm_many_series series = {0};
  const ylm_shade_rival *rival = NULL;
  ylm_many_host host;
  job j = {.view = v,
           .o = o,
           .lights = &l,
           .ask = {.o = o},
           .kernels = ylm__many_kernels(o),
           .out = out};
  ylm_light_virtual_form form;
  ylm_light_virtual *own;
  ylm_status s = ylm__shade_enter(v, from, &own, e);
  if (own) from = own;
  ylm_light_virtual_get(from, &form);
  if (s == YLM_OK) s = check_subset(v, o, e);
  if (s == YLM_OK) s = find_rival(o, &rival, e);
  if (s == YLM_OK && rival) rival->kernels(o->method, &j.kernels);
  if (s == YLM_OK) s = ylm__many_series(form.degree, &series);
  if (s == YLM_OK) s = check(o, &form, e);
  if (s == YLM_OK) s = read_lights(from, o, rival, &series, &l);
  if (s == YLM_OK) s = make_ask(&j.ask, &l);
  if (s == YLM_OK) s = ylm__many_gloss(v, o, &j.gloss, e);
  host = host_of(v, j.gloss);
  j.ask.host = &host;
  j.ask.alpha = o->alpha;
  if (s == YLM_OK && l.bright && o->alpha == 0) s = choose_alpha(&j);
  if (s == YLM_OK)
    s = ylm_parallel(v->points, o->method == YLM_SHADE_VSL && o->samples > MANY ? 1 : GRAIN,
                     o->threads, run, &j, o->progress, "virtual lights");
  if (s == YLM_OK && l.begin) s = rival->filter(&host, o->tile, o->threads, out);
  uint64_t rays = j.rays, singular = 0;
  if (s == YLM_OK && !l.begin &&
      (o->method == YLM_SHADE_VPL || form.profile == YLM_LIGHT_VIRTUAL_POINT))
    s = ylm__many_singular(v, &l, &singular);
  if (s == YLM_OK && o->compensate) s = rival->compensate(&j.ask, out, &rays, e);
  if (s == YLM_OK) reflect(&j, out);
  if (s == YLM_OK && !ylm_all_finite(YLM_FLOAT, out, 3 * v->points, &where))
    s = ylm_fail(e, YLM_ERANGE,
                 "the light at shading point %zu is beyond the range of float: lower the lights' "
                 "intensity",
                 where / 3 + 1);
  ylm_free(l.memory);
  ylm_free(l.begin);
  ylm_free(l.lobe);
  ylm_free(l.top);
  ylm__many_series_free(&series);
  ylm__many_gloss_free(j.gloss);
  size_t lights = o->method == YLM_SHADE_VSGL ? l.n : form.n;
  ylm_light_virtual_free(own);
  *report = (ylm_shade_gather_report){.pairs = j.pairs,
                                      .rays = rays,
                                      .singular = singular,
                                      .lights = lights,
                                      .kept = l.bright ? j.kept : j.pairs,
                                      .alpha = l.bright ? j.ask.alpha : 0,
                                      .seconds = ylm_seconds() - begun};
  return s;
}
