/* zonal.c - glossy points by zonal lobes, lamp by lamp. */
#include "ylm_rival.h"
#include "ylm_vector.h"

#include <math.h>

#define LMAX 60

typedef struct job {
  const ylm_rival_points *p;
  const ylm_rival_lamps *lamps;
  float *out;
} job;

/* w_l (2l+1)/(4 pi) P_l(r.d) for all l, of a sphere with (radius/distance)^2 = s2. */
static void lamp_terms(int lmax, double s2, double cosine, double *w) {
  double alpha = sqrt(fmax(0, 1 - s2)), p0 = 1, p1 = cosine, d0 = 0, d1 = 1, a0 = 1, a1 = alpha;
  w[0] = s2 >= 1 ? 1 : s2 / (2 * (1 + alpha)); /* inside, the whole sphere shines */
  for (int l = 1; l <= lmax; l++) {
    w[l] = s2 >= 1 ? 0 : s2 * d1 / (l * (l + 1)) * (2 * l + 1) / 2 * p1;
    double p = ((2 * l + 1) * cosine * p1 - l * p0) / (l + 1), d = d0 + (2 * l + 1) * a1;
    double a = ((2 * l + 1) * alpha * a1 - l * a0) / (l + 1);
    p0 = p1, p1 = p, d0 = d1, d1 = d, a0 = a1, a1 = a;
  }
}

/* The lobes of the three channels at a cosine of elevation: [3][lmax+1]. */
static void lobes_at(const ylm_rival_points *p, size_t lobe, double cosine, double *z) {
  size_t row = 3 * ((size_t)p->lmax + 1);
  double at = acos(fmin(1, fmax(0, cosine))) / (YLM_PI / 2) * (double)(p->rows - 1);
  size_t k = (size_t)fmin(at, (double)(p->rows - 2));
  const double *a = p->zonal + (lobe * p->rows + k) * row, t = at - (double)k;
  for (size_t i = 0; i < row; i++) z[i] = (1 - t) * a[i] + t * a[row + i];
}

static void shade_point(const job *j, size_t i) {
  const ylm_rival_points *p = j->p;
  double v[3], r[3], n[3], z[3 * (LMAX + 1)], w[LMAX + 1], out[3] = {0}, length = 0;
  for (int a = 0; a < 3; a++) {
    n[a] = (double)p->normal[i][a];
    v[a] = p->eye[a] - (double)p->position[i][a];
    length += v[a] * v[a];
  }
  for (int a = 0; a < 3; a++) v[a] /= length > 0 ? sqrt(length) : 1;
  double up = ylm_dot3d(v, n);
  for (int a = 0; a < 3; a++) r[a] = 2 * up * n[a] - v[a];
  lobes_at(p, (size_t)p->lobe[i], up, z);
  for (size_t k = 0; k < j->lamps->n; k++) {
    double d[3], dd = 0, radius = (double)j->lamps->radius[k];
    for (int a = 0; a < 3; a++) {
      d[a] = (double)j->lamps->at[3 * k + (size_t)a] - (double)p->position[i][a];
      dd += d[a] * d[a];
    }
    for (int a = 0; a < 3; a++) d[a] /= dd > 0 ? sqrt(dd) : 1;
    double cosine = ylm_dot3d(n, d);
    if (cosine <= 0) continue;
    lamp_terms(p->lmax, dd > 0 ? radius * radius / dd : 1, fmin(1, fmax(-1, ylm_dot3d(r, d))), w);
    for (int c = 0; c < 3; c++) {
      double sum = 0;
      for (int l = 0; l <= p->lmax; l++) sum += z[c * (p->lmax + 1) + l] * w[l];
      out[c] += cosine * sum * (double)j->lamps->radiance[3 * k + (size_t)c];
    }
  }
  for (int c = 0; c < 3; c++) j->out[3 * i + (size_t)c] = (float)out[c];
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  for (size_t i = begin; i < end; i++)
    if (j->p->lobe[i] >= 0) shade_point(j, i);
  return YLM_OK;
}

ylm_status ylm_rival_zonal(const ylm_rival_points *p, const ylm_rival_lamps *lamps, int threads,
                           float *out) {
  if (p->lmax < 0 || p->lmax > LMAX || p->rows < 2) return YLM_ERANGE;
  for (size_t i = 0; i < p->n; i++)
    if (!(p->lobe[i] < (float)p->lobes)) return YLM_ERANGE;
  job j = {p, lamps, out};
  return ylm_parallel(p->n, 64, threads, run, &j, NULL, NULL);
}
