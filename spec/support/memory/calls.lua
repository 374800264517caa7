-- The public interface in small calls, for memory that runs out in each of them: name -> function(keep) that makes
-- what the call needs and returns the call. keep(name) names a file that is removed afterwards.

local core = require "ylm.c.core"
local ylm = require "ylm"

local calls = {}
local _ = ylm.mesh -- methods of meshes

local function points(n)
  local list = {}
  for i = 1, n do list[i] = { (i * 0.37) % 1, (i * 0.61) % 1, (i * 0.83) % 1 - 0.5 } end
  return list
end

local function coefficients(rows, lmax) return ylm.sh.random(rows, lmax, { seed = 3 }) end

local function lamps(n)
  local at = {}
  for i = 1, n do at[i] = { (i * 0.37) % 1, 2 + (i * 0.61) % 1, (i * 0.83) % 1 } end
  return ylm.sphere_lights { at = at, radius = 0.1, radiance = 3 }
end

local function triangle() return ylm.polygon_light { vertices = { { -1, 2, -1 }, { 1, 2, -1 }, { 0, 2, 1 } } } end
local function disk() return ylm.disk_light { at = { 0, 2, 0 }, normal = { 0, -1, 0 } } end

local frame = { corner = { 0, 2, 0 }, u = { 1, 0, 0 }, v = { 0, 0, 1 } }
local function panel(method, image)
  local fields = { method = method, image = image or { { 1, 2 }, { 4, 8 } } }
  for name, value in pairs(frame) do fields[name] = value end
  return ylm.textured_light(fields)
end

local function picture(w, h)
  local x = ylm.image { size = { w, h }, layers = { { "radiance", 3 }, { "depth", 1 } } }
  x:fill(1, 1, w, h, { 1, 2, 3 })
  x.metadata.camera = "none"
  return x
end

local bounds = { { -1, -1, -1 }, { 1, 1, 1 } }
local lamp = { at = { 0, 1.5, 0 }, radius = 0.1, radiance = { 4, 5, 6 } }
local function few() return { ylm.sphere_light(lamp), lamps(3) } end
local function uniform(more)
  local fields = { bounds = bounds, cells = 2, lmax = 2 }
  for name, value in pairs(more or {}) do fields[name] = value end
  return ylm.uniform_grid(fields)
end
local function adaptive(more)
  local fields = { bounds = bounds, depth = 2, lmax = 2 }
  for name, value in pairs(more or {}) do fields[name] = value end
  return ylm.adaptive_grid(fields)
end

local text = [[
return scene "small" {
  camera = camera { from = { 3, 2, 3 } },
  geometry = { quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 2 },
    sphere { radius = 0.5, divide = { 8, 4 } },
    mesh { vertices = { { 0, 1, 0 }, { 1, 1, 0 }, { 0, 2, 0 } }, triangles = { { 1, 2, 3 } } } },
  lights = { sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 5 },
    sphere_lights { at = { { 0, 2, 1 }, { 1, 2, 0 } } },
    polygon_light { vertices = { { -1, 2, -1 }, { 1, 2, -1 }, { 0, 2, 1 } } },
    disk_light { at = { 0, 2, 0 }, normal = { 0, -1, 0 } },
    textured_light { corner = { 0, 2, 0 }, u = { 1, 0, 0 }, v = { 0, 0, 1 }, image = { { 1, 2 }, { 3, 4 } } } },
  probes = adaptive_grid { lmax = 2, depth = 1, tolerance = 0.1 },
}]]

local function scene()
  return ylm.scene "small" {
    camera = ylm.camera { from = { 3, 2, 3 } },
    geometry = { ylm.quad { corner = { -2, -1, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 2 } },
    lights = { ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 5 }, triangle() },
    probes = adaptive { depth = 1, tolerance = 0.1 },
  }
end
local size = { 16, 9 }

--- A call of one function with arguments that are made beforehand.
local function on(make, f)
  return function(keep)
    local made, more = make(keep)
    return function() return f(made, more) end
  end
end

local function of(f) return function() return f end end

calls["array of a table"] = of(function() return ylm.array({ { 1, 2 }, { 3, 4 } }) end)
calls["array of an array"] = on(function() return ylm.zeros { 3, 3 } end, function(a) return ylm.array(a, "float") end)
calls["zeros"] = of(function() return ylm.zeros { 30, 3 } end)
calls["array methods"] = on(function() return ylm.array { { 1, 2 }, { 3, 4 } } end, function(a)
  local copy, message, code = a:clone()
  if not copy then return nil, message, code end
  return { copy[1], a:reshape { 4 }, a:totable() }
end)
calls["array:save"] = on(function(keep) return ylm.zeros { 3, 3 }, keep "a.npy" end, function(a, path) return a:save(path) end)
calls["load .npy"] = on(function(keep) return ylm.zeros { 3, 3 }:save(keep "a.npy") and keep "a.npy" end,
  function(path) return ylm.load(path) end)

