/* near.isa.c - irradiance by virtual lights near to points, once per instruction set: lanes are points. */
#define YLM_REAL_IS_FLOAT
#include "near.h"

#include "../../moments/gen/recurrences.h"
#include "../emission.h"

/* Bits of a mask's lanes. */
YLM_INLINE unsigned bits_of(vmask m) {
#if defined(__AVX512F__)
  return (unsigned)_mm512_test_epi32_mask((__m512i)m, (__m512i)m);
#elif defined(__AVX2__)
  return (unsigned)_mm256_movemask_ps((__m256)m);
#elif defined(__x86_64__)
  return (unsigned)_mm_movemask_ps((__m128)m);
#else
  unsigned bits = 0;
  for (int i = 0; i < LANES; i++) bits |= (unsigned)(m[i] & 1) << i;
  return bits;
#endif
}

/* 1/sqrt(x), x > 0, to 3e-7. */
YLM_INLINE vreal root_of(vreal x) {
#if defined(__AVX2__) && !defined(__AVX512F__)
  vreal y = (vreal)_mm256_rsqrt_ps((__m256)x);
  return y * (1.5f - x * 0.5f * y * y);
#else
  return inverse_root(x);
#endif
}

/* -- which lights --------------------------------------------------------------------------- */

ylm__near_cull_fn YLM_KERNEL(ylm__near_cull);

/* Lights within reach of the box, whose front some place of it sees; lanes are lights. */
size_t YLM_KERNEL(ylm__near_cull)(const ylm__near_lights *l, const ylm__near_box *box,
                                  uint32_t *list) {
  const float reach2 = box->reach * box->reach * 1.0001f;
  size_t n = 0;
  for (size_t first = 0; first < l->n; first += LANES) {
    vreal d2 = vreal_set(0), front = vreal_set(box->slack);
    for (int a = 0; a < 3; a++) {
      vreal v = box->middle[a] - vreal_load(l->field[a] + first);
      vreal normal = vreal_load(l->field[3 + a] + first);
      vreal out = magnitude(v) - box->half[a];
      out = larger(out, vreal_set(0));
      d2 += out * out;
      front += normal * v + magnitude(normal) * box->half[a];
    }
    vmask in = (d2 < reach2) & ((front > 0) | (vreal_load(l->field[6] + first) > 0));
    unsigned bits = bits_of(in);
    if (l->n - first < LANES) bits &= (1u << (l->n - first)) - 1;
    for (; bits; bits &= bits - 1) list[n++] = l->number[first + (size_t)__builtin_ctz(bits)];
  }
  return n;
}

/* -- irradiance ----------------------------------------------------------------------------- */

#define GONE 17.5f /* arguments of e^-x beyond which it is nothing beside 1 */

/* e^-x of x >= 0; 0 from `most` on, at most NOTHING. */
YLM_INLINE vreal fall(vreal x, const float most) {
  const vmask something = x < most;
  vreal y = keep_lanes(something, x) * -1.44269504f, k = y + MAGIC, f = y - (k - MAGIC);
  vreal p = vreal_set(1.5403530e-4f);
  p = p * f + 1.3333558e-3f;
  p = p * f + 9.6181291e-3f;
  p = p * f + 5.5504109e-2f;
  p = p * f + 2.4022651e-1f;
  p = p * f + 6.9314718e-1f;
  p = p * f + 1;
  return keep_lanes(something, (vreal)((vmask)p + ((vmask)k << MANTISSA)));
}

/* G_0 d^2 of a near light: e^-o - e^-t. A lane's result is its own, whatever the others are. */
YLM_INLINE vreal remainder_of(vreal t, vreal o) {
  vreal left = fall(o, NOTHING);
  if (!bits_of(t < GONE)) return left;
  left -= fall(t, GONE);
  const vmask small = t < SMALL;
  if (!bits_of(small)) return left;
  vreal a[3], b[3];
  rise(t, 2, 0, a);
  rise(smaller(o, vreal_set(NOTHING)), 4, 0, b);
  return choose(small, a[0] - b[0], left);
}

/* sum over l of z_l P_l(c) w^(l(l+1)/2). */
YLM_INLINE vreal by_degrees(const int lmax, const float *z, vreal c, vreal w) {
  if (lmax == 4) { /* z_3 is 0 */
    vreal c2 = c * c, w3 = w * w * w, w10 = w3 * w3 * w3 * w;
    vreal P4 = (c2 * 4.375f - 3.75f) * c2 + 0.375f;
    return z[0] + z[1] * (w * c) + (z[2] * w3) * (c2 * 1.5f - 0.5f) + (z[4] * w10) * P4;
  }
  vreal P = vreal_set(1), before = vreal_set(0), sum = before, h = P, step = w;
  for (int l = 0; l <= lmax; l++) {
    sum += z[l] * h * P;
    vreal next = ((2 * (real)l + 1) * c * P - (real)l * before) * (1 / (real)(l + 1));
    before = P, P = next;
    h *= step;
    step *= w;
  }
  return sum;
}

