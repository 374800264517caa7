--- Polar curves of photometries as catalogues print them: photometry:plot.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local lines = require "ylm.plot.lines"
local memory = require "ylm.memory"
local picture = require "ylm.picture"

local polar = {}

-- Colours that stay apart for colour-blind eyes too (Okabe & Ito 2008), and dashes.
local looks = {
  { colour = { 0.00, 0.45, 0.70 }, dark = { 0.34, 0.71, 0.91 } },
  { colour = { 0.84, 0.37, 0.00 }, dark = { 0.96, 0.58, 0.18 }, dash = "dashed" },
  { colour = { 0.00, 0.62, 0.45 }, dark = { 0.25, 0.80, 0.60 } },
  { colour = { 0.80, 0.47, 0.65 }, dark = { 0.90, 0.60, 0.78 }, dash = "dashed" },
}

local STEP = 1      -- degrees between points of a curve
local RINGS = 5     -- about so many
local DASH = { 9, 6 } -- pixels that are drawn, and not

-- Curves --------------------------------------------------------------------------------------

--- Intensities of a plane and the one opposite, at gamma -180 .. 180.
local function curve(p, plane)
  local ways, c = {}, math.rad(plane)
  for g = -180, 180, STEP do
    local t = math.rad(g)
    ways[#ways + 1] = { math.sin(t) * math.cos(c), math.sin(t) * math.sin(c), math.cos(t) }
  end
  return core.array_totable((p:intensity(array.array(ways, "double"))))
end

--- The label of a plane and the one opposite: "C0–C180".
local function label_of(plane)
  local function text(x) return ("C%g"):format(x % 360) end
  return text(plane) .. "–" .. text(plane + 180)
end

--- A round step for about RINGS rings up to `most`.
local function ring_step(most)
  local rough = most / RINGS
  local decade = 10 ^ math.floor(math.log(rough) / math.log(10) + 1e-9)
  for _, m in ipairs { 1, 2, 2.5, 5, 10 } do
    if m * decade >= rough * 0.999 then return m * decade end
  end
end

--- Curves with their numbers in the unit of the rings, their largest, and the unit.
local function curves_of(v)
  local per = v.unit == "cd/klm" and (v.photometry.lumens > 0 and 1000 / v.photometry.lumens or 1) or 1
  local list, most, upward = {}, 0, 0
  for i, plane in ipairs(v.planes) do
    local cd = curve(v.photometry, plane)
    for k, x in ipairs(cd) do
      cd[k] = x * per
      most = math.max(most, cd[k])
      if math.abs(-180 + (k - 1) * STEP) > 95 then upward = math.max(upward, cd[k]) end
    end
    list[i] = { plane = plane, cd = cd, look = looks[(i - 1) % #looks + 1] }
  end
  return list, most, upward
end

--- Where the parts of a picture are, and what it has: marks of lines.lua, and words.
local function layout(v)
  local width, height, font = v.size[1], v.size[2], v.font or picture.font(v.size[1], v.size[2])
  local d = { v = v, font = font, pad = math.floor(font * 1.2), marks = {}, words = {} }
  local most, upward
  d.curves, most, upward = curves_of(v)
  d.step = most > 0 and ring_step(most) or 1
  d.rings = math.max(1, math.ceil(most / d.step - 1e-6))
  local top = d.pad + (v.title and math.floor(font * 2.1) or 0)
  d.bottom = height - d.pad - math.floor(font * 1.6) -- the legend's line
  d.whole = upward > 0.02 * most                     -- a whole circle
  local room, up = math.floor(font * 1.8), d.whole and 1 or 0.16
  d.radius = math.min((width - 2 * d.pad - 4 * font) / 2, (d.bottom - top - 2 * room) / (1 + up))
  local spare = d.bottom - top - 2 * room - d.radius * (1 + up)
  d.x, d.y = width / 2, top + room + d.radius * up + spare / 2
  return d
end

local function text(d, string, x, y, style)
  style = style or {}
  style.size, style.colour = style.size or d.font, style.colour or d.v.theme.text
  d.words[#d.words + 1] = { string, math.floor(x), math.floor(y), style }
end

local function put(d, points, colour, width, dash)
  d.marks[#d.marks + 1] = { points = points, colour = colour, width = width, dash = dash }
end

--- The place at an angle in degrees and a distance from the lamp, pixels.
local function at(d, angle, r)
  return d.x + r * math.sin(math.rad(angle)), d.y + r * math.cos(math.rad(angle))
end

--- Rings, and rays every 15 degrees, of which every other has its angle.
local function put_net(d)
  local dim, reach = d.v.theme.dim, d.whole and 180 or 105
  for k = 1, d.rings do
    local points = {}
    for g = -reach, reach do points[#points + 1], points[#points + 2] = at(d, g, d.radius * k / d.rings) end
    put(d, points, dim, k == d.rings and 1.2 or 0.7)
  end
  for g = -reach + (d.whole and 30 or 0), reach, 15 do
    local main = g % 30 == 0
    if main or math.abs(g) <= 90 then
      local x, y = at(d, g, main and 0 or d.radius / d.rings)
      local points = { x, y }
      points[3], points[4] = at(d, g, d.radius)
      put(d, points, dim, main and 0.9 or 0.4)
    end
    if main then
      local x, y = at(d, g, d.radius + d.font * 1.15)
      text(d, ("%d°"):format(math.abs(g)), x, y - d.font * 0.62, { colour = dim, align = "middle" })
    end
  end
end

local function put_curves(d)
  local bright = d.v.theme.text == picture.themes.white.text
  for _, c in ipairs(d.curves) do
    local points = {}
    for k, x in ipairs(c.cd) do
      points[#points + 1], points[#points + 2] = at(d, -180 + (k - 1) * STEP, d.radius * x / (d.rings * d.step))
    end
    c.colour = bright and c.look.colour or c.look.dark
    put(d, points, c.colour, 2.4, c.look.dash)
  end
end

--- Numbers of the rings, their unit, and which curve is which.
local function put_words(d)
  local font, low = d.font, d.bottom + d.font * 0.4
  if d.v.title then text(d, d.v.title, d.pad, d.pad, { size = math.floor(font * 1.25), bold = true }) end
  for k = 1, d.rings do
    text(d, ("%g"):format(k * d.step), d.x + font * 0.3, d.y + d.radius * k / d.rings - font * 1.35,
      { size = math.floor(font * 0.9) })
  end
  text(d, d.v.unit, d.v.size[1] - d.pad - picture.text(nil, d.v.unit, 0, 0, { size = font }), low)
  local x = d.pad
  for _, c in ipairs(d.curves) do
    put(d, { x, d.bottom + font, x + 2.6 * font, d.bottom + font }, c.colour, 2.4, c.look.dash)
    local label = label_of(c.plane)
    text(d, label, x + 3.1 * font, low)
    x = x + 4.6 * font + picture.text(nil, label, 0, 0, { size = font })
  end
end

--- Marks and words of the whole picture.
local function compose(v)
  local d = layout(v)
  put_net(d)
  put_curves(d)
  put_words(d)
  return d.marks, d.words
end

-- Drawing ---------------------------------------------------------------------------------------

--- A polyline on a canvas, in dashes where it has them.
local function stroke(canvas, mark)
  local p, colour = mark.points, picture.with_alpha(mark.colour, 1)
  local drawn, left = true, DASH[1]
  for i = 1, #p - 3, 2 do
    local x, y, dx, dy = p[i], p[i + 1], p[i + 2] - p[i], p[i + 3] - p[i + 1]
    local length, done = math.sqrt(dx * dx + dy * dy), 0
    while done < length do
      local step = mark.dash and math.min(left, length - done) or length
      if drawn then
        core.canvas_line(canvas, x + dx * done / length, y + dy * done / length, x + dx * (done + step) / length,
          y + dy * (done + step) / length, mark.width, colour)
      end
      done, left = done + step, left - step
      if mark.dash and left <= 1e-9 then drawn, left = not drawn, drawn and DASH[2] or DASH[1] end
    end
  end
end

local function draw(v)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local canvas = assert(core.canvas(v.size[1], v.size[2], v.theme.background))
  local marks, words = compose(v)
  for _, mark in ipairs(marks) do stroke(canvas, mark) end
  for _, w in ipairs(words) do picture.text(canvas, w[1], w[2], w[3], w[4]) end
  return canvas
end

--- Writes the picture by lines.
local function trace(v, path)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local marks, words = compose(v)
  local noted = {}
  for _, w in ipairs(words) do picture.text(noted, w[1], w[2], w[3], w[4]) end
  local function measure(word, size, bold) return assert(vtk.text(nil, word, 0, 0, size, bold or false, { 0, 0, 0 })) end
  table.insert(marks, 1, lines.background(v.theme.background, v.size[1], v.size[2]))
  marks = lines.with_words(marks, noted, measure)
  if path:lower():find "%.svg$" then return core.file_save(path, lines.svg(marks, v.size[1], v.size[2])) end
  return vtk.save_pdf(path, v.size[1], v.size[2], marks)
end

local example = "ylm.photometry { cosine = 1 }:plot { size = { 200, 200 } }"
local methods = picture.methods("polar_plot", draw, example,
  { endings = { "svg", "pdf" }, save = trace, about = "by lines as .svg or .pdf. Text is text there." })

-- The form --------------------------------------------------------------------------------------

polar.polar_plot = form.define("polar_plot", {
  about = "The polar curve of a photometry, as photometry:plot makes it. Methods: save, pixels.",
  fields = {
    { "photometry", "object", of = "photometry" },
    { "planes", "list", of = "number", min = -360, max = 360, default = { 0, 90 }, unit = "degrees",
      about = "each is drawn with the one opposite; at most 4" },
    { "unit", "choice", of = { "cd/klm", "cd" }, default = "cd/klm", about = "of the rings" },
    { "title", "string", optional = true },
    { "size", "list", of = "integer", min = 128, max = 8192, default = { 720, 720 }, unit = "pixels" },
    { "background", "any", default = "white", about = "\"dark\", \"white\" or {r, g, b}, 0 to 1" },
    { "font", "integer", min = 6, max = 200, optional = true, unit = "pixels" },
  },
  metatable = { __index = methods },
  build = function(values, fail)
    picture.size(values.size, fail)
    values.theme = picture.theme(values.background, fail)
    if #values.planes == 0 or #values.planes > #looks then return fail(("planes must be 1 to %d angles"):format(#looks)) end
    return setmetatable(values, form.defined.polar_plot.metatable)
  end,
  example = "polar_plot { photometry = ylm.photometry { cosine = 1 }, planes = { 0 } }",
})

--- Called by photometry:plot.
function polar.polar(p, given)
  if given ~= nil and (type(given) ~= "table" or form.kind(given)) then
    return check.bad(1, "plot", "a table of options expected, got %s", check.describe(given))
  end
  local values = { photometry = p }
  for name, value in pairs(given or {}) do values[name] = value end
  return polar.polar_plot(values)
end

memory.publish(methods)

return polar
