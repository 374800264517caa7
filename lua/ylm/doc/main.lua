--- Writes the documentation that is generated, or compares it with what stands there.
--
--     lua lua/ylm/doc/main.lua                  writes docs/ylm.meta.lua and docs/api.md
--     lua lua/ylm/doc/main.lua --check          exit status 1 where they differ
--     lua lua/ylm/doc/main.lua --ldoc FOLDER    also writes input for LDoc

local meta = require "ylm.doc.meta"
local pages = require "ylm.doc.pages"

local function read(path)
  local file = io.open(path, "rb")
  if not file then return nil end
  local text = file:read("*a")
  file:close()
  return text
end

local function write(path, text)
  if read(path) == text then return end
  local file = assert(io.open(path, "wb"))
  assert(file:write(text))
  assert(file:close())
  io.stderr:write(path, "\n")
end

local generated = { ["docs/ylm.meta.lua"] = meta.text, ["docs/api.md"] = pages.markdown }

local mode, folder = ...
local status = 0
for path, text in pairs(generated) do
  if mode ~= "--check" then write(path, text())
  elseif read(path) ~= text() then
    io.stderr:write(path, " is not what make docs writes\n")
    status = 1
  end
end
if mode == "--ldoc" then
  for name, text in pairs(pages.ldoc()) do write(folder .. "/" .. name, text) end
end
os.exit(status)
