/*
** pack_file.c - a grid in bricks as one file, with one brick in memory at a time.
**
** The file is that of pack.c's grid, byte by byte: the top's cells and points, then each brick's, then the cells that continuity
** has added, in the order of the leaves that they are parts of. A first pass counts, and numbers the points that bricks share. The
** second one puts each brick's part of every section where it belongs.
*/
#include <string.h>

#include "set.h"
#include "ylm_list.h"

/* Counts of a brick. */
typedef struct file_part {
  uint32_t cell;  /* of the top */
  uint64_t first; /* the number of the first point that no brick before has */
  uint64_t cells, octree, evaluated, points;
} file_part;

/* The brick at hand, or the top: where its cells and points stand in the file. */
typedef struct place {
  const ylm_grid *from;
  const uint32_t *point; /* [evaluated]; NULL: as they are */
  uint32_t root, source; /* the first cell, and where that has its data from */
  uint64_t base;         /* the second cell */
  uint64_t added, from_added, born,
      from_born; /* of the cells and points that continuity has added */
} place;

typedef struct filing {
  ylm_grid_set *set;
  const ylm_progress *progress;
  int threads;
  ylm_error *e;
  ylm_grid *g;         /* form, counts and stats; neither cells nor points */
  lattice_hash shared; /* points that several bricks may have */
  file_part *part;     /* [bricks] */
  uint32_t *order;     /* [bricks] in the file */
  uint64_t *group;     /* [cells of the top's octree] where continuity has added cells for it */
  uint32_t *number;    /* [number_room] of the brick's points */
  size_t number_room;
  char *room; /* of pieces */
  file_pieces *file;
  uint64_t points, octree, added, born; /* put so far */
  uint64_t done;
} filing;

static ylm_status no_memory(const filing *t) { return ylm_no_memory_for(t->e, t->set->folder); }

static ylm_status other_files(const filing *t) {
  return ylm_fail(t->e, YLM_EFORMAT, "%s: its files are not those of one bake", t->set->folder);
}

static ylm_status report(filing *t) {
  return ylm__set_report(t->set, t->progress, t->done++, 2 * t->set->bricks, "packing");
}

/* -- counts and numbers ------------------------------------------------------------------------------- */

static ylm_status share_point(filing *t, const uint32_t at[3]) {
  if (ylm__lattice_hash_reserve(&t->shared, t->shared.used + 1) != YLM_OK) return no_memory(t);
  uint32_t *number = ylm__lattice_hash_at(&t->shared, lattice_key(at));
  if (*number == YLM_GRID_NONE) *number = (uint32_t)t->g->points++;
  return YLM_OK;
}

/* Whether other bricks may have a point too. */
static bool is_shared(const filing *t, const set_brick *k, const uint32_t at[3]) {
  uint32_t edge = 1u << (t->g->contents.form.depth - (int)k->level);
  bool on = false;
  for (int a = 0; a < 3; a++) on |= at[a] == k->origin[a] || at[a] == k->origin[a] + edge;
  return on;
}

/* A brick's points are counted; those that no brick before has are new. */
static ylm_status count_points(filing *t, size_t number, const uint32_t *lattice, size_t n) {
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < n && s == YLM_OK; i++)
    if (is_shared(t, &t->set->brick[number], lattice + 3 * i))
      s = share_point(t, lattice + 3 * i);
    else
      t->g->points++;
  return s;
}

static void count(filing *t, file_part *p, uint64_t cells, uint64_t octree, uint64_t evaluated,
                  uint64_t points) {
  p->cells = cells;
  p->octree = octree;
  p->evaluated = evaluated;
  p->points = points;
  t->octree += octree - 1;
  t->added += cells - octree;
  t->born += points - evaluated;
}

/* A brick's counts and the places of its points, without the rest of its file; false through *found where the file has no
   such section, since it is of few bytes. */
