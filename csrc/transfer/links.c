/* links.c - rays of elements and of other places, and the elements that they hit first. */
#include <math.h>
#include <stdatomic.h>

#include "calibration.h"
#include "transfer.h"
#include "ylm_random.h"

/* -- rooms of links ---------------------------------------------------------------- */

ylm_links ylm_transfer_room(const ylm_transfer *t, size_t n) {
  ylm_links l = {NULL, NULL};
  if (ylm__links_are_short(t->elements))
    l.two = ylm_alloc(n, sizeof *l.two);
  else
    l.four = ylm_alloc(n, sizeof *l.four);
  return l;
}

void ylm_links_free(ylm_links l) {
  ylm_free(l.two);
  ylm_free(l.four);
}

void ylm__links_put(ylm_links l, size_t k, size_t n, const uint32_t *from) {
  if (l.two)
    for (size_t i = 0; i < n; i++) l.two[k + i] = (uint16_t)from[i];
  else
    memcpy(l.four + k, from, n * sizeof *from);
}

/* -- rays -------------------------------------------------------------------------- */

typedef struct job {
  const ylm_transfer *t;
  int links, lmax; /* lmax < 0: no escape */
  uint64_t seed;
  const float (*origin)[3], (*normal)[3]; /* of places; origin NULL: the transfer's elements */
  const uint64_t *stream;
  ylm_links out;
  float *escape;
  float *share;
  const transfer_flow *flow; /* or NULL */
  transfer_fan fan;
  float (*inside)[2]; /* [links] unshifted places of a square */
  double *zonal;      /* [lmax + 1] of the cosine */
  atomic_uint_fast64_t escaped, buried, lost, deads;
} job;

/* The memory of one thread. */
typedef struct scratch {
  ylm_trace_ray *ray; /* [places*links] */
  ylm_trace_hit *hit;
  uint32_t *target;
  uint8_t *open;           /* [places*links] the ray leaves the scene */
  uint8_t *below;          /* [places*links] it starts into its own triangle */
  uint32_t *pick, *sorted; /* [links] */
  uint32_t *links;         /* [links] of a place */
  float *direction, *Y;    /* [TRANSFER_RAYS][3], [TRANSFER_RAYS][count] */
  float *seen, *all;       /* [count] */
  uint64_t escaped, buried, lost, deads;
} scratch;

void ylm__transfer_fan_free(transfer_fan *f) {
  ylm_free(f->disk);
  ylm_free(f->height);
}

ylm_status ylm__transfer_fan_create(int rays, transfer_fan *f) {
  f->rays = rays;
  f->disk = ylm_alloc((size_t)rays, sizeof *f->disk);
  f->height = ylm_alloc((size_t)rays, sizeof *f->height);
  if (!f->disk || !f->height) return YLM_ENOMEM;
  for (int k = 0; k < rays; k++) {
    double turn = 2 * YLM_PI * ylm_scene_radical((uint32_t)k);
    f->disk[k][0] = (float)cos(turn);
    f->disk[k][1] = (float)sin(turn);
    f->height[k] = (float)k / (float)rays;
  }
  return YLM_OK;
}

void ylm__transfer_fan_aim(const transfer_fan *f, const float *n, ylm_rng *rng,
                           ylm_trace_ray *ray) {
  float shift = (float)ylm_draw_double(rng), a[3], b[3];
  double turn = 2 * YLM_PI * ylm_draw_double(rng);
  float c = (float)cos(turn), s = (float)sin(turn);
  if (n) ylm_scene_basis(n, a, b);
  for (int k = 0; k < f->rays; k++) {
    float h = f->height[k] + shift, r, z;
    if (h >= 1) h -= 1;
    z = n ? sqrtf(1 - h) : 1 - 2 * h;
    r = n ? sqrtf(h) : sqrtf(4 * h * (1 - h));
    float x = r * (f->disk[k][0] * c - f->disk[k][1] * s);
    float y = r * (f->disk[k][0] * s + f->disk[k][1] * c);
    for (int q = 0; q < 3; q++)
      ray[k].dir[q] = n ? x * a[q] + y * b[q] + z * n[q] : q == 0 ? x : q == 1 ? y : z;
    ray[k].near = 0;
    ray[k].far = INFINITY;
  }
}

