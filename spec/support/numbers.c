/*
** numbers.c - numbers that functions of libylm once took, for specs: each has to be refused, and a mesh to stay whole.
**
** Prints a line for each call: its name, its status and its sentence.
*/
#include <math.h>
#include <stdio.h>

#include <ylm/ylm_figure.h>
#include <ylm/ylm_geom.h>
#include <ylm/ylm_grid.h>
#include <ylm/ylm_light.h>
#include <ylm/ylm_light_emitter.h>
#include <ylm/ylm_material.h>
#include <ylm/ylm_sh_exponential.h>
#ifdef SCENE
#include <ylm/ylm_path.h>
#include <ylm/ylm_transfer.h>
#include <ylm/ylm_transfer_adjoint.h>
#endif
#ifdef VTK
#include <ylm/ylm_vtk.h>
#endif

static ylm_error e;

static void say(const char *what, ylm_status s) {
  printf("%s\t%s\t%s\n", what, ylm_status_name(s), e.text);
  e = (ylm_error){YLM_OK, ""};
}

static void images(void) {
  float texel[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  ylm_light_texture zeros = {.width = 0}, t = {.u = {1, 0, 0},
                                               .v = {0, 1, 0},
                                               .width = 2,
                                               .height = 2,
                                               .texel = texel,
                                               .scale = 1,
                                               .largest = 1};
  ylm_light_set *set = NULL;
  size_t parts;
  say("texture of zeros", ylm_light_set_textured(&zeros, true, NULL, &set, &parts, &e));
  t.width = (size_t)-1 / 2 + 1;
  say("texture of many texels", ylm_light_set_textured(&t, true, NULL, &set, &parts, &e));
  t.width = 2, texel[4] = NAN;
  say("texture of no number", ylm_light_set_textured(&t, true, NULL, &set, &parts, &e));
  texel[4] = 1, t.largest = NAN;
  say("texture of parts", ylm_light_set_textured(&t, true, NULL, &set, &parts, &e));
}

static void lights(void) {
  double at[3] = {0, 2, 0}, radius = 0.1, radiance[3] = {1, 1, 1}, origin[3] = {NAN, 0, 0},
         value[12], to[3] = {0, 0, 1};
  float point[3] = {0, 0, 0};
  ylm_light_set *lamps = NULL;
  ylm_light_set_spheres(1, at, &radius, radiance, &lamps, &e);
  ylm_field_query q = {
      .lmax = 1, .channels = 3, .want = YLM_WANT_VALUE, .dtype = YLM_FLOAT, .origin = origin};
  ylm_field_result r = {.value = value};
  say("origin of no number", ylm_field_evaluate(ylm_light_set_field(lamps), &q, 1, point, &r, &e));
  origin[0] = 1e20;
  say("origin far away", ylm_field_evaluate(ylm_light_set_field(lamps), &q, 1, point, &r, &e));
  ylm_light_emitter emitter;
  ylm_light_way way;
  ylm_light_emitter_sphere((float[]){1, 1, 1}, at, radius, &emitter);
  printf("sphere without a direction\t%d\t\n", ylm_light_emitter_toward(&emitter, to, &way));

  ylm_grid_form form = {.kind = YLM_GRID_UNIFORM,
                        .bounds = {-1, -1, -1, 1, 1, 1},
                        .lmax = 1,
                        .channels = 3,
                        .cells = {2, 2, 2}};
  ylm_grid_source source = {.field = ylm_light_set_field(lamps), .threads = 1};
  ylm_grid_probes_places places = {.n = 0};
  ylm_grid_probes *probes = NULL;
  ylm_grid *grid = NULL;
  ylm_grid_bake(&form, &source, &grid, &e);
  say("probes of lmax 65537", ylm_grid_probes_make(grid, 65537, 0, NULL, &places, &probes, &e));
  say("probes of cuts -1", ylm_grid_probes_make(grid, 1, -1, NULL, &places, &probes, &e));
  if (ylm_grid_probes_make(grid, 1, 0, NULL, &places, &probes, &e) == YLM_OK) {
    unsigned char *bytes = NULL;
    size_t size;
    say("probes of 255 bits", ylm_grid_probes_encode(probes, 255, &bytes, &size, &e));
  }
  ylm_grid_probes_free(probes);
  ylm_grid_free(grid);
  ylm_light_set_free(lamps);
}

static void others(void) {
  double in[4] = {0}, out[4], a[2];
  ylm_sh_exponential *x = NULL;
  ylm_sh_exponential_create(1, YLM_SH_EXP_PS, 4, &x, &e);
  say("derivatives -2", ylm_sh_exponential_apply(x, YLM_DOUBLE, 1, -2, in, out, 1, NULL, &e));
  ylm_sh_exponential_free(x);
  say("array of type 9",
      ylm_array_file_write("none.npy", (ylm_dtype)9, 1, (size_t[]){1}, 0, in, &e));
  say("kind 99", ylm_material_transfer(99, 1, a));
  printf("name of kind -1\t%s\t\n", ylm_material_kind_name(-1));
  printf("failures of many\t%d\t\n", ylm_grid_allowed((size_t)-1) > 1000);
}

/* A mesh that has normals gets more vertices. */
static void creases(void) {
  ylm_mesh *m = NULL;
  ylm_mesh_sphere(1, 8, 4, &m, &e);
  size_t before = m->vertices;
  double length = 0;
  say("creases", ylm_mesh_make_creased_normals(m, 10, NULL));
  for (size_t i = 0; i < m->vertices; i++)
    length += fabs(sqrt((double)m->normal[3 * i] * m->normal[3 * i] +
                        (double)m->normal[3 * i + 1] * m->normal[3 * i + 1] +
                        (double)m->normal[3 * i + 2] * m->normal[3 * i + 2]) -
                   1);
  printf("normals\t%d\t\n", m->vertices > before && length < 1e-4);
  ylm_mesh_free(m);
}

/* Pictures that are larger than an int of pixels, or lie nowhere, change the pixels that they meet alone. */
static void canvases(void) {
  const double rgb[3] = {1, 1, 1}, black[4] = {0, 0, 0, 1};
  ylm_figure_canvas c, from;
  ylm_figure_canvas_init(&c, 3, 3, rgb);
  ylm_figure_canvas_init(&from, 2, 2, rgb);
  double begun = ylm_seconds();
  ylm_figure_canvas_copy(&c, 1, 2147483647, 2147483647, 2147483647, &from, 0, 0, 2, 2, true);
  ylm_figure_canvas_copy(&c, -2147483647, 1, 2147483647, 2147483647, &from, NAN, 0, 2, 2, false);
  ylm_figure_canvas_line(&c, NAN, 0, 1, 1, 1, black);
  ylm_figure_canvas_rectangle(&c, NAN, NAN, NAN, NAN, black);
  printf("canvas\t%d\t\n", c.pixel[0] == 255 && c.pixel[26] == 255 && ylm_seconds() - begun < 1);
  ylm_figure_canvas_clear(&c);
  ylm_figure_canvas_clear(&from);
}

#ifdef SCENE
static void lamps_of(const ylm_transfer *transfer) {
  ylm_lamplight_form rays = {.light_samples = 4, .threads = 1};
  ylm_lamp shone = {.shape = YLM_LAMP_polygon,
                    .axis = {0, -1, 0},
                    .across = {1, 0, 0},
                    .half = {1, 1},
                    .scale = {1, 1, 1}};
  ylm_lamplight *direct;
  say("lamp of two corners", ylm_lamplight_create(transfer, NULL, 1, &shone, &rays, &direct, &e));
  shone.shape = YLM_LAMP_sphere, shone.at[1] = NAN;
  say("lamp nowhere", ylm_lamplight_create(transfer, NULL, 1, &shone, &rays, &direct, &e));
  shone.at[1] = 1, shone.power = INFINITY;
  say("lamp of infinite power",
      ylm_lamplight_create(transfer, NULL, 1, &shone, &rays, &direct, &e));
  shone.power = 0, shone.shape = (ylm_lamp_shape)77;
  say("lamp of no shape", ylm_lamplight_create(transfer, NULL, 1, &shone, &rays, &direct, &e));
  say("lamps that are not there",
      ylm_lamplight_create(transfer, NULL, 3, NULL, &rays, &direct, &e));
}

/* Embree ends the process where a ray starts at no number, or beyond 1.8e18. */
static void scenes(void) {
  float place[12] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1}, white[3] = {0.5f, 0.5f, 0.5f};
  const uint32_t index[6] = {0, 2, 1, 0, 3, 2};
  const float lamp[4] = {0, 1, 0, 0.1f}, radiance[3] = {1, 1, 1}, uv[8] = {0, 0, 1, 0, 1, 1, 0, 1};
  ylm_material *matte = NULL;
  ylm_material_create(ylm_material_kind_find("matte"), 3, white, &matte, &e);
  ylm_scene_mesh mesh = {.positions = place,
                         .vertices = 4,
                         .triangles = index,
                         .count = 2,
                         .material = matte,
                         .occludes = true};
  ylm_scene_lamps lamps = {.shape = {.spheres = 1, .sphere = lamp}, .radiance = radiance};
  ylm_scene *scene = NULL;
  ylm_scene_create(1, &mesh, &lamps, &scene, &e);
  ylm_camera camera = {{0, 1, 3}, {0, 0, 0}, {0, 1, 0}, 40};
  ylm_camera_frame frame;
  say("picture of no rows", ylm_scene_frame(scene, &camera, 4, 0, &frame, &e));
  camera.from[0] = 1e300;
  say("camera far away", ylm_scene_frame(scene, &camera, 4, 3, &frame, &e));
  camera.from[0] = 0;
  float number[48], more[48], variance[48], nothing[3] = {NAN, 0, 0}, far[1][3] = {{1e20f, 0, 0}},
                                            up[1][3] = {{0, 1, 0}};
  ylm_path_sum sum = {.mean = number, .rest = more, .variance = variance};
  ylm_path_options paths = {.samples = 16, .last = 1, .threads = 1};
  ylm_path_stats stats;
  say("background of no number",
      ylm_path_image(scene, &camera, 2, 2, nothing, &paths, &sum, &stats, &e));
  say("probe far away",
      ylm_path_probe(scene, 1, (const float(*)[3])far, 1, &paths, &sum, &stats, &e));
  ylm_transfer_form form = {
      .spacing = 1, .links = 8, .lmax = -1, .sides = YLM_TRANSFER_BOTH, .threads = 1};
  ylm_transfer *transfer = NULL;
  ylm_transfer_create(scene, &form, &transfer, &e);
  uint32_t link[8];
  far[0][0] = NAN;
  say("links from nowhere",
      ylm_transfer_find(transfer, 1, (const float(*)[3])far, (const float(*)[3])up, NULL, 8, 1, 1,
                        NULL, (ylm_links){.four = link}, 0, NULL, &e));
  ylm_receivers *receivers;
  say("receiver from nowhere",
      ylm_receivers_create(transfer, 1, (const float(*)[3])far, (const float(*)[3])up, 8, 1, 1,
                           NULL, &receivers, &e));
  far[0][0] = 0, up[0][1] = 4e15f;
  say("links of a long normal",
      ylm_transfer_find(transfer, 1, (const float(*)[3])far, (const float(*)[3])up, NULL, 8, 1, 1,
                        NULL, (ylm_links){.four = link}, 0, NULL, &e));
  lamps_of(transfer);
  ylm_radiosity *light = NULL;
  double change;
  size_t overlaps;
  ylm_radiosity_create(transfer, &light);
  say("bounces 2^31 - 1",
      ylm_radiosity_coarse(light, 2147483647, 1e-3, false, 1, NULL, &change, &e));
  ylm_radiosity_map map = {
      .uvs = uv, .width = 4, .height = 4, .links = 8, .gutter = 2147483647, .threads = 1};
  say("gutter 2^31 - 1", ylm_radiosity_lightmap(light, &map, number, more, &overlaps, &e));
  ylm_radiosity_free(light);
  ylm_transfer_free(transfer);
  ylm_scene_free(scene);
  ylm_material_free(matte);
}
#endif

