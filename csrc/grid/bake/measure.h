/* measure.h - the error that a tolerance is of: of coefficients, or of irradiance. */
#ifndef YLM_GRID_MEASURE_H
#define YLM_GRID_MEASURE_H

#include "../grid.h"

typedef struct measure {
  ylm_grid_measure kind;
  int lmax, channels;
  double floor; /* of coefficients: smaller norms count as this one */
  /* Of irradiance, over occupied points: */
  double mean[3]; /* of its size, by channel */
  double norm;    /* of coefficients' norms */
  bool squares;   /* an error's square is over light times its mean */
} measure;

measure ylm__measure_of(const ylm_grid_form *form);
/* The irradiance on a surface with normal n, by channel: A(l) Y(n) . L. */
void ylm__measure_irradiance(const measure *m, const float *row, const float n[3], double out[3]);
/* The error of coefficients; of irradiance that of a surface with normal n. */
double ylm__measure_error(const measure *m, const float *row, const float *exact, const float n[3]);
/* The error where no normal is known: of irradiance the root of its mean square over all. */
double ylm__measure_anywhere(const measure *m, const float *row, const float *exact);

#endif
