--- Functions that views, plots and figures share: canvases, texts, ticks, saving. Scalar bars: picture/bar.lua.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local library = require "ylm.library"
local text = require "ylm.picture.text"

local picture = { ticks = require "ylm.picture.ticks".of }

--- The binding of libylm_vtk.so, or nil, message, "EMISSING" | "ENOMEM".
function picture.vtk()
  return library.open("vtk", "pictures need libylm_vtk with VTK 9: install libvtk9-dev and run make again (%s)")
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
      light = light + x * core.luminance[i]
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

-- Drawing ----------------------------------------------------------------------------

--- Draws text on a canvas (nil: only measures); returns width and height.
function picture.text(canvas, words, x, y, style)
  if words == nil or words == "" then return 0, 0 end
  return text.set(assert(picture.vtk()), canvas, words, x, y, style)
end

--- Breaks text into lines that fit `width`.
function picture.wrap(words, width, style)
  local lines = {}
  for paragraph in (words .. "\n"):gmatch("(.-)\n") do
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

-- Picture objects ----------------------------------------------------------------------

--- Checks that `self` is a picture of that kind.
local function is_one(self, kind, name)
  local mt = type(self) == "table" and getmetatable(self)
  if type(mt) == "table" and mt.__kind == kind then return self end
  return check.fail("%s: a %s expected before the colon, got %s", name, kind, check.describe(self))
end
picture.is_one = is_one

--- Methods save and pixels of pictures of `kind`; draw(self) returns a canvas, or nil, message, code. `other`: files that
-- are no rasters, { endings =, about =, save = f(self, path) }, or nil.
function picture.methods(kind, draw, example, other)
  local methods, files = {}, ".png"
  for i, ending in ipairs(other and other.endings or {}) do
    files = files .. (i == #other.endings and " or ." or ", .") .. ending
  end

  describe(kind .. ":save") {
    about = other and "Draws the picture and writes it as a .png file, or " .. other.about .. " A file is written whole or not "
      .. "at all." or "Draws the picture and writes it as a .png file, whole or not at all.",
    arguments = { { "path", "string", "ends in " .. files } },
    returns = { { "ok", "boolean", "true" .. (other and other.returns or "")
      .. "; or nil, message, 'EIO' | 'EMISSING' | 'EDEVICE' | 'ENOMEM'" } },
    errors = "raises on another ending; the world's failures are returned",
    example = "local picture = " .. example .. [[

local name = os.tmpname()
os.remove(name)
assert(picture:save(name .. ".png"))
os.remove(name .. ".png")]],
  }
  function methods.save(self, path)
    is_one(self, kind, "save")
    local ending = type(path) == "string" and not path:find "%z" and path:lower():match "[^/]%.(%w+)$"
    local is_other = false
    for _, name in ipairs(other and other.endings or {}) do is_other = is_other or ending == name end
    if ending ~= "png" and not is_other then
      return check.bad(1, "save", "the name of a %s file expected, got %s", files, check.describe(path))
    end
    local vtk, message, code = picture.vtk()
    if not vtk then return nil, message, code end
    local good, canvas
    good, message, code = core.file_probe(path) -- before the work
    if not good then return nil, message, code end
    if is_other then return check.result("save", other.save(self, path)) end
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
