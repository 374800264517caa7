/* film.c - batches of samples, run by threads and added up in an order that does not depend on them. */
#include "calibration.h"
#include "path.h"

typedef struct run {
  path_job *job;
  path_tile **tile; /* [threads] */
  double *values;   /* [batches of the round][items][values] */
  uint64_t batch;   /* the first of the round */
  size_t batches;
  size_t groups; /* of items, in tiles */
  size_t width;  /* items in a tile */
  /* progress of all rounds */
  const ylm_progress *outer;
  uint64_t done, total; /* batches */
} run;

/* One tile: items of a group, batches of the round. */
static void run_tile(run *r, path_tile *t, size_t number, double *values) {
  size_t group = number % r->groups, round = number / r->groups * r->job->batches_per_tile;
  size_t begin = group * r->width, values_each = r->job->values;
  size_t end = r->job->items - begin < r->width ? r->job->items : begin + r->width;
  t->pairs = 0;
  for (size_t b = round; b < round + r->job->batches_per_tile && b < r->batches; b++)
    for (size_t i = begin; i < end; i++) {
      t->item[t->pairs] = i;
      t->batch[t->pairs++] = r->batch + b;
    }
  ylm__path_walk(t, values);
  for (size_t k = 0; k < t->pairs; k++)
    memcpy(r->values + ((t->batch[k] - r->batch) * r->job->items + t->item[k]) * values_each,
           values + k * values_each, values_each * sizeof *values);
}

static ylm_status run_tiles(void *context, size_t begin, size_t end, int worker) {
  run *r = context;
  if (!r->tile[worker]) r->tile[worker] = ylm__path_tile_create(r->job);
  double *values = ylm_alloc(PATH_PAIRS * r->job->values, sizeof *values);
  ylm_status s = r->tile[worker] && values ? YLM_OK : YLM_ENOMEM;
  for (size_t i = begin; s == YLM_OK && i < end; i++) run_tile(r, r->tile[worker], i, values);
  ylm_free(values);
  return s;
}

/* Adds one batch: the running mean as two floats, and its variance as one, so that what is saved is
   what is added to. Source: Welford 1962, "Note on a Method for Calculating Corrected Sums of
   Squares and Products". */
static void add(ylm_path_sum *sum, size_t i, double before, double x) {
  double mean = 0, squares = 0, n = before + 1;
  if (before > 0) {
    mean = (double)sum->mean[i] + (double)sum->rest[i];
    squares = (double)sum->variance[i] * before * (before - 1);
  }
  double next = mean + (x - mean) / n;
  squares += (x - mean) * (x - next);
  sum->mean[i] = (float)next;
  sum->rest[i] = (float)(next - (double)sum->mean[i]);
  sum->variance[i] = before > 0 ? (float)(squares / (n * before)) : 0;
}

void ylm_path_add(ylm_path_sum *sum, size_t n, const float *values) {
  double before = (double)(sum->samples / YLM_PATH_BATCH);
  for (size_t i = 0; i < n; i++) add(sum, i, before, (double)values[i]);
  sum->samples += YLM_PATH_BATCH;
}

static void add_round(const run *r, ylm_path_sum *sum) {
  size_t numbers = r->job->items * r->job->values;
  for (size_t b = 0; b < r->batches; b++) {
    double before = (double)(sum->samples / YLM_PATH_BATCH);
    for (size_t i = 0; i < numbers; i++) add(sum, i, before, r->values[b * numbers + i]);
    sum->samples += YLM_PATH_BATCH;
  }
}

static double noise_of(const path_job *j, const ylm_path_sum *sum) {
  double total = 0;
  size_t lit = 0;
  if (sum->samples < 2 * YLM_PATH_BATCH) return -1;
  for (size_t i = 0; i < j->items; i++) {
    double norm = 0, variance = 0;
    for (size_t k = i * j->values; k < (i + 1) * j->values; k++) {
      norm += (double)sum->mean[k] * (double)sum->mean[k];
      variance += (double)sum->variance[k];
    }
    if (!(norm > 0)) continue;
    total += sqrt(variance / norm);
    lit++;
  }
  return lit ? total / (double)lit : 0;
}

static void add_counts(ylm_path_stats *to, const ylm_path_stats *from) {
  to->paths += from->paths;
  to->nearest_rays += from->nearest_rays;
  to->lamp_rays += from->lamp_rays;
  to->shadow_rays += from->shadow_rays;
  to->absorbed += from->absorbed;
  to->lost += from->lost;
}

static void make_room(run *r, uint64_t todo) {
  path_job *j = r->job;
  size_t numbers = j->items * j->values, most = numbers ? ROUND_NUMBERS / numbers : 1;
  r->width = j->items < PATH_PAIRS ? j->items : PATH_PAIRS;
  r->groups = (j->items + PATH_PAIRS - 1) / PATH_PAIRS;
  r->batches = ROUND_TILES / r->groups * j->batches_per_tile;
  if (r->batches > most) r->batches = most;
  if (r->batches < 1) r->batches = 1;
  if (r->batches > todo) r->batches = (size_t)todo;
}

