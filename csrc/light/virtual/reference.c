/*
** reference.c - virtual lights by the product rule, one light at a time, in double.
**
** Short and plain; it judges the kernels. With t = 2 d^2/sg^2, o = (d/R)^4 and h_l = e^(-l(l+1)/t),
**
**   G_l = g h_l/d^2,   g = 1 - e^-t (gauss), 1 - e^-o (far), e^-o - e^-t (near), 1 with h = 1 (point)
**
** With ' for d d/dd, that takes t to 2t and o to 4o, and q = 2 l(l+1)/t:
**
**   G' = h_l/d^2 (a1 + q a0),   G'' = h_l/d^2 (a2 + 2 q a1 + q (q-2) a0),
**   a0 = g,  a1 = g' - 2g,  a2 = g'' - 4g' + 4g
**
** The emission P(u) = max(0, s + n.u) B(u) has the gradient e and the Hessian H by u, and by v, as
** du/dv = -(1 - u u')/D:
**
**   grad E = -(e - u (u.e))/D
**   hess E = (H - (Hu) u' - u (Hu)' + u u' (u.Hu) - e u' - u e' + 3 u u' (u.e) - (u.e))/D^2
**
** Source  docs/virtual.md
*/
#include <string.h>

#include "virtual.h"
#include "ylm_sh.h"

/* 1, gradient, Hessian xx xy xz yy yz zz, one after the other. */
enum { VALUE, GRADIENT, HESSIAN = 4, WIDE = 10, MOST = 81 };
static const int row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};

/* One light as it is summed. */
typedef struct source {
  double at[3], normal[3], radius, shift, core;
  double emission[3 * MOST];
  bool turned; /* it has a normal */
} source;

typedef struct work {
  const ylm_light_virtual *lights;
  int lmax;
  size_t count;
  double *Y, *dY, *ddY; /* [count], [count][3], [count][6] with respect to v */
  double *P, *dP;       /* [lmax+1] */
  double *G;            /* [lmax+1][3]  G, d G', d^2 G'' */
  double *sum;          /* [3][10 count], as ylm__field_write takes them */
  bool rough;           /* light leaves alike in all directions, as far as derivatives go */
} work;

/* -- distance ------------------------------------------------------------------------------- */

/* a0, a1, a2 of a Gaussian by t. */
static void gaussian(double t, double a[3]) {
  double rest = exp(-t), g = -expm1(-t);
  a[0] = g;
  if (t > 0.1) {
    a[1] = 2 * t * rest - 2 * g;
    a[2] = 4 * t * (1 - t) * rest - 8 * t * rest + 4 * g;
    return;
  }
  a[1] = a[2] = 0;
  double term = t; /* -(-t)^m / m! */
  for (int m = 2; m < 14; m++) {
    term *= -t / m;
    a[1] += (2 * m - 2) * term;
    a[2] += (2 * m - 2) * (2 * m - 2) * term;
  }
}

/* a0, a1, a2 of a core, by o. */
static void hollow(double o, double a[3]) {
  double rest = exp(-o), g = -expm1(-o);
  a[0] = g;
  a[1] = 4 * o * rest - 2 * g;
  a[2] = 16 * o * (1 - o) * rest - 16 * o * rest + 4 * g;
}

/* G of smooth profiles. */
static void smooth(const work *k, const source *s, double d) {
  ylm_light_virtual_profile profile = k->lights->profile;
  double sg = YLM__GAUSS_WIDTH * s->radius, a[3] = {1, -2, 4}, b[3], t = INFINITY;
  if (profile != YLM_LIGHT_VIRTUAL_POINT) {
    d = fmax(d, 1e-8 * sg);
    t = 2 * (d / sg) * (d / sg);
    gaussian(t, a);
  }
  if (profile == YLM_LIGHT_VIRTUAL_FAR || profile == YLM_LIGHT_VIRTUAL_NEAR) {
    double o = d / s->core;
    hollow(o * o * o * o, b);
    for (int i = 0; i < 3; i++) a[i] = profile == YLM_LIGHT_VIRTUAL_FAR ? b[i] : a[i] - b[i];
  }
  for (int l = 0; l <= k->lmax; l++) {
    double q = 2 * l * (l + 1.0) / t, h = exp(-q / 2) / (d * d), *G = k->G + 3 * l;
    double slope = a[1] + q * a[0];
    G[0] = h * a[0];
    G[1] = h * slope;
    G[2] = h * (a[2] + 2 * q * a[1] + q * (q - 2) * a[0] - slope);
    if (h == 0) G[0] = G[1] = G[2] = 0;
  }
}

