/* factors.real.isa.c - straight sums: factors of lights by degree, times harmonics (straight.h). */
#include "kernel.h"

/* Sums of ../gen. */
#define STRAIGHT YLM_REAL_KERNEL(ylm__virtual_straight)
extern const ylm__virtual_straight STRAIGHT;

/* Whether a light's colours differ by a factor, and its distances have a logarithm. */
static bool is_one(const ylm__virtual_plan *p) {
  const ylm_light_virtual_profile profile = p->lights->profile;
  return p->lights->degree == 0 &&
         (profile == YLM_LIGHT_VIRTUAL_GAUSS || profile == YLM_LIGHT_VIRTUAL_POINT ||
          profile == YLM_LIGHT_VIRTUAL_FAR);
}

/* Factors of values: colours [3], [lmax+1]. */
static void put_values(int lmax, const vreal *B, const vreal E[3], vreal *e) {
  for (int c = 0; c < 3; c++) e[c] = E[c];
  for (int l = 0; l <= lmax; l++) e[3 + l] = B[4 * l];
}

YLM_INLINE void fall_values(int lmax, falloff f, const vreal E[3], vreal *e) {
  for (int c = 0; c < 3; c++) e[c] = E[c];
  f.h *= f.a[0];
  for (int l = 0; l <= lmax; l++, go_on(&f)) e[3 + l] = f.h;
}

/* Factors of values and gradients: d, then [lmax+1][12]: colours over d, and the gradient's logarithm, d B1/B0 w -
   l w + d grad E/E; by x and y it is doubled. */
YLM_INLINE void fall_slopes(int lmax, falloff f, const sight *s, const real *n, const vreal E[3],
                            vreal *e) {
  const vreal once = inverse(larger(s->cosine, vreal_set(TINY))), inv = s->inv, *w = s->w;
  const vreal d = s->d2 * inv, part = d * s->inverse, bent = part * part * (s->along * once);
  const vreal back = -part * once, twice = back + back;
  const vreal N[3] = {n[0] * twice, n[1] * twice, n[2] * back}, W[3] = {2 * w[0], 2 * w[1], w[2]};
  const vreal D[3] = {E[0] * inv, E[1] * inv, E[2] * inv};
  *e++ = d;
  f.h *= f.a[0];
  f.steep -= bent;
  for (int l = 0; l <= lmax; l++, e += 12, go_on(&f)) {
    const vreal along = f.q + (f.steep - f.n);
    for (int c = 0; c < 3; c++) e[c] = D[c] * f.h;
    for (int a = 0; a < 3; a++) e[3 + a] = W[a] * along + N[a];
  }
}

/* As that, of lights whose colours differ; E: jets [4][3]. */
static void put_each(int lmax, const vreal *B, const vreal *E, const sight *s, vreal *e) {
  const vreal inv = s->inv, *w = s->w;
  vreal F[9], W[9], D[3];
  for (int c = 0; c < 3; c++) D[c] = E[c] * inv;
  for (int a = 0; a < 3; a++)
    for (int c = 0; c < 3; c++) {
      const vreal f = E[3 + 3 * a + c], g = w[a] * D[c];
      F[3 * a + c] = a < 2 ? f + f : f, W[3 * a + c] = a < 2 ? g + g : g;
    }
  *e++ = s->d2 * inv;
  for (int l = 0; l <= lmax; l++, e += 12) {
    const vreal b = B[4 * l], up = B[4 * l + 1] - (real)l * b;
    for (int c = 0; c < 3; c++) e[c] = D[c] * b;
    for (int i = 0; i < 9; i++) e[3 + i] = W[i] * up + F[i] * b;
  }
}

/* Factors [lmax+3][3] of second derivatives: of degrees l+2, l, l-2. */
YLM_INLINE void bend_factors(const int l, const vreal b0, const vreal b1, const vreal b2,
                             vreal *e) {
  const real n = (real)l;
  e[3 * (l + 2)] = b2 - (2 * n + 2) * b1 + n * (n + 2) * b0;
  e[3 * l + 1] = b2 + b1 - n * (n + 1) * b0;
  if (l > 1) e[3 * (l - 2) + 2] = b2 + 2 * n * b1 + (n * n - 1) * b0;
}

YLM_INLINE vreal bright_of(const vreal E[3], vreal inv) {
  return ((real)YLM_LUMINANCE_R * E[0] + (real)YLM_LUMINANCE_G * E[1] +
          (real)YLM_LUMINANCE_B * E[2]) *
         (inv * inv);
}

static void put_bends(int lmax, const vreal *B, const vreal E[3], vreal inv, vreal *e) {
  const vreal all = bright_of(E, inv);
  for (int l = 0; l <= lmax; l++)
    bend_factors(l, all * B[4 * l], all * B[4 * l + 1], all * B[4 * l + 2], e);
}

YLM_INLINE void fall_bends(int lmax, falloff f, const vreal E[3], vreal inv, vreal *e) {
  f.h *= bright_of(E, inv);
  for (int l = 0; l <= lmax; l++, go_on(&f)) {
    const vreal *a = f.a, q = f.q;
    bend_factors(l, f.h * a[0], f.h * (a[1] + q * a[0]),
                 f.h * (a[2] + q * (2 * a[1] + (q - 2) * a[0])), e);
  }
}

