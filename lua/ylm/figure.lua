--- Pictures out of pictures: rows of images with captions, wipes, a shared scalar bar.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local images = require "ylm.image"
local memory = require "ylm.memory"
local picture = require "ylm.picture"
local picture_bar = require "ylm.picture.bar"

local figure = {}

local LEAST_FONT = 11 -- pixels; a default

-- Contents of an item --------------------------------------------------------------

local function canvas_of_array(what, a, fail)
  local shape, _, _, open = core.array_info(a)
  if not open then return fail(what .. ": the array has been closed") end
  if #shape ~= 3 or shape[3] ~= 3 or shape[1] < 1 or shape[2] < 1 then
    return fail(("%s: pixels [height][width][3] expected, got %s"):format(what, check.describe(a)))
  end
  local canvas, message = core.canvas(shape[2], shape[1], { 0, 0, 0 })
  if not canvas then return fail(("%s: %s"):format(what, message)) end
  core.canvas_set(canvas, a)
  return canvas
end

--- Checks what can be shown: a picture, a ylm.image, an array of pixels, the name of a .png file.
local function check_source(what, x, fail)
  local kind = form.kind(x)
  if kind == "ylm.image" or kind == "ylm.array" or picture.drawers[kind] then return x end
  if type(x) == "string" and x:lower():find("%.png$") then return x end
  return fail(("%s must be a view, plot or figure, an image, pixels [h][w][3], or the name of a .png file, got %s")
    :format(what, check.describe(x)))
end

--- Its pixels as a canvas; nil, message, code where the world fails.
local function canvas_of(x, item, fail)
  local kind = form.kind(x)
  if picture.drawers[kind] then return picture.drawers[kind](x) end
  if kind == "ylm.array" then return canvas_of_array("image", x, fail) end
  if kind == "ylm.image" then
    local canvas, message, code = core.canvas_image(x, item.layer, item.tone, item.exposure)
    if not canvas and core.status(code) == "caller" then
      return fail(item.layer and ("the image has no layer '%s'"):format(item.layer) or message)
    end
    return canvas, message, code
  end
  local file, message, code = images.read(x, true) -- by the codec: VTK's reader ends the process where a file is damaged
  if not file then return nil, message, code end
  return core.canvas_image(file, nil, "linear", 0)
end

local item_fields = {
  { "image", "any", optional = true, about = "a view, plot, figure, image, array [h][w][3] (0 to 1) or .png file" },
  { "values", "any", optional = true, about = "[h][w] numbers as colours instead" },
  { "wipe", "table", optional = true, about = "a list of images of one size: each fills a part, from left to right" },
  { "at", "list", of = "number", min = 0, max = 1, optional = true, about = "where a wipe changes; default even" },
  { "labels", "list", of = "string", optional = true, about = "of the parts of a wipe" },
  { "label", "string", optional = true, about = "in the upper left corner" },
  { "caption", "string", optional = true, about = "below; broken into lines" },
  { "crop", "list", of = "number", min = 0, optional = true, unit = "pixels",
    about = "{x, y, width, height} from the top left" },
  { "mark", "any", optional = true, about = "rectangles {x, y, w, h} outlined in the image: one or a list" },
  { "layer", "string", optional = true, about = "of an image" },
  { "tone", "choice", of = core.choices "tone", default = "srgb", about = "tone curve of an image" },
  { "exposure", "number", min = -60, max = 60, default = 0, unit = "stops", about = "of an image" },
  { "range", "any", optional = true, about = "{least, largest} of values; default: the bar's" },
  { "log", "boolean", optional = true, about = "of values; default: the bar's" },
  { "map", "choice", of = core.figure_map_names(), optional = true, about = "of values; default: the bar's" },
}

local bar_fields = {
  { "range", "any", about = "{least, largest}" },
  { "log", "boolean", default = false },
  { "map", "choice", of = core.figure_map_names(), default = "magma" },
  { "label", "string", default = "" },
  { "unit", "string", optional = true },
}

