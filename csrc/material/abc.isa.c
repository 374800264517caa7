/* abc.isa.c - the ABC model, once per instruction set. abc.c has the plain form. */
#include "abc.h"

#include "kernels.h"
#include "visible.h"

/* Reflected by a dielectric at a cosine, unpolarised. */
YLM_INLINE lane fresnel(float ior, lane c) {
  float square = ior * ior;
  lane t = ylm_vf_sqrt(lane_max(c * c + (square - 1), lane_of(0)));
  lane s = (c - t) / (c + t), p = (c * square - t) / (c * square + t);
  return (s * s + p * p) * 0.5f;
}

/* F S G / (wi.z wo.z), but for the factor a. */
YLM_INLINE lane shape_of(const abc *g, const lane wi[3], const lane wo[3]) {
  lane x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2], flat = x * x + y * y;
  lane least = lane_of(1e-6f), length = lane_max(ylm_vf_sqrt(flat + z * z), least);
  lane c = length * 0.5f, zi = lane_max(wi[2], least), zo = lane_max(wo[2], least);
  lane fall = flat / (length * (length + z)); /* 1 - m.z, without loss of digits */
  lane G = lane_min(2 * z * lane_min(zi, zo) / (length * c), lane_of(1));
  lane over = lane_exp(-g->c * lane_log(1 + g->b * fall));
  return over * G * fresnel(g->ior, lane_min(c, lane_of(1))) / (zi * zo);
}

YLM_INLINE lane density_at(const abc *g, const lane wi[3], const lane wo[3]) {
  lane D, square;
  lane root = visible_root(g->alpha, g->alpha, wo);
  return g->share * visible_pdf(g->alpha, g->alpha, wi, wo, root, &D, &square) +
         (1 - g->share) * (1 / (float)YLM_PI) * wi[2];
}

static void eval(const void *p, size_t n, const float (*in)[3], const float (*out)[3],
                 float (*to)[3]) {
  const abc *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], f[3];
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    lane shape = shape_of(g, wi, wo);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, g->kd[c] + g->a[c] * shape);
    lanes_store3(f, rows, to + i);
  }
}

static void sample(const void *p, size_t n, const float (*out)[3], const float (*numbers)[3],
                   float (*in)[3], float (*weight)[3], float *pdf) {
  const abc *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], u[3], f[3], other[3];
    lanes_load3(out + i, rows, wo);
    lanes_load3(numbers + i, rows, u);
    visible_sample(g->alpha, g->alpha, wo, u[0], u[1], wi);
    lane_cosine(u[1], u[0], other);
    mask diffuse = u[2] >= g->share;
    for (int a = 0; a < 3; a++) wi[a] = ylm_vf_select(diffuse, other[a], wi[a]);
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    lane shape = shape_of(g, wi, wo), density = density_at(g, wi, wo);
    lane scale = lane_if(lit & (density > 0), wi[2] / density);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, g->kd[c] + g->a[c] * shape) * scale;
    lanes_store3(wi, rows, in + i);
    lanes_store3(f, rows, weight + i);
    lanes_store(lane_if(lit, density), rows, pdf + i);
  }
}

static void pdf(const void *p, size_t n, const float (*in)[3], const float (*out)[3], float *to) {
  const abc *g = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3];
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    lanes_store(lane_if((wi[2] > 0) & (wo[2] > 0), density_at(g, wi, wo)), rows, to + i);
  }
}

const material_kernels YLM_KERNEL(ylm_k_material_abc) = {eval, sample, pdf};
