--- Exposure of the pictures that commands write.

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local exposures = {}

local MOST_STOPS = 60 -- of image:save
local MOSTLY = 0.6 -- the part of a picture that is said to be black or white
local FAR = 1 -- stops from the exposure that suits a picture, from which on another one is said

exposures.option = { "exposure", nil, "NAME", "of a .png, in stops; default: auto, the middle of the picture becomes grey" }

--- The exposure that options ask for, a number or "auto"; nil: the file has none. Ends the command where it is wrong.
function exposures.of(name, given)
  local png = given.output:lower():find "%.png$"
  if given.exposure == nil then return png and "auto" or nil end
  if not png then
    status.stop(status.usage, "%s: --exposure is of a .png: %s holds radiance as it is", name, given.output)
  end
  local stops = given.exposure ~= "auto" and tonumber(given.exposure) or nil
  if not stops and given.exposure ~= "auto" then
    status.stop(status.usage, "%s: --exposure is a number of stops, or auto, got '%s'", name, given.exposure)
  end
  if stops and math.abs(stops) > MOST_STOPS then
    status.stop(status.usage, "%s: --exposure is from -%d to %d stops, got %g", name, MOST_STOPS, MOST_STOPS, stops)
  end
  return stops or "auto"
end

--- Says that a picture is mostly black or white.
local function say(given, image, stops)
  local best = status.need(image:exposure())
  local _, shown = image:exposure { stops = stops }
  local what = shown.black > MOSTLY and "black" or shown.white > MOSTLY and "white"
  if not what then return end
  local part = what == "black" and shown.black or shown.white
  local advice = math.abs(best - stops) > FAR and (": --exposure %.1f, or auto, shows its middle"):format(best) or ""
  report.say(given, "ylm: %.0f %% of the picture is %s%s", 100 * part, what, advice)
end

--- Writes the picture of a command under an exposure, nil: as it is; says what was chosen.
function exposures.save(given, image, exposure)
  if not exposure then
    status.need(image:save(given.output))
    return
  end
  local stops = exposure
  if exposure == "auto" then
    stops = status.need(image:exposure())
    if math.abs(stops) >= 0.05 then report.say(given, "ylm: exposure is %+.1f stops", stops) end
  end
  status.need(image:save(given.output, { exposure = stops }))
  say(given, image, stops)
end

return exposures
