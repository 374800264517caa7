/* gltf.c - a file from its bytes to what the caller gets; which versions and extensions. */
#include "gltf.h"

#include <stdlib.h>

/* Extensions that a file may require. */
static const char *const known[] = {
    "EXT_lights_ies",        "KHR_lights_punctual",    "KHR_materials_emissive_strength",
    "KHR_materials_ior",     "KHR_materials_specular", "KHR_materials_unlit",
    "KHR_mesh_quantization", "KHR_texture_transform"};

static void check_version(gltf *g) {
  place p = {NULL, "asset", 0};
  const json_t *asset = ylm__gltf_object(g, NULL, g->root, "asset");
  const char *version = ylm__gltf_string(g, &p, asset, "version");
  const char *least = ylm__gltf_string(g, &p, asset, "minVersion");
  if (!version)
    ylm__gltf_fail(g, YLM_EFORMAT, &p, "no glTF file: a version is missing");
  else if (strncmp(version, "2.", 2) != 0)
    ylm__gltf_fail(g, YLM_EVERSION, &p, "version %.20s, 2 is known", version);
  else if (least && strcmp(least, "2.0") != 0)
    ylm__gltf_fail(g, YLM_EVERSION, &p, "version %.20s is needed, 2.0 is known", least);
}

static void check_extensions(gltf *g) {
  size_t n;
  place p = {NULL, "extensionsRequired", 0};
  json_t *list = ylm__gltf_list(g, NULL, g->root, "extensionsRequired", &n);
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    const char *name = json_string_value(json_array_get(list, i));
    bool found = false;
    for (size_t k = 0; name && k < sizeof known / sizeof *known; k++)
      found |= strcmp(name, known[k]) == 0;
    if (found) continue;
    bool packed = name && (strstr(name, "compression") || strstr(name, "meshopt"));
    ylm__gltf_fail(g, YLM_EFORMAT, &p, "%.60s is needed, and not known%s",
                   name ? name : "(no name)",
                   packed ? "; write the file again without compression" : "");
  }
}

static void note_left_out(gltf *g) {
  size_t n;
  if (ylm__gltf_list(g, NULL, g->root, "animations", &n))
    ylm__gltf_note(g, "animations left out, everything stands where its nodes place it: %zu", n);
}

static void clear(gltf *g) {
  for (size_t i = 0; g->buffer && i < g->buffers; i++) ylm_free(g->buffer[i].own);
  ylm_free(g->buffer);
  ylm_free(g->view);
  ylm_free(g->accessor);
  ylm_free(g->tried);
  ylm_free(g->mean);
  json_decref(g->root);
}

ylm_status ylm_gltf_decode(const unsigned char *data, size_t size, const char *name,
                           const ylm_gltf_options *o, ylm_gltf **out, ylm_error *e) {
  static const ylm_gltf_options defaults;
  gltf g = {.name = name, .o = o ? o : &defaults, .e = e, .lookups = 1 << 24};
  gltf_bytes json;
  *out = NULL;
  g.out = ylm__gltf_alloc(&g, 1, sizeof *g.out);
  ylm__gltf_unwrap(&g, data, size, &json);
  if (g.status == YLM_OK) ylm__gltf_parse(&g, json.data, json.size);
  if (g.status == YLM_OK) check_version(&g);
  if (g.status == YLM_OK) check_extensions(&g);
  if (g.status == YLM_OK) ylm__gltf_accessors(&g);
  if (g.status == YLM_OK) ylm__gltf_materials(&g);
  if (g.status == YLM_OK) ylm__gltf_nodes(&g);
  if (g.status == YLM_OK) note_left_out(&g);
  clear(&g);
  if (g.status == YLM_OK)
    *out = g.out;
  else
    ylm_gltf_free(g.out);
  return g.status;
}

void ylm_gltf_free(ylm_gltf *g) {
  if (!g) return;
  for (size_t i = 0; i < g->pieces; i++) {
    ylm_mesh_free(g->piece[i].mesh);
    ylm_free(g->piece[i].extras);
  }
  for (size_t i = 0; i < g->materials; i++) ylm_free(g->material[i].extras);
  for (size_t i = 0; i < g->cameras; i++) ylm_free(g->camera[i].extras);
  for (size_t i = 0; i < g->lamps; i++) ylm_free(g->lamp[i].extras);
  for (size_t i = 0; i < g->images; i++) ylm_image_free(g->image[i]);
  for (size_t i = 0; i < g->notes; i++) ylm_free(g->note[i]);
  ylm_free(g->piece);
  ylm_free(g->material);
  ylm_free(g->lamp);
  for (size_t i = 0; i < g->profiles; i++) ylm_free(g->profile[i].data);
  ylm_free(g->profile);
  ylm_free(g->camera);
  ylm_free(g->image);
  ylm_free(g->note);
  ylm_free(g->extras);
  ylm_free(g);
}
