/* gather.h - what the files of the gathered field share. Private to csrc/transfer. */
#ifndef YLM_TRANSFER_GATHER_H
#define YLM_TRANSFER_GATHER_H

#include <math.h>
#include <stdatomic.h>

#include "calibration.h"
#include "ylm_sh.h"
#include "ylm_transfer.h"

/* -- lattice.c: cells of all directions, the same everywhere ----------------------------------- */

/* A border of two cells that lie side by side: a line of one coordinate of a face of the cube, from `from` on,
   `size` long, in the finest cells' edges. Cells are split along it in quarters. */
typedef struct gather_border {
  uint32_t low, high; /* cells on both sides: `high` where the coordinate is larger */
  uint16_t line, from, size;
  uint8_t face, across;        /* that coordinate: 0 is u, 1 is v */
  uint8_t side_low, side_high; /* which of their edges it is */
} gather_border;

/* Edges of a cell. */
enum { LEAST_U, MOST_U, LEAST_V, MOST_V };

/* A border as sums want it. */
typedef struct gather_line {
  float at[3], length; /* its middle */
  float across[3];     /* the normal of its great circle, to `high` */
} gather_line;

/* Where a cell is: face, level, and its place among as large ones. */
typedef struct gather_place {
  uint8_t face, level;
  uint16_t i, j;
} gather_place;

typedef struct gather_lattice {
  int base, levels;
  size_t cells, borders, fine; /* of the base; fine: finest cells along a face's edge */
  float *tangent;              /* [2 fine + 1] tan(u pi/4), u from -1 to 1 */
  float (*direction)[3];       /* [cells] of their centres, length 1 */
  float *angle;                /* [cells] solid angles, sr */
  gather_border *border;       /* [borders] */
  gather_line *line;           /* [borders] */
  /* of lines of a face: cosine and sine of the angle to its axis [fine + 1][2]; and of their parts, `part` of the
     finest cells' edges long, towards the axis, across, along, and the length [fine + 1][fine/part][4] */
  float (*turn)[2], (*piece)[4];
  size_t part;
} gather_lattice;

/* `lines`: derivatives will be wanted. YLM_ENOMEM; to be freed in any case. */
ylm_status ylm__gather_lattice_create(int base, int levels, bool lines, gather_lattice *l);
void ylm__gather_lattice_free(gather_lattice *l);
/* Direction of length 1 at a place of a face, in halves of the finest cells. */
void ylm__gather_direction(const gather_lattice *l, int face, size_t u, size_t v, float out[3]);
/* Directions of length 1 and solid angles of the 16 children of a cell. */
void ylm__gather_children_of(const gather_lattice *l, gather_place p, float (*out)[4]);
/* Of any border; `l` must have pieces. */
void ylm__gather_line(const gather_lattice *l, const gather_border *b, gather_line *out);
/* Its two Gauss points. */
void ylm__gather_gauss(const gather_lattice *l, const gather_border *b, float at[2][3]);

/* -- cells.c: what a point sees ---------------------------------------------------------------- */

/* The element that fills a cell, and its distance; or the first of 16 cells that it is split into. */
typedef struct gather_cell {
  uint32_t element;
  float distance;
} gather_cell;

#define GATHER_SPLIT 0x80000000u

static inline bool ylm__gather_is_split(const gather_cell *c) { return c->element & GATHER_SPLIT; }
static inline uint32_t ylm__gather_children(const gather_cell *c) {
  return c->element & ~GATHER_SPLIT;
}

struct gather_memory;
typedef struct gather_lamps gather_lamps;

struct ylm_gather {
  ylm_field field;
  ylm_gather_form form;
  const ylm_radiosity *radiosity;
  const ylm_transfer *transfer;
  const ylm_scene *scene;
  size_t elements;
  float spacing;
  float (*normal)[3]; /* [elements], for YLM_GATHER_POINTS; else NULL */
  gather_lattice lattice;
  size_t most;                  /* cells of a point */
  struct gather_memory *memory; /* NULL: nothing is remembered */
  gather_lamps *lamps;          /* of direct light; NULL: it is not asked for */
  atomic_uint_fast64_t points, rays, shadow_rays, invalid;
};

/* The memory of one thread, and one point in it. */
typedef struct gather_sight {
  const ylm_gather *g;
  float at[3];
  size_t cells, splits;
  gather_cell *cell;     /* [most] */
  gather_place *place;   /* [most] */
  float (*toward)[4];    /* [most] direction and solid angle, of cells that are not of the base */
  float (*radiance)[4];  /* [most] and 1/max(distance, spacing) */
  uint32_t *split;       /* [most/16] cells that are split, in the order of their children */
  float *contrast;       /* [most] to a neighbour, the largest */
  float *sorted;         /* [most] */
  float mean[3], buried; /* radiance; share of the directions that see sides that are not used */
  uint64_t rays;
} gather_sight;

/* The most cells of a point. */
size_t ylm__gather_most(const gather_lattice *l);
gather_sight *ylm__gather_sight_create(const ylm_gather *g);
void ylm__gather_sight_free(gather_sight *v);
/* Looks around from a point, or remembers. YLM_OK, YLM_ENOMEM */
ylm_status ylm__gather_look(gather_sight *v, const float at[3]);
/* Places and directions of the children of cell i, which are the cells from `first` on. */
void ylm__gather_place_children(gather_sight *v, size_t i, size_t first);
/* Looks with the base's cells alone: `buried`. */
void ylm__gather_glance(gather_sight *v, const float at[3]);

