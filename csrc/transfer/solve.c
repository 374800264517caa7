/* solve.c - bounces of direct light as sums over links. */
#include <math.h>

#include "calibration.h"
#include "transfer.h"

/* Norms by area, of the three channels: of dE; of dE - q times the one before; of the light that has bounced, beside which
   both are small or not: direct light may fall on surfaces that send none of it on, as outer walls under a sky. */
typedef struct norms {
  double change[3], strayed[3], bounced[3];
} norms;

typedef struct job {
  const ylm_transfer *t;
  ylm_transfer_sum_fn *sum;
  const float *E0;
  float *E, *next;       /* irradiance, and after one more bounce */
  float *B, *next_B;     /* albedo times that */
  float *change, *after; /* by the last bounce, and by this one */
  double q[3];
  norms *part;                 /* [blocks] */
  const transfer_groups *over; /* groups on which B is constant; NULL: on elements */
} job;

static size_t blocks_of(const ylm_transfer *t) { return t->elements / BOUNCE_GRAIN + 1; }

/* One bounce on elements begin .. end-1. */
static ylm_status bounce(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t links = (size_t)j->t->form.links;
  j->sum(end - begin, (int)links, ylm_links_from(j->t->link, begin * links), 4, j->B,
         j->E0 + 4 * begin, j->next + 4 * begin);
  norms x = {{0}, {0}, {0}};
  for (size_t i = begin; i < end; i++) {
    double area = (double)j->t->area[i] * (double)j->t->share[i];
    for (size_t c = 0; c < 3; c++) {
      float E = j->next[4 * i + c], d = E - j->E[4 * i + c];
      j->after[4 * i + c] = d;
      j->next_B[4 * i + c] = j->t->albedo[i][c] * E;
      x.change[c] += area * fabs((double)d);
      x.strayed[c] += area * fabs((double)d - j->q[c] * (double)j->change[4 * i + c]);
      x.bounced[c] += area * fabs((double)E - (double)j->E0[4 * i + c]);
    }
  }
  j->part[begin / BOUNCE_GRAIN] = x;
  return YLM_OK;
}

static void swap(float **a, float **b) {
  float *c = *a;
  *a = *b;
  *b = c;
}

static void turn(job *j) {
  swap(&j->E, &j->next);
  swap(&j->B, &j->next_B);
  swap(&j->change, &j->after);
}

static norms sum_parts(const job *j) {
  norms all = {{0}, {0}, {0}};
  for (size_t b = 0; b * BOUNCE_GRAIN < j->t->elements; b++)
    for (int c = 0; c < 3; c++) {
      all.change[c] += j->part[b].change[c];
      all.strayed[c] += j->part[b].strayed[c];
      all.bounced[c] += j->part[b].bounced[c];
    }
  return all;
}

static double ratio(double a, double b) { return b > 0 ? a / b : 0; }

static ylm_status endless(const job *j, ylm_error *e) {
  double area = 0, albedo[3] = {0, 0, 0};
  const ylm_transfer *t = j->t;
  int most = 0;
  for (size_t i = 0; i < t->elements; i++) {
    area += (double)t->area[i];
    for (int c = 0; c < 3; c++) albedo[c] += (double)t->area[i] * (double)t->albedo[i][c];
  }
  for (int c = 1; c < 3; c++)
    if (j->q[c] > j->q[most]) most = c;
  return ylm_fail(
      e, YLM_EDOMAIN,
      "bounces = 'all' does not converge: each bounce keeps %.6g of the light before (the "
      "mean albedo is %.3g, and %.2g %% of the links leave the scene); give a number of "
      "bounces",
      j->q[most], ratio(albedo[most], area),
      100 * ratio((double)t->stats.escaped, (double)t->stats.rays));
}

