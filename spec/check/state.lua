--- State belongs to its object: a weak table stands in no file but the one that gives objects their tables.

local tree = require "spec.check.tree"

local state = {}

local OWN = { ["csrc/lua/binding_own.c"] = true, ["csrc/lua/core/own.c"] = true } -- core.own; no other table is weak

--- Places of a tree that make a weak table.
function state.check(root)
  local wrong = {}
  for _, path in ipairs(tree.files(root, "lua csrc/lua", "*.lua", "*.[ch]")) do
    local n, text = 0, not OWN[path] and tree.text(root, path) or ""
    for line in (text:find("__mode", 1, true) and text or ""):gmatch "([^\n]*)\n" do
      n = n + 1
      if line:gsub("%-%-.*", ""):find "__mode" then
        wrong[#wrong + 1] = ("%s:%d: a weak table: what belongs to an object stands in its own table"):format(path, n)
      end
    end
  end
  return wrong
end

return state
