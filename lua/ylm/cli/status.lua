--- Exit statuses of the command-line tool, and how a command ends with one.

local check = require "ylm.check"
local core = require "ylm.c.core"

--- Errors of status.stop are known by their metatable: an experiment may raise tables of its own.
local ending = {}

local status = {
  good = 0,
  failed = 1,    -- a file, a driver, memory
  usage = 2,     -- the command line
  script = 3,    -- a scene file or an experiment is wrong
  beyond = 4,    -- compare: a bound was not kept
  limit = 5,     -- a scene file passed a limit
  unmet = 6,     -- --strict: a result does not keep what it promises
  unfinished = 75, -- bake: the time is over, a call again goes on (EX_TEMPFAIL)
  cancelled = 130,
  own_least = 7, own_most = 125, -- of experiments; shells give the rest meanings
  text = "0 good, 1 a file, driver or memory failed, 2 wrong usage, 3 a scene or experiment is wrong,\n"
    .. "             4 a bound of compare was not kept, 5 a scene passed a limit,\n"
    .. "             6 a warning was given and --strict asked for, 7 to 125 an experiment's own,\n"
    .. "             75 a bake's time is over: start it again, 130 interrupted",
}

local of_code = { EFORMAT = status.script, ELIMIT = status.limit, ECANCELLED = status.cancelled }

--- Ends the command with a message and a status.
function status.stop(code, message, ...)
  if select("#", ...) > 0 then message = message:format(...) end
  error(setmetatable({ status = code, message = message }, ending), 0)
end

--- Is it the name of a file of light on surfaces?
function status.is_surfaces(path) return path ~= nil and path:lower():find "%.surfaces$" ~= nil end

--- The number of bytes that the option of a command says, such as 32kB; nil: it was not given.
function status.bytes(name, text)
  if text == nil then return nil end
  local size, wanted = require "ylm.form".types.memory(tonumber(text) or text)
  if not size then status.stop(status.usage, "%s: --bytes is %s, got '%s'", name, wanted, text) end
  return size
end

--- { tolerance, bytes } that options of a command ask few bytes by; nil: they do not.
function status.few_bytes(name, given)
  if not given.tolerance and not given.bytes then return nil end
  if given.tolerance and given.bytes then
    status.stop(status.usage, "%s: --tolerance or --bytes: each chooses the rounding", name)
  end
  return { tolerance = given.tolerance, bytes = status.bytes(name, given.bytes) }
end

--- The number of bounces, or "all", that the option of a command says; nil: it was not given.
function status.bounces(name, text)
  if text == nil or text == "all" then return text end
  local n = tonumber(text)
  if not n or n < 0 or n ~= math.floor(n) or n >= 2 ^ 30 then
    status.stop(status.usage, "%s: --bounces is a number from 0 on, or all, got '%s'", name, text)
  end
  return n
end

--- The option dering of a width that a command was given: 0 is none; nil: it was not given.
function status.dering(name, width)
  if width == nil then return nil end
  if width == 0 then return false end
  if width > 0 and width < math.huge then return width end
  return status.stop(status.usage, "%s: --dering is a width in degrees, or 0 for no window, got %g", name, width)
end

--- The address of an image viewer that the option of a command gives; nil: it was not given.
function status.display(name, text)
  if text == nil then return nil end
  local display = require "ylm.display"
  if not display.is_address(text) then
    status.stop(status.usage, "%s: --display is %s, got '%s'", name, display.WANTED:gsub("'", ""), text)
  end
  return text
end

