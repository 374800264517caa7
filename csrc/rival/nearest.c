/* nearest.c - tables of materials without interpolation: 90 rows of elevation, of which the nearest stands
   for a view (harmonics-virtual-lights 2022, Sec. 4.2). */
#include "rival.h"

#include <math.h>

#define LAST (89.5 / 180 * YLM_PI) /* of a table's rows */

void ylm__rival_nearest(const ylm_material_table_facts *f, size_t n, const float (*wo)[3],
                        float (*out)[3]) {
  for (size_t i = 0; i < n; i++) {
    double row = acos(fmin(1, fmax(0, (double)wo[i][2]))) / LAST * (f->rows - 1);
    double angle = fmin(rint(row), f->rows - 1) / (f->rows - 1) * LAST;
    double azimuth = atan2((double)wo[i][1], (double)wo[i][0]), step = 2 * YLM_PI / f->columns;
    if (f->columns > 1) azimuth = rint(azimuth / step) * step;
    out[i][0] = (float)(sin(angle) * cos(azimuth));
    out[i][1] = (float)(sin(angle) * sin(azimuth));
    out[i][2] = (float)cos(angle);
  }
}
