/* node.c - the hierarchy of nodes: transforms, instances of meshes, lamps, cameras. */
#include <math.h>

#include "gltf.h"

enum { DEPTH = 256 };

/* A node whose children are being visited. */
typedef struct frame {
  double m[12];
  json_t *children;
  size_t next, count;
} frame;

/* The lists that nodes refer to, and what was found. */
typedef struct walk {
  json_t *nodes, *meshes, *cameras, *lights, *profiles;
  size_t count, mesh_count, camera_count, light_count;
  uint32_t *parent; /* 1 + the node's parent, 0: none */
  uint32_t *root;
  gltf_instance *instance;
  size_t roots, instances, skins;
  frame stack[DEPTH];
} walk;

/* -- transforms -------------------------------------------------------------------------- */

/* Column-major 4 x 4 to rows of 3 x 4. */
static void from_columns(const double c[16], double m[12]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) m[4 * i + j] = c[4 * j + i];
}

/* Translation after rotation (x, y, z, w) after scale. */
static void from_parts(const double t[3], const double q[4], const double s[3], double m[12]) {
  double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  double x = q[0], y = q[1], z = q[2], w = q[3];
  if (n > 0 && isfinite(n)) {
    x /= n, y /= n, z /= n, w /= n;
  } else {
    x = y = z = 0, w = 1;
  }
  double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                 2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                 2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) m[4 * i + j] = r[3 * i + j] * s[j];
    m[4 * i + 3] = t[i];
  }
}

static void local_transform(gltf *g, const place *at, const json_t *o, double m[12]) {
  double c[16], t[3] = {0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
  if (ylm__gltf_numbers(g, at, o, "matrix", 16, c)) {
    from_columns(c, m);
    return;
  }
  ylm__gltf_numbers(g, at, o, "translation", 3, t);
  ylm__gltf_numbers(g, at, o, "rotation", 4, q);
  ylm__gltf_numbers(g, at, o, "scale", 3, s);
  from_parts(t, q, s, m);
}

/* Column j of the 3 x 3 part, made a unit vector; false where it has no length. */
static bool axis(const double m[12], int j, double sign, double out[3]) {
  double n = sqrt(m[j] * m[j] + m[4 + j] * m[4 + j] + m[8 + j] * m[8 + j]);
  for (int i = 0; i < 3; i++) out[i] = sign * m[4 * i + j] / n;
  return n > 0 && isfinite(n);
}

/* A list of n entries with room for one more, zeros; it grows at powers of two. */
static void *grow(gltf *g, void *list, size_t n, size_t size) {
  if (g->status != YLM_OK || (n & (n - 1)) != 0) return list;
  char *more = ylm_realloc(list, n * size, n ? 2 * n : 1, size);
  if (!more) {
    ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
    return list;
  }
  memset(more + n * size, 0, (n ? n : 1) * size);
  return more;
}

/* -- what hangs on nodes --------------------------------------------------------------------- */

static void add_lamp(gltf *g, const place *at, const json_t *o, const double m[12],
                     const char *node) {
  const char *type = ylm__gltf_string(g, at, o, "type");
  double colour[3] = {1, 1, 1};
  g->out->lamp = grow(g, g->out->lamp, g->out->lamps, sizeof *g->out->lamp);
  if (g->status != YLM_OK) return;
  ylm_gltf_lamp *l = &g->out->lamp[g->out->lamps];
  ylm__gltf_name(g, at, o, l->name);
  if (!*l->name) memcpy(l->name, node, sizeof l->name);
  ylm__gltf_numbers(g, at, o, "color", 3, colour);
  double intensity = ylm__gltf_number(g, at, o, "intensity", 1, 0, 1e30);
  l->range = json_object_get(o, "range") != NULL;
  if (type && strcmp(type, "spot") == 0) {
    place p = {at, "spot", 0};
    const json_t *spot = ylm__gltf_object(g, at, o, "spot");
    l->kind = YLM_GLTF_SPOT;
    l->inner = ylm__gltf_number(g, &p, spot, "innerConeAngle", 0, 0, 1.5707963267948966);
    l->outer =
        ylm__gltf_number(g, &p, spot, "outerConeAngle", 0.7853981633974483, 0, 1.5707963267948966);
  } else if (type && strcmp(type, "directional") == 0) {
    l->kind = YLM_GLTF_DIRECTIONAL;
  } else if (!type || strcmp(type, "point") != 0) {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "type must be point, spot or directional");
  }
  for (int i = 0; i < 3; i++) {
    if (!(colour[i] >= 0 && colour[i] <= 1e30))
      ylm__gltf_fail(g, YLM_EFORMAT, at, "color must be three numbers of 0 or more");
    l->at[i] = m[4 * i + 3];
    l->intensity[i] = intensity * colour[i];
  }
  if (!axis(m, 2, -1, l->direction)) l->direction[0] = l->direction[1] = 0, l->direction[2] = -1;
  l->extras = ylm__gltf_extras(g, o);
  g->out->lamps++;
}

