--- Cameras.

local form = require "ylm.form"

local camera = {}

local function length(v) return math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2) end

--- The sine of the angle between two vectors.
local function sine(a, b)
  local c = { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
  return length(c) / (length(a) * length(b))
end

camera.camera = form.define("camera", {
  about = "A pinhole camera.",
  fields = {
    { "from", "point", unit = "scene units", about = "where it stands" },
    { "at", "point", default = { 0, 0, 0 }, unit = "scene units", about = "what it looks at: the middle of the image" },
    { "up", "vector", default = { 0, 1, 0 }, about = "what is up in the image; any length" },
    { "fov", "number", above = 0, max = 179, default = 45, unit = "degrees", about = "angle that the image's height spans" },
  },
  build = function(values, fail)
    local view = {}
    for i = 1, 3 do view[i] = values.at[i] - values.from[i] end
    if length(view) == 0 then return fail("from and at must be different points") end
    if not (sine(view, values.up) > 1e-9) then return fail("up must not point along the view, from 'from' to 'at'") end
    return setmetatable(values, form.defined.camera.metatable)
  end,
  example = "camera { from = { 3.5, 1.6, 3.5 }, at = { 0, 0.8, 0 }, fov = 45 }",
})

return camera
