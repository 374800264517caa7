/* merl.c - reflectance from MERL's bins: lookups, and the kind that is read from a file. */
#include "merl.h"

#include <math.h>

#include "kind.h"
#include "ylm_sets.h"

/* -- places ----------------------------------------------------------------- */

/* Of a pair, by the angles of the light's direction d in the frame of the half vector. */
static void place(int phis, const float wi[3], const float wo[3], float out[3]) {
  double h[3], v[3];
  for (int a = 0; a < 3; a++) {
    h[a] = (double)wi[a] + wo[a];
    v[a] = (double)wi[a] - wo[a];
  }
  double flat = sqrt(h[0] * h[0] + h[1] * h[1]), length = sqrt(flat * flat + h[2] * h[2]);
  double theta_h = atan2(flat, h[2]);
  double theta_d = atan2(sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), length);
  /* d has its x axis down the half vector's meridian. */
  double phi = flat > 0 ? atan2(v[1] * h[0] - v[0] * h[1], -v[2] * length) : atan2(v[1], v[0]);
  if (phi < 0) phi += phis == MERL_PHI_D ? YLM_PI : 2 * YLM_PI;
  out[0] = (float)(MERL_THETA_H * sqrt(theta_h * (2 / YLM_PI)));
  out[1] = (float)(MERL_THETA_D * theta_d * (2 / YLM_PI));
  out[2] = (float)(MERL_PHI_D * phi / YLM_PI);
}

static void places(int phis, size_t n, const float (*wi)[3], const float (*wo)[3],
                   merl_places *out) {
  for (size_t k = 0; k < n; k++) {
    float at[3];
    place(phis, wi[k], wo[k], at);
    out->theta_h[k] = at[0];
    out->theta_d[k] = at[1];
    out->phi_d[k] = at[2];
  }
}

YLM_KERNEL_CHOICE(merl_places_fn, ylm__merl_places, ylm_k_merl_places, places);

bool ylm_material_merl_centre(int theta_h, int theta_d, int phi_d, double wi[3], double wo[3]) {
  double root = (theta_h + 0.5) / MERL_THETA_H, th = root * root * YLM_PI / 2;
  double td = (theta_d + 0.5) / MERL_THETA_D * YLM_PI / 2, pd = (phi_d + 0.5) / MERL_PHI_D * YLM_PI;
  double d[3] = {sin(td) * cos(pd), sin(td) * sin(pd), cos(td)};
  double x = cos(th) * d[0], z = -sin(th) * d[0];
  double hx = sin(th) * d[2], hz = cos(th) * d[2];
  wi[0] = hx + x, wi[1] = d[1], wi[2] = hz + z;
  wo[0] = hx - x, wo[1] = -d[1], wo[2] = hz - z;
  return wi[2] > 0 && wo[2] > 0;
}

/* -- lookups ---------------------------------------------------------------- */

static int clamp(int i, int n) { return i < 0 ? 0 : i < n ? i : n - 1; }

static size_t row_of(const merl_table *t, int theta_h, int theta_d) {
  return ((size_t)theta_h * MERL_THETA_D + (size_t)theta_d) * (size_t)t->phis;
}

/* The bin that holds a place. */
static const float *nearest(const merl_table *t, float theta_h, float theta_d, float phi_d) {
  size_t row = row_of(t, clamp((int)theta_h, MERL_THETA_H), clamp((int)theta_d, MERL_THETA_D));
  return t->bin[row + (size_t)clamp((int)phi_d, t->phis)];
}

/* The eight centres around a place: rows of bins, two bins in them, and how far the place is from the
   first towards the second. */
typedef struct cell {
  const merl_bin *row[4];
  int bin[2];
  float theta_h, theta_d, phi_d;
} cell;

/* The centre before a place x among n bins; *t: the way to the next. */
static int centre(float x, float *t) {
  int before = (int)(x + 0.5f) - 1;
  *t = x - 0.5f - (float)before;
  return before;
}

static cell cell_of(const merl_table *t, float theta_h, float theta_d, float phi_d) {
  cell c;
  int h = centre(theta_h, &c.theta_h), d = centre(theta_d, &c.theta_d), p = centre(phi_d, &c.phi_d);
  for (int k = 0; k < 4; k++)
    c.row[k] =
        t->bin + row_of(t, clamp(h + (k >> 1), MERL_THETA_H), clamp(d + (k & 1), MERL_THETA_D));
  c.bin[0] = p < 0 ? t->phis - 1 : clamp(p, t->phis);
  c.bin[1] = p + 1 < t->phis ? clamp(p + 1, t->phis) : 0;
  return c;
}

typedef float four __attribute__((vector_size(16), may_alias));

