--- Functions of at most 70 lines, from the first of the declaration to the closing brace or `end`; generated files aside.

local tree = require "spec.check.tree"

local functions = {}

local MOST = 70

local function complain(wrong, path, first, last, name)
  if last - first + 1 > MOST then
    wrong[#wrong + 1] = ("%s:%d: %s has %d lines; at most %d"):format(path, first, name, last - first + 1, MOST)
  end
end

--- The long functions of a C file. A definition begins in the first column and ends at the next brace there, as clang-format
-- has it.
function functions.c(path, text, wrong)
  local n, first, statement, inside, continued = 0, nil, "", nil, false
  for line in (tree.without_comments(text) .. "\n"):gmatch "([^\n]*)\n" do
    n = n + 1
    local directive = continued or line:find "^%s*#"
    continued = directive and line:find "\\$" ~= nil
    if inside then
      if line:find "^}" then
        if inside ~= "class" then complain(wrong, path, first, n, inside) end
        inside, statement = nil, ""
      end
    elseif directive or not line:find "%S" or line:find "^}" then statement = ""
    else
      if statement == "" then first = n end
      statement = statement .. line .. " "
      local name = statement:match "^[^=]-([%w_:~]+)%s*%([^=]*{%s*$"
      if name then inside = name
      elseif statement:find "^class[^(]*{%s*$" or statement:find "^struct[^(]*{%s*$" then inside = "class"
      elseif line:find "[;{}]%s*$" then statement = "" end
    end
  end
end

--- The long functions of a Lua file. One ends at the next line of its indentation that begins with `end`. A group of specs,
-- describe(.., function() .. end), is none.
function functions.lua(path, text, wrong)
  local n, open = 0, {}
  for line in (text .. "\n"):gmatch "([^\n]*)\n" do
    n = n + 1
    local margin = line:match "^(%s*)end%f[^%w_]"
    if margin and open[margin] then
      complain(wrong, path, open[margin].first, n, open[margin].name)
      open[margin] = nil
    elseif line:find("function", 1, true) and not line:find "describe[%s(]" then
      local name = line:gsub("%-%-.*", ""):match "%f[%w_]function%s*([%w_.:]*)%s*%([^()]*%)?%s*$"
      if name then open[line:match "^%s*"] = { first = n, name = name ~= "" and name or "a function" } end
    end
  end
end

--- Functions of a tree that are too long.
function functions.check(root)
  local wrong = {}
  for _, path in ipairs(tree.files(root, "csrc spec examples", "*.[ch]", "*.cpp")) do
    if not path:find "/gen/" then functions.c(path, tree.text(root, path), wrong) end
  end
  for _, path in ipairs(tree.files(root, "lua spec examples", "*.lua")) do
    if not path:find "/gen/" then functions.lua(path, tree.text(root, path), wrong) end
  end
  return wrong
end

return functions
