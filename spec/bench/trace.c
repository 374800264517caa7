/*
** trace.c - rays a second and thread by kind, in scenes of few and of many triangles, and the lamps
** that rays meet, among a few and along floors of hundreds.
*/
#include <math.h>

#include "bare.h"
#include "ylm_geom.h"

#define RAYS (1 << 16)

/* The meshes of one scene, all occluders, as one. */
typedef struct place {
  const char *name;
  ylm_mesh *mesh[32];
  int meshes;
} place;

static ylm_trace *trace_of(place *p, const ylm_trace_lamps *lamps) {
  ylm_trace_mesh m[32];
  ylm_trace *t = NULL;
  for (int i = 0; i < p->meshes; i++)
    m[i] = (ylm_trace_mesh){p->mesh[i]->position, p->mesh[i]->vertices, p->mesh[i]->index,
                            p->mesh[i]->triangles, true};
  if (ylm_trace_create((size_t)p->meshes, m, lamps, &t, NULL) != YLM_OK) exit(1);
  return t;
}

static void add(place *p, ylm_status s) {
  if (s != YLM_OK) exit(1);
  p->meshes++;
}

/* A closed box with 24 balls in it. */
static void make_room(place *p) {
  ylm_rng r;
  ylm_rng_seed(&r, 5, 5);
  double lo[3] = {-2, -2, -2}, hi[3] = {2, 2, 2};
  add(p, ylm_mesh_box(lo, hi, 16, &p->mesh[0], NULL));
  for (int k = 0; k < 24; k++) {
    double m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    for (int a = 0; a < 3; a++) m[4 * a + 3] = 3.4 * ylm_rng_double(&r) - 1.7;
    add(p, ylm_mesh_sphere(0.25, 32, 16, &p->mesh[p->meshes], NULL));
    if (ylm_mesh_transform(p->mesh[p->meshes - 1], m, NULL) != YLM_OK) exit(1);
  }
}

/* Rays from random vertices, each from another, `together` from one: cosine about the normal
   (inwards at the walls of a room). */
static void from_surfaces(const place *p, int together, ylm_trace_ray *ray) {
  ylm_rng r;
  ylm_rng_seed(&r, 3, 3);
  const ylm_mesh *m = NULL;
  size_t v = 0;
  for (size_t i = 0; i < RAYS; i++) {
    if (i % (size_t)together == 0) {
      m = p->mesh[ylm_rng_u32(&r) % (uint32_t)p->meshes];
      v = ylm_rng_u32(&r) % m->vertices;
    }
    double side = p->meshes > 1 && m == p->mesh[0] ? -1 : 1, d2 = 0;
    double z = 2 * ylm_rng_double(&r) - 1, phi = 6.28318531 * ylm_rng_double(&r);
    double s = sqrt(1 - z * z), d[3] = {s * cos(phi), s * sin(phi), z};
    const float *n = m->normal + 3 * v;
    for (int a = 0; a < 3; a++) d[a] += side * (double)n[a], d2 += d[a] * d[a];
    ray[i] = (ylm_trace_ray){.far = INFINITY};
    for (int a = 0; a < 3; a++) {
      ray[i].dir[a] = (float)(d[a] / sqrt(d2));
      ray[i].org[a] = m->position[3 * v + (size_t)a] * 0.999f + (float)side * 1e-4f * n[a];
    }
  }
}

/* A camera at `from` looks at the origin: rows of pixels. */
static void from_camera(double from, ylm_trace_ray *ray) {
  for (int i = 0; i < RAYS; i++) {
    double d[3] = {(i % 256 - 127.5) / 256, -1, (i / 256 - 127.5) / 256};
    ray[i] = (ylm_trace_ray){.org = {0, (float)from, 0}, .far = INFINITY};
    for (int a = 0; a < 3; a++) ray[i].dir[a] = (float)d[a];
  }
}

/* `count` spheres about the origin, or a floor of touching disks and spheres at height 0. */
static ylm_trace_lamps make_lamps(size_t count, bool floor, float *x) {
  ylm_rng r;
  ylm_rng_seed(&r, 7, 7);
  for (size_t i = 0; i < count; i++) {
    for (int a = 0; a < 3; a++) x[4 * i + (size_t)a] = (float)(4 * ylm_rng_double(&r) - 2);
    x[4 * i + 3] = floor ? 0.1f : 0.03f;
    if (floor) x[4 * i + 2] = 0;
  }
  return (ylm_trace_lamps){.spheres = count, .sphere = x};
}

