/* sites.c - random places on surfaces, and the light of those that are asked. */
#include <math.h>

#include "surface.h"

typedef struct drawing {
  surface_bake *b;
  const ylm_transfer *t;
  const double *sum;
  uint32_t *n; /* sites of each block */
} drawing;

/* Sites of blocks, each with random numbers of its own. */
static ylm_status draw_blocks(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const drawing *j = context;
  surface_bake *b = j->b;
  for (size_t k = begin; k < end; k++) {
    ylm_rng rng;
    ylm_rng_seed(&rng, b->form->light.seed, 0x51750000 + k);
    j->n[k] = 0;
    for (int tries = 0; j->n[k] < SITE_BLOCK && tries < 2 * SITE_BLOCK; tries++) {
      ylm_scene_place p = ylm__surface_random(&b->charts, j->sum, &rng);
      if (!ylm__surface_is_lit(j->t, &p)) continue;
      ylm_scene_surface at;
      ylm_scene_surfaces(b->scene, 1, &p, &at);
      surface_site *s = &b->site[k * SITE_BLOCK + j->n[k]++];
      *s = (surface_site){.at = p, .light = SURFACE_NONE};
      memcpy(s->position, at.position, sizeof s->position);
      memcpy(s->normal, at.normal, sizeof s->normal);
    }
  }
  return YLM_OK;
}

/* How many places are spread over all surfaces: a budget of few corners chooses from fewer. */
static size_t places_of(const surface_bake *b) {
  size_t corners = b->form->corners;
  if (corners == 0 || corners >= PLACES / PLACES_CORNER || b->form->like) return PLACES;
  size_t n = PLACES_CORNER * corners;
  return n < PLACES_BUDGET ? PLACES_BUDGET : n;
}

static ylm_status draw_sites(surface_bake *b) {
  size_t blocks = b->charts.area > 0 ? places_of(b) / SITE_BLOCK : 0;
  drawing j = {b, ylm_radiosity_transfer(b->r),
               ylm__surface_areas(&b->charts, ylm_radiosity_transfer(b->r)),
               ylm_alloc(blocks, sizeof *j.n)};
  b->site = ylm_alloc(blocks * SITE_BLOCK, sizeof *b->site);
  ylm_status s = j.sum && j.n && b->site ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm_parallel(blocks, 1, b->form->light.threads, draw_blocks, &j, NULL, NULL);
  for (size_t k = 0; s == YLM_OK && k < blocks; k++) {
    if (b->sites < k * SITE_BLOCK)
      memmove(b->site + b->sites, b->site + k * SITE_BLOCK, j.n[k] * sizeof *b->site);
    b->sites += j.n[k];
  }
  b->spread = b->sites;
  b->site_room = blocks * SITE_BLOCK;
  if (s == YLM_OK) b->charts.unit = sqrt(j.sum[b->charts.first[ylm_scene_meshes(b->scene)]]);
  ylm_free((void *)j.sum);
  ylm_free(j.n);
  return s;
}

/* -- entries --------------------------------------------------------------------------------- */

/* Sorts the sites by charts. */
static ylm_status sort_entries(surface_bake *b) {
  size_t *first = ylm_alloc_zero(b->charts.charts + 2, sizeof *first), n = 0;
  surface_spot spot[3];
  if (!first) return YLM_ENOMEM;
  for (size_t pass = 0; pass < 2; pass++) {
    for (size_t i = 0; i < b->sites; i++) {
      const surface_site *s = &b->site[i];
      int spots = ylm__surface_spots(&b->charts, &s->at, s->position, s->normal, spot);
      for (int k = 0; k < spots; k++) {
        if (pass == 0) {
          first[spot[k].chart + 2]++;
          n++;
          continue;
        }
        surface_entry *e = &b->entry[first[spot[k].chart + 1]++];
        e->site = (uint32_t)i;
        memcpy(e->at, spot[k].at, sizeof e->at);
      }
    }
    if (pass == 1) break;
    for (size_t c = 0; c < b->charts.charts; c++) first[c + 2] += first[c + 1];
    b->entries = n;
    if (!(b->entry = ylm_alloc(n, sizeof *b->entry))) {
      ylm_free(first);
      return YLM_ENOMEM;
    }
  }
  ylm_status s = YLM_OK;
  for (uint32_t c = 0; c < b->charts.charts; c++) {
    b->root[c] = SURFACE_NONE;
    if (s == YLM_OK && first[c + 1] > first[c])
      s = ylm__surface_plant(b, c, first[c], first[c + 1] - first[c]);
  }
  ylm_free(first);
  return s;
}

