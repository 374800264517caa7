/* few.c - grids as files of few bytes. */
#include "../bake/panel.h"
#include "file.h"

#include <math.h>

ylm_status ylm__grid_file_check_small(const ylm_grid *g, double error, const ylm_grid_small *how,
                                      ylm_error *e) {
  int asked = (how->tolerance != 0) + (how->bytes != 0) + (how->step != 0);
  if (g->contents.form.dynamic)
    return ylm_fail(
        e, YLM_EINVAL,
        "a grid that follows lights is saved as it is: few bytes are for grids that do not");
  if (asked != 1) return ylm_fail(e, YLM_EINVAL, "one of tolerance, bytes and step expected");
  if (how->tolerance != 0 && !(how->tolerance > 0 && how->tolerance <= 0.5))
    return ylm_fail(e, YLM_EDOMAIN, "tolerance: above 0 and at most 0.5 expected, got %g",
                    how->tolerance);
  if (how->step != 0 && !(how->step >= 1e-7 && how->step <= 1))
    return ylm_fail(e, YLM_EDOMAIN, "step: 1e-7 to 1 expected, got %g", how->step);
  if (how->tolerance > 0 && error >= how->tolerance)
    return ylm_fail(
        e, YLM_ELIMIT,
        "tolerance: the grid errs by %.3g already, and %g is asked for in all: bake it to a "
        "smaller tolerance, or save it to a larger one",
        error, how->tolerance);
  if (!ylm_all_finite(YLM_FLOAT, g->data, g->evaluated * ylm__grid_record(g), NULL))
    return ylm_fail(e, YLM_EDOMAIN, "the grid's light is not finite");
  return YLM_OK;
}

void ylm__grid_file_describe_small(ylm_grid *g, const ylm_grid_small *how,
                                   const ylm_grid_small_report *r) {
  ylm_grid_stats *s = &g->stats;
  double *promised = &g->contents.form.tolerance;
  bool promises = *promised > 0;
  s->error = r->error;
  if (how->tolerance > 0 && promises) *promised = how->tolerance;
  if (!(how->tolerance > 0) && promises && r->error > *promised) *promised = r->error;
  s->met = promises && r->error <= *promised;
  s->limited &= !s->met;
}

ylm_status ylm_grid_encode_small(const ylm_grid *g, const ylm_grid_small *how, unsigned char **data,
                                 size_t *size, ylm_grid_small_report *report, ylm_error *e) {
  small_encoder *k = NULL;
  *data = NULL;
  *size = 0;
  ylm_status s = ylm__grid_file_machine("the grid", e);
  if (s == YLM_OK) s = ylm__grid_file_check_small(g, g->stats.error, how, e);
  if (s != YLM_OK) return s;
  s = ylm__small_encoder(g, NULL, how->threads, &k);
  if (s == YLM_EDOMAIN) ylm_fail(e, s, "the grid has no points");
  if (s == YLM_ENOMEM) ylm_fail(e, s, "the grid does not fit into memory twice");
  if (s == YLM_OK) s = ylm__small_search(k, g, how, ylm__grid_file_small_size, e);
  if (s == YLM_OK) {
    small_packed *p = ylm__small_packed_of(k);
    ylm__grid_file_describe_small(ylm__small_grid_of(k), how, &p->report);
    if (report) *report = p->report;
    s = ylm__grid_file_encode(ylm__small_grid_of(k), p, data, size, e);
  } else if (s == YLM_ENOMEM)
    ylm_fail(e, s, "the grid does not fit into memory twice");
  ylm__small_encoder_free(k);
  return s;
}

const ylm_grid_small_constant *ylm_grid_small_constants(size_t *n) {
#define X(name, value) {#name, (double)(value)},
  static const ylm_grid_small_constant list[] = {SMALL_CONSTANTS(X)};
#undef X
  *n = sizeof list / sizeof *list;
  return list;
}

bool ylm_grid_small_of(const ylm_grid *g, ylm_grid_small_report *report) {
  if (g->is_small) *report = g->small;
  return g->is_small;
}

void ylm_grid_inherit(ylm_grid *to, ylm_grid *from) {
  ylm__grid_forget_panel(to);
  ylm_free(to->judge);
  to->judge = from->judge;
  to->judges = from->judges;
  to->panel = from->panel;
  from->judge = NULL;
  from->judges = 0;
  from->panel = NULL;
}

ylm_status ylm_grid_small_parts(const unsigned char *data, size_t size,
                                ylm_grid_small_part part[YLM_GRID_SMALL_PARTS], ylm_error *e) {
  static const struct {
    const char *name;
    int kind;
  } wanted[YLM_GRID_SMALL_PARTS] = {
      {"head", GRID_FILE_small},          {"tree", GRID_FILE_small_tree},
      {"bases", GRID_FILE_small_bases},   {"tables", GRID_FILE_small_tables},
      {"points", GRID_FILE_small_points}, {"numbers", GRID_FILE_small_numbers},
      {"bits", GRID_FILE_small_bits},
  };
  file_source source;
  file_table t = {0};
  ylm_status s = ylm__file_source_memory(&source, "the grid", data, size, e);
  if (s == YLM_OK) s = ylm__file_table_read(&t, &source, e);
  for (int i = 0; s == YLM_OK && i < YLM_GRID_SMALL_PARTS; i++) {
    const grid_file_entry *entry = ylm__file_table_find(&t, wanted[i].kind);
    part[i] = (ylm_grid_small_part){.name = wanted[i].name};
    if (entry) part[i].data = data + entry->offset, part[i].size = (size_t)entry->size;
  }
  if (s == YLM_OK && !part[0].data) s = ylm__grid_file_bad("the grid", "not of few bytes", e);
  ylm_free(t.entry);
  return s;
}
