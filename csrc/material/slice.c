/* slice.c - the slice f wi.z of an eye in spherical harmonics, by quadrature about the mirror direction. */
#include "slice.h"

#include <math.h>

#include "slice_kernel.h"
#include "ylm_sets.h"
#include "ylm_sh.h"

#define MOST (SLICE_MOST_NODES * SLICE_WIDE)

/* Places in parts of the angle from the mirror direction to the horizon, and what they count. */
typedef struct rule {
  int nodes; /* 0: not made yet */
  double part[SLICE_MOST_NODES], weight[SLICE_MOST_NODES];
} rule;

struct slice_room {
  int lmax, entries;
  const slice_kernels *kernels;
  rule rules[SLICE_RULES];
  slice_recurrence recurrence;
  ylm_sh_rotator *rotator;
  float wi[MOST][3], wo[MOST][3], f[MOST][3];
  double x[MOST], s[MOST], z[MOST], measure[MOST], value[3 * MOST];
  double *sum;            /* [3][entries][SLICE_WIDE] */
  double *before, *about; /* [3][count]: of half the nodes; in the mirror direction's frame */
};

static const slice_kernels plain = {slice_places, slice_sums};
static YLM_KERNEL_CHOICE(const slice_kernels, kernels_now, ylm_k_material_slice, &plain);

static bool make_recurrence(int lmax, slice_recurrence *r) {
  size_t entries = (size_t)(lmax + 1) * (size_t)(lmax + 2) / 2;
  double *p = ylm_alloc(entries, sizeof *p);
  *r = (slice_recurrence){lmax, ylm_alloc((size_t)lmax + 1, sizeof(double)),
                          ylm_alloc(entries, sizeof(double)), ylm_alloc(entries, sizeof(double))};
  bool ok = p && r->first && r->a && r->b;
  if (ok) ylm_sh_legendre(lmax, 0, 1, p);
  for (int m = 0, k = 0; ok && m <= lmax; m++) {
    r->first[m] = p[m * (m + 1) / 2 + m];
    for (int l = m; l <= lmax; l++, k++) { /* to degree l + 1 */
      double n = l + 1, d = n * n - (double)m * m;
      r->a[k] = sqrt((4 * n * n - 1) / d);
      r->b[k] =
          l == m ? 0 : sqrt(((double)l * l - (double)m * m) * (2 * n + 1) / (d * (2 * n - 3)));
    }
  }
  ylm_free(p);
  return ok;
}

slice_room *ylm__slice_room(int lmax) {
  slice_room *r = ylm_alloc_zero(1, sizeof *r);
  size_t count = ylm_sh_count(lmax);
  if (!r) return NULL;
  r->lmax = lmax;
  r->entries = (lmax + 1) * (lmax + 2) / 2;
  r->kernels = kernels_now();
  r->sum = ylm_alloc(3 * SLICE_WIDE * (size_t)r->entries, sizeof *r->sum);
  r->before = ylm_alloc(3 * count, sizeof *r->before);
  r->about = ylm_alloc(3 * count, sizeof *r->about);
  if (make_recurrence(lmax, &r->recurrence) && r->sum && r->before && r->about &&
      ylm_sh_rotator_create(lmax, &r->rotator, NULL) == YLM_OK)
    return r;
  ylm__slice_room_free(r);
  return NULL;
}

void ylm__slice_room_free(slice_room *r) {
  if (!r) return;
  ylm_free(r->recurrence.first);
  ylm_free(r->recurrence.a);
  ylm_free(r->recurrence.b);
  ylm_sh_rotator_free(r->rotator);
  ylm_free(r->sum);
  ylm_free(r->before);
  ylm_free(r->about);
  ylm_free(r);
}

static const rule *rule_of(slice_room *r, int nodes) {
  rule *to = r->rules;
  for (int n = SLICE_LEAST_NODES; n < nodes; n *= 2) to++;
  if (to->nodes) return to;
  to->nodes = nodes;
  ylm_sh_gauss_legendre(nodes, to->part, to->weight);
  for (int i = 0; i < nodes; i++) {
    double u = SLICE_CROWD * (to->part[i] + 1) / 2;
    to->part[i] = sinh(u) / sinh(SLICE_CROWD);
    to->weight[i] *= SLICE_CROWD * cosh(u) / sinh(SLICE_CROWD) / 2;
  }
  return to;
}

/* Values of a channel times what they count, and the integral of the squares of what `of` is about. */
static void weigh(slice_room *r, int n, ylm_material_table_slice of, double step, double total[3]) {
  for (int c = 0; c < 3; c++) {
    double *value = r->value + c * n, sum = 0;
    for (int i = 0; i < n; i++) {
      double v = (double)r->f[i][c] * (of == YLM_MATERIAL_TABLE_BARE ? 1 : r->z[i]);
      double part = r->measure[i] * step * v;
      sum += part * v;
      value[i] = of == YLM_MATERIAL_TABLE_FIT ? part * r->z[i] : part;
    }
    total[c] += sum;
  }
}

