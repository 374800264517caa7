--- Input for LDoc, and docs/api.md: the same entries as pages.

local form = require "ylm.form"
local help = require "ylm.help"
local model = require "ylm.doc.model"
local reference = require "ylm.describe"

local pages = {}

-- LDoc -------------------------------------------------------------------------------

local function comment(put, text)
  model.each_line(text, function(line) put("-- " .. line) end)
end

local function usage(put, text)
  if not text then return end
  put "-- @usage"
  model.each_line(text, function(line) put("-- " .. line) end)
end

local function fields_list(put, title, fields)
  put("--")
  put("-- " .. title .. ":")
  put("--")
  for _, field in ipairs(fields) do
    put(model.one_line(("-- * `%s` %s. %s"):format(field[1], form.field_text(field), field.about or "")))
  end
end

local function ldoc_function(put, entry, name)
  put("--- " .. model.one_line(entry.about))
  if type(entry.options) == "table" and #entry.options > 0 then fields_list(put, "Options", entry.options) end
  if entry.errors and entry.errors ~= "" then put("--") put("-- Errors: " .. model.one_line(entry.errors) .. ".") end
  if entry.source then put("--") put("-- Source: " .. model.one_line(entry.source) .. ".") end
  put("-- @function " .. name)
  for _, argument in ipairs(entry.arguments or {}) do
    local word, optional = argument[1]:match("^(.-)(%??)$")
    put(model.one_line(("-- @%s %s %s (%s)"):format(optional == "?" and "param[opt]" or "param", word,
      argument[3] or "", argument[2])))
  end
  for _, result in ipairs(entry.returns or {}) do
    put(model.one_line(("-- @return %s: %s (%s)"):format(result[1], result[3] or "", result[2])))
  end
  usage(put, entry.example)
  put ""
end

