out vec4 colour;

void main() {
  bool seen = see();
  colour = vec4(0.0);
  SKIPPED(!seen) colour = vec4(min(tint / 3.14159265 * ylm_irradiance(place, n), 60000.0), 1.0);
  if (!seen) discard;
}
