/* spheres_of.h - rays to the spheres of a vector. Private to spheres.isa.c. */
#include "lanes.h"

#define most OF(most)
#define turn OF(turn)
#define about OF(about)
#define aim OF(aim)

YLM_INLINE floats most(floats a, floats b) { return choose(a > b, a, b); }

/* Cosine and sine of 2 pi u, for u of 0 .. 1, by their series within an eighth of a turn. */
YLM_INLINE void turn(floats u, floats *cosine, floats *sine) {
  masks quarter = __builtin_convertvector(4 * u + 0.5f, masks);
  floats t = (4 * u - __builtin_convertvector(quarter, floats)) * ((float)YLM_PI / 2), t2 = t * t;
  floats s =
      t * (1 + t2 * (-1 / 6.f + t2 * (1 / 120.f + t2 * (-1 / 5040.f + t2 * (1 / 362880.f)))));
  floats c = 1 + t2 * (-1 / 2.f + t2 * (1 / 24.f + t2 * (-1 / 720.f + t2 * (1 / 40320.f))));
  masks odd = (quarter & 1) != 0;
  floats x = choose(odd, s, c), y = choose(odd, c, s);
  *cosine = choose(((quarter + 1) & 2) != 0, -x, x);
  *sine = choose((quarter & 2) != 0, -y, y);
}

/* Directions about the axis: cosine 1 - q. Source of the frame: Duff et al. 2017. */
YLM_INLINE void about(const floats axis[3], floats q, floats u, floats out[3]) {
  const floats zero = {0};
  floats x = axis[0], y = axis[1], z = axis[2], s = choose(z < zero, zero - 1, zero + 1);
  floats p = -1 / (s + z), w = x * y * p, c, d, r = root(most(q * (2 - q), zero));
  turn(u, &c, &d);
  c *= r;
  d *= r;
  out[0] = c * (1 + s * x * x * p) + d * w + (1 - q) * x;
  out[1] = c * (s * w) + d * (s + y * y * p) + (1 - q) * y;
  out[2] = -(c * s * x) - d * y + (1 - q) * z;
}

YLM_INLINE void aim(const float normal[3], size_t i, scene_spheres *a) {
  const floats zero = {0};
  floats v[3], axis[3], dir[3], r = load(a->radius + i), r2 = r * r, d2 = zero;
  for (int k = 0; k < 3; k++) v[k] = load(a->v[k] + i), d2 += v[k] * v[k];
  masks outside = d2 > r2;
  floats safe2 = choose(outside, d2, zero + 1), d = root(safe2), inverse = 1 / d;
  floats s2 = choose(outside, r2, zero) * inverse * inverse;
  floats cap = s2 / (1 + root(most(1 - s2, zero))), q = load(a->u[0] + i) * cap;
  for (int k = 0; k < 3; k++) axis[k] = v[k] * inverse;
  about(axis, q, load(a->u[1] + i), dir);
  floats far = d * (1 - q) - root(most(r2 - safe2 * (q * (2 - q)), zero));
  floats cosine = most(dir[0] * normal[0] + dir[1] * normal[1] + dir[2] * normal[2], zero);
  for (int k = 0; k < 3; k++) store(a->dir[k] + i, dir[k]);
  store(a->far + i, far);
  store(a->value + i, choose(outside, cosine * (2 * (float)YLM_PI) * cap, zero - 1));
}
