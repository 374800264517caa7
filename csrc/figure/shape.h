/* shape.h - how shapes grow. Private to csrc/figure. */
#ifndef YLM_FIGURE_SHAPE_H
#define YLM_FIGURE_SHAPE_H

#include "ylm_figure.h"

/* Room for that many more points and cells. */
ylm_status ylm__figure_reserve(ylm_figure_shape *s, size_t points, size_t cells);
/* Appends a point (reserved before; n may be NULL) and returns its index. */
uint32_t ylm__figure_point(ylm_figure_shape *s, const double p[3], const double n[3],
                           const double rgb[3], double alpha);
/* Appends a triangle (reserved before). */
void ylm__figure_triangle(ylm_figure_shape *s, uint32_t a, uint32_t b, uint32_t c);
/* Makes the normals of the points from `first_point` on from the triangles from `first_cell` on. */
void ylm__figure_normals(ylm_figure_shape *s, size_t first_point, size_t first_cell);

#endif