/* The bytes of a profile, once a node has it. */
static void take_profile(gltf *g, const place *at, const json_t *o, ylm_gltf_profile *to) {
  if (to->data || g->status != YLM_OK) return;
  const char *uri = ylm__gltf_string(g, at, o, "uri");
  int64_t view = ylm__gltf_reference(g, at, o, "bufferView", "buffer view", g->views);
  gltf_bytes b = {0};
  if (uri) {
    ylm__gltf_fetch(g, at, uri, &b);
  } else if (view >= 0) {
    b.data = g->view[view].data;
    b.size = g->view[view].size;
  } else {
    ylm__gltf_fail(g, YLM_EFORMAT, at, "uri or bufferView expected");
  }
  if (g->status == YLM_OK) {
    to->data = ylm_alloc_copy(b.data, b.size, 1);
    to->size = b.size;
    if (!to->data) ylm__gltf_fail(g, YLM_ENOMEM, NULL, "memory ran out");
  }
  ylm_free(b.own);
}

/* A photometric file that shines along a node's -z, its C0 along x. */
static void add_profile(gltf *g, const place *at, const json_t *o, size_t profile,
                        const double m[12], const char *node) {
  double colour[3] = {1, 1, 1};
  g->out->lamp = grow(g, g->out->lamp, g->out->lamps, sizeof *g->out->lamp);
  if (g->status != YLM_OK) return;
  ylm_gltf_lamp *l = &g->out->lamp[g->out->lamps];
  memcpy(l->name, node, sizeof l->name);
  l->kind = YLM_GLTF_PROFILE;
  l->profile = profile;
  double multiplier = ylm__gltf_number(g, at, o, "multiplier", 1, 0, 1e30);
  ylm__gltf_numbers(g, at, o, "color", 3, colour);
  for (int i = 0; i < 3; i++) {
    if (!(colour[i] >= 0 && colour[i] <= 1))
      ylm__gltf_fail(g, YLM_EFORMAT, at, "color must be three numbers from 0 to 1");
    l->at[i] = m[4 * i + 3];
    l->intensity[i] = multiplier * colour[i];
  }
  if (!axis(m, 2, -1, l->direction)) l->direction[0] = l->direction[1] = 0, l->direction[2] = -1;
  if (!axis(m, 0, 1, l->across)) l->across[0] = 1, l->across[1] = l->across[2] = 0;
  g->out->lamps++;
}

static void add_camera(gltf *g, const place *at, const json_t *o, const double m[12],
                       const char *node) {
  g->out->camera = grow(g, g->out->camera, g->out->cameras, sizeof *g->out->camera);
  if (g->status != YLM_OK) return;
  ylm_gltf_camera *c = &g->out->camera[g->out->cameras];
  place p = {at, "perspective", 0};
  const json_t *perspective = ylm__gltf_object(g, at, o, "perspective");
  ylm__gltf_name(g, at, o, c->name);
  if (!*c->name) memcpy(c->name, node, sizeof c->name);
  c->yfov = perspective ? ylm__gltf_number(g, &p, perspective, "yfov", 0, 1e-6, 3.14159) : 0;
  for (int i = 0; i < 3; i++) c->from[i] = m[4 * i + 3];
  if (axis(m, 2, -1, c->forward) && axis(m, 1, 1, c->up)) {
    c->extras = ylm__gltf_extras(g, o);
    g->out->cameras++;
  }
}

static void add_instance(gltf *g, walk *w, const json_t *node, const double m[12], const char *name,
                         size_t mesh) {
  w->instance = grow(g, w->instance, w->instances, sizeof *w->instance);
  if (g->status == YLM_OK && w->instances >= YLM_GLTF_PIECES)
    ylm__gltf_fail(g, YLM_ELIMIT, NULL, "more than %d nodes with meshes", YLM_GLTF_PIECES);
  if (g->status != YLM_OK) return;
  gltf_instance *i = &w->instance[w->instances++];
  memcpy(i->m, m, sizeof i->m);
  memcpy(i->name, name, sizeof i->name);
  i->mesh = mesh;
  i->node = node;
  w->skins += json_object_get(node, "skin") != NULL;
}