/* Bounces until they are done or small. `closed`: the rest may be added. */
static ylm_status walk(job *j, int bounces, double residual, bool closure, int threads,
                       const ylm_progress *progress, ylm_radiosity_stats *stats, ylm_error *e) {
  double before[3] = {0, 0, 0};
  if (residual < BOUNCE_ROUNDING) residual = BOUNCE_ROUNDING;
  if (j->t->elements * (size_t)j->t->form.links < BOUNCE_FEW) threads = 1;
  for (int k = 0; bounces < 0 || k < bounces; k++) {
    ylm_status s = ylm_parallel(j->t->elements, BOUNCE_GRAIN, threads, bounce, j, NULL, NULL);
    if (s == YLM_OK)
      s = ylm_report(progress, (uint64_t)k + 1,
                     bounces < 0 ? (uint64_t)(k < 15 ? 16 : k + 2) : (uint64_t)bounces, "bounces");
    if (s != YLM_OK) return s;
    norms x = sum_parts(j);
    turn(j);
    if (j->over) ylm__transfer_level(j->t, j->over, j->B);
    double left = 0, strayed = 0, shrink = 0;
    for (int c = 0; c < 3; c++) {
      j->q[c] = ratio(x.change[c], before[c]);
      before[c] = x.change[c];
      left = fmax(left, ratio(x.change[c], x.bounced[c]));
      shrink = fmax(shrink, j->q[c]);
      double off = j->q[c] < 1 ? x.strayed[c] * j->q[c] / (1 - j->q[c]) : x.bounced[c];
      strayed = fmax(strayed, ratio(off, x.bounced[c]));
    }
    stats->bounces = k + 1;
    stats->residual = left;
    stats->shrink = shrink;
    if (bounces >= 0) continue;
    if (left <= residual && (shrink < 1 - BOUNCE_ENDLESS || left < BOUNCE_ROUNDING)) return YLM_OK;
    if (k >= BOUNCE_PATIENCE && shrink >= 1 - BOUNCE_ENDLESS) return endless(j, e);
    if (closure && k >= 2 && shrink < 1 - BOUNCE_ENDLESS && strayed <= residual) {
      stats->closed = true;
      stats->residual = strayed;
      return YLM_OK;
    }
    if (k + 1 >= BOUNCE_MOST) return endless(j, e);
  }
  return YLM_OK;
}

/* Adds the geometric series that goes on from the last change. */
static void close_series(const job *j) {
  for (size_t i = 0; i < j->t->elements; i++)
    for (size_t c = 0; c < 3; c++)
      if (j->q[c] < 1)
        j->E[4 * i + c] += (float)((double)j->change[4 * i + c] * j->q[c] / (1 - j->q[c]));
}

static void balance(const job *j, ylm_radiosity_stats *stats) {
  const ylm_transfer *t = j->t;
  size_t links = (size_t)t->form.links;
  for (size_t i = 0; i < t->elements; i++) {
    double area = (double)t->area[i] * (double)t->share[i];
    size_t open = 0;
    while (open < links && ylm_links_at(t->link, i * links + links - 1 - open) == t->elements)
      open++;
    for (size_t c = 0; c < 3; c++) {
      double E = (double)j->E[4 * i + c], rho = (double)t->albedo[i][c];
      stats->emitted[c] += area * (double)j->E0[4 * i + c];
      stats->absorbed[c] += area * (1 - rho) * E;
      stats->escaped[c] += area * rho * E * (double)open / (double)links;
    }
  }
  for (int c = 0; c < 3; c++) {
    double off = fabs(stats->emitted[c] - stats->absorbed[c] - stats->escaped[c]);
    stats->balance = fmax(stats->balance, ratio(off, fabs(stats->emitted[c])));
  }
}

static float *rows(const ylm_transfer *t) { return ylm_alloc_zero(t->elements + 1, 16); }

static bool job_create(job *j, const ylm_transfer *t, const float *E0,
                       const transfer_groups *over) {
  size_t bytes = (t->elements + 1) * 16;
  *j = (job){.t = t, .sum = ylm__transfer_sum(), .E0 = E0, .over = over};
  j->E = rows(t), j->next = rows(t), j->B = rows(t), j->next_B = rows(t);
  j->change = rows(t), j->after = rows(t);
  j->part = ylm_alloc(blocks_of(t), sizeof *j->part);
  if (!j->E || !j->next || !j->B || !j->next_B || !j->change || !j->after || !j->part) return false;
  memcpy(j->E, E0, bytes);
  memcpy(j->change, E0, bytes);
  for (size_t i = 0; i < t->elements; i++)
    for (size_t c = 0; c < 3; c++) j->B[4 * i + c] = t->albedo[i][c] * j->E[4 * i + c];
  if (over) ylm__transfer_level(t, over, j->B);
  return true;
}

