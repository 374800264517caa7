/* Samples of a picture to pixels: the mean radiance through exposure and tone curve, under the share that is colours. */
uniform sampler2D picture;
uniform int samples;       /* along each axis, of a pixel */
uniform vec2 shrink;       /* texels a pixel, where the picture is smaller */
uniform float gain;
uniform int tone;          /* 0 linear, 1 srgb, 2 reinhard, 3 hable, 4 aces */
out vec4 colour;

float hable(float x) {
  return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
}

float shown(float x) {
  x = min(max(x, 0.0) * gain, 1e6);
  if (tone == 2) x = x / (1.0 + x);
  if (tone == 3) x = hable(2.0 * x) / hable(11.2);
  if (tone == 4) x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  x = clamp(x, 0.0, 1.0);
  return tone == 0 ? x : x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

void main() {
  vec3 radiance = vec3(0.0), paint = vec3(0.0);
  float lit = 0.0, all = float(samples * samples);
  ivec2 at = ivec2(floor(gl_FragCoord.xy * shrink)) * samples;
  for (int y = 0; y < samples; y++)
    for (int x = 0; x < samples; x++) {
      vec4 s = texelFetch(picture, at + ivec2(x, y), 0);
      radiance += s.w * s.xyz;
      paint += (1.0 - s.w) * s.xyz;
      lit += s.w;
    }
  vec3 mean = lit > 0.0 ? radiance / lit : vec3(0.0);
  colour = vec4((lit * vec3(shown(mean.x), shown(mean.y), shown(mean.z)) + paint) / all, 1.0);
}
