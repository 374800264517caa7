/* tree_kernel.h - the sum over a tree of lights, for the unit's element type: blocks of points. */
#ifndef YLM_LIGHT_TREE_KERNEL_H
#define YLM_LIGHT_TREE_KERNEL_H

#include "block.h"

ylm__tree_range YLM_REAL_KERNEL(ylm__tree_range);

ylm_status YLM_REAL_KERNEL(ylm__tree_range)(const ylm__tree_plan *p, void **scratch, size_t begin,
                                            size_t end, const void *points, ylm_field_result *r) {
  tree_work *k;
  if (tree_work_create(p, scratch, &k) != YLM_OK) return YLM_ENOMEM;
  for (size_t block = begin; block < end; block++) {
    size_t first = p->packing->block[block], n = p->packing->block[block + 1] - first, packets = 0;
    for (size_t i = 0; i < n; i += YLM__PACKET) {
      packet *q = &k->packet[packets++];
      size_t points_of_it = n - i < YLM__PACKET ? n - i : YLM__PACKET;
      gather(p, p->packing->order + first + i, points_of_it, points, q);
      attend(q, &k->crowd);
      find_scales(p, k, q);
    }
    k->far[0].pays = -1;
    sum_block(p, k, k->packet, packets, 0, r);
  }
  return YLM_OK;
}

#endif
