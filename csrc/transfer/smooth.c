/*
** smooth.c - the noise of elements' direct light and of their links, averaged over neighbours that see each other.
**
** Elements that lie close together, face the same way and see one of them are a group. Their light is drawn to a plane that is fitted
** to it, as far as it strays from that by noise alone: a group keeps its mean, and shadows their edges.
**
**   Source  James & Stein 1961, "Estimation with quadratic loss" (the part that is kept)
*/
#include <math.h>

#include "calibration.h"
#include "transfer.h"

/* Groups: elements in their order, whose first one all others see; where each begins in the list, and the end. */
struct transfer_neighbours {
  size_t groups;
  uint32_t *element, *first;
};

void ylm__transfer_neighbours_free(transfer_neighbours *g) {
  if (!g) return;
  ylm_free(g->element);
  ylm_free(g->first);
  ylm_free(g);
}

/* -- groups ------------------------------------------------------------------------------ */

typedef struct parting {
  const ylm_transfer *t;
  const transfer_places *p;
  const ylm_scene_clusters *clusters;
  size_t *begin;  /* [clusters + 1] of each in the list */
  uint32_t *list; /* [places] clusters one after the other, groups one after the other in them */
  uint32_t *size; /* [places] of the group that begins there; 0: none does */
} parting;

/* Puts the places that see the first one behind it; returns their number, with it. */
static size_t seen_from(const parting *j, uint32_t *list, size_t n, ylm_trace_ray *ray) {
  const ylm_scene_places *of = &j->p->of;
  float lift = ylm__transfer_lift(j->t, j->p->element[list[0]]);
  for (size_t i = 0; i < n; i++) {
    ray[i] = (ylm_trace_ray){.far = i > 0 ? 1 : -1};
    for (int a = 0; a < 3; a++) {
      ray[i].org[a] = of->origin[list[0]][a] + lift * of->normal[list[0]][a];
      ray[i].dir[a] = of->origin[list[i]][a] + lift * of->normal[list[i]][a] - ray[i].org[a];
    }
  }
  ylm_trace_occluded(ylm_scene_trace(j->t->scene), n, ray);
  size_t seen = 1;
  for (size_t i = 1; i < n; i++) {
    if (ray[i].far < 0) continue;
    uint32_t other = list[seen];
    list[seen++] = list[i], list[i] = other;
  }
  return seen;
}

/* Puts the place that is nearest to the mean of them all before the others. */
static void middle_first(const parting *j, uint32_t *list, size_t n) {
  double mean[3] = {0, 0, 0}, least = INFINITY;
  size_t found = 0;
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) mean[a] += (double)j->p->of.lit[list[i]][a] / (double)n;
  for (size_t i = 0; i < n; i++) {
    double square = 0;
    for (int a = 0; a < 3; a++) {
      double d = (double)j->p->of.lit[list[i]][a] - mean[a];
      square += d * d;
    }
    if (square < least) least = square, found = i;
  }
  uint32_t other = list[0];
  list[0] = list[found], list[found] = other;
}

static ylm_status part(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const parting *j = context;
  ylm_trace_ray *ray = ylm_alloc(SMOOTH_MOST, sizeof *ray);
  if (!ray) return YLM_ENOMEM;
  for (size_t k = begin; k < end; k++) {
    size_t n = j->begin[k + 1] - j->begin[k], seen;
    if (n > SMOOTH_MOST) continue; /* places that are one */
    for (size_t at = j->begin[k]; n > 0; at += seen, n -= seen) {
      middle_first(j, j->list + at, n);
      seen = seen_from(j, j->list + at, n, ray);
      j->size[at] = (uint32_t)seen;
    }
  }
  ylm_free(ray);
  return YLM_OK;
}

/* Lists the groups that are large enough. */
static ylm_status list_groups(const parting *j, transfer_neighbours *g) {
  size_t n = j->p->of.n, at = 0;
  for (size_t i = 0; i < n; i++) g->groups += j->size[i] >= SMOOTH_LEAST;
  g->element = ylm_alloc(n, sizeof *g->element);
  g->first = ylm_alloc(g->groups + 1, sizeof *g->first);
  if (!g->element || !g->first) return YLM_ENOMEM;
  g->groups = 0;
  for (size_t i = 0; i < n; i++) {
    if (j->size[i] < SMOOTH_LEAST) continue;
    g->first[g->groups++] = (uint32_t)at;
    for (size_t k = 0; k < j->size[i]; k++) g->element[at++] = j->p->element[j->list[i + k]];
  }
  g->first[g->groups] = (uint32_t)at;
  return YLM_OK;
}

