-- Refusals of images, colours and their methods.

local nan, inf = 0 / 0, math.huge

local function new(ylm) return ylm.image { size = { 4, 3 } } end

local function closed(ylm)
  local x = new(ylm)
  x:close()
  return x
end

local function case(call, says) return { call = call, says = says } end

--- A method on something else, on a closed image, and its own cases.
local function method(name, own)
  local all = {
    case(function(ylm) new(ylm)[name](5) end, name .. ": an image expected before the colon, got 5"),
    case(function(ylm) new(ylm)[name](ylm.zeros { 2 }) end, name .. ": an image expected"),
  }
  if name ~= "close" then -- which may be done twice
    all[3] = case(function(ylm) local x = closed(ylm) x[name](x) end, name .. ": the image has been closed")
  end
  for _, c in ipairs(own or {}) do all[#all + 1] = c end
  return all
end

--- One call with each of the arguments.
local function each(f, says, ...)
  local all = {}
  for i = 1, select("#", ...) do
    local x = select(i, ...)
    all[i] = case(function(ylm)
      local result, message = f(ylm, x) -- no tail call, which would hide the line
      return result, message
    end, says)
  end
  return all
end

local function join(...)
  local all = {}
  for i = 1, select("#", ...) do
    for _, c in ipairs((select(i, ...))) do all[#all + 1] = c end
  end
  return all
end

local function save(ylm, ...)
  local result, message = new(ylm):save("/nonexistent/folder/x.png", ...)
  return result, message
end

local function save_as(ylm, path, options)
  local result, message = new(ylm):save(path, options)
  return result, message
end

return {
  image = join(
    each(function(ylm, size) local x = ylm.image { size = size } return x end, "size",
      {}, { 4 }, { 1, 2, 3 }, 5, "4x4", { nan, 2 }, { 1.5, 2 }, { 0, 4 }, { -1, 4 }, { 65537, 1 },
      { 60000, 60000 }, { inf, 1 }),
    each(function(ylm, layers)
      local x = ylm.image { size = { 2, 2 }, layers = layers }
      return x
    end, "layer",
      {}, 3, { 3 }, { { "a" } }, { { 1, 3 } }, { { "a", 0 } }, { { "a", 5 } }, { { "", 1 } }, { { "a b", 1 } },
      { { "a", 1 }, { "a", 1 } }, { { ("x"):rep(65), 1 } }, { { "a", nan } }),
    {
      case(function(ylm) ylm.image() end, "a table of named fields expected, got nil"),
      case(function(ylm) ylm.image {} end, "field 'size' is missing"),
      case(function(ylm) ylm.image { size = { 2 ^ 40, 1 } } end, "image size 1099511627776 x 1: sides"),
      case(function(ylm) ylm.image { size = { 1, 1 }, layers = { { "a\0b", 1 } } } end,
        "the name of element 1 holds a zero byte"),
      case(function(ylm) ylm.image { sizes = { 1, 2 } } end, "no field 'sizes' %(did you mean 'size'%?%)"),
      case(function(ylm) ylm.image { size = { 2, 2 }, metadata = { a = {} } } end, "metadata: 'a' must be a string"),
      case(function(ylm) new(ylm).metadata[""] = "x" end, "metadata: a name"),
      case(function(ylm) new(ylm).metadata.x = "a\0b" end, "metadata: 'x' must be"),
      case(function(ylm) new(ylm).size = { 2, 2 } end, "cannot set 'size'"),
    }),
  colour = {
    case(function(ylm) ylm.colour("virids", 0) end, "did you mean 'viridis'"),
    case(function(ylm) ylm.colour(nil, 0) end, "one of"),
    case(function(ylm) ylm.colour("grey", nan) end, "a number expected"),
    case(function(ylm) ylm.colour("grey") end, "a number expected, got nil"),
  },
  ["image:layers"] = method "layers",
  ["image:close"] = method "close",
  ["image:layer"] = method("layer", {
    case(function(ylm) new(ylm):layer "radianse" end, "no layer 'radianse' %(did you mean 'radiance'%?%)"),
    case(function(ylm) new(ylm):layer(1) end, "no layer 1"),
  }),
  ["image:exposure"] = method("exposure", {
    case(function(ylm) new(ylm):exposure { layer = "glow" } end, "no layer 'glow'"),
    case(function(ylm) new(ylm):exposure { stops = 61 } end, "stops must be a number .*<= 60"),
    case(function(ylm) new(ylm):exposure { stop = 1 } end, "no field .stop. .*did you mean .stops."),
  }),
  ["image:add"] = method("add", {
    case(function(ylm) new(ylm):add() end, "a name expected, got nil"),
    case(function(ylm) new(ylm):add("radiance", 1) end, "is there already"),
    case(function(ylm) new(ylm):add("x/y", 1) end, "letters, digits"),
    case(function(ylm) new(ylm):add("x", 5) end, "from 1 to 4, got 5"),
    case(function(ylm) new(ylm):add("x", nan) end, "channels must be an integer"),
  }),
  ["image:save"] = method("save", join(
    each(save_as, "a file name expected", nil, 5, "", "a\0b.png", {}),
    each(save_as, "must end in", "x.jpg", "x", "png"),
    each(save, "options", 5, "png"),
    each(save, "bits must be one of 8, 16, 32", { bits = 12 }, { bits = nan }, { bits = "16" }),
    {
      case(save, "No such file"),
      case(function(ylm) save(ylm, { tone = "filmic" }) end, "tone must be one of 'srgb'"),
      case(function(ylm) save(ylm, { exposure = nan }) end, "exposure must be a number"),
      case(function(ylm) save(ylm, { exposure = 1e6 }) end, "exposure must be a number from %-60 to 60, or 'auto'"),
      case(function(ylm) save(ylm, { tones = "aces" }) end, "did you mean 'tone'"),
      case(function(ylm) save(ylm, { layer = "depth" }) end, "no layer 'depth'"),
      case(function(ylm) save(ylm, { bits = 32 }) end, "PNG has 8 or 16 bits"),
      case(function(ylm) save_as(ylm, "/tmp/x.exr", { bits = 8 }) end, "OpenEXR has 16 or 32 bits"),
      case(function(ylm) ylm.image { size = { 2, 2 }, layers = { { "a", 2 } } }:save "/tmp/x.pfm" end,
        "1 or 3 channels"),
      case(function(ylm) ylm.image { size = { 2, 2 }, layers = { { "a", 4 } } }:save "/tmp/x.hdr" end,
        "3 channels"),
          })),
  ["image:compare"] = method("compare", {
    case(function(ylm) new(ylm):compare() end, "an image expected, got nil"),
    case(function(ylm) new(ylm):compare(ylm.image { size = { 3, 4 } }) end, "sizes differ: 4 x 3 and 3 x 4"),
    case(function(ylm) new(ylm):compare(ylm.image { size = { 4, 3 }, layers = { { "radiance", 1 } } }) end, "3 channels"),
    case(function(ylm)
      new(ylm):compare(ylm.image { size = { 4, 3 }, layers = { { "x", 3 } } }, { layer = "radiance" })
    end,
      "no layer 'radiance' in the other image"),
    case(function(ylm) new(ylm):compare(new(ylm), { mask = ylm.zeros { 3, 4 } }) end, "the mask leaves no pixel"),
    case(function(ylm) new(ylm):compare(new(ylm), { mask = ylm.zeros { 4, 3 } }) end, "mask must be an array of 3x4"),
    case(function(ylm) new(ylm):compare(new(ylm), { mask = 5 }) end, "mask must be an array of 3x4"),
    case(function(ylm) new(ylm):compare(new(ylm), { peak = -1 }) end, "peak must be a number > 0"),
    case(function(ylm) new(ylm):compare(new(ylm), { floor = nan }) end, "floor must be a number > 0"),
    case(function(ylm) new(ylm):compare(new(ylm), { epsilon = 0 }) end, "epsilon must be a number > 0"),
    case(function(ylm) new(ylm):compare(new(ylm), { flip = "yes" }) end, "flip must be one of 'hdr', 'ldr'"),
    case(function(ylm) new(ylm):compare(new(ylm), { threads = -1 }) end, "threads must be an integer"),
    case(function(ylm) new(ylm):compare(closed(ylm)) end, "closed"),
  }),
  ["image:flip"] = method("flip", {
    case(function(ylm) new(ylm):flip() end, "an image expected, got nil"),
    case(function(ylm) new(ylm):flip(ylm.image { size = { 3, 4 } }) end, "sizes differ: 4 x 3 and 3 x 4"),
    case(function(ylm) new(ylm):flip(new(ylm), { range = "sdr" }) end, "range must be one of 'hdr', 'ldr'"),
    case(function(ylm) new(ylm):flip(new(ylm), { pixels_per_degree = 0 }) end, "pixels_per_degree must be a number > 0"),
    case(function(ylm) new(ylm):flip(new(ylm), { start = 1, stop = 0 }) end, "the first exposure, 1 stops, is above the last, 0"),
    case(function(ylm) new(ylm):flip(new(ylm), { start = nan }) end, "start must be a number"),
    case(function(ylm) new(ylm):flip(new(ylm), { mask = ylm.zeros { 3, 4 } }) end, "the mask leaves no pixel"),
    case(function(ylm) new(ylm):flip(closed(ylm)) end, "closed"),
  }),
  ["image:difference"] = method("difference", {
    case(function(ylm) new(ylm):difference(3) end, "an image expected, got 3"),
    case(function(ylm) new(ylm):difference(ylm.image { size = { 3, 4 } }) end, "sizes differ"),
    case(function(ylm) new(ylm):difference(new(ylm), { scale = inf }) end, "scale must be a number"),
    case(function(ylm) new(ylm):difference(new(ylm), { kind = "sign" }) end, "one of 'absolute'"),
    case(function(ylm) new(ylm):difference(new(ylm), { floor = 0 }) end, "floor must be a number > 0"),
  }),
  ["image:crop"] = method("crop", {
    case(function(ylm) new(ylm):crop() end, "x must be an integer"),
    case(function(ylm) new(ylm):crop(1, 1, 5, 1) end, "not within the image of 4 x 3"),
    case(function(ylm) new(ylm):crop(0, 1, 1, 1) end, "not within the image"),
    case(function(ylm) new(ylm):crop(1, 1, 0, 1) end, "width must be an integer >= 1"),
    case(function(ylm) new(ylm):crop(1, nan, 1, 1) end, "y must be an integer"),
    case(function(ylm) new(ylm):crop(1, 1, 1e300, 1) end, "not within the image"),
  }),
  ["image:resize"] = method("resize", {
    case(function(ylm) new(ylm):resize() end, "a size { width, height } expected"),
    case(function(ylm) new(ylm):resize { 0, 1 } end, "sides must be 1"),
    case(function(ylm) new(ylm):resize { 1e9, 1 } end, "sides must be 1"),
    case(function(ylm) new(ylm):resize({ 1, 1 }, { filter = "cubic" }) end, "filter must be one of 'box'"),
  }),
  ["image:paste"] = method("paste", {
    case(function(ylm) new(ylm):paste(1, 1, 1) end, "an image expected, got 1"),
    case(function(ylm) new(ylm):paste(new(ylm), 1.5, 1) end, "x must be an integer"),
    case(function(ylm) new(ylm):paste(ylm.image { size = { 1, 1 }, layers = { { "a", 2 } } }, 1, 1) end, "2 channels"),
    case(function(ylm) new(ylm):paste(new(ylm), 1, 1, { from = "x" }) end, "no layer 'x'"),
    case(function(ylm) new(ylm):paste(new(ylm), 1, 1, { mask = ylm.zeros { 1 } }) end, "mask must be an array"),
  }),
  ["image:fill"] = method("fill", {
    case(function(ylm) new(ylm):fill(1, 1, 1, 1) end, "a colour expected"),
    case(function(ylm) new(ylm):fill(1, 1, 1, 1, { 1, 2 }) end, "a colour expected: a number, or 3 of them"),
    case(function(ylm) new(ylm):fill(1, 1, 1, 1, nan) end, "a colour expected"),
    case(function(ylm) new(ylm):fill(1, 1, -1, 1, 1) end, "width must be an integer >= 0"),
    case(function(ylm) new(ylm):fill(inf, 1, 1, 1, 1) end, "x must be an integer"),
    case(function(ylm) new(ylm):fill(1, 1, 1, 1, 1, { layer = "x" }) end, "no layer 'x'"),
  }),
  ["image:text"] = method("text", {
    case(function(ylm) new(ylm):text(1, 1) end, "a string expected, got nil"),
    case(function(ylm) new(ylm):text(1, 1, "a", { scale = 0 }) end, "scale must be an integer >= 1"),
    case(function(ylm) new(ylm):text(1, 1, "a", { colour = "red" }) end, "a colour expected"),
    case(function(ylm) new(ylm):text(nan, 1, "a") end, "x must be an integer"),
  }),
  ["image:colours"] = method("colours", {
    case(function(ylm) new(ylm):colours() end, "field 'range' is missing"),
    case(function(ylm) new(ylm):colours { range = { 1, 1 } } end, "range must be two numbers"),
    case(function(ylm) new(ylm):colours { range = { 0, nan } } end, "range must be two numbers"),
    case(function(ylm) new(ylm):colours { range = { 0, 1 }, log = true } end, "must rise and be above 0"),
    case(function(ylm) new(ylm):colours { range = { 0, 1 }, map = "jet" } end, "map must be one of"),
  }),
  ["image:directions"] = method("directions", {
    case(function(ylm) new(ylm):directions { mapping = "cube" } end, "six times as high as wide, not 4x3"),
    case(function(ylm) new(ylm):directions { mapping = "mirror" } end, "mapping must be one of"),
    case(function(ylm) new(ylm):directions { up = "x" } end, "up must be one of 'z', 'y'"),
  }),
  ["image:positions"] = method("positions", {
    case(function(ylm) new(ylm):positions { { 1, 0, 0 }, { 0, 0, 0 } } end, "direction 2 is zero"),
    case(function(ylm) new(ylm):positions { { 1, 0, nan } } end, "row 1 is not finite"),
    case(function(ylm) new(ylm):positions { { 1, 0 } } end, "rows of 3 numbers expected"),
    case(function(ylm) new(ylm):positions() end, "a table of numbers or an array expected"),
  }),
}