YLM_INLINE void colours_of(const ylm__virtual_plan *p, const work *k, int j, send_fn *sender,
                           vreal *E) {
  const real *lamp = k->lamp[j];
  if (sender) {
    seen of;
    seen_of(&k->sight[j], lamp, &of);
    sender(&of, p->lights->degree, k->beta, lamp, E);
  } else
    for (int c = 0; c < 3; c++) E[c] = k->sight[j].cosine * lamp[YLM__VIRTUAL_EMISSION + c];
}

/* Factors of the tile's lights; `one`: of slopes too, `bend`: and of second derivatives. */
typedef void fall_fn(const ylm__virtual_plan *p, work *k, send_fn *sender);
#define FALL(profile, one, bend)                                                                   \
  static void fall_##profile##_##one##bend(const ylm__virtual_plan *p, work *k, send_fn *sender) { \
    for (int j = 0; j < k->held; j++) {                                                            \
      const sight *s = &k->sight[j];                                                               \
      const real *lamp = k->lamp[j];                                                               \
      vreal E[3], *t = k->S + (size_t)j * p->width, *e = t + p->factors;                           \
      colours_of(p, k, j, sender, E);                                                              \
      const falloff f = fall_of(YLM_LIGHT_VIRTUAL_##profile, bend ? 2 : one, p, lamp, s);          \
      if (one)                                                                                     \
        fall_slopes(p->lmax, f, s, lamp + YLM__VIRTUAL_NORMAL, E, e);                              \
      else                                                                                         \
        fall_values(p->lmax, f, E, e);                                                             \
      if (bend) fall_bends(p->lmax, f, E, s->inv, t + p->bent);                                    \
    }                                                                                              \
  }
#define SMOOTH(profile)                                                                            \
  FALL(profile, 0, 0) FALL(profile, 1, 0) FALL(profile, 0, 1) FALL(profile, 1, 1)
SMOOTH(GAUSS)
SMOOTH(POINT)
SMOOTH(FAR)
FALL(NEAR, 0, 0)
FALL(NEAR, 0, 1)
static void fall_CAP_00(const ylm__virtual_plan *p, work *k, send_fn *sender) {
  for (int j = 0; j < k->held; j++) {
    const sight *s = &k->sight[j];
    vreal *e = k->S + (size_t)j * p->width + p->factors, E[3];
    colours_of(p, k, j, sender, E);
    for (int c = 0; c < 3; c++) e[c] = E[c];
    cap(p->lmax, 0, 1, k->lamp[j], s->d2, s->inv * s->inv, e + 3);
  }
}
static fall_fn *const falls[2][2][5] = {
    {{fall_GAUSS_00, fall_CAP_00, fall_POINT_00, fall_FAR_00, fall_NEAR_00},
     {fall_GAUSS_01, NULL, fall_POINT_01, fall_FAR_01, fall_NEAR_01}},
    {{fall_GAUSS_10, NULL, fall_POINT_10, fall_FAR_10, NULL},
     {fall_GAUSS_11, NULL, fall_POINT_11, fall_FAR_11, NULL}}};

/* Factors of the tile's lights by weights. */
static void put_factors(const ylm__virtual_plan *p, work *k, send_fn *sender) {
  weigh_fn *weigh_light = VIRTUAL(weighers)[order_of(p->kinds)][p->lights->profile];
  for (int j = 0; j < k->held; j++) {
    const sight *s = &k->sight[j];
    const real *lamp = k->lamp[j];
    vreal *t = k->S + (size_t)j * p->width, *e = t + p->factors, E[3 * 4];
    weigh_light(p, lamp, s, k->B);
    colours_of(p, k, j, sender, E);
    if (!p->slopes)
      put_values(p->lmax, k->B, E, e);
    else
      put_each(p->lmax, k->B, E, s, e);
    if (p->bends) put_bends(p->lmax, k->B, E, s->inv, t + p->bent);
  }
}

void VIRTUAL(sum_straight)(const ylm__virtual_plan *p, work *k) {
  ylm__virtual_sum *sum = !p->slopes ? STRAIGHT.value : is_one(p) ? STRAIGHT.one : STRAIGHT.each;
  STRAIGHT.harmonics(p->bends ? p->lmax + 2 : p->lmax, k->held, k->sight[0].w,
                     sizeof *k->sight / sizeof(vreal), k->S, p->width);
  const bool slopes = p->slopes && is_one(p);
  send_fn *sender =
      p->lights->degree || (p->slopes && !slopes) ? VIRTUAL(senders)[0][p->slopes] : NULL;
  fall_fn *put = p->slopes == slopes ? falls[slopes][p->bends][p->lights->profile] : NULL;
  if (put)
    put(p, k, sender);
  else
    put_factors(p, k, sender);
  sum(p->lmax, k->held, k->S, p->width, p->factors, k->part);
  if (p->bends) STRAIGHT.bend(p->lmax, k->held, k->S, p->width, p->bent, k->part + p->bend_sums);
}
