--- Parallelograms with an image: ylm.textured_light.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local memory = require "ylm.memory"
local pack = require "ylm.light.pack"

local textured = {}

local MOST, EXTENT = core.limits.light_texels, core.limits.extent

--- Rows of numbers or colours as a float array [h][w] or [h][w][3]; fails with what is wrong.
local function from_rows(rows, fail)
  local h, w = #rows, type(rows[1]) == "table" and #rows[1] or 0
  if h == 0 or w == 0 then return fail "image must be a ylm.image or rows of texels {{1, 2}, {3, 4}}" end
  local depth = type(rows[1][1]) == "table" and #rows[1][1] or nil
  if depth and depth ~= 3 then return fail(("image: texels are numbers or {r, g, b}, got %d numbers"):format(depth)) end
  if w * h > MOST then return fail(("image must have at most %s texels, got %dx%d"):format(check.limit_text(MOST), w, h)) end
  if form.budget then form.budget("texels", w * h, fail) end
  local a, message, code = core.array_zeros({ h, w, depth }, "float")
  if not a then return nil, message, code end
  local ok, where = core.array_fill(a, rows)
  if not ok then
    return fail(("image: %d rows of %d %s each expected, element %d does not fit"):format(h, w,
      depth and "colours {r, g, b}" or "numbers", where))
  end
  return a
end

--- The layer of an image that is an object, rows or a file, as a float array; fails, or nil, message, code.
local function layer_of(values, fail)
  local image = values.image
  if values.file then
    if image ~= nil then return fail "give image or file, not both" end
    if #values.file == 0 or values.file:find "%z" then return fail "file must be a file name" end
    local lib, message, code = require "ylm.image".codec()
    if not lib then return nil, message, code end
    local most = math.min(MOST, form.budget and form.budget "texels" or MOST)
    image, message, code = lib.image_read(values.file, false, 4 * most, form.budget and form.budget "file_size")
    if not image then return nil, message, code end
    local w, h = core.image_info(image)
    if form.budget then form.budget("texels", w * h, fail) end
    return core.image_layer(image)
  end
  if image == nil then return fail "field 'image' is missing (a ylm.image or rows of texels; or file)" end
  if core.type(image) == "ylm.image" then
    if not memory.pcall(core.image_info, image) then return fail "the image has been closed" end
    return core.image_layer(image)
  end
  if type(image) ~= "table" or form.kind(image) then
    return fail(("image must be a ylm.image or rows of texels, got %s"):format(form.kind(image) and "a " .. form.kind(image)
      or check.describe(image)))
  end
  return from_rows(image, fail)
end

--- {corner, u, v} as nine numbers; fails unless they span a parallelogram.
local function frame_of(values, fail)
  local u, v, nine = values.u, values.v, {}
  local nx, ny, nz = u[2] * v[3] - u[3] * v[2], u[3] * v[1] - u[1] * v[3], u[1] * v[2] - u[2] * v[1]
  local lu, lv = math.sqrt(u[1] ^ 2 + u[2] ^ 2 + u[3] ^ 2), math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
  for name, l in pairs { u = lu, v = lv } do
    if not (l >= 1e-15 and l <= EXTENT) then
      return fail(("%s must be from 1e-15 to %s long"):format(name, check.limit_text(EXTENT)))
    end
  end
  if not (math.sqrt(nx * nx + ny * ny + nz * nz) > 1e-6 * lu * lv) then return fail "u and v must not be parallel" end
  for _, p in ipairs { values.corner, u, v } do
    for i = 1, 3 do nine[#nine + 1] = p[i] end
  end
  for i = 1, 3 do
    if math.abs(nine[i]) > EXTENT then
      return fail(("corner is too far out (the limit is %s)"):format(check.limit_text(EXTENT)))
    end
  end
  return nine
end

textured.textured_light = form.define("textured_light", {
  numbers = 256,
  about = "A parallelogram with an image, which it emits to both sides. Spherical harmonics sum its parts, groups of "
    .. "similar texels (a quadtree); pictures and rays see the image. It has count, the number of parts.",
  fields = {
    { "corner", "point", unit = "scene units", about = "the image's bottom left" },
    { "u", "vector", unit = "scene units", about = "to its bottom right" },
    { "v", "vector", unit = "scene units", about = "to its top left" },
    { "image", "any", optional = true, unit = "W sr^-1 m^-2",
      about = "a ylm.image, whose first layer is radiance, or rows of numbers or {r, g, b}, the top one first" },
    { "file", "string", optional = true, about = "an image file (.exr, .hdr, .png, .pfm) instead of image" },
    { "scale", "number", default = 1, about = "multiplies the image" },
    { "tolerance", "number", min = 0, default = 0,
      about = "texels this near in every channel, times the largest value, "
      .. "become one; 0 merges equal ones only" },
    { "largest", "number", above = 0, max = 1, default = 1 / 8,
      about = "most of the image's width and height that one part may stand for: a large sphere is near in front "
      .. "of the image, and wrong there" },
    { "method", "choice", of = { "exact", "spheres" }, default = "exact",
      about = "exact: each part's integrals along its edges; spheres: for each part a sphere of its area times "
      .. "|cos gamma|, 4 to 14 times faster, off by 20 % one width of a part away, by 1 % four widths away" },
    { "horizon", "vector", optional = true, about = "as of polygon_light" },
    pack.photometric,
  },
  build = function(values, fail)
    local frame = frame_of(values, fail)
    local layer, message, code = layer_of(values, fail)
    if not layer then return nil, message, code end
    local shape = core.array_info(layer)
    if shape[1] * shape[2] > MOST then
      return fail(("image must have at most %s texels, got %dx%d"):format(check.limit_text(MOST), shape[2], shape[1]))
    end
    if not core.array_finite(layer) then return fail "image must be finite" end
    local t = { corner = values.corner, u = values.u, v = values.v, scale = values.scale, tolerance = values.tolerance,
      largest = values.largest, method = values.method, horizon = values.horizon, frame = frame,
      photometric = values.photometric }
    t.texels, message, code = core.texture_texels(layer)
    if not t.texels then return nil, message, code end
    t.lights, message, code = core.lights_textured(t.texels, frame, t.scale, t.tolerance, t.largest, t.method == "exact",
      t.horizon)
    if not t.lights then
      if core.status(code) == "caller" then return fail((message:gsub("^polygon (%d+)", "part %1"))) end
      return check.result("textured_light", nil, message, code)
    end
    t.count = message
    return setmetatable(t, form.defined.textured_light.metatable)
  end,
  light = { moved = false, photometric = true },
  metatable = { __tostring = function(t)
    return ("textured_light of %dx%d texels in %d parts"):format(t.texels.shape[2], t.texels.shape[1], t.count)
  end },
  example = [[
local panel = ylm.textured_light { corner = { 0, 0, 0 }, u = { 2, 0, 0 }, v = { 0, 1, 0 },
  image = { { 1, 2 }, { 4, 8 } } }
assert(panel.count == 4)]],
})

return textured
