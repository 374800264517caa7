/* vectors.c - transfer vectors with bounces: of elements, and of other places that see them. */
#include <math.h>
#include <stdatomic.h>

#include "calibration.h"
#include "transfer.h"

size_t ylm_transfer_width(const ylm_transfer *t) {
  return (3 * ylm_sh_count(t->form.lmax) + 3) / 4 * 4;
}

static ylm_status has_escape(const ylm_transfer *t, ylm_error *e) {
  if (t->escape) return YLM_OK;
  return ylm_fail(e, YLM_EINVAL, "the links were made without transfer vectors (lmax = -1)");
}

/* -- elements --------------------------------------------------------------------- */

/* Norms by area, of the channels. */
typedef struct norms {
  double change[3], strayed[3], T[3];
} norms;

/* Vectors of `channels`, 1 where no albedo is coloured, in rows of `width`. */
typedef struct job {
  const ylm_transfer *t;
  ylm_transfer_sum_fn *sum;
  size_t count, channels, width;
  float *T;          /* [elements + 1][width] */
  float *B, *next_B; /* [elements + 1][width] albedo times the vectors before, and after a bounce */
  float *change;     /* [elements][width] by the last bounce; NULL: not kept */
  double q[3];
  norms *part; /* [blocks] */
} job;

/* Takes what a bounce has made of element i, [width] less the escape. */
static void take(const job *j, size_t i, const float *sum, norms *x) {
  double area = (double)j->t->area[i] * (double)j->t->share[i];
  const float *escape = j->t->escape + i * j->count;
  for (size_t c = 0; c < j->channels; c++) {
    size_t at = i * j->width + c * j->count;
    float *T = j->T + at, *B = j->next_B + at, *change = j->change ? j->change + at : NULL;
    float rho = j->t->albedo[i][c], q = (float)j->q[c], moved = 0, strayed = 0, size = 0;
    for (size_t k = 0; k < j->count; k++) {
      float now = escape[k] + sum[c * j->count + k], d = now - T[k];
      if (change) {
        strayed += fabsf(d - q * change[k]);
        change[k] = d;
      }
      T[k] = now;
      B[k] = rho * now;
      moved += fabsf(d);
      size += fabsf(now);
    }
    x->change[c] += area * (double)moved;
    x->strayed[c] += area * (double)strayed;
    x->T[c] += area * (double)size;
  }
}

/* One bounce on elements begin .. end-1. */
static ylm_status bounce(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t links = (size_t)j->t->form.links;
  float *sum = ylm_alloc((end - begin) * j->width, sizeof *sum);
  if (!sum) return YLM_ENOMEM;
  j->sum(end - begin, (int)links, ylm_links_from(j->t->link, begin * links), (int)j->width, j->B,
         NULL, sum);
  norms x = {{0}, {0}, {0}};
  for (size_t i = begin; i < end; i++) take(j, i, sum + (i - begin) * j->width, &x);
  j->part[begin / BOUNCE_GRAIN] = x;
  ylm_free(sum);
  return YLM_OK;
}

static double ratio(double a, double b) { return b > 0 ? a / b : 0; }

/* Sums norms, and finds how much every bounce keeps: what is left, relative, and how badly a geometric
   series fits. */
static void weigh(job *j, double before[3], ylm_radiosity_stats *stats, double *strayed) {
  norms all = {{0}, {0}, {0}};
  for (size_t b = 0; b * BOUNCE_GRAIN < j->t->elements; b++)
    for (size_t c = 0; c < j->channels; c++) {
      all.change[c] += j->part[b].change[c];
      all.strayed[c] += j->part[b].strayed[c];
      all.T[c] += j->part[b].T[c];
    }
  stats->residual = stats->shrink = *strayed = 0;
  for (size_t c = 0; c < j->channels; c++) {
    double q = j->q[c] = ratio(all.change[c], before[c]);
    before[c] = all.change[c];
    stats->residual = fmax(stats->residual, ratio(all.change[c], all.T[c]));
    stats->shrink = fmax(stats->shrink, q);
    *strayed = fmax(*strayed, q < 1 ? ratio(all.strayed[c] * q / (1 - q), all.T[c]) : 1);
  }
}

