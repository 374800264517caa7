/* direct.c - light of lamps at the places where paths are reflected. */
#include "calibration.h"
#include "path.h"

void ylm__path_add(path_tile *t, float sum[3], const float x[3]) {
  if (isfinite(x[0] + x[1] + x[2]))
    for (int c = 0; c < 3; c++) sum[c] += x[c];
  else
    t->counts.lost++;
}

/* The weight of a lamp that a ray meets by chance. */
static float by_chance(const path_tile *t, uint32_t lamp, const float direction[3], float pdf) {
  if (t->job->o->strategy != YLM_PATH_BOTH) return 1;
  return ylm__path_balance(pdf, (float)ylm_scene_density(t->lamps, lamp, direction));
}

static void meet_distant(path_tile *t, const float direction[3], float pdf, float radiance[3]) {
  const ylm_scene *s = t->job->scene;
  size_t near = ylm_scene_near(s), all = ylm_scene_distant(s);
  float one[3];
  for (size_t i = ylm_scene_distant_next(s, 0, direction, one); i < all;
       i = ylm_scene_distant_next(s, i + 1, direction, one)) {
    float w = by_chance(t, (uint32_t)(near + i), direction, pdf);
    for (int c = 0; c < 3; c++) radiance[c] += w * one[c];
  }
}

/* Ray i as it looks for lamps, from the point that it brings light to: to where it meets the plane of the surface that
   it hits. */
static inline void way_of(const path_tile *t, size_t i, ylm_trace_ray *way) {
  const path_rays *r = &t->rays;
  const ylm_trace_hit *hit = &r->hit[i];
  const float *n = hit->normal, *from = r->ray[i].org, *to = r->lit[i];
  *way = r->ray[i];
  for (int a = 0; a < 3; a++) way->org[a] = to[a];
  if (hit->mesh < 0) return;
  float along = ylm_dot3(n, r->ray[i].dir);
  float apart = n[0] * (from[0] - to[0]) + n[1] * (from[1] - to[1]) + n[2] * (from[2] - to[2]);
  way->far = hit->t + (along != 0 ? apart / along : 0);
}

void ylm__path_look(path_tile *t) {
  const ylm_scene *s = t->job->scene;
  path_rays *r = &t->rays;
  float lo[3], hi[3], most;
  if (t->job->o->strategy == YLM_PATH_LIGHTS || ylm_scene_near(s) == 0) return;
  ylm_trace_bounds(t->job->trace, lo, hi);
  for (int a = 0; a < 3; a++) hi[a] = fmaxf(-lo[a], hi[a]);
  most = ylm_trace_offset(t->job->trace, hi); /* no less than ylm_scene_reach asks for at a hit */
  for (size_t i = 0; i < r->n; i++) {
    way_of(t, i, &r->way[i]);
    if (r->hit[i].mesh >= 0) r->way[i].far = (r->way[i].far + most) * (1 / (1 - 2e-5f));
  }
  ylm_trace_meets_lamps(t->job->trace, r->n, r->way);
  t->counts.lamp_rays += r->n;
}

/* Lamps along ray i that are not distant. */
static void meet_near(path_tile *t, size_t i, float pdf, float radiance[3]) {
  const ylm_scene *s = t->job->scene;
  bool open = t->rays.hit[i].mesh == YLM_TRACE_NOTHING;
  ylm_trace_ray way;
  way_of(t, i, &way);
  float end = way.far;
  ylm_trace_meeting met[LAMPS_AT_ONCE];
  size_t n = LAMPS_AT_ONCE;
  if (!open) way.far = ylm_scene_reach(s, UINT32_MAX, &way, end);
  for (bool more = false; n == LAMPS_AT_ONCE; more = true) {
    n = ylm_trace_next_lamps(t->job->trace, &way, more ? &met[LAMPS_AT_ONCE - 1] : NULL,
                             LAMPS_AT_ONCE, met);
    for (size_t k = 0; k < n; k++) {
      float one[3], w;
      if (!open && !(met[k].distance < ylm_scene_reach(s, met[k].lamp, &way, end))) continue;
      if (!ylm_scene_near_radiance(s, &way, met[k].lamp, met[k].distance, one)) continue;
      w = by_chance(t, met[k].lamp, way.dir, pdf);
      for (int c = 0; c < 3; c++) radiance[c] += w * one[c];
    }
  }
}

void ylm__path_meet(path_tile *t, size_t i, float pdf, float radiance[3]) {
  const path_rays *r = &t->rays;
  memset(radiance, 0, 12);
  if (ylm_scene_near(t->job->scene) && r->way[i].far < 0) meet_near(t, i, pdf, radiance);
  if (r->hit[i].mesh == YLM_TRACE_NOTHING) meet_distant(t, r->ray[i].dir, pdf, radiance);
}

