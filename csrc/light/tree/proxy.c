/*
** proxy.c - four or eight lights that stand for many: their power, what they miss, and which
** of them are best.
**
** Lights are at x_i, of power e_i r_i^2. The places c + A y_j of the proxies and their parts w_j of
** the weight have the geometry's moments (place.c). With r_p^2 = sum |e| r^4/sum |e| r^2 they have
** sum e r^4 too. In each colour c the emission is e_cj = w_j (E_c + h_c.y_j + k_c.phi_j)/r_p^2: A
** h_c = sum e_c r^2 (x - c) keeps the moments of degree 0 and 1; phi are products of two unlike
** coordinates less what is linear in them, and k_c keeps the moments xy, xz, yz. The second, third
** and fourth moments that are missed are measured here, node by node; with equal colours third
** moments are missed only where places could not be fitted. Of the tetrahedron, its mirror image
** and the cube the one is taken that costs least.
**
** Source  docs/math.md "Many lights"
*/
#include "proxy.h"

#include <math.h>
#include <string.h>

/* How often an element of the list stands in the full tensor. */
static const double times2[6] = {1, 2, 2, 1, 2, 1};
static const double times3[10] = {1, 3, 3, 3, 6, 3, 1, 3, 3, 1};
static const double times4[15] = {1, 4, 4, 6, 12, 6, 4, 12, 12, 4, 1, 4, 6, 4, 1};

/* Products of two coordinates, of which proxies can have different powers in different colours. */
static const int pair_of[3][2] = {{0, 1}, {0, 2}, {1, 2}};

/* x of A A^T x = b. */
static void solve_square(double A[3][3], const double *b, double *x) {
  ylm__tree_solve(A, b, x);
  for (int a = 2; a >= 0; a--) {
    for (int i = a + 1; i < 3; i++) x[a] -= A[i][a] * x[i];
    x[a] = A[a][a] > 0 ? x[a] / A[a][a] : 0;
  }
}

void ylm__tree_basis(const proxies *p, double A[3][3], basis *b) {
  double linear[3][3] = {{0}}, gram[6] = {0};
  for (int j = 0; j < p->n; j++) {
    double *y = b->y[j];
    ylm__tree_solve(A, p->x[j], y);
    for (int i = 0; i < 3; i++) b->phi[j][i] = y[pair_of[i][0]] * y[pair_of[i][1]];
    for (int i = 0; i < 9; i++) linear[i / 3][i % 3] += p->weight[j] * b->phi[j][i / 3] * y[i % 3];
  }
  for (int j = 0; j < p->n; j++) {
    double *f = b->phi[j];
    for (int i = 0; i < 9; i++) f[i / 3] -= linear[i / 3][i % 3] * b->y[j][i % 3];
    for (int i = 0, k = 0; i < 3; i++)
      for (int m = i; m < 3; m++) gram[k++] += p->weight[j] * f[i] * f[m];
  }
  static const int row[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int i = 0; i < 3; i++) /* a tetrahedron's are linear, but for rounding */
    for (int m = 0; gram[row[i][i]] < 0.01 && m < 3; m++) gram[row[i][m]] = 0;
  ylm__tree_axes(gram, 0, b->L);
}

/* Second moments xy, xz, yz in those units. */
static void whiten_pairs(double A[3][3], const double *m, double *xy) {
  double rows[3][3] = {{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}}, half[3][3];
  double out[3][3];
  for (int a = 0; a < 3; a++) ylm__tree_solve(A, rows[a], half[a]);
  for (int a = 0; a < 3; a++)
    ylm__tree_solve(A, (double[3]){half[0][a], half[1][a], half[2][a]}, out[a]);
  for (int i = 0; i < 3; i++) xy[i] = out[pair_of[i][0]][pair_of[i][1]];
}

void ylm__tree_share(const proxies *p, double A[3][3], basis *b, const double m[M3],
                     double power[YLM__MOST_PROXIES]) {
  double h[3], k[3], xy[3];
  ylm__tree_solve(A, m + M1, h);
  whiten_pairs(A, m + M2, xy);
  for (int j = 0; j < p->n; j++) {
    const double *y = b->y[j];
    power[j] = p->weight[j] * (m[M0] + h[0] * y[0] + h[1] * y[1] + h[2] * y[2]);
    for (int i = 0; i < 3; i++) xy[i] -= power[j] * y[pair_of[i][0]] * y[pair_of[i][1]];
  }
  solve_square(b->L, xy, k);
  for (int j = 0; j < p->n; j++) {
    const double *f = b->phi[j];
    power[j] += p->weight[j] * (k[0] * f[0] + k[1] * f[1] + k[2] * f[2]);
  }
}

