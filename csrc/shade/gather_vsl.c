/* gather_vsl.c - a virtual light as a sphere: directions to it, of its cone and of two cosines. */
#include <math.h>

#include "gather_gloss.h"

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

/* Light i as it is seen from x, normal N; the part of the hemisphere that it fills, 0: nothing of it is above the
   receiver. *n: directions. */
static double see(const gather_lights *l, const ylm_shade_gather_options *o, size_t i,
                  const float x[3], const float N[3], sphere *s, int *n) {
  double r = (double)l->radius[i];
  *s = (sphere){.shift = (double)l->shift[i]};
  for (int k = 0; k < 3; k++) {
    s->w[k] = (double)l->at[k][i] - (double)x[k];
    s->N[k] = (double)N[k];
    s->n[k] = (double)l->normal[k][i];
    s->turned = s->turned || s->n[k] != 0;
  }
  double d2 = dot(s->w, s->w), d = sqrt(d2);
  if (!(d > 0)) return 0;
  for (int k = 0; k < 3; k++) s->w[k] /= d;
  double sine2 = d > r ? r * r / d2 : 1, part = sine2 / (1 + sqrt(1 - sine2));
  s->edge = 1 - part;
  s->cone = 2 * PI * part;
  *n = (int)fmax(4, ceil(o->samples * part));
  return d > r && dot(s->w, s->N) < -r / d ? 0 : part;
}

double ylm__gather_sphere(const gather_lights *l, const gather_ask *a, size_t i, const float x[3],
                          const float N[3], ylm_rng *rng) {
  const ylm_shade_gather_options *o = a->o;
  sphere s;
  int n;
  double r = (double)l->radius[i], u0 = ylm_rng_double(rng), v0 = ylm_rng_double(rng), sum;
  double part = see(l, o, i, x, N, &s, &n);
  if (!(part > 0)) return 0;
  switch (o->strategy == YLM_SHADE_MIS && part < SMALL ? YLM_SHADE_CONE : o->strategy) {
  case YLM_SHADE_CONE: sum = mean(&s, CONE, n, false, u0, v0); break;
  case YLM_SHADE_RECEIVER: sum = mean(&s, RECEIVER, o->samples, false, u0, v0); break;
  default:
    sum = mean(&s, CONE, n, true, u0, v0) + mean(&s, RECEIVER, n, true, v0, u0);
    if (s.turned) sum += mean(&s, LIGHT, n, true, u0, 1 - v0);
  }
  return sum / (PI * r * r);
}

/* -- receivers that gloss ---------------------------------------------------------- */

/* n <= GATHER_CHUNK directions of one way; their number in the cone. */
static size_t choose(const sphere *s, const gather_receiver *r, int way, int n, double u0,
                     double v0, double w0, float (*to)[3]) {
  const double *axis = way == CONE ? s->w : s->n;
  float c[3] = {(float)axis[0], (float)axis[1], (float)axis[2]}, a[3], b[3];
  size_t found = 0;
  double sign = way == LIGHT ? -1 : 1;
  ylm_scene_basis(c, a, b);
  for (int i = 0; i < n; i++) {
    double u = u0 + (i + 0.5) / n, v = v0 + i * 0.61803398874989485;
    float d[3];
    u -= (double)(int)u;
    v -= (double)(int)v;
    if (way == RECEIVER) {
      double t = w0 + i * 0.41421356237309505;
      float by[1][3] = {{fminf((float)u, 0x1.fffffep-1f), fminf((float)v, 0x1.fffffep-1f),
                         fminf((float)(t - (double)(int)t), 0x1.fffffep-1f)}},
            wi[1][3], weight[1][3], pdf;
      ylm_material_sample(r->material, 1, (const float(*)[3])r->wo, (const float(*)[3])by, wi,
                          weight, &pdf);
      if (!(pdf > 0)) continue;
      float x = r->turn[0] * wi[0][0] + r->turn[1] * wi[0][1],
            y = -r->turn[1] * wi[0][0] + r->turn[0] * wi[0][1];
      for (int k = 0; k < 3; k++)
        d[k] = x * r->axis[0][k] + y * r->axis[1][k] + wi[0][2] * r->axis[2][k];
    } else {
      double z = way == CONE ? 1 - u * (1 - s->edge) : sqrt(1 - u);
      float q = sqrtf(fmaxf(0, (float)(1 - z * z))), t = 2 * (float)PI * (float)v;
      float x = q * cosf(t), y = q * sinf(t);
      for (int k = 0; k < 3; k++)
        d[k] = (float)(sign * ((double)(x * a[k] + y * b[k]) + z * axis[k]));
    }
    double wide[3] = {(double)d[0], (double)d[1], (double)d[2]};
    if (way != CONE && dot(s->w, wide) < s->edge) continue;
    if (!(value(s, wide) > 0)) continue;
    for (int k = 0; k < 3; k++) to[found][k] = d[k];
    found++;
  }
  return found;
}

