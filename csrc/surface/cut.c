/*
** cut.c - how a rectangle is halved: across the axis whose halves' own linear fits leave the least, or along the line that
** parts places that do not see each other, where that leaves no more.
*/
#include <math.h>
#include <stdlib.h>

#include "surface.h"

/* -- linear fits ------------------------------------------------------------------------------ */

/* Sums over places for a linear fit in two coordinates, of three channels. */
typedef struct moments {
  double a[3][3][3], y[3][3], square[3];
  size_t n;
} moments;

static void add(moments *m, const surface_bake *b, const surface_branch *at,
                const surface_entry *e) {
  double t[3] = {1, 0, 0}, E[3];
  for (int k = 0; k < 2; k++)
    t[k + 1] = 2 * ((double)e->at[k] - at->lo[k]) / (double)(at->hi[k] - at->lo[k]) - 1;
  ylm__surface_mid(&b->light[b->site[e->site].light], E);
  for (int c = 0; c < 3; c++) {
    double s = ylm__surface_scale(b, E[c], c), w = s > 0 ? 1 / (s * s) : 0;
    for (int i = 0; i < 3; i++) {
      for (int j = 0; j < 3; j++) m->a[c][i][j] += w * t[i] * t[j];
      m->y[c][i] += w * t[i] * E[c];
    }
    m->square[c] += w * E[c] * E[c];
  }
  m->n++;
}

/* The rest that the fit of a channel leaves: by elimination, of the first k terms. */
static double left(const moments *m, int c, int k) {
  double a[3][4], rest = m->square[c];
  double ridge = 0.02 * m->a[c][0][0] / (double)(m->n ? m->n : 1);
  for (int i = 0; i < k; i++) {
    for (int j = 0; j < k; j++) a[i][j] = m->a[c][i][j] + (i == j && i > 0 ? ridge : 0);
    a[i][k] = m->y[c][i];
  }
  for (int i = 0; i < k; i++) {
    if (!(a[i][i] > 0)) continue;
    rest -= a[i][k] * a[i][k] / a[i][i];
    for (int r = i + 1; r < k; r++) {
      double f = a[r][i] / a[i][i];
      for (int j = i; j <= k; j++) a[r][j] -= f * a[i][j];
    }
  }
  return fmax(0, rest);
}

/* Of a half of a leaf: the worst channel's. */
static double residual(const moments *m) {
  double most = 0;
  for (int c = 0; m->n > 0 && c < 3; c++) most = fmax(most, left(m, c, m->n >= 5 ? 3 : 1));
  return most;
}

/* The rest that one fit of a leaf leaves. */
static double judge_whole(const surface_bake *b, const surface_leaf *l) {
  moments all = {.n = 0};
  for (size_t i = l->first; i < l->first + l->sampled; i++)
    add(&all, b, &b->branch[l->branch], &b->entry[i]);
  return residual(&all);
}

/* The rest that fits of both halves of a leaf leave. *both: neither is empty. */
static double judge(const surface_bake *b, const surface_leaf *l, int axis, const float plane[4],
                    bool *both) {
  const surface_branch *n = &b->branch[l->branch];
  moments half[2] = {{.n = 0}, {.n = 0}};
  float middle = 0.5f * (float)(n->lo[axis] + n->hi[axis]);
  for (size_t i = l->first; i < l->first + l->sampled; i++) {
    const surface_entry *e = &b->entry[i];
    bool second =
        plane ? ylm__surface_is_beyond(plane, b->site[e->site].position) : e->at[axis] >= middle;
    add(&half[second], b, n, e);
  }
  *both = half[0].n && half[1].n;
  return residual(&half[0]) + residual(&half[1]);
}

/* -- parts ------------------------------------------------------------------------------------ */

/* Places of a leaf, and which of them one of them sees. */
typedef struct parted {
  uint32_t site[CUT_NEAR];
  bool seen[CUT_NEAR];
  size_t n;
} parted;

typedef struct ordered {
  float t;
  uint32_t place; /* of the list */
  bool seen;
} ordered;

/* A line in the surface, that parts places: at an angle in the tangents t, u, off the origin by the plane's distance. */
typedef struct line {
  float t[3], u[3], plane[4];
  double angle, gap;
  size_t wrong;
} line;

static int by_place(const void *a, const void *b) {
  const ordered *x = a, *y = b;
  return x->t < y->t ? -1 : x->t > y->t;
}

