/* sites.c - places spread over the texels of charts, and their light in two halves. */
#include "map.h"

/* The light of places, as an earlier bake has found it, or found now. */
static ylm_status find_light(map_bake *b, const ylm_radiosity_map *form, size_t n,
                             const ylm_scene_place *place, const uint64_t *stream, float (*E)[3],
                             float *share) {
  map_part part[3] = {{E, n * sizeof *E}, {share, n * sizeof *share}, {form->flow, 36 * n}};
  size_t parts = form->flow ? 3 : 2;
  bool had;
  ylm_status s = ylm__map_recall(b, parts, part, &had);
  if (s != YLM_OK || had) return s;
  s = ylm_radiosity_places(b->r, form, n, place, stream, E, share, b->e);
  return s == YLM_OK ? ylm__map_remember(b, parts, part) : s;
}

/* The light of all places; by pieces where a file gets it. */
static ylm_status find_all(map_bake *b, const ylm_radiosity_map *form, size_t n,
                           const ylm_scene_place *place, const uint64_t *stream, float (*E)[3],
                           float *share) {
  size_t step = b->journal.open ? MAP_KEEP : n;
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < n; i += step) {
    ylm_radiosity_map piece = *form;
    if (form->flow) piece.flow = form->flow + i;
    s = find_light(b, &piece, step < n - i ? step : n - i, place + i, stream + i, E + i, share + i);
  }
  return s;
}

static int at_most(int rays, int more) {
  return rays > YLM_TRANSFER_LINKS / more ? YLM_TRANSFER_LINKS : rays * more;
}

ylm_status ylm__map_ask(map_bake *b, size_t n, const ylm_scene_place *place, const int more[2],
                        surface_light *light, bool *open, float (*flow)[3][3]) {
  uint64_t *stream = ylm_alloc(n, sizeof *stream);
  float(*E)[3] = ylm_alloc(n, sizeof *E), *share = ylm_alloc(n, sizeof *share);
  float(*half_flow)[3][3] = flow ? ylm_alloc(n, sizeof *half_flow) : NULL;
  ylm_radiosity_map form = b->form->light;
  ylm_status s = stream && E && share && (half_flow || !flow) ? YLM_OK : YLM_ENOMEM;
  form.flow = half_flow;
  form.links = at_most(form.links, more[0]);
  form.light_samples = at_most(form.light_samples, more[1]);
  for (int half = 0; s == YLM_OK && half < 2; half++) {
    for (size_t i = 0; i < n; i++) stream[i] = b->asked + i;
    b->asked += n;
    s = find_all(b, &form, n, place, stream, E, share);
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      memcpy(half ? light[i].b : light[i].a, E[i], sizeof E[i]);
      open[i] = (half == 0 || open[i]) && share[i] >= 0.5f;
      for (int k = 0; flow && k < 9; k++)
        flow[i][k / 3][k % 3] =
            (half ? flow[i][k / 3][k % 3] : 0) + 0.5f * half_flow[i][k / 3][k % 3];
    }
  }
  b->m->stats.places += n;
  b->m->stats.rays += 2 * n * (uint64_t)(form.links + (form.scene ? form.light_samples : 0));
  ylm_free(stream);
  ylm_free(E);
  ylm_free(share);
  ylm_free(half_flow);
  return s;
}

static ylm_status add(map_bake *b, const map_sheet *sheet, size_t fine, uint32_t chart, double u,
                      double v) {
  size_t triangle = ylm__map_whole(sheet, fine, &u, &v);
  if (!ylm_list_reserve(&b->site, b->sites, b->sites + 1, &b->site_room, sizeof *b->site))
    return YLM_ENOMEM;
  b->site[b->sites++] =
      (map_site){.place = {sheet->mesh, (uint32_t)triangle, (float)(sheet->back ? v : u),
                           (float)(sheet->back ? u : v), sheet->back},
                 .chart = chart};
  return YLM_OK;
}

