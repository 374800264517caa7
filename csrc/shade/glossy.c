/* glossy.c - radiance of points that gloss: sorted by material, slices times light. */
#include "slices.h"

/* Points of one material. */
typedef struct batch {
  shade_slices *slices;
  size_t n, first;                 /* points, of which number[] counts from `first` */
  size_t number[YLM_SHADE_SLICES]; /* increasing */
} batch;

/* Radiance of the n points of a batch from `from` on, which follow each other. */
static void light_run(const batch *x, ylm_shade_dot_fn *dot, size_t from, size_t n,
                      const shade_light *l, float *out) {
  size_t row = (size_t)l->channels * ylm_sh_count(l->lmax), p = x->number[from];
  shade_light at = *l;
  at.L = (const char *)l->L + p * row * ylm_dtype_size(l->type);
  ylm__shade_slices_light(x->slices, dot, from, n, &at, out + 3 * p);
  ylm__shade_tint(x->slices->v, x->first + p, n, out + 3 * p);
}

static ylm_status shade_batch(batch *x, bool shadows, ylm_shade_dot_fn *dot, const shade_light *l,
                              float *out) {
  const shade_slices *slices = x->slices;
  size_t point[YLM_SHADE_SLICES];
  const float *V[YLM_SHADE_SLICES];
  for (size_t i = 0; i < x->n; i++) {
    point[i] = x->first + x->number[i];
    if (shadows) V[i] = slices->v->transfer + point[i] * slices->count;
  }
  ylm_status s = ylm__shade_slices_make(x->slices, x->n, point, shadows ? V : NULL);
  for (size_t from = 0, behind; s == YLM_OK && from < x->n; from = behind) {
    for (behind = from + 1; behind < x->n && x->number[behind] == x->number[behind - 1] + 1;)
      behind++;
    light_run(x, dot, from, behind - from, l, out);
  }
  x->n = 0;
  return s;
}

/* The least material above `last` among n points' meshes (-1: none is asked for yet); or none. */
static uint32_t next_material(const ylm_shade_view *v, int64_t last, const uint32_t *mesh,
                              size_t n) {
  uint32_t least = YLM_SHADE_MATTE;
  for (size_t i = 0; i < n; i++) {
    if (i > 0 && mesh[i] == mesh[i - 1]) continue;
    uint32_t k = ylm__shade_gloss_slot(v->gloss, mesh[i]);
    if ((int64_t)k > last && k < least) least = k;
  }
  return least;
}

ylm_status ylm__shade_glossy(const ylm_shade_view *v, ylm_shade_dot_fn *dot,
                             const shade_tables *tables, bool shadows, size_t first, size_t n,
                             const shade_light *l, float *out) {
  const uint32_t *mesh = v->mesh + first;
  uint32_t k = next_material(v, -1, mesh, n);
  if (k == YLM_SHADE_MATTE) return YLM_OK;
  batch x = {.slices = ylm__shade_slices(v, tables), .first = first};
  ylm_status s = x.slices ? YLM_OK : YLM_ENOMEM;
  for (; s == YLM_OK && k != YLM_SHADE_MATTE; k = next_material(v, k, mesh, n)) {
    ylm__shade_slices_of(x.slices, k);
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      if (ylm__shade_gloss_slot(v->gloss, mesh[i]) != k) continue;
      x.number[x.n++] = i;
      if (x.n == YLM_SHADE_SLICES) s = shade_batch(&x, shadows, dot, l, out);
    }
    if (s == YLM_OK && x.n) s = shade_batch(&x, shadows, dot, l, out);
  }
  ylm__shade_slices_free(x.slices);
  return s;
}
