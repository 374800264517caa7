-- Lightmaps in browsers: ylm's own page, and three.js. YLM_NODE_MODULES=DIR names a folder with npm's three.

local browser = require "spec.support.browser"
local scratch = require "spec.support.scratch"
local three = require "spec.support.three_page"
local three_lightmap = require "spec.support.three_lightmap"
local ylm = require "ylm"

local ALBEDO = 0.5

local function room()
  return ylm.scene "a box" { geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = ALBEDO } },
    ylm.box { bounds = { { -0.5, -1, -0.4 }, { 0.1, -0.4, 0.3 } }, material = ylm.matte { albedo = ALBEDO } } },
    camera = ylm.camera { from = { 0, 0.9, 0.001 }, at = { 0, -1, 0 }, fov = 60 },
    lights = ylm.sphere_light { at = { 0.4, 0.3, 0.2 }, radius = 0.05, radiance = 100 },
    links = ylm.links { spacing = 0.2, rays = 32 } }
end

local function encoded(x)
  x = math.max(0, math.min(1, x))
  return 255 * (x <= 0.0031308 and 12.92 * x or 1.055 * x ^ (1 / 2.4) - 0.055)
end

describe("a lightmap in a browser", function()
  local folder, light
  setup(function()
    folder, light = scratch.new(), room():lightmap { texels = 2048, rays = 8, light_samples = 4 }
  end)
  teardown(function() folder:remove() end)

  it("is shown by its page as look-ups have it, within 2 of 255, and its charts", function()
    if browser.missing() then return pending(browser.missing()) end
    local W, H = 120, 100
    local _, facts = assert(light:save(folder.path .. "/room.html", { exposure = -1 }))
    assert.same({ "room.html" }, facts.files)
    local window = assert(browser.open { size = { W, H } })
    window:visit(folder.path .. "/room.html", "mode=white&bare")
    window:wait "ready"
    local pixels = window:eval [[(() => {
      const gl = document.getElementById('canvas').getContext('webgl2'), out = new Uint8Array(4 * 120 * 100);
      gl.readPixels(0, 0, 120, 100, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return Array.from(out).join(' '); })()]]
    local list, worst, up = {}, 0, math.tan(math.rad(30))
    for x in pixels:gmatch "%d+" do list[#list + 1] = tonumber(x) end
    for row = 5, 95, 9 do
      for column = 25, 95, 7 do
        -- Right of the picture is x, its top -z. The floor is 1.9 below the camera; pixels of the block are left out.
        local x, z = ((column + 0.5) / H - 0.5 * W / H) * 2 * up * 1.9, (0.5 - (row + 0.5) / H) * 2 * up * 1.9
        if math.abs(x) < 0.98 and math.abs(z) < 0.98 and not (x > -0.9 and x < 0.4 and z > -0.8 and z < 0.7) then
          local E = light:irradiance({ { x, -1, z } }, { { 0, 1, 0 } })
          local shown = list[4 * (row * W + column) + 1]
          worst = math.max(worst, math.abs(encoded(E:get(1, 1) / math.pi / 2) - shown))
        end
      end
    end
    assert.is_true(worst > 0 and worst <= 2, worst)
    window:go "mode=charts&bare"
    window:wait "ready"
    assert.equal(0, #window.said, window.said[1])
    window:close()
  end)

  it("lights three.js within 2 of 255 at 200 places, by .exr, .ktx2, and .png inside of the file", function()
    if not three.there() then return pending "YLM_NODE_MODULES with three, and chromium, are wanted" end
    local places, points, normals = {}, {}, {}
    for i = 1, 200 do
      local axis, side = i % 3 + 1, i % 2 * 2 - 1
      local p, n = { 1.9 * (i * 0.8191725 % 1) - 0.95, 1.9 * (i * 0.6710436 % 1) - 0.95, 1.9 * (i * 0.5497004 % 1) - 0.95 },
        { 0, 0, 0 }
      p[axis], n[axis] = side, -side
      if p[2] == -1 and p[1] > -0.55 and p[1] < 0.15 then p[1] = 0.7 end
      places[i], points[i], normals[i] = { p, n }, p, n
    end
    local E = light:irradiance(points, normals)
    for _, options in ipairs { { picture = "exr" }, { picture = "ktx2" }, { embed = true } } do
      assert(light:save(folder.path .. "/room.glb", options))
      local found, worst = three_lightmap.radiance(folder, "room.glb", options.picture and "room." .. options.picture, places), 0
      assert.equal(200, #found)
      for i, rgb in ipairs(found) do
        for c = 1, 3 do
          worst = math.max(worst, math.abs(encoded(rgb[c]) - encoded(ALBEDO / math.pi * E:get(i, c))))
        end
      end
      if os.getenv "YLM_SAY" then print(worst) end
      assert.is_true(worst > 0 and worst <= 2, worst)
    end
  end)
end)
