/* ggx.isa.c - GGX microfacets, once per instruction set. ggx.c has the plain form. */
#include "ggx.h"
#include "kernels.h"
#include "visible.h"

/* Entries i and i + 1 of the curve for each lane's i. */
#define EVEN(j, a) (2 * (j))
#define ODD(j, a) (2 * (j) + 1)
YLM_INLINE void look_up(const ggx *g, mask i, mask *here, mask *next) {
  int32_t at[W];
  uint64_t pair[W]; /* two neighbours are one load */
  memcpy(at, &i, sizeof at);
  for (int j = 0; j < W; j++) memcpy(&pair[j], &g->curve[at[j]], sizeof *pair);
  mask low, high;
  memcpy(&low, pair, sizeof low);
  memcpy(&high, pair + W / 2, sizeof high);
  *here = __builtin_shufflevector(low, high, LANES(EVEN, 0));
  *next = __builtin_shufflevector(low, high, LANES(ODD, 0));
}

/* A and B at the cosine of each lane. */
YLM_INLINE void curve_at(const ggx *g, lane cosine, lane *A, lane *B) {
  lane s = ylm_vf_sqrt(lane_max(cosine, lane_of(0))) * GGX_CURVE;
  mask at = lane_int(lane_min(s, lane_of(GGX_CURVE - 1))), here, next;
  lane t = s - lane_float(at);
  look_up(g, at, &here, &next);
  lane a = lane_float(here & 65535), b = lane_float((here >> 16) & 65535);
  *A = (a + t * (lane_float(next & 65535) - a)) * (1 / 65535.0f);
  *B = (b + t * (lane_float((next >> 16) & 65535) - b)) * (1 / 65535.0f);
}

YLM_INLINE lane above(const ggx *g, int c, lane A, lane B) {
  return g->f0[c] * A + B + g->K[c] * (1 - A - B);
}

/* The share of mirrored directions among samples, from A and B at wo. */
YLM_INLINE lane share_of(const ggx *g, lane A, lane B) {
  lane mirrored = {0}, rest = {0};
  for (int c = 0; c < 3; c++) {
    mirrored += g->f0[c] * A + B;
    rest += g->K[c] * (1 - A - B) + g->colour[c] * (1 - above(g, c, A, B));
  }
  return lane_max(mirrored / lane_max(mirrored + rest, lane_of(1e-20f)), lane_of(0.1f));
}

/* Of a direction wo, once for eval and sample. */
typedef struct eye {
  lane root, A, B, share;
} eye;

YLM_INLINE eye look(const ggx *g, const lane wo[3], bool plain) {
  eye v = {.root = visible_root(g->ax, g->ay, wo), .share = lane_of(1)};
  if (plain) return v;
  curve_at(g, wo[2], &v.A, &v.B);
  v.share = share_of(g, v.A, v.B);
  return v;
}

/* f where the masks of both directions are set, from D and |wi + wo|^2. */
YLM_INLINE void reflect(const ggx *g, const lane wi[3], const lane wo[3], const eye *v, lane D,
                        lane square, bool plain, lane f[3]) {
  lane q = 1 - 0.5f * ylm_vf_sqrt(square), q2 = q * q, schlick = q2 * q2 * q, A, B;
  lane under = wo[2] * visible_root(g->ax, g->ay, wi) + wi[2] * v->root;
  lane mirrored = D / lane_max(2 * under, lane_of(1e-30f));
  for (int c = 0; c < 3; c++) f[c] = (g->f0[c] + (1 - g->f0[c]) * schlick) * mirrored;
  if (plain) return;
  curve_at(g, wi[2], &A, &B);
  lane lost = (1 - A - B) * (1 - v->A - v->B);
  for (int c = 0; c < 3; c++)
    f[c] +=
        g->lost[c] * lost + g->base[c] * (1 - above(g, c, A, B)) * (1 - above(g, c, v->A, v->B));
}

YLM_INLINE void eval_as(const ggx *g, size_t n, const float (*in)[3], const float (*out)[3],
                        float (*to)[3], bool plain) {
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], f[3], square;
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    eye v = look(g, wo, plain);
    lane D = visible_ndf(g->ax, g->ay, wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2], &square);
    reflect(g, wi, wo, &v, D, square, plain, f);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, f[c]);
    lanes_store3(f, rows, to + i);
  }
}

YLM_INLINE void sample_as(const ggx *g, size_t n, const float (*out)[3], const float (*numbers)[3],
                          float (*in)[3], float (*weight)[3], float *pdf, bool plain) {
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], u[3], f[3], D, square;
    lanes_load3(out + i, rows, wo);
    lanes_load3(numbers + i, rows, u);
    eye v = look(g, wo, plain);
    visible_sample(g->ax, g->ay, wo, u[0], u[1], wi);
    if (!plain) {
      lane other[3];
      mask diffuse = u[2] >= v.share;
      lane_cosine(u[1], u[0], other);
      for (int a = 0; a < 3; a++) wi[a] = ylm_vf_select(diffuse, other[a], wi[a]);
    }
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    lane density = visible_pdf(g->ax, g->ay, wi, wo, v.root, &D, &square);
    reflect(g, wi, wo, &v, D, square, plain, f);
    if (!plain) density = v.share * density + (1 - v.share) * wi[2] * (1 / (float)YLM_PI);
    lane scale = lane_if(lit & (density > 0), wi[2] / density);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, f[c]) * scale;
    lanes_store3(wi, rows, in + i);
    lanes_store3(f, rows, weight + i);
    lanes_store(lane_if(lit, density), rows, pdf + i);
  }
}

static void eval(const void *p, size_t n, const float (*wi)[3], const float (*wo)[3],
                 float (*f)[3]) {
  const ggx *g = p;
  if (g->plain)
    eval_as(g, n, wi, wo, f, true);
  else
    eval_as(g, n, wi, wo, f, false);
}

static void sample(const void *p, size_t n, const float (*wo)[3], const float (*u)[3],
                   float (*wi)[3], float (*weight)[3], float *pdf) {
  const ggx *g = p;
  if (g->plain)
    sample_as(g, n, wo, u, wi, weight, pdf, true);
  else
    sample_as(g, n, wo, u, wi, weight, pdf, false);
}

static void pdf(const void *p, size_t n, const float (*in)[3], const float (*out)[3], float *to) {
  const ggx *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], D, square;
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    eye v = look(g, wo, g->plain);
    lane density = visible_pdf(g->ax, g->ay, wi, wo, v.root, &D, &square);
    density = v.share * density + (1 - v.share) * wi[2] * (1 / (float)YLM_PI);
    lanes_store(lane_if((wi[2] > 0) & (wo[2] > 0), density), rows, to + i);
  }
}

const material_kernels YLM_KERNEL(ylm_k_material_ggx) = {eval, sample, pdf};
