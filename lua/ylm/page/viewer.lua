--- The viewer's sources: the files of viewer/, which stand beside this module in the tree and where ylm is installed.

local core = require "ylm.c.core"

local viewer = {}

--- Weights of luminance, as the sources name them.
local weights = {}
for i, name in ipairs { "R", "G", "B" } do weights["LUMINANCE_" .. name] = ("%.4f"):format(core.luminance[i]) end

local names = { "page.html", "style.css", "viewer.js", "few.js", "probes.js", "walk.glsl", "surface.vert.glsl",
  "buffer.frag.glsl", "seen.glsl", "surface.frag.glsl", "scene.frag.glsl", "edge.vert.glsl", "flat.frag.glsl",
  "lobe.vert.glsl", "lamp.vert.glsl", "lamp.frag.glsl", "resolve.vert.glsl", "resolve.frag.glsl" }

--- Constants of grids in few bytes, as an object of JavaScript.
local function constants()
  local list = {}
  for name, value in pairs(core.grid_small_constants()) do list[#list + 1] = ("%s: %.17g"):format(name, value) end
  table.sort(list)
  return "{ " .. table.concat(list, ", ") .. " }"
end

--- The path of a module's file, as require finds it; Lua 5.1 lacks package.searchpath.
local function path_of(module)
  if package.searchpath then return package.searchpath(module, package.path) end
  local name = module:gsub("%.", "/")
  for pattern in package.path:gmatch "[^;]+" do
    local path = pattern:gsub("%?", name)
    local file = io.open(path, "rb")
    if file then
      file:close()
      return path
    end
  end
end

--- The bytes of sources by their names, those of a grid's page unless `list` names others; nil, message, code.
function viewer.sources(list)
  local here, out = path_of "ylm.page.viewer", {}
  local folder = here and here:gsub("%.lua$", "/")
  if not folder then return nil, "page: package.path has no ylm/page/viewer.lua, beside which the viewer stands", "EIO" end
  for _, name in ipairs(list or names) do
    local file, message = io.open(folder .. name, "rb")
    if not file then return nil, ("page: the viewer is incomplete: %s; install ylm anew"):format(message), "EIO" end
    out[name] = file:read "*a":gsub("LUMINANCE_%u", weights)
    file:close()
  end
  if list then return out end
  out["few.js"] = out["few.js"]:gsub("/%*@CONSTANTS@%*/{}", (constants()))
  return out
end

return viewer
