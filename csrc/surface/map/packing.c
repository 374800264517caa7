/* packing.c - charts on a picture, the texels that are unknown, and where sites are read. */
#include "map.h"

/* Room for a picture of the size that charts have. */
static ylm_status begin_picture(map_bake *b) {
  ylm_unwrap_look(b->m->charts, &b->m->stats.charts);
  b->width = b->m->stats.charts.width;
  b->height = b->m->stats.charts.height;
  size_t n = b->texels = b->width * b->height;
  ylm_free(b->chart), ylm_free(b->bend), ylm_free(b->value);
  b->chart = ylm_alloc(n, sizeof *b->chart);
  b->bend = ylm_alloc(n, sizeof *b->bend);
  b->value = ylm_alloc(n, 6 * sizeof *b->value);
  if (!b->chart || !b->bend || !b->value) return YLM_ENOMEM;
  for (size_t i = 0; i < 6 * n; i++) b->value[i] = (float)b->mean[i / n % 3];
  for (size_t i = 0; i < n; i++) b->bend[i] = (float)MAP_WEIGHT;
  return ylm_unwrap_texels(b->m->charts, b->chart);
}

bool ylm__map_keep_in(const map_bake *b, uint32_t chart, map_tap *tap) {
  uint32_t inside = MAP_NONE;
  for (int k = 0; k < 4; k++)
    if (b->chart[tap->texel[k]] == chart) inside = tap->texel[k];
  for (int k = 0; k < 4; k++)
    if (b->chart[tap->texel[k]] != chart) tap->texel[k] = inside;
  return inside != MAP_NONE;
}

void ylm__map_find_tap(const map_bake *b, map_site *s) {
  s->read = ylm__map_tap(b->m, &s->place, &s->tap) && ylm__map_keep_in(b, s->chart, &s->tap);
}

ylm_status ylm__map_pack(map_bake *b, size_t texels) {
  double start = ylm_seconds();
  ylm_status s = ylm_unwrap_fit(b->m->charts, b->density, b->form->gutter, texels, NULL, b->e);
  if (s == YLM_OK) s = begin_picture(b);
  for (size_t i = 0; s == YLM_OK && i < b->sites; i++) ylm__map_find_tap(b, &b->site[i]);
  if (s == YLM_OK) s = ylm__map_seams(b);
  b->m->stats.pack_seconds += ylm_seconds() - start;
  return s;
}
