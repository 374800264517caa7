/*
** binding.h - what the files of the Lua binding share. Private to csrc/lua.
**
** One C source serves Lua 5.1 to 5.5 and LuaJIT. Functions here take already
** sorted arguments from lua/ylm; they never see option tables. On failure they
** return nil, message, code through ylmL_result; lua/ylm/check.lua raises
** what is the caller's fault and hands back what is the world's.
**
** Each file `core/NAME.c` (or scene/, vtk/, vulkan/) defines
**     void ylmL_open_NAME(lua_State *L)      adds functions to the table on top
** and stands in the list below. Object types are userdata whose
** metatables live in the registry by name, so that every binding sees them.
*/
#ifndef YLM_LUA_BINDING_H
#define YLM_LUA_BINDING_H

#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>
#include <stddef.h>

#include "binding_choices.h"
#include "ylm_numbers.h"

/* -- what is bound ----------------------------------------------------------- */

/* Each X(name) is a file core/NAME.c (scene/NAME.c, ...) with ylmL_open_NAME. */
#define YLML_CORE_BINDINGS(X)                                                                      \
  X(array)                                                                                         \
  X(figure)                                                                                        \
  X(figure_canvas)                                                                                 \
  X(figure_numbers)                                                                                \
  X(figure_page)                                                                                   \
  X(figure_volume)                                                                                 \
  X(array_file)                                                                                    \
  X(array_math)                                                                                    \
  X(array_slice)                                                                                   \
  X(grid)                                                                                          \
  X(grid_bake)                                                                                     \
  X(grid_engine)                                                                                   \
  X(grid_file)                                                                                     \
  X(grid_set)                                                                                      \
  X(grid_probes)                                                                                   \
  X(grid_look)                                                                                     \
  X(light)                                                                                         \
  X(light_shadow)                                                                                  \
  X(light_sky)                                                                                     \
  X(light_texture)                                                                                 \
  X(light_tree)                                                                                    \
  X(light_virtual)                                                                                 \
  X(light_photometry)                                                                              \
  X(limits)                                                                                        \
  X(own)                                                                                           \
  X(process)                                                                                       \
  X(sandbox)                                                                                       \
  X(sh)                                                                                            \
  X(sh_rotate)                                                                                     \
  X(sh_product)                                                                                    \
  X(sh_project)                                                                                    \
  X(team)                                                                                          \
  X(image)                                                                                         \
  X(image_ops)                                                                                     \
  X(material)                                                                                      \
  X(material_file)                                                                                 \
  X(material_table)                                                                                \
  X(mesh)                                                                                          \
  X(unwrap)                                                                                        \
  X(texture)

#define YLML_SCENE_BINDINGS(X)                                                                     \
  X(adjoint)                                                                                       \
  X(chooser)                                                                                       \
  X(emit)                                                                                          \
  X(gather)                                                                                        \
  X(occlusion)                                                                                     \
  X(path)                                                                                          \
  X(radiosity)                                                                                     \
  X(shade)                                                                                         \
  X(shade_entries)                                                                                 \
  X(shade_grid)                                                                                    \
  X(shade_links)                                                                                   \
  X(shade_judge)                                                                                   \
  X(shade_picture)                                                                                 \
  X(shade_relight)                                                                                 \
  X(shade_rounds)                                                                                  \
  X(shade_view)                                                                                    \
  X(shade_virtual)                                                                                 \
  X(surface)                                                                                       \
  X(surface_map)                                                                                   \
  X(traced)                                                                                        \
  X(transfer)                                                                                      \
  X(vectors)                                                                                       \
  X(walls)

#define X(name) void ylmL_open_##name(lua_State *L);
YLML_CORE_BINDINGS(X)
YLML_SCENE_BINDINGS(X)
#undef X

/* The entry points of the shared objects. */
YLM_API int luaopen_ylm_c_core(lua_State *L);
YLM_API int luaopen_ylm_c_mpi(lua_State *L);
YLM_API int luaopen_ylm_c_codec(lua_State *L);
YLM_API int luaopen_ylm_c_rival(lua_State *L);
YLM_API int luaopen_ylm_c_scene(lua_State *L);
YLM_API int luaopen_ylm_c_vtk(lua_State *L);
YLM_API int luaopen_ylm_c_vulkan(lua_State *L);

/* -- Lua 5.1 with the names of later versions ------------------------------ */

#if LUA_VERSION_NUM < 502
#define lua_rawlen lua_objlen
#define luaL_setfuncs(L, l, n) luaL_register(L, NULL, l)
#endif

/* True (and left on the stack) if value `i` is an integral number that fits. */
bool ylmL_toint64(lua_State *L, int i, int64_t *out);

/* Opens a binding: refuses an interpreter of another ABI instead of crashing. */
void ylmL_check_abi(lua_State *L);

