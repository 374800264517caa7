/* cast.c - points that gloss, lit by rays to lamps and by rays that their material chooses. */
#include <math.h>
#include <string.h>

#include "../calibration.h"
#include "../view.h"
#include "ylm_path.h"

/* Points that are lit together: those of one pixel and mesh, which are parts of one highlight. */
typedef struct items {
  size_t n;
  size_t *first;          /* [points+1] of each item's points in `order` */
  size_t *order;          /* [points] their places in the list             */
  size_t *pixel;          /* [points] of each item */
  ylm_scene_place *place; /* [points] in that order */
  float *weight;          /* [points]               */
} items;

static void items_free(items *x) {
  ylm_free(x->first);
  ylm_free(x->order);
  ylm_free(x->pixel);
  ylm_free(x->place);
  ylm_free(x->weight);
}

static bool items_create(items *x, size_t n) {
  *x = (items){.first = ylm_alloc(n + 1, sizeof *x->first),
               .order = ylm_alloc(n, sizeof *x->order),
               .pixel = ylm_alloc(n, sizeof *x->pixel),
               .place = ylm_alloc(n, sizeof *x->place),
               .weight = ylm_alloc(n, sizeof *x->weight)};
  return x->first && x->order && x->pixel && x->place && x->weight;
}

/* Lists the points list[from] .. list[behind-1], of one pixel, mesh by mesh. */
static void gather(const ylm_shade_view *v, size_t pixel, const size_t *list, size_t from,
                   size_t behind, items *x) {
  size_t end = from;
  for (size_t i = from; i < behind; i++) {
    uint32_t mesh = v->entry[list[i]].at.mesh;
    bool known = false;
    for (size_t k = from; v->o.share > 0 && k < i && !known; k++)
      known = v->entry[list[k]].at.mesh == mesh;
    if (known) continue;
    x->pixel[x->n] = pixel;
    x->first[x->n++] = end;
    for (size_t k = i; k < (v->o.share > 0 ? behind : i + 1); k++)
      if (v->entry[list[k]].at.mesh == mesh) {
        x->place[end] = v->entry[list[k]].at;
        x->weight[end] = v->entry[list[k]].weight;
        x->order[end++] = k;
      }
  }
}

/* The items of n listed points. */
static void list_items(const ylm_shade_view *v, size_t n, const size_t *list, items *x) {
  for (size_t i = 0, behind, pixel = 0; i < n; i = behind) {
    while (v->pixel[pixel + 1].first <= list[i]) pixel++;
    for (behind = i + 1; behind < n && list[behind] < v->pixel[pixel + 1].first;) behind++;
    gather(v, pixel, list, i, behind, x);
  }
  x->first[x->n] = n;
}

static uint32_t mesh_of(const items *x, size_t i) { return x->place[x->first[i]].mesh; }

/* Mean, rest and variance of n items' radiance, [n][3] each, in room [9 n]; none where that is NULL. */
static ylm_path_sum sums_in(float *room, size_t n) {
  return room ? (ylm_path_sum){0, room, room + 3 * n, room + 6 * n} : (ylm_path_sum){0};
}

/* Adds the radiance of items, with its variance, to room [9 n]. */
static ylm_status cast_items(const ylm_shade_view *v, const shade_cast *c, int light_samples,
                             uint64_t seed, const items *x, float *room, uint64_t *rays) {
  ylm_path_options o = {.samples = light_samples,
                        .single = c->own != NULL, /* two halves tell the noise */
                        .first = 1,
                        .last = 1,
                        .seed = seed,
                        .threads = c->threads,
                        .progress = c->progress};
  ylm_path_stats stats = {0};
  ylm_path_sum sum = sums_in(room, x->n);
  bool single = x->first[x->n] == x->n;
  ylm_status s =
      ylm_path_places(c->lit ? c->lit : v->scene, x->n, x->place, single ? NULL : x->first,
                      x->weight, v->frame.from, c->shadows, &o, &sum, &stats, NULL);
  *rays += stats.nearest_rays + stats.shadow_rays;
  return s;
}

/* -- places of their own -------------------------------------------------------------- */

typedef struct fresh_job {
  const ylm_shade_view *v;
  const items *all;
  const size_t *item; /* [n] of all */
  size_t most;        /* places of an item */
  uint64_t seed;
  ylm_scene_place *place; /* [n][most] */
  size_t *found;          /* [n]       */
} fresh_job;

