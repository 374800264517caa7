-- busted itself under the Lua that runs this. (`busted --lua=x` takes options apart at blanks.)
require "busted.runner" { standalone = false }
