/*
** calibration.h - the tuned constants of sampling a grid. Private to csrc/grid.
**
** `make bench BENCH=grid` prints millions of points a second from adaptive and uniform grids.
*/
#ifndef YLM_GRID_SAMPLE_CALIBRATION_H
#define YLM_GRID_SAMPLE_CALIBRATION_H

/* Points of a chunk: the more there are, the more often the data of a cell are used while in the
   cache. */
#define SAMPLE_LEAST ((size_t)1024)
#define SAMPLE_MOST ((size_t)1 << 17)
/* Points that a kernel interpolates at once. */
#define SAMPLE_POINTS 4

#endif
