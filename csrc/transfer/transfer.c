/* transfer.c - elements and links as one object. */
#include <math.h>

#include "transfer.h"

static ylm_status check(const ylm_transfer_form *f, size_t meshes, ylm_error *e) {
  ylm_status s = ylm__transfer_check_links(f->links, e);
  size_t where;
  if (s != YLM_OK) return s;
  if (!(f->spacing >= 0) || !isfinite(f->spacing))
    return ylm_fail(e, YLM_ERANGE, "spacing must be a positive length, got %g", f->spacing);
  if (f->lmax < -1 || f->lmax > YLM_TRANSFER_LMAX)
    return ylm_fail(e, YLM_ERANGE, "lmax must be from 0 to %d, got %d", YLM_TRANSFER_LMAX, f->lmax);
  if (f->max_elements > YLM_TRANSFER_ELEMENTS_MOST)
    return ylm_fail(e, YLM_ERANGE, "max_elements must be at most %zu", YLM_TRANSFER_ELEMENTS_MOST);
  for (size_t m = 0; f->mesh_sides && m < meshes; m++)
    if (f->mesh_sides[m] > YLM_TRANSFER_BACK)
      return ylm_fail(e, YLM_ERANGE, "mesh %zu has no such sides", m + 1);
  if (f->places && !ylm_all_finite(YLM_FLOAT, f->inside, 3 * f->places, &where))
    return ylm_fail(e, YLM_ERANGE, "place %zu inside of the scene is not finite", where / 3 + 1);
  return YLM_OK;
}

size_t ylm__transfer_bytes(const ylm_transfer *t) {
  size_t row = t->escape ? ylm_sh_count(t->form.lmax) : 0;
  size_t links = (size_t)t->form.links * ylm_links_bytes(t->link);
  return t->elements * (3 * 12 + 4 * 4 + 1 + links + 4 * row) +
         t->triangles * (sizeof *t->cut + sizeof *t->foot + sizeof *t->start + (t->ground != NULL));
}

ylm_status ylm_transfer_create(const ylm_scene *scene, const ylm_transfer_form *form,
                               ylm_transfer **out, ylm_error *e) {
  *out = NULL;
  double begun = ylm_seconds();
  ylm_status s = check(form, ylm_scene_meshes(scene), e);
  ylm_transfer *t = s == YLM_OK ? ylm_alloc_zero(1, sizeof *t) : NULL;
  if (!t) return s == YLM_OK ? YLM_ENOMEM : s;
  t->scene = scene;
  t->form = *form;
  t->form.mesh_sides = NULL;
  t->form.inside = NULL;
  t->form.places = 0;
  t->form.progress = NULL;
  if (!t->form.max_elements) t->form.max_elements = YLM_TRANSFER_ELEMENTS;
  s = ylm__transfer_cut(t, form, e);
  if (s == YLM_OK) s = ylm__transfer_link(t, form->progress, e);
  t->stats.seconds = ylm_seconds() - begun;
  t->stats.bytes = ylm__transfer_bytes(t);
  if (s == YLM_OK)
    *out = t;
  else
    ylm_transfer_free(t);
  return s;
}

void ylm_transfer_free(ylm_transfer *t) {
  if (!t) return;
  ylm_free(t->first);
  ylm_free(t->side);
  ylm_free(t->ground);
  ylm_free(t->cut);
  ylm_free(t->foot);
  ylm_free(t->start);
  ylm_free(t->centre);
  ylm_free(t->normal);
  ylm_free(t->area);
  ylm_free(t->albedo);
  ylm_free(t->mesh);
  ylm_free(t->triangle);
  ylm_free(t->share);
  ylm_free(t->crossed);
  ylm_links_free(t->link);
  ylm_free(t->escape);
  ylm_free(t);
}

void ylm_transfer_look(const ylm_transfer *t, ylm_transfer_stats *stats) { *stats = t->stats; }
const ylm_transfer_form *ylm_transfer_made(const ylm_transfer *t) { return &t->form; }
const ylm_scene *ylm_transfer_scene(const ylm_transfer *t) { return t->scene; }
size_t ylm_transfer_count(const ylm_transfer *t) { return t->elements; }
ylm_links ylm_transfer_links(const ylm_transfer *t) { return t->link; }
const float *ylm_transfer_escape(const ylm_transfer *t) { return t->escape; }
