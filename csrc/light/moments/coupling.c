/*
** coupling.c - integrals of two spherical harmonics of neighbouring degree and a direction cosine.
*/
#include "../light.h"

#include <math.h>
#include <stdlib.h>

double ylm__coupling(int a, int k, int p, int m) {
  int np = abs(p), nm = abs(m);
  double D = (2.0 * k + 1) * (2.0 * k + 3);
  if (k < 0 || np > k || nm > k + 1) return 0;
  if (a == 2) return p == m ? sqrt(((k + 1.0) * (k + 1.0) - (double)m * m) / D) : 0;
  double c;
  if (nm == np + 1)
    c = -0.5 * sqrt((k + np + 1.0) * (k + np + 2.0) / D) * (np == 0 ? M_SQRT2 : 1);
  else if (nm == np - 1)
    c = 0.5 * sqrt((k - np + 1.0) * (k - np + 2.0) / D) * (nm == 0 ? M_SQRT2 : 1);
  else
    return 0;
  bool cosine = p >= 0, same = cosine == (m >= 0);
  if (a == 0) return same ? c : 0;
  if (same) return 0;
  return (nm > np) == cosine ? c : -c;
}
