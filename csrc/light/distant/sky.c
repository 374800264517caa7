/* sky.c - light that comes from infinity, as rays see it. */
#include "../set.h"

bool ylm_light_set_is_distant(const ylm_light_set *set) {
  for (size_t k = 0; k < set->packs; k++)
    if (set->pack[k]->kind->radiance) return true;
  return false;
}

void ylm_light_set_sky(const ylm_light_set *set, const double d[3], bool cones, double rgb[3]) {
  rgb[0] = rgb[1] = rgb[2] = 0;
  for (size_t k = 0; k < set->packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    if (p->kind->radiance && (cones || !p->kind->cone)) p->kind->radiance(p->of, d, rgb);
  }
}

bool ylm_light_set_cone(const ylm_light_set *set, size_t i, ylm_light_cone *out) {
  for (size_t k = 0; k < set->packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    if (!p->kind->cone) continue;
    if (i < p->n) {
      p->kind->cone(p->of, i, out);
      return true;
    }
    i -= p->n;
  }
  return false;
}

bool ylm_light_set_dome(const ylm_light_set *set, size_t i, ylm_light_dome *out) {
  for (size_t k = 0; k < set->packs; k++) {
    const ylm__light_pack *p = set->pack[k];
    if (!p->kind->dome || i-- > 0) continue;
    *out = (ylm_light_dome){.pack = p};
    p->kind->dome(p->of, out);
    return true;
  }
  return false;
}

void ylm_light_dome_radiance(const ylm_light_dome *dome, const double d[3], double rgb[3]) {
  const ylm__light_pack *p = dome->pack;
  rgb[0] = rgb[1] = rgb[2] = 0;
  p->kind->radiance(p->of, d, rgb);
}
