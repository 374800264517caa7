/*
** few.c - a grid in bricks in few bytes: a folder whose bricks are read one by one.
**
** Parts, which are the bricks and the top, are rounded by one step. The step is searched on a few of them, and then looked at on
** all. Points that parts share are coded by what all of these know (small.h), so that they are the same bits in each.
*/
#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "../small/small.h"
#include "set.h"
#include "ylm_list.h"

#define PLACES 16384    /* that rounding is looked at, in all parts */
#define LEAST_PLACES 64 /* of a part */
#define SEARCHED 6      /* parts, at most, that the step is searched on */
#define SEARCH_ALL 12   /* so many parts are all searched on */
#define SEARCH_TRIES 5
#define NEAR 0.93 /* of what is asked for */
#define PASSES 4  /* over all parts, at most */

typedef struct few {
  ylm_grid_set *set;
  const ylm_grid_small *how;
  const char *folder; /* NULL: nothing is written */
  ylm_error *e;
  index_head head;
  index_entry *entry;
  small_common common;
  uint64_t points;     /* of all parts, shared ones in each */
  size_t parts, apart; /* every apart-th part is looked at */
  double *error;       /* [room] of rounding, of the parts at hand */
  size_t errors, room;
  uint64_t bytes, looked_at; /* of the parts at hand: of files, of points */
  ylm_grid_small_report report;
  uint64_t done, total; /* parts that were rounded, and all that may have to be */
} few;

/* -- parts ------------------------------------------------------------------------------------------------ */

static void path_of(const few *w, const char *folder, size_t part, char path[FOLDER_PATH]) {
  if (part == w->set->bricks)
    ylm__folder_file(folder, "top.ylm", path);
  else
    ylm__folder_brick(folder, w->set->brick[part].code, "ylm", path);
}

/* The level of the finest cells of the top, bricks among them. */
static uint32_t finest_of(const ylm_grid *top) {
  uint32_t finest = 0;
  for (size_t i = 0; i < top->contents.octree_cells; i++)
    if (top->cell[i].level > finest) finest = top->cell[i].level;
  return finest;
}

static ylm_status get(few *w, size_t part, const ylm_grid **g) {
  return ylm__set_get(w->set, part, w->how->threads, g, w->e);
}

/* Sizes of the light of all parts. */
static ylm_status survey(few *w) {
  small_norms *n = ylm_alloc_zero(1, sizeof *n);
  ylm_status s = n ? YLM_OK : ylm_no_memory_for(w->e, w->set->folder);
  for (size_t i = 0; s == YLM_OK && i < w->parts; i++) {
    const ylm_grid *g;
    s = ylm__set_report(w->set, w->how->progress, w->done++, w->total, "rounding");
    if (s == YLM_OK) s = get(w, i, &g);
    if (s == YLM_OK) s = ylm__grid_file_check_small(g, w->head.stats.error, w->how, w->e);
    if (s == YLM_OK) ylm__small_count_norms(g, n);
  }
  if (s == YLM_OK) {
    w->points = n->points;
    w->common = ylm__small_common_of(n, &w->set->top->contents.form);
    w->common.finest = finest_of(w->set->top);
    w->common.points = (size_t)(n->points / w->parts);
  }
  ylm_free(n);
  return s;
}

/* All parts turn coefficients as the largest brick does. */
static ylm_status learn(few *w, double step) {
  const ylm_grid *g;
  size_t largest = 0;
  for (size_t i = 1; i < w->set->bricks; i++)
    if (w->entry[i].evaluated > w->entry[largest].evaluated) largest = i;
  ylm_status s = get(w, largest, &g); /* of no bricks the top */
  if (s == YLM_OK) s = ylm__small_learn_common(g, (float)step, &w->common);
  return s == YLM_ENOMEM ? ylm_no_memory_for(w->e, w->set->folder) : s;
}

/* The report of n errors of rounding, which are sorted. */
static ylm_grid_small_report report_of(const few *w, const double *error, size_t n, double step) {
  double before = w->head.stats.error;
  return (ylm_grid_small_report){.before = before,
                                 .rounding = ylm__small_quantile(error, n, 0.99),
                                 .largest = error[n - 1],
                                 .middle = ylm__small_quantile(error, n, 0.5),
                                 .places = n,
                                 .confidence = before >= 0 ? 0.99 : 0,
                                 .step = step,
                                 .error = before + error[n - 1]};
}