local function casters(hides)
  local turn = { axis = { 1, 2, 3 }, angle = 30 }
  local a, message, code = ylm.caster { hides = hides, at = { 0, 0, 2 }, rotation = turn }
  if not a then return nil, message, code end
  local b
  b, message, code = ylm.sphere_casters { at = { { 0.5, 0, 2 } }, radius = 0.4 }
  if not b then return nil, message, code end
  return { a = a, b = b }
end
local function box() return ylm.occluder { geometry = ylm.box {} } end
calls["occluder"] = on(function() return ylm.box {} end, function(geometry) return ylm.occluder { geometry = geometry } end)
calls["visibility"] = on(box, function(hides)
  local all, message, code = casters(hides)
  if not all then return nil, message, code end
  return ylm.visibility(2, all, points(3), { derivatives = 1 })
end)
calls["occluder by rays"] = on(function()
  local mesh = ylm.box {}
  ylm.occluder({ geometry = mesh, rays = 4 }):close() -- loads the library
  return mesh
end, function(geometry)
  local body, message, code = ylm.occluder { geometry = geometry, rays = 4 }
  if not body then return nil, message, code end
  local V
  V, message, code = ylm.light_field(2, body, { { 0, 0, 2 } }, { channels = "luminance", derivatives = 1, threads = 1 })
  if not V then return nil, message, code end
  return body:noise(2, { threads = 1 })
end)
calls["shadowed"] = on(function()
  return box(), { ylm.sphere_light { at = { 0, 0, 4 } }, ylm.environment_light { radiance = 1 } }
end, function(hides, lights)
  local all, shade, L, message, code
  all, message, code = casters(hides)
  if not all then return nil, message, code end
  shade, message, code = ylm.shadowed { lights = lights, casters = all }
  if not shade then return nil, message, code end
  L, message, code = ylm.light_field(2, shade, points(3), { derivatives = 1 })
  if not L then return nil, message, code end
  return shade:move { a = { at = { 0, 1, 2 } } }
end)
calls["sh.eval"] = of(function()
  return ylm.sh.eval(4, { { 1, 2, 3 }, { 0, 0, 1 } }, { derivatives = 2, dtype = "float", threads = 1 })
end)
for _, method in ipairs { "sloan", "direct", "polynomial" } do
  calls["sh.eval " .. method] = of(function() return ylm.sh.eval(3, { 1, 2, 3 }, { method = method }) end)
end
calls["sh.eval solid"] = of(function() return ylm.sh.eval(3, points(4), { solid = true, derivatives = 1 }) end)
calls["sh.reconstruct"] = on(function() return coefficients(3, 4) end,
  function(c) return ylm.sh.reconstruct(c, { { 1, 2, 3 }, { 0, 0, 1 } }) end)
local function sky(_, y) return y > 0 and y or 0 end
calls["sh.project"] = of(function() return ylm.sh.project(2, sky, { samples = 128 }) end)
calls["sh.project by chance"] = of(function()
  return ylm.sh.project(2, sky, { method = "montecarlo", samples = 100 })
end)
calls["sh.project of samples"] = of(function()
  local nine = { 1, 2, 3, 4, 5, 6, 7, 8, 9 }
  return ylm.sh.project(1, { directions = points(9), values = nine, weights = nine })
end)
calls["sh.project of an image"] = on(function() return picture(8, 4) end, function(x) return ylm.sh.project(2, x) end)
for _, r in ipairs { "fast", "matrix", "reference" } do
  calls["sh.rotate " .. r] = on(function() return coefficients(2, 3) end, function(c)
    if r == "fast" then return ylm.sh.rotate(c, { axis = { 1, 2, 3 }, angle = 1 }) end
    if r == "reference" then return ylm.sh.rotate(c, { axis = { 1, 2, 3 }, angle = 1 }, { method = "reference" }) end
    local rotation, message, code = ylm.sh.rotation(3, { zyz = { 1, 2, 3 } })
    if not rotation then return nil, message, code end
    local block
    block, message, code = rotation:block(2)
    if not block then return nil, message, code end
    return ylm.sh.rotate(c, rotation)
  end)
