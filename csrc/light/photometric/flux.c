/* flux.c - the flux of a table: Gauss-Legendre along gamma, the integral of the cubics around. */
#include "table.h"

#include <math.h>

const double ylm__photometric_gauss[YLM__PHOTOMETRIC_NODES][2] = {
    {0.033765242898423975, 0.085662246189585178}, {0.16939530676686776, 0.18038078652406930},
    {0.38069040695840156, 0.23395696728634552},   {0.61930959304159844, 0.23395696728634552},
    {0.83060469323313224, 0.18038078652406930},   {0.96623475710157603, 0.085662246189585178}};

/* The cubic between two planes does not go below 0: Bezier's control points do not. */
static bool stays_above(double f0, double f1, double c0, double c1, double h) {
  return f0 >= 0 && f1 >= 0 && f0 + c0 * h / 3 >= 0 && f1 - c1 * h / 3 >= 0;
}

/* The integral over C between planes k and k+1 of what is above 0, and of what is below. */
static double slice(const ylm_light_photometry *p, double gamma, size_t k, double *below) {
  double from = p->plane[k], h = p->plane[k + 1] - from, sum = 0;
  for (int i = 0; i < YLM__PHOTOMETRIC_NODES; i++) {
    const double *node = ylm__photometric_gauss[i];
    double f = ylm__photometric_at(p, gamma, from + h * node[0]).f;
    if (f > 0)
      sum += f * node[1];
    else if (f < 0)
      *below += node[1] * h;
  }
  return sum * h;
}

/* The integral over C at an angle gamma; *below: how much of the turn is negative. */
static double ring(const ylm_light_photometry *p, double gamma, double *below) {
  double sum = 0;
  *below = 0;
  if (p->planes == 1) {
    double f = ylm__photometric_at(p, gamma, 0).f;
    if (f < 0) *below = 2 * YLM_PI;
    return 2 * YLM_PI * fmax(0, f);
  }
  bool pole = false;
  for (int k = 0; k < 2; k++)
    pole |= p->pole[k].on && (k ? YLM_PI - gamma : gamma) < p->pole[k].end;
  ylm__photometric_value a = {0}, b;
  for (size_t k = 0; k < p->planes; k++, a = b) {
    double h = p->plane[k + 1] - p->plane[k];
    if (k == 0) a = ylm__photometric_at(p, gamma, p->plane[0]);
    b = ylm__photometric_at(p, gamma, p->plane[k + 1 < p->planes ? k + 1 : 0]);
    bool cubic = !pole && stays_above(a.f, b.f, a.c, b.c, h);
    if (cubic && !p->grid.linear)
      sum += h * ((a.f + b.f) / 2 + h * (a.c - b.c) / 12);
    else
      sum += slice(p, gamma, k, below);
  }
  return sum;
}

/* The flux between two angles without nodes between them. */
static double zone(const ylm_light_photometry *p, double from, double to, double *below) {
  double sum = 0;
  for (int i = 0; i < YLM__PHOTOMETRIC_NODES; i++) {
    const double *node = ylm__photometric_gauss[i];
    double gamma = from + (to - from) * node[0], turn;
    double weight = (to - from) * node[1] * sin(gamma);
    sum += weight * ring(p, gamma, &turn);
    *below += weight * turn;
  }
  return sum;
}

/* Between two angles in one interval of the table: at poles it has two parts. */
static double interval(const ylm_light_photometry *p, double from, double to, double *below) {
  for (int k = 0; k < 2; k++) {
    double middle = k ? YLM_PI - p->pole[k].end / 2 : p->pole[k].end / 2;
    if (p->pole[k].on && middle > from && middle < to)
      return zone(p, from, middle, below) + zone(p, middle, to, below);
  }
  return zone(p, from, to, below);
}

static double flux(const ylm_light_photometry *p, double from, double to, double *below) {
  double sum = 0;
  for (size_t j = 0; j + 1 < p->angles; j++) {
    double a = fmax(from, p->angle[j]), b = fmin(to, p->angle[j + 1]);
    if (b > a) sum += interval(p, a, b, below);
  }
  return sum;
}

double ylm_light_photometry_flux(const ylm_light_photometry *p, double from, double to) {
  double below = 0;
  return flux(p, from * (YLM_PI / 180), to * (YLM_PI / 180), &below);
}

void ylm__photometric_measure(ylm_light_photometry *p) {
  double below = 0;
  p->flux = flux(p, 0, YLM_PI, &below);
  p->clipped = below / (4 * YLM_PI);
}