/* Errors of a part that is rounded: its report. */
static ylm_status look_at(few *w, small_encoder *k, const ylm_grid *from) {
  size_t n = (size_t)(PLACES * ((double)from->evaluated / (double)w->points));
  if (n < LEAST_PLACES) n = LEAST_PLACES;
  if (!ylm_list_reserve(&w->error, w->errors, w->errors + n, &w->room, sizeof *w->error))
    return YLM_ENOMEM;
  double *error = w->error + w->errors;
  ylm_status s = ylm__small_roundings(k, from, w->how->threads, n, error, w->e);
  if (s != YLM_OK) return s;
  small_packed *p = ylm__small_packed_of(k);
  p->report = report_of(w, error, n, (double)p->head.step);
  w->errors += n;
  return YLM_OK;
}

/* The file of a part that is rounded. */
static ylm_status write_part(few *w, small_encoder *k, size_t part) {
  unsigned char *data;
  size_t size;
  char path[FOLDER_PATH];
  small_packed *p = ylm__small_packed_of(k);
  ylm__grid_file_describe_small(ylm__small_grid_of(k), w->how, &p->report);
  ylm_status s = ylm__grid_file_encode(ylm__small_grid_of(k), p, &data, &size, w->e);
  if (s != YLM_OK) return s;
  path_of(w, w->folder, part, path);
  s = ylm_file_save(path, data, size, w->e);
  ylm_free(data);
  if (s == YLM_OK) ylm__folder_sync(path);
  if (s == YLM_OK && part < w->set->bricks) w->entry[part].size = size;
  return s;
}

/* All parts' errors become the report of the whole. */
static void sum_up(few *w, double step) {
  ylm__small_sort(w->error, w->errors);
  w->report = report_of(w, w->error, w->errors, step);
}

static ylm_status round_part(few *w, size_t part, double step) {
  const ylm_grid *g;
  small_encoder *k = NULL;
  ylm_status s = ylm__set_report(w->set, w->how->progress, w->done++, w->total, "rounding");
  if (s == YLM_OK) s = get(w, part, &g);
  if (s != YLM_OK) return s;
  s = ylm__small_encoder(g, &w->common, w->how->threads, &k);
  if (s == YLM_OK) s = ylm__small_round(k, (float)step, NULL, NULL);
  if (s == YLM_OK) s = look_at(w, k, g);
  if (s == YLM_OK) {
    w->bytes += ylm__grid_file_small_size(ylm__small_grid_of(k), ylm__small_packed_of(k));
    w->looked_at += g->evaluated;
  }
  /* The top is last: its report is that of all. */
  if (s == YLM_OK && part == w->set->bricks) {
    sum_up(w, step);
    ylm__small_packed_of(k)->report = w->report;
  }
  if (s == YLM_OK && w->folder) s = write_part(w, k, part);
  ylm__small_encoder_free(k);
  if (s == YLM_ENOMEM) ylm_no_memory_for(w->e, w->set->folder);
  return s;
}

/* Rounds every apart-th part, and the top: the error of all, or their bytes. */
static ylm_status round_parts(void *self, double step, double *found) {
  few *w = self;
  ylm_status s = w->common.entry ? YLM_OK : learn(w, step);
  w->errors = 0;
  w->bytes = w->looked_at = 0;
  for (size_t i = 0; s == YLM_OK && i < w->set->bricks; i += w->apart) s = round_part(w, i, step);
  if (s == YLM_OK) s = round_part(w, w->set->bricks, step);
  if (s != YLM_OK) return s;
  double error = isnan(w->report.error) ? w->report.largest : w->report.error;
  size_t index = sizeof w->head + w->set->bricks * sizeof *w->entry;
  *found = w->how->bytes
               ? (double)w->bytes / (double)w->looked_at * (double)w->points + (double)index
               : error;
  return YLM_OK;
}

/* -- the step ----------------------------------------------------------------------------------------------- */

static ylm_status not_to_be_had(const few *w, double found) {
  if (w->how->bytes)
    return ylm_fail(
        w->e, YLM_ELIMIT,
        "bytes: these bricks take %.0f at the coarsest step of rounding that was tried, "
        "and %llu are asked for",
        found, (unsigned long long)w->how->bytes);
  return ylm_fail(w->e, YLM_ELIMIT,
                  "tolerance: the grid errs by %.3g before any rounding, %g is asked for in all: "
                  "bake it to a smaller tolerance, or save it to a larger one",
                  w->head.stats.error, w->how->tolerance);
}

