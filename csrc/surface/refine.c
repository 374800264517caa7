/*
** refine.c - rounds of fits and halves, until fresh places keep the tolerance.
**
** The square of a rectangle's error is the product of what its places miss by two halves of their rays: their noise is
** independent, so it cancels. Fresh places that do not keep the tolerance become places of their rectangles.
*/
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "surface.h"
#include "ylm_grid.h"

/* -- errors ------------------------------------------------------------------------------------ */

/* The mean square of a leaf's error, without noise. */
static double square_of(const surface_bake *b, const surface_leaf *l) {
  double sum[3] = {0, 0, 0}, n = 0;
  for (size_t i = l->first; i < l->first + l->sampled; i++) {
    const surface_site *s = &b->site[b->entry[i].site];
    const surface_light *x = &b->light[s->light];
    double E[3];
    float value[3];
    if (s->known != SITE_OPEN) continue;
    n++;
    ylm__surface_mid(x, E);
    ylm__surface_value(b, s, value);
    for (int c = 0; c < 3; c++) {
      double m = ylm__surface_scale(b, E[c], c);
      if (!(m > 0)) continue;
      sum[c] +=
          ((double)value[c] - (double)x->a[c]) * ((double)value[c] - (double)x->b[c]) / (m * m);
    }
  }
  double most = n > 0 ? fmax(sum[0], fmax(sum[1], sum[2])) / n : 0;
  return most * (n > FREEDOM + 1 ? n / (n - FREEDOM) : 2);
}

static ylm_status measure(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  surface_bake *b = context;
  for (size_t i = begin; i < end; i++)
    if (b->leaf[i].sampled) b->leaf[i].square = square_of(b, &b->leaf[i]);
  return YLM_OK;
}

/* The part of the surface that is expected to fail, errors being normal in a leaf. */
static double expected(const surface_bake *b) {
  double failing = 0, all = 0;
  for (size_t i = 0; i < b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i];
    if (!l->sampled) continue;
    all += l->weight;
    if (l->square > 0) failing += l->weight * erfc(b->aim / sqrt(2 * l->square));
  }
  return all > 0 ? failing / all : 0;
}

/* -- halves ------------------------------------------------------------------------------------ */

typedef struct scored {
  double score;
  uint32_t leaf;
} scored;

static int by_score(const void *a, const void *b) {
  const scored *x = a, *y = b;
  if (x->score != y->score) return x->score > y->score ? -1 : 1;
  return x->leaf < y->leaf ? -1 : x->leaf > y->leaf;
}

/* Halves the leaves whose error by area is largest; how many. */
static ylm_status halve_worst(surface_bake *b, size_t *halved) {
  scored *list = ylm_alloc(b->leaves, sizeof *list);
  size_t n = 0, filled = 0;
  double tau = b->aim * b->aim;
  *halved = 0;
  if (!list) return YLM_ENOMEM;
  for (uint32_t i = 0; i < b->leaves; i++) {
    const surface_leaf *l = &b->leaf[i];
    filled += l->sampled > 0;
    if (l->stuck || !l->sampled || l->n < PLACES_LEAST || l->square < 0.02 * tau) continue;
    list[n++] = (scored){l->weight * l->square / (l->square + tau), i};
  }
  qsort(list, n, sizeof *list, by_score);
  size_t most = 1 + (size_t)(ROUND_SPLIT * (double)filled);
  ylm_status s = YLM_OK;
  for (size_t i = 0; s == YLM_OK && i < n && i < most; i++) {
    bool done;
    if (list[i].score < SCORE_LEAST * list[0].score) break;
    if (b->form->corners && b->unknowns + *halved >= b->form->corners) {
      b->stats.spent = true;
      break;
    }
    s = ylm__surface_split(b, list[i].leaf, &done);
    if (s == YLM_OK && !done) b->leaf[list[i].leaf].stuck = true;
    *halved += s == YLM_OK && done;
  }
  ylm_free(list);
  return s;
}

/* Rectangles that are not too wide. */
static ylm_status begin(surface_bake *b) {
  ylm_status s = YLM_OK;
  for (uint32_t i = 0; s == YLM_OK && i < b->leaves;) {
    const surface_branch *n = &b->branch[b->leaf[i].branch];
    int widest = 0;
    for (int a = 1; a < 3; a++)
      if (ylm__surface_extent(b, n, a) > ylm__surface_extent(b, n, widest)) widest = a;
    bool wide = (double)ylm__surface_extent(b, n, widest) > WIDEST * 1.0001 * b->charts.unit;
    if (!wide || b->leaf[i].weight < WIDE_PLACES * (double)b->sites) {
      i++;
      continue;
    }
    s = ylm__surface_halve(b, i, (uint32_t)widest, NULL);
  }
  return s;
}

