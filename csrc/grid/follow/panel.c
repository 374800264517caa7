/* panel.c - the points that judge a grid, after its lights changed. Their exact light gets
   the difference, as the data of the grid's points do, or all lights are summed anew. */
#include <string.h>

#include "update.h"
#include "ylm_image.h"

typedef struct panel_change {
  update *u;
  panel *p;
  float *value;    /* [n][count] of one light */
  uint8_t *inside; /* [n] in or on it */
  uint32_t *anew;  /* points whose lights are all summed again */
  size_t anews;
} panel_change;

static float length(const float *x, size_t n) {
  float s = 0;
#pragma omp simd reduction(+ : s)
  for (size_t i = 0; i < n; i++) s += x[i] * x[i];
  return sqrtf(s);
}

/* Adds `sign` times the value of a light of radiance 1 at point i, times its radiance. */
static void add_value(const panel_change *k, size_t i, const ylm_light *l, double sign) {
  const ylm_grid *g = k->u->g;
  size_t count = (size_t)g->contents.count;
  int channels = g->contents.form.channels;
  const double *e = l->radiance;
  double grey = ylm_luminance(e), sum = 0;
  const float *value = k->value + i * count;
  for (int c = 0; c < channels; c++) {
    double x = sign * (channels == 1 ? grey : e[c]);
    float *to = k->p->exact + i * g->width + (size_t)c * count;
    for (size_t j = 0; j < count; j++) to[j] += (float)x * value[j];
    sum += x * x;
  }
  k->p->drift[i] += (float)(ROUNDING * sqrt(sum)) * length(value, count);
}

/* Adds a light to the panel, or with sign -1 takes it away. A point that it leaves may be in
   another: it is summed anew. */
static ylm_status add_light(const panel_change *k, const ylm_light *l, double sign,
                            uint8_t *leaves) {
  const ylm_grid_form *form = &k->u->g->contents.form;
  const double one = 1;
  ylm_light_set *set;
  ylm_status s = ylm_light_set_of(1, &l, &one, &set);
  const ylm_field *f = s == YLM_OK ? ylm_light_set_field(set) : NULL;
  ylm_field_query q = {.lmax = form->lmax,
                       .channels = 1,
                       .metric_channels = 1,
                       .dtype = YLM_FLOAT,
                       .threads = k->u->source.threads,
                       .want = YLM_WANT_VALUE,
                       .origin = ylm__grid_origin(k->u->g)};
  ylm_field_result r = {.value = k->value, .inside = k->inside};
  memset(k->inside, 0, k->p->n);
  if (s == YLM_OK) s = ylm_field_evaluate(f, &q, k->p->n, k->p->point, &r, k->u->b.e);
  k->u->g->stats.pairs += r.pairs;
  ylm_light_set_free(set);
  for (size_t i = 0; s == YLM_OK && i < k->p->n; i++) {
    add_value(k, i, l, sign);
    if (sign < 0) leaves[i] |= k->inside[i];
    if (sign > 0) k->p->inside[i] |= k->inside[i];
  }
  return s;
}

/* Adds what changed; lists the points that a light left, or that have too little light left beside
   what rounding has added up to. */
static ylm_status add_changes(panel_change *k) {
  const update *u = k->u;
  panel *p = k->p;
  uint8_t *leaves = ylm_alloc_zero(p->n, 1);
  ylm_status s = leaves ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; i < u->changes && s == YLM_OK; i++) {
    const light_change *c = &u->change[i];
    if (c->before >= 0) s = add_light(k, &u->d->light[c->before], -1, leaves);
    if (s == YLM_OK && c->after >= 0) s = add_light(k, &u->now.light[c->after], 1, leaves);
  }
  double part = fmax(u->g->contents.form.tolerance / 16, 2e-6);
  for (size_t i = 0; i < p->n && s == YLM_OK; i++) {
    double size = (double)length(p->exact + i * u->g->width, u->g->width);
    p->drift[i] += (float)(ROUNDING * (double)u->changes * size);
    if (leaves[i] || !((double)p->drift[i] <= part * size)) k->anew[k->anews++] = (uint32_t)i;
  }
  ylm_free(leaves);
  return s;
}

/* Sums all lights at the points that are listed. */
static ylm_status sum_anew(const panel_change *k) {
  size_t n = k->anews, w = k->u->g->width;
  panel *p = k->p;
  float *point = ylm_alloc(n, 3 * sizeof *point), *exact = ylm_alloc(n, w * sizeof *exact);
  ylm_status s = point && exact ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    memcpy(point + 3 * i, p->point + 3 * k->anew[i], 3 * sizeof *point);
  if (s == YLM_OK && n) s = ylm__evaluate_values(&k->u->b, n, point, exact, k->inside);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    memcpy(p->exact + k->anew[i] * w, exact + i * w, w * sizeof *exact);
    p->inside[k->anew[i]] = k->inside[i];
    p->drift[k->anew[i]] = 0;
  }
  ylm_free(point);
  ylm_free(exact);
  return s;
}

ylm_status ylm__update_panel(update *u) {
  const panel *before = &u->d->panel;
  size_t n = before->n, count = (size_t)u->g->contents.count;
  if (!n) return YLM_OK;
  panel_change k = {.u = u,
                    .p = &u->panel,
                    .value = ylm_alloc(n, count * sizeof *k.value),
                    .inside = ylm_alloc(n, 1),
                    .anew = ylm_alloc(n, sizeof *k.anew)};
  ylm_status s = ylm__panel_copy_light(&u->panel, before, u->g->width);
  if (!k.value || !k.inside || !k.anew) s = YLM_ENOMEM;
  if (s == YLM_OK && 2 * u->changes < u->now.n) s = add_changes(&k);
  if (s == YLM_OK && 2 * u->changes >= u->now.n)
    for (uint32_t i = 0; i < n; i++) k.anew[k.anews++] = i;
  if (s == YLM_OK) s = sum_anew(&k);
  ylm_free(k.value);
  ylm_free(k.inside);
  ylm_free(k.anew);
  return s;
}