static double rate(bench_fn *fn, bare_rays *b) {
  return (double)b->n / bench_seconds(fn, b) * 1e-6;
}

static void kinds(place *p, double from, ylm_trace_ray *ray, float *lamp) {
  ylm_trace_lamps lamps = make_lamps(64, false, lamp);
  ylm_trace *t = trace_of(p, &lamps);
  bare_rays b = {t, RAYS, ray, 0};
  size_t triangles = 0;
  for (int i = 0; i < p->meshes; i++) triangles += p->mesh[i]->triangles;
  printf("  %-8s %7zu", p->name, triangles);
  from_surfaces(p, 256, ray);
  printf("  %7.2f", rate(bare_occluded, &b));
  from_surfaces(p, 1, ray);
  printf("  %7.2f", rate(bare_occluded, &b));
  printf("  %7.2f", rate(bare_nearest, &b));
  printf("  %7.2f", rate(bare_first, &b));
  printf("  %7.2f", rate(bare_lamps, &b));
  from_camera(from, ray);
  printf("  %7.2f\n", rate(bare_camera, &b));
  ylm_trace_free(t);
}

/* Rays through lamps alone; along a floor they run in its plane. */
static void through_lamps(size_t count, bool floor, ylm_trace_ray *ray, float *lamp) {
  place none = {.name = ""};
  ylm_trace_lamps lamps = make_lamps(count, floor, lamp);
  ylm_trace *t = trace_of(&none, &lamps);
  bare_rays b = {t, floor ? 256 : 4096, ray, 0};
  ylm_rng r;
  ylm_rng_seed(&r, 9, 9);
  for (size_t i = 0; i < b.n; i++) {
    double phi = 6.28318531 * ylm_rng_double(&r), z = floor ? 0 : 2 * ylm_rng_double(&r) - 1;
    double s = sqrt(1 - z * z);
    ray[i] = (ylm_trace_ray){.dir = {(float)(s * cos(phi)), (float)(s * sin(phi)), (float)z},
                             .far = INFINITY};
  }
  double seconds = bench_seconds(bare_lamps, &b);
  double each = (double)b.met / (double)b.n;
  printf("  %-7s %7zu  %8.2f  %9.4f  %7.1f\n", floor ? "a floor" : "a cube", count, each,
         (double)b.n / seconds * 1e-6, seconds / (double)b.n / fmax(each, 1e-30) * 1e9);
  ylm_trace_free(t);
}

int main(void) {
  ylm_trace_ray *ray = ylm_alloc(RAYS, sizeof *ray);
  float *lamp = ylm_alloc(4 * 100000, sizeof *lamp);
  place room = {.name = "room"}, knot = {.name = "knot"};
  if (!ray || !lamp) return 1;
  make_room(&room);
  add(&knot, ylm_mesh_knot(2, 3, 2, 0.8, 0.35, 600, 100, &knot.mesh[0], NULL));
  printf("rays, millions a second; one thread; 64 sphere lamps\n"
         "  %-8s %9s  %7s  %7s  %7s  %7s  %7s  %7s\n",
         "scene", "triangles", "shadow*", "shadow", "nearest", "first", "lamps", "camera");
  kinds(&room, 1.9, ray, lamp);
  kinds(&knot, 9, ray, lamp);
  printf(
      "  *: 256 from a point, the others each from another; nearest: among what occludes, first:\n"
      "  with lamps, lamps: all that a ray meets\n");
  printf("all lamps that a ray meets, %d at a time; one thread\n"
         "  %-7s %7s  %8s  %9s  %7s\n",
         BARE_LAMPS, "lamps", "number", "met", "M rays/s", "ns each");
  through_lamps(100, false, ray, lamp);
  through_lamps(10000, false, ray, lamp);
  through_lamps(100000, false, ray, lamp);
  through_lamps(1000, true, ray, lamp);
  through_lamps(10000, true, ray, lamp);
  for (int i = 0; i < room.meshes; i++) ylm_mesh_free(room.mesh[i]);
  ylm_mesh_free(knot.mesh[0]);
  ylm_free(ray), ylm_free(lamp);
  return 0;
}
