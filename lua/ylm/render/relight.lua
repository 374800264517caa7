--- Prepared views that are shaded again: with other light by one dot product, with other materials, from another camera.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local library = require "ylm.library"
local light = require "ylm.light"
local material = require "ylm.material"
local objects = require "ylm.material.object"
local progress = require "ylm.progress"
local sh = require "ylm.sh"
local tracing = require "ylm.trace"
local views = require "ylm.render.view"

local relight = {}

--- Options of scene:prepare.
relight.prepare_fields = {
  { "relight", "choice", of = { "light", "material", "all" }, optional = true,
    about = "what changes from picture to picture of glossy surfaces, gloss = 'sh': 'light': products of slices and "
      .. "visibility are kept, 4 (lmax+1)^2 bytes and more a point, other light costs a dot product; 'material': these are made "
      .. "again where view:render names other materials; 'all': shading points are all vertices, and the camera may move too" },
}

--- Options of pictures by the coefficients of light.
relight.method_fields = {
  { "method", "choice", shelf = "comparison", of = { "table", "nearest", "zonal" }, optional = true,
    about = "of slices of glossy surfaces; 'table', default: cubic between rows; to compare with: 'nearest', one of 90 rows; "
      .. "'zonal': lobes about the mirror direction with the cosine of each lamp's middle, without shadows (by = 'sum')" },
  { "product", "choice", shelf = "comparison", optional = true,
    of = { "auto", "gaunt", "quadrature", "fourier", "brute", "list" },
    about = "the method of sh.product by which slices and visibility are multiplied; default auto" },
}

relight.fields = {
  { "materials", "table", optional = true,
    about = "other materials, by place in scene.geometry: { [2] = ylm.ggx { .. } }; of views prepared with relight = 'material' "
      .. "or 'all'. Matte surfaces stay matte" },
  { "camera", "object", of = "camera", optional = true, about = "another camera, of views prepared with relight = 'all'" },
}

--- Settles the options of scene:prepare; `given`: those that the caller has named.
function relight.settle(name, o, given)
  if not o.relight then return end
  if given.gloss ~= nil and given.gloss ~= "sh" then
    return check.fail("%s: relight = %q is of glossy surfaces by spherical harmonics: gloss = 'sh', or leave gloss out", name,
      o.relight)
  end
  if o.visibility == "rays" then
    return check.fail("%s: relight = %q is of transfer vectors, visibility is 'rays': 'transfer' or 'none', or leave one out",
      name, o.relight)
  end
  o.gloss = "sh"
  if o.relight ~= "all" then return end
  if given.shading ~= nil and given.shading ~= "vertices" then
    return check.fail("%s: relight = 'all' shades vertices, which every camera sees: shading = 'vertices', or leave shading out",
      name)
  end
  o.shading = "vertices"
end

--- The materials of a change, by mesh: userdata or false; a key that tells them from others; or nil, message, code.
local function dressed(name, p, given)
  local out, key, n = {}, {}, #p.scene.geometry
  for i = 1, n do out[i] = false end
  for i, m in pairs(given) do
    if not check.is_integer(i) or i < 1 or i > n then
      return check.bad(1, name, "materials: places in scene.geometry expected, 1 to %d, got %s", n, check.describe(i))
    end
    if not objects.is(m) then
      return check.bad(1, name, "materials: [%d] must be a material, got %s", i, check.describe(m))
    end
    local before = p.scene.geometry[i].material
    if material.texture(m) ~= (before and material.texture(before)) then
      return check.fail("%s: materials: [%d] has another texture than %s: the prepared view keeps that of its own", name, i,
        tracing.mesh_text(p.scene, i))
    end
    local made, message, code = material.object(name, m)
    if not made then return nil, message, code end
    out[i], key[i] = made, m
  end
  return out, key
end

--- Do two changes make the same view?
local function same(a, b)
  if not a or a.method ~= b.method or a.product ~= b.product or a.blind ~= b.blind then return false end
  for i = 1, 10 do if (a.camera or {})[i] ~= (b.camera or {})[i] then return false end end
  for i, m in pairs(a.materials) do if b.materials[i] ~= m then return false end end
  for i, m in pairs(b.materials) do if a.materials[i] ~= m then return false end end
  return true
end

--- Refuses changes that the prepared view p cannot take.
local function check_change(name, p, o)
  local mode = p.options.relight
  if o.camera and mode ~= "all" then
    return check.fail("%s: another camera sees other shading points: prepare the view with relight = 'all'", name)
  end
  if o.materials and mode ~= "material" and mode ~= "all" then
    return check.fail("%s: materials change in views that are prepared with relight = 'material' or 'all'%s", name,
      mode and (", here it is %q"):format(mode) or "")
  end
  if p.options.gloss ~= "sh" then
    return check.fail("%s: %s is of glossy surfaces by spherical harmonics: prepare the view with gloss = 'sh'", name,
      o.product and "product" or "method")
  end
end

--- Refuses options of a picture that do not go together; lights that stand for a grid become one object.
function relight.check(name, o)
  local first = type(o.grid) == "table" and (form.kind(o.grid) and o.grid or o.grid[1])
  local kind = first and form.kind(first)
  if kind and form.defined[kind] and form.defined[kind].light then o.grid = light.field(1, name, o.grid) end
  if (o.materials or o.camera) and o.reflected then
    return check.fail("%s: light that bounces is that of the scene's materials and camera: leave bounces and bounced out", name)
  end
  if (o.materials or o.camera or o.method or o.product) and o.device then
    return check.fail("%s: materials, camera, method and product are the processor's: leave device out", name)
  end
