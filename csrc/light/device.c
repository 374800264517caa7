/* device.c - what a device sums of a set. */
#include "set.h"

bool ylm_light_set_part(const ylm_light_set *set, size_t i, ylm_light_part *out) {
  if (i >= set->packs) return false;
  const ylm__light_pack *p = set->pack[i];
  *out = (ylm_light_part){.kind = p->kind->name};
  if (p->kind->device) p->kind->device(p->of, out);
  return true;
}
