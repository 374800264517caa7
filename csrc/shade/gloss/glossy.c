/* glossy.c - radiance of points that gloss: sorted by material, slices times light. */
#include <string.h>

#include "../calibration.h"
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

/* Where the slices of a batch's points go. */
typedef struct sink {
  bool shadows;
  ylm_shade_dot_fn *dot; /* times light, to out; or */
  const shade_light *light;
  float *out;
  shade_kept *kept; /* as they are */
} sink;

static void keep_batch(const batch *x, shade_kept *kept) {
  const shade_slices *s = x->slices;
  size_t numbers = s->functions * s->count;
  for (size_t i = 0; i < x->n; i++)
    memcpy(kept->slice + kept->at[x->first + x->number[i]], s->slice + i * numbers,
           numbers * sizeof(float));
}

/* Radiance of a batch whose points share their light. */
static ylm_status shine(batch *x, const size_t *point, const float *const *V, const sink *to) {
  float radiance[YLM_SHADE_SLICES][3];
  size_t row = 3 * x->slices->count, n = x->n;
  const float *L = (const float *)to->light->L + x->number[0] * row;
  ylm_status s = ylm__shade_slices_shine(x->slices, n, point, V, L, radiance);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    memcpy(to->out + 3 * x->number[i], radiance[i], sizeof radiance[i]);
    ylm__shade_tint(x->slices->v, point[i], 1, to->out + 3 * x->number[i]);
  }
  x->n = 0;
  return s;
}

static ylm_status do_batch(batch *x, const sink *to) {
  const shade_slices *slices = x->slices;
  size_t point[YLM_SHADE_SLICES];
  const float *V[YLM_SHADE_SLICES];
  for (size_t i = 0; i < x->n; i++) {
    point[i] = x->first + x->number[i];
    if (to->shadows) V[i] = slices->v->transfer + point[i] * slices->count;
  }
  if (!to->kept && ylm__shade_slices_shares(slices, to->light, x->n, x->number))
    return shine(x, point, to->shadows ? V : NULL, to);
  ylm_status s = ylm__shade_slices_make(x->slices, x->n, point, to->shadows ? V : NULL);
  if (s == YLM_OK && to->kept)
    keep_batch(x, to->kept);
  else
    for (size_t from = 0, behind; s == YLM_OK && from < x->n; from = behind) {
      for (behind = from + 1; behind < x->n && x->number[behind] == x->number[behind - 1] + 1;)
        behind++;
      light_run(x, to->dot, from, behind - from, to->light, to->out);
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

/* Slices of those of n points from `first` on that gloss, sorted by material. */
static ylm_status do_points(const ylm_shade_view *v, const shade_tables *tables, size_t first,
                            size_t n, const sink *to) {
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
      if (x.n == YLM_SHADE_SLICES) s = do_batch(&x, to);
    }
    if (s == YLM_OK && x.n) s = do_batch(&x, to);
  }
  ylm__shade_slices_free(x.slices);
  return s;
}

typedef struct keeping {
  const ylm_shade_view *v;
  shade_kept *kept;
} keeping;

static ylm_status keep_points(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const keeping *j = context;
  return do_points(j->v, j->kept->tables, begin, end - begin,
                   &(sink){.shadows = j->kept->shadows, .kept = j->kept});
}

ylm_status ylm__shade_keep(const ylm_shade_view *v, shade_kept *kept, int threads,
                           const ylm_progress *progress) {
  keeping j = {v, kept};
  return ylm_parallel(v->points, SHADE_KEPT_GRAIN, threads, keep_points, &j, progress, "products");
}

/* Radiance by slices that are kept, one run of points of a mesh after the other. */
static void shade_kept_points(const ylm_shade_view *v, ylm_shade_dot_fn *dot,
                              const shade_rows *rows, size_t first, size_t n, const shade_light *l,
                              float *out) {
  const uint32_t *mesh = v->mesh + first;
  shade_slices x = {.v = v, .t = rows->tables, .count = ylm_sh_count(rows->tables->lmax)};
  size_t row = (size_t)l->channels * ylm_sh_count(l->lmax) * ylm_dtype_size(l->type);
  for (size_t i = 0, behind; i < n; i = behind) {
    uint32_t k = ylm__shade_gloss_slot(v->gloss, mesh[i]);
    for (behind = i + 1; behind < n && mesh[behind] == mesh[i] && behind - i < YLM_SHADE_SLICES;)
      behind++;
    if (k == YLM_SHADE_MATTE) continue;
    shade_light at = *l;
    at.L = (const char *)l->L + i * row;
    ylm__shade_slices_of(&x, k);
    x.slice = rows->kept->slice + rows->kept->at[first + i];
    ylm__shade_slices_light(&x, dot, 0, behind - i, &at, out + 3 * i);
    ylm__shade_tint(v, first + i, behind - i, out + 3 * i);
  }
}

ylm_status ylm__shade_glossy(const ylm_shade_view *v, ylm_shade_dot_fn *dot, const shade_rows *rows,
                             bool shadows, size_t first, size_t n, const shade_light *l,
                             float *out) {
  if (!rows->kept)
    return do_points(v, rows->tables, first, n,
                     &(sink){.shadows = shadows, .dot = dot, .light = l, .out = out});
  shade_kept_points(v, dot, rows, first, n, l, out);
  return YLM_OK;
}
