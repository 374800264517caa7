/*
** walk.h - which nodes of the tree of lights are far enough from a box of points, in float and
** the tree's units; a vector of nodes at a time. Included by moments/sum.isa.c.
*/

#define SIDE (YLM_VF / YLM__GROUP) /* groups in a vector */

/* Groups that a packet may leave to its points, and a block to its packets. */
#define LEFT 1024
/* In a list: this group but for its first or its second node. */
#define NOT_FIRST 0x80000000u
#define NOT_SECOND 0x40000000u
/* Groups on the stack that are taken several at a time: those left are there from the start. */
#define BROAD (2 * LEFT)
/* Sizes of blocks in each other, of which each has a quarter of the points of the next. */
#define LEVELS 4
/* Nodes that are noted before they are summed. */
#define NOTES 256

/* A box as the tests see it: a packet's, or one point. */
typedef struct seen_from {
  float x[3], half[3], radius; /* middle, half of its edges and of its diagonal */
  float allowed[3];            /* B_k of tree.h */
  float part[3], error[3];     /* errors: of the norm of the lights' own sum, and in all */
  float skip;                  /* beyond this distance Hessians are negligible */
  float nearest;               /* of what a block interpolates; 0 for packets and points */
  float strong[3];             /* 1 over what is too strong for that at this distance */
  int power;                   /* by which errors of interpolation fall with the distance, halved */
  bool pilot;
} seen_from;

/* Parts of a block, and vectors of them. */
#define PARTS 64
#define SEEN (PARTS / YLM_VF)

/* The points of a packet, or balls with parts of a block, lanes beside each other. */
typedef struct seen_by {
  int vectors;
  ylm_vf x[SEEN][3], radius[SEEN], allowed[SEEN][3], skip[SEEN];
} seen_by;

/* Kinds of sums: lights of a leaf, four or eight proxies of a node, or one light for a node. With
   OF_DIM added their Hessians are negligible. */
enum { OF_LEAF, OF_FEW, OF_MANY, OF_WHOLE, OF_DIM, KINDS = 2 * OF_DIM };

/* Results of a walk, kind by kind: leaves with their number of lights as in ylm__group, blocks of
   proxies, or nodes, group times YLM__GROUP plus place. Lists have room for one entry that is not
   noted. */
typedef struct note_lists {
  size_t all, n[KINDS];
  uint32_t at[KINDS][NOTES + 1];
} note_lists;

typedef struct tree_walk {
  const ylm__tree_plan *plan;
  uint32_t *stack;
  size_t top, n_left;
  uint64_t lights_left;
  bool too_many;       /* more than there was room for */
  uint32_t left[LEFT]; /* groups that are smaller than the packet and in or near it, or nodes that
                          are too near for a block */
  note_lists notes;
} tree_walk;

/* A field of groups side by side. */
YLM_INLINE ylm_vf side_by_side(const ylm__group *const *g, size_t offset) {
  _Static_assert(YLM__GROUP * sizeof(float) == sizeof(int64_t), "a field of a group is one number");
  ylm_vl v = {0};
  for (size_t i = 0; i < SIDE; i++) {
    int64_t pair;
    memcpy(&pair, (const char *)g[i] + offset, sizeof pair);
    v[i] = pair;
  }
  return (ylm_vf)v;
}
#define FIELD(name) side_by_side(g, offsetof(ylm__group, name))
#define FIELD_OF(name, s)                                                                          \
  side_by_side(g, offsetof(ylm__group, name) + (size_t)(s) * sizeof g[0]->name[0])

/* How far coordinates are from the middle of an interval beyond its ends; 0 inside. */
YLM_INLINE ylm_vf beyond(ylm_vf x, float middle, float half) {
  x -= middle;
  x = ylm_vf_select(x > 0, x, -x) - half;
  return ylm_vf_select(x > 0, x, (ylm_vf){0});
}

/* A vector of nodes, and masks of what becomes of them. */
typedef struct node_vector {
  size_t n; /* groups */
  uint32_t at[SIDE];
  const ylm__group *g[SIDE];
  int32_t absent[YLM_VF], closed[YLM_VF], dim[YLM_VF], small[YLM_VF];
} node_vector;

/* Masks of the nodes that need not be opened, of those whose Hessians are negligible, and of those
   that are small beside the box. */
