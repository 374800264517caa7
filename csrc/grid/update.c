/*
** update.c - a dynamic grid after its lights changed.
**
** In this order: find what changed; bring points up to date whose interpolation is off by more than
** the tolerance; refine and merge from the root, where points that exist are not evaluated again;
** drop what nobody needs and make the grid continuous. Until the last step everything can be taken
** back, so that a cancelled update leaves the grid as it was.
*/
#include "dynamic.h"

#include <math.h>
#include <string.h>

#define DEFAULT_TOLERANCE 1e-3

/* What was, to be taken back. Points are those that were in the grid, interpolated ones too. */
typedef struct undo {
  size_t points, evaluated, cells, cell_room, movers;
  ylm_grid_cell *cell; /* the old cells, while new ones are made; else NULL */
  uint8_t *flags;
  float *lambda, *norm, *size, *drift;
  uint64_t *sign;
  mover *mover;     /* [movers], with copies of `seen` */
  uint32_t *logged; /* points whose rows follow */
  float *data, *hessian;
  size_t logs;
} undo;

typedef struct update {
  ylm_grid *g;
  grid_dynamic *d;
  baker b;
  ylm_grid_source source;
  double tolerance;
  lamp *now;
  int64_t *origin; /* [lamps now] */
  lamp_change *change;
  size_t lamps, changes;
  uint32_t *exact, *shift; /* points to evaluate with all lights, with what changed */
  size_t exacts, shifts;
  uint8_t *changed; /* [points at the beginning] data are not what they were */
  double *boxes;    /* [2 changes][6] around lights that changed */
  undo old;
  bool over; /* nothing can be taken back any more */
  ylm_grid_update_stats stats;
} update;

/* -- taking back -------------------------------------------------------------------------- */

static void *copy(const void *from, size_t bytes) {
  void *to = ylm_alloc(bytes, 1);
  if (to && bytes) memcpy(to, from, bytes);
  return to;
}

/* Keeps everything but rows of data. */
static ylm_status remember(update *u) {
  const ylm_grid *g = u->g;
  const grid_dynamic *d = u->d;
  undo *o = &u->old;
  o->points = g->points;
  o->evaluated = g->evaluated;
  o->cells = g->cells;
  o->cell_room = g->cell_room;
  o->flags = copy(g->flags, g->points);
  o->lambda = copy(g->lambda, g->points * sizeof *o->lambda);
  o->norm = copy(g->norm, g->points * sizeof *o->norm);
  o->size = copy(d->size, g->evaluated * sizeof *o->size);
  o->drift = copy(d->drift, g->evaluated * sizeof *o->drift);
  o->sign = copy(d->sign, g->evaluated * sizeof *o->sign);
  o->mover = copy(d->mover, d->movers * sizeof *o->mover);
  if (!o->flags || !o->lambda || !o->norm || !o->size || !o->drift || !o->sign || !o->mover)
    return YLM_ENOMEM;
  for (size_t m = 0; m < d->movers; m++) o->mover[m].seen = NULL;
  o->movers = d->movers;
  for (size_t m = 0; m < d->movers; m++) {
    o->mover[m].seen = copy(d->mover[m].seen, g->evaluated);
    if (!o->mover[m].seen) return YLM_ENOMEM;
  }
  return YLM_OK;
}

/* Keeps the rows of the points that will be written. */
static ylm_status log_rows(update *u) {
  const ylm_grid *g = u->g;
  undo *o = &u->old;
  size_t invalid = 0, row = 4 * g->stride, bends = u->d->bends;
  for (size_t p = 0; p < g->evaluated; p++) invalid += (g->flags[p] & YLM_GRID_POINT_INVALID) != 0;
  size_t most = u->exacts + u->shifts + invalid;
  o->logged = ylm_alloc(most, sizeof *o->logged);
  o->data = ylm_alloc(most, row * sizeof *o->data);
  o->hessian = ylm_alloc(most, bends * sizeof *o->hessian);
  if (!o->logged || !o->data || !o->hessian) return YLM_ENOMEM;
  for (size_t i = 0; i < u->exacts; i++) o->logged[o->logs++] = u->exact[i];
  for (size_t i = 0; i < u->shifts; i++) o->logged[o->logs++] = u->shift[i];
  for (uint32_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID && !u->changed[p]) o->logged[o->logs++] = p;
  for (size_t i = 0; i < o->logs; i++) {
    size_t p = o->logged[i];
    memcpy(o->data + i * row, g->data + p * row, row * sizeof *o->data);
    if (bends)
      memcpy(o->hessian + i * bends, u->d->hessian + p * bends, bends * sizeof *o->hessian);
  }
  return YLM_OK;
}

