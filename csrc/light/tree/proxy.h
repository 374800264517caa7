/*
** proxy.h - the moments of a node's lights, and the lights that may stand for it.
**
** Private to csrc/light/tree.
*/
#ifndef YLM_LIGHT_TREE_PROXY_H
#define YLM_LIGHT_TREE_PROXY_H

#include "tree.h"

/* Moments about the centroid: 1; x y z; xx xy xz yy yz zz; xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz;
   then of weights e r^2 where these are e: 1; x y z. */
enum { M0 = 0, M1 = 1, M2 = 4, M3 = 10, MR0 = 20, MR1 = 21, MOMENTS = 24 };

/* Lights of power e r^2; geometry is weighted by |luminance| r^2. */
typedef struct cluster {
  double at[3], weight, reach, radius2;         /* centroid, sum of |lum| r^2, r_p^2 */
  double shape[MOMENTS], fourth_of[15], fourth; /* means; of x x x x and of (x^2 + r^2)^2 */
  double strength[YLM__STRENGTHS];
  double sum[3][MOMENTS]; /* of each colour's power */
  double grain;           /* variance that is but rounding */
} cluster;

/* Lights that may stand for a node: places about the centroid, their parts of the weight, and in
   colours of the power. */
typedef struct proxies {
  int n;
  double x[YLM__MOST_PROXIES][3], weight[YLM__MOST_PROXIES], power[YLM__MOST_PROXIES][3];
  double missing[YLM__STRENGTHS][2], fourth; /* second and third moments that they miss */
} proxies;

/* Functions on proxies, where the covariance is the identity: coordinates y, products phi of two of
   them less what is linear in y, and the factor L of phi's products with each other. */
typedef struct basis {
  double y[YLM__MOST_PROXIES][3], phi[YLM__MOST_PROXIES][3], L[3][3];
} basis;

/* -- cluster.c --------------------------------------------------------------------------------- */

/* Adds a light of power e, offset x and squared radius r2. */
void ylm__tree_add(double m[MOMENTS], double e, const double *x, double r2);
/* Adds w x x x x: xxxx xxxy xxxz xxyy xxyz xxzz xyyy xyyz xyzz xzzz yyyy yyyz yyzz yzzz zzzz. */
void ylm__tree_add_fourth(double m[15], double w, const double *x);
/* Of n lights; zero before. */
void ylm__tree_cluster(cluster *q, const ylm__lamp_d *lamps, const uint32_t *order, size_t n);

/* Numbers lamps of positive luminance first, each part in its order; how many they are. */
uint32_t ylm__tree_part_signs(const ylm__lamp_d *lamps, uint32_t n, uint32_t *order);

/* The middle of the box around n spheres, and the largest half of its edges, 1 where all are a point. Numbers of a sphere
   are `step` and `step_radius` after those of the one before. */
double ylm__tree_units(size_t n, const double *at, size_t step, const double *radius,
                       size_t step_radius, double centre[3]);

/* -- place.c ----------------------------------------------------------------------------------- */

/* The lower triangle A of a covariance xx xy xz yy yz zz, C = A A^T; columns without extent are
   zero (walls, lines, one place), and so are those of a variance up to `grain`. */
void ylm__tree_axes(const double *cov, double grain, double A[3][3]);
/* y of x = A y; 0 where A has no column. */
void ylm__tree_solve(double A[3][3], const double *x, double *y);
/*
** Places and weights of n proxies, 4 or 8. They have the moments of degree 0, 1 and 2. Moments of degree 3 are met too, but
** for four of lights in a volume, and where these would need negative weights or squares. `mirror`: 1, or -1 for the other
** tetrahedron.
*/
void ylm__tree_place(const cluster *q, double A[3][3], int n, double mirror, proxies *p);

/* -- proxy.c ----------------------------------------------------------------------------------- */

/* The proxies that cost least, of a cluster with more lights than four; A: its axes. */
void ylm__tree_choose(const cluster *q, size_t n, double A[3][3], proxies *best);
void ylm__tree_basis(const proxies *p, double A[3][3], basis *b);
/* Powers of proxies by moments m of degree 0 to 2, in parts of a weight. A power is a function of
   the place: it keeps the moments of degree 0 and 1, and of xy, xz, yz those for which the proxies
   suffice. */
void ylm__tree_share(const proxies *p, double A[3][3], basis *b, const double m[M3],
                     double power[YLM__MOST_PROXIES]);

#endif