static ylm_status endless(const ylm_radiosity_stats *stats, ylm_error *e) {
  return ylm_fail(e, YLM_EDOMAIN,
                  "bounces = 'all' does not converge: each bounce keeps %.6g of the one before; "
                  "give a number of bounces",
                  stats->shrink);
}

/* Bounces until they are done or small. */
static ylm_status walk(job *j, int bounces, double residual, int threads,
                       const ylm_progress *progress, ylm_radiosity_stats *stats, ylm_error *e) {
  double before[3] = {0}, strayed;
  if (residual < BOUNCE_ROUNDING) residual = BOUNCE_ROUNDING;
  for (int k = 0; bounces < 0 || k < bounces; k++) {
    ylm_status s = ylm_parallel(j->t->elements, BOUNCE_GRAIN, threads, bounce, j, NULL, NULL);
    if (s == YLM_OK)
      s = ylm_report(progress, (uint64_t)k + 1,
                     bounces < 0 ? (uint64_t)(k < 15 ? 16 : k + 2) : (uint64_t)bounces, "bounces");
    if (s != YLM_OK) return s;
    float *swap = j->B;
    j->B = j->next_B;
    j->next_B = swap;
    weigh(j, before, stats, &strayed);
    stats->bounces = k + 1;
    if (bounces >= 0) continue;
    bool shrinks = stats->shrink < 1 - BOUNCE_ENDLESS;
    if (stats->residual <= residual && (shrinks || stats->residual < BOUNCE_ROUNDING))
      return YLM_OK;
    if ((k >= BOUNCE_PATIENCE && !shrinks) || k + 1 >= BOUNCE_MOST) return endless(stats, e);
    if (j->change && k >= 2 && shrinks && strayed <= residual) {
      stats->closed = true;
      stats->residual = strayed;
      return YLM_OK;
    }
  }
  return YLM_OK;
}

/* Adds the geometric series that goes on from the last change. */
static void close_series(const job *j) {
  for (size_t i = 0; i < j->t->elements; i++)
    for (size_t c = 0; c < j->channels; c++)
      for (size_t k = 0; k < j->count && j->q[c] < 1; k++) {
        size_t at = i * j->width + c * j->count + k;
        j->T[at] += (float)((double)j->change[at] * j->q[c] / (1 - j->q[c]));
      }
}

/* out = T of `channels` in rows of three, the last row zero. In place, from the last row on. */
static void deliver(const job *j, float *out) {
  size_t wide = ylm_transfer_width(j->t), count = j->count;
  for (size_t i = j->t->elements; i-- > 0;) {
    float *to = out + i * wide;
    const float *from = j->T + i * j->width;
    for (size_t c = 3; c-- > 0;)
      memmove(to + c * count, from + (j->channels == 3 ? c * count : 0), count * sizeof *to);
    memset(to + 3 * count, 0, (wide - 3 * count) * sizeof *to);
  }
  memset(out + j->t->elements * wide, 0, wide * sizeof *out);
}

static bool is_grey(const ylm_transfer *t) {
  for (size_t i = 0; i < t->elements; i++)
    if (t->albedo[i][0] != t->albedo[i][1] || t->albedo[i][0] != t->albedo[i][2]) return false;
  return true;
}

