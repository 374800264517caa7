--- Runs scene files, which may come from strangers.
--
-- A file can reach the constructors (every form), math, a few functions
-- on tables. Files (but by name, inside its folder), strings' methods, metatables, coroutines,
-- pcall, load and debug are out of its reach. Of objects that constructors build it holds opaque
-- stand-ins. A file's instructions, processor time, memory and described sizes are bounded. The
-- bounds on instructions and memory are C's: csrc/lua/core/sandbox.c.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local memory = require "ylm.memory"
local text = require "ylm.text"

local sandbox = {}

--- The limits and their defaults.
sandbox.limits = {
  { "instructions", "number", min = 1, default = 2e8, about = "of the Lua machine" },
  { "time_limit", "number", above = 0, default = 60, unit = "s", about = "of processor time" },
  { "memory", "number", min = 65536, default = 2 ^ 28, unit = "bytes", about = "for Lua's values" },
  { "triangles", "number", min = 0, default = 2e7, about = "of all geometry together" },
  { "numbers", "number", min = 0, default = 2 ^ 23,
    about = "of all arrays together; a sphere light of an array is 7 of them, a piece of geometry 64, a flat light 256" },
  { "virtual_lights", "number", min = 0, default = 10000, about = "of all sets together: places, of whatever emission" },
  { "texels", "number", min = 0, default = 2 ^ 20, about = "of all textures together" },
  { "cells", "number", min = 0, default = 2 ^ 24, about = "of all uniform grids together" },
  { "lmax", "number", min = 0, default = 64, about = "of any grid" },
  { "depth", "number", min = 0, default = 12, about = "of any adaptive grid" },
  { "file_size", "number", min = 0, default = 2 ^ 28, unit = "bytes",
    about = "of the scene file, each mesh, image and material" },
  { "material_bytes", "number", min = 0, default = 2 ^ 30, about = "of all files of materials together" },
}

-- Numbers: mathematics with a generator that is the same everywhere ------------------

