/* stream.c - streamlines as tubes. */
#include "ylm_figure.h"

#include <math.h>
#include <string.h>

/* Both halves of the line through `seed` in order; returns the number of points in out
   [2*room][3]. */
static size_t both_ways(const ylm_figure_volume *v, const double seed[3], double step, size_t room,
                        double *out) {
  size_t back = ylm_figure_streamline(v, seed, step, false, room, out);
  for (size_t i = 0; i < back / 2; i++) {
    double p[3];
    memcpy(p, out + 3 * i, sizeof p);
    memcpy(out + 3 * i, out + 3 * (back - 1 - i), sizeof p);
    memcpy(out + 3 * (back - 1 - i), p, sizeof p);
  }
  if (back) back--; /* the seed comes again */
  return back + ylm_figure_streamline(v, seed, step, true, room, out + 3 * back);
}

ylm_status ylm_figure_add_streamlines(ylm_figure_shape *shape, const ylm_figure_volume *v, size_t n,
                                      const double *seed, double step, size_t room, size_t fewest,
                                      double radius, const ylm_figure_scale *s) {
  static const double grey[3] = {0.5, 0.5, 0.5};
  double *point = ylm_alloc(room, 6 * sizeof *point), *colour = ylm_alloc(room, 6 * sizeof *colour);
  double *length = ylm_alloc(room, 2 * sizeof *length);
  ylm_status status = point && colour && length ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < n && status == YLM_OK; i++) {
    size_t m = both_ways(v, seed + 3 * i, step, room, point);
    if (m < fewest) continue;
    for (size_t k = 0; k < m; k++) {
      double d[3] = {NAN, NAN, NAN};
      ylm_figure_volume_at(v, point + 3 * k, d);
      length[k] = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
    status = ylm_figure_colours(s, m, length, grey, colour);
    if (status == YLM_OK) status = ylm_figure_add_tube(shape, m, point, colour, radius);
  }
  ylm_free(point);
  ylm_free(colour);
  ylm_free(length);
  return status;
}
