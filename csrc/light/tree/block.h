/*
** block.h - blocks of packets, for the unit's element type. A block shares the sums of lights that are far from all of it,
** where that pays (far.h). The rest is left to the smaller blocks that it is halved into, down to packets.
*/
#ifndef YLM_LIGHT_TREE_BLOCK_H
#define YLM_LIGHT_TREE_BLOCK_H

#include "packet.h"

/* Packets as balls, at most PARTS of them. */
static void see_parts(const packet *q, size_t packets, seen_by *by) {
  size_t parts = packets < PARTS ? packets : PARTS;
  by->vectors = (int)((parts + YLM_VF - 1) / YLM_VF);
  for (size_t i = 0; i < (size_t)by->vectors * YLM_VF; i++) {
    size_t part_of = i < parts ? i : 0;
    size_t first = part_of * packets / parts, end = (part_of + 1) * packets / parts;
    size_t v = i / YLM_VF, lane = i % YLM_VF, n = end - first;
    seen_from part = {.radius = 0};
    for (int j = 0; j < 3; j++) part.allowed[j] = part.part[j] = part.error[j] = INFINITY;
    for (size_t j = 0; j < n; j++) {
      be_strict(&q[first + j].whole, &part);
      for (int a = 0; a < 3; a++) part.x[a] += q[first + j].whole.x[a] / (float)n;
    }
    for (size_t j = 0; j < n; j++) {
      const seen_from *whole = &q[first + j].whole;
      float d2 = 0;
      for (int a = 0; a < 3; a++) {
        float d = fabsf(whole->x[a] - part.x[a]) + whole->half[a];
        d2 += d * d;
      }
      part.radius = fmaxf(part.radius, sqrtf(d2));
    }
    for (int a = 0; a < 3; a++) by->x[v][a][lane] = part.x[a];
    for (int k = 0; k < 3; k++) by->allowed[v][k][lane] = part.allowed[k];
    by->radius[v][lane] = part.radius;
    by->skip[v][lane] = part.skip;
  }
}

/* Sums what is far from all points of so many packets, where that pays; what they share. */
static far_field *share_far(const ylm__tree_plan *p, tree_work *k, const packet *q, size_t packets,
                            int level) {
  far_field *f = &k->far[level], *above = k->shared;
  real lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, half[3];
  seen_from whole = {.skip = 0};
  size_t n = 0;
  if (f->pays == 0) return above;
  see_parts(q, packets, &f->crowd.by);
  for (int j = 0; j < 3; j++) whole.allowed[j] = whole.part[j] = whole.error[j] = INFINITY;
  for (size_t i = 0; i < packets; i++) {
    be_strict(&q[i].whole, &whole);
    n += q[i].n;
    for (size_t j = 0; j < q[i].n; j++)
      for (int a = 0; a < 3; a++) {
        real x = q[i].x[j][a];
        lo[a] = x < lo[a] ? x : lo[a], hi[a] = x > hi[a] ? x : hi[a];
      }
  }
  for (int a = 0; a < 3; a++) {
    real middle = f->middle[a] = lo[a] / 2 + hi[a] / 2;
    half[a] = hi[a] - middle > middle - lo[a] ? hi[a] - middle : middle - lo[a];
    whole.x[a] = (float)(((double)middle - p->tree->centre[a]) / p->tree->size);
    whole.half[a] = (float)((double)half[a] / p->tree->size);
    whole.radius += whole.half[a] * whole.half[a];
  }
  whole.radius = sqrtf(whole.radius);
  if (f->pays < 0) f->pays = whole.radius > 0 && pays(p, &k->walk, above, n, &whole, &f->crowd.by);
  if (!f->pays || !(whole.radius > 0)) return above;
  k->pairs += sum_far(p, &k->walk, above, f, &k->main, &whole, n, half);
  return f->nodes ? f : above;
}

/* Sums at so many packets, which are halved as they were when they were made; every other time
   halves share what is far. */
static void sum_block(const ylm__tree_plan *p, tree_work *k, packet *q, size_t packets, int depth,
                      ylm_field_result *r) {
  far_field *above = k->shared;
  if (packets == 1) {
    attend(q, &k->crowd);
    sum_packet(p, k, q);
    write_packet(p, k, q, r);
    return;
  }
  if (p->nodes && depth % 2 == 0 && packets >= YLM__SHARING && depth / 2 < LEVELS) {
    k->shared = share_far(p, k, q, packets, depth / 2);
    for (int level = depth / 2 + 1; level < LEVELS; level++) k->far[level].pays = -1;
  }
  sum_block(p, k, q, packets / 2, depth + 1, r);
  sum_block(p, k, q + packets / 2, packets - packets / 2, depth + 1, r);
  k->shared = above;
}

#endif