static ylm_status find_fresh(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const fresh_job *j = context;
  ylm_trace_ray *ray = ylm_alloc(j->most, sizeof *ray);
  ylm_trace_hit *hit = ylm_alloc(j->most, sizeof *hit);
  ylm_status s = ray && hit ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; s == YLM_OK && i < end; i++) {
    ylm_scene_place *to = j->place + i * j->most;
    size_t n = 0;
    ylm__shade_pixel_rays(j->v, j->all->pixel[j->item[i]], (int)j->most, j->seed, ray);
    ylm_trace_intersect(ylm_scene_trace(j->v->scene), j->most, ray, true, hit);
    for (size_t k = 0; k < j->most; k++) {
      const ylm_trace_hit *h = &hit[k];
      if (h->mesh != (int32_t)mesh_of(j->all, j->item[i])) continue;
      bool back = ylm_dot3(h->normal, ray[k].dir) > 0;
      to[n++] = (ylm_scene_place){(uint32_t)h->mesh, h->element, h->u, h->v, back};
    }
    j->found[i] = n;
  }
  ylm_free(ray);
  ylm_free(hit);
  return s;
}

/* Items item[0] .. item[n-1] of all: their points, or as many as `most` places of their own (0: points). */
static ylm_status pick(const ylm_shade_view *v, const items *all, size_t n, const size_t *item,
                       size_t most, uint64_t seed, int threads, items *out) {
  size_t end = 0, room = 0;
  for (size_t i = 0; i < n; i++) { /* for its points, or for places of its own */
    size_t points = all->first[item[i] + 1] - all->first[item[i]];
    room += points > most ? points : most;
  }
  fresh_job j = {v, all, item, most, ~seed, NULL, NULL};
  ylm_status s = items_create(out, room) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && most > 0) {
    j.place = ylm_alloc(n * most, sizeof *j.place);
    j.found = ylm_alloc_zero(n, sizeof *j.found);
    s = j.place && j.found ? YLM_OK : YLM_ENOMEM;
    if (s == YLM_OK) s = ylm_parallel(n, CAST_FRESH_GRAIN, threads, find_fresh, &j, NULL, "places");
  }
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    size_t found = most > 0 ? j.found[i] : 0;
    out->first[out->n++] = end;
    for (size_t k = 0; k < found; k++, end++) {
      out->place[end] = j.place[i * most + k];
      out->weight[end] = 1;
    }
    for (size_t k = all->first[item[i]]; !found && k < all->first[item[i] + 1]; k++, end++) {
      out->place[end] = all->place[k];
      out->weight[end] = all->weight[k];
    }
  }
  if (s == YLM_OK) out->first[n] = end;
  ylm_free(j.place);
  ylm_free(j.found);
  return s;
}

/* The radiance of items item[0] .. item[n-1], by as many samples each, and its variance; `call` differs from call
   to call. out: as cast_items has it of all. */
static ylm_status cast_some(const ylm_shade_view *v, const shade_cast *c, const items *all,
                            size_t n, const size_t *item, int samples, uint64_t call, float *out,
                            uint64_t *rays) {
  size_t most = samples / CAST_FRESH_PART < CAST_FRESH_MOST ? (size_t)samples / CAST_FRESH_PART
                                                            : CAST_FRESH_MOST;
  uint64_t seed = c->seed + call * 0x9e3779b97f4a7c15u;
  items some = {0};
  float *room = ylm_alloc_zero(9 * n, sizeof *room);
  ylm_path_sum part = sums_in(room, n), whole = sums_in(out, all->n);
  if (most < CAST_FRESH_LEAST)
    most = c->own && samples < CAST_FRESH_LEAST / 2 ? 2 * (size_t)samples : CAST_FRESH_LEAST;
  if (!(v->o.share > 0)) most = 0;
  ylm_status s = room ? pick(v, all, n, item, most, seed, c->threads, &some) : YLM_ENOMEM;
  if (s == YLM_OK) s = cast_items(v, c, samples, seed, &some, room, rays);
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    for (size_t a = 0; a < 3; a++) {
      whole.mean[3 * item[i] + a] = part.mean[3 * i + a] + part.rest[3 * i + a];
      whole.variance[3 * item[i] + a] = part.variance[3 * i + a];
    }
  items_free(&some);
  ylm_free(room);
  return s;
}

