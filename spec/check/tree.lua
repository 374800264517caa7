--- Files of a tree and their texts, for the checks beside this file. A check is a function(root) -> a list of complaints,
-- "path:line: sentence", with paths below the root.

local tree = {}

local function quote(s) return "'" .. s:gsub("'", "'\\''") .. "'" end

--- The files below folders of a tree that a name of find's matches, sorted; none of a folder that is not there.
function tree.files(root, folders, ...)
  local names = {}
  for i, name in ipairs { ... } do names[i] = "-name " .. quote(name) end
  local list = {}
  local pipe = assert(io.popen(("cd %s && find %s -type f \\( %s \\) 2>/dev/null | LC_ALL=C sort"):format(quote(root), folders,
    table.concat(names, " -o "))))
  for path in pipe:lines() do list[#list + 1] = path end
  pipe:close()
  return list
end

--- The C files of a tree.
function tree.sources(root) return tree.files(root, "csrc", "*.[ch]", "*.cpp", "*.cc", "*.hpp", "*.inc") end

--- The bytes of a file of a tree.
function tree.text(root, path)
  local file = assert(io.open(root .. "/" .. path, "rb"))
  local text = file:read "*a"
  file:close()
  return text
end

function tree.exists(root, path)
  local file = io.open(root .. "/" .. path)
  if file then file:close() end
  return file ~= nil
end

--- The text of a C file with a blank for each comment, lines kept.
function tree.without_comments(text)
  text = text:gsub("/%*.-%*/", function(comment) return " " .. comment:gsub("[^\n]", "") end)
  return (text:gsub("//[^\n]*", ""))
end

return tree