/* Between the centres; missing bins have no share. False: all are missing. */
static bool blend_cell(const cell *c, float f[3]) {
  four sum = {0};
  for (int k = 0; k < 4; k++) {
    float w = (k & 2 ? c->theta_h : 1 - c->theta_h) * (k & 1 ? c->theta_d : 1 - c->theta_d);
    four a = *(const four *)c->row[k][c->bin[0]], b = *(const four *)c->row[k][c->bin[1]];
    sum += (w * (1 - c->phi_d) * a[3]) * a + (w * c->phi_d * b[3]) * b;
  }
  if (!(sum[3] > 1e-6f)) return false;
  for (int i = 0; i < 3; i++) f[i] = sum[i] / sum[3];
  return true;
}

/* f at n <= MERL_BLOCK places. All memory is asked for before any of it is used: tables are larger
   than caches near the core. */
static void look_up(const merl_table *t, const merl_places *at, size_t n, float (*f)[3]) {
  cell cells[MERL_BLOCK];
  if (t->linear)
    for (size_t k = 0; k < n; k++) {
      cells[k] = cell_of(t, at->theta_h[k], at->theta_d[k], at->phi_d[k]);
      for (int i = 0; i < 4; i++) __builtin_prefetch(cells[k].row[i][cells[k].bin[0]]);
    }
  for (size_t k = 0; k < n; k++) {
    if (t->linear && blend_cell(cells + k, f[k])) continue;
    const float *bin = nearest(t, at->theta_h[k], at->theta_d[k], at->phi_d[k]);
    for (int c = 0; c < 3; c++) f[k][c] = bin[c];
  }
}

static void eval(const void *p, size_t n, const float (*wi)[3], const float (*wo)[3],
                 float (*f)[3]) {
  const merl_table *t = p;
  merl_places_fn *find = ylm__merl_places();
  merl_places at;
  for (size_t first = 0; first < n; first += MERL_BLOCK) {
    size_t some = n - first < MERL_BLOCK ? n - first : MERL_BLOCK;
    find(t->phis, some, wi + first, wo + first, &at);
    look_up(t, &at, some, f + first);
    for (size_t k = first; k < first + some; k++)
      if (!(wi[k][2] > 0 && wo[k][2] > 0)) f[k][0] = f[k][1] = f[k][2] = 0;
  }
}

static void pdf(const void *p, size_t n, const float (*wi)[3], const float (*wo)[3], float *pdf) {
  const merl_table *t = p;
  for (size_t k = 0; k < n; k++)
    pdf[k] = wi[k][2] > 0 && wo[k][2] > 0 ? ylm__lobe_pdf(t->lobe, wi[k], wo[k]) : 0;
}

static void sample(const void *p, size_t n, const float (*wo)[3], const float (*u)[3],
                   float (*wi)[3], float (*weight)[3], float *pdf) {
  const merl_table *t = p;
  for (size_t k = 0; k < n; k++) {
    ylm__lobe_sample(t->lobe, wo[k], u[k], wi[k]);
    pdf[k] = wi[k][2] > 0 && wo[k][2] > 0 ? ylm__lobe_pdf(t->lobe, wi[k], wo[k]) : 0;
  }
  eval(t, n, wi, wo, weight);
  for (size_t k = 0; k < n; k++)
    for (int c = 0; c < 3; c++) weight[k][c] = pdf[k] > 0 ? weight[k][c] * wi[k][2] / pdf[k] : 0;
}

const material_kernels *ylm__merl_kernels(void) {
  static const material_kernels kernels = {eval, sample, pdf};
  return &kernels;
}

bool ylm__merl_isotropic(const ylm_material *m) {
  (void)m;
  return true;
}

/* -- the kind --------------------------------------------------------------- */

static ylm_status check(const float *x, ylm_error *e) {
  if (x[0] != 0 && x[0] != 1)
    return ylm_fail(e, YLM_EDOMAIN, "interpolation must be 0 (nearest) or 1 (linear), got %g",
                    (double)x[0]);
  return YLM_OK;
}

static ylm_status load(ylm_material *m, const unsigned char *bytes, size_t size, const char *name,
                       ylm_error *e) {
  merl_table *t;
  ylm_status s = ylm__merl_read(bytes, size, name, &t, &m->bytes, e);
  if (s != YLM_OK) return s;
  t->linear = m->x[0] == 1;
  m->table = t;
  return YLM_OK;
}

const material_kind ylm__material_merl = {.name = "merl",
                                          .numbers = 1,
                                          .check = check,
                                          .load = load,
                                          .facts = ylm__merl_facts,
                                          .isotropic = ylm__merl_isotropic,
                                          .kernels = ylm__merl_kernels};
