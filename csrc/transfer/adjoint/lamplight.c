/* lamplight.c - direct light of lamps one by one, with its derivatives by them. */
#include <math.h>
#include <stdatomic.h>

#include "../calibration.h"
#include "adjoint.h"

/* Numbers of a record: light for a scale of 1, derivatives, and half the differences of both between two halves of the rays. */
enum {
  LIGHT,
  PLACE,
  TURN = 4,
  SIZE = 7,
  LIGHT_NOISE = 9,
  PLACE_NOISE,
  TURN_NOISE = 13,
  RECORD = 16
};

struct ylm_lamplight {
  const ylm_transfer *t;
  const ylm_receivers *r; /* NULL: elements */
  ylm_lamplight_form form;
  size_t places, lamps;
  ylm_lamp *lamp;
  float *short_of;         /* [lamps] how far from a lamp its rays end */
  size_t block;            /* places whose records are held at once */
  float (*record)[RECORD]; /* [block][lamps] */
  float (*direct)[3];      /* [places] */
  ylm_lamplight_stats stats;
};

/* Records of places from `first` on. */
typedef struct job {
  const ylm_transfer *t;
  const ylm_receivers *r;
  const ylm_lamplight_form *form;
  ylm_lamplight *l;
  size_t first;
  atomic_uint_fast64_t rays, rim_rays, pairs, partly;
} job;

/* A place of a receiver or element from which a ray starts. */
typedef struct spot {
  float lit[3], normal[3], origin[3];
} spot;

/* One lamp as a place sees it. */
typedef struct pair {
  double light[2], mean[2];          /* of half the rays each: with shadows and without */
  double place[3], turn[3], size[2]; /* without shadows */
  double still[2][3];                /* what shadows take of light in fixed directions */
  double rim_place[2][3], rim_turn[2][3], rim_size[2];
  double seen; /* the visibility */
  bool partly;
} pair;

/* The memory of a thread: of some lamps at a time. */
typedef struct scratch {
  size_t at_once;
  spot *spot;             /* [light_samples] */
  adjoint_sample *sample; /* [at_once][light_samples] */
  adjoint_rim *rim;       /* [at_once][rim] */
  ylm_trace_ray *ray;
  int32_t *of; /* [rays] of each sample or place of the rim its ray; -1: none */
  pair *pair;  /* [at_once] */
} scratch;

static size_t most_rays(const ylm_lamplight_form *f) {
  return (size_t)(f->light_samples > f->rim ? f->light_samples : f->rim);
}

static void scratch_free(scratch *x) {
  ylm_free(x->spot);
  ylm_free(x->sample);
  ylm_free(x->rim);
  ylm_free(x->ray);
  ylm_free(x->of);
  ylm_free(x->pair);
}

static bool scratch_create(const job *j, scratch *x) {
  size_t most = most_rays(j->form), samples = (size_t)j->form->light_samples;
  x->at_once = LAMPLIGHT_RAYS / most > 0 ? LAMPLIGHT_RAYS / most : 1;
  if (x->at_once > j->l->lamps) x->at_once = j->l->lamps;
  x->spot = ylm_alloc(samples, sizeof *x->spot);
  x->sample = ylm_alloc(x->at_once * samples, sizeof *x->sample);
  x->rim = ylm_alloc(x->at_once * (size_t)j->form->rim, sizeof *x->rim);
  x->ray = ylm_alloc(x->at_once * most, sizeof *x->ray);
  x->of = ylm_alloc(x->at_once * most, sizeof *x->of);
  x->pair = ylm_alloc(x->at_once, sizeof *x->pair);
  return x->spot && x->sample && x->rim && x->ray && x->of && x->pair;
}

static double part_of_one(double x) { return x - floor(x); }

