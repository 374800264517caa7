/* rotate.c - rotation of coefficient vectors; kernels in rotate.isa.c. */
#include "ylm_sh.h"

#include <math.h>
#include <string.h>

#include "rotate.h"

/* -- the recurrence ------------------------------------------------------------------------------
 */

typedef long double real;

/* Elements of all blocks of degrees < l. */
static size_t blocks_before(int l) {
  size_t k = (size_t)l;
  return k * (2 * k - 1) * (2 * k + 1) / 3;
}

/* P of Ivanic & Ruedenberg for element (a, b); r1: degree 1 [3][3]; before: degree l-1. */
static real combine(int i, int a, int b, int l, const real *r1, const real *before) {
  const real *row = before + (size_t)(a + l - 1) * (size_t)(2 * l - 1) + (l - 1);
  const real *r = r1 + (i + 1) * 3 + 1;
  if (b == l) return r[1] * row[l - 1] - r[-1] * row[-l + 1];
  if (b == -l) return r[1] * row[-l + 1] + r[-1] * row[l - 1];
  return r[0] * row[b];
}

/* Element (m, n) of degree l from degrees 1 and l-1. */
static real element(int l, int m, int n, const real *r1, const real *before) {
  int am = m < 0 ? -m : m;
  real d = n == l || n == -l ? (real)(2 * l) * (2 * l - 1) : (real)(l + n) * (l - n), sum = 0;
  real u = sqrtl((real)(l + m) * (l - m) / d);
  real v = 0.5L * sqrtl((m == 0 ? 2 : 1) * (real)(l + am - 1) * (l + am) / d) * (m == 0 ? -1 : 1);
  real w = m == 0 ? 0 : -0.5L * sqrtl((real)(l - am - 1) * (l - am) / d);
  if (u != 0) sum += u * combine(0, m, n, l, r1, before);
  if (m == 0)
    sum += v * (combine(1, 1, n, l, r1, before) + combine(-1, -1, n, l, r1, before));
  else if (m == 1)
    sum += v * combine(1, 0, n, l, r1, before) * sqrtl(2);
  else if (m == -1)
    sum += v * combine(-1, 0, n, l, r1, before) * sqrtl(2);
  else if (m > 0)
    sum += v * (combine(1, m - 1, n, l, r1, before) - combine(-1, -m + 1, n, l, r1, before));
  else
    sum += v * (combine(1, m + 1, n, l, r1, before) + combine(-1, -m - 1, n, l, r1, before));
  if (w != 0) {
    if (m > 0)
      sum += w * (combine(1, m + 1, n, l, r1, before) + combine(-1, -m - 1, n, l, r1, before));
    else
      sum += w * (combine(1, m - 1, n, l, r1, before) - combine(-1, -m + 1, n, l, r1, before));
  }
  return sum;
}

ylm_status ylm_sh_rotation_reference(const double r[9], int lmax, double *blocks) {
  if (lmax < 0 || lmax > YLM_SH_ROTATE_LMAX) return YLM_ERANGE;
  size_t widest = (size_t)(2 * lmax + 1) * (size_t)(2 * lmax + 1);
  real *now = ylm_alloc(2 * widest, sizeof *now), *before = now ? now + widest : NULL, r1[9];
  if (!now) return YLM_ENOMEM;
  real *memory = now;
  /* y z x, with the signs of the Condon-Shortley phase */
  static const int axis[3] = {1, 2, 0}, sign[3] = {-1, 1, -1};
  for (int m = 0; m < 3; m++)
    for (int n = 0; n < 3; n++) r1[m * 3 + n] = sign[m] * sign[n] * (real)r[axis[m] * 3 + axis[n]];
  *blocks++ = 1;
  for (int l = 1; l <= lmax; l++) {
    int n = 2 * l + 1;
    for (int i = 0; i < n * n; i++) {
      now[i] = l == 1 ? r1[i] : element(l, i / n - l, i % n - l, r1, before);
      *blocks++ = (double)now[i];
    }
    real *swap = before;
    before = now;
    now = swap;
  }
  ylm_free(memory);
  return YLM_OK;
}

