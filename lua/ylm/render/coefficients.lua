--- Pictures by coefficients of light, by a grid or a sum: what their reports have in common.

local gloss = require "ylm.render.gloss"
local occlusion = require "ylm.render.occlusion"
local pictures = require "ylm.render.picture"
local relight = require "ylm.render.relight"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local coefficients = {}

--- The report of such a picture, with what it does not keep; or nil, message, code.
function coefficients.begin(name, p, o)
  local report = pictures.new_report(p)
  if o.weight == "cosine" then report.visibility = o.nearby and "none" or "grid"
  else
    local ok, message, code = occlusion.report(name, p, o, report)
    if not ok then return nil, message, code end
    local loud = views.loud(p)
    if loud then report.warnings[#report.warnings + 1] = warning.say(p.scene, "noise", "%s", loud) end
  end
  gloss.announce(p, report)
  return report
end

--- Completes it by its glossy surfaces; `before`: stages of the view when the picture began.
function coefficients.finish(p, o, report, before)
  gloss.report(p, o, report)
  if o.glossy and before then report.stages = report.stages or relight.stages(p, before) end
end

return coefficients
