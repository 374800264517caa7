/* kind.c - the table of kinds of light. */
#include "kind.h"

#include <string.h>

static const ylm__light_kind *const kinds[] = {
#define X(name) &ylm__##name##_kind,
    YLM__LIGHT_KINDS(X)
#undef X
};
enum { KINDS = sizeof kinds / sizeof *kinds };
_Static_assert(KINDS <= YLM_LIGHT_KINDS, "bounds have no room for all kinds");

const ylm__light_kind *ylm__light_kind_of(const char *name) {
  for (size_t i = 0; i < KINDS; i++)
    if (strcmp(kinds[i]->name, name) == 0) return kinds[i];
  return NULL;
}

size_t ylm__light_kind_index(const ylm__light_kind *kind) {
  size_t i = 0;
  while (kinds[i] != kind) i++;
  return i;
}
