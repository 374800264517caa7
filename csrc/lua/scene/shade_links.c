/* shade_links.c - views with links: light that surfaces send to their points. */
#include "shade.h"
#include "transfer.h"
#include "ylm_shade_bounce.h"
#include "ylm_shade_gloss.h"

#define LINKS "ylm.shade_links"

static void destroy(void *links) { ylm_shade_links_free(links); }

static const ylm_shade_links *check_links(lua_State *L, int i) {
  return ylmL_held_check(L, i, LINKS)->object;
}

/* shade_links(view, transfer, links, seed, threads, progress, which: "matte" | "both" | "gloss") -> links, which the
   view must outlive */
static int shade_links(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_transfer *t = ylmL_transfer(L, 2);
  int links = (int)luaL_checknumber(L, 3), threads = (int)luaL_checknumber(L, 5);
  uint64_t seed = (uint64_t)luaL_checknumber(L, 4);
  ylm_error e = {0};
  ylmL_progress p;
  lua_settop(L, 7);
  static const char *const names[] = {"matte", "both", "gloss", NULL};
  ylm_shade_linked which = (ylm_shade_linked)luaL_checkoption(L, 7, NULL, names);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylmL_held *h = ylmL_hold(L, LINKS, destroy, ylmL_held_check(L, 2, YLML_TRANSFER));
  ylm_shade_links *l;
  ylm_status s = ylm_shade_links_create(v, t, links, which, seed, threads, progress, &l, &e);
  h->object = l;
  ylm_shade_links_stats stats = {0};
  if (s == YLM_OK) ylm_shade_links_look(l, &stats);
  ylmL_charge(L, stats.bytes);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_links_stats(links) -> { links, glossy: those of materials' rays, rays, bytes, seconds } */
static int shade_links_stats(lua_State *L) {
  ylm_shade_links_stats s;
  ylm_shade_links_look(check_links(L, 1), &s);
  lua_newtable(L);
  ylmL_set_count(L, "links", (uint64_t)s.links);
  ylmL_set_count(L, "glossy", s.glossy);
  ylmL_set_count(L, "rays", s.rays);
  ylmL_set_count(L, "bytes", s.bytes);
  ylmL_set_number(L, "seconds", s.seconds);
  return 1;
}

/* shade_gather(view, links, lit, radiance [n][3] or nil, threads, progress) -> radiance [n][3], a new array
   with gathered light added */
static int shade_gather(lua_State *L) {
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  const ylm_shade_links *l = check_links(L, 2);
  const ylm_radiosity *lit = ylmL_radiosity(L, 3);
  const ylmL_array *start = ylmL_array_opt(L, 4);
  int threads = (int)luaL_checknumber(L, 5);
  ylm_error e = {0};
  ylmL_progress p;
  size_t shape[] = {ylmL_shade_points(v), 3};
  lua_settop(L, 6);
  if (start && (start->dtype != YLM_FLOAT || start->count != 3 * shape[0]))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (ylm_radiosity_transfer(lit) != ylm_shade_links_transfer(l)) {
    ylm_fail(&e, YLM_EINVAL, "the view has links to elements of others");
    return ylmL_result(L, 0, YLM_EINVAL, &e);
  }
  ylmL_array *out = ylmL_array_new(L, YLM_FLOAT, 2, shape);
  if (!out) return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  const ylm_progress *progress = ylmL_progress_begin(L, 6, &p);
  ylm_status s = ylm_shade_gather(l, ylm_radiosity_leaving(lit), start ? start->data : NULL,
                                  threads, progress, out->data);
  return ylmL_result_progress(L, 1, s, &e, &p);
}

/* shade_gather_noise(links, lit) -> number */
static int shade_gather_noise(lua_State *L) {
  const ylm_shade_links *l = check_links(L, 1);
  const ylm_radiosity *lit = ylmL_radiosity(L, 2);
  if (ylm_radiosity_transfer(lit) != ylm_shade_links_transfer(l))
    return ylmL_result(L, 0, YLM_EINVAL, NULL);
  lua_pushnumber(L, (lua_Number)ylm_shade_gather_noise(l, ylm_radiosity_leaving(lit)));
  return 1;
}

/* shade_add(a, b, factor or nil: 1): a += factor b; float arrays of one size -> a */
static int shade_add(lua_State *L) {
  ylmL_array *a = ylmL_array_check(L, 1), *b = ylmL_array_check(L, 2);
  float factor = (float)luaL_optnumber(L, 3, 1);
  if (a->dtype != YLM_FLOAT || b->dtype != YLM_FLOAT) return ylmL_result(L, 0, YLM_ETYPE, NULL);
  if (a->count != b->count) return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  for (size_t i = 0; i < a->count; i++)
    ((float *)a->data)[i] += factor * ((const float *)b->data)[i];
  lua_pushvalue(L, 1);
  return 1;
}

typedef struct blend_form {
  const ylm_shade_links *links;
  const ylm_radiosity *lit;
  int lmax, threads;
  ylmL_array *share;
  int progress; /* on the stack */
} blend_form;

static void read_links(lua_State *L, int i, void *field) {
  *(const ylm_shade_links **)field = check_links(L, i);
}

static const ylmL_entry blend_entries[] = {
    YLML(blend_form, links, "links", READ, .read = read_links),
    YLML(blend_form, lit, "lit", READ, .read = ylmL_read_radiosity),
    YLML(blend_form, lmax, "lmax", INT),
    YLML(blend_form, threads, "threads", INT),
    YLML(blend_form, progress, "progress", VALUE),
    YLML(blend_form, share, "share", ARRAY,
         .optional = true), /* last: the result, where it is given */
    {.name = NULL}};

/* shade_blend_links(view, radiance [n][3], {links, lit, lmax, share: [n], or nil: it is found, threads, progress}) ->
   share [n], {sh, rays, missed, seconds}; writes radiance */
static int shade_blend_links(lua_State *L) {
  blend_form f = {.share = NULL};
  ylmL_read(L, 3, blend_entries, &f);
  ylm_shade_view *v = ylmL_shade_view(L, 1);
  ylmL_array *radiance = ylmL_array_check(L, 2), *share = f.share;
  bool known = share != NULL;
  size_t n = ylmL_shade_points(v);
  ylm_shade_blended r;
  ylm_error e = {0};
  ylmL_progress p;
  if (radiance->dtype != YLM_FLOAT || radiance->count != 3 * n ||
      (known && (share->dtype != YLM_FLOAT || share->count != n)))
    return ylmL_result(L, 0, YLM_ESHAPE, NULL);
  if (ylm_radiosity_transfer(f.lit) != ylm_shade_links_transfer(f.links))
    return ylmL_result(L, 0, YLM_EINVAL, NULL);
  if (!known && !(share = ylmL_array_new(L, YLM_FLOAT, 1, &n)))
    return ylmL_result(L, 0, YLM_ENOMEM, NULL);
  int result = lua_gettop(L);
  const ylm_progress *progress = ylmL_progress_begin(L, f.progress, &p);
  ylm_status s = ylm_shade_blend_links(f.links, ylm_radiosity_leaving(f.lit), f.lmax, known,
                                       f.threads, progress, radiance->data, share->data, &r, &e);
  lua_pushvalue(L, result);
  if (s == YLM_OK) {
    lua_newtable(L);
    ylmL_set_count(L, "sh", r.sh);
    ylmL_set_count(L, "rays", r.rays);
    ylmL_set_number(L, "missed", r.missed);
    ylmL_set_number(L, "seconds", r.seconds);
  }
  return ylmL_result_progress(L, 2, s, &e, &p);
}

static const luaL_Reg functions[] = {{"shade_links", shade_links},
                                     {"shade_links_stats", shade_links_stats},
                                     {"shade_gather", shade_gather},
                                     {"shade_gather_noise", shade_gather_noise},
                                     {"shade_add", shade_add},
                                     {"shade_blend_links", shade_blend_links},
                                     {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_shade_links(lua_State *L) {
  ylmL_type(L, LINKS, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
