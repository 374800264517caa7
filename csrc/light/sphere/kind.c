/* kind.c - spheres as a kind of light. A record: radiance [3], at [3], radius. */
#include "../kind.h"

#include <math.h>
#include <string.h>

#include "ylm_vector.h"

enum { NUMBERS = 7 };

static size_t length(const double *x, size_t left) {
  (void)x;
  return left < NUMBERS ? 0 : NUMBERS;
}

ylm_status ylm__sphere_pack(size_t n, const double *at, const double *radius,
                            const double *radiance, ylm__light_pack *p, ylm_error *e) {
  ylm_lights *l;
  ylm_status s = ylm_lights_create(n, at, radius, radiance, &l, e);
  if (s == YLM_OK) *p = (ylm__light_pack){&ylm__sphere_kind, l, &l->field, n, 0};
  return s;
}

static ylm_status create(size_t n, const double *const *record, ylm__light_pack *p, ylm_error *e) {
  double *x = ylm_alloc(n, NUMBERS * sizeof *x), *at = x, *radius = x + 3 * n, *rgb = x + 4 * n;
  if (!x) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    memcpy(rgb + 3 * i, record[i], 3 * sizeof *x);
    memcpy(at + 3 * i, record[i] + 3, 3 * sizeof *x);
    radius[i] = record[i][6];
  }
  ylm_status s = ylm__sphere_pack(n, at, radius, rgb, p, e);
  ylm_free(x);
  return s;
}

static void release(void *of) { ylm_lights_free(of); }

static ylm_status evaluate(const void *of, ylm_isa isa, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm_lights_evaluate(of, isa, q, n, points, r, e);
}

static const ylm_light_shape bare = {&ylm__sphere_kind, 0, false};

static size_t get(const void *of, size_t i, ylm_light *out, ylm_light_shape *shape) {
  const ylm_lights *l = of;
  const ylm__lamp_d *from = &l->all[i];
  (void)shape; /* place and size are all */
  *out = (ylm_light){.radius = from->radius, .shape = &bare};
  memcpy(out->at, from->at, sizeof out->at);
  memcpy(out->radiance, from->rgb, sizeof out->radiance);
  return 0;
}

static ylm_status surfaces(const void *of, size_t i, ylm_light_surfaces *out) {
  ylm_light sphere;
  get(of, i, &sphere, NULL);
  return ylm__surfaces_sphere(out, &sphere);
}

static void lamp(const void *of, size_t i, ylm_light_lamp *out) {
  const ylm_lights *l = of;
  const ylm__lamp_d *s = &l->all[i];
  *out = (ylm_light_lamp){.radius = s->radius};
  memcpy(out->at, s->at, sizeof out->at);
  memcpy(out->radiance, s->rgb, sizeof out->radiance);
}

static void device(const void *of, ylm_light_part *out) {
  const ylm_lights *l = of;
  out->lamps = l->n;
  out->lamp = lamp;
  out->of = of;
}

static size_t record(const ylm_light *l, const double radiance[3], double *to) {
  if (!to) return NUMBERS;
  memcpy(to, radiance, 3 * sizeof *to);
  memcpy(to + 3, l->at, sizeof l->at);
  to[6] = l->radius;
  return NUMBERS;
}

static bool slides(const ylm_light *a, const ylm_light *b) { return a->radius == b->radius; }
static double reach(const ylm_light *l) { return l->radius; }
static double near(const ylm_light *l) { return YLM__NEAR * l->radius; }

static double distance(const ylm_light *a, const ylm_light *b, const double p[3]) {
  return a == b ? ylm__distance(p, a->at) : ylm__segment_distance(p, a->at, b->at);
}

/* Norms over all orders do not depend on the direction; radius over distance alone decides. */
static const ylm__light_probes probes = {1,
                                         (const double[]){1, 1, 1, 0, 0, 0, 1},
                                         YLM__PROBE_DISTANCES,
                                         1,
                                         ylm__probe_distance,
                                         ylm__probe_cosine};

/* -- rays: numbers of an emitter are its record ---------------------------------------------- */

enum { AT = 3, RADIUS = 6 };

void ylm_light_emitter_sphere(const float radiance[3], const double at[3], double radius,
                              ylm_light_emitter *out) {
  *out = (ylm_light_emitter){.kind = &ylm__sphere_kind, .numbers = NUMBERS};
  for (int c = 0; c < 3; c++) out->x[c] = (double)radiance[c];
  memcpy(out->x + AT, at, 3 * sizeof *at);
  out->x[RADIUS] = radius;
}

static void move(double *x, const double way[3]) {
  for (int a = 0; a < 3; a++) x[AT + a] += way[a];
}

static double power(const double *x) {
  return M_PI * ylm_luminance_size(x) * 4 * M_PI * x[RADIUS] * x[RADIUS];
}

static bool place(const double *x, ylm_light_place *out) {
  *out = (ylm_light_place){.reach = x[RADIUS],
                           .bright = fabs(ylm_luminance(x)) * M_PI * x[RADIUS] * x[RADIUS]};
  memcpy(out->at, x + AT, sizeof out->at);
  return true;
}

/* From a place uniform in the surface, as the cosine to its normal. */
static bool leave(const double *x, const double u[4], ylm_light_leaving *out) {
  double z = 1 - 2 * u[0], r = sqrt(fmax(0, 1 - z * z)), cosine, sine;
  ylm_turn(u[1], &cosine, &sine);
  double n[3] = {r * cosine, r * sine, z}, area = 4 * M_PI * x[RADIUS] * x[RADIUS];
  for (int k = 0; k < 3; k++) {
    out->axis[k] = (double)(float)n[k];
    out->at[k] = x[AT + k] + x[RADIUS] * n[k];
    out->light[k] = x[k];
  }
  out->cosine = sqrt(1 - u[2]);
  out->sine = sqrt(u[2]);
  out->turn = u[3];
  out->extent = M_PI * area;
  return true;
}

static const ylm__light_emits emits = {
    .move = move, .power = power, .place = place, .leave = leave};

const ylm__light_kind ylm__sphere_kind = {.name = "sphere",
                                          .length = length,
                                          .emits = &emits,
                                          .create = create,
                                          .free = release,
                                          .evaluate = evaluate,
                                          .get = get,
                                          .surfaces = surfaces,
                                          .device = device,
                                          .record = record,
                                          .slides = slides,
                                          .reach = reach,
                                          .distance = distance,
                                          .near = near,
                                          .probes = &probes};
