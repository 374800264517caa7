/* set.h - a set of lights, as the files of csrc/light see it. Private to the folder. */
#ifndef YLM_LIGHT_SET_H
#define YLM_LIGHT_SET_H

#include "kind.h"

/* A light by its pack and its place there. */
typedef struct ylm__light_place {
  uint32_t pack;
  size_t i;
} ylm__light_place;

struct ylm_light_set {
  size_t n, packs;
  ylm__light_pack **pack; /* [packs] in the order of summation */
  ylm_field_sum *sum;     /* of several packs; NULL: there is one */
  size_t places;
  ylm__light_place *place; /* [places] lights of records, in the order they were given */
};

/* A set of one pack, which it takes whatever happens. YLM_ENOMEM. */
ylm_status ylm__light_set_of_pack(const ylm__light_pack *made, ylm_light_set **set, ylm_error *e);
/* The pack of spheres; NULL: there is none. */
ylm__light_pack *ylm__light_set_spheres(const ylm_light_set *set);

#endif