/* Rays of place i. */
static void place_rays(const job *j, size_t i, ylm_trace_ray *ray, uint8_t *below) {
  ylm_rng rng;
  ylm_draw_seed(&rng, j->seed, j->stream ? j->stream[i] : i);
  ylm__transfer_fan_aim(&j->fan, j->normal ? j->normal[i] : NULL, &rng, ray);
  for (int k = 0; k < j->links; k++) memcpy(ray[k].org, j->origin[i], 12);
  memset(below, 0, (size_t)j->links);
}

/* Rays of element i, whose origins are stratified over it. */
static void element_rays(const job *j, size_t i, ylm_trace_ray *ray, uint8_t *below) {
  const ylm_transfer *t = j->t;
  ylm_scene_place place[3], here;
  ylm_scene_surface at[3], own;
  float corner[3][2], across[3];
  double d[2][3];
  ylm_rng rng;
  ylm_draw_seed(&rng, j->seed, i);
  ylm__transfer_fan_aim(&j->fan, t->normal[i], &rng, ray);
  float x0 = (float)ylm_draw_double(&rng), y0 = (float)ylm_draw_double(&rng);
  ylm__transfer_corners(t, i, place, corner);
  for (int k = 2; k >= 0; k--) {
    place[k] = place[0];
    place[k].u = corner[k][0], place[k].v = corner[k][1];
  }
  ylm_scene_surfaces(t->scene, 3, place, at);
  for (int a = 0; a < 6; a++)
    d[a / 3][a % 3] = (double)at[1 + a / 3].origin[a % 3] - (double)at[0].origin[a % 3];
  memcpy(across, at[0].flat, 12);
  here = place[0];
  for (int k = 0; k < j->links; k++) {
    float x = j->inside[k][0] + x0, y = j->inside[k][1] + y0;
    if (x >= 1) x -= 1;
    if (y >= 1) y -= 1;
    if (x + y > 1) x = 1 - x, y = 1 - y;
    for (int a = 0; a < 3; a++)
      ray[k].org[a] =
          ylm_away((double)at[0].origin[a] + (double)x * d[0][a] + (double)y * d[1][a], across[a]);
    if (t->crossed[i]) {
      ylm__transfer_inside(corner, x, y, &here);
      ylm__transfer_hold(t, i, &here);
      ylm_scene_surfaces(t->scene, 1, &here, &own);
      memcpy(ray[k].org, own.origin, 12);
    }
    below[k] = !(ylm_dot3(ray[k].dir, across) > 0);
    if (below[k]) ray[k].far = -1;
  }
}

/* Puts a few numbers in order. */
static void sort_few(uint32_t *a, size_t n) {
  for (size_t i = 1; i < n; i++) {
    uint32_t x = a[i];
    size_t k = i;
    for (; k > 0 && a[k - 1] > x; k--) a[k] = a[k - 1];
    a[k] = x;
  }
}

/* Puts numbers, all below or equal to `most`, in order. */
static void sort(uint32_t *a, uint32_t *b, size_t n, uint32_t most) {
  enum { DIGIT = 7, DIGITS = 1 << DIGIT };
  for (unsigned shift = 0; n > LINKS_FEW && shift < 32 && most >> shift; shift += DIGIT) {
    uint32_t place[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < n; i++) place[a[i] >> shift & (DIGITS - 1)]++;
    for (int k = 0; k < DIGITS; k++) {
      uint32_t count = place[k];
      place[k] = sum;
      sum += count;
    }
    for (size_t i = 0; i < n; i++) b[place[a[i] >> shift & (DIGITS - 1)]++] = a[i];
    memcpy(a, b, n * sizeof *a);
  }
  if (n <= LINKS_FEW) sort_few(a, n);
}

/* The unoccluded transfer: the cosine's, or that of 1. */
static ylm_status whole(const job *j, const float *n, float *T) {
  size_t count = ylm_sh_count(j->lmax);
  if (!n) {
    memset(T, 0, count * sizeof *T);
    T[0] = (float)sqrt(4 * YLM_PI);
    return YLM_OK;
  }
  ylm_status s = ylm_sh_eval(j->lmax, 0, false, YLM_FLOAT, 1, n, T, NULL, NULL, 1, NULL);
  for (int l = 0; l <= j->lmax; l++)
    for (size_t k = ylm_sh_index(l, -l); k <= ylm_sh_index(l, l); k++) T[k] *= (float)j->zonal[l];
  return s;
}

