--- busted's output handler for spec/run: what failed, in words on stdout; each `it` as a line of the file YLM_SPEC_REPORT.
--
-- A line is "passed", "failed" or "skipped", seconds of processor time (children included) and the name, between tabs.
-- A failure is "skipped" after its `it`, or the file outside of any, has asked for a part of ylm that is not built, and where its
-- message is that of a build without jansson; "lacking" names that.
-- A line "other" has the seconds of all else: of the file itself, setup and teardown.
-- The line "done" ends the report of a run that came to its end: a crash, a signal or os.exit leaves it out.

local busted = require "busted"
local lacking = require "spec.support.run.lacking"
local path = os.getenv "YLM_SPEC_REPORT" or "/dev/null"
local ticks = 100 -- per second, in /proc/*/stat

--- Seconds of processor time of this process and of children that it has waited for.
local function clock()
  local file = io.open "/proc/self/stat"
  if not file then return os.clock() end
  local fields, sum = file:read "*a":match "%) (.*)", 0
  file:close()
  local n = 0
  for field in fields:gmatch "%S+" do
    n = n + 1
    if n >= 12 and n <= 15 then sum = sum + field end -- utime, stime, cutime, cstime
  end
  return sum / ticks
end

--- Prints a failure, or why a spec was skipped.
local function say(result, name, message, trace)
  local place = trace and trace.short_src and ("%s:%d: "):format(trace.short_src, trace.currentline) or ""
  message = type(message) == "string" and message or require "pl.pretty".write(message)
  print(("%s %s\n    %s%s"):format(result, name, message:find(place, 1, true) and "" or place, (message:gsub("\n", "\n    "))))
end

return function()
  lacking.watch()
  local names = require "busted.outputHandlers.base"()
  local report = assert(io.open(path, "a"))
  local begun, noted, failures, asked = 0, 0, {}, nil -- asked: the part that was asked for in vain before an `it` began
  local handler = {}

  local function note(result, name)
    local seconds = clock() - begun
    noted = noted + seconds
    report:write(result, ("\t%.2f\t"):format(seconds), (name:gsub("%s+", " ")), "\n")
    report:flush()
  end

  local function start()
    begun, asked = clock(), lacking.part
    return nil, true
  end

  local function finish(element, _, status)
    local name = names.getFullName(element)
    if status == "success" then note("passed", name)
    elseif status == "pending" then
      note("skipped", name)
      if not failures[element] then say("skipped:", name, element.message or "pending") end
    elseif lacking.part or failures[element] then note("skipped", name)
    else note("failed", name) end
    lacking.part = asked
    return nil, true
  end

  local function pending(element, _, message)
    failures[element] = true
    say("skipped:", names.getFullName(element), message)
    return nil, true
  end

  local function failed(element, _, message, trace)
    local name = names.getFullName(element)
    local jansson = type(message) == "string" and message:match "glTF needs jansson: [^\n]*"
    if lacking.part or jansson then
      note("lacking", jansson and "jansson" or "libylm_" .. lacking.part)
      say("skipped:", name, jansson or ("libylm_%s is not built"):format(lacking.part))
      failures[element] = true
      if element.descriptor ~= "it" then note("skipped", name) end
      return nil, true
    end
    say("FAILED:", name, message, trace)
    if element.descriptor ~= "it" then note("failed", name) end -- of a file, describe, setup ..: no `it` is counted for it
    return nil, true
  end

  local function done()
    report:write(("other\t%.2f\t\n"):format(math.max(0, clock() - noted)), "done\n")
    report:close()
    return nil, true
  end

  function handler.subscribe()
    require "busted.languages.en"
    busted.subscribe({ "test", "start" }, start)
    busted.subscribe({ "test", "end" }, finish)
    busted.subscribe({ "pending", "it" }, pending)
    busted.subscribe({ "failure" }, failed)
    busted.subscribe({ "error" }, failed)
    busted.subscribe({ "exit" }, done)
  end

  return handler
end
