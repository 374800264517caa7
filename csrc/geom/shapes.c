/* shapes.c - procedural meshes. */
#include "ylm_geom.h"

#include <math.h>

#include "ylm_vector.h"

/* Position, unit normal and texture coordinates of a surface at grid vertex (i, j). */
typedef void surface_fn(const void *shape, int i, int j, double p[3], double n[3], double uv[2]);

/* Writes (ni+1) x (nj+1) vertices from vertex `v` on and 2*ni*nj triangles from `t` on; the normal
   points along d/di x d/dj. */
static void fill_patch(ylm_mesh *m, size_t v, size_t t, int ni, int nj, surface_fn *at,
                       const void *shape) {
  size_t k = v;
  for (int j = 0; j <= nj; j++)
    for (int i = 0; i <= ni; i++, k++) {
      double p[3], n[3], uv[2];
      at(shape, i, j, p, n, uv);
      for (int a = 0; a < 3; a++) {
        m->position[3 * k + (size_t)a] = (float)(p[a] - m->origin[a]);
        m->normal[3 * k + (size_t)a] = (float)n[a];
      }
      m->uv[2 * k] = (float)uv[0];
      m->uv[2 * k + 1] = (float)uv[1];
    }
  uint32_t *out = m->index + 3 * t;
  for (int j = 0; j < nj; j++)
    for (int i = 0; i < ni; i++) {
      uint32_t a = (uint32_t)(v + (size_t)j * ((size_t)ni + 1) + (size_t)i);
      uint32_t b = a + 1, d = a + (uint32_t)ni + 1, c = d + 1;
      *out++ = a, *out++ = b, *out++ = c;
      *out++ = a, *out++ = c, *out++ = d;
    }
}

/* A mesh with room for `patches` patches of ni x nj, or an error. */
static ylm_status make(int patches, int ni, int nj, ylm_mesh **m, ylm_error *e) {
  *m = NULL;
  if (ni > 1 << 20 || nj > 1 << 20)
    return ylm_fail(e, YLM_ERANGE, "at most %d divisions along a side", 1 << 20);
  size_t vertices = (size_t)patches * ((size_t)ni + 1) * ((size_t)nj + 1);
  ylm_status s =
      ylm_mesh_create(vertices, (size_t)patches * 2 * (size_t)ni * (size_t)nj, true, true, m, e);
  return s;
}

/* Refuses a mesh whose floats overflowed. */
static ylm_status finish(ylm_mesh **m, ylm_error *e) {
  size_t where;
  if (ylm_all_finite(YLM_FLOAT, (*m)->position, (*m)->vertices * 3, &where) &&
      ylm_all_finite(YLM_FLOAT, (*m)->normal, (*m)->vertices * 3, &where))
    return YLM_OK;
  ylm_mesh_free(*m);
  *m = NULL;
  return ylm_fail(e, YLM_EDOMAIN, "coordinates are not finite");
}

static bool positive(double x) { return x > 0 && x <= 1e30; }

/* -- quad ------------------------------------------------------------------------ */

typedef struct quad {
  const double *corner, *u, *v;
  double normal[3];
  int nu, nv;
} quad;

static void at_quad(const void *shape, int i, int j, double p[3], double n[3], double uv[2]) {
  const quad *q = shape;
  uv[0] = (double)i / q->nu;
  uv[1] = (double)j / q->nv;
  for (int a = 0; a < 3; a++) {
    p[a] = q->corner[a] + uv[0] * q->u[a] + uv[1] * q->v[a];
    n[a] = q->normal[a];
  }
}

/* n = a x b / |a x b|; false if they are parallel or not finite. */
static bool unit_cross(const double a[3], const double b[3], double n[3]) {
  double x[3] = {a[0], a[1], a[2]}, y[3] = {b[0], b[1], b[2]};
  if (!ylm_unit3(x) || !ylm_unit3(y)) return false;
  n[0] = x[1] * y[2] - x[2] * y[1];
  n[1] = x[2] * y[0] - x[0] * y[2];
  n[2] = x[0] * y[1] - x[1] * y[0];
  double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 1e-12)) return false;
  for (int k = 0; k < 3; k++) n[k] /= length;
  return true;
}