static ylm_status find_groups(parting *j, size_t clusters, int threads, transfer_neighbours *g) {
  size_t n = j->p->of.n, at = 0, each;
  j->begin = ylm_alloc(clusters + 1, sizeof *j->begin);
  j->list = ylm_alloc(n, sizeof *j->list);
  j->size = ylm_alloc_zero(n, sizeof *j->size);
  if (!j->begin || !j->list || !j->size) return YLM_ENOMEM;
  for (size_t k = 0; k < clusters; k++, at += each) {
    const uint32_t *of = ylm_scene_cluster_places(j->clusters, k, 1, &each);
    j->begin[k] = at;
    memcpy(j->list + at, of, each * sizeof *of);
  }
  j->begin[clusters] = at;
  ylm_status s = ylm_parallel(clusters, SMOOTH_GRAIN, threads, part, j, NULL, NULL);
  return s == YLM_OK ? list_groups(j, g) : s;
}

ylm_status ylm__transfer_neighbours_create(const ylm_transfer *t, const transfer_places *p,
                                           int threads, transfer_neighbours **out) {
  ylm_scene_clusters *clusters = NULL;
  transfer_neighbours *g = *out = ylm_alloc_zero(1, sizeof *g);
  if (!g) return YLM_ENOMEM;
  if (p->of.n == 0) return YLM_OK;
  ylm_status s = ylm_scene_clusters_create(&p->of, SMOOTH_MOST, &clusters);
  if (s == YLM_OK) {
    parting j = {.t = t, .p = p, .clusters = clusters};
    s = find_groups(&j, ylm_scene_clusters_count(clusters), threads, g);
    ylm_free(j.begin);
    ylm_free(j.list);
    ylm_free(j.size);
  }
  ylm_scene_clusters_free(clusters);
  if (s == YLM_OK) return s;
  ylm__transfer_neighbours_free(g);
  *out = NULL;
  return s;
}

/* -- their light ------------------------------------------------------------------------- */

typedef struct job {
  const ylm_transfer *t;
  const transfer_neighbours *of;
  const float *variance; /* [elements] of E0, luminance */
  float *E0, *apart;     /* light, and a sample of its noise or NULL */
} job;

/* Elements of a group: weights by area, places in a plane, and the plane that is fitted to their light. */
typedef struct group {
  size_t n;
  const uint32_t *element;    /* [n] */
  double weight[SMOOTH_MOST]; /* they add up to 1 */
  double x[SMOOTH_MOST][2];   /* from their mean */
  double mean[3], slope[3][2];
} group;

/* Weights and places of a group. */
static void lay_out(const ylm_transfer *t, group *g) {
  float axis[2][3];
  double sum = 0, mean[2] = {0, 0};
  ylm_scene_basis(t->normal[g->element[0]], axis[0], axis[1]);
  for (size_t i = 0; i < g->n; i++) {
    uint32_t e = g->element[i];
    sum += g->weight[i] = (double)t->area[e] * (double)t->share[e];
    for (int k = 0; k < 2; k++) g->x[i][k] = (double)ylm_dot3(t->centre[e], axis[k]);
  }
  for (size_t i = 0; i < g->n; i++) {
    g->weight[i] /= sum;
    for (int k = 0; k < 2; k++) mean[k] += g->weight[i] * g->x[i][k];
  }
  for (size_t i = 0; i < g->n; i++)
    for (int k = 0; k < 2; k++) g->x[i][k] -= mean[k];
}

static double plane_at(const group *g, size_t i, size_t c) {
  return g->mean[c] + g->slope[c][0] * g->x[i][0] + g->slope[c][1] * g->x[i][1];
}

/* Does the plane fall below 0? */
static bool falls(const group *g) {
  for (size_t c = 0; c < 3; c++)
    for (size_t i = 0; i < g->n; i++)
      if (!(plane_at(g, i, c) >= 0)) return true;
  return false;
}

/* Fits the plane. */
static void fit(const float *E0, group *g) {
  double xx = 0, xy = 0, yy = 0, b[3][2] = {{0}};
  memset(g->mean, 0, sizeof g->mean);
  for (size_t i = 0; i < g->n; i++) {
    const float *E = E0 + 4 * (size_t)g->element[i];
    double w = g->weight[i], x = g->x[i][0], y = g->x[i][1];
    xx += w * x * x, xy += w * x * y, yy += w * y * y;
    for (size_t c = 0; c < 3; c++) {
      g->mean[c] += w * (double)E[c];
      b[c][0] += w * x * (double)E[c], b[c][1] += w * y * (double)E[c];
    }
  }
  double det = xx * yy - xy * xy;
  bool flat = !(det > SMOOTH_FLAT * xx * yy);
  for (size_t c = 0; c < 3; c++) {
    g->slope[c][0] = flat ? 0 : (yy * b[c][0] - xy * b[c][1]) / det;
    g->slope[c][1] = flat ? 0 : (xx * b[c][1] - xy * b[c][0]) / det;
  }
}

/* The part that is kept of what strays from the plane: all where more than noise strays, as at a shadow's edge, which passes for noise
   in the elements that it crosses. */
