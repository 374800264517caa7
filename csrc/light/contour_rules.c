/* contour_rules.c - Gauss-Legendre rules for rims of flat lights. */
#include "contour.h"

#include <math.h>

void ylm__gauss(int n, double *x, double *w) {
  for (int i = 0; i < n; i++) {
    double t = cos(M_PI * (i + 0.75) / (n + 0.5)), derivative = 1;
    for (int pass = 0; pass < 20; pass++) {
      double a = 1, b = 0;
      for (int k = 1; k <= n; k++) {
        double c = ((2 * k - 1) * t * a - (k - 1) * b) / k;
        b = a;
        a = c;
      }
      derivative = n * (t * a - b) / (t * t - 1);
      double step = a / derivative;
      t -= step;
      if (fabs(step) < 1e-16) break;
    }
    x[i] = t;
    w[i] = 2 / ((1 - t * t) * derivative * derivative);
  }
}

void ylm__rules_make(ylm__rules *r) {
  static const int length[YLM__RULES] = {12, 16, 24, 32, 48, 64, YLM__MOST_NODES};
  for (int i = 0; i < YLM__RULES; i++) {
    r->length[i] = length[i];
    ylm__gauss(length[i], r->x[i], r->w[i]);
  }
}

int ylm__rule_for(const ylm__rules *r, int l, double angle) {
  int needed = (int)(l * angle * 0.35) + 11, rule = 0;
  while (rule < YLM__RULES - 1 && r->length[rule] < needed) rule++;
  return rule;
}
