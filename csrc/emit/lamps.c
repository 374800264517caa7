/* lamps.c - lamps and skies as sources of particles. */
#include "emit.h"
#include "ylm_math.h"

static void find_reach(emit_lamps *l) {
  double lo[3], hi[3], s = 0;
  ylm_scene_bounds(l->scene, lo, hi);
  for (int k = 0; k < 3; k++) {
    l->centre[k] = (lo[k] + hi[k]) / 2;
    s += (hi[k] - lo[k]) * (hi[k] - lo[k]) / 4;
  }
  l->reach = 1.0001 * sqrt(s);
}

ylm_status ylm__emit_lamps(const ylm_scene *scene, size_t particles, emit_lamps *l) {
  double sum = 0;
  size_t points = ylm_scene_points(scene, NULL);
  *l =
      (emit_lamps){.scene = scene, .n = ylm_scene_lamps_all(scene), .particles = (double)particles};
  l->points = l->n - points;
  l->upto = ylm_alloc(l->n, sizeof *l->upto);
  l->emitter = ylm_alloc(l->n, sizeof *l->emitter);
  if (!l->upto || !l->emitter) return YLM_ENOMEM;
  find_reach(l);
  for (size_t i = 0; i < l->n; i++) {
    if (ylm_scene_is_distant(scene, i)) {
      sum +=
          YLM_PI * l->reach * l->reach * ylm_scene_distant_power(scene, i - ylm_scene_near(scene));
    } else {
      ylm_scene_emitter(scene, i, &l->emitter[i]);
      sum += ylm_light_emitter_power(&l->emitter[i]);
    }
    l->upto[i] = sum;
  }
  return YLM_OK;
}

void ylm__emit_lamps_free(emit_lamps *l) {
  ylm_free(l->upto);
  ylm_free(l->emitter);
}

/* The lamp that u of 0 .. 1 chooses, and how often it does. */
static size_t choose(const emit_lamps *l, double u, double *chance) {
  double all = l->upto[l->n - 1];
  size_t low = ylm_interval_at(l->n, l->upto, u * all);
  *chance = (l->upto[low] - (low > 0 ? l->upto[low - 1] : 0)) / all;
  return low;
}

static void widen(const float *x, double *out) {
  for (int k = 0; k < 3; k++) out[k] = (double)x[k];
}

/* A particle of a lamp that has a place. Its radiance where rays can meet the lamp is what they would see there. */
static bool leave_lamp(const emit_lamps *l, size_t i, const double *u, ylm_trace_ray *ray,
                       double power[3]) {
  ylm_light_leaving from;
  float radiance[3];
  if (!ylm_light_emitter_leave(&l->emitter[i], u, &from)) return false;
  for (int k = 0; k < 3; k++) ray->org[k] = (float)from.at[k];
  ylm__emit_about(from.axis, from.cosine, from.sine, from.turn, ray->dir);
  if (i < l->points) {
    ylm_trace_ray back = *ray;
    for (int k = 0; k < 3; k++) back.dir[k] = -ray->dir[k];
    if (!ylm_scene_near_radiance(l->scene, &back, (uint32_t)i, 0, radiance)) return false;
    widen(radiance, from.light);
  }
  for (int c = 0; c < 3; c++) power[c] = from.light[c] * from.extent;
  ray->near = from.flat ? ylm_trace_offset(ylm_scene_trace(l->scene), ray->org) : 0;
  return true;
}

/* A particle from infinity, through a disk that the scene fits in. */
static bool leave_sky(const emit_lamps *l, size_t i, const double *u, ylm_trace_ray *ray,
                      double power[3]) {
  float to[3], radiance[3], a[3], b[3];
  double solid = ylm_scene_distant_ray(l->scene, i - ylm_scene_near(l->scene), u, to, radiance);
  double r = l->reach * sqrt(u[2]), x, y;
  ylm_turn(u[3], &x, &y);
  x *= r, y *= r;
  if (!(solid > 0)) return false;
  ylm_scene_basis(to, a, b);
  for (int k = 0; k < 3; k++) {
    ray->org[k] =
        (float)(l->centre[k] + x * (double)a[k] + y * (double)b[k] + l->reach * (double)to[k]);
    ray->dir[k] = -to[k];
  }
  widen(radiance, power);
  for (int c = 0; c < 3; c++) power[c] *= solid * YLM_PI * l->reach * l->reach;
  ray->near = 0;
  return true;
}

bool ylm__emit_texel(const emit_lamps *l, size_t i, ylm_trace_ray *ray, double power[3],
                     double *solid) {
  size_t side = (size_t)l->side, each = side * side;
  const ylm_light_emitter *lamp = &l->emitter[l->points + i / each];
  ylm_light_place place;
  ylm_light_emitter_place(lamp, &place);
  double wide = tan(fmin(acos(place.outer), EMIT_WIDEST)), step = 2 * wide / (double)side;
  double x = step * ((double)(i % side) + 0.5) - wide;
  double y = step * ((double)(i % each / side) + 0.5) - wide;
  double z = 1 / sqrt(1 + x * x + y * y), lit = 0;
  float axis[3], a[3], b[3];
  for (int k = 0; k < 3; k++) axis[k] = (float)place.axis[k];
  ylm_scene_basis(axis, a, b);
  *solid = step * step * z * z * z;
  double way[3];
  for (int k = 0; k < 3; k++) way[k] = z * (x * (double)a[k] + y * (double)b[k] + place.axis[k]);
  ylm_light_emitter_intensity(lamp, way, power);
  for (int k = 0; k < 3; k++) {
    ray->org[k] = (float)place.at[k];
    ray->dir[k] = (float)way[k];
    lit += fabs(power[k]);
    power[k] *= *solid;
  }
  ray->near = ylm_trace_offset(ylm_scene_trace(l->scene), ray->org);
  ray->far = INFINITY;
  return lit > 0;
}

bool ylm__emit_start(const emit_lamps *l, const double u[EMIT_NUMBERS], ylm_trace_ray *ray,
                     double power[3]) {
  double chance;
  if (l->n == 0 || !(l->upto[l->n - 1] > 0)) return false;
  size_t i = choose(l, u[4], &chance);
  if (!(chance > 0)) return false;
  if (!(ylm_scene_is_distant(l->scene, i) ? leave_sky : leave_lamp)(l, i, u, ray, power))
    return false;
  for (int c = 0; c < 3; c++) power[c] = power[c] / chance / l->particles;
  ray->far = INFINITY;
  return true;
}
