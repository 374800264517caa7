/* eval.c - the intensity of a table in a direction, with derivatives. */
#include "table.h"

#include <math.h>

typedef ylm__photometric_value value;

/* Hermite's cubic: weights of both values and slopes, and of their derivatives by x. */
typedef struct weights {
  double v[4], d[4], dd[4]; /* f0, f1, m0, m1 */
} weights;

static weights weights_at(double t, double h) {
  double u = 1 - t;
  weights w = {{u * u * (1 + 2 * t), t * t * (3 - 2 * t), t * u * u * h, -t * t * u * h},
               {-6 * t * u / h, 6 * t * u / h, u * (1 - 3 * t), t * (3 * t - 2)},
               {(12 * t - 6) / (h * h), (6 - 12 * t) / (h * h), (6 * t - 4) / h, (6 * t - 2) / h}};
  return w;
}

void ylm__photometric_weights(double t, double h, double w[4]) {
  weights all = weights_at(t, h);
  for (int i = 0; i < 4; i++) w[i] = all.v[i];
}

static double sum(const double w[4], const double x[4]) {
  return w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3];
}

/* Straight lines in place of cubics. */
static weights lines_at(double t, double h) {
  return (weights){{1 - t, t, 0, 0}, {-1 / h, 1 / h, 0, 0}, {0, 0, 0, 0}};
}

/* Interpolation along the planes k and l, then between them; l = k: there is one. */
static value between(const ylm_light_photometry *p, size_t j, size_t k, size_t l, const weights *g,
                     const weights *c) {
  const ylm__photometric_node *a = p->node + k * p->angles + j, *b = p->node + l * p->angles + j;
  double f[2][4] = {{a[0].f, a[1].f, a[0].g, a[1].g}, {b[0].f, b[1].f, b[0].g, b[1].g}};
  if (k == l) return (value){sum(g->v, f[0]), sum(g->d, f[0]), 0, sum(g->dd, f[0]), 0, 0};
  double s[2][4] = {{a[0].c, a[1].c, a[0].gc, a[1].gc}, {b[0].c, b[1].c, b[0].gc, b[1].gc}};
  double v[4], d[4], dd[4];
  for (int i = 0; i < 2; i++) {
    v[i] = sum(g->v, f[i]), v[2 + i] = sum(g->v, s[i]);
    d[i] = sum(g->d, f[i]), d[2 + i] = sum(g->d, s[i]);
    dd[i] = sum(g->dd, f[i]), dd[2 + i] = sum(g->dd, s[i]);
  }
  return (value){sum(c->v, v),  sum(c->v, d), sum(c->d, v),
                 sum(c->v, dd), sum(c->d, d), sum(c->dd, v)};
}

/* The spline; gamma is within the table. */
static value spline(const ylm_light_photometry *p, double gamma, double c) {
  size_t j = ylm__photometric_place(p->angles - 1, p->angle, gamma), k = 0, l = 0;
  double h = p->angle[j + 1] - p->angle[j], t = (gamma - p->angle[j]) / h;
  weights g = p->grid.linear ? lines_at(t, h) : weights_at(t, h), around = g;
  if (p->planes > 1) {
    k = ylm__photometric_place(p->planes, p->plane, c);
    l = k + 1 < p->planes ? k + 1 : 0;
    double wide = p->plane[k + 1] - p->plane[k], s = (c - p->plane[k]) / wide;
    around = p->grid.linear ? lines_at(s, wide) : weights_at(s, wide);
  }
  return between(p, j, k, l, &g, &around);
}

/* Between the polynomial a and the spline b by a blend w. */
static value blend(const value *a, const value *b, const double w[3]) {
  double f = b->f - a->f, g = b->g - a->g, c = b->c - a->c;
  return (value){.f = a->f + w[0] * f,
                 .g = a->g + w[1] * f + w[0] * g,
                 .c = a->c + w[0] * c,
                 .gg = a->gg + w[2] * f + 2 * w[1] * g + w[0] * (b->gg - a->gg),
                 .gc = a->gc + w[1] * c + w[0] * (b->gc - a->gc),
                 .cc = a->cc + w[0] * (b->cc - a->cc)};
}

