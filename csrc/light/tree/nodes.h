/* nodes.h - a vector of nodes of the tree of lights. */
#ifndef YLM_LIGHT_TREE_NODES_H
#define YLM_LIGHT_TREE_NODES_H

#include "walk.h"

#define SIDE (YLM_VF / YLM__GROUP) /* groups in a vector */

/* A field of groups side by side. */
YLM_INLINE ylm_vf side_by_side(const ylm__group *const *g, size_t offset) {
  _Static_assert(YLM__GROUP * sizeof(float) == sizeof(int64_t), "a field of a group is one number");
  ylm_vl v = {0};
  for (size_t i = 0; i < SIDE; i++) {
    int64_t pair;
    memcpy(&pair, (const char *)g[i] + offset, sizeof pair);
    v[i] = pair;
  }
  return (ylm_vf)v;
}
#define FIELD(name) side_by_side(g, offsetof(ylm__group, name))
#define FIELD_OF(name, s)                                                                          \
  side_by_side(g, offsetof(ylm__group, name) + (size_t)(s) * sizeof g[0]->name[0])

/* How far coordinates are from the middle of an interval beyond its ends; 0 inside. */
YLM_INLINE ylm_vf beyond(ylm_vf x, float middle, float half) {
  x -= middle;
  x = ylm_vf_select(x > 0, x, -x) - half;
  return ylm_vf_select(x > 0, x, (ylm_vf){0});
}

/* A vector of nodes, and masks of what becomes of them. */
typedef struct node_vector {
  size_t n; /* groups */
  uint32_t at[SIDE];
  const ylm__group *g[SIDE];
  int32_t absent[YLM_VF], closed[YLM_VF], dim[YLM_VF], small[YLM_VF];
} node_vector;

#endif