/* P_l and P_l' at alpha. */
static void legendre(int lmax, double alpha, double *P, double *dP) {
  P[0] = 1, dP[0] = 0;
  if (lmax > 0) P[1] = alpha, dP[1] = 1;
  for (int l = 2; l <= lmax; l++) {
    P[l] = ((2 * l - 1) * alpha * P[l - 1] - (l - 1) * P[l - 2]) / l;
    dP[l] = dP[l - 2] + (2 * l - 1) * P[l - 1];
  }
}

/* G of a cap: a sphere's outside of it (csrc/light/sphere/reference.c), a hemisphere's inside. */
static void cap(const work *k, const source *s, double d) {
  double r = s->radius, h2 = (d - r) * (d + r), h = h2 > 0 ? sqrt(h2) : 0, alpha = h / d;
  double width = h2 > 0 ? 1 / (d * d) : 1 / (r * r), u = h2 > 0 ? 1 / (d * h) : 0;
  legendre(k->lmax, alpha, k->P, k->dP);
  for (int l = 0; l <= k->lmax; l++) {
    double *G = k->G + 3 * l, P = k->P[l], dP = k->dP[l];
    G[0] = 2 * width * (l ? dP / (l * (l + 1.0)) : 1 / (1 + alpha));
    G[1] = h2 > 0 ? -2 * P * u : 0;
    G[2] = h2 > 0 ? -2 * u * (dP * u * r * r - P * (2 + d * d / h2)) : 0;
  }
}

/* -- direction ------------------------------------------------------------------------------ */

/* Jets of max(0, shift + normal.u) by u. */
static bool cosine(const source *s, const double u[3], double c[WIDE]) {
  memset(c, 0, WIDE * sizeof *c);
  c[VALUE] = 1;
  if (!s->turned) return true;
  c[VALUE] = s->shift;
  for (int a = 0; a < 3; a++) c[VALUE] += s->normal[a] * u[a];
  for (int a = 0; a < 3; a++) c[GRADIENT + a] = s->normal[a];
  return c[VALUE] > 0;
}

/* Jets by v from jets by u. */
static void turn(const double u[3], double D, const double P[WIDE], double E[WIDE]) {
  const double *e = P + GRADIENT, *H = P + HESSIAN;
  double M[3][3], Hu[3], ue = 0, uHu = 0;
  for (int i = 0; i < 6; i++) M[row[i]][column[i]] = M[column[i]][row[i]] = H[i];
  for (int a = 0; a < 3; a++) {
    Hu[a] = M[a][0] * u[0] + M[a][1] * u[1] + M[a][2] * u[2];
    ue += u[a] * e[a];
  }
  for (int a = 0; a < 3; a++) uHu += u[a] * Hu[a];
  E[VALUE] = P[VALUE];
  for (int a = 0; a < 3; a++) E[GRADIENT + a] = -(e[a] - u[a] * ue) / D;
  for (int i = 0; i < 6; i++) {
    int a = row[i], b = column[i];
    E[HESSIAN + i] = (M[a][b] - Hu[a] * u[b] - u[a] * Hu[b] + u[a] * u[b] * (uHu + 3 * ue) -
                      e[a] * u[b] - u[a] * e[b] - (a == b) * ue) /
                     (D * D);
  }
}