/* The entry of a leaf nearest to one of its corners, of the first `most` that are not known to be buried. */
static uint32_t beside_corner(const surface_bake *b, const surface_leaf *l, int corner,
                              size_t most) {
  const surface_branch *n = &b->branch[l->branch];
  const float *size = b->charts.chart[n->chart].size;
  float u = corner & 1 ? n->hi[0] : n->lo[0], v = corner & 2 ? n->hi[1] : n->lo[1];
  uint32_t best = SURFACE_NONE;
  float least = INFINITY;
  for (size_t i = l->first; i < l->first + l->n && i < l->first + most; i++) {
    const surface_entry *e = &b->entry[i];
    if (b->site[e->site].known == SITE_BURIED) continue;
    float x = (e->at[0] - u) * size[0], y = (e->at[1] - v) * size[1];
    if (best == SURFACE_NONE || x * x + y * y < least) least = x * x + y * y, best = e->site;
  }
  return best;
}

/* Places of a leaf, so many at most, and those beside its corners. */
static ylm_status find_places(surface_bake *b, const surface_leaf *l, size_t most, parted *p) {
  uint32_t list[CUT_NEAR], unknown[CUT_NEAR] = {0};
  size_t n = 0, all = 0;
  for (size_t i = l->first; i < l->first + l->n && i < l->first + most; i++)
    list[all++] = b->entry[i].site;
  for (int c = 0; c < 4; c++) {
    uint32_t site = beside_corner(b, l, c, most > CUT_PLACES ? l->n : CUT_CORNERS);
    if (site != SURFACE_NONE) list[all++] = site;
  }
  for (size_t i = 0; i < all; i++)
    if (b->site[list[i]].known == SITE_UNKNOWN) unknown[n++] = list[i];
  ylm_status s = ylm__surface_know(b, n, unknown, NULL);
  p->n = 0;
  for (size_t i = 0; s == YLM_OK && i < all; i++)
    if (b->site[list[i]].known != SITE_BURIED) p->site[p->n++] = list[i];
  return s;
}

static double apart(const surface_bake *b, uint32_t site, const double x[3]) {
  double d = 0;
  for (int a = 0; a < 3; a++) {
    double way = (double)b->site[site].position[a] - x[a];
    d += way * way;
  }
  return d;
}

/* The place of the list nearest to x; `seen` false: of those that are not seen. */
static size_t nearest_to(const surface_bake *b, const parted *p, const double x[3], bool all) {
  size_t best = SIZE_MAX;
  double least = INFINITY;
  for (size_t i = 0; i < p->n; i++) {
    double d = apart(b, p->site[i], x);
    if ((all || !p->seen[i]) && d < least) least = d, best = i;
  }
  return best;
}

static size_t count_seen(const parted *p) {
  size_t seen = 0;
  for (size_t i = 0; i < p->n; i++) seen += p->seen[i];
  return seen;
}

static ylm_status look_from(surface_bake *b, uint32_t pole, parted *p) {
  uint32_t(*pair)[2] = ylm_alloc(p->n, sizeof *pair);
  if (!pair) return YLM_ENOMEM;
  for (size_t i = 0; i < p->n; i++) pair[i][0] = pole, pair[i][1] = p->site[i];
  ylm_status s = ylm__surface_join(b, p->n, (const uint32_t(*)[2])pair, p->seen);
  ylm_free(pair);
  return s;
}

/* Sorts places along a line from their order along the one before, which is much the same. */
static void sort_again(ordered *o, size_t n) {
  for (size_t i = 1; i < n; i++) {
    ordered x = o[i];
    size_t k = i;
    for (; k > 0 && o[k - 1].t > x.t; k--) o[k] = o[k - 1];
    o[k] = x;
  }
}

/* The best line of `lines` about x->angle, `step` apart: the fewest places lie wrong, then the widest gap. */
static ylm_status find_line(const surface_bake *b, const parted *p, int lines, double step,
                            line *x) {
  ordered *o = ylm_alloc(p->n, sizeof *o);
  size_t seen = count_seen(p);
  double middle = x->angle;
  if (!o) return YLM_ENOMEM;
  x->wrong = SIZE_MAX;
  x->gap = 0;
  for (uint32_t i = 0; i < p->n; i++) o[i] = (ordered){.place = i, .seen = p->seen[i]};
  for (int k = 0; k < lines; k++) {
    double angle = middle + step * (k - lines / 2);
    float d[3];
    for (int a = 0; a < 3; a++) d[a] = (float)cos(angle) * x->t[a] + (float)sin(angle) * x->u[a];
    for (size_t i = 0; i < p->n; i++) o[i].t = ylm_dot3(d, b->site[p->site[o[i].place]].position);
    if (k == 0)
      qsort(o, p->n, sizeof *o, by_place);
    else
      sort_again(o, p->n);
    size_t yes = 0, no = 0, hidden = p->n - seen;
    for (size_t i = 0; i + 1 < p->n; i++) {
      yes += o[i].seen;
      no += !o[i].seen;
      size_t one = yes + (hidden - no), other = no + (seen - yes),
             wrong = one < other ? one : other;
      double width = (double)(o[i + 1].t - o[i].t);
      if (wrong > x->wrong || (wrong == x->wrong && width <= x->gap)) continue;
      x->wrong = wrong, x->gap = width, x->angle = angle;
      memcpy(x->plane, d, sizeof d);
      x->plane[3] = 0.5f * (o[i].t + o[i + 1].t);
    }
  }
  ylm_free(o);
  return YLM_OK;
}