--- Ends the command unless `path` ends in one of the extensions and can be written: before the work, not after it.
function status.need_output(name, path, ...)
  local words, fits = {}, false
  for _, extension in ipairs { ... } do
    fits = fits or path:lower():sub(-#extension - 1) == "." .. extension
    words[#words + 1] = "." .. extension
  end
  if not fits then
    status.stop(status.usage, "%s: %s: the name must end in %s", name, path, table.concat(words, ", "))
  end
  status.need(core.file_probe(path))
end

--- Does this message come of a SIGINT? A scene file's reader passes it on like any error.
local function is_interrupt(message)
  return core.process_interrupted() and tostring(message):find("interrupted!", 1, true) ~= nil
end

--- The status of a command that ended with `warnings`: unmet where there are any and --strict was given.
function status.of_warnings(given, warnings)
  return given.strict and #warnings > 0 and status.unmet or status.good
end

--- Passes results on; nil, message, code ends the command.
function status.need(first, message, code, ...)
  if first == nil or first == false then
    if is_interrupt(message) then status.stop(status.cancelled, "interrupted") end
    status.stop(status.failed, tostring(message))
  end
  return first, message, code, ...
end

--- status.need for the object in a file, which must be of a kind ("ylm.grid") that `words` name ("a grid").
function status.need_kind(kind, words, path, first, message, code)
  if first == nil and code == "EFORMAT" and require "ylm.file".kind_of(path) == "surface_grid" then
    status.stop(status.failed, "%s: light on surfaces, and not %s%s", path, words,
      kind == "ylm.grid" and ", which ylm bake SCENE.lua -o NAME.ylm makes" or "")
  end
  status.need(first, message, code)
  local found = require "ylm.form".kind(first)
  if kind == "scene" and found == "ylm.mesh" then
    status.stop(status.failed, "%s: a mesh, not a scene; a scene file names it: return scene \"room\" { camera = camera { from = "
      .. "{ x, y, z }, at = { x, y, z } }, geometry = mesh { file = %q }, lights = environment_light { radiance = 1 } }",
      path, path)
  end
  if found ~= kind then status.stop(status.failed, "%s: not %s", path, words) end
  return first
end

--- The object in a file, by ylm.load; a mistake in a scene has a status of its own.
function status.load(path)
  local x, message, code = require "ylm".load(path)
  local describes = path:lower():find "%.lua$" or require "ylm.gltf".is_name(path)
  if x == nil and of_code[code] and describes and not is_interrupt(message) then
    status.stop(of_code[code], tostring(message))
  end
  return status.need(x, message, code)
end

--- The scene in a file; another file ends the command.
function status.load_scene(path) return status.need_kind("scene", "a scene", path, status.load(path)) end

--- The text of any error that was raised, with its traceback where YLM_DEBUG is set.
local function words_of(raised)
  local text = raised
  if type(raised) ~= "string" then
    local meta = getmetatable(raised)
    local speaks = type(raised) == "number" or type(meta) == "table" and meta.__tostring
    local good, own = pcall(tostring, raised)
    text = speaks and good and own or ("%san error was raised that is no message but %s"):format(check.position(),
      check.describe(raised))
  end
  return os.getenv "YLM_DEBUG" and debug.traceback(text, 4) or text
end

--- A function's refusal as a mistake on the command line: with the option that set the value, where one has its name.
local function as_option(text, name, command)
  local field, said = text:match "^bad argument #%d+ to '[%w_.:]+' %(([%w_]+)( .*)%)$"
  local word = field and field:gsub("_", "-")
  for _, option in ipairs(command.options or {}) do
    if option[1] == word then return ("%s: --%s%s"):format(name, word, said) end
  end
  return text
end

--- An error that was raised while `command` ran, which is called `name`, as what status.stop raises.
function status.raised(raised, name, command)
  if getmetatable(raised) == ending then return raised end
  local text = words_of(raised)
  local code = status.script
  if is_interrupt(text) then
    code, text = status.cancelled, "interrupted"
  elseif text == "not enough memory" then code = status.failed
  elseif name ~= "run" and text:find "^bad argument #" then
    -- scene files are done when options are looked at: what is bad then was on the command line
    code, text = status.usage, as_option(text, name, command)
  end
  return setmetatable({ status = code, message = text }, ending)
end

return status
