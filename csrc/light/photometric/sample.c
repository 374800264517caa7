/* sample.c - random directions of a table: an interval of gamma, then one of C, then uniform in solid angle. */
#include "table.h"
#include "ylm_math.h"

#include <math.h>

/* Every cell that light may come from has this part of the mean chance at least. */
#define LEAST 1e-2

/* A table of more numbers is looked at in the middles of its cells alone. */
#define MANY 100000

/* The mean of a cell's intensity at n^2 of its directions, and the largest of them and of its corners. */
static double look(const ylm_light_photometry *p, size_t j, size_t k, int n, double *most) {
  double from = p->plane[k], wide = p->plane[k + 1] - from, sum = 0;
  double top = cos(p->angle[j]), bottom = cos(p->angle[j + 1]);
  for (int i = 0; i < n * n; i++) {
    double z = top + (i / n + 0.5) / n * (bottom - top), c = from + (i % n + 0.5) / n * wide;
    double f = fmax(0, ylm__photometric_at(p, acos(z), c).f);
    sum += f;
    *most = fmax(*most, f);
  }
  for (int i = 0; i < 4; i++) {
    size_t l = i & 1 ? (k + 1 < p->planes ? k + 1 : 0) : k;
    *most = fmax(*most, p->grid.candela[l * p->angles + j + (size_t)(i >> 1)]);
  }
  return sum / (n * n);
}

static double solid(const ylm_light_photometry *p, size_t j, size_t k) {
  return (cos(p->angle[j]) - cos(p->angle[j + 1])) * (p->plane[k + 1] - p->plane[k]);
}

ylm_status ylm__photometric_weigh(ylm_light_photometry *p) {
  double least = LEAST * p->flux / (4 * YLM_PI), rows = 0;
  int n = p->angles * p->planes > MANY ? 1 : 3;
  p->row = ylm_alloc(p->angles, sizeof *p->row);
  p->cell = ylm_alloc(p->angles * p->planes, sizeof *p->cell);
  if (!p->row || !p->cell) return YLM_ENOMEM;
  for (size_t j = 0; j + 1 < p->angles; j++) {
    double sum = 0;
    for (size_t k = 0; k < p->planes; k++) {
      double most = 0, mean = look(p, j, k, n, &most);
      if (most > 0) sum += fmax(mean, fmax(least, LEAST * most)) * solid(p, j, k);
      p->cell[j * p->planes + k] = sum;
    }
    p->row[j] = rows += sum;
  }
  return YLM_OK;
}

/* The interval of sums upto [n] that u of 0 .. 1 of all chooses; u becomes the part of it. */
static size_t choose(size_t n, const double *upto, double *u, double *share) {
  double all = upto[n - 1], target = *u * all;
  size_t lo = ylm_interval_at(n, upto, target);
  double before = lo > 0 ? upto[lo - 1] : 0, width = upto[lo] - before;
  *share = all > 0 ? width / all : 0;
  *u = width > 0 ? fmin(fmax((target - before) / width, 0), 1 - 0x1p-53) : 0;
  return lo;
}

double ylm_light_photometry_sample(const ylm_light_photometry *p, const double u[2],
                                   double way[3]) {
  double s = u[0], t = u[1], row, cell;
  size_t j = choose(p->angles - 1, p->row, &s, &row);
  if (!(row > 0)) return 0;
  size_t k = choose(p->planes, p->cell + j * p->planes, &t, &cell);
  if (!(cell > 0)) return 0;
  double top = cos(p->angle[j]), z = top + s * (cos(p->angle[j + 1]) - top);
  double c = p->plane[k] + t * (p->plane[k + 1] - p->plane[k]), r = sqrt(fmax(0, 1 - z * z));
  way[0] = r * cos(c), way[1] = r * sin(c), way[2] = z;
  return row * cell / solid(p, j, k);
}
