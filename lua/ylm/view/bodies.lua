--- The layers of a view that show bodies: SH lobes, lights, meshes, points.

local core = require "ylm.c.core"
local drawing = require "ylm.view.drawing"
local material = require "ylm.material"
local surfaces = require "ylm.view.surfaces"

local fill = {}

-- Warm where the function is positive, cool where it is negative.
local positive, negative = { 0.96, 0.55, 0.16 }, { 0.16, 0.48, 0.86 }

local function add_lobes(stage, coefficients, lmax, centres, sizes, detail, fit)
  local directions = core.figure_sphere(detail)
  local basis = require("ylm.sh").eval(lmax, directions, { dtype = "double" })
  local shape = core.shape(3)
  drawing.run(core.shape_lobes(shape, { coefficients = coefficients, centre = centres, scale = sizes, positive = positive,
    negative = negative, detail = detail, basis = basis, fit = fit }))
  drawing.surface(stage, shape, { specular = 0.2 })
end

--- Lobes of points that are spread evenly, or of those of a mask with their distance.
function fill.lobes(stage, v)
  local o = drawing.options(v.lobes)
  local position = v.source.position()
  local mask, spacing = o.mask, o.spacing
  if not mask then mask, spacing = drawing.spread(position, v.source.bounds, o.count or 300, v.source.ghost()) end
  local centres = core.figure_pick(position, mask)
  local coefficients = core.figure_pick(v.source.coefficients(), mask)
  local n, count = centres.shape[1], coefficients.shape[2]
  add_lobes(stage, coefficients, math.floor(math.sqrt(count) + 0.5) - 1, centres,
    drawing.constant(n, 0.42 * spacing * (o.size or 1)), n > 600 and 3 or 4, true)
end