end

--- The view p with what o changes: itself where nothing does; the last one is kept. Or nil, message, code.
function relight.of(name, p, o, blind)
  local method = o.method ~= "zonal" and o.method or nil
  if not (o.materials or o.camera or method or o.product or blind) then return p end
  if o.materials or o.camera or method or o.product then check_change(name, p, o) end
  local materials, key, code = dressed(name, p, o.materials or {})
  if not materials then return nil, key, code end
  local wanted = { method = method or "table", product = o.product or "auto", materials = key, blind = blind and o.camera ~= nil,
    camera = o.camera and views.camera_numbers { camera = o.camera } }
  local own = views.made[p.view]
  if next(key) == nil and not wanted.camera and wanted.method == "table" and wanted.product == "auto" then return p end
  local last = own.changed
  if not (last and same(last.key, wanted)) then
    if last then p.lib.shade_close_view(last.view) end
    own.changed = nil
    local view, message
    view, message, code = check.result(name, library.rival(p.lib.shade_change, p.view, {
      camera = wanted.camera, blind = wanted.blind, materials = materials, meshes = #materials,
      nearest = wanted.method == "nearest", product = wanted.product, keep = p.options.relight ~= nil and not wanted.camera,
      threads = o.threads, progress = progress.resolve(o.progress) }))
    if not view then return nil, message, code end
    own.changed = { key = wanted, view = view }
  end
  local changed = setmetatable({ view = own.changed.view, base = p.view }, { __index = own })
  if wanted.camera then changed.stats = setmetatable(p.lib.shade_stats(changed.view), { __index = own.stats }) end
  return changed
end

--- report.stages: seconds of a picture of p, since `before` (p.lib.shade_stages), of all threads.
function relight.stages(p, before)
  local out = p.lib.shade_stages(p.view)
  for stage, seconds in pairs(before) do out[stage] = out[stage] - seconds end
  return out
end

-- Zonal lobes ------------------------------------------------------------------------------------

local ROWS = 91 -- of elevation, from the normal to the horizon

--- The zonal coefficients [rows][3][lmax+1] of f about the mirror image of the view, as a list; or nil, message, code.
local function lobes(m, lmax, o)
  local t, message, code = m:table { lmax = lmax, cosine = false, threads = o.threads, progress = o.progress }
  if not t then return nil, message, code end
  local wo, mirror, out = {}, {}, {}
  for i = 1, ROWS do
    local a = math.min(89.5, (i - 1) / (ROWS - 1) * 90) * math.pi / 180
    wo[i], mirror[i] = { math.sin(a), 0, math.cos(a) }, { -math.sin(a), 0, math.cos(a) }
  end
  local F, Y
  F, message, code = t:slices(array.array(wo))
  if not F then return nil, message, code end
  Y, message, code = sh.eval(lmax, mirror)
  if not Y then return nil, message, code end
  F, Y = F:totable(), Y:totable()
  for i = 1, ROWS do
    for c = 1, 3 do
      for l = 0, lmax do
        local sum = 0
        for k = l * l + 1, (l + 1) ^ 2 do sum = sum + F[i][c][k] * Y[i][k] end
        out[#out + 1] = sum * 4 * math.pi / (2 * l + 1)
      end
    end
  end
  return out
end

--- Replaces in `radiance` that of glossy points by zonal lobes: true; or nil, message, code.
function relight.zonal(name, p, o, radiance)
  local binding, message, code = library.rival_binding()
  if not binding then return nil, message, code end
  local lights = p.traced.lights
  local count, spheres = core.lights_count(lights)
  if count ~= spheres then
    return check.fail("%s: zonal lobes are summed over sphere lights, and the scene has others: method = 'table' takes all", name)
  end
  local zonal, number, slots = {}, 0, {}
  for i, g in ipairs(p.scene.geometry) do
    slots[i] = -1
    if g.material and material.glossy(g.material) then
      if material.texture(g.material) then
        return check.fail("%s: %s has a texture, which zonal lobes do not take: method = 'table' does", name,
          tracing.mesh_text(p.scene, i))
      end
      if material.direction(g.material, (material.object(name, g.material))) then
        return check.fail("%s: %s has two roughnesses, which no zonal lobe has: method = 'table' takes it", name,
          tracing.mesh_text(p.scene, i))
      end
      local z
      z, message, code = lobes(g.material, p.options.lmax, o)
      if not z then return nil, message, code end
      for k = 1, #z do zonal[#zonal + 1] = z[k] end
      slots[i], number = number, number + 1
    end
  end
  if number == 0 then return true end
  local z = array.array(zonal):reshape { number, ROWS, 3, p.options.lmax + 1 }
  local position, normal, _, object = p.lib.shade_points(p.view)
  if not position then return nil, normal, _ end
  local lobe = core.array_zeros({ #object }, "float")
  local at, radius, shine = light.arrays(lights)
  core.array_fill(lobe, (function()
    local list = object:totable()
    for i = 1, #list do list[i] = slots[list[i]] end
    return list
  end)())
  local eye = p.scene.camera.from
  local function floats(a) return core.array_convert(a, "float") end
  return check.result(name, binding.zonal({ position, normal, lobe, eye[1], eye[2], eye[3] }, p.options.lmax, z,
    { floats(at), floats(radius), floats(shine) }, o.threads or 0, radiance))
end

return relight
