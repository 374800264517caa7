/* weights_of.h - how much the lamps of a vector may bring to a point. Private to weights.isa.c. */
#include "lanes.h"

#define weights OF(weights)
#define weigh OF(weigh)

/* The bound for one vector of lamps: pi s cos, s = (r/d)^2, with the cosine of the lamp's highest
   point where the horizon cuts it; s = 1 from inside. */
YLM_INLINE floats weights(floats vx, floats vy, floats vz, floats r, const float n[3]) {
  const floats zero = {0}, one = zero + 1;
  floats d2 = vx * vx + vy * vy + vz * vz, r2 = r * r;
  masks inside = d2 <= r2;
  d2 = choose(inside, one, d2);
  floats cosine = (vx * n[0] + vy * n[1] + vz * n[2]) / root(d2);
  floats s = r2 / d2, cosine2 = cosine * cosine;
  floats sine2 = choose(cosine2 < one, one - cosine2, zero);
  floats inner = choose(s < one, one - s, zero);
  floats cut = cosine * root(inner) + root(sine2 * s);
  masks whole = (cosine > zero) & (cosine2 >= s), hidden = (cosine < zero) & (cosine2 >= s);
  floats w = choose(whole, cosine, choose(cut > zero, cut, zero));
  w = choose(hidden, zero, w) * s;
  return choose(inside, choose(r > zero, one, zero), w);
}

/* Weights of a vector of lamps from j on. */
YLM_INLINE floats weigh(float *const lamp[4], const float *luminance, const float x[3],
                        const float n[3], size_t j, float *w) {
  floats vx = load(lamp[0] + j) - x[0], vy = load(lamp[1] + j) - x[1],
         vz = load(lamp[2] + j) - x[2];
  floats one = weights(vx, vy, vz, load(lamp[3] + j), n) * load(luminance + j);
  store(w + j, one);
  return one;
}
