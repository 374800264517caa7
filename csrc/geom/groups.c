/* groups.c - the materials that an OBJ file names, and a mesh for each of them. */
#include <string.h>

#include "groups.h"

static void free_texts(ylm_mesh_text *t, size_t n) {
  for (size_t i = 0; i < n; i++) ylm_free(t[i].text);
  ylm_free(t);
}

void ylm_mesh_groups_free(ylm_mesh_groups *g) {
  if (!g) return;
  free_texts(g->library, g->libraries);
  free_texts(g->name, g->names);
  ylm_free(g->group);
  ylm_free(g);
}

/* -- while a file is read -------------------------------------------------------- */

void ylm__groups_begin(ylm_grouping *g) {
  memset(g, 0, sizeof *g);
  g->library.size = g->name.size = sizeof(ylm_mesh_text);
  g->group.size = sizeof(uint32_t);
}

void ylm__groups_discard(ylm_grouping *g) {
  free_texts(g->library.data, g->library.count);
  free_texts(g->name.data, g->name.count);
  ylm_free(g->group.data);
  ylm_keys_free(&g->table);
}

ylm_status ylm__groups_library(ylm_grouping *g, ylm_lines *at) {
  ylm_mesh_text *t = ylm__grow(&g->library, 1);
  if (!t) return YLM_ENOMEM;
  t->line = at->line;
  ylm_status s = ylm__rest_of_line(at, &t->text);
  if (s == YLM_OK) g->library.count++;
  return s;
}

static uint64_t hash(const char *text) {
  uint64_t h = 0xcbf29ce484222325u; /* FNV-1a */
  for (; *text; text++) h = (h ^ (unsigned char)*text) * 0x100000001b3u;
  return h ^ h >> 29;
}

/* A name's hash; where another name has it too, the next of these. */
typedef struct name_key {
  uint64_t hash, next;
} name_key;

/* The number of the name behind the others, or of the one that is like it. */
static ylm_status number_name(ylm_grouping *g, const char *text, uint32_t *number) {
  const ylm_mesh_text *name = g->name.data;
  name_key key = {hash(text), 0};
  for (;; key.next++) {
    ylm_status s = ylm_keys_put(&g->table, &key, sizeof key, number);
    if (s != YLM_OK || *number == g->name.count || strcmp(name[*number].text, text) == 0) return s;
  }
}

ylm_status ylm__groups_use(ylm_grouping *g, ylm_lines *at) {
  ylm_mesh_text *t = ylm__grow(&g->name, 1);
  uint32_t number;
  if (!t) return YLM_ENOMEM;
  t->line = at->line;
  ylm_status s = ylm__rest_of_line(at, &t->text);
  if (s != YLM_OK) return s;
  s = number_name(g, t->text, &number);
  if (s == YLM_OK && number == g->name.count)
    g->name.count++;
  else
    ylm_free(t->text);
  if (s == YLM_OK) g->current = number + 1;
  return s;
}

bool ylm__groups_faces(ylm_grouping *g, size_t n) {
  uint32_t *group = ylm__grow(&g->group, n);
  if (!group) return false;
  for (size_t i = 0; i < n; i++) group[i] = g->current;
  g->group.count += n;
  return true;
}

ylm_mesh_groups *ylm__groups_finish(ylm_grouping *g) {
  ylm_mesh_groups *out = ylm_alloc_zero(1, sizeof *out);
  if (!out) return NULL;
  out->libraries = g->library.count;
  out->library = g->library.data;
  out->names = g->name.count;
  out->name = g->name.data;
  out->triangles = g->group.count;
  out->group = g->group.data;
  ylm_keys_free(&g->table);
  ylm__groups_begin(g);
  return out;
}

/* -- a mesh for each -------------------------------------------------------------- */

typedef struct splitting {
  const ylm_mesh *mesh;
  uint32_t *order; /* [triangles] by group                            */
  size_t *first;   /* [groups + 1] in order                           */
  uint32_t *stamp; /* [vertices]: 1 + the last group that used it     */
  uint32_t *place; /* [vertices]: where that has it                   */
  uint32_t *used;  /* [vertices]: the vertices of the group so far    */
} splitting;

