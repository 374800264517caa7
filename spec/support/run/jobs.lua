--- Prints what spec/run has to do, "LUA FILE" a line, the longest first.
--
--     lua spec/support/run/jobs.lua "lua5.4 luajit" spec/sh_eval_spec.lua spec ...
--
-- YLM_SPEC=quick leaves out what is slow or needs more than a compiler; YLM_SPEC=long runs every spec under each Lua;
-- YLM_SPEC=luas runs those that make test runs under each, and four whose subject is the interpreter too.

local once = dofile "spec/once.lua"
local OTHERS = 10 -- seconds: a spec that runs under each Lua takes less
local which = os.getenv "YLM_SPEC"
local of_luas = { abi = true, codegen = true, guide = true, style = true }

local luas = {}
for lua in arg[1]:gmatch "%S+" do luas[#luas + 1] = lua end

--- The seconds of a spec, and the Luas that run it.
local function about(name)
  local entry = once[name]
  if which == "luas" and type(entry) == "number" and not of_luas[name] then return 0, {} end
  if which == "luas" then return OTHERS, luas end
  if not entry then return OTHERS, luas end
  if type(entry) == "number" then return entry, which == "long" and luas or { luas[1] } end
  return entry[1], which == "long" and luas or { luas[1], luas[2] and luas[#luas] }
end

--- Is a spec left out of `make quick`?
local function slow(name)
  return about(name) > 15 or name:find "^vulkan" or name == "install" or name == "memory"
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
    local seconds, run_by = about(name)
    for _, lua in ipairs(which == "quick" and slow(name) and {} or run_by) do
      jobs[#jobs + 1] = { seconds = seconds, text = lua .. " " .. file }
    end
  end
end
table.sort(jobs, function(a, b)
  if a.seconds ~= b.seconds then return a.seconds > b.seconds end
  return a.text < b.text
end)
for _, job in ipairs(jobs) do print(job.text) end
