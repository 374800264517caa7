/* primitive.c - primitives: strips and fans to triangles, vertices that are used, normals. */
#include <math.h>

#include "gltf.h"

enum { POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, STRIP, FAN };

/* A primitive, its accessors checked. */
typedef struct primitive {
  const gltf_accessor *position, *normal, *colour, *index, *uv;
  size_t corners, triangles; /* of the list of vertices */
  int mode, uv_set;
  int32_t material;
} primitive;

static const gltf_accessor *attribute(gltf *g, const place *at, const json_t *o, const char *key) {
  int64_t i = ylm__gltf_reference(g, at, o, key, "accessor", g->accessors);
  return i < 0 ? NULL : &g->accessor[i];
}

static void need(gltf *g, const place *at, const char *key, bool fits, const char *wanted) {
  place p = {at, key, 0};
  if (!fits) ylm__gltf_fail(g, YLM_EFORMAT, &p, "%s expected", wanted);
}

/* The triangles of n corners. */
static size_t triangles_of(int mode, size_t n) {
  if (mode == TRIANGLES) return n / 3;
  return mode >= STRIP && n >= 3 ? n - 2 : 0;
}

static void read_primitive(gltf *g, const place *at, const json_t *o, primitive *p) {
  place pa = {at, "attributes", 0};
  const json_t *attributes = ylm__gltf_object(g, at, o, "attributes");
  *p = (primitive){.position = attribute(g, &pa, attributes, "POSITION"),
                   .normal = attribute(g, &pa, attributes, "NORMAL"),
                   .colour = attribute(g, &pa, attributes, "COLOR_0"),
                   .index = attribute(g, at, o, "indices")};
  p->material = (int32_t)ylm__gltf_reference(g, at, o, "material", "material", g->out->materials);
  uint64_t mode = ylm__gltf_integer(g, at, o, "mode", TRIANGLES);
  need(g, at, "mode", mode <= FAN, "0 to 6");
  p->mode = (int)mode;
  if (g->status != YLM_OK || mode < TRIANGLES || !p->position) return;
  need(g, &pa, "POSITION", p->position->numbers == 3 && p->position->component != 5125,
       "an accessor of VEC3, of float or of 8 or 16 bits");
  if (p->normal)
    need(g, &pa, "NORMAL",
         p->normal->numbers == 3 && p->normal->component != 5125 &&
             p->normal->count >= p->position->count,
         "an accessor of VEC3, one for each position");
  if (p->colour)
    need(g, &pa, "COLOR_0",
         (p->colour->numbers == 3 || p->colour->numbers == 4) && p->colour->component != 5125 &&
             p->colour->count >= p->position->count,
         "an accessor of VEC3 or VEC4, one for each position");
  if (p->index)
    need(g, at, "indices",
         p->index->numbers == 1 && p->index->component != 5126 && (p->index->component & 1) &&
             !p->index->normalized,
         "an accessor of unsigned integers");
  const ylm_gltf_material *m = p->material < 0 ? NULL : &g->out->material[p->material];
  if (m && (m->base_image >= 0 || m->emission_image >= 0)) {
    char key[32];
    p->uv_set = m->base_image >= 0 ? m->base_set : m->emission_set;
    snprintf(key, sizeof key, "TEXCOORD_%d", p->uv_set);
    p->uv = attribute(g, &pa, attributes, key);
    if (p->uv)
      need(g, &pa, key,
           p->uv->numbers == 2 && p->uv->component != 5125 && p->uv->count >= p->position->count,
           "an accessor of VEC2, one for each position");
  }
  p->corners = p->index ? p->index->count : p->position->count;
  p->triangles = g->status == YLM_OK ? triangles_of(p->mode, p->corners) : 0;
}

static json_t *primitives_of(gltf *g, size_t mesh, place *pm, place *pi, place *pp, size_t *n) {
  size_t meshes;
  *pm = (place){NULL, "meshes", 0};
  *pi = (place){pm, NULL, mesh};
  *pp = (place){pi, "primitives", 0};
  json_t *list = ylm__gltf_list(g, NULL, g->root, "meshes", &meshes);
  return ylm__gltf_list(g, pi, ylm__gltf_entry(g, pm, list, mesh), "primitives", n);
}

