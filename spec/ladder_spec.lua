-- The architecture: includes go down the ladder, libraries stay free of what they do not need.

local ladder = require "spec.check.ladder"
local scratch = require "spec.support.scratch"
local build = os.getenv "YLM_BUILD" or "build"
local known = ladder.read "."

--- Files that are compiled into one unit with another room's, against the direction of their folder.
local joined = { ["csrc/light/moments/sum_float.isa.c"] = "tree", ["csrc/light/moments/sum_double.isa.c"] = "tree" }

--- Rooms whose files call one another in one direction, no two each other.
local ordered = { "grid/bake", "grid/promise" }

--- Which folders may include a system header that matches.
local reserved = {
  { "^lua%.h$", "lua" }, { "^lauxlib%.h$", "lua" }, { "^lualib%.h$", "lua" }, { "^luajit%.h$", "lua" },
  { "^vtk", "vtk" }, { "^EGL/", "vtk" }, { "^GL/", "vtk" }, { "^X11/", "vtk" },
  { "^openexr", "codec" }, { "^OpenEXR", "codec" }, { "^png%.h$", "codec" }, { "^zlib%.h$", "codec" },
  { "^embree", "trace" }, { "^vulkan/", "vulkan" }, { "^mpi%.h$", "mpi" },
}

local lines_of = scratch.lines

local sources = lines_of [[find csrc -name '*.[ch]' -o -name '*.cpp' -o -name '*.cc' -o -name '*.hpp' -o -name '*.inc']]

local function text_of(path)
  local file = assert(io.open(path))
  local text = file:read "*a"
  file:close()
  return text
end

local function exists(path)
  local file = io.open(path)
  if file then file:close() end
  return file ~= nil
end

