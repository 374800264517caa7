/*
** ylm_list.h - arrays that grow, and arrays of members that are joined.
**
** A list is a pointer that its owner declares with its type, NULL at first, and frees with ylm_free.
** `list` is the pointer's address; `size` are the bytes of an item. Items stay where memory runs out.
*/
#ifndef YLM_LIST_H
#define YLM_LIST_H

#include "ylm_base.h"

/* Room for exactly `room` items in a list that has `used`. False: memory ran out. */
YLM_API bool ylm_list_resize(void *list, size_t used, size_t room, size_t size);

/* The room to make for `wanted` items: `room` where these fit, else at least twice that. */
static inline size_t ylm_list_room(size_t room, size_t wanted) {
  size_t next = room < 32 ? 64 : 2 * room;
  return wanted <= room ? room : wanted <= next ? next : wanted;
}

/*
** ylm_list_reserve - make room for `wanted` items.
**
**   list    in/out  address of the pointer
**   used    in      items to keep
**   wanted  in      items there is to be room for
**   room    in/out  items there is room for, 0 at first; grows by doubling
**   size    in      bytes of an item
**
** Returns false where memory runs out.
*/
static inline bool ylm_list_reserve(void *list, size_t used, size_t wanted, size_t *room,
                                    size_t size) {
  if (wanted <= *room) return true;
  size_t next = ylm_list_room(*room, wanted);
  if (!ylm_list_resize(list, used, next, size)) return false;
  *room = next;
  return true;
}

/* The first of the members that are joined to i: to[i] is another one, of the first itself. Ways are halved. */
static inline uint32_t ylm_list_root(uint32_t *to, uint32_t i) {
  while (to[i] != i) i = to[i] = to[to[i]];
  return i;
}

#endif
