/* calibration.h - the tuned constants of bakes in bricks. Private to csrc/grid. */
#ifndef YLM_GRID_BRICK_CALIBRATION_H
#define YLM_GRID_BRICK_CALIBRATION_H

/* Evaluated points of a brick before its children take its place: 85 MB of RGB rows of degree 4. */
#define BRICK_POINTS 65536
/* Seconds of a brick where neither these nor points are asked for. */
#define BRICK_SECONDS 30.0
/* Seconds of a pair of a light and a point for each coefficient: 14 ns at lmax 8 in RGB, with gradient and metric
   (docs/bench/light.md). A constant, so that bricks are the same on every machine. */
#define BRICK_PAIR 0.18e-9
/* Points of a brick that are not too many, however long they take. */
#define BRICK_LEAST 512
/* The level of bricks where none is asked for. */
#define BRICK_LEVEL 3
/* Points of the top at most. */
#define TOP_POINTS 200000
/* Held-out points of a round of a brick, of a tolerance: each brick keeps it. */
#define BRICK_HELD 512
/* Bytes of a set's cache where none is asked for. */
#define SET_CACHE ((size_t)256 << 20)
/* Points that are sampled of a brick at a time. */
#define SET_CHUNK 8192
/* Seconds after which a file of another process is not awaited any more. */
#define LATE_SECONDS 60

#endif
