/* phong.isa.c - Phong's lobe, once per instruction set. phong.c has the plain form. */
#include "phong.h"

#include "kernels.h"
#include "lanes.h"

#define INVERSE_PI 0.31830988618379067f

/* max(0, 1 - t)^n, where t is half the square of a distance of two directions. */
YLM_INLINE lane power(lane square, float n) {
  lane t = square * 0.5f, inside = lane_min(t, lane_of(0.999999f));
  return lane_if(t < 1, lane_exp(n * lane_log1m(inside)));
}

/* The lobe's power at wi. */
YLM_INLINE lane lobe_at(const phong *g, const lane wi[3], const lane wo[3]) {
  lane x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] - wo[2];
  return power(x * x + y * y + z * z, g->exponent);
}

/* The density of samples, from the lobe's power. */
YLM_INLINE lane density_at(const phong *g, const lane wi[3], const lane wo[3], lane lobe) {
  lane x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
  lane image = power(x * x + y * y + z * z, g->exponent);
  return g->share * g->density * (lobe + image) + (1 - g->share) * INVERSE_PI * wi[2];
}

/* A direction of the lobe about the mirror direction. */
YLM_INLINE void lobe_sample(const phong *g, const lane wo[3], const lane u[3], lane wi[3]) {
  lane t = lane_1mexp(lane_log1m(u[1]) * (1 / (g->exponent + 1))), sine, cosine;
  lane s = ylm_vf_sqrt(t * (2 - t)), x = -wo[0], y = -wo[1], k = 1 / (1 + wo[2]);
  lane_turn(u[0], &sine, &cosine);
  lane a = s * cosine, b = s * sine, xy = x * y * k;
  wi[0] = a * (1 - x * x * k) - b * xy + (1 - t) * x;
  wi[1] = b * (1 - y * y * k) - a * xy + (1 - t) * y;
  wi[2] = (1 - t) * wo[2] - a * x - b * y;
  wi[2] = lane_max(wi[2], -wi[2]);
}

static void eval(const void *p, size_t n, const float (*in)[3], const float (*out)[3],
                 float (*to)[3]) {
  const phong *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], f[3];
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    lane lobe = lobe_at(g, wi, wo);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, g->base[c] + g->lobe[c] * lobe);
    lanes_store3(f, rows, to + i);
  }
}

static void sample(const void *p, size_t n, const float (*out)[3], const float (*numbers)[3],
                   float (*in)[3], float (*weight)[3], float *pdf) {
  const phong *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], u[3], f[3], other[3];
    lanes_load3(out + i, rows, wo);
    lanes_load3(numbers + i, rows, u);
    lobe_sample(g, wo, u, wi);
    lane_cosine(u[1], u[0], other);
    mask diffuse = u[2] >= g->share;
    for (int a = 0; a < 3; a++) wi[a] = ylm_vf_select(diffuse, other[a], wi[a]);
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    lane lobe = lobe_at(g, wi, wo), density = density_at(g, wi, wo, lobe);
    lane scale = lane_if(lit & (density > 0), wi[2] / density);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, g->base[c] + g->lobe[c] * lobe) * scale;
    lanes_store3(wi, rows, in + i);
    lanes_store3(f, rows, weight + i);
    lanes_store(lane_if(lit, density), rows, pdf + i);
  }
}

static void pdf(const void *p, size_t n, const float (*in)[3], const float (*out)[3], float *to) {
  const phong *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3];
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    lane density = density_at(g, wi, wo, lobe_at(g, wi, wo));
    lanes_store(lane_if((wi[2] > 0) & (wo[2] > 0), density), rows, to + i);
  }
}

const material_kernels YLM_KERNEL(ylm_k_material_phong) = {eval, sample, pdf};
