/* crosses.c - which boxes meet the surface of a light. */
#include "light.h"

/* Does the surface |p - c| = r pass through the box? Squared distances to its nearest and
   farthest point decide. */
static bool meets(const double *box, const double *c, double r) {
  double near = 0, far = 0;
  for (int a = 0; a < 3; a++) {
    double lo = box[a] - c[a], hi = c[a] - box[3 + a];
    double out = lo > hi ? lo : hi, in = lo < hi ? lo : hi;
    if (out > 0) near += out * out;
    far += in * in;
  }
  return near <= r * r && r * r <= far;
}

ylm_status ylm__crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_lights *l = f->self;
  for (size_t i = 0; i < n; i++) {
    out[i] = 0;
    for (size_t k = 0; k < l->active && !out[i]; k++)
      out[i] = meets(boxes + 6 * i, l->lamp_d[k].at, l->lamp_d[k].radius);
  }
  return YLM_OK;
}
