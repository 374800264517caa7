/*
** rgl.c - measured materials of RGL (Dupuy & Jakob 2018), conditioned on the direction to the eye.
**
** Half vectors have a place u_m in the square of azimuth and elevation; visible normals of the eye
** warp it to a place s, where the value is what is left to measure:
**     f wi.z = value(s) ndf(u_m) / (4 sigma(u_o)).
*/
#include "rgl.h"

#include <math.h>

#include "angle.h"
#include "kind.h"

/* -- directions and places -------------------------------------------------- */

/* The angle from the normal, with all its digits near the normal. */
static float elevation(const float d[3]) {
  return ylm__angle(sqrtf(d[0] * d[0] + d[1] * d[1]), d[2]);
}

static float azimuth(const float d[3]) { return ylm__angle(d[1], d[0]); }

static float place_of_theta(float theta) { return sqrtf(theta * (2 / (float)YLM_PI)); }
static float place_of_phi(float phi) { return (phi + (float)YLM_PI) / (2 * (float)YLM_PI); }

/* Into the frame of the tables, and into the part of the azimuths that is measured; back undoes it. */
typedef struct frame {
  float c, s;    /* of the turn */
  float sign[2]; /* of the reflections */
} frame;

static void forth(const frame *f, const float from[3], float to[3]) {
  float x = f->c * from[0] + f->s * from[1], y = f->c * from[1] - f->s * from[0];
  to[0] = f->sign[0] * x;
  to[1] = f->sign[1] * y;
  to[2] = from[2];
}

static void back(const frame *f, const float from[3], float to[3]) {
  float x = f->sign[0] * from[0], y = f->sign[1] * from[1];
  to[0] = f->c * x - f->s * y;
  to[1] = f->c * y + f->s * x;
  to[2] = from[2];
}

static frame frame_of(const rgl_table *t, const float wo[3]) {
  frame f = {t->turn[0], t->turn[1], {1, 1}};
  if (t->reduction == 1) return f;
  float o[3];
  forth(&f, wo, o);
  float x = o[0] * t->middle[0], y = o[1] * t->middle[1];
  if (t->reduction == 2) {
    f.sign[0] = f.sign[1] = x + y < 0 ? -1 : 1;
  } else {
    f.sign[0] = x < 0 ? -1 : 1;
    f.sign[1] = y < 0 ? -1 : 1;
  }
  return f;
}

/* The nodes around x, and the share of the second. */
static int nodes(const float *at, int n, float x, float *share) {
  int i = 0;
  while (i < n - 2 && at[i + 1] <= x) i++;
  float t = n > 1 ? (x - at[i]) / (at[i + 1] - at[i]) : 0;
  *share = t < 0 ? 0 : t > 1 ? 1 : t;
  return i;
}