static void restore(update *u) {
  ylm_grid *g = u->g;
  grid_dynamic *d = u->d;
  undo *o = &u->old;
  size_t row = 4 * g->stride, bends = d->bends;
  for (size_t p = o->points; p < g->points; p++)
    lattice_hash_remove(&g->hash, lattice_key(g->lattice + 3 * p));
  g->points = o->points;
  g->evaluated = o->evaluated;
  if (o->cell) {
    ylm_free(g->cell);
    g->cell = o->cell;
    g->cells = o->cells;
    g->cell_room = o->cell_room;
    o->cell = NULL;
  }
  memcpy(g->flags, o->flags, g->points);
  memcpy(g->lambda, o->lambda, g->points * sizeof *g->lambda);
  memcpy(g->norm, o->norm, g->points * sizeof *g->norm);
  memcpy(d->size, o->size, g->evaluated * sizeof *d->size);
  memcpy(d->drift, o->drift, g->evaluated * sizeof *d->drift);
  memcpy(d->sign, o->sign, g->evaluated * sizeof *d->sign);
  for (size_t i = 0; i < o->logs; i++) {
    size_t p = o->logged[i];
    memcpy(g->data + p * row, o->data + i * row, row * sizeof *g->data);
    if (bends) memcpy(d->hessian + p * bends, o->hessian + i * bends, bends * sizeof *d->hessian);
  }
  for (size_t m = 0; m < d->movers; m++) {
    uint8_t *seen = d->mover[m].seen;
    if (m >= o->movers) {
      ylm_free(seen);
      continue;
    }
    memcpy(seen, o->mover[m].seen, g->evaluated);
    mover was = o->mover[m];
    was.seen = seen;
    d->mover[m] = was;
  }
  d->movers = o->movers;
  ylm__grid_sync(g);
}

static void forget(update *u) {
  undo *o = &u->old;
  for (size_t m = 0; m < o->movers; m++) ylm_free(o->mover[m].seen);
  ylm_free(o->mover);
  ylm_free(o->flags);
  ylm_free(o->lambda);
  ylm_free(o->norm);
  ylm_free(o->size);
  ylm_free(o->drift);
  ylm_free(o->sign);
  ylm_free(o->logged);
  ylm_free(o->data);
  ylm_free(o->hessian);
  ylm_free(o->cell);
  ylm_free(u->now);
  ylm_free(u->origin);
  ylm_free(u->change);
  ylm_free(u->exact);
  ylm_free(u->shift);
  ylm_free(u->changed);
  ylm_free(u->boxes);
  baker_free(&u->b);
}

/* -- movers --------------------------------------------------------------------------------- */

/* How many points have a mover in each state. */
static void count_states(const mover *m, size_t points, size_t n[STATES]) {
  memset(n, 0, STATES * sizeof *n);
  for (size_t p = 0; p < points; p++) n[m->seen[p]]++;
}

/* Makes `now` the present state: one that is remembered, or a free one. One remains free: if it is
   the last, the state that the fewest points have has to go. */