/* -- the judge ---------------------------------------------------------------------------------- */

/* Fresh places, and their light. */
typedef struct panel {
  uint32_t site[JUDGES];
  surface_light light[JUDGES];
  size_t n;
  uint32_t drawn[JUDGES]; /* those that are asked for now */
  surface_light got[JUDGES];
  float share[JUDGES];
  double error[JUDGES];
} panel;

/* The noise of places that leaves have, root mean square over what errors are relative to, in the worst channel. */
static double noise_of(const surface_bake *b) {
  double sum[3] = {0, 0, 0}, n = 0;
  for (size_t i = 0; i < b->leaves; i++)
    for (size_t k = b->leaf[i].first; k < b->leaf[i].first + b->leaf[i].sampled; k++) {
      const surface_light *x = &b->light[b->site[b->entry[k].site].light];
      double E[3];
      ylm__surface_mid(x, E);
      n++;
      for (int c = 0; c < 3; c++) {
        double m = ylm__surface_scale(b, E[c], c), d = 0.5 * ((double)x->a[c] - (double)x->b[c]);
        if (m > 0) sum[c] += d * d / (m * m);
      }
    }
  return n > 0 ? sqrt(fmax(sum[0], fmax(sum[1], sum[2])) / n) : 0;
}

/* Rays of each half of a place that judges. */
static int judge_rays(const surface_bake *b) {
  double more = noise_of(b) / (JUDGE_NOISE * b->aim);
  double rays = (double)b->links * more * more;
  return 4 * (int)ceil(fmin(JUDGE_MOST, fmax(JUDGE_LEAST, rays)) / 4);
}

/* Places of a look: many leaves hide what few places would not find. */
static size_t places_of(const surface_bake *b) {
  size_t n = (size_t)(JUDGES_EACH * (double)b->leaves);
  return n < JUDGES_FEW ? JUDGES_FEW : n < JUDGES ? n : JUDGES;
}

/* Draws n places that are kept for it; how many there are. */
static size_t draw_sites(const surface_bake *b, size_t n, ylm_rng *rng, panel *p) {
  size_t drawn = 0;
  for (size_t tries = 0; b->sites && tries < 8 * JUDGES_SHARE * n && drawn < n; tries++) {
    size_t i = (size_t)(ylm_rng_double(rng) * (double)b->spread);
    if (site_judges(b, i) && b->site[i].light == SURFACE_NONE && b->site[i].known < SITE_COVERED)
      p->drawn[drawn++] = (uint32_t)i;
  }
  return drawn;
}

/* Fresh places that are not buried, `most` where there are so many. */
static ylm_status draw(surface_bake *b, uint64_t round, size_t most, panel *p) {
  ylm_rng rng;
  ylm_rng_seed(&rng, b->form->light.seed, 0x10000 + round);
  ylm_status s = YLM_OK;
  size_t n = 1;
  int rays = judge_rays(b);
  p->n = 0;
  for (int tries = 0; s == YLM_OK && n > 0 && tries < 8 && p->n < most; tries++) {
    n = draw_sites(b, most - p->n, &rng, p);
    s = ylm__surface_ask(b, n, p->drawn, rays, p->got, p->share);
    if (s == YLM_OK) s = ylm__surface_know(b, n, p->drawn, p->share);
    for (size_t i = 0; s == YLM_OK && i < n; i++) {
      bool open = b->site[p->drawn[i]].known == SITE_OPEN;
      p->site[p->n] = p->drawn[i];
      p->light[p->n] = p->got[i];
      p->n += open;
    }
  }
  return s;
}

