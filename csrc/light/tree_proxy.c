/*
** tree_proxy.c - four or eight lights that stand for many: their places, and what they miss.
**
** Lights x_i of power e_i r_i^2, in geometry weighted by |luminance| r^2: centroid c, covariance
** C = A A^T. The n proxies p_j = c + A u_j with u_j the corners of a cube, or those of them that
*are
** a tetrahedron's, keep the moments of degree 0, 1 and 2, and with r_p^2 = sum |e| r^4/sum |e| r^2
** also sum e r^4. In each colour c the emission e_cj = (E_c + h_c.u_j)/(n r_p^2), A h_c =
** sum e_c r^2 (x - c), keeps the moments of degree 0 and 1. What is missed of second, third and
** fourth moments is measured here, node by node: equal colours miss no second moment. Of the
** tetrahedron, its mirror image and the cube the one is taken that costs least.
**
** Source  docs/math.md "Many lights"
*/
#include "tree.h"

#include <math.h>
#include <string.h>

/* Moments about the centroid, per colour: 1; x y z; xx xy xz yy yz zz; xxx xxy xxz xyy xyz xzz yyy
   yyz yzz zzz; then of weights e r^4: 1; x y z. */
enum { M0 = 0, M1 = 1, M2 = 4, M3 = 10, MR0 = 20, MR1 = 21, MOMENTS = 24 };

/* How often an element of the list stands in the full tensor. */
static const double times2[6] = {1, 2, 2, 1, 2, 1};
static const double times3[10] = {1, 3, 3, 3, 6, 3, 1, 3, 3, 1};
static const double times4[15] = {1, 4, 4, 6, 12, 6, 4, 12, 12, 4, 1, 4, 6, 4, 1};

/* A cube's; the first four are a tetrahedron's. */
static const double corner[YLM__MOST_PROXIES][3] = {{1, 1, 1},   {1, -1, -1},  {-1, 1, -1},
                                                    {-1, -1, 1}, {-1, -1, -1}, {-1, 1, 1},
                                                    {1, -1, 1},  {1, 1, -1}};

/* The error of a node, as estimated, for which the number of proxies is chosen. */
#define TYPICAL 0.25

/* What is missed of the third moments counts so much, which nodes of few lights on a wall have by
   chance; of the fourth so much, since directions seldom agree; and the
   fourth moments themselves so much, for all that is higher. */
#define SKEW 2
#define MISSED 0.7
#define HIGHER 0.03

typedef struct cluster {
  double at[3], weight, reach, radius2; /* centroid, sum of |lum| r^2, r_p^2 */
  double cov[6], m4[15], fourth;        /* mean of x x, of x x x x, of (x^2 + r^2)^2 */
  double strength[YLM__STRENGTHS];
  double sum[3][MOMENTS];
} cluster;

static double magnitude(const ylm__lamp_d *l) {
  return YLM_LUMINANCE_R * fabs(l->rgb[0]) + YLM_LUMINANCE_G * fabs(l->rgb[1]) +
         YLM_LUMINANCE_B * fabs(l->rgb[2]);
}

/* Adds a light of power e, offset x and squared radius r2 to one colour's moments. */
static void add_moments(double *m, double e, const double *x, double r2) {
  int k2 = M2, k3 = M3;
  m[M0] += e;
  m[MR0] += e * r2;
  for (int a = 0; a < 3; a++) {
    m[M1 + a] += e * x[a];
    m[MR1 + a] += e * r2 * x[a];
    for (int b = a; b < 3; b++) {
      m[k2++] += e * x[a] * x[b];
      for (int c = b; c < 3; c++) m[k3++] += e * x[a] * x[b] * x[c];
    }
  }
}

/* Adds w x x x x: xxxx xxxy xxxz xxyy xxyz xxzz xyyy xyyz xyzz xzzz yyyy yyyz yyzz yzzz zzzz. */
static void add_fourth(double *m, double w, const double *x) {
  int k = 0;
  for (int a = 0; a < 3; a++)
    for (int b = a; b < 3; b++)
      for (int c = b; c < 3; c++)
        for (int d = c; d < 3; d++) m[k++] += w * x[a] * x[b] * x[c] * x[d];
}

/* The weighted centroid of n lights; the mean of their centres where nothing emits. */
static void find_centroid(cluster *q, const ylm__lamp_d *lamps, const uint32_t *order, size_t n) {
  double plain[3] = {0}, sum[3] = {0}, r4 = 0;
  q->weight = 0;
  for (size_t i = 0; i < n; i++) {
    const ylm__lamp_d *l = &lamps[order[i]];
    double r2 = l->radius * l->radius, w = magnitude(l) * r2;
    q->weight += w;
    r4 += w * r2;
    for (int a = 0; a < 3; a++) plain[a] += l->at[a] / (double)n, sum[a] += w * l->at[a];
  }
  bool emits = q->weight > 0 && isfinite(r4) && r4 > 0;
  if (!emits) q->weight = 0;
  q->radius2 = emits ? r4 / q->weight : 0;
  for (int a = 0; a < 3; a++) q->at[a] = emits ? sum[a] / q->weight : plain[a];
}

