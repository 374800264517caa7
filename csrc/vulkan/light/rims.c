/* rims.c - exact flat lights on a device: their arrays, and what shaders/rims.real.comp
 * sums. */
#include <math.h>

#include "lights.h"
#include "ylm_image.h"

#define RUNS 10u /* of a slice; these as in the kernel */
#define SLOTS 64u
#define ROWS 4u /* of a light before its vertices */

static ylm_status no_memory(ylm_error *e) { return ylm_no_memory(e); }

/* -- lights -------------------------------------------------------------------------------- */

static size_t rows_of(int sides) { return sides ? (size_t)sides : 3; }

/* Edges, and what runs along a horizon; a rim is one. */
static size_t arcs_of(const ylm_light_rims *a, size_t i) {
  return (a->sides[i] ? (size_t)a->sides[i] : 1) + (a->horizon ? 1 : 0);
}

typedef struct packed {
  double (*row)[4];
  uint32_t (*arc)[2];
  size_t rows, arcs;
} packed;

static void put(double to[4], const double *v, double last) {
  for (size_t k = 0; k < 3; k++) to[k] = v ? v[k] : 0;
  to[3] = last;
}

/* Light i of a: see shaders/rims_seen.glsl. */
static void pack(packed *p, const ylm_light_rims *a, size_t i) {
  const double *v = a->vertices + 3 * a->first[i], *rgb = a->radiance + 3 * i;
  double(*row)[4] = p->row + p->rows;
  size_t vertices = rows_of(a->sides[i]);
  put(row[0], a->normal + 3 * i, a->sides[i]);
  put(row[1], a->centroid + 3 * i, a->sides[i] ? 0 : ylm_light_rim_speed(v + 3, v + 6));
  put(row[2], rgb, ylm_luminance(rgb));
  put(row[3], a->horizon, a->horizon ? 1 : 0);
  for (size_t k = 0; k < vertices; k++) put(row[ROWS + k], v + 3 * k, 0);
  for (size_t k = 0; k < arcs_of(a, i); k++, p->arcs++) {
    p->arc[p->arcs][0] = (uint32_t)p->rows;
    p->arc[p->arcs][1] = (uint32_t)k;
  }
  p->rows += ROWS + vertices;
}