/* All items, those of one number of samples after another. */
static ylm_status cast_chosen(const ylm_shade_view *v, const shade_cast *c, const items *x,
                              const int *samples, uint64_t call, float *out, uint64_t *rays) {
  size_t *item = ylm_alloc(x->n, sizeof *item);
  ylm_status s = item ? YLM_OK : YLM_ENOMEM;
  int most = 0;
  for (size_t i = 0; i < x->n; i++) most = samples[i] > most ? samples[i] : most;
  for (int next, now = 1; s == YLM_OK && now <= most; now = next) {
    size_t n = 0, block = (size_t)CAST_FRESH_ROOM * CAST_FRESH_PART / (size_t)now + 128;
    next = most + 1;
    for (size_t i = 0; i < x->n; i++) {
      if (samples[i] == now) item[n++] = i;
      if (samples[i] > now && samples[i] < next) next = samples[i];
    }
    for (size_t k = 0; s == YLM_OK && k < n; k += block)
      s = cast_some(v, c, x, n - k < block ? n - k : block, item + k, now, call++, out, rays);
  }
  ylm_free(item);
  return s;
}

/* -- how many samples each item needs ------------------------------------------------ */

/* A mesh, as a trial has it. */
typedef struct mesh_noise {
  double square;    /* summed squares of its items' radiance, */
  double deviation; /* summed deviations of one sample of each */
  double left;      /* summed variances that the chosen numbers leave */
  size_t n;
} mesh_noise;

/* How much the picture shows of item i's radiance by rays: its part of the pixel. */
static double part_of(const shade_cast *c, const items *x, size_t i, bool mixed) {
  double part = 0;
  for (size_t k = x->first[i]; k < x->first[i + 1]; k++)
    part += (double)x->weight[k] * (mixed && c->share ? (double)c->share[x->order[k]] : 1);
  return part;
}

static double sum3(const float *x) { return (double)x[0] + (double)x[1] + (double)x[2]; }

/* The mean of the variance of item i and of those of its mesh in pixels beside it. */
static double smooth(const ylm_shade_view *v, const items *x, const size_t *start,
                     const float *variance, size_t i) {
  size_t width = (size_t)v->o.width, height = (size_t)v->o.height, n = 0, reach = v->number ? 0 : 1;
  size_t px = x->pixel[i] % width, py = x->pixel[i] / width;
  double sum = 0;
  for (size_t b = py > reach ? py - reach : 0; b <= py + reach && b < height; b++)
    for (size_t a = px > reach ? px - reach : 0; a <= px + reach && a < width; a++)
      for (size_t k = start[b * width + a]; k < start[b * width + a + 1]; k++) {
        if (mesh_of(x, k) != mesh_of(x, i)) continue;
        sum += sum3(variance + 3 * k);
        n++;
      }
  return sum / (double)n;
}

/* Where each pixel's items start: [pixels+1]. */
static void find_starts(const ylm_shade_view *v, const items *x, size_t *start) {
  size_t pixels = v->stats.pixels;
  for (size_t p = 0, i = 0; p <= pixels; p++) {
    while (i < x->n && x->pixel[i] < p) i++;
    start[p] = i;
  }
}

/* Whole batches: a power of two of samples, or one and a half of that. */
static int whole(double wanted, int least, int most) {
  int n = YLM_PATH_BATCH;
  while (n < most && (n < wanted || n < least)) {
    bool power = (n & (n - 1)) == 0;
    n = n == YLM_PATH_BATCH ? 2 * n : power ? n / 2 * 3 : n / 3 * 4;
  }
  return n < most ? n : most;
}

/* Meshes as the trial's `room` has them, and the deviation of one sample of each item in the picture. */
static void measure(const ylm_shade_view *v, const shade_cast *c, const items *x,
                    const size_t *start, const float *room, mesh_noise *mesh, double *deviation) {
  const float *variance = room + 6 * x->n;
  double all = 0;
  for (size_t i = 0; i < x->n; i++) {
    mesh_noise *m = &mesh[mesh_of(x, i)];
    const float *r = room + 3 * i;
    double part = part_of(c, x, i, false), square = -sum3(variance + 3 * i);
    for (size_t a = 0; a < 3; a++) square += (double)r[a] * (double)r[a];
    deviation[i] =
        sqrt(smooth(v, x, start, variance, i) * CAST_TRIAL_SAMPLES) * part_of(c, x, i, true);
    m->square += part * part * square;
    m->deviation += deviation[i];
    m->n++;
    all += part * part * square;
  }
  for (size_t k = 0; k < ylm_scene_meshes(v->scene); k++)
    mesh[k].square = fmax(mesh[k].square, CAST_DARK * all * (double)mesh[k].n / (double)x->n);
}

