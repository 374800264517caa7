/* neighbours.c - how near the lights around a light are: its tenth neighbour of the same surface. */
#include "emit.h"

#define NEIGHBOURS 10
#define FACING 0.5f /* the cosine between normals of neighbours, at least */
#define FLAT2 0.25f /* the distance from the tangent plane over the distance, squared, at most */
#define MOST_LOOKS 4096 /* lights that are looked at for those of a leaf */
#define LEAF 16         /* lights, at most */
#define APART 16384     /* lights from which on threads share the tree */
#define FEW 24          /* lights of a range that is split by swaps from both ends */
#define GRAIN 8         /* leaves */
#define LEVELS 32

typedef struct place {
  float at[3];
  uint32_t of;
} place;

typedef struct box {
  float low[3], high[3];
} box;

/* Places beyond `n` are far from everything. */
typedef struct leaf {
  size_t n;
  float at[3][LEAF], normal[3][LEAF];
  uint32_t of[LEAF];
} leaf;

/* Lights in halves of halves: node k has the children 2k and 2k+1, the root is 1, and the leaves are the
   last 2^depth nodes. */
typedef struct tree {
  size_t n;
  int depth;
  const emit_landing *landing;
  place *place; /* [n] */
  box *box;     /* [2^(depth+1)] */
  leaf *leaf;   /* [2^depth] */
  int level;    /* that is being split: the order of splits changes nothing */
  double scale;
  double *radius;
} tree;

/* fminf and fmaxf are calls. */
static inline float lesser(float a, float b) { return a < b ? a : b; }
static inline float larger(float a, float b) { return a > b ? a : b; }

/* -- the tree --------------------------------------------------------------------- */

/* Where range p of 2^level begins. */
static size_t begin_of(const tree *t, int level, size_t p) { return t->n * p >> level; }

/* The axis along which the range is longest. */
static int longest(const place *p, size_t low, size_t high) {
  float least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
  int axis = 0;
  for (size_t k = low; k < high; k++)
    for (int a = 0; a < 3; a++) {
      least[a] = lesser(p[k].at[a], least[a]);
      most[a] = larger(p[k].at[a], most[a]);
    }
  for (int a = 1; a < 3; a++)
    if (most[a] - least[a] > most[axis] - least[axis]) axis = a;
  return axis;
}

static float middle_of(float a, float b, float c) {
  return larger(lesser(a, b), lesser(c, larger(a, b)));
}

/* In pieces of eight bytes, all of which are read as they were written. */
static inline void swap(place *a, place *b) {
  uint64_t x[2], y[2];
  memcpy(x, a, sizeof x);
  memcpy(y, b, sizeof y);
  memcpy(a, y, sizeof y);
  memcpy(b, x, sizeof x);
}

/* Puts places below the pivot first, without a branch on them; returns where the others begin. */
static size_t part(place *p, size_t low, size_t high, float pivot, int axis) {
  size_t at = low;
  for (size_t i = low; i < high; i++) {
    bool below = p[i].at[axis] < pivot;
    swap(&p[i], &p[at]);
    at += below;
  }
  return at;
}

/* Puts the place that belongs there at `middle`, lesser ones before it. Source: Hoare 1961, "Algorithm
   65: Find". */
static void find(place *p, size_t begin, size_t end, size_t middle, int axis) {
  ptrdiff_t low = (ptrdiff_t)begin, high = (ptrdiff_t)end - 1, at = (ptrdiff_t)middle;
  while (low < high) {
    float pivot = middle_of(p[low].at[axis], p[low + (high - low) / 2].at[axis], p[high].at[axis]);
    ptrdiff_t i = low, k = high;
    while (i <= k) {
      while (p[i].at[axis] < pivot) i++;
      while (p[k].at[axis] > pivot) k--;
      if (i <= k) swap(&p[i++], &p[k--]);
    }
    if (at <= k)
      high = k;
    else if (at >= i)
      low = i;
    else
      return;
  }
}

/* As `find`: large ranges are parted as long as that helps. */
static void divide(place *p, size_t low, size_t high, size_t middle) {
  int axis = longest(p, low, high);
  while (high - low > FEW) {
    size_t n = high - low, step = n / 4;
    float pivot =
        middle_of(p[low + step].at[axis], p[low + 2 * step].at[axis], p[low + 3 * step].at[axis]);
    size_t behind = part(p, low, high, pivot, axis);
    if (behind > middle)
      high = behind;
    else
      low = behind;
    if (high - low > n - n / 8) break; /* many are alike */
  }
  find(p, low, high, middle, axis);
}

