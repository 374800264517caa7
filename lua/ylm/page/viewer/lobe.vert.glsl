/* A probe's light as a surface around it: radius |L(s)| in direction s. Points of a sphere, one instance a probe. */
uniform sampler2D rows;
uniform mat4 camera;
uniform vec3 eye;
layout(location = 0) in vec3 direction;
layout(location = 1) in vec3 centre;
layout(location = 2) in vec2 probe;  /* its number; what L is multiplied by */
layout(location = 3) in vec3 tint;
out vec3 shown;

const int COUNT = (LMAX + 1) * (LMAX + 1), ROW = CHANNELS * COUNT;
float Y[COUNT];

void main() {
  vec3 s = normalize(direction);
  harmonics(s.x, s.y, s.z, s.z < 0.0 ? -1.0 : 1.0, 1.0 - abs(s.z));
  float sum = 0.0;
  for (int k = 0; k < COUNT; k++) {
    int i = int(probe.x) * ROW + k;
    float L = texelFetch(rows, ivec2(i & 4095, i >> 12), 0).x;
#if CHANNELS == 3
    L = LUMINANCE_R * L + LUMINANCE_G * texelFetch(rows, ivec2((i + COUNT) & 4095, (i + COUNT) >> 12), 0).x
        + LUMINANCE_B * texelFetch(rows, ivec2((i + 2 * COUNT) & 4095, (i + 2 * COUNT) >> 12), 0).x;
#endif
    sum += Y[k] * L;
  }
  vec3 place = centre + abs(sum) * probe.y * s;
  float light = 0.45 + 0.55 * max(0.0, dot(s, normalize(eye - place)));
  shown = light * (sum >= 0.0 ? tint : vec3(0.25, 0.35, 1.0));
  gl_Position = camera * vec4(place, 1.0);
}
