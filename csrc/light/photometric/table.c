/* table.c - tables of intensities: made once, counted, found by their names. */
#include "table.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#define BRIGHTEST 1e20 /* cd */

/* -- all tables ------------------------------------------------------------------------------------ */

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static ylm_light_photometry *first;

/* A record names a table by 52 bits of its contents. */
static double name_of(const ylm_light_photometry_grid *g) {
  size_t sizes[3] = {g->angles, g->planes, g->linear};
  uint64_t crc = ylm_crc64(0, sizes, sizeof sizes);
  crc = ylm_crc64(crc, g->angle, g->angles * sizeof *g->angle);
  crc = ylm_crc64(crc, g->plane, g->planes * sizeof *g->plane);
  crc = ylm_crc64(crc, g->candela, g->planes * g->angles * sizeof *g->candela);
  return (double)(1 + (ylm_mix64(crc) >> 12));
}

static bool is_same(const ylm_light_photometry_grid *a, const ylm_light_photometry_grid *b) {
  return a->angles == b->angles && a->planes == b->planes && a->linear == b->linear &&
         memcmp(a->angle, b->angle, a->angles * sizeof *a->angle) == 0 &&
         memcmp(a->plane, b->plane, a->planes * sizeof *a->plane) == 0 &&
         memcmp(a->candela, b->candela, a->planes * a->angles * sizeof *a->candela) == 0;
}

/* A kept table of a name; the lock is held. */
static ylm_light_photometry *find(double name) {
  for (ylm_light_photometry *p = first; p; p = p->next)
    if (p->name == name) return ylm_light_photometry_keep(p);
  return NULL;
}

ylm_light_photometry *ylm_light_photometry_named(double name) {
  pthread_mutex_lock(&lock);
  ylm_light_photometry *p = find(name);
  pthread_mutex_unlock(&lock);
  return p;
}

/* Puts a table into the list, or frees it where one of the same numbers is there, which is kept and returned. */
static ylm_light_photometry *enter(ylm_light_photometry *p) {
  ylm_light_photometry *other;
  pthread_mutex_lock(&lock);
  while ((other = find(p->name)) && !is_same(&p->grid, &other->grid)) {
    atomic_fetch_sub(&other->references, 1); /* the list's owner still has it */
    p->name++;
  }
  if (!other) p->next = first, first = p;
  pthread_mutex_unlock(&lock);
  if (!other) return p;
  p->name = 0; /* it is not in the list */
  ylm_light_photometry_free(p);
  return other;
}

ylm_light_photometry *ylm_light_photometry_keep(const ylm_light_photometry *p) {
  ylm_light_photometry *own = (ylm_light_photometry *)(uintptr_t)p;
  if (own) atomic_fetch_add(&own->references, 1);
  return own;
}

/* Takes a table out of the list once nobody has it; false: somebody does. */
static bool leave(ylm_light_photometry *p) {
  pthread_mutex_lock(&lock);
  bool last = atomic_fetch_sub(&p->references, 1) == 1;
  for (ylm_light_photometry **at = &first; last && *at; at = &(*at)->next)
    if (*at == p) {
      *at = p->next;
      break;
    }
  pthread_mutex_unlock(&lock);
  return last;
}

void ylm_light_photometry_free(ylm_light_photometry *p) {
  if (!p || !leave(p)) return;
  ylm_free((void *)(uintptr_t)p->grid.angle);
  ylm_free((void *)(uintptr_t)p->grid.plane);
  ylm_free((void *)(uintptr_t)p->grid.candela);
  ylm_free(p->angle);
  ylm_free(p->plane);
  ylm_free(p->node);
  ylm_free(p->row);
  ylm_free(p->cell);
  ylm_free(p);
}

/* -- one ------------------------------------------------------------------------------------------- */

static ylm_status check_angles(const char *what, size_t n, const double *x, double least,
                               double most, ylm_error *e) {
  for (size_t i = 0; i < n; i++) {
    if (!(x[i] >= least && x[i] <= most))
      return ylm_fail(e, YLM_EDOMAIN, "%s angle %zu must be from %g to %g, got %g", what, i + 1,
                      least, most, x[i]);
    if (i > 0 && !(x[i] > x[i - 1]))
      return ylm_fail(e, YLM_EDOMAIN, "%s angles must increase: %g follows %g", what, x[i],
                      x[i - 1]);
  }
  return YLM_OK;
}

