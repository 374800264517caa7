/* vsl.c - a virtual light as a sphere: directions to it, of its cone and of two cosines. */
#include <math.h>
#include <string.h>

#include "many.h"
#include "ylm_vector.h"

/* A light as it is seen from a point. */
typedef struct sphere {
  double w[3], N[3], n[3], shift; /* direction to it; normals of receiver and light */
  double edge, cone;              /* the cosine of its half angle; the solid angle, sr */
  bool turned;                    /* it has a normal */
} sphere;

/* The weight of light from w' in the cone: both cosines. */
static double value(const sphere *s, const double d[3]) {
  return fmax(0, ylm_dot3d(s->N, d)) * fmax(0, s->shift - ylm_dot3d(s->n, d));
}

/* The sum of the densities of all ways to choose a direction in the cone. */
static double densities(const sphere *s, const double d[3]) {
  double light = s->turned ? fmax(0, -ylm_dot3d(s->n, d)) : 0;
  return 1 / s->cone + (fmax(0, ylm_dot3d(s->N, d)) + light) / YLM_PI;
}

/* The sum over n directions of one way; with `mis` weighed against all ways. */
static double sum_of(const ylm_many_host *host, const sphere *s, int way, int n, bool mis,
                     double u0, double v0) {
  const double *axis = way == VSL_CONE ? s->w : way == VSL_RECEIVER ? s->N : s->n;
  float c[3] = {(float)axis[0], (float)axis[1], (float)axis[2]}, a[3], b[3];
  double sum = 0, sign = way == VSL_LIGHT ? -1 : 1;
  host->basis(c, a, b);
  for (int i = 0; i < n; i++) {
    double u = u0 + (i + 0.5) / n, v = v0 + i * 0.61803398874989485, d[3], p;
    u -= (double)(int)u;
    double z = way == VSL_CONE ? 1 - u * (1 - s->edge) : sqrt(1 - u);
    double r = sqrt(fmax(0, 1 - z * z)), t = 2 * YLM_PI * (v - floor(v)), x = r * cos(t),
           y = r * sin(t);
    for (int k = 0; k < 3; k++) d[k] = sign * (x * (double)a[k] + y * (double)b[k] + z * axis[k]);
    if (way != VSL_CONE && ylm_dot3d(s->w, d) < s->edge) continue;
    double f = value(s, d);
    if (!(f > 0)) continue;
    p = mis ? densities(s, d) : way == VSL_CONE ? 1 / s->cone : ylm_dot3d(s->N, d) / YLM_PI;
    sum += f / p;
  }
  return sum;
}

/* Light i as it is seen from x, normal N; the part of the hemisphere that it fills, 0: nothing of it is above the
   receiver. *n: directions. */
static double see(const ylm_many_lights *l, const ylm_shade_gather_options *o, size_t i,
                  const float x[3], const float N[3], sphere *s, int *n) {
  double r = (double)l->radius[i];
  *s = (sphere){.shift = (double)l->shift[i]};
  for (int k = 0; k < 3; k++) {
    s->w[k] = (double)l->at[k][i] - (double)x[k];
    s->N[k] = (double)N[k];
    s->n[k] = (double)l->normal[k][i];
    s->turned = s->turned || s->n[k] != 0;
  }
  double d2 = ylm_dot3d(s->w, s->w), d = sqrt(d2);
  if (!(d > 0)) return 0;
  for (int k = 0; k < 3; k++) s->w[k] /= d;
  double sine2 = d > r ? r * r / d2 : 1, part = sine2 / (1 + sqrt(1 - sine2));
  s->edge = 1 - part;
  s->cone = 2 * YLM_PI * part;
  *n = o->strategy == YLM_SHADE_RECEIVER ? o->samples : (int)fmax(4, ceil(o->samples * part));
  return d > r && ylm_dot3d(s->w, s->N) < -r / d ? 0 : part;
}

static double number(uint32_t seed, uint32_t step, size_t i) {
  return (double)((seed + (uint32_t)i * step) >> 9) * 0x1p-23;
}

