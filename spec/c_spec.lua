-- The C library as others use it: installed, found by pkg-config and by CMake, compiled as C11 and as C++17.

local core = require "ylm.c.core"
local long = require "spec.support.long"
local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local build = os.getenv "YLM_BUILD" or "build"
local usual = build == "build" or build == scratch.capture "pwd":gsub("%s+$", "") .. "/build" -- sanitizers' are not installed
local strict = "-Wall -Wextra -Wpedantic -Werror "
local languages = { "cc -x c -std=c11 ", "c++ -x c++ -std=c++17 " }

local function text_of(path)
  local file = assert(io.open(path))
  local text = file:read "*a"
  file:close()
  return text
end

describe("the C library", function()
  local folder, root

  local function runs(command, ...)
    command = command:format(...)
    local out, code = scratch.capture(command)
    assert(code == 0, command .. "\n" .. out)
    return out
  end

  --- Skips where a program is not installed; a build with sanitizers is not what is shipped.
  local function needs(program)
    if not usual then pending "only of the usual build" end
    if not scratch.shell("command -v " .. program .. " >/dev/null") then pending(program .. " is not installed") end
  end

  local function has(part) return scratch.shell("test -e " .. root .. "/lib/libylm_" .. part .. ".so") end

  --- The environment of who uses what was installed.
  local function env(words)
    return ("env PKG_CONFIG_PATH=%s/lib/pkgconfig LD_LIBRARY_PATH=%s/lib YLM_THREADS=1 %s "):format(root, root, words or "")
  end

  setup(function()
    folder = scratch.new()
    root = scratch.quote(folder.path .. "/dest/opt/ylm") -- not where it says that it is
    if usual then
      runs("env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s install LUAS= PREFIX=/opt/ylm DESTDIR=%s",
        scratch.quote(folder.path .. "/dest"))
    end
  end)
  teardown(function() folder:remove() end)

  --- Compiles an example by pkg-config in one of the languages; the path of the program. `how` goes to pkg-config and cc.
  local function compiled(name, package, language, how)
    local program = folder.path .. "/" .. name
    local libs = ("$(pkg-config --cflags --libs %s %s) -lm"):format(how or "", package)
    runs("%s sh -c %s", env(), scratch.quote(("%s%s %s examples/c/%s.c -x none %s -o %s"):format(language, strict,
      how and "-static" or "", name, libs, scratch.quote(program))))
    return scratch.quote(program)
  end

  it("has one version: headers, library, pkg-config, changes", function()
    local header, number = text_of "csrc/base/ylm_version.h", {}
    for name in ("MAJOR MINOR PATCH"):gmatch "%a+" do
      number[#number + 1] = header:match("#define YLM_VERSION_" .. name .. " (%d+)\n")
    end
    local version = table.concat(number, ".")
    assert.equal(version, text_of "csrc/base/ylm_base.h":match '#define YLM_VERSION "([^"]+)"')
    assert.equal(version, text_of "CHANGELOG.md":match "\n## (%S+)[,\n]")
    assert.equal(version, ylm.info().version)
    needs "pkg-config"
    assert.equal(version .. "\n", runs("%s pkg-config --modversion ylm", env()))
    local out = runs("%s %s %s/x.ylm", env(), compiled("bake", "ylm", languages[1]), scratch.quote(folder.path))
    assert.equal("ylm " .. version .. ", compiled for " .. version, out:match "^[^\n]*")
  end)

  it("has libraries with a version: libylm.so -> libylm.so.0 -> libylm.so.0.1.0", function()
    needs "readelf"
    local version = ylm.info().version
    for name in runs("cd %s/lib && ls *.so", root):gmatch "%S+" do
      local major = name .. "." .. version:match "^%d+"
      assert.equal(major .. "\n", runs("readlink %s/lib/%s", root, name))
      assert.equal(name .. "." .. version .. "\n", runs("readlink %s/lib/%s", root, major))
      local facts = runs("readelf -d %s/lib/%s", root, name)
      assert.truthy(facts:find("soname: [" .. major .. "]", 1, true), facts)
      for needed in facts:gmatch "%(NEEDED%)[^\n]*%[(libylm[^%]]*)%]" do assert.truthy(needed:find "%.so%.%d+$", needed) end
    end
  end)

  it("has public headers alone, without warnings: each by itself as C11, all (make check-long: each) as C++17", function()
    if not usual then pending "only of the usual build" end
    local named = {} -- in the table of libraries
    for cells in text_of "docs/c.md":gmatch "\n| `ylm[%w_]*` | `ylm::%w+` | ([^|]*)|" do
      for word in cells:gmatch "`([^`]*)`" do named[#named + 1] = "^" .. word:match "_([%w_*]+)":gsub("%*", ".*") .. "$" end
    end
    for header in runs("cd %s/include/ylm && ls", root):gmatch "ylm_([%w_]+)%.h" do
      local public = false
      for _, pattern in ipairs(named) do public = public or header:find(pattern) ~= nil end
      assert(public and not header:find "_device$" and not header:find "_rival$", header .. ": installed, but not in docs/c.md")
    end
    runs("cd %s/include/ylm && %s%s -fsyntax-only *.h", root, languages[1], strict)
    needs "c++"
    if long(false, true) then runs("cd %s/include/ylm && %s%s -fsyntax-only *.h", root, languages[2], strict)
    else runs("cd %s/include/ylm && printf '#include \"%%s\"\\n' *.h | %s%s -fsyntax-only -I. -", root, languages[2], strict) end
  end)

  for i, language in ipairs(languages) do
    it("bakes lights, samples and saves by pkg-config: " .. language, function()
      needs(language:match "%S+")
      needs "pkg-config"
      local program, file = compiled("bake", "ylm", language), folder.path .. i .. "/lamps.ylm"
      local out, code = scratch.capture(env() .. program .. " " .. scratch.quote(file)) -- no such folder
      assert.equal(1, code)
      assert.truthy(out:find "bake: [^\n]*lamps%.ylm: cannot be created", out)
      file = folder.path .. "/lamps.ylm"
      out = runs("%s %s %s", env(), program, scratch.quote(file))
      local n = 0
      for error in out:gmatch "relative error (%S+)" do
        n = n + 1
        assert(tonumber(error) < 0.01, out)
      end
      assert.equal(3, n)
      local grid = assert(ylm.load(file))
      assert.equal(tonumber(out:match "(%d+) probes"), grid.stats.points)
      local red = grid:sample({ 0.3, 0.1, -0.2 }):get(1, 1)
      assert.equal(out:match "red L00 (%S+),", ("%.5f"):format(red))
    end)
  end

  --- Compiles spec/support/NAME.c with scenes; the path of the program.
  local function support(name)
    needs "pkg-config"
    if not has "scene" then pending "only with Embree" end
    local program = scratch.quote(folder.path .. "/" .. name)
    runs("%s sh -c %s", env(), scratch.quote(("%s%s spec/support/%s.c -x none $(pkg-config --cflags --libs %s) -lm -o %s")
      :format(languages[1], strict, name, "ylm ylm_scene", program)))
    return program
  end

  it("finds surfaces at many places with the bits of surfaces one by one, by every kernel", function()
    local program = support "surfaces"
    for _, isa in ipairs(ylm.info().kernels) do
      assert.equal("4099 places, 0 differ, the first is 0\n", runs("%s %s", env("YLM_ISA=" .. isa), program), isa)
    end
  end)

  it("weighs few lamps at many places with the bits of one place after the other, guides too, by every kernel", function()
    local program = support "ahead"
    for _, isa in ipairs(ylm.info().kernels) do
      local out = runs("%s %s", env("YLM_ISA=" .. isa), program)
      local line = ": 3999 places, (%d+) dark, 0 differ, the first is 0\n"
      local dark, guided, clusters = out:match("^no guide" .. line .. "a guide" .. line .. "(%d+) clusters, 0 differ\n$")
      assert(dark and tonumber(dark) < 1000 and dark == guided, isa .. ": " .. out)
      assert(tonumber(clusters) > 500, isa .. ": " .. out)
    end
  end)

  it("tells rays that meet few lamps as it tells them among many", function()
    local out, scenes = runs("%s %s", env(), support "looks"), 0
    for met, differ in out:gmatch "90000 rays, (%d+) meet lamps, (%d+) differ\n" do
      scenes = scenes + 1
      assert.equal("0", differ, out)
      assert(tonumber(met) > 30000 and tonumber(met) < 60000, out)
    end
    assert.equal(3, scenes, out)
  end)

  it("refuses numbers that it once took, in sentences: counts, words, NaN", function()
    needs "pkg-config"
    local program = folder.path .. "/numbers"
    local rays = has "scene"
    local more, defined = { rays and "scene", has "vtk" and "vtk" }, ""
    local packages = "ylm"
    for _, part in pairs(more) do
      if part then packages, defined = packages .. " ylm_" .. part, defined .. " -D" .. part:upper() end
    end
    runs("%s sh -c %s", env(), scratch.quote(("%s%s -D_GNU_SOURCE %s spec/support/numbers.c -x none $(pkg-config --cflags --libs "
      .. "%s) -lm -o %s"):format(languages[1], strict, defined, packages, scratch.quote(program))))
    local said = {}
    local out = runs("%s timeout %d %s", env(), patience(20), scratch.quote(program))
    for name, result, sentence in out:gmatch "([^\t\n]+)\t([^\t]*)\t([^\n]*)\n" do
      said[name] = result .. (sentence ~= "" and ": " .. sentence or "")
    end
    local wanted = rays and {
      ["picture of no rows"] = "EINVAL: a picture has at least one pixel, got 4 x 0",
      ["camera far away"] = "EINVAL: the camera's from must be within 1e+15 of the scene, got 1e+300",
      ["background of no number"] = "ERANGE: the background must be finite",
      ["probe far away"] = "ERANGE: point 1 is beyond 1e+15",
      ["links from nowhere"] = "EDOMAIN: origin 1 is not finite",
      ["receiver from nowhere"] = "EDOMAIN: receiver 1 is not finite",
      ["lamp of two corners"] = "ERANGE: lamp 1: a polygon has 3 corners or more",
      ["lamp nowhere"] = "EDOMAIN: lamp 1: at must be finite",
      ["lamp of infinite power"] = "EDOMAIN: lamp 1: power must be finite",
      ["lamp of no shape"] = "EINVAL: lamp 1: shape 77 is not known",
      ["lamps that are not there"] = "EINVAL: lamp is NULL",
      ["links of a long normal"] = "EDOMAIN: normal 1 is not finite, or longer than 1",
      ["bounces 2^31 - 1"] = "ERANGE: bounces must be at most 1000000, got 2147483647",
      ["gutter 2^31 - 1"] = "ERANGE: gutter: 0 to 64 texels, got 2147483647" } or {}
    for name, text in pairs(has "vtk" and {
      ["png of no columns"] = "ERANGE: a canvas of 0 x 4 pixels: sides are 1 .. 32768",
      ["plot of many samples"] = "ERANGE: a plot: supersample is 1 .. 4, not 1048576",
      ["picture of -1 columns"] = "ERANGE: a picture of -1 x 4 pixels: sides are 1 .. 32768",
      ["view of -1 columns"] = "ERANGE: a picture of -1 x 4 pixels: sides are 1 .. 32768",
      ["shape of a point beyond"] = "EINVAL: cell 1 of a shape names point 8 of 3",
      ["shape of corners -3"] = "EINVAL: a shape of -3 corners a cell: 2 or 3 expected" } or {}) do wanted[name] = text end
    for name, text in pairs {
      ["texture of zeros"] = "ERANGE: an image of 0 x 0 texels: sides are 1 to 65536, texels 4194304 at most",
      ["texture of many texels"] = "ERANGE: an image of 9223372036854775808 x 2 texels: sides are 1 to 65536, texels 4194304 "
        .. "at most",
      ["texture of no number"] = "EDOMAIN: texel 2 of row 1 is not finite",
      ["texture of parts"] = "EDOMAIN: a texture's tolerance must be >= 0, its largest part above 0, at most 1, its scale "
        .. "finite; got 0, nan and 1",
      ["origin of no number"] = "EDOMAIN: the origin of points is not finite",
      ["origin far away"] = "ERANGE: the origin of points is beyond 1e+15",
      ["sphere without a direction"] = "0",
      ["probes of lmax 65537"] = "ERANGE: probes have lmax 1 or 2, and leaves 0 to 3 cuts; got 65537 and 0",
      ["probes of cuts -1"] = "ERANGE: probes have lmax 1 or 2, and leaves 0 to 3 cuts; got 1 and -1",
      ["probes of 255 bits"] = "ERANGE: bits of a number are 6 to 16, got 255",
      ["derivatives -2"] = "ERANGE: derivatives must be 0 or 3, got -2",
      ["array of type 9"] = "ETYPE: none.npy: no element type has the number 9",
      ["kind 99"] = "EINVAL", ["name of kind -1"] = "?", ["failures of many"] = "1",
      ["creases"] = "OK", ["normals"] = "1", ["canvas"] = "1" } do wanted[name] = text end
    assert.same(wanted, said)
  end)

  for _, language in ipairs(languages) do
    it("evaluates harmonics, linked by pkg-config: " .. language, function()
      needs(language:match "%S+")
      needs "pkg-config"
      local program = compiled("harmonics", "ylm", language)
      local out = runs("%s %s 1 2 2", env(), program)
      local y, dy = ylm.sh.eval(2, { 1, 2, 2 }, { derivatives = 1 })
      local rows = 0
      for l, m, value, x, _, z in out:gmatch "(%d) +(%-?%d) +(%S+) +(%S+) +(%S+) +(%S+)\n" do
        rows = rows + 1
        local k = ylm.sh.index(tonumber(l), tonumber(m))
        assert.near(y:get(k), tonumber(value), 1e-9)
        assert.near(dy:get(k, 1), tonumber(x), 1e-9)
        assert.near(dy:get(k, 3), tonumber(z), 1e-9)
      end
      assert.equal(9, rows)
      assert.truthy(out:find("(lmax + 1)^2: 1.000000000000\n", 1, true), out)
      local text, code = scratch.capture(env() .. program .. " 0 0 0")
      assert.equal(1, code)
      assert.matches("^harmonics: ", text)
    end)
  end

  it("links the core without shared libraries, by pkg-config --static: the same numbers", function()
    needs "pkg-config"
    local shared = runs("%s %s 1 2 2", env(), compiled("harmonics", "ylm", languages[1]))
    local program = compiled("harmonics", "ylm", languages[1], "--static")
    assert.equal(shared, runs("env -u LD_LIBRARY_PATH %s 1 2 2", program))
    needs "readelf"
    assert.falsy(runs("readelf -d %s", program):find "NEEDED")
    local bake = compiled("bake", "ylm", languages[1], "--static")
    assert.truthy(runs("YLM_THREADS=2 %s %s/static.ylm", bake, scratch.quote(folder.path)):find "%d+ probes")
  end)

  describe("of an environment image", function()
    local image, file

    setup(function()
      image, file = ylm.image { size = { 32, 16 }, layers = { { "radiance", 3 } } }, folder.path .. "/sky.pfm"
      local texels = {}
      for i = 1, 32 * 16 * 3 do texels[i] = (i * 7 % 11) / 8 end
      core.array_fill(image:layer(), texels)
    end)

    --- Are the rows that it prints the image's coefficients and those of its irradiance?
    local function prints(out)
      local c, rows = ylm.sh.project(2, image, { up = "y" }), 0
      local cosine = { [0] = math.pi, 2 * math.pi / 3, math.pi / 4 }
      for row in out:gmatch "[^\n]+" do
        local n, k = {}, 0
        for word in row:gmatch "%S+" do n[#n + 1] = tonumber(word) end
        rows = rows + 1
        for ch = 1, 3 do
          k = k + math.abs(n[2 + ch] - c:get(ch, rows)) + math.abs(n[5 + ch] - cosine[n[1]] * c:get(ch, rows))
        end
        assert(k < 1e-7, row)
      end
      assert.equal(9, rows)
    end

    for _, language in ipairs(languages) do
      it("prints the coefficients by pkg-config: " .. language, function()
        needs(language:match "%S+")
        needs "pkg-config"
        if not has "codec" then pending "libylm_codec is not built" end
        assert(image:save(file))
        local program = compiled("sky", "ylm_codec", language)
        prints(runs("%s %s %s", env(), program, scratch.quote(file)))
        local out, code = scratch.capture(env() .. program .. " README.md")
        assert.equal(1, code)
        assert.truthy(out:find "^sky: README%.md: ", out)
      end)
    end

    it("and of lights by find_package in CMake", function()
      needs "cmake"
      local at = scratch.quote(folder.path .. "/cmake")
      runs("cmake -S examples/c -B %s -DCMAKE_PREFIX_PATH=%s -DCMAKE_C_FLAGS='%s' && cmake --build %s", at, root, strict, at)
      assert.truthy(runs("YLM_THREADS=1 %s/bake %s/lamps.ylm", at, at):find "%d+ probes")
      assert.truthy(runs("%s/harmonics 1 2 2", at):find "1%.000000000000\n")
      if not has "codec" then pending "libylm_codec is not built" end
      assert(image:save(file))
      prints(runs("%s/sky %s", at, scratch.quote(file)))
    end)

    it("and of lights is clean under valgrind", function()
      if not long(false, true) then pending "make check-long" end
      needs "valgrind"
      local valgrind = env "valgrind -q --leak-check=full --errors-for-leak-kinds=definite,indirect,possible --error-exitcode=9"
      runs("%s %s %s/v.ylm", valgrind, compiled("bake", "ylm", languages[1]), scratch.quote(folder.path))
      if not has "codec" then pending "libylm_codec is not built" end
      assert(image:save(file))
      local sky = compiled("sky", "ylm_codec", languages[1])
      runs("%s %s %s", valgrind, sky, scratch.quote(file))
      local _, code = scratch.capture(valgrind .. sky .. " README.md")
      assert.equal(1, code)
    end)
  end)

  it("says which part CMake does not find", function()
    needs "cmake"
    folder:write("CMakeLists.txt", "cmake_minimum_required(VERSION 3.16)\nproject(x NONE)\n"
      .. "find_package(ylm 0.1 REQUIRED COMPONENTS nothing)\n")
    local at = scratch.quote(folder.path)
    local out, code = scratch.capture(("cd %s && cmake -B none -DCMAKE_PREFIX_PATH=%s ."):format(at, root))
    assert.equal(1, code)
    assert.truthy(out:find "libylm_nothing%.so%s+is%s+not%s+in", out)
  end)
end)
