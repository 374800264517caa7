/*
** walk.h - a walk down the tree of lights, which notes the nodes that are far enough from a box of
** points. The walk is in float and in the tree's units for either element type: walk.isa.c.
*/
#ifndef YLM_LIGHT_TREE_WALK_H
#define YLM_LIGHT_TREE_WALK_H

#include "tree.h"
#include "ylm_simd.h"

/* In a list: this group but for its first or its second node. */
#define NOT_FIRST 0x80000000u
#define NOT_SECOND 0x40000000u
/* Groups on the stack that are taken several at a time: those left are there from the start. */
#define BROAD (2 * LEFT)

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

/* Vectors of the parts of a block. */
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

/* Begins a walk at groups. */
YLM_INLINE void walk_from(tree_walk *w, const uint32_t *groups, size_t n) {
  memcpy(w->stack, groups, n * sizeof *groups);
  w->top = n;
}

/* Goes on until NOTES nodes are noted, or none is left; how many there are. `by`: the points of the
   box, or NULL. */
size_t YLM_KERNEL(ylm__walk_on)(tree_walk *w, const seen_from *from, const seen_by *by);
#define walk_on YLM_KERNEL(ylm__walk_on)

#endif
