--- The picture of scene:judge: what a camera sees by paths, by probes, and the error between them.

local array = require "ylm.array"
local core = require "ylm.c.core"
local image = require "ylm.image"
local places = require "ylm.grid.places"

local picture = {}

local LARGEST = 0.3              -- the error at the end of the colours
local GREY = 0.25                -- of the mean irradiance
local ZOOM, CAPTION, SCALE = 3, 26, 2 -- pixels of one place; rows for the caption, and its letters'
local DIM = 0.02                 -- where nothing is seen

--- Numbers of places [n] as a raster of w x h whose pixels without a place have `empty`.
local function raster(numbers, seen, w, h, empty)
  local list, k, all = numbers:totable(), 0, {}
  for i, there in ipairs(seen) do
    if there then k = k + 1 end
    all[i] = there and list[k] or empty
  end
  return array.array(all, "float"):reshape { h, w, 1 }
end

--- A panel of rows of the picture: `paint` makes an image of one that has the layer "number".
local function panel(numbers, caption, paint)
  local h, w = numbers.shape[1], numbers.shape[2]
  local small, message, code = image.image { size = { w, h }, layers = { { "number", 1 } } }
  if not small then return nil, message, code end
  small:layer "number"[{}] = numbers
  local painted = paint(small)
  local big
  big, message, code = image.image { size = { ZOOM * w, ZOOM * h + CAPTION } }
  if not big then return nil, message, code end
  painted, message, code = painted:resize({ ZOOM * w, ZOOM * h }, { filter = "box" })
  if not painted then return nil, message, code end
  big:paste(painted, 1, CAPTION + 1)
  big:text(5, 5, caption, { scale = SCALE, colour = { 1, 1, 1 } })
  return big
end

local function grey(small)
  local w, h = small.size[1], small.size[2]
  return image.image { size = { w, h } }:paste(small, 1, 1)
end

local function colours(small) return small:colours { range = { 0, LARGEST }, map = "magma" } end

--- Places that the scene's camera sees in a raster of w x h: { n, points, normals }, and which pixels have one. Or nil, message,
-- code.
local function looked_at(s, o)
  local view, message, code = s:prepare { size = o.picture, samples = 1, threads = o.threads, progress = o.progress }
  if not view then return nil, message, code end
  local layer = {}
  for _, name in ipairs { "position", "normal", "coverage", "emitter" } do
    layer[name], message, code = view:layer(name)
    if not layer[name] then return nil, message, code end
  end
  view:close()
  local n, seen = o.picture[1] * o.picture[2], {}
  local mask = layer.coverage:greater(0.5):reshape { n } * layer.emitter:less(0.5):reshape { n }
  for i, x in ipairs(mask:totable()) do seen[i] = x == 1 end
  local count = mask:sum()
  if count == 0 then return nil, "judge: the camera sees no surface: no picture is made", "EDOMAIN" end
  local p = { n = count, points = layer.position:reshape { n, 3 }:select(mask) }
  p.normals = layer.normal:reshape { n, 3 }:select(mask)
  return p, seen
end

--- The picture, by o.picture = { width, height } places: an image of three panels. `light` is that of paths (ylm.grid.places),
-- `read(p)` luminances of probes at places, `mean` what errors are beside at least. Or nil, message, code.
function picture.of(s, o, light, read, mean)
  local p, seen, code = looked_at(s, o)
  if not p then return nil, seen, code end
  local wanted, variance
  wanted, variance, code = light.irradiance(p.points, p.normals)
  if not wanted then return nil, variance, code end
  wanted = places.luminance(wanted)
  local noise = (places.luminance(variance:sqrt()) / wanted:clamp(math.max(mean, 1e-300))):mean()
  local got, message
  got, message, code = read(p)
  if not got then return nil, message, code end
  local off = (got - wanted):abs() / wanted:clamp(math.max(mean, 1e-300))
  local w, h, shade = o.picture[1], o.picture[2], GREY / math.max(mean, 1e-300)
  local panels = {}
  for i, row in ipairs {
    { raster(wanted * shade, seen, w, h, DIM), "paths", grey },
    { raster(got * shade, seen, w, h, DIM), "probes", grey },
    { raster(off, seen, w, h, 0), ("error, 0 to %g; %.2g is noise"):format(LARGEST, noise), colours } } do
    panels[i], message, code = panel(row[1], row[2], row[3])
    if not panels[i] then return nil, message, code end
  end
  local out
  out, message, code = image.image { size = { 3 * ZOOM * w, ZOOM * h + CAPTION } }
  if not out then return nil, message, code end
  for i, one in ipairs(panels) do out:paste(one, 1 + (i - 1) * ZOOM * w, 1) end
  out.metadata.software, out.metadata.version = "ylm", (core.info())
  return out
end

return picture
