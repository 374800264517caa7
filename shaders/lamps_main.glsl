/* lamps_main.glsl - the loop over tiles of lights around the includer's add(point, light). */
void main() {
  uint blocks = (points + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x, group = ylm_group(first);
  uint i = (group % blocks) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
  uint row = group / blocks / items; /* chunk + chunks * channel */
  which = group / blocks % items;
  uint channel = channel_first + row / chunks;
  uint begin = (chunk_first + row % chunks) * chunk, end = min(begin + chunk, lamps);
  uint k = 3u * min(i, points - 1u);
  rvec3 at = rvec3(point[k], point[k + 1u], point[k + 2u]);
  bool all_outside = true;
  clear_sums();
  for (uint tile_first = begin; tile_first < end; tile_first += TILE) {
    uint n = min(TILE, end - tile_first);
    barrier();
    for (uint j = gl_LocalInvocationID.x; j < n; j += gl_WorkGroupSize.x) {
      uint from = LAMP_ROWS * (tile_first + j), to = TILE_ROWS * j;
      rvec4 b = lamp[from + 1u];
      if (channel < 3u) b.w = lamp[from + 2u][channel];
      tile[to] = lamp[from];
      tile[to + 1u] = b;
      if (FLAT) tile[to + 2u] = lamp[from + 3u];
    }
    barrier();
    for (uint j = 0u; j < TILE_ROWS * n; j += TILE_ROWS) {
      rvec3 normal = FLAT ? tile[j + TILE_ROWS - 1u].xyz : rvec3(0.0);
      all_outside = add(at, tile[j], tile[j + 1u], normal) && all_outside;
    }
  }
  if (i >= points) return;
  store_at = row * sums * stride + i;
  store_sums();
  if (!all_outside) atomicOr(inside[i], 1u);
}