--- Is `path` a file of a folder?
local function belongs(path, folder) return path:sub(1, #folder + 6) == "csrc/" .. folder .. "/" and exists(path) end

--- A way through a graph { [from] = { [to] = true } } that ends in a circle, as "a > b > c > b"; or nil.
local function circle(graph)
  local state = {}
  local function visit(node, path)
    if state[node] == "done" then return end
    if state[node] then return path .. node end
    state[node] = "open"
    for to in pairs(graph[node] or {}) do
      local found = visit(to, path .. node .. " > ")
      if found then return found end
    end
    state[node] = "done"
  end
  for node in pairs(graph) do
    local found = visit(node, "")
    if found then return found end
  end
end

local function add(graph, from, to)
  graph[from] = graph[from] or {}
  graph[from][to] = true
end

--- The names that an object file defines for others, and those that it uses of others.
local function symbols_of(object)
  local own, used = {}, {}
  for _, line in ipairs(lines_of("nm " .. scratch.quote(object))) do
    local kind, name = line:match "(%a) (%S+)$"
    if kind == "U" then used[#used + 1] = name
    elseif kind and kind:find "[TDBR]" then own[#own + 1] = name end
  end
  return own, used
end

--- Which file of a room calls which.
local function calls_of(room)
  local home, uses, graph = {}, {}, {}
  for _, path in ipairs(lines_of("find csrc/" .. room .. " -name '*.c' -not -name '*.isa.c'")) do
    local name = path:match "([^/]+)%.c$"
    local own, used = symbols_of(build .. "/obj/" .. room .. "/" .. name .. ".o")
    for _, symbol in ipairs(own) do home[symbol] = name end
    uses[name] = used
  end
  for name, used in pairs(uses) do
    for _, symbol in ipairs(used) do
      if home[symbol] and home[symbol] ~= name then add(graph, name, home[symbol]) end
    end
  end
  return graph
end

describe("the ladder", function()
  it("has every folder and room, in which no public header stands", function()
    assert(#sources > 0 and known.rank.base == 1 and #known.rooms.light > 5)
    assert.equal("", table.concat(ladder.rooms ".", "\n"))
  end)

  it("is only gone down by includes, through public headers", function()
    assert.equal("", table.concat(ladder.includes ".", "\n"))
  end)

  it("leads through the rooms of a folder in one direction", function()
    local graphs = {}
    ladder.each_include(".", function(path, folder, _, header)
      local room = path:match("^csrc/[^/]+/([^/]+)/")
      local place = ladder.beside(path, header)
      if not exists(place) then place = ladder.beside("csrc/" .. folder .. "/", header) end
      local other = place:match("^csrc/" .. folder .. "/([^/]+)/")
      if not known.rooms[folder] or not room or not other or other == room or other == "gen" or room == "gen" then return end
      if joined[path] ~= other and exists(place) then
        graphs[folder] = graphs[folder] or {}
        add(graphs[folder], room, other)
      end
    end)
    for folder, graph in pairs(graphs) do assert.equal("", circle(graph) or "", folder) end
    assert(graphs.grid.follow.bake and not graphs.grid.bake, "csrc/grid/bake includes another room")
    assert(circle { b = { a = true }, a = { b = true, c = true } } and not circle { b = { a = true }, a = { c = true } })
  end)

  it("has rooms whose files call one another in one direction", function()
    if not scratch.shell "command -v nm >/dev/null" then pending "nm is not installed" end
    for _, room in ipairs(ordered) do
      local graph = calls_of(room)
      assert(next(graph), "build/obj/" .. room .. " is missing")
      assert.equal("", circle(graph) or "", room)
    end
  end)

  it("has includes before the first declaration of a file, but for generated parts", function()
    local wrong = {}
    for _, path in ipairs(sources) do
      local file = assert(io.open(path))
      local text = file:read "*a":gsub("/%*.-%*/", function(comment) return (comment:gsub("[^\n]", "")) end)
      file:close()
      local n, declared, continued = 0, false, false
      for line in text:gsub("//[^\n]*", ""):gmatch "([^\n]*)\n" do
        n = n + 1
        local header = not continued and line:match '^%s*#%s*include%s*["<]([^">]+)'
        if header and declared and not (path .. header):find "gen/" then
          wrong[#wrong + 1] = ("%s:%d: %s is included after a declaration"):format(path, n, header)
        end
        declared = declared or not continued and line:find "%S" and not line:find "^%s*#" and not line:find '^extern "C"'
        continued = line:find "\\$"
      end
    end
    assert.equal("", table.concat(wrong, "\n"))
  end)

  it("keeps Lua to csrc/lua, VTK to csrc/vtk, and each library to its folder", function()
    local wrong = {}
    ladder.each_include(".", function(path, folder, n, header)
      for _, rule in ipairs(reserved) do
        if header:find(rule[1]) and folder ~= rule[2] and not belongs(ladder.beside(path, header), folder) then
          wrong[#wrong + 1] = ("%s:%d: only csrc/%s includes %s"):format(path, n, rule[2], header)
        end
      end
    end)
    for _, path in ipairs(sources) do
      if not path:find("%.[ch]$") and not path:find("%.inc$") and not path:find("^csrc/vtk/") then
        wrong[#wrong + 1] = path .. ": only csrc/vtk is C++"
      end
    end
    assert.equal("", table.concat(wrong, "\n"))
  end)

  it("has one public header per folder, and those of the table in csrc/README.md", function()
    assert.equal("", table.concat(ladder.headers ".", "\n"))
    assert(known.headers["ylm_gltf.h"] == "codec" and known.headers["ylm_simd.h"] == "base")
  end)

  it("leaves libylm.so with libc, libm and the OpenMP runtime only", function()
    local allowed = { ["linux-vdso"] = true, ["ld-linux-x86-64"] = true, ["ld-linux-aarch64"] = true, libc = true,
      libm = true, libgomp = true, libpthread = true, libdl = true,
      libasan = true, libubsan = true, libgcc_s = true, libstdc = true } -- under the sanitizers
    local out, code = scratch.capture("ldd " .. scratch.quote(build .. "/lib/libylm.so"))
    assert.equal(0, code, out)
    for path in out:gmatch("%s([%w_%-/]+)[%w%.%+]*%.so[%.%d]*") do
      local name = path:match("[^/]+$")
      assert(allowed[name], "libylm.so needs " .. name .. "\n" .. out)
    end
    assert.truthy(out:find "libm%.so")
  end)

  it("keeps what one library needs from the users of another", function()
    local foreign = { codec = { "embree" }, scene = { "OpenEXR", "libpng" } }
    for name, words in pairs(foreign) do
      local path = build .. "/lib/libylm_" .. name .. ".so"
      if not exists(path) then pending(path .. " is not built") end
      local out, code = scratch.capture("ldd " .. scratch.quote(path))
      assert.equal(0, code, out)
      out = out:gsub("=>[^\n]*", "") -- names, not places
      for _, word in ipairs(words) do assert.falsy(out:find(word), path .. " needs " .. word .. "\n" .. out) end
    end
  end)

  it("exports nothing but ylm_* from libylm.so and libylm_rival.so", function()
    if not scratch.shell "command -v nm >/dev/null" then pending "nm is not installed" end
    for _, library in ipairs { "libylm.so", "libylm_rival.so" } do
      for _, line in ipairs(lines_of("nm -D --defined-only " .. scratch.quote(build .. "/lib/" .. library))) do
        local name = line:match("%s[TDBRVWu]%s+(%S+)$")
        assert(not name or name:find "^ylm_" or name:find "^_*asan" or name:find "^__odr", "exported: " .. line)
      end
    end
  end)

  it("leaves libylm_rival.so with libylm, libc and libm only, and libylm.so without its methods", function()
    if not scratch.shell "command -v readelf nm >/dev/null" then pending "binutils are not installed" end
    local allowed = { libylm = true, libc = true, libm = true, ld = true,
      libasan = true, libubsan = true } -- under the sanitizers
    for _, line in ipairs(lines_of("readelf -d " .. scratch.quote(build .. "/lib/libylm_rival.so"))) do
      local name = line:match("%(NEEDED%).*%[(%w+)")
      assert(not name or allowed[name], line)
    end
    local here = {}
    for _, line in ipairs(lines_of("nm --defined-only " .. scratch.quote(build .. "/lib/libylm_rival.so"))) do
      local name = line:match("%s[tTrRdD] (ylm__%S+)$")
      if name then here[name] = true end
    end
    assert(here.ylm__rival_sloan and here.ylm__rival_brute)
    for _, line in ipairs(lines_of("nm --defined-only " .. scratch.quote(build .. "/lib/libylm.so"))) do
      assert(not here[line:match("%s%a (%S+)$")], "in libylm.so too: " .. line)
    end
  end)
end)

describe("csrc/README.md", function()
  it("has a paragraph for every folder, in the order of the ladder", function()
    local file = assert(io.open "csrc/README.md")
    local text, at = file:read "*a", 0
    file:close()
    for _, folder in ipairs(known.folders) do
      local found = text:find("\n**" .. folder .. "**", at + 1, true)
      assert(found, folder .. " is missing, or not where the ladder has it")
      at = found
    end
  end)
end)

describe("the ladder of the Lua half", function()
  --- Module -> path of its file.
  local modules = {}
  for _, path in ipairs(lines_of [[find lua/ylm -name '*.lua']]) do
    modules[(path:match("^lua/(.*)%.lua$"):gsub("/init$", ""):gsub("/", "."))] = path
  end

  --- Step -> its place in the ladder of lua/ylm/README.md, and those between braces with it -> true.
  local function steps()
    local text, place, n = text_of "lua/ylm/README.md":match "\n    ({ check .-)\n\n", {}, 0
    for level in (text .. "<"):gmatch "(.-)<" do
      n = n + 1
      for name in level:gmatch "%w+" do place[name] = n end
    end
    return place
  end

  --- The step of a module: "sh" of "ylm.sh.rotate", "ylm" of "ylm".
  local function step_of(module) return module:match "^ylm%.(%w+)" or "ylm" end

  --- Every module that a file names in a require: a literal; where it requires by a name, each string that is one.
  local function required(path)
    local code, list = ("\n" .. text_of(path)):gsub("%-%-[^\n]*", ""), {}
    for name in code:gmatch "require[%s%(,]*[\"'](ylm[%w_.]*)" do
      if modules[name] then list[name] = true end
    end
    local prefix = code:match "require%s*%(%s*\"(ylm%.[%w_.]*%.)\"%s*%.%." or code:find "require%s*%(%s*[%a_]" and ""
    if prefix then
      for name in code:gmatch "\"([%w_.]+)\"" do
        if modules[prefix .. name] and (prefix ~= "" or name ~= "ylm") then list[prefix .. name] = true end
      end
    end
    return list
  end

  local graph = {}
  for module, path in pairs(modules) do graph[module] = required(path) end

  it("knows every module", function()
    local place = steps()
    for module, path in pairs(modules) do assert(place[step_of(module)], path .. ": not in the ladder of lua/ylm/README.md") end
    for step in pairs(place) do
      local path = step == "ylm" and "lua/ylm" or "lua/ylm/" .. step
      assert(exists(path .. ".lua") or exists(path .. "/."), step .. ": no such file or room of lua/ylm")
    end
  end)

  it("is only gone down, by a require inside a function too", function()
    local place, wrong = steps(), {}
    for module, list in pairs(graph) do
      for other in pairs(list) do
        local from, to = step_of(module), step_of(other)
        if from ~= to and place[to] >= place[from] then
          wrong[#wrong + 1] = ("%s requires %s, which is not below it"):format(modules[module], other)
        end
      end
    end
    table.sort(wrong)
    assert.equal("", table.concat(wrong, "\n"))
  end)

  it("has no circle within a room", function()
    local state = {}
    local function visit(module, path)
      if state[module] == "done" then return end
      path = path .. " > " .. module
      assert(state[module] ~= "open", path)
      state[module] = "open"
      for other in pairs(graph[module]) do visit(other, path) end
      state[module] = "done"
    end
    for module in pairs(graph) do visit(module, "") end
  end)

  it("asks for no module by what is loaded", function()
    for module, path in pairs(modules) do
      assert(module == "ylm.memory" or not text_of(path):find "package%.loaded", path .. ": package.loaded")
    end
  end)
end)

describe("a device", function()
  it("has the methods that lua/ylm/device/init.lua lists, whichever it is", function()
    local listed, found = {}, {}
    for name in text_of "lua/ylm/device/init.lua":gmatch "%-%-     device:([%w_]+)%(" do listed[name] = true end
    for _, path in ipairs { "lua/ylm/device/processor.lua", "lua/ylm/vulkan/device.lua" } do
      found[path] = {}
      for name in text_of(path):gmatch "\nfunction %w+%.([%a][%w_]*)" do found[path][name] = true end
      for name in pairs(listed) do assert(found[path][name], path .. ": no method " .. name) end
    end
    for name in pairs(found["lua/ylm/device/processor.lua"]) do assert(listed[name], name .. " is not listed") end
  end)

  it("is asked by nobody whether it is there", function()
    for _, path in ipairs(lines_of [[find lua/ylm -name '*.lua']]) do
      for line in io.lines(path) do
        assert(not (line:find "if [%w_.]*%.?device then" or line:find "if not [%w_.]*%.?device then"
          or line:find "o%.device and" or line:find "not o%.device"), path .. ": " .. line)
      end
    end
  end)
end)

describe("a binding", function()
  --- The number of arguments between the parentheses that open at byte `i` of `text`.
  local function arguments(text, i)
    local inside, n = text:match("^%b()", i):sub(2, -2), 1
    inside = inside:gsub('"[^"]*"', ""):gsub("%b()", ""):gsub("%b{}", ""):gsub("%b[]", "")
    for _ in inside:gmatch "," do n = n + 1 end
    return n
  end

  it("is called with at most seven positional arguments: more have names, in a table", function()
    local callers = { core = true, lib = true, c = true, vtk = true, binding = true, [")"] = true }
    for _, path in ipairs(lines_of [[find lua/ylm -name '*.lua']]) do
      local text = text_of(path):gsub("%-%-[^\n]*", "")
      for caller, name, at in text:gmatch "([%w_%)]+)%.([%w_]+)()%f[(]" do
        if callers[caller] then
          assert(arguments(text, at) <= 7, ("%s: %s has %d arguments"):format(path, name, arguments(text, at)))
        end
      end
    end
  end)

  it("says of itself that it takes at most seven", function()
    for _, path in ipairs(lines_of [[find csrc/lua -mindepth 2 -name '*.c']]) do
      for comment in text_of(path):gmatch "/%*(.-)%*/" do
        local name, at = comment:match "^[%s*]*([%w_]+)()%("
        if name then assert(arguments(comment, at) <= 7, path .. ": " .. name) end
      end
    end
  end)
end)

describe("the tree", function()
  local files = lines_of "git ls-files 2>/dev/null"
  if #files == 0 then
    files = lines_of "find . -type f -not -path './.git/*' -not -path './build/*' -not -path './out/*'"
  end

  it("names no path of one machine", function()
    local wrong = {}
    for _, path in ipairs(files) do
      local file = not path:find("%.png$") and not path:find("%.exr$") and io.open(path, "rb")
      if file then
        local text = file:read(2 ^ 20) or ""
        file:close()
        for _, word in ipairs { "/wo" .. "rk/", "/ho" .. "me/", "/ro" .. "ot/", "/Us" .. "ers/" } do
          if text:find("[^%w]" .. word) then wrong[#wrong + 1] = path .. ": " .. word end
        end
      end
    end
    assert.equal("", table.concat(wrong, "\n"))
  end)
end)
