--- Files that the key `s` writes: a scene like the first, the picture as it is shown, and its numbers.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"

local save = {}

local MOST = 10000 -- lights that are written as a list

--- A number as Lua reads it, whatever the locale.
local function number(x) return (("%.17g"):format(x):gsub(",", ".")) end
local function vector(v) return ("{ %s, %s, %s }"):format(number(v[1]), number(v[2]), number(v[3])) end

local function same(a, b) return a[1] == b[1] and a[2] == b[2] and a[3] == b[3] end

--- The fields of a lamp that are not those of another.
local function fields(row, other)
  local out = {}
  if not (other and same(row.at, other.at)) then out[#out + 1] = "at = " .. vector(row.at) end
  if not (other and row.radius == other.radius) then out[#out + 1] = "radius = " .. number(row.radius) end
  if not (other and same(row.radiance, other.radiance)) then out[#out + 1] = "radiance = " .. vector(row.radiance) end
  return #out > 0 and "{ " .. table.concat(out, ", ") .. " }" or nil
end

--- Changes of lamps as lists of lines: moved, removed, added. `first`: the rows of the scene.
local function changes(rows, first)
  local there, moved, removed, added = {}, {}, {}, {}
  for _, row in ipairs(rows) do if row.number then there[row.number] = row end end
  for _, row in ipairs(first) do
    local now = there[row.number]
    local text = now and fields(now, row)
    if not now then removed[#removed + 1] = ("%d"):format(row.number)
    elseif text then moved[#moved + 1] = ("    [%d] = %s,"):format(row.number, text) end
  end
  for _, row in ipairs(rows) do
    if not row.number then added[#added + 1] = "    sphere_light " .. fields(row) .. "," end
  end
  return moved, removed, added
end

--- The probes with the tolerance, depth and lmax that were chosen, as a line; nil where these are the scene's.
local function probes_line(s)
  local now, first = s.settings, s.first
  if now.tolerance == first.tolerance and now.depth == first.depth and now.lmax == first.lmax then return nil end
  local own = s.scene.probes
  if own and form.kind(own) ~= "adaptive_grid" then return nil end
  local bounds = own and own.bounds
  local limits = own and now.tolerance == first.tolerance and (own.threshold
    and ('metric = "%s", threshold = %s'):format(own.metric, number(own.threshold)) or "tolerance = " .. number(own.tolerance))
    or "tolerance = " .. number(now.tolerance)
  return ("  probes   = adaptive_grid { lmax = %d, depth = %d, %s%s },"):format(now.lmax, now.depth, limits, bounds
    and (", bounds = { %s, %s }"):format(vector(bounds[1]), vector(bounds[2])) or "")
end

--- Writes a text whole or not at all: true, or nil, message, code.
local function write(path, text) return check.result("live", core.file_save(path, text)) end

local function exists(path)
  local file = io.open(path, "rb")
  if file then file:close() end
  return file ~= nil
end

--- A file's name as seen from a folder that it lies in; nil: it lies elsewhere.
local function within(file, folder)
  local here = file:match "^(.*)/[^/]*$" or "."
  return here == folder and file:match "[^/]*$" or nil
end

--- The name of a copy of the scene's file beside `path`, and its path where it is new; or nil, message, code.
local function copy_beside(file, path)
  local text, message, code = core.read_file(file, 2 ^ 24)
  if not text then return nil, message, code end
  for n = 1, 99 do
    local name = path:gsub("%-[^-/]*%.lua$", n == 1 and "-scene.lua" or ("-scene-%d.lua"):format(n))
    local there = core.read_file(name, 2 ^ 24)
    local new = there == nil and not exists(name)
    if new then
      local ok
      ok, message, code = write(name, text)
      if not ok then return nil, message, code end
    end
    if new or there == text then return name:match "[^/]*$", new and name or nil end
  end
  return nil, ("copies of %s beside %s are all taken"):format(check.describe(file), check.describe(path)), "EIO"
end

--- The text of a scene file that makes what the window shows, and the path of a copy that it needed. `path`: where it will lie.
-- Or nil, message, code.
local function text_of(s, path)
  local out = { ("-- %s, changed in a window (ylm live)."):format((s.scene.name or "scene"):gsub("%c", " ")), "" }
  local function add(line, ...) out[#out + 1] = select("#", ...) > 0 and line:format(...) or line end
  local file = s.scene.file
  add("return scene %q {", s.scene.name or "scene")
  local other = file and within(file, path:match "^(.*)/[^/]*$" or ".")
  local copied, code
  if file and not other then
    if not s.scene.alone then
      return nil, ("the scene's file %s lies in another folder and is made of other files there: save beside it (%s)"):format(
        check.describe(file), check.describe((file:gsub("%.%w+$", "")))), "EINVAL"
    end
    other, copied, code = copy_beside(file, path)
    if not other then return nil, copied, code end
  end
  if other then add("  like     = %q,", other) end
  local c = s.camera
  if not other or c ~= s.cameras[1] then
    add("  camera   = camera { from = %s, at = %s, up = %s, fov = %s },", vector(c.from), vector(c.at), vector(c.up),
      number(c.fov))
  end
  if other then
    local moved, removed, added = changes(s.lamps, s.first_lamps)
    if #moved > 0 then add("  moved    = {\n" .. table.concat(moved, "\n") .. "\n  },") end
    if #removed > 0 then add("  removed  = { " .. table.concat(removed, ", ") .. " },") end
    if #added > 0 then add("  added    = {\n" .. table.concat(added, "\n") .. "\n  },") end
  else
    if s.others > 0 then
      return nil, "a scene without a file is saved as a list of sphere lights, and it has other lights", "EINVAL"
    end
    if #s.lamps > MOST then
      return nil, ("a scene without a file is saved as a list of at most %d lights"):format(MOST), "EINVAL"
    end
    add "  lights   = {"
    for _, row in ipairs(s.lamps) do add("    sphere_light %s,", fields(row)) end
    add "  },"
  end
  local probes = probes_line(s)
  if probes then add(probes) end
  add "}"
  return table.concat(out, "\n") .. "\n", copied
end

--- Writes the scene alone, over what stood there: for work that shall not be lost. True, and the path of a copy of the scene's
-- file where that lies in another folder; or nil, message, code.
function save.scene(s, path)
  local text, copied, code = text_of(s, path)
  if not text then return nil, copied, code end
  local ok, message
  ok, message, code = write(path, text)
  if not ok then return nil, message, code end
  return true, copied
end

--- Writes PREFIX-N.lua, PREFIX-N.png and PREFIX-N.exr with the first N of 1 to 999 that is free; `png(path)` and `image` make
-- pictures. Returns the names; or nil, message, code.
function save.all(s, prefix, png, image)
  for n = 1, 999 do
    local name = ("%s-%d"):format(prefix, n)
    if not (exists(name .. ".lua") or exists(name .. ".png") or exists(name .. ".exr")) then
      local names = {}
      local ok, message, code = save.scene(s, name .. ".lua")
      if ok then names[1] = name .. ".lua" elseif code ~= "EINVAL" then return nil, message, code end
      local note = not ok and message or nil
      if ok and message then names[2] = message end
      ok, message, code = png(name .. ".png")
      if not ok then return nil, message, code end
      names[#names + 1] = name .. ".png"
      if image then
        ok, message, code = image:save(name .. ".exr")
        if not ok then return nil, message, code end
        names[#names + 1] = name .. ".exr"
      end
      return names, note
    end
  end
  return nil, ("%s-1 to %s-999 are all taken"):format(prefix, prefix), "EIO"
end

return save
