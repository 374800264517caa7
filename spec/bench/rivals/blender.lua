--- Blender's EEVEE (irradiance volumes) and Cycles (bakes), by blender.py: blender("eevee"), blender("cycles").

local plain = require "spec.bench.rivals.plain"
local scratch = require "spec.support.scratch"

local MOST_LAMPS = 32 -- EEVEE has 42 shadow maps of points

local function lacks(wants)
  for _, name in ipairs(wants) do
    if not plain.there(name) then return "not here: apt-get install " .. (name == "xvfb-run" and "xvfb" or name) end
  end
end

local function version() return scratch.capture "blender --version":match "Blender (%S+)" end

--- Irradiance at places, processor seconds of the bake, and bytes; or nil, why not.
local function run(command, all, box, points, normals, words)
  local folder = scratch.new()
  all.points, all.normals, all.lo, all.hi = points, normals, box[1], box[2]
  folder:write("scene.json", plain.json(all))
  local said, status = scratch.capture(plain.bounded(("cd %s && timeout 1800 %s --python-exit-code 1 --python "
    .. "\"$OLDPWD/spec/bench/rivals/blender.py\" -- scene.json out.txt %s"):format(scratch.quote(folder.path), command, words)))
  local text = folder:read "out.txt"
  folder:remove()
  local why = plain.ended(status)
  if why or not text then return nil, "blender: " .. (why or said:match "%w*Error[^\n]*" or said:sub(-200):gsub("\n", " ")) end
  local seconds, bytes = text:match "SECONDS (%S+) BYTES ([^\n]+)"
  local size, unit = bytes:match "%(([%d.]+) (%a+)"
  if size then bytes = size * (unit == "MiB" and 2 ^ 20 or 2 ^ 10) end
  return plain.rows(text:match "^(.*)SECONDS"), tonumber(seconds), tonumber(bytes)
end

local cycles = { name = "Cycles, bake", lacks = function() return lacks { "blender" } end, version = version }
cycles.settings = { { name = "512 x 16 paths a place", samples = 512, most_lamps = 64 }, { name = "64 x 16", samples = 64 } }
function cycles.run(all, points, normals, quantity, setting)
  if #all.lamps > (setting.most_lamps or math.huge) then return nil, ("not run: %d lamps"):format(#all.lamps) end
  return run("blender -b", all, { { 0, 0, 0 }, { 1, 1, 1 } }, points, normals,
    ("cycles %s %d"):format(quantity, setting.samples))
end

local eevee = { name = "EEVEE, irradiance volume", version = version }
function eevee.lacks() return lacks { "blender", "xvfb-run" } end
function eevee.run(all, points, normals, quantity, setting)
  if #all.lamps > MOST_LAMPS then return nil, ("not run: %d lamps, and EEVEE has 42 shadow maps"):format(#all.lamps) end
  return run("xvfb-run -a blender", all, setting.box, points, normals, ("eevee %s %s %d %d"):format(quantity,
    table.concat(setting.cells, ","), setting.bounces, setting.cube))
end

return { cycles = cycles, eevee = eevee }
