/* dynamic.c - the state that updates need: made by the bake, kept per point. */
#include "dynamic.h"

#include <math.h>
#include <string.h>

/* -- bounds of a light's field ----------------------------------------------------------- */

static double squares(const double *x, size_t n) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += x[i] * x[i];
  return s;
}

/* The square of the norm of Hessians xx xy xz yy yz zz, or of a difference of two sets. */
static double hessian_squares(const double *a, const double *b, size_t n) {
  double s = 0;
  for (size_t i = 0; i < 6 * n; i++) {
    double x = a[i] - (b ? b[i] : 0);
    s += (i % 6 == 1 || i % 6 == 2 || i % 6 == 4 ? 2 : 1) * x * x;
  }
  return s;
}

/*
** Measures the norms of value and derivatives of a light of radius 1 at distances from NEAR on and
** scales them: s = r/d alone decides, and smoothly. Norms over all orders do not depend on the
** direction.
*/
static ylm_status measure_bounds(int lmax, double bound[4], ylm_error *e) {
  enum { DISTANCES = 7, POINTS = 7 };
  static const double far[DISTANCES] = {NEAR, 3.5, 4.5, 6.5, 12, 40, 400};
  static const double way[3] = {0.36, 0.48, 0.8}, at[3] = {0}, radius = 1, radiance[3] = {1, 1, 1};
  size_t count = (size_t)(lmax + 1) * (size_t)(lmax + 1);
  ylm_lights *one = NULL;
  double *v = ylm_alloc(POINTS * count, sizeof *v), *g = ylm_alloc(POINTS * count, 3 * sizeof *g),
         *h = ylm_alloc(POINTS * count, 6 * sizeof *h), x[POINTS][3];
  ylm_status s = v && g && h ? ylm_lights_create(1, at, &radius, radiance, &one, e) : YLM_ENOMEM;
  for (int k = 0; k < 4; k++) bound[k] = 0;
  for (int i = 0; s == YLM_OK && i < DISTANCES; i++) {
    double d = far[i], step = 1e-4 * d, third = 0;
    for (int p = 0; p < POINTS; p++)
      for (int a = 0; a < 3; a++)
        x[p][a] = d * way[a] + (p > 0 && (p - 1) / 2 == a ? (p & 1 ? step : -step) : 0);
    ylm_field_query q = {.lmax = lmax,
                         .channels = 1,
                         .metric_channels = 1,
                         .dtype = YLM_DOUBLE,
                         .threads = 1,
                         .want = YLM_WANT_VALUE | YLM_WANT_GRADIENT | YLM_WANT_HESSIAN};
    ylm_field_result r = {.value = v, .gradient = g, .hessian = h};
    const ylm_field *f = ylm_lights_field(one);
    s = f->evaluate(f, &q, POINTS, x, &r, e);
    for (size_t a = 0; a < 3; a++)
      third += hessian_squares(h + (1 + 2 * a) * 6 * count, h + (2 + 2 * a) * 6 * count, count);
    double norm[4] = {squares(v, count), squares(g, 3 * count), hessian_squares(h, NULL, count),
                      third / (4 * step * step)};
    for (int k = 0; k < 4; k++) bound[k] = fmax(bound[k], 1.1 * sqrt(norm[k]) * pow(d, k + 2));
  }
  ylm_lights_free(one);
  ylm_free(v);
  ylm_free(g);
  ylm_free(h);
  return s;
}

/* -- making ------------------------------------------------------------------------------- */

ylm_status ylm__dynamic_begin(ylm_grid *g, const ylm_grid_source *source, ylm_error *e) {
  grid_dynamic *d = g->dynamic = ylm_alloc_zero(1, sizeof *d);
  if (!d) return YLM_ENOMEM;
  size_t bytes = source->occupied * 3 * ylm_dtype_size(source->occupied_dtype);
  d->lamps = ylm_lights_count(source->lights);
  d->lamp = ylm__lamps(source->lights);
  d->mover_of = ylm_alloc(d->lamps, sizeof *d->mover_of);
  d->source = *source;
  d->source.field = NULL;
  d->source.lights = NULL;
  d->source.progress = NULL;
  if (source->occupied_points) {
    d->occupied_points = ylm_alloc(bytes, 1);
    if (!d->occupied_points) return YLM_ENOMEM;
    memcpy(d->occupied_points, source->occupied_points, bytes);
  }
  d->source.occupied_points = d->occupied_points;
  if (!d->lamp || !d->mover_of) return YLM_ENOMEM;
  for (size_t i = 0; i < d->lamps; i++) d->mover_of[i] = -1;
  d->bends = 6 * (size_t)g->view.count * (size_t)g->view.form.metric_channels;
  return measure_bounds(g->view.form.lmax, d->bound, e);
}