static ylm_status look_at_file(filing *t, size_t number, bool *found) {
  char path[FOLDER_PATH];
  file_source source;
  file_table table = {0};
  grid_file_form f;
  ylm_grid_form form;
  ylm_grid_stats stats;
  uint32_t *lattice = NULL;
  ylm__folder_brick(t->set->folder, t->set->brick[number].code, "ylm", path);
  ylm_status s = ylm__file_source_open(&source, path, t->e);
  if (s == YLM_OK) s = ylm__file_table_read(&table, &source, t->e);
  if (s == YLM_OK) s = ylm__file_table_form(&table, &source, &f, &form, &stats, t->e);
  const grid_file_entry *entry =
      s == YLM_OK ? ylm__file_table_find(&table, GRID_FILE_lattice) : NULL;
  *found = entry != NULL;
  if (entry) {
    size_t record = 3 * sizeof *lattice;
    lattice = ylm_alloc(entry->size / record, record);
    s = lattice ? ylm__file_table_take(&table, &source, GRID_FILE_lattice, record,
                                       f.evaluated * record, lattice, t->e)
                : no_memory(t);
  }
  if (entry && s == YLM_OK && (!f.octree_cells || f.octree_cells > f.cells)) s = other_files(t);
  if (entry && s == YLM_OK) {
    count(t, &t->part[number], f.cells, f.octree_cells, f.evaluated, f.points);
    s = count_points(t, number, lattice, f.evaluated);
  }
  ylm_free(lattice);
  ylm_free(table.entry);
  ylm__file_source_close(&source);
  return s;
}

static ylm_status look_at_brick(filing *t, size_t number) {
  bool found;
  const ylm_grid *g;
  ylm_status s = look_at_file(t, number, &found);
  if (s != YLM_OK || found) return s;
  s = ylm__set_get(t->set, number, t->threads, &g, t->e);
  if (s != YLM_OK) return s;
  count(t, &t->part[number], g->cells, g->contents.octree_cells, g->evaluated, g->points);
  return count_points(t, number, g->lattice, g->evaluated);
}

/* The bricks in the order of the top's cells. */
static void order_bricks(filing *t) {
  const ylm_grid *top = t->set->top;
  for (size_t i = 0, n = 0; i < top->contents.octree_cells; i++) {
    uint32_t k = t->set->number[i];
    if (k == t->set->bricks) continue;
    t->part[k].cell = (uint32_t)i;
    t->order[n++] = k;
  }
}

static ylm_status count_all(filing *t) {
  const ylm_grid *top = t->set->top;
  ylm_status s = YLM_OK;
  t->octree = top->contents.octree_cells;
  t->added = top->cells - t->octree;
  t->born = top->points - top->evaluated;
  for (size_t i = 0; i < top->evaluated && s == YLM_OK; i++)
    s = share_point(t, top->lattice + 3 * i);
  for (size_t i = 0; i < t->set->bricks && s == YLM_OK; i++) {
    t->part[t->order[i]].first = t->g->points;
    s = look_at_brick(t, t->order[i]);
    if (s == YLM_OK) s = report(t);
    if (s == YLM_OK &&
        (t->g->points + t->born >= YLM_GRID_NONE || t->octree + t->added >= YLM_GRID_NONE))
      s = ylm_fail_plain(t->e, YLM_ELIMIT);
  }
  t->g->evaluated = t->g->points;
  t->g->points += t->born;
  t->g->contents.octree_cells = t->octree;
  t->g->cells = t->octree + t->added;
  t->octree = t->added = t->born = 0;
  return s;
}

/* A brick that is one leaf, but for what continuity has added. */
static bool is_leaf(const filing *t, uint32_t number) {
  return number < t->set->bricks && t->part[number].octree == 1;
}

/* Where cells were added for leaves of the top: to be known before the leaves are put. */
static ylm_status place_groups(filing *t) {
  const ylm_grid *top = t->set->top;
  size_t octree = top->contents.octree_cells, last = octree, own = top->cells;
  uint64_t next = t->g->contents.octree_cells;
  for (size_t i = 0; i < octree; i++) { /* groups follow one another as their leaves do */
    if (top->cell[i].child < octree) continue;
    if (top->cell[i].child < last) return other_files(t);
    last = top->cell[i].child;
  }
  for (size_t i = octree; i > 0; i--) { /* how many cells each has */
    t->group[i - 1] = 0;
    if (top->cell[i - 1].child < octree) continue;
    t->group[i - 1] = own - top->cell[i - 1].child;
    own = top->cell[i - 1].child;
  }
  for (size_t i = 0; i < octree; i++) {
    uint64_t cells =
        is_leaf(t, t->set->number[i]) ? t->part[t->set->number[i]].cells - 1 : t->group[i];
    t->group[i] = cells ? next : 0;
    next += cells;
  }
  return YLM_OK;
}

/* -- records -------------------------------------------------------------------------------------------- */

static uint32_t cell_of(const place *p, uint32_t i) {
  if (!i) return p->root;
  return (uint32_t)(i < p->from->contents.octree_cells ? p->base + i - 1
                                                       : p->added + i - p->from_added);
}

