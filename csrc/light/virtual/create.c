/* create.c - virtual lights: checked, copied, counted, given away. */
#include <string.h>

#include "virtual.h"

static const char *const names[] = {
#define X(name, text) text,
    YLM_LIGHT_VIRTUAL_PROFILES(X)
#undef X
};

const char *ylm_light_virtual_profile_name(ylm_light_virtual_profile profile) {
  return (size_t)profile < sizeof names / sizeof *names ? names[profile] : "?";
}

ylm_light_virtual_profile ylm_light_virtual_profile_of(const char *name) {
  int i = 0;
  while (i < YLM_LIGHT_VIRTUAL_PROFILE_COUNT && strcmp(names[i], name)) i++;
  return (ylm_light_virtual_profile)i;
}

/* -- checks --------------------------------------------------------------------------------- */

static bool is_split(ylm_light_virtual_profile p) {
  return p == YLM_LIGHT_VIRTUAL_FAR || p == YLM_LIGHT_VIRTUAL_NEAR;
}

/* Of light i, counted from 0. */
static ylm_status check_place(const ylm_light_virtual_form *f, size_t i, ylm_error *e) {
  for (size_t a = 0; a < 3; a++)
    if (!(fabs(f->at[3 * i + a]) <= YLM_LIGHT_EXTENT))
      return ylm_fail(e, YLM_ERANGE, "light %zu: its place is not finite, or beyond %g", i + 1,
                      YLM_LIGHT_EXTENT);
  return YLM_OK;
}

static ylm_status check_radius(const ylm_light_virtual_form *f, size_t i, ylm_error *e) {
  double r = f->radius ? f->radius[i] : 0;
  const char *profile = ylm_light_virtual_profile_name(f->profile);
  if (!(r >= 0 && r <= YLM_LIGHT_EXTENT))
    return ylm_fail(e, YLM_EDOMAIN, "light %zu: radius must be 0 to %g, got %g", i + 1,
                    YLM_LIGHT_EXTENT, r);
  if (r == 0 && f->profile != YLM_LIGHT_VIRTUAL_POINT)
    return ylm_fail(e, YLM_EDOMAIN,
                    "light %zu: radius must be above 0 for profile '%s'; profile 'point' has none",
                    i + 1, profile);
  if (is_split(f->profile) && !(f->core > r))
    return ylm_fail(e, YLM_EDOMAIN, "light %zu: core must be above the radius: core %g, radius %g",
                    i + 1, f->core, r);
  return YLM_OK;
}

static ylm_status check_shift(const ylm_light_virtual_form *f, size_t i, ylm_error *e) {
  if (!f->shift || (f->shift[i] >= 0 && f->shift[i] <= 1)) return YLM_OK;
  return ylm_fail(e, YLM_EDOMAIN, "light %zu: shift must be 0 to 1, got %g", i + 1, f->shift[i]);
}

/* Copies a normal, which comes to have length 1 unless it is 0. */
static ylm_status settle_normal(const double from[3], size_t i, double to[3], ylm_error *e) {
  double length = sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
  memcpy(to, from, 3 * sizeof *to);
  if (length == 0) return YLM_OK;
  if (!(length >= 1 - 1e-3 && length <= 1 + 1e-3))
    return ylm_fail(
        e, YLM_EDOMAIN,
        "light %zu: its normal must have length 1, or be 0 for light all around; it has "
        "length %g",
        i + 1, length);
  for (int a = 0; a < 3; a++) to[a] = from[a] / length;
  return YLM_OK;
}

static ylm_status check_form(const ylm_light_virtual_form *f, ylm_error *e) {
  if (f->n > YLM_LIGHT_VIRTUAL_MOST)
    return ylm_fail(e, YLM_ERANGE, "%zu lights are more than %lu", f->n, YLM_LIGHT_VIRTUAL_MOST);
  if (f->degree < 0 || f->degree > YLM_LIGHT_VIRTUAL_DEGREE)
    return ylm_fail(e, YLM_ERANGE, "the emission's degree must be 0 to %d, got %d",
                    YLM_LIGHT_VIRTUAL_DEGREE, f->degree);
  if ((unsigned)f->profile >= YLM_LIGHT_VIRTUAL_PROFILE_COUNT)
    return ylm_fail(e, YLM_EINVAL, "there is no profile %d", (int)f->profile);
  if (is_split(f->profile) && !(f->core > 0 && f->core <= YLM_LIGHT_EXTENT))
    return ylm_fail(e, YLM_EDOMAIN, "core of profile '%s' must be above 0 and at most %g, got %g",
                    ylm_light_virtual_profile_name(f->profile), YLM_LIGHT_EXTENT, f->core);
  return YLM_OK;
}

