/*
** links.c - links of a knot in a room beside bare rays, direct light, and bounces over links at
** random, which is the worst that there is.
*/
#include <math.h>

#include "bench.h"
#include "room.h"
#include "ylm_geom.h"
#include "ylm_transfer.h"

#define LINKS 128
#define ELEMENTS 50000

static ylm_material *matte(float albedo) {
  ylm_material *m = NULL;
  const float numbers[3] = {albedo, albedo, albedo};
  if (ylm_material_create(ylm_material_kind_find("matte"), 3, numbers, &m, NULL) != YLM_OK) exit(1);
  return m;
}

/* A knot in a box, and `lamps` spheres about it. */
static ylm_scene *room(size_t lamps, const ylm_material *m) {
  const double lo[3] = {-3, -3, -2}, hi[3] = {3, 3, 2};
  ylm_mesh *mesh[2];
  ylm_scene *s = NULL;
  float *sphere = ylm_alloc(lamps, 16), *radiance = ylm_alloc(lamps, 12);
  ylm_rng r;
  ylm_rng_seed(&r, 7, 7);
  if (!sphere || !radiance || ylm_mesh_box(lo, hi, 1, &mesh[0], NULL) != YLM_OK ||
      ylm_mesh_knot(2, 3, 1.2, 0.5, 0.25, 150, 40, &mesh[1], NULL) != YLM_OK)
    exit(1);
  for (size_t i = 0; i < lamps; i++) {
    for (int a = 0; a < 3; a++) sphere[4 * i + (size_t)a] = (float)(5.6 * ylm_rng_double(&r) - 2.8);
    sphere[4 * i + 2] *= 0.66f;
    sphere[4 * i + 3] = 0.02f;
    for (int c = 0; c < 3; c++) radiance[3 * i + (size_t)c] = 10;
  }
  const ylm_scene_mesh parts[2] = {bench_part(mesh[0], m), bench_part(mesh[1], m)};
  const ylm_scene_lamps l = {.shape = {.spheres = lamps, .sphere = sphere}, .radiance = radiance};
  if (ylm_scene_create(2, parts, &l, &s, NULL) != YLM_OK) exit(1);
  for (int i = 0; i < 2; i++) ylm_mesh_free(mesh[i]);
  ylm_free(sphere);
  ylm_free(radiance);
  return s;
}

/* -- links beside bare rays ------------------------------------------------------ */

typedef struct task {
  const ylm_scene *scene;
  const ylm_transfer *t;
  ylm_radiosity *lit;
  ylm_transfer_form form;
  ylm_trace_ray *ray;
  ylm_trace_hit *hit;
  size_t n;
  int threads, samples;
} task;

static void make(void *context) {
  task *x = context;
  ylm_transfer *t;
  if (ylm_transfer_create(x->scene, &x->form, &t, NULL) != YLM_OK) exit(1);
  ylm_transfer_free(t);
}

/* Rays from the middle of each element, LINKS at a time: cosine about the normal. */
static void aim(task *x, const float (*centre)[3], const float (*normal)[3]) {
  const ylm_trace *trace = ylm_scene_trace(x->scene);
  ylm_rng r;
  ylm_rng_seed(&r, 3, 3);
  for (size_t i = 0; i < x->n; i++) {
    size_t e = i / LINKS;
    float a[3], b[3];
    double h = ((double)(i % LINKS) + ylm_rng_double(&r)) / LINKS,
           u = 6.28318531 * ylm_rng_double(&r);
    float p = (float)(sqrt(h) * cos(u)), q = (float)(sqrt(h) * sin(u)), z = (float)sqrt(1 - h);
    ylm_scene_basis(normal[e], a, b);
    x->ray[i] = (ylm_trace_ray){.far = INFINITY};
    for (int k = 0; k < 3; k++) {
      x->ray[i].org[k] = centre[e][k] + ylm_trace_offset(trace, centre[e]) * normal[e][k];
      x->ray[i].dir[k] = p * a[k] + q * b[k] + z * normal[e][k];
    }
  }
}

static void bare(void *context) {
  task *x = context;
  for (size_t i = 0; i < x->n; i += 1024)
    ylm_trace_nearest(ylm_scene_trace(x->scene), x->n - i < 1024 ? x->n - i : 1024, x->ray + i,
                      false, x->hit);
}

static void links(task *x) {
  x->n = ylm_transfer_count(x->t) * LINKS;
  x->ray = ylm_alloc(x->n, sizeof *x->ray);
  x->hit = ylm_alloc(1024, sizeof *x->hit);
  float(*centre)[3] = ylm_alloc(x->n / LINKS, 12), (*normal)[3] = ylm_alloc(x->n / LINKS, 12);
  if (!x->ray || !x->hit || !centre || !normal) exit(1);
  ylm_transfer_elements(x->t, centre[0], normal[0], NULL, NULL, NULL);
  aim(x, (const float(*)[3])centre, (const float(*)[3])normal);
  x->form.threads = 1;
  double rays = (double)x->n * 1e-6, least = rays / bench_seconds(bare, x);
  printf("links of %zu elements x %d, a knot in a room; one thread\n", x->n / LINKS, LINKS);
  printf("  %-36s %6.2f M/s\n", "bare nearest hits of such rays", least);
  for (int lmax = -1; lmax <= 4; lmax += 5) {
    x->form.lmax = lmax;
    double rate = rays / bench_seconds(make, x);
    printf("  %-36s %6.2f M/s  %5.2f of it\n",
           lmax < 0 ? "links" : "links with transfer vectors, lmax 4", rate, rate / least);
  }
  ylm_free(x->ray);
  ylm_free(x->hit);
  ylm_free(centre);
  ylm_free(normal);
}

