--- Radiance's rtrace -I: irradiance at places by an ambient cache. Looked for in PATH, with rayinit.cal in RAYPATH.

local plain = require "spec.bench.rivals.plain"
local scratch = require "spec.support.scratch"

local unpack = table.unpack or unpack -- luacheck: ignore
local MOST_LAMPS = 64 -- each ray of a place asks all lamps
local radiance = { name = "Radiance, rtrace -I" }

-- The default of -lw loses a percent of the light of closed rooms. -av 0: nothing is added for what is not traced.
radiance.settings = {
  { name = "-ab 12 -aa .2 -ad 1024 -as 512 -ar 64 -lw 1e-5", bounces = 12 },
  { name = "-ab 6 -aa .3 -ad 256 -as 64 -ar 32 -lw 1e-4", bounces = 6 },
}

function radiance.lacks()
  if not (plain.there "rtrace" and plain.there "oconv") then return "not here: rtrace and oconv are not in PATH" end
end

function radiance.version() return scratch.capture "rtrace -version":match "RADIANCE (%S+)" end

local function colour(c) return ("%.7g %.7g %.7g"):format(c[1], c[2], c[3]) end

local function polygon(out, material, name, corners)
  out[#out + 1] = ("%s polygon %s 0 0 %d %s"):format(material, name, #corners, table.concat(corners, " "))
end

--- A scene as Radiance's text. The sky has 2,048 patches that glow.
local function text_of(all)
  local out = {}
  for i, m in ipairs(all.meshes) do
    if m.alpha then out[#out + 1] = ("void metal m%d 0 0 5 %s 1 %.6g"):format(i, colour(m.colour), m.alpha)
    else out[#out + 1] = ("void plastic m%d 0 0 5 %s 0 0"):format(i, colour(m.colour)) end
    for k = 1, #m.positions, 9 do polygon(out, "m" .. i, ("p%d_%d"):format(i, k), { unpack(m.positions, k, k + 8) }) end
  end
  for i, l in ipairs(all.lamps) do
    out[#out + 1] = ("void light l%d 0 0 3 %s\nl%d sphere s%d 0 0 4 %s %.6g"):format(i, colour(l.radiance), i, i, colour(l.at),
      l.radius)
  end
  local n = 0
  if all.sky then
    plain.each_patch(all.sky, 50, function(corners, L)
      local list = {}
      for k = 4, 1, -1 do for a = 1, 3 do list[#list + 1] = corners[k][a] end end -- glow is black from behind
      n = n + 1
      out[#out + 1] = ("void glow g%d 0 0 4 %s 0"):format(n, colour(L))
      polygon(out, "g" .. n, "sky" .. n, list)
    end)
  end
  return table.concat(out, "\n") .. "\n"
end

--- Irradiance at places, processor seconds and bytes of the cache; or nil, why not.
function radiance.run(all, points, normals, quantity, setting)
  if #all.panels > 0 then return nil, "not run: rays end at its panels, and pass those of the scene" end
  if #all.lamps > MOST_LAMPS then return nil, ("not run: %d lamps"):format(#all.lamps) end
  local folder, lines = scratch.new(), {}
  for i, p in ipairs(points) do lines[i] = ("%.9g %.9g %.9g %s"):format(p[1], p[2], p[3], colour(normals[i])) end
  folder:write("places", table.concat(lines, "\n") .. "\n")
  local scene = folder:write("scene.rad", text_of(all))
  local inside = "cd " .. scratch.quote(folder.path) .. " && "
  local said, status = scratch.capture(inside .. "oconv " .. scene .. " > scene.oct")
  if status ~= 0 then return nil, "oconv: " .. said end
  local command = inside .. "rtrace -h -w -I+ -dj 0 -ds .1 -dt 0 -dc 1 %s scene.oct < places"
  local E, seconds = plain.counted(command:format(setting.name .. " -af cache"))
  local rows = plain.rows(E)
  local bytes = scratch.capture(inside .. "stat -c %s cache")
  if quantity == "indirect" then
    local direct, more = plain.counted(command:format "-ab 0")
    rows, seconds = plain.less(rows, plain.rows(direct)), seconds + more
  end
  folder:remove()
  if #rows ~= #points then return nil, "rtrace gave " .. #rows .. " rows: " .. E:sub(1, 200) end
  return rows, seconds, tonumber(bytes:match "%d+")
end

return radiance
