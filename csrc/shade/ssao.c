/* ssao.c - openness of shading points by horizons in the picture: what the camera sees stands for what is there. */
#include <math.h>

#include "ambient.h"

#define GRAIN 256
#define HALF_TURN 3.14159265358979323846
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
  double radius;
  uint32_t *shown; /* [pixels] the point with the largest share; NONE */
  float *raw;      /* [points] */
  float *out;      /* [points] */
} job;

/* A point seen from the camera. */
typedef struct seen {
  double p[3], n[3], sight[3]; /* sight: unit, towards the camera */
  double x, y, reach;          /* in the picture, pixels; reach: the radius at its depth */
} seen;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Right and up in units of a pixel at distance 1. */
static void place(const job *j, size_t i, seen *s) {
  const ylm_shade_view *v = j->view;
  const ylm_camera_frame *f = &v->frame;
  double d[3], half = f->pixel / 2 * v->o.height;
  for (int a = 0; a < 3; a++) {
    s->p[a] = (double)v->position[i][a];
    s->n[a] = (double)v->normal[i][a];
    d[a] = s->p[a] - f->from[a];
  }
  double depth = dot(d, f->forward), wide = half * v->o.width / v->o.height;
  s->x = v->o.width / 2.0 + dot(d, f->right) / (wide * depth * f->pixel);
  s->y = v->o.height / 2.0 - dot(d, f->up) / (half * depth * f->pixel);
  s->reach = j->radius / (depth * f->pixel);
  double length = sqrt(dot(d, d));
  for (int a = 0; a < 3; a++) s->sight[a] = -d[a] / length;
}

/* The point that pixel (x, y) shows; NONE beside surfaces and outside of the picture. */
static uint32_t shown_at(const job *j, double x, double y) {
  const ylm_shade_options *o = &j->view->o;
  if (!(x >= 0 && y >= 0 && x < o->width && y < o->height)) return NONE;
  return j->shown[(size_t)y * (size_t)o->width + (size_t)x];
}

/* The largest cosine to the line of sight of what stands above the surface along (dx, dy). */
static double horizon(const job *j, const seen *s, double dx, double dy, double shift) {
  double most = -1;
  for (int k = 0; k < STEPS; k++) {
    double t = s->reach * (k + shift) / STEPS;
    uint32_t i = shown_at(j, s->x + t * dx, s->y + t * dy);
    if (i == NONE) continue;
    double d[3];
    for (int a = 0; a < 3; a++) d[a] = (double)j->view->position[i][a] - s->p[a];
    double length = sqrt(dot(d, d));
    if (length > 0 && length < j->radius && dot(d, s->n) > FLAT * length)
      most = fmax(most, dot(d, s->sight) / length);
  }
  return most;
}

/* The integral of the cosine about the normal, at angle g from the line of sight, from there to h. */
static double arc(double h, double g) { return (cos(g) - cos(2 * h - g) + 2 * h * sin(g)) / 4; }

/* Adds what a slice along the picture's (dx, dy) lets through, and what it would without horizons. */
static void slice(const job *j, const seen *s, double dx, double dy, double shift, double sum[2]) {
  const ylm_camera_frame *f = &j->view->frame;
  double along[3], n[3], half = f->pixel / 2 * j->view->o.height;
  double wide = half * j->view->o.width / j->view->o.height;
  for (int a = 0; a < 3; a++) along[a] = dx * f->right[a] / wide - dy * f->up[a] / half;
  double over = dot(along, s->sight), length = 0, up, side;
  for (int a = 0; a < 3; a++) along[a] -= over * s->sight[a];
  length = sqrt(dot(along, along));
  for (int a = 0; a < 3; a++) along[a] /= length;
  up = dot(s->n, s->sight), side = dot(s->n, along);
  for (int a = 0; a < 3; a++) n[a] = up * s->sight[a] + side * along[a];
  double part = sqrt(dot(n, n)), g = atan2(side, up), lo = g - HALF_TURN / 2,
         hi = g + HALF_TURN / 2;
  sum[1] += part * (arc(hi, g) + arc(lo, g));
  double c = horizon(j, s, dx, dy, shift), d = horizon(j, s, -dx, -dy, shift);
  if (c > -1) hi = fmin(hi, acos(fmin(1, c)));
  if (d > -1) lo = fmax(lo, -acos(fmin(1, d)));
  sum[0] += part * (arc(hi, g) + arc(lo, g));
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
    double turn = (PATTERN * x + y + 0.5) / (PATTERN * PATTERN);
    double shift = ylm_scene_radical(PATTERN * ((y + 2 * x) % PATTERN) + x) + 1.0 / 32;
    for (int k = 0; s.reach > 1 && k < SLICES; k++) {
      double angle = HALF_TURN * (k + turn) / SLICES;
      slice(j, &s, cos(angle), sin(angle), shift, sum);
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
      if (tilt < 0.9 || fabs(dot(d, s.n)) > 0.05 * j->radius) continue;
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
