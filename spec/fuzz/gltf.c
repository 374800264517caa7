/* gltf.c - fuzzes the reader of glTF; a file that the JSON names has the input's own bytes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ylm_gltf.h"

typedef struct input {
  const uint8_t *data;
  size_t size;
} input;

static ylm_status open_input(void *user, const char *path, unsigned char **data, size_t *size,
                             ylm_error *e) {
  const input *in = user;
  (void)path;
  *data = ylm_alloc_copy(in->data, in->size ? in->size : 1, 1);
  *size = in->size;
  return *data ? YLM_OK : ylm_fail(e, YLM_ENOMEM, "memory ran out");
}

static void need(bool good) {
  if (!good) __builtin_trap();
}

static void check_text(const char *s, size_t room) { need(memchr(s, 0, room) != NULL); }

static void check_piece(const ylm_gltf *g, const ylm_gltf_piece *p) {
  const ylm_mesh *m = p->mesh;
  check_text(p->name, sizeof p->name);
  need(m && m->triangles > 0 && p->material < (int32_t)g->materials);
  for (size_t i = 0; i < 3 * m->triangles; i++) need(m->index[i] < m->vertices);
  for (size_t i = 0; i < 3 * m->vertices; i++)
    need(isfinite(m->position[i]) && isfinite(m->normal[i]));
  need(p->alpha >= 0 && p->alpha <= 1);
  for (int c = 0; c < 3; c++) need(p->tint[c] >= 0 && p->tint[c] <= 1);
  for (size_t i = 0; m->uv && i < 2 * m->vertices; i++) need(!isnan(m->uv[i]));
  for (size_t i = 0; m->colour && i < 3 * m->vertices; i++)
    need(m->colour[i] >= 0 && m->colour[i] <= 1);
}

static void check_material(const ylm_gltf *g, const ylm_gltf_material *m) {
  check_text(m->name, sizeof m->name);
  for (int i = 0; i < 4; i++) need(m->base[i] >= 0 && m->base[i] <= 1);
  for (int i = 0; i < 3; i++) need(m->emission[i] >= 0 && m->emission[i] <= 1.1e30f);
  need(m->metallic >= 0 && m->metallic <= 1 && m->roughness >= 0 && m->roughness <= 1);
  need(m->base_image < (int32_t)g->images && m->emission_image < (int32_t)g->images);
  need(m->base_image < 0 || g->image[m->base_image]);
  need(m->emission_image < 0 || g->image[m->emission_image]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  input in = {data, size};
  ylm_gltf_options o = {.open = open_input,
                        .user = &in,
                        .triangles = 20000,
                        .texels = 20000,
                        .groups = (int)(size % 4) * 5};
  ylm_error e = {0};
  ylm_gltf *g;
  if (ylm_gltf_decode(data, size, "fuzz", &o, &g, &e) != YLM_OK) {
    if (g || strncmp(e.text, "fuzz:", 5) != 0) __builtin_trap();
    return 0;
  }
  need(g->triangles <= 20000 && g->pieces <= YLM_GLTF_PIECES);
  for (size_t i = 0; i < g->pieces; i++) check_piece(g, &g->piece[i]);
  for (size_t i = 0; i < g->materials; i++) check_material(g, &g->material[i]);
  for (size_t i = 0; i < g->lamps; i++) {
    check_text(g->lamp[i].name, YLM_GLTF_NAME);
    for (int c = 0; c < 3; c++) need(isfinite(g->lamp[i].at[c]) && g->lamp[i].intensity[c] >= 0);
  }
  for (size_t i = 0; i < g->notes; i++) need(strlen(g->note[i]) < 300);
  ylm_gltf_free(g);
  return 0;
}