/* The vector kernels in use; NULL for the plain forms. */
static const ylm__rotate_kernels *choose_kernels(void) {
  switch (ylm_isa_current()) {
#define X(isa)                                                                                     \
  case YLM_ISA_##isa: return &ylm__rotate_kernels_##isa;
    ROTATE_ISAS(X)
#undef X
  default: return NULL;
  }
}

/* -- the plan ------------------------------------------------------------------------------------
 */

/* Writes J of degree l in class order: for each class its columns, rows in the partner class. */
static void pack(int l, const double *dense, double *packed) {
  int n = 2 * l + 1, row = rotate_row(l);
  for (int c = 0; c < 4; c++) {
    int columns = class_columns(l, c), to = class_partner(l, c);
    for (int i = 0; i < columns; i++, packed += row) {
      int m = 2 * i + (c > 1);
      if (c & 1) m = -m;
      if ((c & 1) && m == 0) continue;
      for (int k = 0; k < row; k++) {
        int q = 2 * k + (to > 1);
        if ((to & 1) && q == 0) continue;
        if (to & 1) q = -q;
        if (q < -l || q > l) continue;
        packed[k] = dense[(q + l) * n + (m + l)];
      }
    }
  }
}

/* Writes J of degree l in panels. */
static void pack_panels(int l, int panel, const double *dense, double *out) {
  int n = 2 * l + 1;
  for (int c = 0; c < 4; c++) {
    int to = class_partner(l, c), columns = class_size(l, c), rows = class_size(l, to);
    for (int first = 0; first < rows; first += panel)
      for (int i = 0; i < columns; i++)
        for (int k = first; k < rows && k < first + panel; k++) {
          int q = class_first(to) + (to & 1 ? -2 : 2) * k,
              m = class_first(c) + (c & 1 ? -2 : 2) * i;
          *out++ = dense[(q + l) * n + (m + l)];
        }
  }
}

void ylm_sh_rotator_free(ylm_sh_rotator *p) {
  if (!p || __atomic_sub_fetch(&p->users, 1, __ATOMIC_ACQ_REL) > 0) return;
  ylm_free(p->panels_d);
  ylm_free(p->panels_f);
  ylm_free(p->panel_at);
  ylm_free(p->dense);
  ylm_free(p->dense_at);
  ylm_free(p->packed_d);
  ylm_free(p->packed_f);
  ylm_free(p->packed_at);
  ylm_free(p);
}

ylm_status ylm_sh_rotator_create(int lmax, ylm_sh_rotator **out, ylm_error *e) {
  *out = NULL;
  if (lmax < 0 || lmax > YLM_SH_ROTATE_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_SH_ROTATE_LMAX, lmax);
  ylm_sh_rotator *p = ylm_alloc_zero(1, sizeof *p);
  if (!p) return YLM_ENOMEM;
  p->lmax = lmax;
  p->users = 1;
  p->kernels = choose_kernels();
  p->panel_at = ylm_alloc((size_t)lmax + 1, sizeof(size_t));
  p->dense = ylm_alloc(blocks_before(lmax + 1), sizeof(double));
  p->dense_at = ylm_alloc((size_t)lmax + 1, sizeof(size_t));
  p->packed_at = ylm_alloc((size_t)lmax + 1, sizeof(size_t));
  size_t packed = 0, panels = 0;
  for (int l = 0; l <= lmax && p->packed_at && p->dense_at && p->panel_at; l++) {
    p->dense_at[l] = blocks_before(l);
    p->packed_at[l] = packed;
    p->panel_at[l] = panels;
    for (int c = 0; c < 4; c++) {
      packed += (size_t)(class_columns(l, c) * rotate_row(l));
      panels += (size_t)(class_size(l, c) * class_size(l, class_partner(l, c)));
    }
  }
  p->panels_d = ylm_alloc(panels, sizeof(double));
  p->panels_f = ylm_alloc(panels, sizeof(float));
  p->packed_d = ylm_alloc_zero(packed, sizeof(double));
  p->packed_f = ylm_alloc_zero(packed, sizeof(float));
  if (!p->dense || !p->dense_at || !p->packed_at || !p->packed_d || !p->packed_f || !p->panel_at ||
      !p->panels_d || !p->panels_f || ylm__sh_quarter_turns(lmax, p->dense) != YLM_OK) {
    ylm_sh_rotator_free(p);
    return YLM_ENOMEM;
  }
  for (int l = 0; l <= lmax; l++) {
    pack(l, p->dense + p->dense_at[l], p->packed_d + p->packed_at[l]);
    if (p->kernels)
      pack_panels(l, p->kernels->panel, p->dense + p->dense_at[l], p->panels_d + p->panel_at[l]);
  }
  for (size_t i = 0; p->kernels && i < panels; i++) p->panels_f[i] = (float)p->panels_d[i];
  for (size_t i = 0; i < packed; i++) p->packed_f[i] = (float)p->packed_d[i];
  *out = p;
  return YLM_OK;
}

