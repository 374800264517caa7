/* groups.h - the materials that an OBJ file names, while it is read. Private to csrc/geom. */
#ifndef YLM_GEOM_GROUPS_H
#define YLM_GEOM_GROUPS_H

#include "reader.h"
#include "ylm_keys.h"

typedef struct ylm_grouping {
  ylm_growing library, name; /* ylm_mesh_text */
  ylm_growing group;         /* uint32_t, of each triangle so far */
  uint32_t current;          /* 0: none yet */
  ylm_keys table;            /* of names, numbered as they are */
} ylm_grouping;

void ylm__groups_begin(ylm_grouping *g);
void ylm__groups_discard(ylm_grouping *g);
/* The rest of a line of mtllib, and of usemtl. YLM_EFORMAT (a zero byte), YLM_ENOMEM. */
ylm_status ylm__groups_library(ylm_grouping *g, ylm_lines *at);
ylm_status ylm__groups_use(ylm_grouping *g, ylm_lines *at);
/* n further triangles of the current group; false: no memory. */
bool ylm__groups_faces(ylm_grouping *g, size_t n);
/* Hands over what was read, NULL without memory; discards nothing then. */
ylm_mesh_groups *ylm__groups_finish(ylm_grouping *g);

#endif
