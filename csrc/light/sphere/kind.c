/* kind.c - spheres as a kind of light. A record: radiance [3], at [3], radius. */
#include "../kind.h"

#include <math.h>
#include <string.h>

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

const ylm__light_kind ylm__sphere_kind = {.name = "sphere",
                                          .length = length,
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
