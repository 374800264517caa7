/*
** file.h - grid files as they lie on the disk, and what their reader and writer share. docs/grids.md has the table.
**
** A file is a header of 64 bytes, a table of 64 bytes per section, and the sections. Each begins at a multiple of 64 bytes,
** with zeros between them. Numbers are little-endian. A section that a reader does not know is skipped, unless it is
** flagged as required: what a later feature needs in a file is a section of its own.
*/
#ifndef YLM_GRID_FILE_H
#define YLM_GRID_FILE_H

#include "../grid.h"
#include "../small/small.h"

#define GRID_FILE_ORDER 0x01020304u
#define GRID_FILE_VERSION 2u
#define GRID_FILE_BOUND 64u     /* sections begin at multiples of it */
#define GRID_FILE_SECTIONS 256u /* at most */
#define GRID_FILE_REQUIRED 1u   /* flag of a section: readers that do not know it refuse the file */
#define GRID_FILE_LEAST 32u     /* bytes of a header, up to the size */
#define GRID_FILE_CHUNK (1u << 18) /* bytes that are copied and summed while they are in cache */

typedef struct grid_file_header {
  char magic[8];
  uint32_t order, version;
  uint64_t size; /* of the file */
  uint32_t sections, zero;
  uint64_t zeros[3];
  uint64_t crc; /* of the 56 bytes before, then of the table */
} grid_file_header;

typedef struct grid_file_entry {
  char name[YLM_GRID_SECTION_NAME]; /* the rest is zero */
  uint64_t offset, size;
  uint32_t record, flags; /* bytes of one record */
  uint64_t crc;
  uint64_t zero;
} grid_file_entry;

/* Section "form". */
typedef struct grid_file_form {
  uint32_t kind, lmax, channels, metric_channels, depth, metric, continuous, lattice[3];
  double bounds[6], threshold, tolerance;
  uint64_t cells, octree_cells, points, evaluated;
} grid_file_form;

/* Section "stats", named as in ylm_grid_stats: numbers that the grid itself lacks, and counts for
   readers of the header. */
#define GRID_FILE_STATS(X)                                                                         \
  X(uint64_t, pairs)                                                                               \
  X(uint64_t, outside)                                                                             \
  X(uint64_t, verified)                                                                            \
  X(uint64_t, rounds)                                                                              \
  X(uint64_t, leaves)                                                                              \
  X(uint64_t, occupied)                                                                            \
  X(uint64_t, levels)                                                                              \
  X(uint64_t, continuity)                                                                          \
  X(uint64_t, invalid)                                                                             \
  X(uint64_t, tested)                                                                              \
  X(double, error)                                                                                 \
  X(double, largest_error)                                                                         \
  X(uint32_t, met)                                                                                 \
  X(uint32_t, limited)
typedef struct grid_file_stats {
#define X(type, name) type name;
  GRID_FILE_STATS(X)
#undef X
} grid_file_stats;

/* Section "brick": the cell that the grid is the subtree of. */
typedef struct grid_file_brick {
  uint32_t level, origin[3];
} grid_file_brick;

/* Section "measure". */
typedef struct grid_file_measure {
  uint32_t measure, zero;
  uint64_t zeros;
} grid_file_measure;

_Static_assert(sizeof(small_head) == 64 && sizeof(ylm_grid_small_report) == 72 &&
                   sizeof(grid_file_measure) == 16 && sizeof(ylm_grid_body) == 40 &&
                   sizeof(ylm_grid_prints) == 32 && sizeof(grid_file_brick) == 16 &&
                   sizeof(grid_file_header) == 64 && sizeof(grid_file_entry) == 64 &&
                   sizeof(grid_file_form) == 136 && sizeof(grid_file_stats) == 104 &&
                   sizeof(ylm_grid_cell) == 64 && sizeof(ylm_grid_birth) == 8 &&
                   sizeof(ylm_grid_side) == 120,
               "a record of grid files has padding");

/* The sections of a grid, in their order in the file: name, bytes of a record, required. `rows` are
   the evaluated points' [4][stride], of a grid with sides [1][stride], the stride a multiple of 8, and ROW_PADDING zeros
   behind. `sides`, which only such a grid has, are its leaves that surfaces cross, `nodes` the corners of their parts,
   `ghosts` where the field was asked for the last of the evaluated points, which are flagged as such. The
   sections behind `rows` are left out where they would say nothing: quantity "lights", measure
   "coefficients", the validity of points that nobody told, no floor, no body, no
   fingerprints, and the brick that a whole grid is not. A file of few bytes has the sections `small...` instead of those
   from `cells` to `rows`, `validity`, `sides`, `nodes` and `ghosts`. */
