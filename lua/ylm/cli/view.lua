--- ylm view grid.ylm --quantity error

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

return {
  summary = "a picture of a grid: to a file with -o, else in a window",
  usage = "GRID.ylm [--quantity NAME] [-o PICTURE.png]",
  least = 1,
  options = {
    { "output", "-o", "FILE", "a .png; without it a window opens" },
    { "quantity", nil, "NAME", "error, lambda, norm, ...: see ylm help view" },
    { "range", nil, "A,B", "of the colours" },
    { "log", nil, nil, "logarithmic colours" },
    { "slices", nil, nil, "planes through the middle" },
    { "levels", nil, nil, "the wireframe of the levels" },
    { "title", nil, "TEXT", "above the picture" },
    { "size", "-s", "WxH", "pixels" },
  },
  run = function(given)
    local ylm = require "ylm"
    if given.output then status.need_output("view", given.output, "png") end
    local object = status.need_kind("ylm.grid", "a grid", given[1], ylm.load(given[1]))
    local options = { object }
    for _, name in ipairs { "quantity", "range", "log", "slices", "levels", "title", "size" } do
      options[name] = given[name]
    end
    local good, picture = pcall(ylm.view, options) -- what it refuses stood on the command line
    if not good then
      if tostring(picture):find "^view: " then status.stop(status.usage, "%s", picture) end
      error(picture, 0)
    end
    if given.output then
      status.need(picture:save(given.output))
      if given.json then report.print(given, { output = given.output })
      else report.say(given, "%s", given.output) end
    else
      status.need(picture:show())
    end
  end,
}