/* Moves a line by the places of the leaf that lie near it, and turns it by parts of a step. */
static ylm_status sharpen(surface_bake *b, const surface_leaf *l, uint32_t pole, double step,
                          line *x) {
  parted *p = ylm_alloc(1, sizeof *p);
  const surface_branch *n = &b->branch[l->branch];
  double size = 0;
  ylm_status s = p ? YLM_OK : YLM_ENOMEM;
  for (int a = 0; a < 3; a++) size = fmax(size, (double)ylm__surface_extent(b, n, a));
  for (int turn = 0; s == YLM_OK && turn < CUT_TURNS; turn++) {
    double band = fmax(CUT_BAND * x->gap, size * step);
    p->n = 0;
    for (size_t i = l->first; i < l->first + l->n && p->n < CUT_NEAR; i++) {
      uint32_t site = b->entry[i].site;
      double off = (double)(ylm_dot3(x->plane, b->site[site].position) - x->plane[3]);
      if (fabs(off) <= band && b->site[site].known != SITE_BURIED) p->site[p->n++] = site;
    }
    if (p->n < 8) break;
    s = look_from(b, pole, p);
    size_t seen = count_seen(p);
    if (seen == 0 || seen == p->n) break;
    step /= CUT_FINER;
    line finer = *x;
    if (s == YLM_OK) s = find_line(b, p, 2 * CUT_FINER + 1, step, &finer);
    if (s == YLM_OK) *x = finer;
  }
  ylm_free(p);
  return s;
}

/* How many places of a list lie on the wrong side of a plane, farther from it than `bit`. */
static size_t count_wrong(const surface_bake *b, const parted *p, const float plane[4], float bit) {
  size_t apart = 0, n = 0;
  for (size_t i = 0; i < p->n; i++) {
    const float *x = b->site[p->site[i]].position;
    if (fabsf(ylm_dot3(plane, x) - plane[3]) < bit) continue;
    apart += p->seen[i] != ylm__surface_is_beyond(plane, x);
    n++;
  }
  return apart < n - apart ? apart : n - apart;
}

/* The place of the list nearest to a plane, of those that are seen or not. */
static size_t nearest_to_plane(const surface_bake *b, const parted *p, const float plane[4],
                               bool seen) {
  size_t best = SIZE_MAX;
  float least = INFINITY;
  for (size_t i = 0; i < p->n; i++) {
    float off = fabsf(ylm_dot3(plane, b->site[p->site[i]].position) - plane[3]);
    if (p->seen[i] == seen && off < least) least = off, best = i;
  }
  return best;
}

/* Puts a line where the wall that hides places from others stands, if no more places are on the wrong side then: but for
   those that a slanting wall hides above the surface alone. */
static void snap(const surface_bake *b, const parted *p, line *x) {
  size_t hidden = nearest_to_plane(b, p, x->plane, false);
  if (hidden == SIZE_MAX) return;
  const surface_site *to = &b->site[p->site[hidden]];
  parted near = {.n = 0};
  for (size_t i = 0; i < p->n; i++)
    if (p->seen[i]) near.site[near.n++] = p->site[i];
  const double at[3] = {(double)to->position[0], (double)to->position[1], (double)to->position[2]};
  size_t seen = nearest_to(b, &near, at, true);
  if (seen == SIZE_MAX) return;
  const float *n = to->normal, *from = b->site[near.site[seen]].position;
  float off = (float)(SIGHT_OFF * b->charts.unit), plane[4];
  ylm_trace_ray ray = {.far = 1};
  ylm_trace_hit hit;
  for (int a = 0; a < 3; a++) {
    ray.org[a] = from[a] + off * n[a];
    ray.dir[a] = to->position[a] - from[a];
  }
  ylm_trace_nearest(ylm_scene_trace(b->scene), 1, &ray, false, &hit);
  if (hit.mesh < 0) return;
  float up = ylm_dot3(hit.normal, n);
  for (int a = 0; a < 3; a++) plane[a] = hit.normal[a] - up * n[a];
  float length = sqrtf(ylm_dot3(plane, plane));
  if (!(length > 0)) return;
  /* Of the wall's plane what meets the surface's. */
  plane[3] = 0;
  for (int a = 0; a < 3; a++) {
    float met = ray.org[a] + hit.t * ray.dir[a];
    plane[3] += hit.normal[a] * met - up * n[a] * to->position[a];
  }
  for (int a = 0; a < 4; a++) plane[a] /= length;
  if (count_wrong(b, p, plane, CUT_SLANT * off) <= count_wrong(b, p, x->plane, 0))
    memcpy(x->plane, plane, sizeof plane);
}