end
for _, method in ipairs { "gaunt", "fourier", "quadrature", "recursive" } do
  calls["sh.product " .. method] = on(function() return { coefficients(2, 2), coefficients(2, 2), coefficients(2, 2) } end,
    function(c) return ylm.sh.product(c[1], c[2], c[3], { method = method }) end)
end
calls["sh.product_matrix"] = on(function() return { coefficients(1, 2)[1], coefficients(2, 2) } end, function(c)
  local M, message, code = ylm.sh.product_matrix(c[1], 2)
  if not M then return nil, message, code end
  return ylm.sh.apply(M, c[2])
end)
calls["sh.product rule"] = on(function() return { coefficients(2, 2), coefficients(2, 2) } end,
  function(c) return ylm.sh.product(c[1], c[2], { rule = 3 }) end)
calls["sphere_set"] = on(function() return ylm.box {} end, function(geometry) return ylm.sphere_set(geometry,
  { count = 1 }) end)
calls["visibility by exponentials"] = on(function() return ylm.sphere_casters { at = { { 2, 0, 0 } }, radius = 1 } end,
  function(spheres) return ylm.visibility(1, spheres, points(3), { derivatives = 1, product = "exp", exp = "PS" }) end)
calls["sh.circle_log"] = of(function()
  local g, message, code = ylm.sh.circle_log(1, { 1, 2, 3 }, 0.5)
  if not g then return nil, message, code end
  return ylm.sh.exp(g, { method = "HYB" })
end)
calls["sh.log"] = on(function() return ylm.array { 4, 0.1, 0.2, -0.1 } end, function(c)
  local g, message, code = ylm.sh.log(c)
  if not g then return nil, message, code end
  return ylm.sh.exp(g)
end)
for _, name in ipairs { "convolve", "window", "irradiance", "dering", "convert", "resize", "summary" } do
  calls["sh." .. name] = on(function() return coefficients(2, 3) end, function(c)
    local second = { convolve = { 1, 0.5, 0.25, 0.1 }, window = "hann", convert = "plain", resize = 5, irradiance = { 0, 0,
      1 } }
    return ylm.sh[name](c, second[name])
  end)
end
calls["sh.zonal"] = of(function() return ylm.sh.zonal({ 0, 1, 0.3 }, { 0, 1, 0 }) end)
calls["sh.cap"] = of(function() return ylm.sh.cap(4, { 0, 1, 0 }, 0.3) end)
calls["sh.zonal_irradiance"] = of(function() return ylm.sh.zonal_irradiance({ 1, 2, 3 }, 0.8) end)
calls["sh.random"] = of(function() return ylm.sh.random(4, 3, { seed = 2 }) end)
calls["sh.relative_error"] = of(function() return ylm.sh.relative_error({ { 3, 5 } }, { { 3, 4 } }) end)
calls["sh.sky"] = of(function() return ylm.sh.sky(4, { kind = "clear", sun = { 1, 0, 1 } }) end)

calls["sphere_lights"] = of(function()
  local l, message, code = lamps(9)
  if not l then return nil, message, code end
  return l.count
end)
local function a_light(make)
  return of(function()
    local l, message, code = make()
    if not l then return nil, message, code end
    return ylm.light_field(2, l, { 0, 0, 0 })
  end)
end
calls["polygon_light"], calls["disk_light"] = a_light(triangle), a_light(disk)
calls["textured_light"] = a_light(function() return panel() end)
calls["textured_light exact"] = a_light(function() return panel "exact" end)
calls["textured_light of a file"] = function(keep)
  assert(picture(4, 2):save(keep "t.exr"))
  return function()
    local l, message, code = ylm.textured_light { corner = { 0, 2, 0 }, u = { 1, 0, 0 }, v = { 0, 0, 1 }, file = keep "t.exr" }
    if not l then return nil, message, code end
    return l.count
  end
end
calls["light_field"] = on(function() return { few(), triangle(), triangle(), disk(), panel() } end, function(l)
  return ylm.light_field(2, l, points(5), { derivatives = 2, metric = "rgb" })
end)
calls["light_field of nothing"] = of(function() return ylm.light_field(2, {}, { 0, 0, 0 }) end)
calls["light_field to a tolerance"] = on(function() return { few(), lamps(400), triangle() } end, function(l)
  return ylm.light_field(2, l, points(20), { tolerance = 0.01, derivatives = 1 })
end)

