/* cut.c - the field of a set to a tolerance: spheres by a tree, all other lights as ever. */
#include "set.h"

struct ylm_light_cut {
  const ylm_light_set *set;
  ylm__tree_field *tree; /* of the spheres; NULL: there are none */
  ylm_field_sum *sum;    /* of that and of the other packs; NULL: that alone */
};

/* The fields of the packs, spheres by the tree. */
static ylm_status sum_packs(ylm_light_cut *c) {
  const ylm_light_set *set = c->set;
  const ylm_field **field = ylm_alloc(set->packs, sizeof *field);
  if (!field) return YLM_ENOMEM;
  for (size_t i = 0; i < set->packs; i++) field[i] = set->pack[i]->field;
  field[0] = ylm__tree_field_get(c->tree);
  ylm_status s = ylm_field_sum_create(set->packs, field, &c->sum);
  ylm_free((void *)field);
  return s;
}

ylm_status ylm_light_cut_create(ylm_light_set *set, double tolerance, int threads,
                                ylm_light_cut **cut, ylm_error *e) {
  *cut = NULL;
  if (!(tolerance >= YLM_LIGHT_TOLERANCE_LEAST && tolerance <= YLM_LIGHT_TOLERANCE_MOST))
    return ylm_fail(e, YLM_ERANGE, "tolerance must be %g .. %g, got %g", YLM_LIGHT_TOLERANCE_LEAST,
                    YLM_LIGHT_TOLERANCE_MOST, tolerance);
  ylm_light_cut *c = ylm_alloc_zero(1, sizeof *c);
  if (!c) return ylm_fail(e, YLM_ENOMEM, "%s", ylm_status_text(YLM_ENOMEM));
  c->set = set;
  ylm__light_pack *spheres = ylm__light_set_spheres(set);
  ylm_status s = YLM_OK;
  if (spheres) s = ylm__tree_field_create(spheres->of, tolerance, threads, &c->tree, e);
  if (s == YLM_OK && spheres && set->packs > 1) s = sum_packs(c);
  if (s == YLM_OK)
    *cut = c;
  else
    ylm_light_cut_free(c);
  return s == YLM_ENOMEM ? ylm_fail(e, s, "%s", ylm_status_text(s)) : s;
}

void ylm_light_cut_free(ylm_light_cut *c) {
  if (!c) return;
  ylm_field_sum_free(c->sum);
  ylm__tree_field_free(c->tree);
  ylm_free(c);
}

const ylm_field *ylm_light_cut_field(const ylm_light_cut *c) {
  return c->sum    ? ylm_field_sum_field(c->sum)
         : c->tree ? ylm__tree_field_get(c->tree)
                   : ylm_light_set_field(c->set);
}

ylm_status ylm_light_cut_evaluate(const ylm_light_cut *c, ylm_isa isa, const ylm_field_query *q,
                                  size_t n, const void *points, ylm_field_result *r, ylm_error *e) {
  if (!c->tree || c->sum) return ylm_light_set_evaluate(c->set, isa, q, n, points, r, e);
  return ylm__tree_field_evaluate(c->tree, isa, q, n, points, r, e);
}

size_t ylm_light_set_tree_bytes(const ylm_light_set *set) {
  const ylm__light_pack *p = ylm__light_set_spheres(set);
  return p ? ylm__lights_tree_bytes(p->of) : 0;
}
