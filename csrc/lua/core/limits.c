/* limits.c - core.limits: C's bounds of arguments, for the forms and messages of lua/ylm; and
   core.luminance. */
#include "../binding.h"

#include "ylm_emit.h"
#include "ylm_geom.h"
#include "ylm_grid.h"
#include "ylm_image.h"
#include "ylm_light.h"
#include "ylm_light_shadow.h"
#include "ylm_material_table.h"
#include "ylm_path.h"
#include "ylm_sh.h"
#include "ylm_shade.h"
#include "ylm_transfer.h"

/* name, value */
#define LIMITS(X)                                                                                  \
  X(axes, YLM_MAX_AXES)                                                                            \
  X(camera_samples, YLM_SHADE_SAMPLES)                                                             \
  X(emit_bounces, YLM_EMIT_BOUNCES)                                                                \
  X(emit_degree, YLM_EMIT_DEGREE)                                                                  \
  X(emit_particles, YLM_EMIT_PARTICLES)                                                            \
  X(extent, YLM_LIGHT_EXTENT)                                                                      \
  X(grid_cells, YLM_GRID_MAX_CELLS)                                                                \
  X(gather_least, YLM_GATHER_LEAST)                                                                \
  X(gather_most, YLM_GATHER_MOST)                                                                  \
  X(grid_depth, YLM_GRID_MAX_DEPTH)                                                                \
  X(grid_points, YLM_GRID_NONE - 1)                                                                \
  X(grid_side, YLM_GRID_MAX_SIDE)                                                                  \
  X(image_side, YLM_IMAGE_MAX_SIDE)                                                                \
  X(light_places, YLM_LIGHT_SAMPLES)                                                               \
  X(light_samples, YLM_SCENE_SAMPLES)                                                              \
  X(light_texels, YLM_LIGHT_TEXELS)                                                                \
  X(lmax, YLM_LIGHT_LMAX)                                                                          \
  X(material_degrees, YLM_MATERIAL_DEGREES)                                                        \
  X(material_table_lmax, YLM_MATERIAL_TABLE_LMAX)                                                  \
  X(material_table_rows, YLM_MATERIAL_TABLE_ROWS)                                                  \
  X(path_batch, YLM_PATH_BATCH)                                                                    \
  X(path_lmax, YLM_PATH_LMAX)                                                                      \
  X(path_samples, YLM_PATH_SAMPLES)                                                                \
  X(polygon_vertices, YLM_POLYGON_VERTICES)                                                        \
  X(seed, 4294967296.0) /* of options: C takes 64 bits, of which numbers of Lua hold 53 */         \
  X(sh_lmax, YLM_LMAX)                                                                             \
  X(sh_product_factors, YLM_SH_PRODUCT_FACTORS)                                                    \
  X(sh_product_lmax, YLM_SH_PRODUCT_LMAX)                                                          \
  X(sphere_set, YLM_SPHERE_SET)                                                                    \
  X(casters, YLM_CASTERS)                                                                          \
  X(sh_nodes_degree, YLM_SH_NODES_DEGREE)                                                          \
  X(sh_log_lmax, YLM_SH_LOG_LMAX)                                                                  \
  X(sh_exp_terms, YLM_SH_EXP_TERMS)                                                                \
  X(sh_rotate_each_lmax, YLM_SH_ROTATE_EACH_LMAX)                                                  \
  X(sh_rotate_lmax, YLM_SH_ROTATE_LMAX)                                                            \
  X(threads, YLM_THREADS_MOST)                                                                     \
  X(tolerance_least, YLM_LIGHT_TOLERANCE_LEAST)                                                    \
  X(tolerance_most, YLM_LIGHT_TOLERANCE_MOST)                                                      \
  X(transfer_bounces, YLM_TRANSFER_BOUNCES)                                                        \
  X(transfer_elements, YLM_TRANSFER_ELEMENTS)                                                      \
  X(transfer_elements_most, YLM_TRANSFER_ELEMENTS_MOST)                                            \
  X(transfer_links, YLM_TRANSFER_LINKS)                                                            \
  X(transfer_lmax, YLM_TRANSFER_LMAX)

void ylmL_open_limits(lua_State *L) {
  static const double luminance[3] = {YLM_LUMINANCE_R, YLM_LUMINANCE_G, YLM_LUMINANCE_B};
  lua_newtable(L);
#define X(name, value) ylmL_set_number(L, #name, value);
  LIMITS(X)
#undef X
  lua_setfield(L, -2, "limits");
  lua_newtable(L);
  for (int i = 0; i < 3; i++) {
    lua_pushnumber(L, luminance[i]);
    lua_rawseti(L, -2, i + 1);
  }
  lua_setfield(L, -2, "luminance");
}
