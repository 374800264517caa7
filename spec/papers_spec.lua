-- The examples about the papers' tables and figures run, in their quick form, and print what they should.

local long = require "spec.support.long"
local scratch = require "spec.support.scratch"

local cases = {
  { "products_2021_fig3.lua", "--out %s --quick", " 20 .*%(21%.7%)" },
  { "products_2021_fig4.lua", "--out %s --quick", "k = 8: 7 factors" },
  { "products_2021_table1.lua", "--groups 5", "paper +0%.87 +0%.88" },
  { "products_2021_table2.lua", "--quick", "Lucy +%d+ +5 +ylm .*Teapot +%d+ +7 +list.*Spider & Scorpion +300 +4 +8 +probes" },
  { "products_2021_fig9.lua", "--out %s --quick", " 4 +accurate .* 4 +one rule, probes .*SHEXP, HYB" },
  { "shexp_2006.lua", "--quick", "%-1%.314 %-1%.951 .*knot +64 +5 +SHEXP, HYB" },
  { "products_2021_fig5.lua", "--out %s --quick", "accurate product is nearer .* of 8 cases" },
  { "products_2021_fig6.lua", "--out %s --quick", "in place of Lucy +5 +2 " },
  { "gradient_2022_table1.lua", "--quick", "sloan, paper +67%.5" },
  { "gradient_2022_fig5.lua", "--out %s --quick", "light's gradient: .* at most [%d.]+e%-" },
  { "gradient_2022_triangles.lua", "--out %s --quick", "by shape" },
  { "hessian_2025_table1.lua", "--count 20", "lmax .*SCD.*\n  16 " },
  { "hessian_2025_fig3.lua", "--out %s --n 12", "∂²/∂z² of L%(7, 2%)" },
  { "hessian_2025_fig10.lua", "--out %s --depth 4 --samples 1 --width 48 --height 36", "divides MAPE by" },
  { "gritty_2003_transfer.lua", "--out %s --quick", "all bounces is %d%d%.%d dB .*\n  3  .*%%\n" },
  { "gritty_2003_local.lua", "--out %s --quick", "32 samples, power 10 .*adaptive grid, tolerance 0.1" },
  { "gradient_2022_table4.lua", "--out %s --quick", "ZH / interp.*Table 4: .*%d+%.%d+ .*3 bands" },
  { "gradient_2022_table3.lua", "--out %s --quick --threads 1", "Dragon +578 +here .*Buddha +242 +here .*gradients cost" },
  { "gradient_2022_table5.lua", "--quick --threads 1", "speed%-up .*\n +5 .*interpolation grows" },
  { "gradient_2022_fig8.lua", "--out %s --quick", "gloss: b %- a %% .*\n +5 .*Why they differ" },
  { "gradient_2022_fig10.lua", "--out %s --quick --threads 1", "zonal .*\n +8 .*\n +18 .*a grid is %d" },
  { "gradient_2022_fig11.lua", "--out %s --quick", "satin_gold +stand%-in, not measured.*MAE x 1000 of the grid" },
  { "hvl_2022_table1.lua", "--quick --threads 1", "400 +9 +[%d.]+ +0%.220 .*9 over 5 bands" },
  { "hvl_2022_fig6.lua", "--out %s --quick",
    "\n +5 +26 +25 +22 +10 .*Eq%. 14 has fewer operations than the polynomials from 5 bands" },
  { "hvl_2022_fig8.lua", "--out %s --quick", "footprint +%d+ .* 1%.00 .*lit pixels" },
  { "hvl_2022_table2.lua", "--out %s --quick", "10b +VPL .*10a +HVL +%d+ .*28%.01" },
  { "hvl_2022_fig1.lua", "--out %s --quick", "harmonics, 5 bands .*points, clamped" },
  { "hvl_2022_fig9.lua", "--out %s --quick", "table_room +metals .*the paper: no difference" },
  { "hvl_2022_fig12.lua", "--out %s --quick", "spherical Gaussians +25 .*harmonics, zonal +25 .*order: zonal" },
  { "hvl_profiles.lua", "--out %s --quick", "gauss, k = 1 .*gauss, 0%.6 r to 2 r" },
  { "hvl_split.lua", "--out %s --quick", "floor, far part: irradiance +%d%.%d" },
  { "hvl_methods.lua", "--out %s --quick", "harmonics, gauss +16 .*\npaths +%- .*order with 16 lights" },
  { "hvl_tolerance.lua", "--out %s --quick", "far +irradiance +0%.100 .*pairs of all" },
  { "hvl_many.lua", "--out %s --quick", "\n +1,000 .*time over lights grows" },
  { "hvl_links.lua", "--quick", "standing +links, 16 .*lamp moves +virtual, 50 .*floor glosses +virtual, rays, 50" },
  { "hvl_furnace.lua", "--quick", "points, cosines exact +%-?0%.0000 +0%.0000.*rho/%(1 %- rho%) is 1%.5000" },
  { "hvl_2022_materials.lua", "--out %s --quick", "90 full rows .* 27%.0 .*teflon +ABC fit.*materials change" },
}