/* sum over l of z_l G_l P_l at points with normals N; twice: 2/sg^2. */
YLM_INLINE vreal weight_of(const int lmax, const float *z, const float sg2, const float twice,
                           const float core2, const vreal v[3], vreal d2, const vreal N[3]) {
  d2 = larger(d2, vreal_set(NEAREST * sg2));
  vreal inv = root_of(d2), inv2 = inv * inv, o = d2 * core2;
  vreal c = (v[0] * N[0] + v[1] * N[1] + v[2] * N[2]) * inv;
  vreal w = fall(inv2 * sg2, NOTHING);
  return remainder_of(d2 * twice, o * o) * inv2 * by_degrees(lmax, z, c, w);
}

/* Adds the irradiance by lights of degree 0, which are rows. */
YLM_INLINE void shine_matte(const int lmax, const ylm__virtual_near *near, const float core2,
                            const vreal xyz[3], const vreal N[3], vreal sum[3]) {
  const float reach2 = near->reach * near->reach;
  for (size_t i = 0; i < near->n; i++) {
    const float *row = near->rows + (size_t)YLM__NEAR_ROW * near->list[i], *n = row + 3;
    vreal v[3];
    for (int a = 0; a < 3; a++) v[a] = row[a] - xyz[a];
    vreal d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], inverse = root_of(d2 + row[9]);
    vreal cosine = row[6] - (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]) * inverse;
    vreal g = cosine * weight_of(lmax, near->zonal, row[7], row[8], core2, v, d2, N);
    g = keep_lanes((d2 < reach2) & (cosine > 0), g);
    for (int k = 0; k < 3; k++) sum[k] += g * row[10 + k];
  }
}

/* Adds the irradiance by lights of any degree. */
static void shine(const ylm__virtual_plan *p, const ylm__virtual_near *near, const float core2,
                  const vreal xyz[3], const vreal N[3], vreal sum[3]) {
  const float reach2 = near->reach * near->reach;
  const int degree = p->lights->degree;
  double beta[(YLM_LIGHT_VIRTUAL_DEGREE + 1) * (YLM_LIGHT_VIRTUAL_DEGREE + 1)];
  for (int l = 1; l <= degree; l++)
    for (int m = 0; m <= l; m++) beta[l * (YLM_LIGHT_VIRTUAL_DEGREE + 1) + m] = YLM__BETA(l, m);
  for (size_t i = 0; i < near->n; i++) {
    const float *lamp = p->lights->seen + near->list[i] * p->lights->stride;
    const float sg2 = width2_of(lamp);
    vreal v[3], E[3];
    seen s;
    for (int a = 0; a < 3; a++) v[a] = lamp[a] - xyz[a];
    vreal d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (!look(lamp, sg2 * (float)(YLM__GAUSS_SOFT * YLM__GAUSS_SOFT), v, d2, &s)) continue;
    send(&s, 0, degree, beta, lamp, 0, 3, E);
    vreal g = weight_of(p->lmax, near->zonal, sg2, 2 / sg2, core2, v, d2, N);
    g = keep_lanes(d2 < reach2, g);
    for (int k = 0; k < 3; k++) sum[k] += E[k] * g;
  }
}

/* Vectors relative to `origin`. */
static void load(const float (*from)[3], const double origin[3], int lanes, vreal to[3]) {
  for (size_t a = 0; a < 3; a++)
    for (int i = 0; i < LANES; i++)
      to[a][i] = (float)((double)from[i < lanes ? i : 0][a] - origin[a]);
}

ylm__virtual_near_fn YLM_KERNEL(ylm__near_irradiance);

ylm_status YLM_KERNEL(ylm__near_irradiance)(const ylm__virtual_plan *p,
                                            const ylm__virtual_near *near, void **scratch) {
  const float core2 = (float)(1 / (p->lights->core * p->lights->core));
  vreal xyz[3], N[3], sum[3] = {vreal_set(0), vreal_set(0), vreal_set(0)};
  (void)scratch;
  const double zero[3] = {0};
  /* rows are of places in the scene, lights of those about their origin */
  load(near->points, near->rows ? zero : p->lights->origin, near->lanes, xyz);
  load(near->normals, zero, near->lanes, N);
  if (near->rows && p->lmax == 4)
    shine_matte(4, near, core2, xyz, N, sum);
  else if (near->rows)
    shine_matte(p->lmax, near, core2, xyz, N, sum);
  else
    shine(p, near, core2, xyz, N, sum);
  for (int i = 0; i < near->lanes; i++)
    for (size_t c = 0; c < 3; c++) near->out[i][c] += sum[c][i];
  return YLM_OK;
}

ylm__virtual_near_fn YLM_KERNEL(ylm__virtual_near);
extern const ylm__near_kernels YLM_KERNEL(ylm__near_kernels);

const ylm__near_kernels YLM_KERNEL(ylm__near_kernels) = {LANES, YLM_KERNEL(ylm__near_cull),
                                                         YLM_KERNEL(ylm__near_irradiance),
                                                         YLM_KERNEL(ylm__virtual_near)};
