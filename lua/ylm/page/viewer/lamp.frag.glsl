uniform mat4 camera;
uniform vec3 eye;
in vec3 place;
flat in vec4 lamp;
flat in vec3 radiance;
out vec4 colour;

void main() {
  vec3 ray = normalize(place - eye), v = lamp.xyz - eye;
  float b = dot(ray, v);
  vec3 off = v - b * ray;
  float rest = lamp.w * lamp.w - dot(off, off);
  if (rest < 0.0) discard;
  vec4 p = camera * vec4(eye + (b - sqrt(rest)) * ray, 1.0);
  gl_FragDepth = 0.5 * p.z / p.w + 0.5;
  colour = vec4(min(radiance, 60000.0), 1.0);
}
