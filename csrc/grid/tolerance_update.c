/* tolerance_update.c - keeping a promised tolerance while lights move. */
#include "tolerance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points that are compared, twice; then twice as many from round to round. */
#define UPDATE_HELD 256
#define UPDATE_DRAWN 16384 /* tries to find as many in voxels that changed */
#define UPDATE_ROUNDS 8
#define RELAX 0.98 /* what becomes of the factor in an update that passes at once */

static bool touched(const ylm_grid_cell *c, const uint8_t *changed, size_t known) {
  for (int k = 0; k < 8; k++)
    if (c->corner[k] >= known || changed[c->corner[k]]) return true;
  return false;
}

/* Draws points in occupied leaves whose corners changed. */
static void hold_out_changed(refiner *r, uint64_t round, const uint8_t *changed, size_t known) {
  const ylm_grid *g = r->b->g;
  size_t most = (size_t)UPDATE_HELD << (round > 1 ? round - 1 : 0);
  ylm_rng rng;
  ylm_rng_seed(&rng, r->b->source->seed, 1000 + g->stats.update.updates * UPDATE_ROUNDS + round);
  if (most > HELD_OUT) most = HELD_OUT;
  r->held = 0;
  for (int i = 0; i < UPDATE_DRAWN && r->held < most; i++) {
    float x[3];
    refiner_draw(r, &rng, x);
    uint32_t leaf = refiner_leaf(g, x);
    if (!(g->cell[leaf].flags & YLM_GRID_OCCUPIED) || !touched(&g->cell[leaf], changed, known))
      continue;
    r->verdict[r->held].leaf = leaf;
    memcpy(r->points + 3 * r->held++, x, sizeof x);
  }
}

/* Compares the points that are held out; counts those that fail in leaves that can be split. */
static ylm_status compare_changed(refiner *r, size_t *failed) {
  const ylm_grid *g = r->b->g;
  ylm_status s = refiner_compare(r);
  *failed = 0;
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++)
    *failed += r->verdict[i].error > r->tolerance &&
               g->cell[r->verdict[i].leaf].level < g->view.form.depth;
  return s;
}

static ylm_status split_failed(refiner *r) {
  baker *b = r->b;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < r->verdicts && s == YLM_OK; i++) {
    const ylm_grid_cell *c = &b->g->cell[r->verdict[i].leaf];
    if (!(r->verdict[i].error > r->tolerance) || !(c->flags & YLM_GRID_LEAF) ||
        c->level >= b->g->view.form.depth)
      continue;
    s = refiner_force(r, c);
    if (s == YLM_OK) s = baker_split(b, r->verdict[i].leaf);
  }
  baker_advance(b);
  return s == YLM_OK ? refiner_refine(r) : s;
}

/* Splits what failed; where that is more than chance lets fail, also what the factor asks for that
   would have caught them: the field is not what it was when the factor was found. */
static ylm_status refine_more(refiner *r, uint64_t round) {
  bool limited;
  size_t failed = 0;
  double few = (round < 2 ? 0.02 : 0.01) * (double)r->verdicts;
  for (size_t i = 0; i < r->verdicts; i++) failed += r->verdict[i].error > r->tolerance;
  if ((double)failed <= few || refiner_satisfied(r, &limited)) return split_failed(r);
  return refiner_again(r);
}

static ylm_status refine_changed(refiner *r, const uint8_t *changed, size_t known) {
  ylm_grid_update_stats *stats = &r->b->g->stats.update;
  ylm_status s = refiner_refine(r);
  stats->verified = 0;
  for (uint64_t round = 0; s == YLM_OK && round < UPDATE_ROUNDS; round++) {
    size_t failed;
    double start = ylm_seconds();
    s = ylm__grid_fill_invalid(r->b->g);
    hold_out_changed(r, round, changed, known);
    r->b->stage = "verifying";
    if (s == YLM_OK) s = compare_changed(r, &failed);
    r->b->g->stats.verify_seconds += ylm_seconds() - start;
    if (s != YLM_OK || r->verdicts == 0) break;
    bool last = (double)failed <= 0.006 * (double)r->verdicts || round + 1 == UPDATE_ROUNDS;
    if (!last) s = refine_more(r, round);
    if (!last || s != YLM_OK) continue;
    if (round == 0) r->tight = fmax(r->b->g->dynamic->loosest, RELAX * r->tight);
    double largest;
    refiner_quantiles(r, &stats->error, &largest);
    stats->verified = r->verdicts;
    stats->met = stats->error <= r->tolerance;
    break;
  }
  return s;
}

ylm_status ylm__grid_update_tolerance(baker *b, const uint8_t *changed, size_t known) {
  grid_dynamic *d = b->g->dynamic;
  refiner r = {.b = b,
               .tolerance = b->g->view.form.tolerance,
               .tight = d->tight,
               .ratio = d->ratio,
               .frozen = true};
  ylm_status s = refiner_begin(&r);
  if (s == YLM_OK) s = refine_changed(&r, changed, known);
  if (s == YLM_OK) d->tight = r.tight;
  refiner_end(&r);
  return s;
}
