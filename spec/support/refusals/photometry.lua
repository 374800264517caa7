-- Bad input of photometries and the lamps that have them.

local function cosine(ylm) return ylm.photometry { cosine = 1 } end

local function lamp(ylm, o)
  o.photometry, o.at = o.photometry or cosine(ylm), { 0, 0, 0 }
  return ylm.photometric_light(o)
end

return {
  photometry = {
    { call = function(ylm) ylm.photometry {} end, says = "give one of file, candela" },
    { call = function(ylm) ylm.photometry { cosine = -1 } end, says = "cosine must be a number >= 0" },
    { call = function(ylm) return ylm.photometry { file = "no such lamp.ies" } end, says = "no such lamp.ies" },
    { call = function(ylm) ylm.photometry { vertical = { 0, 90 }, horizontal = { 0 }, candela = { { 1 } } } end,
      says = "candela must be %[1%]%[2%]" },
  },
  photometric_light = {
    { call = function(ylm) lamp(ylm, { to = { 0, 0, 0 } }) end, says = "at and to are the same" },
    { call = function(ylm) lamp(ylm, { photometry = 5 }) end, says = "photometry must be a photometry" },
    { call = function(ylm) lamp(ylm, { opening = { shape = "ring" } }) end, says = "opening: shape must be one of" },
  },
  polar_plot = {
    { call = function(ylm) cosine(ylm):plot { planes = { 0, 1, 2, 3, 4 } } end, says = "planes must be 1 to 4 angles" },
  },
  ["photometry:intensity"] = {
    { call = function(ylm) cosine(ylm):intensity { 0, 0, 0 } end, says = "direction 1 has no length" },
    { call = function(ylm) cosine(ylm).intensity(3, { 0, 0, 1 }) end, says = "a photometry expected before the colon" },
  },
  ["photometry:flux"] = { { call = function(ylm) cosine(ylm):flux { to = 200 } end, says = "to must be a number" } },
  ["photometry:check"] = { { call = function(ylm) cosine(ylm).check {} end, says = "a photometry expected before the colon" } },
  ["photometry:save"] = { { call = function(ylm) cosine(ylm):save "lamp.txt" end, says = "ends in .ies or .ldt" } },
  ["photometry:image"] = { { call = function(ylm) cosine(ylm):image { size = { 5 } } end, says = "size must be { width, height }" } },
  ["photometry:table"] = { { call = function(ylm) cosine(ylm).table {} end, says = "a photometry expected before the colon" } },
  ["photometry:plot"] = { { call = function(ylm) cosine(ylm):plot(3) end, says = "a table of options expected" } },
  ["polar_plot:save"] = { { call = function(ylm) cosine(ylm):plot():save "polar.txt" end, says = "the name of a .png" } },
  ["polar_plot:pixels"] = {
    { call = function(ylm) cosine(ylm):plot().pixels {} end, says = "a polar_plot expected before the colon" } },
}