--- MRG32k3a (L'Ecuyer 1999): exact in doubles, so the same under every Lua.
local function generator()
  local a1, a2, a3, b1, b2, b3
  local m1, m2 = 4294967087, 4294944443
  local function seed(s)
    s = check.is_number(s) and math.floor(math.abs(s)) % 4294944000 or 0
    a1, a2, a3, b1, b2, b3 = s + 1, 12345, 12345, 12345, 12345, s + 1
  end
  local function uniform()
    local a = (1403580 * a2 - 810728 * a1) % m1
    a1, a2, a3 = a2, a3, a
    local b = (527612 * b3 - 1370589 * b1) % m2
    b1, b2, b3 = b2, b3, b
    return ((a - b) % m1) / m1
  end
  seed(0)
  return function(lo, hi)
    local u = uniform()
    if lo == nil then return u end
    if hi == nil then lo, hi = 1, lo end
    if not (check.is_integer(lo) and check.is_integer(hi) and lo <= hi) then
      return check.fail("random: whole numbers with low <= high expected")
    end
    return lo + math.floor(u * (hi - lo + 1))
  end, seed
end

local function mathematics()
  local out = {}
  for _, name in ipairs { "abs", "acos", "asin", "atan", "ceil", "cos", "deg", "exp", "floor", "fmod",
    "huge", "log", "max", "min", "modf", "pi", "rad", "sin", "sqrt", "tan" } do
    out[name] = math[name]
  end
  local atan, log = math.atan, math.log
  local atan2 = math.atan2 or atan -- luacheck: ignore 143
  function out.atan(y, x) if x then return atan2(y, x) else return atan(y) end end
  out.atan2 = atan2
  function out.log(x, base) if base then return log(x) / log(base) else return log(x) end end
  function out.pow(x, y) return x ^ y end
  out.random, out.randomseed = generator()
  return out
end

-- Tables: in Lua, so that their work counts as instructions --------------------------

local function need_table(name, t)
  if type(t) ~= "table" then
    return check.bad(1, name, "a table expected, got %s", check.describe(t))
  end
end

local function insert(t, ...)
  need_table("insert", t)
  local count = select("#", ...)
  local place, value = ...
  if count == 1 then place, value = #t + 1, place
  elseif count ~= 2 or not check.is_integer(place) or place < 1 or place > #t + 1 then
    return check.bad(2, "insert", "a place from 1 to %d expected, got %s", #t + 1, check.describe(place))
  end
  for i = #t, place, -1 do t[i + 1] = t[i] end
  t[place] = value
end

local function remove(t, place)
  need_table("remove", t)
  local n = #t
  if place == nil then place = n end
  if n == 0 then return nil end
  if not check.is_integer(place) or place < 1 or place > n then
    return check.bad(2, "remove", "a place from 1 to %d expected, got %s", n, check.describe(place))
  end
  local value = t[place]
  for i = place, n - 1 do t[i] = t[i + 1] end
  t[n] = nil
  return value
end

local function less(a, b) return a < b end

--- Merge sort: stable, and safe with comparisons that contradict themselves.
local function sort(t, before)
  need_table("sort", t)
  before = before or less
  local n, from, to, width = #t, t, {}, 1
  while width < n do
    for lo = 1, n, 2 * width do
      local mid, hi = math.min(lo + width, n + 1), math.min(lo + 2 * width, n + 1)
      local i, j = lo, mid
      for k = lo, hi - 1 do
        if i < mid and (j >= hi or not before(from[j], from[i])) then to[k], i = from[i], i + 1
        else to[k], j = from[j], j + 1 end
      end
    end
    from, to, width = to, from, 2 * width
  end
  if from ~= t then for i = 1, n do t[i] = from[i] end end
end

local function concat(t, separator, i, j)
  need_table("concat", t)
  separator, i, j = separator or "", i or 1, j or #t
  local out = ""
  for k = i, j do
    local x = t[k]
    if type(x) ~= "string" and type(x) ~= "number" then
      return check.bad(1, "concat", "element %s is %s", tostring(k), check.describe(x))
    end
    out = out .. (k > i and separator or "") .. x
  end
  return out
end

local function spread(t, i, j)
  need_table("unpack", t)
  i, j = i or 1, j or #t
  if not (check.is_integer(i) and check.is_integer(j)) or j - i >= 1000 then
    return check.bad(1, "unpack", "at most 1000 values")
  end
  return (table.unpack or unpack)(t, i, j) -- luacheck: ignore 113
end

-- Stand-ins for what constructors build ------------------------------------------------

--- The object that a stand-in stands for; nil of any other value. Files never hold the object itself: through an
-- object's metatable they could reach functions that trusted code uses later.
local function object_of(x) return core.owned(x, "object") end

local stand_in = {
  __metatable = false,
  __index = function(p, key)
    return check.fail("a %s is a description: its field %s cannot be read in a scene file",
      form.kind(object_of(p)) or "value", check.describe(key))
  end,
  __newindex = function(p)
    return check.fail("a %s is a description: make another instead of changing it",
      form.kind(object_of(p)) or "value")
  end,
  __tostring = function(p) return form.kind(object_of(p)) or "value" end,
}

local function wrap(object)
  local p = setmetatable({}, stand_in)
  core.own(p).object = object
  return p
end

--- A copy of what a file passes to a constructor, objects in place of stand-ins.
local function unwrap(x, seen)
  local t = type(x)
  if t == "number" or t == "string" or t == "boolean" or t == "nil" then return x end
  if t ~= "table" then return check.fail("a %s cannot be part of a description", t) end
  local object = object_of(x)
  if object then return object end
  seen = seen or { depth = 0 }
  if seen[x] then return seen[x] end
  if seen.depth > 64 then return check.fail("tables nested more than 64 deep") end
  local copy = {}
  seen[x] = copy
  seen.depth = seen.depth + 1
  for key, value in next, x do
    if type(key) ~= "number" and type(key) ~= "string" then
      return check.fail("a %s cannot be a key of a description", type(key))
    end
    copy[key] = unwrap(value, seen)
  end
  seen.depth = seen.depth - 1
  return copy
end

-- Described sizes -----------------------------------------------------------------------

--- Is it a form of geometry? They share the field `occludes`, and say `triangles(values)`.
local function is_geometry(definition)
  for _, field in ipairs(definition.fields) do if field[1] == "occludes" then return true end end
  return false
end

--- Bounds of the descriptions of a file and of those that it is like: take(what, n, fail), and form.budget.
local function bounds(limits, state)
  local left = { triangles = limits.triangles, numbers = limits.numbers, cells = limits.cells, texels = limits.texels,
    virtual_lights = limits.virtual_lights, material_bytes = limits.material_bytes,
    file_size = limits.file_size } -- of each file: not used up
  local function take(what, n, fail)
    left[what] = left[what] - n
    if left[what] < 0 then
      state.limit = what
      return fail(("more than %.0f %s in one scene file"):format(limits[what], what))
    end
  end
  local function budget(what, n, fail)
    if n then take(what, n, fail) end
    return left[what]
  end
  return take, budget
end

--- The file's real name and size, as core.resolve_inside has them; a name that it has returned for these files is as good.
local function resolve(folder, name, state)
  if state.sizes[name] then return name, state.sizes[name] end
  state.reads = true
  local real, size, code = core.resolve_inside(folder, name)
  if real then state.sizes[real] = size end
  return real, size, code
end

--- The observer of forms in a file of this folder (see form.observer): counts what is described, resolves file names.
local function observer(folder, limits, state)
  local take = state.take
  --- form.locate: the folder of a file of the scene's folder lies inside it.
  local function locate(place, name)
    state.reads = true
    local real, size, code = core.resolve_inside(place, name)
    if not real then return nil, size, code end
    if size <= limits.file_size then return real end
    state.limit = "file_size"
    return nil, ("%s has more than %.0f bytes"):format(name, limits.file_size), "ELIMIT"
  end
  return locate, function(definition, values, fail)
    for _, field in ipairs(definition.fields) do
      local name = field[1]
      if values[name] ~= nil and (name == "file" or field[2] == "path") then
        local real, size, code = resolve(folder, values[name], state)
        if not real then
          state.code = code ~= "EINVAL" and code or nil
          return fail(("%s: %s"):format(name, size))
        end
        if size > limits.file_size then
          state.limit = "file_size"
          return fail(("%s has more than %.0f bytes"):format(values[name], limits.file_size))
        end
        -- Every further corner of a polygon is a triangle, and takes two bytes of text at least.
        if is_geometry(definition) then take("triangles", size / 2, fail) end
        if definition.material then take("material_bytes", size, fail) end
        values[name] = real
      end
    end
    if definition.numbers then take("numbers", definition.numbers, fail) end
    if is_geometry(definition) then
      if not definition.triangles then return fail "has no bound on its triangles" end
      take("triangles", definition.triangles(values), fail)
    end
    if definition.name == "uniform_grid" and type(values.cells) == "table" then
      local n = 1
      for _, c in ipairs(values.cells) do n = n * c end
      take("cells", n, fail)
    end
    for _, name in ipairs { "lmax", "depth" } do
      if values[name] and values[name] > limits[name] then
        state.limit = name
        return fail(("%s at most %d in a scene file, got %d"):format(name, limits[name], values[name]))
      end
    end
  end
end

-- The environment ---------------------------------------------------------------------

local function names_of(t)
  local names = {}
  for name in pairs(t) do names[#names + 1] = name end
  table.sort(names)
  return names
end

--- The modules of ylm whose forms describe scenes.
local describing = { "ylm.camera", "ylm.material", "ylm.photometry", "ylm.geometry", "ylm.gltf", "ylm.grid", "ylm.transfer.form" }
for _, kind in ipairs(require "ylm.light.kinds") do describing[#describing + 1] = kind[1] end

--- The constructors, as files see them; `scene` is ylm.scene.
local function constructors(env, state, scene)
  local homes = {}
  for _, module in ipairs(describing) do
    require(module)
    homes[module] = true
  end
  for name, definition in pairs(form.defined) do
    if (homes["ylm." .. definition.home] or definition.material) and not definition.trusted then
      local construct = definition.construct
      env[name] = function(given)
        local object, message, code = construct(unwrap(given))
        if object == nil then
          state.code = code
          return check.fail("%s: %s", name, message)
        end
        return wrap(object)
      end
    end
  end
  env.scene = function(name)
    local fill, where = scene(unwrap(name)), check.position()
    return function(given)
      local ok, copy = memory.pcall(unwrap, given)
      if not ok then error(where .. copy:gsub("^.-:%d+: ", ""), 0) end
      local made, message, code = fill(copy)
      if not made then
        state.code = code
        error(("%sscene: %s"):format(where, message), 0)
      end
      return wrap(made)
    end
  end
end

local function environment(state, scene)
  local env = {
    assert = assert, error = error, ipairs = ipairs, next = next, pairs = pairs, select = select,
    tonumber = tonumber, type = function(...)
      if select("#", ...) == 0 then return check.bad(1, "type", "value expected") end
      return (type((...)))
    end,
    tostring = function(x)
      local t = type(x)
      local object = object_of(x)
      if object then return form.kind(object) end
      if t == "table" or t == "function" or t == "userdata" then return t end
      return tostring(x)
    end,
    math = mathematics(),
    table = { insert = insert, remove = remove, sort = sort, concat = concat, unpack = spread },
    unpack = spread,
  }
  constructors(env, state, scene)
  local names = names_of(env)
  return setmetatable(env, {
    __metatable = false,
    __index = function(_, name)
      local guess = type(name) == "string" and check.guess(name, names)
      return check.fail("there is no %s in a scene file%s", check.describe(name),
        guess and (" (did you mean '%s'?)"):format(guess) or "; it holds numbers, tables, math and the constructors")
    end,
  })
end

--- While files run, strings indexed from them (`sources`, a set) have no methods; other code is not disturbed.
local function guarded_strings(sources)
  local metatable = debug.getmetatable("")
  local index = metatable.__index
  local function restore() metatable.__index = index end
  metatable.__index = function(s, key)
    local info = debug.getinfo(2, "S")
    if not info or info.what == "C" or sources[info.source] then
      return check.fail("there are no string methods in a scene file")
    end
    if type(index) == "function" then return index(s, key) end
    return index[key]
  end
  return restore
end

-- Running -------------------------------------------------------------------------------

--- The file as a function, or nil, message: text only, whatever the Lua.
local function compile(code, source, env)
  if code:find("\27", 1, true) then return nil, "compiled Lua is not accepted: only text is" end
  code = code:gsub("^\239\187\191", ""):gsub("^#[^\n]*", "")
  if setfenv then -- luacheck: ignore 113
    local chunk, message = loadstring(code, source) -- luacheck: ignore 113
    if not chunk then return nil, message end
    return setfenv(chunk, env) -- luacheck: ignore 113
  end
  return load(code, source, "t", env)
end

local reasons = {
  instructions = "takes more than %.0f instructions",
  time = "takes more than %g seconds of processor time",
  memory = "takes more than %.0f bytes of memory",
}

--- "file.lua: why", with the line that `why` names if it names one; nothing for a terminal to obey.
local function explain(path, why)
  if why:sub(1, #path + 1) ~= path .. ":" then why = path .. ": " .. why end
  return text.shown(why:sub(1, 1000 + #path))
end

--- A message handler: a line of ylm that an error names becomes the line of a file (`sources`, a set) that led there.
local function located(sources)
  return function(raised)
    if type(raised) ~= "string" then return raised end
    local said, level = raised:match "^[^\n]-:%d+: (.*)$", 2
    local names_ylm = false
    while said and level < 100 do
      local info = debug.getinfo(level, "Sl")
      if not info then return raised end
      if sources[info.source] and info.currentline > 0 then
        return names_ylm and ("%s:%d: %s"):format(info.source:sub(2), info.currentline, said) or raised
      end
      names_ylm = names_ylm or info.what ~= "C" and raised:sub(1, #info.short_src + 1) == info.short_src .. ":"
      level = level + 1
    end
    return raised
  end
end

--- Under LuaJIT: no compiled code while a file runs, because hooks do not fire in it; not even in
-- ylm's own loops, whose length the file may have chosen. Returns what restores it.
local function without_jit()
  if not (jit and jit.status()) then return function() end end -- luacheck: ignore 113
  jit.off()
  jit.flush()
  return jit.on
end

--- Most files that are like one another.
local DEEPEST = 8

--- The scene that a file made, or nil, why.
local function scene_of(result)
  local object = object_of(result)
  if form.kind(object) == "scene" then return object end
  return nil, ("must return a scene (return scene \"name\" { ... }), got %s"):format(
    object and "a " .. form.kind(object) or check.describe(result))
end

--- Makes a file ready: a function that runs it and returns its scene, its real name. Or nil, message, code.
local function ready(path, state, limits, scene)
  local content, message, code = core.read_file(path, math.min(limits.file_size, 2 ^ 24))
  if not content then return nil, message, code end
  local source, env = "@" .. path, environment(state, scene)
  local folder = path:match("^(.*)/[^/]*$") or "."
  if folder == "" then folder = "/" end
  local locate, observe = observer(folder, limits, state)
  state.sources[source] = true

  return function()
    local locate_before, observe_before, boundary_before = form.locate, form.observer, check.boundary
    local path_before, folder_before = state.path, state.folder
    local function work()
      state.compiling = true
      local chunk, wrong = compile(content, source, env)
      if not chunk then error(wrong, 0) end
      state.compiling = false
      local result = chunk() -- not a tail call: this frame is check.boundary
      return result
    end
    form.locate, form.observer, check.boundary, state.path, state.folder = locate, observe, work, path, folder
    local made, why = scene_of(work())
    if not made then error(why, 0) end
    made.file = path
    form.locate, form.observer, check.boundary = locate_before, observe_before, boundary_before
    state.path, state.folder = path_before, folder_before
    return made
  end, (core.resolve_inside(folder, path:match "[^/]*$"))
end

--- form.like for files of `state`: runs another file within what is left. An error of it passes the file that names it:
-- state.chain has the lines.
local function follower(state, limits, scene)
  return function(name, where)
    state.reads = true
    local real, message, code = core.resolve_inside(state.folder, name)
    local function fail(why, status)
      state.code = status
      error(("%slike: %s"):format(where, why), 0)
    end
    if not real then return fail(message, code ~= "EINVAL" and code or nil) end
    local names = {}
    for i, file in ipairs(state.files) do names[i] = file:match "[^/]*$" end
    for i, file in ipairs(state.files) do
      if file == real then
        return fail(("%s is like itself (%s -> %s)"):format(names[i], table.concat(names, " -> ", i), names[i]))
      end
    end
    if #names == DEEPEST then return fail(("more than %d scenes that are like one another"):format(DEEPEST)) end
    local run
    run, message, code = ready(real, state, limits, scene)
    if not run then return fail(message, code) end
    state.files[#names + 1], state.chain[#state.chain + 1] = real, where
    local made = run()
    state.files[#names + 1], state.chain[#state.chain] = nil, nil
    return made
  end
end

--- A message of the file that ran last, behind the lines that led to it.
local function with_lines(state, why)
  if #state.chain == 0 then return explain(state.path, why) end
  return explain(state.chain[1]:match "^(.*):%d+: $" or state.path,
    table.concat(state.chain, "like: ") .. "like: " .. explain(state.path, why))
end

--- Runs the file `path` within `limits` (all fields given); `scene` is ylm.scene. Returns the scene, or nil, message, code.
function sandbox.run(path, limits, scene)
  if form.observer then return check.fail("a scene file cannot load another") end
  local state = { sources = {}, sizes = {}, files = {}, chain = {}, path = path }
  state.take, form.budget = bounds(limits, state)
  local run, real, code = ready(path, state, limits, scene)
  if not run then
    form.budget = nil
    return nil, real, code
  end
  state.files[1] = real or path

  local restore, compile_again = guarded_strings(state.sources), without_jit()
  form.like = follower(state, limits, scene)
  local called, ok, result, reason = pcall(core.bounded_call, run, limits.instructions, limits.memory, limits.time_limit,
    located(state.sources))
  form.budget, form.locate, form.observer, form.like, check.boundary = nil, nil, nil, nil, false
  restore()
  compile_again()
  if not called then error(ok, 0) end

  if reason and reason ~= "exhausted" then
    local limit = reason == "time" and limits.time_limit or limits[reason]
    return nil, with_lines(state, reasons[reason]:format(limit)), "ELIMIT"
  end
  if ok then
    result.alone = not state.reads -- its file is all that it is made of
    return result
  end
  local exhausted = memory.message(result)
  if exhausted then return nil, with_lines(state, exhausted), "ENOMEM" end
  if type(result) ~= "string" then result = "raised " .. check.describe(result) end
  return nil, with_lines(state, result), state.limit and "ELIMIT" or not state.compiling and state.code or "EFORMAT"
end

return sandbox
