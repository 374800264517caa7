/* Where a place is in the grid, and its light. LMAX, CHANNELS, UNIFORM, BIAS, USED_COUNT, USED and COSINE are defined before. */
uniform usampler2D cells;   /* three texels a cell */
uniform usampler2D table;   /* of a uniform grid: the cell of a voxel */
uniform sampler2D rows;     /* a texel a coefficient of a point: value, slopes */
uniform vec3 lowest, unit;  /* of the bounds; a lattice cell in scene units */
uniform vec3 resolution;    /* lattice cells */
uniform int depth;
uniform float scale;        /* of the numbers in `rows` */
uniform float bias;

const int COUNT = (LMAX + 1) * (LMAX + 1), ROW = CHANNELS * COUNT;
const uint NONE = 0xffffffffu;

float Y[COUNT];
float weight[32];
uint own;       /* the leaf of the octree on the way of find(), before cells that continuity alone needs */
float estimate; /* the last estimated error there; negative: none */

uvec4 words(uint i, uint j) {
  uint t = 3u * i + j;
  return texelFetch(cells, ivec2(int(t & 4095u), int(t >> 12)), 0);
}

/* The finest cell at lattice coordinates, and the last on the way whose eight corners have light; NONE: there is none. */
void find(vec3 at, out uint leaf, out uint whole) {
  uvec3 q = uvec3(min(at, resolution - 1.0));
#if UNIFORM
  uint t = (q.z * uint(resolution.y) + q.y) * uint(resolution.x) + q.x;
  leaf = texelFetch(table, ivec2(int(t & 4095u), int(t >> 12)), 0).x;
  whole = leaf;
  own = leaf;
  estimate = leaf == NONE ? -1.0 : unpackHalf2x16(words(leaf, 0u).w >> 16).x;
#else
  leaf = 0u;
  whole = NONE;
  own = 0u;
  estimate = -1.0;
  for (int step = 0; step <= 16; step++) {
    uvec4 w = words(leaf, 0u);
    if ((w.y & 256u) != 0u) whole = leaf;
#if MODE == 3 || MODE == 4 || BIAS
    if ((w.y & 0x100000u) == 0u) {
      own = leaf;
      if ((w.w >> 16 & 0x7c00u) != 0x7c00u) estimate = unpackHalf2x16(w.w >> 16).x;
    }
#endif
    if (w.x == 0u) break;
    leaf = w.x + octant_of(q.x, q.y, q.z, uint(depth) - (w.y & 255u) - 1u);
  }
#endif
}

vec3 lattice(vec3 place) { return clamp((place - lowest) / unit, vec3(0.0), resolution); }

float edge_of(uvec4 w) { return UNIFORM == 1 ? 1.0 : float(1u << (uint(depth) - (w.y & 255u))); }

vec4 row(int i) { return texelFetch(rows, ivec2(i & 4095, i >> 12), 0); }

/* Irradiance that a corner of a cell adds, by weights of its value and slopes; cosine: what Y is multiplied by. */
vec3 corner(uint point, vec4 w, float cosine[USED_COUNT]) {
  int base = int(point) * ROW;
  vec3 sum = vec3(0.0);
  for (int j = 0; j < USED_COUNT; j++) {
    int k = base + USED[j];
    float t = cosine[j];
    sum.x += t * dot(w, row(k));
#if CHANNELS == 3
    sum.y += t * dot(w, row(k + COUNT));
    sum.z += t * dot(w, row(k + 2 * COUNT));
#endif
  }
  return CHANNELS == 3 ? sum : sum.xxx;
}

vec4 of_corner(int c) { return vec4(weight[c], weight[8 + c], weight[16 + c], weight[24 + c]); }

