/* links.c - what shading points see of the elements of a scene, and the light that these send. */
#include <math.h>

#include "../calibration.h"
#include "../gloss/lobes.h"
#include "ylm_shade_bounce.h"

struct ylm_shade_links {
  const ylm_shade_view *view;
  const ylm_transfer *transfer;
  int links;
  ylm_links link; /* [points][links]: of all points, or of those that are matte */
  size_t *
      before; /* [points/SHADE_LINK_POINTS + 1]: points that gloss before each block; NULL: none is told apart */
  size_t glossy;
  shade_lobes lobes; /* of these */
  double seconds;
};

/* The points that do not gloss; the numbers of those that do go to l. NULL without memory. */
static uint32_t *list_matte(ylm_shade_links *l) {
  const ylm_shade_view *v = l->view;
  uint32_t *point = ylm_alloc(v->points, sizeof *point);
  size_t n = 0;
  l->before = ylm_alloc(v->points / SHADE_LINK_POINTS + 1, sizeof *l->before);
  if (!point || !l->before) {
    ylm_free(point);
    return NULL;
  }
  for (size_t i = 0; i < v->points; i++) {
    if (i % SHADE_LINK_POINTS == 0) l->before[i / SHADE_LINK_POINTS] = l->glossy;
    if (ylm__shade_glosses(v, i))
      l->glossy++;
    else
      point[n++] = (uint32_t)i;
  }
  return point;
}

/* Links of n points, by the cosine; point NULL: of all. */
static ylm_status find_matte(ylm_shade_links *l, size_t n, const uint32_t *point,
                             const uint64_t *stream, uint64_t seed, int threads,
                             const ylm_progress *progress, ylm_error *e) {
  const ylm_shade_view *v = l->view;
  float(*origin)[3] = v->origin, (*normal)[3] = v->normal;
  uint64_t *own = NULL;
  ylm_status s = YLM_OK;
  if (point) {
    origin = ylm_alloc(n, sizeof *origin), normal = ylm_alloc(n, sizeof *normal);
    own = ylm_alloc(n, sizeof *own);
    s = origin && normal && own ? YLM_OK : YLM_ENOMEM;
  }
  for (size_t i = 0; point && s == YLM_OK && i < n; i++) {
    memcpy(origin[i], v->origin[point[i]], 12);
    memcpy(normal[i], v->normal[point[i]], 12);
    own[i] = stream[point[i]];
  }
  if (s == YLM_OK)
    s = ylm_transfer_find(l->transfer, n, (const float(*)[3])origin, (const float(*)[3])normal,
                          point ? own : stream, l->links, seed, threads, progress, l->link, 0, NULL,
                          e);
  if (point) {
    ylm_free(origin);
    ylm_free(normal);
    ylm_free(own);
  }
  return s;
}

/* Points from `begin` to `end`, of one pixel, that gloss: those of one mesh share `links` as they share the pixel, and have
   four each at least. */
static void list_pixel(ylm_shade_links *l, size_t begin, size_t end, uint32_t *out, size_t *n) {
  const ylm_shade_view *v = l->view;
  for (size_t i = begin; i < end; i++) {
    if (!ylm__shade_glosses(v, i)) continue;
    double all = 0, own = v->corner || end - begin == 1 ? 1 : (double)v->entry[i].weight;
    for (size_t k = begin; own < 1 && k < end; k++)
      if (v->mesh[k] == v->mesh[i]) all += (double)v->entry[k].weight;
    double part = all > own ? own / all : 1;
    l->lobes.start[*n + 1] = l->lobes.start[*n] + 4 * (size_t)ceil(l->links * part / 4);
    out[(*n)++] = (uint32_t)i;
  }
}

/* All points that gloss, in their order; NULL without memory. Where every sample is shaded, or vertices are, points share
   nothing. */