uint64_t ylm__gltf_count_triangles(gltf *g, size_t mesh, size_t *pieces) {
  place pm, pi, pp;
  size_t n, lines = 0, morphs = 0;
  json_t *list = primitives_of(g, mesh, &pm, &pi, &pp, &n);
  uint64_t triangles = 0;
  *pieces = 0;
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    place p = {&pp, NULL, i};
    primitive one;
    const json_t *o = ylm__gltf_entry(g, &pp, list, i);
    read_primitive(g, &p, o, &one);
    lines += one.mode < TRIANGLES;
    morphs += json_object_get(o, "targets") != NULL;
    triangles += one.triangles;
    *pieces += one.triangles > 0;
  }
  if (lines)
    ylm__gltf_note(g, "mesh %zu: primitives of points or lines left out: %zu", mesh, lines);
  if (morphs) ylm__gltf_note(g, "mesh %zu: morph targets are left out", mesh);
  return triangles;
}

/* -- corners ----------------------------------------------------------------------------- */

/* Corner c of triangle t, as a place in the list of vertices. Every other triangle of a strip is
   turned round. */
static size_t corner(int mode, size_t t, int c) {
  if (mode == TRIANGLES) return 3 * t + (size_t)c;
  if (mode == FAN) return c == 0 ? 0 : t + (size_t)c;
  if (t % 2 == 1 && c > 0) c = 3 - c;
  return t + (size_t)c;
}

/* All corners as numbers of vertices [triangles][3], or NULL. */
static uint32_t *corners_of(gltf *g, const place *at, const primitive *p) {
  uint32_t *out = ylm__gltf_alloc(g, p->triangles, 3 * sizeof *out);
  for (size_t t = 0; g->status == YLM_OK && t < p->triangles; t++) {
    for (int c = 0; c < 3; c++) {
      size_t k = corner(p->mode, t, c);
      uint32_t v = p->index ? ylm__gltf_index(p->index, k) : (uint32_t)k;
      if (v >= p->position->count) {
        place pi = {at, "indices", 0};
        ylm__gltf_fail(g, YLM_EFORMAT, &pi, "index %zu is %u, there are %zu vertices", k, v,
                       p->position->count);
        break;
      }
      out[3 * t + (size_t)c] = v;
    }
  }
  return out;
}

static int by_number(const void *a, const void *b) {
  uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
  return (x > y) - (x < y);
}

/* Renumbers corners so that few vertices remain that they do not use; *used is their old numbers, in order. */
static size_t compact(gltf *g, size_t n, uint32_t *corners, size_t vertices, uint32_t **used) {
  size_t count = 0;
  *used = ylm__gltf_alloc(g, n, sizeof **used);
  if (!*used) return 0;
  if (vertices <= n) { /* few that are not used: all stay */
    for (size_t v = 0; v < vertices; v++) (*used)[v] = (uint32_t)v;
    return vertices;
  }
  if (vertices <= 4 * n) { /* by a table */
    uint32_t *new = ylm__gltf_alloc(g, vertices, sizeof *new);
    if (!new) return 0;
    for (size_t i = 0; i < n; i++) new[corners[i]] = 1;
    for (size_t v = 0; v < vertices; v++)
      if (new[v]) {
        (*used)[count] = (uint32_t)v;
        new[v] = (uint32_t)count++;
      }
    for (size_t i = 0; i < n; i++) corners[i] = new[corners[i]];
    ylm_free(new);
    return count;
  }
  memcpy(*used, corners, n * sizeof *corners);
  qsort(*used, n, sizeof **used, by_number);
  for (size_t i = 0; i < n; i++)
    if (i == 0 || (*used)[i] != (*used)[count - 1]) (*used)[count++] = (*used)[i];
  for (size_t i = 0; i < n; i++) {
    const uint32_t *found = bsearch(&corners[i], *used, count, sizeof **used, by_number);
    corners[i] = (uint32_t)(found - *used);
  }
  return count;
}

/* -- meshes ---------------------------------------------------------------------------------- */

/* Element i of an accessor of a mesh; a failure where it is not finite. */
static void vertex(gltf *g, const place *at, const char *key, const gltf_accessor *a, size_t i,
                   int n, float *out) {
  float x[16];
  ylm__gltf_element(a, i, x);
  for (int k = 0; k < n; k++) {
    place pa = {at, "attributes", 0};
    if (!isfinite(x[k])) need(g, &pa, key, false, "finite numbers");
    out[k] = x[k];
  }
}

static void unit(float n[3]) {
  double l = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
  if (!(l > 1e-12)) {
    n[0] = n[1] = 0, n[2] = 1;
    return;
  }
  for (int i = 0; i < 3; i++) n[i] = (float)(n[i] / l);
}

