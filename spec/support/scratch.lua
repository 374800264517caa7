--- A folder of a spec's own: local folder = scratch(); folder:write("a.lua", text); folder:remove().

local lacking = require "spec.support.run.lacking"

local scratch = {}
scratch.__index = scratch

local function quote(s) return "'" .. s:gsub("'", "'\\''") .. "'" end
scratch.quote = quote

--- Runs a shell command; true if it succeeds.
function scratch.shell(command)
  local ok = os.execute(command)
  return ok == true or ok == 0
end

--- The output of a shell command, and its exit status.
function scratch.capture(command)
  local pipe = assert(io.popen("{ " .. command .. "\n} 2>&1; s=$?; echo; echo $s"))
  local text = pipe:read("*a")
  pipe:close()
  local out, status = text:match("^(.*)\n(%d+)\n$")
  lacking.read(out)
  return out, tonumber(status)
end

--- The lines that a shell command prints, as a list.
function scratch.lines(command)
  local list, pipe = {}, assert(io.popen(command))
  for line in pipe:lines() do list[#list + 1] = line end
  pipe:close()
  return list
end

--- The bytes of a file.
function scratch.text(path)
  local file = assert(io.open(path, "rb"))
  local text = file:read "*a"
  file:close()
  return text
end

--- A new folder; below `home` where that can be written to, "/dev/shm" for files that are written through to the disk.
function scratch.new(home)
  local path = os.tmpname()
  os.remove(path)
  if home and scratch.shell("test -w " .. quote(home)) then path = home .. "/" .. path:match "[^/]*$" end
  assert(scratch.shell("mkdir -p " .. quote(path)))
  return setmetatable({ path = path }, scratch)
end

function scratch:write(name, text)
  local path = self.path .. "/" .. name
  local file = assert(io.open(path, "wb"))
  file:write(text)
  file:close()
  return path
end

function scratch:read(name)
  local file = io.open(self.path .. "/" .. name, "rb")
  if not file then return nil end
  local text = file:read("*a")
  file:close()
  return text
end

function scratch:remove() scratch.shell("rm -rf " .. quote(self.path)) end

return scratch