/* Triangles in the order of their groups, those of one in the order of the file. */
static void sort_triangles(splitting *s, const ylm_mesh_groups *g) {
  size_t groups = g->names + 1;
  for (size_t t = 0; t < g->triangles; t++) s->first[g->group[t] + 1]++;
  for (size_t k = 1; k <= groups; k++) s->first[k] += s->first[k - 1];
  for (size_t t = g->triangles; t-- > 0;) s->order[--s->first[g->group[t] + 1]] = (uint32_t)t;
  /* each first[k + 1] has moved to the beginning of group k */
  for (size_t k = 0; k < groups; k++) s->first[k] = s->first[k + 1];
  s->first[groups] = g->triangles;
}

static void copy_vertices(const float *from, size_t n, const uint32_t *used, size_t width,
                          float *to) {
  for (size_t i = 0; to && i < n; i++)
    memcpy(to + width * i, from + width * used[i], width * sizeof *to);
}

/* The mesh of group k, NULL without triangles. */
static ylm_status extract(splitting *s, size_t k, ylm_mesh **out, ylm_error *e) {
  const ylm_mesh *m = s->mesh;
  size_t n = 0, triangles = s->first[k + 1] - s->first[k];
  const uint32_t *order = s->order + s->first[k];
  if (triangles == 0) return YLM_OK;
  for (size_t i = 0; i < 3 * triangles; i++) {
    uint32_t v = m->index[3 * order[i / 3] + i % 3];
    if (s->stamp[v] == k + 1) continue;
    s->stamp[v] = (uint32_t)k + 1;
    s->place[v] = (uint32_t)n;
    s->used[n++] = v;
  }
  ylm_status status = ylm_mesh_create(n, triangles, m->normal != NULL, m->uv != NULL, out, e);
  if (status != YLM_OK) return status;
  memcpy((*out)->origin, m->origin, sizeof m->origin);
  copy_vertices(m->position, n, s->used, 3, (*out)->position);
  copy_vertices(m->normal, n, s->used, 3, (*out)->normal);
  copy_vertices(m->uv, n, s->used, 2, (*out)->uv);
  if (m->colour && !((*out)->colour = ylm_alloc(n, 3 * sizeof(float)))) return ylm_no_memory(e);
  copy_vertices(m->colour, n, s->used, 3, (*out)->colour);
  for (size_t i = 0; i < 3 * triangles; i++)
    (*out)->index[i] = s->place[m->index[3 * order[i / 3] + i % 3]];
  return YLM_OK;
}

ylm_status ylm_mesh_split(const ylm_mesh *mesh, const ylm_mesh_groups *g, ylm_mesh **part,
                          ylm_error *e) {
  size_t groups = g->names + 1;
  splitting s = {.mesh = mesh,
                 .order = ylm_alloc(g->triangles, sizeof(uint32_t)),
                 .first = ylm_alloc_zero(groups + 1, sizeof(size_t)),
                 .stamp = ylm_alloc_zero(mesh->vertices, sizeof(uint32_t)),
                 .place = ylm_alloc(mesh->vertices, sizeof(uint32_t)),
                 .used = ylm_alloc(mesh->vertices, sizeof(uint32_t))};
  bool room = s.order && s.first && s.stamp && s.place && s.used;
  ylm_status status = room ? YLM_OK : ylm_no_memory(e);
  for (size_t k = 0; k < groups; k++) part[k] = NULL;
  if (room) sort_triangles(&s, g);
  for (size_t k = 0; status == YLM_OK && k < groups; k++) status = extract(&s, k, &part[k], e);
  for (size_t k = 0; status != YLM_OK && k < groups; k++) {
    ylm_mesh_free(part[k]);
    part[k] = NULL;
  }
  ylm_free(s.order);
  ylm_free(s.first);
  ylm_free(s.stamp);
  ylm_free(s.place);
  ylm_free(s.used);
  return status;
}
