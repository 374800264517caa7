/* binding_product.h - methods of products by name, shared by core/sh_product.c and scene/shade_relight.c. */
#ifndef YLM_LUA_PRODUCT_H
#define YLM_LUA_PRODUCT_H

#include <string.h>

#include "binding.h"
#include "ylm_sh.h"

/* The method whose name is argument i, "auto" where there is none; raises. */
static inline ylm_sh_product_method ylmL_product_method(lua_State *L, int i) {
  const char *name = luaL_optstring(L, i, "auto");
  for (int m = 0; m < YLM_SH_PRODUCT_METHOD_COUNT; m++)
    if (strcmp(name, ylm_sh_product_method_name((ylm_sh_product_method)m)) == 0)
      return (ylm_sh_product_method)m;
  return (ylm_sh_product_method)luaL_argerror(L, i, "no such method");
}

#endif
