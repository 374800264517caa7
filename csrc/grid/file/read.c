/*
** read.c - grids from files.
**
** Every section is read to where the grid has it. Sizes are compared with the file before memory is
** asked for, and cells, places and births are checked before rows are read. Interpolated points are
** made again, by the interpolation that made them.
*/
#include "file.h"

#include <string.h>

/* A cell is split for continuity where an evaluated point is the middle of one of its edges or
   faces. At most four cells share it, and each split adds 26 other places. No grid has more interpolated points for each
   evaluated one. */
#define MOST_BORN (4 * 26)

/* True if the counts can be. */
static bool counts_hold(const grid_file_form *f, const ylm_grid_form *form) {
  uint64_t born = f->points - f->evaluated;
  bool uniform = form->kind == YLM_GRID_UNIFORM;
  if (!f->octree_cells || f->octree_cells > f->cells || f->cells >= YLM_GRID_NONE) return false;
  if (f->points >= YLM_GRID_NONE || born > MOST_BORN * f->evaluated) return false;
  return (!born && f->octree_cells == f->cells) || (form->continuous && !uniform);
}

/* A reading of one file. */
typedef struct reading {
  const file_source *source;
  file_table table;
  grid_file_room *room;
  int threads;
  ylm_grid *g;
  ylm_error *e;
} reading;

/* n records of a section, to `to`. */
static ylm_status take(const reading *r, int kind, size_t record, size_t n, void *to) {
  return ylm__file_table_take(&r->table, r->source, kind, record, n * record, to, r->e);
}

/* True if the sections that memory is asked for are as long as the counts say. */
static bool sizes_hold(const reading *r, const grid_file_form *f) {
  const ylm_grid *g = r->g;
  const grid_file_entry *cells = ylm__file_table_find(&r->table, GRID_FILE_cells),
                        *births = ylm__file_table_find(&r->table, GRID_FILE_births),
                        *rows = ylm__file_table_find(&r->table, GRID_FILE_rows),
                        *validity = ylm__file_table_find(&r->table, GRID_FILE_validity);
  return cells && births && rows && cells->size == f->cells * sizeof *g->cell &&
         births->size == (f->points - f->evaluated) * sizeof *g->birth &&
         rows->size == (f->evaluated * ylm__grid_record(g) + ROW_PADDING) * sizeof *g->data &&
         (!validity || validity->size == f->evaluated * sizeof *g->validity);
}

/* Gives the grid the room that rows of another were in. */
static void take_room(reading *r) {
  if (!r->room || !r->room->data) return;
  r->g->data = r->room->data;
  r->g->data_bytes = r->room->bytes;
  *r->room = (grid_file_room){0};
}

/* Room for all that there is. */
static ylm_status reserve(reading *r, const grid_file_form *f) {
  ylm_grid *g = r->g;
  size_t born = f->points - f->evaluated;
  take_room(r);
  ylm_status s = ylm__grid_reserve_cells(g, f->cells);
  if (s == YLM_OK) s = ylm__grid_reserve_points(g, f->points);
  if (s == YLM_OK && born) g->birth = ylm_alloc(born, sizeof *g->birth);
  bool told = ylm__file_table_find(&r->table, GRID_FILE_validity);
  if (s == YLM_OK && told) g->validity = ylm_alloc(f->evaluated, sizeof *g->validity);
  if (s != YLM_OK || (born && !g->birth) || (told && !g->validity))
    return ylm_fail(r->e, s == YLM_OK ? YLM_ENOMEM : s, "%s: the grid does not fit into memory",
                    r->source->name);
  g->birth_room = born;
  g->cells = f->cells;
  g->contents.octree_cells = f->octree_cells;
  g->points = f->points;
  g->evaluated = f->evaluated;
  return YLM_OK;
}

/* Records in a section; 0: there is none. */
static size_t records_in(const reading *r, int kind, size_t record) {
  const grid_file_entry *entry = ylm__file_table_find(&r->table, kind);
  return entry ? (size_t)(entry->size / record) : 0;
}

