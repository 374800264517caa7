/*
** tree.h - the tree over virtual lights, as its builder makes it and the kernels walk it.
**
** Private to the folder. A node stands for the lights below it. From far away it is seen as four or
** eight proxies, virtual lights of degree 0 or 2 that share a normal and a shift. From near it is
** seen as its two children or, where it is a leaf, as its lights themselves. csrc/light/tree has
** the tree over sphere lights, whose places, parts and moments of proxies these are.
**
** Tests work in the tree's units. Half of the longest edge of the box around all lights is 1, and
** all strengths add up to 1.
*/
#ifndef YLM_LIGHT_VIRTUAL_TREE_H
#define YLM_LIGHT_VIRTUAL_TREE_H

#include "../../tree/proxy.h"
#include "../plan.h"
#include "tree_calibration.h"

/* Numbers of a proxy: its place, then its emission [1 or 9][3] of red, green, blue: 1; u; xx xy xz yy yz of
   C in c + c.u + u C u, which has no trace. */
enum { YLM__VIRTUAL_PLACE = 3, YLM__VIRTUAL_MATTE = 1, YLM__VIRTUAL_RICH = 9 };
/* Numbers of a row of degree 2 as kernels see it. */
#define YLM__VIRTUAL_WIDE (YLM__VIRTUAL_EMISSION + 3 * YLM__VIRTUAL_RICH)

/*
** The error of the k-th derivative of a node's proxies at the distance D is about
**
**   G_k flat/D^(2+k) + G_(1+k) first/D^(3+k) + G_(2+k) second/D^(4+k)
**     + G_(3+k) third/D^(5+k) + G_(4+k) fourth/D^(6+k)
**
** tree/bound.c has G.
*/
typedef struct ylm__virtual_node {
  float at[3], reach;             /* centroid; of lights and proxies about it */
  float normal[3], shift;         /* of the proxies; 0: they emit all around */
  float axis[3], open, back;      /* horizon: no light is in front of x where
                                       axis.(x - at) + back + open (|x - at| + reach) <= 0 */
  float strength[YLM__STRENGTHS]; /* sum of the lights' */
  float flat[YLM__STRENGTHS],
      first[YLM__STRENGTHS]; /* what proxies miss in the worst direction: light, */
  float second[YLM__STRENGTHS], third[YLM__STRENGTHS]; /* moments, */
  float fourth;                                        /* times strength */
  float radius;                                        /* of the proxies, scene units */
  uint32_t begin, lights;                              /* lights order[begin ..] */
  uint32_t child;                                      /* the first of two; 0: a leaf */
  uint32_t proxies;                                    /* where their numbers begin */
  uint8_t many, degree;                                /* how many proxies: 0, 4 or 8 */
} ylm__virtual_node;

typedef struct ylm__virtual_tree {
  const ylm_light_virtual *lights;
  double centre[3], size, total; /* the tree's units: origin, length, strength */
  ylm__virtual_node *node;       /* [nodes], the root first */
  uint32_t nodes, *order;        /* [lights->n] */
  int depth;                     /* nodes on the longest way down */
  float *proxies;
  size_t numbers;                /* of proxies */
  ylm_light_virtual matte, rich; /* what proxies are as lights: profile, degree, stride */
} ylm__virtual_tree;

/* -- tree_build.c ------------------------------------------------------------------------------ */

/* The tree of lights; NULL where there are few. YLM_ENOMEM. */
ylm_status ylm__virtual_tree_create(const ylm_light_virtual *lights, int threads,
                                    ylm__virtual_tree **tree);
void ylm__virtual_tree_free(ylm__virtual_tree *tree);
size_t ylm__virtual_tree_bytes(const ylm__virtual_tree *tree);

/* -- tree_fit.c -------------------------------------------------------------------------------- */

enum { YLM__VIRTUAL_DIRECTIONS = 98, YLM__VIRTUAL_PADDED = 112 };

/* Directions and lamps, which all nodes' fits share. */
typedef struct ylm__virtual_fit {
  ylm__virtual_tree *tree;
  const ylm__lamp_d *lamp; /* [lights] as spheres, whose moments are asked for */
  float u[3][YLM__VIRTUAL_PADDED], weight[YLM__VIRTUAL_PADDED];
  float form[YLM__VIRTUAL_RICH][YLM__VIRTUAL_PADDED]; /* what the numbers of a proxy are times */
  double *harmonic; /* [(degree+1)^2][YLM__VIRTUAL_PADDED]: of lights beyond degree 2; NULL */
} ylm__virtual_fit;

/* Proxies of a node before they are written, [many][place and numbers]. */
typedef float
    ylm__virtual_proxies[YLM__MOST_PROXIES * (YLM__VIRTUAL_PLACE + 3 * YLM__VIRTUAL_RICH)];

/* Directions, for lights of a degree; YLM_ENOMEM. */
ylm_status ylm__virtual_fit_create(ylm__virtual_fit *f, int degree);
void ylm__virtual_fit_free(ylm__virtual_fit *f);
/* Fills a node but for what says where things are; its children are filled. */
void ylm__virtual_fit_node(const ylm__virtual_fit *f, ylm__virtual_node *node,
                           ylm__virtual_proxies out);

/* -- tree.c --------------------------------------------------------------------------------------- */

/* How a query is answered by a tree; tree/tree.h says what is allowed. */
typedef struct ylm__virtual_tree_plan {
  const ylm__virtual_tree *tree;
  double tolerance;
  bool want[3];
  int at[3];      /* strengths that errors are measured by */
  float c[3][4];  /* G_(1+k+j)/G_k */
  double norm[3]; /* G_k */
  double share[3];
  float flat[3]; /* how much of what directions miss counts */
  float even,
      kink; /* the same and bends at horizons, beside what is allowed of a node's own light */
  float graze, margin;                 /* tree_calibration.h */
  float one_sign, cancelled;           /* tree_calibration.h */
  float widest, pilot_widest, nearest; /* reach/D; of nodes of profile far, in the tree's units */
  const ylm__packing *packing;
  ylm__virtual_plan lights, matte, rich; /* sums of lights and of proxies: the same sums */
  bool dims;                             /* Hessians of distant lights are left out: */
  float skip[YLM__TAILS];                /* beyond these distances */
  ylm__virtual_plan dim[3];              /* as these, without Hessians */
  ylm__virtual_plan pilot[3];            /* as these */
  ylm_field_query scales, dimmed;        /* queries of these */
} ylm__virtual_tree_plan;

ylm_status ylm__virtual_tree_plan_create(ylm__virtual_tree_plan *p, const ylm__virtual_tree *t,
                                         double tolerance, const ylm_field_query *q);
void ylm__virtual_tree_plan_free(ylm__virtual_tree_plan *p);
/* True if so many lights are summed faster by a tree. */
bool ylm__virtual_tree_pays(const ylm__virtual_tree *t, int lmax, double tolerance);

/* Sums at blocks begin .. end-1 of the packing. scratch: NULL at a worker's first call; freed by the caller, and
   begins with the number of lights and proxies that were summed, a uint64_t. */
typedef ylm_status ylm__virtual_tree_range(const ylm__virtual_tree_plan *p, void **scratch,
                                           size_t begin, size_t end, const float *points,
                                           ylm_field_result *r);
/* The kernel of an instruction set, of floats; NULL: there is none. */
ylm__virtual_tree_range *ylm__virtual_tree_kernel(ylm_isa isa);

#endif
