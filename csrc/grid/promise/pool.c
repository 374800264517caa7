/*
** pool.c - refinement of a grid with sides: leaves are split where the error of places, by area, is largest.
**
** A pool of places is compared with the grid as it is. A leaf's score is the sum over its places of their errors, squared and
** clipped. The leaves of the largest scores are split, unless splits there have not helped. Where few places of the pool
** fail, fresh ones are drawn. If too many of these fail, they join the pool.
*/
#include "../sides/sides.h"
#include "tolerance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_list.h"

/* The record of a leaf. */
typedef struct leaf_record {
  float score;       /* of its places now, each clipped */
  float miss;        /* the sum of their errors over the tolerance */
  float parent;      /* its parent's score when that was split; negative: it was not by its score */
  float parent_miss; /* and its miss */
  uint8_t strikes;   /* splits in a row that did not help */
  uint8_t gross;     /* a place fails by far */
} leaf_record;

typedef struct pool {
  side_baker *k;
  refiner *r;
  panel p;        /* the places */
  double *error;  /* [p.n] */
  uint8_t *extra; /* [p.n] 1: it was not drawn by area */
  size_t error_room, extra_room;
  size_t compared;   /* places whose errors are of the grid as it is */
  leaf_record *leaf; /* [cells] */
  size_t leaves, leaf_room;
  uint64_t round; /* of draws */
  bool spent;     /* the budget is */
} pool;

/* -- places ---------------------------------------------------------------------------------------- */

/* The points that the refiner holds join the pool; `extra`: they were not drawn by area. */
static ylm_status take(pool *q, uint8_t extra) {
  refiner *r = q->r;
  size_t before = q->p.n;
  ylm_status s = ylm__panel_take(r, &q->p);
  if (s != YLM_OK) return s;
  if (!ylm_list_reserve(&q->error, q->compared, q->p.n, &q->error_room, sizeof *q->error) ||
      !ylm_list_reserve(&q->extra, before, q->p.n, &q->extra_room, sizeof *q->extra))
    return YLM_ENOMEM;
  memset(q->extra + before, extra, q->p.n - before);
  return YLM_OK;
}

/* The leaf of the octree that a place is looked up in. */
static uint32_t leaf_of(const pool *q, const float x[3]) {
  const ylm_grid *g = q->r->b->g;
  double p[3];
  ylm__grid_outward(g, x, p);
  return ylm_grid_locate(g, p, false, NULL);
}

/* The parts of places that fail: all, and those in leaves that may be split. */
typedef struct failing {
  double all, open;
} failing;

static bool may_split(const pool *q, uint32_t leaf) {
  const ylm_grid *g = q->r->b->g;
  const leaf_record *l = &q->leaf[leaf];
  return g->cell[leaf].level < g->contents.form.depth &&
         l->strikes < (l->gross ? POOL_STRIKES_GROSS : POOL_STRIKES);
}

/* Of places by area: `extra` (or NULL) marks others. */
static failing count_failing(const pool *q, const panel *p, const double *error,
                             const uint8_t *extra) {
  size_t failed = 0, open = 0, all = 0;
  for (size_t i = 0; i < p->n; i++) {
    if (extra && extra[i]) continue;
    all += error[i] >= 0;
    if (!(error[i] > q->r->tolerance)) continue;
    uint32_t leaf = leaf_of(q, p->point + 3 * i);
    failed++;
    open += leaf != YLM_GRID_NONE && may_split(q, leaf);
  }
  if (!all) return (failing){0, 0};
  return (failing){(double)failed / (double)all, (double)open / (double)all};
}

/* Few enough fail, or can be helped. */
static bool is_enough(failing f) { return f.all <= ENOUGH || f.open <= POOL_OPEN; }

/* -- scores ---------------------------------------------------------------------------------------- */

/* The score of an error. */
static float score_of(const pool *q, double error) {
  double x = error / q->r->tolerance;
  double most = q->r->b->source->squares ? POOL_FAR : POOL_CLIP;
  return x > POOL_SLIGHT ? (float)fmin(x * x, most) : 0;
}

/* Cells that are new get a record. */
static ylm_status extend_leaves(pool *q, leaf_record record) {
  size_t n = q->r->b->g->cells;
  if (!ylm_list_reserve(&q->leaf, q->leaves, n, &q->leaf_room, sizeof *q->leaf)) return YLM_ENOMEM;
  while (q->leaves < n) q->leaf[q->leaves++] = record;
  return YLM_OK;
}

