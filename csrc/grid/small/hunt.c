/* hunt.c - the step of rounding that a tolerance or a number of bytes asks for. */
#include "small.h"

#include <math.h>

#define LEAST_STEP 1e-7
#define MOST_STEP 1.0
#define CLOSE 0.985    /* of a tolerance or a number of bytes: no more is searched for */
#define PER_STEP 0.416 /* of rounding's 99 %: times the root of the row's width */
#define STEEP 0.6      /* bytes fall as step^-STEEP, until two sizes say how they do */
#define AIM 0.993      /* of the bytes that are asked for */

static double wanted(const small_hunt *h) {
  return h->how->bytes ? (double)h->how->bytes : h->how->tolerance;
}

/* The grid's own error, or what stands for one that is not known. */
static double own_error(const small_hunt *h, double unknown) {
  return isnan(h->before) ? unknown : h->before;
}

double ylm__small_next_step(const small_hunt *h, double step, double found) {
  double ratio = found / wanted(h), before = own_error(h, 0) / wanted(h);
  if (h->how->bytes) return step * pow(ratio / AIM, 1 / (h->steep > 0 ? h->steep : STEEP));
  if (!h->judged) return ratio > before ? step * (1 - before) / (ratio - before) * 0.995 : 2 * step;
  double squares = ratio * ratio - before * before;
  return squares > 0 ? step * sqrt((1 - before * before) / squares) * 0.995 : 2 * step;
}

static double first_step(const small_hunt *h) {
  double before = own_error(h, 0), t = h->how->tolerance;
  if (h->how->bytes) return fmax(1e-4, 0.3 * own_error(h, 0.01));
  double part = h->judged ? sqrt(fmax(t * t - before * before, 1e-4 * t * t))
                          : fmax(t - before, 0.01 * t) / 1.3;
  return part / (PER_STEP * sqrt((double)h->width));
}

static ylm_status try_step(small_hunt *h, double *step, double *ratio) {
  *step = fmin(fmax(*step, LEAST_STEP), MOST_STEP);
  ylm_status s = h->round(h->self, *step, ratio);
  *ratio /= wanted(h);
  return s;
}

/* Brackets the step between one that is too fine, or fine enough, and one that is coarser; then narrows this. */
ylm_status ylm__small_hunt(small_hunt *h, double *found) {
  double fine = 0, coarse = INFINITY, step = first_step(h), last_step = 0, last_ratio = 1;
  int tries = h->tries ? h->tries : SMALL_TRIES;
  for (int i = 0; i < tries; i++) {
    double r;
    ylm_status s = try_step(h, &step, &r);
    if (s != YLM_OK) return s;
    if (last_step > 0) h->steep = fmin(fmax(log(r / last_ratio) / log(last_step / step), 0.15), 2);
    last_step = step;
    last_ratio = r;
    bool is_fine = h->how->bytes ? r > 1 : r <= 1;
    if (is_fine)
      fine = fmax(fine, step);
    else
      coarse = fmin(coarse, step);
    *found = step;
    if (r <= 1 && r > CLOSE) return YLM_OK;
    if (step >= (is_fine ? MOST_STEP : INFINITY) || step <= (is_fine ? 0 : LEAST_STEP)) break;
    double next = ylm__small_next_step(h, step, r * wanted(h));
    if (!(next > fine * 1.0005 && next < coarse * 0.9995))
      next = fine > 0 && coarse < INFINITY ? sqrt(fine * coarse) : fine > 0 ? 2 * step : step / 4;
    step = next;
  }
  double best = h->how->bytes ? coarse : fine, r = 1;
  if (!(best > 0 && best < INFINITY)) return YLM_ELIMIT;
  *found = best;
  ylm_status s = last_step == best ? YLM_OK : try_step(h, found, &r);
  return s == YLM_OK && r > 1 ? YLM_ELIMIT : s;
}
