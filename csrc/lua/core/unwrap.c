/* unwrap.c - texture coordinates for meshes: charts, flattened and packed. */
#include "ylm_geom_unwrap.h"

#include "../binding.h"

typedef struct unwrap_form {
  ylm_unwrap_form f;
  int gutter;
  size_t texels;
  double density; /* 0: as many texels as `texels` */
  int progress;   /* on the stack */
} unwrap_form;

static const ylmL_entry entries[] = {
    YLML(unwrap_form, f.angle, "angle", DOUBLE),
    YLML(unwrap_form, f.stretch, "stretch", DOUBLE),
    YLML(unwrap_form, gutter, "gutter", INT),
    YLML(unwrap_form, texels, "texels", COUNT, .optional = true),
    YLML(unwrap_form, density, "density", DOUBLE, .optional = true),
    YLML(unwrap_form, f.threads, "threads", INT, .optional = true),
    YLML(unwrap_form, progress, "progress", VALUE),
    {.name = NULL}};

static void push_stats(lua_State *L, const ylm_unwrap_stats *s) {
  lua_newtable(L);
  ylmL_set_count(L, "triangles", s->triangles);
  ylmL_set_count(L, "charts", s->charts);
  ylmL_set_count(L, "curved", s->curved);
  ylmL_set_count(L, "degenerate", s->degenerate);
  ylmL_set_count(L, "crowded", s->crowded);
  ylmL_set_number(L, "stretch", s->stretch);
  ylmL_set_number(L, "worst", s->worst);
  ylmL_set_count(L, "width", s->width);
  ylmL_set_count(L, "height", s->height);
  ylmL_set_number(L, "density", s->density);
  ylmL_set_number(L, "share", s->share);
}

/* Charts of a mesh, packed. */
static ylm_status make(const ylm_mesh *m, const unwrap_form *f, ylm_unwrap **u, ylm_error *e) {
  ylm_unwrap_mesh mesh = {m->vertices, m->triangles, m->position, m->index};
  ylm_status s = ylm_unwrap_create(1, &mesh, &f->f, u, e);
  ylm_unwrap_stats stats;
  if (s != YLM_OK) return s;
  ylm_unwrap_look(*u, &stats);
  double *density = ylm_alloc(stats.charts, sizeof *density);
  if (!density) return ylm_no_memory(e);
  for (size_t i = 0; i < stats.charts; i++) density[i] = f->density > 0 ? f->density : 1;
  if (f->density > 0)
    s = ylm_unwrap_pack(*u, density, f->gutter, e);
  else
    s = ylm_unwrap_fit(*u, density, f->gutter, f->texels, NULL, e);
  ylm_free(density);
  return s;
}

/* Pushes the mesh, its coordinates, which vertices they were, from 1, and the charts of triangles, from 1; 0: none. */
static ylm_status push_split(lua_State *L, const ylm_mesh *m, const ylm_unwrap *u, ylm_error *e) {
  size_t n = 0;
  uint32_t *from = NULL, *index = NULL;
  float *uv = NULL;
  ylm_mesh **out = ylmL_mesh_new(L);
  ylm_status s = ylm_unwrap_split(u, 0, &n, &from, &uv, &index, e);
  if (s != YLM_OK) return s;
  s = ylm_mesh_pick(m, n, from, index, false, out, e);
  ylmL_array *uvs = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 2});
  ylmL_array *old = uvs ? ylmL_array_new(L, YLM_INT32, 1, &n) : NULL;
  ylmL_array *charts = old ? ylmL_array_new(L, YLM_INT32, 1, &m->triangles) : NULL;
  if (charts) {
    memcpy(uvs->data, uv, 2 * n * sizeof *uv);
    for (size_t i = 0; i < n; i++) ((int32_t *)old->data)[i] = (int32_t)from[i] + 1;
    for (size_t i = 0; i < m->triangles; i++)
      ((int32_t *)charts->data)[i] = (int32_t)(ylm_unwrap_chart(u, 0, i) + 1);
  }
  ylm_free(from);
  ylm_free(uv);
  ylm_free(index);
  return s == YLM_OK && !charts ? ylm_no_memory(e) : s;
}

/* mesh_unwrap(mesh, {angle, stretch, gutter, texels or density, threads, progress}) -> mesh, uvs float [n][2],
   vertices int32 [n] from 1, charts int32 [triangles] from 1 (0: none), stats */
static int mesh_unwrap(lua_State *L) {
  unwrap_form f = {.progress = 0};
  const ylm_mesh *m = ylmL_mesh_check(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_unwrap *u = NULL;
  ylmL_read(L, 2, entries, &f);
  f.f.progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s = make(m, &f, &u, &e);
  if (s == YLM_OK) s = push_split(L, m, u, &e);
  if (s == YLM_OK) {
    ylm_unwrap_stats stats;
    ylm_unwrap_look(u, &stats);
    push_stats(L, &stats);
  }
  ylm_unwrap_free(u);
  return ylmL_result_progress(L, 5, s, &e, &p);
}

static const luaL_Reg functions[] = {{"mesh_unwrap", mesh_unwrap}, {NULL, NULL}};

void ylmL_open_unwrap(lua_State *L) { luaL_setfuncs(L, functions, 0); }