static uint32_t point_of(const filing *t, const place *p, uint32_t i) {
  if (i == YLM_GRID_NONE) return i;
  if (i < p->from->evaluated) return p->point ? p->point[i] : i;
  return (uint32_t)(t->g->evaluated + p->born + (i - p->from->evaluated) - p->from_born);
}

/* A cell as it stands in the file; children of the top's cells are set by it alone. */
static ylm_grid_cell cell_record(const filing *t, const place *p, size_t i) {
  ylm_grid_cell c = p->from->cell[i];
  bool added = i >= p->from->contents.octree_cells;
  for (int k = 0; k < 8; k++)
    c.corner[k] =
        added || c.corner[k] < p->from->evaluated ? point_of(t, p, c.corner[k]) : YLM_GRID_NONE;
  c.child = c.child ? cell_of(p, c.child) : 0;
  c.source = c.source ? cell_of(p, c.source) : p->source;
  return c;
}

static void count_cell(filing *t, const ylm_grid_cell *c, bool added) {
  ylm_grid_stats *s = &t->g->stats;
  if (added) {
    s->continuity += !c->child;
    return;
  }
  bool leaf = c->flags & YLM_GRID_LEAF;
  s->leaves += leaf;
  s->occupied += leaf && c->flags & YLM_GRID_OCCUPIED;
  if (c->level + 1u > s->levels) s->levels = c->level + 1u;
}

static void count_point(filing *t, uint8_t flags) {
  t->g->stats.invalid += (flags & YLM_GRID_POINT_INVALID) != 0;
  t->g->stats.tested += (flags & YLM_GRID_POINT_TESTED) != 0;
}

/* A piece in the making: records of a section, up to GRID_FILE_CHUNK bytes. */
typedef struct piece {
  filing *t;
  int kind;
  size_t bytes;
  ylm_status status;
} piece;

static void flush_piece(piece *q) {
  if (q->status == YLM_OK)
    q->status = ylm__file_pieces_put(q->t->file, q->kind, q->t->room, q->bytes, q->t->e);
  q->bytes = 0;
}

static char *put_record(piece *q, const void *record, size_t n) {
  if (q->bytes + n > GRID_FILE_CHUNK) flush_piece(q);
  char *to = q->t->room + q->bytes;
  memcpy(to, record, n);
  q->bytes += n;
  return to;
}

/* -- cells ---------------------------------------------------------------------------------------------- */

/* Cells of the top's octree, bricks among them. */
static ylm_status put_top_cells(filing *t) {
  const ylm_grid *top = t->set->top;
  size_t octree = top->contents.octree_cells;
  place p = {.from = top, .base = 1};
  piece q = {.t = t, .kind = GRID_FILE_cells};
  uint64_t next = octree;
  for (size_t i = 0; i < octree; i++) {
    uint32_t number = t->set->number[i];
    bool holds_brick = number < t->set->bricks, leaf = !holds_brick || is_leaf(t, number);
    ylm_grid_cell c = cell_record(t, &p, i);
    if (top->cell[i].child >= octree || (holds_brick && leaf)) c.child = (uint32_t)t->group[i];
    c.flags &= (uint8_t)~YLM_GRID_BRICK;
    if (holds_brick) c.detail = 0;
    if (!leaf) {
      c.child = (uint32_t)next;
      c.flags &= (uint8_t)~YLM_GRID_LEAF;
      next += t->part[number].octree - 1;
    }
    put_record(&q, &c, sizeof c);
    count_cell(t, &c, false);
  }
  flush_piece(&q);
  t->octree = octree;
  return q.status;
}

/* Cells first .. end-1 of a brick's octree, or of those that continuity has added. */
static ylm_status put_cells(filing *t, const place *p, size_t first, size_t end) {
  bool added = first >= p->from->contents.octree_cells;
  piece q = {.t = t, .kind = added ? GRID_FILE_ADDED : GRID_FILE_cells};
  for (size_t i = first; i < end; i++) {
    ylm_grid_cell c = cell_record(t, p, i);
    put_record(&q, &c, sizeof c);
    count_cell(t, &c, added);
  }
  flush_piece(&q);
  if (added)
    t->added += end - first;
  else
    t->octree += end - first;
  return q.status;
}