#define GRID_FILE_LIST(X)                                                                          \
  X(form, sizeof(grid_file_form), true)                                                            \
  X(stats, sizeof(grid_file_stats), false)                                                         \
  X(cells, sizeof(ylm_grid_cell), true)                                                            \
  X(lattice, 3 * sizeof(uint32_t), true)                                                           \
  X(lambda, sizeof(float), true)                                                                   \
  X(norm, sizeof(float), true)                                                                     \
  X(flags, 1, true)                                                                                \
  X(births, sizeof(ylm_grid_birth), true)                                                          \
  X(rows, ylm__grid_record(g) * sizeof(float), true)                                               \
  X(quantity, sizeof(uint32_t), false)                                                             \
  X(measure, sizeof(grid_file_measure), false)                                                     \
  X(validity, sizeof(float), false)                                                                \
  X(floor, sizeof(double), false)                                                                  \
  X(body, sizeof(ylm_grid_body), false)                                                            \
  X(prints, sizeof(ylm_grid_prints), false)                                                        \
  X(brick, sizeof(grid_file_brick), true)                                                          \
  X(sides, sizeof(ylm_grid_side), true)                                                            \
  X(nodes, 8 * sizeof(uint32_t), true)                                                             \
  X(ghosts, 3 * sizeof(float), true)                                                               \
  X(small, sizeof(small_head), true)                                                               \
  X(small_tree, 1, true)                                                                           \
  X(small_bases, 1, true)                                                                          \
  X(small_tables, 1, true)                                                                         \
  X(small_points, 1, true)                                                                         \
  X(small_numbers, 1, true)                                                                        \
  X(small_bits, 1, true)                                                                           \
  X(small_report, sizeof(ylm_grid_small_report), false)

enum {
#define X(name, record, required) GRID_FILE_##name,
  GRID_FILE_LIST(X)
#undef X
      GRID_FILE_COUNT
};

/* Offset -> the next place where a section may begin. */
static inline uint64_t grid_file_bound(uint64_t at) {
  return (at + GRID_FILE_BOUND - 1) / GRID_FILE_BOUND * GRID_FILE_BOUND;
}

/* YLM_EFORMAT where this machine's numbers are not those of the file. file.c */
ylm_status ylm__grid_file_machine(const char *name, ylm_error *e);
/* "NAME: not a valid grid: WHAT". file.c */
ylm_status ylm__grid_file_bad(const char *name, const char *what, ylm_error *e);

/* -- source.c: bytes of a file or of memory ---------------------------------------- */

typedef struct file_source {
  const char *name;
  FILE *file;                /* NULL: memory */
  const unsigned char *data; /* [size] of memory */
  uint64_t size;
} file_source;
/* A file, or bytes; both look at magic, byte order, version and size. */
ylm_status ylm__file_source_open(file_source *s, const char *path, ylm_error *e);
ylm_status ylm__file_source_memory(file_source *s, const char *name, const unsigned char *data,
                                   size_t size, ylm_error *e);
void ylm__file_source_close(file_source *s);
/* n bytes from offset `at`, which lie in the file; adds to *crc (may be NULL). *finite (may be NULL; crc is there then) becomes
   false where a float among them is not a finite number. */
ylm_status ylm__file_source_read(const file_source *s, uint64_t at, size_t n, void *to,
                                 uint64_t *crc, bool *finite, ylm_error *e);

/* -- table.c: the sections of a file ------------------------------------------------ */

typedef struct file_table {
  size_t sections;
  grid_file_entry *entry;
} file_table;
/* Header and table, checked: nothing overlaps or lies outside. The caller frees t->entry. */
ylm_status ylm__file_table_read(file_table *t, const file_source *s, ylm_error *e);
/* The place of a section among those of GRID_FILE_LIST, GRID_FILE_COUNT: unknown. */
int ylm__file_table_kind(const grid_file_entry *entry);
/* The entry of a section; NULL: there is none. */
const grid_file_entry *ylm__file_table_find(const file_table *t, int kind);
/* A section whose size is `bytes`, of records of `record` bytes, to `to`; checks its sum. */
ylm_status ylm__file_table_take(const file_table *t, const file_source *s, int kind, size_t record,
                                size_t bytes, void *to, ylm_error *e);
