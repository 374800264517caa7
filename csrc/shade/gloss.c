/* gloss.c - the surfaces of a view that gloss: their materials, and tables of these by degree. */
#include <stdatomic.h>
#include <string.h>

#include "gloss.h"

struct shade_gloss {
  size_t materials, meshes, points;
  const ylm_material **material; /* [materials], each once    */
  bool *seen;                    /* [materials]: at some point */
  uint32_t *slot;                /* [meshes]: of its material; YLM_SHADE_MATTE: matte */
  float (*tangent)[3];           /* [points of the view]; NULL: all materials are isotropic */
  _Atomic(shade_tables *) tables;
};

static bool is_glossy(const ylm_material *m) {
  return ylm_material_kind(m) != ylm_material_kind_find("matte");
}

/* Gives a material its number. */
static uint32_t number_of(shade_gloss *g, const ylm_material *m) {
  for (size_t k = 0; k < g->materials; k++)
    if (g->material[k] == m) return (uint32_t)k;
  g->material[g->materials] = m;
  return (uint32_t)g->materials++;
}

ylm_status ylm__shade_gloss_create(const ylm_scene *scene, shade_gloss **out) {
  size_t meshes = ylm_scene_meshes(scene), n = 0;
  *out = NULL;
  for (size_t i = 0; i < meshes; i++) n += is_glossy(ylm_scene_material(scene, i));
  if (n == 0) return YLM_OK;
  shade_gloss *g = *out = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  g->meshes = meshes;
  g->material = ylm_alloc(n, sizeof *g->material);
  g->seen = ylm_alloc_zero(n, sizeof *g->seen);
  g->slot = ylm_alloc(meshes, sizeof *g->slot);
  if (!g->material || !g->seen || !g->slot) return YLM_ENOMEM;
  for (size_t i = 0; i < meshes; i++) {
    const ylm_material *m = ylm_scene_material(scene, i);
    g->slot[i] = is_glossy(m) ? number_of(g, m) : YLM_SHADE_MATTE;
  }
  return YLM_OK;
}

ylm_status ylm__shade_gloss_room(shade_gloss *g, size_t points) {
  bool turned = false;
  for (size_t k = 0; g && k < g->materials; k++) turned |= !ylm_material_isotropic(g->material[k]);
  if (!turned) return YLM_OK;
  g->tangent = ylm_alloc(points, sizeof *g->tangent);
  return g->tangent ? YLM_OK : YLM_ENOMEM;
}

void ylm__shade_gloss_point(shade_gloss *g, size_t i, uint32_t mesh, const ylm_scene_surface *s) {
  if (g->tangent) memcpy(g->tangent[i], s->tangent, 12);
  if (g->slot[mesh] == YLM_SHADE_MATTE) return;
  g->seen[g->slot[mesh]] = true;
  g->points++;
}

uint32_t ylm__shade_gloss_slot(const shade_gloss *g, uint32_t mesh) { return g->slot[mesh]; }
const float (*ylm__shade_gloss_tangents(const shade_gloss *g))[3] {
  return (const float(*)[3])g->tangent;
}

/* -- tables ------------------------------------------------------------------------------------ */

static void tables_free(shade_tables *t) {
  if (!t) return;
  ylm_free(t->table);
  ylm_sh_rotator_free(t->rotator);
  ylm_sh_product_free(t->product);
  ylm_free(t);
}

static ylm_status tables_create(const shade_gloss *g, int lmax, int threads,
                                const ylm_progress *progress, shade_tables **out, ylm_error *e) {
  double start = ylm_seconds();
  shade_tables *t = *out = ylm_alloc_zero(1, sizeof *t);
  if (!t) return YLM_ENOMEM;
  t->lmax = lmax;
  t->table = ylm_alloc_zero(g->materials, sizeof *t->table);
  ylm_status s = t->table ? ylm_sh_rotator_create(lmax, &t->rotator, e) : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm_sh_product_create(lmax, 2, YLM_SH_PRODUCT_auto, YLM_SH_PRODUCT_auto, &t->product, e);
  for (size_t k = 0; s == YLM_OK && k < g->materials; k++)
    if (g->seen[k]) {
      ylm_material_table_facts f = {0};
      s = ylm_material_table_kept(g->material[k], lmax, threads, progress, &t->table[k], e);
      if (s == YLM_OK) ylm_material_table_look(t->table[k], &f);
      t->bytes += f.bytes;
    }
  t->seconds = ylm_seconds() - start;
  return s;
}

static const shade_tables *find(shade_tables *t, int lmax) {
  while (t && t->lmax != lmax) t = t->next;
  return t;
}

ylm_status ylm__shade_gloss_tables(const ylm_shade_view *v, int lmax, int threads,
                                   const ylm_progress *progress, const shade_tables **out,
                                   ylm_error *e) {
  shade_gloss *g = v->gloss;
  *out = NULL;
  if (!g || g->points == 0) return YLM_OK;
  shade_tables *head = atomic_load(&g->tables), *made;
  if ((*out = find(head, lmax))) return YLM_OK;
  if (lmax > YLM_MATERIAL_TABLE_LMAX)
    return ylm_fail(e, YLM_ERANGE,
                    "surfaces that gloss are shaded by tables of degree 0 to %d, here is light of "
                    "degree %d: lower lmax, or shade them as matte ones",
                    YLM_MATERIAL_TABLE_LMAX, lmax);
  ylm_status s = tables_create(g, lmax, threads, progress, &made, e);
  if (s != YLM_OK) {
    tables_free(made);
    return s;
  }
  do made->next = head; /* others that made the same at the same time stay behind it, unused */
  while (!atomic_compare_exchange_weak(&g->tables, &head, made));
  *out = made;
  return YLM_OK;
}

void ylm__shade_gloss_stats(const ylm_shade_view *v, ylm_shade_stats *stats) {
  shade_gloss *g = v->gloss;
  if (!g) return;
  stats->glossy = g->points;
  stats->bytes += g->meshes * sizeof *g->slot + (g->tangent ? 12 * v->points : 0);
  for (const shade_tables *t = atomic_load(&g->tables); t; t = t->next) {
    stats->gloss_bytes += t->bytes;
    stats->gloss_seconds += t->seconds;
  }
}

void ylm__shade_gloss_free(shade_gloss *g) {
  if (!g) return;
  for (shade_tables *t = atomic_load(&g->tables), *next; t; t = next) {
    next = t->next;
    tables_free(t);
  }
  ylm_free(g->material);
  ylm_free(g->seen);
  ylm_free(g->slot);
  ylm_free(g->tangent);
  ylm_free(g);
}