static int upwards(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

/* The error that all but 1 % of the surface keep, but for a chance of 1 %; of places whose errors ascend. */
static double error_of(const panel *p) {
  int failures = ylm_grid_allowed(p->n);
  if (p->n == 0) return 0;
  return failures < 0 ? INFINITY : p->error[p->n - 1 - (size_t)failures];
}

/* Compares the places with the fit. */
static void compare(surface_bake *b, panel *p) {
  double square = 0, mean = 0;
  size_t failed = 0;
  for (size_t i = 0; i < p->n; i++) {
    double E[3];
    float value[3];
    ylm__surface_mid(&p->light[i], E);
    ylm__surface_value(b, &b->site[p->site[i]], value);
    p->error[i] = 0;
    for (int c = 0; c < 3; c++) {
      double m = ylm__surface_scale(b, E[c], c);
      if (m > 0) p->error[i] = fmax(p->error[i], fabs((double)value[c] - E[c]) / m);
    }
    failed += p->error[i] > b->aim;
    square += ((double)value[1] - (double)p->light[i].a[1]) *
              ((double)value[1] - (double)p->light[i].b[1]);
    mean += E[1];
  }
  qsort(p->error, p->n, sizeof *p->error, upwards);
  double n = p->n ? (double)p->n : 1;
  b->stats.verified = p->n;
  b->stats.failed = failed;
  b->stats.error = error_of(p);
  b->stats.rms = mean > 0 ? sqrt(fmax(0, square / n)) / (mean / n) : 0;
  b->stats.met = b->stats.error <= b->aim;
}

/* Whether so few of the places fail that refinement ends. */
static bool is_enough(const surface_bake *b) {
  double failed = (double)b->stats.failed, n = (double)b->stats.verified;
  if (b->aim < b->form->tolerance) return failed <= ENOUGH * n; /* another judge follows */
  return n == 0 || (b->stats.met && failed <= ENOUGH_SURE * n);
}

/* The places of a panel become places of their leaves. */
static ylm_status join(surface_bake *b, const panel *p) {
  ylm_status s = ylm__surface_keep(b, p->n, p->site, p->light); /* one may be drawn twice */
  if (s != YLM_OK) return s;
  for (size_t k = 0; k < b->leaves; k++) {
    surface_leaf *l = &b->leaf[k];
    for (size_t i = l->first + l->sampled; i < l->first + l->n; i++)
      if (b->site[b->entry[i].site].light != SURFACE_NONE &&
          b->site[b->entry[i].site].known != SITE_BURIED)
        ylm__surface_take(l, b->entry, i);
  }
  return YLM_OK;
}

/* -- rounds -------------------------------------------------------------------------------------- */

/* Asks for light and fits it; `part`: cuts leaves that are new. */
static ylm_status fit(surface_bake *b, bool part) {
  ylm_status s = ylm__surface_sample(b);
  if (s == YLM_OK) ylm__surface_mean(b);
  if (s == YLM_OK && part) s = ylm__surface_part(b);
  if (s == YLM_OK && part) s = ylm__surface_sample(b);
  if (s == YLM_OK) s = ylm__surface_corners(b);
  if (s == YLM_OK) s = ylm__surface_fit(b);
  if (s == YLM_OK) s = ylm_parallel(b->leaves, 16, b->form->light.threads, measure, b, NULL, NULL);
  b->stats.rounds++;
  return s;
}

/* Takes more rays a place where the noise of those that there are would keep the fit from its aim. */
static ylm_status quieten(surface_bake *b) {
  double more = noise_of(b) / (FIT_NOISE * b->aim);
  if (!(more > 1)) return YLM_OK;
  b->links = 4 * (int)ceil(fmin(FIT_MOST, more * more) * (double)b->links / 4);
  if (b->links > YLM_TRANSFER_LINKS) b->links = YLM_TRANSFER_LINKS;
  ylm_status s = ylm__surface_renew(b);
  return s == YLM_OK ? fit(b, false) : s;
}

static ylm_status refine(surface_bake *b, panel *p) {
  size_t judged = 0, judges = 0, fewest = SIZE_MAX, idle = 0;
  ylm_status s = begin(b);
  for (uint64_t round = 1; s == YLM_OK && round <= ROUNDS; round++) {
    char stage[32];
    size_t halved = 0;
    snprintf(stage, sizeof stage, "surfaces, round %d", (int)round);
    s = ylm_report(b->form->light.progress, round - 1, ROUNDS, stage);
    if (s == YLM_OK) s = fit(b, true);
    if (s == YLM_OK && round == 1) s = quieten(b);
    if (s != YLM_OK) break;
    double hope = expected(b);
    if (hope < HOPE || (double)b->unknowns > GROWN * (double)judged) {
      s = draw(b, judges++, places_of(b), p);
      judged = b->unknowns;
      if (s == YLM_OK) compare(b, p);
      if (s != YLM_OK || is_enough(b)) break;
      idle = b->stats.failed < fewest ? 0 : idle + 1;
      if (b->stats.failed < fewest) fewest = b->stats.failed;
      if (idle == JUDGED_IDLE || judges == JUDGED_MOST) break;
      s = join(b, p);
      if (s == YLM_OK)
        s = ylm_parallel(b->leaves, 16, b->form->light.threads, measure, b, NULL, NULL);
    }
    if (s == YLM_OK) s = ylm__surface_denser(b, round);
    if (s == YLM_OK) s = halve_worst(b, &halved);
    if (!halved) break;
  }
  if (s == YLM_OK && judged != b->unknowns) {
    s = draw(b, judges, places_of(b), p);
    if (s == YLM_OK) compare(b, p);
  }
  return s;
}

/* Light on the rectangles of another grid. */
static ylm_status refit(surface_bake *b, panel *p) {
  ylm_scene_prints prints;
  ylm_scene_print(b->scene, &prints);
  if (prints.geometry != b->form->like->stats.prints.geometry)
    return ylm_fail(b->e, YLM_EINVAL, "the rectangles are of other meshes");
  ylm_status s = ylm__surface_grow(b, b->form->like);
  for (uint64_t round = 0; s == YLM_OK && round < REFITS; round++) {
    if (round > 0) s = join(b, p);
    if (s == YLM_OK) s = ylm_report(b->form->light.progress, round, REFITS, "surfaces");
    if (s == YLM_OK) s = fit(b, false);
    if (s == YLM_OK && round == 0) s = quieten(b);
    if (s == YLM_OK) s = draw(b, round, JUDGES_FEW, p);
    if (s == YLM_OK) compare(b, p);
    if (s == YLM_OK && is_enough(b)) break;
  }
  return s;
}

static ylm_status check(const ylm_surface_form *f, ylm_error *e) {
  if (!(f->tolerance > 0) || !isfinite(f->tolerance))
    return ylm_fail(e, YLM_ERANGE, "tolerance must be above 0, got %g", f->tolerance);
  if (!(f->aim >= 0 && f->aim <= 1))
    return ylm_fail(e, YLM_ERANGE, "aim must be from 0 to 1, got %g", f->aim);
  if (f->light.links < 4 || f->light.links > YLM_TRANSFER_LINKS)
    return ylm_fail(e, YLM_ERANGE, "links must be from 4 to %d, got %d", YLM_TRANSFER_LINKS,
                    f->light.links);
  if (f->light.scene && (f->light.light_samples < 1 || f->light.light_samples > YLM_TRANSFER_LINKS))
    return ylm_fail(e, YLM_ERANGE, "light_samples must be from 1 to %d", YLM_TRANSFER_LINKS);
  return YLM_OK;
}

/* Notes the quantity and the prints of the light. */
static void describe(surface_bake *b) {
  const ylm_scene *lit = b->form->lit ? b->form->lit : b->scene;
  b->stats.tolerance = b->form->tolerance;
  b->stats.quantity = b->form->quantity;
  ylm_scene_print(lit, &b->stats.prints);
  b->stats.prints.lights = ylm_scene_print_lights(lit);
}

static void free_bake(surface_bake *b) {
  ylm__surface_charts_free(&b->charts);
  ylm_free(b->site);
  ylm_free(b->light);
  ylm_free(b->entry);
  ylm_free(b->branch);
  ylm_free(b->root);
  ylm_free(b->leaf);
  ylm_free(b->class);
}

ylm_status ylm_surface_bake(const ylm_radiosity *r, const ylm_surface_form *form,
                            ylm_surface_grid **out, ylm_error *e) {
  double start = ylm_seconds();
  surface_bake b = {
      .r = r, .form = form, .e = e, .aim = form->tolerance * (form->aim > 0 ? form->aim : 1)};
  *out = NULL;
  ylm_status s = check(form, e);
  if (s != YLM_OK) return s;
  b.links = form->light.links;
  b.scene = ylm_transfer_scene(ylm_radiosity_transfer(r));
  describe(&b);
  panel *p = ylm_alloc(1, sizeof *p);
  s = p ? ylm__surface_charts(b.scene, &b.charts, e) : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__surface_sites(&b);
  if (s == YLM_OK) s = form->like ? refit(&b, p) : refine(&b, p);
  b.stats.places = b.lights;
  b.stats.seconds = ylm_seconds() - start;
  if (s == YLM_OK) s = ylm__surface_compact(&b, out);
  free_bake(&b);
  ylm_free(p);
  return s;
}
