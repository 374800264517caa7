/*
** ylm_material_rival.h - ways to look materials up that exist to be compared with.
**
** They stand in libylm_rival.so (csrc/rival), which hands them to ylm_material_rival_set. Until then
** ylm_material_rival_nearest answers NULL.
*/
#ifndef YLM_MATERIAL_RIVAL_H
#define YLM_MATERIAL_RIVAL_H

#include "ylm_material_table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The rows of a table that is looked up by the nearest one. */
#define YLM_MATERIAL_NEAREST_ROWS 90

/*
** From n eyes to those of the rows and columns that stand for them.
**
**   facts  in   of the table
**   wo     in   [n][3] of length 1, in the surface's frame
**   out    out  [n][3] likewise; may be wo
*/
typedef void ylm_material_rival_fn(const ylm_material_table_facts *facts, size_t n,
                                   const float (*wo)[3], float (*out)[3]);

/* Makes it known for the life of the process. May be called again, and from any thread. */
YLM_API void ylm_material_rival_set(ylm_material_rival_fn *nearest);
YLM_API ylm_material_rival_fn *ylm_material_rival_nearest(void);

#ifdef __cplusplus
}
#endif
#endif
