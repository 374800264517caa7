/*
** bake.c - lights, an adaptive grid of probes, samples of it beside the lights themselves, a file.
**
**     cc bake.c $(pkg-config --cflags --libs ylm) -lm -o bake && ./bake lamps.ylm
**
** C11 and C++17. docs/c.md has ownership, threads, errors.
*/
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <ylm/ylm_grid.h>
#include <ylm/ylm_light.h>
#include <ylm/ylm_version.h>

enum { LMAX = 4, COUNT = (LMAX + 1) * (LMAX + 1), LAMPS = 12, POINTS = 3 };

static const float points[POINTS][3] = {{0.3f, 0.1f, -0.2f}, {-0.6f, 0.4f, 0.7f}, {0, 0.9f, 0}};

/* True if all is well; else the reason goes to stderr. */
static bool good(ylm_status s, const ylm_error *e) {
  if (s != YLM_OK) fprintf(stderr, "bake: %s\n", e->status == s ? e->text : ylm_status_text(s));
  return s == YLM_OK;
}

/* A ring of lamps, 2 above the middle. Metres, W sr^-1 m^-2. */
static ylm_status light(ylm_light_set **lamps, ylm_error *e) {
  double at[LAMPS][3], radius[LAMPS], radiance[LAMPS][3];
  for (int i = 0; i < LAMPS; i++) {
    double angle = 2 * YLM_PI * i / LAMPS;
    at[i][0] = cos(angle), at[i][1] = 2, at[i][2] = sin(angle);
    radius[i] = 0.05;
    radiance[i][0] = 10, radiance[i][1] = 8, radiance[i][2] = 2 + i % 3;
  }
  return ylm_light_set_spheres(LAMPS, at[0], radius, radiance[0], lamps, e);
}

/* Probes for the cube from -1 to 1. At 99 % of the points the relative error is at most 1 %. */
static ylm_status bake(const ylm_light_set *lamps, ylm_grid **grid, ylm_error *e) {
  ylm_grid_form form;
  ylm_grid_source source;
  memset(&form, 0, sizeof form); /* fields of later versions are 0 then too */
  memset(&source, 0, sizeof source);
  form.kind = YLM_GRID_ADAPTIVE;
  for (int a = 0; a < 3; a++) form.bounds[a] = -1, form.bounds[3 + a] = 1;
  form.lmax = LMAX, form.channels = form.metric_channels = 3;
  form.depth = 4, form.threshold = -1, form.tolerance = 0.01, form.continuous = true;
  source.field = ylm_light_set_field(lamps);
  return ylm_grid_bake(&form, &source, grid, e);
}

/* Coefficients at the points, by the grid and by the lights themselves: [POINTS][3][COUNT]. */
static ylm_status look(const ylm_grid *grid, const ylm_field *field, float *sampled, float *exact,
                       ylm_error *e) {
  ylm_grid_query query;
  ylm_field_query ask;
  ylm_field_result result;
  memset(&query, 0, sizeof query); /* Hermite, float, all cores */
  memset(&ask, 0, sizeof ask);
  memset(&result, 0, sizeof result);
  ask.lmax = LMAX, ask.channels = ask.metric_channels = 3, ask.want = YLM_WANT_VALUE;
  result.value = exact;
  ylm_status s = ylm_grid_sample(grid, &query, POINTS, points, sampled, NULL, NULL, e);
  return s == YLM_OK ? field->evaluate(field, &ask, POINTS, points, &result, e) : s;
}

int main(int argc, char **argv) {
  static float sampled[POINTS][3 * COUNT], exact[POINTS][3 * COUNT];
  ylm_error error = {YLM_OK, ""};
  ylm_light_set *lamps = NULL;
  ylm_grid *grid = NULL;
  if (argc != 2) return fprintf(stderr, "usage: bake FILE.ylm\n"), 2;
  printf("ylm %s, compiled for %s\n", ylm_version(), YLM_VERSION);
  bool done = good(light(&lamps, &error), &error) && good(bake(lamps, &grid, &error), &error) &&
              good(look(grid, ylm_light_set_field(lamps), sampled[0], exact[0], &error), &error) &&
              good(ylm_grid_write(grid, argv[1], &error), &error);
  if (done) printf("%d probes\n", (int)ylm_grid_stats_of(grid)->points);
  for (int i = 0; done && i < POINTS; i++) {
    double apart = 0, norm = 0;
    for (int k = 0; k < 3 * COUNT; k++) {
      apart += pow(sampled[i][k] - exact[i][k], 2);
      norm += pow(exact[i][k], 2);
    }
    printf("at (%4.1f, %4.1f, %4.1f): red L00 %.5f, relative error %.5f\n", points[i][0],
           points[i][1], points[i][2], sampled[i][0], sqrt(apart / norm));
  }
  ylm_grid_free(grid); /* before the lights whose field it was baked from; NULL is fine */
  ylm_light_set_free(lamps);
  return done ? 0 : 1;
}
