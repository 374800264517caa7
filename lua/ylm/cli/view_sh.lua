--- ylm view c.npy: SH vectors as lobes beside each other, with their product and what a rotation makes of them.

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"
local view_things = require "ylm.cli.view_things"

local view_sh = {}

local MOST = 24 -- lobes in a picture

--- The rows of a file of coefficients: { label, c [count] }, in ylm's own convention.
local function rows_of(ylm, path, array, out)
  local shape = array.shape
  local lmax = ylm.sh.lmax(math.max(1, shape[#shape]))
  if not lmax then
    status.stop(status.failed, "%s: [..][(lmax+1)^2] coefficients expected, got %s", path, tostring(array))
  end
  if array.convention ~= "ylm" then array = status.need(ylm.sh.convert(array, "ylm")) end
  local count = 1
  for i = 1, #shape - 1 do count = count * shape[i] end
  local name = path:match "([^/\\]+)%.[^.]*$" or path
  local flat = array:reshape { count, shape[#shape] }
  for i = 1, math.min(count, MOST) do
    out[#out + 1] = { count == 1 and name or ("%s %d"):format(name, i), flat[i], lmax }
  end
  if count > MOST then report.say({}, "%s: %d of %d rows are shown", path, MOST, count) end
  return out
end

--- The vectors that the files and the options describe: { label, c }, all of the highest lmax among them.
function view_sh.vectors(ylm, paths, arrays, given)
  local list, highest = {}, 0
  for i, path in ipairs(paths) do rows_of(ylm, path, arrays[i], list) end
  for _, entry in ipairs(list) do highest = math.max(highest, entry[3]) end
  for _, entry in ipairs(list) do entry[2] = ylm.sh.resize(entry[2], highest) end
  local inputs = #list
  if given.product then
    if inputs < 2 or inputs > 16 then
      status.stop(status.usage, "view: --product wants 2 to 16 vectors, got %d", inputs)
    end
    local factors = {}
    for i = 1, inputs do factors[i] = list[i][2] end
    list[#list + 1] = { "product", (ylm.sh.product((table.unpack or unpack)(factors))) } -- luacheck: ignore
  end
  if given.rotate then
    local angle = given.angle or 90
    for i = 1, #list do
      list[#list + 1] = { list[i][1] .. ", turned", ylm.sh.rotate(list[i][2],
        { axis = given.rotate, angle = math.rad(angle) }) }
    end
  end
  return list
end

--- The view of those vectors, after their summaries were printed, and these as tables for --json.
function view_sh.view(ylm, paths, arrays, given)
  local list = view_sh.vectors(ylm, paths, arrays, given)
  local sh, labels, summaries = {}, {}, {}
  for i, entry in ipairs(list) do
    labels[i], sh[i] = entry[1], entry[2]:totable()
    local text, energy = ylm.sh.summary(entry[2])
    summaries[i] = { label = entry[1], lmax = ylm.sh.lmax(#entry[2]), energy = energy, coefficients = sh[i] }
    if not given.json and not given.quiet then io.stdout:write(entry[1], ": ", text, "\n") end
  end
  local fields = { sh = sh, labels = labels, camera = view_things.camera(ylm, given) }
  if not fields.camera then fields.up = given.up end
  for _, name in ipairs { "title", "caption", "size", "direction", "background", "font", "supersample" } do
    fields[name] = given[name]
  end
  return ylm.view(fields), summaries
end

return view_sh
