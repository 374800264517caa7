/*
** tree_walk.h - which nodes of the tree of lights are far enough from a point; a vector of nodes at
** a time, in float and the tree's units. Included by sum.isa.c.
*/

#define SIDE (YLM_VF / YLM__GROUP) /* groups in a vector */

/* A point as the tests see it. */
typedef struct seen_from {
  float x[3];
  float allowed[3]; /* B_k of tree.h */
  float skip;       /* beyond this distance Hessians are negligible */
  bool pilot;
} seen_from;

/* A field of groups side by side. */
YLM_INLINE ylm_vf side_by_side(const ylm__group *const *g, size_t offset) {
  ylm_vf v;
  for (size_t i = 0; i < SIDE; i++)
    memcpy((char *)&v + YLM__GROUP * sizeof(float) * i, (const char *)g[i] + offset,
           YLM__GROUP * sizeof(float));
  return v;
}
#define FIELD(name) side_by_side(g, offsetof(ylm__group, name))

YLM_INLINE ylm_vf tree_root(ylm_vf x) {
#if defined(__AVX512F__)
  return (ylm_vf)_mm512_sqrt_ps((__m512)x);
#elif defined(__AVX2__)
  return (ylm_vf)_mm256_sqrt_ps((__m256)x);
#elif defined(__x86_64__)
  return (ylm_vf)_mm_sqrt_ps((__m128)x);
#else
  for (int i = 0; i < YLM_VF; i++) x[i] = sqrtf(x[i]);
  return x;
#endif
}

/* Masks of the nodes that need not be opened, and of those whose Hessians are negligible. */
static void test_groups(const ylm__tree_plan *p, const ylm__group *const *g, const seen_from *from,
                        int32_t *closed, int32_t *dim) {
  ylm_vf x = FIELD(at[0]) - from->x[0], y = FIELD(at[1]) - from->x[1];
  ylm_vf z = FIELD(at[2]) - from->x[2], d = tree_root(x * x + y * y + z * z), u = 1 / d;
  ylm_vf reach = FIELD(reach);
  ylm_vi far = reach <= (from->pilot ? p->pilot_widest : p->widest) * d,
         away = d - reach > from->skip;
  if (!from->pilot) {
    ylm_vf second[2] = {FIELD(second[0]), FIELD(second[1])},
           third[2] = {FIELD(third[0]), FIELD(third[1])};
    ylm_vf strength[2] = {FIELD(strength[0]), FIELD(strength[1])}, fourth = FIELD(fourth);
    ylm_vf power = ylm_vf_set(1);
    for (int k = 0; k < 3; k++) {
      int s = p->at[k];
      const float *c = p->c[k];
      ylm_vf missed = c[0] * second[s] + u * (c[1] * third[s] + u * (c[2] * fourth * strength[s]));
      missed *= u * u * u;
      ylm_vi good = missed * missed * power <= from->allowed[k] * strength[s];
      if (p->want[k]) far &= k < 2 ? good : good | away;
      power *= u;
    }
  }
  memcpy(closed, &far, sizeof far);
  memcpy(dim, &away, sizeof away);
}
