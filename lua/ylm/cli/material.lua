--- ylm material FILE: the contents of a file of a measured material holds, and whether it keeps to energy and reciprocity.

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

--- A MERL file's, an RGL file's, and what m:check() says; none stands in the order that a file lacks.
local order = { "kind", "isotropic", "theta_h", "theta_d", "phi_d", "phi_i", "theta_i", "reduction", "columns", "rows",
  "negative", "lobe_alpha", "lobe_share", "albedo", "energy", "reciprocity" }

local command = {
  summary = "what a measured material holds, its largest albedo, whether it is reciprocal",
  usage = "FILE [--json]    FILE: a .binary of MERL or a .bsdf of RGL",
  least = 1,
  most = 1,
}

--- Results of a file by name, and the order of the names.
function command.look(path)
  local m = status.need(require "ylm".load(path))
  local results = status.need(require "ylm.material.file".facts(m))
  for name, value in pairs(status.need(m:check())) do results[name] = value end
  return results, order
end

function command.run(given)
  local kind = status.need(require "ylm.file".kind_of(given[1]))
  if kind ~= "material" then status.stop(status.failed, "%s: not a material", given[1]) end
  report.print(given, command.look(given[1]))
end

return command
