/* rival.c - a function that another library registers: see ylm_material_rival.h. */
#include "ylm_material_rival.h"

#include <stdatomic.h>

static _Atomic(ylm_material_rival_fn *) known;

void ylm_material_rival_set(ylm_material_rival_fn *nearest) { atomic_store(&known, nearest); }
ylm_material_rival_fn *ylm_material_rival_nearest(void) { return atomic_load(&known); }
