--- ylm codegen: the kernels' generator, which parses its own options (lua/ylm/codegen/main.lua).

return {
  summary = "emits C or GLSL for SH values and derivatives, counts their operations",
  usage = "--lmax N [--derivatives 0|1|2] [--language c|glsl] ...",
  raw = true,
  text = function() return require "ylm.codegen.main".usage end,
  run = function(given) return require "ylm.codegen.main".run(given) end,
}
