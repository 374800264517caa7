/* texture.c - images on parallelograms, cut into parts of one colour: quadrilaterals, tiles. */
#include <math.h>
#include <string.h>

#include "ylm_light.h"

/* Texels x0 .. x1-1 of rows y0 .. y1-1. */
typedef struct part {
  size_t x0, y0, x1, y1;
} part;

typedef struct cutting {
  const ylm_light_texture *t;
  double tolerance; /* of radiance */
  double wide, high;
  void (*emit)(void *context, const ylm_light_texture *t, const part *p, const double mean[3]);
  void *context;
} cutting;

static const float *texel(const ylm_light_texture *t, size_t x, size_t y) {
  return t->texel + 3 * (y * t->width + x);
}

/* Mean of a part; returns the largest difference between its texels in a channel. */
static double survey(const ylm_light_texture *t, const part *p, double mean[3]) {
  float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  double n = (double)(p->x1 - p->x0) * (double)(p->y1 - p->y0), spread = 0;
  mean[0] = mean[1] = mean[2] = 0;
  for (size_t y = p->y0; y < p->y1; y++)
    for (size_t x = p->x0; x < p->x1; x++)
      for (int c = 0; c < 3; c++) {
        float v = texel(t, x, y)[c];
        mean[c] += (double)v;
        lo[c] = v < lo[c] ? v : lo[c];
        hi[c] = v > hi[c] ? v : hi[c];
      }
  for (int c = 0; c < 3; c++) {
    mean[c] *= t->scale / n;
    spread = fmax(spread, (double)hi[c] - (double)lo[c]);
  }
  return spread;
}

/* Emits a part, or its halves or quarters where it is too large, too long or of several colours. */
static void cut(const cutting *k, part p) {
  double mean[3], w = (double)(p.x1 - p.x0), h = (double)(p.y1 - p.y0);
  bool one = w == 1 && h == 1;
  bool shaped = w <= k->wide && h <= k->high && fmax(w / h, h / w) <= 2;
  if ((one || shaped) && (survey(k->t, &p, mean) <= k->tolerance || one)) {
    if (mean[0] != 0 || mean[1] != 0 || mean[2] != 0) k->emit(k->context, k->t, &p, mean);
    return;
  }
  size_t x = (p.x0 + p.x1 + 1) / 2, y = (p.y0 + p.y1 + 1) / 2;
  if (!(w > 1 && 2 * w > h)) x = p.x1;
  if (!(h > 1 && 2 * h > w)) y = p.y1;
  cut(k, (part){p.x0, p.y0, x, y});
  if (x < p.x1) cut(k, (part){x, p.y0, p.x1, y});
  if (y < p.y1) cut(k, (part){p.x0, y, x, p.y1});
  if (x < p.x1 && y < p.y1) cut(k, (part){x, y, p.x1, p.y1});
}

static void cut_all(const ylm_light_texture *t, void *context,
                    void (*emit)(void *, const ylm_light_texture *, const part *, const double *)) {
  double most = 0, w = (double)t->width, h = (double)t->height;
  for (size_t i = 0; i < 3 * t->width * t->height; i++)
    most = fmax(most, fabs((double)t->texel[i]));
  cutting k = {t,      t->tolerance * most, fmax(1, t->largest * w), fmax(1, t->largest * h), emit,
               context};
  cut(&k, (part){0, 0, t->width, t->height});
}

/* The place of the corner of texels (x, y), counted from the top left. */
static void place(const ylm_light_texture *t, double x, double y, double out[3]) {
  double s = x / (double)t->width, r = 1 - y / (double)t->height;
  for (int a = 0; a < 3; a++) out[a] = t->corner[a] + s * t->u[a] + r * t->v[a];
}

/* -- quadrilaterals -------------------------------------------------------------------------- */

typedef struct quads {
  size_t n;
  double *vertices, *radiance;
} quads;

static void corners(const ylm_light_texture *t, const part *p, double out[12]) {
  place(t, (double)p->x0, (double)p->y1, out);
  place(t, (double)p->x1, (double)p->y1, out + 3);
  place(t, (double)p->x1, (double)p->y0, out + 6);
  place(t, (double)p->x0, (double)p->y0, out + 9);
}

static void emit_quad(void *context, const ylm_light_texture *t, const part *p,
                      const double mean[3]) {
  quads *q = context;
  size_t i = q->n++;
  if (!q->vertices) return;
  corners(t, p, q->vertices + 12 * i);
  memcpy(q->radiance + 3 * i, mean, 3 * sizeof *mean);
}

size_t ylm_light_texture_quads(const ylm_light_texture *t, double *vertices, double *radiance) {
  quads q = {0, vertices, radiance};
  cut_all(t, &q, emit_quad);
  return q.n;
}

/* -- tiles ----------------------------------------------------------------------------------- */

size_t ylm_light_texture_tiles(const ylm_light_texture *t, size_t across, double *triangles,
                               double *radiance) {
  size_t w = t->width, h = t->height, nx = w < across ? w : across, ny = h < across ? h : across;
  if (!triangles) return 2 * nx * ny;
  for (size_t j = 0; j < ny; j++)
    for (size_t i = 0; i < nx; i++) {
      part p = {i * w / nx, j * h / ny, (i + 1) * w / nx, (j + 1) * h / ny};
      double c[12], mean[3] = {0, 0, 0}, n = (double)(p.x1 - p.x0) * (double)(p.y1 - p.y0);
      corners(t, &p, c);
      for (size_t y = p.y0; y < p.y1; y++)
        for (size_t x = p.x0; x < p.x1; x++)
          for (int a = 0; a < 3; a++) mean[a] += fabs((double)texel(t, x, y)[a] * t->scale) / n;
      for (int half = 0; half < 2; half++, triangles += 9, radiance += 3) {
        memcpy(triangles, c, 3 * sizeof *c);
        memcpy(triangles + 3, c + (half ? 6 : 3), 3 * sizeof *c);
        memcpy(triangles + 6, c + (half ? 9 : 6), 3 * sizeof *c);
        memcpy(radiance, mean, sizeof mean);
      }
    }
  return 2 * nx * ny;
}
