/* direct.c - direct light on elements: by rays to lamps, by coefficients, or as it is given. */
#include <math.h>
#include <stdatomic.h>

#include "calibration.h"
#include "transfer.h"
#include "ylm_random.h"

typedef struct job {
  const ylm_transfer *t;
  const ylm_scene *scene;
  ylm_scene_guide *guide; /* NULL: rays have none */
  int places, each;       /* rays of a place */
  uint64_t seed;
  float *E0, *variance; /* [elements] of E0's luminance; NULL: one place cannot tell */
  float *apart;         /* [elements][4] a sample of E0's noise; NULL likewise */
  double (*part)[2];    /* [blocks] W: of rays to lamps that are near, of all */
  atomic_uint_fast64_t rays;
} job;

/* Elements from `first` on whose rays wait to be traced. */
typedef struct waiting {
  ylm_scene_batch lit;
  size_t first, count;
  size_t end[DIRECT_GRAIN][DIRECT_PLACES]; /* of the rays of each element's places */
} waiting;

/* Some elements whose rays are to be aimed, and the surfaces at their places, one element behind the other. */
typedef struct starts {
  size_t n;
  ylm_rng rng[DIRECT_TOGETHER];
  ylm_scene_place place[DIRECT_TOGETHER * DIRECT_PLACES];
  ylm_scene_surface at[DIRECT_TOGETHER * DIRECT_PLACES];
} starts;

/* A place of element i: number k of a sequence that begins at (x, y). */
static ylm_scene_place place_of(ylm_scene_place place, float corner[3][2], double x, double y,
                                int k) {
  x += k * 0.7548776662466927, y += k * 0.5698402909980532;
  x -= floor(x), y -= floor(y);
  ylm__transfer_inside(corner, x, y, &place);
  return place;
}

/* Looks up the places of elements begin .. end-1, where they have light. */
static void look_up(const job *j, size_t begin, size_t end, starts *to) {
  to->n = 0;
  for (size_t i = begin; i < end; i++) {
    ylm_scene_place place;
    float corner[3][2];
    ylm_rng *rng = &to->rng[i - begin];
    if (!(j->t->share[i] > 0)) continue;
    ylm_draw_seed(rng, ~j->seed, i);
    double x = ylm_draw_double(rng), y = ylm_draw_double(rng);
    ylm__transfer_corners(j->t, i, &place, corner);
    for (int k = 0; k < j->places; k++) {
      ylm_scene_place *here = &to->place[to->n++];
      *here = place_of(place, corner, x, y, k);
      ylm__transfer_hold(j->t, i, here);
    }
  }
  ylm_scene_surfaces(j->scene, to->n, to->place, to->at);
}

/* Aims the rays of element i, where it has light, from its places; returns how many of them there are. */
static size_t aim(const job *j, size_t i, const ylm_scene_surface *at, ylm_rng *rng, waiting *w) {
  size_t *end = w->end[w->count++], n = j->t->share[i] > 0 ? (size_t)j->places : 0;
  for (size_t k = 0; k < (size_t)j->places; k++) {
    if (k < n) ylm_scene_batch_aim(&w->lit, at[k].lit, at[k].normal, at[k].origin, j->each, rng);
    end[k] = w->lit.rays;
  }
  return n;
}

/* The weight of place p of n in a sample of the noise of their mean: weights add up to 0, their squares to 1 / n. */
static double apart_of(int p, int n) {
  int pairs = n / 2;
  return p < 2 * pairs ? (p % 2 ? -1 : 1) / sqrt(2.0 * pairs * n) : 0;
}