ylm_status ylm__surface_sites(surface_bake *b) {
  b->root = ylm_alloc(b->charts.charts, sizeof *b->root);
  ylm_status s = b->root ? draw_sites(b) : YLM_ENOMEM;
  return s == YLM_OK ? sort_entries(b) : s;
}

/* -- light ----------------------------------------------------------------------------------- */

ylm_status ylm__surface_ask(surface_bake *b, size_t n, const uint32_t *site, int links,
                            surface_light *light, float *share) {
  ylm_radiosity_map m = b->form->light;
  ylm_scene_place *place = ylm_alloc(n, sizeof *place);
  uint64_t *stream = ylm_alloc(n, sizeof *stream);
  float(*E)[3] = ylm_alloc(n, sizeof *E);
  ylm_status s = place && stream && E ? YLM_OK : YLM_ENOMEM;
  m.progress = NULL;
  m.links = links;
  double more = (double)links / b->form->light.links;
  m.light_samples = (int)fmin(YLM_TRANSFER_LINKS, fmax(1, ceil(more * m.light_samples)));
  for (size_t i = 0; s == YLM_OK && i < n; i++) {
    place[i] = b->site[site[i]].at;
    stream[i] = site[i];
  }
  for (int half = 0; s == YLM_OK && half < (light ? 2 : 1); half++) {
    m.seed = 2 * b->form->light.seed + (uint64_t)half;
    s = ylm_radiosity_places(b->r, &m, n, place, stream, E, share, b->e);
    for (size_t i = 0; s == YLM_OK && light && i < n; i++)
      memcpy(half ? light[i].b : light[i].a, E[i], sizeof E[i]);
    b->stats.rays += n * (size_t)(links + (m.scene ? m.light_samples : 0));
  }
  ylm_free(place);
  ylm_free(stream);
  ylm_free(E);
  return s;
}

/* Sites of a list, in which a site may be twice, the shares of their rays, and what they are found to be. */
typedef struct knowing {
  surface_bake *b;
  const uint32_t *site;
  const float *share;
  unsigned char *known;
} knowing;

static ylm_status know(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const knowing *j = context;
  for (size_t i = begin; i < end; i++) {
    ylm_scene_surface at;
    j->known[i] = SITE_BURIED;
    if (j->share[i] < 0.5f) continue;
    ylm_scene_surfaces(j->b->scene, 1, &j->b->site[j->site[i]].at, &at);
    j->known[i] =
        ylm__surface_is_covered(&j->b->charts, j->b->charts.unit, &at) ? SITE_COVERED : SITE_OPEN;
  }
  return YLM_OK;
}

ylm_status ylm__surface_know(surface_bake *b, size_t n, const uint32_t *site, const float *share) {
  float *own = share ? NULL : ylm_alloc(n, sizeof *own);
  unsigned char *known = ylm_alloc(n, sizeof *known);
  ylm_status s = known && (share || own) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && !share) s = ylm__surface_ask(b, n, site, 4, NULL, own);
  knowing j = {b, site, share ? share : own, known};
  if (s == YLM_OK) s = ylm_parallel(n, SURFACE_GRAIN, b->form->light.threads, know, &j, NULL, NULL);
  for (size_t i = 0; s == YLM_OK && i < n; i++) b->site[site[i]].known = known[i];
  ylm_free(known);
  ylm_free(own);
  return s;
}

ylm_status ylm__surface_keep(surface_bake *b, size_t n, const uint32_t *site,
                             const surface_light *light) {
  if (!ylm_list_reserve(&b->light, b->lights, b->lights + n, &b->light_room, sizeof *b->light))
    return YLM_ENOMEM;
  for (size_t i = 0; i < n; i++) {
    surface_site *s = &b->site[site[i]];
    if (s->known == SITE_BURIED || s->light != SURFACE_NONE) continue;
    s->light = (uint32_t)b->lights;
    b->light[b->lights++] = light[i];
  }
  return YLM_OK;
}

void ylm__surface_take(surface_leaf *l, surface_entry *entry, size_t at) {
  surface_entry e = entry[at];
  entry[at] = entry[l->first + l->sampled];
  entry[l->first + l->sampled++] = e;
}

/* The squared distance of an entry to the nearest of those that are sampled or chosen. */
static double distance(const surface_bake *b, const surface_leaf *l, const float *size,
                       const surface_entry *e) {
  double best = INFINITY;
  for (size_t i = l->first; i < l->first + l->sampled; i++) {
    double d = 0;
    for (int a = 0; a < 3; a++) {
      double x = (double)((b->entry[i].at[a] - e->at[a]) * size[a]);
      d += x * x;
    }
    best = fmin(best, d);
  }
  return best;
}

