/*
** tree.h - the tree over sphere lights, as its builder makes it and the kernels walk it.
**
** Private to csrc/light. A group holds two nodes side by side, so that a vector tests several
** groups at once. A node stands for the lights below it. From far away it is seen as four or eight
** proxy lights. From near it is seen as its own group or, where it is a leaf, as its lights
** themselves. Points beside each other walk down as a packet: what is far from all of them is
** summed with lanes that are points.
**
** The tests work in the tree's units, in which the root's reach is 1 and all strengths add up to 1;
** the lights and proxies that are summed keep the units of the scene.
*/
#ifndef YLM_LIGHT_TREE_H
#define YLM_LIGHT_TREE_H

#include "../moments/plan.h"
#include "calibration.h"

#define YLM__GROUP 2   /* nodes of a group */
#define YLM__PROXIES 4 /* least lights that stand for a node; nodes with as many have none */
#define YLM__MOST_PROXIES 8

/* Where a field of a block of lights stands: blocks are [field][lights]. */
enum { YLM__X, YLM__Y, YLM__Z, YLM__R, YLM__E, YLM__LUM = YLM__E + 3, YLM__FIELDS };

/* Kinds of strengths: by the norm over rgb, or by luminance. */
enum { YLM__STRENGTH_RGB, YLM__STRENGTH_LUM, YLM__STRENGTHS };

/*
** Nodes beside each other, field by field. The error of a node's proxies at the distance D is about
**   G_(2+k)/D^(4+k) second + G_(3+k)/D^(5+k) third + G_(4+k)/D^(6+k) fourth
** for the k-th derivative (bound.c has G).
*/
typedef struct ylm__group {
  float at[3][YLM__GROUP];                    /* centroid */
  float reach[YLM__GROUP];                    /* of lights and proxies about it */
  float strength[YLM__STRENGTHS][YLM__GROUP]; /* sum of |e| r^2 */
  float radius[YLM__GROUP];                   /* of one light for the node */
  uint32_t child[YLM__GROUP]; /* a group, or YLM__IS_LEAF | lights << YLM__COUNT_AT | leaf */
  /* the second line of the cache, which the pilot does not need */
  float second[YLM__STRENGTHS][YLM__GROUP]; /* moments that the proxies miss */
  float third[YLM__STRENGTHS][YLM__GROUP];
  float fourth[YLM__GROUP];     /* times strength */
  uint32_t lights[YLM__GROUP];  /* how many */
  uint32_t proxies[YLM__GROUP]; /* twice their block, and 1 if they are eight, of two blocks */
  float spread[YLM__GROUP];     /* of what is summed in its stead: reach of the proxies */
} ylm__group;

#define YLM__IS_LEAF 0x80000000u
#define YLM__COUNT_AT 27 /* lights of a leaf, 0 .. 8, above the leaf's number */
#define YLM__LEAF_MASK ((1u << YLM__COUNT_AT) - 1)
#define YLM__NO_NODE YLM__IS_LEAF /* an empty place: a leaf without lights */

typedef float ylm__leaf_f[YLM__FIELDS][YLM__LEAF];
typedef double ylm__leaf_d[YLM__FIELDS][YLM__LEAF];
/* Four proxies; eight are [YLM__FIELDS][YLM__MOST_PROXIES] in two of these. */
typedef float ylm__proxies_f[YLM__FIELDS][YLM__PROXIES];
typedef double ylm__proxies_d[YLM__FIELDS][YLM__PROXIES];

typedef struct ylm_light_tree {
  const ylm_lights *lights;
  double centre[3], size, total; /* the tree's units: origin, length, strength */
  ylm__group *group;             /* group 0 is empty, group 1 the root */
  uint32_t groups, leaves, blocks;
  int depth;           /* groups on the longest way down */
  ylm__leaf_f *leaf_f; /* [leaves] */
  ylm__leaf_d *leaf_d;
  ylm__proxies_f *proxies_f; /* [blocks] */
  ylm__proxies_d *proxies_d;
} ylm_light_tree;

/* -- build.c: cutting the lights into groups -------------------------------------------------- */

/* A node while the tree is built: lights order[begin] .. order[end-1]. */
typedef struct ylm__branch {
  uint32_t begin, end;
} ylm__branch;

/* -- proxy.c ---------------------------------------------------------------------------------- */

/* Fills place `k` of group `g`: centroid, reach, what the proxies miss, and the proxies, whose
   block it has. `order` names `n` lights. */
