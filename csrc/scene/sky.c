/*
** sky.c - distant lights: seen by rays that hit nothing, and aimed at.
**
** A tile of a dome, or a cone, is a light. Its weight is the irradiance of a light of its power and
** mean direction: the cosine to that, softened where the light may cross the horizon.
*/
#include <math.h>
#include <string.h>

#include "scene.h"
#include "ylm_light.h"

enum { SPREAD = 3, QUARTER, POWER };

/* -- the lights of the sky --------------------------------------------------------------------- */

/* Tables of a dome that `from` (or NULL) has too are shared. */
static ylm_status make_domes(ylm_scene *s, const ylm_scene *from) {
  ylm_light_dome light;
  size_t n = 0;
  while (ylm_light_set_dome(s->sky, n, &light)) n++;
  s->dome = ylm_alloc_zero(n, sizeof *s->dome);
  if (!s->dome) return YLM_ENOMEM;
  while (s->domes < n) {
    ylm_light_set_dome(s->sky, s->domes, &light);
    const scene_dome *old = from && s->domes < from->domes ? &from->dome[s->domes] : NULL;
    scene_dome *d = &s->dome[s->domes++];
    ylm_status status = YLM_OK;
    if (old && old->light.pack == light.pack) /* its set holds the pack as long as `from` lives */
      ylm__scene_dome_share(old, d);
    else
      status = ylm__scene_dome_create(d, &light);
    if (status != YLM_OK) return status;
    s->sky_lights += d->lights;
  }
  return YLM_OK;
}

static ylm_status make_cones(ylm_scene *s) {
  ylm_light_cone cone;
  size_t n = 0;
  while (ylm_light_set_cone(s->sky, n, &cone)) n++;
  s->cone = ylm_alloc(n, sizeof *s->cone);
  if (!s->cone) return YLM_ENOMEM;
  for (; s->cones < n; s->cones++) ylm_light_set_cone(s->sky, s->cones, &s->cone[s->cones]);
  s->sky_lights += n;
  return YLM_OK;
}

static scene_sky_bound bound_cone(const ylm_light_cone *c) {
  double power = 2 * (1 - c->cosine) * ylm_luminance_size(c->radiance), mean = (1 + c->cosine) / 2;
  double rim = hypot(sqrt(fmax(0, 1 - c->cosine * c->cosine)), c->cosine - mean);
  scene_sky_bound b = {.power = power, .spread = rim * power};
  for (int a = 0; a < 3; a++) b.mean[a] = mean * power * c->axis[a];
  return b;
}

static void put_bound(ylm_scene *s, size_t i, const scene_sky_bound *b) {
  for (int a = 0; a < 3; a++) s->sky_bound[a][i] = (float)b->mean[a];
  s->sky_bound[SPREAD][i] = (float)b->spread;
  s->sky_bound[QUARTER][i] = b->spread > 0 ? (float)(0.25 / b->spread) : 0;
  s->sky_bound[POWER][i] = (float)b->power;
}

static ylm_status make_bounds(ylm_scene *s) {
  size_t padded = (s->sky_lights + YLM_LAMP_CHUNK - 1) / YLM_LAMP_CHUNK * YLM_LAMP_CHUNK, at = 0;
  for (int k = 0; k < 6; k++)
    if (!(s->sky_bound[k] = ylm_alloc_zero(padded, sizeof(float)))) return YLM_ENOMEM;
  for (size_t k = 0; k < s->domes; k++)
    for (size_t i = 0; i < s->dome[k].lights; i++) put_bound(s, at++, &s->dome[k].bound[i]);
  for (size_t i = 0; i < s->cones; i++) {
    scene_sky_bound b = bound_cone(&s->cone[i]);
    put_bound(s, at++, &b);
  }
  return YLM_OK;
}

ylm_status ylm__scene_share_sky(ylm_scene *s, const ylm_scene_lamps *l, const ylm_scene *from) {
  if (!l->sky || !ylm_light_set_is_distant(l->sky)) return YLM_OK;
  ylm_status status = ylm_light_set_create(1, &(ylm_light_source){.set = l->sky}, &s->sky, NULL);
  s->sky_is_seen = l->sky_is_seen;
  if (status == YLM_OK) status = make_domes(s, from);
  if (status == YLM_OK) status = make_cones(s);
  return status == YLM_OK ? make_bounds(s) : status;
}