/* Irradiance of element i from rays k on, up to the end of each place's; adds up what is near and what is there. */
static void add(const job *j, size_t i, const ylm_scene_batch *s, size_t k, const size_t *end,
                double part[2]) {
  double E[3] = {0, 0, 0}, apart[3] = {0, 0, 0}, squares = 0, before = 0;
  for (int p = 0; p < j->places; p++) {
    double side = apart_of(p, j->places);
    for (; k < end[p]; k++) {
      if (s->ray[k].far < 0) continue;
      double each = (double)s->value[k][0] + (double)s->value[k][1] + (double)s->value[k][2];
      for (int c = 0; c < 3; c++) E[c] += (double)s->value[k][c];
      for (int c = 0; c < 3; c++) apart[c] += side * (double)s->value[k][c];
      if ((double)s->ray[k].far < 2 * j->t->form.spacing) part[0] += (double)j->t->area[i] * each;
      part[1] += (double)j->t->area[i] * each;
    }
    double now = ylm_luminance(E);
    squares += (now - before) * (now - before);
    before = now;
  }
  double share = (double)j->t->share[i], scale = share > 0 ? 1 / (j->places * share) : 0;
  for (int c = 0; c < 3; c++) j->E0[4 * i + (size_t)c] = (float)(E[c] * scale);
  if (!j->variance) return;
  for (int c = 0; c < 3; c++)
    j->apart[4 * i + (size_t)c] = (float)(share > 0 ? apart[c] / share : 0);
  double n = j->places, left = fmax(0, squares - before * before / n) * n / (n - 1);
  j->variance[i] = (float)(left * scale * scale);
}

/* Traces the rays that wait. */
static void finish(const job *j, waiting *w, double part[2]) {
  ylm_scene_batch_trace(&w->lit);
  for (size_t k = 0; k < w->count; k++)
    add(j, w->first + k, &w->lit, k > 0 ? w->end[k - 1][j->places - 1] : 0, w->end[k], part);
  w->first += w->count;
  w->count = w->lit.rays = 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t most = (size_t)j->places * (size_t)j->each;
  double *part = j->part[begin / DIRECT_GRAIN];
  waiting w = {.first = begin};
  ylm_status status = ylm_scene_batch_create(j->scene, most, &w.lit);
  if (status == YLM_OK) ylm_scene_chooser_follow(w.lit.lamps, j->guide);
  for (size_t i = begin, n; status == YLM_OK && i < end; i += n) {
    starts from;
    n = end - i < DIRECT_TOGETHER ? end - i : DIRECT_TOGETHER;
    look_up(j, i, i + n, &from);
    for (size_t k = 0, p = 0; k < n; k++) {
      if (w.lit.rays + most > w.lit.room) finish(j, &w, part);
      p += aim(j, i + k, from.at + p, &from.rng[k], &w);
    }
  }
  if (status == YLM_OK) finish(j, &w, part);
  ylm_scene_batch_free(&w.lit);
  atomic_fetch_add(&j->rays, w.lit.traced);
  return status;
}

static void forget_noise(ylm_radiosity *r) {
  ylm_free(r->apart);
  ylm_free(r->noise);
  r->apart = r->noise = NULL;
}

/* Takes new direct light, a sample of its noise and its guide over, or frees them. */
static ylm_status take(ylm_radiosity *r, ylm_status s, float *E0, float *apart,
                       ylm_scene_guide *guide, uint64_t rays, double close, double begun) {
  ylm_scene_guide_free(s == YLM_OK ? r->guide : guide);
  if (s != YLM_OK) {
    ylm_free(E0);
    ylm_free(apart);
    return s;
  }
  ylm_free(r->E0);
  forget_noise(r);
  r->E0 = E0;
  r->apart = apart;
  r->guide = guide;
  r->rays = rays;
  r->close = close;
  r->seconds = ylm_seconds() - begun;
  return s;
}

ylm_status ylm__transfer_check_rays(const ylm_transfer *t, const ylm_scene *scene,
                                    int light_samples, ylm_error *e) {
  bool same;
  if (light_samples < 1 || light_samples > YLM_TRANSFER_LINKS)
    return ylm_fail(e, YLM_ERANGE, "light_samples must be from 1 to %d, got %d", YLM_TRANSFER_LINKS,
                    light_samples);
  ylm_status s = ylm__transfer_same(t->scene, scene, &same);
  if (s == YLM_OK && !same)
    s = ylm_fail(e, YLM_EINVAL, "the scene has other meshes than those of the links");
  return s;
}

