/* cie.c - skies of the CIE. */
#include <math.h>

#include "ylm_light_sky.h"
#include "ylm_vector.h"

static const struct {
  double a, b, k, c, e;
} skies[] = {
#define X(name, a, b, k, c, e) {a, b, k, c, e},
    YLM_LIGHT_CIE_LIST(X)
#undef X
};

/* The angle between two directions. */
static double angle(const double a[3], const double b[3]) {
  return acos(fmax(-1, fmin(1, ylm_dot3d(a, b))));
}

/* How bright the sky is at an angle to the sun. */
static double glow(const ylm_light_cie *s, double g) {
  double cosine = cos(g);
  return skies[s->kind].a + skies[s->kind].b * exp(skies[s->kind].k * g) +
         skies[s->kind].c * (cosine * cosine);
}

double ylm_light_cie_luminance(const ylm_light_cie *s, const double d[3]) {
  double up = ylm_dot3d(s->zenith, d), e = skies[s->kind].e;
  if (!(up > 0)) return 0;
  if (s->kind == YLM_LIGHT_CIE_overcast) return s->luminance * (1 + 2 * up) / 3;
  double scale = s->luminance / (glow(s, angle(s->zenith, s->sun)) * (1 - exp(e)));
  return scale * glow(s, angle(s->sun, d)) * (1 - exp(e / up));
}