ylm_status ylm__dynamic_end(ylm_grid *g, occupancy *occupied) {
  g->dynamic->occupied = *occupied;
  *occupied = (occupancy){0};
  ylm__dynamic_sign_all(g, NULL, g->dynamic->source.threads);
  g->stats.bytes += ylm__dynamic_bytes(g->dynamic);
  return YLM_OK;
}

void ylm__dynamic_free(grid_dynamic *d) {
  if (!d) return;
  for (size_t m = 0; m < d->movers; m++) ylm_free(d->mover[m].seen);
  ylm_free(d->mover);
  ylm_free(d->lamp);
  ylm_free(d->mover_of);
  ylm_free(d->hessian);
  ylm_free(d->size);
  ylm_free(d->drift);
  ylm_free(d->sign);
  ylm_free(d->born_sign);
  ylm_free(d->cell_sign);
  ylm_free(d->occupied_points);
  occupancy_free(&d->occupied);
  lattice_hash_free(&d->forced);
  ylm_free(d);
}

size_t ylm__dynamic_bytes(const grid_dynamic *d) {
  if (!d) return 0;
  return sizeof *d + d->lamps * (sizeof *d->lamp + sizeof *d->mover_of) +
         d->movers * (sizeof *d->mover + d->room) +
         d->room * ((d->bends + 2) * sizeof(float) + sizeof *d->sign) +
         (d->born_room + d->cell_room) * sizeof *d->sign +
         d->source.occupied * 3 * ylm_dtype_size(d->source.occupied_dtype);
}

/* -- per point ---------------------------------------------------------------------------- */

/* Grows *p from `used` to `room` bytes; false without memory. */
static bool grow(void *p, size_t used, size_t room) {
  void *old, *now;
  memcpy(&old, p, sizeof old);
  now = ylm_realloc(old, used, room, 1);
  if (!now) return false;
  memcpy(p, &now, sizeof now);
  return true;
}

ylm_status ylm__dynamic_reserve(ylm_grid *g) {
  grid_dynamic *d = g->dynamic;
  if (!d || g->points <= d->room) return YLM_OK;
  size_t was = d->room, room = g->points + g->points / 4, row = d->bends * sizeof(float);
  if (room > SIZE_MAX / (row + 8)) return YLM_ENOMEM;
  if (row && !grow(&d->hessian, was * row, room * row)) return YLM_ENOMEM;
  if (!grow(&d->sign, was * sizeof *d->sign, room * sizeof *d->sign)) return YLM_ENOMEM;
  if (!grow(&d->size, was * sizeof(float), room * sizeof(float)) ||
      !grow(&d->drift, was * sizeof(float), room * sizeof(float)))
    return YLM_ENOMEM;
  for (size_t m = 0; m < d->movers; m++)
    if (!grow(&d->mover[m].seen, was, room)) return YLM_ENOMEM;
  d->room = room;
  return YLM_OK;
}

bool ylm__dynamic_bends(const ylm_grid *g) { return g->dynamic && g->dynamic->bends > 0; }

/* Coefficient i's six numbers of channel c of the metric, out of a block's row of `channels`. */
static void metric_hessian(const ylm_grid *g, int channels, const float *row, size_t c, size_t i,
                           float out[6]) {
  static const float weight[3] = {(float)YLM_LUMINANCE_R, (float)YLM_LUMINANCE_G,
                                  (float)YLM_LUMINANCE_B};
  size_t count = (size_t)g->view.count;
  bool mix = channels == 3 && g->view.form.metric_channels == 1;
  for (size_t a = 0; a < 6; a++) {
    if (!mix) {
      out[a] = row[(c * count + i) * 6 + a];
      continue;
    }
    out[a] = 0;
    for (size_t k = 0; k < 3; k++) out[a] += weight[k] * row[(k * count + i) * 6 + a];
  }
}

/* Writes or adds a block's Hessians. */
static void put_hessian(ylm_grid *g, uint32_t p, const field_block *k, size_t i, bool add) {
  grid_dynamic *d = g->dynamic;
  if (!d->bends) return;
  const float *row = k->hessian + i * 6 * (size_t)k->hessian_channels * (size_t)g->view.count;
  float *to = d->hessian + p * d->bends, h[6];
  size_t count = (size_t)g->view.count, channels = (size_t)g->view.form.metric_channels;
  for (size_t c = 0; c < channels; c++)
    for (size_t j = 0; j < count; j++, to += 6) {
      metric_hessian(g, k->hessian_channels, row, c, j, h);
      for (size_t a = 0; a < 6; a++) to[a] = h[a] + (add ? to[a] : 0);
    }
}

static double norm_of(const float *row, size_t n) {
  double s = 0;
  for (size_t i = 0; i < n; i++) s += (double)row[i] * (double)row[i];
  return sqrt(s);
}

static void all_current(grid_dynamic *d, uint32_t p) {
  for (size_t m = 0; m < d->movers; m++) d->mover[m].seen[p] = (uint8_t)d->mover[m].current;
}

