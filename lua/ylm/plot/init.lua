--- Line plots: ylm.plot.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local lines = require "ylm.plot.lines"
local picture = require "ylm.picture"

local plot = {}

-- Colours that stay apart for colour-blind eyes too (Okabe & Ito 2008), brighter ones on dark.
local palette = {
  white = { { 0.00, 0.45, 0.70 }, { 0.84, 0.37, 0.00 }, { 0.00, 0.62, 0.45 }, { 0.80, 0.47, 0.65 },
    { 0.34, 0.71, 0.91 },
    { 0.90, 0.62, 0.00 }, { 0.35, 0.35, 0.35 } },
  dark = { { 0.34, 0.71, 0.91 }, { 0.96, 0.58, 0.18 }, { 0.25, 0.80, 0.60 }, { 0.90, 0.60, 0.78 }, { 0.95, 0.90, 0.35 },
    { 0.45, 0.60, 0.95 }, { 0.75, 0.75, 0.75 } },
}

-- Series -------------------------------------------------------------------------

local series_fields = {
  { "x", "any", about = "numbers: a table or an array" },
  { "y", "any",
    about = "as many numbers; those that are not finite, or not above 0 on a logarithmic axis, are left out" },
  { "label", "string", optional = true, about = "in the legend" },
  { "colour", "colour", min = 0, max = 1, optional = true, about = "default: the next of the palette" },
  { "width", "number", min = 0, max = 50, default = 2.2, unit = "pixels", about = "0 draws no line" },
  { "marker", "choice", of = core.choices "marker", default = "circle" },
  { "marker_size", "number", min = 0, max = 100, default = 8, unit = "pixels" },
  { "dash", "choice", of = core.choices "dash", default = "solid" },
}

--- A plain list of numbers out of a table or array.
local function numbers(what, value, fail)
  if core.type(value) == "ylm.array" then
    local shape, _, _, open = core.array_info(value)
    if not open then return fail(what .. ": the array has been closed") end
    if #shape ~= 1 then return fail(("%s must be a list of numbers, got %s"):format(what, check.describe(value))) end
    value = core.array_totable(value)
  end
  if type(value) ~= "table" or form.kind(value) then
    return fail(("%s must be a list of numbers, got %s"):format(what, check.describe(value)))
  end
  for i = 1, #value do
    if type(value[i]) ~= "number" then
      return fail(("%s: entry %d must be a number, got %s"):format(what, i, check.describe(value[i])))
    end
  end
  return value
end

local function check_series(i, given, fail)
  local function fail_here(message) return fail(("series %d: %s"):format(i, message)) end
  if type(given) ~= "table" or form.kind(given) then
    return fail_here(("a table { x = , y = } expected, got %s"):format(check.describe(given)))
  end
  local s = form.check(series_fields, given, fail_here)
  s.x, s.y = numbers("x", s.x, fail_here), numbers("y", s.y, fail_here)
  if #s.x ~= #s.y then return fail_here(("x has %d numbers, y %d"):format(#s.x, #s.y)) end
  if #s.x == 0 then return fail_here "x and y are empty" end
  return s
end

-- Axes ----------------------------------------------------------------------------

local function shown(x, log)
  return check.is_number(x) and (not log or x > 0)
end

local ALIKE = 1e-9 -- numbers that differ by this part of themselves are a flat line

--- Range of an axis: the one given, or the data's, widened a little (to whole decades' tenths where logarithmic).
local function axis_range(series, key, other, axis, other_axis)
  if axis.range then return axis.range[1], axis.range[2] end
  local lo, hi = math.huge, -math.huge
  for _, s in ipairs(series) do
    for i = 1, #s.x do
      if shown(s[key][i], axis.log) and shown(s[other][i], other_axis.log) then
        lo, hi = math.min(lo, s[key][i]), math.max(hi, s[key][i])
      end
    end
  end
  if lo > hi then lo, hi = 1, 10 end
  if axis.log then
    if hi - lo <= ALIKE * hi then lo, hi = lo / 3, hi * 3 end
    local margin = (hi / lo) ^ 0.04
    return lo / margin, hi * margin
  end
  if hi - lo <= ALIKE * math.max(math.abs(lo), math.abs(hi)) then
    local wide = math.max(0.5, ALIKE * math.abs(hi))
    lo, hi = lo - wide, hi + wide
  end
  local margin = (hi - lo) * 0.04
  return lo - margin, hi + margin