static uint32_t *list_lobes(ylm_shade_links *l) {
  const ylm_shade_view *v = l->view;
  uint32_t *out = ylm_alloc(l->glossy, sizeof *out);
  size_t n = 0;
  l->lobes.start = ylm_alloc_zero(l->glossy + 1, sizeof *l->lobes.start);
  if (!out || !l->lobes.start) {
    ylm_free(out);
    return NULL;
  }
  if (v->corner || v->o.share <= 0)
    for (size_t i = 0; i < v->points; i++) list_pixel(l, i, i + 1, out, &n);
  else
    for (size_t p = 0; p < v->stats.pixels; p++)
      list_pixel(l, v->pixel[p].first, v->pixel[p + 1].first, out, &n);
  return out;
}

/* Links of the points that gloss. */
static ylm_status find_lobes(ylm_shade_links *l, const uint64_t *stream, uint64_t seed, int threads,
                             const ylm_progress *progress) {
  uint32_t *point = list_lobes(l);
  if (!point) return YLM_ENOMEM;
  size_t n = l->lobes.start[l->glossy];
  l->lobes.link = ylm_alloc(n, sizeof *l->lobes.link);
  l->lobes.weight = ylm_alloc(n, 3 * sizeof *l->lobes.weight);
  l->lobes.most = ylm_alloc(l->glossy, sizeof *l->lobes.most);
  ylm_status s = l->lobes.link && l->lobes.weight && l->lobes.most ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK)
    s = ylm__shade_lobes(l->view, l->transfer, NULL, l->glossy, point, stream, (size_t)l->links,
                         seed, threads, progress, &l->lobes);
  ylm_free(point);
  return s;
}

/* Links of all points, those that gloss told apart; `alone`: of these. */
static ylm_status find_both(ylm_shade_links *l, bool alone, const uint64_t *stream, uint64_t seed,
                            int threads, const ylm_progress *progress, ylm_error *e) {
  uint32_t *matte = list_matte(l);
  size_t n = l->view->points - l->glossy;
  if (!alone) l->link = ylm_transfer_room(l->transfer, n * (size_t)l->links);
  ylm_status s = matte && (alone || !ylm_links_are_none(l->link)) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && !alone) s = find_matte(l, n, matte, stream, seed, threads, progress, e);
  ylm_free(matte);
  return s == YLM_OK ? find_lobes(l, stream, seed, threads, progress) : s;
}

/* Whether a surface in sight glosses. */
static bool has_gloss(const ylm_shade_links *l) {
  for (size_t i = 0; i < l->view->points; i++)
    if (ylm__shade_glosses(l->view, i)) return true;
  return false;
}

ylm_status ylm_shade_links_create(const ylm_shade_view *v, const ylm_transfer *t, int links,
                                  ylm_shade_linked which, uint64_t seed, int threads,
                                  const ylm_progress *progress, ylm_shade_links **out,
                                  ylm_error *e) {
  *out = NULL;
  if (links < 4 || links > YLM_TRANSFER_LINKS || links % 4)
    return ylm_fail(e, YLM_ERANGE, "links must be a multiple of 4 from 4 to %d, got %d",
                    YLM_TRANSFER_LINKS, links);
  double start = ylm_seconds();
  ylm_shade_links *l = ylm_alloc_zero(1, sizeof *l);
  uint64_t *stream = l ? ylm__shade_streams(v) : NULL;
  /* Random numbers of successive streams lie on a lattice, which the points of a pixel would share. */
  for (size_t i = 0; stream && i < v->points; i++) stream[i] = ylm_mix64(stream[i]);
  if (l) *l = (ylm_shade_links){.view = v, .transfer = t, .links = links};
  bool alone = which == YLM_SHADE_LINKS_GLOSS;
  bool apart = l && which != YLM_SHADE_LINKS_MATTE && (alone || has_gloss(l));
  if (l && !apart) l->link = ylm_transfer_room(t, v->points * (size_t)links);
  ylm_status s = stream && (apart || !ylm_links_are_none(l->link)) ? YLM_OK : YLM_ENOMEM;
  if (s == YLM_OK && apart)
    s = find_both(l, alone, stream, seed, threads, progress, e);
  else if (s == YLM_OK)
    s = find_matte(l, v->points, NULL, stream, seed, threads, progress, e);
  ylm_free(stream);
  if (s != YLM_OK) {
    ylm_shade_links_free(l);
    return s;
  }
  l->seconds = ylm_seconds() - start;
  *out = l;
  return YLM_OK;
}

