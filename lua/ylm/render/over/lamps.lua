--- Lamps that are drawn over a picture because they move, and the depth of what it shows.

local check = require "ylm.check"
local light = require "ylm.light"
local outputs = require "ylm.outputs"

local lamps = { name = "lamps", called = "lamps" }

lamps.view_options = {
  { "lamps", "any", optional = true,
    about = "sphere lights to draw that are not in the prepared scene, because they move" },
  { "depth", "array", optional = true, shelf = "experiments",
    about = "float [height][width]: takes the layer depth, and in front of it that of lamps which cover more than half of a "
      .. "pixel" },
}

function lamps.wants(o) return o.lamps ~= nil or o.depth ~= nil end

--- Raises where the option depth is no float array of the view's size.
function lamps.prepare(name, p, o)
  local size = p.options.size
  if o.depth then outputs.of(1, name .. ": depth", o.depth, "float", { { size[2], size[1] } }) end
  return true
end

function lamps.draw(name, p, o, layer)
  if not o.lamps then return true end
  return assert(check.result(name, p.lib.shade_draw_lamps(p.view, o.threads or 0, layer, light.lamps(name, o.lamps))))
end

--- Writes into o.depth how far surfaces and o.lamps are.
function lamps.report(p, o)
  if not o.depth then return true end
  local threads = o.threads or 0
  local ok, message, code = check.result("render", p.lib.shade_layer(p.view, "depth", threads, o.depth))
  if not ok or not o.lamps then return ok, message, code end
  return check.result("render", p.lib.shade_lamp_depth(p.view, threads, o.depth, light.lamps("render", o.lamps)))
end

return lamps
