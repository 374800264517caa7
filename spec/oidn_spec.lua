--- Open Image Denoise, by a stand-in that says what it was asked for (spec/support/oidn.c): the library itself is not in Debian.

local scratch = require "spec.support.scratch"

local lua = os.getenv "YLM_LUA" or "lua5.4"

describe('denoise = "oidn"', function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  --- A stand-in of a version of the interface.
  local function library(flag)
    local path = folder.path .. "/" .. flag .. ".so"
    assert(scratch.shell(("%s -std=gnu11 -shared -fPIC -O1 -Wall -Wextra -Werror -DSTAND_IN_BOOL=%s spec/support/oidn.c -o %s")
      :format(os.getenv "CC" or "cc", flag, scratch.quote(path))))
    return path
  end

  --- The text that a script about `scene` prints, with this library.
  local function run(path, text, more)
    local script = folder:write("run.lua", [[
      local ylm = require "ylm"
      ylm.on_warning(false)
      local scene = ylm.scene "a lamp" { camera = ylm.camera { from = { 0, 3, 4 } },
        geometry = { ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 },
          material = ylm.matte { albedo = { 0.2, 0.5, 0.75 } } } },
        lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.3, radiance = 50 } } }
      local o = { size = { 32, 18 }, samples = 4, denoise = "oidn", light_samples = 4, rays = 8 }
      ]] .. text)
    return (scratch.capture(("env %s YLM_OIDN_LIBRARY=%s %s %s 2>&1"):format(more or "", scratch.quote(path), lua,
      scratch.quote(script))))
  end

  it("filters the finished picture by albedo and normals, by either version's names, and keeps it as the layer raw", function()
    for _, flag in ipairs { "oidnSetFilterBool", "oidnSetFilter1b" } do
      local says = run(library(flag), [[
        local image, report = assert(scene:render(o))
        local want = image:layer "raw" + image:layer "albedo" * 2 + image:layer "normal" * 4
        print((image:layer "radiance" - want):abs():max() < 1e-4, image:layer("raw"):max() > 0, report.noise > 0,
          image.metadata.denoise, report.denoise)
        o.denoise = "auto"
        print((image:layer "raw" - scene:render(o):layer "raw"):abs():max() == 0)
        o.denoise, o.layers, o.light_samples, o.rays, o.samples = "oidn", false, nil, nil, nil
        image, report = assert(scene:render(o))
        print((image:layer "radiance" - image:layer "raw"):abs():max(), report.ended)]])
      assert.truthy(says:find "^true%s+true%s+true%s+oidn%s+nil%s+true%s+0%.?0?%s+noise", flag .. ": " .. says)
    end
  end)

  it("says what the library says", function()
    local says = run(library "oidnSetFilterBool", "print(scene:render(o))", "STAND_IN_FAILS=1")
    assert.truthy(says:find "^nil%s+.*Open Image Denoise: no memory for the network%s+EDEVICE", says)
  end)

  it("is refused by name before any ray is traced where the library is missing, or another one", function()
    local says = run(folder.path .. "/none.so", "o.size = { 4096, 4096 } print(scene:render(o))")
    assert.truthy(says:find "^nil%s+.*Open Image Denoise is not installed: .*none%.so cannot be opened.*EMISSING", says)
    says = run("libm.so.6", "print(scene:render(o))")
    assert.truthy(says:find "libm%.so%.6 is no Open Image Denoise%s+EMISSING", says)
  end)
end)
