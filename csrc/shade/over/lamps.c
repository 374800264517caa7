/* lamps.c - lamps drawn over an image without rays: those that move are not in the traced scene. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../calibration.h"
#include "../gen/picture.h"
#include "../view.h"
#include "uncovered.h"
#include "ylm_shade_over.h"

/* A lamp as the camera sees it. */
typedef struct disc {
  double to[3];       /* unit vector from the camera */
  double depth, half; /* along the view axis; chord of half the angle it fills */
  double radius;
  double x, y, reach; /* in pixels */
  const float *radiance;
} disc;

typedef struct lamps_job {
  const ylm_shade_view *v;
  const disc *disc;
  size_t n;
  float *out, *depth; /* [pixels][3]; [pixels]: one of them is NULL */
} lamps_job;

/* False if the lamp is behind the camera or around it, or off the image. */
static bool project(const ylm_shade_view *v, const float sphere[4], const float *radiance,
                    disc *d) {
  const ylm_camera_frame *f = &v->frame;
  double to[3], width = v->o.width, height = v->o.height, r = (double)sphere[3];
  for (int a = 0; a < 3; a++) to[a] = (double)sphere[a] - f->from[a];
  double far = sqrt(ylm_dot3d(to, to)), z = ylm_dot3d(to, f->forward);
  if (!(r > 0) || !(z > r) || !(far > r)) return false;
  double x = ylm_dot3d(to, f->right) / ylm_dot3d(f->right, f->right) / z;
  double y = ylm_dot3d(to, f->up) / ylm_dot3d(f->up, f->up) / z;
  *d = (disc){.depth = z, .half = 2 * sin(asin(r / far) / 2), .radius = r, .radiance = radiance};
  for (int a = 0; a < 3; a++) d->to[a] = to[a] / far;
  d->x = (x + 1) / 2 * width;
  d->y = (1 - y) / 2 * height;
  /* An ellipse: at most this far from the projected centre. */
  d->reach = 1 + tan(d->half) * (far / z) * (far / z) * 1.5 / f->pixel;
  return d->x + d->reach > 0 && d->x - d->reach < width && d->y + d->reach > 0 &&
         d->y - d->reach < height;
}

/* How much of the pixel lies on the disc. */
static double covered(const ylm_shade_view *v, const disc *d, int px, int py) {
  const ylm_camera_frame *f = &v->frame;
  double x = to_the_right(px + 0.5, v->o.width), y = upwards(py + 0.5, v->o.height), u[3];
  for (int a = 0; a < 3; a++) u[a] = ray_along(f->forward[a], f->right[a], f->up[a], x, y);
  return disc_share(u, d->to, d->half, f->pixel);
}

/* The pixels begin .. end-1 of a row that may be on the disc. The direction to pixel x is u = a + x
   right; the disc has the pixels with (u . to)^2 >= cosine^2 u . u. */
static void span(const ylm_shade_view *v, const disc *d, int py, int *begin, int *end) {
  const ylm_camera_frame *f = &v->frame;
  double y = 1 - 2 * (py + 0.5) / v->o.height, a[3], wide = d->half + f->pixel;
  for (int i = 0; i < 3; i++) a[i] = f->forward[i] + y * f->up[i];
  double cosine = fmax(0, 1 - wide * wide / 2), c2 = cosine * cosine;
  double t0 = ylm_dot3d(a, d->to), t1 = ylm_dot3d(f->right, d->to);
  double k0 = t0 * t0 - c2 * ylm_dot3d(a, a), k1 = 2 * (t0 * t1 - c2 * ylm_dot3d(a, f->right)),
         k2 = t1 * t1 - c2 * ylm_dot3d(f->right, f->right), root2 = k1 * k1 - 4 * k0 * k2;
  if (k2 >= 0) return; /* so near that it has no end: all of the row */
  if (!(root2 >= 0)) {
    *end = *begin;
    return;
  }
  double root = sqrt(root2), low = (-k1 + root) / (2 * k2), high = (-k1 - root) / (2 * k2);
  double half = 0.5 * v->o.width;
  *begin = (int)fmax(*begin, floor((low + 1) * half - 0.5));
  *end = (int)fmin(*end, ceil((high + 1) * half + 0.5));
}

/* The box of a disc's pixels within rows top .. bottom-1: x0, x1, y0, y1. */
static void box_of(const ylm_shade_view *v, const disc *d, int top, int bottom, int box[4]) {
  box[0] = (int)fmax(0, floor(d->x - d->reach));
  box[1] = (int)fmin(v->o.width, ceil(d->x + d->reach));
  box[2] = (int)fmax(top, floor(d->y - d->reach));
  box[3] = (int)fmin(bottom, ceil(d->y + d->reach));
}

static void draw(const lamps_job *j, const disc *d, int top, int bottom) {
  const ylm_shade_view *v = j->v;
  int box[4];
  box_of(v, d, top, bottom, box);
  for (int y = box[2]; y < box[3]; y++) {
    int begin = box[0], end = box[1];
    span(v, d, y, &begin, &end);
    for (int x = begin; x < end; x++) {
      double part = covered(v, d, x, y);
      size_t pixel = (size_t)y * (size_t)v->o.width + (size_t)x;
      if (part > 0) part *= open_part(v, pixel, d->depth);
      if (j->depth && part > 0.5)
        j->depth[pixel] = fminf(j->depth[pixel], (float)(d->depth - d->radius));
      for (int c = 0; j->out && part > 0 && c < 3; c++) {
        float *to = &j->out[3 * pixel + (size_t)c];
        *to = drawn_over(*to, (float)part, d->radiance[c]);
      }
    }
  }
}