/* Jets of E by v, [3]; false where it is 0. */
static bool emit(const work *k, const source *s, const double v[3], double d, double E[3][WIDE]) {
  double eps = 0, u[3], c[WIDE], S[MOST], dS[3 * MOST], ddS[6 * MOST];
  ylm_light_virtual_profile p = k->lights->profile;
  if (p != YLM_LIGHT_VIRTUAL_POINT && p != YLM_LIGHT_VIRTUAL_CAP)
    eps = YLM__GAUSS_SOFT * YLM__GAUSS_WIDTH * s->radius;
  double D = hypot(d, eps);
  for (int a = 0; a < 3; a++) u[a] = -v[a] / D;
  if (!cosine(s, u, c)) return false;
  ylm_sh_how how = {.derivatives = 2, .solid = true, .isa = YLM_ISA_reference, .threads = 1};
  if (ylm_sh_eval_how(&how, k->lights->degree, YLM_DOUBLE, 1, u, S, dS, ddS, NULL) != YLM_OK)
    return false;
  size_t n = YLM_LIGHT_VIRTUAL_NUMBERS(k->lights->degree);
  for (size_t i = 0; i < 3; i++) {
    double B[WIDE] = {0}, P[WIDE];
    for (size_t q = 0; q < n; q++) {
      double b = s->emission[i * n + q];
      B[VALUE] += b * S[q];
      for (size_t a = 0; a < 3; a++) B[GRADIENT + a] += b * dS[3 * q + a];
      for (size_t a = 0; a < 6; a++) B[HESSIAN + a] += b * ddS[6 * q + a];
    }
    P[VALUE] = c[VALUE] * B[VALUE];
    for (int a = 0; a < 3; a++)
      P[GRADIENT + a] = c[GRADIENT + a] * B[VALUE] + c[VALUE] * B[GRADIENT + a];
    for (int j = 0; j < 6; j++)
      P[HESSIAN + j] = c[GRADIENT + row[j]] * B[GRADIENT + column[j]] +
                       c[GRADIENT + column[j]] * B[GRADIENT + row[j]] + c[VALUE] * B[HESSIAN + j];
    turn(u, D, P, E[i]);
  }
  return true;
}

/* -- sums ----------------------------------------------------------------------------------- */

/* Adds E times (value, gradient, Hessian) of coefficient i of degree l, by x. */
static void add(work *k, size_t i, int l, const double w[3], double d, const double E[3][WIDE]) {
  const double *G = k->G + 3 * l, *g = k->dY + 3 * i, *H = k->ddY + 6 * i, Y = k->Y[i];
  double S[WIDE];
  S[VALUE] = G[0] * Y;
  for (int a = 0; a < 3; a++) S[GRADIENT + a] = G[0] * g[a] + G[1] / d * w[a] * Y;
  for (int j = 0; j < 6; j++) {
    int a = row[j], b = column[j];
    double radial = (G[2] * w[a] * w[b] + G[1] * ((a == b) - w[a] * w[b])) / (d * d);
    S[HESSIAN + j] = G[0] * H[j] + G[1] / d * (g[a] * w[b] + w[a] * g[b]) + radial * Y;
  }
  for (size_t c = 0; c < 3; c++) {
    double *value = k->sum + c * WIDE * k->count, *slope = value + k->count,
           *bend = slope + 3 * k->count;
    const double *e = E[c];
    value[i] += S[VALUE] * e[VALUE];
    for (size_t a = 0; a < 3; a++)
      slope[3 * i + a] -= S[VALUE] * e[GRADIENT + a] + e[VALUE] * S[GRADIENT + a];
    for (size_t j = 0; j < 6; j++) {
      int a = row[j], b = column[j];
      bend[6 * i + j] += S[VALUE] * e[HESSIAN + j] + e[VALUE] * S[HESSIAN + j] +
                         e[GRADIENT + a] * S[GRADIENT + b] + S[GRADIENT + a] * e[GRADIENT + b];
    }
  }
}

/* Y(v/|v|) with its derivatives at v; near to the light along z, where only degree 0 is left. */
static ylm_status basis(const work *k, const double v[3]) {
  ylm_sh_how how = {.derivatives = 2, .isa = YLM_ISA_reference, .threads = 1};
  return ylm_sh_eval_how(&how, k->lmax, YLM_DOUBLE, 1, v, k->Y, k->dY, k->ddY, NULL);
}

