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

/* As ring where no pole is near: values and slopes of row j of the table at a place in its interval. */
static double plain_ring(const ylm_light_photometry *p, double gamma, double *below) {
  size_t j = ylm__photometric_place(p->angles - 1, p->angle, gamma);
  double h = p->angle[j + 1] - p->angle[j], w[4], sum = 0, f[2], c[2];
  ylm__photometric_weights((gamma - p->angle[j]) / h, h, w);
  for (size_t k = 0; k <= p->planes; k++) {
    const ylm__photometric_node *n = p->node + (k < p->planes ? k : 0) * p->angles + j;
    f[1] = w[0] * n[0].f + w[1] * n[1].f + w[2] * n[0].g + w[3] * n[1].g;
    c[1] = w[0] * n[0].c + w[1] * n[1].c + w[2] * n[0].gc + w[3] * n[1].gc;
    if (k > 0) {
      double wide = p->plane[k] - p->plane[k - 1];
      sum += stays_above(f[0], f[1], c[0], c[1], wide)
                 ? wide * ((f[0] + f[1]) / 2 + wide * (c[0] - c[1]) / 12)
                 : slice(p, gamma, k - 1, below);
    }
    f[0] = f[1], c[0] = c[1];
  }
  return sum;
}

/* The integral over C at an angle gamma; *below: how much of the turn is negative. */
static double ring(const ylm_light_photometry *p, double gamma, double *below) {
  double sum = 0;
  bool pole = false;
  *below = 0;
  if (p->planes == 1) {
    double f = ylm__photometric_at(p, gamma, 0).f;
    if (f < 0) *below = 2 * YLM_PI;
    return 2 * YLM_PI * fmax(0, f);
  }
  for (int k = 0; k < 2; k++)
    pole |= p->pole[k].on && (k ? YLM_PI - gamma : gamma) < p->pole[k].end;
  if (!pole && !p->grid.linear) return plain_ring(p, gamma, below);
  for (size_t k = 0; k < p->planes; k++) sum += slice(p, gamma, k, below);
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
  if (from <= 0 && to >= 180) return p->flux;
  return flux(p, from * (YLM_PI / 180), to * (YLM_PI / 180), &below);
}

void ylm__photometric_measure(ylm_light_photometry *p) {
  double below = 0;
  p->flux = flux(p, 0, YLM_PI, &below);
  p->clipped = below / (4 * YLM_PI);
}
