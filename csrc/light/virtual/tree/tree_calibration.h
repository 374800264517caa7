/*
** tree_calibration.h - the tuned constants of the tree of virtual lights. Private to the folder.
**
** Sizes were moved by the microseconds a point, constants of error by the 99.9 % quantile of
** errors. The quantile has to be at most the tolerance in every scene of the bench. `make bench
** BENCH=many_virtual` prints both. spec/virtual_tree_spec.lua holds the errors. The rest is as in
** ../tree/calibration.h.
*/
#ifndef YLM_LIGHT_VIRTUAL_TREE_CALIBRATION_H
#define YLM_LIGHT_VIRTUAL_TREE_CALIBRATION_H

/* -- errors of nodes --------------------------------------------------------------------------- */

/* Parts of the bounds that count, for values, gradients, Hessians and the metric. */
#define VIRTUAL_SHARE_VALUE 7.0
#define VIRTUAL_SHARE_GRADIENT 10.0
#define VIRTUAL_SHARE_HESSIAN 4.5
#define VIRTUAL_SHARE_METRIC 14.0
/* Where light comes from one side errors add up: so much less counts. */
#define VIRTUAL_ONE_SIGN 0.6
/* Norms that cancel to less than this part of the sum of the lights' norms count as so much. */
#define VIRTUAL_CANCELLED 64
/* reach/D of nodes beyond which Taylor's formula says little; in the pilot, of all and of values alone. */
#define VIRTUAL_WIDEST 0.6f
#define VIRTUAL_PILOT_WIDEST 0.5f
#define VIRTUAL_PILOT_WIDEST_VALUE 0.7f
/* Light that a fit misses in the worst direction, as it counts in values, gradients and Hessians: it varies faster
   with the direction than what was fitted. */
#define VIRTUAL_FLAT_VALUE 5.4f
#define VIRTUAL_FLAT_GRADIENT 14.0f
#define VIRTUAL_FLAT_HESSIAN 100.0f
/* Missed light has one sign in all nodes of a curved surface: this part of it is at most what is
   allowed of the node's own light. */
#define VIRTUAL_EVEN 0.003f
/* Lights at their horizon bend, and proxies for them curve: by this part of the values' norm in Hessians, beside
   what is allowed of the node's own. */
#define VIRTUAL_KINK 0.05f
/* Least part of a node's strength that counts where it is seen at a grazing angle. */
#define VIRTUAL_GRAZE 0.25f
/* The pilot's norms may be off by this part of the sum of the lights' norms. */
#define VIRTUAL_MARGIN 0.03f
/* Second and third moments of the normals beside those of colours. */
#define VIRTUAL_TURNED 1.0
/* Nodes of the far profile nearer than this, in cores, are opened: their core is not constant. */
#define VIRTUAL_CORES 2.0

/* -- the tree itself --------------------------------------------------------------------------- */

#define VIRTUAL_FEW 512 /* fewer lights than this are never worth a tree */
#define VIRTUAL_LEAF 8  /* most lights of a leaf */
#define VIRTUAL_DIRECT                                                                             \
  64 /* lights of a node whose emission is fitted to theirs; above, to its children's */
#define VIRTUAL_NORMALS 0.7 /* weight of normals' extent when lights are cut, beside places' */
/* Normals further apart than this, with so few of the lights in the middle third, are those of two surfaces, and are
   cut first. */
#define VIRTUAL_APART 0.4f
#define VIRTUAL_GAP 0.1
#define VIRTUAL_CHUNK 2048 /* nodes whose proxies are held until they are written */
#define VIRTUAL_LIST 128   /* lights and proxies that are summed without compensation */

#endif
