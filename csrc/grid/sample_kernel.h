/*
** sample_kernel.h - the interpolant's 32 weights, shared by the sampling kernels.
**
** A voxel's interpolant is a sum over its 8 corners of value, d/dx, d/dy, d/dz times a product of
** one function per axis. Per axis and end i = 0, 1 of the edge, at fraction t:
**   L  linear          1-t, t
**   S  cubic correction of the value,      +- t(1-t)(1-2t)      (Hermite, else 0)
**   K  of the derivative, edge x           t(1-t)^2, -t^2(1-t)  (Hermite)
**                         edge x           t(1-t), -t(1-t)      (Taylor), 0 (linear)
** and the weights are  value: LLL + SLL + LSL + LLS,  d/dx: KLL,  d/dy: LKL,  d/dz: LLK.
** Replacing one axis' L, S, K by their derivatives gives the interpolant's gradient.
** Written for any number type: F is a float or a vector of floats.
*/
#define YLM_GRID_WEIGHTS(F)                                                                        \
  typedef struct axis_functions {                                                                  \
    F l[2], s[2], k[2];                                                                            \
  } axis_functions;                                                                                \
                                                                                                   \
  static inline __attribute__((always_inline)) void axis_values(                                   \
      axis_functions *f, F t, float edge, ylm_grid_interpolation how) {                            \
    F one = t - t + 1.0f, u = one - t;                                                             \
    f->l[0] = u;                                                                                   \
    f->l[1] = t;                                                                                   \
    F zero = t - t;                                                                                \
    f->s[0] = how == YLM_GRID_HERMITE ? t * u * (u - t) : zero;                                    \
    f->s[1] = -f->s[0];                                                                            \
    f->k[0] = how == YLM_GRID_HERMITE  ? edge * t * u * u                                          \
              : how == YLM_GRID_TAYLOR ? edge * t * u                                              \
                                       : zero;                                                     \
    f->k[1] = how == YLM_GRID_HERMITE ? -edge * t * t * u : -f->k[0];                              \
  }                                                                                                \
                                                                                                   \
  static inline __attribute__((always_inline)) void axis_slopes(                                   \
      axis_functions *f, F t, float edge, ylm_grid_interpolation how) {                            \
    F zero = t - t, u = zero + 1.0f - t;                                                           \
    float rate = 1.0f / edge;                                                                      \
    f->l[0] = zero - rate;                                                                         \
    f->l[1] = zero + rate;                                                                         \
    f->s[0] = how == YLM_GRID_HERMITE ? rate * (1.0f - 6.0f * t * u) : zero;                       \
    f->s[1] = -f->s[0];                                                                            \
    f->k[0] = how == YLM_GRID_HERMITE  ? u * (u - 2.0f * t)                                        \
              : how == YLM_GRID_TAYLOR ? u - t                                                     \
                                       : zero;                                                     \
    f->k[1] = how == YLM_GRID_HERMITE ? t * (t - 2.0f * u) : -f->k[0];                             \
  }                                                                                                \
                                                                                                   \
  /* w[r * step] is the weight of row r. */                                                        \
  static inline __attribute__((always_inline)) void weights(                                       \
      const axis_functions *x, const axis_functions *y, const axis_functions *z, F *w, int step) { \
    for (int c = 0; c < 8; c++) {                                                                  \
      int i = c & 1, j = c >> 1 & 1, k = c >> 2;                                                   \
      F ll = y->l[j] * z->l[k], xl = x->l[i] * z->l[k], xy = x->l[i] * y->l[j];                    \
      w[c * step] = (x->l[i] + x->s[i]) * ll + (y->s[j] * xl + z->s[k] * xy);                      \
      w[(8 + c) * step] = x->k[i] * ll;                                                            \
      w[(16 + c) * step] = y->k[j] * xl;                                                           \
      w[(24 + c) * step] = z->k[k] * xy;                                                           \
    }                                                                                              \
  }
