/* scene.c - opens ylm.c.scene: the binding of libylm_scene.so. */
#include "../binding.h"

int luaopen_ylm_c_scene(lua_State *L) {
  ylmL_check_abi(L);
  lua_newtable(L);
#define X(name) ylmL_open_##name(L);
  YLML_SCENE_BINDINGS(X)
#undef X
  return 1;
}
