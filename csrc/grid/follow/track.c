/*
** track.c - points that stay where they are while a grid changes.
**
** Points are sorted by the Morton code of the finest voxel they lie in, block by block. Each leaf of any octree then holds
** a run of them. A run remembers its leaf and the leaf's signature: while there is such a leaf, its points' fractions are
** good, and while the signature is the same, so are their samples.
*/
#include "follow.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* The points of a block that lie in one leaf. */
typedef struct track_run {
  uint64_t sign;          /* of what has been handed over; 0: nothing */
  uint32_t origin[3];     /* of the leaf */
  uint8_t level, source;  /* of the leaf and of the cell that is interpolated there */
  uint16_t first, points; /* in the block */
  uint16_t moved;         /* points that are not in that cell */
  uint32_t cell;          /* the leaf, this time */
} track_run;
#define VIRTUAL 255 /* source of a leaf without data that is continued while it is sampled */

typedef struct track_block {
  track_run *run;
  size_t runs, room;
  uint32_t outside;
  bool placed;
} track_block;

/* Scratch of a thread. */
typedef struct track_work {
  float *value; /* [BATCH][row], and room for virtual cells */
  track_run *run;
} track_work;

struct ylm_grid_track {
  size_t points, blocks;
  const float *position; /* [points][3] */
  double origin[3];      /* positions are relative to it */
  uint32_t *order;       /* [points] */
  float *t;              /* [blocks][3][YLM_GRID_TRACK] */
  track_block *block;
  uint64_t form; /* of the grid that points are sorted for; 0: they are not */
  ylm_grid_interpolation how;
};

ylm_status ylm_grid_track_create(size_t n, const float *points, const double *origin,
                                 const uint32_t *order, ylm_grid_track **track) {
  *track = NULL;
  if (n >= YLM_GRID_NONE) return YLM_ELIMIT;
  ylm_grid_track *k = ylm_alloc_zero(1, sizeof *k);
  if (!k) return YLM_ENOMEM;
  k->points = n;
  k->position = points;
  if (origin) memcpy(k->origin, origin, sizeof k->origin);
  k->blocks = (n + YLM_GRID_TRACK - 1) / YLM_GRID_TRACK;
  k->order = ylm_alloc(n, sizeof *k->order);
  k->t = ylm_alloc(k->blocks, 3 * YLM_GRID_TRACK * sizeof *k->t);
  k->block = ylm_alloc_zero(k->blocks, sizeof *k->block);
  if (!k->order || !k->t || !k->block) {
    ylm_grid_track_free(k);
    return YLM_ENOMEM;
  }
  for (size_t i = 0; i < n; i++) k->order[i] = order ? order[i] : (uint32_t)i;
  *track = k;
  return YLM_OK;
}

void ylm_grid_track_free(ylm_grid_track *k) {
  if (!k) return;
  for (size_t i = 0; k->block && i < k->blocks; i++) ylm_free(k->block[i].run);
  ylm_free(k->block);
  ylm_free(k->order);
  ylm_free(k->t);
  ylm_free(k);
}

/* Nothing has been handed over, or not where points lie either. */
static void forget(ylm_grid_track *k, bool places) {
  for (size_t i = 0; i < k->blocks; i++) {
    track_block *b = &k->block[i];
    if (places) b->placed = false, b->runs = 0;
    for (size_t r = 0; r < b->runs; r++) b->run[r].sign = 0;
  }
}

typedef struct track_job {
  ylm_grid_track *track;
  const ylm_grid *g;
  sample_kernel *kernel;
  const ylm_grid_taker *taker;
  track_work *work; /* of each thread */
  size_t row;
  atomic_uint_fast64_t outside, unbaked, fresh;
} track_job;

/* -- where points lie -------------------------------------------------------------------------- */

static void position_of(const ylm_grid_track *k, uint32_t point, double p[3]) {
  for (size_t a = 0; a < 3; a++) p[a] = (double)k->position[3 * (size_t)point + a] + k->origin[a];
}

static void coordinates(const track_job *j, uint32_t point, double at[3], bool *inside) {
  double p[3];
  position_of(j->track, point, p);
  *inside = ylm__grid_coordinates(j->g, p, at);
}

typedef struct coded {
  uint64_t code;
  uint32_t point;
} coded;

static int by_code(const void *a, const void *b) {
  const coded *x = a, *y = b;
  if (x->code != y->code) return x->code < y->code ? -1 : 1;
  return x->point < y->point ? -1 : x->point > y->point;
}

