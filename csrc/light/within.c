/* within.c - the field of a set to a tolerance: spheres by a tree, virtual lights by theirs, all other lights as
   ever. */
#include "set.h"

struct ylm_light_cut {
  const ylm_light_set *set;
  ylm__tree_field *tree; /* of the spheres; NULL: there are none */
  size_t packs;
  struct of_pack {
    const ylm__light_kind *kind;
    ylm_field *field; /* NULL: as ever */
  } * within;         /* [packs] of packs but the spheres */
  ylm_field_sum *sum; /* of these and of the other packs; NULL: there is one */
};

/* The field of a pack. */
static const ylm_field *field_of(const ylm_light_cut *c, size_t i) {
  if (c->tree && c->set->pack[i] == ylm__light_set_spheres(c->set))
    return ylm__tree_field_get(c->tree);
  return c->within[i].field ? c->within[i].field : c->set->pack[i]->field;
}

static ylm_status sum_packs(ylm_light_cut *c) {
  const ylm_light_set *set = c->set;
  const ylm_field **field = ylm_alloc(set->packs, sizeof *field);
  if (!field) return YLM_ENOMEM;
  for (size_t i = 0; i < set->packs; i++) field[i] = field_of(c, i);
  ylm_status s = ylm_field_sum_create(set->packs, field, &c->sum);
  ylm_free((void *)field);
  return s;
}

/* The trees of all packs that have one. */
static ylm_status make_trees(ylm_light_cut *c, double tolerance, int threads, ylm_error *e) {
  ylm__light_pack *spheres = ylm__light_set_spheres(c->set);
  ylm_status s = YLM_OK;
  if (spheres) s = ylm__tree_field_create(spheres->of, tolerance, threads, &c->tree, e);
  for (size_t i = 0; s == YLM_OK && i < c->packs; i++) {
    const ylm__light_pack *p = c->set->pack[i];
    c->within[i].kind = p->kind;
    if (p->kind->within) s = p->kind->within(p->of, tolerance, threads, &c->within[i].field, e);
  }
  return s;
}

ylm_status ylm_light_cut_create(ylm_light_set *set, double tolerance, int threads,
                                ylm_light_cut **cut, ylm_error *e) {
  *cut = NULL;
  if (!(tolerance >= YLM_LIGHT_TOLERANCE_LEAST && tolerance <= YLM_LIGHT_TOLERANCE_MOST))
    return ylm_fail(e, YLM_ERANGE, "tolerance must be %g .. %g, got %g", YLM_LIGHT_TOLERANCE_LEAST,
                    YLM_LIGHT_TOLERANCE_MOST, tolerance);
  ylm_light_cut *c = ylm_alloc_zero(1, sizeof *c);
  if (!c) return ylm_no_memory(e);
  c->set = set;
  c->packs = set->packs;
  c->within = ylm_alloc_zero(set->packs + 1, sizeof *c->within);
  ylm_status s = c->within ? make_trees(c, tolerance, threads, e) : YLM_ENOMEM;
  if (s == YLM_OK && set->packs > 1) s = sum_packs(c);
  if (s == YLM_OK)
    *cut = c;
  else
    ylm_light_cut_free(c);
  return s == YLM_ENOMEM ? ylm_no_memory(e) : s;
}

void ylm_light_cut_free(ylm_light_cut *c) {
  if (!c) return;
  ylm_field_sum_free(c->sum);
  ylm__tree_field_free(c->tree);
  for (size_t i = 0; c->within && i < c->packs; i++)
    if (c->within[i].field) c->within[i].kind->within_free(c->within[i].field);
  ylm_free(c->within);
  ylm_free(c);
}

const ylm_field *ylm_light_cut_field(const ylm_light_cut *c) {
  return c->sum          ? ylm_field_sum_field(c->sum)
         : c->packs == 1 ? field_of(c, 0)
                         : ylm_light_set_field(c->set);
}

ylm_status ylm_light_cut_evaluate(const ylm_light_cut *c, ylm_isa isa, const ylm_field_query *q,
                                  size_t n, const void *points, ylm_field_result *r, ylm_error *e) {
  if (c->sum) return ylm_light_set_evaluate(c->set, isa, q, n, points, r, e);
  if (c->tree) return ylm__tree_field_evaluate(c->tree, isa, q, n, points, r, e);
  if (c->packs == 1 && c->within[0].field)
    return c->within[0].kind->within_evaluate(c->within[0].field->self, isa, q, n, points, r, e);
  return ylm_light_set_evaluate(c->set, isa, q, n, points, r, e);
}

size_t ylm_light_set_tree_bytes(const ylm_light_set *set) {
  const ylm__light_pack *spheres = ylm__light_set_spheres(set);
  size_t bytes = spheres ? ylm__lights_tree_bytes(spheres->of) : 0;
  for (size_t i = 0; i < set->packs; i++) {
    const ylm__light_pack *p = set->pack[i];
    if (p->kind->within_bytes) bytes += p->kind->within_bytes(p->of);
  }
  return bytes;
}