ylm_status ylm_mesh_quad(const double corner[3], const double u[3], const double v[3], int nu,
                         int nv, ylm_mesh **m, ylm_error *e) {
  quad q = {.corner = corner, .u = u, .v = v, .nu = nu, .nv = nv};
  *m = NULL;
  if (nu < 1 || nv < 1) return ylm_fail(e, YLM_ERANGE, "divide must be 1 or more");
  if (!unit_cross(u, v, q.normal)) return ylm_fail(e, YLM_EINVAL, "u and v are parallel or zero");
  ylm_status s = make(1, nu, nv, m, e);
  if (s != YLM_OK) return s;
  double box[6];
  for (int a = 0; a < 3; a++) {
    box[a] = corner[a] + fmin(u[a], 0) + fmin(v[a], 0);
    box[a + 3] = corner[a] + fmax(u[a], 0) + fmax(v[a], 0);
  }
  ylm_origin(box, (*m)->origin);
  fill_patch(*m, 0, 0, nu, nv, at_quad, &q);
  return finish(m, e);
}

/* -- sphere ----------------------------------------------------------------------- */

typedef struct sphere {
  double r;
  int around, rings;
} sphere;

static void at_sphere(const void *shape, int i, int j, double p[3], double n[3], double uv[2]) {
  const sphere *s = shape;
  uv[0] = (double)i / s->around;
  uv[1] = (double)j / s->rings; /* from the south pole up: d/di x d/dj points outwards */
  double phi = 2 * YLM_PI * (i == s->around ? 0 : uv[0]), theta = YLM_PI * (1 - uv[1]);
  double rho = j == 0 || j == s->rings ? 0 : sin(theta);
  n[0] = rho * cos(phi);
  n[1] = rho * sin(phi);
  n[2] = j == 0 ? -1 : j == s->rings ? 1 : cos(theta);
  for (int a = 0; a < 3; a++) p[a] = s->r * n[a];
}

/* Drops triangles two corners of which are the same place. */
static void drop_degenerate(ylm_mesh *m) {
  size_t kept = 0;
  for (size_t t = 0; t < m->triangles; t++) {
    const uint32_t *k = m->index + 3 * t;
    bool good = true;
    for (int a = 0; a < 3; a++) {
      const float *p = m->position + 3 * (size_t)k[a],
                  *q = m->position + 3 * (size_t)k[(a + 1) % 3];
      if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) good = false;
    }
    if (!good) continue;
    for (int a = 0; a < 3; a++) m->index[3 * kept + (size_t)a] = k[a];
    kept++;
  }
  m->triangles = kept;
}

ylm_status ylm_mesh_sphere(double r, int around, int rings, ylm_mesh **m, ylm_error *e) {
  sphere shape = {r, around, rings};
  *m = NULL;
  if (!positive(r)) return ylm_fail(e, YLM_ERANGE, "radius must be > 0");
  if (around < 3 || rings < 2) return ylm_fail(e, YLM_ERANGE, "3 segments and 2 rings at least");
  ylm_status s = make(1, around, rings, m, e);
  if (s != YLM_OK) return s;
  fill_patch(*m, 0, 0, around, rings, at_sphere, &shape);
  drop_degenerate(*m);
  return finish(m, e);
}

/* -- box --------------------------------------------------------------------------- */

ylm_status ylm_mesh_box(const double lo[3], const double hi[3], int n, ylm_mesh **m, ylm_error *e) {
  *m = NULL;
  for (int a = 0; a < 3; a++)
    if (!(lo[a] < hi[a]) || !isfinite(lo[a]) || !isfinite(hi[a]))
      return ylm_fail(e, YLM_EINVAL, "its lower corner must be below the upper one in every axis");
  if (n < 1) return ylm_fail(e, YLM_ERANGE, "divide must be 1 or more");
  ylm_status s = make(6, n, n, m, e);
  if (s != YLM_OK) return s;
  ylm_origin((const double[]){lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]}, (*m)->origin);
  for (int face = 0; face < 6; face++) {
    int a = face / 2, b = (a + 1) % 3, c = (a + 2) % 3;
    bool upper = face % 2;
    double corner[3] = {lo[0], lo[1], lo[2]}, u[3] = {0}, v[3] = {0};
    if (upper) corner[a] = hi[a];
    u[upper ? b : c] = upper ? hi[b] - lo[b] : hi[c] - lo[c];
    v[upper ? c : b] = upper ? hi[c] - lo[c] : hi[b] - lo[b];
    quad q = {.corner = corner, .u = u, .v = v, .nu = n, .nv = n};
    q.normal[a] = upper ? 1 : -1;
    size_t per = ((size_t)n + 1) * ((size_t)n + 1), area = 2 * (size_t)n * (size_t)n;
    fill_patch(*m, (size_t)face * per, (size_t)face * area, n, n, at_quad, &q);
  }
  return finish(m, e);
}

