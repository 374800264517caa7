/* binding_choices.c - the lists of words of binding_choices.h. */
#include "binding_choices.h"
#include "ylm_image.h"
#include "ylm_light_shadow.h"
#include "ylm_sh.h"
#include "ylm_sh_exponential.h"

#define X(name, ...) const char *const ylmL_##name##_choices[] = {__VA_ARGS__, NULL};
YLML_CHOICES(X)
#undef X

#define WORD(name) #name,
#define X(name, list) const char *const ylmL_##name##_choices[] = {list(WORD) NULL};
YLML_LISTS(X)
#undef X