/* Coefficients of cosine times escape of one place, from its rays x->pick; those of the cosine, which
   are known, are a control variate. */
static ylm_status escape(const job *j, scratch *x, const float *n, const ylm_trace_ray *ray,
                         const uint8_t *open, float *T) {
  size_t count = ylm_sh_count(j->lmax);
  int seen = 0;
  for (int k = 0; k < j->links; k++) seen += open[x->pick[k]];
  memset(T, 0, count * sizeof *T);
  if (seen == 0) return YLM_OK;
  ylm_status s = whole(j, n, T);
  if (seen == j->links || s != YLM_OK) return s;
  memset(x->seen, 0, count * sizeof *x->seen);
  memset(x->all, 0, count * sizeof *x->all);
  for (int first = 0; s == YLM_OK && first < j->links; first += TRANSFER_RAYS) {
    int m = j->links - first < TRANSFER_RAYS ? j->links - first : TRANSFER_RAYS;
    for (int k = 0; k < m; k++) memcpy(x->direction + 3 * k, ray[x->pick[first + k]].dir, 12);
    s = ylm_sh_eval(j->lmax, 0, false, YLM_FLOAT, (size_t)m, x->direction, x->Y, NULL, NULL, 1,
                    NULL);
    for (int k = 0; s == YLM_OK && k < m; k++) {
      const float *y = x->Y + (size_t)k * count;
      for (size_t q = 0; q < count; q++) x->all[q] += y[q];
      if (open[x->pick[first + k]])
        for (size_t q = 0; q < count; q++) x->seen[q] += y[q];
    }
  }
  float each = (float)((n ? YLM_PI : 4 * YLM_PI) / j->links), part = (float)seen / (float)j->links;
  for (size_t q = 0; q < count; q++) T[q] = each * x->seen[q] + part * (T[q] - each * x->all[q]);
  return s;
}

/* Turns targets into links: what begins inside of a body gives its slots to the others, evenly. Returns
   how many do not. */
static uint32_t settle(const job *j, scratch *x, const uint32_t *target, uint32_t *out) {
  uint32_t none = (uint32_t)j->t->elements, links = (uint32_t)j->links, n = 0, b = 0;
  for (uint32_t k = 0; k < links; k++)
    if (target[k] <= none) x->sorted[n++] = k;
  x->buried += links - n;
  for (uint32_t k = 0; k < links; k++) {
    bool good = target[k] <= none;
    x->pick[k] = good || n == 0 ? k : x->sorted[(uint64_t)b++ * n / (links - n)];
    out[k] = n == 0 ? none : target[x->pick[k]];
  }
  return n;
}

/* The light that links bring along the axes, of rays that are still in the order of `out`. */
static void flow_of(const job *j, const scratch *x, const float *n, const ylm_trace_ray *ray,
                    const uint32_t *out, float flow[3][3]) {
  double sum[9] = {0};
  for (int k = 0; k < j->links; k++) {
    const float *w = ray[x->pick[k]].dir, *L = j->flow->leaving + 4 * (size_t)out[k];
    double level = fmax((double)ylm_dot3(w, n), FLOW_LEVEL);
    for (int i = 0; i < 9; i++) sum[i] += (double)L[i % 3] * (double)w[i / 3] / level;
  }
  for (int i = 0; i < 9; i++) flow[i / 3][i % 3] = (float)(YLM_PI * sum[i] / j->links);
}

