/* canvas.c - pixels that pictures, bars and texts are laid out on. */
#include "ylm_figure.h"

#include <math.h>
#include <string.h>

static uint8_t byte(double x) { return x >= 255 ? 255 : x > 0 ? (uint8_t)(x + 0.5) : 0; }

ylm_status ylm_figure_canvas_init(ylm_figure_canvas *c, int width, int height,
                                  const double rgb[3]) {
  memset(c, 0, sizeof *c);
  if (width < 1 || height < 1 || width > 32768 || height > 32768) return YLM_ERANGE;
  size_t n = (size_t)width * (size_t)height;
  c->pixel = ylm_alloc(n, 3);
  if (!c->pixel) return YLM_ENOMEM;
  c->width = width;
  c->height = height;
  for (size_t i = 0; i < 3 * n; i++) c->pixel[i] = byte(255 * rgb[i % 3]);
  return YLM_OK;
}

void ylm_figure_canvas_clear(ylm_figure_canvas *c) {
  ylm_free(c->pixel);
  memset(c, 0, sizeof *c);
}

/* Mixes a colour into pixel x, y, which may lie outside. */
static void mix(ylm_figure_canvas *c, int x, int y, const double rgb[3], double alpha) {
  if (x < 0 || y < 0 || x >= c->width || y >= c->height || !(alpha > 0)) return;
  uint8_t *p = c->pixel + 3 * ((size_t)y * (size_t)c->width + (size_t)x);
  for (int a = 0; a < 3; a++) p[a] = byte(p[a] + alpha * (255 * rgb[a] - p[a]));
}

/* Limits to what an int loop over the canvas may run through. */
static int clamp(double x, int limit) { return x > limit ? limit : x > 0 ? (int)x : 0; }

/* Length of the overlap of [a, a+1] and [lo, hi]. */
static double overlap(double a, double lo, double hi) {
  return fmax(0, fmin(a + 1, hi) - fmax(a, lo));
}

void ylm_figure_canvas_rectangle(ylm_figure_canvas *c, double x, double y, double width,
                                 double height, const double rgba[4]) {
  int x0 = clamp(floor(x), c->width), x1 = clamp(ceil(x + width), c->width);
  int y0 = clamp(floor(y), c->height), y1 = clamp(ceil(y + height), c->height);
  for (int j = y0; j < y1; j++)
    for (int i = x0; i < x1; i++)
      mix(c, i, j, rgba, rgba[3] * overlap(i, x, x + width) * overlap(j, y, y + height));
}

void ylm_figure_canvas_line(ylm_figure_canvas *c, double x0, double y0, double x1, double y1,
                            double width, const double rgba[4]) {
  double dx = x1 - x0, dy = y1 - y0, length = sqrt(dx * dx + dy * dy), reach = width / 2 + 1;
  if (!(length > 0)) return;
  int left = clamp(floor(fmin(x0, x1) - reach), c->width);
  int right = clamp(ceil(fmax(x0, x1) + reach), c->width);
  int top = clamp(floor(fmin(y0, y1) - reach), c->height);
  int bottom = clamp(ceil(fmax(y0, y1) + reach), c->height);
  for (int j = top; j < bottom; j++)
    for (int i = left; i < right; i++) {
      double px = i + 0.5 - x0, py = j + 0.5 - y0;
      double along = (px * dx + py * dy) / length, across = fabs(px * dy - py * dx) / length;
      double ends = fmin(fmin(along, length - along) + 0.5, 1),
             side = fmin(width / 2 - across + 0.5, 1);
      if (ends > 0 && side > 0) mix(c, i, j, rgba, rgba[3] * ends * side);
    }
}

void ylm_figure_canvas_blend(ylm_figure_canvas *c, int x, int y, int w, int h,
                             const uint8_t *rgba) {
  if (x >= c->width || y >= c->height) return;
  for (int j = 0; j < h; j++)
    for (int i = 0; i < w; i++) {
      const uint8_t *p = rgba + 4 * ((size_t)j * (size_t)w + (size_t)i);
      double rgb[3] = {p[0] / 255.0, p[1] / 255.0, p[2] / 255.0};
      mix(c, x + i, y + j, rgb, p[3] / 255.0);
    }
}

/* Average of the source over [x0, x1] x [y0, y1] in its pixels. */
static void average(const ylm_figure_canvas *f, double x0, double y0, double x1, double y1,
                    double sum[3]) {
  double weight = 0;
  sum[0] = sum[1] = sum[2] = 0;
  for (int j = clamp(floor(y0), f->height - 1); j < f->height && j < y1; j++)
    for (int i = clamp(floor(x0), f->width - 1); i < f->width && i < x1; i++) {
      double w = overlap(i, x0, x1) * overlap(j, y0, y1);
      const uint8_t *p = f->pixel + 3 * ((size_t)j * (size_t)f->width + (size_t)i);
      for (int a = 0; a < 3; a++) sum[a] += w * p[a];
      weight += w;
    }
  for (int a = 0; a < 3 && weight > 0; a++) sum[a] /= weight;
}

/* The source between its pixels' middles. */
static void interpolate(const ylm_figure_canvas *f, double x, double y, double out[3]) {
  x = fmin(fmax(x - 0.5, 0), f->width - 1), y = fmin(fmax(y - 0.5, 0), f->height - 1);
  int i = (int)x, j = (int)y, i1 = i + 1 < f->width ? i + 1 : i, j1 = j + 1 < f->height ? j + 1 : j;
  double u = x - i, v = y - j;
#define P(a, b) f->pixel[3 * ((size_t)(b) * (size_t)f->width + (size_t)(a)) + (size_t)k]
  for (int k = 0; k < 3; k++)
    out[k] =
        (1 - v) * ((1 - u) * P(i, j) + u * P(i1, j)) + v * ((1 - u) * P(i, j1) + u * P(i1, j1));
#undef P
}

void ylm_figure_canvas_copy(ylm_figure_canvas *c, int x, int y, int w, int h,
                            const ylm_figure_canvas *from, double sx, double sy, double sw,
                            double sh, bool sharp) {
  if (w < 1 || h < 1) return;
  double kx = sw / w, ky = sh / h;
  long right = (long)c->width - x, bottom = (long)c->height - y; /* of the target, from x and y */
  for (long j = y < 0 ? -(long)y : 0; j < h && j < bottom; j++)
    for (long i = x < 0 ? -(long)x : 0; i < w && i < right; i++) {
      double rgb[3], px = sx + (double)i * kx, py = sy + (double)j * ky;
      if (kx >= 1 || ky >= 1)
        average(from, px, py, px + fmax(kx, 1e-6), py + fmax(ky, 1e-6), rgb);
      else if (sharp)
        interpolate(from, floor(px + kx / 2) + 0.5, floor(py + ky / 2) + 0.5, rgb);
      else
        interpolate(from, px + kx / 2, py + ky / 2, rgb);
      uint8_t *p = c->pixel + 3 * ((size_t)(y + j) * (size_t)c->width + (size_t)(x + i));
      for (int a = 0; a < 3; a++) p[a] = byte(rgb[a]);
    }
}
