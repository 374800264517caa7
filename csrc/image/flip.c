/*
** flip.c - how different two pictures look when they alternate on a screen.
**
** A colour difference is raised where edges or points differ too. Both pictures are blurred as by the eye at a distance, in
** a colour space where distances are as large as they look. Pictures of high dynamic range are looked at under several
** exposures, of which the worst counts at each pixel.
**
** Source  Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images"; Andersson et
**         al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images" (exposures)
*/
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "metrics.h"

/* Exponents and weights of the papers. */
#define COLOUR_POWER 0.7
#define FEATURE_POWER 0.5
#define KNEE 0.4            /* this part of the largest colour difference ... */
#define KNEE_TO 0.95        /* ... is mapped to that one */
#define FEATURE_WIDTH 0.082 /* degrees */
#define BRIGHT 0.85         /* what a tone curve makes of the brightest pixel, or of the median */

/* The filters of a picture along x or y: the eye's, of Y, Cx, and Cz as a sum of two; then those
   of features: a Gaussian and its first and second derivative. */
enum { EYE_Y, EYE_X, EYE_Z1, EYE_Z2, GAUSS, FIRST, SECOND, FILTERS };
/* Planes of a picture that is filtered along x; results of filtering them along y. */
enum { ROW_Y, ROW_X, ROW_Z1, ROW_Z2, ROW_GAUSS, ROW_FIRST, ROW_SECOND, PLANES };
enum { SEEN_Y, SEEN_X, SEEN_Z1, SEEN_Z2, EDGE_X, EDGE_Y, POINT_X, POINT_Y, RESULTS };

/* A result's plane, and its filter along y. */
static const struct {
  int plane, filter;
} steps[RESULTS] = {{ROW_Y, EYE_Y},      {ROW_X, EYE_X},     {ROW_Z1, EYE_Z1},
                    {ROW_Z2, EYE_Z2},    {ROW_FIRST, GAUSS}, {ROW_GAUSS, FIRST},
                    {ROW_SECOND, GAUSS}, {ROW_GAUSS, SECOND}};
/* A plane's channel of Y, Cx, Cz, and its filter along x. */
static const struct {
  int channel, filter;
} planes[PLANES] = {{0, EYE_Y}, {1, EYE_X}, {2, EYE_Z1}, {2, EYE_Z2},
                    {0, GAUSS}, {0, FIRST}, {0, SECOND}};

typedef struct flip {
  const ylm_layer *layer[2]; /* the picture and its reference */
  const float *mask;
  size_t width, height;
  bool hdr;
  double gain;                                         /* of the exposure */
  double to_xyz[3][3], to_rgb[3][3], white[3], most;   /* most: largest colour difference */
  int eye, feature;                                    /* radii */
  double weight[FILTERS][2 * FLIP_RADIUS + 1], second; /* of Cz, the part of its second filter */
  float *colour[2][3];                                 /* Y, Cx, Cz: [height][width] each */
  float *plane[2][PLANES];
  float *map; /* [height][width] the largest so far */
} flip;

/* -- colours ----------------------------------------------------------------------------------- */

/* CIE XYZ of sRGB's primaries and white (IEC 61966-2-1). */
static const double rgb_to_xyz[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

static void apply(const double m[3][3], const double x[3], double out[3]) {
  for (int i = 0; i < 3; i++) out[i] = m[i][0] * x[0] + m[i][1] * x[1] + m[i][2] * x[2];
}

static void invert(const double m[3][3], double out[3][3]) {
  double d = 0;
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      int a = (i + 1) % 3, b = (i + 2) % 3, c = (k + 1) % 3, e = (k + 2) % 3;
      out[k][i] = m[a][c] * m[b][e] - m[a][e] * m[b][c];
    }
  for (int k = 0; k < 3; k++) d += m[0][k] * out[k][0];
  for (int i = 0; i < 9; i++) out[i / 3][i % 3] /= d;
}

/* Opponent colours: linear in XYZ, so that blurring them is blurring light. */
static void to_opponent(const flip *f, const double rgb[3], double out[3]) {
  double t[3];
  apply(f->to_xyz, rgb, t);
  for (int k = 0; k < 3; k++) t[k] /= f->white[k];
  out[0] = 116 * t[1] - 16;
  out[1] = 500 * (t[0] - t[1]);
  out[2] = 200 * (t[1] - t[2]);
}

