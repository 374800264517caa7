/* rival.c - opens ylm.c.rival, which registers libylm_rival.so. For lua/ylm/library.lua. */
#include "ylm_rival.h"

#include "../binding.h"

int luaopen_ylm_c_rival(lua_State *L) {
  ylmL_check_abi(L);
  ylm_rival_register();
  lua_newtable(L);
  return 1;
}
