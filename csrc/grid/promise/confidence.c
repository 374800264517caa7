/* confidence.c - what random points that were compared say of all points. */
#include "../bake/panel.h"

/* By the binomial distribution: exact (Clopper and Pearson 1934). */
int ylm__confidence_allowed(size_t n, double share, double doubt) {
  double term = exp((double)n * log1p(-share)), sum = term;
  int k = -1;
  while (sum <= doubt && (size_t)(k + 1) < n) {
    k++;
    term *= (double)(n - (size_t)k) / (double)(k + 1) * (share / (1 - share));
    sum += term;
  }
  return k;
}
