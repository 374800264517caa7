/*
** calibration.h - the tuned constants of the tree of lights. Private to csrc/light.
**
** Sizes and constants of speed were moved by the microseconds a point, constants of error by the 99.9 % quantile of errors.
** The quantile has to be at most the tolerance in every scene of the bench. Both are columns of
** spec/bench/many_lights.c; spec/light_tree_spec.lua holds the errors. The bodies of the commits
** that are named after the title of a group have the figures.
*/
#ifndef YLM_LIGHT_TREE_CALIBRATION_H
#define YLM_LIGHT_TREE_CALIBRATION_H

/* -- errors of nodes ("Sum many lights by a tree", "Trees of lights have eight proxies") ------- */

/* Bounds by Taylor's formula are some ten times the errors: the directions of moments and
   derivatives seldom agree. These parts of them count, for values, gradients, Hessians and the
   metric, whose eigenvalues forgive more. Moved by: the error of each, at all tolerances. */
#define SHARE_VALUE 4.3
#define SHARE_GRADIENT 5.0
#define SHARE_HESSIAN 3.2
#define SHARE_METRIC 5.5
/* Where light comes from one side, nodes' errors have one sign and add up: so much less counts.
   Moved by: lambda outside of a room with lamps on its walls. */
#define YLM__ONE_SIGN 0.6
/* Norms that cancel to less than this part of the sum of the lights' norms count as so much. */
#define YLM__CANCELLED 64
/* Hessians of lights beyond a distance are left out where the sum of their norms is below this part
   of the tolerance. TAILS distances are tried, from the tree's extent on, each smaller than the one
   before by the square root of two. */
#define YLM__SKIP 0.7
#define YLM__TAILS 10
/* reach/D of nodes beyond which Taylor's formula says little; and in the pilot, whose nodes are one
   light each and whose norms may be off by a third: with derivatives, and for values alone. */
#define WIDEST 0.6f
#define PILOT_WIDEST 0.5f
#define PILOT_WIDEST_VALUE 0.7f
/* Weights of missed moments, which make errors beside their estimates alike: second moments of
   colours; third moments; fourth, whose directions seldom agree, and the fourth moments themselves
   for all that is higher. */
#define COLOURS 1.8
#define SKEW 1.5
#define MISSED 1.05
#define HIGHER 0.045

/* -- the tree itself ("Trees of lights have eight proxies") ------------------------------------ */

#define YLM__LEAF 8 /* most lights of a leaf */
#define YLM__MANY 8 /* lights of a node that may have more proxies than the least */
/* Fewer lights than this are never worth a tree. */
#define YLM__FEW 512
/* The error of a node, as estimated, for which the number of proxies is chosen. */
#define TYPICAL 0.25
/* Least part of an equal weight that a proxy has, and of a square; steps that bring third moments
   nearer. */
#define LEAST 0.2
#define TIMES 5

/* -- packets ("Tree of lights: packets of points walk together") ------------------------------- */

#define YLM__PACKET 16 /* points that walk together */
/* The points of a packet that fills less than one lane of so many walk alone. */
#define YLM__LONELY 4
/* A node goes to the packet's points if it is too near for the packet and its reach is below LITTLE
   packet radii. The points then walk on alone. Walking alone pays only if such nodes hold many
   lights, n (1 + n/all) > WORTH in all. WORTH grows as sqrt(0.01/tolerance) below 0.01. Moved by:
   256 random points among 10^6 lights, and a grid of 32^3. */
#define YLM__LITTLE 2
#define YLM__WORTH 12000
#define LEFT 1024 /* groups that a packet may leave to its points, and a block to its packets */
#define NOTES 256 /* nodes that are noted before they are summed */
#define AHEAD 12  /* notes whose lights are fetched before they are read */

/* -- blocks ("Blocks of dense points share what is far from all of them") ---------------------- */

/* A block is a set of points for which distant lights are summed once. A block has BLOCK_LEAST to
   BLOCK_MOST points, at most 1/BLOCKS of the query; the sums at its nodes take at most NODES_BYTES.
   Moved by: pairs a point on a floor of 256^2. */
#define YLM__BLOCK_LEAST 256
#define YLM__BLOCK_MOST 4096
#define YLM__BLOCKS 64
#define YLM__NODES_BYTES (1 << 21)
#define YLM__SHARING 4 /* fewest packets that share what is far */
#define LEVELS 4       /* sizes of blocks in each other, each a quarter of the next */
#define PARTS 64       /* parts of a block that tests see */
/* Nodes whose middle is near a block, and smaller than so much of what is near, are left to its
   packets. */
#define YLM__WITHIN 0.5f
/* Vectors of sums that are interpolated together, so that no addition is waited for. */
#define ABREAST 4
/* Most nodes along an axis, and fewest along the longest. */
#define ALONG 8
#define FEWEST 5
/* How much interpolation may err, relative to the allowed error: FAR_SHARE for a single light
   at the nearest distance (few are that near), but never more than LARGEST of that light's own
   field; STRONG for a node that makes up the whole field, STRONG/sqrt(x) for one that makes up
   a part x. */
#define FAR_SHARE 16
#define STRONG 0.5f
#define LARGEST 0.25f
/* Interpolation costs a point COST pairs for each node, and replaces the part INSTEAD of the lights
   and proxies that a block sums. */
#define COST 0.5
#define INSTEAD 0.4
/* Groups of nodes that a thread fills at a time. */
#define TREE_GRAIN 8

#endif
