--- Promises that a result does not keep, in one line each: an unmet tolerance, light that is not the scene's.
--
-- A line names what falls short, its cause and what to change. The line goes to stderr, or to the
-- function that ylm.on_warning was given; YLM_WARNINGS=no in the environment silences stderr.
-- Reports hold the same lines.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe

local warning = {}

--- Writes a line to stderr.
local function to_stderr(message)
  io.stderr:write("ylm: ", message, "\n")
end

local function to_nobody() end

local quiet = os.getenv "YLM_WARNINGS" == "no"

--- The action where the caller has chosen none.
local function standard(message)
  if not quiet then to_stderr(message) end
end

local listener = standard

local muted = false

--- Results of f(...), whose warnings are neither said nor counted as said: the caller says its own.
function warning.silently(f, ...)
  local before = muted
  muted = true
  local function finish(ok, ...)
    muted = before
    if not ok then error((...), 0) end
    return ...
  end
  return finish(pcall(f, ...))
end

--- Says `message` of `object`, once a topic; returns the message, for reports.
function warning.say(object, topic, message, ...)
  if select("#", ...) > 0 then message = message:format(...) end
  if muted then return message end
  local own = core.own(object)
  own.said = own.said or {} -- topics: a film of a thousand frames says a thing once
  if not own.said[topic] then
    own.said[topic] = true
    listener(message)
  end
  return message
end

describe "on_warning" {
  about = "Chooses where warnings go: one line for each promise that a result does not keep, with its cause and what to "
    .. "change. Each is said once of a scene or a grid; reports and grid.stats hold it too.",
  arguments = { { "listener?", "function|false", "called as f(message); false: nowhere; nil: to stderr, unless "
    .. "YLM_WARNINGS=no is set in the environment" } },
  returns = { { "before", "function|false|nil", "what was chosen before, for choosing it again" } },
  errors = "raises on anything else",
  example = [[
local said = {}
local before = ylm.on_warning(function(message) said[#said + 1] = message end)
ylm.on_warning(before)
assert(#said == 0)]],
}
function warning.on_warning(f)
  if f ~= nil and f ~= false and type(f) ~= "function" then
    return check.bad(1, "on_warning", "a function, false or nothing expected, got %s", check.describe(f))
  end
  local before = listener
  listener = f or (f == false and to_nobody) or standard
  if before == standard then return nil end
  return before ~= to_nobody and before
end

return warning