/* Where the image is looked up: the map of the file, then v upwards. */
static void place_uv(const float map[6], float uv[2]) {
  double u = uv[0], v = uv[1];
  uv[0] = (float)fmax(-1e30, fmin(1e30, map[0] * u + map[1] * v + map[2]));
  uv[1] = (float)fmax(-1e30, fmin(1e30, 1 - (map[3] * u + map[4] * v + map[5])));
}

/* Each triangle gets vertices of its own, with the triangle's normal. */
static void flatten(uint32_t *corners, size_t triangles, const uint32_t *used, uint32_t *out) {
  for (size_t i = 0; i < 3 * triangles; i++) {
    out[i] = used[corners[i]];
    corners[i] = (uint32_t)i;
  }
}

static void face_normals(ylm_mesh *m) {
  for (size_t t = 0; t < m->triangles; t++) {
    const float *a = m->position + 9 * t, *b = a + 3, *c = a + 6;
    double u[3], v[3], n[3], l;
    for (int i = 0; i < 3; i++) u[i] = (double)b[i] - a[i], v[i] = (double)c[i] - a[i];
    for (int i = 0; i < 3; i++)
      n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    l = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 9; k++)
      m->normal[9 * t + (size_t)k] = l > 0 ? (float)(n[k % 3] / l) : k % 3 == 2;
  }
}

/* The mesh of a primitive in its own coordinates; NULL and a failure. *alpha: of its vertices, or NULL. */
static ylm_mesh *decode(gltf *g, const place *at, const primitive *p, float **alpha) {
  uint32_t *used = NULL, *mine = NULL, *corners = corners_of(g, at, p);
  ylm_mesh *m = NULL;
  size_t n =
      g->status == YLM_OK ? compact(g, 3 * p->triangles, corners, p->position->count, &used) : 0;
  if (g->status == YLM_OK && !p->normal) {
    mine = ylm__gltf_alloc(g, p->triangles, 3 * sizeof *mine);
    if (mine) flatten(corners, p->triangles, used, mine);
    n = 3 * p->triangles;
  }
  const uint32_t *vertices = mine ? mine : used;
  if (g->status == YLM_OK) {
    g->status = ylm_mesh_create(n, p->triangles, true, p->uv != NULL, &m, g->e);
    if (m && p->colour && !(m->colour = ylm_alloc(n, 3 * sizeof(float))))
      ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
  }
  const ylm_gltf_material *material = p->material < 0 ? NULL : &g->out->material[p->material];
  bool fades = material && material->alpha != YLM_GLTF_OPAQUE;
  *alpha =
      fades && p->colour && p->colour->numbers == 4 ? ylm__gltf_alloc(g, n, sizeof **alpha) : NULL;
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    vertex(g, at, "POSITION", p->position, vertices[i], 3, m->position + 3 * i);
    if (p->normal) {
      vertex(g, at, "NORMAL", p->normal, vertices[i], 3, m->normal + 3 * i);
      unit(m->normal + 3 * i);
    }
    if (p->uv) {
      vertex(g, at, "TEXCOORD", p->uv, vertices[i], 2, m->uv + 2 * i);
      place_uv(material->base_image >= 0 ? material->base_map : material->emission_map,
               m->uv + 2 * i);
    }
    if (p->colour) {
      float c[4];
      vertex(g, at, "COLOR_0", p->colour, vertices[i], p->colour->numbers, c);
      for (int k = 0; k < p->colour->numbers; k++) c[k] = c[k] < 0 ? 0 : c[k] > 1 ? 1 : c[k];
      memcpy(m->colour + 3 * i, c, 3 * sizeof *c);
      if (*alpha) (*alpha)[i] = c[3];
    }
  }
  if (g->status == YLM_OK) {
    ylm_copy(m->index, corners, 3 * p->triangles * sizeof *corners);
    if (!p->normal) face_normals(m);
  }
  ylm_free(corners);
  ylm_free(used);
  ylm_free(mine);
  if (g->status == YLM_OK) return m;
  ylm_mesh_free(m);
  return NULL;
}

