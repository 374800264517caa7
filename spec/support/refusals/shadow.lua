--- Bodies in the way of light: see spec/refusals_spec.lua.

local function ball(ylm) return ylm.occluder { radius = 1 } end
local function caster(ylm) return ylm.caster { hides = ball(ylm) } end
local function tetrahedron(ylm, triangles, last)
  return ylm.occluder { geometry = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, last or { 0, 0, 1 } }, triangles = triangles } }
end
local closed = { { 1, 3, 2 }, { 1, 2, 4 }, { 2, 3, 4 }, { 3, 1, 4 } }

return {
  sphere_set = {
    { call = function(ylm) ylm.sphere_set(5) end, says = "geometry must be a mesh or a shape, got 5" },
    { call = function(ylm) ylm.sphere_set(ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }) end,
      says = "the mesh has 4 edges that are open, or between triangles that turn opposite ways: what is inside of it?" },
    { call = function(ylm) ylm.sphere_set(ylm.mesh { vertices = {}, triangles = {} }) end, says = "no triangles" },
    { call = function(ylm)
      ylm.sphere_set(ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 }, { 1, 3, 2 } } })
    end, says = "the mesh encloses no volume" },
    { call = function(ylm) ylm.sphere_set(ylm.box {}, { count = 4097 }) end, says = "count must be" },
    { call = function(ylm) ylm.sphere_set(ylm.box {}, { spheres = 4 }) end, says = "spheres" },
  },
  occluder = {
    { call = function(ylm) ylm.occluder {} end, says = "give geometry, a closed convex mesh, or radius" },
    { call = function(ylm) ylm.occluder { radius = 1, geometry = ylm.box {} } end, says = "give geometry or radius, not both" },
    { call = function(ylm) ylm.occluder { at = { 0, 0, 0 }, geometry = ylm.box {} } end, says = "at is of a sphere" },
    { call = function(ylm) ylm.occluder { geometry = 7 } end, says = "geometry must be a mesh or a shape, got 7" },
    { call = function(ylm) ylm.occluder { radius = 0 } end, says = "radius must be a number > 0" },
    { call = function(ylm) ylm.occluder { radius = 0 / 0 } end, says = "radius must be" },
    { call = function(ylm) tetrahedron(ylm, { closed[1], closed[2], closed[3] }) end,
      says = "the mesh has 3 open edges: what is inside of it" },
    { call = function(ylm) tetrahedron(ylm, closed, { 0.3, 0.3, 0 }) end, says = "the mesh is flat" },
    { call = function(ylm) ylm.occluder { geometry = ylm.torus { divide = { 8, 6 } } } end,
      says = "the body is not convex: a corner at .* stands out of a face by .*: give rays" },
    { call = function(ylm) ylm.occluder { geometry = ylm.sphere { divide = { 100, 50 } } } end,
      says = "triangles, at most 4096 expected.*: give rays" },
    { call = function(ylm) ylm.occluder { radius = 1, rays = 64 } end, says = "rays are of geometry" },
    { call = function(ylm) ylm.occluder { geometry = ylm.box {}, rays = 3 } end, says = "rays must be an integer >= 4" },
    { call = function(ylm) ylm.occluder { geometry = ylm.box {}, rays = 1025 } end, says = "rays must be an integer" },
    { call = function(ylm) ylm.occluder { geometry = ylm.box {}, near = 0 } end, says = "near must be a number > 0" },
    { call = function(ylm)
      ylm.occluder { rays = 8, geometry = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } } }
    end, says = "open edges: what is inside of it" },
    { call = function(ylm)
      ylm.light_field(2, ylm.occluder { geometry = ylm.box {}, rays = 8 }, { 0, 0, 3 }, { derivatives = 2 })
    end, says = "a body by rays has no Hessians" },
    { call = function(ylm)
      ylm.bake(ylm.adaptive_grid { lmax = 4, tolerance = 1e-4, channels = "luminance" },
        ylm.occluder { geometry = ylm.torus { divide = { 16, 8 } }, rays = 8 })
    end, says = "tolerance 0.0001 is below the noise of rays here, .*: rays = %d+ may do, or tolerance = " },
    { call = function(ylm) ylm.occluder { geometry = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } } } end,
      says = "open edges" },
    { call = function(ylm) ylm.light_field(2, { ball(ylm) }, { 0, 0, 3 }) end, says = "a visibility is no light" },
    { call = function(ylm) ylm.bake(ylm.adaptive_grid { lmax = 2, depth = 2 }, ball(ylm)) end, says = "a visibility has no colour" },
  },
  ["occluder:noise"] = {
    { call = function(ylm) local b = ball(ylm) b.noise(7, 2) end, says = "an occluder expected before the colon, got 7" },
    { call = function(ylm) ball(ylm):noise(101) end, says = "lmax must be an integer from 0 to 100" },
    { call = function(ylm)
      local b = ball(ylm)
      b:close()
      b:noise(2)
    end, says = "noise: the occluder has been closed" },
  },
  ["occluder:close"] = {
    { call = function(ylm) local b = ball(ylm) b.close(7) end, says = "an occluder expected before the colon, got 7" },
    { call = function(ylm)
      local b = ball(ylm)
      b:close()
      ylm.light_field(2, b, { 0, 0, 3 })
    end, says = "the occluder has been closed" },
  },
  caster = {
    { call = function(ylm) ylm.caster {} end, says = "field 'hides' is missing" },
    { call = function(ylm) ylm.caster { hides = 7 } end, says = "hides must be an occluder, or a grid" },
    { call = function(ylm) ylm.caster { hides = ball(ylm), scale = { 1, 2, 3 } } end, says = "one number: shear is not a rotation" },
    { call = function(ylm) ylm.caster { hides = ball(ylm), scale = -1 } end, says = "scale must be a number > 0" },
    { call = function(ylm) ylm.caster { hides = ball(ylm), at = { 0 / 0, 0, 0 } } end, says = "at must be three numbers" },
    { call = function(ylm) ylm.caster { hides = ball(ylm), rotation = { 1, 0, 0 } } end, says = "rotation must be { axis" },
    { call = function(ylm)
      local lamp = ylm.sphere_light { at = { 0, 0, 3 } }
      ylm.caster { hides = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 1, lmax = 1 }, lamp) }
    end, says = "hides must be a visibility, and this grid holds lights" },
    { call = function(ylm)
      local b = ball(ylm)
      b:close()
      ylm.caster { hides = b }
    end, says = "hides: the occluder has been closed" },
    { call = function(ylm)
      ylm.caster { hides = ylm.bake(ylm.uniform_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, cells = 1, lmax = 1,
        channels = "luminance" }, ball(ylm)) }
    end, says = "within its radius of 1" },
  },
  casters = {
    { call = function(ylm) ylm.casters { hides = ball(ylm), at = { 1, 2 } } end, says = "at must be %[n%]%[3%] numbers" },
    { call = function(ylm) ylm.casters { hides = ball(ylm), at = { { 1, 2, 3 } }, rotation = { 0, 0, 0, 0 } } end,
      says = "quaternion 1 has no length" },
    { call = function(ylm) ylm.casters { hides = ball(ylm), at = { { 1, 2, 3 } }, scale = { 1, 2 } } end,
      says = "scale must be a number or one for each of the 1 casters" },
    { call = function(ylm) ylm.casters { hides = ball(ylm), at = ylm.zeros { 65536, 3 } } end, says = "at most 65535 casters" },
    { call = function(ylm) ylm.shadowed { lights = {}, casters = ylm.casters { hides = ball(ylm), at = { { 0, 0, 0 } }, scale = -1 } } end,
      says = "caster 1: scale must be above 0" },
  },
  sphere_casters = {
    { call = function(ylm) ylm.sphere_casters { at = { { 0, 0, 0 } } } end, says = "field 'radius' is missing" },
    { call = function(ylm) ylm.sphere_casters { at = { { 0, 0, 0 } }, radius = 1, body = 0 } end, says = "body 1 must be an integer" },
    { call = function(ylm) ylm.shadowed { lights = {}, casters = { ylm.sphere_casters { at = { { 0 / 0, 0, 0 } }, radius = 1 } } } end,
      says = "caster 1 is not finite" },
    { call = function(ylm) ylm.shadowed { lights = {}, casters = { ylm.sphere_casters { at = { { 0, 0, 0 } }, radius = 0 } } } end,
      says = "caster 1: scale must be above 0" },
  },
  shadowed = {
    { call = function(ylm) ylm.shadowed { casters = {} } end, says = "field 'lights' is missing" },
    { call = function(ylm) ylm.shadowed { lights = {}, casters = 7 } end, says = "casters must be a caster or a table" },
    { call = function(ylm) ylm.shadowed { lights = {}, casters = { b = ball(ylm) } } end, says = "a caster expected as 'b'" },
    { call = function(ylm) ylm.shadowed { lights = ball(ylm), casters = {} } end, says = "a visibility is no light" },
    { call = function(ylm) ylm.shadowed { lights = {}, casters = caster(ylm), product = "log" } end, says = "product must be one of" },
    { call = function(ylm)
      ylm.shadowed { lights = {}, casters = ylm.casters { hides = ball(ylm), at = ylm.zeros { 16, 3 } }, product = "accurate" }
    end, says = "product 'accurate' is for 15 casters at most, got 16" },
    { call = function(ylm) ylm.light_field(2, ylm.shadowed { lights = {}, casters = caster(ylm) }, { 0, 0, 3 }, { derivatives = 2 }) end,
      says = "shadowed light has no Hessians" },
    { call = function(ylm) ylm.light_field(2, ylm.shadowed { lights = {}, casters = caster(ylm) }, { 0 / 0, 0, 3 }) end,
      says = "not finite" },
    { call = function(ylm)
      local b = ball(ylm)
      local shade = ylm.shadowed { lights = ylm.environment_light { radiance = 1 }, casters = ylm.caster { hides = b } }
      b:close()
      ylm.light_field(2, shade, { 0, 0, 3 })
    end, says = "closed" },
  },
  ["shadowed:move"] = {
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = { ball = caster(ylm) } }):move { bal = {} } end,
      says = "no caster has the name 'bal' %(did you mean 'ball'%?%)" },
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = { ball = caster(ylm) } }):move { ball = { at = 7 } } end,
      says = "ball: at must be three numbers" },
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = { ball = caster(ylm) } }):move { ball = { size = 7 } } end,
      says = "no field 'size'" },
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = { ball = caster(ylm) } }):move(7) end,
      says = "a table of places by name expected" },
  },
  ["shadowed:without"] = {
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = { ball = caster(ylm) } }):without "bal" end,
      says = "no caster has the name 'bal'" },
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = { ball = caster(ylm) } }):without("ball"):without "ball" end,
      says = "ask the shadowed light that it is of" },
    { call = function(ylm) ylm.shadowed({ lights = {}, casters = {} }).without(7) end, says = "shadowed light expected before the colon" },
  },
  ["shadowed:surfaces"] = {
    { call = function(ylm)
      local shade = ylm.shadowed { lights = {}, casters = {} }
      shade:close()
      shade:surfaces()
    end, says = "the shadowed light has been closed" },
    { call = function(ylm) ylm.caster { hides = ball(ylm), surface = 7 } end, says = "surface must be a shape" },
  },
  ["shadowed:close"] = {
    { call = function(ylm)
      local shade = ylm.shadowed { lights = {}, casters = {} }
      shade:close()
      shade:move {}
    end, says = "the shadowed light has been closed" },
  },
  visibility = {
    { call = function(ylm) ylm.visibility(101, {}, { 0, 0, 0 }) end, says = "lmax must be an integer from 0 to 100" },
    { call = function(ylm) ylm.visibility(2, 7, { 0, 0, 0 }) end, says = "casters must be a caster" },
    { call = function(ylm) ylm.visibility(2, {}, { 0, 0, 0 }, { rule = 1 }) end, says = "rule must be a number >= 2" },
  },
}