/* The vectors of no bounce; T is in `out`. */
static bool begin(job *j, const ylm_transfer *t, bool change, float *out) {
  size_t count = ylm_sh_count(t->form.lmax), channels = is_grey(t) ? 1 : 3;
  *j = (job){.t = t, .sum = ylm__transfer_sum(), .count = count, .channels = channels, .T = out};
  j->width = (channels * count + 3) / 4 * 4;
  j->B = ylm_alloc_zero(t->elements + 1, j->width * sizeof *j->B);
  j->next_B = ylm_alloc_zero(t->elements + 1, j->width * sizeof *j->B);
  j->change = change ? ylm_alloc_zero(t->elements + 1, j->width * sizeof *j->change) : NULL;
  j->part = ylm_alloc(t->elements / BOUNCE_GRAIN + 1, sizeof *j->part);
  if (!j->B || !j->next_B || !j->part || (change && !j->change)) return false;
  for (size_t i = 0; i < t->elements; i++)
    for (size_t c = 0; c < channels; c++)
      for (size_t k = 0; k < count; k++) {
        size_t at = i * j->width + c * count + k;
        out[at] = t->escape[i * count + k];
        j->B[at] = t->albedo[i][c] * out[at];
      }
  return true;
}

ylm_status ylm_transfer_vectors(const ylm_transfer *t, int bounces, double residual, bool closure,
                                int threads, const ylm_progress *progress,
                                ylm_radiosity_stats *stats, float *out, ylm_error *e) {
  double begun = ylm_seconds();
  ylm_radiosity_stats found = {0};
  job j = {0};
  ylm_status s = has_escape(t, e);
  if (s != YLM_OK) return s;
  if (!(residual > 0)) return ylm_fail(e, YLM_ERANGE, "residual must be above 0, got %g", residual);
  s = begin(&j, t, closure && bounces < 0, out) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = walk(&j, bounces, residual, threads, progress, &found, e);
  if (s == YLM_OK && bounces < 0)
    s = ylm_report(progress, 1, 1, "bounces"); /* sooner than it could know */
  if (s == YLM_OK && found.closed) close_series(&j);
  if (s == YLM_OK) deliver(&j, out);
  ylm_free(j.B);
  ylm_free(j.next_B);
  ylm_free(j.change);
  ylm_free(j.part);
  found.solve_seconds = ylm_seconds() - begun;
  if (s == YLM_OK && stats) *stats = found;
  return s;
}

/* -- other places ------------------------------------------------------------------- */

/* [elements + 1][width] albedo times the vectors. */
float *ylm__transfer_reflected(const ylm_transfer *t, const float *vectors, double scale) {
  size_t count = ylm_sh_count(t->form.lmax), width = ylm_transfer_width(t);
  float *B = ylm_alloc_zero(t->elements + 1, width * sizeof *B);
  for (size_t i = 0; B && i < t->elements; i++)
    for (size_t c = 0; c < 3; c++) {
      size_t at = i * width + c * count;
      float rho = (float)(scale * (double)t->albedo[i][c]);
      for (size_t k = 0; k < count; k++) B[at + k] = rho * vectors[at + k];
    }
  return B;
}

/* Memory for a block of places. */
typedef struct places {
  uint64_t *stream; /* [VECTOR_PLACES] */
  ylm_links link;   /* [VECTOR_PLACES][links] */
  float *escape;    /* [VECTOR_PLACES][count] */
  float *sum;       /* [VECTOR_PLACES][width] */
  float *B;         /* NULL: no bounces */
} places;

static void places_free(places *p) {
  ylm_free(p->stream);
  ylm_links_free(p->link);
  ylm_free(p->escape);
  ylm_free(p->sum);
  ylm_free(p->B);
}

static bool places_create(places *p, const ylm_transfer *t, const float *vectors, size_t n,
                          int links) {
  size_t block = n < VECTOR_PLACES ? n : VECTOR_PLACES;
  p->stream = ylm_alloc(block, sizeof *p->stream);
  p->link = ylm_transfer_room(t, block * (size_t)links);
  p->escape = ylm_alloc(block, ylm_sh_count(t->form.lmax) * sizeof *p->escape);
  p->sum = ylm_alloc_zero(block, ylm_transfer_width(t) * sizeof *p->sum);
  p->B = vectors ? ylm__transfer_reflected(t, vectors, 1) : NULL;
  return p->stream && !ylm_links_are_none(p->link) && p->escape && p->sum && (p->B || !vectors);
}