static void job_free(job *j) {
  ylm_free(j->E);
  ylm_free(j->next);
  ylm_free(j->B);
  ylm_free(j->next_B);
  ylm_free(j->change);
  ylm_free(j->after);
  ylm_free(j->part);
}

/* Radiance of elements of irradiance E. */
static void leave(const ylm_transfer *t, const float *E, float *leaving) {
  const float each = 0.318309886183790672f;
  for (size_t i = 0; i < t->elements; i++)
    for (size_t c = 0; c < 3; c++) leaving[4 * i + c] = t->albedo[i][c] * E[4 * i + c] * each;
}

/* Gives the solution to r. */
static void deliver(job *j, ylm_radiosity *r, const ylm_radiosity_stats *stats) {
  memcpy(r->direct, j->E0, (j->t->elements + 1) * 16);
  swap(&r->E, &j->E);
  leave(j->t, r->E, r->leaving);
  memcpy(r->q, j->q, sizeof r->q);
  r->stats = *stats;
  ylm_transfer_targets_free(r->targets);
  r->targets = NULL;
  r->aimed = false;
  ylm_free(r->averaged);
  r->averaged = NULL;
}

static ylm_status check_series(int bounces, double residual, ylm_error *e) {
  if (bounces > YLM_TRANSFER_BOUNCES)
    return ylm_fail(e, YLM_ERANGE, "bounces must be at most %d, got %d", YLM_TRANSFER_BOUNCES,
                    bounces);
  if (!(residual > 0)) return ylm_fail(e, YLM_ERANGE, "residual must be above 0, got %g", residual);
  return YLM_OK;
}

ylm_status ylm_radiosity_solve(ylm_radiosity *r, int bounces, double residual, bool closure,
                               int threads, const ylm_progress *progress,
                               ylm_radiosity_stats *stats, ylm_error *e) {
  double begun = ylm_seconds();
  ylm_radiosity_stats found = {.rays = r->rays, .close = r->close, .direct_seconds = r->seconds};
  ylm_scene_guide_stats guide = {0};
  if (r->guide) ylm_scene_guide_look(r->guide, &guide);
  found.guides = guide.clusters;
  found.guide_rays = guide.rays;
  job j = {0};
  ylm_status s = check_series(bounces, residual, e);
  if (s != YLM_OK) return s;
  s = job_create(&j, r->t, r->E0, NULL) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = walk(&j, bounces, residual, closure, threads, progress, &found, e);
  if (s == YLM_OK && bounces < 0)
    s = ylm_report(progress, 1, 1, "bounces"); /* sooner than it could know */
  if (s == YLM_OK) {
    if (found.closed) close_series(&j);
    balance(&j, &found);
    found.solve_seconds = ylm_seconds() - begun;
    deliver(&j, r, &found);
    if (stats) *stats = found;
  }
  job_free(&j);
  return s;
}

ylm_status ylm_radiosity_noise(ylm_radiosity *r, int threads, const float **leaving) {
  *leaving = r->noise;
  if (r->noise || !r->apart) return YLM_OK;
  ylm_radiosity_stats found = {0};
  int bounces = r->stats.bounces < BOUNCE_NOISE ? r->stats.bounces : BOUNCE_NOISE;
  job j = {0};
  float *noise = rows(r->t);
  ylm_status s = noise && job_create(&j, r->t, r->apart, NULL) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = walk(&j, bounces, 1, false, threads, NULL, &found, NULL);
  if (s == YLM_OK) {
    leave(r->t, j.E, noise);
    *leaving = r->noise = noise;
  } else
    ylm_free(noise);
  job_free(&j);
  return s;
}

