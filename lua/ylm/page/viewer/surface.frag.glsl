/* MODE: 0 grid, 1 exact, 2 error, 3 estimated error, 4 levels. Alpha 1: radiance; 0: a colour to be shown. */
uniform vec3 eye;
uniform sampler2D lamps; /* two texels a lamp: place, radius; radiance */
uniform int lamp_count;
uniform vec3 palette[16];
uniform vec2 range;      /* logarithms of errors that are the palette's ends */
out vec4 colour;

const float PI = 3.14159265358979;

/* Irradiance by the lamps themselves, by the addition theorem: no coefficients. */
vec3 exact(vec3 n) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < lamp_count; i++) {
    vec4 lamp = texelFetch(lamps, ivec2(2 * i & 4095, i >> 11), 0);
    vec3 radiance = texelFetch(lamps, ivec2((2 * i & 4095) + 1, i >> 11), 0).xyz, v = lamp.xyz - place;
    float d2 = dot(v, v), r2 = lamp.w * lamp.w;
    if (d2 <= r2) {
      sum += PI * radiance;
      continue;
    }
    float s2 = r2 / d2, alpha = sqrt(1.0 - s2), mu = dot(n, v) * inversesqrt(d2);
    /* Legendre polynomials of mu and of alpha, and the slopes of those of alpha */
    float p = 1.0, next_p = mu, q = 1.0, next_q = alpha, slope = 0.0, next_slope = 1.0;
    float total = LEGENDRE[0] / (1.0 + alpha);
    for (int l = 1; l <= LMAX; l++) {
      total += LEGENDRE[l] * next_slope * next_p;
      float f = float(l), above = ((2.0 * f + 1.0) * mu * next_p - f * p) / (f + 1.0);
      p = next_p;
      next_p = above;
      float rise = slope + (2.0 * f + 1.0) * next_q;
      slope = next_slope;
      next_slope = rise;
      above = ((2.0 * f + 1.0) * alpha * next_q - f * q) / (f + 1.0);
      q = next_q;
      next_q = above;
    }
    sum += s2 * total * radiance;
  }
  return CHANNELS == 3 ? sum : vec3(dot(sum, vec3(LUMINANCE_R, LUMINANCE_G, LUMINANCE_B)));
}

vec3 painted(float t) {
  t = clamp(t, 0.0, 1.0) * 15.0;
  int i = min(int(t), 14);
  return mix(palette[i], palette[i + 1], t - float(i));
}

vec4 lit() {
#if MODE == 0
  return vec4(min(tint / PI * irradiance(place, n, face), 60000.0), 1.0);
#elif MODE == 1
  return vec4(min(tint / PI * exact(n), 60000.0), 1.0);
#elif MODE == 2
  return vec4(min(100.0 * tint / PI * abs(irradiance(place, n, face) - exact(n)), 60000.0), 1.0);
#else
  uint leaf, whole;
  find(lattice(place), leaf, whole);
  float light = 0.35 + 0.65 * abs(dot(n, normalize(eye - place)));
  vec3 paint = vec3(0.4);
  if (whole != NONE) {
    if (MODE == 4) paint = painted(float(words(own, 0u).y & 255u) / max(float(depth), 1.0));
    else if (estimate >= 0.0) paint = painted((log(max(estimate, 1e-30)) - range.x) / (range.y - range.x));
  }
  return vec4(light * paint, 0.0);
#endif
}

void main() {
  bool seen = see();
  colour = vec4(0.0);
  SKIPPED(!seen) colour = lit();
  if (!seen) discard;
}
