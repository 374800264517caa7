--- Prints what spec/run has to do, "LUA FILE" a line, the longest first, by the seconds that spec/run measured last.
--
--     lua spec/support/run/jobs.lua "lua5.4 luajit" spec/sh_eval_spec.lua spec ...
--
-- YLM_SPEC=quick leaves out what is slow or needs more than a compiler; YLM_SPEC=luas runs those that make test runs under each,
-- and four whose subject is the interpreter too; YLM_SPEC=compiled leaves out those that run no code of the build, and
-- YLM_SPEC=threads what quick and compiled leave out, and those of arguments and examples.

local LONG, EARLY = 40, 20 -- seconds of specs that once.lua calls so, before they were measured
local BYTES = 3000         -- of a spec's file a second, for any other
local which = os.getenv "YLM_SPEC"
local build = os.getenv "BUILD" or "build"
local of_luas = { abi = true, codegen = true, guide = true, style = true }

local luas = {}
for lua in arg[1]:gmatch "%S+" do luas[#luas + 1] = lua end

--- List of spec/once.lua -> spec -> true.
local once = {}
for list, names in pairs(dofile "spec/once.lua") do
  once[list] = {}
  for name in names:gmatch "%S+" do once[list][name] = true end
end

--- The Luas that run a spec.
local function luas_of(name)
  if which == "luas" then return (once.one[name] or once.last[name]) and not of_luas[name] and {} or luas end
  if once.one[name] then return { luas[1] } end
  if once.last[name] then return { luas[#luas] } end
  if once.two[name] then return { luas[1], luas[2] and luas[#luas] } end
  return luas
end

--- The seconds of processor time that a spec took last; nil where there is no whole report.
local function measured(lua, name)
  local file = io.open(("%s/spec/%s/%s_spec"):format(build, lua, name))
  if not file then return nil end
  local seconds, done = 0, false
  for line in file:lines() do
    seconds = seconds + (tonumber(line:match "^%l+\t([%d.]+)\t") or 0)
    done = line == "done"
  end
  file:close()
  return done and seconds or nil
end

--- About as many seconds as a spec takes under a Lua: measured under it, under the first Lua, or by the size of its file.
local function seconds_of(lua, name, path)
  local seconds = measured(lua, name) or measured(luas[1], name)
  seconds = seconds or once.long[name] and LONG or once.early[name] and EARLY
  if seconds then return seconds end
  local file = io.open(path)
  local bytes = file and file:seek "end" or 0
  if file then file:close() end
  return bytes / BYTES
end

local leaves_slow, leaves_text = which == "quick" or which == "threads", which == "compiled" or which == "threads"

--- Is a spec left out?
local function left_out(name)
  return leaves_text and once.text[name]
    or which == "threads" and once.words[name]
    or leaves_slow and (once.long[name] or name:find "^vulkan" or name == "install" or name == "memory")
end

local function quote(s) return "'" .. s:gsub("'", "'\\''") .. "'" end

--- The spec files that a word of the command line stands for: itself, or those in a folder.
local function files(word)
  if word:find "%.lua$" then return { word } end
  local list, pipe = {}, assert(io.popen("find " .. quote(word) .. " -name '*_spec.lua'"))
  for file in pipe:lines() do list[#list + 1] = file end
  pipe:close()
  return list
end

local jobs = {}
for i = 2, #arg do
  for _, file in ipairs(files(arg[i])) do
    local name = file:match "([^/]*)_spec%.lua$" or file
    for _, lua in ipairs(left_out(name) and {} or luas_of(name)) do
      jobs[#jobs + 1] = { seconds = seconds_of(lua, name, file), text = lua .. " " .. file }
    end
  end
end
table.sort(jobs, function(a, b)
  if a.seconds ~= b.seconds then return a.seconds > b.seconds end
  return a.text < b.text
end)
for _, job in ipairs(jobs) do print(job.text) end
