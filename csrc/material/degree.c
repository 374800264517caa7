/* degree.c - how many degrees of spherical harmonics the slices of a material need. */
#include <math.h>
#include <string.h>

#include "calibration.h"
#include "kind.h"
#include "ylm_sh.h"

/* A slice f wi.z on rows of directions above the surface, their azimuths twice as many. */
typedef struct slice {
  int rows;
  double *z, *weight;                /* [rows]                   */
  float (*wi)[3], (*wo)[3], (*f)[3]; /* [2 rows]  */
  double *turn;                      /* [4 rows][2] cosine, sine: half steps between azimuths */
  double *value;                     /* [rows][2 rows][3]        */
} slice;

static void slice_free(slice *s) {
  void *all[] = {s->z, s->weight, s->wi, s->wo, s->f, s->turn, s->value};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) ylm_free(all[i]);
}

static bool slice_create(int rows, slice *s) {
  size_t n = (size_t)rows, columns = 2 * n;
  *s = (slice){.rows = rows,
               .z = ylm_alloc(n, 8),
               .weight = ylm_alloc(n, 8),
               .wi = ylm_alloc(columns, 12),
               .wo = ylm_alloc(columns, 12),
               .f = ylm_alloc(columns, 12),
               .turn = ylm_alloc(2 * columns, 16),
               .value = ylm_alloc(n * columns, 24)};
  if (!(s->z && s->weight && s->wi && s->wo && s->f && s->turn && s->value)) return false;
  ylm_sh_gauss_legendre(rows, s->z, s->weight);
  for (int i = 0; i < rows; i++) s->z[i] = (s->z[i] + 1) / 2, s->weight[i] /= 2;
  for (size_t k = 0; k < 2 * columns; k++) {
    double turn = YLM_PI * (double)k / (double)columns;
    s->turn[2 * k] = cos(turn), s->turn[2 * k + 1] = sin(turn);
  }
  return true;
}

/* Fills the slice of an eye; the integral of its square over directions and channels. */
static double fill(const ylm_material *m, double angle, slice *s) {
  size_t columns = 2 * (size_t)s->rows;
  double total = 0, *value = s->value;
  for (size_t k = 0; k < columns; k++)
    s->wo[k][0] = (float)sin(angle), s->wo[k][1] = 0, s->wo[k][2] = (float)cos(angle);
  for (int i = 0; i < s->rows; i++) {
    double z = s->z[i], r = sqrt(1 - z * z), sum = 0;
    for (size_t k = 0; k < columns; k++) {
      const double *at = s->turn + 2 * (2 * k + 1);
      s->wi[k][0] = (float)(r * at[0]), s->wi[k][1] = (float)(r * at[1]);
      s->wi[k][2] = (float)z;
    }
    ylm_material_eval(m, columns, (const float(*)[3])s->wi, (const float(*)[3])s->wo, s->f);
    for (size_t k = 0; k < columns; k++)
      for (int c = 0; c < 3; c++, value++) {
        *value = (double)s->f[k][c] * z;
        sum += *value * *value;
      }
    total += sum * s->weight[i] * 2 * YLM_PI / (double)columns;
  }
  return total;
}

/* Sums over the azimuths of each row: cosines, then sines, of order m. */
static void turns(const slice *s, int order, double *sum) {
  size_t columns = 2 * (size_t)s->rows;
  for (int i = 0; i < s->rows; i++) {
    double *to = sum + 6 * i;
    const double *value = s->value + 3 * columns * (size_t)i;
    memset(to, 0, 6 * sizeof *to);
    for (size_t k = 0; k < columns; k++) {
      const double *at = s->turn + 2 * ((2 * k + 1) * (size_t)order % (2 * columns));
      double c = at[0], q = at[1];
      for (int a = 0; a < 3; a++) to[a] += c * value[3 * k + (size_t)a];
      for (int a = 0; a < 3; a++) to[3 + a] += q * value[3 * k + (size_t)a];
    }
  }
}

/* Adds to power[l] the squares of the coefficients of order m >= 0 and -m, of degrees to `most`. */
static void add_order(const slice *s, int m, int most, const double *sum, double *p, double *before,
                      double *power) {
  double step = 2 * YLM_PI / (2 * s->rows);
  for (int l = m; l <= most; l++) {
    double c[6] = {0};
    double x = sqrt((4.0 * l * l - 1) / ((double)l * l - (double)m * m));
    double y =
        l - 1 > m ? sqrt(((l - 1.0) * (l - 1) - (double)m * m) / (4 * (l - 1.0) * (l - 1) - 1)) : 0;
    for (int i = 0; i < s->rows; i++) {
      if (l > m) {
        double next = x * (s->z[i] * p[i] - y * before[i]);
        before[i] = p[i], p[i] = next;
      }
      for (int a = 0; a < 6; a++) c[a] += p[i] * s->weight[i] * sum[6 * i + a];
    }
    for (int a = 0; a < 6; a++) power[l] += c[a] * c[a] * step * step * (m > 0 ? 2 : 1);
  }
}

/* The least degree to which the slice misses at most `error` of its norm; most + 1: none. */
static int least(const slice *s, double total, double error, int most, double *sum, double *p,
                 double *before, double *power) {
  double left = total;
  memset(power, 0, ((size_t)most + 1) * sizeof *power);
  for (int m = 0; m <= most; m++) {
    turns(s, m, sum);
    for (int i = 0; i < s->rows; i++) {
      double r2 = 1 - s->z[i] * s->z[i], start = 1 / (4 * YLM_PI);
      for (int k = 1; k <= m; k++) start *= (2 * k + 1.0) / (2 * k) * r2;
      p[i] = sqrt(start), before[i] = 0;
    }
    add_order(s, m, most, sum, p, before, power);
  }
  for (int l = 0; l <= most; l++)
    if ((left -= power[l]) <= error * error * total) return l;
  return most + 1;
}

ylm_status ylm_material_degrees(const ylm_material *m, double error, int most, size_t n,
                                const double *angle, int *degree) {
  if (most < 0 || most > YLM_MATERIAL_DEGREES || !(error > 0 && error < 1)) return YLM_ERANGE;
  double *work = ylm_alloc(8 * DEGREE_MOST_ROWS + (size_t)most + 1, sizeof *work);
  ylm_status s = work ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    double total = 0, finer = 0;
    for (int rows = DEGREE_LEAST_ROWS; s == YLM_OK && rows <= DEGREE_MOST_ROWS; rows *= 2) {
      slice x;
      if (!slice_create(rows, &x)) s = YLM_ENOMEM;
      if (s == YLM_OK) finer = fill(m, angle[i], &x);
      bool settled = fabs(finer - total) <= 0.1 * error * error * finer || rows == DEGREE_MOST_ROWS;
      total = finer;
      if (s == YLM_OK && settled)
        degree[i] = least(&x, total, error, most, work, work + 6 * DEGREE_MOST_ROWS,
                          work + 7 * DEGREE_MOST_ROWS, work + 8 * DEGREE_MOST_ROWS);
      slice_free(&x);
      if (settled) break;
    }
  }
  ylm_free(work);
  return s;
}
