--- The model that the generators of documentation share: the exported names, grouped, in a fixed order.

local form = require "ylm.form"
local help = require "ylm.help"
local reference = require "ylm.describe"

local model = {}

local rank = {}
for i, shelf in ipairs(reference.shelves) do rank[shelf] = i end

--- Everything, as lists sorted by name, entries and forms by shelf first:
-- modules { name, entries }, objects { name, about, fields, entries }, forms { definitions }.
function model.read()
  local public = help.public()
  local modules, objects, by_module, by_object = {}, {}, {}, {}
  for _, name in ipairs(public.functions) do
    local entry = reference.entries[name]
    if entry then
      local module = name:match("^(.-)%.[^.]*$") or ""
      if not by_module[module] then
        by_module[module] = { name = module, entries = {} }
        modules[#modules + 1] = by_module[module]
      end
      table.insert(by_module[module].entries, entry)
    end
  end
  local function object(name)
    if not by_object[name] then
      local known = reference.objects[name] or {}
      by_object[name] = { name = name, about = known.about or "", fields = known.fields or {}, entries = {} }
      objects[#objects + 1] = by_object[name]
    end
    return by_object[name]
  end
  for _, name in ipairs(public.methods) do
    local entry = reference.entries[name]
    if entry then table.insert(object(name:match("^[^:]+")).entries, entry) end
  end
  for name in pairs(reference.objects) do object(name) end
  local function by_name(a, b) return a.name < b.name end
  local function by_rank(a, b)
    local x, y = rank[reference.shelf(a)], rank[reference.shelf(b)]
    if x ~= y then return x < y end
    return a.name < b.name
  end
  for _, group in ipairs { modules, objects } do
    for _, of in ipairs(group) do table.sort(of.entries, by_rank) end
  end
  table.sort(modules, by_name)
  table.sort(objects, by_name)
  local forms = {}
  for _, name in ipairs(public.forms) do forms[#forms + 1] = form.defined[name] end
  table.sort(forms, by_rank)
  return { modules = modules, objects = objects, forms = forms }
end

--- Those of a list that stand on a shelf.
function model.on_shelf(list, shelf)
  local some = {}
  for _, x in ipairs(list) do if reference.shelf(x) == shelf then some[#some + 1] = x end end
  return some
end

--- Calls f(line) for each line of `text`.
function model.each_line(text, f)
  for line in (text:gsub("%s+$", "") .. "\n"):gmatch("(.-)\n") do f(line) end
end

--- The text on one line.
function model.one_line(text)
  return (text:gsub("%s+", " "):gsub("^ ", ""):gsub(" $", ""))
end

return model
