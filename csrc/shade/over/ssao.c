/* ssao.c - openness of shading points by horizons in the picture: what the camera sees stands for what is there. */
#include <math.h>

#include "ambient.h"

#define GRAIN 256
#define NONE UINT32_MAX
/* 16 samples: slices through the line of sight, both sides of each, so many steps. */
#define SLICES 2
#define STEPS 4
/* Slices and steps are shifted by a pattern of PATTERN x PATTERN pixels, whose mean is taken. */
#define PATTERN 4
/* Sine of the angle over the surface below which a sample is the surface itself. */
#define FLAT 0.05

typedef struct job {
  const ylm_shade_view *view;
  double radius, right[3], up[3]; /* unit */
  double direction[SLICES * PATTERN * PATTERN]
                  [2]; /* of slices, by a pixel's place in the pattern */
  uint32_t *shown;     /* [pixels] the point with the largest share; NONE */
  float *raw;          /* [points] */
  float *out;          /* [points] */
} job;

/* A point seen from the camera. */
typedef struct seen {
  double p[3], n[3], sight[3]; /* sight: unit, towards the camera */
  double x, y, reach;          /* in the picture, pixels; reach: the radius at its depth */
} seen;

static void place(const job *j, size_t i, seen *s) {
  const ylm_shade_view *v = j->view;
  const ylm_camera_frame *f = &v->frame;
  double d[3];
  for (int a = 0; a < 3; a++) {
    s->p[a] = (double)v->position[i][a];
    s->n[a] = (double)v->normal[i][a];
    d[a] = s->p[a] - f->from[a];
  }
  double depth = 1 / (ylm_dot3d(d, f->forward) * f->pixel), length = 1 / sqrt(ylm_dot3d(d, d));
  s->x = v->o.width / 2.0 + ylm_dot3d(d, j->right) * depth;
  s->y = v->o.height / 2.0 - ylm_dot3d(d, j->up) * depth;
  s->reach = j->radius * depth;
  for (int a = 0; a < 3; a++) s->sight[a] = -d[a] * length;
}

/* The point that pixel (x, y) shows; NONE beside surfaces and outside of the picture. */
static uint32_t shown_at(const job *j, double x, double y) {
  const ylm_shade_options *o = &j->view->o;
  if (!(x >= 0 && y >= 0 && x < o->width && y < o->height)) return NONE;
  return j->shown[(size_t)y * (size_t)o->width + (size_t)x];
}

/* The largest cosine to the line of sight of what stands above the surface along (dx, dy); -1: nothing. */
static double horizon(const job *j, const seen *s, double dx, double dy, double shift) {
  double most = -1, far = j->radius * j->radius;
  for (int k = 0; k < STEPS; k++) {
    double t = s->reach * (k + shift) / STEPS;
    uint32_t i = shown_at(j, s->x + t * dx, s->y + t * dy);
    if (i == NONE) continue;
    const float *q = j->view->position[i];
    double d[3] = {(double)q[0] - s->p[0], (double)q[1] - s->p[1], (double)q[2] - s->p[2]};
    double square = ylm_dot3d(d, d), up = ylm_dot3d(d, s->n);
    if (!(square > 0 && square < far && up > 0 && up * up > FLAT * FLAT * square)) continue;
    most = fmax(most, ylm_dot3d(d, s->sight) / sqrt(square));
  }
  return most;
}

/* The integral of the cosine about the normal from the line of sight to the horizon. The horizon's
   angle h has the cosine c and this sign; the normal stands at an angle of these cosine and sine,
   on the side of h > 0. */
static double arc(double c, double sign, double cosine, double sine) {
  double h = sign * acos(c), twice = sign * 2 * c * sqrt(1 - c * c);
  return (cosine - (2 * c * c - 1) * cosine - twice * sine + 2 * h * sine) / 4;
}

