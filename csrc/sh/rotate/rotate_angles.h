/* rotate_angles.h - the angles of rows that each have a rotation of their own. */
#ifndef YLM_SH_ROTATE_ANGLES_H
#define YLM_SH_ROTATE_ANGLES_H

#include "ylm_real.h"
#include "ylm_sh.h"

/* Rows at once. */
#define TILE (2 * LANES)

/* Cosines and sines of m times the three angles of each row. */
typedef struct each_angles {
  real c[3][YLM_SH_ROTATE_EACH_LMAX + 1][TILE] __attribute__((aligned(64)));
  real s[3][YLM_SH_ROTATE_EACH_LMAX + 1][TILE] __attribute__((aligned(64)));
} each_angles;

#endif