static ylm_status settle(const ylm_light_virtual_form *f, ylm_light_virtual *v, ylm_error *e) {
  size_t wide = 3 * YLM_LIGHT_VIRTUAL_NUMBERS(f->degree), where;
  ylm_status s = YLM_OK;
  for (size_t i = 0; i < f->n && s == YLM_OK; i++) {
    s = check_place(f, i, e);
    if (s == YLM_OK) s = check_radius(f, i, e);
    if (s == YLM_OK) s = check_shift(f, i, e);
    if (s == YLM_OK && f->normal) s = settle_normal(f->normal + 3 * i, i, v->normal + 3 * i, e);
  }
  if (s == YLM_OK && f->n && !ylm_all_finite(YLM_DOUBLE, f->emission, f->n * wide, &where))
    s = ylm_fail(e, YLM_EDOMAIN, "light %zu: its emission is not finite", where / wide + 1);
  return s;
}

/* -- lights --------------------------------------------------------------------------------- */

static size_t numbers_of(size_t n, int degree) {
  return n * (8 + 3 * YLM_LIGHT_VIRTUAL_NUMBERS(degree));
}

static ylm_status evaluate(const ylm_field *f, const ylm_field_query *q, size_t n,
                           const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm_light_virtual_evaluate(f->self, ylm_isa_current(), q, n, points, r, e);
}

/* Lights of profile cap have a kink at their radius, and jump at their place. */
static ylm_status crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_light_virtual *v = f->self;
  memset(out, 0, n);
  if (v->profile != YLM_LIGHT_VIRTUAL_CAP && v->profile != YLM_LIGHT_VIRTUAL_POINT) return YLM_OK;
  for (size_t k = 0; k < n; k++)
    for (size_t i = 0; i < v->n && !out[k]; i++) {
      const double *p = v->at + 3 * i, *box = boxes + 6 * k;
      out[k] = p[0] >= box[0] && p[0] <= box[3] && p[1] >= box[1] && p[1] <= box[4] &&
               p[2] >= box[2] && p[2] <= box[5];
    }
  return YLM_OK;
}

ylm_status ylm_light_virtual_create(const ylm_light_virtual_form *f, ylm_light_virtual **lights,
                                    ylm_error *e) {
  *lights = NULL;
  ylm_status s = check_form(f, e);
  if (s != YLM_OK) return s;
  ylm_light_virtual *v = ylm_alloc_zero(1, sizeof *v);
  double *x = ylm_alloc_zero(numbers_of(f->n, f->degree) + 1, sizeof *x);
  if (!v || !x) {
    ylm_free(v);
    ylm_free(x);
    return ylm_no_memory(e);
  }
  *v = (ylm_light_virtual){
      .field = {.self = v, .evaluate = evaluate, .crosses = crosses, .relative = true},
      .users = 1,
      .n = f->n,
      .degree = f->degree,
      .profile = f->profile,
      .core = is_split(f->profile) ? f->core : 0,
      .at = x,
      .normal = x + 3 * f->n,
      .radius = x + 6 * f->n,
      .shift = x + 7 * f->n,
      .emission = x + 8 * f->n};
  s = settle(f, v, e);
  if (s != YLM_OK) {
    ylm_light_virtual_free(v);
    return s;
  }
  if (f->n) {
    memcpy(v->at, f->at, 3 * f->n * sizeof *x);
    if (f->profile != YLM_LIGHT_VIRTUAL_POINT) memcpy(v->radius, f->radius, f->n * sizeof *x);
    if (f->shift) memcpy(v->shift, f->shift, f->n * sizeof *x);
    memcpy(v->emission, f->emission, 3 * f->n * YLM_LIGHT_VIRTUAL_NUMBERS(f->degree) * sizeof *x);
  }
  s = ylm__virtual_settle(v);
  if (s == YLM_OK) {
    *lights = v;
    return s;
  }
  ylm_light_virtual_free(v);
  return ylm_fail_plain(e, s);
}

