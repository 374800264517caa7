-- busted itself under the Lua that runs this. (`busted --lua=x` takes options apart at blanks.)
if not pcall(require, "lfs") then dofile "spec/support/run/bare.lua" end
require "busted.runner" { standalone = false }