void ylm__tree_node(ylm_light_tree *t, uint32_t g, int k, const uint32_t *order, size_t n);

/* -- packets.c -------------------------------------------------------------------------------- */

/* The order of points in packets, all of which but the last have YLM__PACKET points that lie
   together, and of packets in blocks. */
typedef struct ylm__packing {
  size_t *order;         /* [n] points, one packet after the other */
  size_t *block, blocks; /* [blocks + 1] where each block begins among them */
} ylm__packing;
/* Blocks have up to `most` points. YLM_ENOMEM; to be freed in any case. */
ylm_status ylm__packing_create(ylm_dtype type, size_t n, const void *points, size_t most,
                               ylm__packing *out);
/* Runs `fn` over the blocks, by the query's threads; its progress is told of points. */
ylm_status ylm__packing_run(const ylm__packing *p, const ylm_field_query *q, ylm_range_fn *fn,
                            void *job);
void ylm__packing_free(ylm__packing *p);

/* -- far.c ------------------------------------------------------------------------------------ */

/*
** Points that lie together are a block. Lights far from all of it are summed at the nodes of a grid, from which the sums of
** its points are interpolated. `error[k][i][n]` is log2 of the error of the k-th derivative, in
** parts of a light's, at the i-th distance (far.c). The error is that of n of Chebyshev's nodes
** along an axis of half extent 1.
*/
#define YLM__FAR_NODES 16 /* most nodes along an axis */
#define YLM__FAR_STEPS 16 /* distances */
typedef struct ylm__far {
  float error[3][YLM__FAR_STEPS][YLM__FAR_NODES + 1];
} ylm__far;

void ylm__far_create(int lmax, const bool want[3], ylm__far *f);
/* The distance from a box from which on n[0] nodes along its longest axis keep the errors of lights
   below `part` of the lights' own. `n` gets as many nodes as that takes along each axis. Returns 0
   if no such distance is worth having. */
double ylm__far_nodes(const ylm__far *f, const bool want[3], const float half[3],
                      const float part[3], int n[3]);

/* -- bound.c ---------------------------------------------------------------------------------- */

/* The norms G_j of the j-th derivatives of a small light's coefficients at distance 1 for unit
   e r^2, over degrees 0 .. lmax: j = 0 .. 6. */
#define YLM__NORMS 7
void ylm__tree_norms(int lmax, double G[YLM__NORMS]);

/*
** How a query is answered by a tree. `at[k]`: the strength that the k-th derivative's error is
** measured by. A node is far for the k-th derivative where, with u = 1/D,
**
**   u^(6+k) (second c[k][0] + third c[k][1] u + strength fourth c[k][2] u^2)^2 <= B_k strength,
**   B_k = (share_k tolerance scale_k/G_k)^2 / (sum over lights of strength u^(2+k))
**
** The sum of the squares of all errors is then at most (share tolerance scale_k)^2, however many
** nodes there are. A packet's nodes are far from each of its points.
*/
typedef struct ylm__tree_plan {
  const ylm_light_tree *tree;
  const ylm__plan *sums;  /* of the results */
  const ylm__plan *pilot; /* of the scales: luminance sums of the strengths */
  double tolerance;
  bool want[3]; /* values, gradients, Hessians (or the metric) */
  int at[3];
  float c[3][3];               /* G_(2+k+j)/G_k */
  double norm[3];              /* G_k */
  float skip[YLM__TAILS];      /* distances beyond which Hessians may be left out */
  double share[3];             /* how much of the bounds counts, inverse */
  float widest, pilot_widest;  /* largest reach/D of a node that is not opened */
  ylm__plan dim;               /* the sums of lights whose Hessians are negligible; has no maps */
  uint32_t *dim_at;            /* [luminance sums of dim, then of a colour]: where among sums' */
  const ylm__packing *packing; /* of the query's points */
  size_t block;                /* most points of a block */
  size_t nodes;                /* most nodes of a block's grid; 0: nothing is interpolated */
  ylm__far far;
} ylm__tree_plan;

ylm_status ylm__tree_plan_create(ylm__tree_plan *p, const ylm_light_tree *t, double tolerance,
                                 const ylm__plan *sums, const ylm__plan *pilot);
/* How large blocks of `n` points are, and what is known of interpolation in them. */
void ylm__tree_plan_blocks(ylm__tree_plan *p, size_t n);
/* True if so many lights are summed faster by a tree. */
bool ylm__tree_pays(const ylm_light_tree *t, int lmax, double tolerance);
void ylm__tree_plan_free(ylm__tree_plan *p);

#endif