/* Adds what is summed at half planes to coefficients about the mirror direction. */
static void gather(slice_room *r, const slice_planes *p) {
  size_t count = ylm_sh_count(r->lmax);
  double cm[SLICE_WIDE], sm[SLICE_WIDE];
  for (int q = 0; q < SLICE_WIDE; q++) cm[q] = 1, sm[q] = 0;
  for (int m = 0, k = 0; m <= r->lmax; m++) {
    for (int l = m; l <= r->lmax; l++, k++)
      for (int c = 0; c < 3; c++) {
        const double *sum = r->sum + (size_t)(c * r->entries + k) * SLICE_WIDE;
        double a = 0, b = 0;
        for (int q = 0; q < SLICE_WIDE; q++) a += sum[q] * cm[q], b += sum[q] * sm[q];
        double *to = r->about + (size_t)c * count + l * l + l;
        to[m] += a;
        if (m) to[-m] += b;
      }
    for (int q = 0; q < SLICE_WIDE; q++) {
      double next = cm[q] * p->cos_phi[q] - sm[q] * p->sin_phi[q];
      sm[q] = sm[q] * p->cos_phi[q] + cm[q] * p->sin_phi[q];
      cm[q] = next;
    }
  }
}

/* The slice by so many nodes, about the mirror direction. */
static void integrate(const ylm_material *m, slice_room *r, int nodes, double angle, double azimuth,
                      ylm_material_table_slice of, material_slice *out) {
  const rule *by = rule_of(r, nodes);
  bool symmetric = ylm_material_isotropic(m);
  int planes = symmetric ? nodes : 2 * nodes, n = nodes * SLICE_WIDE;
  size_t count = ylm_sh_count(r->lmax);
  slice_nodes at = {r->wi, r->x, r->s, r->z, r->measure};
  slice_planes p = {.nodes = nodes,
                    .part = by->part,
                    .weight = by->weight,
                    .cosine = cos(angle),
                    .sine = sin(angle),
                    .turn = {cos(azimuth), sin(azimuth)}};
  for (int i = 0; i < n; i++) {
    r->wo[i][0] = (float)(p.sine * p.turn[0]);
    r->wo[i][1] = (float)(p.sine * p.turn[1]);
    r->wo[i][2] = (float)p.cosine;
  }
  for (size_t k = 0; k < 3 * count; k++) r->about[k] = 0;
  for (int c = 0; c < 3; c++) out->total[c] = 0;
  for (int k = 0; k < planes; k += SLICE_WIDE) {
    for (int q = 0; q < SLICE_WIDE; q++) {
      double phi = YLM_PI * (k + q + 0.5) / nodes;
      p.cos_phi[q] = cos(phi), p.sin_phi[q] = sin(phi);
      p.end[q] = atan2(p.cosine, -p.cos_phi[q] * p.sine);
    }
    r->kernels->places(&p, &at);
    ylm_material_eval(m, (size_t)n, (const float(*)[3])r->wi, (const float(*)[3])r->wo, r->f);
    weigh(r, n, of, YLM_PI / nodes * (symmetric ? 2 : 1), out->total);
    memset(r->sum, 0, 3 * SLICE_WIDE * (size_t)r->entries * sizeof *r->sum);
    r->kernels->sums(&r->recurrence, nodes, r->x, r->s, r->value, r->sum);
    gather(r, &p);
  }
  if (symmetric) /* the other half has the other sign */
    for (size_t c = 0; c < 3; c++)
      for (int l = 1; l <= r->lmax; l++)
        for (int q = 1; q <= l; q++) r->about[c * count + (size_t)(l * l + l - q)] = 0;
}

ylm_status ylm__slice(const ylm_material *m, slice_room *r, double angle, double azimuth,
                      ylm_material_table_slice of, material_slice *out) {
  size_t count = ylm_sh_count(r->lmax);
  const double c = cos(angle), s = sin(angle), frame[9] = {c, 0, -s, 0, 1, 0, s, 0, c};
  integrate(m, r, SLICE_LEAST_NODES, angle, azimuth, of, out);
  for (int nodes = 2 * SLICE_LEAST_NODES; nodes <= SLICE_MOST_NODES; nodes *= 2) {
    double change = 0, total = 0;
    memcpy(r->before, r->about, 3 * count * sizeof *r->before);
    integrate(m, r, nodes, angle, azimuth, of, out);
    for (size_t k = 0; k < 3 * count; k++)
      change += (r->about[k] - r->before[k]) * (r->about[k] - r->before[k]);
    for (int k = 0; k < 3; k++) total += out->total[k];
    if (change <= SLICE_SETTLED * SLICE_SETTLED * total) break;
  }
  return ylm_sh_rotate(r->rotator, frame, r->lmax, YLM_DOUBLE, 3, r->about, out->c, 1, NULL, NULL);
}