/* The number of samples that leave little noise in item i beside its own radiance. */
static double wanted_there(double noise, const mesh_noise *m, const float *mean, double deviation) {
  double norm = CAST_PIXEL_DARK * sqrt(m->square / (double)m->n), square = 0;
  for (size_t a = 0; a < 3; a++) square += (double)mean[a] * (double)mean[a];
  norm = (norm + sqrt(square)) * CAST_PIXEL_NOISE * noise;
  return norm > 0 ? fmin(CAST_PIXEL_MOST, deviation * deviation / (norm * norm)) : 0;
}

/* The number of samples of each item: the fewest in all that leave c->noise in each mesh are in proportion
   to deviations. */
static void choose(const ylm_shade_view *v, shade_cast *c, const items *x, const float *mean,
                   const double *deviation, mesh_noise *mesh, int *samples) {
  double worst = 0, total = 0;
  for (size_t i = 0; i < x->n; i++) {
    mesh_noise *m = &mesh[mesh_of(x, i)];
    double allowed = c->noise * c->noise * m->square;
    double wanted = allowed > 0 ? deviation[i] * m->deviation / allowed : 0;
    wanted = fmax(wanted, wanted_there(c->noise, m, mean + 3 * i, deviation[i]));
    samples[i] = whole(wanted, c->light_samples, c->most);
    m->left += deviation[i] * deviation[i] / samples[i];
    total += samples[i];
  }
  for (size_t k = 0; k < ylm_scene_meshes(v->scene); k++)
    if (mesh[k].square > 0) worst = fmax(worst, sqrt(mesh[k].left / mesh[k].square));
  c->noise = worst;
  c->light_samples = (int)ceil(total / (double)x->n);
}

static ylm_status try_items(const ylm_shade_view *v, shade_cast *c, const items *x, float *room,
                            int *samples, uint64_t *rays) {
  mesh_noise *mesh = ylm_alloc_zero(ylm_scene_meshes(v->scene), sizeof *mesh);
  size_t *start = ylm_alloc(v->stats.pixels + 1, sizeof *start);
  double *deviation = ylm_alloc(x->n, sizeof *deviation);
  ylm_status s = mesh && start && deviation ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < x->n; i++) samples[i] = CAST_TRIAL_SAMPLES;
  if (s == YLM_OK) s = cast_chosen(v, c, x, samples, CAST_TRIAL_CALLS, room, rays);
  if (s == YLM_OK) {
    find_starts(v, x, start);
    measure(v, c, x, start, room, mesh, deviation);
    choose(v, c, x, room, deviation, mesh, samples);
    memset(room, 0, 9 * x->n * sizeof *room);
  }
  ylm_free(mesh);
  ylm_free(start);
  ylm_free(deviation);
  return s;
}

/* All items, each with the rays of its points. */
static ylm_status cast_own(const ylm_shade_view *v, const shade_cast *c, const items *x,
                           int *samples, float *room, uint64_t *rays) {
  for (size_t i = 0; i < x->n; i++) {
    double wanted = 0;
    for (size_t k = x->first[i]; k < x->first[i + 1]; k++) wanted += (double)c->own[x->order[k]];
    samples[i] = whole(wanted, YLM_PATH_BATCH, YLM_PATH_SAMPLES);
  }
  return cast_chosen(v, c, x, samples, 1, room, rays);
}

ylm_status ylm__shade_cast(const ylm_shade_view *v, shade_cast *c, size_t n, const size_t *point,
                           float *out, uint64_t *rays) {
  items x;
  float *room = ylm_alloc_zero(9 * n, sizeof *room);
  int *samples = ylm_alloc(n, sizeof *samples);
  ylm_status s = items_create(&x, n) && room && samples ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && n > 0 && v->corner) s = YLM_EINVAL;
  if (s == YLM_OK) list_items(v, n, point, &x);
  if (s == YLM_OK && n > 0 && c->noise > 0) {
    s = try_items(v, c, &x, room, samples, rays);
    if (s == YLM_OK) s = cast_chosen(v, c, &x, samples, 1, room, rays);
  } else if (s == YLM_OK && n > 0 && c->own)
    s = cast_own(v, c, &x, samples, room, rays);
  else if (s == YLM_OK && n > 0)
    s = cast_items(v, c, c->light_samples, c->seed, &x, room, rays);
  for (size_t i = 0; s == YLM_OK && i < x.n; i++)
    for (size_t k = x.first[i]; k < x.first[i + 1]; k++)
      for (size_t a = 0; a < 3; a++) out[3 * x.order[k] + a] = room[3 * i + a];
  items_free(&x);
  ylm_free(room);
  ylm_free(samples);
  return s;
}
