/* material.c - materials as factors, and the images that they use. */
#include <math.h>

#include "gltf.h"
#include "ylm_codec.h"

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

/* -- images ------------------------------------------------------------------------------ */

enum { REPEAT = 10497, CLAMP = 33071, MIRROR = 33648 };

/* Decodes bytes; NULL and a note where they are no image that is read. */
static ylm_image *decode(gltf *g, size_t i, const gltf_bytes *b, bool raw) {
  uint64_t most = g->o->texels ? g->o->texels : (uint64_t)1 << 26;
  ylm_codec_kind kind = ylm_codec_recognise(b->data, b->size);
  ylm_codec_input input = {.raw = raw, .numbers = 4 * (most - g->texels)};
  char name[32];
  snprintf(name, sizeof name, "image %zu", i);
  if (kind != YLM_CODEC_PNG && kind != YLM_CODEC_JPEG) {
    ylm__gltf_note(g, "%s is neither PNG nor JPEG: the factors stand alone", name);
    return NULL;
  }
  if (g->texels >= most) {
    ylm__gltf_note(g, "%s: %llu texels of one file are read: the factors stand alone", name,
                   (unsigned long long)most);
    return NULL;
  }
  ylm_error e = {0};
  ylm_image *image = NULL;
  ylm_status s = ylm_codec_parse(b->data, b->size, name, &input, &image, &e);
  if (s == YLM_ENOMEM)
    ylm__gltf_fail(g, s, NULL, "%.200s", e.text);
  else if (s == YLM_ELIMIT)
    ylm__gltf_note(g, "%.200s (of a file %llu texels): the factors stand alone", e.text,
                   (unsigned long long)most);
  else if (s != YLM_OK)
    ylm__gltf_note(g, "%.200s: the factors stand alone", e.text);
  else
    g->texels += (uint64_t)image->width * (uint64_t)image->height;
  return image;
}

/* The bytes of image i, decoded; NULL and a note or a failure. */
static ylm_image *load(gltf *g, size_t i, bool raw) {
  place pi = {NULL, "images", 0}, p = {&pi, NULL, i}, pu = {&p, "uri", 0};
  size_t n;
  const json_t *o = ylm__gltf_entry(g, &pi, ylm__gltf_list(g, NULL, g->root, "images", &n), i);
  int64_t view = ylm__gltf_reference(g, &p, o, "bufferView", "view", g->views);
  const char *uri = ylm__gltf_string(g, &p, o, "uri");
  gltf_bytes b = {0};
  if (view >= 0)
    b = (gltf_bytes){g->view[view].data, g->view[view].size, NULL};
  else if (uri)
    ylm__gltf_fetch(g, &pu, uri, &b);
  ylm_image *image = g->status == YLM_OK && b.data ? decode(g, i, &b, raw) : NULL;
  ylm_free(b.own);
  return image;
}

static ylm_texture_wrap read_wrap(gltf *g, const place *at, const json_t *sampler,
                                  const char *key) {
  uint64_t mode = ylm__gltf_integer(g, at, sampler, key, REPEAT);
  place p = {at, key, 0};
  if (mode != REPEAT && mode != CLAMP && mode != MIRROR)
    ylm__gltf_fail(g, YLM_EFORMAT, &p, "10497, 33071 or 33648 expected");
  return mode == CLAMP    ? YLM_TEXTURE_CLAMP
         : mode == MIRROR ? YLM_TEXTURE_MIRROR
                          : YLM_TEXTURE_REPEAT;
}

