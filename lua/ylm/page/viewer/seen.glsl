/* The surface at a pixel, as buffer.frag.glsl has left it. */
uniform usampler2D places, surfaces;
uniform int stride; /* pixels of the buffer a pixel */
uniform int below;  /* rows of the picture before those of the buffer */
vec3 place, tint, n, face;

vec3 unfolded(uint word) {
  vec2 o = unpackSnorm2x16(word);
  vec3 v = vec3(o, 1.0 - abs(o.x) - abs(o.y));
  if (v.z < 0.0) v.xy = (1.0 - abs(v.yx)) * vec2(v.x < 0.0 ? -1.0 : 1.0, v.y < 0.0 ? -1.0 : 1.0);
  return normalize(v);
}

/* Runs a statement unless a condition holds: drivers on processors run all branches, but no loop that none of some pixels needs. */
#define SKIPPED(condition) for (int once = (condition) ? 1 : 0; once < 1; once++)

/* Fills place, tint, n and face; false: there is none. */
bool see() {
  ivec2 at = ivec2(gl_FragCoord.xy) * stride - ivec2(0, below);
  uvec4 s = texelFetch(surfaces, at, 0), p = texelFetch(places, at, 0);
  place = uintBitsToFloat(p.xyz);
  gl_FragDepth = uintBitsToFloat(p.w);
  n = unfolded(s.x);
  face = unfolded(s.y);
  tint = vec3(unpackUnorm2x16(s.z), unpackUnorm2x16(s.w).x);
  return s.w > 0xffffu;
}
