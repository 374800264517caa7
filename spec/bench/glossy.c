/*
** glossy.c - a point that glosses, by stages: rows of its material's table, their rotation into the world, the product
** with visibility, product and light in one where the light is far (`far L`), the light from a grid, and light times slices; beside the multiply-adds that a core can do.
*/
#include <math.h>

#include "bench.h"
#include "peak.h"
#include "ylm_geom.h"
#include "ylm_light.h"
#include "ylm_material_table.h"
#include "ylm_sh.h"
#include "ylm_shade.h"

/* Points whose slices are made together, as csrc/shade has them. */
enum { BATCH = 256 };

typedef struct job {
  int lmax, functions;
  size_t count, width;
  const ylm_material_table *table;
  ylm_sh_rotator *rotator;
  ylm_sh_product *product;
  float wo[BATCH][3], frame[BATCH][9];
  float *row, *slice, *V, *out; /* [BATCH][functions][..] */
  const ylm_shade_view *view;
  size_t points;
  const ylm_grid *grid;
  float *L, *radiance;
  const void *factor[BATCH];
} job;

static void rows(void *context) {
  job *j = context;
  ylm_material_table_rows(j->table, BATCH, (const float(*)[3])j->wo, j->row);
}

static void turn(void *context) {
  job *j = context;
  ylm_sh_rotate_each(j->rotator, j->lmax, YLM_FLOAT, BATCH, j->frame, j->functions, true, j->row,
                     j->slice, 1, NULL, NULL);
}

/* Rotation, product and light, of all functions. */
static void by_product(void *context) {
  job *j = context;
  for (int i = 0; i < BATCH; i++) j->factor[i] = j->V + (size_t)i * j->count;
  ylm_sh_rotate_times(j->rotator, j->product, YLM_FLOAT, BATCH, j->frame, j->functions, true,
                      j->row, j->factor, j->slice, NULL, NULL);
}

/* Rotation and integrals under light that all points share, to radiance. */
static void by_integral(void *context) {
  job *j = context;
  const float *light[3] = {j->V, j->V + j->count, j->V + 2 * j->count};
  static const float mix[3][3] = {{1, 0.5f, 0}, {1, 0.7f, 0}, {1, 0.9f, 0}};
  static float out[BATCH][3];
  for (int i = 0; i < BATCH; i++) j->factor[i] = j->V + (size_t)i * j->count;
  ylm_sh_rotate_integrate(j->rotator, j->product, YLM_FLOAT, BATCH, j->frame, j->functions, true,
                          j->row, j->factor, (const void *const *)light, mix, out, NULL, NULL);
}

static void multiply(void *context) {
  job *j = context;
  for (int k = 0; k < j->functions; k++)
    ylm_sh_product_apply(j->product, YLM_FLOAT, BATCH, (const void *[]){j->slice, j->V}, NULL,
                         j->out, 1, NULL, NULL);
}

static void look_up(void *context) {
  job *j = context;
  ylm_grid_query q = {.interpolation = YLM_GRID_HERMITE, .dtype = YLM_FLOAT, .threads = 1};
  if (ylm_grid_sample(j->grid, &q, j->points, ylm_shade_view_positions(j->view), j->L, NULL, NULL,
                      NULL) != YLM_OK)
    exit(1);
}

/* All but the light. */
static void shade(void *context) {
  job *j = context;
  if (ylm_shade_coefficients(j->view, 0, j->points, 3, j->lmax, YLM_FLOAT, j->L, 1, j->radiance) !=
      YLM_OK)
    exit(1);
}

static void whole(void *context) {
  job *j = context;
  if (ylm_shade_grid(j->view, j->grid, YLM_SHADE_TRANSFER, YLM_GRID_HERMITE, NULL, 1, NULL,
                     j->radiance, NULL, NULL) != YLM_OK)
    exit(1);
}

/* Views of the upper hemisphere, and frames of normals everywhere. */
static void make_views(job *j) {
  ylm_rng r;
  ylm_rng_seed(&r, 7, 1);
  for (size_t i = 0; i < BATCH; i++) {
    double z = 0.02 + 0.98 * ylm_rng_double(&r), q[4], m[9];
    j->wo[i][0] = (float)sqrt(1 - z * z), j->wo[i][1] = 0, j->wo[i][2] = (float)z;
    for (int a = 0; a < 4; a++) q[a] = 2 * ylm_rng_double(&r) - 1;
    ylm_sh_rotation_from_quaternion(q, m, NULL);
    for (int a = 0; a < 9; a++) j->frame[i][a] = (float)m[a];
  }
}

/* A knot that glosses, alone. */
static ylm_scene *knot(const ylm_material *m) {
  ylm_mesh *mesh = NULL;
  ylm_scene *scene = NULL;
  ylm_scene_lamps none = {0};
  if (ylm_mesh_knot(2, 3, 2, 0.8, 0.35, 300, 50, &mesh, NULL) != YLM_OK) exit(1);
  ylm_scene_mesh part = {.positions = mesh->position,
                         .normals = mesh->normal,
                         .vertices = mesh->vertices,
                         .triangles = mesh->index,
                         .count = mesh->triangles,
                         .material = m,
                         .occludes = true};
  if (ylm_scene_create(1, &part, &none, &scene, NULL) != YLM_OK) exit(1);
  ylm_mesh_free(mesh);
  return scene;
}