static void find_moments(cluster *q, const ylm__lamp_d *lamps, const uint32_t *order, size_t n) {
  for (size_t i = 0; i < n; i++) {
    const ylm__lamp_d *l = &lamps[order[i]];
    double x[3], d2 = 0, r2 = l->radius * l->radius, norm2 = 0;
    for (int a = 0; a < 3; a++) x[a] = l->at[a] - q->at[a], d2 += x[a] * x[a];
    for (int c = 0; c < 3; c++) {
      add_moments(q->sum[c], l->rgb[c] * r2, x, r2);
      norm2 += l->rgb[c] * l->rgb[c];
    }
    q->strength[YLM__STRENGTH_RGB] += sqrt(norm2) * r2;
    q->strength[YLM__STRENGTH_LUM] += fabs(l->luminance) * r2;
    q->reach = fmax(q->reach, sqrt(d2) + l->radius);
    if (q->weight == 0) continue;
    double w = magnitude(l) * r2 / q->weight;
    for (int a = 0, k = 0; a < 3; a++)
      for (int b = a; b < 3; b++) q->cov[k++] += w * x[a] * x[b];
    add_fourth(q->m4, w, x);
    q->fourth += w * (d2 + r2) * (d2 + r2);
  }
}

/* The lower triangle A of C = A A^T; columns without extent are zero (walls, lines, one place). */
static void cholesky(const double *cov, double A[3][3]) {
  double C[3][3] = {{cov[0], cov[1], cov[2]}, {cov[1], cov[3], cov[4]}, {cov[2], cov[4], cov[5]}};
  double least = 1e-12 * (C[0][0] + C[1][1] + C[2][2]);
  memset(A, 0, 9 * sizeof(double));
  for (int k = 0; k < 3; k++) {
    double pivot = C[k][k];
    for (int j = 0; j < k; j++) pivot -= A[k][j] * A[k][j];
    if (!(pivot > least)) continue;
    A[k][k] = sqrt(pivot);
    for (int i = k + 1; i < 3; i++) {
      double s = C[i][k];
      for (int j = 0; j < k; j++) s -= A[i][j] * A[k][j];
      A[i][k] = s / A[k][k];
    }
  }
}

/* Lights that may stand for a node. */
typedef struct proxies {
  int n;
  double x[YLM__MOST_PROXIES][3], power[YLM__MOST_PROXIES][3];
  double missing[YLM__STRENGTHS][2], fourth; /* second and third moments that they miss */
} proxies;

/* The first n corners, or their mirror images, about the centroid by A u, with the power of each in
   each colour. */
static void place_proxies(const cluster *q, double A[3][3], int n, double mirror, proxies *p) {
  p->n = n;
  for (int j = 0; j < n; j++)
    for (int a = 0; a < 3; a++)
      p->x[j][a] =
          mirror * (A[a][0] * corner[j][0] + A[a][1] * corner[j][1] + A[a][2] * corner[j][2]);
  for (int c = 0; c < 3; c++) {
    double h[3];
    for (int a = 0; a < 3; a++) {
      double s = q->sum[c][M1 + a];
      for (int b = 0; b < a; b++) s -= A[a][b] * h[b];
      h[a] = A[a][a] > 0 ? s / A[a][a] : 0;
    }
    for (int j = 0; j < n; j++)
      p->power[j][c] = (q->sum[c][M0] + mirror * (h[0] * corner[j][0] + h[1] * corner[j][1] +
                                                  h[2] * corner[j][2])) /
                       n;
  }
}

static double tensor_square(const double *m, const double *times, int n) {
  double s = 0;
  for (int i = 0; i < n; i++) s += times[i] * m[i] * m[i];
  return s;
}

/* What proxies miss: [strengths][second, third], with the constants of Taylor's formula. */
static void find_missing(const cluster *q, proxies *p) {
  static const double plain[3] = {1, 1, 1};
  double rest[3][MOMENTS], lum[MOMENTS];
  memcpy(rest, q->sum, sizeof rest);
  for (int c = 0; c < 3; c++)
    for (int j = 0; j < p->n; j++) add_moments(rest[c], -p->power[j][c], p->x[j], q->radius2);
  for (int i = 0; i < MOMENTS; i++) {
    double rgb[3] = {rest[0][i], rest[1][i], rest[2][i]};
    lum[i] = ylm__emission(rgb, 1, 0);
  }
  for (int s = 0; s < YLM__STRENGTHS; s++) {
    double m2 = 0, m3 = 0, r0 = 0, r1 = 0;
    for (int c = 0; c < (s == YLM__STRENGTH_RGB ? 3 : 1); c++) {
      const double *m = s == YLM__STRENGTH_RGB ? rest[c] : lum;
      m2 += tensor_square(m + M2, times2, 6);
      m3 += tensor_square(m + M3, times3, 10);
      r0 += m[MR0] * m[MR0];
      r1 += tensor_square(m + MR1, plain, 3);
    }
    /* a quarter and three quarters: what radii do beside what offsets do, at any lmax */
    p->missing[s][0] = sqrt(m2) / 2 + sqrt(r0) / 8;
    p->missing[s][1] = SKEW * sqrt(m3) / 6 + sqrt(r1) / 8;
  }
}