/* Chooses the farthest of some entries of a leaf that are not kept for judges, from *next on; false: none is left. */
static bool choose(surface_bake *b, surface_leaf *l, size_t *next) {
  const float *size = b->charts.chart[b->branch[l->branch].chart].size;
  size_t best = SIZE_MAX;
  double farthest = -1;
  if (*next < l->first + l->sampled) *next = l->first + l->sampled;
  for (int turn = 0; turn < SPREAD && *next < l->first + l->n; ++*next) {
    const surface_site *s = &b->site[b->entry[*next].site];
    if (s->known == SITE_BURIED ||
        (s->light == SURFACE_NONE && site_judges(b, (size_t)(s - b->site))))
      continue;
    double d = distance(b, l, size, &b->entry[*next]);
    turn++;
    if (d > farthest) farthest = d, best = *next;
  }
  if (best == SIZE_MAX) return false;
  ylm__surface_take(l, b->entry, best);
  return true;
}

/* Entries of a leaf that turned out to be buried go to its end, and out of it. */
static void bury(const surface_bake *b, surface_leaf *l) {
  for (size_t i = l->first; i < l->first + l->sampled;) {
    if (b->site[b->entry[i].site].known != SITE_BURIED) {
      i++;
      continue;
    }
    l->weight -= l->weight / (double)l->n;
    size_t last = l->first + --l->sampled, end = l->first + --l->n;
    surface_entry e = b->entry[i];
    b->entry[i] = b->entry[last];
    b->entry[last] = b->entry[end];
    b->entry[end] = e;
  }
}

typedef struct asked {
  uint32_t *site;
  size_t n, room;
} asked;

/* Places that the leaves want, and have no light yet: on a later pass more, where those before were buried. */
static ylm_status choose_all(surface_bake *b, int pass, asked *q) {
  double dense = SAMPLES_ALL / ((double)b->spread + 1);
  q->n = 0;
  for (size_t k = 0; k < b->leaves; k++) {
    surface_leaf *l = &b->leaf[k];
    size_t wanted = (size_t)fmax(SAMPLES, dense * l->weight), next = l->first;
    if (l->sampled >= wanted) continue;
    wanted = l->sampled + ((wanted - l->sampled) << pass);
    while (l->sampled < wanted && choose(b, l, &next)) {
      surface_site *s = &b->site[b->entry[l->first + l->sampled - 1].site];
      if (s->light != SURFACE_NONE) continue;
      if (!ylm_list_reserve(&q->site, q->n, q->n + 1, &q->room, sizeof *q->site)) return YLM_ENOMEM;
      s->light = (uint32_t)(b->lights + q->n);
      q->site[q->n++] = (uint32_t)(s - b->site);
    }
  }
  return YLM_OK;
}

/* Asks for the light of the chosen places. */
static ylm_status ask_all(surface_bake *b, const asked *q) {
  float *share = ylm_alloc(q->n, sizeof *share);
  ylm_status s = share && ylm_list_reserve(&b->light, b->lights, b->lights + q->n, &b->light_room,
                                           sizeof *b->light)
                     ? YLM_OK
                     : YLM_ENOMEM;
  if (s == YLM_OK) s = ylm__surface_ask(b, q->n, q->site, b->links, b->light + b->lights, share);
  if (s == YLM_OK) s = ylm__surface_know(b, q->n, q->site, share);
  if (s == YLM_OK) b->lights += q->n;
  ylm_free(share);
  return s;
}

ylm_status ylm__surface_sample(surface_bake *b) {
  asked q = {.site = NULL};
  ylm_status s = YLM_OK;
  for (int pass = 0; s == YLM_OK && pass < SAMPLE_PASSES; pass++) {
    s = choose_all(b, pass, &q);
    if (s == YLM_OK && q.n == 0) break;
    if (s == YLM_OK) s = ask_all(b, &q);
    for (size_t k = 0; s == YLM_OK && k < b->leaves; k++) bury(b, &b->leaf[k]);
  }
  ylm_free(q.site);
  return s;
}

ylm_status ylm__surface_renew(surface_bake *b) {
  uint32_t *site = ylm_alloc(b->lights, sizeof *site);
  float *share = ylm_alloc(b->lights, sizeof *share);
  ylm_status s = site && share ? YLM_OK : YLM_ENOMEM;
  for (size_t i = 0; s == YLM_OK && i < b->sites; i++)
    if (b->site[i].light != SURFACE_NONE) site[b->site[i].light] = (uint32_t)i;
  if (s == YLM_OK) s = ylm__surface_ask(b, b->lights, site, b->links, b->light, share);
  ylm_free(site);
  ylm_free(share);
  return s;
}
