--- The checks of the tree's architecture: name, function(root) -> a list of complaints.

local ladder = require "spec.check.ladder"

return {
  { "rooms", ladder.rooms },
  { "headers", ladder.headers },
  { "includes", ladder.includes },
  { "functions", require("spec.check.functions").check },
  { "state", require("spec.check.state").check },
  { "choices", require("spec.check.choices").check },
}