/* Sides, the corners of their parts, and ghosts. */
static ylm_status read_sides(reading *r) {
  ylm_grid *g = r->g;
  grid_sides *s = &g->sides;
  if (!g->contents.form.sides) return YLM_OK;
  size_t n = records_in(r, GRID_FILE_sides, sizeof *s->side),
         parts = records_in(r, GRID_FILE_nodes, sizeof *s->node),
         ghosts = records_in(r, GRID_FILE_ghosts, sizeof *s->asked);
  if (n > g->cells || parts > n * YLM_GRID_PARTS || ghosts > g->evaluated)
    return ylm__grid_file_bad(r->source->name, "its sides", r->e);
  s->side = ylm_alloc(n ? n : 1, sizeof *s->side);
  s->node = ylm_alloc(parts ? parts : 1, sizeof *s->node);
  if (!s->side || !s->node) return ylm_no_memory_for(r->e, r->source->name);
  s->room = n ? n : 1;
  s->part_room = parts ? parts : 1;
  s->n = n;
  s->parts = parts;
  float(*asked)[3] = s->asked + (g->evaluated - ghosts);
  bool finite = true;
  ylm_status status = take(r, GRID_FILE_sides, sizeof *s->side, n, s->side);
  if (status == YLM_OK && parts) status = take(r, GRID_FILE_nodes, sizeof *s->node, parts, s->node);
  if (status == YLM_OK && ghosts)
    status = ylm__file_table_take_floats(&r->table, r->source, GRID_FILE_ghosts, sizeof *asked,
                                         ghosts * sizeof *asked, asked[0], &finite, r->e);
  if (status != YLM_OK) return status;
  for (size_t i = 0; finite && i < g->evaluated; i++)
    finite = !(g->flags[i] & YLM_GRID_POINT_GHOST) == (i < g->evaluated - ghosts);
  return finite ? YLM_OK : ylm__grid_file_bad(r->source->name, "its ghosts", r->e);
}

/* All sections but the rows, checked. */
static ylm_status read_structure(reading *r) {
  ylm_grid *g = r->g;
  size_t n = g->evaluated, born = g->points - n;
  ylm_status s = take(r, GRID_FILE_cells, sizeof *g->cell, g->cells, g->cell);
  if (s == YLM_OK) s = take(r, GRID_FILE_lattice, 3 * sizeof *g->lattice, n, g->lattice);
  if (s == YLM_OK) s = take(r, GRID_FILE_lambda, sizeof *g->lambda, n, g->lambda);
  if (s == YLM_OK) s = take(r, GRID_FILE_norm, sizeof *g->norm, n, g->norm);
  if (s == YLM_OK) s = take(r, GRID_FILE_flags, 1, n, g->flags);
  if (s == YLM_OK) s = take(r, GRID_FILE_births, sizeof *g->birth, born, g->birth);
  if (s == YLM_OK && g->validity)
    s = take(r, GRID_FILE_validity, sizeof *g->validity, n, g->validity);
  if (s != YLM_OK) return s;
  s = read_sides(r);
  if (s != YLM_OK) return s;
  const char *what = ylm__grid_file_check_points(g);
  if (!what) what = ylm__grid_file_check_births(g);
  if (!what) ylm__grid_file_place_births(g);
  if (what) return ylm__grid_file_bad(r->source->name, what, r->e);
  s = ylm__grid_file_check_cells(g, r->source->name, r->e);
  what = s == YLM_OK ? ylm__grid_file_check_sides(g) : NULL;
  return what ? ylm__grid_file_bad(r->source->name, what, r->e) : s;
}

/* The rows of evaluated points from the file, then those of interpolated ones from these. */
static ylm_status read_rows(reading *r) {
  ylm_grid *g = r->g;
  size_t row = ylm__grid_record(g), bytes = (g->evaluated * row + ROW_PADDING) * sizeof *g->data;
  bool finite;
  ylm_status s = ylm__file_table_take_floats(&r->table, r->source, GRID_FILE_rows,
                                             row * sizeof *g->data, bytes, g->data, &finite, r->e);
  if (s != YLM_OK) return s;
  if (!finite) return ylm__grid_file_bad(r->source->name, "coefficients", r->e);
  s = ylm__grid_interpolate_points(g, NULL, r->threads, NULL);
  if (s == YLM_OK && !ylm_all_finite(YLM_FLOAT, g->data + g->evaluated * row,
                                     (g->points - g->evaluated) * row, NULL))
    return ylm__grid_file_bad(r->source->name, "coefficients", r->e);
  if (s == YLM_OK) s = ylm__grid_file_finish(g);
  return s == YLM_OK ? YLM_OK : ylm_fail(r->e, s, "%s: memory ran out", r->source->name);
}

/* The cell that a brick is the subtree of. */
static ylm_status take_root(reading *r) {
  const ylm_grid_form *f = &r->g->contents.form;
  grid_file_brick b;
  if (!ylm__file_table_find(&r->table, GRID_FILE_brick)) return YLM_OK;
  ylm_status s = take(r, GRID_FILE_brick, sizeof b, 1, &b);
  if (s != YLM_OK) return s;
  bool holds = f->kind == YLM_GRID_ADAPTIVE && b.level >= 1 && b.level <= (uint32_t)f->depth;
  for (int a = 0; holds && a < 3; a++)
    holds = b.origin[a] < r->g->contents.resolution[a] &&
            b.origin[a] % (1u << ((uint32_t)f->depth - b.level)) == 0;
  if (!holds) return ylm__grid_file_bad(r->source->name, "the place of a brick", r->e);
  ylm__grid_set_root(r->g, (int)b.level, b.origin);
  return YLM_OK;
}

