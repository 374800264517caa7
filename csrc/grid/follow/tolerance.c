/* tolerance.c - keeping a promised tolerance while lights move. */
#include "calibration.h"
#include "update.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool touched(const ylm_grid_cell *c, const uint8_t *changed, size_t known) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] >= known || changed[c->corner[k]]) return true;
  return false;
}

/* Draws points in occupied leaves, every other one in those whose corners changed: elsewhere, what
   points have sat out may have added up. */
static void hold_out(refiner *r, uint64_t round, const uint8_t *changed, size_t known) {
  const ylm_grid *g = r->b->g;
  size_t most = (size_t)UPDATE_HELD << round;
  ylm_rng rng;
  ylm_rng_seed(&rng, r->b->source->seed, 1000 + g->stats.update.updates * UPDATE_ROUNDS + round);
  if (most > HELD_OUT) most = HELD_OUT;
  r->held = 0;
  for (int i = 0; i < UPDATE_DRAWN && r->held < most; i++) {
    float x[3];
    ylm__held_draw(r, &rng, x);
    uint32_t leaf = ylm__held_leaf(g, x);
    const ylm_grid_cell *c = &g->cell[leaf];
    if (!(c->flags & YLM_GRID_OCCUPIED) || (r->held % 2 && !touched(c, changed, known))) continue;
    r->verdict[r->held].leaf = leaf;
    memcpy(r->points + 3 * r->held++, x, sizeof x);
  }
}

static ylm_status split_failed(refiner *r) {
  baker *b = r->b;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &b->g->cell[r->verdict[i].leaf];
    if (!(r->verdict[i].error > r->tolerance) || !(c->flags & YLM_GRID_LEAF) ||
        c->level >= b->g->contents.form.depth)
      continue;
    s = b->g->follower->failed(b->g, c);
    if (s == YLM_OK) s = ylm__cells_split(b, r->verdict[i].leaf);
  }
  ylm__cells_advance(b);
  return s == YLM_OK ? ylm__tolerance_refine(r) : s;
}

/* Splits where fresh points fail; where that is more than chance lets fail, also what the factor
   asks for that would have caught them: the field is not what it was when the factor was found. */
static ylm_status refine_more(refiner *r, uint64_t round, const uint8_t *changed, size_t known) {
  bool limited;
  double start = ylm_seconds();
  hold_out(r, round, changed, known);
  r->b->stage = "verifying";
  ylm_status s = ylm__verify_compare(r);
  r->b->g->stats.verify_seconds += ylm_seconds() - start;
  if (s != YLM_OK) return s;
  return ylm__verify_satisfied(r, &limited) ? split_failed(r) : ylm__tolerance_again(r);
}

/* True if the promise is kept, or the depth forbids it. */
static bool is_settled(const ruling *said) {
  double all = (double)said->points, stuck = (double)said->stuck;
  return said->met ||
         (stuck > PROMISED * all && (double)said->failed - stuck <= ENOUGH_BESIDE_STUCK * all);
}

static ylm_status refine_changed(refiner *r, const uint8_t *changed, size_t known, const panel *p) {
  ylm_grid *g = r->b->g;
  ruling said = {0};
  ylm_status s = ylm__tolerance_refine(r);
  for (uint64_t round = 0; s == YLM_OK; round++) {
    double start = ylm_seconds();
    s = ylm__grid_fill_invalid(g);
    if (s == YLM_OK) s = ylm__judge_leaves(r, p, changed, known, &said);
    g->stats.verify_seconds += ylm_seconds() - start;
    if (s == YLM_OK && said.met && round == 0)
      r->tight = fmax(g->dynamic->loosest, RELAX * r->tight);
    if (s != YLM_OK || is_settled(&said) || round == UPDATE_ROUNDS) break;
    s = refine_more(r, round, changed, known);
  }
  if (s == YLM_OK) ylm__panel_report(&g->stats, p, &said, said.stuck > 0);
  return s;
}

ylm_status ylm__update_tolerance(baker *b, const uint8_t *changed, size_t known, const panel *p) {
  grid_dynamic *d = b->g->dynamic;
  refiner r = {.b = b,
               .tolerance = b->g->contents.form.tolerance,
               .tight = d->tight,
               .ratio = d->ratio,
               .frozen = true,
               .forced = ylm__dynamic_forced};
  ylm_status s = ylm__tolerance_begin(&r);
  if (s == YLM_OK) s = refine_changed(&r, changed, known, p);
  if (s == YLM_OK) d->tight = r.tight;
  ylm__tolerance_end(&r);
  return s;
}