static ylm_status smooth(ylm_radiosity *r, const transfer_places *p, const float *variance,
                         float *E0, float *apart, int threads) {
  ylm_status s =
      r->neighbours ? YLM_OK : ylm__transfer_neighbours_create(r->t, p, threads, &r->neighbours);
  return s == YLM_OK ? ylm__transfer_smooth(r->t, r->neighbours, variance, E0, apart, threads) : s;
}

ylm_status ylm_radiosity_rays(ylm_radiosity *r, const ylm_scene *scene, int light_samples,
                              bool guides, uint64_t seed, int threads, const ylm_progress *progress,
                              ylm_error *e) {
  double begun = ylm_seconds();
  ylm_status s = ylm__transfer_check_rays(r->t, scene, light_samples, e);
  if (s != YLM_OK) return s;
  int places = light_samples / DIRECT_EACH < 1               ? 1
               : light_samples / DIRECT_EACH < DIRECT_PLACES ? light_samples / DIRECT_EACH
                                                             : DIRECT_PLACES;
  job j = {.t = r->t,
           .scene = scene,
           .places = places,
           .each = (light_samples + places - 1) / places,
           .seed = seed,
           .E0 = ylm_alloc_zero(r->t->elements + 1, 16),
           .part = ylm_alloc_zero(r->t->elements / DIRECT_GRAIN + 1, sizeof *j.part)};
  j.variance = places > 1 ? ylm_alloc(r->t->elements, sizeof *j.variance) : NULL;
  j.apart = places > 1 ? ylm_alloc_zero(r->t->elements + 1, 16) : NULL;
  transfer_places p = {0};
  s = j.E0 && j.part && ((j.variance && j.apart) || places == 1) ? YLM_OK : YLM_ENOMEM;
  bool guided = guides && ylm_scene_guides(scene);
  if (s == YLM_OK && (guided || (j.variance && !r->neighbours)))
    s = ylm__transfer_places(r->t, scene, &p);
  if (s == YLM_OK && guided)
    s = ylm_scene_guide_create(scene, &p.of, light_samples, seed, threads, progress, &j.guide);
  if (s == YLM_OK)
    s = ylm_parallel(r->t->elements, DIRECT_GRAIN, threads, run, &j, progress, "direct");
  if (s == YLM_OK && j.variance) s = smooth(r, &p, j.variance, j.E0, j.apart, threads);
  ylm__transfer_places_free(&p);
  ylm_free(j.variance);
  double near = 0, all = 0;
  for (size_t b = 0; s == YLM_OK && b * DIRECT_GRAIN < r->t->elements; b++)
    near += j.part[b][0], all += j.part[b][1];
  ylm_free(j.part);
  if (s == YLM_OK) r->guided = guides;
  return take(r, s, j.E0, j.apart, j.guide, j.rays, all > 0 ? near / all : 0, begun);
}

/* Light by coefficients. */
typedef struct by_field {
  const ylm_transfer *t;
  int lmax;
  size_t count;   /* coefficients of a channel */
  double *zonal;  /* [lmax+1] of the cosine; NULL: T0 is used */
  float *normals; /* [DIRECT_ASKED][count] the basis at normals */
  float (*place)[3];
  float *light; /* [DIRECT_ASKED][3][count] */
} by_field;

/* The products of T0, or of the cosine, of elements from `first` on with x->light. */
static ylm_status dot(const by_field *x, size_t first, size_t n, float *E0) {
  const ylm_transfer *t = x->t;
  size_t row = x->zonal ? x->count : ylm_sh_count(t->form.lmax);
  const float *T = x->zonal ? x->normals : t->escape + first * row;
  ylm_status s = YLM_OK;
  if (x->zonal) {
    s = ylm_sh_eval(x->lmax, 0, false, YLM_FLOAT, n, t->normal[first], x->normals, NULL, NULL, 1,
                    NULL);
    for (size_t i = 0; s == YLM_OK && i < n; i++)
      for (int l = 0; l <= x->lmax; l++)
        for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++)
          x->normals[i * row + k] *= (float)x->zonal[l];
  }
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (size_t c = 0; c < 3 && t->share[first + i] > 0; c++) {
      double sum = 0;
      for (size_t k = 0; k < x->count; k++)
        sum += (double)T[i * row + k] * (double)x->light[(i * 3 + c) * x->count + k];
      E0[4 * (first + i) + c] = (float)sum;
    }
  return s;
}