static void from_opponent(const flip *f, const double x[3], double rgb[3]) {
  double y = (x[0] + 16) / 116, t[3] = {y + x[1] / 500, y, y - x[2] / 200};
  for (int k = 0; k < 3; k++) t[k] *= f->white[k];
  apply(f->to_rgb, t, rgb);
}

/* CIE L*a*b*, its colours less vivid where it is dark (Hunt's effect). */
static void to_lab(const flip *f, const double rgb[3], double lab[3]) {
  const double delta = 6.0 / 29;
  double t[3];
  apply(f->to_xyz, rgb, t);
  for (int k = 0; k < 3; k++) {
    t[k] /= f->white[k];
    t[k] = t[k] > delta * delta * delta ? cbrt(t[k]) : t[k] / (3 * delta * delta) + 4.0 / 29;
  }
  lab[0] = 116 * t[1] - 16;
  lab[1] = 0.01 * lab[0] * 500 * (t[0] - t[1]);
  lab[2] = 0.01 * lab[0] * 200 * (t[1] - t[2]);
}

/* HyAB distance (Abasi et al. 2020), compressed. */
static double distance(const double a[3], const double b[3]) {
  return pow(fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]), COLOUR_POWER);
}

static void make_colours(flip *f) {
  double green[3], blue[3];
  memcpy(f->to_xyz, rgb_to_xyz, sizeof rgb_to_xyz);
  invert(f->to_xyz, f->to_rgb);
  apply(f->to_xyz, (const double[]){1, 1, 1}, f->white);
  to_lab(f, (const double[]){0, 1, 0}, green);
  to_lab(f, (const double[]){0, 0, 1}, blue);
  f->most = distance(green, blue);
}

/* -- tone -------------------------------------------------------------------------------------- */

/* The curve of Narkowicz 2015, whose input is scaled by 0.6 as ACES itself does. */
#define TONE_A (0.6 * 0.6 * 2.51)
#define TONE_B (0.6 * 0.03)
#define TONE_D (0.6 * 0.6 * 2.43)
#define TONE_E (0.6 * 0.59)
#define TONE_F 0.14

static double tone(double x) {
  return x < 1e100 ? x * (TONE_A * x + TONE_B) / (x * (TONE_D * x + TONE_E) + TONE_F) : 1;
}

/* The number that the curve makes BRIGHT: the larger root of a quadratic. */
static double tone_bright(void) {
  double a = TONE_A - BRIGHT * TONE_D, b = TONE_B - BRIGHT * TONE_E, c = -BRIGHT * TONE_F;
  double half = -b / (2 * a);
  return half + sqrt(half * half - c / a);
}

/* The linear colour of pixel i of a picture, without negative light, as the screen shows it. */
static void shown(const flip *f, int side, size_t i, double rgb[3]) {
  size_t channels = (size_t)f->layer[side]->channels;
  const float *x = f->layer[side]->data + i * channels;
  for (size_t c = 0; c < 3; c++) {
    double v = fmax(0, (double)x[channels < 3 ? 0 : c]);
    rgb[c] = fmin(1, f->hdr ? tone(f->gain * v) : v);
  }
}

static bool counts(const flip *f, size_t i) { return !f->mask || f->mask[i] != 0; }

/* Whether all numbers of pixel i are finite in both pictures. */
static bool sound(const flip *f, size_t i) {
  for (int side = 0; side < 2; side++) {
    size_t channels = (size_t)f->layer[side]->channels;
    if (!ylm_all_finite(YLM_FLOAT, f->layer[side]->data + i * channels, channels, NULL))
      return false;
  }
  return true;
}

/* -- filters ----------------------------------------------------------------------------------- */

/* The eye's contrast sensitivity: a sqrt(pi/b) exp(-pi^2 x^2/b), x in degrees. */
static const struct {
  double a, b;
} eye[4] = {{1, 0.0047}, {1, 0.0053}, {34.1, 0.04}, {13.5, 0.025}};

/* Fills filter k with a Gaussian of variance v pixels^2, whose sum is 1; that before. */
static double gaussian(flip *f, int k, double v, int radius) {
  double sum = 0;
  for (int i = -radius; i <= radius; i++)
    sum += f->weight[k][i + FLIP_RADIUS] = exp(-i * i / (2 * v));
  for (int i = -radius; i <= radius; i++) f->weight[k][i + FLIP_RADIUS] /= sum;
  return sum;
}