/* Looks from a place of the list for a line that parts it. */
static ylm_status try_pole(surface_bake *b, const surface_leaf *l, parted *p, size_t pole, line *x,
                           bool *found, bool *all) {
  uint32_t site = p->site[pole];
  ylm_status s = look_from(b, site, p);
  size_t seen = count_seen(p);
  size_t least = seen < p->n - seen ? seen : p->n - seen;
  *all = seen == p->n;
  if (s != YLM_OK || least < 1) return s;
  *x = (line){.angle = 0};
  ylm_scene_basis(b->site[site].normal, x->t, x->u);
  int lines = p->n > 2 * CUT_PLACES ? CUT_DENSE * CUT_LINES : CUT_LINES;
  s = find_line(b, p, lines, YLM_PI / lines, x);
  if (s == YLM_OK && 2 * x->wrong <= least) s = sharpen(b, l, site, YLM_PI / lines, x);
  if (s == YLM_OK && x->wrong < SIZE_MAX) snap(b, p, x);
  double most = least > 1 ? CUT_WRONG * (double)least + 1 : 0;
  float bit = (float)(CUT_SLANT * SIGHT_OFF * b->charts.unit);
  size_t wrong = s == YLM_OK ? count_wrong(b, p, x->plane, bit) : SIZE_MAX;
  *found = (double)wrong <= most && wrong < least;
  return s;
}

/* A plane that parts places of a leaf, `most` of them, that do not see each other. */
static ylm_status find_cut(surface_bake *b, const surface_leaf *l, size_t most, float plane[4],
                           bool *found) {
  parted *p = ylm_alloc(1, sizeof *p);
  double middle[3] = {0, 0, 0};
  *found = false;
  ylm_status s = p ? find_places(b, l, most, p) : YLM_ENOMEM;
  size_t n = s == YLM_OK ? p->n : 0;
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) middle[a] += (double)b->site[p->site[i]].position[a] / (double)n;
  size_t pole = n < 8 ? SIZE_MAX : nearest_to(b, p, middle, true);
  for (int turn = 0; s == YLM_OK && pole != SIZE_MAX && turn < 2 && !*found; turn++) {
    line x;
    bool all;
    s = try_pole(b, l, p, pole, &x, found, &all);
    if (*found) memcpy(plane, x.plane, sizeof x.plane);
    const float *from = b->site[p->site[pole]].position;
    const double at[3] = {(double)from[0], (double)from[1], (double)from[2]};
    pole = all ? SIZE_MAX : nearest_to(b, p, at, false);
  }
  ylm_free(p);
  return s;
}

/* -- the choice ------------------------------------------------------------------------------- */

/* The axis across which a leaf is halved best, -1: none; what that leaves. */
static int best_axis(const surface_bake *b, const surface_leaf *l, double *least) {
  const surface_branch *n = &b->branch[l->branch];
  float size[3], longest = 0;
  int best = -1;
  *least = INFINITY;
  for (int a = 0; a < 3; a++) {
    size[a] = ylm__surface_extent(b, n, a);
    longest = fmaxf(longest, size[a]);
  }
  for (int a = 0; a < 3; a++) {
    bool both;
    if (!ylm__surface_may(b, n, a)) continue;
    if (a == 2 && size[2] < 0.25f * fmaxf(size[0], size[1])) continue;
    double e = judge(b, l, a, NULL, &both) * (1 - 1e-3 * (double)(size[a] / longest));
    if (6 * size[a] < longest) e *= 1.5; /* not too thin */
    if (e < *least || best < 0) *least = e, best = a;
  }
  return best;
}

