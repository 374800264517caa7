/* grid.glsl - a grid in the device's memory, as csrc/vulkan/grid/sample.c lays it out. */

struct Cell {
  uint corner[8]; /* rows of data */
  uint origin[3], edge; /* lattice units */
  uint child, source, info, unused;
};

#include "gen/layout.glsl"