static void hang_profile(gltf *g, walk *w, const place *at, const json_t *o, const double m[12],
                         const char *name) {
  place pe = {at, "extensions", 0}, pl = {&pe, "EXT_lights_ies", 0};
  const json_t *extension = ylm__gltf_extension(g, at, o, "EXT_lights_ies");
  int64_t light = ylm__gltf_reference(g, &pl, extension, "light", "light", g->out->profiles);
  if (light < 0) return;
  place re = {NULL, "extensions", 0}, rl = {&re, "EXT_lights_ies", 0}, rc = {&rl, "lights", 0};
  place p = {&rc, NULL, (size_t)light};
  take_profile(g, &p, ylm__gltf_entry(g, &rc, w->profiles, p.index), &g->out->profile[light]);
  add_profile(g, &pl, extension, (size_t)light, m, name);
}

static void hang(gltf *g, walk *w, const place *at, const json_t *o, const double m[12]) {
  char name[YLM_GLTF_NAME];
  ylm__gltf_name(g, at, o, name);
  int64_t mesh = ylm__gltf_reference(g, at, o, "mesh", "mesh", w->mesh_count);
  int64_t camera = ylm__gltf_reference(g, at, o, "camera", "camera", w->camera_count);
  place pe = {at, "extensions", 0}, pl = {&pe, "KHR_lights_punctual", 0};
  const json_t *extension = ylm__gltf_extension(g, at, o, "KHR_lights_punctual");
  int64_t light = ylm__gltf_reference(g, &pl, extension, "light", "light", w->light_count);
  if (mesh >= 0) add_instance(g, w, o, m, name, (size_t)mesh);
  if (camera >= 0) {
    place pc = {NULL, "cameras", 0}, p = {&pc, NULL, (size_t)camera};
    add_camera(g, &p, ylm__gltf_entry(g, &pc, w->cameras, p.index), m, name);
  }
  if (light >= 0) {
    place pc = {&pl, "lights", 0}, p = {&pc, NULL, (size_t)light};
    add_lamp(g, &p, ylm__gltf_entry(g, &pc, w->lights, p.index), m, name);
  }
  hang_profile(g, w, at, o, m, name);
}

/* -- the walk ---------------------------------------------------------------------------------- */

/* Notes the parent of every node; a node has one at most. */
static void find_parents(gltf *g, walk *w) {
  place pn = {NULL, "nodes", 0};
  for (size_t i = 0; g->status == YLM_OK && i < w->count; i++) {
    place p = {&pn, NULL, i}, pc = {&p, "children", 0};
    size_t n;
    json_t *children = ylm__gltf_list(g, &p, ylm__gltf_entry(g, &pn, w->nodes, i), "children", &n);
    for (size_t k = 0; g->status == YLM_OK && k < n; k++) {
      place pk = {&pc, NULL, k};
      const json_t *v = json_array_get(children, k);
      double x = json_is_number(v) ? json_number_value(v) : -1;
      if (!(x >= 0 && x < (double)w->count) || x != floor(x)) {
        ylm__gltf_fail(g, YLM_EFORMAT, &pk, "the number of one of %zu nodes expected", w->count);
      } else if (w->parent[(size_t)x]) {
        ylm__gltf_fail(g, YLM_EFORMAT, &pk, "node %zu is a child of node %u too", (size_t)x,
                       w->parent[(size_t)x] - 1);
      } else {
        w->parent[(size_t)x] = (uint32_t)i + 1;
      }
    }
  }
}

/* Refuses nodes that are below themselves: each step leads to the parent, and marks what was seen. */
static void find_cycles(gltf *g, const walk *w) {
  place pn = {NULL, "nodes", 0};
  uint32_t *seen = ylm__gltf_alloc(g, w->count, sizeof *seen);
  for (size_t i = 0; g->status == YLM_OK && i < w->count; i++) {
    size_t k = i;
    while (!seen[k] && w->parent[k]) {
      seen[k] = (uint32_t)i + 1;
      k = w->parent[k] - 1;
    }
    place p = {&pn, NULL, k};
    if (w->parent[k] && seen[k] == (uint32_t)i + 1)
      ylm__gltf_fail(g, YLM_EFORMAT, &p, "the node is below itself");
  }
  ylm_free(seen);
}