static void test_groups(const ylm__tree_plan *p, const seen_from *from, node_vector *v) {
  const ylm__group *const *g = v->g;
  ylm_vf x = beyond(FIELD(at[0]), from->x[0], from->half[0]);
  ylm_vf y = beyond(FIELD(at[1]), from->x[1], from->half[1]);
  ylm_vf z = beyond(FIELD(at[2]), from->x[2], from->half[2]);
  ylm_vf d = ylm_vf_sqrt(x * x + y * y + z * z), u = 1 / d, reach = FIELD(reach);
  ylm_vi far = reach <= (from->pilot ? p->pilot_widest : p->widest) * d,
         away = d - reach > from->skip, little = reach < YLM__LITTLE * from->radius;
  if (!from->pilot) {
    ylm_vf second = {0}, third = {0}, strength = {0}, fourth = FIELD(fourth), power = ylm_vf_set(1);
    int at = -1;
    for (int k = 0; k < 3; k++, power *= u) {
      if (!p->want[k]) continue;
      if (p->at[k] != at) {
        at = p->at[k];
        second = FIELD_OF(second, at), third = FIELD_OF(third, at);
        strength = FIELD_OF(strength, at);
      }
      const float *c = p->c[k];
      ylm_vf missed = c[0] * second + u * (c[1] * third + u * (c[2] * fourth * strength));
      missed *= u * u * u;
      ylm_vi good = missed * missed * power <= from->allowed[k] * strength;
      far &= k < 2 ? good : good | away;
    }
  }
  ylm_vi absent;
  memcpy(&absent, v->absent, sizeof absent);
  far |= absent, little &= ~absent;
  memcpy(v->closed, &far, sizeof far);
  memcpy(v->dim, &away, sizeof away);
  memcpy(v->small, &little, sizeof little);
}

YLM_INLINE bool everywhere(ylm_vi mask) {
#if defined(__AVX512F__)
  return _mm512_movepi32_mask((__m512i)mask) == 0xFFFF;
#else
  int32_t each[YLM_VF], all = -1;
  memcpy(each, &mask, sizeof mask);
  for (int i = 0; i < YLM_VF; i++) all &= each[i];
  return all != 0;
#endif
}

/* The tests of test_groups for one node, point by point: a box is nearer than its points. */
static bool test_points(const ylm__tree_plan *p, const ylm__group *g, int i, const seen_by *by,
                        int32_t *dim) {
  bool closed = true, all_away = true;
  for (int v = 0; v < by->vectors && closed; v++) {
    ylm_vf x = g->at[0][i] - by->x[v][0], y = g->at[1][i] - by->x[v][1];
    ylm_vf z = g->at[2][i] - by->x[v][2], d = ylm_vf_sqrt(x * x + y * y + z * z);
    d = ylm_vf_select(d > by->radius[v], d - by->radius[v], (ylm_vf){0});
    ylm_vf u = 1 / d;
    ylm_vi far = g->reach[i] <= p->widest * d, away = d - g->reach[i] > by->skip[v];
    ylm_vf power = ylm_vf_set(1);
    for (int k = 0; k < 3; k++) {
      int s = p->at[k];
      const float *c = p->c[k];
      float strength = g->strength[s][i];
      ylm_vf missed = c[0] * g->second[s][i] +
                      u * (c[1] * g->third[s][i] + u * (c[2] * g->fourth[i] * strength));
      missed *= u * u * u;
      ylm_vi good = missed * missed * power <= by->allowed[v][k] * strength;
      if (p->want[k]) far &= k < 2 ? good : good | away;
      power *= u;
    }
    closed = everywhere(far), all_away = all_away && everywhere(away);
  }
  *dim = all_away;
  return closed;
}

static void walk_from(tree_walk *w, const uint32_t *groups, size_t n) {
  memcpy(w->stack, groups, n * sizeof *groups);
  w->top = n;
}

/* Nodes that are too near for the box of a packet may not be for its points. */
static void test_again(const ylm__tree_plan *p, const seen_by *by, node_vector *v) {
  for (int i = 0; i < YLM_VF; i++) {
    const ylm__group *g = v->g[i / YLM__GROUP];
    uint32_t child = g->child[i % YLM__GROUP];
    bool few = child & YLM__IS_LEAF && (child >> YLM__COUNT_AT & 15) <= YLM__PROXIES;
    if (!v->closed[i] && !few) v->closed[i] = -test_points(p, g, i % YLM__GROUP, by, &v->dim[i]);
  }
}

/* Leaves small nodes that are to be opened to the points, as far as there is room. */
static void leave(tree_walk *w, node_vector *v) {
  for (int i = 0; i < YLM_VF; i++) {
    const ylm__group *g = v->g[i / YLM__GROUP];
    uint32_t child = g->child[i % YLM__GROUP];
    if (v->closed[i] || child & YLM__IS_LEAF || w->n_left == LEFT) v->small[i] = 0;
    if (!v->small[i]) continue;
    w->left[w->n_left++] = child;
    w->lights_left += g->lights[i % YLM__GROUP];
  }
}

