/* A line from `from` to `to`, `width` pixels wide, drawn a little before what it lies on. */
uniform mat4 camera;
uniform vec2 pixels; /* of the picture */
uniform float width, near;
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec3 colour;
out vec3 shown;

void main() {
  vec4 a = camera * vec4(from, 1.0), b = camera * vec4(to, 1.0);
  shown = colour;
  if (a.w < near && b.w < near) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  if (a.w < near) a = mix(a, b, (near - a.w) / (b.w - a.w));
  if (b.w < near) b = mix(b, a, (near - b.w) / (a.w - b.w));
  vec2 along = (b.xy / b.w - a.xy / a.w) * pixels;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  vec4 p = (gl_VertexID & 1) == 0 ? a : b;
  float side = (gl_VertexID & 2) == 0 ? -1.0 : 1.0;
  p.xy += side * width * vec2(-along.y, along.x) / pixels * p.w;
  p.z -= 2e-3 * near;
  gl_Position = p;
}