/* Splits range p of a level, and all ranges within it. */
static void plant(tree *t, int level, size_t p) {
  if (level == t->depth) return;
  divide(t->place, begin_of(t, level, p), begin_of(t, level, p + 1),
         begin_of(t, level + 1, 2 * p + 1));
  plant(t, level + 1, 2 * p);
  plant(t, level + 1, 2 * p + 1);
}

static ylm_status split(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  tree *t = context;
  for (size_t p = begin; p < end; p++)
    divide(t->place, begin_of(t, t->level, p), begin_of(t, t->level, p + 1),
           begin_of(t, t->level + 1, 2 * p + 1));
  return YLM_OK;
}

/* Leaf p of the places in its range. */
static void fill(const tree *t, size_t p) {
  leaf *l = &t->leaf[p];
  size_t begin = begin_of(t, t->depth, p);
  box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  l->n = begin_of(t, t->depth, p + 1) - begin;
  for (size_t k = 0; k < LEAF; k++)
    for (int a = 0; a < 3; a++) {
      uint32_t of = l->of[k] = k < l->n ? t->place[begin + k].of : 0;
      l->at[a][k] = k < l->n ? t->place[begin + k].at[a] : INFINITY;
      l->normal[a][k] = k < l->n ? t->landing[of].normal[a] : 0;
    }
  for (size_t k = 0; k < l->n; k++)
    for (int a = 0; a < 3; a++) {
      b.low[a] = lesser(b.low[a], l->at[a][k]);
      b.high[a] = larger(b.high[a], l->at[a][k]);
    }
  t->box[((size_t)1 << t->depth) + p] = b;
}

/* Subtrees and their leaves. */
static ylm_status grow(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  tree *t = context;
  size_t each = (size_t)1 << (t->depth - t->level);
  for (size_t p = begin; p < end; p++) {
    plant(t, t->level, p);
    for (size_t k = 0; k < each; k++) fill(t, p * each + k);
  }
  return YLM_OK;
}

static ylm_status plant_all(tree *t, int threads) {
  ylm_status s = YLM_OK;
  while (t->n > (size_t)LEAF << t->depth) t->depth++;
  size_t leaves = (size_t)1 << t->depth;
  t->place = ylm_alloc(t->n, sizeof *t->place);
  t->box = ylm_alloc(2 * leaves, sizeof *t->box);
  t->leaf = ylm_alloc(leaves, sizeof *t->leaf);
  if (!t->place || !t->box || !t->leaf) return YLM_ENOMEM;
  for (size_t i = 0; i < t->n; i++) {
    t->place[i].of = (uint32_t)i;
    memcpy(t->place[i].at, t->landing[i].at, sizeof t->place[i].at);
  }
  int subtrees = t->n < APART || ylm_threads(threads) == 1 ? 1 : 4 * ylm_threads(threads);
  for (t->level = 0; s == YLM_OK && 1 << t->level < subtrees && t->level < t->depth; t->level++)
    s = ylm_parallel((size_t)1 << t->level, 1, threads, split, t, NULL, NULL);
  if (s == YLM_OK) s = ylm_parallel((size_t)1 << t->level, 1, threads, grow, t, NULL, NULL);
  for (size_t k = leaves - 1; s == YLM_OK && k > 0; k--)
    for (int a = 0; a < 3; a++) {
      t->box[k].low[a] = lesser(t->box[2 * k].low[a], t->box[2 * k + 1].low[a]);
      t->box[k].high[a] = larger(t->box[2 * k].high[a], t->box[2 * k + 1].high[a]);
    }
  return s;
}

/* -- neighbours ------------------------------------------------------------------- */

/* Neighbours of the lights of a leaf: squares of distances, the least first. */
typedef struct search {
  const tree *t;
  const leaf *of;
  box around;
  size_t looks;
  float most; /* of the last row, over the leaf's lights */
  float d2[NEIGHBOURS][LEAF];
} search;

/* The distance of two boxes, squared: never above that of two places in them, in float as well. */
static inline float apart(const box *a, const box *b) {
  float d2 = 0;
  for (int k = 0; k < 3; k++) {
    float v = larger(0, larger(a->low[k] - b->high[k], b->low[k] - a->high[k]));
    d2 += v * v;
  }
  return d2;
}

