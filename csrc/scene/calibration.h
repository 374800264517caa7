/*
** calibration.h - the tuned constants of the choice of lamps. Private to csrc/scene.
**
** `make bench BENCH=choose` prints the time of a sample, and the variance of what it brings. Both
** stand there for samples through the tree of lamps, and for all lamps weighed one by one.
** spec/choose_spec.lua holds that each lamp has its chance.
*/
#ifndef YLM_SCENE_CALIBRATION_H
#define YLM_SCENE_CALIBRATION_H

/* Fewer places at a time are looked at one by one: scene.c. */
#define SURFACES_FEW 4

/* -- few lamps: weights.c, choose.c, patch.c ----------------------------------------------------- */

/* Lamps of a chunk, whose weights are summed together. */
#define YLM_LAMP_CHUNK 64
/* Lamps that are weighed faster one by one. */
#define CHOOSE_FEW 16
/* Triangles that fill a smaller solid angle are sampled by area. */
#define PATCH_SMALL 1e-4
/* Distance over the longest edge from which on a triangle is far: it then fills less than a fifth
   of a steradian. */
#define PATCH_FAR 1.5

/* -- the tree of lamps: tree.c, order.c ---------------------------------------------------------- */

/* Nodes that a thread sums at a time; fewer are summed by one. */
#define TREE_GRAIN 512
/* Spheres that are weighed one by one in the time of a flat lamp. */
#define TREE_FLAT 8
/* The least squared cosine at flat lamps, as seen from close to their plane. */
#define LEAST_FACING 0.01
/* Ranges that are smaller than ORDER_PIECE lamps, or than an ORDER_PARTS-th of all, are ordered
   side by side. */
#define ORDER_PIECE ((size_t)1 << 14)
#define ORDER_PARTS 32
/* Lamps that are parted by branches. */
#define ORDER_FEW 32
/* Lamps within so many radii are weighed on their own. */
#define SCENE_NEAR 3
/* The part of the mean squared distance from the mean that counts as distance of a child. Moved by:
   variance in a room with lamps on its walls. */
#define SCENE_SPREAD 0.35

/* -- the walk down: draw.c ----------------------------------------------------------------------- */

/* Samples that walk down together. */
#define SCENE_GROUP 64
/* A node is opened whose doubt is more than this part of the whole, over the square root of the samples. */
#define SCENE_DOUBT 0.02
/* The most nodes that are open. */
#define SCENE_OPEN 64

/* -- guides: guide.c ----------------------------------------------------------------------------- */

/* The most places of a cluster: GUIDE_ROOT times the root of all, GUIDE_PLACES at least; rays of the pilot from each. Moved
   by: variance in a room with a window, of pictures of 1,000 and 100,000 points. */
#define GUIDE_PLACES 32
#define GUIDE_ROOT 3
#define GUIDE_RAYS 16
/* The pilot has one ray for so many others. */
#define GUIDE_PART 4
/* Normals of a cluster differ by less than this along each axis. */
#define GUIDE_NORMALS 0.4f
/* The part of a ray that is taken for seen, beside those of a tile and its neighbours. */
#define GUIDE_DOUBT 0.15f
/* The least mean square of what a cell of a tile brings, of all that it would bring if nothing were in its way. */
#define GUIDE_CELL_LEAST 0.002f
/* The part that rays of clusters beside one count as, of which it knows so many. */
#define GUIDE_PART_BESIDE 0.5f
#define GUIDE_BESIDE 16
/* Of lamps: a ray's worth of which half is seen; the least variance, relative to the mean square. */
#define GUIDE_LAMP_DOUBT 0.5f
#define GUIDE_LEAST 0.002f

/* -- light that fills the sky: dome.c ------------------------------------------------------------ */

/* The table of a dome that is no image: its size, samples of a cell a side, and the share of the mean that is added to each
   cell. */
#define TABLE_WIDTH 128
#define TABLE_HEIGHT 64
#define TABLE_LOOKS 2
#define TABLE_LEAST 0.01
/* Cells of a tile along each side, of which guides know what is seen; pixels among which these choose for a ray. Moved by: variance
   in rooms with windows. */
#define DOME_CELLS 4
#define DOME_LOOKS 8

/* -- grounds: ground.c ----------------------------------------------------------------------------- */

/* A box is flat whose least extent is this part of the largest at most. */
#define GROUND_FLAT 0.1
/* The diagonal of all is so many times that of what stands on grounds. */
#define GROUND_WIDER 2.5
/* Grounds at most. */
#define GROUND_PARTS 64

#endif
