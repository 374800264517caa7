/*
** probes.h - a grid's light as engines take it: irradiance as polynomials of the normal, at the corners of bricks.
**
** The bounds are cut into equal roots, each of which is an octree. A leaf has a brick for each part of its free space: eight points,
** between which light is interpolated along the axes. Planes cut a leaf of several bricks: the sides of them that a place is on
** name its brick.
*/
#ifndef YLM_GRID_PROBES_H
#define YLM_GRID_PROBES_H

#include "../grid.h"

#define PROBES_SPLIT 255 /* in the place of a leaf's bricks: the cell has eight children */
#define PROBES_SUB 4
#define PROBES_PIECES 64
#define PROBES_PARTS 15 /* bricks of a leaf, at most */
#define PROBES_PLANES 4 /* that cut a leaf, at most */
/* Of a leaf's edge: how far in front of a surface its brick is looked for. */
#define PROBES_FRONT 0.1875
#define PROBES_DEPTH 19      /* splits below a root, at most */
#define PROBES_NORMAL 127.0  /* a plane's normal of length 1, in edges of the leaf */
#define PROBES_OFFSET 8192.0 /* its distance of one edge from the leaf's origin */

/* Planes tell the bricks of a leaf: bit k of an index into `part` is whether normal[k] . place >= offset[k], in edges. */
typedef struct probes_cut {
  uint8_t planes, part[1 << PROBES_PLANES];
  int8_t normal[PROBES_PLANES][3];
  int16_t offset[PROBES_PLANES];
} probes_cut;

struct ylm_grid_probes {
  double bounds[6];
  uint32_t roots[3];
  int lmax, count; /* 1 or 2; (lmax+1)^2 numbers of a channel */
  int quantity;    /* ylm_quantity: the light that it is of */
  size_t cells, several, bricks, points;
  uint8_t *parts;        /* [cells] bricks of a leaf, 0: nothing of it is free; PROBES_SPLIT */
  uint32_t *first;       /* [cells] the first child; of a leaf its first brick */
  uint32_t *row;         /* [cells] of `cut`; YLM_GRID_NONE: one brick, or none */
  probes_cut *cut;       /* [several] */
  uint32_t (*corner)[8]; /* [bricks] points, x fastest */
  float *value;          /* [points][3][count] */
  /* Of probes that were not read from a file: */
  uint32_t (*tie)
      [4]; /* [points] those that it is the mean of; the first YLM_GRID_NONE: none. NULL: not yet looked for */
  uint8_t *ghost;   /* [points] 1: it stands for a corner that the brick does not see */
  uint32_t *source; /* [cells] the leaf of the grid; YLM_GRID_NONE: none */
  uint8_t (*piece)[PROBES_PIECES]; /* [several] the brick of each of 4 x 4 x 4 pieces, x fastest */
  uint8_t (*brick_of)[YLM_GRID_PARTS]; /* [several] of the grid's parts; 255: none */
};

/* Where irradiance is read: a brick, and the place in it; YLM_GRID_NONE: it is dark. */
typedef struct probes_place {
  uint32_t brick;
  float t[3];
} probes_place;

/* A place in front of a surface: its leaf, and where it and what it is in front of are, in edges of that. */
typedef struct probes_front {
  uint32_t cell;
  double at[3], front[3];
} probes_front;

/* look.c. The normal NULL: in free space. */
probes_front ylm__probes_front(const ylm_grid_probes *p, const double x[3], const float normal[3]);
/* The brick, among those of its leaf, of a place in edges. */
uint8_t ylm__probes_side(const probes_cut *c, const double at[3]);
probes_place ylm__probes_find(const ylm_grid_probes *p, const double x[3], const float normal[3]);
/* The weights of the eight points of a place. */
void ylm__probes_shares(const probes_place *at, float share[8]);
/* Finds planes between the bricks of leaves: at places of surfaces, the grid says by rays which brick is theirs. `walls` and `at` may
   be NULL: then pieces alone say so. cut.c */
ylm_status ylm__probes_cut(const ylm_grid *g, const ylm_grid_walls *walls,
                           const ylm_grid_probes_places *at, ylm_grid_probes *p);
/* Cells on the lattice of the corners of the smallest. names.c */
typedef struct probes_lattice {
  uint32_t (*at)[3]; /* [cells] the lower corner */
  uint8_t *level;    /* [cells] */
  uint32_t deepest;
} probes_lattice;

#define PROBES_MEANS 0x80000000u

/* The corners of bricks as files have them. */
typedef struct probes_names {
  uint8_t *mask; /* [bricks] which corners are named */
  uint32_t *
      name; /* [names] numbers of points, or of means behind them; the first two there: a mean of two, of four follows */
  uint32_t *
      number; /* [points] in the file; of means PROBES_MEANS and more; YLM_GRID_NONE: it is in no brick */
  size_t names, points, means;
  int bits; /* of a name */
} probes_names;

/* Names of a file. */
typedef struct probes_packed {
  const unsigned char *data;
  size_t n;
  int bits;
} probes_packed;

/* YLM_ENOMEM; YLM_ELIMIT: the cells are too small. */
ylm_status ylm__probes_lattice(const ylm_grid_probes *p, probes_lattice *l);
void ylm__probes_lattice_free(probes_lattice *l);
/* The key of a place of the lattice, 60 bits. */
uint64_t ylm__probes_key(const uint32_t at[3]);
/* That of corner k of a cell. */
uint64_t ylm__probes_corner(const probes_lattice *l, size_t cell, uint32_t k);
ylm_status ylm__probes_name(const ylm_grid_probes *p, probes_names *n);
void ylm__probes_names_free(probes_names *n);
/* Bits of a name of so many points and means. */
int ylm__probes_name_bits(size_t points);
uint32_t ylm__probes_packed(const probes_packed *p, size_t i);
/* Sets the corners of bricks; `points` grows by means, whose ends `tie` has then. YLM_EFORMAT, YLM_ENOMEM, YLM_ELIMIT. */
ylm_status ylm__probes_read_names(ylm_grid_probes *p, const unsigned char *mask,
                                  const probes_packed *packed);
/* Finds the corners that hang on larger leaves, once. tie.c */
ylm_status ylm__probes_tie(ylm_grid_probes *p);
/* Sets the values of tied points. */
void ylm__probes_follow_ties(ylm_grid_probes *p);
/* Points that are not tied. */
size_t ylm__probes_free_points(const ylm_grid_probes *p);

/* Takes the bricks from leaves that no place of a surface reads. unread.c */
ylm_status ylm__probes_drop_unread(ylm_grid_probes *p, const ylm_grid_probes_places *at);
/* Drops bricks that no place has, bricks that are the same as another of their leaf, and points of no brick. compact.c */
ylm_status ylm__probes_compact(ylm_grid_probes *p);
/* The polynomials of a normal: irradiance is the sum of theirs times the numbers. */
void ylm__probes_basis(const float normal[3], float basis[9]);
/* Their mean squares over all normals. */
extern const float ylm__probes_norm[9];

#endif