/* Roots: those of the scene, or all nodes without a parent. */
static void find_roots(gltf *g, walk *w) {
  size_t scenes, n;
  place ps = {NULL, "scenes", 0};
  json_t *list = ylm__gltf_list(g, NULL, g->root, "scenes", &scenes);
  int64_t chosen = ylm__gltf_reference(g, NULL, g->root, "scene", "scene", scenes);
  if (g->o->scene > 0) {
    chosen = g->o->scene - 1;
    if ((size_t)chosen >= scenes) {
      ylm__gltf_fail(g, YLM_EFORMAT, NULL, "scene %d of %zu", g->o->scene, scenes);
      return;
    }
  }
  if (chosen < 0 && scenes == 1) chosen = 0;
  if (chosen < 0) {
    for (size_t i = 0; i < w->count; i++)
      if (!w->parent[i]) w->root[w->roots++] = (uint32_t)i;
    return;
  }
  place p = {&ps, NULL, (size_t)chosen}, pr = {&p, "nodes", 0};
  const json_t *scene = ylm__gltf_entry(g, &ps, list, p.index);
  g->out->extras = ylm__gltf_extras(g, scene);
  json_t *roots = ylm__gltf_list(g, &p, scene, "nodes", &n);
  unsigned char *listed = ylm__gltf_alloc(g, w->count, 1);
  for (size_t i = 0; g->status == YLM_OK && i < n; i++) {
    place pi = {&pr, NULL, i};
    const json_t *v = json_array_get(roots, i);
    double x = json_is_number(v) ? json_number_value(v) : -1;
    bool fits = x >= 0 && x < (double)w->count && x == floor(x);
    if (!fits || w->parent[(size_t)x] || listed[(size_t)x]) {
      ylm__gltf_fail(g, YLM_EFORMAT, &pi,
                     "the number of a node without a parent expected, each once");
    } else {
      listed[(size_t)x] = 1;
      w->root[w->roots++] = (uint32_t)x;
    }
  }
  ylm_free(listed);
}

/* Visits node `node` below `up`: its frame is ready for its children. */
static void enter(gltf *g, walk *w, size_t node, const double up[12], frame *f) {
  place pn = {NULL, "nodes", 0}, p = {&pn, NULL, node};
  const json_t *o = ylm__gltf_entry(g, &pn, w->nodes, node);
  double local[12];
  local_transform(g, &p, o, local);
  ylm_transform_compose(f->m, up, local);
  for (int i = 0; i < 12; i++)
    if (!(fabs(f->m[i]) <= 1e12)) ylm__gltf_fail(g, YLM_EFORMAT, &p, "its place is beyond 1e12");
  if (g->status != YLM_OK) return;
  hang(g, w, &p, o, f->m);
  f->children = ylm__gltf_list(g, &p, o, "children", &f->count);
  f->next = 0;
  g->out->nodes++;
}

/* Visits everything below a root, depth first. */
static void visit_below(gltf *g, walk *w, size_t root) {
  static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  enter(g, w, root, identity, &w->stack[0]);
  for (size_t depth = 1; g->status == YLM_OK && depth > 0;) {
    frame *f = &w->stack[depth - 1];
    if (f->next == f->count) {
      depth--;
    } else if (depth == DEPTH) {
      ylm__gltf_fail(g, YLM_ELIMIT, NULL, "nodes nest more than %d deep", DEPTH);
    } else {
      size_t child = (size_t)json_number_value(json_array_get(f->children, f->next++));
      enter(g, w, child, f->m, f + 1);
      depth++;
    }
  }
}

