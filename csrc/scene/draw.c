/*
** draw.c - lamps drawn from the tree of lamps.
**
** A sample is a number of 0 .. 1. Each node that it comes to divides its interval in proportion to what
** the node's children may bring to the point; the sample goes on with its place in the part that it fell
** into. Samples come in increasing order and walk together, so that a node is looked at once.
**
** Source  Shirley, Wang, Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting Calculations";
**         Walter et al. 2005, "Lightcuts: A Scalable Approach to Illumination"; Conty Estevez & Kulla
**         2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"
*/
#include <math.h>
#include <string.h>

#include "scene.h"
#include "tree.h"

/* The weight of lamp i where it is near. */
static double exact(const ylm_scene_chooser *c, size_t i, const float *n) {
  const ylm_scene *s = c->scene;
  double v[3], solid;
  if (i >= s->lamps)
    return ylm__scene_patch_weight(s, i - s->lamps, c->x, n, &solid) *
           (double)s->patch_luminance[i - s->lamps];
  for (int a = 0; a < 3; a++) v[a] = (double)s->lamp[a][i] - (double)c->x[a];
  return ylm__scene_weight(v, (double)s->lamp[3][i], n) * (double)s->lamp_luminance[i];
}

/* Whether all of a flat lamp, a child of `node`, is below its own horizon. */
static bool is_below(const ylm_scene_chooser *c, const scene_node *node, size_t child, size_t i) {
  const ylm_scene *s = c->scene;
  if (i < s->lamps) return false;
  const float *h = s->horizon + 3 * (i - s->lamps);
  double above = 0, length2 = 0;
  for (int a = 0; a < 3; a++) {
    above += (double)h[a] * ((double)node->x[a][child] - (double)c->x[a]);
    length2 += (double)h[a] * (double)h[a];
  }
  return above + sqrt(length2) * (double)node->radius[child] < 0;
}

/* Sums of weights 0 .. i. */
static void sum_up(const float w[SCENE_WIDTH], double upto[SCENE_WIDTH]) {
  double before = 0;
  for (int i = 0; i < SCENE_WIDTH; i += 4) {
    double sum = 0;
    for (int k = i; k < i + 4; k++) upto[k] = sum += (double)w[k];
  }
  for (int i = 0; i < SCENE_WIDTH; i += 4) {
    for (int k = i; k < i + 4; k++) upto[k] += before;
    before = upto[i + 3];
  }
}

/* Weighs lamps on their own that are near. */
static void look_closely(const ylm_scene_chooser *c, size_t i, scene_seen *seen) {
  const scene_tree *t = c->scene->tree;
  const float *n = c->in_space ? NULL : c->normal;
  uint32_t todo = t->horizons ? seen->live : seen->live & seen->near;
  for (; todo; todo &= todo - 1) {
    unsigned k = (unsigned)__builtin_ctz(todo);
    uint32_t lamp = t->lamp[i * SCENE_WIDTH + k];
    if (seen->near >> k & 1) seen->weight[k] = (float)(exact(c, lamp, n) / t->unit);
    if (t->horizons && is_below(c, &t->node[i], k, lamp)) seen->weight[k] = 0;
    if (!(seen->weight[k] > 0)) seen->live &= ~(1u << k);
  }
}

/* Looks at the children of node i of a level. */
static void look(const ylm_scene_chooser *c, size_t level, size_t i, float limit,
                 scene_seen *seen) {
  const scene_tree *t = c->scene->tree;
  const float *n = c->in_space ? NULL : c->normal;
  c->nodes(&t->node[t->first[level] + i], t->flat, c->x, n, limit, seen);
  if (level == 0 && seen->live & (t->horizons ? UINT32_MAX : seen->near)) look_closely(c, i, seen);
}

static void open_node(scene_cut *cut, const ylm_scene_chooser *c, uint32_t level, uint32_t node,
                      float limit) {
  scene_open *o = &cut->open[cut->n++];
  o->level = level;
  o->node = node;
  memset(o->below, 0, sizeof o->below);
  look(c, level, node, limit, &o->seen);
}

/* Opens the children of open node b that are in doubt. */
static void open_children(scene_cut *cut, const ylm_scene_chooser *c, uint32_t b, float limit) {
  scene_open *o = &cut->open[b];
  for (uint32_t todo = o->seen.live & o->seen.doubtful; todo && cut->n < SCENE_OPEN;
       todo &= todo - 1) {
    unsigned k = (unsigned)__builtin_ctz(todo);
    o->below[k] = (uint8_t)cut->n;
    cut->open[cut->n].parent = b;
    cut->open[cut->n].lane = k;
    open_node(cut, c, o->level - 1, o->node * SCENE_WIDTH + k, limit);
  }
}

/* Sums over open nodes, which come after those that they are children of. */
static void add_up(scene_cut *cut) {
  for (uint32_t b = cut->n; b-- > 0;) {
    scene_open *o = &cut->open[b], *above = &cut->open[o->parent];
    sum_up(o->seen.weight, o->upto);
    if (b == 0) return;
    float sum = (float)o->upto[SCENE_WIDTH - 1];
    above->seen.weight[o->lane] = sum;
    if (!(sum > 0)) above->seen.live &= ~(1u << o->lane);
  }
}

