/* emit.c - virtual lights of a scene: landings of particles, chosen, with radii. */
#include "emit.h"

#define GRAIN 8192 /* lights */

static ylm_status check(const ylm_emit_options *o, ylm_error *e) {
  if (o->particles < 1 || o->particles > YLM_EMIT_PARTICLES)
    return ylm_fail(e, YLM_ERANGE, "particles must be from 1 to %zu, got %zu", YLM_EMIT_PARTICLES,
                    o->particles);
  if (o->lights > YLM_EMIT_PARTICLES)
    return ylm_fail(e, YLM_ERANGE, "there are at most %zu lights, got %zu", YLM_EMIT_PARTICLES,
                    o->lights);
  if (o->bounces < 1 || o->bounces > YLM_EMIT_BOUNCES)
    return ylm_fail(e, YLM_ERANGE, "bounces must be from 1 to %d, got %d", YLM_EMIT_BOUNCES,
                    o->bounces);
  if (o->degree < YLM_EMIT_AUTO || o->degree > YLM_EMIT_DEGREE)
    return ylm_fail(e, YLM_ERANGE, "degree must be from 0 to %d, got %d", YLM_EMIT_DEGREE,
                    o->degree);
  if (!(o->cell >= 0) || !isfinite(o->cell))
    return ylm_fail(e, YLM_ERANGE, "cell must be a positive length, got %g", o->cell);
  if (o->merge && o->grid)
    return ylm_fail(e, YLM_EINVAL, "a grid's lights are its texels: they are not merged");
  if (o->radius == YLM_EMIT_FIXED && (!(o->fixed > 0) || !isfinite(o->fixed)))
    return ylm_fail(e, YLM_ERANGE, "radius must be a positive length, got %g", o->fixed);
  if (o->radius == YLM_EMIT_NEIGHBOURS && !o->grid)
    return ylm_fail(e, YLM_EINVAL, "radii by neighbours are of a grid, whose texels have them");
  if (!(o->scale > 0) || !isfinite(o->scale))
    return ylm_fail(e, YLM_ERANGE, "scale must be a positive number, got %g", o->scale);
  return YLM_OK;
}

/* Options of a grid: a particle a texel, each a light. */
static ylm_status lay_grids(const ylm_scene *scene, ylm_emit_options *o, ylm_error *e) {
  size_t spots = ylm_scene_spots(scene, NULL), each = (size_t)o->grid * (size_t)o->grid;
  if (spots == 0 || ylm_scene_near(scene) + ylm_scene_distant(scene) > 0)
    return ylm_fail(e, YLM_EINVAL, "a grid is of spot_lights alone, the scene has %s",
                    spots ? "other lamps too: distribution = 'particles' is of all" : "none");
  if (o->grid > 8192 || each > YLM_EMIT_PARTICLES / spots)
    return ylm_fail(e, YLM_ERANGE, "grids of %d texels a side are too many texels", o->grid);
  o->particles = spots * each;
  o->lights = 0;
  o->bounces = 1;
  return YLM_OK;
}

/* Keeps at most `lights` landings, by equal steps along the sum of their power. */
static void choose(const ylm_emit_options *o, emit_landings *x) {
  double all = 0, upto = 0, step;
  ylm_rng rng;
  size_t n = 0;
  for (size_t i = 0; i < x->n; i++) all += ylm__emit_luminous(&x->landing[i]);
  step = all / (double)o->lights;
  ylm_rng_seed(&rng, o->seed, ~(uint64_t)1);
  double next = step * ylm_rng_double(&rng);
  for (size_t i = 0; i < x->n; i++) {
    double own = ylm__emit_luminous(&x->landing[i]);
    int times = 0;
    for (upto += own; next < upto && own > 0; next += step) times++;
    if (!times) continue;
    emit_landing l = x->landing[i];
    for (int c = 0; c < 3; c++) l.power[c] *= (float)(times * step / own);
    x->landing[n++] = l;
  }
  x->n = n;
}

/* Cells are numbered by 30 bits and a sign along each axis. */
static ylm_status check_cell(const ylm_scene *scene, const ylm_emit_options *o, ylm_error *e) {
  double lo[3], hi[3], far = 0;
  ylm_scene_bounds(scene, lo, hi);
  for (int a = 0; a < 3; a++) far = fmax(far, fmax(fabs(lo[a]), fabs(hi[a])));
  if (!o->merge || !(o->cell > 0) || o->cell >= 1e-9 * far) return YLM_OK;
  return ylm_fail(
      e, YLM_ERANGE,
      "cell must be at least %.3g, 1e-9 of the farthest surface from the origin, got %g",
      1e-9 * far, o->cell);
}

typedef struct filling {
  const emit_landing *landing;
  ylm_emit_lights *l;
} filling;