/* Spots of place i: a receiver's own, or all over an element. */
static void find_spots(const job *j, size_t i, spot *out) {
  size_t n = (size_t)j->form->light_samples;
  if (j->r) {
    for (size_t k = 0; k < n; k++) {
      memcpy(out[k].lit, j->r->point[i], 12);
      memcpy(out[k].origin, j->r->point[i], 12);
      memcpy(out[k].normal, j->r->normal[i], 12);
    }
    return;
  }
  ylm_scene_place place;
  float corner[3][2];
  ylm_rng rng;
  ylm_rng_seed(&rng, ~j->form->seed, i);
  double x0 = ylm_rng_double(&rng), y0 = ylm_rng_double(&rng);
  ylm__transfer_corners(j->t, i, &place, corner);
  for (size_t k = 0; k < n; k++) {
    ylm_scene_surface at;
    double x = part_of_one(x0 + (double)k * 0.8566748838545029);
    double y = part_of_one(y0 + (double)k * 0.7338918566271260);
    ylm__transfer_inside(corner, x, y, &place);
    ylm__transfer_hold(j->t, i, &place);
    ylm_scene_surfaces(j->t->scene, 1, &place, &at);
    memcpy(out[k].lit, at.lit, 12);
    memcpy(out[k].normal, at.normal, 12);
    memcpy(out[k].origin, at.origin, 12);
  }
}

/* A ray from a spot that ends before a place of lamp k. */
static ylm_trace_ray ray_to(const job *j, const spot *from, const double to[3], size_t k) {
  ylm_trace_ray ray = {.near = 0};
  double d[3], far2 = 0;
  for (int a = 0; a < 3; a++) {
    d[a] = to[a] - (double)from->origin[a];
    far2 += d[a] * d[a];
    ray.org[a] = from->origin[a];
  }
  double far = sqrt(far2), over = far > 0 ? 1 / far : 0;
  for (int a = 0; a < 3; a++) ray.dir[a] = (float)(d[a] * over);
  ray.far = fmaxf(0, (float)(far * (1 - 1e-5)) - j->l->short_of[k]);
  return ray;
}

/* Where the numbers of lamp k at place i begin. */
static void pattern_of(const job *j, size_t i, size_t k, ylm_rng *rng) {
  ylm_rng_seed(rng, j->form->seed, ((uint64_t)i << 24) + k);
}

/* Aims rays at lamps first .. first + n - 1. */
static size_t aim(const job *j, size_t i, size_t first, size_t n, scratch *x) {
  size_t samples = (size_t)j->form->light_samples, rays = 0;
  const double step[2][2] = {{0.6287067210378087, 0.5385972572236101},
                             {0.7548776662466927, 0.5698402909980532}};
  const double *by = step[j->r ? 1 : 0];
  for (size_t k = 0; k < n; k++) {
    ylm_rng rng;
    pattern_of(j, i, first + k, &rng);
    double u0 = ylm_rng_double(&rng), u1 = ylm_rng_double(&rng);
    for (size_t s = 0; s < samples; s++) {
      adjoint_sample *to = &x->sample[k * samples + s];
      double u[2] = {part_of_one(u0 + (double)s * by[0]), part_of_one(u1 + (double)s * by[1])};
      bool lit = ylm__lamp_sample(&j->l->lamp[first + k], x->spot[s].lit, x->spot[s].normal, u, to);
      x->of[k * samples + s] = lit ? (int32_t)rays : -1;
      if (lit) x->ray[rays++] = ray_to(j, &x->spot[s], to->to, first + k);
    }
  }
  return rays;
}

static void add(double *to, const double *x, size_t n, double by) {
  for (size_t a = 0; a < n; a++) to[a] += by * x[a];
}

/* Sums over the rays to one lamp, which have been traced. */
static void sum_samples(const job *j, const scratch *x, size_t k, pair *p) {
  size_t samples = (size_t)j->form->light_samples, seen = 0, all = 0;
  *p = (pair){.partly = false};
  for (size_t s = 0; s < samples; s++) {
    const adjoint_sample *at = &x->sample[k * samples + s];
    int32_t ray = x->of[k * samples + s];
    if (ray < 0) continue;
    bool open = !(x->ray[ray].far < 0);
    p->mean[s % 2] += at->light;
    if (open) p->light[s % 2] += at->light;
    add(p->place, at->place, 3, 1);
    add(p->turn, at->turn, 3, 1);
    add(p->size, at->size, 2, 1);
    all++, seen += open;
  }
  double mean = p->mean[0] + p->mean[1];
  p->seen = mean > 0 ? (p->light[0] + p->light[1]) / mean : 0;
  p->partly = seen > 0 && seen < all;
  for (size_t s = 0; s < samples && p->partly; s++) {
    int32_t ray = x->of[k * samples + s];
    if (ray < 0) continue;
    double open = !(x->ray[ray].far < 0);
    add(p->still[s % 2], x->sample[k * samples + s].still, 3, open - p->seen);
  }
}