/* Counts triangles and pieces of all instances, before memory is taken for them. */
static void check_size(gltf *g, const walk *w, uint64_t *triangles_of, size_t *pieces_of) {
  uint64_t most = g->o->triangles ? g->o->triangles : YLM_MESH_MAX, triangles = 0, pieces = 0;
  for (size_t i = 0; g->status == YLM_OK && i < w->mesh_count; i++) triangles_of[i] = UINT64_MAX;
  for (size_t i = 0; g->status == YLM_OK && i < w->instances; i++) {
    size_t mesh = w->instance[i].mesh;
    if (triangles_of[mesh] == UINT64_MAX)
      triangles_of[mesh] = ylm__gltf_count_triangles(g, mesh, &pieces_of[mesh]);
    triangles += triangles_of[mesh];
    pieces += pieces_of[mesh];
    if (g->status == YLM_OK && triangles > most)
      ylm__gltf_fail(g, YLM_ELIMIT, NULL, "more than %llu triangles", (unsigned long long)most);
    if (g->status == YLM_OK && pieces > YLM_GLTF_PIECES)
      ylm__gltf_fail(g, YLM_ELIMIT, NULL, "more than %d pieces, a node and a primitive each",
                     YLM_GLTF_PIECES);
  }
  g->out->triangles = (size_t)triangles;
  g->out->piece = ylm__gltf_alloc(g, (size_t)pieces, sizeof *g->out->piece);
  g->room = (size_t)pieces;
}

/* Makes pieces, mesh by mesh: each is decoded once. */
static void make_pieces(gltf *g, walk *w) {
  uint64_t *triangles = ylm__gltf_alloc(g, w->mesh_count, sizeof *triangles);
  size_t *pieces = ylm__gltf_alloc(g, w->mesh_count, sizeof *pieces);
  size_t *first = ylm__gltf_alloc(g, w->mesh_count + 1, sizeof *first);
  gltf_instance *sorted = ylm__gltf_alloc(g, w->instances, sizeof *sorted);
  check_size(g, w, triangles, pieces);
  for (size_t i = 0; g->status == YLM_OK && i < w->instances; i++) first[w->instance[i].mesh + 1]++;
  for (size_t i = 0; g->status == YLM_OK && i < w->mesh_count; i++) first[i + 1] += first[i];
  for (size_t i = 0; g->status == YLM_OK && i < w->instances; i++)
    sorted[first[w->instance[i].mesh]++] = w->instance[i];
  for (size_t i = 0; g->status == YLM_OK && i < w->instances;) {
    size_t n = 1;
    while (i + n < w->instances && sorted[i + n].mesh == sorted[i].mesh) n++;
    ylm__gltf_pieces(g, sorted[i].mesh, sorted + i, n);
    i += n;
  }
  ylm_free(triangles);
  ylm_free(pieces);
  ylm_free(first);
  ylm_free(sorted);
}

static void read_nodes(gltf *g, walk *w) {
  place pe = {NULL, "extensions", 0}, pl = {&pe, "KHR_lights_punctual", 0};
  w->nodes = ylm__gltf_list(g, NULL, g->root, "nodes", &w->count);
  w->meshes = ylm__gltf_list(g, NULL, g->root, "meshes", &w->mesh_count);
  w->cameras = ylm__gltf_list(g, NULL, g->root, "cameras", &w->camera_count);
  const json_t *punctual = ylm__gltf_extension(g, NULL, g->root, "KHR_lights_punctual");
  w->lights = ylm__gltf_list(g, &pl, punctual, "lights", &w->light_count);
  place px = {&pe, "EXT_lights_ies", 0};
  const json_t *ies = ylm__gltf_extension(g, NULL, g->root, "EXT_lights_ies");
  size_t profiles = 0;
  w->profiles = ylm__gltf_list(g, &px, ies, "lights", &profiles);
  g->out->profile = ylm__gltf_alloc(g, profiles, sizeof *g->out->profile);
  if (g->out->profile) g->out->profiles = profiles;
  w->parent = ylm__gltf_alloc(g, w->count, sizeof *w->parent);
  w->root = ylm__gltf_alloc(g, w->count, sizeof *w->root);
  if (g->status == YLM_OK) find_parents(g, w);
  if (g->status == YLM_OK) find_cycles(g, w);
  if (g->status == YLM_OK) find_roots(g, w);
  for (size_t i = 0; g->status == YLM_OK && i < w->roots; i++) visit_below(g, w, w->root[i]);
  if (g->status == YLM_OK) make_pieces(g, w);
  if (w->skins)
    ylm__gltf_note(g, "skinned meshes, which stand in the pose in which they were modelled: %zu",
                   w->skins);
}

void ylm__gltf_nodes(gltf *g) {
  walk *w = ylm__gltf_alloc(g, 1, sizeof *w);
  if (!w) return;
  read_nodes(g, w);
  ylm_free(w->parent);
  ylm_free(w->root);
  ylm_free(w->instance);
  ylm_free(w);
}