local function check_range(r, log, fail)
  if type(r) ~= "table" or #r ~= 2 or not check.is_number(r[1]) or not check.is_number(r[2]) or r[1] >= r[2]
    or (log and r[1] <= 0) then
    return fail(("range must be {least, largest} with least < largest%s, got %s"):format(
      log and " and above 0 where log is true" or "", check.describe(r)))
  end
  return { r[1], r[2] }
end

local function check_rectangle(what, r, fail)
  if type(r) ~= "table" or #r ~= 4 then return fail(what .. " must be {x, y, width, height}") end
  for i = 1, 4 do
    if not check.is_number(r[i]) or r[i] < 0 then
      return fail(what .. " must be {x, y, width, height}, none below 0")
    end
  end
  if r[3] <= 0 or r[4] <= 0 then return fail(what .. " must have a width and a height above 0") end
  return r
end

local function check_values(item, bar, fail)
  local a = item.values
  if core.type(a) ~= "ylm.array" then
    local ok, made = memory.pcall(array.array, a, "double")
    if not ok then return fail(("values must be numbers [h][w], got %s"):format(check.describe(item.values))) end
    a = made
  end
  local shape, _, _, open = core.array_info(a)
  if not open then return fail "values: the array has been closed" end
  if #shape == 3 and shape[3] == 1 then
    shape = { shape[1], shape[2] }
    a = core.array_reshape(a, shape)
  end
  if #shape ~= 2 or shape[1] < 1 or shape[2] < 1 then
    return fail(("values must be numbers [h][w], got %s"):format(check.describe(a)))
  end
  item.values = a
  if item.log == nil then item.log = bar and bar.log or false end
  item.map = item.map or bar and bar.map or "magma"
  if item.range then item.range = check_range(item.range, item.log, fail)
  elseif bar then item.range = bar.range
  else return fail "values need a range, or the figure a bar" end
end