/* The weights of a cell's interpolant at fractions t, moved along `off` by its slope. */
void weigh(vec3 t, vec3 edge, vec3 off) {
  Axis x = values(t.x, edge.x), y = values(t.y, edge.y), z = values(t.z, edge.z);
#if BIAS
  float sum[32];
  corner_weights(0u, slopes(t.x, edge.x), y, z);
  for (int i = 0; i < 32; i++) sum[i] = off.x * weight[i];
  corner_weights(0u, x, slopes(t.y, edge.y), z);
  for (int i = 0; i < 32; i++) sum[i] += off.y * weight[i];
  corner_weights(0u, x, y, slopes(t.z, edge.z));
  for (int i = 0; i < 32; i++) sum[i] += off.z * weight[i];
  corner_weights(0u, x, y, z);
  for (int i = 0; i < 32; i++) weight[i] += sum[i];
#else
  corner_weights(0u, x, y, z);
#endif
}

#if BIAS
/* The mean light of the channels by the weights of a cell's corners. */
vec3 mean_light(uvec4 lower, uvec4 upper) {
  vec3 sum = vec3(0.0);
  for (int c = 0; c < 8; c++) {
    int base = int(c < 4 ? lower[c] : upper[c - 4]) * ROW;
    vec4 w = of_corner(c);
    sum.x += dot(w, row(base));
#if CHANNELS == 3
    sum.y += dot(w, row(base + COUNT));
    sum.z += dot(w, row(base + 2 * COUNT));
#endif
  }
  return sum;
}

/* The part of the way off a place on which the mean light of no channel changes by more than half of itself. */
float carry(vec3 t, vec3 edge, vec3 off, uvec4 lower, uvec4 upper) {
  weigh(t, edge, vec3(0.0));
  vec3 value = mean_light(lower, upper);
  weigh(t, edge, off);
  vec3 change = abs(mean_light(lower, upper) - value), most = 0.5 * abs(value);
  float part = 1.0;
  for (int k = 0; k < CHANNELS; k++)
    if (most[k] < part * change[k]) part = most[k] / change[k];
  return part;
}
#endif

/* Irradiance of a surface by the grid; face: the normal of its triangle, on the side of n. */
vec3 irradiance(vec3 place, vec3 n, vec3 face) {
  uint leaf, whole;
  vec3 there = place;
#if BIAS
  /* as ylm_grid_bias: a voxel's thickness off the surface, that of the larger one on the way */
  vec3 h = unit * abs(face);
  float b = 0.0;
  for (int look = 0; look <= 4; look++) {
    find(lattice(place + b * face), leaf, whole);
    float further = bias * (UNIFORM == 1 ? 1.0 : edge_of(words(own, 0u))) * (h.x + h.y + h.z);
    if (!(further > b)) break;
    b = further;
  }
  there = place + b * face;
#endif
  vec3 at = lattice(there);
  find(at, leaf, whole);
  if (whole == NONE) return vec3(0.0);
  uvec4 w = words(whole, 0u), lower = words(whole, 1u), upper = words(whole, 2u);
  float edge = edge_of(w), inverse = 1.0 / edge;
  vec3 t = vec3(edge_fraction(at.x, float(w.z & 65535u), inverse), edge_fraction(at.y, float(w.z >> 16), inverse),
      edge_fraction(at.z, float(w.w & 65535u), inverse));
  t = clamp(t, 0.0, 1.0);
  vec3 off = place - there;
#if BIAS
  off *= carry(t, edge * unit, off, lower, upper);
#endif
  weigh(t, edge * unit, off);
  harmonics(n.x, n.y, n.z, n.z < 0.0 ? -1.0 : 1.0, 1.0 - abs(n.z));
  float cosine[USED_COUNT];
  for (int j = 0; j < USED_COUNT; j++) cosine[j] = COSINE[j] * Y[USED[j]];
  return scale * (corner(lower.x, of_corner(0), cosine) + corner(lower.y, of_corner(1), cosine)
      + corner(lower.z, of_corner(2), cosine) + corner(lower.w, of_corner(3), cosine)
      + corner(upper.x, of_corner(4), cosine) + corner(upper.y, of_corner(5), cosine)
      + corner(upper.z, of_corner(6), cosine) + corner(upper.w, of_corner(7), cosine));
}
