-- Grids beside another scene than theirs: one line says which part of it differs.
local bytes = require "spec.support.grid_bytes"
local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

local text = [[
return scene "shelf" {
  camera   = camera { from = { 2, 2, 3 }, at = { 0, 0, 0 } }, background = BACKGROUND,
  geometry = { quad { corner = { -2, -0.5, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, material = matte { albedo = ALBEDO } },
               quad { corner = { SHELF, 1, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
  lights   = { sphere_light { at = { LAMP, 1.5, 0.5 }, radius = 0.1, radiance = 50 },
               environment_light { coefficients = ylm_sky } },
  probes   = uniform_grid { cells = 2, lmax = 1 },
}]]
local usual = { ALBEDO = 0.5, SHELF = -1, LAMP = 0.5, BACKGROUND = "nil",
  ylm_sky = "{ 1, 0.2, 0.3, 0.1 }" }

--- The text of the scene with some numbers changed.
local function written(changes)
  return (text:gsub("[%a_]+", function(word) return tostring(changes[word] or usual[word] or word) end))
end

local small = { size = { 8, 5 }, samples = 1, layers = false }
local function with(more)
  for key, value in pairs(small) do more[key] = value end
  return more
end

describe("a grid of another scene", function()
  local folder, said, before
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)
  before_each(function()
    said = {}
    before = ylm.on_warning(function(line) if line:find "was baked from" then said[#said + 1] = line end end)
  end)
  after_each(function() ylm.on_warning(before) end)

  local function scene(changes) return assert(ylm.load(folder:write("scene.lua", written(changes or {})))) end
  local function bake(parts)
    local s = scene()
    return s:bake { quantity = parts, threads = 2, links = parts ~= "lights" and s:links { rays = 4, lmax = 0 } or nil }
  end
  local function line(what, parts)
    return { ('%s was baked from other %s than scene "shelf" has: the light is not the scene\'s; bake it anew, or give the '
      .. 'scene it is of'):format(what, parts) }
  end
  --- The lines that a picture of a scene by a grid gives.
  local function render(changes, grid)
    said = {}
    local o = grid.quantity == "indirect" and { bounced = grid } or { grid = grid }
    local _, report = assert(scene(changes):render(with(o)))
    for _, sentence in ipairs(said) do
      local found = false
      for _, w in ipairs(report.warnings) do found = found or w == sentence end
      assert.is_true(found, sentence)
    end
    return said
  end

  it("is said by the parts that its light depends on, and its own scene is silent", function()
    local moved = { albedo = { ALBEDO = 0.6 }, lamp = { LAMP = 0.6 }, shelf = { SHELF = -1.1 },
      sky = { ylm_sky = "{ 1, 0.2, 0.3, 0.2 }" } }
    local expected = {
      lights = { lamp = "lights", sky = "lights" },
      direct = { lamp = "lights", sky = "lights", shelf = "geometry" },
      indirect = { lamp = "lights", sky = "lights", shelf = "geometry", albedo = "materials" },
    }
    for parts, cases in pairs(expected) do
      local made = assert(bake(parts))
      local path = folder.path .. "/" .. parts .. ".ylm"
      assert(made:save(path))
      assert.same({}, render({ BACKGROUND = 1 }, made), parts)
      local again = assert(ylm.load(path))
      assert.same(made.prints, again.prints)
      assert.same({}, render({}, again), parts)
      for name, changes in pairs(moved) do
        local grid = assert(ylm.load(path))
        assert.same(cases[name] and line("grid " .. path, cases[name]) or {}, render(changes, grid), parts .. " " .. name)
        if parts == "lights" then assert.same({}, render(changes, grid)) end -- once
      end
    end
  end)

  it("is named with all its parts; grids of which nobody told are not", function()
    local s = scene()
    local grid = assert(bake "all")
    local other = { ALBEDO = 0.6, LAMP = 0.6, SHELF = -1.1 }
    assert.same(line("the grid", "geometry, materials and lights"), render(other, grid))
    assert.is_nil(ylm.bake(ylm.uniform_grid { cells = 2, lmax = 1, bounds = grid.bounds }, s.lights).prints)
    assert.is_nil(s:bake({ lights = { s.lights[1] } }).prints)
    local lit = s:bake {}
    local lights = lit.prints.lights
    assert.matches("^%x+$", lights)
    assert(lit:update(s.lights)) -- the same light, to the bit
    assert.equal(lights, lit.prints.lights)
    assert(lit:update(s.lights[1]))
    assert.is_nil(lit.prints)
    local followed = ylm.scene "followed" { lights = s.lights[1], geometry = s.geometry,
      probes = ylm.uniform_grid { cells = 2, lmax = 1, dynamic = true } }:bake {}
    assert.is_not_nil(followed.prints)
    assert(followed:update(s.lights[1]))
    assert.is_not_nil(followed.prints)
    assert(followed:update(ylm.sphere_light { at = { 0, 2, 0 } }))
    assert.is_nil(followed.prints)
  end)

  it("in bricks is one too", function()
    local path = folder.path .. "/bricks.ylmd"
    local o = { probes = ylm.adaptive_grid { lmax = 1, depth = 3, threshold = 0.5, bricks = 1 }, folder = path }
    local set = assert(scene():bake(o))
    assert.same({}, render({}, set))
    assert.same(line("grid " .. path, "lights"), render({ LAMP = 0.6 }, assert(ylm.load(path))))
    assert(set:save(folder.path .. "/packed.ylm"))
    assert.same(set.prints, assert(ylm.load(folder.path .. "/packed.ylm")).prints)
  end)

  it("keeps its fingerprints in a section that files need not have", function()
    local grid = bake "direct"
    local whole = core.grid_encode(grid)
    local function forge(section)
      local f = bytes.open(whole)
      local s = f.section.prints
      s.name, s.data = section and s.name or "unknown", section or s.data
      return f:seal()
    end
    local function prints(known, ...)
      local words = { bytes.u64(known) }
      for i, x in ipairs { ... } do words[i + 1] = bytes.u64(x) end
      return table.concat(words)
    end
    assert.same(grid.prints, core.grid_form(core.grid_decode(bytes.open(whole):seal())).prints)
    local older = assert(core.grid_decode(forge()))
    assert.is_nil(older.prints)
    assert.same({}, render({ LAMP = 0.6, SHELF = -1.1 }, older))
    for _, bad in ipairs { prints(0, 0, 0, 0), prints(8, 0, 0, 0), prints(4, 1, 0, 2), prints(4, 0, 0) } do
      local g, message, code = core.grid_decode(forge(bad))
      assert.is_nil(g)
      assert.equal("EFORMAT", code)
      assert.matches("not a valid grid: .*prints", message)
    end
  end)

  it("is a warning of the command line, with status 6 under --strict", function()
    local run = tool.runner(folder, "YLM_WARNINGS=")
    local function at(name) return scratch.quote(folder.path .. "/" .. name) end
    folder:write("a.lua", written {})
    folder:write("b.lua", written { ALBEDO = 0.6, LAMP = 0.6, SHELF = -1.1 })
    local _, code, err = run("bake " .. at "a.lua" .. " -q --quantity direct -o " .. at "a.ylm")
    assert.equal(0, code, err)
    local out
    out, code, err = run("info " .. at "a.ylm")
    assert.equal(0, code, err)
    assert.matches("\nprints +geometry %x+, lights %x+\n", "\n" .. out)
    for name, wanted in pairs { ["a.lua"] = 0, ["b.lua"] = 6 } do
      _, code, err = run("render " .. at(name) .. " --strict -s 8x5 -n 1 --grid " .. at "a.ylm" .. " -o " .. at "a.exr")
      assert.equal(wanted, code, err)
      assert.equal(wanted == 6, err:find("a.ylm was baked from other geometry and lights than", 1, true) ~= nil, err)
    end
  end)
end)