#include "near.h"

/* Puts each node on the stack or among the notes; without branches, which are unpredictable. */
YLM_INLINE void sort_nodes(tree_walk *w, const node_vector *v, const bool pilot, const bool left) {
  const ylm__group *group = w->plan->tree->group, *const *g = v->g;
  note_lists *notes = &w->notes;
  ylm_vi child = (ylm_vi)FIELD(child), closed, dim, small, absent, kind, at, leaf = child < 0;
  memcpy(&absent, v->absent, sizeof absent);
  ylm_vi lights = child >> YLM__COUNT_AT & 15, none = (leaf & (lights == 0)) | absent;
  memcpy(&closed, v->closed, sizeof closed);
  memcpy(&dim, v->dim, sizeof dim);
  memcpy(&small, v->small, sizeof small);
  ylm_vi down = ~closed & ~leaf, take = ~down & ~none;
  ylm_vi each = ~closed | (leaf & (lights <= (pilot ? 1 : YLM__PROXIES))); /* a leaf's lights */
  if (pilot) {
    for (int i = 0; i < YLM_VF; i++)
      at[i] = (int32_t)(v->at[i / YLM__GROUP] * YLM__GROUP) + i % YLM__GROUP;
    kind = ~each & OF_WHOLE;
  } else {
    ylm_vi proxies = (ylm_vi)FIELD(proxies);
    kind = (~each & (OF_FEW + (proxies & 1))) + (dim & OF_DIM);
    at = proxies >> 1 & INT32_MAX;
  }
  at = (at & ~each) | (child & each);
  int32_t downs[YLM_VF], takes[YLM_VF], kinds[YLM_VF], ats[YLM_VF], children[YLM_VF];
  if (left) down &= ~small, take &= ~small;
  memcpy(downs, &down, sizeof down);
  memcpy(takes, &take, sizeof take);
  memcpy(kinds, &kind, sizeof kind);
  memcpy(ats, &at, sizeof at);
  memcpy(children, &child, sizeof child);
  for (int i = 0; i < YLM_VF; i++) {
    const ylm__group *below = &group[children[i] & downs[i]];
    w->stack[w->top] = (uint32_t)children[i];
    w->top -= (size_t)(ptrdiff_t)downs[i];
    __builtin_prefetch(below);
    if (!pilot) __builtin_prefetch(below->second);
    notes->at[kinds[i]][notes->n[kinds[i]]] = (uint32_t)ats[i];
    notes->n[kinds[i]] -= (size_t)(ptrdiff_t)takes[i];
    notes->all -= (size_t)(ptrdiff_t)takes[i];
  }
}

/* Takes groups off the stack, a vector of them or, where it is long, one: so it stays short. */
static void pop(tree_walk *w, node_vector *v) {
  size_t most = w->top > BROAD - 2 * YLM_VF ? 1 : SIDE;
  v->n = w->top < most ? w->top : most;
  for (size_t i = 0; i < SIDE; i++) {
    uint32_t at = i < v->n ? w->stack[--w->top] : 0;
    v->at[i] = at & ~(NOT_FIRST | NOT_SECOND);
    v->g[i] = &w->plan->tree->group[v->at[i]];
    v->absent[YLM__GROUP * i] = -(int32_t)(at / NOT_FIRST);
    v->absent[YLM__GROUP * i + 1] = -(int32_t)(at / NOT_SECOND & 1);
  }
}

/* Goes on until NOTES nodes are noted, or none is left; how many there are. Groups are taken off
   the stack one turn before they are looked at: meanwhile they come from memory. */
static size_t walk_on(tree_walk *w, const seen_from *from, const seen_by *by) {
  node_vector now, next;
  memset(w->notes.n, 0, sizeof w->notes.n);
  w->notes.all = 0;
  pop(w, &now);
  while (now.n && w->notes.all <= NOTES - YLM_VF) {
    pop(w, &next);
    test_groups(w->plan, from, &now);
    if (by) test_again(w->plan, by, &now);
    if (from->nearest > 0)
      leave_nodes(w, from, &now);
    else if (from->radius > 0)
      leave(w, &now);
    if (from->pilot)
      sort_nodes(w, &now, true, from->radius > 0);
    else
      sort_nodes(w, &now, false, from->radius > 0);
    if (!next.n) pop(w, &next);
    now = next;
  }
  for (size_t i = 0; i < now.n; i++)
    w->stack[w->top++] = now.at[i] | (now.absent[YLM__GROUP * i] ? NOT_FIRST : 0) |
                         (now.absent[YLM__GROUP * i + 1] ? NOT_SECOND : 0);
  return w->notes.all;
}
