/* exposure.c - the exposure under which a picture is seen well, and how much of it is black or white. */
#include <math.h>
#include <string.h>

#include "calibration.h"
#include "ylm_image.h"

/* The layer of that name, or the first. */
static const ylm_layer *layer_of(const ylm_image *image, const char *name) {
  return name ? ylm_image_find(image, name) : image->layers > 0 ? &image->layer[0] : NULL;
}

static double brightness(const ylm_layer *l, size_t i) {
  const float *x = l->data + i * (size_t)l->channels;
  if (l->channels < 3) return (double)x[0];
  return ylm_luminance((double[]){(double)x[0], (double)x[1], (double)x[2]});
}

/* The mean logarithm of pixels between `least` and `most`, of which darker ones count as `least`; NAN: there is none. */
static double log_mean(const ylm_image *image, const ylm_layer *l, double least, double most) {
  const ylm_layer *lamps = ylm_image_find(image, "emitter");
  size_t pixels = (size_t)image->width * (size_t)image->height, n = 0;
  double sum = 0;
  for (size_t i = 0; i < pixels; i++) {
    double x = brightness(l, i);
    if (!(x > 0 && x <= most) || (lamps && lamps->channels == 1 && lamps->data[i] > 0)) continue;
    sum += log(fmax(x, least));
    n++;
  }
  return n > 0 ? sum / (double)n : (double)NAN;
}

/* Parts of pixels that are shown as black and as white. */
static void count(const ylm_image *image, const ylm_layer *l, ylm_exposure *out) {
  size_t pixels = (size_t)image->width * (size_t)image->height, black = 0, white = 0;
  double gain = exp2(out->stops);
  for (size_t i = 0; i < pixels; i++) {
    double x = gain * brightness(l, i);
    black += !(x > EXPOSURE_BLACK);
    white += x >= 1;
  }
  out->black = (double)black / (double)pixels;
  out->white = (double)white / (double)pixels;
}

ylm_status ylm_image_expose(const ylm_image *image, const char *layer, const double *stops,
                            ylm_exposure *out, ylm_error *e) {
  const ylm_layer *l = layer_of(image, layer);
  if (!l) return ylm_fail(e, YLM_EINVAL, "no layer %s", layer ? layer : "");
  double mean = log_mean(image, l, 0, INFINITY);
  for (int k = 0; k < EXPOSURE_ROUNDS && !isnan(mean); k++) {
    double middle = exp(mean), next;
    next = log_mean(image, l, middle / EXPOSURE_DARK, middle * EXPOSURE_BRIGHT);
    mean = isnan(next) ? mean : next;
  }
  *out = (ylm_exposure){0};
  if (!isnan(mean)) out->stops = fmax(-60, fmin(60, log2(EXPOSURE_KEY) - mean / log(2)));
  if (stops) out->stops = *stops;
  count(image, l, out);
  return YLM_OK;
}
