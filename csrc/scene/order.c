/* order.c - lamps put into the order of the tree of lamps: halved across the longest extent of their
   places, at a multiple of what a node holds, until a leaf is left. */
#include "calibration.h"
#include "tree.h"

#define MOST_PIECES (4 * ORDER_PARTS)

typedef struct range {
  size_t begin, end;
} range;

typedef struct pieces {
  scene_item *item;
  size_t n, largest;
  range range[MOST_PIECES];
} pieces;

static int longest_axis(const scene_item *item, range r) {
  float lo[3], hi[3];
  int axis = 0;
  for (int a = 0; a < 3; a++) lo[a] = hi[a] = item[r.begin].x[a];
  for (size_t i = r.begin + 1; i < r.end; i++)
    for (int a = 0; a < 3; a++) {
      float x = item[i].x[a];
      lo[a] = x < lo[a] ? x : lo[a];
      hi[a] = x > hi[a] ? x : hi[a];
    }
  for (int a = 1; a < 3; a++)
    if (hi[a] - lo[a] > hi[axis] - lo[axis]) axis = a;
  return axis;
}

static float middle_of(float a, float b, float c) {
  float lo = a < b ? a : b, hi = a < b ? b : a;
  return c < lo ? lo : c > hi ? hi : c;
}

/* Puts those below the pivot first, without a branch on them; returns where the others begin. */
static size_t part(scene_item *item, range r, float pivot, int axis) {
  size_t at = r.begin;
  for (size_t i = r.begin; i < r.end; i++) {
    scene_item t = item[i];
    item[i] = item[at];
    item[at] = t;
    at += t.x[axis] < pivot;
  }
  return at;
}

/* Puts the smallest of a range along an axis before `at`. Source: Hoare 1961, "Algorithm 65: Find". */
static void separate_few(scene_item *item, range r, size_t at, int axis) {
  ptrdiff_t lo = (ptrdiff_t)r.begin, hi = (ptrdiff_t)r.end - 1, middle = (ptrdiff_t)at;
  while (lo < hi) {
    float pivot = middle_of(item[lo].x[axis], item[lo + (hi - lo) / 2].x[axis], item[hi].x[axis]);
    ptrdiff_t i = lo, k = hi;
    while (i <= k) {
      while (item[i].x[axis] < pivot) i++;
      while (item[k].x[axis] > pivot) k--;
      if (i > k) break;
      scene_item t = item[i];
      item[i++] = item[k];
      item[k--] = t;
    }
    if (middle <= k)
      hi = k;
    else if (middle >= i)
      lo = i;
    else
      return;
  }
}

/* The middle one of nine all over a range. */
static float pivot_of(const scene_item *item, range r, int axis) {
  float x[3];
  size_t step = (r.end - r.begin - 1) / 8;
  for (size_t i = 0; i < 3; i++) {
    const scene_item *p = item + r.begin + 3 * i * step;
    x[i] = middle_of(p[0].x[axis], p[step].x[axis], i < 2 ? p[2 * step].x[axis] : p[step].x[axis]);
  }
  return middle_of(x[0], x[1], x[2]);
}

/* As separate_few: large ranges are parted as long as that helps. */
static void separate(scene_item *item, range r, size_t at, int axis) {
  while (r.end - r.begin > ORDER_FEW) {
    size_t n = r.end - r.begin, behind = part(item, r, pivot_of(item, r, axis), axis);
    if (behind > at)
      r.end = behind;
    else
      r.begin = behind;
    if (r.end - r.begin > n - n / 8) break; /* many are alike */
  }
  separate_few(item, r, at, axis);
}

/* Where a range is halved: its first half is full nodes of the highest level that has several in it. */
static size_t halve(scene_item *item, range r) {
  size_t n = r.end - r.begin, holds = SCENE_WIDTH;
  while (holds * SCENE_WIDTH < n) holds *= SCENE_WIDTH;
  size_t at = r.begin + (n + holds - 1) / holds / 2 * holds;
  separate(item, r, at, longest_axis(item, r));
  return at;
}

static void order(scene_item *item, range r) {
  while (r.end - r.begin > SCENE_WIDTH) {
    size_t at = halve(item, r);
    order(item, (range){r.begin, at});
    r.begin = at;
  }
}

/* Halves large ranges, and notes the others. */
static void cut(pieces *p, range r) {
  while (r.end - r.begin > p->largest) {
    size_t at = halve(p->item, r);
    cut(p, (range){r.begin, at});
    r.begin = at;
  }
  p->range[p->n++] = r;
}

static ylm_status order_pieces(void *context, size_t begin, size_t end, int worker) {
  const pieces *p = context;
  (void)worker;
  for (size_t i = begin; i < end; i++) order(p->item, p->range[i]);
  return YLM_OK;
}

ylm_status ylm__scene_order(size_t n, scene_item *item) {
  pieces p = {.item = item,
              .largest = n / ORDER_PARTS < ORDER_PIECE ? ORDER_PIECE : n / ORDER_PARTS};
  if (n == 0) return YLM_OK;
  cut(&p, (range){0, n});
  return ylm_parallel(p.n, 1, p.n > 1 ? 0 : 1, order_pieces, &p, NULL, NULL);
}
