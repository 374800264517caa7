/* write.c - grids as files: sections one after the other, then what says where they are. */
#include "file.h"

#include <errno.h>
#include <string.h>

/* Where bytes go: a file or memory. */
typedef struct sink {
  ylm_file *file;
  unsigned char *data;
  uint64_t at, crc;
} sink;

/* n bytes; they are added to the sum. */
static void put(sink *s, const void *bytes, size_t n) {
  for (size_t done = 0; done < n;) {
    size_t some = n - done < GRID_FILE_CHUNK ? n - done : GRID_FILE_CHUNK;
    const unsigned char *p = (const unsigned char *)bytes + done;
    s->crc = ylm_crc64(s->crc, p, some);
    if (s->file)
      ylm_file_write(s->file, p, some);
    else
      memcpy(s->data + s->at, p, some);
    s->at += some;
    done += some;
  }
}

/* Zeros up to an offset of at most GRID_FILE_BOUND more. */
static void put_zeros(sink *s, uint64_t end) {
  static const unsigned char zeros[GRID_FILE_BOUND];
  put(s, zeros, end - s->at);
}

/* -- what there is to write ------------------------------------------------------------------- */

typedef struct writing {
  const ylm_grid *g;
  const small_packed *small; /* NULL: none */
  grid_file_header header;
  grid_file_entry entry[GRID_FILE_COUNT];
  size_t entries;
  grid_file_form form;
  grid_file_stats stats;
  uint32_t quantity;
  grid_file_measure measure;
  grid_file_brick brick;
  int kind[GRID_FILE_COUNT]; /* of each entry, one of GRID_FILE_LIST */
} writing;

static void describe(writing *w) {
  const ylm_grid *g = w->g;
  const ylm_grid_form *f = &g->contents.form;
  const ylm_grid_stats *t = &g->stats;
  w->form = (grid_file_form){.kind = (uint32_t)f->kind,
                             .lmax = (uint32_t)f->lmax,
                             .channels = (uint32_t)f->channels,
                             .metric_channels = (uint32_t)f->metric_channels,
                             .depth = (uint32_t)f->depth,
                             .metric = (uint32_t)f->metric,
                             .continuous = f->continuous,
                             .threshold = f->threshold,
                             .tolerance = f->tolerance,
                             .cells = g->cells,
                             .octree_cells = g->contents.octree_cells,
                             .points = g->points,
                             .evaluated = g->evaluated};
  w->quantity = (uint32_t)f->quantity;
  w->measure = (grid_file_measure){.measure = (uint32_t)f->measure};
  w->brick.level = (uint32_t)g->contents.root_level;
  memcpy(w->brick.origin, g->contents.root, sizeof w->brick.origin);
  memcpy(w->form.lattice, f->cells, sizeof f->cells);
  memcpy(w->form.bounds, f->bounds, sizeof f->bounds);
#define X(type, name) w->stats.name = t->name;
  GRID_FILE_STATS(X)
#undef X
}