calls["bake uniform"] = on(few, function(l) return ylm.bake(uniform(), l) end)
calls["bake uniform, one light"] = on(triangle, function(l) return ylm.bake(uniform { metric_channels = "none" }, l) end)
calls["bake to a tolerance"] = on(few, function(l)
  return ylm.bake(adaptive { tolerance = 0.05 }, l, { occupied = points(50) })
end)
calls["bake by a threshold"] = on(few, function(l)
  return ylm.bake(adaptive { threshold = 0.5, continuous = false }, l, { occupied = points(50) })
end)
calls["bake with a tree"] = on(function() return { few(), lamps(200) } end, function(l)
  return ylm.bake(adaptive { threshold = 0.5 }, l, { occupied = points(50), sums_tolerance = 0.01 })
end)
calls["bake dynamic"] = on(function() return { few(), triangle() } end, function(l)
  return ylm.bake(adaptive { tolerance = 0.05, dynamic = true }, l, { occupied = points(50) })
end)
calls["bake dynamic uniform"] = on(few, function(l) return ylm.bake(uniform { dynamic = true }, l) end)
local function linear(p, lmax, channels)
  local n = #p
  local value = ylm.zeros({ n, channels, (lmax + 1) ^ 2 }, p.dtype)
  local gradient = ylm.zeros({ n, channels, (lmax + 1) ^ 2, 3 }, p.dtype)
  for i = 1, n do value:set(i, 1, 1, 3 + p:get(i, 1)) gradient:set(i, 1, 1, 1, 1) end
  return value, gradient
end
calls["bake of a function"] = of(function()
  return ylm.bake(uniform { metric_channels = "none", channels = "luminance" }, linear)
end)
local function grid() return ylm.bake(adaptive { tolerance = 0.1 }, few(), { occupied = points(50) }) end
calls["bake of a grid"] = on(grid, function(g) return ylm.bake(uniform { metric_channels = "none" }, g) end)
calls["grid:sample"] = on(grid, function(g) return g:sample(points(9), { derivatives = 1 }) end)
calls["bake in bricks, grid_set:sample"] = on(function(keep) return few(), keep "g.ylmd" end, function(light, folder)
  local description = adaptive { threshold = 1, depth = 3, bricks = 1, lmax = 1 }
  local g, message, code = ylm.bake(description, light, { folder = folder, threads = 1 })
  local c
  if g then c, message, code = g:sample(points(9), { derivatives = 1 }) end
  os.execute("rm -r " .. folder)
  return c, message, code
end)
calls["grid:points"] = on(grid, function(g) return g:points() end)
calls["grid:cells"] = on(grid, function(g) return g:cells() end)
calls["grid:locate"] = on(grid, function(g) return g:locate { 0, 0, 0 } end)
calls["grid:save"] = on(function(keep) return grid(), keep "g.ylm" end, function(g, path) return g:save(path) end)
calls["grid:save .html"] = on(function(keep) return grid(), keep "g.html" end, function(g, path) return g:save(path) end)
calls["grid:save .html of a scene"] = on(function(keep) return { grid(), scene() }, keep "h.html" end, function(both, path)
  return both[1]:save(path, { scene = both[2], size = { 8, 8 } })
end)
calls["grid:save .vtu"] = on(function(keep) return grid(), keep "g.vtu" end, function(g, path) return g:save(path) end)
local function few_cells(name, dering)
  return on(function(keep) return ylm.bake(uniform {}, few()), keep(name) end,
    function(g, path) return g:export(path, { cells = { 2, 2, 2 }, points = points(9), dering = dering }) end)
end
calls["grid:export .ktx2"] = few_cells "g.ktx2"
calls["grid:export .three.json"] = few_cells("g.three.json", true)
calls["grid:export .npy"] = on(function(keep) return ylm.bake(uniform {}, few()), keep "e.npy" end,
  function(g, path) return g:export(path, { tolerance = 10, points = points(9) }) end)
calls["save a grid in few bytes"] = on(function(keep) return grid(), keep "s.ylm" end, function(g, path)
  return g:save(path, { step = 0.1 })
end)
calls["load a grid in few bytes"] = on(function(keep)
  return assert(grid():save(keep "s.ylm", { step = 0.1 })) and keep "s.ylm"
end, function(path) return ylm.load(path) end)
calls["slow: save bricks in few bytes"] = on(function(keep) return few(), keep "f.ylmd" end, function(light, path)
  local description = adaptive { threshold = 1, depth = 3, bricks = 1, lmax = 1 }
  local set, message, code = ylm.bake(description, light, { folder = path, threads = 1, occupied = points(1) })
  local ok, c
  if set then ok, message, code = set:save(path .. "/few.ylmd", { step = 0.1 }) end
  if ok then c, message, code = ylm.load(path .. "/few.ylmd") end
  if c then c, message, code = c:sample(points(9)) end
  os.execute("rm -rf " .. path)
  return c, message, code
end)
calls["load a grid"] = on(function(keep) return grid():save(keep "g.ylm") and keep "g.ylm" end,
  function(path) return ylm.load(path) end)

