--- No direct light: pictures of light that bounces alone, without lamps and background.

local check = require "ylm.check"
local options = require "ylm.render.options"
local pictures = require "ylm.render.picture"

local none = { name = "none", called = 'by = "none"', bare = true }

none.options = options.bounce_fields
none.view_options = { options.lights_field, options.seed_field }

function none.wants() return false end

function none.prepare(name, p, o)
  if not o.reflected then
    return check.fail("%s: by = 'none' shows light that bounces alone, and nothing bounces: give bounced, or bounces above 0",
      name)
  end
  local report = pictures.new_report(p)
  report.visibility = "none"
  return p, report
end

function none.radiance() return false, 0 end

function none.report(p, o, report, image)
  pictures.sign(image, p, o.reflected.record.name, report)
end

return none
