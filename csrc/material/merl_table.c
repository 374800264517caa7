/* merl_table.c - tables of MERL's bins: their memory, missing bins, the lobe to sample by. */
#include <string.h>

#include "kind.h"
#include "merl.h"

/* Bytes that a line of the cache has. */
#define LINE 64

merl_table *ylm__merl_new(int phis, size_t *held) {
  size_t bins = (size_t)MERL_THETA_H * MERL_THETA_D * (size_t)phis;
  *held = sizeof(merl_table) + LINE + bins * sizeof(merl_bin);
  merl_table *t = ylm_alloc(*held, 1);
  if (!t) return NULL;
  uintptr_t at = (uintptr_t)(t + 1);
  *t = (merl_table){.phis = phis, .bin = (merl_bin *)((at + LINE - 1) / LINE * LINE)};
  return t;
}

/* -- missing bins ----------------------------------------------------------- */

/* A missing bin holds the numbers of the nearest that is measured of smaller theta_d, or zeros. */
static void fill_missing(merl_table *t) {
  size_t phis = (size_t)t->phis;
  for (size_t row = 0; row < (size_t)MERL_THETA_H * MERL_THETA_D; row++)
    for (size_t p = 0; p < phis; p++) {
      float *bin = t->bin[row * phis + p];
      if (bin[3] != 0) continue;
      const float *below = row % MERL_THETA_D ? bin - 4 * phis : NULL;
      for (int c = 0; c < 3; c++) bin[c] = below ? below[c] : 0;
    }
}

/* -- the lobe --------------------------------------------------------------- */

static float luminance(const float *bin) {
  return (float)YLM_LUMINANCE_R * bin[0] + (float)YLM_LUMINANCE_G * bin[1] +
         (float)YLM_LUMINANCE_B * bin[2];
}

/* The angle of the centre of a bin, or of the border before it. */
static float theta_h_of(float place) {
  float root = place / MERL_THETA_H;
  return root * root * ((float)YLM_PI / 2);
}

/* The mean over phi_d of the bins around theta_d = 0. */
static float profile(const merl_table *t, int theta_h) {
  const merl_bin *row = t->bin + (size_t)theta_h * MERL_THETA_D * (size_t)t->phis;
  double sum = 0;
  for (int p = 0; p < t->phis; p++) sum += (double)luminance(row[p]);
  return (float)(sum / t->phis);
}

/* The roughness of GGX whose profile falls to a quarter where this one does: tan^2 theta = alpha^2. */
static float roughness(const merl_table *t) {
  float before = profile(t, 0), quarter = before / 4;
  for (int i = 1; i < MERL_THETA_H; i++) {
    float here = profile(t, i);
    if (here <= quarter) {
      float part = before > here ? (before - quarter) / (before - here) : 0;
      float alpha = tanf(theta_h_of((float)i - 0.5f + part));
      return alpha > 1 ? 1 : alpha < 1e-3f ? 1e-3f : alpha;
    }
    before = here;
  }
  return 1;
}

/* The part of the albedo along the normal that its least reflectance does not explain. wi is then at 2 theta_h from the
   normal, and theta_d = theta_h. */
static float gloss(const merl_table *t) {
  float albedo = 0, least = -1;
  for (int i = 0; i < MERL_THETA_H; i++) {
    float theta = theta_h_of((float)i + 0.5f);
    if (theta >= (float)YLM_PI / 4) break;
    int d = (int)(theta * (MERL_THETA_D * 2 / (float)YLM_PI));
    const float *bin = t->bin[((size_t)i * MERL_THETA_D + (size_t)d) * (size_t)t->phis];
    float f = luminance(bin), step = 2 * (theta_h_of((float)i + 1) - theta_h_of((float)i));
    albedo += (float)YLM_PI * f * sinf(4 * theta) * step;
    if (bin[3] != 0 && (least < 0 || f < least)) least = f;
  }
  return albedo > 0 && least >= 0 ? 1 - (float)YLM_PI * least / albedo : 0;
}

void ylm__merl_complete(merl_table *t) {
  fill_missing(t);
  float share = gloss(t);
  t->lobe = (lobe){roughness(t), share < 0.1f ? 0.1f : share > 0.9f ? 0.9f : share};
}

void ylm__merl_facts(const ylm_material *m, ylm_material_fact *fact, void *to) {
  const merl_table *t = m->table;
  size_t bins = (size_t)MERL_THETA_H * MERL_THETA_D * (size_t)t->phis, missing = 0;
  for (size_t i = 0; i < bins; i++) missing += t->bin[i][3] == 0;
  fact(to, "theta_h", MERL_THETA_H);
  fact(to, "theta_d", MERL_THETA_D);
  fact(to, "phi_d", t->phis);
  fact(to, "negative", (double)missing / (double)bins);
  fact(to, "lobe_alpha", (double)t->lobe.alpha);
  fact(to, "lobe_share", (double)t->lobe.share);
}
