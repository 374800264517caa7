/*
** ylm.glsl - what every kernel of shaders/*.comp begins with.
**
**     #version 450
**     #extension GL_GOOGLE_include_directive : require
**     #include "ylm.glsl"
**     layout(constant_id = 1) const uint LMAX = 4;
**     layout(set = 0, binding = 0) readonly buffer A { float a[]; };
**     PUSH { uint first; uint n; };      // `first` is the slice's own; the caller's follow
**     void main() { uint i = ylm_item(first); if (i >= n) return; ... }
**
** Work is dispatched in slices of groups, so gl_WorkGroupID alone does not say which group
** this is: `first` is the number of groups in slices before this one.
** NAME.real.comp is compiled twice, with `real` as float and as double; there a constant is
** written REAL(0.1lf).
*/
layout(local_size_x_id = 0) in;

#define PUSH layout(push_constant) uniform Push

#ifdef YLM_DOUBLE
#define real double
#define rvec2 dvec2
#define rvec3 dvec3
#else
#define real float
#define rvec2 vec2
#define rvec3 vec3
#endif
#define REAL(x) real(x)
#define PI 3.141592653589793lf

real choose(bool first, real a, real b) { return first ? a : b; }

/* The number of this group among all slices. */
uint ylm_group(uint first) { return first + gl_WorkGroupID.x; }

/* The number of this invocation among all slices: one item each. */
uint ylm_item(uint first) { return ylm_group(first) * gl_WorkGroupSize.x + gl_LocalInvocationID.x; }