void ylm_shade_links_free(ylm_shade_links *l) {
  if (!l) return;
  ylm_links_free(l->link);
  ylm_free(l->before);
  ylm_free(l->lobes.start);
  ylm_free(l->lobes.link);
  ylm_free(l->lobes.weight);
  ylm_free(l->lobes.most);
  ylm_free(l);
}

void ylm_shade_links_look(const ylm_shade_links *l, ylm_shade_links_stats *stats) {
  size_t lobes = l->before ? l->lobes.start[l->glossy] : 0;
  bool none = ylm_links_are_none(l->link);
  size_t matte = none ? 0 : (l->view->points - l->glossy) * (size_t)l->links;
  size_t bytes = sizeof *l + matte * ylm_links_bytes(l->link) + lobes * sizeof *l->lobes.link +
                 lobes * 3 * sizeof *l->lobes.weight;
  if (l->before)
    bytes += l->glossy * (sizeof *l->lobes.most + sizeof *l->lobes.start) +
             (l->view->points / SHADE_LINK_POINTS + 1) * sizeof *l->before;
  *stats = (ylm_shade_links_stats){l->links, lobes, matte + lobes, bytes, l->seconds};
}

const ylm_shade_view *ylm__shade_links_view(const ylm_shade_links *l) { return l->view; }
const ylm_transfer *ylm_shade_links_transfer(const ylm_shade_links *l) { return l->transfer; }

/* -- noise ------------------------------------------------------------------------ */

/* How many points before point i gloss. */
static size_t glossy_before(const ylm_shade_links *l, size_t i) {
  size_t n = l->before[i / SHADE_LINK_POINTS];
  for (size_t k = i - i % SHADE_LINK_POINTS; k < i; k++) n += ylm__shade_glosses(l->view, k);
  return n;
}

/* Halves of the mean radiance that arrives along links of even and of odd number, a row of links. */
static void halves(const ylm_shade_links *l, ylm_links link, const float *leaving, double sum[2]) {
  sum[0] = sum[1] = 0;
  for (int i = 0; i < l->links; i++) {
    const float *r = leaving + 4 * (size_t)ylm_links_at(link, (size_t)i);
    sum[i & 1] += YLM_LUMINANCE_R * (double)r[0] + YLM_LUMINANCE_G * (double)r[1] +
                  YLM_LUMINANCE_B * (double)r[2];
  }
}

/* Halves of the radiance that point i, which glosses, reflects, over its mean albedo; as noisy as if it had the links of
   all points with which it shares them. */
static void glossy_halves(const ylm_shade_links *l, size_t i, size_t row, const float *leaving,
                          double sum[2]) {
  float albedo[3];
  double part[3], own = (double)(l->lobes.start[row + 1] - l->lobes.start[row]);
  ylm_material_albedo(ylm__shade_material(l->view, i), albedo);
  double mean = ylm_luminance((double[]){albedo[0], albedo[1], albedo[2]});
  for (int k = 0; k < 2; k++) {
    ylm__shade_lobe(&l->lobes, row, leaving, k, part);
    sum[k] = mean > 0 ? ylm_luminance(part) * l->links / mean : 0;
  }
  double middle = (sum[0] + sum[1]) / 2, apart = (sum[0] - sum[1]) / 2 * sqrt(own / l->links);
  sum[0] = middle + apart;
  sum[1] = middle - apart;
}