/* A ray from vertex v to a lamp; it is kept where it may bring light. */
static void aim(path_tile *t, uint32_t v, const double u[3]) {
  path_lights *l = &t->lights;
  size_t i = l->n;
  uint32_t lamp;
  double pdf = ylm_scene_sample(t->lamps, u, &l->ray[i], l->radiance[i], &lamp);
  if (!(pdf > 0)) return;
  ylm__path_inward(&t->vertex[v], l->ray[i].dir, l->wi[i]);
  memcpy(l->toward[i], l->ray[i].dir, 12);
  ylm_scene_start(&l->ray[i], t->vertex[v].at.origin);
  if (!(l->wi[i][2] > 0)) return;
  if (t->cluster[v] != PATH_UNKNOWN)
    ylm__path_density_ahead(t->job->known, t->cluster[v], l->toward[i]);
  memcpy(l->wo[i], t->wo[v], 12);
  l->density[i] = (float)pdf;
  for (int c = 0; c < 3; c++) l->radiance[i][c] = (float)((double)l->radiance[i][c] / pdf);
  l->of[i] = v;
  l->n++;
}

/* Tells the chooser of the vertices from v on. */
static void look_ahead(path_tile *t, size_t v) {
  float x[YLM_SCENE_AHEAD][3], normal[YLM_SCENE_AHEAD][3];
  size_t n = ylm__path_next(t, v, x, normal);
  ylm_scene_look_ahead(t->lamps, n, (const float(*)[3])x, (const float(*)[3])normal);
}

/* Aims at lamps from all vertices, and adds the lamps that material rays meet. */
static void gather(path_tile *t, bool first) {
  ylm_path_strategy strategy = t->job->o->strategy;
  const path_rays *r = &t->rays;
  t->lights.n = 0;
  ylm__path_look(t);
  for (uint32_t v = 0, i = 0; v < t->n; v++) {
    path_state *p = &t->path[t->vertex[v].path];
    const ylm_scene_surface *at = &t->vertex[v].at;
    if (strategy != YLM_PATH_MATERIAL) {
      double u[3];
      for (int a = 0; a < 3; a++) u[a] = first ? p->light[a] : ylm__path_random(&p->rng);
      if (v % YLM_SCENE_AHEAD == 0) look_ahead(t, v);
      if (ylm_scene_choose_ahead(t->lamps, v % YLM_SCENE_AHEAD, at->lit, at->normal)) aim(t, v, u);
    }
    if (i >= r->n || r->of[i] != v) continue;
    if (strategy != YLM_PATH_LIGHTS) {
      float x[3];
      ylm__path_meet(t, i, t->pdf[v], x);
      for (int c = 0; c < 3; c++) x[c] *= p->throughput[c] * t->weight[v][c];
      ylm__path_add(t, p->radiance, x);
    }
    i++;
  }
}

/* Asks each material of its light samples, which are in the order of vertices. */
static void reflect(path_tile *t) {
  const path_job *j = t->job;
  path_lights *l = &t->lights;
  for (size_t m = 0, i = 0, end; m < j->materials; m++, i = end) {
    for (end = i; end < l->n && l->of[end] < t->behind[m];) end++;
    if (end == i) continue;
    const float(*wi)[3] = (const float(*)[3])(l->wi + i), (*wo)[3] = (const float(*)[3])(l->wo + i);
    ylm_material_eval(j->material[m], end - i, wi, wo, l->f + i);
    if (j->o->strategy == YLM_PATH_BOTH)
      ylm_material_pdf(j->material[m], end - i, wi, wo, l->pdf + i);
  }
}

void ylm__path_direct(path_tile *t, bool first) {
  path_lights *l = &t->lights;
  bool both = t->job->o->strategy == YLM_PATH_BOTH;
  gather(t, first);
  reflect(t);
  if (!t->job->open) {
    ylm_trace_occluded(t->job->trace, l->n, l->ray);
    t->counts.shadow_rays += l->n;
  }
  for (size_t i = 0; i < l->n; i++) {
    if (l->ray[i].far < 0) continue;
    path_state *p = &t->path[t->vertex[l->of[i]].path];
    float w = l->wi[i][2], x[3];
    if (both)
      w *=
          ylm__path_balance(l->density[i], ylm__path_density(t, l->of[i], l->pdf[i], l->toward[i]));
    for (int c = 0; c < 3; c++) x[c] = w * p->throughput[c] * l->f[i][c] * l->radiance[i][c];
    ylm__path_add(t, p->radiance, x);
  }
}
