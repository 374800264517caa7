/* table.h - a table of intensities: nodes of splines, poles. Private to csrc/light. */
#ifndef YLM_LIGHT_PHOTOMETRIC_TABLE_H
#define YLM_LIGHT_PHOTOMETRIC_TABLE_H

#include <stdatomic.h>

#include "ylm_light_photometry.h"
#include "ylm_math.h"

/* A value and its derivatives by gamma and C. */
typedef struct ylm__photometric_node {
  double f, g, c, gc;
} ylm__photometric_node;

/* The polynomial about a pole: with r the sine of the angle to the pole,
   even[0] + even[1] r^2 + even[2] r^4
   + (odd[0][0] r + odd[0][1] r^3) cos C + (odd[1][0] r + odd[1][1] r^3) sin C
   + (two[0][0] r^2 + two[0][1] r^4) cos 2C + (two[1][0] r^2 + two[1][1] r^4) sin 2C */
typedef struct ylm__photometric_pole {
  bool on;
  double
      end; /* angle of the first ring: the polynomial alone holds to half of it, the spline from there on */
  double even[3], odd[2][2], two[2][2];
} ylm__photometric_pole;

struct ylm_light_photometry {
  atomic_uint references;
  double name;
  ylm_light_photometry_grid grid; /* its arrays are this table's */
  size_t angles, planes;
  double *angle, *plane;       /* radians; [planes + 1], the last a turn behind the first */
  ylm__photometric_node *node; /* [planes][angles] */
  ylm__photometric_pole pole[2];
  double peak, flux, clipped;
  double *row, *cell;         /* sums of weights for samples: [angles - 1], [angles - 1][planes] */
  ylm_light_photometry *next; /* in the list of all */
};

/* f, and its derivatives by gamma, C, gamma twice, gamma and C, C twice, of the spline or the polynomial; values may
   be negative. eval.c */
typedef struct ylm__photometric_value {
  double f, g, c, gg, gc, cc;
} ylm__photometric_value;
ylm__photometric_value ylm__photometric_at(const ylm_light_photometry *p, double gamma, double c);
/* The intensity in a unit direction of the lamp's frame. eval.c */
double ylm__photometric_intensity(const ylm_light_photometry *p, const double way[3]);

/* Weights of both values, then of both slopes, of a cubic at a part t of an interval h (Hermite). eval.c */
void ylm__photometric_weights(double t, double h, double w[4]);

/* Fills node and pole from the grid; YLM_ENOMEM. spline.c */
ylm_status ylm__photometric_spline(ylm_light_photometry *p);
/* The polynomial of pole k, 0 or 1; slopes [2] along C0 and C90 there. pole.c */
void ylm__photometric_fit_pole(ylm_light_photometry *p, int k, double slope[2]);
/* The weight of the spline against a pole's polynomial at an angle t to the pole, and its derivatives. pole.c */
void ylm__photometric_blend(const ylm__photometric_pole *pole, double t, double w[3]);
/* The polynomial at an angle t to the pole, derivatives by t and C. pole.c */
ylm__photometric_value ylm__photometric_polynomial(const ylm__photometric_pole *pole, double t,
                                                   double c);

/* Fills flux and clipped. flux.c */
void ylm__photometric_measure(ylm_light_photometry *p);
/* Fills row and cell; YLM_ENOMEM. sample.c */
ylm_status ylm__photometric_weigh(ylm_light_photometry *p);

/* The last of n increasing numbers that is not above x; the first, where all are. */
static inline size_t ylm__photometric_place(size_t n, const double *x, double at) {
  size_t upto = ylm_count_upto(n, x, at);
  return upto > 0 ? upto - 1 : 0;
}

/* Gauss-Legendre nodes and weights on 0 .. 1. */
enum { YLM__PHOTOMETRIC_NODES = 6 };
extern const double ylm__photometric_gauss[YLM__PHOTOMETRIC_NODES][2];

#endif