static void enter_state(update *u, mover *m, const lamp *now) {
  size_t n[STATES], least = SIZE_MAX;
  int found = -1, empty = -1, left = 0;
  count_states(m, u->g->evaluated, n);
  for (int k = 0; k < STATES; k++) {
    m->taken[k] = k == m->current || n[k] > 0;
    if (m->taken[k] && memcmp(&m->state[k], now, sizeof *now) == 0) found = k;
    if (!m->taken[k] && empty < 0) empty = k;
  }
  m->current = found >= 0 ? found : empty;
  m->state[m->current] = *now;
  m->taken[m->current] = true;
  m->moved = u->stats.updates;
  m->evict = -1;
  for (int k = 0; k < STATES; k++) {
    left += !m->taken[k];
    if (k != m->current && m->taken[k] && n[k] < least) {
      least = n[k];
      m->evict = k;
    }
  }
  if (left > 1) m->evict = -1;
}

/* A mover whose points all have it in state 0. */
static ylm_status new_mover(grid_dynamic *d, const lamp *was) {
  mover *more = ylm_realloc(d->mover, d->movers * sizeof *more, d->movers + 1, sizeof *more);
  if (!more) return YLM_ENOMEM;
  d->mover = more;
  mover *m = &more[d->movers];
  *m = (mover){.evict = -1};
  m->state[0] = *was;
  m->taken[0] = true;
  m->seen = ylm_alloc_zero(d->room, 1);
  if (!m->seen) return YLM_ENOMEM;
  d->movers++;
  return YLM_OK;
}

static lamp dark(const lamp *l) {
  lamp out = *l;
  memset(out.radiance, 0, sizeof out.radiance);
  return out;
}

/* The box around a lamp. */
static void enclose(const lamp *l, double box[6]) {
  for (int a = 0; a < 3; a++) {
    box[a] = l->at[a] - l->radius;
    box[a + 3] = l->at[a] + l->radius;
  }
}

/* The light set becomes the new one; whoever changed is a mover from now on. The arrays are changed
   only where nothing can fail any more, `of` is the new mover_of. */
static ylm_status enter_changes(update *u, int32_t *of) {
  grid_dynamic *d = u->d;
  u->boxes = ylm_alloc(2 * u->changes, 6 * sizeof *u->boxes);
  if (!u->boxes) return YLM_ENOMEM;
  for (size_t j = 0; j < u->lamps; j++) of[j] = u->origin[j] < 0 ? -1 : d->mover_of[u->origin[j]];
  for (size_t i = 0; i < u->changes; i++) {
    const lamp_change *c = &u->change[i];
    const lamp *after = c->after < 0 ? NULL : &u->now[c->after];
    const lamp was = c->before < 0 ? dark(after) : d->lamp[c->before];
    int32_t m = c->before < 0 ? -1 : d->mover_of[c->before];
    if (m < 0) {
      ylm_status s = new_mover(d, &was);
      if (s != YLM_OK) return s;
      m = (int32_t)d->movers - 1;
    }
    lamp now = after ? *after : dark(&was);
    enter_state(u, &d->mover[m], &now);
    enclose(&was, u->boxes + 12 * i);
    enclose(&now, u->boxes + 12 * i + 6);
    if (after) of[c->after] = m;
  }
  if (d->movers > MANY_MOVERS) {
    size_t oldest = 0;
    for (size_t m = 1; m < d->movers; m++)
      if (d->mover[m].moved < d->mover[oldest].moved) oldest = m;
    d->mover[oldest].evict = EVICT_ALL;
  }
  return YLM_OK;
}

/* Forgets movers that all points have in their present state. */
static void retire(grid_dynamic *d, size_t points) {
  for (size_t m = d->movers; m-- > 0;) {
    size_t n[STATES];
    count_states(&d->mover[m], points, n);
    if (n[d->mover[m].current] != points) continue;
    size_t last = --d->movers;
    ylm_free(d->mover[m].seen);
    if (m != last) d->mover[m] = d->mover[last];
    for (size_t i = 0; i < d->lamps; i++) {
      if (d->mover_of[i] == (int32_t)m)
        d->mover_of[i] = -1;
      else if (d->mover_of[i] == (int32_t)last)
        d->mover_of[i] = (int32_t)m;
    }
  }
}

