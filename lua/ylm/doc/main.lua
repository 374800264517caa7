--- Writes the documentation that is generated from the entries beside the code.
--
--     ylm run lua/ylm/doc/main.lua FOLDER         FOLDER/ylm.meta.lua for editors, FOLDER/api.md
--     ylm run lua/ylm/doc/main.lua FOLDER --api   FOLDER/api.md

local core = require "ylm.c.core"
local meta = require "ylm.doc.meta"
local pages = require "ylm.doc.pages"

local function write(path, text) assert(core.file_save(path, text)) end

local folder, mode = ...
if not folder then
  io.stderr:write "main.lua: a folder to write to expected\n"
  os.exit(2)
end
if mode == "--api" then
  write(folder .. "/api.md", pages.markdown())
else
  write(folder .. "/ylm.meta.lua", meta.text())
  write(folder .. "/api.md", pages.markdown())
end
