/*
** direct.c - direct light of a point with shadows: coefficients of lamps in closed form, times the part of each group
** that is seen.
**
** A group has GATHER_FIRST rays, and as many again as it has while they disagree and it brings more than an
** eighth of the tolerance. Rays go to the same places of lamps from every point, so that what they miss
** changes slowly from point to point. The edge of a shadow has no derivative.
*/
#include "direct.h"

#include "ylm_light.h"

struct gather_direct {
  const ylm_gather *g;
  const gather_lamps *lamps;
  gather_want want;
  gather_group group[GATHER_GROUPS];
  ylm_trace_ray ray[GATHER_SHADOWS];
  uint32_t of[GATHER_SHADOWS];
  double *record; /* [lamps][16] */
  double *value, *gradient, *hessian;
  uint64_t rays;
};

gather_direct *ylm__gather_direct_create(const ylm_gather *g, const gather_lamps *lamps,
                                         const gather_want *want) {
  gather_direct *d = ylm_alloc_zero(1, sizeof *d);
  size_t rows = (size_t)want->channels * want->count;
  if (!d) return NULL;
  d->g = g;
  d->lamps = lamps;
  d->want = *want;
  d->record = ylm_alloc(16 * lamps->n, sizeof *d->record);
  d->value = ylm_alloc(rows, sizeof *d->value);
  d->gradient = ylm_alloc(3 * rows, sizeof *d->gradient);
  d->hessian = ylm_alloc(6 * rows, sizeof *d->hessian);
  if (d->record && d->value && d->gradient && d->hessian) return d;
  ylm__gather_direct_free(d);
  return NULL;
}

void ylm__gather_direct_free(gather_direct *d) {
  if (!d) return;
  ylm_free(d->record);
  ylm_free(d->value);
  ylm_free(d->gradient);
  ylm_free(d->hessian);
  ylm_free(d);
}

uint64_t ylm__gather_direct_rays(const gather_direct *d) { return d->rays; }

/* -- shadows ----------------------------------------------------------------------------------- */

static double wrap(double x) { return x - floor(x); }

/* The lamp of a group that its ray k goes to: in proportion to power, evenly spread. */
static const gather_lamp *lamp_of(const gather_lamps *l, const gather_group *group, uint32_t k,
                                  double shift) {
  double all = 0, passed = 0, target;
  if (group->n == 1) return &l->lamp[group->first];
  for (uint32_t i = 0; i < group->n; i++) all += l->lamp[group->first + i].power;
  target = wrap(shift + (k + 0.5) * 0.6180339887498949) * all;
  for (uint32_t i = 0; i < group->n; i++) {
    passed += l->lamp[group->first + i].power;
    if (passed > target) return &l->lamp[group->first + i];
  }
  return &l->lamp[group->first + group->n - 1];
}

/* Traces `more` rays of each of n groups. */
static void shadow(gather_direct *d, const float x[3], size_t n, const uint32_t *more) {
  const gather_lamps *l = d->lamps;
  double shift = (double)(d->g->form.seed % 65536) / 65536;
  size_t rays = 0;
  for (uint32_t i = 0; i < n; i++)
    for (uint32_t k = d->group[i].rays, end = k + more[i]; k < end; k++) {
      double u[2] = {wrap(shift + 0.5 + k * 0.7548776662466927),
                     wrap(shift + 0.5 + k * 0.5698402909980532)};
      d->of[rays] = i;
      d->group[i].rays++;
      if (ylm_scene_lamp_ray(l->scene, lamp_of(l, &d->group[i], k, shift)->lamp, x, u,
                             &d->ray[rays]))
        rays++;
    }
  ylm_trace_occluded(ylm_scene_trace(l->scene), rays, d->ray);
  for (size_t i = 0; i < rays; i++) d->group[d->of[i]].seen += !(d->ray[i].far < 0);
  d->rays += rays;
}

/* How many rays of the groups are looked at closer; fewer once there are GATHER_SHADOWS. */
static size_t choose_more(const gather_direct *d, size_t n, double all, size_t used,
                          uint32_t *more) {
  size_t sum = 0;
  for (size_t i = 0; i < n; i++) {
    const gather_group *g = &d->group[i];
    bool split = g->seen > 0 && g->seen < g->rays;
    more[i] = split && g->light > d->g->form.tolerance / 8 * all &&
                      2 * g->rays <= GATHER_OF_GROUP && used + sum + g->rays <= GATHER_SHADOWS
                  ? g->rays
                  : 0;
    sum += more[i];
  }
  return sum;
}

static size_t find_groups(gather_direct *d, const float x[3], double indirect) {
  uint32_t more[GATHER_GROUPS];
  size_t n = ylm__gather_groups(d->lamps, x, d->group), used = n * GATHER_FIRST;
  double all = indirect;
  d->rays = 0;
  for (size_t i = 0; i < n; i++) {
    all += d->group[i].light;
    more[i] = GATHER_FIRST;
  }
  shadow(d, x, n, more);
  for (size_t sum; (sum = choose_more(d, n, all, used, more)) > 0; used += sum)
    shadow(d, x, n, more);
  return n;
}