/* The slices around a direction. */
static blend slices_of(const rgl_table *t, float phi, float theta) {
  float a, b;
  size_t i = (size_t)nodes(t->phi, t->phis, phi, &a);
  size_t j = (size_t)nodes(t->theta, t->thetas, theta, &b);
  size_t at = i * (size_t)t->thetas + j, above = t->thetas > 1, round = (size_t)t->thetas;
  if (t->phis == 1) return (blend){2, {at, at + above}, {1 - b, b}};
  return (blend){4,
                 {at, at + above, at + round, at + round + above},
                 {(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b}};
}

/* The eye, as the tables know it. */
typedef struct eye {
  frame frame;
  float o[3], phi;
  blend slices;
  float sigma;
} eye;

static eye eye_of(const rgl_table *t, const float wo[3]) {
  eye v = {.frame = frame_of(t, wo)};
  forth(&v.frame, wo, v.o);
  float theta = elevation(v.o);
  v.phi = azimuth(v.o);
  v.slices = slices_of(t, v.phi, theta);
  float u[2] = {place_of_theta(theta), place_of_phi(v.phi)};
  v.sigma = t->jacobian ? ylm__raster_at(&t->sigma, u) : 1;
  return v;
}

/* -- what the tables say ---------------------------------------------------- */

/* f wi.z where the half vector's place is u, which visible normals warp to s. */
static void value_at(const rgl_table *t, const eye *v, const float u[2], const float s[2],
                     float out[3]) {
  float scale = 1;
  if (t->jacobian) scale = v->sigma > 0 ? ylm__raster_at(&t->ndf, u) / (4 * v->sigma) : 0;
  ylm__colours_at(t->luminance.width, t->luminance.height, t->colour, &v->slices, s, out);
  for (int c = 0; c < 3; c++) out[c] = out[c] > 0 && scale > 0 ? out[c] * scale : 0;
}

/* The density of directions, per density of places of half vectors; cosine: of eye and half vector. */
static float per_direction(float cosine, float u, float sine) {
  float area = 2 * (float)YLM_PI * (float)YLM_PI * u * sine;
  return 1 / (4 * cosine * (area > 1e-6f ? area : 1e-6f));
}

/* A pair of directions above the surface: the place of its half vector, the place that it is warped
   to and its density there, and per_direction. */
typedef struct pair {
  float u[2], s[2], density, jacobian;
} pair;

static pair pair_of(const rgl_table *t, const eye *v, const float wi[3]) {
  float i[3], m[3];
  forth(&v->frame, wi, i);
  for (int a = 0; a < 3; a++) m[a] = i[a] + v->o[a];
  float length = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
  for (int a = 0; a < 3; a++) m[a] /= length;
  float phi = azimuth(m) - (t->isotropic ? v->phi : 0);
  pair p = {.u = {place_of_theta(elevation(m)), place_of_phi(phi)}};
  p.u[1] -= floorf(p.u[1]);
  p.density = ylm__warp_invert(&t->vndf, &v->slices, p.u, p.s);
  p.jacobian = per_direction(length / 2, p.u[0], sqrtf(m[0] * m[0] + m[1] * m[1]));
  return p;
}

static void eval(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                 float (*f)[3]) {
  const rgl_table *t = m->table;
  for (size_t k = 0; k < n; k++) {
    f[k][0] = f[k][1] = f[k][2] = 0;
    if (!(wi[k][2] > 0 && wo[k][2] > 0)) continue;
    eye v = eye_of(t, wo[k]);
    pair p = pair_of(t, &v, wi[k]);
    value_at(t, &v, p.u, p.s, f[k]);
    for (int c = 0; c < 3; c++) f[k][c] /= wi[k][2];
  }
}

static void pdf(const ylm_material *m, size_t n, const float (*wi)[3], const float (*wo)[3],
                float *out) {
  const rgl_table *t = m->table;
  for (size_t k = 0; k < n; k++) {
    out[k] = 0;
    if (!(wi[k][2] > 0 && wo[k][2] > 0)) continue;
    eye v = eye_of(t, wo[k]);
    pair p = pair_of(t, &v, wi[k]);
    out[k] = p.density * ylm__warp_density(&t->luminance, &v.slices, p.s) * p.jacobian;
  }
}

/* The half vector of a place, and per_direction. */
static float half_vector(const rgl_table *t, const eye *v, const float u[2], float m[3]) {
  float theta = u[0] * u[0] * ((float)YLM_PI / 2),
        phi = (2 * u[1] - 1) * (float)YLM_PI + (t->isotropic ? v->phi : 0);
  float sine = sinf(theta);
  m[0] = sine * cosf(phi);
  m[1] = sine * sinf(phi);
  m[2] = cosf(theta);
  return per_direction(m[0] * v->o[0] + m[1] * v->o[1] + m[2] * v->o[2], u[0], sine);
}

/* Directions for n <= WARP_BLOCK eyes above the surface. */
static void sample_block(const rgl_table *t, size_t n, const float (*wo)[3], const float (*u)[3],
                         float (*wi)[3], float (*weight)[3], float *pdf) {
  eye v[WARP_BLOCK];
  blend slices[WARP_BLOCK];
  float start[WARP_BLOCK][2], s[WARP_BLOCK][2], um[WARP_BLOCK][2], of_s[WARP_BLOCK],
      of_u[WARP_BLOCK];
  if (n == 0) return;
  for (size_t k = 0; k < n; k++) {
    v[k] = eye_of(t, wo[k]);
    slices[k] = v[k].slices;
    start[k][0] = u[k][0];
    start[k][1] = u[k][1];
  }
  ylm__warp_sample(&t->luminance, n, slices, (const float(*)[2])start, s, of_s);
  ylm__warp_sample(&t->vndf, n, slices, (const float(*)[2])s, um, of_u);
  for (size_t k = 0; k < n; k++) {
    float h[3], i[3], density = of_s[k] * of_u[k] * half_vector(t, v + k, um[k], h);
    float cosine = h[0] * v[k].o[0] + h[1] * v[k].o[1] + h[2] * v[k].o[2];
    for (int a = 0; a < 3; a++) i[a] = 2 * cosine * h[a] - v[k].o[a];
    back(&v[k].frame, i, wi[k]);
    bool good = wo[k][2] > 0 && cosine > 0 && i[2] > 0 && density > 0;
    pdf[k] = good ? density : 0;
    value_at(t, v + k, um[k], s[k], weight[k]);
    for (int c = 0; c < 3; c++) weight[k][c] = good ? weight[k][c] / density : 0;
  }
}

static void sample(const ylm_material *m, size_t n, const float (*wo)[3], const float (*u)[3],
                   float (*wi)[3], float (*weight)[3], float *pdf) {
  for (size_t k = 0; k < n; k += WARP_BLOCK)
    sample_block(m->table, n - k < WARP_BLOCK ? n - k : WARP_BLOCK, wo + k, u + k, wi + k,
                 weight + k, pdf + k);
}

/* -- the kind --------------------------------------------------------------- */

static ylm_status check(const float *x, ylm_error *e) {
  if (!isfinite(x[0]))
    return ylm_fail(e, YLM_EDOMAIN, "rotate must be finite, got %g", (double)x[0]);
  return YLM_OK;
}

static ylm_status load(ylm_material *m, const unsigned char *bytes, size_t size, const char *name,
                       ylm_error *e) {
  rgl_table *t;
  ylm_status s = ylm__rgl_read(bytes, size, name, m->x[0], &t, &m->bytes, e);
  if (s == YLM_OK) m->table = t;
  return s;
}

static void facts(const ylm_material *m, ylm_material_fact *fact, void *to) {
  const rgl_table *t = m->table;
  fact(to, "phi_i", t->phis);
  fact(to, "theta_i", t->thetas);
  fact(to, "reduction", t->reduction);
  fact(to, "columns", t->luminance.width);
  fact(to, "rows", t->luminance.height);
}

static bool isotropic(const ylm_material *m) {
  const rgl_table *t = m->table;
  return t->isotropic;
}

const material_kind ylm__material_rgl = {.name = "rgl",
                                         .numbers = 1,
                                         .check = check,
                                         .load = load,
                                         .facts = facts,
                                         .isotropic = isotropic,
                                         .eval = eval,
                                         .sample = sample,
                                         .pdf = pdf};
