/*
** calibration.h - the tuned constants of the path tracer. Private to csrc/path.
**
** `make bench BENCH=path` prints the time of paths beside that of their rays alone, and of a picture.
*/
#ifndef YLM_PATH_CALIBRATION_H
#define YLM_PATH_CALIBRATION_H

/* A tile holds so many pairs of an item and a batch of samples. Moved by: rays in one go, and the
   memory of a thread. */
#define PATH_PAIRS 64
/* Tiles of a round, after which it is decided whether to go on: enough for many threads. */
#define ROUND_TILES 64
/* The most numbers that a round keeps. */
#define ROUND_NUMBERS (4u << 20)
/* The reflection from which on paths end at random, and the bounds of their chance to go on. Moved
   by: variance times seconds. */
#define ROULETTE 4
#define LEAST_CHANCE 0.05f
#define MOST_CHANCE 0.95f
/* Lamps along a ray that are asked for at once. */
#define LAMPS_AT_ONCE 16

/* -- guides: guide.c ------------------------------------------------------------------------------ */

/* One of so many items has a batch of the pilot's paths, at most PILOT_PAIRS; of probes one of PILOT_PART batches, if these are
   more. An item lets the pilot have so many shadow rays, all of them at most PILOT_RAYS. Numbers of pictures do not depend on
   samples, so that pictures go on bit for bit. Moved by: 1 / variance / rays of pictures of the window room (`make bench
   BENCH=interiors`). */
#define PILOT_ITEMS 4
#define PILOT_PART 32
#define PILOT_PAIRS 4096
#define PILOT_EACH 64
#define PILOT_RAYS (1 << 21)
/* Guides that are kept do where a pilot would have at most so many times the paths of theirs. */
#define PILOT_KEPT 4
/* Places of a path that are noted, on average, at most. */
#define PILOT_PLACES 6

/* -- what is known of reflected light: known.c ----------------------------------------------------

   Moved by: 1 / variance / rays of pictures of four interiors (`make bench BENCH=interiors`). */

/* Cells of directions along an axis: a power of two. */
#define KNOWN_SIDE 16
/* Reflections that are counted by themselves; the others follow from these. */
#define KNOWN_ORDERS 16
/* The most places of a cluster; places that its irradiance and its directions come from, at least. */
#define KNOWN_PLACES 128
#define KNOWN_LEAST 64
#define KNOWN_PATHS 3072
/* In a cell of directions: paths that brought as much as others do, beside those of the pilot. */
#define KNOWN_DOUBT 0.3f
/* The part of directions that guides choose. */
#define GUIDED_PART 0.5f
/* Materials of a smaller excess, for an eye at this cosine, are guided as matte ones are. */
#define GUIDED_COSINE 0.7f
#define GUIDED_EXCESS 1
/* Guides are fetched to the cache so many directions before they are asked. */
#define GUIDES_AHEAD 8
/* The chance to go on of a path that may bring as much as it could at its start; bounds of it. */
#define KNOWN_CHANCE 1.2f
#define KNOWN_LEAST_CHANCE 0.3f
#define KNOWN_MOST_CHANCE 0.95f

#endif