/* Sorts the points of a block. */
static ylm_status sort_block(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const track_job *j = context;
  uint32_t *order = j->track->order + begin, voxel[3];
  coded c[YLM_GRID_TRACK];
  for (size_t i = 0; i < end - begin; i++) {
    double p[3];
    position_of(j->track, order[i], p);
    ylm_grid_voxel(j->g, p, voxel);
    c[i] = (coded){ylm_morton(voxel[0], voxel[1], voxel[2]), order[i]};
  }
  qsort(c, end - begin, sizeof *c, by_code);
  for (size_t i = 0; i < end - begin; i++) order[i] = c[i].point;
  return YLM_OK;
}

/* A new run at the leaf `found`. */
static track_run new_run(const ylm_grid *g, uint32_t found, size_t first) {
  const ylm_grid_cell *leaf = &g->cell[found];
  track_run r = {.level = leaf->level,
                 .source = leaf->detail ? VIRTUAL : g->cell[leaf->source].level,
                 .first = (uint16_t)first,
                 .cell = found};
  memcpy(r.origin, leaf->origin, sizeof r.origin);
  return r;
}

/* Finds the runs of a block into `run`, which has room for all its points. Runs whose signature
   is unchanged keep it: it belongs to a place, so it was that of the same points. */
static size_t find_runs(const track_job *j, size_t begin, size_t n, track_block *b,
                        track_run *run) {
  const ylm_grid *g = j->g;
  float *t = j->track->t + 3 * begin;
  size_t runs = 0, old = 0;
  leaf_cursor cursor = {.leaf = YLM_GRID_NONE};
  uint32_t last = YLM_GRID_NONE;
  b->outside = 0;
  for (size_t i = 0; i < n; i++) {
    double at[3];
    float x[3];
    bool inside;
    coordinates(j, j->track->order[begin + i], at, &inside);
    b->outside += !inside;
    uint32_t found = ylm__grid_leaf_again(g, &cursor, at);
    if (found != last) {
      run[runs++] = new_run(g, found, i);
      while (old < b->runs && (size_t)b->run[old].first + b->run[old].points <= i) old++;
      if (old < b->runs && b->run[old].sign == g->dynamic->cell_sign[found])
        run[runs - 1].sign = b->run[old].sign;
      last = found;
    }
    const ylm_grid_cell *leaf = &g->cell[found];
    run[runs - 1].points++;
    run[runs - 1].moved +=
        ylm__grid_fractions(g, leaf->detail ? leaf : &g->cell[leaf->source], at, x);
    for (size_t a = 0; a < 3; a++) t[a * YLM_GRID_TRACK + i] = x[a];
  }
  return runs;
}

static ylm_status place_block(const track_job *j, size_t begin, size_t n, track_block *b,
                              track_run *room) {
  size_t runs = find_runs(j, begin, n, b, room);
  if (runs > b->room) {
    track_run *more = ylm_alloc(runs + runs / 4, sizeof *more);
    if (!more) return YLM_ENOMEM;
    ylm_free(b->run);
    b->run = more;
    b->room = runs + runs / 4;
  }
  memcpy(b->run, room, runs * sizeof *room);
  b->runs = runs;
  b->placed = true;
  return YLM_OK;
}

/* Finds the leaves of all runs; false if one is gone. */
static bool still_placed(const ylm_grid *g, track_block *b) {
  for (size_t r = 0; b->placed && r < b->runs; r++) {
    track_run *run = &b->run[r];
    run->cell = ylm__grid_finest(g, run->origin);
    const ylm_grid_cell *leaf = &g->cell[run->cell];
    uint8_t source = leaf->detail ? VIRTUAL : g->cell[leaf->source].level;
    if (leaf->level != run->level || source != run->source) return false;
  }
  return b->placed;
}

/* -- samples ----------------------------------------------------------------------------------- */

/* Samples the points of a run. */
static void sample_run(const track_job *j, const track_work *w, size_t begin, const track_run *r) {
  const ylm_grid *g = j->g;
  const ylm_grid_cell *leaf = &g->cell[r->cell];
  const uint32_t *point = j->track->order + begin + r->first;
  const float *t = j->track->t + 3 * begin + r->first;
  sample_batch b = {.width = (int)g->width, .interpolation = j->track->how};
  for (size_t i = 0; i < BATCH; i++) b.value[i] = w->value + i * j->row;
  if (!leaf->detail) ylm__grid_set_cell(g, &g->cell[leaf->source], &b);
  size_t most = leaf->detail ? 1 : BATCH;
  for (size_t i = 0; i < r->points; i += most) {
    size_t n = r->points - i < most ? r->points - i : most;
    if (leaf->detail)
      ylm__grid_set_virtual(g, r->cell,
                            (float[3]){t[i], t[YLM_GRID_TRACK + i], t[2 * YLM_GRID_TRACK + i]},
                            w->value + BATCH * j->row, &b);
    else
      for (size_t a = 0; a < 3; a++) memcpy(b.t[a], t + a * YLM_GRID_TRACK + i, n * sizeof *t);
    b.points = (int)n;
    if (j->taker->announce) j->taker->announce(j->taker->user, n, point + i);
    j->kernel(&b);
    j->taker->take(j->taker->user, n, point + i, j->row, w->value);
  }
}

