/* alias.h - alias tables: n columns of equal width, each filled by its own item and by one other, which
   has more than its share. Private to csrc/scene. */
#ifndef YLM_SCENE_ALIAS_H
#define YLM_SCENE_ALIAS_H

#include "ylm_base.h"

/*
** ylm__alias_fill - the table of n items.
**
**   height  in   [n]  n times the items' shares; changed
**   list         [n]  room
**   stay    out  [n]  of column i that item i keeps
**   other   out  [n]  the item that has the rest of it
**
** Source  Walker 1977, "An Efficient Method for Generating Discrete Random Variables with General
**         Distributions"; Vose 1991, "A Linear Algorithm for Generating Random Numbers with a Given
**         Distribution"
*/
void ylm__alias_fill(size_t n, double *height, uint32_t *list, float *stay, uint32_t *other);

#endif