/* Adds the mean over n directions of one way to sum [3]. */
static void add_way(const sphere *s, const gather_receiver *r, int way, int n, bool mis,
                    const double u[3], double sum[3]) {
  float to[GATHER_CHUNK][3], f[GATHER_CHUNK][3];
  for (int begin = 0; begin < n; begin += GATHER_CHUNK) {
    int part = n - begin < GATHER_CHUNK ? n - begin : GATHER_CHUNK;
    double at[3] = {u[0] + begin * 0.75487766624669276, u[1] + begin * 0.61803398874989485,
                    u[2] + begin * 0.41421356237309505};
    for (int k = 0; k < 3; k++) at[k] -= floor(at[k]);
    size_t found = choose(s, r, way, part, at[0], at[1], at[2], to);
    ylm__gather_eval(r, found, (const float(*)[3])to, f);
    for (size_t i = 0; i < found; i++) {
      double d[3] = {(double)to[i][0], (double)to[i][1], (double)to[i][2]}, p = 1 / s->cone;
      float pdf = 0, wi[1][3];
      if (way != CONE || mis) {
        float x = ylm_dot3(to[i], r->axis[0]), y = ylm_dot3(to[i], r->axis[1]);
        wi[0][0] = r->turn[0] * x - r->turn[1] * y, wi[0][1] = r->turn[1] * x + r->turn[0] * y;
        wi[0][2] = ylm_dot3(to[i], r->axis[2]);
        ylm_material_pdf(r->material, 1, (const float(*)[3])wi, (const float(*)[3])r->wo, &pdf);
      }
      if (mis)
        p += (double)pdf + (s->turned ? fmax(0, -dot(s->n, d)) / PI : 0);
      else if (way == RECEIVER)
        p = (double)pdf;
      if (!(p > 0)) continue;
      double each = value(s, d) / p / n;
      for (int c = 0; c < 3; c++) sum[c] += each * (double)f[i][c];
    }
  }
}

void ylm__gather_sphere_gloss(const gather_lights *l, const gather_ask *a, const gather_receiver *r,
                              size_t i, const float x[3], ylm_rng *rng, double out[3]) {
  const ylm_shade_gather_options *o = a->o;
  const double u[3] = {ylm_rng_double(rng), ylm_rng_double(rng), ylm_rng_double(rng)};
  const double other[3] = {u[1], u[0], u[2]}, third[3] = {u[0], 1 - u[1], u[2]};
  sphere s;
  int n;
  for (int c = 0; c < 3; c++) out[c] = 0;
  double part = see(l, o, i, x, r->axis[2], &s, &n), R = (double)l->radius[i];
  if (!(part > 0)) return;
  switch (o->strategy) {
  case YLM_SHADE_CONE: add_way(&s, r, CONE, n, false, u, out); break;
  case YLM_SHADE_RECEIVER: add_way(&s, r, RECEIVER, o->samples, false, u, out); break;
  default:
    add_way(&s, r, CONE, n, true, u, out);
    add_way(&s, r, RECEIVER, n, true, other, out);
    if (s.turned) add_way(&s, r, LIGHT, n, true, third, out);
  }
  for (int c = 0; c < 3; c++) out[c] /= PI * R * R;
}
