--- ylm photometry FILE: what a lamp's file says, its polar curve, the file in the other format.

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

--- Texts, then the lamp, then the table; none stands in the order that a file lacks.
local order = { "format", "luminaire", "company", "lamp", "opening", "lumens", "lumens_file", "ratio", "watts", "efficacy",
  "peak", "beam", "field", "downward", "clipped", "planes", "angles", "notes", "warnings" }

local command = {
  summary = "what a lamp's photometric file says, and its polar curve",
  usage = "FILE [-o polar.png] [--save FILE.ldt] [--json]    FILE: .ies (LM-63) or .ldt (EULUMDAT)",
  least = 1,
  most = 1,
  options = {
    { "output", "-o", "FILE", "the polar curve as .png, .svg or .pdf" },
    { "save", nil, "FILE", "the lamp as .ies (LM-63-2002) or .ldt" },
    { "planes", nil, "A,B", "C planes of the curve, degrees; default 0,90" },
    { "unit", nil, "NAME", "of the curve's rings: cd/klm (default) or cd" },
    { "tilt", nil, "N", "degrees at which the lamp hangs, for files with a TILT table" },
    { "lamps", nil, "N", "of an .ldt with several lamp sets: which one" },
  },
}

--- An opening in words: "rectangle 1.2 x 0.3 m".
local function opening_text(o)
  local size = o.size and ("%g x %g m"):format(o.size[1], o.size[2]) or o.radius and ("of radius %g m"):format(o.radius)
  return o.shape .. (size and " " .. size or "")
end

local function first_of(text, ...)
  for _, name in ipairs { ... } do if text[name] and text[name] ~= "" then return text[name] end end
end

--- Results of a photometry by name, and the order of the names.
function command.look(p)
  local results = status.need(p:check())
  results.format, results.opening = p.format, opening_text(p.opening)
  results.luminaire = first_of(p.text, "luminaire", "LUMINAIRE", "LUMCAT", "number")
  results.company, results.lamp = first_of(p.text, "company", "MANUFAC"), first_of(p.text, "lamp", "LAMP")
  results.notes = #p.notes > 0 and p.notes or nil
  return results, order
end

function command.run(given)
  if given.output then status.need_output("photometry", given.output, "png", "svg", "pdf") end
  if given.save then status.need_output("photometry", given.save, "ies", "ldt") end
  local p = status.need(require "ylm".photometry { file = given[1], tilt = given.tilt, lamps = given.lamps })
  report.print(given, command.look(p))
  if given.save then status.need(p:save(given.save)) end
  if given.output then
    local title = first_of(p.text, "luminaire", "LUMINAIRE", "LUMCAT", "number") or given[1]:match "[^/]*$"
    local plot = p:plot { planes = given.planes, unit = given.unit, title = title }
    status.need(plot:save(given.output))
  end
end

return command