/* Links of a place whose rays have been traced. */
static ylm_status finish(const job *j, scratch *x, size_t i, size_t first) {
  size_t links = (size_t)j->links, at = (i - first) * links, under = 0;
  uint32_t none = (uint32_t)j->t->elements, *out = x->links;
  uint8_t *open = x->open + at;
  for (size_t k = 0; k < links; k++) {
    bool hit = x->hit[at + k].mesh >= 0, below = x->below[at + k];
    if (below) x->target[at + k] = none;
    under += below;
    open[k] = !hit && !below;
    x->escaped += !hit || below;
    x->lost += hit && !below && x->target[at + k] == none;
  }
  size_t good = settle(j, x, x->target + at, out);
  bool dead = good == 0 || (good == under && good < links);
  x->deads += dead;
  if (j->share) j->share[i] = dead ? 0 : (float)(good - under) / (float)(links - under);
  if (j->share && under == links) j->share[i] = 1;
  ylm_status s = YLM_OK;
  if (j->escape) {
    const float *n = j->origin ? (j->normal ? j->normal[i] : NULL) : j->t->normal[i];
    s = escape(j, x, n, x->ray + at, open, j->escape + i * ylm_sh_count(j->lmax));
  }
  if (j->flow) flow_of(j, x, j->normal[i], x->ray + at, out, j->flow->out[i]);
  sort(out, x->sorted, links, none);
  ylm__links_put(j->out, i * links, links, out);
  return s;
}

static void scratch_free(scratch *x) {
  ylm_free(x->ray);
  ylm_free(x->hit);
  ylm_free(x->target);
  ylm_free(x->open);
  ylm_free(x->below);
  ylm_free(x->pick);
  ylm_free(x->sorted);
  ylm_free(x->links);
  ylm_free(x->direction);
  ylm_free(x->Y);
  ylm_free(x->seen);
  ylm_free(x->all);
}

static bool scratch_create(scratch *x, size_t rays, size_t links, int lmax) {
  size_t count = ylm_sh_count(lmax < 0 ? 0 : lmax),
         batch = links < TRANSFER_RAYS ? links : TRANSFER_RAYS;
  x->ray = ylm_alloc(rays, sizeof *x->ray);
  x->hit = ylm_alloc(rays, sizeof *x->hit);
  x->target = ylm_alloc(rays, sizeof *x->target);
  x->open = ylm_alloc(rays, 1);
  x->below = ylm_alloc(rays, 1);
  x->pick = ylm_alloc(links, sizeof *x->pick);
  x->sorted = ylm_alloc(links, sizeof *x->sorted);
  x->links = ylm_alloc(links, sizeof *x->links);
  x->direction = ylm_alloc(batch, 12);
  x->Y = ylm_alloc(batch * count, sizeof *x->Y);
  x->seen = ylm_alloc(count, sizeof *x->seen);
  x->all = ylm_alloc(count, sizeof *x->all);
  return x->ray && x->hit && x->target && x->open && x->below && x->pick && x->sorted && x->links &&
         x->direction && x->Y && x->seen && x->all;
}

/* Places begin .. end-1. */
static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  size_t links = (size_t)j->links, batch = TRANSFER_RAYS / links > 1 ? TRANSFER_RAYS / links : 1;
  scratch x = {0};
  ylm_status s = scratch_create(&x, batch * links, links, j->lmax) ? YLM_OK : YLM_ENOMEM;
  for (size_t first = begin; s == YLM_OK && first < end; first += batch) {
    size_t n = end - first < batch ? end - first : batch;
    for (size_t i = 0; i < n; i++)
      (j->origin ? place_rays : element_rays)(j, first + i, x.ray + i * links, x.below + i * links);
    ylm_trace_nearest(ylm_scene_trace(j->t->scene), n * links, x.ray, false, x.hit);
    ylm_transfer_hits(j->t, n * links, x.ray, x.hit, x.target);
    for (size_t i = first; s == YLM_OK && i < first + n; i++) s = finish(j, &x, i, first);
  }
  atomic_fetch_add(&j->escaped, x.escaped);
  atomic_fetch_add(&j->buried, x.buried);
  atomic_fetch_add(&j->lost, x.lost);
  atomic_fetch_add(&j->deads, x.deads);
  scratch_free(&x);
  return s;
}

/* Low-discrepancy numbers that all places share: Hammersley's set, and R2 (Roberts 2018). */
static ylm_status share(job *j) {
  size_t links = (size_t)j->links;
  ylm_status s = ylm__transfer_fan_create(j->links, &j->fan);
  j->inside = ylm_alloc(links, sizeof *j->inside);
  j->zonal = ylm_alloc((size_t)(j->lmax < 0 ? 0 : j->lmax) + 1, sizeof *j->zonal);
  if (s != YLM_OK || !j->inside || !j->zonal) return YLM_ENOMEM;
  for (size_t k = 0; k < links; k++) {
    double x, y;
    j->inside[k][0] = (float)modf((double)k * 0.7548776662466927, &x);
    j->inside[k][1] = (float)modf((double)k * 0.5698402909980532, &y);
  }
  if (j->lmax < 0) return YLM_OK;
  return ylm_material_cosine(j->lmax, j->zonal);
}

