-- Pages: what is in the file, read by a second decoder, and what a browser shows of it.

local browser = require "spec.support.browser"
local core = require "ylm.c.core"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local vector = require "ylm.vector"
local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore

local function lacks_parts()
  local parts = " " .. table.concat(ylm.info().parts, " ") .. " "
  return not (parts:find " codec " and parts:find " scene ")
end

local function small(title)
  return ylm.scene(title or "A floor") {
    camera = ylm.camera { from = { 2.2, 1.6, 2.4 }, at = { 0, 0.3, 0 }, fov = 45 },
    geometry = {
      ylm.quad { corner = { -1.5, 0, 1.5 }, u = { 3, 0, 0 }, v = { 0, 0, -3 }, divide = 8,
        material = ylm.matte { albedo = { 0.7, 0.6, 0.5 } } },
      ylm.sphere { at = { 0.2, 0.4, 0 }, radius = 0.4, divide = { 32, 16 }, material = ylm.matte { albedo = 0.8 } },
    },
    lights = { ylm.sphere_light { at = { -0.6, 0.5, 0.5 }, radius = 0.1, radiance = { 14, 11, 8 } },
      ylm.sphere_light { at = { 0.8, 0.9, -0.3 }, radius = 0.08, radiance = { 6, 9, 16 } } },
    probes = ylm.adaptive_grid { lmax = 3, depth = 3, tolerance = 0.05 },
  }
end

--- A room that a wall of one quad parts, but for a gap, and a grid that light jumps in: behind the wall it is a fifth.
local function walled(probes)
  local lamp = ylm.sphere_light { at = { -0.8, 1.2, 0.1 }, radius = 0.15, radiance = { 14, 12, 9 } }
  local scene = ylm.scene "a wall" { camera = ylm.camera { from = { 1.3, 1.3, 0.9 }, at = { -0.2, 0.5, -0.3 }, fov = 60 },
    geometry = { ylm.box { bounds = { { -1.5, 0, -1 }, { 1.5, 1.6, 1 } }, material = ylm.matte { albedo = 0.7 } },
      ylm.quad { corner = { 0.13, 0, -1 }, u = { 0, 1.2, 0 }, v = { 0, 0, 1.4 },
        material = ylm.matte { albedo = { 0.65, 0.2, 0.15 } } } },
    lights = lamp }
  local function field(points, lmax, channels)
    local L, dL, _, report = ylm.light_field(lmax, lamp, points, { derivatives = 1, metric = "luminance",
      channels = channels == 3 and "rgb" or "luminance" })
    local function column(a) return points[{ {}, { a, a } }] end
    local weight = column(1):greater(0.13) * column(2):less(1.2) * column(3):less(0.4) * -0.8 + 1
    local n = #points
    return L * weight:reshape { n, 1, 1 }, dL * weight:reshape { n, 1, 1, 1 }, report.lambda * weight:reshape { n }
  end
  return scene, assert(ylm.bake(probes, field, { quantity = "all", scene = scene, geometry = scene.geometry }))
end

