uniform vec3 eye;
in vec3 place, normal, tint;
out vec4 colour;

void main() {
  vec3 n = normalize(normal);
  if (dot(n, eye - place) < 0.0) n = -n;
  colour = vec4(min(tint / 3.14159265 * ylm_irradiance(place, n), 60000.0), 1.0);
}
