/*
** grid_weights.glsl - what csrc/grid/sample_kernel.h says of a cell's interpolant. Wants INTERPOLATION (hermite, taylor,
** linear), cell[], unit[3] (a lattice cell in scene units) and weight[].
*/
struct Axis {
  float l[2], s[2], k[2];
};

Axis values(float t, float edge) {
  float u = 1.0 - t, s = INTERPOLATION == 0 ? t * u * (u - t) : 0.0;
  float k = INTERPOLATION == 0 ? edge * t * u * u : INTERPOLATION == 1 ? edge * t * u : 0.0;
  return Axis(float[](u, t), float[](s, -s), float[](k, INTERPOLATION == 0 ? -edge * t * t * u : -k));
}

Axis slopes(float t, float edge) {
  float u = 1.0 - t, rate = 1.0 / edge, s = INTERPOLATION == 0 ? rate * (1.0 - 6.0 * t * u) : 0.0;
  float k = INTERPOLATION == 0 ? u * (u - 2.0 * t) : INTERPOLATION == 1 ? u - t : 0.0;
  return Axis(float[](-rate, rate), float[](s, -s), float[](k, INTERPOLATION == 0 ? t * (t - 2.0 * u) : -k));
}

/* The 32 weights of the value (set 0) or the derivative along axis set - 1, to weight[at ..]. */
void weights(uint at, uint set, uint k, vec3 t) {
  Axis f[3];
  for (int a = 0; a < 3; a++) {
    float edge = float(cell[k].edge) * unit[a];
    f[a] = set == a + 1 ? slopes(t[a], edge) : values(t[a], edge);
  }
  for (uint c = 0; c < 8; c++) {
    uint i = c & 1, j = c >> 1 & 1, m = c >> 2;
    float ll = f[1].l[j] * f[2].l[m], xl = f[0].l[i] * f[2].l[m], xy = f[0].l[i] * f[1].l[j];
    weight[at + c] = (f[0].l[i] + f[0].s[i]) * ll + (f[1].s[j] * xl + f[2].s[m] * xy);
    weight[at + 8 + c] = f[0].k[i] * ll;
    weight[at + 16 + c] = f[1].k[j] * xl;
    weight[at + 24 + c] = f[2].k[m] * xy;
  }
}
