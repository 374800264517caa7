/* stale.c - bounds of what points lack, and which points have to be brought up to date. */
#include "follow.h"

#include <math.h>

typedef struct stale_job {
  const ylm_grid *g;
  double tolerance;
  const float *reach, *least; /* [points] */
  uint8_t *what;
} stale_job;

static double distance(const double a[3], const double b[3]) {
  double s = 0;
  for (int k = 0; k < 3; k++) s += (a[k] - b[k]) * (a[k] - b[k]);
  return sqrt(s);
}

/* The norm of a light's radiance over the channels that are baked, or of the difference of two. */
static double emission(const ylm_grid *g, const lamp *a, const lamp *b) {
  double x[3], s = 0;
  for (int c = 0; c < 3; c++) x[c] = a->radiance[c] - (b ? b->radiance[c] : 0);
  if (g->view.form.channels == 1)
    return fabs(YLM_LUMINANCE_R * x[0] + YLM_LUMINANCE_G * x[1] + YLM_LUMINANCE_B * x[2]);
  for (int c = 0; c < 3; c++) s += x[c] * x[c];
  return sqrt(s);
}

/* Bounds of value, gradient and Hessian. */
typedef struct bounds {
  double of[3];
} bounds;

/*
** Bounds of a light of radiance e at distance d, of an exact flat one from its nearest point. The
** part that a horizon cuts off changes with the point: the gradient gets a term along the cut,
** which is at most as long as the light. The Hessian depends on the corners at its ends and has no
** bound.
*/
static bounds bounds_at(const ylm_grid *g, const lamp *l, double e, double d) {
  const double *bound = g->dynamic->bound[lamp_kind_of(l)];
  bounds out = {{0}};
  double x = e > 0 ? e * l->radius * l->radius / (d * d) : 0;
  for (int k = 0; k < 3; k++) {
    out.of[k] = bound[k] * x;
    x = x > 0 ? x / d : 0;
  }
  if (!l->shape || !l->shape->clipped || !(e > 0)) return out;
  double whole = (g->view.form.lmax + 1) * 0.28209479177387814; /* the norm of Y */
  out.of[1] += whole * e * 2 * l->shape->reach / (d * d);
  out.of[2] = INFINITY;
  return out;
}

/* True if p is on one side of the planes of two flat lights of one normal, or lights are spheres:
   across the plane gradients jump. */
static bool same_side(const lamp *a, const lamp *b, const double p[3]) {
  double sa = 0, sb = 0;
  if (!a->shape) return true;
  for (int k = 0; k < 3; k++) {
    sa += a->shape->normal[k] * (p[k] - a->at[k]);
    sb += a->shape->normal[k] * (p[k] - b->at[k]);
  }
  return (sa > 0 && sb > 0) || (sa < 0 && sb < 0);
}

/* Bounds of what a way from a to b changes, of a light of radiance e that slides along it, and of
   the change of its radiance; false where they do not hold. */
static bool bounds_of_way(const ylm_grid *g, const lamp *a, const lamp *b, const double p[3],
                          double e, double db, bounds *out) {
  const double *bound = g->dynamic->bound[lamp_kind_of(a)];
  double way = distance(a->at, b->at);
  if (!same_side(a, b, p)) return false;
  double ds = lamp_way_distance(a, b, p);
  if (ds <= lamp_near(a)) return false;
  *out = bounds_at(g, b, emission(g, b, a), db);
  double x = e * a->radius * a->radius * way / (ds * ds * ds);
  for (int k = 0; k < 3; k++) {
    out->of[k] += x > 0 ? bound[k + 1] * x : 0;
    x = x > 0 ? x / ds : 0;
  }
  return true;
}

/*
** Adds bounds of L(b) - L(a) at p; false if p is too near to either for them to hold. Both ends are
** bounded by themselves; a light that moves as it is also by its way times the largest derivative
** on it.
*/
static bool add_bounds(const ylm_grid *g, const lamp *a, const lamp *b, bool slides,
                       const double p[3], bounds *sum) {
  double ea = emission(g, a, NULL), eb = emission(g, b, NULL), da = lamp_distance(a, p),
         db = lamp_distance(b, p);
  if ((ea > 0 && da <= lamp_near(a)) || (eb > 0 && db <= lamp_near(b))) return false;
  bounds from = bounds_at(g, a, ea, da), to = bounds_at(g, b, eb, db), moved;
  bool moves = slides && bounds_of_way(g, a, b, p, ea, db, &moved);
  for (int k = 0; k < 3; k++) {
    double ends = from.of[k] + to.of[k];
    sum->of[k] += moves && moved.of[k] < ends ? moved.of[k] : ends;
  }
  return true;
}