/* A section's bytes (ylm_free), and zeros behind them; an absent one has none. */
static ylm_status take_bytes(const reading *r, int kind, unsigned char **data, size_t *size) {
  const grid_file_entry *entry = ylm__file_table_find(&r->table, kind);
  *size = entry ? (size_t)entry->size : 0;
  *data = ylm_alloc_zero(*size + RANS_BEHIND(r->g->contents.count), 1);
  if (!*data) return ylm_no_memory_for(r->e, r->source->name);
  return entry ? take(r, kind, 1, *size, *data) : YLM_OK;
}

/* Cells and points of a file of few bytes. */
static ylm_status read_packed(reading *r, const grid_file_form *f, small_packed *p) {
  const char *bad = NULL, *name = r->source->name;
  ylm_status s = take(r, GRID_FILE_small, sizeof p->head, 1, &p->head);
  if (s == YLM_OK && !ylm__small_head_holds(&p->head, r->g))
    return ylm__grid_file_bad(name, "how its points are rounded", r->e);
  if (s == YLM_OK) s = take_bytes(r, GRID_FILE_small_tree, &p->tree, &p->tree_size);
  if (s == YLM_OK) s = take_bytes(r, GRID_FILE_small_bases, &p->bases, &p->bases_size);
  if (s == YLM_OK) s = take_bytes(r, GRID_FILE_small_tables, &p->tables, &p->tables_size);
  if (s == YLM_OK) s = take_bytes(r, GRID_FILE_small_points, &p->points, &p->points_size);
  if (s == YLM_OK) s = take_bytes(r, GRID_FILE_small_numbers, &p->data, &p->data_size);
  if (s == YLM_OK) s = take_bytes(r, GRID_FILE_small_bits, &p->raw, &p->raw_size);
  if (s != YLM_OK) return s;
  s = ylm__small_decode(r->g, p, f->octree_cells, f->evaluated, r->threads, &bad);
  if (bad) return ylm__grid_file_bad(name, bad, r->e);
  if (s != YLM_OK) return ylm_fail(r->e, s, "%s: the grid does not fit into memory", name);
  if (r->g->cells != f->cells || r->g->points != f->points)
    return ylm__grid_file_bad(name, "its counts", r->e);
  return YLM_OK;
}

/* A file of few bytes, whose form is known. */
static ylm_status read_small(reading *r, const grid_file_form *f) {
  ylm_grid *g = r->g;
  small_packed p = {0};
  take_room(r);
  ylm_status s = take_root(r);
  if (s == YLM_OK) s = read_packed(r, f, &p);
  ylm__small_packed_free(&p);
  if (s != YLM_OK) return s;
  if (ylm__file_table_find(&r->table, GRID_FILE_small_report)) {
    s = take(r, GRID_FILE_small_report, sizeof g->small, 1, &g->small);
    g->is_small = s == YLM_OK;
  }
  return s;
}

/* The grid of a file whose table was read. */
static ylm_status read_grid(reading *r) {
  grid_file_form f;
  ylm_grid_form form;
  ylm_grid_stats stats;
  const char *name = r->source->name;
  ylm_status s = ylm__file_table_form(&r->table, r->source, &f, &form, &stats, r->e);
  if (s != YLM_OK) return s;
  if (!counts_hold(&f, &form)) return ylm__grid_file_bad(name, "its counts", r->e);
  r->g = ylm__grid_new(&form);
  if (!r->g) return ylm_no_memory_for(r->e, name);
  r->g->stats = stats;
  if (!ylm__grid_file_table_holds(r->g, f.cells))
    return ylm__grid_file_bad(name, "too sparse a lattice", r->e);
  if (ylm__file_table_find(&r->table, GRID_FILE_small)) return read_small(r, &f);
  if (!sizes_hold(r, &f)) return ylm__grid_file_bad(name, "the size of a section", r->e);
  s = take_root(r);
  if (s == YLM_OK) s = reserve(r, &f);
  if (s == YLM_OK) s = read_structure(r);
  return s == YLM_OK ? read_rows(r) : s;
}

ylm_status ylm__grid_file_read_source(const file_source *source, grid_file_room *room, int threads,
                                      ylm_grid **out, ylm_error *e) {
  reading r = {.source = source, .room = room, .threads = threads, .e = e};
  ylm_status s = ylm__file_table_read(&r.table, source, e);
  if (s == YLM_OK) s = read_grid(&r);
  ylm_free(r.table.entry);
  if (s == YLM_OK)
    *out = r.g;
  else
    ylm_grid_free(r.g);
  return s;
}
