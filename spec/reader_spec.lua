-- Named arguments of C: unknown names, types, ranges and choices are refused in one place, csrc/lua/binding_read.c.

local core = require "ylm.c.core"
local library = require "ylm.library"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

--- The message that f(...) raises.
local function refusal(f, ...)
  local ok, message = pcall(f, ...)
  assert.is_false(ok)
  return message
end

describe("the reader of named arguments", function()
  --- Arguments of core.sh_convert, with changes.
  local function convert(changes)
    local o = { from = 0, to = 0, lmax = 1, rows = 1, threads = 1 }
    for key, value in pairs(changes) do o[key] = value ~= "none" and value or nil end
    return core.sh_convert(ylm.zeros({ 1, 4 }, "double"), ylm.zeros({ 1, 4 }, "double"), o)
  end

  --- Arguments of core.grid_sample, with changes.
  local function sample(changes)
    local grid = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 2, lmax = 1 },
      ylm.sphere_light { at = { 0, 2, 0 } })
    local o = { interpolation = "linear", derivatives = 0, outside = "nan", dtype = "double" }
    for key, value in pairs(changes) do o[key] = value ~= "none" and value or nil end
    return core.grid_sample(grid, ylm.zeros({ 1, 3 }, "double"), o)
  end

  it("takes what is right, and leaves out what may be left out", function()
    assert.is_true(convert {})
    assert.is_true(convert { threads = "none" })
    assert.same({ 1, 3, 4 }, sample({}).shape)
    assert.equal("float", sample({ dtype = "float", outside = "clamp" }).dtype)
  end)

  it("refuses a name that no entry has", function()
    assert.matches("no argument has the name 'degree'", refusal(convert, { degree = 3 }), 1, true)
    assert.matches("no argument has the name 'number'", refusal(convert, { [5] = 3 }), 1, true)
  end)

  it("refuses a missing one", function()
    assert.matches("lmax is missing", refusal(convert, { lmax = "none" }), 1, true)
    assert.matches("interpolation is missing", refusal(sample, { interpolation = "none" }), 1, true)
  end)

  it("refuses another type", function()
    assert.matches("lmax: an integer of 0 to ", refusal(convert, { lmax = "4" }), 1, true)
    assert.matches("got '4'", refusal(convert, { lmax = "4" }), 1, true)
    assert.matches("lmax: an integer expected, got 1.5", refusal(convert, { lmax = 1.5 }), 1, true)
    assert.matches("rows: an integer of 0 to ", refusal(convert, { rows = {} }), 1, true)
    assert.matches("interpolation: one of 'hermite', 'taylor', 'linear' expected, got table",
      refusal(sample, { interpolation = {} }), 1, true)
    assert.matches("ylm.array expected", refusal(sample, { value = 3 }), 1, true)
    assert.matches("table expected", refusal(core.sh_convert, ylm.zeros { 1 }, ylm.zeros { 1 }, 5), 1, true)
  end)

  it("refuses what is out of its range", function()
    for _, n in ipairs { -1, 1e6, 1 / 0, -1 / 0, 0 / 0, 2 ^ 40 } do
      assert.matches("lmax: an integer of 0 to ", refusal(convert, { lmax = n }), 1, true)
    end
    for _, n in ipairs { -1, 2 ^ 60, 1 / 0 } do
      assert.matches("rows: an integer of 0 to ", refusal(convert, { rows = n }), 1, true)
    end
    assert.matches("threads: an integer of -", refusal(convert, { threads = 2 ^ 31 }), 1, true)
  end)

  it("refuses a word that is none of the choices", function()
    local message = refusal(sample, { interpolation = "cubic" })
    assert.matches("interpolation: one of 'hermite', 'taylor', 'linear' expected, got 'cubic'", message, 1, true)
    assert.matches("outside: one of 'clamp', 'nan' expected, got 'zero'", refusal(sample, { outside = "zero" }), 1, true)
  end)

  it("refuses lists and booleans that are none", function()
    local scene = library.open("scene", "%s")
    if not scene then return pending "libylm_scene is not there" end
    local s = ylm.scene "empty" { camera = ylm.camera { from = { 0, 0, 1 }, at = { 0, 0, 0 } } }
    local t = require "ylm.trace".trace("reader", s)
    local function view(changes)
      local o = { camera = { 0, 0, 1, 0, 0, 0, 0, 1, 0, 40 }, width = 2, height = 2, samples = 1, lmax = 1, shading = "pixel",
        visibility = "none", transfer_samples = 1, occlusion_distance = 1, share = 1, seed = 1 }
      for key, value in pairs(changes) do o[key] = value end
      return scene.shade_view(t.handle, o)
    end
    assert(view {})
    assert.matches("fine: a boolean expected, got 1", refusal(view, { fine = 1 }), 1, true)
    assert.matches("gloss_error: a list of 2 numbers expected, got nil", refusal(view, { gloss_error = { 1 } }), 1, true)
    assert.matches("gloss_error: a list of 2 numbers expected, got 1", refusal(view, { gloss_error = 1 }), 1, true)
    assert.matches("share: a number expected, got table", refusal(view, { share = {} }), 1, true)
    assert.matches("seed: an integer of 0 to ", refusal(view, { seed = -1 }), 1, true)
    assert.matches("an object with a light field expected", refusal(view, { light = t.handle }), 1, true)
  end)
end)

describe("choices", function()
  it("are lists by name, with a word in front", function()
    assert.same({ "hermite", "taylor", "linear" }, core.choices "interpolation")
    assert.same({ "linear", "hermite", "taylor" }, core.choices("interpolation", "linear"))
    assert.same({ "float", "double" }, core.choices().dtype)
    assert.matches("no option has such a list", refusal(core.choices, "shape"), 1, true)
  end)

  --- Words of a list in one string, whatever their order.
  local function key(words)
    local sorted = { (table.unpack or unpack)(words) }  -- luacheck: ignore 113
    table.sort(sorted)
    return table.concat(sorted, ",")
  end

  it("stand in C alone: no option of lua/ylm types a list of them again", function()
    local known, wrong = {}, {}
    for name, words in pairs(core.choices()) do known[key(words)] = name end
    for _, path in ipairs(scratch.lines "find lua/ylm -name '*.lua' -not -path 'lua/ylm/render/*'") do
      for list in scratch.text(path):gmatch "of = (%b{})" do
        local words = {}
        for word in list:gmatch '"([^"]*)"' do words[#words + 1] = word end
        if known[key(words)] then wrong[#wrong + 1] = ("%s: of = %s is core.choices %q"):format(path, list, known[key(words)]) end
      end
    end
    assert.equal("", table.concat(wrong, "\n"))
  end)
end)
