-- The time that Lua adds to a call of ylm.sh: nanoseconds of single vectors (arguments checked, results allocated) beside batches
-- of 1000 by vector, whose arithmetic is the same. Run by `make bench` for every Lua that was built.

local ylm = require "ylm"
local core = require "ylm.c.core"

local quick = os.getenv "BENCH" == "quick"

--- Nanoseconds of a call, the least of some samples.
local function time(f)
  local least = math.huge
  f()
  for _ = 1, quick and 3 or 9 do
    local calls, began = 0, core.seconds()
    repeat
      for _ = 1, 20 do f() end
      calls = calls + 20
    until core.seconds() - began > (quick and 0.001 or 0.005)
    least = math.min(least, (core.seconds() - began) / calls)
  end
  return least * 1e9
end

print(("what Lua adds (%s): ns of one call for one vector, ns per vector of batches of 1000, one thread, float")
  :format(rawget(_G, "jit") and "LuaJIT" or _VERSION))
print "lmax  eval: one   with out   of 1000 | rotate: one  by object  with out  of 1000 | product: one  with out  of 1000"
for _, lmax in ipairs { 2, 4, 9 } do
  local a = ylm.sh.random(1, lmax, { dtype = "float" }):reshape { (lmax + 1) ^ 2 }
  local b = ylm.sh.rotate(a, { axis = { 0, 0, 1 }, angle = 1 })
  local many, others = ylm.sh.random(1000, lmax, { dtype = "float" }), ylm.sh.random(1000, lmax, { dtype = "float" })
  local point = ylm.array({ { 1, 2, 3 } }, "float")
  local points = ylm.array(ylm.sh.random(1000, 1)[{ {}, { 1, 3 } }], "float")
  local r = { quaternion = { 0.3, 0.5, -0.2, 0.7 } }
  local object = ylm.sh.rotation(lmax, r, { dtype = "float" })
  local out, outs, Y = ylm.zeros(a.shape, "float"), ylm.zeros(many.shape, "float"),
    ylm.zeros({ 1, (lmax + 1) ^ 2 }, "float")
  local to, all = { out = out }, { out = outs, threads = 1 }
  local evaluated = { out = Y }
  local cells = {
    time(function() ylm.sh.eval(lmax, point) end), time(function() ylm.sh.eval(lmax, point, evaluated) end),
    time(function() ylm.sh.eval(lmax, points, all) end) / 1000,
    time(function() ylm.sh.rotate(a, r) end), time(function() ylm.sh.rotate(a, object) end),
    time(function() ylm.sh.rotate(a, object, to) end), time(function() ylm.sh.rotate(many, object, all) end) / 1000,
    time(function() ylm.sh.product(a, b) end), time(function() ylm.sh.product(a, b, to) end),
    time(function() ylm.sh.product(many, others, all) end) / 1000,
  }
  print(("%4d  %9.0f  %9.0f %9.1f | %11.0f  %9.0f %9.0f %8.1f | %12.0f %9.0f %8.1f"):format(lmax,
    (table.unpack or unpack)(cells))) -- luacheck: ignore
end
