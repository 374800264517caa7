--- ylm codegen: the kernels' generator, see lua/ylm/codegen.

local status = require "ylm.cli.status"

return {
  summary = "emits C or GLSL for SH values and derivatives",
  usage = "--lmax N --derivatives 0|1|2 --language c|glsl [-o FILE]",
  options = {
    { "lmax", nil, "N", "highest degree" },
    { "derivatives", nil, "N", "0 values, 1 gradients, 2 Hessians; default 0" },
    { "language", nil, "NAME", "c (default) or glsl" },
    { "output", "-o", "FILE", "default: stdout" },
  },
  run = function(given)
    local codegen = require "ylm.codegen"
    local ok, text = pcall(codegen.emit, { lmax = given.lmax, derivatives = given.derivatives or 0,
      language = given.language or "c" })
    if not ok then status.stop(status.usage, tostring(text)) end
    if not given.output then
      io.stdout:write(text)
      return status.good
    end
    local file = status.need(io.open(given.output, "wb"))
    status.need(file:write(text))
    status.need(file:close())
  end,
}