/* Positive weights of a derivative sum to 1, negative ones to -1. */
static void balance(double *w, int radius) {
  double sum[2] = {0, 0};
  for (int i = -radius; i <= radius; i++) sum[w[i + FLIP_RADIUS] > 0] += fabs(w[i + FLIP_RADIUS]);
  for (int i = -radius; i <= radius; i++)
    if (w[i + FLIP_RADIUS] != 0) w[i + FLIP_RADIUS] /= sum[w[i + FLIP_RADIUS] > 0];
}

/* YLM_ERANGE: filters are too large. */
static ylm_status make_filters(flip *f, double pixels, ylm_error *e) {
  double part[4], deviation = 0.5 * FEATURE_WIDTH * pixels, v = deviation * deviation;
  double reach = 3 * sqrt(eye[2].b / (2 * YLM_PI * YLM_PI)) * pixels;
  if (!(pixels > 0) || !(reach <= FLIP_RADIUS) || !(3 * deviation <= FLIP_RADIUS))
    return ylm_fail(e, YLM_ERANGE, "%g pixels per degree: more than 0 and at most %g expected",
                    pixels, floor(FLIP_RADIUS / (3 * sqrt(eye[2].b / (2 * YLM_PI * YLM_PI)))));
  f->eye = (int)ceil(reach);
  f->feature = (int)ceil(3 * deviation);
  for (int k = 0; k < 4; k++) {
    double sum = gaussian(f, EYE_Y + k, eye[k].b * pixels * pixels / (2 * YLM_PI * YLM_PI), f->eye);
    part[k] = eye[k].a * sqrt(YLM_PI / eye[k].b) * sum * sum;
  }
  f->second = part[3] / (part[2] + part[3]);
  gaussian(f, GAUSS, v, f->feature);
  for (int i = -f->feature; i <= f->feature; i++) {
    double g = f->weight[GAUSS][i + FLIP_RADIUS];
    f->weight[FIRST][i + FLIP_RADIUS] = -i * g;
    f->weight[SECOND][i + FLIP_RADIUS] = (i * i / v - 1) * g;
  }
  balance(f->weight[FIRST], f->feature);
  balance(f->weight[SECOND], f->feature);
  return YLM_OK;
}

static int radius_of(const flip *f, int filter) { return filter < GAUSS ? f->eye : f->feature; }

/* Position x + i, the nearest pixel where that is outside. */
static size_t near(size_t x, int i, size_t n) {
  ptrdiff_t at = (ptrdiff_t)x + i;
  return at < 0 ? 0 : (size_t)at < n ? (size_t)at : n - 1;
}

/* Opponent colours of rows; what does not count and is not finite is black in both. */
static ylm_status convert_rows(void *context, size_t begin, size_t end, int worker) {
  const flip *f = context;
  (void)worker;
  for (size_t i = begin * f->width; i < end * f->width; i++)
    for (int side = 0; side < 2; side++) {
      double rgb[3] = {0}, x[3];
      if (sound(f, i)) shown(f, side, i, rgb);
      to_opponent(f, rgb, x);
      for (int c = 0; c < 3; c++) f->colour[side][c][i] = (float)x[c];
    }
  return YLM_OK;
}

static ylm_status filter_rows(void *context, size_t begin, size_t end, int worker) {
  const flip *f = context;
  (void)worker;
  for (size_t y = begin; y < end; y++)
    for (int side = 0; side < 2; side++)
      for (int p = 0; p < PLANES; p++) {
        const float *from = f->colour[side][planes[p].channel] + y * f->width;
        float *to = f->plane[side][p] + y * f->width;
        const double *w = f->weight[planes[p].filter] + FLIP_RADIUS;
        int radius = radius_of(f, planes[p].filter);
        for (size_t x = 0; x < f->width; x++) {
          double sum = 0;
          bool inner = x >= (size_t)radius && x + (size_t)radius < f->width;
          for (int i = -radius; i <= radius; i++)
            sum += w[i] * (double)from[inner ? x + (size_t)(ptrdiff_t)i : near(x, i, f->width)];
          to[x] = (float)sum;
        }
      }
  return YLM_OK;
}

/* -- differences ------------------------------------------------------------------------------- */