/* Births first .. end-1 of a brick or of the top. */
static ylm_status put_births(filing *t, const place *p, size_t first, size_t end) {
  piece q = {.t = t, .kind = GRID_FILE_births};
  for (size_t i = first; i < end; i++) {
    ylm_grid_birth b = p->from->birth[i];
    b.cell = cell_of(p, b.cell);
    put_record(&q, &b, sizeof b);
  }
  flush_piece(&q);
  t->born += end - first;
  return q.status;
}

/* All that continuity has added to a brick. */
static ylm_status put_added(filing *t, place *p) {
  const ylm_grid *g = p->from;
  p->from_added = g->contents.octree_cells;
  p->added = t->g->contents.octree_cells + t->added;
  p->born = t->born;
  ylm_status s = put_cells(t, p, g->contents.octree_cells, g->cells);
  return s == YLM_OK ? put_births(t, p, 0, g->points - g->evaluated) : s;
}

/* -- bricks --------------------------------------------------------------------------------------------- */

/* The brick, with the numbers of its points. */
static ylm_status get_brick(filing *t, uint32_t number, place *p) {
  const ylm_grid *g;
  const file_part *part = &t->part[number];
  uint64_t next = part->first;
  ylm_status s = ylm__set_get(t->set, number, t->threads, &g, t->e);
  if (s != YLM_OK) return s;
  if (g->cells != part->cells || g->contents.octree_cells != part->octree ||
      g->evaluated != part->evaluated || g->points != part->points ||
      g->cell[0].child > part->octree || (part->octree > 1 && g->cell[0].child != 1))
    return other_files(t);
  if (!ylm_list_reserve(&t->number, 0, g->evaluated, &t->number_room, sizeof *t->number))
    return no_memory(t);
  for (size_t i = 0; i < g->evaluated; i++) {
    const uint32_t *at = g->lattice + 3 * i;
    bool shared = is_shared(t, &t->set->brick[number], at);
    t->number[i] = shared ? ylm__lattice_hash_find(&t->shared, lattice_key(at)) : (uint32_t)next;
    if (t->number[i] == YLM_GRID_NONE) return other_files(t);
    next += t->number[i] == next;
  }
  *p = (place){.from = g, .point = t->number, .root = part->cell, .base = t->octree};
  p->source = t->set->top->cell[part->cell].source;
  return YLM_OK;
}

/* Records of a section of the points that are new. */
static ylm_status put_column(filing *t, const place *p, int kind, const void *from, size_t record) {
  piece q = {.t = t, .kind = kind};
  uint64_t next = t->points;
  const ylm_grid *g = p->from;
  for (size_t i = 0; i < g->evaluated; i++) {
    if ((p->point ? p->point[i] : i) != next) continue;
    next++;
    char *to = put_record(&q, (const char *)from + i * record, record);
    for (size_t r = 0; kind == GRID_FILE_rows && r < g->rows; r++)
      memset(to + (r * g->stride + g->width) * sizeof(float), 0,
             (g->stride - g->width) * sizeof(float));
    if (kind == GRID_FILE_flags) count_point(t, g->flags[i]);
  }
  flush_piece(&q);
  if (kind == GRID_FILE_rows) t->points = next;
  return q.status;
}

/* The points that no brick before has. */
static ylm_status put_points(filing *t, const place *p) {
  const ylm_grid *g = p->from;
  ylm_status s = put_column(t, p, GRID_FILE_lattice, g->lattice, 3 * sizeof *g->lattice);
  if (s == YLM_OK) s = put_column(t, p, GRID_FILE_lambda, g->lambda, sizeof *g->lambda);
  if (s == YLM_OK) s = put_column(t, p, GRID_FILE_norm, g->norm, sizeof *g->norm);
  if (s == YLM_OK) s = put_column(t, p, GRID_FILE_flags, g->flags, 1);
  if (s == YLM_OK && g->validity)
    s = put_column(t, p, GRID_FILE_validity, g->validity, sizeof *g->validity);
  if (s != YLM_OK) return s;
  return put_column(t, p, GRID_FILE_rows, g->data, ylm__grid_record(g) * sizeof *g->data);
}