/* -- points ----------------------------------------------------------------------------------- */

/* Which points are to be evaluated anew, and which get the difference. */
static ylm_status choose_points(update *u) {
  ylm_grid *g = u->g;
  uint8_t *what = ylm_alloc(g->evaluated, 1);
  u->exact = ylm_alloc(g->evaluated, sizeof *u->exact);
  u->shift = ylm_alloc(g->evaluated, sizeof *u->shift);
  u->changed = ylm_alloc_zero(g->points, 1);
  ylm_status s = what && u->exact && u->shift && u->changed ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__grid_find_stale(g, u->tolerance, u->source.threads, what);
  for (uint32_t p = 0; s == YLM_OK && p < g->evaluated; p++) {
    if (what[p] == STALE_EXACT) u->exact[u->exacts++] = p;
    if (what[p] == STALE_SHIFT) u->shift[u->shifts++] = p;
    u->stats.skipped += what[p] == STALE_SKIPPED;
    u->changed[p] = what[p] == STALE_EXACT || what[p] == STALE_SHIFT;
  }
  ylm_free(what);
  return s;
}

typedef struct shift_job {
  ylm_grid *g;
  const field_block *block;
  const uint32_t *list;
} shift_job;

static ylm_status add_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const shift_job *j = context;
  for (size_t i = begin; i < end; i++) ylm__dynamic_add(j->g, j->list[i], j->block, i);
  return YLM_OK;
}

static ylm_status measure_range(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const shift_job *j = context;
  for (size_t i = begin; i < end; i++) ylm__dynamic_measure(j->g, j->list[i]);
  return YLM_OK;
}

/* Adds the light b and subtracts a at n points. */
static ylm_status shift_points(update *u, const lamp *a, const lamp *b, size_t n,
                               const uint32_t *list) {
  double at[6], radius[2], radiance[6];
  const lamp *both[2] = {a, b};
  ylm_lights *pair;
  for (size_t k = 0; k < 2; k++)
    for (size_t i = 0; i < 3; i++) {
      at[3 * k + i] = both[k]->at[i];
      radiance[3 * k + i] = k ? both[k]->radiance[i] : -both[k]->radiance[i];
      radius[k] = both[k]->radius;
    }
  ylm_status s = ylm_lights_create(2, at, radius, radiance, &pair, u->b.e);
  if (s == YLM_OK) s = baker_reserve_block(&u->b, &u->b.block, n);
  field_block *k = &u->b.block;
  for (size_t i = 0; s == YLM_OK && i < n; i += k->room) {
    size_t now = n - i < k->room ? n - i : k->room;
    for (size_t p = 0; p < now; p++) ylm__grid_asked(u->g, list[i + p], k->position + 3 * p);
    s = baker_ask_few(&u->b, ylm_lights_field(pair), now, k);
    shift_job j = {u->g, k, list + i};
    if (s == YLM_OK) s = ylm_parallel(now, 64, u->source.threads, add_range, &j, NULL, NULL);
  }
  ylm_lights_free(pair);
  return s;
}

/* Every mover, one state after the other: its points that are listed in u->shift. */
static ylm_status shift_all(update *u) {
  grid_dynamic *d = u->d;
  uint32_t *list = ylm_alloc(u->shifts, sizeof *list);
  ylm_status s = list ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < d->movers; i++) {
    mover *m = &d->mover[i];
    size_t first[STATES + 1] = {0}, next[STATES];
    for (size_t k = 0; k < u->shifts; k++) first[m->seen[u->shift[k]] + 1]++;
    for (int k = 0; k < STATES; k++) first[k + 1] += first[k], next[k] = first[k];
    for (size_t k = 0; k < u->shifts; k++) list[next[m->seen[u->shift[k]]]++] = u->shift[k];
    for (int k = 0; s == YLM_OK && k < STATES; k++) {
      size_t n = first[k + 1] - first[k];
      if (k == m->current || n == 0) continue;
      s = shift_points(u, &m->state[k], &m->state[m->current], n, list + first[k]);
      for (size_t p = first[k]; p < first[k + 1]; p++) m->seen[list[p]] = (uint8_t)m->current;
    }
  }
  ylm_free(list);
  shift_job j = {u->g, NULL, u->shift};
  if (s == YLM_OK)
    s = ylm_parallel(u->shifts, 64, u->source.threads, measure_range, &j, NULL, NULL);
  return s;
}