local function check_item(given, bar, place, fail)
  local function fail_here(message) return fail(place .. ": " .. message) end
  if form.kind(given) or type(given) == "string" then given = { image = given } end
  if type(given) ~= "table" then
    return fail_here(("an image, or a table { image = } expected, got %s"):format(check.describe(given)))
  end
  local item = form.check(item_fields, given, fail_here)
  local n = (item.image ~= nil and 1 or 0) + (item.values ~= nil and 1 or 0) + (item.wipe and 1 or 0)
  if n ~= 1 then return fail_here "one of image, values and wipe expected" end
  if item.image ~= nil then check_source("image", item.image, fail_here) end
  if item.values ~= nil then check_values(item, bar, fail_here) end
  if item.wipe then
    if #item.wipe < 2 then return fail_here "wipe: at least two images expected" end
    for i, x in ipairs(item.wipe) do check_source(("wipe: image %d"):format(i), x, fail_here) end
    if item.at and #item.at ~= #item.wipe - 1 then
      return fail_here(("at: %d numbers expected, got %d"):format(#item.wipe - 1, #item.at))
    end
    for i = 2, #(item.at or {}) do
      if item.at[i] <= item.at[i - 1] then return fail_here "at must rise" end
    end
  end
  if item.crop then check_rectangle("crop", item.crop, fail_here) end
  if item.mark ~= nil then
    if type(item.mark) ~= "table" then return fail_here "mark must be {x, y, width, height}, or a list of such" end
    if type(item.mark[1]) ~= "table" then item.mark = { item.mark } end
    for _, r in ipairs(item.mark) do check_rectangle("mark", r, fail_here) end
  end
  return item
end

-- Drawing --------------------------------------------------------------------------

local function values_canvas(item)
  local shape = core.array_info(item.values)
  local a = core.array_convert(item.values, "double")
  local colours = core.figure_colours(a, { 0.5, 0.5, 0.5 }, item.map, item.range[1], item.range[2], item.log)
  local canvas, message, code = core.canvas(shape[2], shape[1], { 0, 0, 0 })
  if not canvas then return nil, message, code end
  core.canvas_set(canvas, colours)
  return canvas
end

--- Parts of several canvases beside each other, at their places.
local function wipe_canvas(item, fail)
  local parts, width, height = {}, nil, nil
  for i, x in ipairs(item.wipe) do
    local message, code
    parts[i], message, code = canvas_of(x, item, fail)
    if not parts[i] then return nil, message, code end
    local w, h = core.canvas_size(parts[i])
    if width and (w ~= width or h ~= height) then
      return fail(("wipe: images of one size expected, got %d x %d and %d x %d"):format(width, height, w, h))
    end
    width, height = w, h
  end
  local canvas = assert(core.canvas(width, height, { 0, 0, 0 }))
  item.edges = { 0 }
  for i = 1, #parts do
    local x = math.floor(width * (item.at and item.at[i] or i / #parts) + 0.5)
    if i == #parts then x = width end
    local from = item.edges[i]
    if x > from then core.canvas_copy(canvas, { from, 0, x - from, height }, parts[i], { from, 0, x - from, height }, true) end
    item.edges[i + 1] = x
  end
  return canvas
end

local function item_canvas(item, fail)
  if item.values then return values_canvas(item) end
  if item.wipe then return wipe_canvas(item, fail) end
  return canvas_of(item.image, item, fail)
end

--- A label on a dark, translucent ground.
local function draw_label(canvas, text, x, y, font)
  local style = { size = font, bold = true, colour = { 1, 1, 1 } }
  local w, h = picture.text(nil, text, 0, 0, style)
  local pad = math.floor(font * 0.45)
  core.canvas_rectangle(canvas, x, y, w + 2 * pad, h + math.floor(pad * 1.2), { 0, 0, 0, 0.55 })
  picture.text(canvas, text, math.floor(x + pad), math.floor(y + pad * 0.6), style)
end

local function draw_item(f, canvas, item, x, y, w, h, font)
  local cw, ch = core.canvas_size(item.canvas)
  local crop = item.crop or { 0, 0, cw, ch }
  core.canvas_copy(canvas, { x, y, w, h }, item.canvas, crop, w > crop[3])
  local kx, ky = w / crop[3], h / crop[4]
  for i = 2, #(item.edges or {}) - 1 do
    local ex = x + (item.edges[i] - crop[1]) * kx
    core.canvas_line(canvas, ex, y, ex, y + h, 2, { 1, 1, 1, 0.9 })
  end
  for i, text in ipairs(item.labels or {}) do
    local from = item.edges and item.edges[i] or 0
    draw_label(canvas, text, math.floor(x + math.max(0, from - crop[1]) * kx + font * 0.6),
      math.floor(y + font * 0.6), font)
  end
  if item.label then draw_label(canvas, item.label, math.floor(x + font * 0.6), math.floor(y + font * 0.6), font) end
  for i, r in ipairs(item.mark or {}) do
    local c = picture.with_alpha(f.marks[(i - 1) % #f.marks + 1], 1)
    local x0, y0 = x + (r[1] - crop[1]) * kx, y + (r[2] - crop[2]) * ky
    local x1, y1 = x0 + r[3] * kx, y0 + r[4] * ky
    core.canvas_line(canvas, x0 - 1, y0, x1 + 1, y0, 2, c)
    core.canvas_line(canvas, x0 - 1, y1, x1 + 1, y1, 2, c)
    core.canvas_line(canvas, x0, y0, x0, y1, 2, c)
    core.canvas_line(canvas, x1, y0, x1, y1, 2, c)
  end
end

--- Sizes of a row's items: equal heights, together `width`.
local function place_row(row, width, gap)
  local sum, x = 0, 0
  for _, item in ipairs(row) do
    local w, h = core.canvas_size(item.canvas)
    if item.crop then w, h = item.crop[3], item.crop[4] end
    item.aspect = w / h
    sum = sum + item.aspect
  end
  local height = math.max(1, math.floor((width - gap * (#row - 1)) / sum + 0.5))
  for i, item in ipairs(row) do
    item.x = math.floor(x + 0.5)
    local right = i == #row and width or math.floor(x + height * item.aspect + 0.5)
    item.w, item.h = math.max(1, right - item.x), height
    x = x + height * item.aspect + gap
  end
  return height
end

--- The width of the longest word of a text.
local function longest_word(words, font)
  local most = 0
  for word in words:gmatch "%S+" do most = math.max(most, (picture.text(nil, word, 0, 0, { size = font }))) end
  return most
end

--- The least width of a figure at which its title is whole and no word of a caption is wider than its picture.
local function readable_width(f)
  local most = f.title and picture.text(nil, f.title, 0, 0, { size = math.floor(LEAST_FONT * 1.35), bold = true }) or 0
  for _, row in ipairs(f.items) do
    place_row(row, 1000, 0)
    local sum = 0
    for _, item in ipairs(row) do sum = sum + item.aspect end
    for _, item in ipairs(row) do
      local word = item.caption and longest_word(item.caption, LEAST_FONT) or 0
      most = math.max(most, math.ceil(word * sum / item.aspect) + f.gap * (#row - 1))
    end
  end
  return most + 2 * f.margin
end

--- Heights and texts of everything, from top to bottom; returns the height of the figure.
local function layout(f, font)
  local m, y = f.margin, f.margin
  local inner = f.width - 2 * m
  if f.title then
    local _, h = picture.text(nil, f.title, 0, 0, { size = math.floor(font * 1.35), bold = true })
    f.title_y, y = y, y + h + font
  end
  for _, row in ipairs(f.items) do
    local height, captions = place_row(row, inner, f.gap), 0
    row.y = y
    for _, item in ipairs(row) do
      if item.caption then
        item.caption_text = picture.wrap(item.caption, item.w, { size = font })
        local _, h = picture.text(nil, item.caption_text, 0, 0, { size = font })
        captions = math.max(captions, h)
      end
    end
    row.caption_y = y + height + math.floor(font * 0.5)
    y = y + height + (captions > 0 and captions + font or 0) + f.gap
  end
  y = y - f.gap
  if f.bar then
    f.bar_width = math.min(inner, math.max(320, math.floor(inner * 0.42)))
    f.bar_y = y + font
    local bar_height
    bar_height, f.draw_bar = picture_bar.horizontal(f.bar, font, f.bar_width, f.theme)
    y = f.bar_y + bar_height
  end
  if f.caption then
    f.caption_text = picture.wrap(f.caption, inner, { size = font })
    local _, h = picture.text(nil, f.caption_text, 0, 0, { size = font })
    f.caption_y = y + font
    y = f.caption_y + h
  end
  return y + m
end

local function draw(f)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local function fail(text) return check.fail("figure: %s", text) end
  local widest = 0
  for _, row in ipairs(f.items) do
    local width = 0
    for _, item in ipairs(row) do
      item.canvas, message, code = item_canvas(item, fail)
      if not item.canvas then return nil, message, code end
      local w, h = core.canvas_size(item.canvas)
      local c = item.crop
      if c and (c[1] + c[3] > w or c[2] + c[4] > h) then
        return fail(("crop {%g, %g, %g, %g} leaves the image of %d x %d"):format(c[1], c[2], c[3], c[4], w, h))
      end
      width = width + (c and c[3] or w)
    end
    widest = math.max(widest, width + (#row - 1) * f.gap)
  end
  f.width = f.asked_width or math.max(160, readable_width(f), math.min(8192, math.ceil(widest) + 2 * f.margin))
  local font = f.font or math.max(LEAST_FONT, math.min(26, math.floor(f.width / 84 + 0.5)))
  local height = layout(f, font)
  local canvas
  canvas, message = core.canvas(f.width, height, f.theme.background)
  if not canvas then
    return nil, ("the figure would be %d x %d pixels: %s"):format(f.width, height, message), "ELIMIT"
  end
  if f.title then
    picture.text(canvas, f.title, f.margin, f.title_y, { size = math.floor(font * 1.35), bold = true,
      colour = f.theme.text })
  end
  for _, row in ipairs(f.items) do
    for _, item in ipairs(row) do
      draw_item(f, canvas, item, f.margin + item.x, row.y, item.w, item.h, font)
      if item.caption then
        picture.text(canvas, item.caption_text, math.floor(f.margin + item.x + item.w / 2), row.caption_y,
          { size = font, colour = f.theme.text, align = "middle" })
      end
      item.canvas = nil
    end
  end
  if f.bar then f.draw_bar(canvas, math.floor((f.width - f.bar_width) / 2), f.bar_y) end
  if f.caption then
    picture.text(canvas, f.caption_text, f.margin, f.caption_y, { size = font, colour = f.theme.dim })
  end
  return canvas
end

local example = "ylm.figure { rows = { { { image = ylm.zeros({ 8, 8, 3 }), caption = \"black\" } } } }"
local methods = picture.methods("figure", draw, example)

-- The form --------------------------------------------------------------------------

local fields = {
  { "rows", "table",
    about = "a list of rows: lists of images, or { image | values | wipe = , caption = , label = , crop = , "
    .. "mark = , tone = , exposure = , layer = , range = , log = , map = , at = , labels = }" },
  { "title", "string", optional = true },
  { "caption", "string", optional = true, about = "below everything; broken into lines" },
  { "bar", "table", optional = true, about = "a scalar bar for all values: { range, log, map, label, unit }" },
  { "width", "integer", min = 64, max = 16384, optional = true, unit = "pixels",
    about = "default: the widest row at its own size, or as wide as title and captions need" },
  { "margin", "integer", min = 0, max = 500, default = 24, unit = "pixels" },
  { "gap", "integer", min = 0, max = 500, default = 10, unit = "pixels" },
  { "background", "any", default = "white", about = "\"dark\", \"white\" or {r, g, b}, 0 to 1" },
  { "font", "integer", min = 6, max = 200, optional = true, unit = "pixels" },
}

local function build(values, fail)
  values.theme = picture.theme(values.background, fail)
  values.asked_width, values.width = values.width, nil
  values.marks = { { 1, 0.35, 0.25 }, { 0.25, 0.75, 1 }, { 0.45, 0.9, 0.35 }, { 1, 0.8, 0.2 } }
  if values.bar then
    local function fail_here(message) return fail("bar: " .. message) end
    local bar = form.check(bar_fields, values.bar, fail_here)
    bar.range = check_range(bar.range, bar.log, fail_here)
    values.bar = bar
  end
  if #values.rows == 0 then return fail "rows is empty" end
  values.items = {}
  for r, row in ipairs(values.rows) do
    if type(row) ~= "table" or form.kind(row) then
      return fail(("row %d must be a list of images, got %s"):format(r, check.describe(row)))
    end
    if #row == 0 then return fail(("row %d is empty"):format(r)) end
    values.items[r] = {}
    for i, item in ipairs(row) do
      values.items[r][i] = check_item(item, values.bar, ("row %d, image %d"):format(r, i), fail)
    end
  end
  return setmetatable(values, form.defined.figure.metatable)
end

figure.figure = form.define("figure", {
  about = "Rows of pictures with captions, wipes between them, a shared scalar bar. Methods: save, pixels.",
  fields = fields,
  metatable = { __index = methods },
  build = build,
  example = 'figure { rows = { { { values = { { 0, 1 }, { 2, 3 } } } } }, bar = { range = { 0, 3 } } }',
})

memory.publish(methods)

return figure
