--- Code by which a grid's cells are decided, found and filled: for C (csrc/grid/gen/cells.h) and for GLSL
-- (shaders/gen/cells.glsl). The processor computes in double what a device computes in float, but where it is said.

local common = require "ylm.codegen.common"

local cells = {}

cells.functions = {
  { about = "What a cell's metric is the mean of: of a corner with eigenvalues lambda, coefficients of that norm.", text = [[
real point_ratio(real lambda, real norm, bool relative) {
  return !(lambda > #0.0) ? #0.0 : relative ? lambda / norm : lambda;
}]] },
  { about = "A cell's metric from the ratios of its corners outside of lights, their sum and number. width * half is half the "
      .. "square of its\n   diagonal, which a float may not hold.", text = [[
real cell_metric(real sum, real count, real width, real half_width) {
  return count > #0.0 ? sum / count * width * half_width : #0.0;
}]] },
  { about = "Is a cell to be split by its metric, or by the surface of a light?", text = [[
bool cell_splits(real metric, real threshold, bool crossed) {
  return metric > threshold || crossed;
}]] },
  { about = "Relative distance of coefficients from sums of squares: of differences, of what is exact.", text = [[
real relative_distance(real differences, real exact_squares) {
  return differences == #0.0 ? #0.0 : ROOT(differences / exact_squares);
}]] },
  { about = "A value at the lattice's position from that at the nearest float, `lacks` away.", text = [[
float carried(float value, floats lacks, floats slope) {
  return value + (lacks[0] * slope[0] + lacks[1] * slope[1] + lacks[2] * slope[2]);
}]] },
  { about = "Is a number within bounds? Not NaN.", text = [[
bool within(real p, real lo, real hi) { return p >= lo && p <= hi; }]] },
  { about = "A lattice coordinate, from 0 to `last`, of a number, moved into the bounds; scale: lattice cells per unit.",
    text = [[
real lattice_coordinate(real p, real lo, real hi, real scale, real last) {
  real at = (p - lo) * scale;
  return within(p, lo, hi) ? (at < last ? at : last) : p > hi ? last : #0.0;
}]] },
  { about = "How far along the edge of a cell a lattice coordinate is, 0 to 1 within; inverse: of the edge.", text = [[
real edge_fraction(real at, real origin, real inverse) { return (at - origin) * inverse; }]] },
  { about = "The octant, at bit `shift` of lattice coordinates.", text = [[
uint octant_of(uint x, uint y, uint z, uint shift) {
  return (x >> shift & 1u) | (y >> shift & 1u) << 1 | (z >> shift & 1u) << 2;
}]] },
}

--- The file's text in a language of common.lua.
function cells.text(name)
  return common.text(name, "cells", { "Metric, subdivision and places of a grid's cells (Iwasaki & Dobashi 2025, Sec. 5.1)." },
    cells.functions)
end

return cells
