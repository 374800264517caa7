/*
** walk.isa.c - which nodes of the tree of lights are far enough from a box of points; a vector of
** nodes at a time.
*/
#include "near.h"

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

/* Groups are taken off the stack one turn before they are looked at: memory has that turn to
   deliver them. */
size_t YLM_KERNEL(ylm__walk_on)(tree_walk *w, const seen_from *from, const seen_by *by) {
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