--- Pictures of what products_2021_fig9.lua runs, with other bodies.
if long(false, true) then
  cases[#cases + 1] = { "products_2021_fig7.lua", "--out %s --quick",
    "Spider & Scorpion +2 +one rule .*Ball & DNA +4 +SHEXP, HYB" }
  cases[#cases + 1] = { "products_2021_fig8.lua", "--out %s --quick", "Dragon in Hall +4 +spheres as unions .*SHEXP, PS%-9" }
end

describe("examples/papers", function()
  for _, case in ipairs(cases) do
    it("runs " .. case[1], function()
      local folder = scratch.new()
      local out, status = scratch.capture(("%s examples/papers/%s %s"):format(os.getenv "YLM_LUA" or "lua5.4", case[1],
        case[2]:format(scratch.quote(folder.path))))
      folder:remove()
      assert.equal(0, status, out)
      assert(out:find(case[3]), out)
    end)
  end

  it("take --help, and --out where they write nothing", function()
    local folder = scratch.new()
    folder:write("script.lua", 'print(dofile "examples/common.lua".options({ count = 3 }).count)')
    local command = (os.getenv "YLM_LUA" or "lua5.4") .. " " .. scratch.quote(folder.path .. "/script.lua")
    local out, status = scratch.capture(command .. " --help")
    assert.same({ 0, true }, { status, out:find("usage: .*script.lua %[%-%-count 3%]") ~= nil })
    assert.same({ "--out: this script prints its results, and writes no file\n5\n", 0 },
      { scratch.capture(command .. " --out x --count 5") })
    assert.is_true(select(2, scratch.capture(command .. " --nothing 2>&1")) ~= 0)
    folder:remove()
  end)

  it("take a scene of one's own, or say why they do not", function()
    local folder = scratch.new()
    local file = scratch.quote(folder:write("own.lua", [[
      return scene "own" { camera = camera { from = { 0.9, 0, 0 }, at = { -1, 0, 0 }, fov = 50 },
        geometry = { box { scale = 2 }, sphere { at = { 0, -0.5, 0 }, radius = 0.3, material = ggx { alpha = 0.3, f0 = 0.6 } } },
        lights = sphere_light { at = { 0.1, 0.8, 0 }, radius = 0.05, radiance = 100 } }
    ]]))
    local function run(name, more)
      return scratch.capture(("%s examples/papers/hvl_%s.lua --quick --scene %s %s 2>&1"):format(os.getenv "YLM_LUA" or "lua5.4",
        name, file, more or ""))
    end
    for _, name in ipairs(long({ "furnace", "2022_fig6" }, { "furnace", "split", "profiles", "2022_fig6", "2022_materials" })) do
      local out, status = run(name)
      assert.equal(1, status)
      assert.matches("%-%-scene: %l", out)
    end
    local out_option = "--out " .. scratch.quote(folder.path)
    for name, says in pairs(long({ ["2022_fig9"] = "metals" }, { ["2022_fig9"] = "metals", ["2022_fig1"] = "harmonics",
      ["2022_fig12"] = "order: zonal", ["2022_table2"] = "10a", many = "\n +1,000", methods = "order with",
      tolerance = "pairs of all" })) do
      local out, status = run(name, out_option)
      assert.equal(0, status, out)
      assert(out:find(says), out)
    end
    folder:remove()
  end)

  local office = long(false, true) and it or function() end -- its rooms have light that bounces
  office("runs 18_office.lua, a small one", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/18_office.lua --out %s --width 128 --samples 1 --paths 32"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    assert.equal(0, status, out)
    for _, name in ipairs { "Panel 600", "Linear 1200", "Downlight 60" } do
      local lamps, lumens = out:match(name .. " +(%d+) +(%d+)")
      assert.is_true(tonumber(lamps) > 3 and tonumber(lumens) > 10000, out)
    end
    for _, name in ipairs { "panel.ies", "linear.ldt", "downlight.ies" } do assert.truthy(folder:read(name), name) end
    folder:remove()
  end)

  it("runs 05_lobes.lua, which prints Green's Fig. 9", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/05_lobes.lua --out %s --width 320 --samples 20000"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    folder:remove()
    assert.equal(0, status, out)
    assert(out:find("two lights, projected by quadrature", 1, true) and out:find("........#................", 1, true), out)
  end)

  for _, words in ipairs(long({ "--only texture" }, { "" })) do
    it("runs 15_ideas.lua --quick " .. words .. ", the figures of docs", function()
      local folder = scratch.new()
      local out, status = scratch.capture(("%s examples/15_ideas.lua --out %s --quick %s"):format(
        os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path), words))
      folder:remove()
      assert.equal(0, status, out)
      assert(out:find "texture: 4096 texels, 1038 parts", out)
    end)
  end

  for _, words in ipairs(long({ "--only lobes" }, { "" })) do
    it("runs 17_shadow_fields.lua --quick " .. words, function()
      local folder = scratch.new()
      local out, status = scratch.capture(("%s examples/17_shadow_fields.lua --out %s --quick %s"):format(
        os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path), words))
      folder:remove()
      assert.equal(0, status, out)
      assert(out:find "x =  0.00: 90.8 %% of all directions are open", out)
      assert(words ~= "" or out:find "balls +5 +SHEXP, PS%-9.*grid, tolerance .*least voxel", out)
    end)
  end

  local bounces = long(false, true) and it or function() end -- a bake of gathered light takes a while
  bounces("runs 12_bouncing_light.lua, a small one", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/12_bouncing_light.lua --out %s --width 64 --samples 16 "
      .. "--tolerance 0.5"):format(os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    folder:remove()
    assert.equal(0, status, out)
    assert(out:find "indirect light: %d+ probes" and out:find "and light gathered along links", out)
  end)

  for _, part in ipairs(long({ "bounce", "methods" }, { "bounce", "methods", "corner", "grids", "lobes", "moving" })) do
    it("runs 13_virtual_lights.lua, a small one: " .. part, function()
      local folder = scratch.new()
      local out, status = scratch.capture(("%s examples/13_virtual_lights.lua --out %s --only %s --width 12 --samples 2 "
        .. "--lights 40 --few 8"):format(os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path), part))
      folder:remove()
      assert.equal(0, status, out)
      assert(out:find "virtual_lights[%l_]*.png" or out:find "no picture", out)
    end)
  end

  it("runs 08_glossy.lua, a small one", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/08_glossy.lua --out %s --width 100 --samples 4 --rays 16 --quick"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    folder:remove()
    assert.equal(0, status, out)
    assert(out:find "slices, lmax 4" and out:find "\nsh, lmax 4 " and out:find "points by rays, 16 light samples", out)
  end)

  it("runs 06_many_lights.lua, a small one", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/06_many_lights.lua --out %s --count 2000 --most 1000"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    folder:remove()
    assert.equal(0, status, out)
    assert(out:find "2,000 lamps, lmax 4, rgb" and out:find "\n1,000 ", out)
  end)

  --- Runs examples/04_moving_lights.lua, a small one, with further options.
  local function moving(options)
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/04_moving_lights.lua --out %s --width 64 --height 48 --samples 1 "
      .. "--rays 1 --tolerance 0.05 %s"):format(os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path), options))
    local sheet = io.open(folder.path .. "/moving.png", "rb")
    if sheet then sheet:close() end
    folder:remove()
    assert.equal(0, status, out)
    assert(sheet, out)
    assert(out:find("frames per second", 1, true), out)
  end

  it("runs 04_moving_lights.lua, a small one", function() moving "--frames 3 --depth 6" end)

  it("runs 10_moving_shadows.lua, a small one", function()
    local folder = scratch.new()
    local out, status = scratch.capture(("%s examples/10_moving_shadows.lua --quick --truth --out %s"):format(
      os.getenv "YLM_LUA" or "lua5.4", scratch.quote(folder.path)))
    local sheet = io.open(folder.path .. "/shadows.png", "rb")
    if sheet then sheet:close() end
    folder:remove()
    assert.equal(0, status, out)
    assert(sheet and out:find("frames a second", 1, true), out)
    assert(out:find("beside rays, 256 a point: rms [%d.]+ %% of the mean"), out)
  end)

  it("runs 04_moving_lights.lua on a device", function()
    local device, missing = require "spec.support.gpu".choose()
    if not device then pending("no Vulkan device: " .. missing) end
    moving("--frames 2 --depth 3 --device " .. device)
  end)
end)