static double kept_of(const job *j, const group *g) {
  double strayed = 0, noise = 0;
  for (size_t i = 0; i < g->n; i++) {
    const float *E = j->E0 + 4 * (size_t)g->element[i];
    double off[3];
    for (size_t c = 0; c < 3; c++) off[c] = (double)E[c] - plane_at(g, i, c);
    double y = ylm_luminance(off);
    strayed += g->weight[i] * y * y;
    noise += g->weight[i] * (double)j->variance[g->element[i]];
  }
  strayed *= (double)g->n / (double)(g->n - 3);
  double part = strayed > 0 ? fmin(1, noise / strayed) : 0;
  double sure = (part - SMOOTH_DOUBTED) / (SMOOTH_NOISE - SMOOTH_DOUBTED);
  return 1 - part * fmax(0, fmin(1, sure));
}

/* Draws light to the plane that is fitted to it. */
static void draw(const group *g, float kept, float *light) {
  for (size_t i = 0; i < g->n; i++)
    for (size_t c = 0; c < 3; c++) {
      float *E = light + 4 * (size_t)g->element[i] + c, plane = (float)plane_at(g, i, c);
      *E = plane + kept * (*E - plane);
    }
}

static ylm_status smooth(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const job *j = context;
  for (size_t k = begin; k < end; k++) {
    const uint32_t *first = j->of->first + k;
    group g = {.n = first[1] - first[0], .element = j->of->element + first[0]};
    lay_out(j->t, &g);
    fit(j->E0, &g);
    bool level = falls(&g);
    if (level) memset(g.slope, 0, sizeof g.slope);
    float kept = (float)kept_of(j, &g);
    if (!(kept < 1)) continue;
    draw(&g, kept, j->E0);
    if (!j->apart) continue;
    fit(j->apart, &g);
    if (level) memset(g.slope, 0, sizeof g.slope);
    draw(&g, kept, j->apart);
  }
  return YLM_OK;
}

ylm_status ylm__transfer_smooth(const ylm_transfer *t, const transfer_neighbours *of,
                                const float *variance, float *E0, float *apart, int threads) {
  job j = {t, of, variance, E0, apart};
  return ylm_parallel(of->groups, SMOOTH_GRAIN, threads, smooth, &j, NULL, NULL);
}

/* -- light of links ---------------------------------------------------------------------------- */

/*
** One link of 64 that meets a lamp's shade from inside makes its element shine. Means over many elements do not change; a place in the
** corner of a room, which sees that element alone, would show it. Links are taken for random ones: they are spread evenly, so that
** their variance is less than this where light changes slowly, and elements are drawn to planes that they stray from by light. Errors
** beside 2,048 links say that it pays (spec/radiosity_spec.lua).
*/

typedef struct links_job {
  const ylm_radiosity *r;
  const float *leaving; /* [elements + 1] luminance */
  float *variance;      /* [elements] of the irradiance by links */
} links_job;

static ylm_status vary(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const links_job *j = context;
  size_t links = (size_t)j->r->t->form.links;
  for (size_t e = begin; e < end; e++) {
    ylm_links link = ylm_links_from(j->r->t->link, e * links);
    double sum = 0, square = 0, n = (double)links;
    for (size_t k = 0; k < links; k++) {
      double y = (double)j->leaving[ylm_links_at(link, k)];
      sum += y, square += y * y;
    }
    double each = fmax(0, square / n - sum * sum / (n * n)) / (n - 1);
    j->variance[e] = (float)(YLM_PI * YLM_PI * each);
  }
  return YLM_OK;
}

/* E [elements][4], light that links bring, without their noise; y [elements + 1], variance [elements]: room. */
static ylm_status average(const ylm_radiosity *r, int threads, float *E, float *y,
                          float *variance) {
  size_t n = r->t->elements;
  links_job j = {r, y, variance};
  ylm__transfer_luminances(n + 1, r->leaving, y);
  for (size_t i = 0; i < 4 * n; i++) E[i] = fmaxf(0, r->E[i] - r->direct[i]);
  ylm_status s = ylm_parallel(n, BOUNCE_GRAIN, threads, vary, &j, NULL, NULL);
  return s == YLM_OK ? ylm__transfer_smooth(r->t, r->neighbours, variance, E, NULL, threads) : s;
}

ylm_status ylm__transfer_average(const ylm_radiosity *r, int threads, float *E) {
  size_t n = r->t->elements;
  float *y = ylm_alloc(n + 1, sizeof *y), *variance = ylm_alloc(n, sizeof *variance);
  ylm_status s = y && variance ? average(r, threads, E, y, variance) : YLM_ENOMEM;
  ylm_free(y);
  ylm_free(variance);
  for (size_t i = 0; s == YLM_OK && i < 4 * n; i++) E[i] += r->direct[i];
  return s;
}

bool ylm__transfer_has_groups(const transfer_neighbours *g) { return g && g->groups > 0; }
