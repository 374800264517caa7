--- ylm view grid.ylm scene.lua mesh.obj: what the options ask for, as the fields of ylm.view.

local status = require "ylm.cli.status"

local view_things = {}

--- Options that are fields of ylm.view under the same name.
local same = { "quantity", "range", "map", "label", "unit", "title", "caption", "size", "direction", "background",
  "supersample", "resolution", "font", "opacity", "levels", "boxes", "volume", "slices" }
--- Layers that --count thins out.
local counted = { "glyphs", "streamlines", "lobes" }

--- "y=0.2,x" as planes: { { axis = "y", at = 0.2 }, { axis = "x" } }.
local function planes(text)
  local list = {}
  for part in (text .. ","):gmatch "([^,]*)," do
    local axis, at = part:match "^([xyz])$", nil
    if not axis then axis, at = part:match "^([xyz])=(.+)$" end
    if not axis or (at and not tonumber(at)) then
      status.stop(status.usage, "view: --slice wants planes such as y=0.2 or x,z=1, got '%s'", text)
    end
    list[#list + 1] = { axis = axis, at = tonumber(at) }
  end
  return list
end

--- "0.5,1,2" as numbers.
local function numbers(name, text)
  local list = {}
  for part in (text .. ","):gmatch "([^,]*)," do
    list[#list + 1] = tonumber(part)
    if not tonumber(part) then
      status.stop(status.usage, "view: --%s wants numbers such as 0.5,1,2, got '%s'", name, text)
    end
  end
  return list
end

--- The camera that --from, --at, --up and --fov describe, looking at `middle` without --at; nil without --from.
function view_things.camera(ylm, given, middle)
  if not given.from then
    for _, name in ipairs { "at", "fov" } do
      if given[name] then status.stop(status.usage, "view: --%s is of a camera: --from X,Y,Z says where it stands", name) end
    end
    return nil
  end
  local good, camera = pcall(ylm.camera, { from = given.from, at = given.at or middle, up = given.up, fov = given.fov })
  if not good then status.stop(status.usage, "view: %s", tostring(camera)) end
  return camera
end

--- The middle of what has bounds, {min, max}.
local function middle_of(thing)
  local b = thing and thing.bounds
  if not b then return nil end
  return { (b[1][1] + b[2][1]) / 2, (b[1][2] + b[2][2]) / 2, (b[1][3] + b[2][3]) / 2 }
end

--- The fields of a view of a grid (or nil), a scene (or nil) and meshes, as the options say.
function view_things.fields(ylm, given, grid, scene, meshes)
  local fields = { grid, scene = scene, meshes = #meshes > 0 and meshes or nil, bar = not given["no-bar"],
    frame = not given["no-frame"] }
  for _, name in ipairs(same) do fields[name] = given[name] end
  for _, name in ipairs(counted) do
    if given[name] then fields[name] = given.count and { count = given.count } or true end
  end
  if given.count and not (given.glyphs or given.streamlines or given.lobes) then
    status.stop(status.usage, "view: --count is of --glyphs, --streamlines or --lobes")
  end
  if given.slice then fields.slices = planes(given.slice) end
  if given["iso-values"] then fields.isosurfaces = numbers("iso-values", given["iso-values"])
  elseif given.isosurfaces then fields.isosurfaces = given.isosurfaces end
  if given.log and given.linear then status.stop(status.usage, "view: --log or --linear, not both") end
  if given.log or given.linear then fields.log = given.log or false end
  if given.lights then
    if not scene then status.stop(status.usage, "view: --lights shows those of a scene: name its file too") end
    fields.lights = true
  end
  fields.camera = view_things.camera(ylm, given, middle_of(grid or meshes[1]))
  if not fields.camera then fields.up = given.up end
  return fields
end

return view_things