static ylm_status go(job *j, size_t n, int threads, const ylm_progress *progress) {
  ylm_status s = share(j);
  if (s == YLM_OK) s = ylm_parallel(n, LINKS_GRAIN, threads, run, j, progress, "links");
  ylm__transfer_fan_free(&j->fan);
  ylm_free(j->inside);
  ylm_free(j->zonal);
  return s;
}

ylm_status ylm__transfer_link(ylm_transfer *t, const ylm_progress *progress, ylm_error *e) {
  size_t links = (size_t)t->form.links;
  t->link = ylm_transfer_room(t, t->elements * links);
  if (t->form.lmax >= 0)
    t->escape = ylm_alloc(t->elements * ylm_sh_count(t->form.lmax), sizeof *t->escape);
  if (ylm_links_are_none(t->link) || (t->form.lmax >= 0 && !t->escape)) return YLM_ENOMEM;
  job j = {.t = t,
           .links = t->form.links,
           .lmax = t->form.lmax,
           .seed = t->form.seed,
           .out = t->link,
           .escape = t->escape,
           .share = t->share};
  ylm_status s = go(&j, t->elements, t->form.threads, progress);
  if (s == YLM_ECANCELLED) ylm_fail(e, s, "cancelled while links were found");
  t->stats.rays = t->elements * links;
  t->stats.escaped = j.escaped;
  t->stats.buried = j.buried;
  t->stats.lost = j.lost;
  t->stats.dead = j.deads;
  return s;
}

ylm_status ylm__transfer_check_links(int links, ylm_error *e) {
  if (links >= 4 && links <= YLM_TRANSFER_LINKS && links % 4 == 0) return YLM_OK;
  return ylm_fail(e, YLM_ERANGE, "rays must be a multiple of 4 from 4 to %d, got %d",
                  YLM_TRANSFER_LINKS, links);
}

ylm_status ylm__transfer_find_shares(const ylm_transfer *t, size_t n, const float (*origin)[3],
                                     const float (*normal)[3], const uint64_t *stream, int links,
                                     uint64_t seed, int threads, const ylm_progress *progress,
                                     ylm_links out, int lmax, float *escapes, float *share,
                                     const transfer_flow *flow) {
  job j = {.t = t,
           .links = links,
           .lmax = escapes ? lmax : -1,
           .seed = seed,
           .origin = origin,
           .normal = normal,
           .stream = stream,
           .out = out,
           .escape = escapes,
           .share = share,
           .flow = flow};
  return go(&j, n, threads, progress);
}

ylm_status ylm__transfer_check_places(size_t n, const char *what, const float (*place)[3],
                                      const float (*normal)[3], ylm_error *e) {
  ylm_status s = ylm_trace_check(YLM_FLOAT, n, place, what, e);
  for (size_t i = 0; s == YLM_OK && normal && i < n; i++) {
    double x = (double)normal[i][0], y = (double)normal[i][1], z = (double)normal[i][2];
    if (!(x * x + y * y + z * z <= 1.01))
      s = ylm_fail(e, YLM_EDOMAIN, "normal %zu is not finite, or longer than 1", i + 1);
  }
  return s;
}

ylm_status ylm_transfer_find(const ylm_transfer *t, size_t n, const float (*origin)[3],
                             const float (*normal)[3], const uint64_t *stream, int links,
                             uint64_t seed, int threads, const ylm_progress *progress,
                             ylm_links out, int lmax, float *escapes, ylm_error *e) {
  ylm_status s = ylm__transfer_check_links(links, e);
  if (s == YLM_OK) s = ylm__transfer_check_places(n, "origin", origin, normal, e);
  if (s != YLM_OK || n == 0) return s;
  if (escapes && (lmax < 0 || lmax > YLM_TRANSFER_LMAX))
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_TRANSFER_LMAX, lmax);
  return ylm__transfer_find_shares(t, n, origin, normal, stream, links, seed, threads, progress,
                                   out, lmax, escapes, NULL, NULL);
}