/* -- the octree ---------------------------------------------------------------------------------
 */

/* True if the new octree is the old one: then what continuity added stays. */
static bool same_octree(const update *u) {
  const ylm_grid *g = u->g;
  const uint8_t flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_CROSSED;
  if (g->points != u->old.points || g->cells != g->view.octree_cells) return false;
  for (size_t p = 0; p < u->old.evaluated; p++)
    if (!u->b.used[p]) return false;
  for (size_t i = 0; i < g->cells; i++) {
    const ylm_grid_cell *a = &u->old.cell[i], *b = &g->cell[i];
    if (a->level != b->level || (a->flags & flags) != (b->flags & flags) ||
        memcmp(a->origin, b->origin, sizeof a->origin) != 0 ||
        (!(b->flags & YLM_GRID_LEAF) && a->child != b->child))
      return false;
  }
  return true;
}

/* The old cells again, with the new errors; points that continuity made follow those they are
   made of. */
static ylm_status keep_octree(update *u) {
  ylm_grid *g = u->g;
  for (size_t i = 0; i < g->cells; i++) {
    u->old.cell[i].error = g->cell[i].error;
    u->old.cell[i].residual = g->cell[i].residual;
  }
  ylm_free(g->cell);
  g->cell = u->old.cell;
  g->cells = u->old.cells;
  g->cell_room = u->old.cell_room;
  u->old.cell = NULL;
  g->evaluated = u->old.evaluated;
  for (size_t p = 0; p < g->evaluated; p++)
    if (g->flags[p] & YLM_GRID_POINT_INVALID) u->changed[p] = 1;
  ylm_status s = ylm__grid_fill_invalid(g);
  if (s == YLM_OK) s = ylm__grid_interpolate_points(g, u->changed, u->source.threads);
  ylm__grid_count(g);
  return s;
}

/* Points that are used take the first places, those that come last fill the gaps. */
static ylm_status drop_points(update *u) {
  ylm_grid *g = u->g;
  size_t live = 0, from = g->points;
  uint32_t *place = ylm_alloc(g->points, sizeof *place);
  if (!place) return YLM_ENOMEM;
  for (size_t p = 0; p < g->points; p++) {
    bool was = p < u->old.evaluated, interpolated = !was && p < u->old.points;
    if (interpolated) u->b.used[p] = 0;
    live += u->b.used[p];
    place[p] = (uint32_t)p;
    if (was && !u->b.used[p]) {
      u->stats.removed++;
      lattice_hash_remove(&g->hash, lattice_key(g->lattice + 3 * p));
    }
  }
  u->stats.added = live + u->stats.removed - u->old.evaluated;
  for (size_t to = 0; to < live; to++) {
    if (u->b.used[to]) continue;
    do from--;
    while (!u->b.used[from]);
    place[from] = (uint32_t)to;
    ylm__dynamic_move(g, (uint32_t)from, (uint32_t)to);
    *lattice_hash_at(&g->hash, lattice_key(g->lattice + 3 * to)) = (uint32_t)to;
  }
  for (size_t i = 0; i < g->cells; i++)
    for (int k = 0; k < 8; k++)
      if (g->cell[i].corner[k] != YLM_GRID_NONE) g->cell[i].corner[k] = place[g->cell[i].corner[k]];
  g->points = g->evaluated = live;
  ylm_free(place);
  return YLM_OK;
}

