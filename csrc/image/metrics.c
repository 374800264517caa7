/* metrics.c - how far two images are apart. */
#include "metrics.h"

#include <math.h>
#include <string.h>

#define RADIUS 5 /* of the window of ssim, 11 x 11 */
#define FIELDS 6 /* weight, a, b, aa, bb, ab */

typedef struct partial {
  double square, absolute, percent, relative, ssim, max, peak;
  size_t pixels, bad; /* bad: one-based index of the first pixel that is not finite */
} partial;

typedef struct comparison {
  const float *a, *b, *mask;
  size_t width, height, channels;
  double peak, floor, epsilon;
  double window[2 * RADIUS + 1];
  partial *part; /* one for each block */
} comparison;

static bool counts(const comparison *c, size_t pixel) { return !c->mask || c->mask[pixel] != 0; }

/* First pass: which pixels count, the largest reference, what is not finite. */
static ylm_status survey(void *context, size_t begin, size_t end, int worker) {
  comparison *c = context;
  partial *p = &c->part[begin / IMAGE_ROWS];
  (void)worker;
  for (size_t i = begin * c->width; i < end * c->width; i++) {
    if (!counts(c, i)) continue;
    p->pixels++;
    for (size_t k = 0; k < c->channels; k++) {
      double x = c->a[i * c->channels + k], y = c->b[i * c->channels + k];
      if (!(isfinite(x) && isfinite(y)) && !p->bad) p->bad = i + 1;
      if (fabs(y) > p->peak) p->peak = fabs(y);
    }
  }
  return YLM_OK;
}

/* Second pass: sums of differences. */
static ylm_status sum_up(void *context, size_t begin, size_t end, int worker) {
  comparison *c = context;
  partial *p = &c->part[begin / IMAGE_ROWS];
  (void)worker;
  for (size_t i = begin * c->width; i < end * c->width; i++) {
    if (!counts(c, i)) continue;
    for (size_t k = 0; k < c->channels; k++) {
      double y = c->b[i * c->channels + k], d = fabs((double)c->a[i * c->channels + k] - y);
      p->square += d * d;
      p->relative += d * d / (y * y + c->epsilon);
      p->absolute += d;
      if (d > 0) p->percent += d / fmax(fabs(y), c->floor);
      if (d > p->max) p->max = d;
    }
  }
  return YLM_OK;
}

/* -- structural similarity ---------------------------------------------------------- */

/* The six fields of row y of channel k, blurred along the row: out[FIELDS][width]. */
static void blur_row(const comparison *c, size_t y, size_t k, double *raw, double *out) {
  size_t w = c->width;
  for (size_t x = 0; x < w; x++) {
    size_t i = y * w + x;
    bool in = counts(c, i);
    double a = in ? c->a[i * c->channels + k] : 0, b = in ? c->b[i * c->channels + k] : 0;
    double f[FIELDS] = {in, a, b, a * a, b * b, a * b};
    for (int q = 0; q < FIELDS; q++) raw[(size_t)q * w + x] = f[q];
  }
  for (size_t q = 0; q < FIELDS; q++)
    for (size_t x = 0; x < w; x++) {
      double sum = 0;
      size_t lo = x < RADIUS ? 0 : x - RADIUS, hi = x + RADIUS < w ? x + RADIUS : w - 1;
      for (size_t t = lo; t <= hi; t++) sum += c->window[t + RADIUS - x] * raw[q * w + t];
      out[q * w + x] = sum;
    }
}

/* Similarity of one window from its weighted sums. */
static double similarity(const double f[FIELDS], double peak) {
  double c1 = 0.01 * peak * 0.01 * peak, c2 = 0.03 * peak * 0.03 * peak;
  double a = f[1] / f[0], b = f[2] / f[0];
  double va = f[3] / f[0] - a * a, vb = f[4] / f[0] - b * b, cov = f[5] / f[0] - a * b;
  double over = (2 * a * b + c1) * (2 * cov + c2), under = (a * a + b * b + c1) * (va + vb + c2);
  return under == 0 ? over == 0 : over / under;
}

static ylm_status ssim_rows(void *context, size_t begin, size_t end, int worker) {
  comparison *c = context;
  (void)worker;
  size_t w = c->width, first = begin < RADIUS ? 0 : begin - RADIUS;
  size_t last = end + RADIUS < c->height ? end + RADIUS : c->height;
  double *raw = ylm_alloc(FIELDS * w, sizeof *raw);
  double *rows = ylm_alloc((last - first) * FIELDS * w, sizeof *rows);
  ylm_status s = raw && rows ? YLM_OK : YLM_ENOMEM;
  for (size_t k = 0; s == YLM_OK && k < c->channels; k++) {
    for (size_t y = first; y < last; y++) blur_row(c, y, k, raw, rows + (y - first) * FIELDS * w);
    for (size_t y = begin; y < end; y++)
      for (size_t x = 0; x < w; x++) {
        if (!counts(c, y * w + x)) continue;
        double f[FIELDS] = {0};
        size_t lo = y < RADIUS ? 0 : y - RADIUS,
               hi = y + RADIUS < c->height ? y + RADIUS : c->height - 1;
        for (size_t t = lo; t <= hi; t++)
          for (size_t q = 0; q < FIELDS; q++)
            f[q] += c->window[t + RADIUS - y] * rows[((t - first) * FIELDS + q) * w + x];
        c->part[begin / IMAGE_ROWS].ssim += similarity(f, c->peak);
      }
  }
  ylm_free(raw);
  ylm_free(rows);
  return s;
}

static void make_window(double window[2 * RADIUS + 1]) {
  double sum = 0;
  for (int i = -RADIUS; i <= RADIUS; i++) sum += window[i + RADIUS] = exp(-i * i / (2 * 1.5 * 1.5));
  for (int i = 0; i <= 2 * RADIUS; i++) window[i] /= sum;
}