static ylm_status upload(ylm_gpu_lights *l, size_t rows, size_t arcs, ylm_error *e) {
  rim_set *r = &l->rims;
  packed p = {ylm_alloc(rows, sizeof *p.row), ylm_alloc(arcs, sizeof *p.arc), 0, 0};
  size_t numbers = ylm_light_rim_rules(NULL);
  double *rules = ylm_alloc(numbers, sizeof *rules);
  ylm_status s = p.row && p.arc && rules ? YLM_OK : no_memory(e);
  for (size_t k = 0; s == YLM_OK && k < r->objects; k++) {
    const ylm_light_rims *a = &r->of[k];
    for (size_t i = 0; i < a->n; i++) pack(&p, a, i);
  }
  if (rules) ylm_light_rim_rules(rules);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(l->gpu, rows * sizeof *p.row, p.row, &r->row, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(l->gpu, arcs * sizeof *p.arc, p.arc, &r->arc, e);
  if (s == YLM_OK) s = ylm_gpu_buffer_from(l->gpu, numbers * sizeof *rules, rules, &r->rule, e);
  ylm_free(p.row);
  ylm_free(p.arc);
  ylm_free(rules);
  return s;
}

ylm_status ylm__rims_create(ylm_gpu_lights *l, ylm_error *e) {
  rim_set *r = &l->rims;
  size_t rows = 0, arcs = 0;
  if (!r->objects) return YLM_OK;
  if (ylm__loops(l))
    return ylm_fail(e, YLM_EINVAL,
                    "exact flat lights are summed along their rims: "
                    "method must be \"merged\" with them");
  if (!ylm_gpu_about(l->gpu)->float64)
    return ylm_fail(e, YLM_EMISSING,
                    "exact flat lights are summed in double, which '%s' does not compute in: take "
                    "them with method = \"sphere\", or leave out the device",
                    ylm_gpu_about(l->gpu)->name);
  for (size_t k = 0; k < r->objects; k++) {
    const ylm_light_rims *a = &r->of[k];
    r->cut |= a->horizon != NULL;
    r->lights += (uint32_t)a->n;
    for (size_t i = 0; i < a->n; i++) {
      rows += ROWS + rows_of(a->sides[i]);
      arcs += arcs_of(a, i);
    }
  }
  if (rows > 1u << 28) return ylm_fail(e, YLM_ELIMIT, "more than 2^28 vertices of flat lights");
  r->arcs = (uint32_t)arcs;
  uint32_t chunk = (r->arcs / 16 + 31) / 32 * 32;
  r->chunk = chunk < 32 ? 32 : chunk > 1024 ? 1024 : chunk;
  if (ylm_gpu_about(l->gpu)->type == YLM_GPU_CPU) r->chunk = 256;
  return upload(l, rows, arcs, e);
}

void ylm__rims_free(rim_set *r) {
  ylm_gpu_buffer_free(r->row);
  ylm_gpu_buffer_free(r->arc);
  ylm_gpu_buffer_free(r->rule);
  ylm_free(r->of);
}

/* -- passes ---------------------------------------------------------------------------------- */

/* A run of degrees of an order, as the kernel reads it. */
typedef struct run {
  uint32_t m, first, end, slot;
} run;

/* Slices of at most SLOTS harmonics up to degree `top`, RUNS a slice; to NULL: how many. */
static uint32_t slices(int top, run *to) {
  uint32_t slice = 0, n = 0, slot = 0;
  for (uint32_t m = 0; (int)m <= top; m++)
    for (uint32_t l = m, each = m ? 2 : 1; (int)l <= top;) {
      uint32_t room = (SLOTS - slot) / each, degrees = (uint32_t)top + 1 - l;
      if (!room || n == RUNS) {
        slice++, n = slot = 0;
        continue;
      }
      if (degrees > room) degrees = room;
      if (to) to[slice * RUNS + n] = (run){m, l, l + degrees, slot};
      n++, slot += each * degrees, l += degrees;
    }
  return slice + 1;
}

static ylm_status make_betas(const ylm_gpu_lights *l, sum_plan *p, ylm_error *e) {
  size_t wide = (size_t)p->lmax + 2;
  if (p->betas) return YLM_OK;
  double *beta = ylm_alloc_zero(wide * wide, sizeof *beta), c[4];
  if (!beta) return no_memory(e);
  for (size_t m = 0; m < wide; m++)
    for (size_t k = m + 1; k < wide; k++) {
      double grow = ylm_light_recurrence(p->lmax, (int)m, (int)k, c);
      beta[m * wide + k] = c[3] / (grow * grow);
    }
  ylm_status s = ylm_gpu_buffer_from(l->gpu, wide * wide * sizeof *beta, beta, &p->betas, e);
  ylm_free(beta);
  return s;
}

ylm_status ylm__rims_cut(const ylm_gpu_lights *l, sum_plan *p, sum_set *set, ylm_error *e) {
  if (!l->rims.objects || !set->channels) return YLM_OK;
  ylm_status s = make_betas(l, p, e);
  if (s != YLM_OK) return s;
  struct sum_pass *pass = &set->pass[set->passes++];
  uint32_t kinds = set->kinds | 1;
  int top = kinds & 4 ? p->lmax + 1 : kinds & 2 ? p->lmax : p->lmax - 1;
  *pass = (struct sum_pass){.rims = true, .kinds = kinds, .parts = set->sums};
  pass->items = slices(top, NULL);
  run *runs = ylm_alloc_zero((size_t)pass->items * RUNS, sizeof *runs);
  if (!runs) return no_memory(e);
  slices(top, runs);
  set->sums += (uint32_t)ylm_light_rim_sums(p->lmax, (int)kinds, l->rims.cut);
  s = ylm_gpu_buffer_from(l->gpu, (size_t)pass->items * RUNS * sizeof *runs, runs, &pass->item, e);
  ylm_free(runs);
  return s;
}