/* -- results --------------------------------------------------------------- */

/* YLM_OK: returns `n` (results already pushed). YLM_ENOMEM: ylmL_no_memory. Else pushes nil,
   message, code; returns 3. Comes last in a function: memory of C without an owner has been freed
   before. */
int ylmL_result(lua_State *L, int n, ylm_status s, const ylm_error *e);

/* Raises an error that says that memory ran out, as Lua does where its own runs out; `text`: a
   sentence, or NULL. Public functions turn both into nil, message, code (lua/ylm/memory.lua). */
#define YLM_NO_MEMORY "ylm.no_memory"
int ylmL_no_memory(lua_State *L, const char *text);

/* A number of things: an integer where Lua has integers, so that it reads 5 and not 5.0. */
void ylmL_push_count(lua_State *L, uint64_t n);
/* Named entries of the table on top of the stack. */
void ylmL_set_count(lua_State *L, const char *name, uint64_t n);
void ylmL_set_number(lua_State *L, const char *name, double x);
void ylmL_set_boolean(lua_State *L, const char *name, bool x);

/* -- named arguments: csrc/lua/binding_read.c, compiled into every binding ---- */

/* The kinds of values, and the C types that they become. */
typedef enum ylmL_kind {
  YLML_INT,
  YLML_COUNT, /* size_t */
  YLML_UINT64,
  YLML_DOUBLE,
  YLML_BOOL,                 /* nil leaves the field as it is */
  YLML_CHOICE,               /* an enum: the place of the word in `choices` */
  YLML_EITHER,               /* bool: is it the second of two `choices`? */
  YLML_STRING,               /* const char *, of the table's */
  YLML_NUMBERS,              /* double[n], from a list of as many */
  YLML_OBJECTS,              /* these and what follows stay on the stack, behind the table: */
  YLML_ARRAY = YLML_OBJECTS, /* ylmL_array *, open, of float or double */
  YLML_FIELD,                /* const ylm_field * */
  YLML_READ,                 /* what `read` makes of it */
  YLML_VALUE, /* int: its index on the stack; any value, also nil, for the caller to look at */
  YLML_KINDS
} ylmL_kind;

/* An entry of a table of Lua, and the field of a struct that its value goes into. */
typedef struct ylmL_entry {
  const char *name; /* NULL ends a list of entries */
  ylmL_kind kind;
  size_t at, size;            /* of the field */
  bool optional;              /* nil leaves the field as it is; of others nil raises */
  double least, most;         /* of numbers; unless least < most, all that the field can hold */
  const char *const *choices; /* NULL ends them */
  /* The value is at i, maybe nil; raises where it is another. */
  void (*read)(lua_State *L, int i, void *field);
} ylmL_entry;

/* The entry `text` for a field of a struct `type`; what else it has follows, as .optional = true. */
#define YLML(type, field, text, what, ...)                                                         \
  {                                                                                                \
    .name = text, .kind = YLML_##what, .at = offsetof(type, field),                                \
    .size = sizeof(((type *)NULL)->field), __VA_ARGS__                                             \
  }

/* Named arguments: reads the table at absolute index `i` into the struct at `out`. Values that stood above are dropped; those
   of YLML_OBJECTS stay there. Raises where an entry has no such name, is missing, of another type, out of its range or none of
   its choices. A function with more than seven arguments takes them so. */
void ylmL_read(lua_State *L, int i, const ylmL_entry *entries, void *out);

/* -- object types ---------------------------------------------------------- */

/* Registers (once per state) the metatable `name` with methods; leaves it on the stack.
   __index is the metatable itself, __name its name; Lua files add methods by
   require "ylm.c.core".metatable(name). Where binding.c lists a type's file, an object's first use
   loads it, so that objects have their methods wherever they were made. */
void ylmL_type(lua_State *L, const char *name, const luaL_Reg *methods);
/* The userdata at `i` if it is of type `name`, else NULL. */
void *ylmL_test(lua_State *L, int i, const char *name);
/* The userdata at `i` if it is of type `name`; raises a type error otherwise. */
void *ylmL_check(lua_State *L, int i, const char *name);
/* -- own tables: csrc/lua/binding_own.c, compiled into every binding ---------- */

/* Pushes the own table of the value at absolute index `i`: fields that Lua keeps of it. A new one where there is none. */
void ylmL_own(lua_State *L, int i);
/* ylmL_own where there is one; else nothing is pushed, and false. */
bool ylmL_owned(lua_State *L, int i);
/* Drops the own table of the object at absolute index `i`: what closes an object says so. */
void ylmL_disown(lua_State *L, int i);
/* Pushes the table of the registry by that name whose keys are weak, a new one where there is none. */
void ylmL_weak(lua_State *L, const char *name);

