/* stages.real.isa.c - weights by distance and emissions of lights, each function made for what it is constant in. */
#include "kernel.h"

#define WEIGH(profile, order)                                                                      \
  static void weigh_##profile##_##order(const ylm__virtual_plan *p, const real *lamp,              \
                                        const sight *s, vreal *B) {                                \
    if (YLM_LIGHT_VIRTUAL_##profile == YLM_LIGHT_VIRTUAL_CAP)                                      \
      cap(p->lmax, order, 4, lamp, s->d2, s->inv * s->inv, B);                                     \
    else                                                                                           \
      smooth(p->lmax, order, fall_of(YLM_LIGHT_VIRTUAL_##profile, order, p, lamp, s), B);          \
  }
#define PROFILES(X, order)                                                                         \
  X(GAUSS, order) X(CAP, order) X(POINT, order) X(FAR, order) X(NEAR, order)
PROFILES(WEIGH, 0)
PROFILES(WEIGH, 1)
PROFILES(WEIGH, 2)
#define ENTRY(profile, order) weigh_##profile##_##order,
weigh_fn *const VIRTUAL(weighers)[3][5] = {
    {PROFILES(ENTRY, 0)}, {PROFILES(ENTRY, 1)}, {PROFILES(ENTRY, 2)}};

#define SEND(name, order, first, channels)                                                         \
  static void name##_##order(const seen *s, int degree, const double *beta, const real *lamp,      \
                             vreal *E) {                                                           \
    send(s, order, degree, beta, lamp, first, channels, E);                                        \
  }
SEND(rgb, 0, 0, 3)
SEND(rgb, 1, 0, 3)
SEND(rgb, 2, 0, 3)
SEND(lum, 0, 3, 1)
SEND(lum, 1, 3, 1)
SEND(lum, 2, 3, 1)
send_fn *const VIRTUAL(senders)[2][3] = {{rgb_0, rgb_1, rgb_2}, {lum_0, lum_1, lum_2}};