static ylm_status draw_rows(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const lamps_job *j = context;
  for (size_t i = 0; i < j->n; i++) draw(j, &j->disc[i], (int)begin, (int)end);
  return YLM_OK;
}

static int far_first(const void *a, const void *b) {
  double x = ((const disc *)a)->depth, y = ((const disc *)b)->depth;
  return x > y ? -1 : x < y;
}

/* The lamps in sight, the farthest first, which the caller frees; NULL without memory. */
static disc *discs_of(const ylm_shade_view *v, const ylm_scene_lamps *lamps, size_t *n) {
  disc *d = ylm_alloc(lamps->shape.spheres, sizeof *d);
  *n = 0;
  for (size_t i = 0; d && i < lamps->shape.spheres; i++)
    *n += project(v, lamps->shape.sphere + 4 * i, lamps->radiance + 3 * i, &d[*n]);
  if (d) qsort(d, *n, sizeof *d, far_first);
  return d;
}

static ylm_status draw_all(const ylm_shade_view *v, const ylm_scene_lamps *lamps, int threads,
                           float *out, float *depth) {
  lamps_job j = {.v = v, .out = out, .depth = depth};
  disc *d = discs_of(v, lamps, &j.n);
  if (!d) return YLM_ENOMEM;
  j.disc = d;
  ylm_status s =
      ylm_parallel((size_t)v->o.height, SHADE_LAMP_ROWS, threads, draw_rows, &j, NULL, NULL);
  ylm_free(d);
  return s;
}

ylm_status ylm_shade_draw_lamps(const ylm_shade_view *v, const ylm_scene_lamps *lamps, int threads,
                                float *out) {
  return draw_all(v, lamps, threads, out, NULL);
}

ylm_status ylm_shade_lamp_depth(const ylm_shade_view *v, const ylm_scene_lamps *lamps, int threads,
                                float *depth) {
  return draw_all(v, lamps, threads, NULL, depth);
}

/* False where the sphere's rim is farther than `reach` pixels from x, y: cheaper than to project. */
static bool may_be_near(const ylm_shade_view *v, const float sphere[4], double x, double y,
                        double reach) {
  const ylm_camera_frame *f = &v->frame;
  double to[3], r = (double)sphere[3];
  for (int a = 0; a < 3; a++) to[a] = (double)sphere[a] - f->from[a];
  double z = ylm_dot3d(to, f->forward), far2 = ylm_dot3d(to, to);
  if (!(z > r)) return false;
  if (far2 < 4 * r * r) return true; /* so near that its picture is no small ellipse */
  double px = ylm_dot3d(to, f->right) / ylm_dot3d(f->right, f->right) / z;
  double py = ylm_dot3d(to, f->up) / ylm_dot3d(f->up, f->up) / z;
  double wide = reach + 2 + 2 * r * sqrt(far2) / (z * z) / f->pixel;
  return fabs((px + 1) / 2 * v->o.width - x) < wide && fabs((1 - py) / 2 * v->o.height - y) < wide;
}

bool ylm_shade_lamp_at(const ylm_shade_view *v, const ylm_scene_lamps *lamps, double x, double y,
                       double reach, ylm_shade_lamp *found) {
  const ylm_camera_frame *f = &v->frame;
  double right = to_the_right(x, v->o.width), up = upwards(y, v->o.height), u[3];
  for (int a = 0; a < 3; a++) u[a] = ray_along(f->forward[a], f->right[a], f->up[a], right, up);
  double length = sqrt(ylm_dot3d(u, u));
  int column = (int)fmin(fmax(x, 0), v->o.width - 1), row = (int)fmin(fmax(y, 0), v->o.height - 1);
  size_t pixel = (size_t)row * (size_t)v->o.width + (size_t)column;
  bool some = false;
  for (size_t i = 0; i < lamps->shape.spheres; i++) {
    disc d;
    const float *sphere = lamps->shape.sphere + 4 * i;
    if (!may_be_near(v, sphere, x, y, reach)) continue;
    if (!project(v, sphere, lamps->radiance + 3 * i, &d)) continue;
    double chord = 0;
    for (int a = 0; a < 3; a++) chord += (u[a] / length - d.to[a]) * (u[a] / length - d.to[a]);
    /* A pixel in direction u is seen under an angle that falls with the length of u. */
    double away = fmax(0, (sqrt(chord) - d.half) * length / f->pixel);
    if (!(away <= reach) || open_part(v, pixel, d.depth) < 0.5) continue;
    if (some && (away > found->away || (away == found->away && d.depth >= found->depth))) continue;
    *found = (ylm_shade_lamp){i, away, d.depth};
    some = true;
  }
  return some;
}

ylm_status ylm_shade_view_discs(const ylm_shade_view *v, const ylm_scene_lamps *lamps, double *out,
                                size_t *n) {
  disc *d = discs_of(v, lamps, n);
  if (!d) return YLM_ENOMEM;
  for (size_t i = 0; i < *n; i++, out += YLM_SHADE_DISC) {
    int box[4];
    box_of(v, &d[i], 0, v->o.height, box);
    memcpy(out, d[i].to, sizeof d[i].to);
    out[3] = d[i].depth;
    out[4] = d[i].half;
    for (int c = 0; c < 3; c++) out[5 + c] = (double)d[i].radiance[c];
    for (int c = 0; c < 4; c++) out[8 + c] = box[c];
  }
  ylm_free(d);
  return YLM_OK;
}