/* When memory runs out where nothing can be taken back: the root voxel alone, which needs none. */
static void collapse(ylm_grid *g) {
  ylm_grid_cell *c = &g->cell[0];
  g->cells = g->view.octree_cells = 1;
  g->points = g->evaluated;
  c->child = c->source = 0;
  c->detail = 0;
  c->flags = YLM_GRID_LEAF | YLM_GRID_OCCUPIED | YLM_GRID_BAKED;
  for (int a = 0; a < 3; a++) g->top[a] = 1;
  g->top_shift = g->view.form.depth;
  g->table[0] = 0;
  ylm__grid_count(g);
}

/* New cells from the root; points that exist are found by the hash. */
static ylm_status refine(update *u) {
  ylm_grid *g = u->g;
  baker *b = &u->b;
  b->used_room = g->point_room;
  b->used = ylm_alloc_zero(b->used_room, 1);
  if (!b->used) return YLM_ENOMEM;
  b->before = u->old.cell = g->cell;
  b->changed = u->changed;
  b->unsettled = u->boxes;
  b->unsettleds = 2 * u->changes;
  g->cell = NULL;
  g->cells = g->cell_room = 0;
  g->evaluated = g->points; /* new ones come behind interpolated ones, which go later */
  for (size_t p = 0; p < u->old.evaluated; p++) g->flags[p] |= YLM_GRID_POINT_TESTED;
  ylm_status s = baker_root(b);
  if (s != YLM_OK) return s;
  return g->view.form.tolerance > 0 ? ylm__grid_update_tolerance(b, u->changed, u->old.points)
                                    : baker_refine_threshold(b);
}

static ylm_status update_octree(update *u) {
  ylm_status s = refine(u);
  if (s != YLM_OK) return s;
  if (same_octree(u)) return keep_octree(u);
  s = drop_points(u);
  if (s != YLM_OK) return s;
  ylm_free(u->old.cell);
  u->old.cell = NULL;
  u->over = true;
  s = baker_finish(&u->b, true);
  if (s != YLM_OK) collapse(u->g);
  return s;
}

static ylm_status update_uniform(update *u) {
  ylm_grid *g = u->g;
  ylm_status s = ylm__grid_fill_invalid(g);
  for (size_t i = 0; s == YLM_OK && i < g->cells; i++)
    g->cell[i].error = baker_metric(&u->b, &g->cell[i], g->view.form.metric);
  ylm__grid_count(g);
  return s;
}

/* -- all together ---------------------------------------------------------------------------------
 */

/* Bakes everything anew; the grid changes places with the new one. */
static ylm_status rebake(update *u) {
  ylm_grid *g = u->g, *fresh;
  ylm_grid_form form = g->view.form;
  ylm_status s = ylm_grid_bake(&form, &u->source, &fresh, u->b.e);
  if (s != YLM_OK) return s;
  ylm_grid swap = *g;
  *g = *fresh;
  *fresh = swap;
  g->field.self = g;
  fresh->field.self = fresh;
  g->updating = true;
  ylm__grid_sync(g);
  ylm_grid_free(fresh);
  u->stats.rebaked = true;
  u->stats.points = u->stats.exact = g->stats.points;
  u->stats.pairs = g->stats.pairs;
  u->stats.field_seconds = g->stats.field_seconds;
  u->stats.verified = g->stats.verified;
  u->stats.error = g->stats.error;
  u->stats.met = g->stats.met;
  return YLM_OK;
}

/* The new lights are the grid's. */
static void commit(update *u, int32_t *of) {
  grid_dynamic *d = u->d;
  ylm_free(d->lamp);
  ylm_free(d->mover_of);
  d->lamp = u->now;
  d->mover_of = of;
  d->lamps = u->lamps;
  u->now = NULL;
}