--- SH vectors side by side, in rows of at most eight, seen from -y: x to the right, z up.
function fill.sh(stage, v)
  local n, list = v.sh.shape[1], {}
  local columns = math.min(n, math.max(1, math.ceil(math.sqrt(n * 1.8))))
  stage.labels = {}
  for i = 1, n do
    local column, row = (i - 1) % columns, math.floor((i - 1) / columns)
    list[i] = { 2.2 * column, 0, -2.6 * row }
    if v.labels and v.labels[i] then
      stage.labels[#stage.labels + 1] = { text = v.labels[i], at = { 2.2 * column, 0, -2.6 * row - 1.08 } }
    end
  end
  local centres = core.array_zeros({ n, 3 }, "double")
  core.array_fill(centres, list)
  add_lobes(stage, v.sh, v.lmax, centres, drawing.constant(n, 1), 6, true)
  local lowest = -2.6 * math.floor((n - 1) / columns) - (v.labels and 1.35 or 1)
  drawing.grow(stage, { -1, -1, lowest, 2.2 * (columns - 1) + 1, 1, 1 })
end

--- Linear light as a colour on the screen.
local function encode(x)
  x = math.max(0, math.min(1, x))
  return x <= 0.0031308 and 12.92 * x or 1.055 * x ^ (1 / 2.4) - 0.055
end

--- The colour of a light on the screen; a little white keeps saturated ones visible.
local function lit(rgb)
  local most = math.max(rgb[1], rgb[2], rgb[3], 1e-30)
  for a = 1, 3 do rgb[a] = 0.15 + 0.85 * encode(math.max(0, rgb[a]) / most) end
  return rgb
end

--- The tiles of images in the colours of their radiances, the brightest of each image as bright as can be.
local function colour_tiles(rgb, first, images)
  for _, t in ipairs(images) do
    local most = 1e-30
    for i = first, first + t - 1 do most = math.max(most, rgb[i][1], rgb[i][2], rgb[i][3]) end
    for i = first, first + t - 1 do
      for a = 1, 3 do rgb[i][a] = encode(rgb[i][a] / most) end
    end
    first = first + t
  end
end

--- Triangles [t][9], and disks [d][7] as 48-gons, in the colours of radiance [t+d][..]; the last triangles are those of
-- images, whose numbers are listed.
local function add_flat_lights(stage, triangles, disks, radiance, images)
  local position, colour, index = {}, {}, {} -- three rows to a triangle, no corner shared
  local rgb, list = core.array_totable(radiance), core.array_totable(triangles)
  local function corner(x, y, z, c)
    position[#position + 1], colour[#colour + 1] = { x, y, z }, c
    if #position % 3 == 0 then index[#index + 1] = { #position - 2, #position - 1, #position } end
  end
  for i, c in ipairs(rgb) do rgb[i] = { c[1], c[2], c[3] } end
  local plain = #list
  for _, t in ipairs(images) do plain = plain - t end
  colour_tiles(rgb, plain + 1, images)
  for i, t in ipairs(list) do
    local c = i <= plain and lit(rgb[i]) or rgb[i]
    for k = 0, 2 do corner(t[3 * k + 1], t[3 * k + 2], t[3 * k + 3], c) end
  end
  for i, d in ipairs(core.array_totable(disks)) do
    local c = lit(rgb[#list + i])
    local u, w = require "ylm.light.polygon".frame { d[5], d[6], d[7] }
    local function rim(k)
      local a, b = d[4] * math.cos(math.pi * k / 24), d[4] * math.sin(math.pi * k / 24)
      corner(d[1] + a * u[1] + b * w[1], d[2] + a * u[2] + b * w[2], d[3] + a * u[3] + b * w[3], c)
    end
    for k = 0, 47 do
      corner(d[1], d[2], d[3], c)
      rim(k)
      rim(k + 1)
    end
  end
  local function numbers(threes)
    local a = assert(core.array_zeros({ #threes, 3 }, "double"))
    core.array_fill(a, threes)
    return a
  end
  local shape = core.shape(3)
  drawing.run(core.shape_mesh(shape, numbers(position), nil, numbers(colour), numbers(index), 1))
  drawing.surface(stage, shape, { ambient = 1, diffuse = 0, specular = 0 })
end

function fill.lights(stage, v)
  local light = require "ylm.light"
  local packed = core.has_field(v.lights) and v.lights or light.pack(1, "view", v.lights)
  local triangles, disks, flat, images = light.patches(packed, 64)
  if triangles then add_flat_lights(stage, triangles, disks, flat, images) end
  local at, radius, radiance = light.arrays(packed)
  local c, r = core.array_totable(radiance), core.array_totable(radius)
  local least = stage.bounds and drawing.diagonal(stage.bounds) * 0.0022 or 0
  for i, rgb in ipairs(c) do
    lit(rgb)
    r[i] = math.max(r[i], least)
  end
  if #r == 0 then return end
  core.array_fill(radiance, c)
  core.array_fill(radius, r)
  local shape = core.shape(3)
  drawing.run(core.shape_spheres(shape, at, radius, radiance, #r > 3000 and 2 or #r > 50 and 3 or 5))
  drawing.surface(stage, shape, { ambient = 1, diffuse = 0, specular = 0 })
end

--- The colours of vertices that a texture or the mesh itself varies, double [n][3]; nothing where they do not.
local function varying(m)
  local albedo, message, code = material.at_vertices("view", m.material, m.mesh)
  if message then drawing.run(nil, message, code) end
  if not albedo then return nil end
  local rows = core.array_totable(albedo)
  for _, c in ipairs(rows) do
    for i = 1, 3 do c[i] = encode(c[i]) end
  end
  local colours = core.array_zeros({ #rows, 3 }, "double")
  core.array_fill(colours, rows)
  return colours
end

local function add_mesh(stage, m, opacity)
  local mesh = m.mesh
  local position = core.array_convert(mesh:vertices(), "double")
  local normals = mesh:normals()
  normals = normals and core.array_convert(normals, "double")
  local colour = m.colours
  if colour and #colour ~= #position then
    error({ ("meshes: %d colours for %d vertices"):format(#colour, #position), "ESHAPE" }, 0)
  end
  if not colour and not m.colour then colour = varying(m) end
  if not colour then
    local c = m.colour
    if not c and m.material then
      local albedo, message, code = material.albedo("view", m.material)
      drawing.run(albedo, message, code)
      c = { encode(albedo[1]), encode(albedo[2]), encode(albedo[3]) }
    end
    c = c or { 0.66, 0.67, 0.69 }
    colour = core.array_zeros({ 1, 3 }, "double")
    core.array_fill(colour, { c })
  end
  local shape = core.shape(3)
  drawing.run(core.shape_mesh(shape, position, normals, colour, core.array_convert(mesh:triangles(), "double"), 1))
  drawing.surface(stage, shape, { opacity = opacity or m.opacity or 1, specular = 0.1 })
end

function fill.meshes(stage, v)
  for _, m in ipairs(v.meshes) do add_mesh(stage, m) end
end

fill.surfaces = surfaces.fill

function fill.scene(stage, v)
  if v.surfaces then return end -- the same surfaces
  for _, part in ipairs(v.scene.geometry) do
    add_mesh(stage, { mesh = part.mesh, material = part.material }, v.opacity)
  end
end

function fill.points(stage, v)
  local n = v.points.shape[1]
  local b = core.figure_bounds(v.points)
  local colours, list = core.array_zeros({ n, 3 }, "double"), {}
  for i = 1, n do list[i] = stage.theme.text end
  core.array_fill(colours, list)
  local reach = stage.bounds and drawing.diagonal(stage.bounds) or drawing.diagonal(b)
  local shape = core.shape(3)
  local radii = drawing.constant(n, math.max(reach, 1e-6) * 0.003)
  drawing.run(core.shape_spheres(shape, v.points, radii, colours, n > 2000 and 1 or 2))
  drawing.surface(stage, shape)
end

return fill
