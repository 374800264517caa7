-- Every exported function, method and form refuses bad input, in words that name what was wrong.
--
-- spec/support/refusals/*.lua return { ["sh.eval"] = { { call = function(ylm) ... end, says = "pattern" }, ... } }.
-- A name that is exported and has no refusals fails here.

local help = require "ylm.help"
local ylm = help.load()

--- They take no argument.
local takes_nothing = { names = true, info = true }

local cases, names = {}, {}
do
  local list = assert(io.popen("ls spec/support/refusals/*.lua 2>/dev/null"))
  for path in list:lines() do
    for name, entries in pairs(dofile(path)) do
      cases[name] = cases[name] or {}
      for _, case in ipairs(entries) do table.insert(cases[name], case) end
    end
  end
  list:close()
  for name in pairs(cases) do names[#names + 1] = name end
  table.sort(names)
end

--- Fails unless the call raises, or returns nil and a message, that matches.
local function check_case(name, i, case)
  local ok, first, message = pcall(case.call, ylm)
  local said = first
  if ok then
    assert(first == nil and message ~= nil, ("%s, refusal %d: was accepted"):format(name, i))
    said = message
  end
  said = tostring(said)
  assert(said:find(case.says), ("%s, refusal %d: %q does not match %q"):format(name, i, said, case.says))
  if not ok then
    assert(said:find("refusals[%w_/]*%.lua:%d+: "),
      ("%s, refusal %d: %q is not at the caller's line"):format(name, i, said))
  end
end

describe("refusals", function()
  for _, name in ipairs(names) do
    it("of " .. name, function()
      for i, case in ipairs(cases[name]) do check_case(name, i, case) end
    end)
  end

  local public = help.public()
  for _, kind in ipairs { "functions", "methods", "forms" } do
    it("cover all " .. kind, function()
      local missing = {}
      for _, name in ipairs(public[kind]) do
        if not cases[name] and not takes_nothing[name] then missing[#missing + 1] = name end
      end
      assert.equal("", table.concat(missing, ", "))
    end)
  end

  it("are of things that exist", function()
    local known = {}
    for _, list in pairs(public) do for _, name in ipairs(list) do known[name] = true end end
    for _, name in ipairs(names) do assert(known[name], "refusals of unknown " .. name) end
  end)
end)