/* Proxies, and the power of each in each colour. */
static void make_proxies(const cluster *q, double A[3][3], int n, double mirror, proxies *p) {
  basis b;
  ylm__tree_place(q, A, n, mirror, p);
  ylm__tree_basis(p, A, &b);
  for (int c = 0; c < 3; c++) {
    double power[YLM__MOST_PROXIES];
    ylm__tree_share(p, A, &b, q->sum[c], power);
    for (int j = 0; j < n; j++) p->power[j][c] = power[j];
  }
}

static double tensor_square(const double *m, const double *times, int n) {
  double s = 0;
  for (int i = 0; i < n; i++) s += times[i] * m[i] * m[i];
  return s;
}

/* Moments that proxies miss: [strengths][second, third], with the constants of Taylor's formula. */
static void find_missing(const cluster *q, proxies *p) {
  static const double plain[3] = {1, 1, 1};
  double rest[3][MOMENTS], lum[MOMENTS];
  memcpy(rest, q->sum, sizeof rest);
  for (int c = 0; c < 3; c++)
    for (int j = 0; j < p->n; j++) ylm__tree_add(rest[c], -p->power[j][c], p->x[j], q->radius2);
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
    p->missing[s][0] = COLOURS * sqrt(m2) / 2 + sqrt(r0) / 8;
    p->missing[s][1] = SKEW * sqrt(m3) / 6 + sqrt(r1) / 8;
  }
}

/* Fourth moments of geometry that proxies miss, with the 1/24 of Taylor's formula. */
static void find_fourth(const cluster *q, proxies *p) {
  double rest[15];
  memcpy(rest, q->fourth_of, sizeof rest);
  for (int j = 0; j < p->n; j++) ylm__tree_add_fourth(rest, -p->weight[j], p->x[j]);
  p->fourth = (MISSED * sqrt(tensor_square(rest, times4, 15)) + HIGHER * q->fourth) / 24;
}

/* The cost of a volume of such nodes: proxies times the cube of the distance at which the error of
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

void ylm__tree_choose(const cluster *q, size_t n, double A[3][3], proxies *best) {
  double least = INFINITY;
  ylm__tree_axes(q->shape + M2, q->grain, A);
  for (int i = 0; i < (n > YLM__MANY ? 3 : 2); i++) {
    proxies p;
    make_proxies(q, A, i < 2 ? YLM__PROXIES : YLM__MOST_PROXIES, i == 1 ? -1 : 1, &p);
    find_missing(q, &p);
    find_fourth(q, &p);
    double c = cost(q, &p);
    if (i == 0 || c < least) *best = p, least = c;
  }
}

/* Rounds up, so that what is enclosed stays so. */
static float up(double x) { return nextafterf((float)x, INFINITY); }

void ylm__tree_node(ylm_light_tree *t, uint32_t g, int k, const uint32_t *order, size_t n) {
  cluster q;
  ylm__tree_cluster(&q, t->lights->lamp_d, order, n);
  ylm__group *to = &t->group[g];
  proxies p = {.n = 0};
  double spread = 0;
  if (n > YLM__PROXIES) {
    double A[3][3];
    ylm__tree_choose(&q, n, A, &p);
    for (int j = 0; j < p.n; j++) {
      const double *x = p.x[j];
      double d = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
      spread = fmax(spread, d + sqrt(q.radius2));
    }
    write_proxies(t, to->proxies[k] / 2, &q, &p);
    to->proxies[k] |= p.n == YLM__MOST_PROXIES;
  }
  q.reach = fmax(q.reach, spread);
  double s = t->size, s2 = s * s;
  for (int a = 0; a < 3; a++) to->at[a][k] = (float)((q.at[a] - t->centre[a]) / s);
  to->reach[k] = up(q.reach / s);
  to->spread[k] = p.n > 0 ? up(spread / s) : to->reach[k];
  to->radius[k] = (float)(sqrt(q.radius2) / s);
  to->lights[k] = (uint32_t)n;
  for (int i = 0; i < YLM__STRENGTHS; i++) {
    to->strength[i][k] = (float)(q.strength[i] / t->total);
    to->second[i][k] = up(p.missing[i][0] / s2 / t->total);
    to->third[i][k] = up(p.missing[i][1] / s2 / s / t->total);
  }
  to->fourth[k] = up(p.fourth / s2 / s2);
}