/* Compares the places that were not. */
static ylm_status find_errors(pool *q) {
  const size_t w = q->r->b->g->width, had = q->compared;
  panel rest = {.n = q->p.n - had,
                .point = q->p.point + 3 * had,
                .exact = q->p.exact + w * had,
                .drift = q->p.drift + had,
                .inside = q->p.inside + had,
                .side = q->p.side ? q->p.side + 3 * had : NULL};
  if (!rest.n) return YLM_OK;
  q->compared = q->p.n;
  return ylm__panel_errors(q->r, &rest, q->r->b->source->walls, q->error + had);
}

static ylm_status find_scores(pool *q) {
  const ylm_grid *g = q->r->b->g;
  ylm_status s = extend_leaves(q, (leaf_record){.parent = -1});
  for (size_t i = 0; s == YLM_OK && i < g->cells; i++)
    q->leaf[i].score = q->leaf[i].miss = q->leaf[i].gross = 0;
  if (s == YLM_OK) s = find_errors(q);
  for (size_t i = 0; s == YLM_OK && i < q->p.n; i++) {
    uint32_t leaf = leaf_of(q, q->p.point + 3 * i);
    if (leaf == YLM_GRID_NONE || !(q->error[i] >= 0)) continue;
    q->leaf[leaf].score += score_of(q, q->error[i]);
    q->leaf[leaf].miss += (float)fmin(q->error[i] / q->r->tolerance, POOL_FAR);
    q->leaf[leaf].gross |= q->error[i] > POOL_GROSS * q->r->tolerance;
  }
  return s;
}

/* Strikes of the children of leaves that were split: where their scores together are still most of what it was, and their errors
   too. */
static void judge_splits(pool *q) {
  const ylm_grid *g = q->r->b->g;
  for (size_t i = 0; i < g->cells; i++) {
    uint32_t first = g->cell[i].child;
    float sum = 0, miss = 0;
    if (!first || q->leaf[first].parent < 0) continue;
    for (uint32_t c = first; c < first + 8; c++) sum += q->leaf[c].score, miss += q->leaf[c].miss;
    bool helped = sum <= (float)POOL_HELPS * q->leaf[first].parent ||
                  miss <= (float)POOL_HELPS * q->leaf[first].parent_miss;
    for (uint32_t c = first; c < first + 8; c++) {
      q->leaf[c].strikes = helped ? 0 : (uint8_t)(q->leaf[i].strikes + 1);
      q->leaf[c].parent = -1;
    }
  }
}

/* -- splits ---------------------------------------------------------------------------------------- */

typedef struct candidate {
  float score;
  uint32_t leaf;
} candidate;

static int by_score(const void *a, const void *b) {
  const candidate *x = a, *y = b;
  if (x->score != y->score) return x->score > y->score ? -1 : 1;
  return x->leaf < y->leaf ? -1 : 1;
}

/* Leaves that the budget of points leaves room to split. */
static ylm_status find_room(pool *q, size_t *most) {
  size_t budget = q->r->b->source->budget, points;
  if (!budget) return YLM_OK;
  ylm_status s = ylm__sides_count(q->r->b->g, &points);
  size_t room = points < budget ? (budget - points) / POOL_COST : 0;
  if (room < *most) *most = room;
  q->spent = !room;
  return s;
}

/* Splits the leaves of the largest scores, `gross`: among those in which a place fails by far; how many. */
static ylm_status split_worst(pool *q, bool gross, size_t *split) {
  const ylm_grid *g = q->r->b->g;
  candidate *c = ylm_alloc(g->cells, sizeof *c);
  size_t n = 0, leaves = 0;
  if (!c) return YLM_ENOMEM;
  for (size_t i = 0; i < g->cells; i++) {
    if (!(g->cell[i].flags & YLM_GRID_LEAF)) continue;
    leaves++;
    if (!(q->leaf[i].score > 0) || (gross && !q->leaf[i].gross)) continue;
    if (may_split(q, (uint32_t)i)) c[n++] = (candidate){q->leaf[i].score, (uint32_t)i};
  }
  qsort(c, n, sizeof *c, by_score);
  size_t most = 1 + (size_t)(POOL_SPLIT * (double)leaves);
  ylm_status s = n ? find_room(q, &most) : YLM_OK;
  for (*split = 0; s == YLM_OK && *split < n && *split < most; ++*split) {
    uint32_t leaf = c[*split].leaf;
    uint8_t strikes = q->leaf[leaf].strikes;
    s = ylm__sides_split(q->k, leaf);
    if (s == YLM_OK)
      s = extend_leaves(q, (leaf_record){.parent = c[*split].score,
                                         .parent_miss = q->leaf[leaf].miss,
                                         .strikes = strikes});
  }
  q->k->b->next.n = 0; /* leaves are looked for among all */
  ylm_free(c);
  return s;
}

