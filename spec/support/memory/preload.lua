--- Programs in which memory runs out: spec/support/memory/failure.c is preloaded, and a module of theirs.
--
--     local preload = require "spec.support.memory.preload"
--     setup(function() program, missing = preload.new(folder) end)
--     local out, status = program "spec/support/update_memory.lua 5"

local scratch = require "spec.support.scratch"

local quote = scratch.quote
local build, lua = os.getenv "YLM_BUILD" or "build", os.getenv "YLM_LUA" or "lua5.4"
local abi = lua == "luajit" and "lua5.1" or lua

local preload = {}

--- A function that runs a script with arguments and returns what it prints, and its status. The library is made in a folder
-- of scratch.new. Where it cannot be: nil, the reason.
function preload.new(folder)
  local preloaded = (os.getenv "LD_PRELOAD" or "") .. (os.getenv "TSAN_OPTIONS" or "") -- spec/threads hides its own
  if preloaded ~= "" then return nil, "another library is preloaded" end
  local source, library = "spec/support/memory/failure.c", quote(folder.path .. "/failure.so")
  local out, status = scratch.capture(("${CC:-cc} -std=gnu11 -O1 -Wall -Wextra -Werror -shared -fPIC "
    .. "$(pkg-config --cflags %s) %s -o %s -ldl"):format(lua, source, library))
  if status ~= 0 then return nil, source .. " cannot be built: " .. out end
  return function(words)
    return scratch.capture(("YLM_THREADS=1 YLM_WARNINGS=no LUA_PATH='lua/?.lua;lua/?/init.lua;./?.lua;;' LD_PRELOAD=%s "
      .. "LUA_CPATH=%s %s %s"):format(library, quote(folder.path .. "/?.so;" .. build .. "/" .. abi .. "/?.so;;"), lua, words))
  end
end

--- Sweeps the calls whose names match a pattern (sweep.lua), every stride-th request, or with YLM_MEMORY=all each, or
-- every `all`-th.
function preload.sweep(program, folder, pattern, stride, all)
  local files = folder.path .. "/files"
  scratch.shell("mkdir -p " .. quote(files))
  return program(("spec/support/memory/sweep.lua %s %d %s"):format(quote(files),
    os.getenv "YLM_MEMORY" == "all" and (all or 1) or stride, quote(pattern)))
end

return preload
