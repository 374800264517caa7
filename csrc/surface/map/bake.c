/* bake.c - pictures, denser from round to round, until fresh places keep the tolerance; and what is asked of a map. */
#include "map.h"

void ylm_surface_map_free(ylm_surface_map *m) {
  if (!m) return;
  ylm__surface_charts_free(&m->plane);
  ylm_unwrap_free(m->charts);
  for (size_t i = 0; m->sheet && i < m->sheets; i++)
    ylm_free(m->sheet[i].parts), ylm_free(m->sheet[i].first), ylm_free(m->sheet[i].of);
  ylm_free(m->sheet);
  ylm_free(m->error);
  ylm_free(m->of);
  ylm_free(m->picture), ylm_free(m->flow);
  ylm_free(m);
}

static ylm_status check(const ylm_surface_map_form *f, ylm_error *e) {
  if (!(f->tolerance >= 0) || !isfinite(f->tolerance))
    return ylm_fail(e, YLM_ERANGE, "tolerance must be at least 0, got %g", f->tolerance);
  if (!(f->aim >= 0 && f->aim <= 1))
    return ylm_fail(e, YLM_ERANGE, "aim must be from 0 to 1, got %g", f->aim);
  if (f->light.links < 4 || f->light.links > YLM_TRANSFER_LINKS)
    return ylm_fail(e, YLM_ERANGE, "links must be from 4 to %d, got %d", YLM_TRANSFER_LINKS,
                    f->light.links);
  if (f->light.scene && (f->light.light_samples < 1 || f->light.light_samples > YLM_TRANSFER_LINKS))
    return ylm_fail(e, YLM_ERANGE, "light_samples must be from 1 to %d", YLM_TRANSFER_LINKS);
  if (f->texels < 16 || f->texels > (size_t)YLM_UNWRAP_SIDE * YLM_UNWRAP_SIDE)
    return ylm_fail(e, YLM_ERANGE, "texels must be from 16 to %d x %d", YLM_UNWRAP_SIDE,
                    YLM_UNWRAP_SIDE);
  return YLM_OK;
}

/* -- rounds ------------------------------------------------------------------------------------------- */

/* The square errors of charts as they are packed; *products [sites], to be freed, NULL: not wanted. */
static ylm_status find_square(map_bake *b, double *square, double **products) {
  double *own = ylm_alloc(b->sites, sizeof *own);
  if (!own) return YLM_ENOMEM;
  ylm__map_products(b, own);
  ylm_status s = b->aim > 0 ? ylm__map_bound(b, own) : YLM_OK;
  if (s == YLM_OK) s = ylm__map_square(b, own, square);
  if (products)
    *products = own;
  else
    ylm_free(own);
  return s;
}

/* Texels as an earlier bake has fitted them, or fitted now. */
static ylm_status fit(map_bake *b, bool last) {
  ylm_status s = ylm__map_matrix(b);
  map_part part[2] = {{b->bend, b->texels * sizeof *b->bend},
                      {b->value, 6 * b->texels * sizeof *b->value}};
  bool had = false;
  if (s == YLM_OK) s = ylm__map_recall(b, 2, part, &had);
  if (s != YLM_OK || had) return s;
  if (last && b->form->smooth) s = ylm__map_smooth(b);
  if (s == YLM_OK) s = ylm__map_fit(b, b->value);
  if (s == YLM_OK && last) s = ylm__map_lift(b, b->value);
  return s == YLM_OK ? ylm__map_remember(b, 2, part) : s;
}

/* One picture of at most so many texels, at the densities as they are. */
static ylm_status make(map_bake *b, size_t texels, bool last) {
  ylm_status s = ylm__map_pack(b, texels);
  b->last = last;
  if (s == YLM_OK) s = ylm__map_sample(b);
  double start = ylm_seconds();
  if (s == YLM_OK) s = fit(b, last);
  b->m->stats.fit_seconds += ylm_seconds() - start;
  if (s == YLM_OK && last) s = find_square(b, b->square, NULL);
  b->m->stats.rounds++;
  return s;
}

/* How square errors fall with the density: the same places on a picture with a quarter of the texels; *products [sites] of these.
   YLM_ELIMIT: the charts do not fit. */
static ylm_status learn_slopes(map_bake *b, size_t few, double **products) {
  double *coarse = ylm_alloc(b->charts, sizeof *coarse);
  ylm_status s = coarse ? ylm__map_pack(b, few) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__map_matrix(b);
  if (s == YLM_OK) s = ylm__map_fit(b, b->value);
  if (s == YLM_OK) s = find_square(b, coarse, products);
  if (s == YLM_OK) ylm__map_slopes(b, coarse);
  ylm_free(coarse);
  return s;
}

