/* gather_vsl.c - a virtual light as a sphere: directions to it, of its cone and of two cosines. */
#include <math.h>

#include "gather.h"

#define PI 3.14159265358979323846

/* Of smaller cones, in parts of the hemisphere, the other ways find next to nothing. */
#define SMALL 0.03

/* A light as it is seen from a point. */
typedef struct sphere {
  double w[3], N[3], n[3], shift; /* direction to it; normals of receiver and light */
  double edge, cone;              /* the cosine of its half angle; the solid angle, sr */
  bool turned;                    /* it has a normal */
} sphere;

static inline double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The weight of light from w' in the cone: both cosines. */
static double value(const sphere *s, const double d[3]) {
  return fmax(0, dot(s->N, d)) * fmax(0, s->shift - dot(s->n, d));
}

enum { CONE, RECEIVER, LIGHT, WAYS };

/* The sum of the densities of all ways to choose a direction in the cone. */
static double densities(const sphere *s, const double d[3]) {
  double light = s->turned ? fmax(0, -dot(s->n, d)) : 0;
  return 1 / s->cone + (fmax(0, dot(s->N, d)) + light) / PI;
}

/* The mean over n directions of one way; with `mis` weighed against all ways. */
static double mean(const sphere *s, int way, int n, bool mis, double u0, double v0) {
  const double *axis = way == CONE ? s->w : way == RECEIVER ? s->N : s->n;
  float c[3] = {(float)axis[0], (float)axis[1], (float)axis[2]}, a[3], b[3];
  double sum = 0, sign = way == LIGHT ? -1 : 1;
  ylm_scene_basis(c, a, b);
  for (int i = 0; i < n; i++) {
    double u = u0 + (i + 0.5) / n, v = v0 + i * 0.61803398874989485, d[3], p;
    u -= (double)(int)u;
    double z = way == CONE ? 1 - u * (1 - s->edge) : sqrt(1 - u);
    float r = sqrtf(fmaxf(0, (float)(1 - z * z))), t = 2 * (float)PI * (float)(v - (double)(int)v);
    float x = r * cosf(t), y = r * sinf(t);
    for (int k = 0; k < 3; k++) d[k] = sign * ((double)(x * a[k] + y * b[k]) + z * axis[k]);
    if (way != CONE && dot(s->w, d) < s->edge) continue;
    double f = value(s, d);
    if (!(f > 0)) continue;
    p = mis ? densities(s, d) : way == CONE ? 1 / s->cone : dot(s->N, d) / PI;
    sum += f / p;
  }
  return sum / n;
}

double ylm__gather_sphere(const gather_lights *l, const gather_ask *a, size_t i, const float x[3],
                          const float N[3], ylm_rng *rng) {
  const ylm_shade_gather_options *o = a->o;
  sphere s = {.shift = (double)l->shift[i]};
  double r = (double)l->radius[i], u0 = ylm_rng_double(rng), v0 = ylm_rng_double(rng);
  for (int k = 0; k < 3; k++) {
    s.w[k] = (double)l->at[k][i] - (double)x[k];
    s.N[k] = (double)N[k];
    s.n[k] = (double)l->normal[k][i];
    s.turned = s.turned || s.n[k] != 0;
  }
  double d2 = dot(s.w, s.w), d = sqrt(d2);
  if (!(d > 0)) return 0;
  for (int k = 0; k < 3; k++) s.w[k] /= d;
  double sine2 = d > r ? r * r / d2 : 1, part = sine2 / (1 + sqrt(1 - sine2));
  s.edge = 1 - part;
  s.cone = 2 * PI * part;
  /* nothing of the cone is above the receiver */
  if (d > r && dot(s.w, s.N) < -r / d) return 0;
  int n = (int)fmax(4, ceil(o->samples * part));
  double sum;
  switch (o->strategy == YLM_SHADE_MIS && part < SMALL ? YLM_SHADE_CONE : o->strategy) {
  case YLM_SHADE_CONE: sum = mean(&s, CONE, n, false, u0, v0); break;
  case YLM_SHADE_RECEIVER: sum = mean(&s, RECEIVER, o->samples, false, u0, v0); break;
  default:
    sum = mean(&s, CONE, n, true, u0, v0) + mean(&s, RECEIVER, n, true, v0, u0);
    if (s.turned) sum += mean(&s, LIGHT, n, true, u0, 1 - v0);
  }
  return sum / (PI * r * r);
}