void ylm__many_spheres(const ylm_many_lights *l, const ylm_many_ask *a, size_t first, size_t n,
                       const float x[3], const float N[3], const uint32_t seed[2],
                       const float *keep, float *w) {
  const ylm_shade_gather_options *o = a->o;
  for (size_t k = 0; k < n; k++) {
    size_t i = first + k;
    sphere s;
    int m;
    w[k] = 0;
    if (i >= l->n || (keep && !(keep[k] > 0))) continue;
    double part = see(l, o, i, x, N, &s, &m), sum;
    if (!(part > 0)) continue;
    double r = (double)l->radius[i], u = number(seed[0], VSL_STEP_U, i),
           v = number(seed[1], VSL_STEP_V, i);
    if (o->strategy == YLM_SHADE_RECEIVER)
      sum = sum_of(a->host, &s, VSL_RECEIVER, m, false, u, v);
    else if (o->strategy == YLM_SHADE_CONE || part < (double)VSL_SMALL)
      sum = sum_of(a->host, &s, VSL_CONE, m, false, u, v);
    else {
      sum = sum_of(a->host, &s, VSL_CONE, m, true, u, v) +
            sum_of(a->host, &s, VSL_RECEIVER, m, true, v, u);
      if (s.turned) sum += sum_of(a->host, &s, VSL_LIGHT, m, true, u, 1 - v);
    }
    w[k] = (float)(sum / (m * YLM_PI * r * r)) * (keep ? keep[k] : 1);
  }
}

/* -- receivers that gloss ---------------------------------------------------------- */

/* Directions that wait for f: of light k of a chunk, of the surface's frame, with both cosines over the number of directions,
   and the density without the material's. */
typedef struct waiting {
  const ylm_many_host *host;
  const ylm_many_receiver *r;
  float (*w)[YLM_MANY_CHUNK];
  size_t n;
  uint16_t of[YLM_MANY_CHUNK];
  bool by_material[YLM_MANY_CHUNK];
  float to[YLM_MANY_CHUNK][3], value[YLM_MANY_CHUNK], density[YLM_MANY_CHUNK];
} waiting;

/* Adds what waits to the weights. */
static void flush(waiting *x) {
  const ylm_many_receiver *r = x->r;
  float wo[YLM_MANY_CHUNK][3], f[YLM_MANY_CHUNK][3], pdf[YLM_MANY_CHUNK];
  for (size_t i = 0; i < x->n; i++) memcpy(wo[i], r->wo, sizeof wo[i]);
  ylm_material_eval(r->material, x->n, (const float(*)[3])x->to, (const float(*)[3])wo, f);
  ylm_material_pdf(r->material, x->n, (const float(*)[3])x->to, (const float(*)[3])wo, pdf);
  for (size_t i = 0; i < x->n; i++) {
    float p = x->density[i] + (x->by_material[i] ? pdf[i] : 0);
    if (!(p > 0)) continue;
    for (int c = 0; c < 3; c++) x->w[c][x->of[i]] += x->value[i] * f[i][c] / p;
  }
  x->n = 0;
}

/* A direction of the world, or of the surface's frame, in the other. */
static void to_surface(const ylm_many_receiver *r, const float d[3], float out[3]) {
  float x = ylm_dot3(d, r->axis[0]), y = ylm_dot3(d, r->axis[1]);
  out[0] = r->turn[0] * x - r->turn[1] * y;
  out[1] = r->turn[1] * x + r->turn[0] * y;
  out[2] = ylm_dot3(d, r->axis[2]);
}
static void to_world(const ylm_many_receiver *r, const float wi[3], float out[3]) {
  float x = r->turn[0] * wi[0] + r->turn[1] * wi[1], y = -r->turn[1] * wi[0] + r->turn[0] * wi[1];
  for (int k = 0; k < 3; k++)
    out[k] = x * r->axis[0][k] + y * r->axis[1][k] + wi[2] * r->axis[2][k];
}