/* -- rotation matrices ----------------------------------------------------------------------------
 */

static double determinant(const double r[9]) {
  return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
         r[2] * (r[3] * r[7] - r[4] * r[6]);
}

/* R^T R - I as its six numbers xx xy xz yy yz zz; returns the largest. */
static double departure(const double r[9], double d[6]) {
  double worst = 0;
  for (int i = 0, k = 0; i < 3; i++)
    for (int j = i; j < 3; j++, k++) {
      d[k] = r[i] * r[j] + r[3 + i] * r[3 + j] + r[6 + i] * r[6 + j] - (i == j);
      if (!(fabs(d[k]) <= worst)) worst = fabs(d[k]);
    }
  return worst;
}

/* Is r one of the cube's 24 rotations to twice the rounding of 1? Then *out is that one. Products
   of sines and cosines of quarter turns, axes along diagonals and unit quaternions are no further
   off. */
static bool snap(const double r[9], double out[9]) {
  double m[9], d[6];
  for (int i = 0; i < 9; i++) {
    m[i] = fabs(r[i]) <= 4.5e-16 ? 0 : r[i] < 0 ? -1 : 1;
    if (!(fabs(r[i] - m[i]) <= 4.5e-16)) return false;
  }
  if (departure(m, d) != 0 || determinant(m) != 1) return false;
  memcpy(out, m, sizeof m);
  return true;
}

ylm_status ylm_sh_rotation_check(const double r[9], double out[9], ylm_error *e) {
  if (snap(r, out)) return YLM_OK;
  double d[6], m[9], worst = departure(r, d);
  if (!(worst < 1e-5)) {
    for (int i = 0; i < 9; i++)
      if (!isfinite(r[i]))
        return ylm_fail(e, YLM_EDOMAIN,
                        "3x3 rotation expected, it holds a number that is not finite");
    return ylm_fail(e, YLM_EDOMAIN,
                    "3x3 rotation expected, columns are not orthonormal (off by %.3g)", worst);
  }
  double det = determinant(r);
  if (det < 0) return ylm_fail(e, YLM_EDOMAIN, "3x3 rotation expected, determinant is %.6g", det);
  memcpy(m, r, sizeof m);
  /* R (I - (R^T R - I)/2): the departure is squared each time */
  for (int pass = 0; pass < 3 && worst > 1e-15; pass++) {
    double q[9] = {1 - d[0] / 2, -d[1] / 2, -d[2] / 2, -d[1] / 2,   1 - d[3] / 2,
                   -d[4] / 2,    -d[2] / 2, -d[4] / 2, 1 - d[5] / 2},
           t[9];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        t[i * 3 + j] = m[i * 3] * q[j] + m[i * 3 + 1] * q[3 + j] + m[i * 3 + 2] * q[6 + j];
    memcpy(m, t, sizeof m);
    worst = departure(m, d);
  }
  memcpy(out, m, sizeof m);
  return YLM_OK;
}