/* ylm__file_table_take of floats; *finite as of ylm__file_source_read. */
ylm_status ylm__file_table_take_floats(const file_table *t, const file_source *s, int kind,
                                       size_t record, size_t bytes, float *to, bool *finite,
                                       ylm_error *e);
/* Form and stats; those of a file without the section stats are 0, errors NaN. */
ylm_status ylm__file_table_form(const file_table *t, const file_source *s, grid_file_form *form,
                                ylm_grid_form *out, ylm_grid_stats *stats, ylm_error *e);

/* -- write.c ------------------------------------------------------------------------- */

/* The file of a grid: small NULL: all its sections as they are; else those of few bytes. */
ylm_status ylm__grid_file_encode(const ylm_grid *g, const small_packed *small, unsigned char **data,
                                 size_t *size, ylm_error *e);
/* Bytes of a file of few bytes. */
/* Whether few bytes can be asked of a grid whose own error is known, or NAN. */
ylm_status ylm__grid_file_check_small(const ylm_grid *g, double error, const ylm_grid_small *how,
                                      ylm_error *e);
/* Gives a grid in the making the facts that its file says. */
void ylm__grid_file_describe_small(ylm_grid *g, const ylm_grid_small *how,
                                   const ylm_grid_small_report *r);
uint64_t ylm__grid_file_small_size(const ylm_grid *g, const small_packed *small);

/*
** A file whose sections are written piece by piece, several at a time, each in its order. The grid has form, counts and stats;
** cells and points need not be there. It lives as long as the file is under way.
*/
typedef struct file_pieces file_pieces;
#define GRID_FILE_ADDED GRID_FILE_COUNT /* the cells behind those of the octree */
ylm_status ylm__file_pieces_begin(const ylm_grid *g, const char *path, file_pieces **out,
                                  ylm_error *e);
/* n bytes of a section from `cells` to `rows`, of `validity`, or of GRID_FILE_ADDED. */
ylm_status ylm__file_pieces_put(file_pieces *f, int kind, const void *bytes, size_t n,
                                ylm_error *e);
/* Whether all that was put is all that the counts say. */
bool ylm__file_pieces_whole(const file_pieces *f);
/* The other sections, of the grid as it is now, and the end of the file; frees f. */
ylm_status ylm__file_pieces_end(file_pieces *f, ylm_error *e);
void ylm__file_pieces_discard(file_pieces *f);

/* -- readers ------------------------------------------------------------------------- */

/* Memory that the rows of a grid were in, for those of the next: pages that need no clearing. */
typedef struct grid_file_room {
  float *data;
  size_t bytes;
} grid_file_room;
/* `room` is taken where it is not NULL and has any; interpolated rows are made by so many threads, 0: all. */
ylm_status ylm__grid_file_read_source(const file_source *s, grid_file_room *room, int threads,
                                      ylm_grid **out, ylm_error *e);
/* As ylm_grid_read. file.c */
ylm_status ylm__grid_file_read(const char *path, grid_file_room *room, int threads, ylm_grid **g,
                               ylm_error *e);

/* -- check.c: what no grid may have --------------------------------------------------- */

/* Whether cells and points of a grid that was read hold, all of whose points have their lattice
   coordinates: YLM_EFORMAT, YLM_ENOMEM where there is no room to look. */
ylm_status ylm__grid_file_check_cells(const ylm_grid *g, const char *name, ylm_error *e);
/* The error in the sides of a grid, or NULL: needs cells and points that hold, but for their corners. */
const char *ylm__grid_file_check_sides(const ylm_grid *g);
/* The error in lambda and norm of evaluated points, or NULL. */
const char *ylm__grid_file_check_points(const ylm_grid *g);
/* The error in births, and in the range of cells' corners, or NULL; needs no check of cells
   before. */
const char *ylm__grid_file_check_births(const ylm_grid *g);
/* A uniform grid's table must be in proportion to the cells that the file holds. */
bool ylm__grid_file_table_holds(const ylm_grid *g, uint64_t cells);
/* Gives interpolated points flags and lattice coordinates from their births. */
void ylm__grid_file_place_births(ylm_grid *g);
/* Stats without the times of a bake, which files do not have. */
void ylm__grid_file_forget_times(ylm_grid_stats *s);
/* The hash of evaluated points, sources, table, counts. */
ylm_status ylm__grid_file_finish(ylm_grid *g);

#endif