void ylm__transfer_off(const ylm_transfer *t, size_t n, const float (*place)[3],
                       const float (*normal)[3], float (*out)[3]) {
  float b = (float)(t->form.spacing / 2);
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) out[i][a] = place[i][a] + b * normal[i][a];
}

static ylm_status ask(const by_field *x, const ylm_field *field, int threads,
                      const ylm_progress *progress, float *E0, ylm_error *e) {
  size_t n = x->t->elements;
  ylm_field_query q = {.lmax = x->lmax,
                       .channels = 3,
                       .want = YLM_WANT_VALUE,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = threads,
                       .origin = ylm_scene_origin(x->t->scene)};
  ylm_status s = YLM_OK;
  for (size_t first = 0; s == YLM_OK && first < n; first += DIRECT_ASKED) {
    size_t part = n - first < DIRECT_ASKED ? n - first : DIRECT_ASKED;
    ylm_field_result out = {.value = x->light};
    const float(*place)[3] = (const float(*)[3])x->t->centre + first;
    if (x->zonal) {
      ylm__transfer_off(x->t, part, place, (const float(*)[3])x->t->normal + first, x->place);
      place = (const float(*)[3])x->place;
    }
    s = ylm_field_evaluate(field, &q, part, place, &out, e);
    if (s == YLM_OK) s = dot(x, first, part, E0);
    if (s == YLM_OK) s = ylm_report(progress, first + part, n, "direct");
  }
  return s;
}

ylm_status ylm_radiosity_field(ylm_radiosity *r, const ylm_field *field, int lmax, int threads,
                               const ylm_progress *progress, ylm_error *e) {
  const ylm_transfer *t = r->t;
  double begun = ylm_seconds();
  bool shadowed = field->quantity != YLM_QUANTITY_lights;
  if (!shadowed && !t->escape)
    return ylm_fail(e, YLM_EINVAL, "the links were made without transfer vectors (lmax)");
  if (lmax < 0 || lmax > (shadowed ? YLM_TRANSFER_LMAX : t->form.lmax))
    return ylm_fail(e, YLM_ERANGE, "lmax %d is beyond that of the links", lmax);
  by_field x = {.t = t, .lmax = lmax, .count = ylm_sh_count(lmax)};
  float *E0 = ylm_alloc_zero(t->elements + 1, 16);
  x.place = ylm_alloc(DIRECT_ASKED, 12);
  x.light = ylm_alloc(DIRECT_ASKED * 3 * x.count, sizeof *x.light);
  x.normals = ylm_alloc(shadowed ? DIRECT_ASKED * x.count : 0, sizeof *x.normals);
  x.zonal = shadowed ? ylm_alloc((size_t)lmax + 1, sizeof *x.zonal) : NULL;
  bool room = E0 && x.place && x.light && x.normals && (x.zonal || !shadowed);
  ylm_status s = room ? YLM_OK : YLM_ENOMEM;
  if (room && shadowed) s = ylm_material_cosine(lmax, x.zonal);
  if (s == YLM_OK) s = ask(&x, field, threads, progress, E0, e);
  ylm_free(x.place);
  ylm_free(x.light);
  ylm_free(x.normals);
  ylm_free(x.zonal);
  if (s == YLM_OK) r->guided = false;
  return take(r, s, E0, NULL, NULL, 0, 0, begun);
}

void ylm_radiosity_set(ylm_radiosity *r, const float *E0) {
  for (size_t i = 0; i < r->t->elements; i++)
    for (size_t c = 0; c < 3; c++) r->E0[4 * i + c] = r->t->share[i] > 0 ? E0[3 * i + c] : 0;
  forget_noise(r);
  r->rays = 0;
  r->guided = false;
  r->close = r->seconds = 0;
}