/* Aims rays at the rims of those of n lamps that are seen in part. */
static size_t aim_at_rims(const job *j, size_t i, size_t first, size_t n, scratch *x) {
  size_t rim = (size_t)j->form->rim, samples = (size_t)j->form->light_samples, rays = 0;
  for (size_t k = 0; k < n; k++) {
    ylm_rng rng;
    if (!x->pair[k].partly) continue;
    pattern_of(j, i, first + k, &rng);
    for (int skip = 0; skip < 2; skip++) ylm_rng_double(&rng);
    double turn = ylm_rng_double(&rng);
    for (size_t s = 0; s < rim; s++) {
      adjoint_rim *to = &x->rim[k * rim + s];
      const spot *from = &x->spot[s % samples];
      double u = part_of_one(turn + (double)s / (double)rim);
      bool lit = ylm__lamp_rim(&j->l->lamp[first + k], from->lit, from->normal, u, (int)rim, to);
      x->of[k * rim + s] = lit ? (int32_t)rays : -1;
      if (lit) x->ray[rays++] = ray_to(j, from, to->to, first + k);
    }
  }
  return rays;
}

static void sum_rim(const job *j, const scratch *x, size_t k, pair *p) {
  size_t rim = (size_t)j->form->rim;
  for (size_t s = 0; s < rim; s++) {
    const adjoint_rim *at = &x->rim[k * rim + s];
    int32_t ray = x->of[k * rim + s];
    if (ray < 0) continue;
    double more = (x->ray[ray].far < 0 ? 0 : 1) - p->seen;
    add(p->rim_place[s % 2], at->place, 3, more);
    add(p->rim_turn[s % 2], at->turn, 3, more);
    add(p->rim_size, at->size, 2, more);
  }
}

/* The record of a lamp; `share`: the part of the place that is not inside of a body. */
static void write(const job *j, const pair *p, double share, float *out) {
  double each = 1 / (share * j->form->light_samples), whole = 1 / share;
  double by_half[2];
  for (int h = 0; h < 2; h++) by_half[h] = p->mean[h] > 0 ? p->light[h] / p->mean[h] : p->seen;
  double drift = (by_half[0] - by_half[1]) / 2;
  out[LIGHT] = (float)(each * (p->light[0] + p->light[1]));
  out[LIGHT_NOISE] = (float)(each * drift * (p->mean[0] + p->mean[1]));
  for (int a = 0; a < 3; a++) {
    const double rim[2][2] = {{p->rim_place[0][a], p->rim_place[1][a]},
                              {p->rim_turn[0][a], p->rim_turn[1][a]}};
    out[PLACE + a] = (float)(each * p->seen * p->place[a] + whole * (rim[0][0] + rim[0][1]));
    out[TURN + a] = (float)(each * (p->seen * p->turn[a] + p->still[0][a] + p->still[1][a]) +
                            whole * (rim[1][0] + rim[1][1]));
    out[PLACE_NOISE + a] = (float)(each * drift * p->place[a] + whole * (rim[0][0] - rim[0][1]));
    out[TURN_NOISE + a] = (float)(each * (drift * p->turn[a] + p->still[0][a] - p->still[1][a]) +
                                  whole * (rim[1][0] - rim[1][1]));
  }
  for (int a = 0; a < 2; a++)
    out[SIZE + a] = (float)(each * p->seen * p->size[a] + whole * p->rim_size[a]);
}