void ylm__scene_free_sky(ylm_scene *s) {
  for (size_t k = 0; s->dome && k < s->domes; k++) ylm__scene_dome_free(&s->dome[k]);
  for (int k = 0; k < 6; k++) ylm_free(s->sky_bound[k]);
  ylm_free(s->dome);
  ylm_free(s->cone);
  ylm_light_set_free(s->sky);
}

bool ylm_scene_sky_radiance(const ylm_scene *s, const ylm_trace_ray *ray, double radiance[3]) {
  double d[3], length = 0;
  if (!s->sky || !s->sky_is_seen) return false;
  for (int a = 0; a < 3; a++) length += (double)ray->dir[a] * (double)ray->dir[a];
  for (int a = 0; a < 3; a++) d[a] = (double)ray->dir[a] / sqrt(length);
  ylm_light_set_sky(s->sky, d, true, radiance);
  return true;
}

/* -- weights ----------------------------------------------------------------------------------- */

/* The sum of a chunk's weights, in lanes. */
static double sum_of(const float *weight) {
  enum { LANES = 8 };
  double lane[LANES] = {0}, sum = 0;
  for (size_t i = 0; i < YLM_LAMP_CHUNK; i += LANES)
    for (size_t k = 0; k < LANES; k++) lane[k] += (double)weight[i + k];
  for (size_t k = 0; k < LANES; k++) sum += lane[k];
  return sum;
}

/* With the cosine to the mean x and the spread s, times power: x above s, 0 below -s, and a parabola
   between them that meets both. Padding keeps the weight 0 that it has. */
static void weigh(const ylm_scene_chooser *c, bool one, float *restrict weight, float *sum) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal;
  (void)one;
  float *const *b = s->sky_bound;
  const float *restrict x0 = b[0], *restrict x1 = b[1], *restrict x2 = b[2];
  const float *restrict spreads = b[SPREAD], *restrict quarter = b[QUARTER];
  for (size_t chunk = 0; chunk * YLM_LAMP_CHUNK < s->sky_lights; chunk++) {
    size_t first = chunk * YLM_LAMP_CHUNK, left = s->sky_lights - first;
    size_t end = left < YLM_LAMP_CHUNK ? s->sky_lights : first + YLM_LAMP_CHUNK;
    if (n) {
      const float n0 = n[0], n1 = n[1], n2 = n[2];
      for (size_t i = first; i < end; i++) {
        float x = n0 * x0[i] + n1 * x1[i] + n2 * x2[i], spread = spreads[i];
        float over = x + spread, most = 2 * spread;
        over = over > 0 ? over : 0;
        float soft = over < most ? over : most;
        weight[i] = soft * soft * quarter[i] + (over - soft);
      }
    } else
      memcpy(weight + first, b[POWER] + first, (end - first) * sizeof *weight);
    sum[chunk] = (float)sum_of(weight + first);
  }
}

/* -- rays -------------------------------------------------------------------------------------- */

/* The dome that has light *i, which comes to count from its first; NULL: a cone, counted from 0. */
static const scene_dome *dome_of(const ylm_scene *s, size_t *i) {
  for (size_t k = 0; k < s->domes; k++) {
    if (*i < s->dome[k].lights) return &s->dome[k];
    *i -= s->dome[k].lights;
  }
  return NULL;
}

static size_t cells_of(const scene_dome *d) { return d->cells[0] * d->cells[1]; }

/* Cells of the domes before one. */
static size_t cells_before(const ylm_scene *s, const scene_dome *d) {
  size_t n = 0;
  for (const scene_dome *k = s->dome; k < d; k++) n += cells_of(k);
  return n;
}

size_t ylm__scene_sky_cells(const ylm_scene *s) { return cells_before(s, s->dome + s->domes); }

static void widen(const float d[3], double out[3]) {
  for (int a = 0; a < 3; a++) out[a] = (double)d[a];
}

static void narrow(const double d[3], float out[3]) {
  for (int a = 0; a < 3; a++) out[a] = (float)d[a];
}

