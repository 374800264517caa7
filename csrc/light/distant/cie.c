/* cie.c - skies of the CIE. */
#include <math.h>

#include "cie.h"
#include "ylm_vector.h"

static const struct {
  double a, b, k, c, e;
} skies[] = {
#define X(name, a, b, k, c, e) {a, b, k, c, e},
    YLM_LIGHT_CIE_LIST(X)
#undef X
};

/* How bright the sky is in a direction, by its angle to the sun. */
static double glow(const ylm_light_cie *s, const double d[3]) {
  double cosine = fmax(-1, fmin(1, ylm_dot3d(s->sun, d)));
  return skies[s->kind].a + skies[s->kind].b * exp(skies[s->kind].k * acos(cosine)) +
         skies[s->kind].c * (cosine * cosine);
}

double ylm__light_cie_scale(const ylm_light_cie *s) {
  if (s->kind == YLM_LIGHT_CIE_overcast) return s->luminance / 3;
  return s->luminance / (glow(s, s->zenith) * (1 - exp(skies[s->kind].e)));
}

double ylm__light_cie_scaled(const ylm_light_cie *s, double scale, const double d[3]) {
  double up = ylm_dot3d(s->zenith, d);
  if (!(up > 0)) return 0;
  if (s->kind == YLM_LIGHT_CIE_overcast) return scale * (1 + 2 * up);
  return scale * glow(s, d) * (1 - exp(skies[s->kind].e / up));
}

double ylm_light_cie_luminance(const ylm_light_cie *s, const double d[3]) {
  return ylm__light_cie_scaled(s, ylm__light_cie_scale(s), d);
}
