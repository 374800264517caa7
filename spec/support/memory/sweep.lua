-- Memory that runs out at every request in turn, or at a limit of the address space, in the calls of calls.lua.
--
--     LD_PRELOAD=failure.so lua5.4 spec/support/memory/sweep.lua FOLDER STRIDE [PATTERN]
--
-- Prints a line for each defect and one for each call; its exit status is 1 where there was a defect.

local failure = require "failure"
local core = require "ylm.c.core"
local calls = require "spec.support.memory.calls"
local ylm = require "ylm"

local folder, stride, only = arg[1], tonumber(arg[2] or 1), arg[3]

--- A result in words: equal results have equal words. Times differ and are left out.
local function words(x, depth)
  depth = depth or 0
  local kind = core.type(x)
  if kind == "ylm.array" then
    local numbers = (x.dtype == "int32" or x.dtype == "float16") and ylm.array(x, "double") or x
    local _, _, norm = core.array_distance(numbers, numbers)
    return ("%s %.9g"):format(table.concat(x.shape, "x"), norm)
  elseif kind == "ylm.image" then
    local list = {}
    for _, name in ipairs(x:layers()) do list[#list + 1] = name .. " " .. words(x:layer(name)) end
    return table.concat(list, ", ")
  elseif kind == "ylm.mesh" then return words(x:vertices()) .. ", " .. words(x:triangles())
  elseif kind == "ylm.grid" then return words(x:points().value) .. ", " .. words(x:cells().size)
  elseif type(x) == "table" and depth < 4 then
    local names, list = {}, {}
    for name in pairs(x) do if not tostring(name):find "seconds" then names[#names + 1] = name end end
    table.sort(names, function(a, b) return tostring(a) < tostring(b) end)
    for i, name in ipairs(names) do list[i] = tostring(name) .. "=" .. words(x[name], depth + 1) end
    return "{" .. table.concat(list, ", ") .. "}"
  elseif type(x) == "number" then return ("%.9g"):format(x)
  elseif type(x) == "table" or type(x) == "userdata" then return type(x) end
  return tostring(x)
end

local defects = 0
local function defect(name, where, ...)
  defects = defects + 1
  io.write("DEFECT ", name, ", ", where, ": ", (...):format(select(2, ...)), "\n")
end

--- One call while memory is short: its result is right, or nil, message, "ENOMEM". Returns whether it failed so.
local function check(name, where, expected, ok, result, message, code)
  if not ok then return defect(name, where, "raised %s", tostring(result)) end
  if result == nil then
    if code ~= "ENOMEM" or type(message) ~= "string" then
      return defect(name, where, "nil, %s, %s", tostring(message), tostring(code))
    end
    if message:find "%.lua:%d" and name ~= "load of a scene file" then return defect(name, where, "names a line: %s", message) end
    return true
  end
  local got = words(result)
  if got ~= expected then defect(name, where, "gave %s\n  instead of %s", got, expected) end
end

--- Repeats the call once memory is there again.
local function afterwards(name, where, expected, call)
  local ok, result, message, code = pcall(call)
  if not ok or result == nil then
    return defect(name, where .. ", afterwards", "%s, %s, %s", tostring(result), tostring(message), tostring(code))
  end
  local got = words(result)
  if got ~= expected then defect(name, where .. ", afterwards", "gave %s\n  instead of %s", got, expected) end
end

--- Every stride-th request fails; returns how many requests there are, and how many of the calls failed.
local function requests(name, call, expected)
  failure.arm(1e9)
  pcall(call)
  local total, failed = failure.requests(), 0
  -- of a few requests all, so that none is left out for ever
  local step = stride > 12 and stride or math.max(1, math.min(stride, math.floor(total / 12)))
  for k = 1 + #name % math.max(1, math.min(step, total)), total, step do
    local where = ("request %d of %d"):format(k, total)
    failure.arm(k)
    local results = { pcall(call) }
    failure.arm(0)
    if check(name, where, expected, results[1], results[2], results[3], results[4]) then failed = failed + 1 end
    afterwards(name, where, expected, call)
  end
  failure.arm(0)
  return total, failed
end

--- The address space may grow by few bytes only. Lua's own memory runs out then too: also in the spec's lines.
local function limits(name, call, expected)
  -- LLVM, which draws pictures without a GPU, aborts; Embree waits for ever
  if name:find "^picture" or name:find "by rays$" then return 0 end
  local failed = 0
  for i = 14, 26, stride == 1 and 1 or 4 do
    local where = ("%d KiB"):format(2 ^ (i - 10))
    collectgarbage()
    failure.limit(2 ^ i)
    local ok, result, message, code = pcall(call)
    failure.limit()
    if ok or not tostring(result):find "not enough memory" then
      if check(name, where, expected, ok, result, message, code) then failed = failed + 1 end
    else failed = failed + 1 end
    afterwards(name, where, expected, call)
  end
  return failed
end

local names = {}
for name in pairs(calls) do if not only or name:find(only) then names[#names + 1] = name end end
table.sort(names)
local all, failures = 0, 0
for _, name in ipairs(names) do
  local files = {}
  local began = os.clock()
  local call = calls[name](function(file)
    local path = folder .. "/" .. file
    files[path] = true
    return path
  end)
  local result, message = call()
  assert(result ~= nil, name .. ": " .. tostring(message))
  local expected = words(result)
  result = nil -- luacheck: ignore
  local total, failed = requests(name, call, expected)
  all, failures = all + total, failures + failed
  local short = limits(name, call, expected)
  for path in pairs(files) do os.remove(path) end
  local left = io.popen("ls " .. folder):read "*a"
  if left ~= "" then defect(name, "its folder", "holds %s", left) end
  io.write(("%-28s %4d requests, %4d made it fail, %2d limits did; %.2f s\n"):format(name, total, failed, short,
    os.clock() - began))
end
io.write(("%d calls, %d requests, %d failures, %d defects\n"):format(#names, all, failures, defects))
os.exit(defects == 0 and 0 or 1)