/* Cells that were added for the leaves of the top, and for bricks that are leaves. */
static ylm_status put_top_added(filing *t) {
  const ylm_grid *top = t->set->top;
  size_t octree = top->contents.octree_cells, cells = octree, born = 0;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < octree && s == YLM_OK; i++) {
    place p = {.from = top, .base = 1};
    uint32_t number = t->set->number[i];
    if (is_leaf(t, number)) {
      s = get_brick(t, number, &p);
      if (s == YLM_OK) s = put_added(t, &p);
      continue;
    }
    if (top->cell[i].child < octree) continue;
    size_t next = i + 1, births = born;
    while (next < octree && top->cell[next].child < octree) next++;
    size_t end = next < octree ? top->cell[next].child : top->cells;
    while (births < top->points - top->evaluated &&
           (top->birth[births].cell == i ||
            (top->birth[births].cell >= cells && top->birth[births].cell < end)))
      births++;
    p.from_added = cells;
    p.added = t->group[i];
    p.from_born = born;
    p.born = t->born;
    s = put_cells(t, &p, cells, end);
    if (s == YLM_OK) s = put_births(t, &p, born, births);
    cells = end;
    born = births;
  }
  return s;
}

static ylm_status put_brick(filing *t, uint32_t number) {
  place p;
  ylm_status s = get_brick(t, number, &p);
  if (s == YLM_OK) s = put_points(t, &p);
  if (s != YLM_OK || is_leaf(t, number)) return s;
  p.added = t->g->contents.octree_cells + t->added; /* leaves name what is behind them */
  p.from_added = p.from->contents.octree_cells;
  s = put_cells(t, &p, 1, p.from->contents.octree_cells);
  return s == YLM_OK ? put_added(t, &p) : s;
}

static ylm_status put_all(filing *t) {
  static const float padding[ROW_PADDING];
  place top = {.from = t->set->top, .base = 1};
  ylm_status s = put_points(t, &top);
  if (s == YLM_OK) s = put_top_cells(t);
  if (s == YLM_OK) s = put_top_added(t);
  for (size_t i = 0; i < t->set->bricks && s == YLM_OK; i++) {
    s = report(t);
    if (s == YLM_OK) s = put_brick(t, t->order[i]);
  }
  if (s == YLM_OK) s = ylm__file_pieces_put(t->file, GRID_FILE_rows, padding, sizeof padding, t->e);
  return s == YLM_OK && !ylm__file_pieces_whole(t->file) ? other_files(t) : s;
}

/* -- the whole ------------------------------------------------------------------------------------------ */

/* Room for all, and a grid that has no cells. */
static ylm_status begin(filing *t) {
  size_t bricks = t->set->bricks, record = ylm__grid_record(t->set->top) * sizeof(float);
  const ylm_grid *top = t->set->top;
  t->g = ylm__grid_new(&top->contents.form);
  t->part = ylm_alloc_zero(bricks, sizeof *t->part);
  t->order = ylm_alloc(bricks, sizeof *t->order);
  t->group = ylm_alloc(top->contents.octree_cells, sizeof *t->group);
  t->room = ylm_alloc(GRID_FILE_CHUNK + record, 1);
  if (t->g && top->validity) t->g->validity = ylm_alloc(1, sizeof *t->g->validity);
  if (!t->g || !t->part || !t->order || !t->group || !t->room || (top->validity && !t->g->validity))
    return no_memory(t);
  ylm__pack_stats(t->g, top);
  order_bricks(t);
  return YLM_OK;
}

static ylm_status write_file(filing *t, const char *path) {
  ylm_status s = begin(t);
  if (s == YLM_OK) s = count_all(t);
  if (s == YLM_OK) s = place_groups(t);
  if (s == YLM_OK) s = ylm__file_pieces_begin(t->g, path, &t->file, t->e);
  if (s == YLM_OK) s = put_all(t);
  if (s != YLM_OK) {
    ylm__file_pieces_discard(t->file);
    return s;
  }
  s = ylm__set_report(t->set, t->progress, t->done, 2 * t->set->bricks, "packing");
  if (s == YLM_OK) return ylm__file_pieces_end(t->file, t->e);
  ylm__file_pieces_discard(t->file);
  return s;
}

ylm_status ylm_grid_set_write(ylm_grid_set *set, const char *path, int threads,
                              const ylm_progress *progress, ylm_error *e) {
  filing t = {.set = set, .progress = progress, .threads = threads, .e = e};
  pthread_mutex_lock(&set->lock);
  ylm_status s = write_file(&t, path);
  pthread_mutex_unlock(&set->lock);
  ylm_grid_free(t.g);
  ylm__lattice_hash_free(&t.shared);
  ylm_free(t.part);
  ylm_free(t.order);
  ylm_free(t.group);
  ylm_free(t.number);
  ylm_free(t.room);
  return s;
}
