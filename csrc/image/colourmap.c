/* colourmap.c - numbers as colours. */
#include "ylm_image.h"

#include <math.h>
#include <string.h>

static const char *const names[] = {
#define X(name) #name,
    YLM_COLOURMAP_LIST(X)
#undef X
};

const char *ylm_colourmap_name(ylm_colourmap map) {
  return (unsigned)map < YLM_COLOURMAP_COUNT ? names[map] : "?";
}

bool ylm_colourmap_find(const char *name, ylm_colourmap *map) {
  for (int i = 0; i < YLM_COLOURMAP_COUNT; i++)
    if (strcmp(name, names[i]) == 0) {
      *map = (ylm_colourmap)i;
      return true;
    }
  return false;
}

/* Colours of the CC0 maps at t = 0, 16/255, 32/255 ... 240/255, 1. */
typedef float nodes[17][3];

static const nodes viridis = {{.267f, .005f, .329f}, {.282f, .095f, .417f}, {.279f, .175f, .483f},
                              {.259f, .252f, .525f}, {.230f, .322f, .546f}, {.199f, .388f, .555f},
                              {.173f, .449f, .558f}, {.149f, .508f, .557f}, {.128f, .567f, .551f},
                              {.121f, .626f, .533f}, {.158f, .684f, .502f}, {.246f, .739f, .452f},
                              {.369f, .789f, .383f}, {.516f, .831f, .294f}, {.678f, .864f, .190f},
                              {.846f, .887f, .100f}, {.993f, .906f, .144f}};

static const nodes magma = {{.001f, .000f, .014f}, {.040f, .031f, .134f}, {.113f, .065f, .277f},
                            {.212f, .062f, .419f}, {.317f, .072f, .485f}, {.415f, .110f, .505f},
                            {.513f, .148f, .508f}, {.614f, .182f, .499f}, {.716f, .215f, .475f},
                            {.817f, .256f, .436f}, {.904f, .320f, .388f}, {.961f, .418f, .360f},
                            {.987f, .536f, .382f}, {.996f, .654f, .446f}, {.997f, .770f, .535f},
                            {.992f, .884f, .640f}, {.987f, .991f, .750f}};

/* Cubic through the nodes with central slopes. */
static void interpolate(const nodes n, double t, float rgb[3]) {
  double s = t * 255 / 16, u = t >= 240.0 / 255 ? (s - 15) * 16 / 15 : s - floor(s);
  int i = t >= 240.0 / 255 ? 15 : (int)s;
  const float *a = n[i > 0 ? i - 1 : 0], *b = n[i], *c = n[i + 1], *d = n[i < 15 ? i + 2 : 16];
  for (int k = 0; k < 3; k++) {
    double m0 = 0.5 * (c[k] - a[k]), m1 = 0.5 * (d[k] - b[k]), e = c[k] - b[k];
    double x = b[k] + u * (m0 + u * (3 * e - 2 * m0 - m1 + u * (m0 + m1 - 2 * e)));
    rgb[k] = (float)(x < 0 ? 0 : x > 1 ? 1 : x);
  }
}

static double encode_srgb(double x) {
  x = x < 0 ? 0 : x > 1 ? 1 : x;
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

/* OKLab (Ottosson 2020) to sRGB. */
static void from_oklab(double L, double a, double b, float rgb[3]) {
  double l = L + 0.3963377774 * a + 0.2158037573 * b;
  double m = L - 0.1055613458 * a - 0.0638541728 * b;
  double s = L - 0.0894841775 * a - 1.2914855480 * b;
  l = l * l * l, m = m * m * m, s = s * s * s;
  rgb[0] = (float)encode_srgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s);
  rgb[1] = (float)encode_srgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s);
  rgb[2] = (float)encode_srgb(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s);
}

/* Blue - light grey - red: lightness falls alike on both sides, chroma rises. */
static void coolwarm(double t, float rgb[3]) {
  const double degree = YLM_PI / 180;
  double x = 2 * t - 1, side = fabs(x), hue = (x < 0 ? 258 : 27) * degree;
  double chroma = 0.17 * sin(90 * degree * fmin(1, side * 1.15)),
         lightness = 0.95 - 0.50 * pow(side, 1.4);
  from_oklab(lightness, chroma * cos(hue), chroma * sin(hue), rgb);
}

void ylm_colourmap_at(ylm_colourmap map, double t, float rgb[3]) {
  if (isnan(t)) {
    rgb[0] = rgb[2] = 1, rgb[1] = 0;
    return;
  }
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  switch (map) {
  case YLM_COLOURMAP_magma: interpolate(magma, t, rgb); break;
  case YLM_COLOURMAP_coolwarm: coolwarm(t, rgb); break;
  case YLM_COLOURMAP_grey: rgb[0] = rgb[1] = rgb[2] = (float)t; break;
  default: interpolate(viridis, t, rgb); break;
  }
}

/* The number that stands for a pixel: luminance, or its only channel. */
static double measure(const float *p, int channels) {
  return channels >= 3 ? ylm_luminance((const double[]){p[0], p[1], p[2]}) : p[0];
}

ylm_status ylm_image_false_colour(const ylm_image *in, const char *name, ylm_colourmap map,
                                  double lo, double hi, bool logarithmic, ylm_image **out,
                                  ylm_error *e) {
  const ylm_layer *layer = ylm_image_find(in, name);
  *out = NULL;
  if (!layer) return ylm_fail(e, YLM_EINVAL, "no layer '%s'", name ? name : "(first)");
  if (!(lo < hi) || !isfinite(lo) || !isfinite(hi) || (logarithmic && !(lo > 0)))
    return ylm_fail(e, YLM_ERANGE, "the range %g .. %g must rise%s", lo, hi,
                    logarithmic ? " and be above 0" : "");
  ylm_status s = ylm_image_create(in->width, in->height, out, e);
  if (s == YLM_OK) s = ylm_image_add(*out, "radiance", 3, e);
  if (s != YLM_OK) {
    ylm_image_free(*out);
    *out = NULL;
    return s;
  }
  float table[1025][3]; /* linear colours */
  for (int i = 0; i <= 1024; i++) {
    ylm_colourmap_at(map, i / 1024.0, table[i]);
    for (int k = 0; k < 3; k++) table[i][k] = ylm_tone_decode_srgb(table[i][k]);
  }
  size_t n = (size_t)in->width * (size_t)in->height;
  float nan_colour[3] = {1, 0, 1}, *q = (*out)->layer[0].data;
  for (size_t i = 0; i < n; i++) {
    double x = measure(layer->data + i * (size_t)layer->channels, layer->channels);
    double t = logarithmic ? (x > 0      ? log(x / lo) / log(hi / lo)
                              : isnan(x) ? x
                                         : 0)
                           : (x - lo) / (hi - lo);
    const float *c = isnan(t) ? nan_colour : table[(int)((t < 0 ? 0 : t > 1 ? 1 : t) * 1024 + 0.5)];
    memcpy(q + 3 * i, c, 3 * sizeof *q);
  }
  return YLM_OK;
}
