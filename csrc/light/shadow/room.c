/* room.c - memory that grows with a block. */
#include "shadow.h"

bool ylm__shadow_grow(void **list, size_t n, size_t *room, size_t size) {
  size_t more = *room ? 2 * *room : 256;
  void *p = ylm_realloc(*list, n * size, more, size);
  if (!p) return false;
  *list = p;
  *room = more;
  return true;
}

bool ylm__shadow_have(void **list, size_t n, size_t *room, size_t size) {
  if (*list && n <= *room) return true;
  ylm_free(*list);
  *list = ylm_alloc(n, size);
  *room = *list ? n : 0;
  return *list != NULL;
}

void *ylm__shadow_room(const shadow_query *w, int worker, int which, size_t bytes) {
  shadow_room *r = &w->room[(size_t)worker * ROOMS + (size_t)which];
  if (r->bytes < bytes) {
    ylm_free(r->at);
    r->at = ylm_alloc(bytes, 1);
    r->bytes = r->at ? bytes : 0;
  }
  return r->at;
}
