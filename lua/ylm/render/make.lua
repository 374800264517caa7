--- The picture of a prepared view: direct light, light that bounces added, layers composed, the report completed.

local bounces = require "ylm.render.bounces"
local choose = require "ylm.render.choose"
local core = require "ylm.c.core"
local devices = require "ylm.device"
local light = require "ylm.light"
local near = require "ylm.render.near"
local pictures = require "ylm.render.picture"
local prints = require "ylm.render.prints"

local make = {}

--- Makes ready what bounces and what lies over direct light, in o.over: true, or nil, message, code.
local function prepare(name, p, o)
  local ok, message, code = true, nil, nil
  if o.reflected then ok, message, code = o.reflected.record.prepare(name, p, o) end
  if not ok then return nil, message, code end
  o.over = {}
  for _, over in ipairs(o.direct.alone and {} or choose.over) do
    if over.wants(o) then
      ok, message, code = over.prepare(name, p, o)
      if not ok then return nil, message, code end
      o.over[#o.over + 1] = over
    end
  end
  return true
end

--- The picture that stays on the device of o, a gpu_array [height][width][3]; or nil, message, code.
local function kept(name, p, o, write)
  local out, message, code = devices.of(o.device):room(name, p, o)
  if not out then return nil, message, code end
  local ok
  ok, message, code = write(out)
  if not ok and out ~= o.out then out:close() end
  if not ok then return nil, message, code end
  return out
end

--- Completes a report by what bounces and what lies over: true, or nil, message, code.
local function complete(p, o, report, image)
  if o.reflected then
    bounces.report(o, report, image)
    o.reflected.record.report(p, o, report, image)
  elseif not o.direct.alone then bounces.omitted(o, report, image) end
  for _, sentence in ipairs(prints.say(p, o)) do report.warnings[#report.warnings + 1] = sentence end
  near.report(p, o, report, image)
  for _, over in ipairs(o.over) do
    local ok, message, code = over.report(p, o, report, image)
    if not ok then return nil, message, code end
  end
  return true
end

--- The picture of the prepared view p by o, whose ways choose and bounces have settled, and its report; or nil, message, code.
function make.picture(name, p, o)
  pictures.check_truth(name, p, o)
  if o.direct.check then o.direct.check(name, p) end
  local ok, message, code = prepare(name, p, o)
  if not ok then return nil, message, code end
  local tally = light.tally(o.grid, o.bodies)
  local view, report
  view, report, code = o.direct.prepare(name, p, o)
  if not view then return nil, report, code end
  local start, before = core.seconds(), p.lib.shade_stages(view.view)
  local radiance, seconds, image
  radiance, seconds, code = o.direct.radiance(name, view, o, report)
  if radiance == nil then return nil, seconds, code end
  if o.download == false then image, message, code = kept(name, view, o, radiance)
  else image, message, code = pictures.picture(name, view, radiance, o) end
  if not image then return nil, message, code end
  pictures.finish(report, start, seconds or report.seconds.light)
  o.direct.report(view, o, report, image, before)
  report.shadow = report.shadow or tally()
  ok, message, code = complete(p, o, report, image)
  if not ok then return nil, message, code end
  return image, report
end

return make