calls["image"] = of(function()
  return ylm.image { size = { 4, 2 }, layers = { { "radiance", 3 }, { "depth", 1 } }, metadata = { name = "x" } }
end)
calls["image:add"] = of(function()
  local x, message, code = ylm.image { size = { 4, 2 }, layers = { { "radiance", 3 }, { "depth", 1 } } }
  if not x then return nil, message, code end
  local layer
  layer, message, code = x:add("more", 2)
  if not layer then
    assert(#x:layers() == 2) -- as it was
    return nil, message, code
  end
  return x
end)
calls["image methods"] = on(function() return picture(8, 8), picture(4, 4) end, function(x, part)
  local out = {}
  x:fill(1, 1, 8, 8, { 1, 2, 3 })
  for _, call in ipairs {
    function() return x:crop(2, 2, 4, 4) end, function() return x:resize({ 4, 4 }, { filter = "lanczos" }) end,
    function() return x:paste(part, 2, 2) end, function() return x:fill(1, 1, 2, 2, { 1, 2, 3 }) end,
    function() return x:text(1, 1, "a") end, function() return x:colours { layer = "depth", range = { 0, 1 } } end,
    function() return x:compare(x) end, function() return x:difference(x) end, function() return x:layer "depth" end,
    function() return part:directions { mapping = "angular" } end,
    function() return part:positions({ { 0, 0, 1 } }, { mapping = "angular" }) end,
  } do
    local result, message, code = call()
    if result == nil then return nil, message, code end
    out[#out + 1] = result
  end
  return out
end)
for _, kind in ipairs { "exr", "png", "hdr", "pfm" } do
  calls["image:save ." .. kind] = on(function(keep) return picture(4, 2), keep("x." .. kind) end,
    function(x, path) return x:save(path) end)
  calls["load ." .. kind] = on(function(keep) return picture(4, 2):save(keep("x." .. kind)) and keep("x." .. kind) end,
    function(path) return ylm.load(path) end)
end

calls["shapes"] = of(function()
  local out = {}
  for _, name in ipairs { "box", "torus", "knot", "sphere" } do
    local shape, message, code = ylm[name] { divide = name == "box" and 2 or { 32, 8 }, at = { 0, 1, 0 },
      rotate = { axis = { 0, 1, 0 }, angle = 30 } }
    if not shape then return nil, message, code end
    out[#out + 1] = shape.mesh
  end
  return out
end)
local corners = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }
calls["mesh"] = of(function()
  local m, message, code = ylm.mesh { vertices = corners.vertices, triangles = corners.triangles,
    normals = { { 0, 0, 1 }, { 0, 0, 1 }, { 0, 0, 1 } }, uvs = { { 0, 0 }, { 1, 0 }, { 0, 1 } } }
  if not m then return nil, message, code end
  return m.mesh
end)
calls["mesh methods"] = on(function(keep) return ylm.mesh(corners).mesh, keep "m.ply" end, function(m, path)
  local out = {}
  for _, call in ipairs { m.vertices, m.normals, m.triangles, function() return m:save(path) end,
    function() return ylm.load(path) end } do
    local result, message, code = call(m)
    if result == nil then return nil, message, code end
    out[#out + 1] = result
  end
  return out
end)
calls["load .obj"] = function(keep)
  local file = assert(io.open(keep "m.obj", "w"))
  file:write "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n"
  file:close()
  return function() return ylm.load(keep "m.obj") end
end
calls["mesh of an OBJ file with materials"] = function(keep)
  local function write(name, content)
    local file = assert(io.open(keep(name), "w"))
    file:write(content)
    file:close()
  end
  assert(picture(2, 2):save(keep "t.png"))
  write("r.mtl", "newmtl a\nKd 0.5\nmap_Kd t.png\nillum 1\nnewmtl b\nKd 1\nKs 1\nNs 9\nnewmtl c\nKe 4\n")
  write("r.obj", "mtllib r.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n"
    .. "usemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n")
  return function()
    local m, message, code = ylm.mesh { file = keep "r.obj", at = { 0, 1, 0 } }
    if not m then return nil, message, code end
    return { m.mesh, #m.parts, #m.emitters, m.parts[1].mesh, #m.notes }
  end
end
calls["matte with a texture"] = on(function()
  local x = ylm.image { size = { 2, 2 } }
  x:fill(1, 1, 2, 2, { 0.5, 1, 0 })
  return x
end, function(x)
  local m, message, code = ylm.matte { albedo = x }
  if not m then return nil, message, code end
  return { m.albedo[1] }
end)

calls["rgl of a file"] = function(keep)
  local files = require "spec.support.brdf_files"
  files.write(keep "m.bsdf", files.tensor(files.constant_fields { 0.5, 0.4, 0.3 }))
  return function()
    local m, message, code = ylm.load(keep "m.bsdf")
    if not m then return nil, message, code end
    return m:eval({ 0, 0, 1 }, { 0.6, 0, 0.8 })
  end
end

--- A file of a lamp, a textured surface and one that emits.
local function write_gltf(path)
  local gltf = require "spec.support.gltf"
  local f = gltf.new()
  local image = ylm.image { size = { 2, 2 } }
  assert(image:save(path .. ".png"))
  local attributes = { POSITION = f:accessor("VEC3", 5126, { 0, 0, 0, 1, 0, 0, 0, 1, 0 }),
    TEXCOORD_0 = f:accessor("VEC2", 5126, { 0, 0, 1, 0, 0, 1 }) }
  local json = f:text { nodes = { { mesh = 0 }, { mesh = 0, extensions = { KHR_lights_punctual = { light = 0 } } } },
    meshes = { { primitives = { { attributes = attributes, material = 0 }, { attributes = attributes, material = 1 } } } },
    materials = { { name = "a", pbrMetallicRoughness = { baseColorTexture = { index = 0 } } }, { emissiveFactor = { 1, 1,
      1 } } },
    textures = { { source = 0 } }, images = { { uri = path:match "[^/]*$" .. ".png" } },
    extensions = { KHR_lights_punctual = { lights = { { type = "point" } } } } }
  local file = assert(io.open(path, "w"))
  file:write(json)
  file:close()
end

if select(3, ylm.gltf { file = "/nonexistent.glb" }) ~= "EMISSING" then
  calls["load of glTF"] = function(keep)
    write_gltf(keep "m.gltf")
    keep "m.gltf.png"
    return function()
      local m, message, code = ylm.load(keep "m.gltf")
      assert(m == nil or #m.report.notes > 0 and #m.lights == 3 or code == "ENOMEM", message)
      return m, message, code
    end
  end
  calls["load of glTF in groups"] = function(keep)
    write_gltf(keep "n.gltf")
    keep "n.gltf.png"
    return function()
      local m, message, code = ylm.load(keep "n.gltf", { textures = 4 })
      assert(m == nil or #m.geometry > 0 or code == "ENOMEM", message)
      return m, message, code
    end
  end
end
calls["scene to glTF"] = function(keep)
  local given = ylm.scene "x" { geometry = ylm.box {}, lights = { few(), triangle(), disk() } }
  return function() return given:save(keep "m.glb") end
end
calls["scene like another"] = function()
  local given = ylm.scene "x" { geometry = ylm.box {}, lights = { few(), triangle() } }
  return function() return ylm.scene "y" { like = given, moved = { [3] = { radius = 0.2 } }, removed = { 2 } } end
end
calls["load of a scene file"] = function(keep)
  local file = assert(io.open(keep "s.lua", "w"))
  file:write(text)
  file:close()
  return function()
    local s, message, code = ylm.load(keep "s.lua")
    if not s then return nil, message, code end
    return { s.name, #s.geometry, #s.lights }
  end
end
calls["scene"] = on(triangle, function(light)
  local s, message, code = ylm.scene "one light" { lights = light }
  return s and s.name, message, code
end)
calls["scene:bake with sides"] = on(scene, function(s)
  return s:bake { quantity = "indirect", probes = ylm.adaptive_grid { lmax = 0, depth = 1, tolerance = 0.9 } }
end)
calls["probes: file, and read"] = function(keep)
  local s, path = scene(), keep "p.ylmp"
  local baked = assert(s:bake { quantity = "indirect", probes = ylm.adaptive_grid { lmax = 1, depth = 1, threshold = 0.9 } })
  return function()
    local report, message, code = baked:export(path, { scene = s, anyway = true })
    if not report then return nil, message, code end
    local file = assert(io.open(path, "rb"))
    local bytes = file:read "*a"
    file:close()
    local probes
    probes, message, code = core.probes_decode(bytes, path)
    return probes and #bytes, message, code
  end
end
calls["surface: grid"] = on(scene, function(s)
  local links, message, code = s:links { spacing = 2, rays = 4 }
  if not links then return nil, message, code end
  local light, report
  light, message, code = s:surface_grid { tolerance = 1, corners = 16, judge = "field", rays = 4, links = links }
  if not light then return nil, message, code end
  report, message, code = light:update()
  return report and light.stats.corners, message, code
end)
calls["lightmap: made, divided and saved"] = on(scene, function(s)
  local links, message, code = s:links { spacing = 2, rays = 4 }
  if not links then return nil, message, code end
  local light
  light, message, code = s:lightmap { texels = 300, rays = 4, light_samples = 1, directional = true, links = links }
  if not light then return nil, message, code end
  for _, ending in ipairs { ".glb", ".html" } do
    local name = os.tmpname()
    local ok, why, what = light:save(name .. ending, { lit = ending == ".glb" or nil })
    for _, left in ipairs { "", ending, ".exr", "_x.exr", "_y.exr", "_z.exr" } do os.remove(name .. left) end
    if not ok then return nil, why, what end
  end
  return light.stats.charts
end)
calls["scene:bake"] = on(scene, function(s) return s:bake { occupied = "camera", samples = 1, size = size } end)
for _, name in ipairs { "render", "reference", "raycast" } do
  calls["scene:" .. name] = on(scene, function(s)
    return s[name](s, { size = size, samples = 1, light_samples = name ~= "reference" and 2 or nil })
  end)
end
calls["scene:render transfer"] = on(scene, function(s) return s:render { size = size, samples = 1,
  visibility = "transfer" } end)
calls["glossy surfaces"] = on(scene, function(s)
  s.geometry[1].material = ylm.phong { exponent = 4 }
  return s:render { by = "sum", size = size, samples = 1, lmax = 1, gloss = "sh", transfer_samples = 8 }
end)
calls["glossy surfaces, by rays too"] = on(scene, function(s)
  s.geometry[1].material = ylm.phong { exponent = 4 }
  return s:render { by = "sum", size = size, samples = 1, lmax = 1, gloss = "auto", transfer_samples = 8, light_samples = 2,
    gloss_error = { 0.1, 1 } }
end)
calls["virtual lights of a scene, gathered"] = on(scene, function(s)
  local lights, message, code = s:virtual_lights { count = 8, particles = 32 }
  if not lights then return nil, message, code end
  local view
  view, message, code = s:prepare { size = size, samples = 1 }
  if not view then return nil, message, code end
  return view:render { by = "none", bounced = lights, rival = { "vpl", compensate = 2 } }
end)
calls["slow: virtual lights, merged and interleaved"] = on(scene, function(s)
  s.geometry[1].material = ylm.phong { exponent = 4 }
  local lights, message, code = s:virtual_lights { merge = 8, particles = 40, degree = 2 }
  if not lights then return nil, message, code end
  local view
  view, message, code = s:prepare { size = size, samples = 1, gloss = "matte" }
  if not view then return nil, message, code end
  local image
  image, message, code = view:render { by = "none", bounced = lights, virtual = { subset = "stochastic" } }
  if not image then return nil, message, code end
  return view:render { by = "none", bounced = lights, virtual = { subset = "interleaved", tile = 2 } }
end)
calls["virtual lights by parts, in a picture"] = on(scene, function(s)
  return s:render { size = size, samples = 1, light_samples = 1, layers = false, bounced = "virtual", bounces = 1,
    virtual = { sums = "split", tolerance = 1 } }
end)
calls["virtual lights by their tree"] = on(function()
  local at, normal = {}, {}
  for i = 1, 600 do at[i], normal[i] = { i % 10, math.floor(i / 10) % 10, i / 100 }, { 0, 0, 1 } end
  return { at, normal }
end, function(both)
  local lights, message, code = ylm.virtual_lights { at = both[1], normal = both[2], radius = 0.2, intensity = 1 }
  if not lights then return nil, message, code end
  return ylm.light_field(0, lights, { { 3, 4, 20 } }, { tolerance = 0.1 })
end)
calls["virtual lights, far and near"] = on(function()
  return ylm.virtual_lights { at = { { 0, 0, 0 } }, radius = 0.2, intensity = 1 }
end, function(lights)
  local far, near, code = lights:split { core = 1 }
  if not far then return nil, near, code end
  return near:irradiance({ { 0, 0, 0.5 } }, { { 0, 0, -1 } })
end)
calls["virtual lights with their shadows"] = on(scene, function(s)
  local lights, message, code = ylm.virtual_lights { at = { { 0, 3, 0 }, { 1, 3, 0 } }, radius = 0.2, intensity = 1 }
  if not lights then return nil, message, code end
  local field
  field, message, code = lights:visible(s)
  if not field then return nil, message, code end
  return ylm.light_field(1, field, { { 0, 2, 0 }, { 0, 2, 1 } }, { derivatives = 1 })
end)
for _, how in ipairs { "ssao", "rays" } do
  calls["ambient by " .. how] = on(scene, function(s)
    return s:render { size = size, samples = 1, light_samples = 2, ambient = how, bounces = 0 }
  end)
end
local function many_lamps()
  local at = {}
  for i = 1, 300 do at[i] = { i / 100, 1, 0 } end
  return ylm.sphere_lights { at = at, radius = 0.01 }
end
calls["scene:render with other lamps"] = on(function()
  local s = scene()
  assert(s:render { bounces = 0, size = size, samples = 1, light_samples = 1 })
  return s
end, function(s)
  local others, message, code = many_lamps()
  if not others then return nil, message, code end
  s.lights[1] = others -- meshes stay
  return s:render { bounces = 0, size = size, samples = 1, light_samples = 2 }
end)
calls["prepared by rays"] = on(scene, function(s)
  local view, message, code = s:prepare { size = size, samples = 1 }
  if not view then return nil, message, code end
  local image
  image, message, code = view:render { light_samples = 2 }
  if image == nil then assert(view:points() or view:points()) end -- still usable
  view:close()
  return image, message, code
end)
calls["prepared"] = on(scene, function(s)
  local view, message, code = s:prepare { size = size, samples = 1, visibility = "transfer" }
  if not view then return nil, message, code end
  local out = {}
  for _, call in ipairs { { "points" }, { "transfer" }, { "render", { by = "sum" } }, { "render", { by = "rays" } } } do
    local result
    result, message, code = view[call[1]](view, call[2])
    if result == nil then
      assert(view:points() or view:points()) -- still usable
      return nil, message, code
    end
    out[#out + 1] = result
  end
  view:close()
  return out
end)
calls["true_error"] = on(function() return picture(4, 2), picture(4, 2) end, function(a, b) return ylm.true_error(a, b) end)

calls["team"] = function()
  local a = ylm.array { 1, 2, 3 }
  return function()
    return ylm.team():each({ { n = 1, list = { "a", true } }, { n = 2 } }, function(case) return { case, a } end)
  end
end
calls["team with a journal"] = function(keep)
  local path = keep "sweep.journal"
  return function()
    return ylm.team():each({ 1, 2 }, function(i) return i end, { journal = path })
  end
end

local looks = {
  ["view of a grid"] = function() return ylm.view { grid(), quantity = "L00", slices = true, levels = true } end,
  ["view of cells"] = function() return ylm.view { grid(), boxes = true, volume = true, frame = true } end,
  ["view of lights"] = function()
    return ylm.view { grid(), levels = true, lights = { ylm.sphere_light(lamp), triangle(), panel() } }
  end,
  ["view of vectors"] = function() return ylm.view { grid(), glyphs = true, streamlines = { count = 5 }, lobes = true } end,
  ["view of SH"] = function() return ylm.view { sh = coefficients(2, 2) } end,
  plot = function() return ylm.plot { x = { 1, 10, 100 }, y = { 1e-4, 1e-3, 1e-2 }, log = true } end,
  figure = function() return ylm.figure { rows = { { { values = { { 0, 1 }, { 2, 3 } } } } }, bar = { range = { 0, 3 } } } end,
}
for name, make in pairs(looks) do
  calls["picture: " .. name] = on(function(keep)
    local picture_of = assert(make())
    picture_of.size = { 240, 180 }
    return picture_of, keep "p.png"
  end, function(p, path)
    local good, message, code = p:save(path)
    if not good then return nil, message, code end
    return p:pixels()
  end)
end
calls["picture live: scene:live"] = on(scene, function(s)
  return s:live { hidden = true, quiet = true, size = { 64, 48 }, samples = 1, transfer_samples = 4, light_samples = 16,
    save = "unused/live", events = { { 0, "key", "Tab" }, { 0, "key", "l" }, { 1, "key", "Right" }, { 2, "rest" } } }
end)
calls["picture: view as glTF"] = on(function(keep) return ylm.view { sh = coefficients(2, 2) }, keep "p.gltf" end,
  function(v, path) return v:save(path) end)

return calls
