--- POV-Ray's radiosity: an irradiance cache, seen by a camera of one triangle a place.

local plain = require "spec.bench.rivals.plain"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore
local povray = { name = "POV-Ray, radiosity" }

povray.settings = {
  { name = "count 400, error_bound 0.2, recursion_limit 6", count = 400, error = 0.2, recursion = 6 },
  { name = "count 200, error_bound 0.4, recursion_limit 6", count = 200, error = 0.4, recursion = 6 },
}

local MOST_LAMPS = 64 -- each ray of a place asks all lamps
local FADE = 1e-3     -- light falls by 2 / (1 + (r / FADE)^2)
local LIFT = 0.005
local SCALE = 1 / 64  -- of light, since pictures end at 1

function povray.lacks() if not plain.there "povray" then return "not here: apt-get install povray" end end

function povray.version() return scratch.capture "povray --version 2>&1":match "POV%-Ray (%S+)" end

local function vector(v) return ("<%.8g,%.8g,%.8g>"):format(v[1], v[2], v[3]) end
local function colour(c, scale) return ("rgb<%.8g,%.8g,%.8g>"):format(c[1] * scale, c[2] * scale, c[3] * scale) end

--- Triangles of a list of numbers, as a mesh.
local function mesh(out, positions, texture)
  out[#out + 1] = "mesh {"
  for k = 1, #positions, 9 do
    out[#out + 1] = ("triangle { %s, %s, %s }"):format(vector { unpack(positions, k, k + 2) },
      vector { unpack(positions, k + 3, k + 5) }, vector { unpack(positions, k + 6, k + 8) })
  end
  out[#out + 1] = texture .. " }"
end

--- A triangle of 0.1 mm at a place, `lift` above it; turned: the other way round.
local function corners_of(p, n, lift, turned)
  local u, v, corners = {}, {}, {}
  local far = math.abs(n[1]) < 0.7 and { 1, 0, 0 } or { 0, 1, 0 }
  local function cross(out, x, y)
    for a = 1, 3 do
      local b, c = a % 3 + 1, (a + 1) % 3 + 1
      out[a] = x[b] * y[c] - x[c] * y[b]
    end
  end
  cross(u, n, far)
  cross(v, n, u)
  local side = turned and -1 or 1
  for k, st in ipairs { { 1, 0 }, { -0.5, -0.8 * side }, { -0.5, 0.8 * side } } do
    corners[k] = {}
    for a = 1, 3 do corners[k][a] = p[a] + lift * n[a] + 1e-4 * (st[1] * u[a] + st[2] * v[a]) end
  end
  return corners
end

local function camera(out, points, normals, turned)
  out[#out + 1] = "camera { mesh_camera { 1 0 mesh {"
  for i, p in ipairs(points) do
    local c = corners_of(p, normals[i], LIFT, turned[i])
    out[#out + 1] = ("triangle { %s, %s, %s }"):format(vector(c[1]), vector(c[2]), vector(c[3]))
  end
  out[#out + 1] = "} } location <0,0,0> direction <0,0,1> }"
end

--- Marks of 1 mm between the camera and the places, which alone are seen.
local function marks(points, normals)
  local out, list = { "#version 3.7; global_settings { assumed_gamma 1 } background { rgb 0 }" }, {}
  for i, p in ipairs(points) do
    for _, c in ipairs(corners_of(p, normals[i], LIFT / 2)) do
      for a = 1, 3 do list[#list + 1] = p[a] + LIFT / 2 * normals[i][a] + 10 * (c[a] - p[a] - LIFT / 2 * normals[i][a]) end
    end
  end
  mesh(out, list, "texture { pigment { rgb 1 } finish { emission 1 diffuse 0 ambient 0 } }")
  camera(out, points, normals, {})
  return table.concat(out, "\n") .. "\n"
end

--- The scene's text. pass: "radiosity", "direct", or "albedo", whose surfaces shine by their colour.
local function text_of(all, points, normals, turned, pass, setting)
  local out = { "#version 3.7; #include \"colors.inc\"" }
  local bodies = pass == "albedo" and "finish { emission 1 diffuse 0 ambient 0 }" or "finish { ambient 0 diffuse 1 }"
  local radiosity = pass == "radiosity" and ("radiosity { count %d error_bound %g recursion_limit %d nearest_count 8 "
    .. "brightness 1 gray_threshold 0 low_error_factor 0.7 minimum_reuse 0.001 pretrace_start 0.01 pretrace_end 0.001 "
    .. "always_sample on adc_bailout 0.0001 }"):format(setting.count, setting.error, setting.recursion) or ""
  out[#out + 1] = ("global_settings { assumed_gamma 1 max_trace_level 50 %s }\nbackground { rgb 0 }"):format(radiosity)
  for _, m in ipairs(all.meshes) do
    mesh(out, m.positions, ("texture { pigment { %s } %s }"):format(colour(m.colour, 1), bodies))
  end
  -- colours of surfaces that shine are pi radiances: a colour is that of a surface of albedo 1. Panels let rays through.
  local shine = "texture { pigment { %s } finish { emission 1 diffuse 0 ambient 0 } } no_shadow"
  local panel = "texture { pigment { %s transmit 0.999 } finish { emission 1000 diffuse 0 ambient 0 } } no_shadow"
  for _, p in ipairs(all.panels) do
    local triangles = {}
    for k = 4, #p.corners - 3, 3 do
      for _, at in ipairs { 1, k, k + 3 } do for a = 0, 2 do triangles[#triangles + 1] = p.corners[at + a] end end
    end
    mesh(out, triangles, panel:format(colour(p.radiance, pass == "albedo" and 0 or math.pi * SCALE)))
  end
  for _, l in ipairs(pass ~= "albedo" and all.lamps or {}) do
    out[#out + 1] = ("light_source { %s, %s fade_distance %g fade_power 2 }"):format(vector(l.at),
      colour(l.power, SCALE / (2 * FADE ^ 2)), FADE)
  end
  if all.sky and pass ~= "albedo" then
    plain.each_patch(all.sky, 50, function(c, L)
      local triangles = {}
      for _, k in ipairs { 1, 2, 3, 1, 3, 4 } do for a = 1, 3 do triangles[#triangles + 1] = c[k][a] end end
      mesh(out, triangles, shine:format(colour(L, math.pi * SCALE)))
    end)
  end
  camera(out, points, normals, turned)
  return table.concat(out, "\n") .. "\n"
end

--- Colours that a pass sees at the places, and processor seconds; or nil, why not.
local function seen(folder, text, points, pass)
  local scene = folder:write(pass .. ".pov", text)
  local image = folder.path .. "/" .. pass .. ".exr"
  local said, seconds = plain.counted(("cd %s && povray +I%s +O%s +FE +W%d +H1 -D -V -A +WT1 File_Gamma=1 %s 2>&1"):format(
    scratch.quote(folder.path), scene, image, #points, pass == "radiosity" and "+RFO +RFcache.rca" or ""))
  local picture = ylm.load(image)
  if not picture then return nil, "povray: " .. said:sub(-600) end
  local pixels, rows = picture:layer(), {}
  for i = 1, #points do rows[i] = { pixels:get(1, i, 1), pixels:get(1, i, 2), pixels:get(1, i, 3) } end
  return rows, seconds
end

--- Irradiance at places, processor seconds and bytes of the cache; or nil, why not.
function povray.run(all, points, normals, quantity, setting)
  if #all.lamps > MOST_LAMPS then return nil, ("not run: %d lamps"):format(#all.lamps) end
  local folder = scratch.new()
  local marked, why = seen(folder, marks(points, normals), points, "marks")
  if not marked then return nil, why end
  local turned = {} -- a camera looks to a side of its triangle that POV-Ray chooses
  for i, c in ipairs(marked) do turned[i] = c[1] < 0.5 end
  local function pass_of(pass) return seen(folder, text_of(all, points, normals, turned, pass, setting), points, pass) end
  local albedo = pass_of "albedo"
  local rows, seconds = pass_of "radiosity"
  if not rows or not albedo then return nil, seconds end
  if quantity == "indirect" then
    local direct, more = pass_of "direct"
    rows, seconds = plain.less(rows, direct), seconds + more
  end
  for i, row in ipairs(rows) do for c = 1, 3 do row[c] = row[c] / math.max(1e-6, albedo[i][c]) / SCALE end end
  local bytes = scratch.capture("stat -c %s " .. scratch.quote(folder.path .. "/cache.rca"))
  folder:remove()
  return rows, seconds, tonumber(bytes:match "%d+")
end

return povray
