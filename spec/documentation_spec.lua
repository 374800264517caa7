-- Everything that is exported is described once, and every example runs.

local form = require "ylm.form"
local help = require "ylm.help"
local reference = require "ylm.describe"
local ylm = help.load()
local public = help.public()

--- Runs an example with `ylm` and the constructors at hand.
local function run(name, text)
  local env = setmetatable({ ylm = ylm }, { __index = function(_, key)
    local definition = form.defined[key]
    if definition then return definition.construct end
    return _G[key]
  end })
  local chunk, message
  if setfenv then -- luacheck: ignore
    chunk, message = loadstring(text, "=example of " .. name) -- luacheck: ignore
    if chunk then setfenv(chunk, env) end -- luacheck: ignore
  else chunk, message = load(text, "=example of " .. name, "t", env) end
  assert(chunk, message)
  chunk()
end

--- A form's example may be one constructor call.
local function run_form(name, text)
  if pcall(function() assert((loadstring or load)(text)) end) then return run(name, text) end
  return run(name, "return " .. text)
end

local function unspoken(list, entries)
  local missing = {}
  for _, name in ipairs(list) do
    if not entries[name] and not form.defined[name] then missing[#missing + 1] = name end
  end
  return table.concat(missing, ", ")
end

describe("the reference", function()
  for _, kind in ipairs { "functions", "methods", "forms" } do
    it("describes all " .. kind, function()
      assert.equal("", unspoken(public[kind], reference.entries))
    end)
  end

  it("describes nothing that does not exist", function()
    local known = {}
    for _, list in pairs(public) do for _, name in ipairs(list) do known[name] = true end end
    for _, name in ipairs(reference.names) do assert(known[name], "described, but not exported: " .. name) end
  end)

  it("says what each is about, its arguments, results, errors, and shows it", function()
    for name, entry in pairs(reference.entries) do
      for _, key in ipairs { "about", "errors" } do
        assert(type(entry[key]) == "string" and entry[key] ~= "", name .. ": " .. key .. " is missing")
      end
      for _, list in ipairs { "arguments", "returns" } do
        assert(type(entry[list]) == "table", name .. ": " .. list .. " is missing")
        for _, row in ipairs(entry[list]) do
          assert(type(row[1]) == "string" and type(row[2]) == "string", name .. ": " .. list)
        end
      end
      assert(type(entry.example) == "string" and entry.example ~= "", name .. ": an example is missing")
    end
    for name, definition in pairs(form.defined) do
      assert(definition.about and definition.about ~= "", name .. ": about is missing")
      assert(definition.example, name .. ": an example is missing")
    end
  end)

  for _, name in ipairs(reference.names) do
    it("runs the example of " .. name, function() run(name, reference.entries[name].example) end)
  end
  for _, name in ipairs(form.names) do
    it("runs the example of the form " .. name, function() run_form(name, form.defined[name].example) end)
  end

  it("is what editors and pages are generated from, the same under every Lua", function()
    local scratch = require "spec.support.scratch"
    local meta = require "ylm.doc.meta".text()
    local pages = require "ylm.doc.pages"
    assert((loadstring or load)(meta, "=ylm.meta.lua"))
    assert.truthy(meta:find("\nfunction ylm.sh.eval(lmax, points, options) end\n", 1, true))
    assert.truthy(meta:find("\n---@param fields ylm.fields.sphere_light\n", 1, true))
    assert.truthy(pages.markdown():find("\n### sphere_light { ... }\n", 1, true))
    local all = pages.ldoc()
    assert(all["ylm.lua"] and all["ylm.sh.lua"] and all["forms.lua"] and all["object.array.lua"])
    for _, text in pairs(all) do assert((loadstring or load)(text)) end
    assert(scratch.text "docs/api.md" == pages.markdown(), "docs/api.md is not what the entries say: make api")
    local build = scratch.quote(os.getenv "YLM_BUILD" or "build")
    local other, abi = "luajit", "lua5.1"
    if os.getenv "YLM_LUA" == "luajit" then other, abi = "lua5.4", "lua5.4" end
    if not scratch.shell(("command -v %s >/dev/null && [ -e %s/%s/ylm/c/core.so ]"):format(other, build, abi)) then
      return pending(other .. " is not installed, or nothing is built for it")
    end
    local folder = scratch.new()
    local out, code = scratch.capture(("YLM_LUA=%s LUA_PATH= LUA_CPATH= %s/ylm run lua/ylm/doc/main.lua %s"):format(other, build,
      scratch.quote(folder.path)))
    assert.equal(0, code, out)
    assert.equal(meta, folder:read "ylm.meta.lua")
    assert.equal(pages.markdown(), folder:read "api.md")
    folder:remove()
  end)

  it("has at most 70 entries on its first shelf, each with at most 25 options there", function()
    local count, wide = 0, {}
    for _, name in ipairs(help.names()) do
      local entry = form.defined[name] or reference.entries[name]
      local rows = entry.options or entry.fields
      if reference.shelf(entry) == "everyday" then count = count + 1 end
      for _, part in ipairs(reference.by_shelf(type(rows) == "table" and rows or {}, entry)) do
        if part[1] == "everyday" and #part[2] > 25 then wide[#wide + 1] = name end
      end
    end
    assert.is_true(count > 40 and count <= 70, count)
    assert.same({}, wide)
  end)

  it("is what help prints", function()
    for _, name in ipairs(help.names()) do
      local text = assert(help.text(name))
      assert(text:find(name, 1, true))
      for line in text:gmatch("[^\n]+") do assert(not line:find("%s$"), name .. ": a blank ends " .. line) end
    end
    assert.truthy(help.text("zeros"):find("ylm.zeros(shape [, dtype])", 1, true))
    local _, message = help.text "zeroes"
    assert.equal("no help on 'zeroes' (did you mean 'zeros'?)", message)
    assert.truthy(help.overview():find("\n  zeros +Makes an array of zeros%.\n"), help.overview())
  end)
end)
