/* tree.h - the tree of lamps: groups of lamps, and of such groups, from which lamps are drawn. Private
   to csrc/scene. */
#ifndef YLM_SCENE_TREE_H
#define YLM_SCENE_TREE_H

#include "calibration.h"
#include "ylm_scene.h"

/* Children of a node; each has a lane. */
#define SCENE_WIDTH 16
#define SCENE_WIDTH_BITS 4
/* Levels of 2^30 lamps, less one. */
#define SCENE_LEVELS 8

/* Light that leaves each child. Its power is luminance times area over pi, seen from where it is
   largest. Its place is the mean of its lamps', weighed by power, with the mean square of their distances. A ball of its
   radius holds them all. `facing` is the mean of the squared cosine at lamps towards v, v'Fv/|v|^2: xx, yy, zz, xy, xz, yz;
   spheres have 1 on all sides. */
typedef struct scene_node {
  float x[3][SCENE_WIDTH], power[SCENE_WIDTH], spread[SCENE_WIDTH], radius[SCENE_WIDTH];
  float facing[6][SCENE_WIDTH];
} scene_node;

/* Children of node i of a level are nodes 16 i .. 16 i + 15 of the level below; those of level 0 are
   slots, which hold lamps. All nodes are full but the last of their level, whose empty lanes have
   power 0. */
typedef struct scene_tree {
  size_t lamps; /* that may bring light */
  size_t levels, first[SCENE_LEVELS];
  double unit; /* of powers: that of the brightest lamp */
  scene_node *node;
  uint32_t *lamp; /* [lamps] of slots */
  uint32_t *slot; /* [all lamps]; UINT32_MAX: brings none */
  bool flat;      /* some are flat */
  bool horizons;  /* some have one */
} scene_tree;

/* Places that are put into order. */
typedef struct scene_item {
  float x[3];
  uint32_t lamp;
} scene_item;

/* -- order.c -------------------------------------------------------------------------------- */

/* Puts n lamps into the order of a tree's slots: those of a node lie close together. */
ylm_status ylm__scene_order(size_t n, scene_item *item);

/* -- tree.c --------------------------------------------------------------------------------- */

/* Fills s->tree where there are more lamps than are weighed one by one. */
ylm_status ylm__scene_plant(ylm_scene *s, size_t one_by_one);
void ylm__scene_free_tree(ylm_scene *s);

/* -- nodes.c -------------------------------------------------------------------------------- */

/* The children of a node as they are seen from a point. */
typedef struct scene_seen {
  /* about the luminous irradiance over pi that a child brings to the point, in units; above 0 wherever
     it may bring any */
  _Alignas(64) float weight[SCENE_WIDTH];
  _Alignas(64) float doubt[SCENE_WIDTH]; /* about how far that may be off */
  uint32_t live;                         /* bit i: weight i is above 0 */
  uint32_t doubtful;                     /* bit i: doubt i is above the limit */
  uint32_t near; /* bit i: the point is within SCENE_NEAR radii of child i */
} scene_seen;

/* Looks at the children of a node from x, a place with normal n. With n NULL x is a point in space,
   whose scalar irradiance counts. `flat`: `facing` does. `limit`: of doubts. */
typedef void ylm_scene_nodes_fn(const scene_node *node, bool flat, const float x[3], const float *n,
                                float limit, scene_seen *seen);
/* The kernel of the instruction set in use. */
ylm_scene_nodes_fn *ylm__scene_nodes(void);

/* -- draw.c --------------------------------------------------------------------------------- */

/* A node that is open: the weights of its children are sums over theirs where these are open too. */
typedef struct scene_open {
  scene_seen seen;
  double upto[SCENE_WIDTH]; /* sums of weights 0 .. i */
  uint32_t level, node;
  uint32_t parent, lane;
  uint8_t below[SCENE_WIDTH]; /* which of those that are open each child is; 0: none */
} scene_open;

/* The open nodes as they are seen from a chooser's point; the first is the root. */
typedef struct scene_cut {
  uint32_t n;
  scene_open open[SCENE_OPEN];
} scene_cut;

/* The largest number below 1. */
#define SCENE_BELOW_ONE 0x1.fffffffffffffp-1

/* Samples on their way to lamps. */
typedef struct scene_drawn {
  double at[SCENE_GROUP]; /* where in the tree, 0 .. 1, increasing; then within the lamp's part */
  double share[SCENE_GROUP]; /* how often the lamp is chosen; 0: there is none */
  uint32_t lamp[SCENE_GROUP];
} scene_drawn;

/* -- spheres.c ------------------------------------------------------------------------------- */

/* Rays to spheres, as ylm__scene_sphere_sample makes them. Numbers behind n, to the end of a
   vector, are read and of no use. */
typedef struct scene_spheres {
  float v[3][SCENE_GROUP], radius[SCENE_GROUP]; /* in: from the point to the centre */
  float u[2][SCENE_GROUP];                      /* in: the place on the sphere */
  float dir[3][SCENE_GROUP], far[SCENE_GROUP];
  float value[SCENE_GROUP]; /* the irradiance that it brings for radiance 1; -1: from inside */
} scene_spheres;

/* n <= SCENE_GROUP rays from a point with that normal. */
typedef void ylm_scene_spheres_fn(size_t n, const float normal[3], scene_spheres *a);
/* The kernel of the instruction set in use. */
ylm_scene_spheres_fn *ylm__scene_spheres(void);

/* -- draw.c ---------------------------------------------------------------------------------- */

/* Looks at the tree from c->x, and opens nodes whose doubt is above SCENE_DOUBT of the whole over the
   root of the number of samples. */
void ylm__scene_look(ylm_scene_chooser *c, int light_samples);
/* Draws n <= SCENE_GROUP lamps: one walk for all. */
void ylm__scene_draw(const ylm_scene_chooser *c, size_t n, scene_drawn *d);
/* How often a lamp is drawn. */
double ylm__scene_drawn_share(const ylm_scene_chooser *c, uint32_t lamp);

#endif