/* Turns derivatives by the angle to the lower pole into those by gamma, and back. */
static void turn(value *v) { v->g = -v->g, v->gc = -v->gc; }

/* The pole near which gamma is; NULL: none. *t: the angle to it. */
static const ylm__photometric_pole *near_pole(const ylm_light_photometry *p, double gamma,
                                              double *t) {
  for (int k = 0; k < 2; k++) {
    *t = k ? YLM_PI - gamma : gamma;
    if (p->pole[k].on && *t < p->pole[k].end) return &p->pole[k];
  }
  return NULL;
}

static bool is_dark(const ylm_light_photometry *p, double gamma) {
  return gamma < p->angle[0] - 1e-9 || gamma > p->angle[p->angles - 1] + 1e-9;
}

value ylm__photometric_at(const ylm_light_photometry *p, double gamma, double c) {
  double t, w[3];
  if (is_dark(p, gamma)) return (value){0};
  if (c < p->plane[0]) c += 2 * YLM_PI;
  const ylm__photometric_pole *pole = near_pole(p, gamma, &t);
  if (!pole) return spline(p, gamma, c);
  value a = ylm__photometric_polynomial(pole, t, c), b = a;
  if (t > pole->end / 2) {
    b = spline(p, gamma, c);
    if (pole == &p->pole[1]) turn(&b);
    ylm__photometric_blend(pole, t, w);
    b = blend(&a, &b, w);
  }
  if (pole == &p->pole[1]) turn(&b);
  return b;
}

/* -- directions ------------------------------------------------------------------------------------ */

/* Value, and derivatives in space of the function that is constant along rays. */
typedef struct in_space {
  double f, g[3], h[6];
} in_space;

static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

/* From derivatives by the angles; s, c are sine and cosine of gamma. */
static void from_angles(const value *v, const double w[3], double s, in_space *out) {
  double x = s > 0 ? w[0] / s : 1, y = s > 0 ? w[1] / s : 0;
  double down[3] = {w[2] * x, w[2] * y, -s}, across[3] = {-y, x, 0};
  double cot = s > 0 ? w[2] / s : 0, over = s > 0 ? 1 / s : 0;
  double gc = v->c * over, hgc = (v->gc - cot * v->c) * over;
  /* at a pole without planes the slope is 0, and its part over the sine is the second derivative */
  double hcc = s > 1e-7 ? v->cc * over * over + cot * v->g : v->gg;
  for (int a = 0; a < 3; a++) out->g[a] = v->g * down[a] + gc * across[a];
  for (int q = 0; q < 6; q++) {
    int a = row[q], b = column[q];
    out->h[q] = v->gg * down[a] * down[b] + hgc * (down[a] * across[b] + across[a] * down[b]) +
                hcc * across[a] * across[b] - w[a] * out->g[b] - out->g[a] * w[b];
  }
}