/* Square errors and their slopes. Charts are then divided for a picture of `texels`. */
static ylm_status learn(map_bake *b, size_t few, size_t texels) {
  double *products = NULL, *coarse = NULL;
  ylm_status s = find_square(b, b->square, &products);
  if (s == YLM_OK) s = learn_slopes(b, few / 4, &coarse);
  if ((s == YLM_OK || s == YLM_ELIMIT) && b->form->parts)
    s = ylm__map_divide(b, texels, products, coarse);
  ylm_free(products), ylm_free(coarse);
  return s;
}

/* Densities for a number of texels, learnt from a picture with a part of them, or where charts do not fit, with all. */
static ylm_status pilot(map_bake *b, size_t texels) {
  size_t few = (size_t)(MAP_PILOT * (double)texels);
  ylm_error none = {YLM_OK, ""}, *e = b->e;
  b->e = &none;
  ylm_status s = make(b, few, false);
  if (s == YLM_ELIMIT) s = make(b, few = texels, false);
  if (s == YLM_OK) s = learn(b, few, texels);
  b->e = e;
  if (s != YLM_OK && s != YLM_ELIMIT) {
    if (e) *e = none;
    return s;
  }
  if (b->sites) ylm__map_spread(b);
  return YLM_OK; /* what does not fit the next picture says */
}

/* -- the whole ---------------------------------------------------------------------------------------- */

/* Pictures for a tolerance. */
static ylm_status refine(map_bake *b) {
  const ylm_surface_map_form *f = b->form;
  size_t texels = f->texels < MAP_FIRST ? f->texels : MAP_FIRST;
  ylm_status s = f->even ? YLM_OK : pilot(b, texels);
  double before = 0; /* places that missed the aim in the picture before */
  for (uint64_t round = 0; s == YLM_OK && round < MAP_ROUNDS; round++) {
    ylm_error none = {YLM_OK, ""}, *e = b->e;
    b->e = texels < f->texels ? &none : e;
    s = make(b, texels, true);
    b->e = e;
    if (s == YLM_OK) s = ylm__map_draw(b);
    if (s == YLM_OK) s = ylm__map_judge(b, round);
    if (s == YLM_OK && ylm__map_is_enough(b)) break;
    double more = MAP_GROW_MOST;
    if (s == YLM_ELIMIT && texels < f->texels)
      s = YLM_OK; /* too few for all charts */
    else if (texels >= f->texels) {
      b->m->stats.spent = true;
      break;
    } else if (s == YLM_OK) {
      double failed = (double)b->m->stats.failed;
      if (round >= 2 && before > 0 && failed > MAP_PAYS * before + sqrt(before)) {
        b->m->stats.stalled = true;
        break;
      }
      more = ylm__map_growth(b);
      before = failed;
    }
    if (s != YLM_OK && e) *e = none;
    texels = (size_t)fmin((double)f->texels, more * (double)texels);
    if (s == YLM_OK && !f->even && b->width) ylm__map_spread(b);
  }
  return s;
}

static ylm_status make_one(map_bake *b) {
  ylm_status s = b->form->even ? YLM_OK : pilot(b, b->form->texels);
  if (s == YLM_OK) s = make(b, b->form->texels, true);
  if (s == YLM_OK) s = ylm__map_draw(b);
  return s == YLM_OK ? ylm__map_judge(b, 0) : s;
}

ylm_status ylm__map_begin(map_bake *b) {
  ylm_unwrap_stats charts;
  ylm_unwrap_look(b->m->charts, &charts);
  b->charts = charts.charts;
  ylm_free(b->density), ylm_free(b->square), ylm_free(b->slope);
  b->density = ylm_alloc(b->charts, sizeof *b->density);
  b->square = ylm_alloc_zero(b->charts, sizeof *b->square);
  b->slope = ylm_alloc(b->charts, sizeof *b->slope);
  if (!b->density || !b->square || !b->slope) return YLM_ENOMEM;
  for (size_t i = 0; i < b->charts; i++) b->density[i] = 1, b->slope[i] = 2;
  return YLM_OK;
}

static void free_bake(map_bake *b) {
  ylm__map_journal_close(b);
  ylm_free(b->density), ylm_free(b->square), ylm_free(b->slope);
  ylm_free(b->site), ylm_free(b->flow);
  ylm_free(b->chart);
  ylm__map_matrix_free(&b->matrix);
  ylm_free(b->seam);
  ylm_free(b->bend), ylm_free(b->value);
}

