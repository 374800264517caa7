--- A choice has one list of names: Lua asks the binding for those that C reads, and types none again.

local tree = require "spec.check.tree"

local choices = {}

local FREE = "^lua/ylm/codegen/" -- the generator works before there is a binding

--- The names of a list in braces as one key, whatever their order; nil of one that holds anything but two names or more.
local function key_of(list, last)
  local names, rest = {}, list:gsub('"([^"\n]*)"', function(name) return "\1" .. name .. "\2" end)
  for name in rest:gmatch "\1(.-)\2" do names[#names + 1] = name end
  rest = rest:gsub("\1.-\2", ""):gsub("[%s,]", "")
  if #names < 2 or rest ~= last then return nil end
  table.sort(names)
  return table.concat(names, "|")
end

--- The names of an enumeration in braces, { a = 0, b = 1, .. }, as one key; nil of any other table.
local function keys_of(list)
  local names, numbers = {}, {}
  for name, number in list:gmatch "([%a_][%w_]*)%s*=%s*(%d+)" do
    names[#names + 1] = name
    numbers[tonumber(number)] = true
  end
  local rest = list:gsub("[%a_][%w_]*%s*=%s*%d+", ""):gsub("[%s,]", "")
  if #names < 2 or rest ~= "" then return nil end
  for i = 0, #names - 1 do if not (numbers[i] or numbers[i + 1]) then return nil end end
  table.sort(names)
  return table.concat(names, "|")
end

local function line_of(text, at) return select(2, text:sub(1, at):gsub("\n", "")) + 1 end

--- Key -> the place of a list of names in csrc/lua: X(name, "a", "b") of binding_choices.h, or an array that NULL ends.
local function lists_of(root)
  local lists = {}
  for _, path in ipairs(tree.files(root, "csrc/lua", "*.c", "*.h")) do
    local text = tree.without_comments(tree.text(root, path))
    for at, list in text:gmatch "()%[%]%s*=%s*{([^{}]*)}" do
      local key = key_of(list, "NULL")
      if key then lists[key] = ("%s:%d"):format(path, line_of(text, at)) end
    end
    for at, list in text:gsub("\\\n", " \n"):gmatch "()%f[%w]X%([%w_]+,([^()]*)%)" do
      local key = key_of(list, "")
      if key then lists[key] = ("%s:%d"):format(path, line_of(text, at)) end
    end
  end
  return lists
end

--- Lists of Lua that a list of the binding equals.
function choices.check(root)
  local wrong, lists = {}, lists_of(root)
  for _, path in ipairs(tree.files(root, "lua", "*.lua")) do
    local text = (path:find "/gen/" or path:find(FREE)) and "" or tree.text(root, path)
    for at, list in text:gmatch "()=%s*{([^{}]*)}" do
      local key = key_of(list, "") or keys_of(list)
      if key and lists[key] then
        wrong[#wrong + 1] = ("%s:%d: { %s } are typed in %s too"):format(path, line_of(text, at), key:gsub("|", ", "), lists[key])
      end
    end
  end
  return wrong
end

return choices
