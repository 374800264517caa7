--- ylm view grid.ylm --quantity error, ylm view a.npy b.npy --product

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"
local view_sh = require "ylm.cli.view_sh"

local of_grids = { "quantity", "range", "log", "slices", "levels" }
local of_vectors = { "product", "rotate", "angle" }

--- Ends the command where an option was given that this kind of file has no use for.
local function refuse(given, names, what)
  for _, name in ipairs(names) do
    if given[name] ~= nil then status.stop(status.usage, "view: --%s is for %s", name, what) end
  end
end

--- What the files hold: all arrays, or one of anything else.
local function load(ylm, given)
  local objects = {}
  for i, path in ipairs(given) do objects[i] = status.need(ylm.load(path)) end
  local core = require "ylm.c.core"
  for i, object in ipairs(objects) do
    if #objects > 1 and core.type(object) ~= "ylm.array" then
      status.stop(status.usage, "view: several files must all hold SH vectors, %s does not", given[i])
    end
  end
  return objects, core.type(objects[1]) == "ylm.array"
end

return {
  summary = "a picture of a grid, or of SH vectors as lobes: to a file with -o, else in a window",
  usage = "GRID.ylm [--quantity NAME] [-o PICTURE.png]\n       ylm view C.npy [MORE.npy ..] [--product] "
    .. "[--rotate X,Y,Z [--angle N]] [-o PICTURE.png]",
  least = 1,
  most = 16,
  options = {
    { "output", "-o", "FILE", "a .png; without it a window opens" },
    { "quantity", nil, "NAME", "error, lambda, norm, ...: see ylm help view" },
    { "range", nil, "A,B", "of the colours" },
    { "log", nil, nil, "logarithmic colours" },
    { "slices", nil, nil, "planes through the middle" },
    { "levels", nil, nil, "the wireframe of the levels" },
    { "product", nil, nil, "SH vectors: show their product beside them" },
    { "rotate", nil, "X,Y,Z", "SH vectors: show them turned about this axis beside them" },
    { "angle", nil, "N", "of --rotate, degrees, default 90" },
    { "title", nil, "TEXT", "above the picture" },
    { "size", "-s", "WxH", "pixels" },
  },
  run = function(given)
    local ylm = require "ylm"
    if given.output then status.need_output("view", given.output, "png") end
    if given.json and not given.output then status.stop(status.usage, "view: --json goes with -o FILE, not with a window") end
    if given.angle and not given.rotate then status.stop(status.usage, "view: --angle goes with --rotate X,Y,Z") end
    local objects, vectors = load(ylm, given)
    local good, picture, summaries
    if vectors then
      refuse(given, of_grids, "grids")
      good, picture, summaries = pcall(view_sh.view, ylm, given, objects, given)
    else
      refuse(given, of_vectors, "SH vectors")
      local options = { status.need_kind("ylm.grid", "a grid or SH vectors", given[1], objects[1]), title = given.title,
        size = given.size }
      for _, name in ipairs(of_grids) do options[name] = given[name] end
      good, picture = pcall(ylm.view, options)
    end
    if not good then -- what it refuses stood on the command line
      if tostring(picture):find "^view: " then status.stop(status.usage, "%s", picture) end
      error(picture, 0)
    end
    if given.output then
      status.need(picture:save(given.output))
      if given.json then report.print(given, { output = given.output, vectors = summaries })
      else report.say(given, "%s", given.output) end
    else
      status.need(picture:show())
    end
  end,
}