void ylm__dynamic_store(ylm_grid *g, uint32_t p, const field_block *k, size_t i) {
  grid_dynamic *d = g->dynamic;
  put_hessian(g, p, k, i, false);
  d->size[p] = (float)norm_of(ylm__grid_row(g, p, 0), g->width);
  d->drift[p] = 0;
  ylm__dynamic_sign(g, p);
  all_current(d, p);
}

void ylm__dynamic_add(ylm_grid *g, uint32_t p, const field_block *k, size_t i) {
  size_t w = g->width;
  double exact[3], before = 0, change = 0;
  float d[3], *to = g->data + (size_t)p * 4 * g->stride;
  const float *value = k->value + i * w, *slope = k->gradient + i * w * 3;
  ylm_grid_position(g, g->lattice + 3 * (size_t)p, exact);
  for (size_t a = 0; a < 3; a++) d[a] = (float)(exact[a] - (double)k->position[3 * i + a]);
  before = norm_of(to, w);
  change = norm_of(value, w);
  for (size_t c = 0; c < w; c++) {
    to[c] += value[c] + (d[0] * slope[3 * c] + d[1] * slope[3 * c + 1] + d[2] * slope[3 * c + 2]);
    for (size_t a = 0; a < 3; a++) to[(a + 1) * g->stride + c] += slope[3 * c + a];
  }
  put_hessian(g, p, k, i, true);
  g->dynamic->drift[p] += (float)(ROUNDING * (before + change));
}

/* cos(2/3 acos(t)) for t = (1+u)/2 in 0 .. 1, to 4e-9: Chebyshev interpolation (csrc/light). */
static float third(float u) {
  static const float c[] = {0.766044443f,     0.247409067f,    -0.0155091689f,   0.00246634011f,
                            -0.000504279435f, 0.000116495476f, -2.84967340e-05f, 7.3851101e-06f,
                            -2.49732176e-06f, 7.1227402e-07f};
  float s = c[9];
  for (int i = 8; i >= 0; i--) s = s * u + c[i];
  return s;
}

/* The largest absolute eigenvalue of a symmetric matrix xx xy xz yy yz zz (Smith 1961). */
static double largest_eigenvalue(const float h[6]) {
  double xx = (double)h[0], xy = (double)h[1], xz = (double)h[2], yy = (double)h[3],
         yz = (double)h[4], zz = (double)h[5];
  double mean = (xx + yy + zz) / 3, a = xx - mean, b = yy - mean, c = zz - mean;
  double p2 = (a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6, p = sqrt(p2);
  if (!(p > 0)) return fabs(mean);
  double r =
      (a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)) / (2 * p2 * p);
  float t = (float)(r < -1 ? -1 : r > 1 ? 1 : r);
  double high = mean + 2 * p * (double)third(2 * sqrtf((1 + t) / 2) - 1);
  double low = mean - 2 * p * (double)third(2 * sqrtf((1 - t) / 2) - 1);
  return fmax(fabs(high), fabs(low));
}

void ylm__dynamic_measure(ylm_grid *g, uint32_t p) {
  grid_dynamic *d = g->dynamic;
  static const double weight[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  const float *row = ylm__grid_row(g, p, 0);
  size_t count = (size_t)g->view.count;
  d->size[p] = (float)norm_of(row, g->width);
  ylm__dynamic_sign(g, p);
  if (!d->bends) return;
  double lambda = 0, norm = 0;
  for (size_t i = 0; i < d->bends; i += 6) {
    double e = largest_eigenvalue(d->hessian + p * d->bends + i);
    lambda += e * e;
  }
  bool mix = g->view.form.channels == 3 && g->view.form.metric_channels == 1;
  for (size_t i = 0; i < (mix ? count : g->width); i++) {
    double x = (double)row[i];
    if (mix)
      x = weight[0] * x + weight[1] * (double)row[count + i] +
          weight[2] * (double)row[2 * count + i];
    norm += x * x;
  }
  g->lambda[p] = (float)sqrt(lambda);
  g->norm[p] = (float)sqrt(norm);
}

void ylm__dynamic_move(ylm_grid *g, uint32_t from, uint32_t to) {
  grid_dynamic *d = g->dynamic;
  memcpy(g->lattice + 3 * (size_t)to, g->lattice + 3 * (size_t)from, 3 * sizeof *g->lattice);
  memcpy(g->data + (size_t)to * 4 * g->stride, g->data + (size_t)from * 4 * g->stride,
         4 * g->stride * sizeof *g->data);
  g->lambda[to] = g->lambda[from];
  g->norm[to] = g->norm[from];
  g->flags[to] = g->flags[from];
  if (d->bends)
    memcpy(d->hessian + to * d->bends, d->hessian + from * d->bends, d->bends * sizeof *d->hessian);
  d->size[to] = d->size[from];
  d->drift[to] = d->drift[from];
  d->sign[to] = d->sign[from];
  for (size_t m = 0; m < d->movers; m++) d->mover[m].seen[to] = d->mover[m].seen[from];
}