/* -- torus and knot ------------------------------------------------------------------- */

typedef struct torus {
  double radius, tube;
  int around, across;
} torus;

static void at_torus(const void *shape, int i, int j, double p[3], double n[3], double uv[2]) {
  const torus *t = shape;
  uv[0] = (double)i / t->around;
  uv[1] = (double)j / t->across;
  double phi = 2 * YLM_PI * (i == t->around ? 0 : uv[0]),
         psi = 2 * YLM_PI * (j == t->across ? 0 : uv[1]);
  n[0] = cos(psi) * cos(phi);
  n[1] = cos(psi) * sin(phi);
  n[2] = sin(psi);
  p[0] = (t->radius + t->tube * cos(psi)) * cos(phi);
  p[1] = (t->radius + t->tube * cos(psi)) * sin(phi);
  p[2] = t->tube * n[2];
}

ylm_status ylm_mesh_torus(double radius, double tube, int around, int across, ylm_mesh **m,
                          ylm_error *e) {
  torus shape = {radius, tube, around, across};
  *m = NULL;
  if (!positive(radius) || !positive(tube))
    return ylm_fail(e, YLM_ERANGE, "radius and tube must be > 0");
  if (around < 3 || across < 3) return ylm_fail(e, YLM_ERANGE, "3 segments each way at least");
  ylm_status s = make(1, around, across, m, e);
  if (s != YLM_OK) return s;
  fill_patch(*m, 0, 0, around, across, at_torus, &shape);
  return finish(m, e);
}

typedef struct knot {
  double radius, minor, tube;
  int p, q, along, across;
} knot;

/* The knot's point at t, unit tangent and unit outward normal of its torus. */
static void knot_frame(const knot *k, double t, double c[3], double tangent[3], double out[3]) {
  double ct = cos(k->p * t), st = sin(k->p * t), cq = cos(k->q * t), sq = sin(k->q * t);
  double r = k->radius + k->minor * cq, dr = -k->minor * k->q * sq;
  c[0] = r * ct, c[1] = r * st, c[2] = k->minor * sq;
  tangent[0] = dr * ct - r * k->p * st;
  tangent[1] = dr * st + r * k->p * ct;
  tangent[2] = k->minor * k->q * cq;
  out[0] = cq * ct, out[1] = cq * st, out[2] = sq; /* already perpendicular to the tangent */
  ylm_unit3(tangent);
}

static void at_knot(const void *shape, int i, int j, double p[3], double n[3], double uv[2]) {
  const knot *k = shape;
  uv[0] = (double)i / k->along;
  uv[1] = (double)j / k->across;
  double c[3], tangent[3], out[3], side[3];
  knot_frame(k, 2 * YLM_PI * (i == k->along ? 0 : uv[0]), c, tangent, out);
  double psi = 2 * YLM_PI * (j == k->across ? 0 : uv[1]);
  side[0] = out[1] * tangent[2] - out[2] * tangent[1];
  side[1] = out[2] * tangent[0] - out[0] * tangent[2];
  side[2] = out[0] * tangent[1] - out[1] * tangent[0];
  /* d/di runs along the tangent, d/dj from `out` to out x tangent: their product points outwards */
  for (int a = 0; a < 3; a++) {
    n[a] = cos(psi) * out[a] + sin(psi) * side[a];
    p[a] = c[a] + k->tube * n[a];
  }
}

static int common_divisor(int a, int b) { return b ? common_divisor(b, a % b) : a; }

ylm_status ylm_mesh_knot(int p, int q, double radius, double minor, double tube, int along,
                         int across, ylm_mesh **m, ylm_error *e) {
  knot shape = {radius, minor, tube, p, q, along, across};
  *m = NULL;
  if (p < 1 || q < 1 || p > 64 || q > 64) return ylm_fail(e, YLM_ERANGE, "p and q must be 1 .. 64");
  if (common_divisor(p, q) != 1)
    return ylm_fail(e, YLM_EINVAL, "p = %d and q = %d have a common divisor", p, q);
  if (!positive(radius) || !positive(minor) || !positive(tube))
    return ylm_fail(e, YLM_ERANGE, "radius, minor and tube must be > 0");
  if (!(minor < radius)) return ylm_fail(e, YLM_ERANGE, "minor must be less than radius");
  if (along < 3 || across < 3) return ylm_fail(e, YLM_ERANGE, "3 segments each way at least");
  ylm_status s = make(1, along, across, m, e);
  if (s != YLM_OK) return s;
  fill_patch(*m, 0, 0, along, across, at_knot, &shape);
  return finish(m, e);
}