/* Splits occupied leaves that are wider than they may be. */
static ylm_status split_wide(pool *q) {
  baker *b = q->k->b;
  const ylm_grid_form *f = &b->g->contents.form;
  ylm_status s = YLM_OK;
  int level = 0;
  while (level < f->depth && ldexp(1, -level) > POOL_WIDEST) level++;
  while (b->wave.n && s == YLM_OK) {
    for (size_t i = 0; s == YLM_OK && i < b->wave.n; i++)
      if (b->g->cell[b->wave.cell[i]].level < level) s = ylm__sides_split(q->k, b->wave.cell[i]);
    ylm__cells_advance(b);
  }
  return s;
}

/* The grid as it is, ready to be sampled. */
static ylm_status renew(pool *q) {
  ylm_grid *g = q->r->b->g;
  ylm_status s = ylm__sides_renew(q->k);
  q->compared = 0;
  return s == YLM_OK ? ylm__grid_finish(g) : s;
}

/* -- rounds ---------------------------------------------------------------------------------------- */

/* Draws places: HELD_OUT of them. */
static ylm_status draw(pool *q) {
  double t = ylm_seconds();
  q->r->b->stage = "verifying";
  ylm_status s = ylm__verify_draw(q->r, POOL_FROM + ++q->round);
  q->r->b->stage = q->r->b->stage_text;
  q->r->b->g->stats.verify_seconds += ylm_seconds() - t;
  return s;
}

/* Whether fresh places confirm that few fail; else they join the pool. */
static ylm_status confirm(pool *q, bool *enough) {
  panel fresh = {.n = 0};
  ylm_status s = draw(q);
  if (s == YLM_OK) s = ylm__panel_take(q->r, &fresh);
  double *error = ylm_alloc(fresh.n ? fresh.n : 1, sizeof *error);
  if (s == YLM_OK && !error) s = YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__panel_errors(q->r, &fresh, q->r->b->source->walls, error);
  *enough = s == YLM_OK && is_enough(count_failing(q, &fresh, error, NULL));
  if (s == YLM_OK && !*enough) s = take(q, 0);
  ylm__panel_free(&fresh);
  ylm_free(error);
  return s;
}

/* -- suspects ---------------------------------------------------------------------------------------- */

/* How much the light at the corners of a leaf's parts differs, of its norm or of that of all places. */
static float spread_of(const pool *q, size_t cell) {
  const ylm_grid *g = q->r->b->g;
  const ylm_grid_side *side = ylm__grid_side_of(g, (uint32_t)cell);
  double most = 0;
  for (uint32_t part = 0; side && part < side->parts; part++) {
    const uint32_t *node = g->sides.node[side->first + part];
    double sum = 0, square = 0;
    for (size_t j = 0; j < g->width; j++) {
      double mean = 0;
      for (size_t k = 0; k < 8; k++) mean += (double)ylm__grid_row(g, node[k], 0)[j] / 8;
      for (size_t k = 0; k < 8; k++) {
        double d = (double)ylm__grid_row(g, node[k], 0)[j] - mean;
        square += d * d / 8;
      }
      sum += mean * mean;
    }
    most = fmax(most, sqrt(square) / fmax(sqrt(sum), q->r->b->measure.norm));
  }
  return (float)most;
}

