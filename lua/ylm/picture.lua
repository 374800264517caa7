--- What views, plots and figures share: canvases, texts, ticks, scalar bars, saving.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.reference".describe

local picture = {}

--- The binding of libylm_vtk.so, or nil, message, "EMISSING".
function picture.vtk()
  local ok, vtk = pcall(require, "ylm.c.vtk")
  if ok then return vtk end
  return nil, "pictures need VTK: install libvtk9-dev and run make again (" .. tostring(vtk):match("[^\n]*") .. ")",
    "EMISSING"
end

-- Looks ----------------------------------------------------------------------------

picture.themes = {
  dark = { background = { 0.055, 0.063, 0.078 }, text = { 0.93, 0.94, 0.95 }, dim = { 0.62, 0.65, 0.69 } },
  white = { background = { 1, 1, 1 }, text = { 0.09, 0.10, 0.12 }, dim = { 0.38, 0.40, 0.44 } },
}

--- The theme for the field `background`: "dark", "white" or a colour {r, g, b}.
function picture.theme(background, fail)
  if background == nil then background = "dark" end
  if picture.themes[background] then return picture.themes[background] end
  if type(background) == "table" and #background == 3 then
    local light = 0
    for i = 1, 3 do
      local x = background[i]
      if not check.is_number(x) or x < 0 or x > 1 then light = nil break end
      light = light + x * ({ 0.2126, 0.7152, 0.0722 })[i]
    end
    if light then
      local like = light > 0.5 and picture.themes.white or picture.themes.dark
      return { background = { background[1], background[2], background[3] }, text = like.text, dim = like.dim }
    end
  end
  return fail(("background must be 'dark', 'white' or {r, g, b} from 0 to 1, got %s"):format(
    check.describe(background)))
end

--- The field `size` checked: width and height in pixels.
function picture.size(size, fail)
  if #size ~= 2 then return fail "size must be {width, height} in pixels" end
  return size[1], size[2]
end

function picture.with_alpha(rgb, a) return { rgb[1], rgb[2], rgb[3], a } end

--- Letters that suit a picture of that height.
function picture.font(width, height)
  return math.max(11, math.floor(math.min(height / 42, width / 50) + 0.5))
end

-- Numbers as text --------------------------------------------------------------------

local raised = { ["-"] = "⁻", ["0"] = "⁰", ["1"] = "¹", ["2"] = "²", ["3"] = "³", ["4"] = "⁴", ["5"] = "⁵",
  ["6"] = "⁶", ["7"] = "⁷", ["8"] = "⁸", ["9"] = "⁹" }

--- 10 to the power of an integer, as text: "10⁻³".
function picture.power(exponent)
  return "10" .. (("%d"):format(exponent):gsub(".", raised))
end

--- A number as a tick wants it: few digits, a real minus sign, powers of ten raised.
function picture.number(x)
  if x == 0 then return "0" end
  local text = ("%.4g"):format(x)
  local mantissa, exponent = text:match("^([^e]+)e([+-]%d+)$")
  if not mantissa then return (text:gsub("^%-", "−")) end
  local power = picture.power(tonumber(exponent))
  mantissa = mantissa:gsub("^%-", "−")
  return mantissa == "1" and power or mantissa .. "·" .. power
end