/* Tells the collector of `bytes` of C memory: runs a step in proportion. */
void ylmL_charge(lua_State *L, size_t bytes);

/* -- arrays: csrc/lua/binding_array.c, compiled into every binding ----------- */

#define YLM_ARRAY "ylm.array"

/* Dense, row-major. A view shares its parent's block of elements. */
typedef struct ylmL_array {
  void *data; /* NULL once closed */
  ylm_dtype dtype;
  int axes;
  size_t shape[YLM_MAX_AXES];
  size_t count;        /* product of the shape */
  uint32_t convention; /* of SH coefficients; 0 is ylm's own (ylm_sh.h lists others) */
  bool keeps;          /* a value of Lua in its own table keeps the elements alive */
  struct ylmL_block *block;
} ylmL_array;

/* Element i, counted from 0 through all axes, of an array of float or double. */
static inline double ylmL_array_get(const ylmL_array *a, size_t i) {
  return ylm_get(a->dtype, a->data, i);
}

/* True if two open arrays have an element's memory in common. */
static inline bool ylmL_array_overlaps(const ylmL_array *a, const ylmL_array *b) {
  uintptr_t pa = (uintptr_t)a->data, pb = (uintptr_t)b->data;
  return pa < pb + b->count * ylm_numbers_size(b->dtype) &&
         pb < pa + a->count * ylm_numbers_size(a->dtype);
}

/* A new array of zeros, on the stack; NULL (nothing pushed) if the size overflows or memory
   runs out. */
ylmL_array *ylmL_array_new(lua_State *L, ylm_dtype t, int axes, const size_t *shape);
/* ylmL_array_new whose numbers are not set: the caller writes all of them. */
ylmL_array *ylmL_array_unset(lua_State *L, ylm_dtype t, int axes, const size_t *shape);
/* The array at `given` to be written to, or a new one where nil stands there; pushed. Where it does
   not fit or cannot be made: YLM_ETYPE, YLM_ESHAPE, YLM_EOVERFLOW or YLM_ENOMEM in *s, which is
   else left alone, and NULL. */
ylmL_array *ylmL_array_result(lua_State *L, int given, ylm_dtype t, int axes, const size_t *shape,
                              ylm_status *s);
/* An array over elements of another owner: give_back(owner) is called once the array and
   its views are gone; never where NULL is returned (nothing pushed). */
ylmL_array *ylmL_array_share(lua_State *L, ylm_dtype t, int axes, const size_t *shape, void *data,
                             void (*give_back)(void *owner), void *owner);
/* A view of the array at absolute index `at` with the given shape, from flat element k on. */
ylmL_array *ylmL_array_part(lua_State *L, int at, size_t k, int axes, const size_t *shape);
/* Lets go of the elements. */
void ylmL_array_close(ylmL_array *a);
/* The array at `i`, open; raises otherwise. */
ylmL_array *ylmL_array_any(lua_State *L, int i);
/* ylmL_array_any, of float or double; raises at the caller's line where it holds another type. */
ylmL_array *ylmL_array_check(lua_State *L, int i);
/* Names the value at absolute index `i` as the owner of the elements of the array on top of the
   stack: it lives as long as the array and its views. */
void ylmL_array_keep(lua_State *L, int i);
/* The open array at `i`, or NULL where `i` is nil or none; raises otherwise. */
ylmL_array *ylmL_array_opt(lua_State *L, int i);

/* -- images, meshes, materials: csrc/lua/binding_objects.c, compiled into every binding -- */

#define YLM_IMAGE "ylm.image"
#define YLM_MESH "ylm.mesh"
#define YLM_MATERIAL "ylm.material"
#define YLM_TEXTURE "ylm.texture"

/* An object without an image yet, on the stack: the caller fills the address returned, which the
   object then owns. ylmL_no_memory where memory runs out, so call it before making the image. */
struct ylm_image **ylmL_image_new(lua_State *L);
/* The image at `i`; raises if there is none or it has been closed. */
struct ylm_image *ylmL_image_check(lua_State *L, int i);
/* ylmL_image_new and ylmL_image_check for meshes, materials and textures. */
struct ylm_mesh **ylmL_mesh_new(lua_State *L);
struct ylm_mesh *ylmL_mesh_check(lua_State *L, int i);
/* Positions [vertices][3] of a mesh in the world, in float. Leaves a value on the stack, which keeps them alive. */
const float *ylmL_mesh_floats(lua_State *L, const struct ylm_mesh *m);
struct ylm_material **ylmL_material_new(lua_State *L);
struct ylm_material *ylmL_material_check(lua_State *L, int i);
struct ylm_texture **ylmL_texture_new(lua_State *L);
struct ylm_texture *ylmL_texture_check(lua_State *L, int i);
/* Lets go of the image or mesh at 1. */
int ylmL_object_close(lua_State *L);
/* An array over memory of the image or mesh at `i`, which it keeps alive; ylmL_no_memory where
 * there is none. */
