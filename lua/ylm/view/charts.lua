--- The numbers that colours of a lightmap's charts show.

local core = require "ylm.c.core"
local drawing = require "ylm.view.drawing"
local objects = require "ylm.transfer.object"

local charts = {}

--- Numbers of a lightmap's charts, double [n][1], their least, largest, and how a scale names them.
function charts.numbers(v)
  local m = objects.made(v.surfaces)
  local errors, density = m.lib.map_charts(v.surfaces)
  if not errors then drawing.run(nil, density, "ENOMEM") end
  local list = v.charts == "error" and errors or density
  local values, least, most = core.array_zeros({ #list, 1 }, "double"), math.huge, 0
  for i = 1, #list do
    local x = list:get(i)
    core.array_set(values, i, 1, x)
    if x > 0 then least, most = math.min(least, x), math.max(most, x) end
  end
  return values, math.min(least, most), most, { map = "viridis", log = true, label = v.charts == "error" and "error of charts"
    or "texels", unit = v.charts == "error" and "relative" or "a scene unit" }
end

return charts