/* Asks for the corners of the cell that the run after this one is interpolated in. */
static void fetch_next(const ylm_grid *g, const track_block *b, size_t next) {
  if (next >= b->runs || g->dynamic->cell_sign[b->run[next].cell] == b->run[next].sign) return;
  ylm__grid_fetch(g, &g->cell[g->cell[b->run[next].cell].source]);
}

static ylm_status run_block(void *context, size_t begin, size_t end, int worker) {
  track_job *j = context;
  const ylm_grid *g = j->g;
  track_block *b = &j->track->block[begin / YLM_GRID_TRACK];
  uint64_t fresh = 0, unbaked = 0;
  if (!still_placed(g, b)) {
    ylm_status s = place_block(j, begin, end - begin, b, j->work[worker].run);
    if (s != YLM_OK) return s;
  }
  for (size_t i = 0; i < b->runs; i++) {
    track_run *r = &b->run[i];
    bool baked = g->cell[r->cell].flags & (YLM_GRID_BAKED | YLM_GRID_ADDED);
    unbaked += baked ? r->moved : r->points;
    uint64_t sign = g->dynamic->cell_sign[r->cell];
    if (sign && sign == r->sign) continue;
    fetch_next(g, b, i + 1);
    sample_run(j, &j->work[worker], begin, r);
    r->sign = sign;
    fresh += r->points;
  }
  atomic_fetch_add_explicit(&j->outside, b->outside, memory_order_relaxed);
  atomic_fetch_add_explicit(&j->unbaked, unbaked, memory_order_relaxed);
  atomic_fetch_add_explicit(&j->fresh, fresh, memory_order_relaxed);
  return YLM_OK;
}

/* -- all together ------------------------------------------------------------------------------ */

static void free_work(track_job *j, int threads) {
  for (int i = 0; j->work && i < threads; i++) {
    ylm_free(j->work[i].value);
    ylm_free(j->work[i].run);
  }
  ylm_free(j->work);
}

static ylm_status make_work(track_job *j, int threads) {
  j->work = ylm_alloc_zero((size_t)threads, sizeof *j->work);
  bool ok = j->work;
  for (int i = 0; ok && i < threads; i++) {
    track_work *w = &j->work[i];
    w->value =
        ylm_alloc(BATCH * j->row + VIRTUAL_ROWS * j->g->stride + 2 * ROW_PADDING, sizeof *w->value);
    w->run = ylm_alloc(YLM_GRID_TRACK, sizeof *w->run);
    ok = w->value && w->run;
  }
  return ok ? YLM_OK : YLM_ENOMEM;
}

ylm_status ylm_grid_track_sample(ylm_grid_track *k, const ylm_grid *g, ylm_grid_interpolation how,
                                 int threads, const ylm_progress *progress,
                                 const ylm_grid_taker *taker, uint64_t *fresh,
                                 ylm_grid_report *report) {
  double start = ylm_seconds();
  *fresh = 0;
  if (!g->dynamic || !g->dynamic->is_signed) {
    forget(k, false);
    return YLM_EINVAL;
  }
  threads = ylm_threads(threads);
  track_job j = {.track = k,
                 .g = g,
                 .kernel = ylm__grid_kernel(),
                 .taker = taker,
                 .row = (g->width + 15) / 16 * 16};
  if (k->form != g->dynamic->form_sign) {
    forget(k, true);
    k->form = g->dynamic->form_sign;
    ylm_parallel(k->points, YLM_GRID_TRACK, threads, sort_block, &j, NULL, NULL);
  }
  if (k->how != how) forget(k, false);
  k->how = how;
  ylm_status s = make_work(&j, threads);
  if (s == YLM_OK)
    s = ylm_parallel(k->points, YLM_GRID_TRACK, threads, run_block, &j, progress, "shading");
  free_work(&j, threads);
  *fresh = j.fresh;
  if (report) *report = (ylm_grid_report){j.outside, j.unbaked, ylm_seconds() - start};
  return s;
}
