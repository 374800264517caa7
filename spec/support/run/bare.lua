--- busted for a Lua that has no packages (spec/luas): Lua files from another Lua's path, YLM_BUSTED, stand-ins for the three
-- C modules, and loops that Lua 5.5 compiles.

package.path = package.path .. ";" .. (os.getenv "YLM_BUSTED" or "")

--- "file", "directory" or nil.
local function mode(path)
  local file = io.open(path)
  if not file then return nil, path .. ": not there" end
  local _, _, code = file:read(0)
  file:close()
  return code == 21 and "directory" or "file" -- EISDIR
end

local function attributes(path, what)
  local is, message = mode(path)
  if not is then return nil, message end
  return what and ({ mode = is })[what] or { mode = is }
end

package.preload.lfs = function()
  return {
    attributes = attributes, symlinkattributes = attributes,
    currentdir = function() return os.getenv "PWD" end,
    chdir = function() return true end, -- spec/run stays where it is
    dir = function(path) error(path .. ": folders are not listed", 2) end,
  }
end
package.preload.term = function() return { isatty = function() return false end } end
package.preload.system = function() return { gettime = os.time, monotime = os.clock, sleep = function() end } end

-- Lua 5.5 refuses to assign to a loop's variable, as penlight does: each loop gets a variable of that name of its own.
if _VERSION == "Lua 5.5" then
  local function compiled(text, name)
    for _ = 1, 20 do
      local chunk, message = load(text, name)
      if chunk then return chunk end
      local variable = message:match "const variable '([%w_]+)'"
      if not variable then return nil, message end
      local function shadow(head, names)
        for one in names:gmatch "[%w_]+" do
          if one == variable then return ("%s local %s = %s"):format(head, variable, variable) end
        end
      end
      for _, by in ipairs { "%s+in%f[^%w_]", "%s*=" } do
        text = text:gsub("(%f[%w_]for%s+([%w_%s,]-)" .. by .. "[^\n]-%f[%w_]do%f[^%w_])", shadow)
      end
    end
    return nil, name .. ": loops remain"
  end
  local search = package.searchers[2]
  package.searchers[2] = function(module)
    local path, message = package.searchpath(module, package.path)
    if not path then return message end
    if loadfile(path) then return search(module) end
    local file = assert(io.open(path))
    local text = file:read "a"
    file:close()
    return assert(compiled(text, "@" .. path)), path
  end
end