/* Of one thread processor time, of more wall time. */
static double seconds_of(bench_fn *fn, void *context, int threads) {
  return threads == 1 ? bench_seconds(fn, context) : bench_wall(fn, context);
}

/* -- light -------------------------------------------------------------------------- */

static void direct(void *context) {
  task *x = context;
  if (ylm_radiosity_rays(x->lit, x->scene, x->samples, true, 1, x->threads, NULL, NULL) != YLM_OK)
    exit(1);
}

static void solve(void *context) {
  task *x = context;
  if (ylm_radiosity_solve(x->lit, -1, 1e-3, true, x->threads, NULL, NULL, NULL) != YLM_OK) exit(1);
}

static void light(const ylm_transfer *t, const ylm_material *m) {
  printf("direct light on %zu elements and all bounces (albedo 0.7); milliseconds\n"
         "  %8s  %7s  %9s  %10s  %10s  %10s\n",
         ylm_transfer_count(t), "lamps", "samples", "threads", "direct", "bounces", "how many");
  for (int k = 0; k < 4; k++) {
    task x = {.scene = room(k < 2 ? 1 : 2516, m), .t = t, .threads = 1 + k % 2, .samples = 8};
    ylm_radiosity_stats stats;
    if (ylm_radiosity_create(t, &x.lit) != YLM_OK) exit(1);
    double seconds = seconds_of(direct, &x, x.threads), bounces = seconds_of(solve, &x, x.threads);
    ylm_radiosity_look(x.lit, &stats);
    printf("  %8d  %7d  %9d  %10.1f  %10.1f  %10d\n", k < 2 ? 1 : 2516, x.samples, x.threads,
           1e3 * seconds, 1e3 * bounces, stats.bounces);
    ylm_radiosity_free(x.lit);
    ylm_scene_free((ylm_scene *)x.scene);
  }
}

/* -- sums over links --------------------------------------------------------------- */

typedef struct sums {
  ylm_links link;
  float *in, *out;
  size_t n;
  int width, threads;
} sums;

static void sum(void *context) {
  sums *x = context;
  ylm_transfer_sum(x->n, LINKS, x->link, x->width, x->in, x->in, x->out, x->threads);
}

static void bounce(const char *name, ylm_links link, size_t n) {
  for (int k = 0; k < 4; k++) {
    sums x = {.link = link, .n = n, .width = k < 2 ? 4 : 76, .threads = 1 + k % 2};
    x.in = ylm_alloc_zero((n + 1) * (size_t)x.width, sizeof(float));
    x.out = ylm_alloc_zero((n + 1) * (size_t)x.width, sizeof(float));
    if (!x.in || !x.out) exit(1);
    bench_fill(YLM_FLOAT, x.in, n * (size_t)x.width);
    double seconds = seconds_of(sum, &x, x.threads);
    printf("  %-10s %8zu  %5d  %7d  %8.2f  %8.2f\n", name, n, x.width, x.threads, 1e3 * seconds,
           1e9 * seconds / ((double)n * LINKS));
    ylm_free(x.in);
    ylm_free(x.out);
  }
}

int main(void) {
  ylm_material *m = matte(0.7f);
  ylm_transfer *t;
  ylm_rng r;
  ylm_rng_seed(&r, 1, 1);
  task x = {.scene = room(1, m)};
  x.form = (ylm_transfer_form){.spacing = 0.155, .links = LINKS, .lmax = -1, .seed = 1};
  if (ylm_transfer_create(x.scene, &x.form, &t, NULL) != YLM_OK) return 1;
  x.t = t;
  links(&x);
  uint32_t *link = ylm_alloc((size_t)ELEMENTS * LINKS, sizeof *link);
  if (!link) return 1;
  for (size_t i = 0; i < (size_t)ELEMENTS * LINKS; i++)
    link[i] = (uint32_t)((uint64_t)ylm_rng_u32(&r) * ELEMENTS >> 32);
  printf("a bounce: means of rows over %d links of each element\n"
         "  %-10s %8s  %5s  %7s  %8s  %8s\n",
         LINKS, "links", "elements", "width", "threads", "ms", "ns a link");
  bounce("at random", (ylm_links){.four = link}, ELEMENTS);
  bounce("of a room", ylm_transfer_links(t), ylm_transfer_count(t));
  light(t, m);
  printf("  one thread: processor time; two: wall time\n");
  ylm_free(link);
  ylm_transfer_free(t);
  ylm_scene_free((ylm_scene *)x.scene);
  ylm_material_free(m);
  return 0;
}