/* -- both -------------------------------------------------------------------------------- */

ylm_status ylm__image_not_finite(size_t i, size_t width, ylm_error *e) {
  return ylm_fail(e, YLM_EDOMAIN, "pixel (%zu, %zu) is not finite: give a mask that leaves it out",
                  i % width + 1, i / width + 1);
}

ylm_status ylm__image_match(const ylm_image *a, const ylm_image *b, const char *name,
                            const ylm_layer **la, const ylm_layer **lb, ylm_error *e) {
  *la = ylm_image_find(a, name);
  *lb = *la ? ylm_image_find(b, name ? name : (*la)->name) : NULL;
  if (*la && !name && !*lb) *lb = ylm_image_find(b, NULL);
  if (!*la || !*lb)
    return ylm_fail(e, YLM_EINVAL, "no layer '%s' in %s image", name ? name : "(first)",
                    *la ? "the other" : "this");
  if (a->width != b->width || a->height != b->height)
    return ylm_fail(e, YLM_ESHAPE, "sizes differ: %d x %d and %d x %d", a->width, a->height,
                    b->width, b->height);
  if ((*la)->channels != (*lb)->channels)
    return ylm_fail(e, YLM_ESHAPE, "layer '%s' has %d channels, the other one %d", (*la)->name,
                    (*la)->channels, (*lb)->channels);
  return YLM_OK;
}

static ylm_status measure(comparison *c, size_t blocks, double peak, double floor, double epsilon,
                          int threads, const ylm_progress *progress, ylm_metrics *m, ylm_error *e) {
  ylm_parallel(c->height, IMAGE_ROWS, threads, survey, c, NULL, NULL);
  for (size_t i = 0; i < blocks; i++) {
    if (c->part[i].bad) return ylm__image_not_finite(c->part[i].bad - 1, c->width, e);
    m->pixels += c->part[i].pixels;
    if (c->part[i].peak > m->peak) m->peak = c->part[i].peak;
  }
  if (m->pixels == 0) return ylm_fail(e, YLM_EINVAL, "the mask leaves no pixel");
  if (peak > 0) m->peak = peak;
  m->floor = floor > 0 ? floor : m->peak / 1000;
  c->peak = m->peak;
  c->floor = m->floor;
  c->epsilon = m->epsilon = epsilon > 0 ? epsilon : 0.01;
  ylm_parallel(c->height, IMAGE_ROWS, threads, sum_up, c, NULL, NULL);
  ylm_status s = ylm_parallel(c->height, IMAGE_ROWS, threads, ssim_rows, c, progress, "comparing");
  if (s != YLM_OK) return ylm_fail_plain(e, s);
  for (size_t i = 0; i < blocks; i++) {
    m->mse += c->part[i].square;
    m->mae += c->part[i].absolute;
    m->mape += c->part[i].percent;
    m->relmse += c->part[i].relative;
    m->ssim += c->part[i].ssim;
    if (c->part[i].max > m->max) m->max = c->part[i].max;
  }
  double n = (double)m->pixels * (double)c->channels;
  m->mse /= n;
  m->mae /= n;
  m->mape *= 100 / n;
  m->relmse /= n;
  m->ssim /= n;
  m->rmse = sqrt(m->mse);
  m->psnr = m->mse > 0 ? 10 * log10(m->peak * m->peak / m->mse) : INFINITY;
  return YLM_OK;
}

ylm_status ylm_image_compare(const ylm_image *a, const ylm_image *b, const char *name,
                             const float *mask, double peak, double floor, double epsilon,
                             int threads, const ylm_progress *progress, ylm_metrics *m,
                             ylm_error *e) {
  const ylm_layer *la, *lb;
  memset(m, 0, sizeof *m);
  ylm_status s = ylm__image_match(a, b, name, &la, &lb, e);
  if (s != YLM_OK) return s;
  comparison c = {.a = la->data,
                  .b = lb->data,
                  .mask = mask,
                  .width = (size_t)a->width,
                  .height = (size_t)a->height,
                  .channels = (size_t)la->channels};
  size_t blocks = (c.height + IMAGE_ROWS - 1) / IMAGE_ROWS;
  make_window(c.window);
  c.part = ylm_alloc_zero(blocks, sizeof *c.part);
  if (!c.part) return ylm_no_memory(e);
  s = measure(&c, blocks, peak, floor, epsilon, threads, progress, m, e);
  ylm_free(c.part);
  return s;
}

ylm_status ylm_image_difference(const ylm_image *a, const ylm_image *b, const char *name,
                                ylm_difference kind, double scale, double floor, ylm_image **out,
                                ylm_error *e) {
  const ylm_layer *la, *lb;
  *out = NULL;
  ylm_status s = ylm__image_match(a, b, name, &la, &lb, e);
  if (s != YLM_OK) return s;
  s = ylm_image_create(a->width, a->height, out, e);
  if (s == YLM_OK) s = ylm_image_add(*out, la->name, la->channels, e);
  if (s != YLM_OK) {
    ylm_image_free(*out);
    *out = NULL;
    return s;
  }
  size_t n = (size_t)a->width * (size_t)a->height * (size_t)la->channels;
  for (size_t i = 0; i < n; i++) {
    double y = lb->data[i], d = (double)la->data[i] - y;
    if (kind != YLM_DIFFERENCE_SIGNED) d = fabs(d);
    if (kind == YLM_DIFFERENCE_RELATIVE && d != 0) d /= fmax(fabs(y), floor);
    (*out)->layer[0].data[i] = (float)(d * scale);
  }
  return YLM_OK;
}