/* Marks leaves [cells] that may be split, whose corners differ and in which there is no place; how many. */
static size_t find_suspects(const pool *q, uint8_t *wanted) {
  const ylm_grid *g = q->r->b->g;
  size_t n = 0;
  for (size_t i = 0; i < g->cells; i++) {
    wanted[i] = g->cell[i].flags & YLM_GRID_LEAF && g->cell[i].flags & YLM_GRID_OCCUPIED &&
                may_split(q, (uint32_t)i) && spread_of(q, i) > POOL_SUSPECT;
  }
  for (size_t i = 0; i < q->p.n; i++) {
    uint32_t leaf = leaf_of(q, q->p.point + 3 * i);
    if (leaf != YLM_GRID_NONE) wanted[leaf] = 0;
  }
  for (size_t i = 0; i < g->cells; i++) n += wanted[i];
  return n;
}

/* Places in suspects join the pool, where there is a surface to draw them on. */
static ylm_status look_at_suspects(pool *q) {
  if (!q->r->surface) return YLM_OK;
  uint8_t *wanted = ylm_alloc(q->r->b->g->cells, 1);
  if (!wanted) return YLM_ENOMEM;
  double t = ylm_seconds();
  size_t n = find_suspects(q, wanted);
  ylm_status s = YLM_OK;
  if (n) s = ylm__verify_draw_in(q->r, POOL_FROM + ++q->round, wanted);
  ylm_free(wanted);
  q->r->b->g->stats.verify_seconds += ylm_seconds() - t;
  if (s != YLM_OK || !n || !q->r->held) return s;
  s = take(q, 1);
  return s == YLM_OK ? find_scores(q) : s;
}

/* Whether a place fails by far in a leaf that may be split. */
static bool is_gross(const pool *q) {
  for (size_t i = 0; i < q->leaves; i++)
    if (q->leaf[i].gross && q->r->b->g->cell[i].flags & YLM_GRID_LEAF && may_split(q, (uint32_t)i))
      return true;
  return false;
}

/* Whether more fails at the finest level than in leaves whose halves did not help. */
static bool is_stuck(const pool *q) {
  const ylm_grid *g = q->r->b->g;
  double finest = 0, others = 0;
  for (size_t i = 0; i < q->leaves && i < g->cells; i++) {
    if (!(g->cell[i].flags & YLM_GRID_LEAF) || may_split(q, (uint32_t)i)) continue;
    *(g->cell[i].level < g->contents.form.depth ? &others : &finest) += q->leaf[i].score;
  }
  return finest > others;
}

static ylm_status refine(pool *q) {
  baker *b = q->r->b;
  ylm_status s = split_wide(q);
  if (s == YLM_OK) s = draw(q);
  if (s == YLM_OK) s = take(q, 0);
  for (int round = 1; s == YLM_OK; round++) {
    size_t split = 0;
    snprintf(b->stage_text, sizeof b->stage_text, "round %d", round);
    b->g->stats.rounds = (uint64_t)round;
    s = renew(q);
    if (s == YLM_OK) s = find_scores(q);
    if (s != YLM_OK || round >= POOL_ROUNDS) break;
    judge_splits(q);
    bool enough = is_enough(count_failing(q, &q->p, q->error, q->extra));
    if (enough && !q->r->all && q->p.n < POOL_MOST) {
      s = confirm(q, &enough);
      if (s == YLM_OK && !enough) s = find_scores(q);
    }
    if (s == YLM_OK && enough && !q->r->all) s = look_at_suspects(q);
    if (s != YLM_OK || (enough && !is_gross(q))) break;
    s = split_worst(q, enough, &split);
    if (!split) break;
  }
  return s;
}

ylm_status ylm__pool_bake(side_baker *k) {
  baker *b = k->b;
  double aim = b->source->aim > 0 ? b->source->aim : 1;
  refiner r = {.b = b, .tolerance = aim * b->g->contents.form.tolerance};
  pool q = {.k = k, .r = &r};
  ylm_status s = ylm__tolerance_begin(&r);
  b->choose = NULL;
  if (s == YLM_OK) s = refine(&q);
  if (s == YLM_OK) s = ylm__sides_finish(k);
  if (s == YLM_OK) s = ylm__panel_judge(&r, is_stuck(&q));
  if (s == YLM_OK) b->g->stats.spent = q.spent && !b->g->stats.met;
  ylm__tolerance_end(&r);
  ylm__panel_free(&q.p);
  ylm_free(q.error);
  ylm_free(q.extra);
  ylm_free(q.leaf);
  return s;
}