ylm_status ylm_sh_rotation_from_quaternion(const double q[4], double r[9], ylm_error *e) {
  double scale = 0;
  for (int i = 0; i < 4; i++) scale = fmax(scale, fabs(q[i]));
  if (!(scale > 0) || !isfinite(scale) || q[0] != q[0] || q[1] != q[1] || q[2] != q[2] ||
      q[3] != q[3])
    return ylm_fail(e, YLM_EDOMAIN,
                    "a quaternion {w, x, y, z} of finite numbers, not all zero, expected");
  double w = q[0] / scale, x = q[1] / scale, y = q[2] / scale, z = q[3] / scale;
  double n = 2 / (w * w + x * x + y * y + z * z);
  double m[9] = {1 - n * (y * y + z * z), n * (x * y - w * z),     n * (x * z + w * y),
                 n * (x * y + w * z),     1 - n * (x * x + z * z), n * (y * z - w * x),
                 n * (x * z - w * y),     n * (y * z + w * x),     1 - n * (x * x + y * y)};
  memcpy(r, m, sizeof m);
  return YLM_OK;
}

/* Cosine and sine, exact at whole quarter turns as near as a double can name them. */
static void cosine_sine(double angle, double *c, double *s) {
  double quarters = angle / 1.57079632679489661923;
  double whole = nearbyint(quarters);
  if (fabs(whole) < 1e6 && fabs(quarters - whole) <= 4e-16 * fmax(1, fabs(whole))) {
    int k = (int)whole & 3;
    *c = k == 0 ? 1 : k == 2 ? -1 : 0;
    *s = k == 1 ? 1 : k == 3 ? -1 : 0;
    return;
  }
  *c = cos(angle);
  *s = sin(angle);
}

ylm_status ylm_sh_rotation_from_axis(const double axis[3], double angle, double r[9],
                                     ylm_error *e) {
  double scale = fmax(fabs(axis[0]), fmax(fabs(axis[1]), fabs(axis[2])));
  if (!(scale > 0) || !isfinite(scale + axis[0] + axis[1] + axis[2]) || !isfinite(angle))
    return ylm_fail(e, YLM_EDOMAIN,
                    "an axis {x, y, z} that is not zero and a finite angle expected");
  double x = axis[0] / scale, y = axis[1] / scale, z = axis[2] / scale;
  double n = sqrt(x * x + y * y + z * z), c, s;
  x /= n, y /= n, z /= n;
  cosine_sine(angle, &c, &s);
  double t = 1 - c;
  double m[9] = {t * x * x + c,     t * x * y - s * z, t * x * z + s * y,
                 t * x * y + s * z, t * y * y + c,     t * y * z - s * x,
                 t * x * z - s * y, t * y * z + s * x, t * z * z + c};
  memcpy(r, m, sizeof m);
  return YLM_OK;
}

ylm_status ylm_sh_rotation_from_zyz(const double abc[3], double r[9], ylm_error *e) {
  if (!isfinite(abc[0] + abc[1] + abc[2]))
    return ylm_fail(e, YLM_EDOMAIN, "three finite angles expected");
  double ca, sa, cb, sb, cc, sc;
  cosine_sine(abc[0], &ca, &sa);
  cosine_sine(abc[1], &cb, &sb);
  cosine_sine(abc[2], &cc, &sc);
  double m[9] = {ca * cb * cc - sa * sc,
                 -ca * cb * sc - sa * cc,
                 ca * sb,
                 sa * cb * cc + ca * sc,
                 -sa * cb * sc + ca * cc,
                 sa * sb,
                 -sb * cc,
                 sb * sc,
                 cb};
  memcpy(r, m, sizeof m);
  return YLM_OK;
}

