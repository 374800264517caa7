-- Scenes: what they hold, how lists nest, and that mistakes are named at their line.

local ylm = require "ylm"

local function lamp(x) return ylm.sphere_light { at = { x, 2, 0 }, radius = 0.1, radiance = 5 } end

describe("ylm.scene", function()
  it("holds what was described, with its name", function()
    local camera = ylm.camera { from = { 3, 2, 3 }, at = { 0, 0, 0 } }
    local box, light = ylm.box {}, lamp(1)
    local scene = ylm.scene "one box" { camera = camera, geometry = { box }, lights = light, background = { 0, 0, 1 } }
    assert.equal("one box", scene.name)
    assert.equal(camera, scene.camera)
    assert.equal(box, scene.geometry[1])
    assert.equal(light, scene.lights[1])
    assert.same({ 0, 0, 1 }, scene.background)
    assert.is_nil(scene.probes)
    assert.equal('scene "one box": 1 pieces of geometry, 1 lights', tostring(scene))
  end)

  it("may be empty", function()
    local scene = ylm.scene "" {}
    assert.same({}, scene.geometry)
    assert.same({}, scene.lights)
    assert.same({ 0, 0, 0 }, scene.background)
  end)

  it("flattens nested lists in order, and takes fields of lights that loops have built", function()
    local row, grid = {}, {}
    for i = 1, 3 do row[i] = lamp(i) end
    for i = 1, 2 do grid[i] = { row, {}, { { lamp(10 * i) } } } end
    local scene = ylm.scene "loops" { lights = { grid, lamp(99) } }
    local x = {}
    for i, light in ipairs(scene.lights) do x[i] = light.at[1] end
    assert.same({ 1, 2, 3, 10, 1, 2, 3, 20, 99 }, x)
    local many = ylm.sphere_lights { at = { { 0, 0, 0 }, { 1, 0, 0 } }, radius = 0.1, radiance = 1 }
    assert.equal(2, #ylm.scene "arrays" { lights = { many, lamp(1) } }.lights)
  end)

  it("does not change the tables it is given", function()
    local lights = { lamp(1), { lamp(2) } }
    local fields = { lights = lights }
    local scene = ylm.scene "x"(fields)
    scene.lights[1] = nil
    assert.equal(2, #lights)
    assert.equal(lights, fields.lights)
    assert.is_nil(fields.name)
  end)

  it("can be made of one name more than once", function()
    local make = ylm.scene "twice"
    assert.are_not.equal(make {}, make {})
  end)

  --- The line that an error names, of a chunk called scene.lua.
  local function message_of(text)
    local chunk = assert((loadstring or load)("local ylm, lamp = ...\n" .. text, "@scene.lua"))
    local ok, message = pcall(chunk, ylm, lamp)
    assert.is_false(ok)
    return message
  end

  it("says whose a field is that stands elsewhere, and is not misspelt", function()
    local s = ylm.scene "x" {}
    local ok, message = pcall(s.render, s, { spacing = 1 })
    assert.is_false(ok)
    assert.matches("no field 'spacing'; it is a field of ylm.links", message)
  end)

  it("names the first in the alphabet of fields that there are not", function()
    for _, others in ipairs { { "zz", "yy", "xx" }, { "e1", "e2", "e3", "e4" }, { "q", 1 } } do
      local fields = { albedo = 0.5, dd = 1 }
      for _, name in ipairs(others) do fields[name] = 1 end
      local ok, message = pcall(ylm.matte, fields)
      assert.is_false(ok)
      assert.matches("no field 'dd'", message)
    end
  end)

  it("names the line of a mistake, though scene files end in a tail call", function()
    assert.equal("scene.lua:3: scene: no field 'ligths' (did you mean 'lights'?)",
      message_of "\nreturn ylm.scene 'x' { ligths = {} }")
    assert.truthy(message_of("\nreturn ylm.scene 'x' {\n  lights = {\n    ylm.sphere_light { at = { 0, 1 } },\n  } }")
      :find("^scene.lua:5: sphere_light: at must be three numbers"))
    assert.truthy(message_of "return ylm.scene 'x' { lights = { lamp(1), { lamp(2), ylm.box {} } } }"
      :find("^scene.lua:2: scene: lights%[2%]%[2%] must be a light .*, got a box"))
    assert.truthy(message_of "return ylm.scene 'x' { geometry = { lamp(1) } }"
      :find("geometry[1] must be geometry (a quad, sphere, box, torus, knot or mesh), got a sphere_light", 1, true))
    assert.truthy(message_of "return ylm.scene { lights = {} }"
      :find("the scene's name comes first: scene \"name\" { ... }; got a table", 1, true))
  end)

  it("says why a mesh is not there, instead of going on without it", function()
    assert.truthy(message_of "return ylm.scene 'x' { geometry = { ylm.mesh { file = 'no such.obj' } } }"
      :find("geometry%[1%] is nil: no such.obj: "))
    assert.truthy(message_of "return ylm.scene 'x' { geometry = { ylm.mesh { file = 'no such.obj' }, ylm.box {} } }"
      :find("geometry%[1%] is nil"))
  end)
end)
