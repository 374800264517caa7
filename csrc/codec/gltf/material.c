/* material.c - materials as factors, and the images that they use. */
#include <math.h>

#include "gltf.h"

/* Extensions of materials that are read. */
static const char *const known[] = {"KHR_materials_emissive_strength", "KHR_materials_ior",
                                    "KHR_materials_specular", "KHR_materials_unlit"};

static void name_unknown(gltf *g, const place *at, const json_t *o) {
  const json_t *all = ylm__gltf_object(g, at, o, "extensions");
  const char *key;
  json_t *value;
  json_object_foreach((json_t *)all, key, value) {
    bool found = false;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) found |= strcmp(key, known[i]) == 0;
    if (!found) ylm__gltf_note(g, "material %zu: %.60s is ignored", at->index, key);
  }
}

/* Reflectance of what is no metal along the normal. */
static float reflectance(gltf *g, const place *at, const json_t *o) {
  place pe = {at, "extensions", 0}, pi = {&pe, "KHR_materials_ior", 0},
        ps = {&pe, "KHR_materials_specular", 0};
  double ior = ylm__gltf_number(g, &pi, ylm__gltf_extension(g, at, o, "KHR_materials_ior"), "ior",
                                1.5, 0, 1e6);
  double specular = ylm__gltf_number(
      g, &ps, ylm__gltf_extension(g, at, o, "KHR_materials_specular"), "specularFactor", 1, 0, 1);
  double r = ior == 0 ? 1 : (ior - 1) / (ior + 1);
  return (float)(r * r * specular);
}

static void read_alpha(gltf *g, const place *at, const json_t *o, ylm_gltf_material *m) {
  const char *mode = ylm__gltf_string(g, at, o, "alphaMode");
  m->cutoff = (float)ylm__gltf_number(g, at, o, "alphaCutoff", 0.5, 0, 1e30);
  if (mode && strcmp(mode, "MASK") == 0)
    m->alpha = YLM_GLTF_MASK;
  else if (mode && strcmp(mode, "BLEND") == 0)
    m->alpha = YLM_GLTF_BLEND;
  else if (mode && strcmp(mode, "OPAQUE") != 0) {
    place p = {at, "alphaMode", 0};
    ylm__gltf_fail(g, YLM_EFORMAT, &p, "OPAQUE, MASK or BLEND expected");
  }
}

static void read_material(gltf *g, const place *at, const json_t *o, ylm_gltf_material *m) {
  static const float identity[6] = {1, 0, 0, 0, 1, 0};
  double base[4] = {1, 1, 1, 1}, emission[3] = {0};
  place pp = {at, "pbrMetallicRoughness", 0}, pe = {at, "extensions", 0},
        ps = {&pe, "KHR_materials_emissive_strength", 0};
  const json_t *pbr = ylm__gltf_object(g, at, o, "pbrMetallicRoughness");
  ylm__gltf_name(g, at, o, m->name);
  ylm__gltf_numbers(g, &pp, pbr, "baseColorFactor", 4, base);
  ylm__gltf_numbers(g, at, o, "emissiveFactor", 3, emission);
  double strength =
      ylm__gltf_number(g, &ps, ylm__gltf_extension(g, at, o, "KHR_materials_emissive_strength"),
                       "emissiveStrength", 1, 0, 1e30);
  m->metallic = (float)ylm__gltf_number(g, &pp, pbr, "metallicFactor", 1, 0, 1);
  m->roughness = (float)ylm__gltf_number(g, &pp, pbr, "roughnessFactor", 1, 0, 1);
  m->f0 = reflectance(g, at, o);
  m->unlit = ylm__gltf_extension(g, at, o, "KHR_materials_unlit") != NULL;
  m->both_sides = ylm__gltf_boolean(g, at, o, "doubleSided");
  m->base_image = m->emission_image = -1;
  memcpy(m->base_map, identity, sizeof identity);
  memcpy(m->emission_map, identity, sizeof identity);
  read_alpha(g, at, o, m);
  for (int i = 0; i < 4; i++) {
    if (!(base[i] >= 0 && base[i] <= 1))
      ylm__gltf_fail(g, YLM_EFORMAT, &pp, "baseColorFactor must be from 0 to 1");
    m->base[i] = (float)base[i];
  }
  for (int i = 0; i < 3; i++) {
    if (!(emission[i] >= 0 && emission[i] <= 1e30))
      ylm__gltf_fail(g, YLM_EFORMAT, at, "emissiveFactor must be 0 or more");
    m->emission[i] = (float)fmin(emission[i] * strength, 1e30);
  }
  m->extras = ylm__gltf_extras(g, o);
  name_unknown(g, at, o);
}

void ylm__gltf_materials(gltf *g) {
  size_t n;
  place pm = {NULL, "materials", 0};
  json_t *list = ylm__gltf_list(g, NULL, g->root, "materials", &n);
  g->out->material = ylm__gltf_alloc(g, n, sizeof *g->out->material);
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    place p = {&pm, NULL, i};
    g->out->materials = i + 1;
    read_material(g, &p, ylm__gltf_entry(g, &pm, list, i), &g->out->material[i]);
  }
}
