-- The code generator: what stands in the tree is what it makes, and what it makes is right.

local codegen = require "ylm.codegen.main"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local source = require "ylm.codegen.source"
local targets = require "ylm.codegen.targets"
local ylm = require "ylm"

local quote, capture = scratch.quote, scratch.capture

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

local read = scratch.text

--- Compiles C with a main that prints numbers, runs it, and returns them in a list.
local function run_c(folder, name, text, optimise)
  local program = folder.path .. "/" .. name
  local cc = os.getenv("CC") or "cc"
  local out, status = capture(cc .. " -std=gnu11 -Wall -Wextra -Werror " .. (optimise or "-O1")
    .. " -Wno-unused-function -o " .. quote(program) .. " " .. quote(folder:write(name .. ".c", text)) .. " -lm")
  assert(status == 0, out)
  out, status = capture(quote(program))
  assert(status == 0, out)
  local numbers = {}
  for word in out:gmatch("%S+") do numbers[#numbers + 1] = tonumber(word) end
  return numbers
end

--- All outputs of a generated C function at each of the vectors, in the order Y, dY, ddY; a list for each vector.
local function evaluate_all_c(folder, request, vectors, optimise)
  local count, k = (request.lmax + 1) ^ 2, request.derivatives
  local outs, calls, sizes = { "Y", "dY", "ddY" }, {}, { 1, 3, 6 }
  for _, v in ipairs(vectors) do
    local d = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
    local unit = not request.solid
    local arguments = {}
    for i = 1, 3 do arguments[i] = ("%.17g"):format(unit and v[i] / d or v[i]) end
    if request.stable then
      local z = v[3] / d
      arguments[#arguments + 1] = z < 0 and "-1" or "1"
      arguments[#arguments + 1] = ("%.17g"):format(1 - math.abs(z))
    end
    if unit and not request.unit and request.method ~= "scd" and k > 0 then
      arguments[#arguments + 1] = ("%.17g"):format(1 / d)
    end
    for i = 1, k + 1 do arguments[#arguments + 1] = outs[i] end
    calls[#calls + 1] = ("%s(%s);"):format(request.name, table.concat(arguments, ", "))
    for i = 1, k + 1 do
      calls[#calls + 1] = ("for (int i = 0; i < %d; i++) printf(\"%%.17g\\n\", %s[i]);"):format(count * sizes[i], outs[i])
    end
  end
  local main = ("int main(void) {\n  double Y[%d], dY[%d], ddY[%d];\n  (void)dY, (void)ddY;\n  %s\n}\n")
    :format(count, 3 * count, 6 * count, table.concat(calls, "\n  "))
  local numbers = run_c(folder, ("f_%d_%d"):format(request.lmax, k),
    "#include <stdio.h>\n" .. source.file({ request }, "c") .. main, optimise)
  local lists, each = {}, #numbers / #vectors
  for i in ipairs(vectors) do
    lists[i] = {}
    for n = 1, each do lists[i][n] = numbers[(i - 1) * each + n] end
  end
  return lists
end

--- The outputs at one vector.
local function evaluate_c(folder, request, v) return evaluate_all_c(folder, request, { v })[1] end

--- Results of the library's reference kernel.
local function evaluate_ylm(request, v)
  local flat = {}
  for k, a in ipairs { ylm.sh.eval(request.lmax, v, { derivatives = request.derivatives, solid = request.solid,
    kernel = "reference" }) } do
    a = a:reshape({ (request.lmax + 1) ^ 2 * ({ 1, 3, 6 })[k] })
    for _, x in ipairs(a:totable()) do flat[#flat + 1] = x end
  end
  return flat
end

local function assert_same(got, wanted, bound)
  assert.equals(#wanted, #got)
  for i = 1, #wanted do assert.is_near(wanted[i], got[i], bound, "output " .. i) end
end

describe("ylm.codegen", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  describe("the tree's generated files", function()
    for _, target in ipairs(targets) do
      it("are what the generator makes: " .. target[1], function()
        assert(read(target[1]) == codegen.generate(target), target[1] .. " is stale: run make gen")
      end)
    end

    it("include every file in a gen folder", function()
      local known = {}
      for _, target in ipairs(targets) do known[target[1]] = true end
      local out = capture("ls csrc/*/gen/* csrc/*/*/gen/* shaders/gen/* lua/ylm/*/gen/* 2>/dev/null; true")
      for path in out:gmatch("%S+") do assert(known[path], path .. " is not in lua/ylm/codegen/targets.lua") end
    end)

    -- make gen-check, which spec/style_spec.lua runs, takes Lua 5.4
    it("are the same under every other Lua that is installed, and (make check-long) Lua 5.3", function()
      for _, lua in ipairs(long({ "lua5.1", "luajit" }, { "lua5.1", "luajit", "lua5.3", "lua5.4" })) do
        if has(lua) and lua ~= os.getenv "YLM_LUA" then
          local out, status = capture("LUA_PATH='lua/?.lua;lua/?/init.lua' " .. lua
            .. " lua/ylm/codegen/command.lua --check")
          assert(status == 0, lua .. ": " .. out)
        end
      end
    end)

    describe("of interpolation", function()
      local expression, interpolation = require "ylm.codegen.expression", require "ylm.codegen.interpolation"

      --- The number that a node stands for, with variables from a table.
      local function number(n, at)
        if n.op == "constant" then return n.value end
        if n.op == "variable" then return at[n.name] end
        local a, b = number(n.a, at), n.b and number(n.b, at)
        if n.op == "negate" then return -a end
        if n.op == "+" then return a + b end
        if n.op == "-" then return a - b end
        return n.op == "*" and a * b or a / b
      end

      it("have the slopes of the values that they come with", function()
        local h, edge = 1e-5, 0.7
        for _, kind in ipairs(interpolation.kinds) do
          local v, d = interpolation.values(expression.graph(), kind), interpolation.slopes(expression.graph(), kind)
          for _, which in ipairs { "l", "s", "k" } do
            for e = 1, 2 do
              for _, t in ipairs { 0, 0.2, 0.5, 0.9, 1 } do
                local up, down = number(v[which][e], { t = t + h, edge = edge }), number(v[which][e], { t = t - h, edge = edge })
                assert.near((up - down) / (2 * h * edge), number(d[which][e], { t = t, rate = 1 / edge }), 1e-8)
              end
            end
          end
        end
      end)

      it("reproduce cubics by Hermite's, what is linear by all", function()
        local edge = 0.7
        for _, kind in ipairs(interpolation.kinds) do
          local v = interpolation.values(expression.graph(), kind)
          for power = 0, kind == "hermite" and 3 or 1 do
            for _, t in ipairs { 0, 0.3, 0.8, 1 } do
              local at = { t = t, edge = edge }
              local function f(which, e) return number(v[which][e], at) end
              local slope = kind == "linear" and 0 or power / edge -- at the far end; at the near end only of t
              local sum = (power == 0 and f("l", 1) + f("s", 1) or 0) + f("l", 2) + f("s", 2) + f("k", 2) * slope
                + (power == 1 and kind ~= "linear" and f("k", 1) / edge or 0)
              assert.near(power == 0 and 1 or t ^ power, sum, 1e-14)
            end
          end
        end
      end)
    end)

    describe("of functions that C and GLSL have in common", function()
      local common = require "ylm.codegen.common"

      it("differ in types, constants and precisions alone", function()
        local list = { { about = "Half.", text = [[
real f(vector x, floats y, uint k) {
  exact real a = #0.5 * ABS(x[0]);
  FINE
  return a;
  COARSE
  return ROOT(a);
  END
}]] } }
        local constants = { { "WIDTH", 255, "of it" } }
        local function of(name) return (common.text(name, "x", {}, list, constants):gsub("^.-%*/\n", "")) end
        assert.equal("const uint WIDTH = 0xff; /* of it */\n\n/* Half. */\nreal f(rvec3 x, vec3 y, uint k) {\n"
          .. "  precise real a = REAL(0.5lf) * abs(x[0]);\n#ifdef YLM_DOUBLE\n  return a;\n#else\n  return sqrt(a);\n"
          .. "#endif\n}\n", of "shader")
        local c = of "c"
        assert(c:find("enum {\n  YLM_GPU_WIDTH = 0xff, /* of it */\n};", 1, true), c)
        assert(c:find("static inline double f(const double x[3], const float y[3], uint32_t k) {\n"
          .. "  double a = 0.5 * fabs(x[0]);\n  return a;\n}", 1, true), c)
        local written = { { about = "Twice.", text = "void g(inout real x) {\n  @x = #2.0 * @x;\n}" } }
        assert(common.text("shader", "x", {}, written):find("void g(inout real x) {\n  x = REAL(2.0lf) * x;\n}", 1, true))
        assert(common.text("c", "x", {}, written):find("static inline void g(double *x) {\n  *x = 2.0 * *x;\n}", 1, true))
        assert(common.text("kernel", "x", {}, written):find("YLM_INLINE void g(vreal *x) {\n  *x = (real)2.0 * *x;\n}", 1, true))
        list = { list[1] }
        assert(common.text("double_shader", "x", {}, list):find("precise double a = 0.5lf * abs(x[0]);\n  return a;", 1, true))
      end)

      it("say what they should: surfaces that touch boxes, metrics, pixels on a disc", function()
        local numbers = run_c(folder, "common", [[
#include <stdio.h>
#include "csrc/light/flat/gen/crossing.h"
#include "csrc/grid/gen/cells.h"
#include "csrc/shade/gen/picture.h"
int main(void) {
  const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1}, c[3] = {2, 0.5, 0.5}, inside[3] = {0.5, 0.5, 0.5};
  double middle[3], reach[3];
  for (int a = 0; a < 3; a++) middle[a] = box_middle(lo[a], hi[a]), reach[a] = box_reach(lo[a], hi[a]);
  printf("%d %d %d %d\n", sphere_meets(c, 1, lo, hi), sphere_meets(c, 0.999, lo, hi), sphere_meets(inside, 0.8, lo, hi),
         sphere_meets(inside, 0.9, lo, hi));
  printf("%d %d %d\n", sphere_meets_wide(c, 1 - 1e-15, middle, reach), sphere_meets_wide(c, 0.999, middle, reach),
         sphere_meets_wide(inside, 0.9, middle, reach));
  printf("%g %g %g %g\n", point_ratio(0, 0, true), point_ratio(3, 2, true), point_ratio(3, 2, false),
         cell_metric(6, 2, 4, 0.5));
  printf("%g %g %g\n", lattice_coordinate(0.5, 0, 2, 4, 8), lattice_coordinate(3, 0, 2, 4, 8),
         lattice_coordinate(NAN, 0, 2, 4, 8));
  printf("%u %g\n", octant_of(2, 1, 3, 1), relative_distance(0, 0));
  const double u[3] = {0, 0, -1}, to[3] = {0, 0, -1};
  printf("%g %g\n", disc_share(u, to, 0.1, 0.01), disc_share(u, to, 0.001, 0.01));
}
]], "-O1 -I.")
        assert.same({ 1, 0, 1, 0, 1, 0, 0, 0, 1.5, 3, 6, 2, 8, 0, 5, 0, 1, 0.024 }, numbers)
      end)
    end)

    it("bear no dates and no absolute paths", function()
      for _, target in ipairs(targets) do
        local text = read(target[1])
        assert(text:find("GENERATED by", 1, true) and not text:find("20%d%d%-%d%d") and not text:find('"/'), target[1])
      end
    end)
  end)

  describe("generated C", function()
    local v = { 0.3, -1.1, 0.7 }
    for _, request in ipairs {
      { lmax = 0, derivatives = 2 }, { lmax = 1, derivatives = 2 }, { lmax = 4, derivatives = 0 },
      { lmax = 4, derivatives = 1 }, { lmax = 4, derivatives = 2 }, { lmax = 10, derivatives = 2 },
      { lmax = 6, derivatives = 2, solid = true }, { lmax = 8, derivatives = 2, stable = true },
    } do
      local name = ("lmax %d, %d derivatives%s%s"):format(request.lmax, request.derivatives,
        request.solid and ", solid" or "", request.stable and ", stable" or "")
      it("compiles without a warning and agrees with the reference kernel: " .. name, function()
        request.name = "f"
        assert_same(evaluate_c(folder, request, v), evaluate_ylm(request, v), 1e-12)
      end)
    end

    it("agrees at unit length with fewer operations (unit), and by the other method (scd)", function()
      local u = { 0.48, -0.6, 0.64 }
      local unit = { lmax = 5, derivatives = 2, unit = true, name = "f" }
      local full = { lmax = 5, derivatives = 2, name = "f" }
      assert_same(evaluate_c(folder, unit, u), evaluate_ylm(unit, u), 1e-12)
      assert(source.count(unit).total < source.count(full).total)
      local scd = { lmax = 5, derivatives = 2, method = "scd", name = "f" }
      assert_same(evaluate_c(folder, scd, u), evaluate_ylm(scd, u), 1e-11)
    end)

    it("agrees at high degrees, where functions are long: lmax 32 with gradients, 60" .. long("", ", 150"), function()
      local vectors = { { 0.3, -1.1, 0.7 }, { 0.001, 0.002, -1 } }
      for lmax, derivatives in pairs { [32] = 1, [60] = 0, [150] = long(nil, 0) } do
        local request = { lmax = lmax, derivatives = derivatives, name = "f" }
        for i, numbers in ipairs(evaluate_all_c(folder, request, vectors, "-O0")) do
          assert_same(numbers, evaluate_ylm(request, vectors[i]), 1e-11)
        end
      end
    end)

    it("is exact at the poles", function()
      local request, poles = { lmax = 6, derivatives = 2, name = "f" }, { { 0, 0, 2 }, { 0, 0, -2 } }
      for i, numbers in ipairs(evaluate_all_c(folder, request, poles)) do
        assert_same(numbers, evaluate_ylm(request, poles[i]), 1e-12)
      end
    end)
  end)

  describe("generated GLSL", function()
    it("compiles for Vulkan 1.2 as an include, for values, gradients, Hessians and solid harmonics", function()
      if not has "glslc" then return pending "glslc is not installed" end
      for _, request in ipairs {
        { lmax = 0, derivatives = 2, name = "f" }, { lmax = 4, derivatives = 2, name = "f" },
        { lmax = 8, derivatives = 0, name = "f" }, { lmax = 3, derivatives = 1, solid = true, name = "f" },
      } do
        folder:write("f.glsl", source.file({ request }, "glsl"))
        local count, arrays, uses = (request.lmax + 1) ^ 2, { "Y", "dY", "ddY" }, {}
        local declared, names = {}, {}
        for k = 1, request.derivatives + 1 do
          local n = ("%d"):format(count * ({ 1, 3, 6 })[k])
          declared[k] = ("float %s[%s];"):format(arrays[k], n)
          names[k] = arrays[k]
          uses[k] = ("for (int i = 0; i < %s; i++) sum += %s[i];"):format(n, arrays[k])
        end
        local main = folder:write("f.comp", table.concat({
          "#version 450", "#extension GL_GOOGLE_include_directive : require", '#include "f.glsl"',
          "layout(local_size_x = 64) in;",
          "layout(binding = 0) buffer Data { vec4 data[]; };",
          "void main() {", table.concat(declared, " "), "float sum = 0.0; uint k = gl_GlobalInvocationID.x;",
          "f(data[k].xyz, " .. table.concat(names, ", ") .. ");", table.concat(uses, "\n"), "data[k].w = sum; }", "",
        }, "\n"))
        local out, status = capture("glslc --target-env=vulkan1.2 -O -Werror " .. quote(main) .. " -o "
          .. quote(folder.path .. "/f.spv"))
        assert(status == 0, out)
      end
    end)
  end)

  describe("operation counts", function()
    it("stand in the banner", function()
      local c = source.count { lmax = 4, derivatives = 2 }
      local text = source.file({ { lmax = 4, derivatives = 2 } }, "c")
      assert(text:find(("degrees 0 .. 4: %d additions, %d multiplications"):format(c.adds, c.muls), 1, true))
    end)

    it("are at lmax 4 less than those of spherical-coordinate derivatives by at least the paper's 1.46", function()
      local ours = source.count { lmax = 4, derivatives = 2, unit = true }
      local scd = source.count { lmax = 4, derivatives = 2, unit = true, method = "scd" }
      assert(scd.total / ours.total >= 1.46, ("%d / %d"):format(scd.total, ours.total))
    end)

    it("count what the emitted C does", function()
      local text = source.file({ { lmax = 3, derivatives = 1 } }, "c"):match("{\n(.*)}")
      local _, muls = text:gsub(" %* ", "")
      local _, adds = text:gsub(" [+-] ", "")
      local c = source.count { lmax = 3, derivatives = 1 }
      assert.equals(c.muls, muls)
      assert.equals(c.adds, adds)
    end)
  end)

  describe("the command", function()
    local function command(arguments)
      return capture("LUA_PATH='lua/?.lua;lua/?/init.lua' " .. (os.getenv("YLM_LUA") or "lua5.4")
        .. " lua/ylm/codegen/command.lua " .. arguments)
    end

    it("prints C and GLSL, counts, and writes files", function()
      local c = command "--lmax 2 --derivatives 1 --language c"
      assert(c:find("void ylm_sh_2_1(YLM_T x", 1, true))
      assert(command("--lmax 2 --language glsl"):find("void ylm_sh_2_0(vec3 v, out float Y[9])", 1, true))
      assert(command("--count --lmax 4"):find("SCD/ours", 1, true))
      local path = folder.path .. "/out.h"
      local _, status = command("--lmax 2 --derivatives 1 -o " .. quote(path))
      assert.equals(0, status)
      assert.equals(c, read(path))
    end)

    it("refuses what it does not know, with exit code 2", function()
      for arguments, says in pairs {
        ["--lmax -1"] = "%-%-lmax must be", ["--lmax 151"] = "from 0 to 150",
        ["--lmax 101 --language glsl"] = "from 0 to 100 for glsl",
        ["--count --lmax 31"] = "from 0 to 30 with %-%-count", ["--lmax x"] = "must be",
        [""] = "lmax is missing", ["--lmax"] = "wants a value", ["--lmx 4"] = "unknown option %-%-lmx",
        ["--lmax 4 --language rust"] = "cannot be 'rust'",
        ["--lmax 4 --derivatives 3"] = "cannot be '3'", ["--lmax 4 --name 4x"] = "identifier",
        ["--lmax 4 --method scd --solid"] = "without %-%-solid",
      } do
        local out, status = command(arguments)
        assert.equals(2, status)
        assert(out:find(says), arguments .. ": " .. out)
      end
      local _, status = command "--lmax 1 -o /nonexistent/folder/x.h"
      assert.equals(1, status)
    end)
  end)
end)