static ylm_status fill_some(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const filling *f = context;
  for (size_t i = begin; i < end; i++) {
    const emit_landing *from = &f->landing[i];
    double n[3] = {(double)from->normal[0], (double)from->normal[1], (double)from->normal[2]};
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (size_t k = 0; k < 3; k++) {
      f->l->at[3 * i + k] = (double)from->at[k];
      f->l->normal[3 * i + k] = length > 0 ? n[k] / length : 0;
      f->l->intensity[3 * i + k] = (double)from->power[k] / YLM_PI;
    }
  }
  return YLM_OK;
}

static ylm_status fill(const emit_landings *x, int threads, ylm_emit_lights *l) {
  filling f = {x->landing, l};
  l->n = x->n;
  l->at = ylm_alloc(x->n, 3 * sizeof *l->at);
  l->normal = ylm_alloc(x->n, 3 * sizeof *l->normal);
  l->radius = ylm_alloc(x->n, sizeof *l->radius);
  l->intensity = ylm_alloc(x->n, 3 * sizeof *l->intensity);
  if (!l->at || !l->normal || !l->radius || !l->intensity) return YLM_ENOMEM;
  return ylm_parallel(x->n, GRAIN, threads, fill_some, &f, NULL, NULL);
}

/* One light of the landings of each cell; those of surfaces that gloss are made first, with what each sends. */
static ylm_status merge(const emit_gloss *gloss, const ylm_emit_options *o, emit_landings *x,
                        ylm_emit_lights *lights, ylm_emit_report *report, ylm_error *e) {
  ylm_emit_lights parts = {0};
  double begun = ylm_seconds();
  ylm_status s = gloss ? fill(x, o->threads, &parts) : YLM_OK;
  if (s == YLM_OK && gloss) s = ylm__emit_emission(gloss, x->landing, o, &parts, report, e);
  report->seconds[2] = ylm_seconds() - begun;
  report->merged = x->n;
  if (s == YLM_OK) s = ylm__emit_merge(o, gloss ? &parts : NULL, x, lights, &report->cell);
  report->seconds[3] = ylm_seconds() - begun - report->seconds[2];
  ylm_emit_free(&parts);
  return s;
}

/* A light of each landing, or of as many as are wanted. */
static ylm_status make(const emit_gloss *gloss, const ylm_emit_options *o, emit_landings *x,
                       ylm_emit_lights *lights, ylm_emit_report *report, ylm_error *e) {
  double begun = ylm_seconds();
  if (o->lights > 0 && x->n > o->lights) choose(o, x);
  ylm_status s = fill(x, o->threads, lights);
  if (s == YLM_OK) s = ylm__emit_emission(gloss, x->landing, o, lights, report, e);
  report->seconds[2] = ylm_seconds() - begun;
  return s;
}

ylm_status ylm_emit(const ylm_scene *scene, const ylm_emit_options *o, ylm_emit_lights *lights,
                    ylm_emit_report *report, ylm_error *e) {
  emit_landings x = {0};
  emit_gloss *gloss = NULL;
  double begun = ylm_seconds();
  *lights = (ylm_emit_lights){0};
  *report = (ylm_emit_report){.particles = o->particles};
  ylm_emit_options gridded = *o;
  ylm_status s = check(o, e);
  if (s == YLM_OK) s = check_cell(scene, o, e);
  if (s == YLM_OK && o->grid) {
    s = lay_grids(scene, &gridded, e);
    report->particles = gridded.particles;
    o = &gridded;
  }
  if (s == YLM_OK) s = ylm__emit_gloss(scene, o, &gloss);
  if (s == YLM_OK) s = ylm__emit_trace(scene, gloss, o, &x, report);
  report->seconds[0] = ylm_seconds() - begun;
  bool merged = o->merge && x.n > 0 && (x.n > o->lights || o->cell > 0);
  if (s == YLM_OK) s = (merged ? merge : make)(gloss, o, &x, lights, report, e);
  begun = ylm_seconds();
  if (s == YLM_OK) s = ylm__emit_radii(scene, x.landing, o, lights, report);
  report->seconds[1] = ylm_seconds() - begun;
  ylm_free(x.landing);
  ylm__emit_gloss_free(gloss);
  for (size_t i = 0; s == YLM_OK && ylm_scene_origin(scene) && i < 3 * lights->n; i++)
    lights->at[i] += ylm_scene_origin(scene)[i % 3];
  if (s != YLM_OK) ylm_emit_free(lights);
  return s;
}

void ylm_emit_free(ylm_emit_lights *l) {
  ylm_free(l->at);
  ylm_free(l->normal);
  ylm_free(l->radius);
  ylm_free(l->intensity);
  ylm_free(l->shift);
  ylm_free(l->emission);
  *l = (ylm_emit_lights){0};
}
