/* slopes.c - gradients of points that are values alone. */
#include <string.h>

#include "sides.h"

/* Adds the slopes along the edges of a box of cells to its corners' gradients [channels count][3], and counts them. */
static void add_slopes(const ylm_grid_contents *v, const uint32_t corner[8], const double edge[3],
                       float *gradient, float *count) {
  size_t w = (size_t)(v->form.channels * v->count);
  for (int k = 0; k < 8; k++) {
    if (corner[k] == YLM_GRID_NONE || corner[k] >= v->points) continue;
    count[corner[k]]++;
    for (int a = 0; a < 3; a++) {
      const float *from = v->data + v->stride * corner[k & ~(1 << a)],
                  *to = v->data + v->stride * corner[k | 1 << a];
      for (size_t j = 0; j < w; j++)
        gradient[3 * (corner[k] * w + j) + (size_t)a] += (to[j] - from[j]) / (float)edge[a];
    }
  }
}

ylm_status ylm_grid_mean_slopes(const ylm_grid *g, float *gradient) {
  const ylm_grid_contents *v = &g->contents;
  size_t w = (size_t)(v->form.channels * v->count);
  float *count = ylm_alloc_zero(v->points, sizeof *count);
  if (!count) return YLM_ENOMEM;
  memset(gradient, 0, 3 * v->points * w * sizeof *gradient);
  for (size_t i = 0, side = 0; i < v->cells; i++) {
    const ylm_grid_cell *c = &v->cell[i];
    double box[6], edge[3];
    if (c->child || c->corner[0] == YLM_GRID_NONE) continue;
    ylm_grid_box(g, i, box);
    for (int a = 0; a < 3; a++) edge[a] = box[a + 3] - box[a];
    while (side < v->sides && v->side[side].cell < i) side++;
    const ylm_grid_side *s = side < v->sides && v->side[side].cell == i ? &v->side[side] : NULL;
    if (!s) add_slopes(v, c->corner, edge, gradient, count);
    for (uint32_t p = 0; s && p < s->parts; p++)
      add_slopes(v, v->node[s->first + p], edge, gradient, count);
  }
  for (size_t i = 0; i < v->points; i++)
    for (size_t j = 0; count[i] > 0 && j < 3 * w; j++) gradient[3 * i * w + j] /= count[i];
  ylm_free(count);
  return YLM_OK;
}