/* Lamps first .. first + n - 1 at place i. */
static void look(job *j, size_t i, size_t first, size_t n, double share, scratch *x) {
  const ylm_trace *trace = ylm_scene_trace(j->t->scene);
  size_t rays = aim(j, i, first, n, x), pairs = 0, partly = 0;
  ylm_trace_occluded(trace, rays, x->ray);
  atomic_fetch_add(&j->rays, rays);
  for (size_t k = 0; k < n; k++) {
    sum_samples(j, x, k, &x->pair[k]);
    pairs += x->pair[k].mean[0] + x->pair[k].mean[1] > 0, partly += x->pair[k].partly;
  }
  if (j->form->rim > 0 && partly > 0) {
    rays = aim_at_rims(j, i, first, n, x);
    ylm_trace_occluded(trace, rays, x->ray);
    atomic_fetch_add(&j->rim_rays, rays);
    for (size_t k = 0; k < n; k++)
      if (x->pair[k].partly) sum_rim(j, x, k, &x->pair[k]);
  }
  for (size_t k = 0; k < n; k++)
    write(j, &x->pair[k], share, j->l->record[(i - j->first) * j->l->lamps + first + k]);
  atomic_fetch_add(&j->pairs, pairs);
  atomic_fetch_add(&j->partly, partly);
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  scratch x = {0};
  ylm_status s = scratch_create(j, &x) ? YLM_OK : YLM_ENOMEM;
  for (size_t i = j->first + begin; i < j->first + end && s == YLM_OK; i++) {
    double share = j->r ? 1 : (double)j->t->share[i];
    size_t row = (i - j->first) * j->l->lamps;
    if (!(share > 0)) memset(j->l->record[row], 0, j->l->lamps * sizeof *j->l->record);
    if (!(share > 0)) continue;
    find_spots(j, i, x.spot);
    for (size_t first = 0; first < j->l->lamps; first += x.at_once) {
      size_t n = j->l->lamps - first < x.at_once ? j->l->lamps - first : x.at_once;
      look(j, i, first, n, share, &x);
    }
  }
  scratch_free(&x);
  return s;
}

static ylm_status check(const ylm_lamplight_form *f, ylm_error *e) {
  if (f->light_samples < 4 || f->light_samples > YLM_TRANSFER_LINKS || f->light_samples % 2)
    return ylm_fail(e, YLM_ERANGE, "light_samples must be even, from 4 to %d, got %d",
                    YLM_TRANSFER_LINKS, f->light_samples);
  if (f->rim < 0 || f->rim > YLM_TRANSFER_LINKS || f->rim % 2)
    return ylm_fail(e, YLM_ERANGE, "rim must be even, from 0 to %d, got %d", YLM_TRANSFER_LINKS,
                    f->rim);
  return YLM_OK;
}

static bool are_finite(const double *x, size_t n) {
  for (size_t i = 0; i < n; i++)
    if (!isfinite(x[i])) return false;
  return true;
}

/* Lamps whose numbers are none, or name no shape. */
static ylm_status check_lamps(size_t lamps, const ylm_lamp *lamp, ylm_error *e) {
  if (lamps > 0 && !lamp) return ylm_fail(e, YLM_EINVAL, "lamp is NULL");
  for (size_t k = 0; k < lamps; k++) {
    const ylm_lamp *l = &lamp[k];
    const struct {
      const char *name;
      const double *x;
      size_t n;
    } of[] = {{"at", l->at, 3},     {"axis", l->axis, 3},   {"across", l->across, 3},
              {"half", l->half, 2}, {"scale", l->scale, 3}, {"power", &l->power, 1},
              {"cone", l->cone, 2}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++)
      if (!are_finite(of[i].x, of[i].n))
        return ylm_fail(e, YLM_EDOMAIN, "lamp %zu: %s must be finite", k + 1, of[i].name);
    if ((unsigned)l->shape > YLM_LAMP_sun)
      return ylm_fail(e, YLM_EINVAL, "lamp %zu: shape %d is not known", k + 1, (int)l->shape);
    if (l->half[0] < 0 || l->half[1] < 0)
      return ylm_fail(e, YLM_ERANGE, "lamp %zu: half must not be negative", k + 1);
    if (l->shape != YLM_LAMP_polygon) continue;
    if (l->corners < 3 || !l->corner)
      return ylm_fail(e, YLM_ERANGE, "lamp %zu: a polygon has 3 corners or more", k + 1);
    for (size_t i = 0; i < l->corners; i++)
      if (!are_finite(l->corner[i].place, 2))
        return ylm_fail(e, YLM_EDOMAIN, "lamp %zu: corner %zu must be finite", k + 1, i + 1);
  }
  return YLM_OK;
}

