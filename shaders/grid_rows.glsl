/*
** grid_rows.glsl - the rows of a grid's points, [4][stride] each: values, then derivatives by x, y, z. They lie in up to
** four buffers of part_rows rows. Push constants come with stride and part_rows; kernels that write rows define WRITES_ROWS.
*/
#ifdef WRITES_ROWS
#define ROWS_ACCESS
#else
#define ROWS_ACCESS readonly
#endif

layout(constant_id = 4) const uint PARTS = 1;
layout(constant_id = 6) const bool PACKED = false; /* rows are words of ylm_grid_pack, [stride]: coefficients, two units */

layout(set = 0, binding = 0) ROWS_ACCESS buffer Data0 { float data0[]; };
layout(set = 0, binding = 1) ROWS_ACCESS buffer Data1 { float data1[]; };
layout(set = 0, binding = 2) ROWS_ACCESS buffer Data2 { float data2[]; };
layout(set = 0, binding = 3) ROWS_ACCESS buffer Data3 { float data3[]; };

/* Word `at` of a row of `length` words. */
float row_word(uint row, uint length, uint at) {
  if (PARTS == 1) return data0[row * length + at];
  uint part = row / part_rows, i = (row - part * part_rows) * length + at;
  return part == 0 ? data0[i] : part == 1 ? data1[i] : part == 2 ? data2[i] : data3[i];
}

/* Coefficient j (kind 0) or its derivative along axis kind - 1 at a point of the grid. */
float grid_data(uint row, uint kind, uint j) {
  if (!PACKED) return row_word(row, 4 * stride, kind * stride + j);
  int word = floatBitsToInt(row_word(row, stride, j));
  int x = kind == 0 ? bitfieldExtract(word, 0, 11) : bitfieldExtract(word, int(4 + 7 * kind), 7);
  return float(x) * row_word(row, stride, stride - (kind == 0 ? 2 : 1));
}

#ifdef WRITES_ROWS
void put_data(uint row, uint kind, uint j, float x) {
  uint part = row / part_rows, at = ((row - part * part_rows) * 4 + kind) * stride + j;
  if (part == 0)
    data0[at] = x;
  else if (part == 1)
    data1[at] = x;
  else if (part == 2)
    data2[at] = x;
  else
    data3[at] = x;
}
#endif