describe("a page", function()
  local folder, scene, grid, path
  local said = ylm.on_warning(false)

  setup(function()
    if lacks_parts() then return end
    folder, scene = scratch.new(), small()
    grid = assert(scene:bake())
    path = folder.path .. "/a.html"
    assert(grid:save(path, { scene = scene, precision = "half", size = { 64, 36 } }))
  end)
  teardown(function()
    ylm.on_warning(said)
    if folder then folder:remove() end
  end)

  local function needs_parts()
    if lacks_parts() then pending "libylm_codec or libylm_scene is not built" end
  end

  it("holds the grid's numbers as halves, and its cells, as a second decoder reads them", function()
    needs_parts()
    local page = require "spec.support.page".read(path)
    local meta, s = page.meta, page.sections
    assert.equal(0, page.left)
    local points, cells = grid:points(), grid:cells { added = true }
    local width, n = 3 * 16, meta.counts.evaluated
    assert.equal(n * width * 4, #s.rows)
    local half = ylm.array({ 0 }, "float16")
    local scale, largest = 2 ^ meta.exponent, 0
    for p = 1, n, 7 do
      for i = 0, width - 1 do
        local c, k = math.floor(i / 16) + 1, i % 16 + 1
        for r = 0, 3 do
          local x = r == 0 and points.value:get(p, c, k) or points.gradient:get(p, c, k, r)
          half[1] = x * scale
          assert.equal(half[1], s.rows[((p - 1) * width + i) * 4 + r + 1])
        end
      end
    end
    for i = 1, #s.rows do largest = math.max(largest, math.abs(s.rows[i])) end
    assert(largest >= 2 ^ 14 and largest <= 2 ^ 15)
    assert.equal(12 * #cells.level, #s.cells)
    for i = 1, #cells.level do
      assert.equal(cells.level[i], s.cells[12 * i - 10] % 256)
      for k = 1, 8 do
        local row = cells.corners:get(i, k)
        assert.equal(row == 0 and 2 ^ 32 - 1 or row - 1, s.cells[12 * i - 8 + k])
      end
    end
    assert(meta.counts.points > n, "the grid has no points of continuity")
  end)

  it("of a grid with sides has the light of grid:sample on both sides of a wall, as a second decoder looks it up", function()
    needs_parts()
    local decoder, other = require "spec.support.page", folder.path .. "/walled.html"
    for _, probes in ipairs { ylm.uniform_grid { cells = { 9, 5, 6 }, lmax = 2 },
      ylm.adaptive_grid { lmax = 1, depth = 4, threshold = 0.3, continuous = false } } do
      local room, lit = walled(probes)
      assert(lit.sides and lit.stats.parts > 100)
      assert(lit:save(other, { scene = room, precision = "float", poster = false }))
      local p, points, normals, width = decoder.read(other), {}, {}, 3 * (lit.lmax + 1) ^ 2
      assert.equal(0, p.left)
      assert.equal(12 * (p.meta.counts.cells + lit.stats.parts), #p.sections.cells)
      for i = 1, 300 do
        local u, v, front = i * 0.618034 % 1, i * 0.754878 % 1, i % 2 == 0 and 1 or -1
        points[i] = i % 3 == 0 and { 3 * u - 1.5, 0, 2 * v - 1 } or { 0.13, 1.2 * u, 1.4 * v - 1 }
        normals[i] = i % 3 == 0 and { 0, 1, 0 } or { front, 0, 0 }
        if i % 7 == 0 then normals[i] = { front * 0.6, 0, 0.8 } end
      end
      local L, near, largest = lit:sample(points, { normals = normals }), 0, 0
      for i = 1, #points do
        local found, nearest = decoder.light(p, points[i], normals[i])
        near = near + (nearest and 1 or 0)
        for k = 1, width do
          local wanted = L:get(i, math.floor((k - 1) / (width / 3)) + 1, (k - 1) % (width / 3) + 1)
          largest = math.max(largest, math.abs(found[k] - wanted) / L:get(i, 1, 1))
        end
      end
      assert(largest < 1e-5, largest)
      if os.getenv "YLM_SAY" then print(lit, largest, near) end
    end
  end)

  it("holds the meshes within 2^-16 of their box, flat ones undivided, and the lamps", function()
    needs_parts()
    local page = require "spec.support.page".read(path)
    local s, m = page.sections, page.meta.mesh
    local ball = scene.geometry[2].mesh
    assert.equal(3 * (2 + #ball), #s.triangles)
    local positions, normals, first = ball:vertices(), ball:normals(), #s.positions / 3 - #ball:vertices()
    for i = 1, #positions do
      local v = { s.normals[2 * (first + i) - 1] / 32767, s.normals[2 * (first + i)] / 32767 }
      v[3] = 1 - math.abs(v[1]) - math.abs(v[2])
      if v[3] < 0 then
        local x, y = v[1], v[2]
        v[1], v[2] = (1 - math.abs(y)) * (x < 0 and -1 or 1), (1 - math.abs(x)) * (y < 0 and -1 or 1)
      end
      local length = math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
      for a = 1, 3 do
        local x = m.lowest[a] + m.step[a] * s.positions[3 * (first + i - 1) + a]
        assert.near(positions:get(i, a), x, 0.51 * m.step[a] + 1e-6)
        assert.near(normals:get(i, a), v[a] / length, 1.2e-4)
      end
    end
    assert.near(0.6, s.albedo[2] / 65535, 1e-5)
    assert.same({ -0.6, 0.5, 0.5, 0.1, 14, 11, 8 }, page.meta.lamps[1])
    assert.equal(grid.stats.points, page.meta.stats.points)
  end)

  it("asks for nothing from elsewhere, and says so in its policy", function()
    needs_parts()
    local text = scratch.text(path)
    assert.truthy(text:find("content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
      .. "img-src data:\"", 1, true))
    text = text:gsub('<script id="data".-</script>', ""):gsub('base64,[%w+/=]*"', '"')
    for _, word in ipairs { "http:", "https:", "import ", "fetch(", "XMLHttp", "WebSocket", "url(" } do
      assert.falsy(text:find(word, 1, true), word)
    end
    for source in text:gmatch 'src="([^"]*)' do assert.truthy(source:find "^data:") end
    assert.falsy(text:find "[\r\239]")
  end)

  it("keeps slopes in bytes within 1/254 of a point's largest, at 0.63 of the size", function()
    needs_parts()
    local other = folder.path .. "/byte.html"
    local ok, report = grid:save(other, { scene = scene, precision = "byte", poster = false })
    assert(ok, report)
    local page, halves = require "spec.support.page".read(other), require "spec.support.page".read(path)
    local s, width = page.sections, 48
    for p = 0, page.meta.counts.evaluated - 1, 11 do
      for i = 0, width - 1 do
        local at = p * width + i
        assert.equal(halves.sections.rows[4 * at + 1], s.values[at + 1])
        for a = 1, 3 do
          local scale = s.scales[3 * p + a]
          local x = s.slopes[3 * at + a] * scale
          assert.near(halves.sections.rows[4 * at + a + 1], x, 0.51 * scale + math.abs(x) * 2 ^ -10 + 1e-6)
        end
      end
    end
  end)

  it("is in few bytes unless it has to be otherwise: a fifth of halves, within the tolerance that is asked for", function()
    needs_parts()
    local decoder, other = require "spec.support.page", folder.path .. "/few.html"
    local ok, report = grid:save(other, { scene = scene, poster = false })
    assert(ok, report)
    local page, halves = decoder.read(other), decoder.read(path)
    assert.equal("few", page.meta.precision)
    assert.equal(0, page.left)
    local light = 0
    for _, name in ipairs { "bases", "tables", "points", "numbers", "bits" } do light = light + report.sections[name] end
    local rows
    for _, section in ipairs(halves.meta.sections) do rows = section.name == "rows" and section.bytes or rows end
    assert(light < 0.2 * rows, light / rows)
    assert(report.few.error > grid.stats.error and report.few.error < 1.6 * grid.stats.error, report.few.error)
    local tolerance = 1.2 * grid.stats.error
    ok, report = grid:save(other, { tolerance = tolerance })
    assert(ok, report)
    assert(report.few.error <= tolerance and report.few.error > 0.9 * tolerance, report.few.error)
    local _, lit = walled(ylm.adaptive_grid { lmax = 1, depth = 3, threshold = 0.3 })
    assert(lit:save(other, { poster = false }))
    page = decoder.read(other)
    assert.equal("few", page.meta.precision)
    assert.is_nil(page.sections.sides) -- the viewer reads them from the octree
  end)

  it("shows titles as text", function()
    needs_parts()
    local other, title = folder.path .. "/title.html", '</script><script>alert(1)</script> "&\226\128\168'
    assert(grid:save(other, { scene = scene, title = title, poster = false }))
    local text = scratch.text(other)
    assert.falsy(text:find("alert(1)</script>", 1, true))
    assert.falsy(text:find("\226\128\168", 1, true))
  end)

  it("is refused, with what to change, where it cannot be; a file of that name stays", function()
    needs_parts()
    local before = scratch.text(path)
    local function refused(words, code, g, options)
      local ok, message, why = g:save(path, options)
      assert.falsy(ok)
      assert.equal(code, why)
      assert.truthy(message:find(words, 1, true), message)
      assert.equal(before, scratch.text(path))
    end
    local high = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 1, lmax = 9 }, scene.lights)
    refused("lmax 9 needs 100 numbers a corner of a cell and channel; bake with lmax <= 8", "ELIMIT", high)
    if long(false, true) then
      local fine = assert(ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 257, lmax = 0 },
        scene.lights, { geometry = ylm.quad { corner = { -0.1, 0.03, 0.1 }, u = { 0.2, 0, 0 }, v = { 0, 0, -0.2 } } }))
      refused("257 x 257 x 257 voxels are too many for a page: at most 2^24", "ELIMIT", fine)
      fine:close()
    end
    refused("MB of light", "ELIMIT", grid, { scene = scene, limit = 1e4 })
    assert.has_error(function() grid:save(path, { scene = 1 }) end)
    assert.has_error(function() grid:save(path, { poster = "x" }) end)
    assert.has_error(function() grid:save(path, { precision = "double" }) end)
    local ok, _, code = grid:save(folder.path .. "/none/a.html", { scene = scene })
    assert(ok == nil and code == "EIO")
    high:close()
    assert.has_error(function() high:save(path) end)
  end)

  it("is what ylm page writes, of a scene and of a grid alone", function()
    needs_parts()
    local file = folder:write("s.lua", [[
      return scene "s" { camera = camera { from = { 0.8, 0.5, 0.9 } }, links = links { spacing = 0.5, rays = 16 },
        geometry = box { scale = 2, material = matte { albedo = 0.1 } },
        lights = sphere_light { at = { 0, 0, 0 }, radius = 0.3 } }]])
    local ylm_tool = (os.getenv "YLM_BUILD" or "build") .. "/ylm"
    local read = require "spec.support.json".read
    local out, status = scratch.capture(("%s page %s --depth 2 --no-poster -o %s -q --json"):format(ylm_tool, file,
      folder.path .. "/s.html"))
    assert.equal(0, status, out)
    local light = read(out).light
    assert(light.bytes > 100 and light.bytes <= 65536 and light.error > 0 and light.seconds > 0, out) -- walls, shadows, bounces
    assert(read(out).sections.probes <= light.bytes)
    out, status = scratch.capture(("%s page %s --depth 2 --no-poster --lamps -o %s -q --json"):format(ylm_tool, file,
      folder.path .. "/s.html"))
    assert.equal(0, status, out)
    assert(not read(out).light and not read(out).sections.probes, out)
    local open = folder:write("open.lua", [[
      return scene "open" { camera = camera { from = { 0, 1, 3 } },
        geometry = quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } },
        lights = sphere_light { at = { 0, 1.5, 0 } } }]])
    out, status = scratch.capture(("%s page %s --depth 2 --no-poster -o %s -q --json"):format(ylm_tool, open,
      folder.path .. "/open.html"))
    assert.equal(0, status, out)
    assert(not read(out).light, out) -- no walls stand around it
    out, status = scratch.capture(("%s page %s --light --lamps -o %s"):format(ylm_tool, open, folder.path .. "/open.html"))
    assert.equal(2, status, out)
    assert.matches("leave one out", out)
    out, status = scratch.capture(("%s page %s -o b.html"):format(ylm_tool, folder:write("b.lua", [[
      return scene "b" { lights = sphere_light { at = { 0, 1.5, 0 } }, probes = adaptive_grid { depth = 3, bricks = 1 } }]])))
    assert.equal(2, status, out)
    assert.matches("probes are in bricks, and a page holds a whole grid: leave bricks out of them", out)
    assert(grid:save(folder.path .. "/g.ylm"))
    out, status = scratch.capture(("%s page %s -o %s -q --json"):format(ylm_tool, folder.path .. "/g.ylm",
      folder.path .. "/g.html"))
    assert.equal(0, status, out)
    assert.equal(0, read(out).triangles)
    assert.is_nil(read(out).light)
    out, status = scratch.capture(("%s page %s -o %s --tolerance 1 -q"):format(ylm_tool, folder.path .. "/g.ylm",
      folder.path .. "/g.html"))
    assert.equal(2, status)
    assert.truthy(out:find("--tolerance is of a bake", 1, true), out)
    out, status = scratch.capture(("%s page g.ylmd -o g.html"):format(ylm_tool))
    assert.equal(2, status)
    assert.truthy(out:find("ylm pack makes a file of it", 1, true), out)
  end)

  describe("in a browser", function()
    local SIZE = { long(128, 640), long(72, 360) }
    local window, shown_file

    setup(function()
      if lacks_parts() or browser.missing() then return end
      window = browser.open { size = SIZE, limit = long(120, 900) }
    end)
    teardown(function() if window then window:close() end end)

    local function needs_browser()
      needs_parts()
      if not window then pending(browser.missing()) end
      window.said = {}
    end

    --- The window's pixels with what stands behind #, as an array; nothing may be said on the console.
    local function seen(file, hash)
      if file == shown_file then window:go("bare&" .. hash) else window:visit(file, "bare&" .. hash) end
      shown_file = file == path and file or nil
      window:wait "ready"
      assert.same({}, window.said)
      return assert(ylm.load(window:screenshot(folder.path .. "/shot.png"), { raw = true })):layer()
    end

    local function psnr(a, b)
      local d = a - b
      return -10 * math.log((d * d):mean()) / math.log(10)
    end

    --- The renderer's picture of light in the scene, with no lamps drawn.
    local function rendered(of, light, tone)
      local dark = ylm.scene "dark" { camera = of.camera, geometry = of.geometry, background = of.background }
      local view = assert(dark:prepare { size = SIZE, samples = 16, visibility = "none" })
      assert((assert(view:render { grid = light, dering = false })):save(folder.path .. "/truth.png", tone))
      return assert(ylm.load(folder.path .. "/truth.png", { raw = true })):layer()
    end

    it("shows the grid as view:render does, 38 dB", function()
      needs_browser()
      local decibels = psnr(seen(path, "nolamps&still"), rendered(scene, grid))
      assert(decibels >= 38, decibels)
    end)

    --- Opens what a file holds without its viewer, which would draw it.
    local function visit_data(file)
      local text, viewers = scratch.text(file):gsub("<script>.-</script>", "")
      assert.equal(1, viewers)
      window:visit(folder:write("data.html", text))
      shown_file = nil
    end

    --- Decodes the page's grid by few.js alone; `words` is what becomes of the sections and `decode`.
    local function by_few(words)
      local functions, sources = require "ylm.page.gen.functions", require "ylm.page.viewer".sources()
      return window:eval("(async () => { const meta = JSON.parse(document.getElementById('meta').textContent), sections = {};\n"
        .. "const INTERPOLATION = meta.sides ? 2 : 0;\n" .. functions.interpolation_js .. "\n" .. sources["few.js"] .. [[
        const raw = atob(document.getElementById('data').textContent.trim());
        let at = 0;
        for (const s of meta.sections) {
          const part = Uint8Array.from(raw.slice(at, at + s.bytes), x => x.charCodeAt(0));
          at += s.bytes;
          if (s.type === 'u8') sections[s.name] = new Uint8Array(await new Response(new Blob([part]).stream().pipeThrough(
            new DecompressionStream('deflate'))).arrayBuffer());
        }
        const decode = changed => decodeFew(meta, Object.assign({}, sections, changed), async () => {});
        ]] .. words .. "})()")
    end

    it("decodes few bytes to the bits of the library's own decoder", function()
      needs_browser()
      local other = folder.path .. "/few.html"
      for _, one in ipairs { { grid }, { ylm.adaptive_grid { lmax = 0, depth = 4, tolerance = 0.05, channels = "luminance" } },
        { ylm.adaptive_grid { lmax = 2, depth = 3, tolerance = 0.1, continuous = false } },
        { ylm.adaptive_grid { lmax = 4, depth = 4, tolerance = 0.1 } },
        { ylm.adaptive_grid { lmax = 1, depth = 3, tolerance = 0.1, measure = "irradiance" } },
        { ylm.uniform_grid { cells = { 5, 4, 3 }, lmax = 2 }, 0.02 },
        { select(2, walled(ylm.adaptive_grid { lmax = 1, depth = 4, threshold = 0.3 })), 0.05 },
        { select(2, walled(ylm.uniform_grid { cells = { 9, 5, 6 }, lmax = 2 })), 0.05 } } do
        local g = one[1].stats and one[1] or assert(scene:bake { probes = one[1] })
        local tolerance = one[2] or 1.3 * g.stats.error
        assert(g:save(other, { tolerance = tolerance }))
        local decoded = assert(core.grid_decode((assert(core.grid_encode_small(g, tolerance, 0, 0, 0)))))
        visit_data(other)
        local rows = core.page_base64((core.page_rows(decoded, 0, "float")))
        local function words(bytes) return "new Uint32Array(read('" .. core.page_base64(bytes) .. "').buffer)" end
        assert.equal("equal", by_few("const read = text => Uint8Array.from(atob(text), x => x.charCodeAt(0)), cells = "
          .. words(core.page_cells(decoded)) .. ", walked = " .. words(core.page_cells(decoded, decoded)) .. ", sides = "
          .. words(core.page_sides(decoded)) .. ", flags = read('" .. core.page_base64(core.page_flags(decoded))
          .. "'), wanted = read('" .. rows .. [[');
          const rows = new Float32Array(wanted.length / 4), per = meta.sides ? 1 : 4;
          const made = await decode({}), n = rows.length / made.layout.points.met / 4;
          for (let i = 0; i < rows.length; i++) {
            const p = Math.floor(i / 4 / n), r = i % 4;
            rows[i] = r < per ? made.data[per * n * p + r * n + Math.floor(i / 4) % n] : 0;
          }
          fewCells(walked, made.layout, made.place);
          if (walked.some((x, i) => x !== cells[i])) return 'other cells';
          const decodedSides = fewSides(made.layout, meta.counts.cells);
          if (decodedSides.length !== sides.length || sides.some((x, i) => x !== decodedSides[i])) return 'other sides';
          if (made.flags.some((x, i) => x !== flags[i])) return 'other flags';
          const got = new Uint8Array(rows.buffer), first = got.findIndex((x, i) => x !== wanted[i]);
          return first < 0 && made.data.length === rows.length / 4 * per ? 'equal' : first / 4 + ' of ' + rows.length;]]))
      end
      assert.same({}, window.said)
    end)

    it("says of damaged few bytes that they are damaged", function()
      needs_browser()
      local other = folder.path .. "/few.html"
      local damage = [[let refused = 0, all = 0, seed = 1;
        const draw = n => { seed = (seed * 16807) % 2147483647; return seed % n; };
        for (const name of ['head', 'tree', 'bases', 'tables', 'points', 'numbers', 'bits', 'frame'])
          for (let i = 0; i < 12; i++) {
            const bytes = sections[name].slice(0, i < 4 ? draw(sections[name].length) : undefined);
            if (i >= 4) bytes[draw(bytes.length)] ^= 1 << draw(8);
            all++;
            try { await decode({ [name]: bytes }); } catch (e) {
              if (!e.message.startsWith('the grid is damaged: ')) return name + ': ' + e.stack;
              refused++;
            }
          }
        return refused + ' of ' + all;]]
      for _, g in ipairs { grid, (select(2, walled(ylm.adaptive_grid { lmax = 1, depth = 3, threshold = 0.3 }))) } do
        assert(g:save(other, { poster = false }))
        visit_data(other)
        local words = by_few(damage)
        local refused, all = words:match "^(%d+) of (%d+)$"
        assert(refused and tonumber(refused) > 0.5 * all, words)
        if os.getenv "YLM_SAY" then print(words) end
      end
    end)

    it("shows a grid in few bytes as view:render does, 38 dB", function()
      needs_browser()
      local other = folder.path .. "/few.html"
      assert(grid:save(other, { scene = scene, poster = false }))
      local decibels = psnr(seen(other, "nolamps&still"), rendered(scene, grid))
      assert(decibels >= 38, decibels)
      if os.getenv "YLM_SAY" then print("few", decibels) end
    end)

    it("has the tone curves and exposures of image:save", function()
      needs_browser()
      if not long(false, true) then pending "make check-long tries all curves" end
      for _, tone in ipairs { "linear", "reinhard", "hable", "aces" } do
        local truth = rendered(scene, grid, { tone = tone, exposure = 1.5 })
        local decibels = psnr(seen(path, "nolamps&still&ev=1.5&tone=" .. tone), truth)
        assert(decibels >= 38, tone .. ": " .. decibels)
      end
    end)

    it("shows the lamps' own light as a grid without error would", function()
      needs_browser()
      local at, radius, radiance = {}, {}, {}
      for i, l in ipairs(scene.lights) do at[i], radius[i], radiance[i] = l.at, l.radius, l.radiance end
      local lights = ylm.sphere_lights { at = at, radius = radius, radiance = radiance }
      local decibels = psnr(seen(path, "mode=exact&nolamps&still"), rendered(scene, lights.lights))
      assert(decibels >= 38, decibels)
    end)

    it("shows modes, edges and lamps that differ, and turns under the pointer", function()
      needs_browser()
      local plain = seen(path, "samples=1")
      local few = { "mode=error", "lines", "lobes" }
      for _, hash in ipairs(long(few, { "mode=estimated", "mode=levels", "nolamps", "ev=1", "tone=aces", unpack(few) })) do
        local other = psnr(plain, seen(path, "samples=1&" .. hash))
        assert(other < 40, hash .. " looks like the grid: " .. other)
      end
      seen(path, "samples=1")
      window:mouse("mousePressed", 60, 40)
      for i = 1, 2 do window:mouse("mouseMoved", 60 + 20 * i, 40 + 5 * i) end
      window:mouse("mouseReleased", 100, 50)
      window:wait "ready"
      local turned = assert(ylm.load(window:screenshot(folder.path .. "/shot.png"), { raw = true })):layer()
      assert(psnr(plain, turned) < 30)
      window:key "Home"
      window:wait "ready"
      local back = assert(ylm.load(window:screenshot(folder.path .. "/shot.png"), { raw = true })):layer()
      assert(psnr(plain, back) > 50)
      assert.same({}, window.said)
    end)

    it("says what colours mean: a legend of errors and levels, whose ends follow the exposure; none of light", function()
      needs_browser()
      local function legend(hash)
        window:visit(path, hash)
        shown_file = nil
        window:wait "ready"
        return window:eval "document.getElementById('legend').hidden ? '' : document.getElementById('legend').textContent"
      end
      assert.equal("", legend "samples=1")
      assert.equal("|grid - lamps|, radiance, shown 100 times brighter00.0050.01", legend "mode=error&samples=1")
      assert.truthy(legend("mode=error&samples=1&ev=1"):find "00%.00250%.005$")
      assert.equal("level of a cell03", legend "mode=levels&samples=1")
      assert.truthy(legend("mode=estimated&samples=1"):find "^estimated error of a cell, logarithmic%d")
      assert.same({}, window.said)
    end)

    it("says that it is loading, before its data are read and until the first picture", function()
      needs_browser()
      local text = scratch.text(path)
      local word = text:find('<div id="note" class="busy">loading ...</div>', 1, true)
      local data = text:find('<script id="data"', 1, true)
      assert(word and word < data, "no word before the data")
      local watched = folder.path .. "/watched.html"
      local file = assert(io.open(watched, "wb"))
      local script = "<script>window.words = []; new MutationObserver(() => { const n = document.getElementById('note'); "
        .. "window.words.push(n.textContent + (n.className === 'busy' ? '!' : '')); }).observe(document.getElementById('note'), "
        .. "{ childList: true, attributes: true });</script>"
      file:write((text:gsub('<script id="data"', function(x) return script .. x end, 1)))
      file:close()
      window:visit(watched, "samples=1")
      shown_file = nil
      window:wait "ready"
      local words = window:eval "window.words.join('|')"
      assert.truthy(words:find("loading: reading the grid ...!|", 1, true), words)
      assert.truthy(words:find("loading: the first picture ...!|", 1, true), words)
      assert.falsy(words:match "[^|]*$":find "loading", words)
      assert.falsy(words:match "[^|]*$":find "!", words)
    end)

    --- The pixel of a place under the scene's camera.
    local function pixel_of(place)
      local c, size = scene.camera, SIZE
      local function minus(a, b) return { a[1] - b[1], a[2] - b[2], a[3] - b[3] } end
      local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end
      local forward = vector.unit(minus(c.at, c.from))
      local right = vector.unit(vector.cross(forward, c.up))
      local up, v, t = vector.cross(right, forward), minus(place, c.from), math.tan(math.rad(c.fov) / 2)
      local far = dot(v, forward) * t
      return size[1] / 2 + dot(v, right) / far * size[2] / 2, size[2] / 2 * (1 - dot(v, up) / far)
    end

    it("follows a lamp that is dragged: the picture of the same cells under moved light, 45 dB", function()
      needs_browser()
      seen(path, "nolamps&still") -- lamps that are not drawn cannot be taken
      window:go "bare&still"
      window:wait "ready"
      local x, y = pixel_of(scene.lights[1].at)
      window:mouse("mousePressed", x, y)
      for i = 1, 3 do window:mouse("mouseMoved", x + 6 * i, y + 3 * i) end
      window:mouse("mouseReleased", x + 18, y + 9)
      window:wait "ready"
      local words = window:eval "document.getElementById('corner').textContent"
      local at = {}
      for number in words:match "^lamp 1 at (.*)$":gmatch "%S+" do at[#at + 1] = tonumber(number) end
      assert(#at == 3 and math.abs(at[1] - scene.lights[1].at[1]) > 0.1, words)
      local moved = ylm.sphere_light { at = at, radius = 0.1, radiance = { 14, 11, 8 } }
      assert(grid:save(folder.path .. "/moved.ylm"))
      local again = assert(ylm.load(folder.path .. "/moved.ylm"))
      assert(again:update { moved, scene.lights[2] })
      window:key "k"
      window:wait "ready"
      local shot = assert(ylm.load(window:screenshot(folder.path .. "/shot.png"), { raw = true })):layer()
      local decibels = psnr(shot, rendered(scene, again))
      assert(decibels >= 45, decibels)
      assert.same({}, window.said)
      shown_file = nil
    end)

    it("says of a surface that is clicked what grid:locate says", function()
      needs_browser()
      seen(path, "samples=1")
      local place = { -0.9, 0, -0.2 }
      local x, y = pixel_of(place)
      window:mouse("mousePressed", x, y)
      window:mouse("mouseReleased", x, y)
      window:wait "ready"
      local words = window:eval "document.getElementById('corner').textContent"
      local hit = {}
      for number in words:match "^at ([^\n]*)":gmatch "%S+" do hit[#hit + 1] = tonumber(number) end
      for a = 1, 3 do assert.near(place[a], hit[a], 2e-3) end
      local cell = grid:locate(hit)
      local index, level = words:match "cell (%d+), level (%d+)"
      assert.equal(cell.index, tonumber(index))
      assert.equal(cell.level, tonumber(level))
      local L = grid:sample { hit }
      assert.near(L:get(1, 1, 1), tonumber(words:match "L00 (%S+)"), 2e-3 * L:get(1, 1, 1))
      local exact = ylm.light_field(3, scene.lights, { hit })
      assert.near(exact:get(1, 1, 1), tonumber(words:match "of the lamps (%S+)"), 1e-3 * exact:get(1, 1, 1))
      local wrong = ylm.sh.relative_error(L:reshape { 1, 48 }, exact:reshape { 1, 48 })[1]
      assert.near(wrong, tonumber(words:match "true error (%S+)"), 1e-3 + 0.1 * wrong)
      assert.same({}, window.said)
    end)

    it("shows and says light on both sides of a wall", function()
      needs_browser()
      local other = folder.path .. "/walled.html"
      local room, lit = walled(ylm.adaptive_grid { lmax = 2, depth = 6, threshold = 0.3 })
      assert(lit:save(other, { scene = room, precision = "float", poster = false }))
      local decibels = psnr(seen(other, "nolamps&still"), rendered(room, lit))
      assert(decibels >= 38, decibels)
      local function click(x, y)
        window:mouse("mousePressed", x, y)
        window:mouse("mouseReleased", x, y)
        window:wait "ready"
        local words = window:eval "document.getElementById('corner').textContent"
        local hit = {}
        for number in words:match "^at ([^\n]*)":gmatch "%S+" do hit[#hit + 1] = tonumber(number) end
        return words, hit, tonumber(words:match "L00 (%S+)")
      end
      for _, from in ipairs { { 1.3, 1 }, { -1.3, -1 } } do
        window:go(("bare&samples=1&from=%g,0.7,-0.3&at=0,0.5,-0.3"):format(from[1]))
        window:wait "ready"
        local words, hit, told = click(SIZE[1] / 2, SIZE[2] / 2)
        assert.near(0.13, hit[1], 1e-4)
        assert.truthy(words:find "part %d+ of %d+")
        local front = lit:sample({ hit }, { normals = { { from[2], 0, 0 } } }):get(1, 1, 1)
        local behind = lit:sample({ hit }, { normals = { { -from[2], 0, 0 } } }):get(1, 1, 1)
        assert.near(front, told, 2e-3 * front)
        assert(math.abs(front - behind) > 0.5 * math.min(front, behind))
      end
      assert.same({}, window.said)
    end)

    it("shows uniform grids, one channel, bytes, light with shadows, cells without a scene, and their title as text", function()
      needs_browser()
      local other = folder.path .. "/other.html"
      local function shown(g, options)
        options.scene, options.poster = scene, false
        assert(g:save(other, options))
        local decibels = psnr(seen(other, "nolamps&still"), rendered(scene, g))
        assert(decibels >= 36, decibels)
      end
      shown(scene:bake { probes = ylm.uniform_grid { cells = { 5, 4, 3 }, lmax = 2, channels = "luminance" } },
        { precision = "byte" })
      if long(false, true) then
        shown(scene:bake { probes = ylm.uniform_grid { cells = { 5, 4, 3 }, lmax = 2 } }, {})
        shown(scene:bake { probes = ylm.adaptive_grid { lmax = 1, depth = 3, channels = "luminance", tolerance = 0.1 } }, {})
        shown(grid, { precision = "byte" })
        shown(grid, { precision = "float" })
        shown(scene:bake { probes = ylm.adaptive_grid { lmax = 8, depth = 3, tolerance = 0.1 } }, { dering = false })
        shown(scene:bake { quantity = "direct", probes = ylm.adaptive_grid { lmax = 3, depth = 4, tolerance = 0.1 } }, {})
      end
      -- a title that would be a script is text
      assert(grid:save(other, { title = "</script><script>alert(1)</script>\226\128\168x" }))
      local cells = seen(other, "samples=1")
      assert(cells:max() > 0.2 and cells:mean() < 0.5)
      assert.truthy(window:eval "document.title":find("</script><script>alert(1)", 1, true))
    end)

    it("says what it lacks where there is no WebGL 2, over its poster", function()
      needs_browser()
      if not long(false, true) then pending "make check-long opens a browser without WebGL" end
      local blind = browser.open { size = { 160, 90 }, switches = "--headless=new --disable-gpu --disable-3d-apis" }
      blind:visit(path)
      local ok, message = pcall(blind.wait, blind, "failed")
      local text = blind:eval "document.getElementById('note').textContent"
      local poster = blind:eval "document.getElementById('poster').naturalWidth"
      local errors = blind.said
      blind:close()
      assert(ok, message)
      assert.truthy(text:find("This page needs WebGL 2", 1, true), text)
      assert.equal(64, poster)
      for _, x in ipairs(errors) do assert.falsy(x:find "exception", x) end
    end)

    it("shows scenes of the collection within their sizes, 38 dB", function()
      needs_browser()
      if not long(false, true) then pending "make check-long shows them" end
      for _, one in ipairs { { "two_lamps", nil, 10e6 }, { "floor_lights", 8, 25e6 } } do
        local s = assert(ylm.load("examples/scenes/" .. one[1] .. ".lua"))
        local g = assert(s:bake { -- the second one's own probes are too many for a page
          probes = one[2] and ylm.adaptive_grid { lmax = 4, depth = one[2], tolerance = 0.05 } })
        local other = folder.path .. "/" .. one[1] .. ".html"
        local ok, report = g:save(other, { scene = s, limit = one[3], poster = false })
        assert(ok, report)
        local decibels = psnr(seen(other, "nolamps&still"), rendered(s, g))
        assert(decibels >= 38, one[1] .. ": " .. decibels)
        if os.getenv "YLM_SAY" then print(one[1], g.stats.points, report.bytes, decibels) end
      end
    end)
  end)
end)