ylm_status ylm_radiosity_averaged(ylm_radiosity *r, int threads, const float **leaving) {
  *leaving = r->averaged ? r->averaged : r->leaving;
  if (r->averaged || !ylm__transfer_has_groups(r->neighbours)) return YLM_OK;
  float *E = rows(r->t);
  ylm_status s = E ? ylm__transfer_average(r, threads, E) : YLM_ENOMEM;
  if (s == YLM_OK) {
    leave(r->t, E, E);
    *leaving = r->averaged = E;
  } else
    ylm_free(E);
  return s;
}

/* How far the light that bounces is from that of r: the root mean square over its mean, in luminance. */
static double change_of(const job *j, const ylm_radiosity *r) {
  double square = 0, mean = 0, area = 0;
  for (size_t i = 0; i < j->t->elements; i++) {
    double a = (double)j->t->area[i] * (double)j->t->share[i], change[3], light[3];
    for (size_t c = 0; c < 3; c++) {
      change[c] = (double)j->E[4 * i + c] - (double)r->E[4 * i + c];
      light[c] = (double)r->E[4 * i + c] - (double)r->direct[4 * i + c];
    }
    double y = ylm_luminance(change);
    square += a * y * y, mean += a * ylm_luminance(light), area += a;
  }
  return ratio(sqrt(square * area), mean);
}

ylm_status ylm_radiosity_coarse(const ylm_radiosity *r, int bounces, double residual, bool closure,
                                int threads, ylm_radiosity *into, double *change, ylm_error *e) {
  transfer_groups groups;
  ylm_radiosity_stats found = {0};
  job j = {0};
  *change = 0;
  if (into && into->t != r->t)
    return ylm_fail(e, YLM_EINVAL, "the two radiosities are of the same links");
  ylm_status s = check_series(bounces, residual, e);
  if (s != YLM_OK) return s;
  s = ylm__transfer_group(r->t, &groups);
  if (s == YLM_OK && !job_create(&j, r->t, r->direct, &groups)) s = YLM_ENOMEM;
  if (s == YLM_OK) s = walk(&j, bounces, residual, closure, threads, NULL, &found, e);
  if (s == YLM_OK) {
    if (found.closed) close_series(&j);
    *change = change_of(&j, r);
    if (into) {
      deliver(&j, into, &found);
      ylm__transfer_level(r->t, &groups, into->leaving);
    }
  }
  job_free(&j);
  ylm__transfer_ungroup(&groups);
  return s;
}

ylm_status ylm_radiosity_create(const ylm_transfer *t, ylm_radiosity **out) {
  *out = NULL;
  ylm_radiosity *r = ylm_alloc_zero(1, sizeof *r);
  if (!r) return YLM_ENOMEM;
  r->t = t;
  r->E0 = rows(t), r->direct = rows(t), r->E = rows(t), r->leaving = rows(t);
  if (r->E0 && r->direct && r->E && r->leaving)
    *out = r;
  else
    ylm_radiosity_free(r);
  return *out ? YLM_OK : YLM_ENOMEM;
}

void ylm_radiosity_free(ylm_radiosity *r) {
  if (!r) return;
  ylm_free(r->E0);
  ylm_free(r->direct);
  ylm_free(r->E);
  ylm_free(r->leaving);
  ylm_free(r->averaged);
  ylm_free(r->apart);
  ylm_free(r->noise);
  ylm_scene_guide_free(r->guide);
  ylm__transfer_neighbours_free(r->neighbours);
  ylm_transfer_targets_free(r->targets);
  ylm_free(r);
}

const ylm_transfer *ylm_radiosity_transfer(const ylm_radiosity *r) { return r->t; }
const float *ylm_radiosity_direct(const ylm_radiosity *r) { return r->direct; }
const float *ylm_radiosity_irradiance(const ylm_radiosity *r) { return r->E; }
const float *ylm_radiosity_leaving(const ylm_radiosity *r) { return r->leaving; }
void ylm_radiosity_look(const ylm_radiosity *r, ylm_radiosity_stats *stats) { *stats = r->stats; }
