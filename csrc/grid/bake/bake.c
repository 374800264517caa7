/* bake.c - a bake under way, from its beginning to its end: which voxels there are, the loop over levels, by a
   tolerance as often as it takes, and what finishes the grid. */
#include "baker.h"
#include "surface.h"

#include <float.h>
#include <string.h>

/* Reports the progress of some work under the bake's own stage. */
static bool forward(void *user, uint64_t done, uint64_t total, const char *stage) {
  const baker *b = user;
  (void)stage;
  return ylm_report(b->source->progress, done, total, b->stage) == YLM_OK;
}

void ylm__baker_begin(baker *b, ylm_grid *g, const ylm_grid_source *source, ylm_error *e) {
  *b = (baker){.g = g, .source = source, .remote = source->backend, .e = e};
  b->own = ylm__processor_backend(b);
  if (g) b->measure = ylm__measure_of(&g->contents.form);
  b->measure.squares = source->squares;
  if (g && source->backend) memset(g->origin, 0, sizeof g->origin); /* it asks at positions */
  b->stage = strcpy(b->stage_text, "verifying"); /* points that judge come before any level */
  b->progress = (ylm_progress){forward, b};
  b->making = (ylm_grid_making){.source = source,
                                .grid = g,
                                .stats = g ? &g->stats : NULL,
                                .progress = source->progress ? &b->progress : NULL,
                                .e = e};
}

void ylm__baker_free(baker *b) {
  ylm__evaluate_free_block(&b->block);
  ylm_free(b->row);
  ylm_free(b->wave.cell);
  ylm_free(b->next.cell);
  ylm_free(b->parent.cell);
  ylm_free(b->used);
}

ylm_status ylm__grid_check_source(const ylm_grid_source *s, bool dynamic, ylm_error *e) {
  size_t bad;
  if (!s->field || !s->field->evaluate) return ylm_fail(e, YLM_EINVAL, "no light field");
  if (dynamic && !s->lights)
    return ylm_fail(e, YLM_EINVAL,
                    "dynamic: a grid that is to be updated is baked from sphere or flat lights");
  if (s->meshes && (s->occupied || s->occupied_points))
    return ylm_fail(e, YLM_EINVAL, "occupied: either points or surfaces");
  if (s->meshes) return ylm__grid_check_meshes(s->meshes, s->mesh, e);
  if (!s->occupied_points) return YLM_OK;
  if (s->occupied == 0) return ylm_fail(e, YLM_EINVAL, "occupied: no points");
  if (!ylm_all_finite(s->occupied_dtype, s->occupied_points, 3 * s->occupied, &bad))
    return ylm_fail(e, YLM_EDOMAIN, "occupied: point %zu is not finite", bad / 3 + 1);
  return YLM_OK;
}

ylm_status ylm__grid_no_room(ylm_status s, const ylm_grid_source *source, ylm_error *e) {
  if (s == YLM_ENOMEM) ylm_fail(e, s, "the grid does not fit into memory");
  if (s == YLM_ELIMIT)
    ylm_fail(e, s, "the grid needs more than %zu points",
             source->max_points ? source->max_points : (size_t)YLM_GRID_NONE);
  return s;
}

/* A back end rounds positions to float: far from 0 the light at them is that of another place. */
static ylm_status check_back_end(const ylm_grid_form *f, ylm_error *e) {
  double far = 0, edge = INFINITY, voxel = INFINITY;
  for (int a = 0; a < 3; a++) {
    double wide = f->bounds[a + 3] - f->bounds[a];
    far = fmax(far, fmax(fabs(f->bounds[a]), fabs(f->bounds[a + 3])));
    edge = fmin(edge, wide);
    voxel = fmin(voxel, f->kind == YLM_GRID_UNIFORM ? wide / f->cells[a] : ldexp(wide, -f->depth));
  }
  double rounding = far * FLT_EPSILON / 2;
  if (rounding > voxel * REMOTE_VOXEL)
    return ylm_fail(
        e, YLM_ERANGE,
        "device: it rounds positions to float, and %g from the origin that is %.2g of the "
        "finest voxel: leave device out, or move the scene to the origin",
        far, rounding / voxel);
  if (!(f->tolerance > 0) || rounding <= f->tolerance * edge * REMOTE_ROUNDING) return YLM_OK;
  return ylm_fail(e, YLM_ERANGE,
                  "device: it rounds positions to float, and %g from the origin that is too coarse "
                  "for a tolerance of %g: leave device out, or move the scene to the origin",
                  far, f->tolerance);
}