double ylm_shade_gather_noise(const ylm_shade_links *l, const float *leaving) {
  size_t points = l->view->points, n = points < NOISE_OF_LINKS ? points : NOISE_OF_LINKS;
  double square = 0, mean = 0;
  for (size_t k = 0; k < n; k++) {
    size_t i = k * points / n, row = l->before ? glossy_before(l, i) : 0;
    double sum[2];
    bool gloss = l->before && ylm__shade_glosses(l->view, i);
    if (!gloss && ylm_links_are_none(l->link)) continue;
    if (gloss)
      glossy_halves(l, i, row, leaving, sum);
    else
      halves(l, ylm_links_from(l->link, (i - row) * (size_t)l->links), leaving, sum);
    double apart =
        (sum[0] - sum[1]) / l->links; /* half of the difference of means over half of them */
    square += apart * apart;
    mean += (sum[0] + sum[1]) / l->links;
  }
  return mean > 0 ? sqrt(square * (double)n) / mean : 0;
}

/* -- gathering ------------------------------------------------------------------- */

typedef struct gather_job {
  const ylm_shade_links *l;
  const float *leaving, *start;
  float *out;
} gather_job;

/* Reflected at n points: the mean radiance that arrives along their links, [n][4], and `start`. */
static void reflect(const ylm_shade_view *v, size_t first, size_t n, const float *mean,
                    const float *start, float *out) {
  float radiance[3 * SHADE_LINK_POINTS];
  for (size_t i = 0; i < n; i++)
    for (size_t c = 0; c < 3; c++) radiance[3 * i + c] = (float)YLM_PI * mean[4 * i + c];
  ylm__shade_reflect(v, first, n, radiance);
  for (size_t k = 0; k < 3 * n; k++) out[k] = (start ? start[k] : 0) + radiance[k];
}

/* Matte points from `first` on, whose rows of links begin at number `row`. */
static void gather_matte(const gather_job *j, size_t first, size_t row, size_t n) {
  const ylm_shade_links *l = j->l;
  float mean[4 * SHADE_LINK_POINTS] __attribute__((aligned(64)));
  if (ylm_links_are_none(l->link)) {
    for (size_t k = 3 * first; k < 3 * (first + n); k++) j->out[k] = j->start ? j->start[k] : 0;
    return;
  }
  ylm_transfer_sum(n, l->links, ylm_links_from(l->link, row * (size_t)l->links), 4, j->leaving,
                   NULL, mean, 1);
  reflect(l->view, first, n, mean, j->start ? j->start + 3 * first : NULL, j->out + 3 * first);
}

/* Point i, which glosses. */
static void gather_glossy(const gather_job *j, size_t i, size_t row) {
  double radiance[3];
  float all[3];
  ylm__shade_lobe(&j->l->lobes, row, j->leaving, -1, radiance);
  for (int c = 0; c < 3; c++) all[c] = (float)radiance[c];
  ylm__shade_tint(j->l->view, i, 1, all);
  for (size_t c = 0; c < 3; c++) j->out[3 * i + c] = (j->start ? j->start[3 * i + c] : 0) + all[c];
}

static ylm_status run_gather(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const gather_job *j = context;
  const ylm_shade_links *l = j->l;
  size_t glossy = l->before ? l->before[begin / SHADE_LINK_POINTS] : 0;
  for (size_t i = begin, behind; i < end; i = behind) {
    for (behind = i; behind < end; behind++)
      if (l->before && ylm__shade_glosses(l->view, behind)) break;
    if (behind > i)
      gather_matte(j, i, i - glossy, behind - i);
    else
      gather_glossy(j, behind++, glossy++);
  }
  return YLM_OK;
}

ylm_status ylm_shade_gather(const ylm_shade_links *l, const float *leaving, const float *start,
                            int threads, const ylm_progress *progress, float *out) {
  gather_job j = {l, leaving, start, out};
  return ylm_parallel(l->view->points, SHADE_LINK_POINTS, threads, run_gather, &j, progress,
                      "gathering");
}
