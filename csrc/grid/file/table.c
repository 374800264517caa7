/* table.c - header and table of a grid file, and its sections one by one. */
#include "file.h"

#include <string.h>

static ylm_status damaged(const file_source *s, const char *where, ylm_error *e) {
  return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged (%s)", s->name, where);
}

/* -- the table --------------------------------------------------------------------------------- */

/* A name of small letters, digits, '.', '_' and '-', and zeros behind it. */
static bool name_holds(const grid_file_entry *entry) {
  size_t n = strnlen(entry->name, sizeof entry->name);
  if (!n || n == sizeof entry->name) return false;
  if (strspn(entry->name, "abcdefghijklmnopqrstuvwxyz0123456789._-") != n) return false;
  for (size_t i = n; i < sizeof entry->name; i++)
    if (entry->name[i]) return false;
  return true;
}

/* Bytes from `at` to `end` are zero. */
static ylm_status check_gap(const file_source *s, uint64_t at, uint64_t end, ylm_error *e) {
  unsigned char some[4096];
  while (at < end) {
    size_t n = end - at < sizeof some ? (size_t)(end - at) : sizeof some;
    ylm_status status = ylm__file_source_read(s, at, n, some, NULL, NULL, e);
    if (status != YLM_OK) return status;
    for (size_t i = 0; i < n; i++)
      if (some[i]) return damaged(s, "between sections", e);
    at += n;
  }
  return YLM_OK;
}

/* Sections have names, follow one another without overlap, and end where the file ends. */
static ylm_status check_table(const file_table *t, const file_source *s, ylm_error *e) {
  uint64_t end = sizeof(grid_file_header) + t->sections * sizeof *t->entry;
  for (size_t i = 0; i < t->sections; i++) {
    const grid_file_entry *entry = &t->entry[i];
    if (!name_holds(entry)) return ylm__grid_file_bad(s->name, "the name of a section", e);
    for (size_t k = 0; k < i; k++)
      if (memcmp(entry->name, t->entry[k].name, sizeof entry->name) == 0)
        return ylm__grid_file_bad(s->name, "two sections of one name", e);
    if (entry->offset % GRID_FILE_BOUND || entry->offset < end || entry->offset > s->size ||
        entry->size > s->size - entry->offset)
      return ylm__grid_file_bad(s->name, "the place of a section", e);
    ylm_status status = check_gap(s, end, entry->offset, e);
    if (status != YLM_OK) return status;
    end = entry->offset + entry->size;
  }
  return end == s->size ? YLM_OK : ylm__grid_file_bad(s->name, "its length", e);
}

/* Refuses a file with a section that its reader must know and does not. */
static ylm_status check_required(const file_table *t, const file_source *s, ylm_error *e) {
  for (size_t i = 0; i < t->sections; i++)
    if (t->entry[i].flags & GRID_FILE_REQUIRED &&
        ylm__file_table_kind(&t->entry[i]) == GRID_FILE_COUNT)
      return ylm_fail(
          e, YLM_EVERSION,
          "%s: the grid needs its section '%s', which this version of ylm does not know", s->name,
          t->entry[i].name);
  return YLM_OK;
}

ylm_status ylm__file_table_read(file_table *t, const file_source *s, ylm_error *e) {
  grid_file_header h;
  *t = (file_table){0};
  ylm_status status = ylm__grid_file_machine(s->name, e);
  if (status != YLM_OK) return status;
  if (s->size < sizeof h) return damaged(s, "cut off", e);
  status = ylm__file_source_read(s, 0, sizeof h, &h, NULL, NULL, e);
  if (status != YLM_OK) return status;
  if (!h.sections || h.sections > GRID_FILE_SECTIONS ||
      h.sections > (s->size - sizeof h) / sizeof *t->entry)
    return damaged(s, "number of sections", e);
  t->entry = ylm_alloc(h.sections, sizeof *t->entry);
  if (!t->entry) return ylm_no_memory_for(e, s->name);
  t->sections = h.sections;
  uint64_t crc = ylm_crc64(0, &h, offsetof(grid_file_header, crc));
  status =
      ylm__file_source_read(s, sizeof h, t->sections * sizeof *t->entry, t->entry, &crc, NULL, e);
  if (status == YLM_OK && crc != h.crc) status = damaged(s, "header", e);
  return status == YLM_OK ? check_table(t, s, e) : status;
}

int ylm__file_table_kind(const grid_file_entry *entry) {
  static const char *const names[] = {
#define X(name, record, required) #name,
      GRID_FILE_LIST(X)
#undef X
  };
  int kind = 0;
  while (kind < GRID_FILE_COUNT && strcmp(names[kind], entry->name) != 0) kind++;
  return kind;
}

const grid_file_entry *ylm__file_table_find(const file_table *t, int kind) {
  for (size_t i = 0; i < t->sections; i++)
    if (ylm__file_table_kind(&t->entry[i]) == kind) return &t->entry[i];
  return NULL;
}

/* -- sections --------------------------------------------------------------------------------- */

static ylm_status take(const file_table *t, const file_source *s, int kind, size_t record,
                       size_t bytes, void *to, bool *finite, ylm_error *e) {
  const grid_file_entry *entry = ylm__file_table_find(t, kind);
  if (!entry) return ylm__grid_file_bad(s->name, "a section is missing", e);
  uint64_t crc = 0;
  if (entry->record != record || entry->size != bytes)
    return ylm_fail(e, YLM_EFORMAT, "%s: not a valid grid: the size of section '%s'", s->name,
                    entry->name);
  ylm_status status = ylm__file_source_read(s, entry->offset, bytes, to, &crc, finite, e);
  if (status == YLM_OK && crc != entry->crc)
    return ylm_fail(e, YLM_ECHECKSUM, "%s: the grid file is damaged (section '%s')", s->name,
                    entry->name);
  return status;
}

