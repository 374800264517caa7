/* uncovered.h - the part of a pixel that nothing hides: for lamps and bodies that are drawn over a picture. Private to csrc/shade. */
#ifndef YLM_SHADE_UNCOVERED_H
#define YLM_SHADE_UNCOVERED_H

#include "../gen/picture.h"
#include "../view.h"

/* The part of a pixel that shows nothing nearer than `depth`. */
static inline double open_part(const ylm_shade_view *v, size_t pixel, double depth) {
  const shade_pixel *q = &v->pixel[pixel];
  double hidden = 0;
  for (size_t i = q[0].first; i < q[1].first; i++)
    hidden += hides((double)v->entry[i].weight, (double)v->entry[i].depth, depth);
  return open_share(hidden);
}

#endif