/* Direction i of n of a way, in the world; false: there is none. */
static bool choose(const sphere *s, const ylm_many_receiver *r, int way, int i, int n, double u0,
                   double v0, const float a[3], const float b[3], float d[3]) {
  const double *axis = way == VSL_CONE ? s->w : s->n, sign = way == VSL_LIGHT ? -1 : 1;
  double u = u0 + (i + 0.5) / n, v = v0 + i * 0.61803398874989485;
  u -= (double)(int)u;
  v -= floor(v);
  if (way == VSL_RECEIVER) {
    double third = u0 + v0 + i * 0.41421356237309505;
    float wi[1][3], weight[1][3], pdf,
        by[1][3] = {{fminf((float)u, 0x1.fffffep-1f), fminf((float)v, 0x1.fffffep-1f),
                     fminf((float)(third - floor(third)), 0x1.fffffep-1f)}};
    ylm_material_sample(r->material, 1, (const float(*)[3])r->wo, (const float(*)[3])by, wi, weight,
                        &pdf);
    to_world(r, wi[0], d);
    return pdf > 0;
  }
  double z = way == VSL_CONE ? 1 - u * (1 - s->edge) : sqrt(1 - u);
  float q = sqrtf(fmaxf(0, (float)(1 - z * z))), t = 2 * (float)YLM_PI * (float)v;
  float x = q * cosf(t), y = q * sinf(t);
  for (int k = 0; k < 3; k++) d[k] = (float)(sign * ((double)(x * a[k] + y * b[k]) + z * axis[k]));
  return true;
}

/* Lets n directions of one way wait. */
static void add_way(waiting *x, const sphere *s, size_t light, int way, int n, bool mis, double u,
                    double v) {
  const double *axis = way == VSL_CONE ? s->w : s->n;
  float c[3] = {(float)axis[0], (float)axis[1], (float)axis[2]}, a[3], b[3], d[3];
  x->host->basis(c, a, b);
  for (int i = 0; i < n; i++) {
    if (!choose(s, x->r, way, i, n, u, v, a, b, d)) continue;
    double wide[3] = {(double)d[0], (double)d[1], (double)d[2]};
    if (way != VSL_CONE && ylm_dot3d(s->w, wide) < s->edge) continue;
    double f = value(s, wide), light_pdf = s->turned ? fmax(0, -ylm_dot3d(s->n, wide)) / YLM_PI : 0;
    if (!(f > 0)) continue;
    x->of[x->n] = (uint16_t)light;
    x->value[x->n] = (float)(f / n);
    x->by_material[x->n] = mis || way == VSL_RECEIVER;
    x->density[x->n] = mis               ? (float)(1 / s->cone + light_pdf)
                       : way == VSL_CONE ? (float)(1 / s->cone)
                                         : 0;
    to_surface(x->r, d, x->to[x->n]);
    if (++x->n == YLM_MANY_CHUNK) flush(x);
  }
}

void ylm__many_spheres_gloss(const ylm_many_lights *l, const ylm_many_ask *a,
                             const ylm_many_receiver *r, size_t first, size_t n, const float x[3],
                             const uint32_t seed[2], const float *keep,
                             float (*w)[YLM_MANY_CHUNK]) {
  const ylm_shade_gather_options *o = a->o;
  waiting wait;
  wait.host = a->host, wait.r = r, wait.w = w, wait.n = 0;
  memset(w, 0, 3 * sizeof *w);
  for (size_t k = 0; k < n && first + k < l->n; k++) {
    size_t i = first + k;
    sphere s;
    int m;
    if (keep && !(keep[k] > 0)) continue;
    if (!(see(l, o, i, x, r->axis[2], &s, &m) > 0)) continue;
    double u = number(seed[0], VSL_STEP_U, i), v = number(seed[1], VSL_STEP_V, i);
    bool mis = o->strategy == YLM_SHADE_MIS;
    if (o->strategy == YLM_SHADE_RECEIVER)
      add_way(&wait, &s, k, VSL_RECEIVER, m, false, u, v);
    else
      add_way(&wait, &s, k, VSL_CONE, m, mis, u, v);
    if (!mis) continue;
    add_way(&wait, &s, k, VSL_RECEIVER, m, true, v, u);
    if (s.turned) add_way(&wait, &s, k, VSL_LIGHT, m, true, u, 1 - v);
  }
  flush(&wait);
  for (size_t k = 0; k < n && first + k < l->n; k++) {
    float R = l->radius[first + k], by = (keep ? keep[k] : 1) / ((float)YLM_PI * R * R);
    for (int c = 0; c < 3; c++) w[c][k] *= by;
  }
}