ylm_status ylm_transfer_vectors_at(const ylm_transfer *t, const float *vectors, size_t n,
                                   const float (*origin)[3], const float (*normal)[3],
                                   const uint64_t *stream, int links, uint64_t seed, int threads,
                                   const ylm_progress *progress, float *out, ylm_error *e) {
  size_t count = ylm_sh_count(t->form.lmax), width = ylm_transfer_width(t);
  places p = {0};
  ylm_status s = has_escape(t, e);
  if (s == YLM_OK) s = ylm__transfer_check_links(links, e);
  if (s == YLM_OK && !places_create(&p, t, vectors, n, links)) s = YLM_ENOMEM;
  for (size_t first = 0; s == YLM_OK && first < n; first += VECTOR_PLACES) {
    size_t m = n - first < VECTOR_PLACES ? n - first : VECTOR_PLACES;
    for (size_t i = 0; i < m; i++) p.stream[i] = stream ? stream[first + i] : first + i;
    s = ylm_transfer_find(t, m, origin + first, normal + first, p.stream, links, seed, threads,
                          NULL, p.link, t->form.lmax, p.escape, e);
    if (s == YLM_OK && p.B)
      ylm_transfer_sum(m, links, p.link, (int)width, p.B, NULL, p.sum, threads);
    for (size_t i = 0; s == YLM_OK && i < m; i++)
      for (size_t k = 0; k < 3 * count; k++)
        out[(first + i) * 3 * count + k] = p.escape[i * count + k % count] + p.sum[i * width + k];
    if (s == YLM_OK) s = ylm_report(progress, first + m, n, "links");
  }
  places_free(&p);
  return s;
}

/* -- vertices ------------------------------------------------------------------------- */

/* A place on a triangle near its corner k, on the side where t has an element; where there is none, the number of elements. */
static uint32_t element_at(const ylm_transfer *t, size_t mesh, size_t triangle, int k) {
  const float near = 1 - 1e-4f, rest = 0.5e-4f;
  ylm_scene_place p = {.mesh = (uint32_t)mesh, .element = (uint32_t)triangle};
  p.u = k == 1 ? near : rest;
  p.v = k == 2 ? near : rest;
  uint32_t i = ylm_transfer_element(t, &p);
  if (i < t->elements) return i;
  p.back = true;
  return ylm_transfer_element(t, &p);
}

ylm_status ylm_transfer_vectors_of(const ylm_transfer *t, const float *vectors, size_t mesh,
                                   float *out) {
  size_t wide = 3 * ylm_sh_count(t->form.lmax), width = ylm_transfer_width(t);
  size_t first = ylm_scene_first_vertex(t->scene, mesh);
  size_t n = ylm_scene_first_vertex(t->scene, mesh + 1) - first;
  double *weight = ylm_alloc_zero(n, sizeof *weight);
  if (!weight) return YLM_ENOMEM;
  memset(out, 0, n * wide * sizeof *out);
  for (size_t i = 0; i < ylm_scene_triangles(t->scene, mesh); i++) {
    const uint32_t *corner = ylm_scene_triangle(t->scene, mesh, i);
    for (int k = 0; k < 3; k++) {
      uint32_t at = element_at(t, mesh, i, k);
      if (at >= t->elements || !(t->share[at] > 0)) continue;
      const float *from = vectors + at * width;
      float area = t->area[at], *to = out + corner[k] * wide;
      for (size_t q = 0; q < wide; q++) to[q] += area * from[q];
      weight[corner[k]] += (double)area;
    }
  }
  for (size_t i = 0; i < n; i++)
    for (size_t q = 0; q < wide && weight[i] > 0; q++) out[i * wide + q] /= (float)weight[i];
  ylm_free(weight);
  return YLM_OK;
}
