-- What cameras, materials and rendering refuse: see spec/support/refusals in the walker's spec.

local nan, inf = 0 / 0, 1 / 0

return {
  camera = {
    { call = function(ylm) return ylm.camera() end, says = "a table of named fields expected, got nil" },
    { call = function(ylm) return ylm.camera {} end, says = "field 'from' is missing" },
    { call = function(ylm) return ylm.camera { form = { 0, 0, 1 } } end, says = "did you mean 'from'" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, nan } } end, says = "from must be three numbers" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 0 } } end, says = "different points" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, up = { 0, 0, 0 } } end, says = "up must be three numbers" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, up = { 0, 0, 2 } } end, says = "up must not point along" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, fov = 180 } end, says = "fov must be a number > 0 and <= 179" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, fov = inf } end, says = "fov must be a number" },
  },
  matte = {
    { call = function(ylm) return ylm.matte { 0.5 } end, says = "fields are given by name" },
    { call = function(ylm) return ylm.matte { albdeo = 0.5 } end, says = "did you mean 'albedo'" },
    { call = function(ylm) return ylm.matte { albedo = -0.1 } end, says = "albedo must be" },
    { call = function(ylm) return ylm.matte { albedo = { 1, 1 } } end, says = "albedo must be" },
    { call = function(ylm) return ylm.matte { albedo = nan } end, says = "albedo must be" },
  },
}