/* Adds what a slice along the picture's (dx, dy) lets through, and what it would without horizons. */
static void slice(const job *j, const seen *s, double dx, double dy, double shift, double sum[2]) {
  double along[3];
  for (int a = 0; a < 3; a++) along[a] = dx * j->right[a] - dy * j->up[a];
  double over = ylm_dot3d(along, s->sight);
  for (int a = 0; a < 3; a++) along[a] -= over * s->sight[a];
  double length = sqrt(ylm_dot3d(along, along)), up = ylm_dot3d(s->n, s->sight),
         side = ylm_dot3d(s->n, along) / length;
  double part = sqrt(up * up + side * side);
  if (!(part > 0)) return;
  double cosine = up / part, sine = side / part, g = atan2(side, up);
  double c = horizon(j, s, dx, dy, shift), d = horizon(j, s, -dx, -dy, shift);
  /* without horizons h is g + 90 and g - 90 degrees */
  double half = (2 * cosine + 2 * g * sine) / 4, quarter = YLM_PI * sine / 4,
         above = half + quarter;
  double below = half - quarter;
  sum[1] += part * 2 * half;
  if (c > -sine) above = arc(fmin(1, c), 1, cosine, sine);
  if (d > sine) below = arc(fmin(1, d), -1, cosine, sine);
  sum[0] += part * (above + below);
}

static ylm_status look(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  for (size_t i = begin; i < end; i++) {
    seen s;
    double sum[2] = {0};
    place(j, i, &s);
    unsigned x = (unsigned)(s.x < 0 ? 0 : s.x) % PATTERN,
             y = (unsigned)(s.y < 0 ? 0 : s.y) % PATTERN;
    double shift = ylm_scene_radical(PATTERN * ((y + 2 * x) % PATTERN) + x) + 1.0 / 32;
    for (int k = 0; s.reach > 1 && k < SLICES; k++) {
      const double *d = j->direction[SLICES * (PATTERN * x + y) + (unsigned)k];
      slice(j, &s, d[0], d[1], shift, sum);
    }
    j->raw[i] = sum[1] > 0 ? (float)fmin(1, fmax(0, sum[0] / sum[1])) : 1;
  }
  return YLM_OK;
}

/* The mean over PATTERN x PATTERN pixels of what lies in the point's plane. */
static ylm_status smooth(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  job *j = context;
  const ylm_shade_view *v = j->view;
  for (size_t i = begin; i < end; i++) {
    seen s;
    double sum = (double)j->raw[i], n = 1;
    place(j, i, &s);
    for (int k = 0; k < PATTERN * PATTERN; k++) {
      uint32_t q = shown_at(j, s.x + k % PATTERN - PATTERN / 2, s.y + k / PATTERN - PATTERN / 2);
      if (q == NONE || q == i || v->mesh[q] != v->mesh[i]) continue;
      double d[3], tilt = 0;
      for (int a = 0; a < 3; a++) {
        d[a] = (double)v->position[q][a] - s.p[a];
        tilt += (double)v->normal[q][a] * s.n[a];
      }
      if (tilt < 0.9 || fabs(ylm_dot3d(d, s.n)) > 0.05 * j->radius) continue;
      sum += (double)j->raw[q];
      n++;
    }
    j->out[i] = (float)(sum / n);
  }
  return YLM_OK;
}

ylm_status ylm__shade_ssao(const ylm_shade_view *v, double radius, int threads, float *out) {
  if (v->number || v->corner) return YLM_EINVAL;
  job j = {.view = v, .radius = radius, .out = out};
  double half = v->frame.pixel / 2 * v->o.height;
  for (int a = 0; a < 3; a++) {
    j.up[a] = v->frame.up[a] / half;
    j.right[a] = v->frame.right[a] * v->o.height / (half * v->o.width);
  }
  for (int k = 0; k < SLICES * PATTERN * PATTERN; k++) {
    double turn = (k / SLICES + 0.5) / (PATTERN * PATTERN),
           angle = YLM_PI * (k % SLICES + turn) / SLICES;
    j.direction[k][0] = cos(angle);
    j.direction[k][1] = sin(angle);
  }
  j.shown = ylm_alloc(v->stats.pixels, sizeof *j.shown);
  j.raw = ylm_alloc(v->points ? v->points : 1, sizeof *j.raw);
  ylm_status s = j.shown && j.raw ? YLM_OK : YLM_ENOMEM;
  for (size_t p = 0; s == YLM_OK && p < v->stats.pixels; p++) {
    uint32_t best = NONE;
    for (size_t i = v->pixel[p].first; i < v->pixel[p + 1].first; i++)
      if (best == NONE || v->entry[i].weight > v->entry[best].weight) best = (uint32_t)i;
    j.shown[p] = best;
  }
  if (s == YLM_OK) s = ylm_parallel(v->points, GRAIN, threads, look, &j, NULL, NULL);
  if (s == YLM_OK) s = ylm_parallel(v->points, GRAIN, threads, smooth, &j, NULL, NULL);
  ylm_free(j.shown);
  ylm_free(j.raw);
  return s;
}