/* Places from `first` on whose records are held together. */
static size_t block_of(const ylm_lamplight *l, size_t first) {
  return l->places - first < l->block ? l->places - first : l->block;
}

/* Traces the records of a block. */
static ylm_status fill(ylm_lamplight *l, size_t first, const ylm_progress *progress) {
  job j = {.t = l->t, .r = l->r, .form = &l->form, .l = l, .first = first};
  ylm_status s = ylm_parallel(block_of(l, first), LAMPLIGHT_GRAIN, l->form.threads, run, &j,
                              progress, "direct");
  l->stats.rays += j.rays, l->stats.rim_rays += j.rim_rays;
  l->stats.pairs += j.pairs, l->stats.partly += j.partly;
  return s;
}

/* The light of all lamps at the places of a block. */
static void sum_block(ylm_lamplight *l, size_t first) {
  for (size_t i = 0; i < block_of(l, first); i++) {
    double E[3] = {0, 0, 0};
    for (size_t k = 0; k < l->lamps; k++)
      add(E, l->lamp[k].scale, 3, (double)l->record[i * l->lamps + k][LIGHT]);
    for (int c = 0; c < 3; c++) l->direct[first + i][c] = (float)E[c];
  }
}

/* Its own copies of lamps, with tables and corners. */
static bool keep_lamps(ylm_lamplight *l, const ylm_lamp *lamp) {
  l->lamp = ylm_alloc_copy(lamp, l->lamps, sizeof *lamp);
  l->short_of = ylm_alloc(l->lamps, sizeof *l->short_of);
  if (!l->lamp || !l->short_of) return false;
  bool all = true;
  for (size_t k = 0; k < l->lamps; k++) {
    float at[3] = {(float)lamp[k].at[0], (float)lamp[k].at[1], (float)lamp[k].at[2]};
    ylm_light_photometry_keep(lamp[k].table);
    l->short_of[k] =
        lamp[k].shape == YLM_LAMP_sun ? 0 : ylm_trace_offset(ylm_scene_trace(l->t->scene), at);
    l->lamp[k].corner = NULL;
    if (lamp[k].shape != YLM_LAMP_polygon) continue;
    l->lamp[k].corner = ylm_alloc_copy(lamp[k].corner, lamp[k].corners, sizeof *lamp[k].corner);
    if (l->lamp[k].corner) ylm__lamp_measure(&l->lamp[k]);
    all = all && l->lamp[k].corner;
  }
  return all;
}

ylm_status ylm_lamplight_create(const ylm_transfer *t, const ylm_receivers *receivers, size_t lamps,
                                const ylm_lamp *lamp, const ylm_lamplight_form *form,
                                ylm_lamplight **out, ylm_error *e) {
  double begun = ylm_seconds();
  *out = NULL;
  ylm_status s = check(form, e);
  if (s == YLM_OK) s = check_lamps(lamps, lamp, e);
  ylm_lamplight *l = s == YLM_OK ? ylm_alloc_zero(1, sizeof *l) : NULL;
  if (!l) return s == YLM_OK ? YLM_ENOMEM : s;
  *l = (ylm_lamplight){.t = t, .r = receivers, .form = *form, .lamps = lamps};
  l->form.progress = NULL;
  l->places = receivers ? receivers->n : t->elements;
  size_t most = form->bytes > 0 ? form->bytes : YLM_LAMPLIGHT_BYTES;
  l->block = lamps > 0 ? most / sizeof *l->record / lamps : l->places;
  if (l->block < 1) l->block = 1;
  if (l->block > l->places) l->block = l->places;
  l->record = ylm_alloc(l->block * lamps, sizeof *l->record);
  l->direct = ylm_alloc_zero(l->places, sizeof *l->direct);
  s = keep_lamps(l, lamp) && l->record && l->direct ? YLM_OK : YLM_ENOMEM;
  for (size_t first = 0; first < l->places && lamps > 0 && s == YLM_OK; first += l->block) {
    s = fill(l, first, form->progress);
    if (s == YLM_OK) sum_block(l, first);
  }
  l->stats.bytes = l->block * lamps * sizeof *l->record + l->places * sizeof *l->direct;
  l->stats.again = l->block < l->places;
  l->stats.seconds = ylm_seconds() - begun;
  if (s == YLM_OK)
    *out = l;
  else
    ylm_lamplight_free(l);
  return s;
}

