/* A square around a lamp, which holds all of it that the eye can see. */
uniform mat4 camera;
uniform vec3 eye, right, up;
uniform sampler2D lamps;
out vec3 place;
flat out vec4 lamp;
flat out vec3 radiance;

void main() {
  int i = gl_InstanceID;
  lamp = texelFetch(lamps, ivec2(2 * i & 4095, i >> 11), 0);
  radiance = texelFetch(lamps, ivec2((2 * i & 4095) + 1, i >> 11), 0).xyz;
  vec2 corner = vec2((gl_VertexID & 1) == 0 ? -1.0 : 1.0, (gl_VertexID & 2) == 0 ? -1.0 : 1.0);
  float d = length(lamp.xyz - eye), r = lamp.w;
  float half_side = d > 1.01 * r ? r * d / sqrt(d * d - r * r) * 1.5 : 0.0;
  place = lamp.xyz + half_side * (corner.x * right + corner.y * up);
  gl_Position = camera * vec4(place, 1.0);
}
