--- Checks of the methods of images: the image before the colon, its layers, other images, masks.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local memory = require "ylm.memory"

local images = {}

--- The image before the colon of method `name`, checked; returns what core.image_info does.
function images.open(x, name)
  if core.type(x) ~= "ylm.image" then
    return check.fail("%s: an image expected before the colon, got %s", name, check.describe(x))
  end
  local is_open, w, h, names, channels = memory.pcall(core.image_info, x)
  if not is_open then return check.fail("%s: the image has been closed", name) end
  return w, h, names, channels
end

--- Raises unless the image has layer `name` (nil: the first).
function images.layer(fn, x, name)
  local _, _, names = images.open(x, fn)
  if name == nil then return names[1] end
  for i = 1, #names do if names[i] == name then return name end end
  local guess = type(name) == "string" and check.guess(name, names)
  return check.fail("%s: no layer %s%s", fn, check.describe(name), guess and (" (did you mean '%s'?)"):format(guess)
    or ("; layers are " .. table.concat(names, ", ")))
end

--- Argument `n` of method `fn` as another image.
function images.other(n, fn, other)
  if core.type(other) == "ylm.image" then
    if memory.pcall(core.image_info, other) then return other end
    return check.bad(n, fn, "the image has been closed")
  end
  return check.bad(n, fn, "an image expected, got %s", check.describe(other))
end

--- A mask for the pixels of image x, as a float array: an array [h][w] or an image of one channel.
function images.mask(fn, x, mask)
  if mask == nil then return nil end
  local w, h = core.image_info(x)
  if core.type(mask) == "ylm.image" then mask = core.image_layer(images.other(0, fn, mask)) end
  if core.type(mask) == "ylm.array" then
    local shape, dtype, _, is_open = core.array_info(mask)
    if is_open and shape[1] == h and shape[2] == w and (#shape == 2 or (#shape == 3 and shape[3] == 1)) then
      return dtype == "float" and mask or core.array_convert(mask, "float")
    end
  end
  return check.fail("%s: mask must be an array of %dx%d or an image of one channel and that size, got %s",
    fn, h, w, check.describe(mask))
end

images.progress = { "progress", "progress", optional = true, about = "called as f(done, total, stage); false cancels" }
images.threads = { "threads", "integer", min = 0, max = form.threads.max, default = 0, about = "0: YLM_THREADS or all cores" }

return images