local function linear_ticks(lo, hi, most, whole)
  local step = 10 ^ math.floor(math.log((hi - lo) / most) / math.log(10))
  if whole and step < 1 then step = 1 end
  for _, factor in ipairs { 1, 2, 5, 10 } do
    if (hi - lo) / (step * factor) <= most then
      step = step * factor
      break
    end
  end
  local ticks, labels = {}, {}
  for i = math.ceil(lo / step - 1e-9), math.floor(hi / step + 1e-9) do
    ticks[#ticks + 1] = i * step
    labels[#labels + 1] = picture.number(i * step)
  end
  return ticks, labels
end

local function log10(x) return math.log(x) / math.log(10) end

--- Powers of ten with empty labels between them; where they are too few, 2 and 5 are labelled too.
local function log_ticks(lo, hi, most)
  local first, last = math.floor(log10(lo) + 1e-9), math.ceil(log10(hi) - 1e-9)
  local ticks, labels, decades = {}, {}, last - first
  local each = math.max(1, math.ceil(decades / most))
  local whole = math.floor(log10(hi) + 1e-9) - math.ceil(log10(lo) - 1e-9) + 1
  for e = first, last do
    for m = 1, decades > 12 and 1 or 9 do
      local x = m * 10 ^ e
      if x >= lo * (1 - 1e-9) and x <= hi * (1 + 1e-9) then
        ticks[#ticks + 1] = x
        if m == 1 then labels[#labels + 1] = e % each == 0 and picture.power(e) or ""
        elseif whole < 2 and (m == 2 or m == 5) then labels[#labels + 1] = picture.number(x)
        else labels[#labels + 1] = "" end
      end
    end
  end
  return ticks, labels
end

--- Ticks from lo to hi, about `most` of them labelled: positions, labels ("" for minor ones).
-- `whole`: none between integers.
function picture.ticks(lo, hi, log, most, whole)
  if lo >= hi then return { lo }, { picture.number(lo) } end
  return (log and log_ticks or linear_ticks)(lo, hi, most or 6, whole)
end

-- Drawing ----------------------------------------------------------------------------

local aligned = { left = 0, middle = 1, right = 2 }

--- Draws text on a canvas (nil: only measures); returns width and height.
function picture.text(canvas, text, x, y, style)
  if text == nil or text == "" then return 0, 0 end
  local vtk = assert(picture.vtk())
  return assert(vtk.text(canvas, text, x, y, style.size, style.bold or false, aligned[style.align or "left"],
    style.colour or { 1, 1, 1 }))
end

--- Breaks text into lines that fit `width`.
function picture.wrap(text, width, style)
  local lines = {}
  for paragraph in (text .. "\n"):gmatch("(.-)\n") do
    local line = ""
    for word in paragraph:gmatch("%S+") do
      local longer = line == "" and word or line .. " " .. word
      if line ~= "" and picture.text(nil, longer, 0, 0, style) > width then
        lines[#lines + 1], line = line, word
      else line = longer end
    end
    lines[#lines + 1] = line
  end
  return table.concat(lines, "\n")
end

--- How wide a vertical bar with its labels is.
function picture.bar_width(scale, font)
  local _, labels = picture.ticks(scale.range[1], scale.range[2], scale.log, 6, scale.whole)
  local widest = 0
  for _, label in ipairs(labels) do widest = math.max(widest, (picture.text(nil, label, 0, 0, { size = font }))) end
  local title = picture.text(nil, scale.label, 0, 0, { size = font })
  local unit = picture.text(nil, scale.unit, 0, 0, { size = font * 0.85 })
  return math.max(math.floor(font * 1.1) + 10 + widest, title, unit)
end

--- Draws a vertical scalar bar into box {x, y, w, h} (the title on top included); returns the colours' box.
function picture.vertical_bar(canvas, scale, x, y, height, font, theme)
  local title_height = 0
  if scale.label ~= "" then
    local _, h = picture.text(canvas, scale.label, x, y, { size = font, colour = theme.text })
    title_height = h
  end
  if scale.unit then
    local _, h = picture.text(canvas, scale.unit, x, y + title_height + 2, { size = font * 0.85, colour = theme.dim })
    title_height = title_height + h + 2
  end
  if title_height > 0 then title_height = title_height + math.floor(font * 0.7) end
  local w, top, h = math.floor(font * 1.1), y + title_height, height - title_height
  if h < 1 then return { x, top, w, 0 } end -- a picture this small has room for the title only
  local at, shape = {}, core.canvas(w, h, theme.background)
  for i = 1, h do at[i] = { (h - i + 0.5) / h } end
  local values = core.array_zeros({ h, 1 }, "double")
  core.array_fill(values, at)
  local colours = core.figure_colours(values, theme.background, scale.map, 0, 1, false)
  for i = 1, h do
    core.canvas_rectangle(shape, 0, i - 1, w, 1, { core.array_get(colours, i, 1), core.array_get(colours, i, 2),
      core.array_get(colours, i, 3), 1 })
  end
  core.canvas_copy(canvas, x, top, w, h, shape, 0, 0, w, h, true)
  local ticks, labels = picture.ticks(scale.range[1], scale.range[2], scale.log,
    math.max(2, math.floor(h / font / 2.5)), scale.whole)
  local lo, hi = scale.range[1], scale.range[2]
  local ink = picture.with_alpha(theme.dim, 1)
  for i, tick in ipairs(ticks) do
    local t = scale.log and math.log(tick / lo) / math.log(hi / lo) or (hi > lo and (tick - lo) / (hi - lo) or 0.5)
    local ty = top + h - t * h
    core.canvas_line(canvas, x + w, ty, x + w + (labels[i] == "" and 3 or 6), ty, 1, ink)
    if labels[i] ~= "" then
      local _, lh = picture.text(nil, labels[i], 0, 0, { size = font })
      picture.text(canvas, labels[i], x + w + 10, math.floor(ty - lh / 2 + 0.5), { size = font, colour = theme.text })
    end
  end
  return { x, top, w, h }
end

--- Draws a horizontal scalar bar of the given width with its label above and ticks below; returns its height.
function picture.horizontal_bar(canvas, scale, x, y, width, font, theme)
  local _, title_height = picture.text(canvas, scale.label, x + width / 2, y,
    { size = font, colour = theme.text, align = "middle" })
  local h, top = math.floor(font * 0.8), y + (scale.label ~= "" and title_height + math.floor(font * 0.3) or 0)
  local at, values = {}, core.array_zeros({ width, 1 }, "double")
  for i = 1, width do at[i] = { (i - 0.5) / width } end
  core.array_fill(values, at)
  local colours = core.figure_colours(values, theme.background, scale.map, 0, 1, false)
  if canvas then
    for i = 1, width do
      core.canvas_rectangle(canvas, x + i - 1, top, 1, h, { core.array_get(colours, i, 1),
        core.array_get(colours, i, 2), core.array_get(colours, i, 3), 1 })
    end
  end
  local lo, hi, label_height = scale.range[1], scale.range[2], 0
  local ticks, labels = picture.ticks(lo, hi, scale.log, math.max(2, math.floor(width / font / 6)))
  for i, tick in ipairs(ticks) do
    local t = scale.log and math.log(tick / lo) / math.log(hi / lo) or (hi > lo and (tick - lo) / (hi - lo) or 0.5)
    local tx = x + t * width
    if canvas then
      core.canvas_line(canvas, tx, top + h, tx, top + h + (labels[i] == "" and 3 or 6), 1,
        picture.with_alpha(theme.dim, 1))
    end
    if labels[i] ~= "" then
      local _, lh = picture.text(canvas, labels[i], math.floor(tx + 0.5), top + h + 8,
        { size = font, colour = theme.text, align = "middle" })
      label_height = math.max(label_height, lh)
    end
  end
  return top + h + 8 + label_height - y, { x, top, width, h }
end

-- Picture objects ----------------------------------------------------------------------

--- Checks that `self` is a picture of that kind.
local function is_one(self, kind, name)
  local mt = type(self) == "table" and getmetatable(self)
  if type(mt) == "table" and mt.__kind == kind then return self end
  return check.fail("%s: a %s expected before the colon, got %s", name, kind, check.describe(self))
end
picture.is_one = is_one

--- Methods save and pixels of pictures of `kind`; draw(self) returns a canvas, or nil, message, code.
function picture.methods(kind, draw, example)
  local methods = {}

  describe(kind .. ":save") {
    about = "Draws the picture and writes it as a .png file, whole or not at all.",
    arguments = { { "path", "string", "ends in .png" } },
    returns = { { "ok", "boolean", "true; or nil, message, 'EIO' | 'EMISSING' | 'EDEVICE' | 'ENOMEM'" } },
    errors = "raises on another ending; the world's failures are returned",
    example = "local picture = " .. example .. [[

local name = os.tmpname()
os.remove(name)
assert(picture:save(name .. ".png"))
os.remove(name .. ".png")]],
  }
  function methods.save(self, path)
    is_one(self, kind, "save")
    if type(path) ~= "string" or not path:lower():find("[^/]%.png$") or path:find("%z") then
      return check.bad(1, "save", "the name of a .png file expected, got %s", check.describe(path))
    end
    local vtk, message, code = picture.vtk()
    if not vtk then return nil, message, code end
    local good, canvas
    good, message, code = core.file_probe(path) -- before the work
    if not good then return nil, message, code end
    canvas, message, code = draw(self)
    if not canvas then return nil, message, code end
    return check.result("save", vtk.save_png(path, canvas))
  end

  describe(kind .. ":pixels") {
    about = "Draws the picture and returns it as numbers.",
    arguments = {},
    returns = { { "pixels", "array", "float [height][width][3], display values 0 to 1, top row first; "
      .. "or nil, message, code as for save" } },
    errors = "the world's failures are returned",
    example = "local pixels = assert((" .. example .. "):pixels())\nassert(pixels.shape[3] == 3)",
  }
  function methods.pixels(self)
    is_one(self, kind, "pixels")
    local canvas, message, code = picture.draw(self, draw)
    if not canvas then return nil, message, code end
    return check.result("pixels", core.canvas_pixels(canvas))
  end

  picture.drawers[kind] = draw
  return methods
end

--- How pictures of each kind are drawn, for figures that hold them.
picture.drawers = {}

--- A picture's canvas; or nil, message, code.
function picture.draw(self, draw)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  return draw(self)
end

return picture
