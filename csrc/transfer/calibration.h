/*
** calibration.h - the tuned constants of light from surface to surface. Private to csrc/transfer.
**
** Sizes of work move time alone: `make bench BENCH=links` prints the times of links, of direct light on
** elements and of bounces, spec/bench/bounces.lua those of whole pictures.
*/
#ifndef YLM_TRANSFER_CALIBRATION_H
#define YLM_TRANSFER_CALIBRATION_H

/* -- elements and links: elements.c, links.c, sides.c -------------------------------------------- */

/* A triangle is cut into strips where they have less than this part of k^2 elements. A foot nearer than this part of the height to
   the end of the longest edge is there. Moved by: numbers of elements of meshes from modellers. */
#define CUT_STRIPS 0.5
#define CUT_FOOT 0.5
/* Places of an element whose tints are averaged. */
#define TRANSFER_TINTS 16
/* Rays that are traced in one go, unless one place has more. */
#define TRANSFER_RAYS 1024
/* Elements that a thread describes at a time, and elements whose links it finds. */
#define TRANSFER_GRAIN 256
#define LINKS_GRAIN 64
/* Links of a place that are sorted one by one. */
#define LINKS_FEW 32
/* The most lamps that are looked at; of more, evenly many. */
#define SIDES_LAMPS 65536
/* Distinct sets of bodies around lamps that are remembered, and the most bodies in one. */
#define SIDES_SETS 64
#define SIDES_NESTED 16

/* -- elements that walls cross: crossed.c ---------------------------------------------------------- */

/* Corners are looked at this far from the middle. */
#define CROSSED_WITHIN 0.999f
/* Places of an element on its other side come nearer to its middle by halves, so many times. */
#define CROSSED_HALVES 4
/* A neighbour is looked for within the spacing in so many steps, by rays down from this part of an element's width, of surfaces that
   face as this cosine. */
#define CROSSED_STEPS 3
#define CROSSED_LIFT 0.05f
#define CROSSED_FACING 0.9f

/* -- files: file.c ------------------------------------------------------------------------------- */

/* Transfer vectors of files are taken with a noise of at most so many standard deviations, and this rounding; shares of
   rays with that of floats. */
#define ESCAPE_NOISE 6
#define ESCAPE_ROUNDING 1e-4
#define SHARE_ROUNDING 1e-6f

/* -- direct light: direct.c, smooth.c, lightmap.c ---------------------------------------------------------- */

/* Places of an element from which lamps are looked at, at most, and rays of each, at least: a place
   costs a choice among all lamps. */
#define DIRECT_PLACES 4
#define DIRECT_EACH 8
/* Elements whose places are looked up together. */
#define DIRECT_TOGETHER 16
/* Elements whose light is asked of a field at a time. */
#define DIRECT_ASKED 4096
/* Elements that a thread takes at a time. */
#define DIRECT_GRAIN 128
/* Elements of a group whose noise is averaged, at most and at least. Groups that a thread takes at a time. */
#define SMOOTH_MOST 64
#define SMOOTH_LEAST 8
#define SMOOTH_GRAIN 64
/* The part of noise in what strays from a plane from which on noise is averaged in part, and in full. Moved by: edges of shadows, noise
   of elements in a room with a window. */
#define SMOOTH_DOUBTED 0.6
#define SMOOTH_NOISE 0.85
/* Of elements on a line, which is their determinant relative to its diagonal. */
#define SMOOTH_FLAT 1e-6
/* Texels that are worked on in one go. */
#define LIGHTMAP_TEXELS 256
/* Cosines below it count as this one where light is told along axes: the noise of rays near the horizon ends. */
#define FLOW_LEVEL 0.05

/* -- bounces: solve.c, vectors.c, matrices.c ----------------------------------------------------- */

/* Elements that a thread takes at a time. */
#define BOUNCE_GRAIN 256
/* Changes below this, relative, are rounding. */
#define BOUNCE_ROUNDING 1e-6
/* A shrinkage this near to 1 has no sum. */
#define BOUNCE_ENDLESS 1e-5
/* Bounces without a smaller change after which a sum is given up, and bounces at most. */
#define BOUNCE_PATIENCE 64
#define BOUNCE_MOST 20000
/* Bounces of noise, at most: of a mean albedo of 0.7 they have 92 % of it. */
#define BOUNCE_NOISE 6
/* Links of which a bounce takes less time than to wake other threads. */
#define BOUNCE_FEW 200000
/* Places whose links are known at once. */
#define VECTOR_PLACES 4096
/* Rays that are summed in one go, and rows that are fetched before they are read. */
#define MATRIX_STEP 64
#define MATRIX_AHEAD 8
/* Matrices that a thread takes at a time. */
#define MATRIX_GRAIN 8
/* Rows of emitters that are fetched before they are read. Moved by: bounces a second where rows
   exceed the caches. */
#define SUM_AHEAD 8

/* -- targets: targets.c ----------------------------------------------------------------------------

   Moved by: noise at equal links of pictures (`make bench BENCH=interiors`). */

/* Clusters of places, about, and the fewest places of one; places of a cluster that have links, and these links. */
#define TARGETS_CLUSTERS 512
#define TARGETS_LEAST 64
#define TARGETS_PLACES 16
#define TARGETS_LINKS 32
/* Elements that learn, at most. */
#define TARGETS_ELEMENTS 65536
/* Hits that elements are grouped by, and the most of a group. */
#define TARGETS_HITS 32768
#define TARGETS_GROUP 64
/* Rays of a cluster to each group, the part of the light of all of them of which less is not looked for, and the part of light
   without shadows that is added, and of that as if all faced each other. */
#define TARGETS_LOOKS 4
#define TARGETS_SMALL 1e-5
#define TARGETS_FLOOR 0.2
/* The variance of a link over its squared mean above which links are aimed; of what elements learn. Moved by: time of pictures, and of
   light on surfaces in the room with a window (7.0) and the lamp's shade (12.9). */
#define TARGETS_WORTH 6
#define TARGETS_WORTH_ELEMENTS 9
#define TARGETS_FAR 0.02
/* Places that a thread gathers at in one go. */
#define TARGETS_GRAIN 64

/* -- adjoint/lamplight.c --------------------------------------------------------------------------- */

/* Rays that are traced in one go, unless one lamp has more, and places that a thread takes at a time. */
#define LAMPLIGHT_RAYS 1024
#define LAMPLIGHT_GRAIN 32

/* -- boxes.c -------------------------------------------------------------------------------------- */

/* Triangles of a leaf at most. */
#define MEETS_LEAF 4

#endif
