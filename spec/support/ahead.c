/*
** ahead.c - few lamps at many places, weighed ahead and one place after the other, without a guide and with one, for specs: chances and
** densities of lamps have the same bits. So have clusters of places that are found together and one by one.
**
** Prints the number of places, how many bring no light, how many differ, and the first of those; then clusters.
*/
#include <stdio.h>
#include <string.h>

#include <ylm/ylm_geom.h>
#include <ylm/ylm_scene.h>

enum { PLACES = 3999, SPHERES = 3, TRIANGLES = 5, LAMPS = SPHERES + TRIANGLES };

static float draw(ylm_rng *r) { return (float)(2 * ylm_rng_double(r) - 1); }

/* Lamps all over a cube, the last of them without an area; places there, every ninth in the first sphere. */
static ylm_scene *create(ylm_rng *r, float sphere[SPHERES][4]) {
  float triangle[TRIANGLES][9], radiance[LAMPS][3];
  ylm_scene *scene = NULL;
  for (int i = 0; i < SPHERES; i++)
    for (int a = 0; a < 4; a++) sphere[i][a] = a < 3 ? draw(r) : .05f + .1f * (float)i;
  for (int i = 0; i < 9 * TRIANGLES; i++) triangle[i / 9][i % 9] = draw(r) * (i < 9 ? .1f : 1);
  memcpy(triangle[TRIANGLES - 1] + 3, triangle[TRIANGLES - 1], 12);
  for (int i = 0; i < 3 * LAMPS; i++) radiance[i / 3][i % 3] = 2 + draw(r);
  ylm_scene_lamps lamps = {.shape = {SPHERES, TRIANGLES, 0, sphere[0], triangle[0], NULL},
                           .radiance = radiance[0]};
  return ylm_scene_create(0, NULL, &lamps, &scene, NULL) == YLM_OK ? scene : NULL;
}

static int differ(const ylm_scene_chooser *a, const ylm_scene_chooser *b, const float d[3]) {
  for (uint32_t i = 0; i < LAMPS; i++) {
    double x[2] = {ylm_scene_share(a, i), ylm_scene_density(a, i, d)};
    double y[2] = {ylm_scene_share(b, i), ylm_scene_density(b, i, d)};
    if (memcmp(x, y, sizeof x)) return 1;
  }
  return 0;
}

static float x[PLACES][3], normal[PLACES][3];

/* Places in the cube, and near the first sphere. */
static void scatter(ylm_rng *r, const float sphere[4]) {
  for (size_t i = 0; i < PLACES; i++)
    for (int k = 0; k < 3; k++) {
      x[i][k] = i % 9 ? 2 * draw(r) : sphere[k] + .02f * draw(r);
      normal[i][k] = i % 2 ? draw(r) : (float)((int)(i / 2 % 3) == k);
    }
}

/* Asks a of places that it is told of, the last first, and b of one after the other. */
static void compare(const char *what, ylm_scene_chooser *a, ylm_scene_chooser *b) {
  size_t dark = 0, wrong = 0, first = 0;
  for (size_t i = PLACES; i-- > 0;) {
    size_t k = i % YLM_SCENE_AHEAD, n = i - k + YLM_SCENE_AHEAD > PLACES ? k + 1 : YLM_SCENE_AHEAD;
    if (k == n - 1)
      ylm_scene_look_ahead(a, n, (const float(*)[3])(x + i - k),
                           (const float(*)[3])(normal + i - k));
    bool one = ylm_scene_choose_ahead(a, k, x[i], normal[i]);
    dark += !one;
    if (one != ylm_scene_choose(b, x[i], normal[i]) || (one && differ(a, b, normal[i])))
      wrong++, first = i;
  }
  printf("%s: %d places, %zu dark, %zu differ, the first is %zu\n", what, PLACES, dark, wrong,
         first);
}

/* Finds the places' clusters; says how many of those that are found together differ. */
static void group(const ylm_scene_places *p) {
  static uint32_t cluster[PLACES];
  ylm_scene_clusters *c;
  size_t wrong = 0;
  if (ylm_scene_clusters_create(p, 8, &c) != YLM_OK) return;
  ylm_scene_clusters_at(c, p->n, p->lit, p->normal, cluster);
  for (size_t i = 0; i < p->n; i++)
    wrong += cluster[i] != ylm_scene_cluster_at(c, p->lit[i], p->normal[i]);
  printf("%zu clusters, %zu differ\n", ylm_scene_clusters_count(c), wrong);
  ylm_scene_clusters_free(c);
}

int main(void) {
  float sphere[SPHERES][4];
  ylm_rng r;
  ylm_rng_seed(&r, 1, 1);
  ylm_scene *scene = create(&r, sphere);
  ylm_scene_chooser *a = scene ? ylm_scene_chooser_create(scene) : NULL;
  ylm_scene_chooser *b = scene ? ylm_scene_chooser_create(scene) : NULL;
  ylm_scene_guide *guide = NULL;
  if (!a || !b) return 1;
  scatter(&r, sphere[0]);
  compare("no guide", a, b);
  ylm_scene_places places = {PLACES, (const float(*)[3])x, (const float(*)[3])normal,
                             (const float(*)[3])x};
  if (ylm_scene_guide_create(scene, &places, 16, 1, 1, NULL, &guide) != YLM_OK || !guide ||
      !ylm_scene_chooser_follow(a, guide) || !ylm_scene_chooser_follow(b, guide))
    return 1;
  compare("a guide", a, b);
  group(&places);
  ylm_scene_guide_free(guide);
  ylm_scene_chooser_free(a);
  ylm_scene_chooser_free(b);
  ylm_scene_free(scene);
  return 0;
}
