--- A scene in numbers for other programs: plain.of(scene) -> { meshes, lamps, panels, sky }.
--
--   meshes   positions (nine numbers a triangle), colour, side ("front", "back" or "both": which one reflects), alpha of
--            gloss or nil
--   lamps    at, radius, radiance, power (candela)
--   panels   corners (numbers), radiance, of both sides
--   sky      radiance at 64 x 32 directions, the row beside +y first, or nil

local form = require "ylm.form"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local plain = {}

plain.sky_size = { 64, 32 }
plain.seconds_most = 600 -- of a rival's process
local XCPU = 152         -- exit status after the signal of ulimit -t
local GLOSSY = { 0.9, 0.9, 0.9 } -- of materials without albedo, which are matte where a program has no gloss

--- A list of numbers, words and lists, or a table of names, as JSON.
function plain.json(value)
  if type(value) == "number" then return ("%.7g"):format(value) end
  if type(value) == "string" then return '"' .. value .. '"' end
  local words = {}
  if #value > 0 or next(value) == nil then
    for i, x in ipairs(value) do words[i] = plain.json(x) end
    return "[" .. table.concat(words, ",") .. "]"
  end
  for name, x in pairs(value) do words[#words + 1] = '"' .. name .. '":' .. plain.json(x) end
  table.sort(words)
  return "{" .. table.concat(words, ",") .. "}"
end

local function meshes_of(scene)
  local list = {}
  for _, g in ipairs(scene.geometry) do
    local vertices, triangles, positions = g.mesh:vertices():totable(), g.mesh:triangles():totable(), {}
    for _, t in ipairs(triangles) do
      for k = 1, 3 do for a = 1, 3 do positions[#positions + 1] = vertices[t[k]][a] end end
    end
    local albedo = g.material and g.material.albedo
    if type(albedo) == "number" then albedo = { albedo, albedo, albedo } end
    local alpha = g.material and type(albedo) ~= "table" and g.material.alpha or nil
    list[#list + 1] = { positions = positions, colour = type(albedo) == "table" and albedo or GLOSSY, side = g.sides or "both",
      alpha = type(alpha) == "table" and math.sqrt(alpha[1] * alpha[2]) or alpha }
  end
  return list
end

--- The direction of a texel of the sky, from 0.
function plain.direction(column, row)
  local theta, phi = (row + 0.5) / plain.sky_size[2] * math.pi, ((column + 0.5) / plain.sky_size[1] - 0.5) * 2 * math.pi
  return { math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi) }
end

local function sky_of(light)
  local directions = {}
  for y = 0, plain.sky_size[2] - 1 do
    for x = 0, plain.sky_size[1] - 1 do directions[#directions + 1] = plain.direction(x, y) end
  end
  local L, out = ylm.sh.reconstruct(ylm.light_field(20, light, { { 0, 0, 0 } }):reshape { 3, 441 }, directions):totable(), {}
  for i = 1, #directions do for channel = 1, 3 do out[#out + 1] = math.max(0, L[channel][i]) end end
  return out
end

function plain.of(scene)
  local all = { meshes = meshes_of(scene), lamps = {}, panels = {} }
  for _, light in ipairs(scene.lights) do
    local kind = form.kind(light)
    if kind == "sphere_light" then
      local power = {}
      for c = 1, 3 do power[c] = math.pi * light.radius ^ 2 * light.radiance[c] end
      all.lamps[#all.lamps + 1] = { at = light.at, radius = light.radius, radiance = light.radiance, power = power }
    elseif kind == "polygon_light" then
      local corners = {}
      for _, v in ipairs(light.vertices) do for a = 1, 3 do corners[#corners + 1] = v[a] end end
      all.panels[#all.panels + 1] = { corners = corners, radiance = light.radiance }
    elseif kind == "environment_light" then all.sky = sky_of(light)
    else error("no rival has a " .. kind) end
  end
  return all
end

--- The sky as quadrilaterals of a distant sphere: each(corners [4], radiance).
function plain.each_patch(sky, distance, each)
  local columns, rows = plain.sky_size[1], plain.sky_size[2]
  for y = 0, rows - 1 do
    for x = 0, columns - 1 do
      local corners, at = {}, 3 * (y * columns + x)
      for k, corner in ipairs { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } } do
        local d = plain.direction(x + corner[1] - 0.5, y + corner[2] - 0.5)
        corners[k] = { distance * d[1], distance * d[2], distance * d[3] }
      end
      each(corners, { sky[at + 1], sky[at + 2], sky[at + 3] })
    end
  end
end

--- A shell command that ends after plain.seconds_most processor seconds of one of its processes.
function plain.bounded(command) return ("ulimit -t %d; %s"):format(plain.seconds_most, command) end

--- Says why a bounded command ended early, by its exit status, or nil.
function plain.ended(status)
  local stopped = status == XCPU or status == 256 - (XCPU - 128) -- the second one is Python's of a negative status
  if stopped then return ("longer than %d processor seconds"):format(plain.seconds_most) end
  if status == 124 then return "longer than the bench waits" end -- of timeout
end

--- Runs a bounded command: its output, and the processor seconds of it and of all that it started.
function plain.counted(command)
  local text, status = scratch.capture("python3 spec/bench/rivals/processor.py sh -c "
    .. scratch.quote(plain.bounded(command)))
  local why = plain.ended(status)
  if why then error(why, 0) end
  local seconds = text:match "PROCESSOR ([%d.]+)%s*$"
  return text, tonumber(seconds)
end

--- Is a command there?
function plain.there(name) return scratch.shell("command -v " .. name .. " >/dev/null 2>&1") end

--- Numbers of lines of three, of a text.
function plain.rows(text)
  local rows = {}
  for r, g, b in text:gmatch "([^%s]+)%s+([^%s]+)%s+([^%s]+)[^\n]*\n" do
    local row = { tonumber(r), tonumber(g), tonumber(b) }
    if row[1] and row[2] and row[3] then rows[#rows + 1] = row end
  end
  return rows
end

--- a - b, of rows of three.
function plain.less(a, b)
  local rows = {}
  for i = 1, #a do rows[i] = { a[i][1] - b[i][1], a[i][2] - b[i][2], a[i][3] - b[i][3] } end
  return rows
end

return plain
