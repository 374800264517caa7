--- Images of the sphere: directions of pixels, and pixels of directions.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local images = require "ylm.image.check"

local methods = core.metatable "ylm.image"

local mapping_options = {
  { "mapping", "choice", of = core.choices "mapping", default = "latlong",
    about = "cube: six faces in a column, +x -x +y -y +z -z" },
  { "up", "choice", of = core.choices "up", default = "z",
    about = "the pole; the middle of the image is +x, or -z where y is up" },
}

describe "image:directions" {
  about = "The direction and the solid angle of every pixel of an image of the whole sphere, row by row.",
  arguments = { { "options?", "table", "" } },
  options = mapping_options,
  returns = {
    { "directions", "array", "double [height*width][3], unit; zeros outside of an angular map's disc" },
    { "solid_angles", "array", "double [height*width], sr; their sum is 4 pi" },
  },
  errors = "raises on a cube map whose height is not six times its width",
  example = [[
local d = ylm.image { size = { 2, 1 } }:directions()
assert(math.abs(d:get(1, 2) - 1) < 1e-15)           -- the left half of the equator is +y]],
}
function methods.directions(x, options)
  local w, h = images.open(x, "directions")
  options = form.options(1, "directions", mapping_options, options)
  local d, angles, code = core.mapping_pixels(options.mapping, options.up, w, h)
  if not d and code == "ESHAPE" then
    return check.fail("directions: a cube map is six times as high as wide, not %dx%d", w, h)
  end
  return check.result("directions", d, angles, code)
end

describe "image:positions" {
  about = "Where directions fall on an image of the whole sphere: the inverse of image:directions.",
  arguments = { { "directions", "array|table", "[n][3], any length but 0" }, { "options?", "table", "" } },
  options = mapping_options,
  returns = { { "positions", "array",
    "double [n][2]: x from the left, y from the top; a pixel's middle is at k - 0.5" } },
  errors = "raises on a zero direction, naming the row",
  example = [[
local p = ylm.image { size = { 8, 4 } }:positions { { 1, 0, 0 } }
assert(p:get(1, 1) == 4 and p:get(1, 2) == 2)]],
}
function methods.positions(x, directions, options)
  local w, h = images.open(x, "positions")
  local d = require("ylm.array").points(1, "positions", directions, "double")
  options = form.options(2, "positions", mapping_options, options)
  return check.result("positions", core.mapping_positions(options.mapping, options.up, w, h, d))
end
