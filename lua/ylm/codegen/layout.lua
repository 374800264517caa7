--- How the host and the shaders write down what both read: once for C (csrc/vulkan/gen/layout.h) and once for GLSL
-- (shaders/gen/layout.glsl).

local common = require "ylm.codegen.common"

local layout = {}

layout.constants = {
  { "CHILDREN", 0xff, "of a voxel's state: children that are voxels, as bits" },
  { "CROSSED", 0x100, "by a light's surface" },
  { "SPLIT", 0x200, "it has children" },
  { "ASKED", 0x400, "its parent is crossed" },
  { "COUNT_OUTSIDE", 0, "of an octree's counts: shading points outside of the bounds" },
  { "COUNT_FRESH", 1, "points that a level adds" },
  { "COUNT_ASKED", 2, "voxels of the next level that a surface may cross" },
  { "COUNT_SPLITS", 3, "cells that are split" },
  { "COUNT_VOXELS", 4, "voxels of the next level, or of a lattice" },
  { "COUNT_PLACED", 5, "of those asked" },
  { "COUNT_BAD", 6, "the complement of the first shading point that is not finite; 0: none" },
  { "COUNTS", 7, "how many there are" },
  { "LEVEL", 0xff, "of a grid's cell's info: its level" },
  { "HAS_DATA", 0x100, "its corners do" },
  { "ELSEWHERE", 0x200, "the host samples it" },
  { "NONE", 0x3fffffff, "of a place's cell: none here" },
  { "AWAY", 0x40000000, "outside of the bounds" },
  { "SCAN_EACH", 16, "numbers of an invocation of octree_scan.comp" },
  { "SCAN_LANES", 64, "invocations of its groups" },
  { "LOW_LMAX", 4, "the largest lmax of kernels named _low, which hold no sums of more" },
  { "PIXEL_TILE", 8, "pixels along a side: picture_lamps.real.comp" },
}

layout.functions = {
  { about = "A key: lattice coordinates, 0 .. 2^17 - 1 each, in two words.", text = [[
uint key_low(uint x, uint y) { return x | y << 17; }]] },
  { about = "The second.", text = [[
uint key_high(uint y, uint z) { return y >> 15 | z << 2; }]] },
  { about = "And back.", text = [[
uint key_x(uint low) { return low & 0x1ffffu; }]] },
  { about = "y.", text = [[
uint key_y(uint low, uint high) { return low >> 17 | (high & 3u) << 15; }]] },
  { about = "z.", text = [[
uint key_z(uint high) { return high >> 2; }]] },
  { about = "The bits of a float, or the high word of a double, as a whole number that orders like it.", text = [[
uint order_of_high(uint high) { return (high >> 31) != 0u ? ~high : high | 0x80000000u; }]] },
  { about = "The low word of a double likewise.", text = [[
uint order_of_low(uint high, uint low) { return (high >> 31) != 0u ? ~low : low; }]] },
  { about = "The bits of a number of that order: of a float, or the high word.", text = [[
uint bits_of_high(uint order) { return (order >> 31) != 0u ? order & 0x7fffffffu : ~order; }]] },
  { about = "The low word.", text = [[
uint bits_of_low(uint order, uint low) { return (order >> 31) != 0u ? low : ~low; }]] },
}

--- The file's text in a language of common.lua.
function layout.text(name)
  return common.text(name, "layout", { "Numbers that the host and kernels share." }, layout.functions, layout.constants)
end

return layout
