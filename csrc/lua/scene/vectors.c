/* vectors.c - transfer vectors with bounces and transfer matrices, of elements, of vertices, and of shading points. */
#include "shade.h"
#include "transfer.h"
#include "ylm_shade_bounce.h"

/* transfer_vectors(t, bounces (-1: all), residual, closure, threads, progress) -> float [n + 1][width] as C keeps them,
   {bounces, closed, residual, shrink, seconds} */
static int transfer_vectors(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  ylm_error e = {0};
  ylmL_progress p;
  ylm_radiosity_stats stats = {0};
  lua_settop(L, 6);
  const ylm_progress *show = ylmL_progress_begin(L, 6, &p);
  ylmL_array *a =
      ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){ylm_transfer_count(t) + 1, ylm_transfer_width(t)});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_transfer_vectors(t, (int)luaL_checknumber(L, 2),
                                      (double)luaL_checknumber(L, 3), lua_toboolean(L, 4),
                                      (int)luaL_optnumber(L, 5, 0), show, &stats, a->data, &e);
  lua_newtable(L);
  ylmL_set_count(L, "bounces", (uint64_t)stats.bounces);
  ylmL_set_boolean(L, "closed", stats.closed);
  ylmL_set_number(L, "residual", stats.residual);
  ylmL_set_number(L, "shrink", stats.shrink);
  ylmL_set_number(L, "seconds", stats.solve_seconds);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

/* The vectors of transfer_vectors at `i`, which are t's; NULL: nil. */
static const float *read_vectors(lua_State *L, int i, const ylm_transfer *t) {
  ylmL_array *a = ylmL_array_opt(L, i);
  if (!a) return NULL;
  if (a->dtype != YLM_FLOAT || a->count != (ylm_transfer_count(t) + 1) * ylm_transfer_width(t))
    luaL_argerror(L, i, "vectors of this transfer expected");
  return a->data;
}

static size_t count_of(const ylm_transfer *t) {
  size_t row = (size_t)ylm_transfer_made(t)->lmax + 1;
  return row * row;
}

/* transfer_vectors_rows(t, vectors) -> [n][3][(lmax+1)^2] */
static int transfer_vectors_rows(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  const float *vectors = read_vectors(L, 2, t);
  size_t n = ylm_transfer_count(t), count = count_of(t);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 3, (size_t[]){n, 3, count});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  for (size_t i = 0; i < n; i++)
    ylm_copy((float *)a->data + 3 * count * i, vectors + i * ylm_transfer_width(t),
             3 * count * sizeof(float));
  return 1;
}

/* transfer_vectors_of(t, vectors, mesh from 1) -> [vertices][3][(lmax+1)^2] */
static int transfer_vectors_of(lua_State *L) {
  const ylm_transfer *t = ylmL_transfer(L, 1);
  const float *vectors = read_vectors(L, 2, t);
  const ylm_scene *scene = ylm_transfer_scene(t);
  size_t mesh = (size_t)luaL_checknumber(L, 3) - 1;
  if (mesh >= ylm_scene_meshes(scene)) luaL_argerror(L, 3, "no such mesh");
  size_t n = ylm_scene_first_vertex(scene, mesh + 1) - ylm_scene_first_vertex(scene, mesh);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 3, (size_t[]){n, 3, count_of(t)});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  return ylmL_result(L, 1, ylm_transfer_vectors_of(t, vectors, mesh, a->data), NULL);
}

/* shade_vectors(view, t, vectors | nil, links, seed, threads, progress) -> [points][3][(lmax+1)^2] */
static int shade_vectors(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_transfer *t = ylmL_transfer(L, 2);
  const float *vectors = read_vectors(L, 3, t);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 7);
  const ylm_progress *show = ylmL_progress_begin(L, 7, &p);
  ylmL_array *a = ylmL_array_new(L, YLM_FLOAT, 3, (size_t[]){ylmL_shade_points(v), 3, count_of(t)});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_view_vectors(v, t, vectors, (int)luaL_checknumber(L, 4),
                                        (uint64_t)luaL_checknumber(L, 5),
                                        (int)luaL_optnumber(L, 6, 0), show, a->data, &e);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

typedef struct matrices_form {
  int rays, lmax_in, lmax_out, threads;
  uint64_t seed;
  int progress; /* on the stack */
} matrices_form;

static const ylmL_entry matrices_entries[] = {
    YLML(matrices_form, rays, "rays", INT),
    YLML(matrices_form, seed, "seed", UINT64),
    YLML(matrices_form, lmax_in, "lmax_in", INT, .least = 0, .most = YLM_LMAX),
    YLML(matrices_form, lmax_out, "lmax_out", INT, .least = 0, .most = YLM_LMAX),
    YLML(matrices_form, threads, "threads", INT, .optional = true),
    YLML(matrices_form, progress, "progress", VALUE),
    {.name = NULL}};

/* shade_matrices(view, t, vectors | nil, {rays, seed, lmax_in, lmax_out, threads, progress})
   -> [points][3][(lmax_out+1)^2][(lmax_in+1)^2] */
static int shade_matrices(lua_State *L) {
  matrices_form f = {.threads = 0};
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_transfer *t = ylmL_transfer(L, 2);
  ylm_error e = {0};
  ylmL_progress p;
  ylmL_read(L, 4, matrices_entries, &f);
  const float *vectors = read_vectors(L, 3, t);
  const ylm_progress *show = ylmL_progress_begin(L, f.progress, &p);
  size_t in = (size_t)f.lmax_in + 1, out = (size_t)f.lmax_out + 1;
  ylmL_array *a =
      ylmL_array_new(L, YLM_FLOAT, 4, (size_t[]){ylmL_shade_points(v), 3, out * out, in * in});
  if (!a) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  ylm_status s = ylm_shade_view_matrices(v, t, vectors, f.rays, f.seed, f.lmax_in, f.lmax_out,
                                         f.threads, show, a->data, &e);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_by_vectors(view, float [n][channels][(lmax+1)^2], lmax, object with a field, threads, progress)
   -> radiance [n][3], pairs */
static int shade_by_vectors(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylmL_array *T = ylmL_array_check(L, 2);
  int lmax = (int)luaL_checknumber(L, 3);
  const ylm_field *field = ylmL_field_check(L, 4);
  size_t n = ylmL_shade_points(v), row = ((size_t)lmax + 1) * ((size_t)lmax + 1);
  ylm_error e = {0};
  ylmL_progress p;
  uint64_t pairs = 0;
  lua_settop(L, 6);
  if (T->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (T->count != n * row && T->count != 3 * n * row) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, (size_t[]){n, 3});
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const ylm_progress *show = ylmL_progress_begin(L, 6, &p);
  ylm_status s = ylm_shade_by_vectors(v, lmax, T->count == n * row ? 1 : 3, T->data, field,
                                      (int)luaL_optnumber(L, 5, 0), show, out->data, &pairs, &e);
  if (s == YLM_OK) ylmL_push_count(L, pairs);
  return ylmL_result_progress(L, 2, s, &e, &p);
}

static const luaL_Reg functions[] = {{"transfer_vectors", transfer_vectors},
                                     {"transfer_vectors_rows", transfer_vectors_rows},
                                     {"transfer_vectors_of", transfer_vectors_of},
                                     {"shade_vectors", shade_vectors},
                                     {"shade_matrices", shade_matrices},
                                     {"shade_by_vectors", shade_by_vectors},
                                     {NULL, NULL}};

void ylmL_open_vectors(lua_State *L) { luaL_setfuncs(L, functions, 0); }
