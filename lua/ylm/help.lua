--- The exports of ylm, in words: for `ylm help`, the generated documentation and the specs that walk it.

local check = require "ylm.check"
local form = require "ylm.form"
local progress = require "ylm.progress"
local reference = require "ylm.describe"

local help = {}

-- Names ---------------------------------------------------------------------------

local function sorted(set)
  local list = {}
  for name in pairs(set) do list[#list + 1] = name end
  table.sort(list)
  return list
end

local function add_functions(set, prefix, t)
  for name, value in pairs(t) do
    if type(name) == "string" and type(value) == "function" and not name:find("^_") then set[prefix .. name] = true end
  end
end

--- Loads every public module, so that all forms and entries are there.
function help.load()
  local ylm = require "ylm"
  require "ylm.live" -- a method of scenes
  for _, name in ipairs(ylm.names()) do
    local value = ylm[name]
    local parts = type(value) == "table" and getmetatable(value)
    if parts and parts.__names then for _, part in ipairs(parts.__names()) do local _ = value[part] end end
  end
  return ylm
end

--- Sorted names: functions ("array", "sh.eval"), methods ("grid:sample"), forms ("sphere_light").
function help.public()
  local ylm = help.load()
  local functions, methods = {}, {}
  for _, name in ipairs(ylm.names()) do
    local value = ylm[name]
    local is_table = type(value) == "table"
    if is_table then add_functions(functions, name .. ".", value) end
    if not is_table or reference.entries[name] then functions[name] = true end -- ylm.array is both
  end
  for name, value in pairs(ylm) do if type(value) == "function" then functions[name] = true end end
  for name, t in pairs(debug.getregistry()) do
    if type(name) == "string" and type(t) == "table" and rawget(t, "__name") == name then
      local kind = name:match("^ylm%.([%a_]+)$")
      if kind then add_functions(methods, kind .. ":", t) end
    end
  end
  for name, definition in pairs(form.defined) do
    local index = definition.metatable.__index
    if type(index) == "table" then add_functions(methods, name .. ":", index) end
  end
  for name, object in pairs(reference.objects) do
    if object.methods then add_functions(methods, name .. ":", object.methods) end
  end
  return { functions = sorted(functions), methods = sorted(methods), forms = sorted(form.defined) }
end

-- In words --------------------------------------------------------------------------

--- Appends `text` to `out`, wrapped at 100 columns, every line after `indent` blanks.
local function wrap(out, text, indent)
  local pad = (" "):rep(indent)
  for paragraph in (text .. "\n"):gmatch("(.-)\n") do
    local line = pad
    for word in paragraph:gmatch("%S+") do
      if #line + #word + 1 > 100 and line ~= pad then
        out[#out + 1], line = line, pad
      end
      line = line .. (line == pad and "" or " ") .. word
    end
    out[#out + 1] = (line:gsub("%s+$", ""))
  end
end

local function sentence(text)
  return text and text ~= "" and text or nil
end

local function rows(out, title, list)
  if #list == 0 then return end
  local width = 0
  for _, row in ipairs(list) do width = math.max(width, #row[1]) end
  out[#out + 1] = ""
  out[#out + 1] = title
  for _, row in ipairs(list) do
    out[#out + 1] = (("  %-" .. width .. "s  %s"):format(row[1], row[2]):gsub("%s+$", ""))
    if sentence(row[3]) then wrap(out, row[3], width + 6) end
  end
end

--- Rows { name, what it is, about } of fields; those of a field that is a table of its own follow it, as "virtual.lmax".
function help.field_rows(fields, owner)
  local list = {}
  for _, field in ipairs(fields) do
    list[#list + 1] = { (owner and owner .. "." or "") .. field[1], form.field_text(field), field.about or "" }
    for _, row in ipairs(field.fields and help.field_rows(field.fields, field[1]) or {}) do list[#list + 1] = row end
  end
  return list
end

--- Rows of the fields of a report, { name, unit, what it says }.
function help.report_rows(fields)
  local list = {}
  for i, field in ipairs(fields) do list[i] = { field[1], field[2] == "1" and "number" or field[2], field[3] } end
  return list
end

--- Rows of options or fields, by shelf; those of the owner's shelf have no other title.
local function shelves_of(out, title, fields, owner)
  for _, part in ipairs(reference.by_shelf(fields, owner)) do
    rows(out, title .. reference.shelf_note(part[1], owner, " "), help.field_rows(part[2]))
  end
end

local function value_rows(values)
  local list = {}
  for i, value in ipairs(values or {}) do list[i] = { value[1], value[2], value[3] } end
  return list
end

local function example(out, text)
  if not text then return end
  out[#out + 1] = ""
  out[#out + 1] = "example"
  for line in (text:gsub("\n$", "") .. "\n"):gmatch("(.-)\n") do out[#out + 1] = "  " .. line end
end

--- How a function is called: "ylm.sh.eval(lmax, points [, options])", "grid:sample(points)".
function help.signature(name, entry)
  local text = ""
  for i, argument in ipairs(entry.arguments or {}) do
    local word, optional = argument[1]:match("^(.-)(%??)$")
    if optional == "?" then text = text .. (i > 1 and " [, " or "[") .. word .. "]"
    else text = text .. (i > 1 and ", " or "") .. word end
  end
  return (name:find(":", 1, true) and "" or "ylm.") .. name .. "(" .. text .. ")"
end

local function entry_text(out, name, entry)
  out[#out + 1] = help.signature(name, entry)
  wrap(out, entry.about, 2)
  rows(out, "arguments", value_rows(entry.arguments))
  if type(entry.options) == "table" then shelves_of(out, "options", entry.options, entry) end
  rows(out, "returns", value_rows(entry.returns))
  if entry.report then rows(out, "report", help.report_rows(entry.report)) end
  if sentence(entry.errors) then
    out[#out + 1] = ""
    out[#out + 1] = "errors"
    wrap(out, entry.errors, 2)
  end
  example(out, entry.example)
  if entry.source then
    out[#out + 1] = ""
    out[#out + 1] = "source"
    wrap(out, entry.source, 2)
  end
end

local function form_text(out, name, definition)
  out[#out + 1] = name == "scene" and 'scene "name" { ... }' or name .. " { ... }"
  wrap(out, definition.about or "", 2)
  shelves_of(out, "fields", definition.fields, definition)
  example(out, definition.example)
end

--- Every name that help knows, sorted.
function help.names()
  help.load()
  local all = {}
  for name in pairs(form.defined) do all[name] = true end
  for name in pairs(reference.entries) do all[name] = true end
  return sorted(all)
end

--- The page on progress, with the names of its stages.
local function progress_text()
  local out = { "progress", "" }
  wrap(out, "The option of work that may be long: true draws a bar on stderr (lines in a log), false draws none, a function is "
    .. "called as f(done, total, stage) and cancels by returning false, { f, every = seconds } says how often. Where nothing is "
    .. "given, bakes, pictures, transfers and virtual lights draw a bar on a terminal once they take more than two seconds; "
    .. "YLM_PROGRESS=no in the environment leaves it out. Stages that take less than half a second share a line.", 2)
  rows(out, "stages", progress.stages)
  return table.concat(out, "\n")
end

--- The page on reports: fields by the calls that return them.
local function report_text()
  local out, by_fields, list = { "report", "" }, {}, {}
  wrap(out, "The table that calls return beside their result. Fields are there where they say something.", 2)
  help.load()
  for _, name in ipairs(reference.names) do
    local fields = reference.entries[name].report
    if fields then
      if not by_fields[fields] then
        by_fields[fields] = {}
        list[#list + 1] = fields
      end
      table.insert(by_fields[fields], name)
    end
  end
  for _, fields in ipairs(list) do rows(out, table.concat(by_fields[fields], ", "), help.report_rows(fields)) end
  return table.concat(out, "\n")
end

-- Words that are no name of the interface.
local topics = { progress = progress_text, report = report_text }

--- Help on a form, function or method; its last part will do ("eval"). nil, message if there is none.
function help.text(word)
  if topics[word] then return topics[word]() end
  help.load()
  word = word:gsub("^ylm%.", "")
  local names, found = help.names(), {}
  for _, name in ipairs(names) do
    if name == word then
      found = { name }
      break
    end
    if name:match("[%w_]+$") == word or name:match("^[%w_]+") == word then found[#found + 1] = name end
  end
  if #found == 0 then
    local guess = check.guess(word, names)
    return nil, ("no help on %s%s"):format(check.describe(word), guess and (" (did you mean '%s'?)"):format(guess) or "")
  end
  local out = {}
  for _, name in ipairs(found) do
    if #out > 0 then
      out[#out + 1] = ""
      out[#out + 1] = ("-"):rep(72)
    end
    if form.defined[name] then form_text(out, name, form.defined[name])
    elseif reference.entries[name] then entry_text(out, name, reference.entries[name]) end
  end
  return table.concat(out, "\n")
end

--- The first sentence of a name's text.
local function first_sentence(name)
  local entry = form.defined[name] or reference.entries[name]
  local about = entry and entry.about or ""
  return about:match("^(.-%.)%s") or about
end

--- Names that hold `word` and names whose text alone does, upper and lower case alike: two lists of
-- { name, first sentence }.
function help.find(word)
  local in_names, in_texts = {}, {}
  word = word:lower()
  for _, name in ipairs(help.names()) do
    local row = { name, first_sentence(name) }
    if name:lower():find(word, 1, true) then in_names[#in_names + 1] = row
    elseif help.text(name):lower():find(word, 1, true) then in_texts[#in_texts + 1] = row end
  end
  return in_names, in_texts
end

--- The lists of help.find as text, or nil where nothing speaks of `word`; `more` are such rows of other texts.
function help.matches(word, more)
  local in_names, in_texts = help.find(word)
  for _, row in ipairs(more) do table.insert(in_texts, 1, row) end
  if #in_names + #in_texts == 0 then return nil end
  local out = { ("%s has no page of its own; ylm help NAME shows one of these."):format(check.describe(word)) }
  rows(out, "names that hold it", in_names)
  rows(out, "pages that speak of it", in_texts)
  return table.concat(out, "\n")
end

--- The list of all names with the first sentence of each, by shelf.
function help.overview()
  local out = {}
  for _, shelf in ipairs(reference.shelves) do
    local list = { { "forms", {} }, { "functions", {} }, { "methods", {} } }
    for _, name in ipairs(help.names()) do
      local place = form.defined[name] and 1 or name:find(":", 1, true) and 3 or 2
      if reference.shelf(form.defined[name] or reference.entries[name]) == shelf then
        table.insert(list[place][2], { name, first_sentence(name) })
      end
    end
    for _, part in ipairs(list) do rows(out, shelf .. ": " .. part[1], part[2]) end
  end
  table.remove(out, 1)
  return table.concat(out, "\n")
end

return help
