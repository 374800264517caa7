-- Every example of the help, as the first call of a program: whatever module is loaded first, what it makes is complete.

local form = require "ylm.form"
local help = require "ylm.help"
local lacking = require "spec.support.run.lacking"
local long = require "spec.support.long"
local reference = require "ylm.describe"
local scratch = require "spec.support.scratch"

help.load()

--- Name -> text of a program that runs the example with `ylm` and the constructors at hand; of every twelfth name, or of all.
local function programs()
  local list, names, every = {}, {}, long(12, 1)
  local function add(name, text)
    if not (loadstring or load)(text) then text = "return " .. text end
    list[name] = 'local ylm = require "ylm"\nsetmetatable(_G, { __index = function(_, name) return ylm[name] end })\n'
      .. text .. "\n"
  end
  for name in pairs(reference.entries) do names[#names + 1] = name end
  for name in pairs(form.defined) do names[#names + 1] = name end
  table.sort(names)
  for i = 1, #names, every do add(names[i], (reference.entries[names[i]] or form.defined[names[i]]).example) end
  return list
end

--- The begin of a program: it says which parts it asks for that were not built.
local function begin_of_programs()
  local lines = {}
  for _, part in ipairs(lacking.parts()) do
    lines[#lines + 1] = ('package.preload["ylm.c.%s"] = function() io.stderr:write "lacks %s\\n" error("not built", 0) end')
      :format(part, part)
  end
  return table.concat(lines, "\n") .. "\n"
end

--- Runs each program in a process of its own, two at a time; name -> what it printed, of those that failed for other reasons than
-- a part that was not built.
local function failures(list)
  local folder, failed, begin = scratch.new(), {}, begin_of_programs()
  for name, text in pairs(list) do folder:write(name:gsub("%W", "-") .. ".lua", begin .. text) end
  scratch.capture(("ls %s | YLM_THREADS=1 xargs -P 2 -I @ sh -c '%s %s/@ >%s/@.out 2>&1 || touch %s/@.failed'"):format(
    scratch.quote(folder.path), os.getenv "YLM_LUA" or "lua5.4", folder.path, folder.path, folder.path))
  for name in pairs(list) do
    local file = name:gsub("%W", "-") .. ".lua"
    local mark = io.open(folder.path .. "/" .. file .. ".failed")
    if mark then
      mark:close()
      local text = folder:read(file .. ".out")
      if not text:find("^lacks %l+\n") and not text:find("\nlacks %l+\n") then failed[#failed + 1] = name .. ": " .. text end
    end
  end
  folder:remove()
  table.sort(failed)
  return failed
end

describe("a program's first call", function()
  it("may be any example of the help", function()
    assert.equal("", table.concat(failures(programs()), "\n"))
  end)

  it("may use an object before the module that has its methods", function()
    local uses = {
      array = "assert(core.array_zeros({ 2, 3 }, 'float').shape[2] == 3)",
      length = "assert(#core.array_zeros({ 2, 3 }, 'float') == 2)",
      text = "assert(tostring(core.array_zeros({ 2 }, 'float')):find 'array')",
      set = "local a = core.array_zeros({ 2 }, 'float'); a[2] = 5; assert(a[2] == 5)",
      image = "assert(core.image_new(2, 3).size[2] == 3)",
      mesh = "local mesh = core.mesh_quad({ 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, 1, 1); assert(#mesh:triangles() == 2)",
      unknown = "assert(core.array_zeros({ 2 }, 'float').nonsense == nil)",
    }
    for name, text in pairs(uses) do uses[name] = 'local core = require "ylm.c.core"\n' .. text .. "\n" end
    assert.equal("", table.concat(failures(uses), "\n"))
  end)
end)
