/* nearby.isa.c - coefficients of lights of a list at points, in float. */
#define YLM_REAL_IS_FLOAT
#include "../kernel.h"

#include <string.h>

/* Points relative to the origin of lights. */
static void load(const float (*from)[3], const double origin[3], int lanes, vreal to[3]) {
  for (size_t a = 0; a < 3; a++)
    for (int i = 0; i < LANES; i++)
      to[a][i] = (float)((double)from[i < lanes ? i : 0][a] - origin[a]);
}

ylm__virtual_near_fn YLM_KERNEL(ylm__virtual_near);

ylm_status YLM_KERNEL(ylm__virtual_near)(const ylm__virtual_plan *p, const ylm__virtual_near *near,
                                         void **scratch) {
  const size_t stride = p->lights->stride;
  const float *lamps = p->lights->seen, reach2 = near->reach * near->reach;
  vreal xyz[3] = {vreal_set(0), vreal_set(0), vreal_set(0)};
  load(near->points, p->lights->origin, near->lanes, xyz);
  if (!*scratch) *scratch = ylm_alloc_zero(VIRTUAL(room_of)(p), sizeof(vreal));
  if (!*scratch) return YLM_ENOMEM;
  work own, *k = &own;
  VIRTUAL(work_place)(k, p, *scratch);
  memset(k->part, 0, p->sums * sizeof *k->part);
  for (size_t i = 0; i < near->n; i++) add_light(p, k, lamps + near->list[i] * stride, xyz, reach2);
  VIRTUAL(flush)(p, k);
  ylm_copy(k->sum, k->part, p->sums * sizeof *k->part);
  for (size_t c = 0; c < 3; c++) {
    const size_t n = p->rows[0];
    VIRTUAL(value_of)(p, k, 3, (int)c, k->out);
    for (int i = 0; i < near->lanes; i++)
      for (size_t j = 0; j < n; j++) near->out[i][c * n + j] += k->out[j][i];
    if (!p->slopes) continue;
    VIRTUAL(gradient_of)(p, k, 3, (int)c, k->out);
    for (int i = 0; i < near->lanes; i++)
      for (size_t j = 0; j < n; j++)
        for (size_t a = 0; a < 3; a++)
          near->out[i][(a + 1) * near->row + c * n + j] += k->out[3 * j + a][i];
  }
  return YLM_OK;
}