/* What proxies miss of the fourth moments of geometry, with the 1/24 of Taylor's formula. */
static void find_fourth(const cluster *q, proxies *p) {
  double rest[15];
  memcpy(rest, q->m4, sizeof rest);
  for (int j = 0; j < p->n; j++) add_fourth(rest, -1.0 / p->n, p->x[j]);
  p->fourth = (MISSED * sqrt(tensor_square(rest, times4, 15)) + HIGHER * q->fourth) / 24;
}

/* What a volume of such nodes costs: proxies times the cube of the distance at which the error of
   gradients, at lmax 4, is TYPICAL of the field. */
static double cost(const cluster *q, const proxies *p) {
  double most = 1 / q->reach, u = 0, strength = q->strength[YLM__STRENGTH_RGB];
  const double *m = p->missing[YLM__STRENGTH_RGB];
  for (double step = most / 2; step > most / 1000; step /= 2) {
    double v = u + step;
    double e = v * v * (185 * m[0] + v * (327 * m[1] + v * 3245 * p->fourth * strength));
    if (e <= TYPICAL * strength) u = v;
  }
  return u > 0 ? p->n / (u * u * u) : INFINITY;
}

static void write_proxies(ylm_light_tree *t, size_t block, const cluster *q, const proxies *p) {
  float *f = t->proxies_f[block][0];
  double *d = t->proxies_d[block][0];
  for (int j = 0; j < p->n; j++) {
    double field[YLM__FIELDS], rgb[3];
    for (int a = 0; a < 3; a++) {
      field[YLM__X + a] = q->at[a] + p->x[j][a];
      field[YLM__E + a] = rgb[a] = q->radius2 > 0 ? p->power[j][a] / q->radius2 : 0;
    }
    field[YLM__R] = sqrt(q->radius2);
    field[YLM__LUM] = ylm__emission(rgb, 1, 0);
    for (int i = 0; i < YLM__FIELDS; i++) {
      d[i * p->n + j] = field[i];
      f[i * p->n + j] = (float)field[i];
    }
  }
}

/* The proxies that cost least, of a cluster with more lights than four. */
static void choose_proxies(const cluster *q, size_t n, proxies *best) {
  double A[3][3], least = INFINITY;
  cholesky(q->cov, A);
  for (int i = 0; i < (n > YLM__MANY ? 3 : 2); i++) {
    proxies p;
    place_proxies(q, A, i < 2 ? YLM__PROXIES : YLM__MOST_PROXIES, i == 1 ? -1 : 1, &p);
    find_missing(q, &p);
    find_fourth(q, &p);
    double c = cost(q, &p);
    if (i == 0 || c < least) *best = p, least = c;
  }
}

/* Rounds up, so that what is enclosed stays so. */
static float up(double x) { return nextafterf((float)x, INFINITY); }

void ylm__tree_node(ylm_light_tree *t, uint32_t g, int k, const uint32_t *order, size_t n) {
  cluster q = {.weight = 0};
  find_centroid(&q, t->lights->lamp_d, order, n);
  find_moments(&q, t->lights->lamp_d, order, n);
  ylm__group *to = &t->group[g];
  proxies p = {.n = 0};
  if (n > YLM__PROXIES) {
    choose_proxies(&q, n, &p);
    for (int j = 0; j < p.n; j++) {
      const double *x = p.x[j];
      double d = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
      q.reach = fmax(q.reach, d + sqrt(q.radius2));
    }
    write_proxies(t, to->proxies[k] / 2, &q, &p);
    to->proxies[k] |= p.n == YLM__MOST_PROXIES;
  }
  double s = t->size, s2 = s * s;
  for (int a = 0; a < 3; a++) to->at[a][k] = (float)((q.at[a] - t->centre[a]) / s);
  to->reach[k] = up(q.reach / s);
  to->radius[k] = (float)(sqrt(q.radius2) / s);
  to->lights[k] = (uint32_t)n;
  for (int i = 0; i < YLM__STRENGTHS; i++) {
    to->strength[i][k] = (float)(q.strength[i] / t->total);
    to->second[i][k] = up(p.missing[i][0] / s2 / t->total);
    to->third[i][k] = up(p.missing[i][1] / s2 / s / t->total);
  }
  to->fourth[k] = up(p.fourth / s2 / s2);
}
