--- The objects that scene:links and links:radiosity return, and what they were made of.

local check = require "ylm.check"
local core = require "ylm.c.core"
local show = require "ylm.show"
local tracing = require "ylm.trace"

local objects = {}

local lib = tracing.library()

--- The record of all that such an object was made of.
function objects.made(object) return core.owned(object, "made") end

--- Closes an object by `close`; what it was made of can be read as before.
function objects.close(object, close)
  local m = objects.made(object)
  check.result("close", close(object))
  m.closed, core.own(object).made = true, m
end

--- The methods of the userdata "ylm.NAME"; `fields` can be read from it, `text` is what it prints as.
function objects.kind(name, fields, text)
  local methods, readable = lib and core.metatable("ylm." .. name) or {}, {}
  for _, field in ipairs(fields) do readable[field] = true end
  methods.__index = function(object, key)
    local m = objects.made(object)
    if m and readable[key] then return key == "stats" and show.report(m[key]) or m[key] end
    return rawget(methods, key)
  end
  methods.__newindex = function(_, key)
    return check.fail("%s: cannot set %s: %s not change so", name, check.describe(key),
      name == "links" and "links do" or ("a %s does"):format((name:gsub("_", " "))))
  end
  methods.__tostring = function(object)
    local m = objects.made(object)
    if not m or m.closed then return ("ylm.%s (closed)"):format(name) end
    return ("ylm.%s of %q: %s"):format(name, m.scene.name or "?", text(m))
  end
  return methods
end

objects.links = objects.kind("links", { "stats", "scene", "notes" }, function(m)
  return ("%d elements, %d links of each"):format(m.stats.elements, m.stats.links)
end)

objects.radiosity = objects.kind("radiosity", { "stats", "scene", "links", "notes" }, function(m)
  return ("%d elements, %d bounces"):format(m.elements, m.stats.bounces)
end)

objects.gather = objects.kind("gather", { "stats", "scene", "radiosity", "rays" }, function(m)
  return ("%s light, %s rays"):format(m.quantity, m.rays == "auto" and m.rays or ("%.0f"):format(m.rays))
end)

--- Names that stand for more than one.
local PLURAL = { links = true, receivers = true }

--- All about the object before the colon.
function objects.opened(name, object, type_name, article)
  if core.type(object) ~= type_name then
    return check.fail("%s: %s expected before the colon, got %s", name, article, check.describe(object))
  end
  local m = objects.made(object)
  if not m or m.closed then
    return check.fail("%s: the %s %s been closed", name, article:gsub("^an? ", ""), PLURAL[article] and "have" or "has")
  end
  return m
end

function objects.open_links(name, t)
  return objects.opened(name, t, "ylm.links", "links")
end

--- Raises where the option `links` of function `name` is closed, or of another scene than `scene`.
function objects.check_scene(name, t, scene)
  objects.open_links(name, t)
  if t.scene == scene then return end
  return check.fail("%s: the links are of scene %q, this is another, %q: make some of it (scene:links)", name,
    t.scene.name or "?", scene.name or "?")
end

function objects.open_radiosity(name, lit)
  return objects.opened(name, lit, "ylm.radiosity", "a radiosity")
end

function objects.open_gather(name, field)
  return objects.opened(name, field, "ylm.gather", "a gathered field")
end

--- Do two traced scenes hold the same meshes?
function objects.alike(a, b)
  if #a.shapes ~= #b.shapes then return false end
  for i = 1, #a.shapes do if a.shapes[i] ~= b.shapes[i] then return false end end
  return true
end

--- All about the links t; raises where a prepared view is of other meshes, or t have been closed.
function objects.of_view(name, p, t)
  local m = objects.open_links(name, t)
  if objects.alike(p.traced, m.traced) then return m end
  return check.fail("%s: the links are of other geometry, that of scene %q%s: make some of the view's scene (scene:links)",
    name, m.scene.name or "?", m.scene == p.scene and ", before it changed or after" or "")
end

--- Raises where the meshes of a scene differ from those that links were made of. Returns the scene traced
-- anew; or nil, message, code.
function objects.traced_again(name, m)
  local now, message, code = tracing.trace(name, m.scene)
  if not now then return nil, message, code end
  if objects.alike(m.traced, now) then return now end
  return check.fail("%s: the geometry of scene %q has changed since its links were made: make others "
    .. "(scene:links)", name,
    m.scene.name or "?")
end

return objects