/* Asks for the light of some places of each side of a plane, where it is not known. */
static ylm_status light_both(surface_bake *b, surface_leaf *l, const float plane[4]) {
  uint32_t site[2 * CUT_SIDE];
  size_t entry[2 * CUT_SIDE], n = 0;
  float share[2 * CUT_SIDE];
  surface_light light[2 * CUT_SIDE];
  size_t have[2] = {0, 0};
  for (size_t i = l->first; i < l->first + l->n; i++) {
    const surface_site *x = &b->site[b->entry[i].site];
    int side = ylm__surface_is_beyond(plane, x->position);
    if (have[side] >= CUT_SIDE || x->known == SITE_BURIED) continue;
    have[side]++;
    if (i < l->first + l->sampled) continue;
    entry[n] = i;
    site[n++] = b->entry[i].site;
  }
  ylm_status s = ylm__surface_ask(b, n, site, b->links, light, share);
  if (s == YLM_OK) s = ylm__surface_know(b, n, site, share);
  if (s == YLM_OK) s = ylm__surface_keep(b, n, site, light);
  /* Entries ascend: those behind stay where they are. */
  for (size_t i = 0; s == YLM_OK && i < n; i++)
    if (b->site[site[i]].known != SITE_BURIED) ylm__surface_take(l, b->entry, entry[i]);
  return s;
}

/* Whether something stands on the border of a leaf of a plane: a wall that crosses the leaf does. */
static bool is_crossed(const surface_bake *b, const surface_leaf *l) {
  const surface_branch *n = &b->branch[l->branch];
  const surface_chart *c = &b->charts.chart[n->chart];
  const float *normal = b->site[b->entry[l->first].site].normal;
  float corner[4][3];
  ylm_trace_ray ray[4];
  static const int next[4] = {1, 3, 0, 2}; /* around */
  for (int k = 0; k < 4; k++) {
    float u = (float)(k & 1 ? n->hi[0] : n->lo[0]) / SURFACE_TOP * c->size[0],
          v = (float)(k & 2 ? n->hi[1] : n->lo[1]) / SURFACE_TOP * c->size[1];
    for (int a = 0; a < 3; a++)
      corner[k][a] = c->origin[a] + u * c->axis[0][a] + v * c->axis[1][a] +
                     (float)(SIGHT_OFF * b->charts.unit) * normal[a];
  }
  for (int k = 0; k < 4; k++) {
    ray[k] = (ylm_trace_ray){.far = 1};
    for (int a = 0; a < 3; a++) {
      ray[k].org[a] = corner[k][a];
      ray[k].dir[a] = corner[next[k]][a] - corner[k][a];
    }
  }
  ylm_trace_occluded(ylm_scene_trace(b->scene), 4, ray);
  bool crossed = false;
  for (int k = 0; k < 4; k++) crossed |= ray[k].far < 0;
  return crossed;
}

/* Cuts leaf i where its places do not see each other, and their light tells them apart. */
static ylm_status part_leaf(surface_bake *b, uint32_t i) {
  float plane[4];
  bool found, both;
  const surface_chart *c = &b->charts.chart[b->branch[b->leaf[i].branch].chart];
  bool dense = c->size[2] == 0;
  b->leaf[i].parted = true;
  if (dense && !is_crossed(b, &b->leaf[i])) return YLM_OK;
  ylm_status s = find_cut(b, &b->leaf[i], dense ? CUT_NEAR - 4 : CUT_PLACES, plane, &found);
  if (s != YLM_OK || !found) return s;
  s = light_both(b, &b->leaf[i], plane);
  double cut = judge(b, &b->leaf[i], 0, plane, &both);
  if (s != YLM_OK || !both || !(cut < CUT_GAIN * judge_whole(b, &b->leaf[i]))) return s;
  return ylm__surface_halve(b, i, NODE_PLANE, plane);
}

ylm_status ylm__surface_part(surface_bake *b) {
  ylm_status s = YLM_OK;
  for (uint32_t i = 0; s == YLM_OK && i < b->leaves; i++)
    while (s == YLM_OK && b->leaf[i].sampled && !b->leaf[i].parted) s = part_leaf(b, i);
  return s;
}

ylm_status ylm__surface_split(surface_bake *b, uint32_t leaf, bool *done) {
  float plane[4];
  double least;
  bool found, both;
  int axis = best_axis(b, &b->leaf[leaf], &least);
  ylm_status s = find_cut(b, &b->leaf[leaf], CUT_PLACES, plane, &found);
  *done = true;
  if (s != YLM_OK) return s;
  if (found && judge(b, &b->leaf[leaf], 0, plane, &both) <= least && both)
    return ylm__surface_halve(b, leaf, NODE_PLANE, plane);
  if (axis >= 0) return ylm__surface_halve(b, leaf, (uint32_t)axis, NULL);
  *done = false;
  return YLM_OK;
}