void ylm__scene_look(ylm_scene_chooser *c, int light_samples) {
  const scene_tree *t = c->scene->tree;
  scene_cut *cut = c->cut;
  cut->n = 0;
  if (t->lamps == 0) return;
  open_node(cut, c, (uint32_t)t->levels - 1, 0, INFINITY);
  cut->open[0].parent = cut->open[0].lane = 0;
  if (t->levels > 1) {
    scene_seen *root = &cut->open[0].seen;
    float limit = 0;
    for (int k = 0; k < SCENE_WIDTH; k++) limit += root->weight[k];
    limit *= (float)(SCENE_DOUBT / sqrt((double)light_samples));
    for (unsigned k = 0; k < SCENE_WIDTH; k++)
      root->doubtful |= (uint32_t)(root->doubt[k] > limit) << k;
    for (uint32_t b = 0; b < cut->n; b++)
      if (cut->open[b].level > 0) open_children(cut, c, b, limit);
  }
  add_up(cut);
}

/* -- walks ---------------------------------------------------------------------------------- */

/* A node on the way down: open, or being looked at. */
typedef struct place {
  const scene_open *open; /* NULL: it is not */
  size_t level, node;
  const scene_seen *seen;
  const double *upto;
  scene_seen room;
  double sums[SCENE_WIDTH];
} place;

static void stand(place *p, const scene_open *open) {
  p->open = open;
  p->level = open->level;
  p->node = open->node;
  p->seen = &open->seen;
  p->upto = open->upto;
}

/* The child k of a node that is none of the last level. */
static void enter(const ylm_scene_chooser *c, const place *p, unsigned k, place *below) {
  if (p->open && p->open->below[k]) {
    stand(below, &c->cut->open[p->open->below[k]]);
    return;
  }
  below->open = NULL;
  below->level = p->level - 1;
  below->node = p->node * SCENE_WIDTH + k;
  below->seen = &below->room;
  below->upto = below->sums;
  look(c, below->level, below->node, INFINITY, &below->room);
  sum_up(below->room.weight, below->sums);
}

typedef double two __attribute__((vector_size(16)));
typedef int64_t two_whole __attribute__((vector_size(16)));

/* The child that holds `at`. */
static unsigned find(const place *p, double at) {
  two_whole passed = {0, 0};
  for (int i = 0; i < SCENE_WIDTH; i += 2) {
    two upto;
    memcpy(&upto, p->upto + i, sizeof upto);
    passed -= upto <= (two){at, at};
  }
  unsigned k = (unsigned)(passed[0] + passed[1]);
  return k < SCENE_WIDTH ? k : 31u - (unsigned)__builtin_clz(p->seen->live);
}

static double within(double x, double width) {
  x /= width;
  return x > 0 ? (x < SCENE_BELOW_ONE ? x : SCENE_BELOW_ONE) : 0;
}

/* Samples first .. end-1 at a place where they arrived with chance `share`. */
static void descend(const ylm_scene_chooser *c, const place *p, double share, size_t first,
                    size_t end, scene_drawn *d) {
  double total = p->upto[SCENE_WIDTH - 1];
  for (size_t q = first; q < end; q++) d->at[q] *= total, d->share[q] = 0;
  while (p->seen->live && first < end) {
    unsigned k = find(p, d->at[first]);
    double own = (double)p->seen->weight[k], behind = p->upto[k],
           begin = k > 0 ? p->upto[k - 1] : 0;
    double chance = share * own / total;
    size_t from = first;
    do {
      d->at[first] = within(d->at[first] - begin, own);
      d->share[first++] = chance;
    } while (first < end && d->at[first] < behind);
    if (p->level > 0) {
      place below;
      enter(c, p, k, &below);
      descend(c, &below, chance, from, first, d);
    } else {
      uint32_t lamp = c->scene->tree->lamp[p->node * SCENE_WIDTH + k];
      for (size_t q = from; q < first; q++) d->lamp[q] = lamp;
    }
  }
}

void ylm__scene_draw(const ylm_scene_chooser *c, size_t n, scene_drawn *d) {
  place root;
  stand(&root, &c->cut->open[0]);
  descend(c, &root, 1, 0, n, d);
}

double ylm__scene_drawn_share(const ylm_scene_chooser *c, uint32_t lamp) {
  const scene_tree *t = c->scene->tree;
  place p[2];
  double share = 1;
  size_t slot = t->slot[lamp];
  if (slot == UINT32_MAX) return 0;
  stand(&p[0], &c->cut->open[0]);
  for (size_t i = 0;; i ^= 1) {
    unsigned k = (unsigned)(slot >> SCENE_WIDTH_BITS * p[i].level) % SCENE_WIDTH;
    double own = (double)p[i].seen->weight[k];
    if (!(own > 0)) return 0;
    share = share * own / p[i].upto[SCENE_WIDTH - 1];
    if (p[i].level == 0) return share;
    enter(c, &p[i], k, &p[i ^ 1]);
  }
}