static double colour_difference(const flip *f, const double a[RESULTS], const double b[RESULTS]) {
  double lab[2][3];
  for (int side = 0; side < 2; side++) {
    const double *r = side ? b : a;
    double rgb[3],
        x[3] = {r[SEEN_Y], r[SEEN_X], (1 - f->second) * r[SEEN_Z1] + f->second * r[SEEN_Z2]};
    from_opponent(f, x, rgb);
    for (int c = 0; c < 3; c++) rgb[c] = fmin(1, fmax(0, rgb[c]));
    to_lab(f, rgb, lab[side]);
  }
  double d = distance(lab[0], lab[1]), knee = KNEE * f->most;
  if (d < knee) return d * KNEE_TO / knee;
  return KNEE_TO + (d - knee) / (f->most - knee) * (1 - KNEE_TO);
}

/* Lightness has the range 0 .. 1 for features, which is 116 of Y. */
static double feature_difference(const double a[RESULTS], const double b[RESULTS]) {
  double edge = fabs(hypot(a[EDGE_X], a[EDGE_Y]) - hypot(b[EDGE_X], b[EDGE_Y]));
  double point = fabs(hypot(a[POINT_X], a[POINT_Y]) - hypot(b[POINT_X], b[POINT_Y]));
  return pow(fmax(edge, point) / 116 / sqrt(2), FEATURE_POWER);
}

/* Filters along y, and raises the map. */
static ylm_status finish_rows(void *context, size_t begin, size_t end, int worker) {
  const flip *f = context;
  (void)worker;
  double *sum = ylm_alloc(2 * RESULTS * f->width, sizeof *sum);
  if (!sum) return YLM_ENOMEM;
  for (size_t y = begin; y < end; y++) {
    memset(sum, 0, 2 * RESULTS * f->width * sizeof *sum);
    for (int k = 0; k < 2 * RESULTS; k++) {
      int filter = steps[k % RESULTS].filter, radius = radius_of(f, filter);
      const float *plane = f->plane[k / RESULTS][steps[k % RESULTS].plane];
      double *to = sum + (size_t)k * f->width;
      for (int i = -radius; i <= radius; i++) {
        const float *from = plane + near(y, i, f->height) * f->width;
        double w = f->weight[filter][i + FLIP_RADIUS];
        for (size_t x = 0; x < f->width; x++) to[x] += w * (double)from[x];
      }
    }
    for (size_t x = 0; x < f->width; x++) {
      double r[2][RESULTS];
      for (int k = 0; k < 2 * RESULTS; k++)
        r[k / RESULTS][k % RESULTS] = sum[(size_t)k * f->width + x];
      double d = pow(colour_difference(f, r[0], r[1]), 1 - feature_difference(r[0], r[1]));
      float *to = f->map + y * f->width + x;
      if ((float)d > *to) *to = (float)d;
    }
  }
  ylm_free(sum);
  return YLM_OK;
}

/* -- exposures --------------------------------------------------------------------------------- */