static double aim_at_cone(const ylm_light_cone *c, double u0, double u1, float direction[3],
                          float radiance[3]) {
  float axis[3];
  narrow(c->axis, axis);
  narrow(c->radiance, radiance);
  ylm__scene_turn(axis, 1 - u0 * (1 - c->cosine), u1, direction);
  return 2 * YLM_PI * (1 - c->cosine);
}

/* As the cosine where there is a normal. */
static double aim_at_uniform(const scene_dome *d, const float *n, double u0, double u1,
                             float direction[3], float radiance[3]) {
  double wide[3], rgb[3];
  ylm__scene_turn(n ? n : (const float[]){0, 0, 1}, n ? sqrt(1 - u0) : 1 - 2 * u0, u1, direction);
  widen(direction, wide);
  ylm_light_dome_radiance(&d->light, wide, rgb);
  narrow(rgb, radiance);
  if (!n) return 4 * YLM_PI;
  double cosine = (double)ylm_dot3(direction, n);
  return cosine > 0 ? YLM_PI / cosine : 0;
}

/* A pixel of a tile, which is chosen among several as the factors of their cells (Talbot et al. 2005); *u becomes the rest of
   it; *scale: how much less often a pixel is chosen than one of the tile's would be. */
static size_t seen_pixel(const scene_dome *d, size_t tile, const float *seen, double u[2],
                         double *scale) {
  size_t pixel[DOME_LOOKS], cell[DOME_LOOKS], k = 0;
  double rest[DOME_LOOKS], factor[DOME_LOOKS], sum = 0;
  ylm__scene_dome_looks(d, tile, u[0], pixel, rest, cell);
  for (size_t i = 0; i < DOME_LOOKS; i++) sum += factor[i] = (double)seen[cell[i]];
  double target = u[1] * sum;
  while (k + 1 < DOME_LOOKS && target >= factor[k]) target -= factor[k++];
  u[0] = rest[k], u[1] = fmin(target / factor[k], SCENE_BELOW_ONE);
  *scale = sum / (DOME_LOOKS * factor[k]);
  return pixel[k];
}

static double aim_at_tile(const scene_dome *d, size_t tile, const float *seen, double u[2],
                          float direction[3], float radiance[3]) {
  double wide[3], rgb[3], spread, scale = 1;
  size_t pixel =
      seen ? seen_pixel(d, tile, seen, u, &scale) : ylm__scene_dome_pixel(d, tile, u[0], &u[0]);
  double share = (double)d->share[pixel];
  if (!(share > 0)) return 0;
  if (!ylm_mapping_within(d->mapping, d->up, d->width, d->height, pixel, u[0], u[1], wide, &spread))
    return 0;
  ylm__scene_dome_radiance(d, pixel, wide, rgb);
  narrow(wide, direction);
  narrow(rgb, radiance);
  return scale * spread / share;
}

/* A direction to distant light i and its radiance there; 1 over the density, sr; 0: there is none. */
static double aim(const ylm_scene *s, size_t i, const scene_aim *to, float direction[3],
                  float radiance[3]) {
  const scene_dome *d = dome_of(s, &i);
  double u[2] = {to->u[0], to->u[1]};
  if (!d) return aim_at_cone(&s->cone[i], u[0], u[1], direction, radiance);
  if (d->light.uniform) return aim_at_uniform(d, to->normal, u[0], u[1], direction, radiance);
  return aim_at_tile(d, i, to->seen ? to->seen + cells_before(s, d) : NULL, u, direction, radiance);
}

static double sample(const ylm_scene *s, size_t i, const scene_aim *to, ylm_trace_ray *ray,
                     float radiance[3]) {
  size_t at = i;
  const scene_dome *d = dome_of(s, &at);
  const float *n = to->normal;
  double area = aim(s, i, to, ray->dir, radiance);
  for (int a = 0; a < 3; a++) ray->org[a] = to->x[a];
  ray->near = 0;
  ray->far = INFINITY;
  if (!(area > 0) || !n) return area;
  return d && d->light.uniform ? YLM_PI : fmax(0, (double)ylm_dot3(ray->dir, n)) * area;
}

/* -- directions -------------------------------------------------------------------------------- */

