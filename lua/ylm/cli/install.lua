--- Writes what `make install` installs beside the tool: the man page, and completions for shells.
--
--     ylm run lua/ylm/cli/install.lua FOLDER     FOLDER/ylm.1, ylm.bash, _ylm (zsh), ylm.fish

local completions = require "ylm.cli.completions"
local core = require "ylm.c.core"
local help = require "ylm.help"
local manual = require "ylm.cli.manual"

local folder = ...
if not folder then
  io.stderr:write "install.lua: a folder to write to expected\n"
  os.exit(2)
end
local texts = completions.texts(help.names())
assert(core.file_save(folder .. "/ylm.1", manual.text(require "ylm".info().version)))
assert(core.file_save(folder .. "/ylm.bash", texts.bash))
assert(core.file_save(folder .. "/_ylm", texts.zsh))
assert(core.file_save(folder .. "/ylm.fish", texts.fish))