static ylm_shade_view *look(const ylm_scene *scene, int lmax, bool shadows) {
  ylm_camera camera = {.from = {0, -9, 3}, .at = {0, 0, 0}, .up = {0, 0, 1}, .fov = 40};
  ylm_shade_options o = {.width = 48,
                         .height = 36,
                         .samples = 1,
                         .lmax = lmax,
                         .visibility = shadows ? YLM_SHADE_PIXEL : YLM_SHADE_UNSHADOWED,
                         .transfer_samples = 64,
                         .occlusion_distance = INFINITY,
                         .share = 1,
                         .gloss = true,
                         .threads = 1};
  ylm_shade_view *v = NULL;
  if (ylm_shade_view_create(scene, &camera, &o, &v, NULL) != YLM_OK) exit(1);
  return v;
}

/* A uniform grid about the knot under two lamps. */
static ylm_grid *bake(int lmax) {
  const double at[6] = {3, -4, 4, -5, -3, 2}, radius[2] = {0.5, 0.3}, e[6] = {9, 8, 7, 5, 6, 9};
  ylm_light_set *lights = NULL;
  ylm_grid *g = NULL;
  if (ylm_light_set_spheres(2, at, radius, e, &lights, NULL) != YLM_OK) exit(1);
  ylm_grid_form form = {.kind = YLM_GRID_UNIFORM,
                        .bounds = {-3.2, -3.2, -1.5, 3.2, 3.2, 1.5},
                        .lmax = lmax,
                        .channels = 3,
                        .cells = {8, 8, 4}};
  ylm_grid_source source = {.field = ylm_light_set_field(lights), .threads = 1};
  if (ylm_grid_bake(&form, &source, &g, NULL) != YLM_OK) exit(1);
  ylm_light_set_free(lights);
  return g;
}

/* Shades what a camera sees: ns a point without its light, and with it. */
static void see(job *j, const ylm_scene *scene, bool shadows, double ns[2]) {
  ylm_shade_view *v = look(scene, j->lmax, shadows);
  ylm_shade_stats s;
  ylm_shade_view_stats(v, &s);
  j->view = v, j->points = s.points;
  j->L = ylm_alloc(s.points * 3 * j->count, sizeof(float));
  j->radiance = ylm_alloc(s.points, 12);
  if (!j->L || !j->radiance) exit(1);
  look_up(j);
  ns[0] = 1e9 * bench_seconds(shade, j) / (double)s.points;
  ns[1] = 1e9 * bench_seconds(whole, j) / (double)s.points;
  ylm_free(j->L), ylm_free(j->radiance);
  ylm_shade_view_free(v);
}

static void measure(const ylm_material *m, const ylm_scene *scene, int lmax) {
  static job j;
  ylm_material_table_facts f;
  j = (job){.lmax = lmax, .count = ylm_sh_count(lmax)};
  if (ylm_material_table_kept(m, lmax, 1, NULL, &j.table, NULL) != YLM_OK ||
      ylm_sh_rotator_create(lmax, &j.rotator, NULL) != YLM_OK ||
      ylm_sh_product_create(lmax, 2, YLM_SH_PRODUCT_auto, YLM_SH_PRODUCT_auto, &j.product, NULL) !=
          YLM_OK)
    exit(1);
  ylm_material_table_look(j.table, &f);
  j.functions = f.functions, j.width = f.width;
  j.row = ylm_alloc(BATCH * 3 * f.width, sizeof(float));
  j.slice = ylm_alloc(BATCH * 3 * j.count, sizeof(float));
  j.V = ylm_alloc(BATCH * j.count, sizeof(float));
  j.out = ylm_alloc(BATCH * j.count, sizeof(float));
  if (!j.row || !j.slice || !j.V || !j.out) exit(1);
  make_views(&j);
  bench_fill(YLM_FLOAT, j.V, BATCH * j.count);
  double each = 1e9 / BATCH / f.functions, a = each * bench_seconds(rows, &j);
  double b = each * bench_seconds(turn, &j), c = each * bench_seconds(multiply, &j);
  double open[2], shadows[2], each_point = 1e9 / BATCH;
  double d = each_point * bench_seconds(by_product, &j),
         far = each_point * bench_seconds(by_integral, &j);
  j.grid = bake(lmax);
  see(&j, scene, false, open);
  see(&j, scene, true, shadows);
  printf("%4d  %9d  %5.1f  %5.1f  %7.1f  %7.1f  %7.1f  %7.1f  %7.1f  %7.1f  %7.1f\n", lmax,
         f.functions, a, b, c, d, far, open[0], shadows[0], open[1], shadows[1]);
  fflush(stdout);
  ylm_grid_free((ylm_grid *)(uintptr_t)j.grid);
  ylm_sh_rotator_free(j.rotator), ylm_sh_product_free(j.product);
  ylm_free(j.row), ylm_free(j.slice), ylm_free(j.V), ylm_free(j.out);
}

int main(void) {
  static const int degrees[] = {4, 8, 9, 14};
  static const float gold[] = {0.3f, 0.3f, 1, 0.78f, 0.34f, 0, 0, 0, 1};
  ylm_material *m = NULL;
  if (ylm_material_create(ylm_material_kind_find("ggx"), 9, gold, &m, NULL) != YLM_OK) return 1;
  ylm_scene *scene = knot(m);
  printf("GGX of roughness 0.3, coloured; one thread, %.1f multiply-adds a ns\n",
         bench_peak(ylm_isa_current(), YLM_FLOAT));
  printf("      table's      ns a function       turned, ns a point      ns a point        with a "
         "grid's light\n");
  printf("lmax  functions   rows   turn  product  product    far L     open  shadows     open  "
         "shadows\n");
  for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) measure(m, scene, degrees[i]);
  ylm_scene_free(scene);
  ylm_material_free(m);
  return 0;
}