/* The angles of an exact rotation R = Rz(a) Ry(b) Rz(c), in the form that the kernels want. */
static void angles_of(const double r[9], ylm__angles *a) {
  double sb2 = r[2] * r[2] + r[5] * r[5], cb = r[8], ca = 1, sa = 0;
  if (sb2 == 0 && cb > 0) {
    *a = (ylm__angles){{1, 1, r[0]}, {0, 0, r[3]}, TURN_FLAT};
    return;
  }
  if (sb2 == 0) { /* R = Rz(a) Rx(pi) */
    *a = (ylm__angles){{r[0], 1, 1}, {r[3], 0, 0}, TURN_HALF};
    return;
  }
  double sb = sqrt(sb2), inverse = 1 / sb;
  ca = r[2] * inverse;
  sa = r[5] * inverse;
  /* Rz(-a) R = Ry(b) Rz(c): its second row is (sin c, cos c, 0), well conditioned for every b */
  double sc = ca * r[3] - sa * r[0], cc = ca * r[4] - sa * r[1];
  if (cb == 0 && (ca == 0 || sa == 0) && (sc == 0 || cc == 0)) {
    /* Ry(pi/2) = Rz(pi/2) Rx(pi/2) Rz(-pi/2): a + pi/2, c - pi/2 */
    *a = (ylm__angles){{-sa, 1, sc}, {ca, 0, -cc}, TURN_QUARTER};
    return;
  }
  *a = (ylm__angles){{-ca, -cb, cc}, {-sa, -sb, sc}, TURN_GENERAL};
}

/* -- blocks ---------------------------------------------------------------------------------------
 */

struct ylm_sh_rotation {
  int lmax;
  ylm_dtype t;
  ylm_sh_rotator *plan; /* kept alive */
  ylm__rotate_batch batch;
  size_t *at; /* [blocked+1] where each degree's padded columns begin */
  void *blocks, *turns;
};

/* x = Z x, x [2l+1][n] the rows of a degree. */
static void turn_rows(int l, int n, double c1, double s1, double *x) {
  double c = c1, s = s1;
  for (int m = 1; m <= l; m++) {
    double *a = x + (l + m) * n, *b = x + (l - m) * n;
    for (int i = 0; i < n; i++) {
      double ai = a[i], bi = b[i];
      a[i] = c * ai - s * bi;
      b[i] = s * ai + c * bi;
    }
    double next = c * c1 - s * s1;
    s = c * s1 + s * c1;
    c = next;
  }
}

/* y = J x */
static void quarter_rows(int l, const double *j, const double *x, double *y) {
  int n = 2 * l + 1;
  memset(y, 0, (size_t)(n * n) * sizeof *y);
  for (int q = 0; q < n; q++)
    for (int m = 0; m < n; m++) {
      double v = j[q * n + m];
      if (v == 0) continue;
      for (int i = 0; i < n; i++) y[q * n + i] += v * x[m * n + i];
    }
}

/* The block of degree l, row-major, in x; y is scratch of the same size. */
static void build(const ylm_sh_rotator *p, const ylm__angles *a, int l, double *x, double *y) {
  int n = 2 * l + 1;
  const double *j = p->dense + p->dense_at[l];
  memset(x, 0, (size_t)(n * n) * sizeof *x);
  for (int i = 0; i < n; i++) x[i * n + i] = 1;
  turn_rows(l, n, a->c[2], a->s[2], x);
  switch (a->turn) {
  case TURN_FLAT: return;
  case TURN_HALF:
    for (int m = -l; m <= l; m++)
      if (half_turn_sign(l, m) < 0)
        for (int i = 0; i < n; i++) x[(m + l) * n + i] = -x[(m + l) * n + i];
    break;
  case TURN_QUARTER:
    memcpy(y, x, (size_t)(n * n) * sizeof *x);
    quarter_rows(l, j, y, x);
    break;
  default:
    quarter_rows(l, j, x, y);
    turn_rows(l, n, a->c[1], a->s[1], y);
    quarter_rows(l, j, y, x);
  }
  turn_rows(l, n, a->c[0], a->s[0], x);
}

void ylm_sh_rotation_free(ylm_sh_rotation *r) {
  if (!r) return;
  ylm_sh_rotator_free(r->plan);
  ylm_free(r->at);
  ylm_free(r->blocks);
  ylm_free(r->turns);
  ylm_free(r);
}

int ylm_sh_rotation_lmax(const ylm_sh_rotation *r) { return r->lmax; }
ylm_dtype ylm_sh_rotation_dtype(const ylm_sh_rotation *r) { return r->t; }

static int lanes_of(ylm_dtype t) { return t == YLM_DOUBLE ? 8 : 16; }

