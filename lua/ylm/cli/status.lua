--- Exit statuses of the command-line tool, and how a command ends with one.

local status = {
  good = 0,
  failed = 1,    -- a file, a driver, memory
  usage = 2,     -- the command line
  raised = nil,  -- see below
  script = 3,    -- a scene file or an experiment is wrong
  beyond = 4,    -- compare: a bound was not kept
  limit = 5,     -- a scene file passed a limit
  unmet = 6,     -- --strict: a result does not keep what it promises
  cancelled = 130,
  text = "0 good, 1 a file, driver or memory failed, 2 wrong usage, 3 a scene or experiment is wrong,\n"
    .. "             4 a bound of compare was not kept, 5 a scene passed a limit,\n"
    .. "             6 a warning was given and --strict asked for, 130 interrupted",
}

local of_code = { EFORMAT = status.script, ELIMIT = status.limit, ECANCELLED = status.cancelled }

--- Ends the command with a message and a status.
function status.stop(code, message, ...)
  if select("#", ...) > 0 then message = message:format(...) end
  error({ status = code, message = message }, 0)
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
  status.need(require "ylm.c.core".file_probe(path))
end

--- The status of a command that ended with `warnings`: unmet where there are any and --strict was given.
function status.of_warnings(given, warnings)
  return given.strict and #warnings > 0 and status.unmet or status.good
end

--- Passes results on; nil, message, code ends the command.
function status.need(first, message, code, ...)
  if first == nil or first == false then
    status.stop(status.failed, tostring(message))
  end
  return first, message, code, ...
end

--- The same for what a file holds, which must be of a kind ("ylm.grid") that `words` name ("a grid").
function status.need_kind(kind, words, path, first, message, code)
  status.need(first, message, code)
  if require "ylm.form".kind(first) ~= kind then status.stop(status.failed, "%s: not %s", path, words) end
  return first
end

--- The same for scene files, whose mistakes have a status of their own.
function status.need_scene(first, message, code)
  if first == nil then status.stop(of_code[code] or status.failed, tostring(message)) end
  return first
end

--- An error that was raised, as a table: with its traceback where YLM_DEBUG is set.
function status.raised(message)
  message = tostring(message)
  if message:find("interrupted!", 1, true) then return { status = status.cancelled, message = "interrupted" } end
  if os.getenv "YLM_DEBUG" then message = debug.traceback(message, 3) end
  -- scene files are done when options are looked at: what is bad then was on the command line
  return { status = message:find "^bad argument #" and status.usage or status.script, message = message }
end

return status
