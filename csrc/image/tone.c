/* tone.c - tone curves. */
#include "ylm_image.h"

#include <math.h>
#include <string.h>

static const char *const names[] = {
#define X(name) #name,
    YLM_TONE_LIST(X)
#undef X
};

const char *ylm_tone_name(ylm_tone curve) {
  return (unsigned)curve < YLM_TONE_COUNT ? names[curve] : "?";
}

bool ylm_tone_find(const char *name, ylm_tone *curve) {
  for (int i = 0; i < YLM_TONE_COUNT; i++)
    if (strcmp(name, names[i]) == 0) {
      *curve = (ylm_tone)i;
      return true;
    }
  return false;
}

static float encode_srgb(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1.0f / 2.4f) - 0.055f;
}

float ylm_tone_decode_srgb(float x) {
  return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

/* Hable 2010: ((x(Ax+CB)+DE)/(x(Ax+B)+DF)) - E/F. */
static float hable(float x) {
  const float A = 0.15f, B = 0.50f, C = 0.10f, D = 0.20f, E = 0.02f, F = 0.30f;
  return (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F;
}

/* Narkowicz 2015. */
static float aces(float x) { return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f); }

float ylm_tone_apply(ylm_tone curve, float x) {
  if (!(x > 0)) return 0;
  if (x > 1e6f) x = 1e6f; /* every curve has reached its end; no overflow, no inf/inf */
  switch (curve) {
  case YLM_TONE_hable: x = hable(2.0f * x) / hable(11.2f); break;
  case YLM_TONE_aces: x = aces(x); break;
  case YLM_TONE_reinhard: x = x / (1 + x); break;
  default: break;
  }
  if (curve != YLM_TONE_linear) x = encode_srgb(x < 1 ? x : 1);
  return x < 0 ? 0 : x < 1 ? x : 1;
}

void ylm_tone_map(ylm_tone curve, double stops, size_t n, const float *x, float *y) {
  float gain = (float)exp2(stops);
  for (size_t i = 0; i < n; i++) y[i] = ylm_tone_apply(curve, gain * x[i]);
}