static void put(ylm_dtype t, void *to, size_t k, double x) {
  if (t == YLM_DOUBLE)
    ((double *)to)[k] = x;
  else
    ((float *)to)[k] = (float)x;
}

static double get(ylm_dtype t, const void *from, size_t k) {
  return t == YLM_DOUBLE ? ((const double *)from)[k] : (double)((const float *)from)[k];
}

/* Cosines and sines of m times the three angles. */
static void fill_turns(const ylm__angles *a, int lmax, ylm_dtype t, void *turns) {
  size_t row = (size_t)lmax + 1;
  for (size_t i = 0; i < 3; i++) {
    double c = 1, s = 0;
    for (size_t m = 0; m < row; m++) {
      put(t, turns, 2 * i * row + m, c);
      put(t, turns, (2 * i + 1) * row + m, s);
      double next = c * a->c[i] - s * a->s[i];
      s = c * a->s[i] + s * a->c[i];
      c = next;
    }
  }
}

static void fill_blocks(ylm_sh_rotation *r, double *x, double *y) {
  for (int l = 0; l <= r->batch.blocked; l++) {
    int w = 2 * l + 1, padded = rotate_padded(l, lanes_of(r->t));
    build(r->plan, &r->batch.angles, l, x, y);
    for (int q = 0; q < w; q++)
      for (int m = 0; m < w; m++)
        put(r->t, r->blocks, r->at[l] + (size_t)(m * padded + q), x[q * w + m]);
  }
}

static ylm_status create(const ylm_sh_rotator *p, const ylm__angles *a, int lmax, ylm_dtype t,
                         ylm_sh_rotation **out) {
  int blocked = p->kernels && lmax > ROTATE_BLOCKS ? ROTATE_BLOCKS : lmax;
  size_t n = (size_t)(2 * blocked + 1), total = 0;
  ylm_sh_rotation *r = ylm_alloc_zero(1, sizeof *r);
  if (!r) return YLM_ENOMEM;
  double *x = ylm_alloc(2 * n * n, sizeof *x);
  r->at = ylm_alloc((size_t)blocked + 1, sizeof(size_t));
  for (int l = 0; r->at && l <= blocked; l++) {
    r->at[l] = total;
    total += (size_t)((2 * l + 1) * rotate_padded(l, lanes_of(t)));
  }
  r->blocks = ylm_alloc_zero(total, ylm_dtype_size(t));
  r->turns = ylm_alloc(6 * ((size_t)lmax + 1), ylm_dtype_size(t));
  if (!x || !r->at || !r->blocks || !r->turns) {
    ylm_free(x);
    ylm_sh_rotation_free(r);
    return YLM_ENOMEM;
  }
  r->lmax = lmax;
  r->t = t;
  r->plan = (ylm_sh_rotator *)(uintptr_t)p;
  __atomic_add_fetch(&r->plan->users, 1, __ATOMIC_RELAXED);
  r->batch = (ylm__rotate_batch){p, *a, a->turn, lmax, blocked, r->blocks, r->turns};
  fill_turns(a, lmax, t, r->turns);
  fill_blocks(r, x, x + n * n);
  ylm_free(x);
  *out = r;
  return YLM_OK;
}

static ylm_status check_lmax(const ylm_sh_rotator *p, int lmax, ylm_error *e) {
  if (lmax >= 0 && lmax <= p->lmax) return YLM_OK;
  return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", p->lmax, lmax);
}

ylm_status ylm_sh_rotation_create(const ylm_sh_rotator *p, const double r[9], int lmax, ylm_dtype t,
                                  ylm_sh_rotation **out, ylm_error *e) {
  double exact[9];
  ylm__angles a;
  *out = NULL;
  ylm_status s = check_lmax(p, lmax, e);
  if (s == YLM_OK) s = ylm_sh_rotation_check(r, exact, e);
  if (s != YLM_OK) return s;
  angles_of(exact, &a);
  return create(p, &a, lmax, t, out);
}

