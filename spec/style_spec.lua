-- The tree's own style, and that what is generated is what the generators make.

local loops = require "spec.support.loops"
local scratch = require "spec.support.scratch"

describe("the tree", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  it("passes luacheck", function()
    local path = scratch.capture "command -v luacheck":match "^%S+"
    if not path then pending "luacheck is not installed" end
    -- LuaJIT's interpreter takes less than half the time, where luacheck is a script of Lua.
    local fast = scratch.text(path):find "^#![^\n]*lua" and scratch.shell "command -v luajit >/dev/null"
    local out, code = scratch.capture((fast and "luajit -joff " or "") .. path .. " --no-color -q examples lua rockspec spec")
    assert(code == 0, out)
  end)

  it("holds the kernels that the generator makes (make gen)", function()
    local out, code = scratch.capture "env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s --no-print-directory gen-check"
    assert(code == 0, out)
  end)

  local function lua_files() return scratch.lines "find lua spec examples rockspec -name '*.lua' -o -name '*.rockspec'" end

  it("assigns to no control variable of a loop, which Lua 5.5 refuses", function()
    if _VERSION ~= "Lua 5.4" then pending "Lua 5.4 has constants" end
    assert(load(loops.constant "for i = 1, 3 do local x = 'for' i = x end") == nil)
    assert(load(loops.constant "for i, k in f(function() for j = 1, 2 do end end) do k = i; local i = 3; i = k end"))
    for _, path in ipairs(lua_files()) do
      local file = assert(io.open(path))
      local ok, message = load(loops.constant(file:read "a"), "@" .. path)
      file:close()
      assert(ok, message)
    end
  end)

  it("keeps state of an object in core.own, and in no weak table", function()
    local wrong = {}
    for _, path in ipairs(scratch.lines "find lua/ylm -name '*.lua'") do
      local n = 0
      for line in io.lines(path) do
        n = n + 1
        if line:find "__mode" then wrong[#wrong + 1] = path .. ":" .. n end
      end
    end
    assert.equal("", table.concat(wrong, "\n"))
  end)

  -- Functions of a C file that begin in column 1: calls f(line number, lines), signature and body.
  local function each_function(path, f)
    local n, first, opened = 0, nil, false
    for line in io.lines(path) do
      n = n + 1
      if line:find "^[%w_][^;=]*%(" and not line:find "^typedef" then first = first or n end
      opened = opened or first and line:find "{$" ~= nil
      if line:find "^}" or not opened and (line == "" or line:find ";$") then
        if line == "}" and first then f(first, n - first + 1) end
        first, opened = nil, false
      end
    end
  end

  it("has functions in C of at most 70 lines", function()
    local wrong, count = {}, 0
    for _, path in ipairs(scratch.lines "find csrc -name gen -prune -o \\( -name '*.[ch]' -o -name '*.cpp' \\) -print") do
      each_function(path, function(n, lines)
        count = count + 1
        if lines > 70 then wrong[#wrong + 1] = ("%s:%d: %d lines"):format(path, n, lines) end
      end)
    end
    assert(count > 4000, count)
    assert.equal("", table.concat(wrong, "\n"))
  end)

  it("compiles under Lua 5.5", function()
    if not scratch.shell "command -v lua5.5 >/dev/null" then pending "lua5.5 is not installed" end
    local list = folder:write("list.lua", "return { [[" .. table.concat(lua_files(), "]], [[") .. "]] }")
    local program = ("for _, f in ipairs(dofile %q) do assert(loadfile(f)) end"):format(list)
    local out, code = scratch.capture("lua5.5 -e " .. scratch.quote(program))
    assert(code == 0, out)
  end)

  it("has the specs that spec/once.lua names", function()
    for _, names in pairs(dofile "spec/once.lua") do
      for name in names:gmatch "%S+" do assert(io.open("spec/" .. name .. "_spec.lua"), name):close() end
    end
  end)

  -- The lines of a C file that a reflow of comments has torn: the end of a comment of one line, alone
  -- on the next; a word or two of a paragraph, before a line that they would fit into.
  local function torn(lines)
    local found, opened = {}, nil
    for n, line in ipairs(lines) do
      if line:find "/%*" then opened = n end
      local text, following = line:match "^%*%* (%S.*)$", (lines[n + 1] or ""):match "^%*%* ([%l(]%S*)"
      if line:find "^%s*%*/$" and not lines[opened]:find "^%s*/%*%*?$"
         or text and following and #text + #following < 60 and text:find "[%w,]$" and not text:find "  " then
        found[#found + 1] = n
      end
    end
    return found
  end

  it("has C sources without tabs, blanks at line ends, and comments whose lines were broken by a reflow", function()
    local wrong = {}
    local pipe = assert(io.popen "find csrc spec -name gen -prune -o \\( -name '*.[ch]' -o -name '*.cpp' \\) -print")
    for path in pipe:lines() do
      local lines = {}
      for line in io.lines(path) do
        lines[#lines + 1] = line
        if line:find "\t" or line:find "%s$" or line:find "^%*[^ /*]" then wrong[#wrong + 1] = path .. ":" .. #lines end
      end
      for _, n in ipairs(torn(lines)) do wrong[#wrong + 1] = path .. ":" .. n end
    end
    pipe:close()
    assert.equal("", table.concat(wrong, "\n"))
  end)

  -- Comments of a source with blanks for all else, lines kept; the text of a page without its code.
  local comments = {
    c = function(text)
      local out, at = {}, 1
      while true do
        local first = text:find("/[/*]", at)
        if not first then break end
        local last
        if text:sub(first, first + 1) == "/*" then
          last = select(2, text:find("*/", first, true)) or #text
        else
          last = (text:find("\n", first, true) or #text + 1) - 1
        end
        out[#out + 1] = text:sub(at, first - 1):gsub("[^\n]", "") .. text:sub(first, last)
        at = last + 1
      end
      return table.concat(out)
    end,
    lua = function(text)
      return (text:gsub("[^\n]*", function(line) return line:match "%-%-+%s.*$" or "" end))
    end,
    md = function(text)
      return (text:gsub("```.-```", function(code) return code:gsub("[^\n]", "") end))
    end,
  }

  -- The lines of prose on which a sentence opens with a word that hides its subject; titles of pages are none.
  local function hidden(prose)
    local found, n, ended = {}, 0, true
    for line in (prose .. "\n"):gmatch "([^\n]*)\n" do
      n = n + 1
      local text = line:gsub("^[%s/*>|-]+", "")
      if line:find "^%s*/%*" then ended = true end
      for _, word in ipairs { "What", "Those", "The same", "So many", "Whoever" } do
        if ended and text:find("^" .. word .. "[ ,]") or text:find("[.!?]%**%s+" .. word .. "[ ,]") then
          found[#found + 1] = n
        end
      end
      ended = text == "" or text:find "[.!?:|]%s*%*?/?%s*$" ~= nil
    end
    return found
  end

  it("opens no sentence of a comment or a page with What, Those, So many or The same", function()
    local wrong = {}
    local pipe = assert(io.popen "git ls-files '*.c' '*.h' '*.cpp' '*.comp' '*.glsl' '*.lua' '*.md'")
    for path in pipe:lines() do
      local kind = path:match "%.(%w+)$"
      local generated = path:find "/gen/"
      local file = not generated and path ~= "CHANGELOG.md" and io.open(path)
      if file then
        for _, n in ipairs(hidden((comments[kind] or comments.c)(file:read "*a"))) do wrong[#wrong + 1] = path .. ":" .. n end
        file:close()
      end
    end
    pipe:close()
    assert.equal("", table.concat(wrong, "\n"))
  end)

  it("has lines of documentation within 160 columns, tables aside", function()
    local wrong = {}
    for _, path in ipairs(scratch.lines "ls README.md csrc/README.md docs/*.md") do
      local n = 0
      for line in io.lines(path) do
        n = n + 1
        local _, columns = line:gsub("[^\128-\191]", "")
        if columns > 160 and not line:find "^|" then wrong[#wrong + 1] = path .. ":" .. n end
      end
    end
    assert.equal("", table.concat(wrong, "\n"))
  end)
end)