void ylm_lamplight_free(ylm_lamplight *l) {
  if (!l) return;
  for (size_t k = 0; l->lamp && l->short_of && k < l->lamps; k++) {
    ylm_light_photometry_free((ylm_light_photometry *)(uintptr_t)l->lamp[k].table);
    ylm_free((ylm_lamp_corner *)(uintptr_t)l->lamp[k].corner);
  }
  ylm_free(l->lamp);
  ylm_free(l->short_of);
  ylm_free(l->record);
  ylm_free(l->direct);
  ylm_free(l);
}

size_t ylm_lamplight_places(const ylm_lamplight *l) { return l->places; }
size_t ylm_lamplight_lamps(const ylm_lamplight *l) { return l->lamps; }
void ylm_lamplight_look(const ylm_lamplight *l, ylm_lamplight_stats *stats) { *stats = l->stats; }

void ylm_lamplight_direct(const ylm_lamplight *l, float (*out)[3]) {
  memcpy(out, l->direct, l->places * sizeof *out);
}

/* Sums over the records of a lamp: by scale [3], and of each number. */
typedef struct total {
  double power[3], sum[RECORD];
} total;

typedef struct weighing {
  const ylm_lamplight *l;
  const double (*weight)[3];
  total *total; /* [lamps] */
  size_t first;
} weighing;

static void weigh_lamp(const weighing *w, size_t k, total *to) {
  const ylm_lamplight *l = w->l;
  for (size_t i = 0; i < block_of(l, w->first); i++) {
    const float *r = l->record[i * l->lamps + k];
    const double *weight = w->weight[w->first + i];
    double worth = ylm_dot3d(weight, l->lamp[k].scale);
    add(to->power, weight, 3, (double)r[LIGHT]);
    for (int q = PLACE; q < LIGHT_NOISE; q++) to->sum[q] += worth * (double)r[q];
    for (int q = LIGHT_NOISE; q < RECORD; q++)
      to->sum[q] += worth * worth * (double)r[q] * (double)r[q];
  }
}

static ylm_status weigh(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const weighing *w = context;
  for (size_t k = begin; k < end; k++) weigh_lamp(w, k, &w->total[k]);
  return YLM_OK;
}

static void write_total(const total *t, double *out) {
  for (int a = 0; a < 3; a++) {
    out[YLM_LAMPLIGHT_SCALE + a] = t->power[a];
    out[YLM_LAMPLIGHT_PLACE + a] = t->sum[PLACE + a];
    out[YLM_LAMPLIGHT_TURN + a] = t->sum[TURN + a];
    out[YLM_LAMPLIGHT_NOISE + 1 + a] = sqrt(t->sum[PLACE_NOISE + a]);
    out[YLM_LAMPLIGHT_NOISE + 4 + a] = sqrt(t->sum[TURN_NOISE + a]);
  }
  for (int a = 0; a < 2; a++) out[YLM_LAMPLIGHT_SIZE + a] = t->sum[SIZE + a];
  out[YLM_LAMPLIGHT_NOISE] = sqrt(t->sum[LIGHT_NOISE]);
}

ylm_status ylm_lamplight_weigh(ylm_lamplight *l, const double (*weight)[3], int threads,
                               double *out) {
  weighing w = {.l = l, .weight = weight, .total = ylm_alloc_zero(l->lamps, sizeof *w.total)};
  ylm_status s = w.total ? YLM_OK : YLM_ENOMEM;
  for (; w.first < l->places && s == YLM_OK; w.first += l->block) {
    if (l->stats.again) s = fill(l, w.first, NULL);
    if (s == YLM_OK) s = ylm_parallel(l->lamps, 1, threads, weigh, &w, NULL, NULL);
  }
  for (size_t k = 0; k < l->lamps && s == YLM_OK; k++)
    write_total(&w.total[k], out + k * YLM_LAMPLIGHT_NUMBERS);
  ylm_free(w.total);
  return s;
}
