/*
** tree_walk.h - which nodes of the tree of lights are far enough from a box of points, in float and
** the tree's units; a vector of nodes at a time. Included by sum.isa.c.
*/

#define SIDE (YLM_VF / YLM__GROUP) /* groups in a vector */

/* Groups that a packet may leave to its points. */
#define LEFT 1024
/* Groups on the stack that are taken several at a time: those left are there from the start. */
#define BROAD (2 * LEFT)
/* Nodes that are noted before they are summed. */
#define NOTES 256

/* A box as the tests see it: a packet's, or one point. */
typedef struct seen_from {
  float x[3], half[3], radius; /* middle, half of its edges and of its diagonal */
  float allowed[3];            /* B_k of tree.h */
  float skip;                  /* beyond this distance Hessians are negligible */
  bool pilot;
} seen_from;

/* Vectors of a packet's points. */
#define SEEN (YLM__PACKET > YLM_VF ? YLM__PACKET / YLM_VF : 1)

/* The points of a packet, lanes beside each other. */
typedef struct seen_by {
  int vectors;
  ylm_vf x[SEEN][3], allowed[SEEN][3], skip[SEEN];
} seen_by;

/* What is to be summed: lights of a leaf, proxies of a node, or one light for a node. */
enum { OF_LEAF, OF_PROXIES, OF_WHOLE };
typedef struct note {
  uint32_t index; /* leaf, or node: group times YLM__GROUP plus place */
  uint8_t what, count;
  bool dim; /* its Hessians are negligible */
} note;

typedef struct tree_walk {
  const ylm__tree_plan *plan;
  uint32_t *stack;
  size_t top, noted, n_left;
  uint64_t lights_left;
  uint32_t left[LEFT]; /* groups that are smaller than the packet and in or near it */
  note notes[NOTES];
} tree_walk;

/* A field of groups side by side. */
YLM_INLINE ylm_vf side_by_side(const ylm__group *const *g, size_t offset) {
  ylm_vf v;
  for (size_t i = 0; i < SIDE; i++)
    memcpy((char *)&v + YLM__GROUP * sizeof(float) * i, (const char *)g[i] + offset,
           YLM__GROUP * sizeof(float));
  return v;
}
#define FIELD(name) side_by_side(g, offsetof(ylm__group, name))

/* How far coordinates are from the middle of an interval beyond its ends; 0 inside. */
YLM_INLINE ylm_vf beyond(ylm_vf x, float middle, float half) {
  x -= middle;
  x = ylm_vf_select(x > 0, x, -x) - half;
  return ylm_vf_select(x > 0, x, (ylm_vf){0});
}

/* Masks of the nodes that need not be opened, of those whose Hessians are negligible, and of those
   that are small beside the box. */
static void test_groups(const ylm__tree_plan *p, const ylm__group *const *g, const seen_from *from,
                        int32_t *closed, int32_t *dim, int32_t *small) {
  ylm_vf x = beyond(FIELD(at[0]), from->x[0], from->half[0]);
  ylm_vf y = beyond(FIELD(at[1]), from->x[1], from->half[1]);
  ylm_vf z = beyond(FIELD(at[2]), from->x[2], from->half[2]);
  ylm_vf d = ylm_vf_sqrt(x * x + y * y + z * z), u = 1 / d, reach = FIELD(reach);
  ylm_vi far = reach <= (from->pilot ? p->pilot_widest : p->widest) * d,
         away = d - reach > from->skip, little = reach < YLM__LITTLE * from->radius;
  if (!from->pilot) {
    ylm_vf second[2] = {FIELD(second[0]), FIELD(second[1])},
           third[2] = {FIELD(third[0]), FIELD(third[1])};
    ylm_vf strength[2] = {FIELD(strength[0]), FIELD(strength[1])}, fourth = FIELD(fourth);
    ylm_vf power = ylm_vf_set(1);
    for (int k = 0; k < 3; k++) {
      int s = p->at[k];
      const float *c = p->c[k];
      ylm_vf missed = c[0] * second[s] + u * (c[1] * third[s] + u * (c[2] * fourth * strength[s]));
      missed *= u * u * u;
      ylm_vi good = missed * missed * power <= from->allowed[k] * strength[s];
      if (p->want[k]) far &= k < 2 ? good : good | away;
      power *= u;
    }
  }
  memcpy(closed, &far, sizeof far);
  memcpy(dim, &away, sizeof away);
  memcpy(small, &little, sizeof little);
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
    ylm_vf z = g->at[2][i] - by->x[v][2], d = ylm_vf_sqrt(x * x + y * y + z * z), u = 1 / d;
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

/* Goes on until NOTES nodes are noted, or none is left; how many there are. */
static size_t walk_on(tree_walk *w, const seen_from *from, const seen_by *by) {
  const ylm_light_tree *t = w->plan->tree;
  uint32_t *stack = w->stack;
  w->noted = 0;
  while (w->top && w->noted <= NOTES - YLM_VF) {
    const ylm__group *g[SIDE];
    uint32_t at[SIDE];
    int32_t closed[YLM_VF], dim[YLM_VF], small[YLM_VF];
    int most = w->top > BROAD - YLM_VF ? 1 : SIDE; /* one by one the stack stays short */
    for (int i = 0; i < SIDE; i++) {
      at[i] = i < most && w->top ? stack[--w->top] : 0;
      g[i] = &t->group[at[i]];
    }
    test_groups(w->plan, g, from, closed, dim, small);
    for (int i = 0; i < YLM_VF; i++) {
      int place = i % YLM__GROUP;
      uint32_t child = g[i / YLM__GROUP]->child[place];
      uint32_t few = child & YLM__IS_LEAF ? child >> YLM__COUNT_AT & 15 : UINT32_MAX;
      note *next = &w->notes[w->noted];
      if (few == 0) continue;
      if (!closed[i] && by && few > YLM__PROXIES)
        closed[i] = test_points(w->plan, g[i / YLM__GROUP], place, by, &dim[i]);
      if (few == UINT32_MAX && !closed[i]) {
        if (small[i] && w->n_left < LEFT) {
          w->left[w->n_left++] = child;
          w->lights_left += g[i / YLM__GROUP]->lights[place];
        } else
          stack[w->top++] = child;
        continue;
      }
      *next = (note){at[i / YLM__GROUP] * YLM__GROUP + (uint32_t)place, OF_WHOLE, 1, dim[i] != 0};
      if (!closed[i] || few <= (from->pilot ? 1 : YLM__PROXIES))
        next->what = OF_LEAF, next->index = child & YLM__LEAF_MASK, next->count = (uint8_t)few;
      else if (!from->pilot)
        next->what = OF_PROXIES, next->count = YLM__PROXIES;
      w->noted++;
    }
  }
  return w->noted;
}
