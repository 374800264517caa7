-- Materials: what every kind answers, whoever asks. Kinds are not named here but where a number is a kind's own.

local ylm = require "ylm"
local core = require "ylm.c.core"
local form = require "ylm.form"
local material = require "ylm.material"
local files = require "spec.support.brdf_files"
local scratch = require "spec.support.scratch"
local ways = require "spec.support.ways"

local folder = scratch.new()
teardown(function() folder:remove() end)

--- A MERL file of a matte surface, an RGL file of f cos = colour / 4.
local function merl(name, albedo)
  assert(ylm.matte { albedo = albedo }:save(folder.path .. "/" .. name))
  return folder.path .. "/" .. name
end
local function rgl(name, colour) return folder:write(name, files.tensor(files.constant_fields(colour))) end

--- Materials of each kind, by its form.
local examples = {
  matte = { ylm.matte {}, ylm.matte { albedo = 1 }, ylm.matte { albedo = { 0.63, 0.06, 0 } } },
  ggx = { ylm.ggx {}, ylm.ggx { f0 = 1 }, ylm.ggx { alpha = { 0.1, 0.3 }, base = { 0.5, 0.2, 0 } } },
  phong = { ylm.phong { base = 0 }, ylm.phong {} },
  abc = { ylm.abc { fit = "chrome" }, ylm.abc { fit = "white-paint" } },
  merl = { ylm.merl { file = merl("a.binary", 0.2) }, ylm.merl { file = merl("b.binary", { 0.5, 0.3, 0.7 }) } },
  rgl = { ylm.rgl { file = rgl("a.bsdf", { 0.3, 0.2, 0.1 }) }, ylm.rgl { file = rgl("b.bsdf", { 0.5, 0.6, 0 }) } },
  tabulated = { ylm.tabulated { f = function() return 0.1 end }, ylm.tabulated { f = function() return 0.3, 0, 0.2 end } },
}

--- A square of a material in a lamp that is all around it, of radiance 1.
local function inside(m)
  return ylm.scene "in a lamp" {
    camera = ylm.camera { from = { 0, 3, 0 }, up = { 0, 0, -1 }, fov = 10 },
    geometry = ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 }, material = m },
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 50, radiance = 1 },
  }
end

describe("materials", function()
  it("have a form in Lua and a row in C for each kind", function()
    for _, name in ipairs(material.kinds) do
      assert(form.defined[name] and form.defined[name].home == "material." .. name, name)
      assert(examples[name], name .. ": no examples here")
      assert.equal(name, form.kind(examples[name][1]))
    end
    for name, definition in pairs(form.defined) do
      assert(not definition.material or material[name], name .. " is not listed in csrc/material/kind.h")
    end
    assert.same({ 0.5, 0.5, 0.5 }, material.albedo("spec", material.default))
  end)

  for _, name in ipairs(material.kinds) do
    it("of a kind reflect light from everywhere by their albedo, which no channel exceeds: " .. name, function()
      for _, m in ipairs(examples[name]) do
        local albedo = material.albedo("spec", m)
        local s = inside(m)
        local options = { size = { 2, 2 }, samples = 1, visibility = "none", lmax = 2, gloss = "matte" }
        local view = s:prepare(options)
        local harmonics, points = view:render { by = "sum" }, view:points()
        local matte = name == "matte"
        local rays, seen = view:render { by = "rays", light_samples = matte and 16 or 1024 }, m:albedo { 0.999 }
        for c = 1, 3 do
          assert(albedo[c] >= 0 and albedo[c] <= 1)
          assert.near(albedo[c], points.albedo:get(1, c), 1e-7)
          assert.near(albedo[c], harmonics:layer "albedo":get(1, 1, c), 1e-7)
          assert.near(albedo[c], harmonics:layer():get(1, 1, c), 2e-6)
          if matte then assert.near(albedo[c], rays:layer():get(1, 1, c), 2e-6)
          else assert.near(seen:get(1, c), rays:layer():get(1, 1, c), 0.02) end -- what goes to the eye, by samples
        end
      end
    end)

    it("of a kind weigh light by zonal coefficients, to a degree that is checked: " .. name, function()
      local a = core.material_transfer(name, 1000)
      assert.equal(1001, #a)
      assert(a:get(1) > 0)
      for _, lmax in ipairs { -1, 1001, 0 / 0 } do
        local none, _, code = core.material_transfer(name, lmax)
        assert.same({ nil, "ERANGE" }, { none, code })
      end
    end)

    it("of a kind are traced anew where a number of them changes: " .. name, function()
      local m = examples[name][1]
      local s = inside(m)
      local options = { size = { 2, 2 }, samples = 1, visibility = "none", lmax = 0 }
      local before = s:render(ways.sum(options)):layer "albedo":get(1, 1, 1)
      s.geometry[1].material = examples[name][2]
      assert.is_true(s:render(ways.sum(options)):layer "albedo":get(1, 1, 1) > before)
    end)
  end

  it("refuse what C does not know, and other numbers than a kind has", function()
    local function refuses(says, wanted, ...)
      local none, message, code = core.material_create(...)
      assert.is_nil(none)
      assert.equal(wanted, code)
      assert.truthy(message:find(says), message)
    end
    refuses("no such kind", "EINVAL", "chalk", { 1, 1, 1 })
    refuses("has 3 numbers, got 2", "EINVAL", "matte", { 1, 1 })
    refuses("has 3 numbers, got 9", "EINVAL", "matte", { 1, 1, 1, 1, 1, 1, 1, 1, 1 })
    refuses("albedo's green .* got 1.5", "EDOMAIN", "matte", { 0, 1.5, 0 })
    refuses("albedo's red", "EDOMAIN", "matte", { 0 / 0, 1, 0 })
    local none, _, code = core.material_transfer("chalk", 2)
    assert.same({ nil, "EINVAL" }, { none, code })
  end)
end)

describe("the clamped cosine", function()
  it("has the zonal coefficients of spec/data/irradiance.txt", function()
    local a, n = core.material_transfer("matte", 20), 0
    for line in io.lines "spec/data/irradiance.txt" do
      local l, value = line:match "^A (%d+) (%S+)"
      if l then
        assert.near(tonumber(value), a:get(tonumber(l) + 1), 1e-15)
        n = n + 1
      end
    end
    assert.equal(21, n)
  end)
end)