static ylm_status follow(update *u) {
  ylm_grid *g = u->g;
  ylm_status s = remember(u);
  int32_t *of = s == YLM_OK ? ylm_alloc(u->lamps, sizeof *of) : NULL;
  if (!of) return YLM_ENOMEM;
  s = enter_changes(u, of);
  if (s == YLM_OK) s = choose_points(u);
  if (s == YLM_OK) s = log_rows(u);
  if (s == YLM_OK) s = baker_evaluate_list(&u->b, u->exacts, u->exact);
  if (s == YLM_OK) s = shift_all(u);
  u->stats.exact = u->exacts;
  u->stats.points = u->exacts + u->shifts;
  double begin = ylm_seconds(), field = g->stats.field_seconds;
  if (s == YLM_OK) s = g->view.form.kind == YLM_GRID_UNIFORM ? update_uniform(u) : update_octree(u);
  u->stats.tree_seconds = ylm_seconds() - begin - (g->stats.field_seconds - field);
  if (s != YLM_OK && !u->over) {
    restore(u);
    ylm_free(of);
    return s;
  }
  commit(u, of);
  retire(u->d, g->evaluated);
  ylm__dynamic_sign_all(g, u->source.threads);
  ylm__grid_sync(g);
  return s;
}

static ylm_status run(update *u) {
  ylm_status s = ylm__lamps_match(u->d, u->lamps, u->now, u->origin, &u->change, &u->changes);
  if (s != YLM_OK) return s;
  u->stats.lights = u->changes;
  if (!u->changes) return YLM_OK;
  s = ylm_report(u->source.progress, 0, 1, "updating");
  if (s != YLM_OK) return s;
  if (u->changes > MOST_CHANGES || (u->changes > 4 && 2 * u->changes > u->d->lamps))
    return rebake(u);
  return follow(u);
}

ylm_status ylm_grid_update(ylm_grid *g, const ylm_grid_change *change, ylm_error *e) {
  double begin = ylm_seconds();
  if (!g->dynamic)
    return ylm_fail(e, YLM_EINVAL,
                    "the grid was not made with dynamic = true, it cannot be updated");
  if (isnan(change->tolerance) || isinf(change->tolerance))
    return ylm_fail(e, YLM_EDOMAIN, "tolerance: a number, got %g", change->tolerance);
  ylm_grid_stats before = g->stats;
  update u = {
      .g = g, .d = g->dynamic, .source = g->dynamic->source, .tolerance = change->tolerance};
  if (u.tolerance < 0)
    u.tolerance = g->view.form.tolerance > 0 ? g->view.form.tolerance / 8 : DEFAULT_TOLERANCE;
  u.source.lights = change->lights;
  u.source.field = change->field ? change->field : ylm_lights_field(change->lights);
  u.source.threads = change->threads;
  u.source.progress = change->progress;
  u.b =
      (baker){.g = g, .source = &u.source, .e = e, .occupied = u.d->occupied, .stage = "updating"};
  u.stats =
      (ylm_grid_update_stats){.updates = before.update.updates + 1, .error = NAN, .met = true};
  u.lamps = ylm_lights_count(change->lights);
  u.now = ylm__lamps(change->lights);
  u.origin = ylm_alloc(u.lamps, sizeof *u.origin);
  g->updating = true;
  g->stats.update = u.stats; /* its number is used by refinement */
  if (u.d->forced.used > MOST_FORCED) lattice_hash_free(&u.d->forced);
  g->stats.pairs = 0;
  g->stats.field_seconds = 0;
  ylm_status s = u.now && u.origin ? run(&u) : YLM_ENOMEM;
  if (!u.stats.rebaked) {
    u.stats.pairs = g->stats.pairs;
    u.stats.field_seconds = g->stats.field_seconds;
    u.stats.verified = g->stats.update.verified;
    if (u.stats.verified) u.stats.error = g->stats.update.error, u.stats.met = g->stats.update.met;
    g->stats.pairs = before.pairs;
    g->stats.field_seconds = before.field_seconds;
    g->stats.verify_seconds = before.verify_seconds;
  }
  g->updating = false;
  forget(&u);
  u.stats.seconds = ylm_seconds() - begin;
  g->stats.update = s == YLM_OK ? u.stats : before.update;
  return s == YLM_OK ? s : ylm__grid_no_room(s, &u.source, e);
}

bool ylm_grid_updating(const ylm_grid *g) { return g->updating; }