local function file(title, about, kind, name, body)
  local lines = {}
  local function put(line) lines[#lines + 1] = (line:gsub("%s+$", "")) end
  put("--- " .. title)
  comment(put, about)
  put(("-- @%s %s"):format(kind, name))
  put ""
  body(put)
  return table.concat(lines, "\n") .. "\n"
end

--- File name -> text, for LDoc.
function pages.ldoc()
  local all, out = model.read(), {}
  for _, module in ipairs(all.modules) do
    local name = module.name == "" and "ylm" or "ylm." .. module.name
    out[name .. ".lua"] = file(module.name == "" and "Arrays, lights, grids, scenes, pictures." or
      "Functions of " .. name .. ".", "", "module", name, function(put)
      for _, entry in ipairs(module.entries) do ldoc_function(put, entry, entry.name:match("[%w_]+$")) end
    end)
  end
  for _, object in ipairs(all.objects) do
    out["object." .. object.name .. ".lua"] = file(("Methods of %s objects."):format(object.name), object.about,
      "classmod", object.name, function(put)
        for _, field in ipairs(object.fields) do
          put(model.one_line(("--- %s (%s)"):format(field[3] or "", field[2])))
          put("-- @field " .. field[1])
          put ""
        end
        for _, entry in ipairs(object.entries) do ldoc_function(put, entry, entry.name:match("[%w_]+$")) end
      end)
  end
  out["forms.lua"] = file("Constructors that take one named table: `ylm.NAME { ... }`, globals in scene files.", "",
    "module", "forms", function(put)
      for _, definition in ipairs(all.forms) do
        put("--- " .. model.one_line(definition.about))
        fields_list(put, "Fields", definition.fields)
        put("-- @function " .. definition.name)
        put("-- @param fields the table of fields")
        usage(put, definition.example)
        put ""
      end
    end)
  return out
end

-- Markdown ---------------------------------------------------------------------------

--- A cell of a table: bars and line ends would end it.
local function cell(text)
  return (model.one_line(text or ""):gsub("|", "\\|"):gsub("<", "&lt;"))
end

--- Prose, by lines of 120 letters at most.
local function prose(put, text)
  local line = ""
  for word in text:gmatch "%S+" do
    if #line + #word >= 120 then
      put(line)
      line = word
    else line = line == "" and word or line .. " " .. word end
  end
  put(line)
end

--- Fields or options of `owner`, a table for each shelf.
local function field_table(put, fields, owner)
  for _, part in ipairs(reference.by_shelf(fields, owner)) do
    put(("| field%s | is | |"):format(reference.shelf_note(part[1], owner, ", ")))
    put "| --- | --- | --- |"
    for _, row in ipairs(help.field_rows(part[2])) do
      put(("| `%s` | %s | %s |"):format(row[1], cell(row[2]), cell(row[3])))
    end
    put ""
  end
end

local function row_table(put, title, rows)
  if not rows or #rows == 0 then return end
  put(("| %s | is | |"):format(title))
  put "| --- | --- | --- |"
  for _, row in ipairs(rows) do put(("| `%s` | %s | %s |"):format(row[1], cell(row[2]), cell(row[3]))) end
  put ""
end

local function example(put, text)
  if not text then return end
  put "```lua"
  model.each_line(text, put)
  put "```"
  put ""
end

local function section(put, entry)
  put("### " .. help.signature(entry.name, entry))
  put ""
  prose(put, (model.one_line(entry.about):gsub("<", "&lt;")))
  put ""
  row_table(put, "argument", entry.arguments)
  if type(entry.options) == "table" and #entry.options > 0 then field_table(put, entry.options, entry) end
  row_table(put, "returns", entry.returns)
  if entry.report then row_table(put, "report", help.report_rows(entry.report)) end
  if entry.errors and entry.errors ~= "" then
    prose(put, "Errors: " .. model.one_line(entry.errors) .. ".")
    put ""
  end
  if entry.source then
    prose(put, "Source: " .. model.one_line(entry.source) .. ".")
    put ""
  end
  example(put, entry.example)
end

local function form_section(put, definition)
  put("### " .. (definition.name == "scene" and 'scene "name" { ... }' or definition.name .. " { ... }"))
  put ""
  prose(put, model.one_line(definition.about))
  put ""
  field_table(put, definition.fields, definition)
  example(put, definition.example)
end

--- An object and its methods of a shelf; what it is, and its fields, where it is named first.
local function object_section(put, object, entries, said)
  put("### " .. object.name)
  put ""
  if not said[object] then
    if object.about ~= "" then
      prose(put, model.one_line(object.about))
      put ""
    end
    row_table(put, "field", object.fields)
  end
  said[object] = true
  for _, entry in ipairs(entries) do section(put, entry) end
end

--- All of one shelf: forms, functions, objects.
local function shelf_of(put, all, shelf, said)
  put("## " .. reference.shelf_titles[shelf])
  put ""
  for _, definition in ipairs(model.on_shelf(all.forms, shelf)) do form_section(put, definition) end
  for _, module in ipairs(all.modules) do
    for _, entry in ipairs(model.on_shelf(module.entries, shelf)) do section(put, entry) end
  end
  for _, object in ipairs(all.objects) do
    local entries = model.on_shelf(object.entries, shelf)
    local bare = #object.entries == 0 and shelf == "experiments"
    if #entries > 0 or bare then object_section(put, object, entries, said) end
  end
end

--- docs/api.md, as text.
function pages.markdown()
  local all, lines = model.read(), {}
  local function put(line) lines[#lines + 1] = (line:gsub("%s+$", "")) end
  put "# Reference"
  put ""
  put "<!-- GENERATED by lua/ylm/doc/pages.lua from the entries beside the code: make docs -->"
  put ""
  put "`ylm help WORD` prints this text too. Conventions (axes, units, indices) are in docs/conventions.md."
  put ""
  put "Entries stand on three shelves: [everyday](#everyday) has what every user needs, [experiments](#experiments) what"
  put "experiments need, and [comparison](#comparison) what exists to compare with. Forms are constructors that take one named"
  put "table: `ylm.NAME { ... }` in scripts, globals in scene files."
  put ""
  local said = {}
  for _, shelf in ipairs(reference.shelves) do shelf_of(put, all, shelf, said) end
  while lines[#lines] == "" do lines[#lines] = nil end
  return table.concat(lines, "\n") .. "\n"
end

return pages
