/* moments.real.comp - the merged moments of docs/math.md "Sum of sphere lights": csrc/light/moments/moments.h. */
#version 450
#extension GL_GOOGLE_include_directive : require
#include "ylm.glsl"

#include "lamps.glsl"
layout(constant_id = 2) const uint KINDS = 1;

uint store_at;
#include "sums.glsl"
#include "gen/moments.glsl"

#define weigh(direction, id, normal, plain)
#include "moments_add.glsl"
#include "lamps_main.glsl"