/* -- light ------------------------------------------------------------------------------------- */

/* Records of one kind, of all lamps that are seen, dimmed: how many numbers. */
static size_t collect(gather_direct *d, size_t groups, const char *kind) {
  size_t numbers = 0;
  for (size_t i = 0; i < groups; i++) {
    const gather_group *g = &d->group[i];
    if (!g->seen) continue;
    double part = (double)g->seen / g->rays;
    for (uint32_t k = g->first; k < g->first + g->n; k++) {
      const gather_lamp *lamp = &d->lamps->lamp[k];
      if (strcmp(lamp->kind, kind)) continue;
      double *to = d->record + numbers;
      memcpy(to, lamp->record, lamp->numbers * sizeof *to);
      for (int c = 0; c < 3; c++) to[c] *= part;
      numbers += lamp->numbers;
    }
  }
  return numbers;
}

ylm_status ylm__gather_direct_light(gather_direct *d, const float at[3], double indirect,
                                    gather_sums *s, bool *inside, ylm_error *e) {
  static const char *const kinds[] = {"sphere", "polygon", "sun"};
  const double x[3] = {(double)at[0], (double)at[1], (double)at[2]};
  size_t groups = find_groups(d, at, indirect);
  ylm_field_query q = {.lmax = d->want.lmax,
                       .channels = d->want.channels,
                       .want = YLM_WANT_VALUE | (d->want.gradient ? YLM_WANT_GRADIENT : 0) |
                               (d->want.hessians ? YLM_WANT_HESSIAN : 0),
                       .dtype = YLM_DOUBLE,
                       .threads = 1};
  for (size_t k = 0; k < 3; k++) {
    ylm_light_source source = {kinds[k], d->record, collect(d, groups, kinds[k]), NULL, NULL};
    ylm_light_set *set;
    uint8_t within = 0;
    if (!source.numbers) continue;
    ylm_field_result r = {
        .value = d->value, .gradient = d->gradient, .hessian = d->hessian, .inside = &within};
    ylm_status status = ylm_light_set_create(1, &source, &set, e);
    if (status != YLM_OK) return status;
    const ylm_field *f = ylm_light_set_field(set);
    status = f->evaluate(f, &q, 1, x, &r, e);
    ylm_light_set_free(set);
    if (status != YLM_OK) return status;
    ylm__gather_add(s, d->value, d->gradient, d->hessian);
    *inside = *inside || within;
  }
  return YLM_OK;
}

/* -- the sky ----------------------------------------------------------------------------------- */

void ylm__gather_sky(const gather_lamps *l, const float direction[3], float rgb[3]) {
  const ylm_light_set *sky = ylm_scene_sky(l->scene);
  double d[3] = {(double)direction[0], (double)direction[1], (double)direction[2]}, x[3];
  ylm_light_set_sky(sky, d, false, x);
  for (int c = 0; c < 3; c++) rgb[c] = (float)x[c];
}

/* Means over 4 x 4 places of each cell; exactly the sky's radiance where all are alike. */
ylm_status ylm__gather_make_sky(const gather_lattice *l, gather_lamps *lamps) {
  const ylm_light_set *set = ylm_scene_sky(lamps->scene);
  ylm_light_dome dome;
  if (!set || !ylm_light_set_dome(set, 0, &dome)) return YLM_OK;
  lamps->sky = ylm_alloc(l->cells, sizeof *lamps->sky);
  if (!lamps->sky) return YLM_ENOMEM;
  size_t n = (size_t)l->base;
  for (size_t c = 0; c < l->cells; c++) {
    float first[3] = {0, 0, 0};
    double sum[3] = {0, 0, 0};
    for (size_t k = 0; k < 16; k++) {
      size_t at[2] = {4 * (c % n) + k % 4, 4 * (c / n % n) + k / 4};
      float d[3], rgb[3];
      int axis = (int)(c / (n * n)) / 2;
      d[axis] = c / (n * n) % 2 ? -1 : 1;
      for (int a = 0; a < 2; a++)
        d[(axis + 1 + a) % 3] =
            (float)tan((((double)at[a] + 0.5) / (2 * (double)n) - 1) * (YLM_PI / 4));
      double length = sqrt((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
      for (int a = 0; a < 3; a++) d[a] = (float)((double)d[a] / length);
      ylm__gather_sky(lamps, d, rgb);
      if (k == 0) memcpy(first, rgb, 12);
      for (int i = 0; i < 3; i++) sum[i] += (double)(rgb[i] - first[i]);
    }
    for (int i = 0; i < 3; i++) lamps->sky[c][i] = first[i] + (float)(sum[i] / 16);
  }
  return YLM_OK;
}
