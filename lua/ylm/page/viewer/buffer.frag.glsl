/* A surface at a pixel, for the pass that lights it: place and depth; the normals of the surface and of its
   triangle, both on the eye's side; albedo. The upper half of the last word is above 0 where there is a surface. */
uniform vec3 eye;
in vec3 place, normal, tint;
layout(location = 0) out uvec4 at_place;
layout(location = 1) out uvec4 of_surface;

/* A unit vector on an octahedron. */
uint folded(vec3 n) {
  n /= abs(n.x) + abs(n.y) + abs(n.z);
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  return packSnorm2x16(n.xy);
}

void main() {
  vec3 n = normalize(normal);
  if (dot(n, eye - place) < 0.0) n = -n;
  vec3 face = normalize(cross(dFdx(place), dFdy(place)));
  if (dot(face, n) < 0.0) face = -face;
  at_place = uvec4(floatBitsToUint(place), floatBitsToUint(gl_FragCoord.z));
  of_surface = uvec4(folded(n), folded(face), packUnorm2x16(tint.xy), packUnorm2x16(vec2(tint.z, 1.0)));
}