ylm_status ylm__file_table_take(const file_table *t, const file_source *s, int kind, size_t record,
                                size_t bytes, void *to, ylm_error *e) {
  return take(t, s, kind, record, bytes, to, NULL, e);
}

ylm_status ylm__file_table_take_floats(const file_table *t, const file_source *s, int kind,
                                       size_t record, size_t bytes, float *to, bool *finite,
                                       ylm_error *e) {
  *finite = true;
  return take(t, s, kind, record, bytes, to, finite, e);
}

/* The form that a section describes. */
static ylm_grid_form form_of(const grid_file_form *f) {
  ylm_grid_form out = {.kind = (ylm_grid_kind)f->kind,
                       .lmax = (int)f->lmax,
                       .channels = (int)f->channels,
                       .metric_channels = (int)f->metric_channels,
                       .depth = (int)f->depth,
                       .metric = (ylm_grid_metric)f->metric,
                       .threshold = f->threshold,
                       .tolerance = f->tolerance,
                       .continuous = f->continuous != 0};
  memcpy(out.cells, f->lattice, sizeof out.cells);
  memcpy(out.bounds, f->bounds, sizeof out.bounds);
  return out;
}

/* The stats that sections describe. */
static ylm_grid_stats stats_of(const grid_file_form *f, const grid_file_stats *t) {
  ylm_grid_stats out = {
      .points = f->evaluated, .interpolated = f->points - f->evaluated, .cells = f->octree_cells};
#define X(type, name) out.name = t->name;
  GRID_FILE_STATS(X)
#undef X
  ylm__grid_file_forget_times(&out);
  return out;
}

/* Fingerprints: some, of parts that there are. */
static ylm_status take_prints(const file_table *t, const file_source *s, ylm_grid_prints *out,
                              ylm_error *e) {
  if (!ylm__file_table_find(t, GRID_FILE_prints)) return YLM_OK;
  ylm_status status =
      ylm__file_table_take(t, s, GRID_FILE_prints, sizeof *out, sizeof *out, out, e);
  if (status == YLM_OK && !out->known) return ylm__grid_file_bad(s->name, "its fingerprints", e);
  return status;
}

/* Quantity, measure, floor, body, fingerprints; a file without these sections is of lights and of coefficients. */
static ylm_status take_meaning(const file_table *t, const file_source *s, ylm_grid_form *out,
                               ylm_error *e) {
  uint32_t quantity = 0;
  grid_file_measure m = {0};
  ylm_status status = YLM_OK;
  if (ylm__file_table_find(t, GRID_FILE_quantity))
    status = ylm__file_table_take(t, s, GRID_FILE_quantity, sizeof quantity, sizeof quantity,
                                  &quantity, e);
  if (status == YLM_OK && ylm__file_table_find(t, GRID_FILE_measure))
    status = ylm__file_table_take(t, s, GRID_FILE_measure, sizeof m, sizeof m, &m, e);
  if (status == YLM_OK && (m.zero || m.zeros)) return ylm__grid_file_bad(s->name, "its measure", e);
  if (status == YLM_OK && ylm__file_table_find(t, GRID_FILE_floor))
    status = ylm__file_table_take(t, s, GRID_FILE_floor, sizeof out->floor, sizeof out->floor,
                                  &out->floor, e);
  if (status == YLM_OK && ylm__file_table_find(t, GRID_FILE_body))
    status = ylm__file_table_take(t, s, GRID_FILE_body, sizeof out->body, sizeof out->body,
                                  &out->body, e);
  if (status == YLM_OK) status = take_prints(t, s, &out->prints, e);
  out->quantity = quantity < YLM_QUANTITY_COUNT ? (ylm_quantity)quantity : YLM_QUANTITY_COUNT;
  out->measure = (ylm_grid_measure)m.measure;
  out->sides = ylm__file_table_find(t, GRID_FILE_sides) != NULL;
  small_head small;
  if (status == YLM_OK && ylm__file_table_find(t, GRID_FILE_small)) {
    status = ylm__file_table_take(t, s, GRID_FILE_small, sizeof small, sizeof small, &small, e);
    out->sides = status == YLM_OK && small.flags & SMALL_HAS_SIDES;
  }
  return status;
}

ylm_status ylm__file_table_form(const file_table *t, const file_source *s, grid_file_form *form,
                                ylm_grid_form *out, ylm_grid_stats *stats, ylm_error *e) {
  grid_file_stats history = {.error = NAN, .largest_error = NAN};
  ylm_error why = {0};
  ylm_status status = check_required(t, s, e);
  if (status == YLM_OK)
    status = ylm__file_table_take(t, s, GRID_FILE_form, sizeof *form, sizeof *form, form, e);
  if (status == YLM_OK && ylm__file_table_find(t, GRID_FILE_stats))
    status =
        ylm__file_table_take(t, s, GRID_FILE_stats, sizeof history, sizeof history, &history, e);
  if (status != YLM_OK) return status;
  *out = form_of(form);
  status = take_meaning(t, s, out, e);
  if (status != YLM_OK) return status;
  *stats = stats_of(form, &history);
  if (ylm__grid_check_form(out, &why) != YLM_OK) return ylm__grid_file_bad(s->name, why.text, e);
  if (form->evaluated > form->points) return ylm__grid_file_bad(s->name, "its counts", e);
  return YLM_OK;
}