/* Borders that follow one another on a line, n is 1 or 4, whose cells may be split. `line` is NULL where they are not of
   the base. */
typedef void gather_visit(gather_sight *v, int n, const gather_border *b, const gather_line *line,
                          void *context);
/* All borders of the base, and all within cells that are split, always in the same order. */
void ylm__gather_borders(gather_sight *v, gather_visit *visit, void *context);
/* Whether a cell of the border is split: then it has quarters, of which *part is the q-th. */
static inline bool ylm__gather_is_parted(const gather_sight *v, const gather_border *b) {
  return ylm__gather_is_split(&v->cell[b->low]) || ylm__gather_is_split(&v->cell[b->high]);
}
gather_border ylm__gather_quarter(const gather_sight *v, const gather_border *b, uint32_t q);

/* -- keep.c: points that are remembered -------------------------------------------------------- */

ylm_status ylm__gather_memory_create(struct gather_memory **m);
void ylm__gather_memory_free(struct gather_memory *m);
size_t ylm__gather_memory_bytes(struct gather_memory *m);
/* Whether the cells of v->at were there. */
bool ylm__gather_recall(struct gather_memory *m, gather_sight *v);
ylm_status ylm__gather_keep(struct gather_memory *m, const gather_sight *v);

/* -- rows.c: the sums ------------------------------------------------------------------------- */

/* Numbers behind the end of rows that are summed. */
#define GATHER_SPARE 64

/*
** out[r][k] += sum over i of w[r][i] y[i][k], k < width
**
**   w  in  [rows][GATHER_BATCH], rows a multiple of 3
**   y  in  [n][stride] and GATHER_SPARE
*/
typedef void gather_rows_fn(size_t n, size_t rows, const float *w, size_t width, size_t stride,
                            const float *y, double *out);
/* The kernel of the instruction set in use. */
gather_rows_fn *ylm__gather_rows(void);

/* -- slopes.c: derivatives of harmonics -------------------------------------------------------- */

/* One term: out[of] += factor in[from] for axis `axis`. */
typedef struct gather_term {
  uint32_t of, from;
  double factor;
  int axis;
} gather_term;

/* The terms of (grad Y - 3 s Y)_b of degrees 0 .. lmax by Y of degrees 0 .. lmax + 1. */
typedef struct gather_slopes {
  size_t n;
  gather_term *term;
} gather_slopes;
/* YLM_ENOMEM; to be freed in any case. */
ylm_status ylm__gather_slopes_create(int lmax, gather_slopes *s);
void ylm__gather_slopes_free(gather_slopes *s);

/* -- sums.c: harmonics ------------------------------------------------------------------------- */

/* Sums that a query wants. */
typedef struct gather_want {
  int lmax;
  size_t count; /* (lmax+1)^2 */
  int channels; /* of values and gradients: 1, luminance, or 3 */
  int hessians; /* of Hessians: 0, 1 or 3 */
  bool gradient;
} gather_want;

/* Sums of one point, in double: value [channels][count], gradient [channels][3][count], hessian
   [hessians][6][count]. */
typedef struct gather_sums gather_sums;
gather_sums *ylm__gather_sums_create(const ylm_gather *g, const gather_want *want,
                                     const float *base, const gather_slopes *slopes);
void ylm__gather_sums_free(gather_sums *s);
/* Integrals of the basis over the base's cells: [cells][count] and GATHER_SPARE; NULL without memory. */
float *ylm__gather_base(const gather_lattice *l, int lmax);
void ylm__gather_sum(gather_sums *s, gather_sight *v);
/* Sets the derivatives to 0. */
void ylm__gather_flatten(gather_sums *s);
const double *ylm__gather_value(const gather_sums *s);
const double *ylm__gather_gradient(const gather_sums *s);
const double *ylm__gather_hessian(const gather_sums *s);

/* Adds sums of one point in the layout of fields: [channels][count], [..][3], [..][6]. */
void ylm__gather_add(gather_sums *s, const double *value, const double *gradient,
                     const double *hessian);

/* -- lamps.c, direct.c: light of lamps with shadows -------------------------------------------- */

ylm_status ylm__gather_light(const ylm_gather *g, const ylm_scene *scene, gather_lamps **lamps);
void ylm__gather_dark(gather_lamps *lamps);
/* Whether there is a sky that fills directions, its radiance in cell i of the base, and in a direction of length 1. */
const float *ylm__gather_sky_cell(const gather_lamps *l, size_t i);
void ylm__gather_sky(const gather_lamps *l, const float direction[3], float rgb[3]);

/* The memory of one thread. */
typedef struct gather_direct gather_direct;
gather_direct *ylm__gather_direct_create(const ylm_gather *g, const gather_lamps *lamps,
                                         const gather_want *want);
void ylm__gather_direct_free(gather_direct *d);
/* Adds the light of lamps to sums; `indirect`: about the scalar irradiance of what is there already. */
ylm_status ylm__gather_direct_light(gather_direct *d, const float at[3], double indirect,
                                    gather_sums *s, bool *inside, ylm_error *e);
/* Rays of the last point. */
uint64_t ylm__gather_direct_rays(const gather_direct *d);

/* -- field.c ------------------------------------------------------------------------------------- */

/* A field that is alike but for twice as many cells along the edges. */
ylm_status ylm__gather_finer(const ylm_gather *g, ylm_gather **out);

#endif