ylm_status ylm_sh_rotation_block(const ylm_sh_rotation *r, int l, double *out) {
  if (l < 0 || l > r->lmax) return YLM_ERANGE;
  size_t n = (size_t)(2 * l + 1);
  double *x = ylm_alloc(2 * n * n, sizeof *x);
  if (!x) return YLM_ENOMEM;
  build(r->plan, &r->batch.angles, l, x, x + n * n);
  for (size_t k = 0; k < n * n; k++) out[k] = r->t == YLM_DOUBLE ? x[k] : (double)(float)x[k];
  ylm_free(x);
  return YLM_OK;
}

/* -- applying -------------------------------------------------------------------------------------
 */

/* The plain form, for the reference set and processors without vectors: every degree has its block.
 */
static void apply_plain(const ylm_sh_rotation *r, int lmax, size_t rows, const void *in,
                        void *out) {
  size_t count = ylm_sh_count(lmax);
  double temporary[2 * YLM_SH_ROTATE_LMAX + 1];
  for (size_t i = 0; i < rows; i++)
    for (int l = 0; l <= lmax; l++) {
      int w = 2 * l + 1, padded = rotate_padded(l, lanes_of(r->t));
      size_t at = i * count + (size_t)(l * l);
      memset(temporary, 0, sizeof temporary);
      for (int m = 0; m < w; m++)
        for (int q = 0; q < w; q++)
          temporary[q] += get(r->t, r->blocks, r->at[l] + (size_t)(m * padded + q)) *
                          get(r->t, in, at + (size_t)m);
      for (int q = 0; q < w; q++) put(r->t, out, at + (size_t)q, temporary[q]);
    }
}

typedef struct job {
  const ylm_sh_rotation *r;
  int lmax;
  const char *in;
  char *out;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  size_t offset = begin * ylm_sh_count(j->lmax) * ylm_dtype_size(j->r->t);
  const void *in = j->in + offset;
  void *out = j->out + offset;
  const ylm__rotate_kernels *k = j->r->plan->kernels;
  if (!k)
    apply_plain(j->r, j->lmax, end - begin, in, out);
  else if (j->r->t == YLM_DOUBLE)
    k->apply_d(&j->r->batch, j->lmax, end - begin, in, out);
  else
    k->apply_f(&j->r->batch, j->lmax, end - begin, in, out);
  return YLM_OK;
}

ylm_status ylm_sh_rotation_apply(const ylm_sh_rotation *r, int lmax, size_t rows, const void *in,
                                 void *out, int threads, const ylm_progress *progress) {
  if (lmax < 0 || lmax > r->lmax) return YLM_ERANGE;
  job j = {r, lmax, in, out};
  size_t grain = lmax > 15 ? 64 : 256;
  if (rows <= grain && !progress) return run(&j, 0, rows, 0);
  return ylm_parallel(rows, grain, threads, run, &j, progress, "rotate");
}

ylm_status ylm_sh_rotate(const ylm_sh_rotator *p, const double r[9], int lmax, ylm_dtype t,
                         size_t rows, const void *in, void *out, int threads,
                         const ylm_progress *progress, ylm_error *e) {
  double exact[9];
  ylm__angles a;
  ylm_status s = check_lmax(p, lmax, e);
  if (s == YLM_OK) s = ylm_sh_rotation_check(r, exact, e);
  if (s != YLM_OK) return s;
  angles_of(exact, &a);
  const ylm__rotate_kernels *k = p->kernels;
  size_t count = ylm_sh_count(lmax);
  /* building the blocks costs about as much as this many rows one at a time */
  if (k && rows <= 4 + (size_t)lmax && in != out) {
    for (size_t i = 0; i < rows; i++) {
      if (t == YLM_DOUBLE)
        k->one_d(p, lmax, &a, (const double *)in + i * count, (double *)out + i * count);
      else
        k->one_f(p, lmax, &a, (const float *)in + i * count, (float *)out + i * count);
    }
    return ylm_report(progress, rows, rows, "rotate");
  }
  ylm_sh_rotation *blocks;
  s = create(p, &a, lmax, t, &blocks);
  if (s == YLM_OK) s = ylm_sh_rotation_apply(blocks, lmax, rows, in, out, threads, progress);
  ylm_sh_rotation_free(blocks);
  return s;
}