static ylm_status check(const ylm_light_photometry_grid *g, ylm_error *e) {
  if (g->angles < 2 || g->planes < 1 || g->angles > YLM_LIGHT_PHOTOMETRY_ANGLES ||
      g->planes > YLM_LIGHT_PHOTOMETRY_ANGLES ||
      g->angles * g->planes > YLM_LIGHT_PHOTOMETRY_NUMBERS)
    return ylm_fail(e, YLM_ERANGE,
                    "a table has 2 to %d vertical and 1 to %d horizontal angles, at most %zu "
                    "numbers; got %zu and %zu",
                    YLM_LIGHT_PHOTOMETRY_ANGLES, YLM_LIGHT_PHOTOMETRY_ANGLES,
                    YLM_LIGHT_PHOTOMETRY_NUMBERS, g->angles, g->planes);
  ylm_status s = check_angles("vertical", g->angles, g->angle, 0, 180, e);
  if (s == YLM_OK) s = check_angles("horizontal", g->planes, g->plane, 0, nextafter(360, 0), e);
  for (size_t i = 0; s == YLM_OK && i < g->planes * g->angles; i++)
    if (!(g->candela[i] >= 0 && g->candela[i] <= BRIGHTEST))
      s = ylm_fail(e, YLM_EDOMAIN,
                   "the intensity at horizontal angle %zu, vertical angle %zu must be from 0 to %g "
                   "cd, got %g",
                   i / g->angles + 1, i % g->angles + 1, BRIGHTEST, g->candela[i]);
  return s;
}

/* Copies the grid, and its angles in radians. */
static ylm_status copy(ylm_light_photometry *p, const ylm_light_photometry_grid *g) {
  p->angles = g->angles, p->planes = g->planes;
  p->grid = *g;
  p->grid.angle = ylm_alloc_copy(g->angle, g->angles, sizeof *g->angle);
  p->grid.plane = ylm_alloc_copy(g->plane, g->planes, sizeof *g->plane);
  p->grid.candela = ylm_alloc_copy(g->candela, g->planes * g->angles, sizeof *g->candela);
  p->angle = ylm_alloc(p->angles, sizeof *p->angle);
  p->plane = ylm_alloc(p->planes + 1, sizeof *p->plane);
  p->node = ylm_alloc_zero(p->planes * p->angles, sizeof *p->node);
  if (!p->grid.angle || !p->grid.plane || !p->grid.candela || !p->angle || !p->plane || !p->node)
    return YLM_ENOMEM;
  for (size_t i = 0; i < p->angles; i++) p->angle[i] = g->angle[i] * (YLM_PI / 180);
  for (size_t i = 0; i < p->planes; i++) p->plane[i] = g->plane[i] * (YLM_PI / 180);
  p->plane[p->planes] = p->plane[0] + 2 * YLM_PI;
  return YLM_OK;
}

/* Bezier's control points of a cubic between two nodes of a plane: none of it is above the largest. */
static double bound_of(const ylm__photometric_node *n, double h) {
  return fmax(fmax(n[0].f, n[1].f), fmax(n[0].f + h * n[0].g / 3, n[1].f - h * n[1].g / 3));
}

/* The largest intensity of planes, between nodes too. */
static void find_peak(ylm_light_photometry *p) {
  for (size_t i = 0; i < p->planes * p->angles; i++) p->peak = fmax(p->peak, p->grid.candela[i]);
  for (size_t k = 0; k < p->planes && !p->grid.linear; k++)
    for (size_t j = 0; j + 1 < p->angles; j++) {
      double h = p->angle[j + 1] - p->angle[j];
      if (!(bound_of(p->node + k * p->angles + j, h) > p->peak * (1 + 1e-9))) continue;
      for (int i = 1; i < 8; i++)
        p->peak = fmax(p->peak, ylm__photometric_at(p, p->angle[j] + i * h / 8, p->plane[k]).f);
    }
}

static ylm_status make(ylm_light_photometry *p, const ylm_light_photometry_grid *g) {
  p->references = 1;
  ylm_status s = copy(p, g);
  if (s != YLM_OK) return s;
  p->name = name_of(&p->grid);
  s = ylm__photometric_spline(p);
  if (s != YLM_OK) return s;
  find_peak(p);
  ylm__photometric_measure(p);
  return ylm__photometric_weigh(p);
}

ylm_status ylm_light_photometry_create(const ylm_light_photometry_grid *grid,
                                       ylm_light_photometry **out, ylm_error *e) {
  *out = NULL;
  ylm_status s = check(grid, e);
  if (s != YLM_OK) return s;
  ylm_light_photometry *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return ylm_no_memory(e);
  s = make(p, grid);
  if (s == YLM_OK) {
    *out = enter(p);
    return YLM_OK;
  }
  ylm_light_photometry_free(p);
  return ylm_no_memory(e);
}

double ylm_light_photometry_name(const ylm_light_photometry *p) { return p->name; }

double ylm_light_photometry_peak(const ylm_light_photometry *p) { return p->peak; }

double ylm_light_photometry_clipped(const ylm_light_photometry *p) { return p->clipped; }

ylm_light_photometry_grid ylm_light_photometry_grid_of(const ylm_light_photometry *p) {
  return p->grid;
}

size_t ylm_light_photometry_bytes(const ylm_light_photometry *p) {
  size_t n = p->planes * p->angles;
  return sizeof *p + n * (sizeof *p->node + 2 * sizeof(double)) +
         2 * (p->planes + 2 * p->angles) * sizeof(double);
}