/* Rounds and writes all parts; by other steps, where the first is not what is asked for, or far below. */
static ylm_status write_all(few *w, const small_hunt *h, double step, const char *folder) {
  double found = 0, good = 0, wanted = w->how->bytes ? (double)w->how->bytes : w->how->tolerance;
  bool searched = w->apart > 1;
  if (searched && w->how->tolerance > 0) step *= 0.97; /* more places than were searched on */
  w->apart = 1;
  w->folder = folder;
  for (int i = 0; i < PASSES; i++) {
    ylm_status s = round_parts(w, step, &found);
    if (s != YLM_OK || w->how->step > 0) return s;
    if (found <= wanted && (found > NEAR * wanted || good > 0 || !searched)) return s;
    double next = ylm__small_next_step(h, step, found);
    if (found <= wanted) good = step;
    if (found > wanted)
      next = w->how->bytes ? fmin(fmax(next, 1.02 * step), 1) : fmin(next, 0.97 * step);
    step = next;
  }
  return good > 0 ? round_parts(w, good, &found) : not_to_be_had(w, found);
}

static ylm_status search(few *w, const char *folder) {
  double step = w->how->step;
  small_hunt h = {.how = w->how,
                  .before = w->head.stats.error,
                  .width = w->set->top->width,
                  .round = round_parts,
                  .self = w,
                  .tries = w->apart > 1 ? SEARCH_TRIES : 0};
  ylm_status s = step > 0 ? YLM_OK : ylm__small_hunt(&h, &step);
  if (s == YLM_ELIMIT) return not_to_be_had(w, (double)w->bytes);
  return s == YLM_OK ? write_all(w, &h, step, folder) : s;
}

/* The index of the new folder, by that of the old one. */
static ylm_status write_index(few *w, const char *folder) {
  grid_file_stats *t = &w->head.stats;
  double promised = w->set->top->contents.form.tolerance;
  t->error = w->report.error;
  t->met = promised > 0 && !(w->how->tolerance > 0 && t->error > w->how->tolerance);
  return ylm__index_write(folder, &w->head, w->entry, w->e);
}

static bool is_same(const char *a, const char *b) {
  struct stat here, there;
  return stat(a, &here) == 0 && stat(b, &there) == 0 && here.st_dev == there.st_dev &&
         here.st_ino == there.st_ino;
}

ylm_status ylm_grid_set_write_small(ylm_grid_set *set, const char *folder,
                                    const ylm_grid_small *how, uint64_t *bytes,
                                    ylm_grid_small_report *report, ylm_error *e) {
  few w = {.set = set, .how = how, .e = e, .parts = set->bricks + 1};
  ylm_status s = ylm__grid_file_machine(set->folder, e);
  if (s == YLM_OK) s = ylm__index_read(set->folder, &w.head, &w.entry, e);
  if (s != YLM_OK) return s;
  if (is_same(set->folder, folder))
    s = ylm_fail(e, YLM_EINVAL,
                 "%s: its bricks are read while others are written: choose another folder", folder);
  else if (w.head.bricks != set->bricks)
    s = ylm_fail(e, YLM_EFORMAT, "%s: another bake has changed it", set->folder);
  w.apart = set->bricks > SEARCH_ALL ? (set->bricks + SEARCHED - 1) / SEARCHED : 1;
  w.total = 2 * w.parts + SEARCH_TRIES * (set->bricks / w.apart + 1);
  bool begun = false;
  pthread_mutex_lock(&set->lock);
  if (s == YLM_OK) s = survey(&w);
  if (s == YLM_OK) begun = (s = ylm__folder_pack(folder, e)) == YLM_OK;
  if (s == YLM_OK) s = search(&w, folder);
  if (s == YLM_OK) s = write_index(&w, folder);
  pthread_mutex_unlock(&set->lock);
  if (s != YLM_OK && begun) ylm__folder_remove(folder);
  ylm_free(w.entry);
  ylm_free(w.error);
  ylm_free(w.common.entry);
  if (s != YLM_OK) return s;
  *bytes = w.bytes + sizeof w.head + set->bricks * sizeof *w.entry;
  if (report) *report = w.report;
  return YLM_OK;
}

bool ylm_grid_set_small_of(const ylm_grid_set *s, ylm_grid_small_report *report) {
  return ylm_grid_small_of(s->top, report);
}
