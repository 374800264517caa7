-- Scenes that are like other scenes: fields, lights by their numbers, files within one set of limits.

local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local function lamp(x) return ylm.sphere_light { at = { x, 2, 0 }, radius = 0.1, radiance = 5 } end

describe("a scene that is like another", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local other = ylm.scene "four lamps" {
    camera = ylm.camera { from = { 3, 2, 3 } },
    geometry = { ylm.box {}, ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } } },
    lights = { lamp(1), ylm.sphere_lights { at = { { 2, 0, 0 }, { 3, 0, 0 }, { 4, 0, 0 } }, radius = { 1, 2, 3 } },
      ylm.polygon_light { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, radiance = 7 } },
    probes = ylm.adaptive_grid { depth = 3 },
    transfer = ylm.transfer {},
  }

  --- x and radius of every sphere, in order; rows of arrays too.
  local function spheres(scene)
    local at, radius = require "ylm.light.pack".arrays(require "ylm.light.pack".pack(1, "spec", scene.lights))
    local out = {}
    for i = 1, #radius do out[i] = { at:get(i, 1), radius:get(i) } end
    return out
  end

  it("takes every field that is not given", function()
    local scene = ylm.scene "same" { like = other }
    assert.equal("same", scene.name)
    for _, name in ipairs { "camera", "probes", "transfer_options" } do assert.equal(other[name], scene[name], name) end
    for _, name in ipairs { "geometry", "lights" } do
      assert.equal(#other[name], #scene[name])
      for i, part in ipairs(other[name]) do assert.equal(part, scene[name][i]) end
    end
    assert.is_true(scene.sky_is_seen)
    local camera = ylm.camera { from = { 1, 1, 1 } }
    local changed = ylm.scene "changed" { like = scene, camera = camera, geometry = {}, lights = lamp(9), background = 2 }
    assert.equal(camera, changed.camera)
    assert.same({}, changed.geometry)
    assert.equal(9, changed.lights[1].at[1])
    assert.same({ 2, 2, 2 }, ylm.scene "again" { like = changed }.background)
    assert.equal(2, #other.geometry)
  end)

  it("moves, removes and adds lights by their numbers; rows of arrays have numbers", function()
    local scene = ylm.scene "moved" {
      like = other,
      moved = { [1] = { radius = 0.25 }, [3] = { at = { -3, 0, 0 } }, [5] = { radiance = { 1, 2, 3 } } },
      removed = { 2 },
      added = { lamp(8), { lamp(9) } },
    }
    assert.same({ { 1, 0.25 }, { -3, 2 }, { 4, 3 }, { 8, 0.1 }, { 9, 0.1 } }, spheres(scene))
    assert.same({ 1, 2, 0 }, scene.lights[1].at)
    assert.same({ 1, 2, 3 }, scene.lights[3].radiance)
    assert.same({ 1, 0, 0 }, scene.lights[3].vertices[2])
    assert.same({ { 1, 0.1 }, { 2, 1 }, { 3, 2 }, { 4, 3 } }, spheres(other))
    assert.same({}, ylm.scene "dark" { like = other, removed = { 1, 2, 3, 4, 5 } }.lights)
  end)

  it("changes environments, disks and spots by their own fields", function()
    local scene = ylm.scene "x" { like = ylm.scene "y" { lights = {
      ylm.environment_light { coefficients = { 1, 0, 0, 0 }, scale = 2 },
      ylm.disk_light { at = { 0, 0, 0 }, normal = { 0, 1, 0 } },
      ylm.spot_light { at = { 0, 2, 0 }, to = { 0, 0, 0 } } } },
      moved = { [1] = { scale = 3 }, [2] = { radius = 2 }, [3] = { intensity = 4 } } }
    assert.equal(3, scene.lights[1].scale)
    assert.equal(2, scene.lights[2].radius)
    assert.same({ 4, 4, 4 }, scene.lights[3].intensity)
  end)

  it("keeps the lamps of a file's surfaces with those surfaces", function()
    folder:write("lamp.mtl", "newmtl glow\nKe 1 1 1\n")
    local path = folder:write("lamp.obj", "mtllib lamp.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glow\nf 1 2 3\n")
    local first = ylm.scene "x" { geometry = ylm.mesh { file = path }, lights = lamp(1) }
    assert.equal(2, #first.lights)
    assert.equal(2, #ylm.scene "a" { like = first }.lights)
    assert.equal(1, #ylm.scene "b" { like = first, geometry = ylm.box {} }.lights)
    assert.equal(3, #ylm.scene "c" { like = first, lights = { lamp(3), lamp(4) } }.lights)
    assert.equal(first.notes[1], ylm.scene "d" { like = first }.notes[1])
    local moved = ylm.scene "e" { like = first, moved = { [2] = { radiance = 9 } } }
    assert.equal(1, #ylm.scene "f" { like = moved, geometry = {} }.lights)
  end)

  it("is a file like another in its folder, and brings numbers back to the bit", function()
    local x = 0.1 + 0.2
    scratch.shell("mkdir " .. scratch.quote(folder.path .. "/deep"))
    folder:write("deep/first.lua", "return scene 'first' { lights = { sphere_light { at = { 1, 2, 3 } } }, geometry = box {} }")
    folder:write("deep/second.lua", "return scene 'second' { like = 'first.lua', background = 1 }")
    local path = folder:write("third.lua",
      ("return scene 'third' { like = 'deep/second.lua', moved = { { at = { %.17g, 0, 0 } } } }"):format(x))
    local scene = assert(ylm.load(path))
    assert.equal(x, scene.lights[1].at[1])
    assert.same({ 1, 1, 1 }, scene.background)
    assert.equal(path, scene.file)
    assert.equal(1, #ylm.scene "script" { like = path }.geometry)
  end)

  --- The file is refused with this code and a message that matches `says`.
  local function refuses(code, says, name, text, limits)
    local scene, message, got = ylm.load(folder:write(name, text), limits)
    assert.is_nil(scene)
    message = message:gsub("/[^ ]*/", "")
    assert.equal(says, message:sub(1, #says))
    assert.equal(code, got)
  end

  it("names both files where one is at fault", function()
    folder:write("wrong.lua", "\nreturn scene 'x' { lihgts = {} }")
    refuses("EFORMAT", "a.lua:2: like: wrong.lua:2: scene: no field 'lihgts'", "a.lua",
      "\nreturn scene 'a' { like = 'wrong.lua' }")
    folder:write("b.lua", "return scene 'b' { like = 'a.lua' }")
    refuses("EFORMAT", "c.lua:1: like: b.lua:1: like: a.lua:2: like: wrong.lua:2: scene:", "c.lua",
      "return scene 'c' { like = 'b.lua' }")
    folder:write("none.lua", "return 3")
    refuses("EFORMAT", "a.lua:1: like: none.lua: must return a scene", "a.lua", "return scene 'a' { like = 'none.lua' }")
    refuses("EIO", "a.lua:1: like: missing.lua: no such file", "a.lua", "return scene 'a' { like = 'missing.lua' }")
    refuses("EFORMAT", "a.lua:1: like: a path inside the scene's folder", "a.lua", "return scene 'a' { like = '../a.lua' }")
    refuses("EFORMAT", "a.lua:1: scene: like must be", "a.lua", "return scene 'a' { like = 3 }")
    local scene, message, code = ylm.scene "x" { like = folder.path .. "/missing.lua" }
    assert.is_nil(scene)
    assert.truthy(message:find "missing.lua")
    assert.equal("EIO", code)
  end)

  it("refuses files that are like themselves, and more than eight", function()
    folder:write("b.lua", "return scene 'b' { like = 'a.lua' }")
    refuses("EFORMAT", "a.lua:1: like: b.lua:1: like: a.lua is like itself (a.lua -> b.lua -> a.lua)", "a.lua",
      "return scene 'a' { like = 'b.lua' }")
    folder:write("f1.lua", "return scene 'f' {}")
    for i = 2, 8 do folder:write(("f%d.lua"):format(i), ("return scene 'f' { like = 'f%d.lua' }"):format(i - 1)) end
    assert(ylm.load(folder.path .. "/f8.lua"))
    local scene, message = ylm.load(folder:write("f9.lua", "return scene 'f' { like = 'f8.lua' }"))
    assert.is_nil(scene)
    assert.truthy(message:find "more than 8 scenes that are like one another$", message)
  end)

  it("shares one set of limits among the files", function()
    folder:write("half.lua", "local n = 0 for i = 1, 3e5 do n = n + 1 end "
      .. "return scene 'h' { geometry = box { divide = 10 } }")
    local text = "local n = 0 for i = 1, 3e5 do n = n + 1 end "
      .. "return scene 'x' { like = 'half.lua', geometry = box { divide = 10 } }"
    local path = folder:write("whole.lua", text)
    assert(ylm.load(path, { triangles = 2400 }))
    refuses("ELIMIT", "whole.lua:1: like: half.lua:1: box: more than 2399 triangles in one scene file", "whole.lua", text,
      { triangles = 2399 })
    assert(ylm.load(folder.path .. "/half.lua", { instructions = 1e6 }))
    refuses("ELIMIT", "whole.lua:1: like: half.lua: takes more than 1000000 instructions", "whole.lua",
      text, { instructions = 1e6 })
  end)

  it("refuses changes that fit no light, and says which", function()
    local function says(text, fields)
      fields.like = fields.like or other
      local ok, message = pcall(ylm.scene "x", fields)
      assert.is_false(ok)
      assert.truthy(message:find(text, 1, true), message)
    end
    says("moved: a number of one of the 5 lights of \"four lamps\" expected, got 6", { moved = { [6] = {} } })
    says("removed: a number of one of the 5 lights of \"four lamps\" expected, got 0", { removed = { 0 } })
    says("removed: a list of numbers of lights expected", { removed = { a = 1 } })
    says("moved[1]: sphere_light: no field 'raduis' (did you mean 'radius'?)", { moved = { { raduis = 1 } } })
    says("moved[2]: sphere_light: radius must be a number >= 0", { moved = { [2] = { radius = -1 } } })
    says("moved[5]: polygon_light: vertices must be three or more points", { moved = { [5] = { vertices = 1 } } })
    says("moved[1]: a table of the light's fields expected, got 3", { moved = { 3 } })
    says("give lights, or changes to those of the other scene (added), not both", { lights = {}, added = lamp(1) })
    says("added must be a light", { added = ylm.box {} })
    says("moved[1]: the fields of a virtual_lights are not kept; remove it, and add another", { moved = { {} },
      like = ylm.scene "v" { lights = ylm.virtual_lights { at = { { 0, 0, 0 } }, intensity = 1, profile = "point" } } })
    local ok, message = pcall(ylm.scene "x", { removed = { 1 } })
    assert.is_false(ok)
    assert.truthy(message:find("scene: removed changes the lights of another scene, which like names", 1, true))
  end)
end)