#ifdef VTK
static void pictures(void) {
  uint8_t pixel[48] = {0};
  float position[9] = {0};
  uint32_t index[3] = {0, 1, 7};
  double zero[3] = {0};
  ylm_figure_canvas none = {.width = 0, .height = 4, .pixel = pixel};
  ylm_figure_shape shape = {.corners = 3,
                            .points = 3,
                            .cells = 1,
                            .position = position,
                            .normal = position,
                            .colour = pixel,
                            .index = index};
  ylm_vtk_style style = {.opacity = 1};
  ylm_vtk_chart chart = {.width = 4, .height = 4, .supersample = 1048576};
  ylm_vtk_scene *scene;
  say("png of no columns", ylm_vtk_save_png("none.png", &none, &e));
  say("plot of many samples", ylm_vtk_plot(&chart, pixel, &e));
  if (ylm_vtk_scene_create(&scene, &e)) return;
  say("picture of -1 columns", ylm_vtk_add_picture(scene, zero, zero, zero, -1, 4, pixel, 0, &e));
  say("view of -1 columns", ylm_vtk_render(scene, -1, 4, 1, zero, pixel, &e));
  say("shape of a point beyond", ylm_vtk_add_shape(scene, &shape, &style, &e));
  shape.corners = -3;
  say("shape of corners -3", ylm_vtk_add_shape(scene, &shape, &style, &e));
  ylm_vtk_scene_free(scene);
}
#endif

int main(void) {
#ifdef VTK
  pictures();
#endif
#ifdef SCENE
  scenes();
#endif
  images();
  lights();
  others();
  creases();
  canvases();
  return 0;
}
