/* list.c - arrays that grow. */
#include "ylm_list.h"

bool ylm_list_resize(void *list, size_t used, size_t room, size_t size) {
  void *old, *now;
  memcpy(&old, list, sizeof old);
  now = ylm_realloc(old, used * size, room, size);
  if (now) memcpy(list, &now, sizeof now);
  return now != NULL;
}
