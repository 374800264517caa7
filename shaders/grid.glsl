/* grid.glsl - a grid in the device's memory, as csrc/vulkan/grid.c lays it out. */

struct Cell {
  uint corner[8]; /* rows of data */
  uint origin[3], edge; /* lattice units */
  uint child, source, info, unused;
};

/* Of info. */
const uint LEVEL = 0xff, HAS_DATA = 0x100, ELSEWHERE = 0x200;
/* Of a place's cell: none here; outside of the bounds. */
const uint NONE = 0x3fffffff, AWAY = 0x40000000;