/* The bytes of each section, as they lie in memory; rows are put one by one. */
static void sizes(const writing *w, uint64_t size[GRID_FILE_COUNT],
                  const void *data[GRID_FILE_COUNT]) {
  const ylm_grid *g = w->g;
  uint64_t n = g->evaluated;
#define SECTION(name, pointer, bytes)                                                              \
  data[GRID_FILE_##name] = (pointer);                                                              \
  size[GRID_FILE_##name] = (bytes)
  SECTION(form, &w->form, sizeof w->form);
  SECTION(stats, &w->stats, sizeof w->stats);
  SECTION(cells, g->cell, g->cells * sizeof *g->cell);
  SECTION(lattice, g->lattice, n * 3 * sizeof *g->lattice);
  SECTION(lambda, g->lambda, n * sizeof *g->lambda);
  SECTION(norm, g->norm, n * sizeof *g->norm);
  SECTION(flags, g->flags, n);
  SECTION(births, g->birth, (g->points - n) * sizeof *g->birth);
  SECTION(rows, NULL, (n * ylm__grid_record(g) + ROW_PADDING) * sizeof *g->data);
  SECTION(quantity, &w->quantity, w->quantity ? sizeof w->quantity : 0);
  SECTION(measure, &w->measure, w->measure.measure ? sizeof w->measure : 0);
  SECTION(validity, g->validity, g->validity ? n * sizeof *g->validity : 0);
  const ylm_grid_form *f = &g->contents.form;
  SECTION(floor, &f->floor, f->floor > 0 ? sizeof f->floor : 0);
  SECTION(body, &f->body, f->body.radius > 0 ? sizeof f->body : 0);
  SECTION(prints, &f->prints, f->prints.known ? sizeof f->prints : 0);
  SECTION(brick, &w->brick, w->brick.level ? sizeof w->brick : 0);
  const grid_sides *s = &g->sides;
  uint64_t ghosts = 0;
  for (size_t i = 0; f->sides && i < n; i++) ghosts += (g->flags[i] & YLM_GRID_POINT_GHOST) != 0;
  SECTION(sides, s->side, s->n * sizeof *s->side);
  SECTION(nodes, s->node, s->parts * sizeof *s->node);
  SECTION(ghosts, ghosts ? s->asked[n - ghosts] : NULL, ghosts * sizeof *s->asked);
  for (int i = GRID_FILE_small; i < GRID_FILE_COUNT; i++) size[i] = 0;
  if (!w->small) return;
  static const int instead[] = {GRID_FILE_cells, GRID_FILE_lattice,  GRID_FILE_lambda,
                                GRID_FILE_norm,  GRID_FILE_flags,    GRID_FILE_births,
                                GRID_FILE_rows,  GRID_FILE_validity, GRID_FILE_sides,
                                GRID_FILE_nodes, GRID_FILE_ghosts};
  for (size_t i = 0; i < sizeof instead / sizeof *instead; i++) size[instead[i]] = 0;
  const small_packed *p = w->small;
  SECTION(small, &p->head, sizeof p->head);
  SECTION(small_tree, p->tree, p->tree_size);
  SECTION(small_bases, p->bases, p->bases_size);
  SECTION(small_tables, p->tables, p->tables_size);
  SECTION(small_points, p->points, p->points_size);
  SECTION(small_numbers, p->data, p->data_size);
  SECTION(small_bits, p->raw, p->raw_size);
  SECTION(small_report, &p->report, sizeof p->report);
#undef SECTION
}

/* Where every section of the grid's file will stand, and the size of the file. */
static void lay_out(writing *w, const ylm_grid *g, const small_packed *small) {
  *w = (writing){.g = g, .small = small};
  uint64_t size[GRID_FILE_COUNT], at = sizeof w->header;
  const void *data[GRID_FILE_COUNT];
  describe(w);
  sizes(w, size, data);
  const grid_file_entry all[] = {
#define X(name_, record_, required)                                                                \
  {.name = #name_,                                                                                 \
   .record = (uint32_t)(record_),                                                                  \
   .flags = (required) ? GRID_FILE_REQUIRED : 0,                                                   \
   .size = size[GRID_FILE_##name_]},
      GRID_FILE_LIST(X)
#undef X
  };
  for (int i = 0; i < GRID_FILE_COUNT; i++) {
    bool always =
        !small && (i <= GRID_FILE_rows || (i == GRID_FILE_sides && g->contents.form.sides));
    if (!always && !size[i]) continue;
    w->kind[w->entries] = i;
    w->entry[w->entries++] = all[i];
  }
  at += w->entries * sizeof *w->entry;
  for (size_t i = 0; i < w->entries; i++) {
    w->entry[i].offset = at = grid_file_bound(at);
    at += w->entry[i].size;
  }
  w->header = (grid_file_header){.order = GRID_FILE_ORDER,
                                 .version = GRID_FILE_VERSION,
                                 .size = at,
                                 .sections = (uint32_t)w->entries};
  memcpy(w->header.magic, YLM_GRID_MAGIC, sizeof w->header.magic);
}

/* -- writing it
 * ------------------------------------------------------------------------------------ */

/* Are there zeros behind the coefficients of n points? */
static bool ends_in_zeros(const ylm_grid *g, const float *data, size_t n) {
  static const float zeros[8];
  size_t rest = (g->stride - g->width) * sizeof *data;
  if (rest > sizeof zeros) return false;
  for (size_t r = 0; r < g->rows * n; r++)
    if (memcmp(data + r * g->stride + g->width, zeros, rest) != 0) return false;
  return true;
}

/* The rows of evaluated points, with zeros behind the coefficients of each: equal grids are equal
   files. `room` is that of `rows` points. */
static void put_rows(sink *s, const ylm_grid *g, float *room, size_t rows) {
  size_t row = ylm__grid_record(g), rest = (g->stride - g->width) * sizeof *room;
  for (size_t p = 0; p < g->evaluated; p += rows) {
    size_t n = g->evaluated - p < rows ? g->evaluated - p : rows;
    const float *from = g->data + p * row;
    if (!ends_in_zeros(g, from, n)) {
      memcpy(room, from, n * row * sizeof *room);
      for (size_t r = 0; r < g->rows * n; r++) memset(room + r * g->stride + g->width, 0, rest);
      from = room;
    }
    put(s, from, n * row * sizeof *room);
  }
  memset(room, 0, ROW_PADDING * sizeof *room);
  put(s, room, ROW_PADDING * sizeof *room);
}

/* Sections behind room for header and table, with their sums. */
static ylm_status put_sections(writing *w, sink *s) {
  const ylm_grid *g = w->g;
  uint64_t size[GRID_FILE_COUNT];
  const void *data[GRID_FILE_COUNT];
  size_t row = ylm__grid_record(g) * sizeof(float), rows = GRID_FILE_CHUNK / row + 1;
  float *room = ylm_alloc(rows, row + ROW_PADDING * sizeof *room);
  if (!room) return YLM_ENOMEM;
  sizes(w, size, data);
  put(s, w->entry, sizeof w->header);
  put(s, w->entry, w->entries * sizeof *w->entry);
  for (size_t i = 0; i < w->entries; i++) {
    int kind = w->kind[i];
    put_zeros(s, w->entry[i].offset);
    s->crc = 0;
    if (kind == GRID_FILE_rows)
      put_rows(s, g, room, rows);
    else
      put(s, data[kind], size[kind]);
    w->entry[i].crc = s->crc;
  }
  ylm_free(room);
  return YLM_OK;
}

/* The sum of a header and its table. */
static uint64_t head_sum(const grid_file_header *h, const grid_file_entry *entry, size_t n) {
  return ylm_crc64(ylm_crc64(0, h, offsetof(grid_file_header, crc)), entry, n * sizeof *entry);
}

/* Header and table, at the beginning. */
static void put_head(writing *w, sink *s) {
  w->header.crc = head_sum(&w->header, w->entry, w->entries);
  s->at = 0;
  put(s, &w->header, sizeof w->header);
  put(s, w->entry, w->entries * sizeof *w->entry);
}

uint64_t ylm__grid_file_small_size(const ylm_grid *g, const small_packed *small) {
  writing w;
  lay_out(&w, g, small);
  return w.header.size;
}

ylm_status ylm_grid_encode(const ylm_grid *g, unsigned char **data, size_t *size, ylm_error *e) {
  return ylm__grid_file_encode(g, NULL, data, size, e);
}

ylm_status ylm__grid_file_encode(const ylm_grid *g, const small_packed *small, unsigned char **data,
                                 size_t *size, ylm_error *e) {
  writing w;
  ylm_status status = ylm__grid_file_machine("the grid", e);
  if (status != YLM_OK) return status;
  lay_out(&w, g, small);
  *size = w.header.size;
  *data = ylm_alloc(*size, 1);
  sink s = {.data = *data};
  if (!*data || put_sections(&w, &s) != YLM_OK) {
    ylm_free(*data);
    *data = NULL;
    return ylm_fail(e, YLM_ENOMEM, "no memory for a file of %zu bytes", *size);
  }
  put_head(&w, &s);
  return YLM_OK;
}

ylm_status ylm_grid_write(const ylm_grid *g, const char *path, ylm_error *e) {
  writing w;
  sink s = {0};
  ylm_status status = ylm__grid_file_machine(path, e);
  if (status == YLM_OK) status = ylm_file_create(path, &s.file, e);
  if (status != YLM_OK) return status;
  lay_out(&w, g, NULL);
  if (put_sections(&w, &s) != YLM_OK) {
    ylm_file_discard(s.file);
    return ylm_no_memory_for(e, path);
  }
  if (fseeko(ylm_file_stream(s.file), 0, SEEK_SET) != 0) {
    ylm_file_discard(s.file);
    return ylm_fail(e, YLM_EIO, "%s: cannot be written: %s", path, strerror(errno));
  }
  put_head(&w, &s);
  return ylm_file_commit(s.file, e);
}

/* Replaces a section's bytes in a file in memory, and its sum in the table; false: it has another size. */
static bool replace(unsigned char *data, const file_table *t, int kind, const void *bytes,
                    size_t n) {
  const grid_file_entry *found = ylm__file_table_find(t, kind);
  if (!found || found->size != n) return false;
  memcpy(data + found->offset, bytes, n);
  t->entry[found - t->entry].crc = ylm_crc64(0, bytes, n);
  return true;
}

ylm_status ylm_grid_restate(unsigned char *data, size_t size, const ylm_grid *g, ylm_error *e) {
  writing w = {.g = g};
  file_source source;
  file_table t;
  ylm_status s = ylm__file_source_memory(&source, "the grid", data, size, e);
  if (s == YLM_OK) s = ylm__file_table_read(&t, &source, e);
  if (s != YLM_OK) return s;
  describe(&w);
  const grid_file_entry *form = ylm__file_table_find(&t, GRID_FILE_form);
  bool holds = form && form->size == sizeof w.form &&
               memcmp(data + form->offset, &w.form, offsetof(grid_file_form, bounds)) == 0 &&
               replace(data, &t, GRID_FILE_form, &w.form, sizeof w.form) &&
               replace(data, &t, GRID_FILE_stats, &w.stats, sizeof w.stats);
  if (!holds) s = ylm__grid_file_bad("the grid", "it is another's", e);
  if (holds) {
    memcpy(&w.header, data, sizeof w.header);
    w.header.crc = head_sum(&w.header, t.entry, t.sections);
    memcpy(data, &w.header, sizeof w.header);
    memcpy(data + sizeof w.header, t.entry, t.sections * sizeof *t.entry);
  }
  ylm_free(t.entry);
  return s;
}

/* -- piece by piece ------------------------------------------------------------------------------ */

/* Where the next bytes of a section go, and its sum so far; the last is of the cells behind the octree's. */
struct file_pieces {
  writing w;
  ylm_file *file;
  char *path;
  sink at[GRID_FILE_COUNT + 1];
};

static const grid_file_entry *entry_of(const writing *w, int kind) {
  for (size_t i = 0; i < w->entries; i++)
    if (w->kind[i] == kind) return &w->entry[i];
  return NULL;
}

static ylm_status fail_pieces(const file_pieces *f, ylm_error *e) {
  return ylm_fail(e, YLM_EIO, "%s: cannot be written: %s", f->path, strerror(errno));
}

ylm_status ylm__file_pieces_begin(const ylm_grid *g, const char *path, file_pieces **out,
                                  ylm_error *e) {
  *out = NULL;
  ylm_status s = ylm__grid_file_machine(path, e);
  if (s != YLM_OK) return s;
  file_pieces *f = ylm_alloc_zero(1, sizeof *f);
  if (f) f->path = ylm_alloc_copy(path, strlen(path) + 1, 1);
  if (!f || !f->path) {
    ylm_free(f);
    return ylm_no_memory_for(e, path);
  }
  s = ylm_file_create(path, &f->file, e);
  if (s != YLM_OK) {
    ylm__file_pieces_discard(f);
    return s;
  }
  lay_out(&f->w, g, NULL);
  for (size_t i = 0; i < f->w.entries; i++)
    f->at[f->w.kind[i]] = (sink){.file = f->file, .at = f->w.entry[i].offset};
  f->at[GRID_FILE_ADDED] = f->at[GRID_FILE_cells];
  f->at[GRID_FILE_ADDED].at += g->contents.octree_cells * sizeof *g->cell;
  *out = f;
  return YLM_OK;
}

ylm_status ylm__file_pieces_put(file_pieces *f, int kind, const void *bytes, size_t n,
                                ylm_error *e) {
  sink *s = &f->at[kind];
  if (!n) return YLM_OK;
  if (fseeko(ylm_file_stream(f->file), (off_t)s->at, SEEK_SET) != 0) return fail_pieces(f, e);
  put(s, bytes, n);
  return ferror(ylm_file_stream(f->file)) ? fail_pieces(f, e) : YLM_OK;
}

/* Bytes of the section that another one begins within or behind. */
static uint64_t end_of(const file_pieces *f, int kind) {
  const ylm_grid *g = f->w.g;
  const grid_file_entry *entry = entry_of(&f->w, kind == GRID_FILE_ADDED ? GRID_FILE_cells : kind);
  return kind == GRID_FILE_cells ? entry->offset + g->contents.octree_cells * sizeof *g->cell
                                 : entry->offset + entry->size;
}

bool ylm__file_pieces_whole(const file_pieces *f) {
  bool whole = f->at[GRID_FILE_ADDED].at == end_of(f, GRID_FILE_ADDED);
  for (int kind = GRID_FILE_cells; kind <= GRID_FILE_rows; kind++)
    whole &= f->at[kind].at == end_of(f, kind);
  return whole && (!entry_of(&f->w, GRID_FILE_validity) ||
                   f->at[GRID_FILE_validity].at == end_of(f, GRID_FILE_validity));
}

/* The sections that were not put, and all sums. */
static ylm_status finish_pieces(file_pieces *f, ylm_error *e) {
  writing *w = &f->w;
  uint64_t size[GRID_FILE_COUNT];
  const void *data[GRID_FILE_COUNT];
  describe(w);
  sizes(w, size, data);
  for (size_t i = 0; i < w->entries; i++) {
    int kind = w->kind[i];
    bool given = (kind >= GRID_FILE_cells && kind <= GRID_FILE_rows) || kind == GRID_FILE_validity;
    ylm_status s = given ? YLM_OK : ylm__file_pieces_put(f, kind, data[kind], size[kind], e);
    if (s != YLM_OK) return s;
    w->entry[i].crc = f->at[kind].crc;
    if (kind == GRID_FILE_cells)
      w->entry[i].crc = ylm_crc64_join(f->at[kind].crc, f->at[GRID_FILE_ADDED].crc,
                                       end_of(f, GRID_FILE_ADDED) - end_of(f, kind));
  }
  if (fseeko(ylm_file_stream(f->file), 0, SEEK_SET) != 0) return fail_pieces(f, e);
  put_head(w, &(sink){.file = f->file});
  return YLM_OK;
}

ylm_status ylm__file_pieces_end(file_pieces *f, ylm_error *e) {
  ylm_status s = finish_pieces(f, e);
  if (s == YLM_OK) {
    s = ylm_file_commit(f->file, e);
    f->file = NULL;
  }
  ylm__file_pieces_discard(f);
  return s;
}

void ylm__file_pieces_discard(file_pieces *f) {
  if (!f) return;
  if (f->file) ylm_file_discard(f->file);
  ylm_free(f->path);
  ylm_free(f);
}