/* Sites of a triangle: one in each cell of a lattice, at a random place of it, where that is on the triangle. */
static ylm_status scatter(map_bake *b, const map_sheet *sheet, size_t triangle, uint32_t chart,
                          const double p[3][2], uint8_t *has) {
  double twice =
      (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
  double low[2], high[2];
  ylm_status s = YLM_OK;
  for (int a = 0; a < 2; a++) {
    low[a] = floor(MAP_ALONG * fmin(p[0][a], fmin(p[1][a], p[2][a])));
    high[a] = floor(MAP_ALONG * fmax(p[0][a], fmax(p[1][a], p[2][a])));
  }
  for (double y = low[1]; twice != 0 && y <= high[1]; y++)
    for (double x = low[0]; s == YLM_OK && x <= high[0]; x++) {
      ylm_rng rng;
      ylm_rng_seed(&rng, b->form->light.seed + b->asked,
                   (uint64_t)y * (MAP_ALONG * YLM_UNWRAP_SIDE) + (uint64_t)x);
      double at[2] = {(x + ylm_rng_double(&rng)) / MAP_ALONG,
                      (y + ylm_rng_double(&rng)) / MAP_ALONG};
      double u =
          ((at[0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (at[1] - p[0][1])) /
          twice;
      double v =
          ((p[1][0] - p[0][0]) * (at[1] - p[0][1]) - (at[0] - p[0][0]) * (p[1][1] - p[0][1])) /
          twice;
      if (u < 0 || v < 0 || u + v > 1) continue;
      has[chart] = 1;
      s = add(b, sheet, triangle, chart, u, v);
    }
  return s;
}

/* Sites of all sheets; a chart between all of them has one in the middle of its first triangle. */
static ylm_status scatter_all(map_bake *b, uint8_t *has) {
  const ylm_surface_map *m = b->m;
  ylm_status s = YLM_OK;
  for (int pass = 0; pass < 2; pass++)
    for (size_t i = 0; i < m->sheets; i++)
      for (size_t t = 0; s == YLM_OK && t < m->sheet[i].fine; t++) {
        uint32_t chart = ylm_unwrap_chart(m->charts, i, t);
        double p[3][2];
        if (chart == YLM_UNWRAP_NONE || (pass && has[chart])) continue;
        ylm_unwrap_corners(m->charts, i, t, p);
        if (!pass)
          s = scatter(b, &m->sheet[i], t, chart, (const double(*)[2])p, has);
        else {
          has[chart] = 1;
          s = add(b, &m->sheet[i], t, chart, 1 / 3.0, 1 / 3.0);
        }
      }
  return s;
}

/* The mean of the light by area. */
static void find_mean(map_bake *b) {
  double sum[3] = {0, 0, 0}, area = 0, *n = ylm_alloc_zero(b->charts, sizeof *n);
  for (size_t i = 0; n && i < b->sites; i++) n[b->site[i].chart] += b->site[i].open;
  for (size_t i = 0; n && i < b->sites; i++) {
    const map_site *s = &b->site[i];
    if (!s->open) continue;
    double E[3], part = ylm_unwrap_area(b->m->charts, s->chart) / n[s->chart];
    ylm__surface_mid(&s->light, E);
    area += part;
    for (int c = 0; c < 3; c++) sum[c] += part * E[c];
  }
  for (int c = 0; c < 3; c++) b->mean[c] = area > 0 ? sum[c] / area : 0;
  ylm_free(n);
}

/* Sums of values [sites], and of their weights, over the texels around each: the first two of room [3][texels]. */
static void sum_near(const map_bake *b, const double *value, float *room) {
  float *sum = room, *count = room + b->texels, *spare = room + 2 * b->texels;
  memset(sum, 0, 2 * b->texels * sizeof *sum);
  ylm__map_sum(b, value, sum, count);
  ylm__map_sum_around(b, sum, spare);
  ylm__map_sum_around(b, count, spare);
}

/* Weights of sites, by the mean of the light around: if each had that of its own, those whose noise makes them bright would
   count less, and the picture would be too dim. */
static ylm_status weigh(map_bake *b) {
  float *room = ylm_alloc(3 * b->texels, sizeof *room);
  double *light = ylm_alloc(b->sites, sizeof *light);
  bool ok = room && light;
  for (size_t i = 0; i < b->sites; i++) b->site[i].weight = 0;
  for (int c = 0; ok && c < 3; c++) {
    for (size_t i = 0; i < b->sites; i++)
      light[i] = (double)(0.5f * (b->site[i].light.a[c] + b->site[i].light.b[c]));
    sum_near(b, light, room);
    for (size_t i = 0; i < b->sites; i++) {
      map_site *s = &b->site[i];
      if (!map_counts(s)) continue;
      double m = fmax(ylm__map_mean_at(s, room, room + b->texels), b->mean[c]);
      s->weight += m > 0 ? (float)(1 / (3 * m * m)) : 0;
    }
  }
  ylm_free(room);
  ylm_free(light);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* The square of the noise of the mean of both halves, over what errors are told over. */
static double square_noise(const map_site *s) {
  double square = 0;
  for (int c = 0; c < 3; c++) {
    double d = 0.5 * ((double)s->light.a[c] - (double)s->light.b[c]);
    square += d * d / 3;
  }
  return square * (double)s->weight;
}

/* Its mean over all sites, the root. */
static double noise_of(const map_bake *b) {
  double sum = 0, n = 0;
  for (size_t i = 0; i < b->sites; i++) {
    if (!map_counts(&b->site[i])) continue;
    sum += square_noise(&b->site[i]);
    n++;
  }
  return n > 0 ? sqrt(sum / n) : 0;
}

/* Keeps the light of all sites. */
static ylm_status light_all(map_bake *b) {
  static const int once[2] = {1, 1};
  size_t n = b->sites;
  ylm_scene_place *place = ylm_alloc(n, sizeof *place);
  surface_light *light = ylm_alloc(n, sizeof *light);
  bool *open = ylm_alloc(n, sizeof *open);
  ylm_status s = place && light && open ? YLM_OK : YLM_ENOMEM;
  ylm_free(b->flow);
  b->flow = b->last && b->form->directional ? ylm_alloc(n, sizeof *b->flow) : NULL;
  if (b->last && b->form->directional && !b->flow) s = YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) place[i] = b->site[i].place;
  if (s == YLM_OK) s = ylm__map_ask(b, n, place, once, light, open, b->flow);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    b->site[i].light = light[i];
    b->site[i].open = open[i];
  }
  ylm_free(place);
  ylm_free(light);
  ylm_free(open);
  return s;
}

/* The sites around which light has too much noise for the aim: of [sites]; how many. The noise of others around chooses them: its
   own would choose sites that are too bright. */
static ylm_status find_noisy(const map_bake *b, size_t *of, size_t *found) {
  float *room = ylm_alloc(3 * b->texels, sizeof *room);
  double *square = ylm_alloc(b->sites, sizeof *square);
  *found = 0;
  if (room && square) {
    for (size_t i = 0; i < b->sites; i++) square[i] = square_noise(&b->site[i]);
    sum_near(b, square, room);
    double most = MAP_NOISY * MAP_NOISY * b->aim * b->aim;
    for (size_t i = 0; i < b->sites; i++)
      if (ylm__map_mean_at(&b->site[i], room, room + b->texels) > most) of[(*found)++] = i;
  }
  ylm_status s = room && square ? YLM_OK : YLM_ENOMEM;
  ylm_free(room);
  ylm_free(square);
  return s;
}

/* Asks the light of noisy sites anew, with more rays. */
static ylm_status ask_again(map_bake *b, const int more[2]) {
  size_t n = 0, *of = ylm_alloc(b->sites, sizeof *of);
  ylm_status s = of ? find_noisy(b, of, &n) : YLM_ENOMEM;
  ylm_scene_place *place = ylm_alloc(n, sizeof *place);
  surface_light *light = ylm_alloc(n, sizeof *light);
  bool *open = ylm_alloc(n, sizeof *open);
  float(*flow)[3][3] = b->flow ? ylm_alloc(n, sizeof *flow) : NULL;
  if (!place || !light || !open || (b->flow && !flow)) s = YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < n; i++) place[i] = b->site[of[i]].place;
  if (s == YLM_OK && n) s = ylm__map_ask(b, n, place, more, light, open, flow);
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    b->site[of[i]].light = light[i];
    if (flow) memcpy(b->flow[of[i]], flow[i], sizeof flow[i]);
  }
  ylm_free(of), ylm_free(place), ylm_free(light), ylm_free(open), ylm_free(flow);
  return s;
}

/* Means and weights by the light of sites. */
static ylm_status settle(map_bake *b) {
  find_mean(b);
  return weigh(b);
}

ylm_status ylm__map_sample(map_bake *b) {
  double start = ylm_seconds();
  uint8_t *has = ylm_alloc_zero(b->charts, 1);
  b->sites = 0;
  ylm_status s = has ? scatter_all(b, has) : YLM_ENOMEM;
  ylm_free(has);
  for (size_t i = 0; s == YLM_OK && i < b->sites; i++) ylm__map_find_tap(b, &b->site[i]);
  if (s == YLM_OK) s = light_all(b);
  if (s == YLM_OK) s = settle(b);
  for (int k = 0; s == YLM_OK && b->last && b->aim > 0 && k < MAP_AGAIN; k++) {
    int more[2] = {map_again[k][b->form->light.scene == NULL], map_again[k][1]};
    s = ask_again(b, more);
    if (s == YLM_OK) s = settle(b);
  }
  if (s == YLM_OK) b->m->stats.noise = noise_of(b);
  b->m->stats.light_seconds += ylm_seconds() - start;
  return s;
}
