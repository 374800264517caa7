/* direct.h - direct light of a point: groups of lamps, and how much of each is seen. Private to csrc/transfer/gather. */
#ifndef YLM_TRANSFER_GATHER_DIRECT_H
#define YLM_TRANSFER_GATHER_DIRECT_H

#include "calibration.h"
#include "gather.h"
#include "ylm_light_emitter.h"

typedef struct gather_lamp {
  ylm_light_emitter emitter;
  double at[3], reach, power;
  uint32_t lamp; /* as the scene counts it */
} gather_lamp;

typedef struct gather_node {
  double at[3], reach, power;
  uint32_t first, n, child[2]; /* one lamp: no children */
} gather_node;

struct gather_lamps {
  const ylm_scene *scene;
  gather_lamp *lamp; /* [n] in the order of the tree, distant ones last */
  gather_node *node;
  size_t n, suns;
  size_t *kind, kinds; /* [kinds] of lamps, by ylm_light_emitter_order */
  uint32_t nodes;
  float (*sky)[3]; /* [cells] radiance of the sky in the base's cells; NULL: there is none */
};

/* Lamps first .. first+n-1, and what is known of them at a point. */
typedef struct gather_group {
  uint32_t node, first, n, rays, seen;
  double light, angle;
} gather_group;

/* -- lamps.c ------------------------------------------------------------------------------------ */

ylm_status ylm__gather_lamps_create(const ylm_scene *scene, gather_lamps *l);
void ylm__gather_lamps_free(gather_lamps *l);
/* The groups as x sees them: how many; out [GATHER_GROUPS]. */
size_t ylm__gather_groups(const gather_lamps *l, const float x[3], gather_group *out);

/* -- direct.c ----------------------------------------------------------------------------------- */

/* Fills l->sky where there is one; YLM_ENOMEM. */
ylm_status ylm__gather_make_sky(const gather_lattice *l, gather_lamps *lamps);

#endif