/* The grid that a bake is to be like knows how, and is of such light. */
static ylm_status check_like(const ylm_grid_form *form, const ylm_grid_source *s, ylm_error *e) {
  const ylm_grid_form *f = &s->like->contents.form;
  if (!s->like->frames)
    return ylm_fail(e, YLM_EINVAL,
                    "a grid expected that ylm.bake made by a tolerance, not dynamic, on the "
                    "processor");
  if (!(form->tolerance > 0) || form->dynamic || s->backend)
    return ylm_fail(e, YLM_EINVAL,
                    "what another bake has learnt is for grids with a tolerance, not dynamic, on "
                    "the processor");
  if (f->lmax != form->lmax || f->channels != form->channels || f->measure != form->measure)
    return ylm_fail(e, YLM_EINVAL,
                    "a grid of the same lmax, channels and measure expected: of lmax %d, got %d",
                    form->lmax, f->lmax);
  return YLM_OK;
}

/* The voxels of the first level, from the back end as far as it knows. */
static ylm_status occupy(baker *b, size_t *voxels) {
  uint64_t *code = NULL;
  ylm_status s = ylm__backend_occupied(b, &code, voxels);
  if (s != YLM_OK || backend_keeps_cells(b)) return s;
  s = ylm__occupy_voxels(b, code, *voxels);
  *voxels = b->wave.n;
  return s;
}

static ylm_status bake(baker *b) {
  size_t voxels = 0;
  ylm_status s = occupy(b, &voxels);
  if (s != YLM_OK) return s;
  if (b->g->contents.form.sides) return ylm__sides_bake(b);
  if (b->g->contents.form.tolerance > 0) return ylm__tolerance_bake(b);
  s = ylm__refine(b, voxels);
  return s == YLM_OK ? ylm__finish(b) : s;
}

ylm_status ylm_grid_bake(const ylm_grid_form *form, const ylm_grid_source *source, ylm_grid **out,
                         ylm_error *e) {
  double begin = ylm_seconds();
  *out = NULL;
  ylm_status s = ylm__grid_check_form(form, e);
  if (s == YLM_OK) s = ylm__grid_check_source(source, form->dynamic, e);
  if (s == YLM_OK && form->sides && !(source->walls && source->walls->meets))
    s = ylm_fail(e, YLM_EINVAL, "a grid with sides needs to know where surfaces are");
  if (s == YLM_OK && form->sides && source->backend)
    s = ylm_fail(e, YLM_EINVAL, "device: a grid with sides is baked by the processor");
  if (s == YLM_OK && source->like) s = check_like(form, source, e);
  if (s == YLM_OK && source->backend) s = check_back_end(form, e);
  if (s == YLM_OK && form->dynamic && source->backend)
    s = ylm_fail(e, YLM_EINVAL, "a grid is wanted that is not dynamic");
  if (s == YLM_OK && source->team && (form->dynamic || source->backend))
    s = ylm_fail(e, YLM_EINVAL, "a team bakes on processors, a grid that is not dynamic");
  if (s != YLM_OK) return s;
  baker b;
  frames *before = source->like ? ylm_alloc_copy(source->like->frames, 1, sizeof *before) : NULL;
  if (source->like && !before) return ylm__grid_no_room(YLM_ENOMEM, source, e);
  ylm_grid_form meant = *form;
  meant.quantity = source->field->quantity;
  ylm__baker_begin(&b, ylm__grid_new(&meant), source, e);
  s = b.g ? YLM_OK : YLM_ENOMEM;
  b.before_this = before;
  if (s == YLM_OK && source->field->tells_validity && !source->backend) {
    b.g->validity = ylm_alloc(1, sizeof *b.g->validity);
    s = b.g->validity ? YLM_OK : YLM_ENOMEM;
  }
  if (s == YLM_OK && b.g->follower) s = b.g->follower->begin(b.g, source, &b.surface, e);
  if (s == YLM_OK) s = ylm__divide_begin(&b);
  if (s == YLM_OK) s = bake(&b);
  if (!b.told) ylm__grid_no_room(s, source, e);
  s = ylm__divide_agree(&b, s);
  if (s == YLM_OK && b.g->follower) s = b.g->follower->end(b.g, &b.learnt);
  ylm__occupancy_free(&b.learnt.occupied);
  ylm__panel_free(&b.learnt.panel);
  ylm__baker_free(&b);
  ylm_free(before);
  if (s != YLM_OK) {
    ylm_grid_free(b.g);
    return s;
  }
  if (!form->dynamic && !backend_keeps_cells(&b)) ylm__grid_trim(b.g);
  b.g->stats.seconds = ylm_seconds() - begin;
  *out = b.g;
  return YLM_OK;
}