static int by_size(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The exposures that show the brightest pixel, and the median one, as BRIGHT. A reference that is
   black in more than half of its pixels has the median of the others; one without light has 0. */
static ylm_status choose_exposures(const flip *f, double *start, double *stop) {
  size_t n = 0, dark = 0;
  double *luminance = ylm_alloc(f->width * f->height, sizeof *luminance);
  if (!luminance) return YLM_ENOMEM;
  for (size_t i = 0; i < f->width * f->height; i++) {
    size_t channels = (size_t)f->layer[1]->channels;
    const float *x = f->layer[1]->data + i * channels;
    double rgb[3];
    if (!counts(f, i)) continue;
    for (size_t c = 0; c < 3; c++) rgb[c] = fmax(0, (double)x[channels < 3 ? 0 : c]);
    luminance[n++] = ylm_luminance(rgb);
  }
  qsort(luminance, n, sizeof *luminance, by_size);
  while (dark < n && !(luminance[dark] > 0)) dark++;
  *start = *stop = 0;
  if (dark < n) {
    size_t median = n / 2 >= dark ? n / 2 : (n + dark) / 2;
    *start = log2(tone_bright() / luminance[n - 1]);
    *stop = log2(tone_bright() / luminance[median]);
  }
  ylm_free(luminance);
  return YLM_OK;
}

/* -- both -------------------------------------------------------------------------------------- */

static bool make_room(flip *f, float **room) {
  size_t n = f->width * f->height;
  float *at = *room = ylm_alloc(n, 2 * (3 + PLANES) * sizeof *at);
  for (int k = 0; at && k < 2 * (3 + PLANES); k++, at += n) {
    int side = k / (3 + PLANES), which = k % (3 + PLANES);
    *(which < 3 ? &f->colour[side][which] : &f->plane[side][which - 3]) = at;
  }
  return at;
}

static ylm_status find_layers(flip *f, const ylm_image *a, const ylm_image *b, const char *name,
                              ylm_error *e) {
  ylm_status s = ylm__image_match(a, b, name, &f->layer[0], &f->layer[1], e);
  if (s != YLM_OK) return s;
  f->width = (size_t)a->width;
  f->height = (size_t)a->height;
  size_t n = 0;
  for (size_t i = 0; i < f->width * f->height; i++) {
    if (!counts(f, i)) continue;
    n++;
    if (!sound(f, i)) return ylm__image_not_finite(i, f->width, e);
  }
  return n ? YLM_OK : ylm_fail(e, YLM_EINVAL, "the mask leaves no pixel");
}

static ylm_status settle_exposures(flip *f, ylm_flip *o, ylm_error *e) {
  double start, stop;
  if (!f->hdr) {
    o->start = o->stop = 0;
    o->exposures = 1;
    return YLM_OK;
  }
  ylm_status s = choose_exposures(f, &start, &stop);
  if (s != YLM_OK) return s;
  if (isnan(o->start)) o->start = start;
  if (isnan(o->stop)) o->stop = stop;
  if (!(o->start <= o->stop))
    return ylm_fail(e, YLM_ERANGE, "the first exposure, %.3g stops, is above the last, %.3g",
                    o->start, o->stop);
  o->exposures = (int)fmax(2, ceil(o->stop - o->start));
  return YLM_OK;
}

/* All exposures, one after the other. */
static ylm_status run(flip *f, const ylm_flip *o, int threads, const ylm_progress *progress) {
  ylm_status s = YLM_OK;
  for (int i = 0; i < o->exposures && s == YLM_OK; i++) {
    double part = o->exposures > 1 ? (double)i / (o->exposures - 1) : 0;
    f->gain = exp2(o->start + part * (o->stop - o->start));
    s = ylm_parallel(f->height, IMAGE_ROWS, threads, convert_rows, f, NULL, NULL);
    if (s == YLM_OK) s = ylm_parallel(f->height, IMAGE_ROWS, threads, filter_rows, f, NULL, NULL);
    if (s == YLM_OK) s = ylm_parallel(f->height, IMAGE_ROWS, threads, finish_rows, f, NULL, NULL);
    if (s == YLM_OK) s = ylm_report(progress, (uint64_t)i + 1, (uint64_t)o->exposures, "exposures");
  }
  return s;
}

static void add_up(const flip *f, ylm_flip *o) {
  size_t n = 0;
  o->mean = o->max = 0;
  for (size_t i = 0; i < f->width * f->height; i++) {
    if (!counts(f, i)) {
      f->map[i] = 0;
      continue;
    }
    n++;
    o->mean += (double)f->map[i];
    o->max = fmax(o->max, (double)f->map[i]);
  }
  o->mean /= (double)n;
}

ylm_status ylm_image_flip(const ylm_image *a, const ylm_image *b, const char *name,
                          const float *mask, ylm_flip *o, int threads, const ylm_progress *progress,
                          ylm_image **map, ylm_error *e) {
  float *room = NULL;
  flip *f = ylm_alloc_zero(1, sizeof *f);
  *map = NULL;
  if (!f) return ylm_no_memory(e);
  f->mask = mask;
  f->hdr = o->hdr;
  make_colours(f);
  ylm_status s = find_layers(f, a, b, name, e);
  if (s == YLM_OK) s = make_filters(f, o->pixels_per_degree, e);
  if (s == YLM_OK) s = settle_exposures(f, o, e);
  if (s == YLM_OK) s = ylm_image_create(a->width, a->height, map, e);
  if (s == YLM_OK) s = ylm_image_add(*map, "flip", 1, e);
  if (s == YLM_OK && !make_room(f, &room)) s = YLM_ENOMEM;
  if (s == YLM_OK) {
    f->map = (*map)->layer[0].data;
    s = run(f, o, threads, progress);
  }
  if (s == YLM_OK)
    add_up(f, o);
  else {
    ylm_image_free(*map);
    *map = NULL;
  }
  ylm_free(room);
  ylm_free(f);
  if (s == YLM_ENOMEM || s == YLM_ECANCELLED) return ylm_fail_plain(e, s);
  return s;
}
