--- How much of a picture's light is not the scene's, where visibility is by direction: measured once a prepared view,
-- reported with each of its pictures, and said in one line where it matters.

local check = require "ylm.check"
local views = require "ylm.render.view"
local warning = require "ylm.warning"

local occlusion = {}

local POINTS, RAYS = 1024, 8   -- shading points that are looked at, and rays from each
local LEAST, CERTAIN = 0.01, 3 -- a share is said above this, and above so many of its standard errors

--- ylm_shade_occlusion of a prepared view, measured at the first call; nil, message, code.
local function measure(name, p, threads)
  local view = p.base or p.view
  local made = views.made[view]
  if not made.occlusion then
    local found, message, code = check.result(name, p.lib.shade_occlusion(view, POINTS, RAYS, threads or 0))
    if not found then return nil, message, code end
    made.occlusion = found
  end
  return made.occlusion
end

--- "12 %" of a share that is worth a word; nil of others.
local function percent(share, error)
  if share <= LEAST or share <= CERTAIN * error then return nil end
  return (share < 0.1 and "%.1f %%" or "%.0f %%"):format(100 * share)
end

local CAUSE = "occluders count by direction, up to occlusion_distance = %.3g wherever the lamp is; "
local REMEDY = 'by = "rays" (ylm render --by rays), whose shadows are true'

--- The sentence about a view: how much is not the scene's, why, and what to change; nil where it is of no account.
local function sentence(p, found)
  local passing, missing = percent(found.passing, found.passing_error), percent(found.missing, found.missing_error)
  if not passing and not missing then return nil end
  local o, words, advice = p.options, {}, "use "
  if passing then words[1] = passing .. " of the picture's light passes through occluders" end
  if missing then words[#words + 1] = missing .. " of the scene's light is missing" end
  if o.visibility == "none" then advice = 'set visibility = "transfer" or use '
  elseif not missing then advice = "set a longer one or use "
  elseif not passing then advice = "set a shorter one or use " end
  local cause = o.visibility == "none" and 'visibility = "none" has no shadows; ' or CAUSE:format(o.occlusion_distance)
  return ("scene %q: %s: %s%s%s"):format(p.scene.name or "?", table.concat(words, " and "), cause, advice, REMEDY)
end

--- Completes the report of a picture that is made with transfer vectors: true, or nil, message, code.
function occlusion.report(name, p, o, report)
  if p.options.self then return true end -- shadows of others are those of the light
  local found, message, code = measure(name, p, o.threads)
  if not found then return nil, message, code end
  local out = {}
  for key, value in pairs(found) do out[key] = value end
  report.occlusion, report.seconds.occlusion = out, out.seconds
  local words = sentence(p, found)
  if words then report.warnings[#report.warnings + 1] = warning.say(p.scene, "occlusion", "%s", words) end
  return true
end

return occlusion