/* Finds the errors of charts, as the last fit has them at its own places. */
static ylm_status find_errors(map_bake *b) {
  double *product = ylm_alloc(b->sites, sizeof *product);
  ylm_status s = product ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) ylm__map_products(b, product);
  if (s == YLM_OK) s = ylm__map_square(b, product, b->square);
  for (size_t i = 0; s == YLM_OK && i < b->charts; i++) b->square[i] = sqrt(b->square[i]);
  if (s == YLM_OK) b->m->error = b->square, b->square = NULL;
  ylm_free(product);
  return s;
}

ylm_status ylm_surface_map_bake(const ylm_radiosity *r, const ylm_surface_map_form *form,
                                ylm_surface_map **out, ylm_error *e) {
  *out = NULL;
  ylm_status s = check(form, e);
  if (s != YLM_OK) return s;
  map_bake b = {.r = r, .form = form, .e = e};
  double start = ylm_seconds();
  b.aim = form->tolerance * (form->aim > 0 ? form->aim : 1);
  b.m = ylm_alloc_zero(1, sizeof *b.m);
  if (!b.m) return YLM_ENOMEM;
  b.m->stats.tolerance = form->tolerance;
  b.m->stats.quantity = form->quantity;
  b.m->scene = ylm_transfer_scene(ylm_radiosity_transfer(r));
  s = ylm__surface_charts(b.m->scene, &b.m->plane, e);
  if (s == YLM_OK) s = ylm__map_journal_open(&b);
  if (s == YLM_OK) s = ylm__map_sheets(b.m, r, form, e);
  if (s == YLM_OK && form->parts && !form->even) s = ylm__map_refine(b.m, form, e);
  if (s == YLM_OK) s = ylm__map_begin(&b);
  b.m->stats.sheets = b.m->sheets;
  b.m->stats.chart_seconds = ylm_seconds() - start;
  if (s == YLM_OK) s = form->tolerance > 0 ? refine(&b) : make_one(&b);
  if (s == YLM_OK) s = find_errors(&b);
  free_bake(&b);
  if (s == YLM_OK)
    *out = b.m;
  else
    ylm_surface_map_free(b.m);
  return s;
}

/* -- what is asked ------------------------------------------------------------------------------------- */

void ylm_surface_map_look(const ylm_surface_map *m, ylm_surface_map_stats *stats) {
  *stats = m->stats;
}
const ylm_scene *ylm_surface_map_scene(const ylm_surface_map *m) { return m->scene; }
const float *ylm_surface_map_picture(const ylm_surface_map *m) { return m->picture; }
const float *ylm_surface_map_flow(const ylm_surface_map *m) { return m->flow; }
const double *ylm_surface_map_errors(const ylm_surface_map *m) { return m->error; }
const ylm_unwrap *ylm_surface_map_charts(const ylm_surface_map *m) { return m->charts; }

void ylm_surface_map_verdict(ylm_surface_map *m, size_t verified, size_t failed, double error,
                             double rms) {
  m->stats.verified = verified;
  m->stats.failed = failed;
  m->stats.error = error;
  m->stats.rms = rms;
  m->stats.met = error <= m->stats.tolerance;
}

size_t ylm_surface_map_sheet(const ylm_surface_map *m, size_t sheet, bool *back) {
  *back = m->sheet[sheet].back;
  return m->sheet[sheet].mesh;
}

void ylm_surface_map_irradiance(const ylm_surface_map *m, size_t n, const ylm_scene_place *place,
                                float (*out)[3], uint32_t *chart) {
  for (size_t i = 0; i < n; i++) {
    map_tap tap;
    for (size_t c = 0; c < 3; c++) out[i][c] = 0;
    if (chart) chart[i] = ylm__map_chart(m, &place[i]);
    if (!ylm__map_tap(m, &place[i], &tap)) continue;
    for (size_t k = 0; k < 4; k++)
      for (size_t c = 0; c < 3; c++)
        out[i][c] += tap.weight[k] * m->picture[3 * (size_t)tap.texel[k] + c];
  }
}

ylm_status ylm_surface_map_draw(const ylm_surface_map *m, const ylm_radiosity *r, size_t n,
                                uint64_t seed, ylm_scene_place *place, size_t *drawn) {
  return ylm__surface_draw(&m->plane, r, n, seed, place, drawn);
}