ylmL_array *ylmL_object_array(lua_State *L, int i, ylm_dtype t, int axes, const size_t *shape,
                              void *data);

/* -- light fields ----------------------------------------------------------- */

/* Object types that have a light field (lights, grids) put the address of such a function into
   their metatable with ylmL_type_has_field; the metatable must be on top of the stack. */
typedef const ylm_field *ylmL_field_of(void *object);
void ylmL_type_has_field(lua_State *L, ylmL_field_of *get);
/* The field of the object at `i`; raises if it has none. The field lives as long as the object. */
const ylm_field *ylmL_field_check(lua_State *L, int i);

/* A body's visibility, "ylm.occluder": what each kind does. */
#define YLML_OCCLUDER "ylm.occluder"
typedef struct ylmL_occluder_kind {
  const ylm_field *(*field)(const void *of);
  void (*body)(const void *of, double at[3], double *radius, double *area);
  ylm_status (*places)(const void *of, double near, double far, size_t n, float *places,
                       ylm_error *e);
  void (*free)(void *of);
} ylmL_occluder_kind;
typedef struct ylmL_occluder {
  void *of; /* NULL once closed */
  const ylmL_occluder_kind *kind;
} ylmL_occluder;
/* Pushes one that is closed until `of` is set. */
ylmL_occluder *ylmL_occluder_push(lua_State *L, const ylmL_occluder_kind *kind);
/* The function that finds its field; NULL: it has none. */
ylmL_field_of *ylmL_field_getter(lua_State *L, int i);

#define YLM_LIGHTS "ylm.lights"

/* The cut of a set of lights at `i`, or NULL. core/light_tree.c */
const struct ylm_light_cut *ylmL_light_cut(lua_State *L, int i);
/* New lights on the stack, whose set is to be made there. core/light.c */
struct ylm_light_set **ylmL_lights_new(lua_State *L);
/* The set of lights at `i`; raises if there is none or it has been closed. binding_objects.c */
struct ylm_light_set *ylmL_lights_check(lua_State *L, int i);
/* The surfaces that rays see of the set of lights at `i`, images in at most `tiles` tiles a side; it lives in an
   object left on the stack. NULL without memory. binding_objects.c */
struct ylm_light_surfaces *ylmL_light_surfaces(lua_State *L, int i, size_t tiles);
/* The texture in arguments 1 to 5: texels float [h][w][3], {corner, u, v: 9 numbers}, scale,
   tolerance, largest. core/light_texture.c */
struct ylm_light_texture ylmL_light_texture(lua_State *L);

/* -- teams: csrc/lua/binding_team.c ------------------------------------------ */

#define YLM_TEAM "ylm.team"

/* An object without a team yet, on the stack: the caller fills the address returned, which the
   object then owns. */
ylm_team **ylmL_team_new(lua_State *L);
/* The team at `i`; raises otherwise. NULL where `i` is nil or none. */
ylm_team *ylmL_team_opt(lua_State *L, int i);

/* -- progress -------------------------------------------------------------- */

typedef struct ylmL_progress {
  ylm_progress base;
  lua_State *L;
  int index;   /* stack index of the Lua function; 0: there is none */
  int top;     /* stack slots below are the call's arguments */
  int message; /* where the message lies that the function raised */
  bool raised; /* the function raised */
} ylmL_progress;

/* Prepares `p` for the function at absolute stack index `i`, where nil may stand.
   The function is called as f(done, total, stage); returning false cancels, and so does an
   error, which ylmL_result_progress raises again once C has cleaned up. With or without a function
   the debug hook is asked first: the interpreter's answer to SIGINT is a hook that raises. */
const ylm_progress *ylmL_progress_begin(lua_State *L, int i, ylmL_progress *p);
/* YLM_EBUSY where the object at `i` is an argument of a call whose progress function is running:
   what closes or changes an object asks first, since C holds pointers into it. */
ylm_status ylmL_busy(lua_State *L, int i);
/* Notes that the object on top of the stack is part of another one, which keeps it: ylmL_busy then
   says YLM_EBUSY of it while any progress function runs. */
void ylmL_note_part(lua_State *L);
/* ylmL_busy of an array that is to be written to: YLM_EBUSY where an argument of the running call
   is an array that shares elements with it. */
ylm_status ylmL_array_busy(lua_State *L, const ylmL_array *a);
/* ylmL_result, after raising an error that the progress function raised. */
int ylmL_result_progress(lua_State *L, int n, ylm_status s, const ylm_error *e, ylmL_progress *p);

#endif
