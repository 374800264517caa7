/* near.h - what near.c asks of the kernels that sum near lights at points. Private to the folder. */
#ifndef YLM_LIGHT_VIRTUAL_NEAR_H
#define YLM_LIGHT_VIRTUAL_NEAR_H

#include "../plan.h"

enum {
  YLM__NEAR_FIELDS = 7, /* of a light: place, normal, shift (1 without a normal) */
  YLM__NEAR_ROW =
      16 /* numbers of a light of degree 0: these, sg^2, 2/sg^2, eps^2, red, green, blue */
};

/* Lights of a cell and its neighbours, in their order; arrays have room for a vector more than n. */
typedef struct ylm__near_lights {
  size_t n, room;
  uint32_t *number;               /* [room] of a light, or of its row */
  float *field[YLM__NEAR_FIELDS]; /* [room] each, of one block of memory */
} ylm__near_lights;

/* The box of some points, and how far lights shine. */
typedef struct ylm__near_box {
  float middle[3], half[3], reach, slack; /* slack: of rounding, scene units */
} ylm__near_box;

/* Numbers of those lights that may shine into the box, in their order, to list [n]: how many they are. Lights
   that are left out give its points exactly nothing. */
typedef size_t ylm__near_cull_fn(const ylm__near_lights *l, const ylm__near_box *box,
                                 uint32_t *list);

/* The kernels of an instruction set; lanes: points of one call; NULL: there are none. */
typedef struct ylm__near_kernels {
  int lanes;
  ylm__near_cull_fn *cull;
  ylm__virtual_near_fn *irradiance, *value;
} ylm__near_kernels;

/* -- near.c, for levels.c: lights of profile far with an outer core, summed within 1.6 outer cores -------------- */

/* Boxes side by side. */
typedef struct ylm__near_lattice {
  double origin[3], edge[3];
} ylm__near_lattice;
/* Which of n cells of a lattice, about points [n][3], lights may shine into. YLM_ENOMEM, YLM_ECANCELLED. */
ylm_status ylm__near_touch(const ylm_light_virtual *lights, const ylm__near_lattice *lattice,
                           size_t n, const float *points, int threads, const ylm_progress *progress,
                           uint8_t *touched);
/* Adds coefficients and gradients at points to rows [n][4][row]: [3][(lmax+1)^2] each of the value and of its slopes by
   x, y, z. Likewise. */
ylm_status ylm__near_rows(const ylm_light_virtual *lights, const ylm__near_lattice *lattice,
                          int lmax, size_t n, const float *points, int threads,
                          const ylm_progress *progress, float *rows, size_t row, uint64_t *pairs);

#endif
