/* mpi.c - opens ylm.c.mpi: the team of the processes that mpirun or srun has started.
   lua/ylm/team/init.lua. */
#include <stdlib.h>

#include "../binding.h"
#include "ylm_mpi.h"

/* begin() -> team, its number of threads for each process; nil, message, code */
static int begin(lua_State *L) {
  ylm_error e = {0};
  int threads = 1;
  ylm_team **t = ylmL_team_new(L);
  ylm_status s = ylm_mpi_begin(t, &threads, &e);
  lua_pushinteger(L, threads);
  return ylmL_result(L, 2, s, &e);
}

/* is_alone() -> does this process go on alone? */
static int is_alone(lua_State *L) {
  lua_pushboolean(L, ylm_mpi_is_alone());
  return 1;
}

/* version() -> the library, in a line */
static int version(lua_State *L) {
  lua_pushstring(L, ylm_mpi_version());
  return 1;
}

/* set_threads(n): the environment's YLM_THREADS, where it says nothing */
static int set_threads(lua_State *L) {
  char text[16];
  snprintf(text, sizeof text, "%d", (int)luaL_checkinteger(L, 1));
  const char *now = getenv("YLM_THREADS");
  if (!now || !*now) setenv("YLM_THREADS", text, 1);
  return 0;
}

static const luaL_Reg functions[] = {{"begin", begin},
                                     {"is_alone", is_alone},
                                     {"version", version},
                                     {"set_threads", set_threads},
                                     {NULL, NULL}};

int luaopen_ylm_c_mpi(lua_State *L) {
  ylmL_check_abi(L);
  lua_newtable(L);
  luaL_setfuncs(L, functions, 0);
  return 1;
}