static ylm_mesh *copy_mesh(gltf *g, const ylm_mesh *m) {
  ylm_mesh *c = NULL;
  if (g->status != YLM_OK) return NULL;
  g->status = ylm_mesh_create(m->vertices, m->triangles, true, m->uv != NULL, &c, g->e);
  if (g->status != YLM_OK) return NULL;
  ylm_copy(c->position, m->position, 3 * m->vertices * sizeof(float));
  ylm_copy(c->origin, m->origin, sizeof m->origin);
  ylm_copy(c->normal, m->normal, 3 * m->vertices * sizeof(float));
  if (m->uv) ylm_copy(c->uv, m->uv, 2 * m->vertices * sizeof(float));
  ylm_copy(c->index, m->index, 3 * m->triangles * sizeof *m->index);
  if (m->colour && !(c->colour = ylm_alloc_copy(m->colour, m->vertices, 3 * sizeof(float)))) {
    ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
    ylm_mesh_free(c);
    return NULL;
  }
  return c;
}

/* A new piece, zeros; NULL and a failure. */
static ylm_gltf_piece *new_piece(gltf *g) {
  if (g->out->pieces == g->room) { /* groups make more pieces than primitives */
    if (g->room >= YLM_GLTF_PIECES)
      ylm__gltf_fail(g, YLM_ELIMIT, NULL, "more than %d pieces", YLM_GLTF_PIECES);
    size_t room = 2 * g->room < YLM_GLTF_PIECES ? 2 * g->room : YLM_GLTF_PIECES;
    ylm_gltf_piece *more = ylm__gltf_alloc(g, room, sizeof *more);
    if (!more) return NULL;
    ylm_copy(more, g->out->piece, g->out->pieces * sizeof *more);
    ylm_free(g->out->piece);
    g->out->piece = more;
    g->room = room;
  }
  return &g->out->piece[g->out->pieces++];
}

/* Pieces of a part for `n` transforms; the part's mesh is the callee's. Counts those that cannot be moved. */
static void place_part(gltf *g, const place *at, const gltf_part *part, int32_t material,
                       const char *name, const gltf_instance *instance, size_t n,
                       size_t *left_out) {
  static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  ylm_mesh *m = part->mesh;
  for (size_t k = 0; m && g->status == YLM_OK && k < n; k++) {
    ylm_mesh *moved = k + 1 < n ? copy_mesh(g, m) : m;
    if (!moved) break;
    if (moved == m) m = NULL;
    ylm_error e = {0};
    bool still = memcmp(instance[k].m, identity, sizeof identity) == 0;
    ylm_status s = still ? YLM_OK : ylm_mesh_transform(moved, instance[k].m, &e);
    ylm_gltf_piece *piece = s == YLM_OK ? new_piece(g) : NULL;
    if (piece) {
      piece->mesh = moved;
      piece->material = material;
      piece->grouped = part->grouped;
      piece->alpha = part->alpha;
      memcpy(piece->tint, part->tint, sizeof piece->tint);
      piece->extras = ylm__gltf_extras(g, instance[k].node);
      memcpy(piece->name, *instance[k].name ? instance[k].name : name, sizeof piece->name);
      continue;
    }
    ylm_mesh_free(moved);
    if (s == YLM_EDOMAIN)
      ++*left_out;
    else if (s != YLM_OK)
      ylm__gltf_fail(g, s, at, "%.200s", e.text);
  }
  ylm_mesh_free(m);
}

void ylm__gltf_pieces(gltf *g, size_t mesh, const gltf_instance *instance, size_t instances) {
  place pm, pi, pp;
  size_t n, left_out = 0, cut = 0;
  json_t *list = primitives_of(g, mesh, &pm, &pi, &pp, &n);
  char name[YLM_GLTF_NAME] = "";
  size_t meshes;
  ylm__gltf_name(g, &pi,
                 ylm__gltf_entry(g, &pm, ylm__gltf_list(g, NULL, g->root, "meshes", &meshes), mesh),
                 name);
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    place p = {&pp, NULL, i};
    primitive one;
    read_primitive(g, &p, ylm__gltf_entry(g, &pp, list, i), &one);
    if (g->status != YLM_OK || one.triangles == 0) continue;
    float *alpha = NULL;
    gltf_part *part = NULL;
    ylm_mesh *m = decode(g, &p, &one, &alpha);
    size_t parts = m ? ylm__gltf_parts(g, m, alpha, one.material, &part, &cut) : 0;
    for (size_t k = 0; k < parts; k++)
      place_part(g, &p, &part[k], one.material, name, instance, instances, &left_out);
    ylm_free(part);
    ylm_free(alpha);
  }
  if (cut)
    ylm__gltf_note(g, "mesh %zu: triangles left out, because their alpha is below the cutoff: %zu",
                   mesh, cut);
  if (left_out)
    ylm__gltf_note(g,
                   "mesh %zu: pieces left out, whose nodes flatten them or move them too far: %zu",
                   mesh, left_out);
}
