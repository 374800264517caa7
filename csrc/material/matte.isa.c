/* matte.isa.c - matte surfaces, once per instruction set; p: albedo [3]. matte.c has the plain
   form. */
#include "kernels.h"
#include "lanes.h"

#define INVERSE_PI 0.31830988618379067f

static void eval(const void *p, size_t n, const float (*in)[3], const float (*out)[3],
                 float (*to)[3]) {
  const float *albedo = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], f[3];
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    mask lit = (wi[2] > 0) & (wo[2] > 0);
    for (int c = 0; c < 3; c++) f[c] = lane_if(lit, lane_of(albedo[c] * INVERSE_PI));
    lanes_store3(f, rows, to + i);
  }
}

static void sample(const void *p, size_t n, const float (*out)[3], const float (*numbers)[3],
                   float (*in)[3], float (*weight)[3], float *pdf) {
  const float *albedo = p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3], u[3], w[3];
    lanes_load3(out + i, rows, wo);
    lanes_load3(numbers + i, rows, u);
    lane_cosine(u[0], u[1], wi);
    mask lit = wo[2] > 0;
    for (int c = 0; c < 3; c++) w[c] = lane_if(lit, lane_of(albedo[c]));
    lanes_store3(wi, rows, in + i);
    lanes_store3(w, rows, weight + i);
    lanes_store(lane_if(lit, wi[2] * INVERSE_PI), rows, pdf + i);
  }
}

static void pdf(const void *p, size_t n, const float (*in)[3], const float (*out)[3], float *to) {
  (void)p;
  LANES_EACH(i, rows, n) {
    lane wi[3], wo[3];
    lanes_load3(in + i, rows, wi);
    lanes_load3(out + i, rows, wo);
    lanes_store(lane_if((wi[2] > 0) & (wo[2] > 0), wi[2] * INVERSE_PI), rows, to + i);
  }
}

const material_kernels YLM_KERNEL(ylm_k_material_matte) = {eval, sample, pdf};
