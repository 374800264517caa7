--- Materials of OBJ files: the libraries that they name (MTL), and the images that these name.
--
--     local set = mtl.open({ { name = "room.mtl", line = 1 } }, "scenes", fail)    -- or nil, message, code
--     local found = set:find("wall", 12)      -- { material =, emission = or nil }, or nil, message, code
--     set.known                               -- whether a library was read
--     set.notes, set.warnings                 -- sentences about what is read, and what is not
--
-- Notes say what was made of the file; warnings, which are among them, that something is missing.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local matte = require "ylm.material.matte"
local phong = require "ylm.material.phong"
local text = require "ylm.text"
local texture = require "ylm.material.texture"
local vector = require "ylm.vector"

local mtl = {}

local NAMED = 4 -- sentences of one kind before the others are only counted
local KD = { 0.8, 0.8, 0.8 } -- of a material that says none, as other readers have it

local methods = {}

-- Notes ---------------------------------------------------------------------------------

--- Adds a sentence; of `kind` the first NAMED are kept, the others are counted.
local function note(set, kind, sentence, ...)
  set.counts[kind] = (set.counts[kind] or 0) + 1
  if set.counts[kind] > NAMED then return end
  sentence = text.shown(sentence:format(...))
  set.notes[#set.notes + 1] = sentence
  return sentence
end

local function warn(set, kind, sentence, ...)
  set.warnings[#set.warnings + 1] = note(set, kind, sentence, ...)
end

--- Completes the notes: how many sentences of each kind were left out.
function methods.finish(set)
  for _, kind in ipairs { "library", "material", "image", "scaled" } do
    local more = (set.counts[kind] or 0) - NAMED
    if more > 0 then set.notes[#set.notes + 1] = ("%s: and %d more of the kind: %s"):format(text.shown(set.file), more, kind) end
  end
end

-- Files -----------------------------------------------------------------------------------

--- The path of a file that another one in `folder` names; nil, message, code, of a missing one "EIO". A scene file's lie at
-- or below the folder.
local function locate(folder, name)
  name = name:gsub("\\", "/")
  if form.locate then return form.locate(folder, name) end
  local path = name:sub(1, 1) == "/" and name or folder .. "/" .. name
  local head, message, code = core.file_head(path)
  if not head then return nil, message, code end
  return path
end

local function folder_of(path) return path:match "^(.*)/[^/]*$" or "." end

--- Names of one statement mtllib that has several, which end in .mtl.
local function names_in(list)
  local names, rest = {}, list
  while rest do
    local first, more = rest:match "^(.-%.[mM][tT][lL])%s+(.*)$"
    names[#names + 1] = first or rest
    rest = more
  end
  return names
end

--- Reads one library into the set, if that was not done before: true, or nil, message, code.
local function read_library(set, path)
  if set.read[path] then return true end
  set.read[path] = true
  local materials, skipped, words = core.mtl_read(path, form.budget and form.budget "file_size" or 0)
  if not materials then return nil, skipped, words end
  for _, m in ipairs(materials) do
    m.file = path
    if set.materials[m.name] then
      note(set, "twice", "%s:%d: material '%s' stands in line %d too: the last one counts", path, m.line, check.short(m.name),
        set.materials[m.name].line)
    else
      set.names[#set.names + 1] = m.name
    end
    set.materials[m.name] = m
  end
  if skipped > 0 then
    note(set, "skipped", "%s: %d statement%s not read: %s", path, skipped, skipped == 1 and " is" or "s are", words)
  end
  return true
end

--- Reads the libraries that one statement names; a missing one is told.
local function read_statement(set, statement)
  local path, message, code = locate(set.folder, statement.name)
  local names = path and { statement.name } or names_in(statement.name)
  for _, name in ipairs(names) do
    if #names > 1 or not path then path, message, code = locate(set.folder, name) end
    if path then
      local ok
      ok, message, code = read_library(set, path)
      if not ok then return nil, message, code end
    elseif code == "EIO" then
      warn(set, "library", "%s:%d: mtllib %s is not read: %s", set.file, statement.line, check.describe(name), message)
    else
      return nil, ("%s:%d: mtllib %s: %s"):format(set.file, statement.line, check.describe(name), message), code
    end
  end
  return true
end

-- Materials ---------------------------------------------------------------------------------

--- The texture of an image that a material names, once each; nothing where the image is missing, which is told; nil, message,
-- code.
local function texture_of(set, m, fail)
  if not m.map_Kd then return nil end
  local place = ("%s:%d: map_Kd %s"):format(m.file, m.map_Kd.line, check.describe(m.map_Kd.name))
  local path, message, code = locate(folder_of(m.file), m.map_Kd.name)
  if not path and code == "EIO" then
    warn(set, "image", "%s is not read, and Kd stands alone: %s", place, message)
    return nil
  end
  if not path then return nil, place .. ": " .. message, code end
  if not set.textures[path] then
    local made
    made, message, code = texture.of_file(path, fail)
    if not made then return nil, place .. ": " .. message, code end
    set.textures[path] = made
  end
  return set.textures[path]
end

local function largest(c) return math.max(c[1], c[2], c[3]) end

--- The factor that brings base and specular to 1 in each channel.
local function fitting(kd, ks)
  local most = 0
  for c = 1, 3 do most = math.max(most, kd[c] + ks[c]) end
  return most > 1 and 1 / most or 1
end

--- A material of ylm: matte, or phong where it has highlights.
local function convert(set, m, kd)
  local ks = m.Ks
  if not ks or largest(ks) == 0 then return matte { albedo = kd } end
  local k = fitting(kd, ks)
  if k < 1 then
    note(set, "scaled", "%s:%d: material '%s': Kd + Ks is above 1: both are multiplied by %.3g", m.file, m.line,
      check.short(m.name), k)
    k = k * (1 - 1e-6) -- the sum of two roundings is not above 1 either
  end
  return phong { base = vector.times(kd, k), specular = vector.times(ks, k), exponent = m.Ns or 0 }
end

--- Makes { material =, emission = } of one entry; nil, message, code.
local function make(set, m, fail)
  if m.Ke and largest(m.Ke) > 0 then return { emission = m.Ke } end
  local image, message, code = texture_of(set, m, fail)
  if message then return nil, message, code end
  local made
  made, message, code = convert(set, m, m.Kd or image and { 1, 1, 1 } or KD)
  if not made then return nil, message, code end
  return { material = texture.attach(image, made) }
end

--- The material of a name that usemtl gives in a line; one without material where the name is unknown, which is told; nil,
-- message, code.
function methods.find(set, name, line, fail)
  if set.made[name] then return set.made[name] end
  local m, made, message, code = set.materials[name]
  if m then
    made, message, code = make(set, m, fail)
    if not made then return nil, message, code end
  else
    local guess = (set.counts.material or 0) < NAMED and check.guess(name, set.names)
    warn(set, "material", "%s:%d: no material '%s'%s", set.file, line, check.short(name),
      guess and (" (did you mean '%s'?)"):format(check.short(guess)) or "")
    made = {}
  end
  set.made[name] = made
  return made
end

--- The libraries of the OBJ file `file`, which its statements mtllib name; nil, message, code.
function mtl.open(libraries, file)
  local set = setmetatable({ file = file, folder = folder_of(file), names = {}, materials = {}, read = {}, made = {},
    textures = {}, notes = {}, warnings = {}, counts = {} }, { __index = methods })
  for _, statement in ipairs(libraries) do
    local ok, message, code = read_statement(set, statement)
    if not ok then return nil, message, code end
    set.known = set.known or next(set.materials) ~= nil
  end
  return set
end

return mtl
