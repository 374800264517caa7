/* transfer.h - what the files that bind elements, links and radiosity share. Private to csrc/lua. */
#ifndef YLM_LUA_SCENE_TRANSFER_H
#define YLM_LUA_SCENE_TRANSFER_H

#include "traced.h"
#include "ylm_transfer_targets.h"

#define YLML_TRANSFER "ylm.links"
#define YLML_RADIOSITY "ylm.radiosity"

/* A C object that others of C point to: it is freed with the last hold of it. */
typedef struct ylmL_held ylmL_held;
struct ylmL_held {
  size_t holds;
  void *object;
  void (*destroy)(void *object);
  ylmL_held *of; /* what it points to itself, or NULL */
  void *extra;   /* another object that points to it, freed before it; or NULL */
  void (*destroy_extra)(void *extra);
  size_t running; /* calls that read it through another object */
};

/* A new userdata of a type, whose object is still to be made; `of` (NULL: nothing) is held. */
ylmL_held *ylmL_hold(lua_State *L, const char *type, void (*destroy)(void *), ylmL_held *of);
/* The object of a type at `i`, open; raises otherwise. */
ylmL_held *ylmL_held_check(lua_State *L, int i, const char *type);
/* __gc and close of such a userdata. */
int ylmL_let_go(lua_State *L);

ylm_transfer *ylmL_transfer(lua_State *L, int i);
ylm_radiosity *ylmL_radiosity(lua_State *L, int i);
/* ylmL_radiosity, for a field of a form: const ylm_radiosity *. */
void ylmL_read_radiosity(lua_State *L, int i, void *field);

/* The light field that a radiosity has by itself. gather.c */
ylmL_field_of ylmL_radiosity_default;
/* YLM_EBUSY where the radiosity at `i` is read by a call whose progress function is running. */
ylm_status ylmL_radiosity_busy(lua_State *L, int i);

#endif
