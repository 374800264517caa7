--- Which ways a picture is made: one finds direct light, at most one light that bounces, others lie over both.
--
-- A way is a record in a file of its own, found by name:
--
--     name                          "rays"
--     called                        'by = "rays"', as messages name it
--     options                       fields that scene:render and view:render have of it
--     scene_options, view_options   of one of these alone
--
-- Direct light (render/direct):
--
--     wants(o, p)                   do options without `by` mean it? p: the prepared view, nil in scene:render
--     alone                         nothing bounces and nothing lies over it
--     settle(name, s, o, given)     before scene:render prepares its view
--     make(name, s, o, given, how)  scene:render's picture where it takes more than one view; how() makes one
--     check(name, p)                raises where it cannot shade the view p
--     prepare(name, p, o)           the view that is shaded, its report; or nil, message, code
--     radiance(name, p, o, report)  of shading points, or function(layer) that writes a picture; seconds; or nil, message, code
--     report(p, o, report, image, before)   before: stages of the view when it began
--
-- Light that bounces (render/bounced), settled in o.reflected:
--
--     wants(o)                      is o.bounced this way?
--     settle(name, o, s)            { bounces =, .. }
--     prepare(name, p, o)           true; or nil, message, code
--     radiance(name, p, o, start)   that of shading points, added to `start` (nil: nothing), a new array; or nil, message, code
--     report(p, o, report, image)
--
-- Ways that lie over them (render/over):
--
--     wants(o)
--     prepare(name, p, o)           true; or nil, message, code
--     radiance(name, p, o, direct)  direct light, changed; or nil, message, code
--     draw(name, p, o, layer)       over a picture: true; or nil, message, code
--     report(p, o, report, image)   true; or nil, message, code

local check = require "ylm.check"
local form = require "ylm.form"
local options = require "ylm.render.options"

local choose = {}

local function room(folder, ...)
  local list = {}
  for i, name in ipairs { ... } do
    list[i] = require("ylm.render." .. folder .. "." .. name)
    list[list[i].name] = list[i]
  end
  return list
end

--- Ways of a kind, in the order in which they are asked; by name too.
choose.direct = room("direct", "vectors", "none", "sum", "paths", "grid", "rays")
choose.bounced = room("bounced", "virtual", "surfaces", "grid", "links")
choose.over = room("over", "ambient", "bodies", "lamps", "oidn")

-- Options ------------------------------------------------------------------------------------

--- Options that ways define by ranges and defaults of their own, as scene:render has them.
local merged = {
  samples = { "samples", "integer", min = 1, max = choose.direct.paths.MOST_SAMPLES, optional = true,
    about = "camera rays per pixel, stratified, default 16; above 16 shading points by rays have as many times more rays to "
      .. "lamps and links, unless their numbers are given or share is 0; by paths in batches of 16, of which there are two at "
      .. "least, default 256" },
  tolerance = { "tolerance", "number", above = 0, optional = true,
    about = "by rays: of the picture, from 0.001 to 1, the root mean square error relative to its mean, edges included: chooses "
      .. "elements, rays, light_samples and samples where they are not given, judges itself by paths, and says whether it is met "
      .. "(report.met, .error). By paths: ends once the noise, report.noise, is at most this" },
  time_limit = { "time_limit", "number", above = 0, optional = true, unit = "s", shelf = "experiments",
    about = "by paths, and by rays with noise: ends after about so long, which makes results depend on it; by rays a pilot and "
      .. "64 links a shading point are the least" },
  visibility = options.visibility,
  bounces = options.bounce_fields[1],
  seed = options.view_fields[3],
}

--- The fields that way `x` has for a call, "scene" or "view".
local function fields_of(x, call) return options.list(x.options or {}, x[call .. "_options"] or {}) end

--- The fields of a call, each name once: those that all pictures have, then those of ways.
function choose.fields(call, first, last, ...)
  local all, seen = {}, {}
  local function add(list)
    for _, field in ipairs(list) do
      if not seen[field[1]] then
        seen[field[1]] = true
        all[#all + 1] = call == "scene" and merged[field[1]] or field
      end
    end
  end
  add(first)
  for _, kind in ipairs { ... } do
    for i = #kind, 1, -1 do add(fields_of(kind[i], call)) end
  end
  add(last)
  return all
end

--- All ways that have a field of this name in a call, as messages name them.
local function owners(name, call)
  local list = {}
  for _, kind in ipairs { choose.direct, choose.bounced } do
    for i = #kind, 1, -1 do
      for _, field in ipairs(fields_of(kind[i], call)) do
        if field[1] == name then
          list[#list + 1] = kind[i].called
          break
        end
      end
    end
  end
  return #list > 0 and table.concat(list, " or ") or nil
end

--- A value by a way's own field of its name: its range, its default.
local function refined(name, field, value)
  local function fail(message) return check.bad(1, name, "%s", message) end
  return form.check({ field }, { [field[1]] = value }, fail)[field[1]]
end

--- Raises where an option is given that no chosen way has; defaults and ranges of those that have it are looked at. `fields`
-- are all of the call, `common` the names that every picture has.
function choose.check(name, call, fields, common, o, given)
  local known, chosen = {}, { o.direct, o.reflected and o.reflected.record or nil }
  for _, way in ipairs(chosen) do
    for _, field in ipairs(fields_of(way, call)) do known[field[1]] = known[field[1]] or field end
  end
  for _, over in ipairs(choose.over) do
    for _, field in ipairs(not o.direct.alone and fields_of(over, call) or {}) do known[field[1]] = field end
  end
  for _, field in ipairs(fields) do
    local key = field[1]
    local own = known[key]
    if own and own ~= field then o[key] = refined(name, own, o[key]) end
    if not own and not common[key] and type(given) == "table" and given[key] ~= nil then
      return check.fail("%s: %s is for %s, and this picture is by = %q%s: name one that fits, or leave %s out", name, key,
        owners(key, call) or "pictures of shading points", o.direct.name,
        o.reflected and ", " .. o.reflected.record.called or "", key)
    end
  end
end

-- Ways ----------------------------------------------------------------------------------------

--- The field `by` of a call: the names of its ways.
function choose.by(...)
  local names = { ... }
  return { "by", "choice", of = names, optional = true,
    about = "how direct light is found: " .. (names[1] == "rays" and "'rays': rays to the lamps; 'grid': a grid of light, option "
      .. "grid, or where there is none the scene's probes, baked for what the camera sees; 'sum': coefficients of all lights, "
      .. "summed at every shading point, what an exact grid would give; ")
      .. (names[4] == "paths" and "'paths': paths of any length, also all light that bounces. " or "'vectors': transfer "
        .. "vectors that are given; 'none': not at all, light that bounces alone. ")
      .. "Default: 'grid' where a grid is given or visibility asks for transfer vectors, else 'rays'" }
end

--- The record of direct light that options mean; `p`: a prepared view, nil in scene:render.
function choose.direct_of(o, p)
  if o.by then return choose.direct[o.by] end
  for _, way in ipairs(choose.direct) do
    if way.wants(o, p) then return way end
  end
end

return choose