/* Derivatives by x and y of a pole's polynomial, x and y of length 1 taken as coordinates. */
static void by_place(const ylm__photometric_pole *p, double x, double y, double *f, double g[2],
                     double h[3]) {
  double q = x * x + y * y, d[2] = {2 * x, 2 * y};
  /* parts u = x, y, x^2 - y^2, 2xy, each times c0 + c1 q; and e0 + e1 q + e2 q^2 */
  double u[4] = {x, y, x * x - y * y, 2 * x * y};
  double du[4][2] = {{1, 0}, {0, 1}, {2 * x, -2 * y}, {2 * y, 2 * x}};
  double ddu[4][3] = {{0, 0, 0}, {0, 0, 0}, {2, 0, -2}, {0, 2, 0}};
  const double *c[4] = {p->odd[0], p->odd[1], p->two[0], p->two[1]};
  double e1 = p->even[1] + 2 * p->even[2] * q, e2 = 2 * p->even[2];
  *f = p->even[0] + p->even[1] * q + p->even[2] * q * q;
  for (int a = 0; a < 2; a++) g[a] = e1 * d[a];
  for (int k = 0; k < 3; k++) h[k] = (k != 1 ? 2 * e1 : 0) + e2 * d[k / 2] * d[(k + 1) / 2];
  for (int i = 0; i < 4; i++) {
    double part = c[i][0] + c[i][1] * q;
    *f += part * u[i];
    for (int a = 0; a < 2; a++) g[a] += part * du[i][a] + c[i][1] * d[a] * u[i];
    for (int k = 0; k < 3; k++) {
      int a = k / 2, b = (k + 1) / 2;
      h[k] += part * ddu[i][k] +
              c[i][1] * ((k != 1 ? 2 : 0) * u[i] + d[a] * du[i][b] + d[b] * du[i][a]);
    }
  }
}

/* From derivatives g, h by x and y of a function of them. */
static void from_place(const double w[3], const double g[2], const double h[3], in_space *out) {
  double p[3] = {g[0], g[1], 0}, m[3][3] = {{h[0], h[1], 0}, {h[1], h[2], 0}, {0, 0, 0}};
  double along = w[0] * g[0] + w[1] * g[1], mw[3], wmw = 0;
  for (int a = 0; a < 3; a++) {
    mw[a] = m[a][0] * w[0] + m[a][1] * w[1];
    out->g[a] = p[a] - along * w[a];
  }
  for (int a = 0; a < 3; a++) wmw += w[a] * mw[a];
  for (int q = 0; q < 6; q++) {
    int a = row[q], b = column[q];
    double same = a == b;
    out->h[q] = m[a][b] - w[a] * mw[b] - mw[a] * w[b] + wmw * w[a] * w[b] -
                along * (same - w[a] * w[b]) - w[a] * out->g[b] - out->g[a] * w[b];
  }
}

static in_space look(const ylm_light_photometry *p, const double w[3]) {
  in_space out = {0};
  double s = sqrt(w[0] * w[0] + w[1] * w[1]), gamma = atan2(s, w[2]), t;
  if (is_dark(p, gamma)) return out;
  const ylm__photometric_pole *pole = near_pole(p, gamma, &t);
  if (pole && t <= pole->end / 2) {
    double g[2], h[3];
    by_place(pole, w[0], w[1], &out.f, g, h);
    from_place(w, g, h, &out);
  } else {
    value v = ylm__photometric_at(p, gamma, p->planes > 1 ? atan2(w[1], w[0]) : 0);
    out.f = v.f;
    from_angles(&v, w, s, &out);
  }
  return out.f > 0 ? out : (in_space){0};
}

double ylm__photometric_intensity(const ylm_light_photometry *p, const double w[3]) {
  double s = sqrt(w[0] * w[0] + w[1] * w[1]), gamma = atan2(s, w[2]);
  double c = p->planes > 1 ? atan2(w[1], w[0]) : 0;
  return fmax(0, ylm__photometric_at(p, gamma, c).f);
}

void ylm_light_photometry_intensity(const ylm_light_photometry *p, size_t n, const double (*way)[3],
                                    double *cd, double (*gradient)[3], double (*hessian)[6]) {
  for (size_t i = 0; i < n; i++) {
    if (!gradient && !hessian) {
      cd[i] = ylm__photometric_intensity(p, way[i]);
      continue;
    }
    in_space v = look(p, way[i]);
    cd[i] = v.f;
    for (int a = 0; gradient && a < 3; a++) gradient[i][a] = v.g[a];
    for (int q = 0; hessian && q < 6; q++) hessian[i][q] = v.h[q];
  }
}