/* The image that a texture of a material names, and where it is looked up; -1 where there is none. */
static int32_t find_image(gltf *g, const place *at, const json_t *o, const char *key, int32_t *set,
                          float map[6], ylm_texture_wrap wrap[2]) {
  place p = {at, key, 0}, pe = {&p, "extensions", 0}, px = {&pe, "KHR_texture_transform", 0};
  place pt = {NULL, "textures", 0};
  size_t textures, images, samplers;
  const json_t *info = ylm__gltf_object(g, at, o, key);
  if (!info) return -1;
  json_t *list = ylm__gltf_list(g, NULL, g->root, "textures", &textures);
  ylm__gltf_list(g, NULL, g->root, "images", &images);
  json_t *modes = ylm__gltf_list(g, NULL, g->root, "samplers", &samplers);
  int64_t t = ylm__gltf_reference(g, &p, info, "index", "texture", textures);
  uint64_t coordinates = ylm__gltf_integer(g, &p, info, "texCoord", 0);
  const json_t *x = ylm__gltf_extension(g, &p, info, "KHR_texture_transform");
  double offset[2] = {0}, scale[2] = {1, 1};
  ylm__gltf_numbers(g, &px, x, "offset", 2, offset);
  ylm__gltf_numbers(g, &px, x, "scale", 2, scale);
  double turn = ylm__gltf_number(g, &px, x, "rotation", 0, -1e6, 1e6);
  coordinates = ylm__gltf_integer(g, &px, x, "texCoord", coordinates);
  if (g->status != YLM_OK || t < 0) return -1;
  place pi = {&pt, NULL, (size_t)t};
  const json_t *texture = ylm__gltf_entry(g, &pt, list, (size_t)t);
  int64_t source = ylm__gltf_reference(g, &pi, texture, "source", "image", images);
  int64_t sampler = ylm__gltf_reference(g, &pi, texture, "sampler", "sampler", samplers);
  place ps = {NULL, "samplers", 0}, pm = {&ps, NULL, (size_t)sampler};
  const json_t *mode = sampler < 0 ? NULL : ylm__gltf_entry(g, &ps, modes, (size_t)sampler);
  wrap[0] = read_wrap(g, &pm, mode, "wrapS");
  wrap[1] = read_wrap(g, &pm, mode, "wrapT");
  if (source < 0) ylm__gltf_note(g, "texture %lld has no image that is known", (long long)t);
  double c = cos(turn), s = sin(turn);
  const double m[6] = {c * scale[0],  s * scale[1], offset[0],
                       -s * scale[0], c * scale[1], offset[1]};
  for (int i = 0; i < 6; i++) map[i] = (float)(fabs(m[i]) < 1e6 ? m[i] : 0);
  *set = coordinates < 1000 ? (int32_t)coordinates : 0;
  return (int32_t)source;
}

/* Means of green and blue of image i, which is decoded once; ones where it cannot be. */
static const float *means(gltf *g, size_t i) {
  float *mean = g->mean + 2 * i;
  if (g->tried[i] & 2) return mean;
  g->tried[i] |= 2;
  mean[0] = mean[1] = 1;
  ylm_image *image = load(g, i, true);
  const ylm_layer *l = image ? &image->layer[0] : NULL;
  size_t n = image ? (size_t)image->width * (size_t)image->height : 0;
  for (size_t c = 0; l && l->channels >= 3 && c < 2; c++) {
    double sum = 0;
    for (size_t k = 0; k < n; k++) sum += (double)l->data[k * (size_t)l->channels + 1 + c];
    mean[c] = (float)(sum / (double)n);
  }
  ylm_image_free(image);
  return mean;
}

/* Multiplies metallic and roughness by the means of their texture's blue and green. */
static void apply_mean(gltf *g, const place *at, const json_t *o, ylm_gltf_material *m) {
  int32_t set;
  float map[6];
  ylm_texture_wrap wrap[2];
  int32_t i = find_image(g, at, o, "metallicRoughnessTexture", &set, map, wrap);
  if (i < 0) return;
  const float *mean = means(g, (size_t)i);
  m->roughness *= mean[0];
  m->metallic *= mean[1];
  ylm__gltf_note(g, "material %zu: metallic and roughness are the means of a texture",
                 at->up->index);
}

/* Decodes the image of a material, once; -1 where it cannot be. */
static int32_t use_image(gltf *g, int32_t i) {
  if (i < 0 || g->status != YLM_OK) return -1;
  if (!(g->tried[i] & 1)) g->out->image[i] = load(g, (size_t)i, false);
  g->tried[i] |= 1;
  return g->out->image[i] ? i : -1;
}

static void read_textures(gltf *g, const place *at, const json_t *o, const json_t *pbr,
                          ylm_gltf_material *m) {
  place pp = {at, "pbrMetallicRoughness", 0};
  if (g->o->no_images) return;
  bool emits = m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0;
  apply_mean(g, &pp, pbr, m);
  m->base_image = use_image(
      g, find_image(g, &pp, pbr, "baseColorTexture", &m->base_set, m->base_map, m->base_wrap));
  if (emits)
    m->emission_image = use_image(g, find_image(g, at, o, "emissiveTexture", &m->emission_set,
                                                m->emission_map, m->emission_wrap));
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
  read_textures(g, at, o, pbr, m);
  m->extras = ylm__gltf_extras(g, o);
  name_unknown(g, at, o);
}

void ylm__gltf_materials(gltf *g) {
  size_t n, images;
  place pm = {NULL, "materials", 0};
  ylm__gltf_list(g, NULL, g->root, "images", &images);
  g->out->image = ylm__gltf_alloc(g, images, sizeof *g->out->image);
  g->tried = ylm__gltf_alloc(g, images, 1);
  g->mean = ylm__gltf_alloc(g, images, 2 * sizeof *g->mean);
  g->out->images = g->status == YLM_OK ? images : 0;
  json_t *list = ylm__gltf_list(g, NULL, g->root, "materials", &n);
  g->out->material = ylm__gltf_alloc(g, n, sizeof *g->out->material);
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    place p = {&pm, NULL, i};
    g->out->materials = i + 1;
    read_material(g, &p, ylm__gltf_entry(g, &pm, list, i), &g->out->material[i]);
  }
}
