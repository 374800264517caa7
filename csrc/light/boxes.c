/* boxes.c - which boxes meet the surface of a light: a tree of boxes around lights. */
#include "calibration.h"
#include "light.h"

#include <math.h>

#include "flat/gen/crossing.h"

/* Deeper than any tree that halves. */
#define DEPTH 64

/* A node holds the lights order[begin] .. order[end-1]; its first child follows it. */
typedef struct node {
  double box[6];
  size_t begin, end, second; /* second: the other child, 0 for a leaf */
} node;

typedef struct tree {
  const ylm__lamp_d *lamps;
  node *nodes;
  uint32_t *order;
  size_t count;
} tree;

static bool meets(const double *box, const ylm__lamp_d *l) {
  return sphere_meets(l->at, l->radius, box, box + 3);
}

static bool overlaps(const double *a, const double *b) {
  for (int i = 0; i < 3; i++)
    if (a[i] > b[3 + i] || b[i] > a[3 + i]) return false;
  return true;
}

static void enclose(const tree *t, node *k) {
  for (int a = 0; a < 3; a++) k->box[a] = INFINITY, k->box[3 + a] = -INFINITY;
  for (size_t i = k->begin; i < k->end; i++) {
    const ylm__lamp_d *l = &t->lamps[t->order[i]];
    for (int a = 0; a < 3; a++) {
      k->box[a] = fmin(k->box[a], l->at[a] - l->radius);
      k->box[3 + a] = fmax(k->box[3 + a], l->at[a] + l->radius);
    }
  }
}

/* Partial sort: order[middle] gets its place along the axis, smaller ones before it. */
static void select_middle(tree *t, size_t begin, size_t end, size_t middle, int axis) {
  while (end - begin > 1) {
    double pivot = t->lamps[t->order[begin + (end - begin - 1) / 2]].at[axis];
    size_t i = begin, j = end - 1;
    for (;;) {
      while (t->lamps[t->order[i]].at[axis] < pivot) i++;
      while (t->lamps[t->order[j]].at[axis] > pivot) j--;
      if (i >= j) break;
      uint32_t swap = t->order[i];
      t->order[i++] = t->order[j], t->order[j--] = swap;
    }
    if (middle <= j)
      end = j + 1;
    else
      begin = j + 1;
  }
}

/* Makes the node of lights begin .. end-1 and all below it. */
static void build(tree *t, size_t begin, size_t end) {
  node *k = &t->nodes[t->count++];
  *k = (node){.begin = begin, .end = end};
  enclose(t, k);
  if (end - begin <= CROSSES_LEAF) return;
  int axis = 0;
  for (int a = 1; a < 3; a++)
    if (k->box[3 + a] - k->box[a] > k->box[3 + axis] - k->box[axis]) axis = a;
  size_t middle = begin + (end - begin) / 2;
  select_middle(t, begin, end, middle, axis);
  build(t, begin, middle);
  k->second = t->count;
  build(t, middle, end);
}

/* Does the box meet any light? */
static bool any_meets(const tree *t, const double *box) {
  size_t stack[DEPTH], top = 0, at = 0;
  for (;;) {
    const node *k = &t->nodes[at];
    bool inner = overlaps(k->box, box);
    if (inner && k->second) {
      stack[top++] = k->second;
      at++;
      continue;
    }
    for (size_t i = k->begin; inner && i < k->end; i++)
      if (meets(box, &t->lamps[t->order[i]])) return true;
    if (top == 0) return false;
    at = stack[--top];
  }
}

typedef struct job {
  const ylm_lights *lights;
  const tree *tree; /* NULL: light by light */
  const double *boxes;
  uint8_t *out;
} job;

static ylm_status run(void *context, size_t begin, size_t end, int worker) {
  const job *j = context;
  (void)worker;
  for (size_t i = begin; i < end; i++) {
    double box[6];
    for (int a = 0; a < 6; a++) box[a] = j->boxes[6 * i + (size_t)a] - j->lights->origin[a % 3];
    bool found = j->tree && any_meets(j->tree, box);
    for (size_t k = 0; !j->tree && !found && k < j->lights->active; k++)
      found = meets(box, &j->lights->lamp_d[k]);
    j->out[i] = found;
  }
  return YLM_OK;
}

ylm_status ylm__crosses(const ylm_field *f, size_t n, const double *boxes, uint8_t *out) {
  const ylm_lights *l = f->self;
  job j = {.lights = l, .boxes = boxes, .out = out};
  if (l->active <= CROSSES_LEAF || n < CROSSES_FEW / l->active || l->active > UINT32_MAX)
    return ylm_parallel(n, CROSSES_GRAIN, 1, run, &j, NULL, NULL);
  tree t = {.lamps = l->lamp_d};
  t.nodes = ylm_alloc(l->active, sizeof *t.nodes); /* leaves hold more than two lights */
  t.order = ylm_alloc(l->active, sizeof *t.order);
  ylm_status s = YLM_ENOMEM;
  if (t.nodes && t.order) {
    for (size_t i = 0; i < l->active; i++) t.order[i] = (uint32_t)i;
    build(&t, 0, l->active);
    j.tree = &t;
    s = ylm_parallel(n, CROSSES_GRAIN, 0, run, &j, NULL, NULL);
  }
  ylm_free(t.nodes);
  ylm_free(t.order);
  return s;
}
