/* binding_team.c - teams of processes as Lua objects, in every binding. */
#include "binding.h"

static int team_gc(lua_State *L) {
  ylm_team **t = lua_touserdata(L, 1);
  if (t) {
    ylm_team_free(*t);
    *t = NULL;
  }
  return 0;
}

static const luaL_Reg methods[] = {{"__gc", team_gc}, {NULL, NULL}};

ylm_team **ylmL_team_new(lua_State *L) {
  ylm_team **t = lua_newuserdata(L, sizeof *t);
  *t = NULL;
  ylmL_type(L, YLM_TEAM, methods);
  lua_setmetatable(L, -2);
  return t;
}

ylm_team *ylmL_team_opt(lua_State *L, int i) {
  if (lua_isnoneornil(L, i)) return NULL;
  ylm_team **t = ylmL_check(L, i, YLM_TEAM);
  if (!*t) luaL_argerror(L, i, "the team has ended");
  return *t;
}