static ylm_status add_light(work *k, const source *s, const double x[3]) {
  ylm_light_virtual_profile p = k->lights->profile;
  bool sharp = p == YLM_LIGHT_VIRTUAL_POINT || p == YLM_LIGHT_VIRTUAL_CAP;
  double v[3], E[3][WIDE], sg = YLM__GAUSS_WIDTH * s->radius;
  for (int a = 0; a < 3; a++) v[a] = s->at[a] - x[a];
  double d = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if ((sharp && d == 0) || !emit(k, s, v, d, E)) return YLM_OK;
  for (int c = 0; c < 3 && k->rough; c++)
    for (int i = GRADIENT; i < WIDE; i++) E[c][i] = 0;
  if (!sharp && d < 1e-8 * sg) v[0] = v[1] = 0, v[2] = d = 1e-8 * sg;
  if (p == YLM_LIGHT_VIRTUAL_CAP)
    cap(k, s, d);
  else
    smooth(k, s, d);
  ylm_status status = basis(k, v);
  double w[3] = {v[0] / d, v[1] / d, v[2] / d};
  for (int l = 0; l <= k->lmax && status == YLM_OK; l++)
    for (size_t i = ylm_sh_index(l, -l); i <= ylm_sh_index(l, l); i++) add(k, i, l, w, d, E);
  return status;
}

/* A number as it is seen: in float the kernels' inputs are rounded. */
static double seen(ylm_dtype t, double x) { return t == YLM_FLOAT ? (double)(float)x : x; }

static void read_light(const ylm_light_virtual *v, ylm_dtype t, size_t i, source *s) {
  size_t n = 3 * YLM_LIGHT_VIRTUAL_NUMBERS(v->degree);
  s->turned = false;
  for (size_t a = 0; a < 3; a++) {
    s->at[a] = seen(t, v->local[3 * i + a]);
    s->normal[a] = seen(t, v->normal[3 * i + a]);
    s->turned |= s->normal[a] != 0;
  }
  s->radius = seen(t, v->radius[i]);
  s->shift = seen(t, v->shift[i]);
  s->core = seen(t, v->core);
  for (size_t q = 0; q < n; q++) s->emission[q] = seen(t, v->emission[n * i + q]);
}

static ylm_status work_create(work *k, const ylm_light_virtual *v, int lmax) {
  size_t n = ylm_sh_count(lmax), degrees = (size_t)lmax + 1;
  double *p = ylm_alloc(n * 10 + 3 * WIDE * n + 5 * degrees, sizeof *p);
  if (!p) return YLM_ENOMEM;
  *k = (work){.lights = v,
              .lmax = lmax,
              .count = n,
              .sum = p,
              .Y = p + 30 * n,
              .dY = p + 31 * n,
              .ddY = p + 34 * n,
              .P = p + 40 * n,
              .dP = p + 40 * n + degrees,
              .G = p + 40 * n + 2 * degrees};
  return YLM_OK;
}

ylm_status ylm__virtual_reference(const ylm_light_virtual *v, const ylm_field_query *q,
                                  size_t begin, size_t end, const void *points,
                                  ylm_field_result *r) {
  work k;
  source light;
  ylm_field_query exact = *q, rough = *q;
  const bool both = (q->want & YLM_WANT_METRIC) && (q->want & YLM_WANT_ROUGH);
  ylm_status s = work_create(&k, v, q->lmax);
  if (s != YLM_OK) return s;
  if (both) exact.want &= ~YLM_WANT_METRIC, rough.want = YLM_WANT_METRIC;
  for (size_t p = begin; s == YLM_OK && p < end; p++) {
    double x[3];
    for (size_t a = 0; a < 3; a++) x[a] = ylm_get(q->dtype, points, 3 * p + a);
    for (int pass = 0; pass < (both ? 2 : 1); pass++) {
      memset(k.sum, 0, 3 * WIDE * k.count * sizeof *k.sum);
      k.rough = pass;
      for (size_t i = 0; s == YLM_OK && i < v->n; i++) {
        read_light(v, q->dtype, i, &light);
        s = add_light(&k, &light, x);
      }
      ylm__field_write(pass ? &rough : &exact, p, 3, k.sum, WIDE * k.count, r);
    }
    if (r->inside) r->inside[p] = 0;
  }
  ylm_free(k.sum);
  return s;
}
