--- Scenes as scene files: surfaces as .glb and photometries as .ies beside a .lua that names them.

local core = require "ylm.c.core"
local form = require "ylm.form"
local scenes = require "ylm.scene"
local warning = require "ylm.warning"

local written = {}

--- A number that reads the same again.
local function number(x) return ("%.17g"):format(x) end

local function list(x)
  local out = {}
  for i, v in ipairs(x) do out[i] = number(v) end
  return "{ " .. table.concat(out, ", ") .. " }"
end

local function quoted(text) return (("%q"):format(text):gsub("\n", "n")) end

local function opening(o)
  if type(o) ~= "table" then return quoted(o) end
  return ("{ shape = %s, %s }"):format(quoted(o.shape), o.size and "size = " .. list(o.size) or o.radius
    and "radius = " .. number(o.radius) or "")
end

local writers = {}

function writers.photometric_light(l, names)
  local parts = { "photometry = " .. names[l.photometry], "at = " .. list(l.at) }
  if l.to then parts[#parts + 1] = "to = " .. list(l.to) end
  if l.turn ~= 0 then parts[#parts + 1] = "turn = " .. number(l.turn) end
  parts[#parts + 1] = "dim = " .. number(l.dim)
  if l.colour then parts[#parts + 1] = "colour = " .. list(l.colour) end
  if l.temperature then parts[#parts + 1] = "temperature = " .. number(l.temperature) end
  parts[#parts + 1] = "opening = " .. opening(l.opening)
  if l.efficacy then parts[#parts + 1] = "efficacy = " .. number(l.efficacy) end
  if l.name then parts[#parts + 1] = "name = " .. quoted(l.name) end
  return "photometric_light { " .. table.concat(parts, ", ") .. " }"
end

--- A field's value as text: numbers, words, lists of these; nil: it is none of them.
local function value(x)
  local kind = type(x)
  if kind == "number" then return number(x) end
  if kind == "boolean" then return tostring(x) end
  if kind == "string" then return quoted(x) end
  if kind ~= "table" or form.kind(x) then return nil end
  local parts = {}
  for i, v in ipairs(x) do
    parts[i] = value(v)
    if not parts[i] then return nil end
  end
  for key, v in pairs(x) do
    if type(key) == "string" then
      local text = value(v)
      if not text then return nil end
      parts[#parts + 1] = key .. " = " .. text
    end
  end
  return "{ " .. table.concat(parts, ", ") .. " }"
end

--- A light as its form's fields; nil, message, code where one is no text.
local function of_form(l)
  local name, parts = form.kind(l), {}
  for _, field in ipairs(form.defined[name] and form.defined[name].fields or {}) do
    local key = field[1]
    if l[key] ~= nil then
      local text = value(l[key])
      if not text then return nil, ("save: %s of a %s is no text: a scene file cannot hold it"):format(key, name), "EINVAL" end
      parts[#parts + 1] = key .. " = " .. text
    end
  end
  if #parts == 0 then return nil, "save: a set of lights is no text: a scene file cannot hold it", "EINVAL" end
  return name .. " { " .. table.concat(parts, ", ") .. " }"
end

--- Writes the photometries of lights beside a file; the names that they have in it, and lines that read them; nil, message, code.
local function photometries(lights, base, files)
  local names, lines = {}, {}
  for _, l in ipairs(lights) do
    local p = l.photometry
    if p and not names[p] then
      local path = ("%s_%d.ies"):format(base, #lines + 1)
      local ok, message, code = p:save(path)
      if not ok then return nil, message, code end
      files[#files + 1] = path
      names[p] = ("lamp_%d"):format(#lines + 1)
      lines[#lines + 1] = ("local %s = photometry { file = %s }"):format(names[p], quoted(path:match "[^/]*$"))
    end
  end
  return names, lines
end

--- Writes the scene s to `path`: true, and the files; nil, message, code.
function written.save(s, path)
  local base, files = path:sub(1, -5), {}
  local surfaces = scenes.scene(s.name) { camera = s.camera, geometry = s.geometry }
  local ok, message, code = warning.silently(surfaces.save, surfaces, base .. ".glb")
  if not ok then return nil, message, code end
  files[1] = base .. ".glb"
  local names, lines = photometries(s.lights, base, files)
  if not names then return nil, lines, message end
  local text = { "-- A scene that scene:inverse_lighting has planned.", "" }
  for _, line in ipairs(lines) do text[#text + 1] = line end
  text[#text + 1] = ("\nreturn scene %s {\n  like = %s,\n  lights = {"):format(quoted(s.name), quoted(files[1]:match "[^/]*$"))
  for _, l in ipairs(s.lights) do
    local line
    line, message, code = (writers[form.kind(l)] or of_form)(l, names)
    if not line then return nil, message, code end
    text[#text + 1] = "    " .. line .. ","
  end
  text[#text + 1] = "  },\n}\n"
  ok, message, code = core.file_save(path, table.concat(text, "\n"))
  if not ok then return nil, message, code end
  files[#files + 1] = path
  return true, files
end

return written