/* Whether a light at x with normal n is a neighbour, and at what distance, of each light of a leaf: the square,
   infinity where it is none; false: it is too far for all of them. */
static inline bool weigh(const search *s, const float x[3], const float n[3], float d2[LEAF]) {
  const leaf *a = s->of;
  int nearer = 0;
  for (size_t i = 0; i < LEAF; i++) {
    float v[3] = {x[0] - a->at[0][i], x[1] - a->at[1][i], x[2] - a->at[2][i]};
    float d = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    float up = v[0] * a->normal[0][i] + v[1] * a->normal[1][i] + v[2] * a->normal[2][i];
    float facing = a->normal[0][i] * n[0] + a->normal[1][i] * n[1] + a->normal[2][i] * n[2];
    d2[i] = (facing >= FACING) & (up * up <= FLAT2 * d) ? d : INFINITY;
    nearer |= d2[i] < s->d2[NEIGHBOURS - 1][i];
  }
  return nearer;
}

/* Looks at the lights of a leaf for all lights of the search. */
static void look(search *s, const leaf *b) {
  for (size_t k = 0; k < b->n; k++) {
    float d2[LEAF], x[3] = {b->at[0][k], b->at[1][k], b->at[2][k]},
                    n[3] = {b->normal[0][k], b->normal[1][k], b->normal[2][k]};
    if (!weigh(s, x, n, d2)) continue;
    if (s->of == b) d2[k] = INFINITY; /* itself */
    for (size_t i = 0; i < LEAF; i++) /* of all at once: without branches */
      for (int row = 0; row < NEIGHBOURS; row++) {
        float old = s->d2[row][i];
        s->d2[row][i] = lesser(old, d2[i]);
        d2[i] = larger(old, d2[i]);
      }
  }
  s->looks += b->n;
  s->most = -INFINITY;
  for (size_t i = 0; i < s->of->n; i++) s->most = larger(s->most, s->d2[NEIGHBOURS - 1][i]);
}

/* Looks at all leaves below a node that are near enough, at nearer ones first. */
static void walk(search *s, size_t node) {
  const tree *t = s->t;
  size_t stack[LEVELS + 1], n = 0, leaves = (size_t)1 << t->depth;
  stack[n++] = node;
  while (n > 0) {
    size_t k = stack[--n];
    if (s->looks >= MOST_LOOKS || !(apart(&s->around, &t->box[k]) < s->most)) continue;
    if (k >= leaves) {
      look(s, &t->leaf[k - leaves]);
      continue;
    }
    size_t first = apart(&s->around, &t->box[2 * k + 1]) < apart(&s->around, &t->box[2 * k]);
    stack[n++] = 2 * k + !first;
    stack[n++] = 2 * k + first;
  }
}

static double radius_of(const search *s, size_t i) {
  int found = NEIGHBOURS;
  while (found > 0 && !(s->d2[found - 1][i] < INFINITY)) found--;
  return found ? s->t->scale * sqrt((double)s->d2[found - 1][i] / (double)found) : 0;
}

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  (void)worker;
  const tree *t = context;
  size_t leaves = (size_t)1 << t->depth;
  for (size_t p = begin; p < end; p++) {
    search s = {.t = t, .of = &t->leaf[p], .around = t->box[leaves + p]};
    for (int row = 0; row < NEIGHBOURS; row++)
      for (size_t i = 0; i < LEAF; i++) s.d2[row][i] = INFINITY;
    look(&s, s.of);
    for (size_t k = leaves + p; k > 1; k /= 2) walk(&s, k ^ 1);
    for (size_t i = 0; i < s.of->n; i++) t->radius[s.of->of[i]] = radius_of(&s, i);
  }
  return YLM_OK;
}

ylm_status ylm__emit_density(size_t n, const emit_landing *landing, const ylm_emit_options *o,
                             double *radius) {
  tree t = {.n = n, .landing = landing, .scale = o->scale, .radius = radius};
  ylm_status s = plant_all(&t, o->threads);
  if (s == YLM_OK)
    s = ylm_parallel((size_t)1 << t.depth, GRAIN, o->threads, run, &t, o->progress, "radius");
  ylm_free(t.place);
  ylm_free(t.box);
  ylm_free(t.leaf);
  return s;
}