/* Rounds until there are `samples`, or enough. */
static ylm_status run_rounds(run *r, ylm_path_sum *sum, ylm_path_stats *stats) {
  const ylm_path_options *o = r->job->o;
  double start = ylm_seconds();
  size_t most = r->batches;
  stats->end = YLM_PATH_DONE;
  while (r->done < r->total) {
    r->batch = sum->samples / YLM_PATH_BATCH;
    r->batches = r->total - r->done < most ? (size_t)(r->total - r->done) : most;
    size_t tiles = (r->batches + r->job->batches_per_tile - 1) / r->job->batches_per_tile;
    ylm_progress_part part;
    ylm_status s = ylm_parallel(tiles * r->groups, 1, o->threads, run_tiles, r,
                                ylm_progress_part_of(&part, r->outer, NULL, r->done * 1000,
                                                     r->batches * 1000, r->total * 1000),
                                r->job->kind->stage);
    if (s != YLM_OK) return s;
    add_round(r, sum);
    r->done += r->batches;
    if (r->done == r->total || sum->samples < 2 * YLM_PATH_BATCH) continue;
    if (o->seconds > 0 && ylm_seconds() - start >= o->seconds) stats->end = YLM_PATH_LATE;
    if (o->error > 0 && noise_of(r->job, sum) <= o->error) stats->end = YLM_PATH_PRECISE;
    if (stats->end != YLM_PATH_DONE) return ylm_report(r->outer, 1, 1, r->job->kind->stage);
  }
  return YLM_OK;
}

/* Numbers the materials of all meshes, equal ones alike. */
static ylm_status list_materials(path_job *j) {
  size_t meshes = ylm_scene_meshes(j->scene);
  j->material = ylm_alloc(meshes, sizeof *j->material);
  j->material_of = ylm_alloc(meshes, sizeof *j->material_of);
  j->albedo = ylm_alloc(meshes, sizeof *j->albedo);
  j->glosses = ylm_alloc(meshes, sizeof *j->glosses);
  if (!j->material || !j->material_of || !j->albedo || !j->glosses) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++) {
    const ylm_material *m = ylm_scene_material(j->scene, i);
    size_t k = j->materials;
    while (k > 0 && j->material[k - 1] != m) k--;
    if (k == 0) j->material[k = j->materials++] = m, k++;
    j->material_of[i] = (uint32_t)(k - 1);
  }
  for (size_t k = 0; k < j->materials; k++) {
    ylm_material_albedo(j->material[k], j->albedo[k]);
    j->glosses[k] = ylm_material_glosses(j->material[k]) &&
                    ylm_material_excess(j->material[k], GUIDED_COSINE) > GUIDED_EXCESS;
  }
  return YLM_OK;
}

static ylm_status check(const path_job *j, ylm_error *e) {
  const ylm_path_options *o = j->o;
  if (o->samples < 1 || o->samples > YLM_PATH_SAMPLES)
    return ylm_fail(e, YLM_ERANGE, "samples must be from 1 to %d, got %d", YLM_PATH_SAMPLES,
                    o->samples);
  if (o->first < 0 || (o->last >= 0 && o->last < o->first))
    return ylm_fail(e, YLM_ERANGE, "reflections must be first <= last from 0 on, got %d and %d",
                    o->first, o->last);
  if (j->items > UINT32_MAX) return ylm_fail(e, YLM_EOVERFLOW, "more than 2^32 points");
  return YLM_OK;
}

ylm_status ylm__path_run(path_job *j, ylm_path_sum *sum, ylm_path_stats *stats, ylm_error *e) {
  double start = ylm_seconds();
  uint64_t all = ((uint64_t)j->o->samples + YLM_PATH_BATCH - 1) / YLM_PATH_BATCH;
  if (all < 2 && !j->o->single) all = 2; /* one alone has no variance */
  uint64_t have = sum->samples / YLM_PATH_BATCH;
  int threads = ylm_threads(j->o->threads);
  run r = {.job = j, .outer = j->o->progress, .total = all > have ? all - have : 0};
  *stats = (ylm_path_stats){.noise = -1};
  ylm_status s = check(j, e);
  if (s != YLM_OK) return s;
  j->trace = ylm_scene_trace(j->scene);
  for (int i = 0; i < YLM_PATH_BATCH; i++) j->radical[i] = ylm_scene_radical((uint32_t)i);
  if (j->items > 0) {
    make_room(&r, r.total);
    s = list_materials(j);
    if (s == YLM_OK && j->o->guides) s = ylm__path_learn(j, stats);
    r.tile = ylm_alloc_zero((size_t)threads, sizeof *r.tile);
    r.values = ylm_alloc(r.batches * j->items * j->values, sizeof *r.values);
    if (s == YLM_OK && (!r.tile || !r.values)) s = YLM_ENOMEM;
    if (s == YLM_OK) s = run_rounds(&r, sum, stats);
    for (int i = 0; r.tile && i < threads; i++) {
      if (r.tile[i]) add_counts(stats, &r.tile[i]->counts);
      ylm__path_tile_free(r.tile[i]);
    }
    ylm_free(r.tile);
    ylm_free(r.values);
    ylm_free((void *)j->material);
    ylm_free(j->material_of);
    ylm_free(j->albedo);
    ylm_free(j->glosses);
    ylm__path_forget(j);
  }
  stats->noise = noise_of(j, sum);
  stats->seconds = ylm_seconds() - start;
  return s;
}
