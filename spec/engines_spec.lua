-- Grids as engines read them: files by bytes, and by the engines' own code where it is installed.
--
-- YLM_NODE_MODULES=DIR names a folder with npm's `three` (0.187 or later) and `ktx-parse`; rendering needs Chromium too.

local browser_page = require "spec.support.three_page"
local reader = require "spec.support.engine_reader"
local scratch = require "spec.support.scratch"
local blocks = require "spec.support.blocks"
local pictures = require "spec.support.pictures"
local ylm = require "ylm"

local modules = os.getenv "YLM_NODE_MODULES"

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

local function integer(text, at, bytes)
  local x = 0
  for i = bytes, 1, -1 do x = x * 256 + text:byte(at + i - 1) end
  return x
end

describe("grid:export", function()
  local folder, grid
  setup(function()
    folder = scratch.new()
    local lamps = { ylm.sphere_light { at = { 0, 2.2, 0 }, radius = 0.2, radiance = { 60, 40, 20 } },
      ylm.sphere_light { at = { 2.5, 1, 2 }, radius = 0.2, radiance = { 10, 20, 40 } } }
    grid = ylm.bake(ylm.adaptive_grid { depth = 4, tolerance = 0.02, bounds = { { -1, -0.5, -1.5 }, { 1, 0.5, 1.5 } } }, lamps)
  end)
  teardown(function() folder:remove() end)

  --- Another interpolation along the axes than the exporter's: rows [nz][ny][nx] of numbers, at p.
  local function interpolated(rows, cells, p)
    local at, part = {}, {}
    for a = 1, 3 do
      local lo, hi = grid.bounds[1][a], grid.bounds[2][a]
      local x = math.max(0, math.min(cells[a] - 1, (p[a] - lo) / (hi - lo) * cells[a] - 0.5))
      at[a] = math.min(cells[a] - 2, math.floor(x))
      part[a] = x - at[a]
    end
    local sum = {}
    for corner = 0, 7 do
      local w, place = 1, {}
      for a = 1, 3 do
        local up = math.floor(corner / 2 ^ (a - 1)) % 2
        w, place[a] = w * (up == 1 and part[a] or 1 - part[a]), at[a] + up + 1
      end
      for c, list in ipairs(rows[place[3]][place[2]][place[1]]) do
        for k, v in ipairs(list) do sum[9 * (c - 1) + k] = (sum[9 * (c - 1) + k] or 0) + w * v end
      end
    end
    return sum
  end

  it("chooses the coarsest cells of a tolerance, and reports the error that another interpolation has", function()
    local points = {}
    for i = 1, 2000 do
      points[i] = { -1 + 2 * (i * 0.8191725 % 1), -0.5 + i * 0.6710436 % 1, -1.5 + 3 * (i * 0.5497004 % 1) }
    end
    local path = folder.path .. "/a.npy"
    local report = assert(grid:export(path, { tolerance = 0.03, points = ylm.array(points, "float"), dtype = "float" }))
    assert(report.met and report.error <= 0.03 and report.probes == report.cells[1] * report.cells[2] * report.cells[3])
    local rows = ylm.load(path)
    assert.same({ report.cells[3], report.cells[2], report.cells[1], 3, 9 }, rows.shape)
    rows = rows:totable()
    local truth, errors = grid:sample(points):totable(), {}
    for i, p in ipairs(points) do
      local got, off, norm = interpolated(rows, report.cells, p), 0, 0
      for c = 1, 3 do
        for k = 1, 9 do
          off = off + (got[9 * (c - 1) + k] - truth[i][c][k]) ^ 2
          norm = norm + truth[i][c][k] ^ 2
        end
      end
      errors[i] = math.sqrt(off / norm)
    end
    table.sort(errors)
    local found = errors[1980]
    assert(math.abs(found / report.error - 1) < 0.05, found .. " " .. report.error)
    local longest = math.max(report.cells[1], report.cells[2], report.cells[3])
    local n = longest - 1
    local coarser = assert(grid:export(path, { points = ylm.array(points, "float"),
      cells = { math.floor(2 * n / 3 + 0.5), math.floor(n / 3 + 0.5), n } }))
    assert(coarser.error > 0.03, coarser.error)
  end)

  it("writes ambient cubes whose faces are irradiance over pi", function()
    local path = folder.path .. "/a.ktx2"
    local report = assert(grid:export(path, { cells = { 4, 3, 5 } }))
    local text = folder:read "a.ktx2"
    assert.equal("\171KTX 20\187\r\n\26\n", text:sub(1, 12))
    assert.same({ 97, 2, 4, 6, 15, 0, 1, 1, 0 }, (function()
      local list = {}
      for i = 0, 8 do list[i + 1] = integer(text, 13 + 4 * i, 4) end
      return list
    end)())
    local at, size = integer(text, 81, 8), integer(text, 89, 8)
    assert(at % 8 == 0 and size == 8 * 4 * 6 * 15 and #text == at + size and report.bytes == #text)
    -- The probe at 3, 2, 4: its faces, by a sum over directions (Fibonacci's) of what the coefficients are.
    local n, directions = 20000, {}
    for i = 1, n do
      local z, phi = 1 - (2 * i - 1) / n, i * math.pi * (3 - math.sqrt(5))
      local r = math.sqrt(1 - z * z)
      directions[i] = { r * math.cos(phi), r * math.sin(phi), z }
    end
    local p = { -1 + 2 * 2.5 / 4, -0.5 + 1.5 / 3, -1.5 + 3 * 3.5 / 5 }
    local radiance = ylm.sh.reconstruct(grid:sample(p), directions):totable()
    for axis = 1, 3 do
      for side = 0, 1 do
        for channel = 1, 3 do
          local sum = 0
          for i, d in ipairs(directions) do
            sum = sum + radiance[channel][i] * math.max(0, (1 - 2 * side) * d[axis])
          end
          local x, y, z = 2, 1 + 3 * side, 3 + 5 * (axis - 1)
          local value = reader.half(text, at + 1 + 8 * ((z * 6 + y) * 4 + x) + 2 * (channel - 1))
          local wanted = sum * 4 / n                             -- 4 pi / n over pi
          assert(math.abs(value - wanted) < 0.01 * math.abs(wanted) + 1e-3,
            ("axis %d, side %d: %g, %g expected"):format(axis, side, value, wanted))
        end
      end
    end
    assert.equal(1, reader.half(text, at + 1 + 6))                      -- valid
  end)

  it("writes three.js' atlas, padded by its ends", function()
    local path = folder.path .. "/a.three.json"
    assert(grid:export(path, { cells = { 4, 3, 5 } }))
    local text = folder:read "a.three.json"
    assert(text:find('"resolution":[4,3,5]', 1, true) and text:find('"min":[-1,-0.5,-1.5],"max":[1,0.5,1.5]', 1, true))
    assert(text:find('"width":4,"height":3,"depth":49', 1, true))
    assert.equal(4 * math.ceil(4 * 3 * 49 * 8 / 3), #text:match '"data":"([^"]*)"')
    assert.equal(4 * 3 * 5 / 3 * 4, #text:match '"validity":"([^"]*)"')
    local data = reader.decoded(text:match '"data":"([^"]*)"')
    for _, cell in ipairs { { 0, 0, 0 }, { 2, 1, 3 }, { 3, 2, 4 } } do
      local p = {}
      for a = 1, 3 do
        local lo, hi, n = grid.bounds[1][a], grid.bounds[2][a], ({ 4, 3, 5 })[a]
        p[a] = lo + (hi - lo) * (cell[a] + 0.5) / n
      end
      local c = grid:sample(p)                                     -- in ylm's convention, to grid.lmax
      for l = 0, 2 do
        for m = -l, l do
          for channel = 1, 3 do
            local number = 3 * (l * (l + 1) + m) + channel - 1     -- coefficients before channels, four numbers a volume
            local volume, slice = math.floor(number / 4), cell[3] + 1
            local texel = ((volume * 7 + slice) * 3 + cell[2]) * 4 + cell[1]
            local wanted = (m % 2 == 0 and 1 or -1) * c:get(channel, ylm.sh.index(l, m))
            assert.is_near(wanted, reader.half(data, 8 * texel + 2 * (number % 4) + 1), 6e-4 * math.abs(wanted) + 1e-4)
          end
        end
      end
    end
  end)

  it("is read by the ten lines of docs/engines.md", function()
    if not has "node" then pending "node is not installed" end
    local name = folder.path .. "/ten"
    assert(grid:export(name .. ".three.json", { cells = { 3, 2, 4 } }))
    assert(grid:export(name .. ".npy", { cells = { 3, 2, 4 }, lmax = 2, dtype = "float" }))
    local code
    for block in scratch.text("docs/engines.md"):gmatch "```js\n(.-)```" do
      code = block:find "function probe" and block or code
    end
    local program = folder:write("ten.js", code
      .. "const file = JSON.parse( require( 'fs' ).readFileSync( process.argv[ 2 ] ) );\n"
      .. "for ( const [ x, y, z ] of [ [ 0, 0, 0 ], [ 2, 1, 3 ], [ 1, 0, 2 ] ] )\n"
      .. "\tconsole.log( probe( file, x, y, z ).flat().join( ' ' ) );")
    local out, status = scratch.capture(("node %s %s.three.json"):format(program, name))
    assert.equal(0, status, out)
    local truth = assert(ylm.load(name .. ".npy")):reshape { 24, 3, 9 }
    local rows, at = ylm.sh.convert(truth, "three.js"):totable(), { 1, 24, 14 }
    local count, n = 0, 0
    for line in out:gmatch "[^\n]+" do
      n = n + 1
      local k = 0
      for word in line:gmatch "%S+" do
        assert.near(rows[at[n]][math.floor(k / 3) + 1][k % 3 + 1], tonumber(word), 2e-3 * truth:max())
        k, count = k + 1, count + 1
      end
    end
    assert.equal(81, count)
  end)

  it("tells the share of each middle that lies outside of bodies", function()
    local lamp = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.3, radiance = 10 }  -- of grid points it holds the middle one
    local around = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 4, lmax = 2 }, lamp)
    local cells, count = { cells = { 4, 4, 4 } }, 0
    local report = assert(around:export(folder.path .. "/v.ktx2", cells))
    assert(around:export(folder.path .. "/v.three.json", cells))
    local texels, bytes = folder:read "v.ktx2", reader.decoded(folder:read "v.three.json":match '"validity":"([^"]*)"')
    local at = integer(texels, 81, 8)
    for z = 0, 3 do
      for y = 0, 3 do
        for x = 0, 3 do
          local function inner(i) return i == 1 or i == 2 end
          local wanted = inner(x) and inner(y) and inner(z) and 0.875 or 1    -- one corner of eight
          local i = (z * 4 + y) * 4 + x
          assert.equal(wanted, report.validity[i + 1])
          assert.equal(wanted, reader.half(texels, at + 1 + 8 * ((z * 8 + y) * 4 + x) + 6))
          assert.equal(math.floor(255 * wanted + 0.5), bytes:byte(i + 1))
          count = count + 1 - wanted
        end
      end
    end
    assert.equal(1, count)
  end)

  it("leaves a good file as it was where the disk is full", function()
    for _, ending in ipairs { "ktx2", "three.json", "npy" } do
      local path = folder.path .. "/kept." .. ending
      assert(grid:export(path, { cells = { 2, 2, 2 } }))
      local before = folder:read("kept." .. ending)
      local out = pictures.on_full_disk(scratch, ([[local ylm = require "ylm"
        local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 2, lmax = 2 },
          ylm.sphere_light { at = { 0, 2, 0 } })
        print(grid:export(%q, { cells = { 8, 8, 8 } }))]]):format(path))
      assert.truthy(out:find "^nil\t.*cannot be written: .*\tEIO", out)
      assert.equal(before, folder:read("kept." .. ending))
    end
    local left = scratch.capture("ls -A " .. scratch.quote(folder.path) .. " | grep unfinished")
    assert.equal("", left)
  end)

  it("leaves points in bodies out of the error, and ends at bytes", function()
    local white = ylm.matte { albedo = 0.6 }
    local room = ylm.scene "a room" {
      geometry = { ylm.box { scale = 2, material = white },
        ylm.box { at = { 0.3, -0.7, 0.2 }, scale = { 0.5, 0.6, 0.5 }, material = white } },
      lights = ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.1, radiance = 20 },
    }
    local before = ylm.on_warning(false)
    local lit = assert(room:bake { quantity = "all", judge = "field", links = room:links { spacing = 0.4, rays = 64 },
      probes = ylm.adaptive_grid { lmax = 2, depth = 4, tolerance = 0.1 } })
    ylm.on_warning(before)
    local path = folder.path .. "/room.ktx2"
    local report = assert(lit:export(path, { tolerance = 0.15 }))
    assert(report.met and report.cells[1] <= 24, report.cells[1])
    local none, message, code = lit:export(path .. ".npy", { tolerance = 0.001, bytes = 1e4 })
    assert(none == nil and code == "ELIMIT" and message:find "cells end at bytes = 10000", message)
    none, message, code = lit:export(path .. ".npy", { cells = { 9, 9, 9 }, bytes = 1e4 })
    assert(none == nil and code == "ELIMIT" and message:find "9 x 9 x 9 cells take", message)
    assert.is_nil(io.open(path .. ".npy"))
  end)

  it("has the light within a closed room, seen from outside of it", function()
    local room = ylm.scene "a room" {
      geometry = ylm.box { scale = 2, material = ylm.matte { albedo = 0.6 } },
      lights = ylm.sphere_light { at = { 0, 0.5, 0 }, radius = 0.1, radiance = 20 },
      camera = ylm.camera { from = { 0, 0.3, 6 }, at = { 0, 0, 0 } },
    }
    local links = room:links { spacing = 0.4, rays = 64 }
    local lit = assert(room:bake { quantity = "all", links = links, probes = ylm.uniform_grid { lmax = 2, cells = { 6, 6, 6 } } })
    local report = assert(lit:export(folder.path .. "/seen.ktx2", { tolerance = 0.1 }))
    assert(report.met and report.cells[1] <= 20, report.cells[1])
    for i = 1, #report.validity do assert(report.validity[i] >= 0.5) end
    local corners = {}
    for i = 0, 7 do corners[i + 1] = { i % 2 * 2 - 1, math.floor(i / 2) % 2 * 2 - 1, math.floor(i / 4) * 2 - 1 } end
    local _, _, sampled = lit:sample(corners)
    assert.equal(0, sampled.outside)
    local inside = { { 0.9, 0.3, 0.2 }, { -0.6, -0.9, 0.4 }, { 0.2, 0.1, -0.95 }, { 0, -0.5, 0.9 } }
    local truth = ylm.light_field(2, links:radiosity():field { quantity = "all" }, inside)
    assert(ylm.sh.relative_error(lit:sample(inside), truth):max() < 0.1)
  end)

  it("says what falls short, and refuses", function()
    local said = {}
    local before = ylm.on_warning(function(message) said[#said + 1] = message end)
    local thin = { { -1, -0.01, -0.01 }, { 1, 0.01, 0.01 } }      -- 256 cells along one axis are few
    local small = ylm.bake(ylm.uniform_grid { bounds = thin, cells = 2, lmax = 2 },
      ylm.sphere_light { at = { 0, 1.5, 0 }, radius = 0.1, radiance = 10 })
    local none, sentence, why = small:export(folder.path .. "/b.npy", { tolerance = 1e-9 })
    assert(none == nil and why == "ELIMIT" and sentence:find "nothing was written" and not io.open(folder.path .. "/b.npy"))
    local report = small:export(folder.path .. "/b.npy", { tolerance = 1e-9, anyway = true })
    ylm.on_warning(before)
    assert(report and not report.met and report.warning == said[1] and said[1]:find "tolerance 1e%-09 is not met by")
    for _, bad in ipairs { { "a.png" }, { "a.ktx2", { cells = { 1, 2, 3 } } },
      { "a.ktx2", { tolerance = 0.1, cells = { 2, 2, 2 } } }, { "a.ktx2", { lmax = 2 } },
      { "a.npy", { tolerance = 0 / 0 } }, { "a.npy", { tolerence = 1 } },
      { "a.npy", { points = {} } }, { "a.npy", { cells = { 4096, 4096, 2 } } } } do
      assert(not pcall(grid.export, grid, folder.path .. "/" .. bad[1], bad[2]), bad[1])
    end
    local ok, message, code = grid:export(folder.path .. "/no/a.ktx2", { cells = { 2, 2, 2 } })
    assert(ok == nil and code == "EIO", message)
    local ringed = assert(grid:export(folder.path .. "/c.three.json", { cells = { 4, 3, 5 }, dering = true }))
    assert(ringed.dering.minimum >= -1e-6)
    local plain = assert(grid:export(folder.path .. "/c.three.json", { cells = { 4, 3, 5 } }))
    assert(ringed.error > plain.error, "the error knows nothing of the window")
    assert(assert(grid:export(folder.path .. "/c.ktx2", { cells = { 4, 3, 5 }, dering = true })).dering.width)
    assert(assert(grid:export(folder.path .. "/c.npy", { cells = { 4, 3, 5 }, dering = true })).dering.width)
    local smooth = ylm.load(folder.path .. "/c.npy"):reshape { 60, 3, 9 }
    assert(ylm.sh.reconstruct(smooth, ylm.sh.random(500, 1)[{ {}, { 1, 3 } }]):min() >= -1e-5)
  end)

  it("is read by ktx-parse", function()
    if not modules or not has "node" then pending "YLM_NODE_MODULES with ktx-parse, and node, are wanted" end
    assert(grid:export(folder.path .. "/k.ktx2", { cells = { 4, 3, 5 } }))
    folder:write("k.mjs", ([[
import { read } from '%s/ktx-parse/dist/index.mjs';
import fs from 'fs';
const c = read( new Uint8Array( fs.readFileSync( 'k.ktx2' ) ) );
const { vkFormat, pixelWidth, pixelHeight, pixelDepth, levels, keyValue } = c;
console.log( vkFormat, pixelWidth, pixelHeight, pixelDepth, levels.length, levels[ 0 ].levelData.length, keyValue.KTXwriter );
]]):format(modules))
    local out = scratch.capture("cd " .. scratch.quote(folder.path) .. " && node k.mjs 2>&1")
    assert(out:find "^97 4 6 15 1 2880 ylm ", out)
  end)

  it("lights a white sphere in three.js as ylm says, within 2 %", function()
    if not browser_page.there() then pending "YLM_NODE_MODULES with three, and chromium, are wanted" end
    local report = assert(grid:export(folder.path .. "/p.three.json", { cells = { 16, 8, 24 } }))
    local places = { { 0, 0, 0 }, { -0.6, 0.2, -1 }, { 0.6, -0.2, 0.9 }, { 0.3, 0.3, -0.4 }, { -0.5, -0.3, 1.1 } }
    local rows, row = browser_page.irradiance(folder, folder:read "p.three.json", places), 0
    assert.equal(15, #rows)
    for _, p in ipairs(places) do
      for _, n in ipairs { { 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 } } do
        row = row + 1
        local q = {}
        for a = 1, 3 do                                            -- half a cell off the surface, as three.js looks
          local h = (grid.bounds[2][a] - grid.bounds[1][a]) / report.cells[a]
          q[a] = p[a] + n[a] * (0.02 + h / 2)
        end
        local E = ylm.sh.irradiance(ylm.sh.resize(grid:sample(q), 2), n)
        for c = 1, 3 do
          local wanted = math.max(0, E[c] / math.pi)               -- three.js shows nothing that is negative
          assert(math.abs(rows[row][c] - wanted) < 0.02 * math.max(wanted, 1e-3),
            ("place %d: %g, %g expected"):format(row, rows[row][c], wanted))
        end
      end
    end
  end)
end)

describe("docs/engines.md", function()
  it("has one program in Lua, and a loader of thirty lines at most beside it", function()
    assert(#blocks.of(scratch.text "docs/engines.md") == 1)
    assert(select(2, scratch.text "package/three/index.js":gsub("\n", "")) <= 30)
  end)
end)
