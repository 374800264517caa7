/* Where a place is in the grid, and its light. LMAX, CHANNELS, UNIFORM, SIDES, USED_COUNT, USED and COSINE are defined before. */
uniform usampler2D cells;   /* three texels a cell */
uniform usampler2D table;   /* of a uniform grid: the cell of a voxel */
uniform usampler2D sides;   /* a texel a word of a leaf with sides */
uniform sampler2D rows;     /* a texel a coefficient of a point: value, slopes */
uniform vec3 lowest, unit;  /* of the bounds; a lattice cell in scene units */
uniform vec3 resolution;    /* lattice cells */
uniform int depth;
uniform float scale;        /* of the numbers in `rows` */
uniform sampler2D flats;    /* irradiance of flat surfaces at points, a texel a channel: value, slopes */
uniform vec3 flat_normals[MOST_FLATS];
uniform int flat_count, points;

const int COUNT = (LMAX + 1) * (LMAX + 1), ROW = CHANNELS * COUNT;
const uint NONE = 0xffffffffu, SIDED = 0x400000u;

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
#if MODE == 3 || MODE == 4
    if ((w.y & 0x100000u) == 0u) {
      own = leaf;
      if ((w.w >> 16 & 0x7c00u) != 0x7c00u) estimate = unpackHalf2x16(w.w >> 16).x;
    }
#endif
#if SIDES
    if ((w.y & SIDED) != 0u) {
      whole = leaf;
      break;
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

/* Irradiance that a corner adds to a flat surface, whose coefficients are summed already. */
vec3 flat_corner(uint point, vec4 w, int which) {
  vec3 sum;
  for (int c = 0; c < 3; c++) {
    int i = (which * points + int(point)) * CHANNELS + min(c, CHANNELS - 1);
    sum[c] = dot(w, texelFetch(flats, ivec2(i & 4095, i >> 12), 0));
  }
  return sum;
}

vec4 of_corner(int c) { return vec4(weight[c], weight[8 + c], weight[16 + c], weight[24 + c]); }

/* The sum of all corners' coefficients. */
vec3 by_coefficients(vec3 n, uvec4 lower, uvec4 upper) {
  harmonics(n.x, n.y, n.z, n.z < 0.0 ? -1.0 : 1.0, 1.0 - abs(n.z));
  float cosine[USED_COUNT];
  for (int j = 0; j < USED_COUNT; j++) cosine[j] = COSINE[j] * Y[USED[j]];
  return corner(lower.x, of_corner(0), cosine) + corner(lower.y, of_corner(1), cosine)
      + corner(lower.z, of_corner(2), cosine) + corner(lower.w, of_corner(3), cosine)
      + corner(upper.x, of_corner(4), cosine) + corner(upper.y, of_corner(5), cosine)
      + corner(upper.z, of_corner(6), cosine) + corner(upper.w, of_corner(7), cosine);
}

vec3 origin_of(uvec4 w) { return vec3(float(w.z & 65535u), float(w.z >> 16), float(w.w & 65535u)); }

#if SIDES
uint side_word(uint i) { return texelFetch(sides, ivec2(int(i & 4095u), int(i >> 12)), 0).x; }

/* The part of a piece of the leaf whose record begins at that word; 15: none. */
uint part_of(uint record, int piece) {
  return side_word(record + 2u + uint(piece >> 3)) >> uint(4 * (piece & 7)) & 15u;
}

/* The cell of the part that a surface sees in a leaf with sides, as by_pieces of csrc/grid/sides/look.c: that of the piece in
   front of it, else of the nearest one; NONE: nothing of the leaf is free. */
uint seen_part(uvec4 w, vec3 place, vec3 face) {
  uint first = side_word(w.x), parts = side_word(w.x + 1u), best = 0u;
  if (parts < 2u) return parts == 0u ? NONE : first;
  vec3 edge = edge_of(w) * unit, at = ((place - lowest) / unit - origin_of(w)) / edge_of(w);
  vec3 way = 0.1875 * dot(abs(face), edge) * face / edge;
  for (int i = 0; i < 3; i++) {
    ivec3 q = clamp(ivec3(floor(4.0 * (at + (i == 0 ? 1.0 : i == 1 ? 1.7 : 0.5) * way))) + 1, 0, 5);
    uint part = part_of(w.x, q.x + 6 * q.y + 36 * q.z);
    if (part != 15u) return first + part;
  }
  float least = 1e38;
  for (int i = 0; i < 216; i++) {
    uint part = part_of(w.x, i);
    if (part == 15u) continue;
    vec3 d = (0.25 * (vec3(float(i % 6), float(i / 6 % 6), float(i / 36)) - 0.5) - at - way) * edge;
    if (dot(d, d) >= least) continue;
    least = dot(d, d);
    best = part;
  }
  return first + best;
}
#endif

/* Irradiance of a surface by the grid; face: the normal of its triangle, on the side of n. */
vec3 irradiance(vec3 place, vec3 n, vec3 face) {
  uint leaf, whole;
  vec3 at = lattice(place);
  find(at, leaf, whole);
  if (whole == NONE) return vec3(0.0);
  uvec4 w = words(whole, 0u);
#if SIDES
  if ((w.y & SIDED) != 0u) whole = seen_part(w, place, face);
  if (whole == NONE) return vec3(0.0);
#endif
  uvec4 lower = words(whole, 1u), upper = words(whole, 2u);
  float edge = edge_of(w), inverse = 1.0 / edge;
  vec3 origin = origin_of(w), size = edge * unit;
  vec3 t = clamp(vec3(edge_fraction(at.x, origin.x, inverse), edge_fraction(at.y, origin.y, inverse),
      edge_fraction(at.z, origin.z, inverse)), 0.0, 1.0);
  corner_weights(0u, values(t.x, size.x), values(t.y, size.y), values(t.z, size.z));
  int plane = -1;
  for (int i = 0; i < flat_count; i++) {
    vec3 off = n - flat_normals[i];
    if (dot(off, off) < 1e-8) plane = i;
  }
  vec3 sum = vec3(0.0);
  for (int k = plane < 0 ? 8 : 0; k < 8; k++) sum += flat_corner(k < 4 ? lower[k] : upper[k - 4], of_corner(k), plane);
  SKIPPED(plane >= 0) sum = by_coefficients(n, lower, upper);
  return scale * sum;
}
