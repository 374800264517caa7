/*
** go_on.c - bakes by a tolerance: the first, and such that go on from another, of the same surfaces in light that has
** changed a little.
**
** A bake finds out how residuals follow from the metric, and by which factor estimates are to be tightened; then it verifies
** by thousands of points. A bake like it begins with both numbers. It compares FRAME_HELD fresh points with the field. The
** judgement is of these and of those of the bakes before, HELD_OUT at best: it holds for the bakes in a row, and for one
** of them as far as they are alike.
*/
#include <math.h>
#include <string.h>

#include "tolerance.h"

/* Seeds of held-out points: away from those of rounds and panels. */
#define FRAMES_FROM ((uint64_t)1 << 20)

/* The part of the compared points that fail. */
static double failing(const refiner *r) {
  size_t failed = 0;
  for (size_t i = 0; i < r->verdicts; i++) failed += r->verdict[i].error > r->tolerance;
  return r->verdicts ? (double)failed / (double)r->verdicts : 0;
}

/* True if a point fails in a voxel of the finest level. */
static bool is_limited(const refiner *r) {
  const ylm_grid *g = r->b->g;
  for (size_t i = 0; i < r->verdicts; i++)
    if (r->verdict[i].error > r->tolerance &&
        g->cell[r->verdict[i].leaf].level >= g->contents.form.depth)
      return true;
  return false;
}

/* Errors of the held-out points in the finished grid; negative: left out. */
static ylm_status finished(const refiner *r, double *error) {
  panel p = {
      .n = r->held, .point = r->points, .exact = r->exact, .inside = r->inside, .side = r->side};
  return ylm__panel_errors(r, &p, NULL, error);
}

static void remember(frames *f, double error) {
  size_t at = f->n < HELD_OUT ? f->n++ : f->next++;
  f->next %= HELD_OUT;
  f->error[at] = (float)error;
}

/* Judges by the errors that are known, and settles the factor of the next bake. */
static ylm_status judge(refiner *r, frames *f, bool limited) {
  panel p = {.n = f->n, .all = r->all};
  double *error = ylm_alloc(f->n, sizeof *error);
  if (!error) return YLM_ENOMEM;
  ruling said;
  for (size_t i = 0; i < f->n; i++) error[i] = (double)f->error[i];
  ylm_status s = ylm__panel_rule(&p, error, r->tolerance, DOUBT, &said);
  if (s == YLM_OK) {
    ylm__panel_report(&r->b->g->stats, &p, &said, limited);
    double share = said.points ? (double)said.failed / (double)said.points : 0;
    if (share > ENOUGH) r->tight *= FRAME_TIGHTER;
    if (share < FRAME_FEW) r->tight *= FRAME_LOOSER;
  }
  ylm_free(error);
  return s;
}

/* Takes the errors of this bake's points; where they are all that there are, no others. */
static ylm_status conclude(refiner *r, frames *f, bool limited) {
  double *error = ylm_alloc(r->held, sizeof *error);
  if (!error) return YLM_ENOMEM;
  double t = ylm_seconds();
  ylm_status s = finished(r, error);
  if (r->all) f->n = f->next = 0;
  for (size_t i = 0; s == YLM_OK && i < r->held; i++)
    if (error[i] >= 0) remember(f, error[i]);
  if (s == YLM_OK) s = judge(r, f, limited);
  r->b->g->stats.verify_seconds += ylm_seconds() - t;
  ylm_free(error);
  return s;
}

/* Ratios count for less, the older they are. */
static void forget_half(ratios *r) {
  r->n = 0;
  for (int k = 0; k < 256; k++) r->n += r->count[k] /= 2;
}

static ylm_status run_on(refiner *r) {
  frames *f = r->b->g->frames = ylm_alloc_copy(r->b->before_this, 1, sizeof *f);
  bool limited = false;
  if (!f) return YLM_ENOMEM;
  f->bakes++;
  if (r->ratio.n > FRAME_RATIOS) forget_half(&r->ratio);
  r->most = FRAME_HELD;
  ylm_status s = ylm__tolerance_refine(r);
  for (uint64_t round = 1; s == YLM_OK; round++) {
    r->b->g->stats.rounds = round;
    s = ylm__verify(r, FRAMES_FROM + f->bakes * (MAX_ROUNDS + 1) + round);
    if (s != YLM_OK || failing(r) <= FRAME_FAILS || ylm__verify_satisfied(r, &limited) ||
        round == MAX_ROUNDS)
      break;
    s = ylm__tolerance_again(r);
  }
  if (s == YLM_OK) limited = is_limited(r);
  if (s == YLM_OK) s = ylm__finish(r->b);
  return s == YLM_OK ? conclude(r, f, limited) : s;
}

/* The grid keeps what bakes like it go on with. */
static ylm_status keep(const refiner *r) {
  frames *f = r->b->g->frames;
  bool first = !f;
  if (first) f = r->b->g->frames = ylm_alloc_zero(1, sizeof *f);
  if (!f) return YLM_ENOMEM;
  f->ratio = r->ratio;
  f->tight = r->tight;
  for (size_t i = 0; first && i < r->verdicts; i++) remember(f, r->verdict[i].error);
  return YLM_OK;
}

/* -- the bake ------------------------------------------------------------------------------------ */

/* The first: rounds of refinement until few points fail, then the panel. */
static ylm_status run(refiner *r) {
  bool limited = false;
  ylm_status s = ylm__tolerance_refine(r);
  for (uint64_t round = 1; s == YLM_OK; round++) {
    r->b->g->stats.rounds = round;
    s = ylm__verify(r, round);
    if (s != YLM_OK || ylm__verify_satisfied(r, &limited) || round == MAX_ROUNDS) break;
    s = ylm__tolerance_again(r);
  }
  if (s == YLM_OK) s = ylm__finish(r->b);
  return s == YLM_OK ? ylm__panel_judge(r, limited) : s;
}

ylm_status ylm__tolerance_bake(baker *b) {
  refiner r = {.b = b, .tolerance = b->g->contents.form.tolerance, .tight = FIRST_TIGHT};
  if (b->before_this) {
    r.ratio = b->before_this->ratio;
    r.tight = b->before_this->tight;
  }
  ylm_status s = ylm__tolerance_begin(&r);
  if (s == YLM_OK) s = b->before_this ? run_on(&r) : run(&r);
  if (s == YLM_OK && !b->g->follower && !b->remote) s = keep(&r);
  ylm__tolerance_end(&r);
  b->learnt.ratio = r.ratio;
  b->learnt.tight = r.tight;
  return s;
}