void ylm_light_virtual_free(ylm_light_virtual *v) {
  if (!v || --v->users > 0) return;
  if (v->local != v->at) ylm_free(v->local);
  ylm_free(v->at);
  ylm_free(v->seen);
  ylm__virtual_tree_free(v->tree);
  ylm_free(v);
}

size_t ylm_light_virtual_count(const ylm_light_virtual *v) { return v->n; }

size_t ylm_light_virtual_bytes(const ylm_light_virtual *v) {
  return sizeof *v + numbers_of(v->n, v->degree) * sizeof *v->at +
         v->n * v->stride * sizeof *v->seen;
}

void ylm_light_virtual_get(const ylm_light_virtual *v, ylm_light_virtual_form *f) {
  *f = (ylm_light_virtual_form){.n = v->n,
                                .at = v->at,
                                .normal = v->normal,
                                .radius = v->radius,
                                .shift = v->shift,
                                .degree = v->degree,
                                .emission = v->emission,
                                .profile = v->profile,
                                .core = v->core};
}

const ylm_field *ylm_light_virtual_field(const ylm_light_virtual *v) { return &v->field; }

/* -- sets ----------------------------------------------------------------------------------- */

static void release(void *of) { ylm_light_virtual_free(of); }

static ylm_status evaluate_pack(const void *of, ylm_isa isa, const ylm_field_query *q, size_t n,
                                const void *points, ylm_field_result *r, ylm_error *e) {
  return ylm_light_virtual_evaluate(of, isa, q, n, points, r, e);
}

const ylm__light_kind ylm__virtual_kind = {.name = "virtual",
                                           .free = release,
                                           .evaluate = evaluate_pack,
                                           .within = ylm__virtual_within,
                                           .within_free = ylm__virtual_within_free,
                                           .within_evaluate = ylm__virtual_within_evaluate,
                                           .within_bytes = ylm__virtual_within_bytes};

ylm_status ylm_light_set_virtual(ylm_light_virtual *v, ylm_light_set **set, ylm_error *e) {
  *set = NULL;
  v->users++;
  return ylm__light_set_of_pack(
      &(ylm__light_pack){.kind = &ylm__virtual_kind, .of = v, .field = &v->field, .n = v->n}, set,
      e);
}

ylm_light_virtual *ylm_light_set_virtuals(const ylm_light_set *set) {
  return set->packs == 1 && set->pack[0]->kind == &ylm__virtual_kind ? set->pack[0]->of : NULL;
}

bool ylm_light_set_has_virtual(const ylm_light_set *set) {
  for (size_t i = 0; i < set->packs; i++)
    if (set->pack[i]->kind == &ylm__virtual_kind) return true;
  return false;
}

/* -- far and near --------------------------------------------------------------------------- */

ylm_status ylm_light_virtual_split(const ylm_light_virtual *v, double core, ylm_light_virtual **far,
                                   ylm_light_virtual **near, ylm_error *e) {
  ylm_light_virtual_form f;
  *far = *near = NULL;
  if (v->profile != YLM_LIGHT_VIRTUAL_GAUSS)
    return ylm_fail(e, YLM_EINVAL, "lights of profile 'gauss' are split, and these are '%s'",
                    ylm_light_virtual_profile_name(v->profile));
  ylm_light_virtual_get(v, &f);
  f.core = core;
  f.profile = YLM_LIGHT_VIRTUAL_FAR;
  ylm_status s = ylm_light_virtual_create(&f, far, e);
  f.profile = YLM_LIGHT_VIRTUAL_NEAR;
  if (s == YLM_OK) s = ylm_light_virtual_create(&f, near, e);
  if (s == YLM_OK) return s;
  ylm_light_virtual_free(*far);
  *far = NULL;
  return s;
}