static bool in_cone(const ylm_light_cone *c, const double d[3]) {
  return c->axis[0] * d[0] + c->axis[1] * d[1] + c->axis[2] * d[2] >= c->cosine;
}

/* The pixel that a direction falls into. */
static bool pixel_at(const scene_dome *d, const double direction[3], size_t *pixel) {
  return ylm_mapping_pixel(d->mapping, d->up, d->width, d->height, direction, pixel);
}

bool ylm__scene_sky_cell(const ylm_scene *s, size_t i, const float direction[3], size_t *cell) {
  const scene_dome *d = dome_of(s, &i);
  double wide[3];
  size_t pixel;
  widen(direction, wide);
  if (!d || d->light.uniform || !pixel_at(d, wide, &pixel)) return false;
  *cell = cells_before(s, d) + ylm__scene_dome_cell(d, pixel);
  return true;
}

static double density(const ylm_scene_chooser *c, size_t i, const float direction[3]) {
  const ylm_scene *s = c->scene;
  const float *n = c->in_space ? NULL : c->normal;
  const scene_dome *d = dome_of(s, &i);
  double wide[3];
  size_t pixel;
  widen(direction, wide);
  if (!d) return in_cone(&s->cone[i], wide) ? 1 / (2 * YLM_PI * (1 - s->cone[i].cosine)) : 0;
  if (d->light.uniform)
    return n ? fmax(0, (double)ylm_dot3(direction, n)) / YLM_PI : 1 / (4 * YLM_PI);
  if (!pixel_at(d, wide, &pixel) || ylm__scene_dome_tile(d, pixel) != i) return 0;
  double area = ylm_mapping_spread(d->mapping, d->up, d->width, d->height, pixel, wide);
  return area > 0 ? (double)d->share[pixel] / area : 0;
}

static size_t count(const ylm_scene *s) { return s->sky_lights; }

static bool emitter(const ylm_scene *s, size_t i, ylm_light_emitter *out) {
  if (dome_of(s, &i)) return false;
  ylm_light_emitter_cone(&s->cone[i], out);
  return true;
}

const scene_storage ylm__scene_sky_storage = {count, weigh, sample, density, emitter};

double ylm_scene_distant_ray(const ylm_scene *s, size_t i, const double u[2], float direction[3],
                             float radiance[3]) {
  const scene_aim a = {.x = (const float[]){0, 0, 0}, .u = {u[0], u[1]}, .one = true};
  ylm_trace_ray ray;
  double area = sample(s, i, &a, &ray, radiance);
  memcpy(direction, ray.dir, sizeof ray.dir);
  return area;
}

double ylm_scene_distant_power(const ylm_scene *s, size_t i) {
  return YLM_PI * (double)s->sky_bound[POWER][i]; /* times power over pi */
}

const ylm_light_set *ylm_scene_sky(const ylm_scene *s) { return s->sky; }

/* Where a dome shines from a direction: the light of it, and its radiance. */
static size_t light_at(const scene_dome *d, const double direction[3], double rgb[3]) {
  size_t pixel = 0;
  if (!d->light.uniform && !pixel_at(d, direction, &pixel)) return d->lights;
  ylm__scene_dome_radiance(d, pixel, direction, rgb);
  return d->light.uniform ? 0 : ylm__scene_dome_tile(d, pixel);
}

size_t ylm_scene_distant(const ylm_scene *s) { return s->sky_lights; }

size_t ylm_scene_distant_next(const ylm_scene *s, size_t i, const float direction[3],
                              float radiance[3]) {
  double wide[3], rgb[3];
  size_t first = 0;
  widen(direction, wide);
  for (size_t k = 0; k < s->domes; first += s->dome[k++].lights) {
    if (i >= first + s->dome[k].lights) continue;
    size_t at = light_at(&s->dome[k], wide, rgb);
    if (first + at < i || at == s->dome[k].lights) continue;
    narrow(rgb, radiance);
    return first + at;
  }
  for (size_t k = i > first ? i - first : 0; k < s->cones; k++) {
    if (!in_cone(&s->cone[k], wide)) continue;
    narrow(s->cone[k].radiance, radiance);
    return first + k;
  }
  return s->sky_lights;
}