end

--- The series' points that axes can show, as arrays; lines go on from one to the next.
local function arrays(p, s, x, y)
  local px, py = {}, {}
  for i = 1, #s.x do
    if shown(s.x[i], p.x_log) and shown(s.y[i], p.y_log) then
      px[#px + 1], py[#py + 1] = s.x[i], s.y[i]
    end
  end
  if #px == 0 then return nil end
  return array.array(px), array.array(py), x, y
end

-- Drawing ---------------------------------------------------------------------------

--- Are all of an axis' numbers integers? Then nothing is written between integers.
local function whole(series, key)
  for _, s in ipairs(series) do
    for i = 1, #s[key] do
      if s[key][i] % 1 ~= 0 and check.is_number(s[key][i]) then return false end
    end
  end
  return true
end

local function axis_for_c(lo, hi, log, most, integers)
  local ticks, labels = picture.ticks(lo, hi, log, most, integers and hi - lo >= 1)
  return { least = lo, largest = hi, log = log, ticks = ticks, labels = labels }
end

local function widest(labels, font)
  local width, height = 0, 0
  for _, label in ipairs(labels) do
    local w, h = picture.text(nil, label, 0, 0, { size = font })
    width, height = math.max(width, w), math.max(height, h)
  end
  return width, height
end

--- Margins around the axes: left, right, top, bottom; and where titles go.
local function layout(p, chart, width, height, font)
  local pad = math.floor(font * 1.1)
  local label_width, label_height = widest(chart.y.labels, font)
  local _, x_height = widest(chart.x.labels, font)
  local l = { left = pad + label_width + 16, right = pad + 2 * font, top = pad, bottom = pad + x_height + 14 }
  if p.title then
    local _, h = picture.text(nil, p.title, 0, 0, { size = math.floor(font * 1.3), bold = true })
    l.title = l.top
    l.top = l.top + h + math.floor(font * 0.7)
  end
  if p.y_label then
    local _, h = picture.text(nil, p.y_label, 0, 0, { size = font })
    l.y_label = l.top
    l.top = l.top + h + math.floor(font * 0.6)
  else l.top = l.top + math.floor(label_height / 2) end
  if p.caption then
    l.caption_text = picture.wrap(p.caption, width - 2 * pad, { size = font })
    local _, h = picture.text(nil, l.caption_text, 0, 0, { size = font })
    l.caption = height - pad - h
    l.bottom = l.bottom + h + math.floor(font * 0.6)
  end
  if p.x_label then
    local _, h = picture.text(nil, p.x_label, 0, 0, { size = font })
    l.bottom = l.bottom + h + math.floor(font * 0.4)
    l.x_label = height - l.bottom + x_height + 14 + math.floor(font * 0.4)
  end
  l.pad = pad
  return l
end

--- The chart as the binding takes it. Texts around it go onto `canvas`, once paint(chart) has drawn the chart there.
local function compose(p, canvas, paint)
  local width, height, theme = p.size[1], p.size[2], p.theme
  local font = p.font or picture.font(width, height * 1.25)
  local x_axis, y_axis = { range = p.x_range, log = p.x_log }, { range = p.y_range, log = p.y_log }
  local x0, x1 = axis_range(p.all, "x", "y", x_axis, y_axis)
  local y0, y1 = axis_range(p.all, "y", "x", y_axis, x_axis)
  local chart = { supersample = p.supersample, font = font, background = theme.background, foreground = theme.text,
    legend = p.legend, series = {},
    x = axis_for_c(x0, x1, p.x_log, math.max(3, math.floor(width / font / 7)), whole(p.all, "x")),
    y = axis_for_c(y0, y1, p.y_log, math.max(3, math.floor(height / font / 4)), whole(p.all, "y")) }
  local l = layout(p, chart, width, height, font)
  chart.left, chart.right, chart.top, chart.bottom = l.left, l.right, l.top, l.bottom
  if width - l.left - l.right < 20 or height - l.top - l.bottom < 20 then
    return nil, ("a plot of %d x %d pixels has no room for its texts"):format(width, height), "ELIMIT"
  end
  local any = false
  for _, s in ipairs(p.all) do
    local x, y = arrays(p, s)
    if x then
      any = any or s.label
      chart.series[#chart.series + 1] = { x = x, y = y, label = s.label, width = s.width,
        colour = picture.with_alpha(s.colour, s.alpha or 1), marker = s.marker, dash = s.dash,
        marker_size = s.marker == "none" and 0 or s.marker_size }
    end
  end
  if not any then chart.legend = "none" end
  local painted, failed, status = paint(chart)
  if not painted then return nil, failed, status end
  if p.title then
    picture.text(canvas, p.title, l.pad, l.title, { size = math.floor(font * 1.3), bold = true, colour = theme.text })
  end
  picture.text(canvas, p.y_label, l.pad, l.y_label, { size = font, colour = theme.text })
  picture.text(canvas, p.x_label, math.floor((l.left + width - l.right) / 2), l.x_label,
    { size = font, colour = theme.text, align = "middle" })
  if p.caption then picture.text(canvas, l.caption_text, l.pad, l.caption, { size = font, colour = theme.dim }) end
  local box = { l.left, l.top, width - l.left - l.right, height - l.top - l.bottom }
  p.axes = { x = { x0, x1 }, y = { y0, y1 }, box = box, labels = { x = chart.x.labels, y = chart.y.labels } }
  return chart
end

local function draw(p)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local canvas = assert(core.canvas(p.size[1], p.size[2], p.theme.background))
  local chart
  chart, message, code = compose(p, canvas, function(c)
    local _, failed, status = vtk.plot(c, canvas)
    return not failed, failed, status
  end)
  if not chart then return nil, message, code end
  return canvas
end

--- The plot as marks of lines.lua, or nil, message, code.
local function marks_of(p, vtk)
  local words = {}
  local chart, message, code = compose(p, words, function() return true end)
  if not chart then return nil, message, code end
  local function measure(text, size, bold) return assert(vtk.text(nil, text, 0, 0, size, bold or false, { 0, 0, 0 })) end
  return lines.of(chart, words, p.size[1], p.size[2], measure)
end

--- Writes the plot by lines.
local function trace(p, path)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local marks
  marks, message, code = marks_of(p, vtk)
  if not marks then return nil, message, code end
  if path:lower():find "%.svg$" then return core.file_save(path, lines.svg(marks, p.size[1], p.size[2])) end
  return vtk.save_pdf(path, p.size[1], p.size[2], marks)
end

local example = 'ylm.plot { x = { 1, 2, 3 }, y = { 1, 4, 9 }, size = { 200, 150 } }'
local methods = picture.methods("plot", draw, example,
  { endings = { "svg", "pdf" }, save = trace, about = "by lines as .svg or .pdf. Text is text there." })

describe "plot:where" {
  about = "The pixel at which a point of the plot is drawn.",
  arguments = { { "x", "number", "" }, { "y", "number", "" } },
  returns = { { "column", "number", "from the left edge of the picture" }, { "row", "number", "from its top" } },
  errors = "raises on what is no number; nil, message, code as for save",
  example = "local p = " .. example .. "\nlocal left, right = p:where(1, 1), p:where(3, 9)\nassert(left < right)",
}
function methods.where(self, x, y)
  picture.is_one(self, "plot", "where")
  if not check.is_number(x) then return check.bad(1, "where", "a number expected, got %s", check.describe(x)) end
  if not check.is_number(y) then return check.bad(2, "where", "a number expected, got %s", check.describe(y)) end
  if not self.axes then
    local canvas, message, code = picture.draw(self, draw)
    if not canvas then return nil, message, code end
  end
  local function axis(range, log) return { least = range[1], largest = range[2], log = log } end
  local axes, box = self.axes, self.axes.box
  return lines.place(axis(axes.x, self.x_log), x, box[1], box[1] + box[3]),
    lines.place(axis(axes.y, self.y_log), y, box[2] + box[4], box[2])
end

-- The form ------------------------------------------------------------------------

local fields = {
  { "x", "any", optional = true, about = "of a single series" },
  { "y", "any", optional = true, about = "of a single series" },
  { "series", "table", optional = true,
    about = "a list of { x, y, label, colour, width, marker, marker_size, dash }; dash: solid, dashed, dotted" },
  { "diagonal", "any", optional = true, about = "a dashed line y = x: true, or its label" },
  { "title", "string", optional = true },
  { "caption", "string", optional = true },
  { "x_label", "string", optional = true, about = "with its unit" },
  { "y_label", "string", optional = true, about = "with its unit" },
  { "log", "boolean", optional = true, about = "both axes logarithmic" },
  { "x_log", "boolean", optional = true },
  { "y_log", "boolean", optional = true },
  { "x_range", "any", optional = true, about = "{least, largest}; default: of the data" },
  { "y_range", "any", optional = true, about = "{least, largest}; default: of the data" },
  { "legend", "choice", of = core.choices "legend", default = "top left" },
  { "size", "list", of = "integer", min = 64, max = 8192, default = { 960, 640 }, unit = "pixels" },
  { "background", "any", default = "white", about = "\"dark\", \"white\" or {r, g, b}, 0 to 1" },
  { "supersample", "integer", min = 1, max = 4, default = 2, about = "anti-aliasing" },
  { "font", "integer", min = 6, max = 200, optional = true, unit = "pixels" },
}

local function check_range(values, name, log, fail)
  local r = values[name]
  if r == nil then return end
  if type(r) ~= "table" or #r ~= 2 or not check.is_number(r[1]) or not check.is_number(r[2]) or r[1] >= r[2]
    or (log and r[1] <= 0) then
    return fail(("%s must be {least, largest} with least < largest%s, got %s"):format(name,
      log and " and above 0 on a logarithmic axis" or "", check.describe(r)))
  end
end

local function build(values, fail)
  picture.size(values.size, fail)
  values.theme = picture.theme(values.background, fail)
  if math.max(values.size[1], values.size[2]) * values.supersample > 16384 then
    return fail "size times supersample must be at most 16384 pixels"
  end
  if values.log ~= nil then
    if values.x_log == nil then values.x_log = values.log end
    if values.y_log == nil then values.y_log = values.log end
  end
  values.x_log, values.y_log = values.x_log or false, values.y_log or false
  check_range(values, "x_range", values.x_log, fail)
  check_range(values, "y_range", values.y_log, fail)
  if (values.x == nil) ~= (values.y == nil) then return fail "x and y belong together" end
  local list = {}
  if values.x ~= nil then list[1] = { x = values.x, y = values.y } end
  for _, s in ipairs(values.series or {}) do list[#list + 1] = s end
  if #list == 0 then return fail "nothing to plot: give x and y, or series" end
  if #list > 40 then return fail(("at most 40 series, got %d"):format(#list)) end
  values.all = {}
  local colours = palette[values.theme.text == picture.themes.white.text and "white" or "dark"]
  for i, s in ipairs(list) do
    values.all[i] = check_series(i, s, fail)
    values.all[i].colour = values.all[i].colour or colours[(i - 1) % #colours + 1]
  end
  if values.diagonal then
    if values.diagonal ~= true and type(values.diagonal) ~= "string" then
      return fail(("diagonal must be true or its label, got %s"):format(check.describe(values.diagonal)))
    end
    local axis = { range = values.x_range, log = values.x_log }
    local lo, hi = axis_range(values.all, "x", "y", axis, { log = values.y_log })
    values.x_range = values.x_range or { lo, hi }
    table.insert(values.all, 1, { x = { lo, hi }, y = { lo, hi }, colour = values.theme.dim, width = 1.6,
      dash = "dashed",
      marker = "none", marker_size = 0, label = type(values.diagonal) == "string" and values.diagonal or nil })
  end
  return setmetatable(values, form.defined.plot.metatable)
end

plot.plot = form.define("plot", {
  about = "A line plot. Methods: save, pixels, where.",
  fields = fields,
  metatable = { __index = methods },
  build = build,
  example = 'plot { x = { 1, 10, 100 }, y = { 1e-4, 1e-3, 1e-2 }, log = true, x_label = "n", y_label = "error" }',
})

memory.publish(methods)

return plot
