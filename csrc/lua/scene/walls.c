/* walls.c - the surfaces of a scene, as bakes and look-ups of grids with sides ask for them. */
#include "transfer.h"

#define YLML_WALLS "ylm.walls"

static void destroy(void *w) { ylm_walls_free(w); }

/* scene_walls(traced scene) -> walls, the bytes of their ylm_grid_walls, which hold as long as walls and scene live */
static int scene_walls(lua_State *L) {
  const ylm_scene *scene = ylmL_scene(L, 1);
  ylmL_held *h = ylmL_hold(L, YLML_WALLS, destroy, NULL);
  ylm_walls *w;
  ylm_status s = ylm_walls_create(scene, NULL, &w);
  if (s != YLM_OK) return ylmL_result(L, 0, s, NULL);
  h->object = w;
  ylm_grid_walls look = ylm_walls_look(w);
  lua_pushlstring(L, (const char *)&look, sizeof look);
  return 2;
}

static const luaL_Reg functions[] = {{"scene_walls", scene_walls}, {NULL, NULL}};

static const luaL_Reg methods[] = {{"__gc", ylmL_let_go}, {NULL, NULL}};

void ylmL_open_walls(lua_State *L) {
  ylmL_type(L, YLML_WALLS, methods);
  lua_pop(L, 1);
  luaL_setfuncs(L, functions, 0);
}
