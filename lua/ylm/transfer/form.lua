--- The form `links`: how a scene file wants its surfaces cut.

local core = require "ylm.c.core"
local form = require "ylm.form"

local cut = {}

local MOST_LINKS, MOST_LMAX = core.limits.transfer_links, core.limits.transfer_lmax
local IN_FILES = 2 ^ 28 -- links of all elements that a scene file may ask for: 1 GiB

function form.types.links(x)
  if type(x) == "number" and x >= 4 and x <= MOST_LINKS and x % 4 == 0 then return x end
  return nil, ("a multiple of 4 from 4 to %d"):format(MOST_LINKS)
end

--- Options of scene:links that a scene may carry.
cut.fields = {
  { "spacing", "number", above = 0, optional = true, unit = "scene units",
    about = "the longest edge of an element; default: a hundredth of the diagonal of the scene's bounding box, without grounds "
      .. "where the camera is in the rest (and on grounds a hundredth of the diagonal of all), raised until there are at most "
      .. "max_elements" },
  { "rays", "links", default = 128, about = "rays of an element: 2 bytes each, 4 from 65,536 elements on" },
  { "lmax", "integer", min = 0, max = MOST_LMAX, default = 4,
    about = "highest degree of the elements' transfer vectors: what direct = 'field' and distant light are weighed with" },
  { "sides", "choice", of = core.choices "sides", default = "auto",
    about = "which sides of triangles reflect: 'auto' is both of an open mesh, and of a closed one those that a lamp or the "
      .. "camera "
      .. "can see; geometry has an option of this name too" },
  { "max_elements", "integer", min = 1, max = core.limits.transfer_elements_most,
    default = core.limits.transfer_elements, about = "more are refused" },
  { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of all random numbers" },
}

cut.links = form.define("links", {
  about = "How surfaces of a scene are cut into elements, and how many rays each of them sends: the defaults of scene:links.",
  fields = cut.fields,
  build = function(values, fail)
    if form.budget and values.rays * values.max_elements > IN_FILES then
      return fail(("rays times max_elements at most %.0f in a scene file"):format(IN_FILES))
    end
    return setmetatable(values, form.defined.links.metatable)
  end,
  example = "links { spacing = 0.05, rays = 128 }",
})

return cut
