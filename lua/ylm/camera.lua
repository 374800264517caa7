--- Cameras.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local vector = require "ylm.vector"

local camera = {}

local EXTENT = core.limits.extent

camera.camera = form.define("camera", {
  shelf = "everyday",
  about = "A pinhole camera.",
  fields = {
    { "from", "point", unit = "scene units", about = "where it stands" },
    { "at", "point", default = { 0, 0, 0 }, unit = "scene units", about = "what it looks at: the middle of the image" },
    { "up", "vector", default = { 0, 1, 0 }, about = "what is up in the image; any length" },
    { "fov", "number", above = 0, max = 179, default = 45, unit = "degrees", about = "angle that the image's height spans" },
  },
  build = function(values, fail)
    local view = {}
    for i = 1, 3 do
      for _, name in ipairs { "from", "at" } do
        if math.abs(values[name][i]) > EXTENT then
          return fail(("%s is too far out (the limit is %s)"):format(name, check.limit_text(EXTENT)))
        end
      end
      view[i] = values.at[i] - values.from[i]
    end
    if view[1] == 0 and view[2] == 0 and view[3] == 0 then return fail("from and at must be different points") end
    if not (vector.length(vector.cross(vector.unit(view), vector.unit(values.up))) > 1e-9) then
      return fail("up must not point along the view, from 'from' to 'at'")
    end
    return setmetatable(values, form.defined.camera.metatable)
  end,
  example = "camera { from = { 3.5, 1.6, 3.5 }, at = { 0, 0.8, 0 }, fov = 45 }",
})

return camera
