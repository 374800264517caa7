/*
** profile.c - spheres at the directions of a rule: the rings of the rule, the caps that spheres are, the choice of kernels.
**
** A sphere is a cap, whose rim is a smooth step, from 0 inside to 1 outside. The step is SHADOW_STEP distances of directions
** wide. A step about the rim of a lone sphere would hide too much, since a ring outside is longer than one inside. The
** cap is therefore narrower, and where it is smaller than the step fainter, so that it hides as much as the sphere.
*/
#include "shadow.h"

#include <math.h>
#include <stdlib.h>

#include "ylm_sets.h"

#define PAD 16 /* rings begin at a multiple of it */

YLM_KERNEL_CHOICE(shadow_profile_fn, ylm__shadow_profile, ylm_k_shadow_profile, NULL);

/* -- rings ------------------------------------------------------------------------------------- */

typedef struct direction {
  double x, y, z, angle;
  uint32_t node;
} direction;

static int by_ring(const void *a, const void *b) {
  const direction *p = a, *q = b;
  if (p->z != q->z) return p->z < q->z ? -1 : 1;
  if (p->angle != q->angle) return p->angle < q->angle ? -1 : 1;
  return p->node < q->node ? -1 : p->node > q->node;
}

void ylm__shadow_rings_free(shadow_rings *r) {
  ylm_free(r->z);
  ylm_free(r->first);
  ylm_free(r->node);
  ylm_free(r->at);
  ylm_free(r->at_f);
}

/* Numbers at directions in order, PAD to a multiple; r->at is there on the second pass. */
static void lay_out(const direction *d, size_t n, shadow_rings *r) {
  size_t to = 0;
  r->n = 0;
  for (size_t i = 0; i < n; r->n++) {
    size_t from = i, begin = to;
    for (; i < n && d[i].z == d[from].z; i++, to++) {
      if (!r->at) continue;
      double at[3] = {d[i].x, d[i].y, d[i].z};
      r->node[to] = d[i].node;
      for (size_t a = 0; a < 3; a++)
        r->at_f[a * r->padded + to] = (float)(r->at[a * r->padded + to] = at[a]);
    }
    to = (to + PAD - 1) / PAD * PAD;
    if (!r->at) continue;
    r->z[r->n] = d[from].z;
    r->first[2 * r->n] = begin;
    r->first[2 * r->n + 1] = i - from;
    if (!r->around || i - from < r->around) r->around = i - from;
  }
  r->padded = to;
}

ylm_status ylm__shadow_rings_create(const ylm_sh_nodes *nodes, shadow_rings *r) {
  size_t n = ylm_sh_nodes_count(nodes);
  const double *at = ylm_sh_nodes_directions(nodes);
  direction *d = ylm_alloc(n, sizeof *d);
  if (!d) return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    const double *p = at + 3 * i;
    d[i] = (direction){p[0], p[1], p[2] + 0.0, atan2(p[1], p[0]), (uint32_t)i};
  }
  qsort(d, n, sizeof *d, by_ring);
  *r = (shadow_rings){.n = 0};
  lay_out(d, n, r);
  r->z = ylm_alloc(r->n, sizeof *r->z);
  r->first = ylm_alloc(2 * r->n, sizeof *r->first);
  r->node = ylm_alloc_zero(r->padded, sizeof *r->node);
  r->at_f = ylm_alloc_zero(3 * r->padded, sizeof *r->at_f);
  r->at = ylm_alloc_zero(3 * r->padded, sizeof *r->at);
  bool ok = r->z && r->first && r->node && r->at && r->at_f;
  if (ok) lay_out(d, n, r);
  ylm_free(d);
  return ok ? YLM_OK : YLM_ENOMEM;
}

/* -- caps -------------------------------------------------------------------------------------- */

shadow_blur ylm__shadow_blur(int degree, bool lone) {
  double step = (lone ? SHADOW_STEP_LONE : SHADOW_STEP) * YLM_PI / (degree + 1), h = step / 2;
  double mean = h < 1e-3 ? 1 - h * h / 10 : 3 * (sin(h) - h * cos(h)) / (h * h * h);
  return (shadow_blur){.step = step, .half_cosine = cos(h), .half_sine = sin(h), .mean = mean};
}

void ylm__shadow_cap_of(const shadow_blur *b, const shadow_seen *s, const shadow_part *x, bool lone,
                        shadow_cap *c) {
  double sine = s->sine < 1 ? s->sine : 1, cosine = sqrt(1 - sine * sine);
  double ratio = 1, deep = 1, fade = 0; /* d c/d angle, and d deep/d angle */
  c->cosine = cosine;
  c->sine = sine;
  if (lone && cosine > b->half_cosine * b->mean) {
    c->cosine = b->half_cosine;
    c->sine = b->half_sine;
    double area = 1 - b->half_cosine * b->mean, own = sine * sine / (1 + cosine);
    deep = own / area;
    fade = sine / area;
    ratio = 0;
  } else if (lone) {
    c->cosine = cosine / b->mean;
    c->sine = sqrt(1 - c->cosine * c->cosine);
    ratio = sine / (b->mean * c->sine);
  }
  /* cos(angle + step/2); a cap and a step that reach around everything have no limit */
  c->limit = c->cosine * b->half_cosine - c->sine * b->half_sine;
  if (c->sine * b->half_cosine + c->cosine * b->half_sine <= 0 || b->step > 1.2) c->limit = -2;
  double beyond = sqrt(fmax(0, 1 - c->limit * c->limit)),
         flat = sqrt(fmax(0, 1 - s->w[2] * s->w[2]));
  bool all = c->limit <= 0; /* half a sphere or more */
  c->low = all || -s->w[2] > c->limit ? -2 : s->w[2] * c->limit - flat * beyond - 1e-9;
  c->high = all || s->w[2] > c->limit ? 2 : s->w[2] * c->limit + flat * beyond + 1e-9;
  c->azimuth = (double)atan2f((float)s->w[1], (float)s->w[0]);
  c->reach = all || beyond >= flat ? 2 : beyond / flat;
  c->step = b->step;
  c->deep = x->weight * deep;
  c->over = 1 / s->distance;
  double tangent = cosine > 0 ? sine / cosine : 0;
  c->turn = tangent * ratio;
  for (int a = 0; a < 3; a++) {
    c->w[a] = s->w[a];
    c->fade[a] = x->slope[a] * deep + x->weight * fade * tangent * s->w[a] * c->over;
  }
}