bool ylm__grid_is_worn(const ylm_grid *g, size_t p, double tolerance, double sixteenths) {
  const grid_dynamic *d = g->dynamic;
  return (double)d->drift[p] > sixteenths * fmax(tolerance / 16, 2e-6) * (double)d->size[p];
}

static int judge(const stale_job *j, size_t p, const double at[3]) {
  const ylm_grid *g = j->g;
  const grid_dynamic *d = g->dynamic;
  bool stale = false, forced = false, near = false;
  bounds sum = {{0}};
  for (size_t m = 0; m < d->movers; m++) {
    const mover *k = &d->mover[m];
    int seen = k->seen[p];
    if (seen == k->current) continue;
    stale = true;
    forced |= k->evict == seen || k->evict == EVICT_ALL;
    near |= !add_bounds(g, &k->state[seen], &k->state[k->current], k->slides[seen], at, &sum);
  }
  if (!stale) return STALE_NOT;
  if (near) return STALE_EXACT;
  if (g->flags[p] & YLM_GRID_POINT_INVALID) return STALE_NOT; /* filled from its neighbours */
  double limit = j->tolerance * (double)j->least[p], edge = (double)j->reach[p];
  bool beyond = 1.58 * sum.of[0] + 0.43 * edge * sum.of[1] > limit;
  if (g->view.form.threshold >= 0 && g->dynamic->bends)
    beyond |= sum.of[2] > 5 * j->tolerance * (double)g->lambda[p];
  if (!beyond && !forced) return STALE_SKIPPED;
  return ylm__grid_is_worn(g, p, j->tolerance, 1) ? STALE_EXACT : STALE_SHIFT;
}

static ylm_status judge_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const stale_job *j = context;
  const ylm_grid *g = j->g;
  const grid_dynamic *d = g->dynamic;
  for (size_t p = begin; p < end; p++) {
    double at[3];
    ylm_grid_position(g, g->lattice + 3 * p, at);
    j->what[p] = (uint8_t)judge(j, p, at);
    if (j->what[p] == STALE_NOT && g->flags[p] & YLM_GRID_POINT_INVALID)
      for (size_t m = 0; m < d->movers; m++) d->mover[m].seen[p] = (uint8_t)d->mover[m].current;
  }
  return YLM_OK;
}

/* Longest edge of the occupied leaves that a point is a corner of, and the smallest norm at their
   corners. */
static void find_reach(const ylm_grid *g, float *reach, float *least) {
  double unit = 0;
  for (int a = 0; a < 3; a++) unit = fmax(unit, 1 / g->scale[a]);
  for (size_t p = 0; p < g->evaluated; p++) {
    reach[p] = (float)unit;
    least[p] = g->dynamic->size[p];
  }
  for (size_t i = 0; i < g->view.octree_cells; i++) {
    const ylm_grid_cell *c = &g->cell[i];
    if (!(c->flags & YLM_GRID_LEAF) || !(c->flags & YLM_GRID_OCCUPIED)) continue;
    float edge = (float)(ylm__grid_edge(g, c) * unit), low = INFINITY;
    for (int k = 0; k < 8; k++)
      if (!(g->flags[c->corner[k]] & YLM_GRID_POINT_INVALID))
        low = fminf(low, g->dynamic->size[c->corner[k]]);
    for (int k = 0; k < 8; k++) {
      uint32_t p = c->corner[k];
      reach[p] = fmaxf(reach[p], edge);
      least[p] = fminf(least[p], low);
    }
  }
}

ylm_status ylm__grid_find_stale(ylm_grid *g, double tolerance, int threads, uint8_t *what) {
  float *reach = ylm_alloc(g->evaluated, sizeof *reach);
  float *least = ylm_alloc(g->evaluated, sizeof *least);
  ylm_status s = reach && least ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) {
    find_reach(g, reach, least);
    stale_job j = {g, tolerance, reach, least, what};
    s = ylm_parallel(g->evaluated, 512, threads, judge_range, &j, NULL, NULL);
  }
  ylm_free(reach);
  ylm_free(least);
  return s;
}
