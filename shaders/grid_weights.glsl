/*
** grid_weights.glsl - the weights of a cell's interpolant. Wants INTERPOLATION (hermite, taylor, linear), cell[], unit[3]
** (a lattice cell in scene units) and weight[].
*/
#include "gen/interpolation.glsl"

/* The 32 weights of the value (set 0) or the derivative along axis set - 1, to weight[at ..]. */
void weights(uint at, uint set, uint k, vec3 t) {
  Axis f[3];
  for (int a = 0; a < 3; a++) {
    float edge = float(cell[k].edge) * unit[a];
    f[a] = set == a + 1 ? slopes(t[a], edge) : values(t[a], edge);
  }
  corner_weights(at, f[0], f[1], f[2]);
}
