uniform mat4 camera;
uniform vec3 mesh_lowest, mesh_step;
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 octahedron;
layout(location = 2) in vec3 albedo;
out vec3 place, normal, tint;

void main() {
  place = mesh_lowest + mesh_step * position;
  vec2 o = octahedron / 32767.0;
  vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  normal = normalize(n);
  tint = albedo / 65535.0;
  gl_Position = camera * vec4(place, 1.0);
}
