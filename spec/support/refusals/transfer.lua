-- Refusals of elements, links and radiosity: see spec/refusals_spec.lua.

local long = require "spec.support.long"
local nan, inf = 0 / 0, 1 / 0

local function scene(ylm, fields)
  return ylm.scene "refusing" {
    geometry = fields and fields.geometry or { ylm.box { scale = 2,
      material = ylm.matte { albedo = fields and fields.albedo or 0.5 } } },
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 },
  }
end

local function links(ylm, fields) return scene(ylm, fields):links { spacing = 4, rays = 4 } end
local function radiosity(ylm) return links(ylm):radiosity() end

--- Cases of method `name` of what `make` makes, called `what` in messages, before those of `list`.
local function methods(name, make, what, list)
  local plural = what == "links" or what == "receivers"
  local out = {
    { call = function(ylm) return make(ylm)[name]({}) end, says = name .. ": " .. (plural and what or "a " .. what) .. " expected before the colon" },
  }
  if name ~= "close" then
    out[2] = { call = function(ylm)
      local object = make(ylm)
      object:close()
      return object[name](object)
    end, says = name .. ": the " .. what .. (plural and " have" or " has") .. " been closed" }
  end
  for _, case in ipairs(list or {}) do out[#out + 1] = case end
  return out
end

local function receivers(ylm) return links(ylm):receivers { points = { { 0, 0.5, 0 } }, rays = 4 } end

--- A radiosity with derivatives, and receivers of its links.
local function differentiated(ylm, o)
  o = o or {}
  o.derivatives = true
  local t = links(ylm)
  return t:radiosity(nil, o), t:receivers { points = { { 0, 0.5, 0 } }, rays = 4 }
end

local function importance(ylm)
  local lit, r = differentiated(ylm)
  return lit:importance { { r, weights = { 1 } } }
end

local function receivers_by(o, says)
  return { call = function(ylm) return links(ylm):receivers(o) end, says = says }
end

local function at_receivers(name)
  return methods(name, receivers, "receivers", {
    { call = function(ylm) return receivers(ylm)[name](receivers(ylm), 5) end,
      says = name == "map" and "these receivers are no plane" or name .. ": a radiosity expected before the colon" },
    { call = function(ylm)
      local r = receivers(ylm)
      return r[name](r, radiosity(ylm))
    end, says = name == "map" and "these receivers are no plane" or "of different links" },
  })
end

local function weighed(terms, says)
  return { call = function(ylm)
    local lit, r = differentiated(ylm)
    return lit:importance(terms(r, ylm))
  end, says = says }
end

local function field(ylm) return radiosity(ylm):field { rays = 192 } end

local function field_of(o, says)
  return { call = function(ylm) return radiosity(ylm):field(o) end, says = says }
end

local function form_cases(wrap)
  local out = {}
  for _, case in ipairs {
    { { spacing = 0 }, "spacing must be a number > 0" }, { { spacing = -1 }, "spacing must be" },
    { { spacing = nan }, "spacing must be" }, { { spacing = inf }, "spacing must be" }, { { rays = 3 }, "rays must be a "
      .. "multiple of 4" },
    { { rays = 6 }, "rays must be" }, { { rays = 0 }, "rays must be" }, { { rays = 4100 }, "rays must be" },
    { { rays = nan }, "rays must be" }, { { lmax = -1 }, "lmax must be" }, { { lmax = 21 }, "lmax must be" },
    { { sides = "frnt" }, "did you mean 'front'" }, { { max_elements = 0 }, "max_elements must be" },
    { { seed = -1 }, "seed must be" }, { { spaceing = 1 }, "did you mean 'spacing'" },
  } do out[#out + 1] = { call = function(ylm) return wrap(ylm, case[1]) end, says = case[2] } end
  return out
end

local of_scene = form_cases(function(ylm, o) return scene(ylm):links(o) end)
for _, case in ipairs {
  { call = function(ylm) return scene(ylm).links({}) end, says = "links: a scene expected before the colon" },
  { call = function(ylm) return scene(ylm):links(7) end, says = "a table of options expected, got 7" },
  { call = function(ylm) return scene(ylm):links { spacing = 1e-6 } end,
    says = "spacing = 1e%-06 would make 9.6e%+13 elements; spacing 0.01 makes 9.6e%+05 %(at most max_elements = 1048576%)" },
  { call = function(ylm) return scene(ylm):links { max_elements = 11 } end,
    says = "max_elements = 11 is less than the sides of the scene's triangles, 12" },
  { call = function(ylm) return scene(ylm):links { file = "none.links" } end, says = "none.links" },
  { call = function(ylm) return scene(ylm):links { file = "spec/once.lua" } end, says = "spec/once.lua: these are no links" },
  { call = function(ylm) return scene(ylm):links { file = "none.links", spacing = 1 } end,
    says = "spacing is the file's: leave out file, or spacing" },
  { call = function(ylm) return scene(ylm):links { inside = { { 0, 0 } } } end, says = "links" },
  { call = function(ylm) return scene(ylm):links { threads = 0 } end, says = "threads must be" },
  { call = function(ylm) return scene(ylm):links { progress = 5 } end, says = "progress must be" },
  { call = function(ylm) return scene(ylm):links { progress = function() return false end } end, says = "cancelled" },
} do of_scene[#of_scene + 1] = case end

local function lit_by(o, says)
  return { call = function(ylm) return links(ylm):radiosity(nil, o) end, says = says }
end

return {
  links = form_cases(function(ylm, o) return ylm.links(o) end),
  ["scene:links"] = of_scene,
  ["scene:field"] = {
    { call = function(ylm) return scene(ylm):field { quantity = "indirekt" } end, says = "did you mean 'indirect'" },
    { call = function(ylm) return scene(ylm):field { bounces = 2 } end,
      says = "field: bounces are of quantity = 'indirect' or 'all': name one, or leave bounces out" },
    { call = function(ylm) return scene(ylm):field { rays = 768 } end,
      says = "field: rays is for quantity = 'direct', 'indirect' or 'all': name one, or leave rays out" },
    { call = function(ylm) return scene(ylm):field { links = links(ylm) } end,
      says = "field: links are for quantity = 'direct', 'indirect' or 'all'" },
    { call = function(ylm) return scene(ylm):field { quantity = "all", links = links(ylm) } end, says = "this is another" },
    { call = function(ylm) return scene(ylm):field { quantity = "indirect", bounces = 0 } end,
      says = "field: bounces = 0 is direct light alone, quantity = 'indirect' would be dark" },
    { call = function(ylm) return scene(ylm).field {} end, says = "field: a scene expected before the colon" },
    { call = function(ylm) return scene(ylm):field { quantity = "all", progress = function() return false end } end,
      says = "cancelled" },
  },
  ["links:elements"] = methods("elements", links, "links"),
  ["links:hits"] = methods("hits", links, "links"),
  ["links:save"] = methods("save", links, "links", {
    { call = function(ylm) return links(ylm):save(5) end, says = "the name of a file expected, got 5" },
    { call = function(ylm) return links(ylm):save "no such folder/a.links" end, says = "no such folder" },
  }),
  ["links:close"] = methods("close", links, "links"),
  ["links:radiosity"] = methods("radiosity", links, "links", {
    lit_by({ direct = "ray" }, "did you mean 'rays'"), lit_by({ light_samples = 0 }, "light_samples must be"),
    lit_by({ bounces = -1 }, "bounces must be a number of reflections after direct light"), lit_by({ bounces = 1.5 },
      "bounces must be"),
    lit_by({ residual = 0 }, "residual must be"), lit_by({ residual = nan }, "residual must be"), lit_by({ closure = 1 },
      "closure must be"),
    lit_by({ progress = function() return false end }, "cancelled"),
    { call = function(ylm) return differentiated(ylm, { light_samples = 5 }) end, says = "even light_samples from 4 on.*got 5 and 8" },
    { call = function(ylm) return differentiated(ylm, { rim = 3 }) end, says = "an even rim" },
    { call = function(ylm) return differentiated(ylm, { direct = "rays" }) end, says = "leave direct out" },
    { call = function(ylm) return links(ylm):radiosity({ 5 }, { derivatives = true }) end,
      says = "derivatives = true is for lamps and skies; light 1 is 5" },
    { call = function(ylm)
      return links(ylm):radiosity({ ylm.sphere_light { at = { 0, 0, 0 }, radius = 0 } }, { derivatives = true })
    end, says = "light 1 has the radius 0" },
    { call = function(ylm) return links(ylm):radiosity(5) end, says = "a light or a list of lights expected, got 5" },
    { call = function(ylm)
      local t = links(ylm)
      local grid = ylm.bake(ylm.uniform_grid { cells = 1, lmax = 4, bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }, t.scene.lights)
      return t:radiosity(grid, { direct = "rays" })
    end, says = "direct = 'rays' is for lights; a ylm.grid has coefficients alone: direct = 'field'" },
    { call = function(ylm) return links(ylm, { albedo = 1 }):radiosity() end,
      says = "bounces = 'all' does not converge: each bounce keeps [%d.]+ of the light before %(the mean albedo is 1, and 0 %% of "
        .. "the links" },
    { call = function(ylm)
      local t = links(ylm)
      return t:radiosity(t:radiosity())
    end, says = 'a ylm.radiosity holds light that has bounced %(quantity "indirect"%): give lights or a grid of quantity' },
    { call = function(ylm)
      local t = links(ylm)
      t.scene.geometry[2] = ylm.box {}
      return t:radiosity()
    end, says = "radiosity: the geometry of scene \"refusing\" has changed since its links were made" },
  }),
  ["links:receivers"] = methods("receivers", links, "links", {
    receivers_by({}, "give one of points %(with normals%), plane and mesh"),
    receivers_by({ mesh = 1, points = { { 0, 0, 0 } } }, "give one of points"),
    receivers_by({ mesh = 2 }, "mesh = 2 has no element; scene \"refusing\" has 1 pieces of geometry"),
    receivers_by({ points = { { 0, 0, 0 } }, normals = { { 0, 0, 0 } } }, "normal 1 is 0"),
    receivers_by({ points = { { 0, 0, 0 } }, normals = { { 0, 1, 0 }, { 0, 1, 0 } } }, "1 points and 2 normals"),
    receivers_by({ points = { { 0, 0, 0 } }, size = { 4, 4 } }, "size is of a mesh"),
    receivers_by({ mesh = 3, size = { 4, 4 } }, "mesh = 3 with size wants texture coordinates"),
    receivers_by({ points = { { 0, 0, nan } } }, "receivers"),
    receivers_by({ points = { { 0, -1.01, 0 } } }, "all 1 places are inside of bodies"),
    receivers_by({ points = { { 0, 0, 0 } }, rays = 5 }, "rays must be a multiple of 4"),
    receivers_by({ points = { { 0, 0, 0 } }, light_samples = 2 }, "light_samples must be an integer >= 4"),
    receivers_by({ points = { { 0, 0, 0 } }, quantity = "luminance" }, "quantity must be"),
    receivers_by({ plane = { at = { 0, 0, 0 } } }, "receivers: plane: .*size"),
    receivers_by({ plane = { at = { 0, 0, 0 }, size = { 1, 0 } } }, "receivers: plane: size must be two numbers above 0"),
    receivers_by({ plane = { at = { 0, 0, 0 }, size = { 1, 1 }, spacing = 1e-4 } }, "are more than 2^20"),
    receivers_by({ plane = { at = { 0, 0, 0 }, size = { 1, 1 }, normal = { 0, 0, 0 } } }, "normal must not be 0"),
  }),
  ["receivers:irradiance"] = at_receivers "irradiance",
  ["receivers:illuminance"] = at_receivers "illuminance",
  ["receivers:figures"] = at_receivers "figures",
  ["receivers:map"] = at_receivers "map",
  ["receivers:close"] = methods("close", receivers, "receivers"),
  ["radiosity:importance"] = methods("importance", radiosity, "radiosity", {
    { call = function(ylm) return radiosity(ylm):importance(5) end, says = "a list of terms expected, got 5" },
    weighed(function() return {} end, "nothing is weighed"),
    weighed(function() return { desk = {} } end, "no such term: 'desk'"),
    weighed(function() return { 5 } end, "term 1 must be { receivers, weights = %[n%] }, got 5"),
    weighed(function(r) return { { r } } end, "weights of term 1 must be %[1%] numbers, or %[1%]%[3%], got nil"),
    weighed(function(r) return { { r, weights = { 1, 2 } } } end, "weights of term 1 must be %[1%]"),
    weighed(function() return { elements = { 1 } } end, "elements must be %["),
    weighed(function(_, ylm) return { { receivers(ylm), weights = { 1 } } } end, "receivers 1 are of other links"),
  }),
  ["importance:elements"] = {
    { call = function(ylm) return importance(ylm).elements({}) end, says = "elements: an importance expected before the colon" },
  },
  ["importance:derivatives"] = {
    { call = function(ylm) return importance(ylm).derivatives({}) end, says = "derivatives: an importance expected before the colon" },
    { call = function(ylm) return importance(ylm):derivatives { shadows = "held" } end, says = "no field 'shadows'" },
    { call = function(ylm)
      local t = links(ylm)
      local r = t:receivers { points = { { 0, 0.5, 0 } }, rays = 4 }
      return t:radiosity():importance({ { r, weights = { 1 } } }):derivatives()
    end, says = "links:radiosity%(lights, { derivatives = true }%)" },
    { call = function(ylm)
      local lit, r = differentiated(ylm)
      local i = lit:importance { { r, weights = { 1 } } }
      lit:update()
      return i:derivatives()
    end, says = "has been lit anew: take its importance again" },
  },
  ["radiosity:update"] = methods("update", radiosity, "radiosity", {
    { call = function(ylm) return radiosity(ylm):update "dark" end, says = "a light or a list of lights expected" },
  }),
  ["radiosity:irradiance"] = methods("irradiance", radiosity, "radiosity", {
    { call = function(ylm) return radiosity(ylm):irradiance "indirect" end, says = "'all' or 'direct' expected, got 'indirect'" },
  }),
  ["radiosity:leaving"] = methods("leaving", radiosity, "radiosity"),
  ["radiosity:elements"] = methods("elements", radiosity, "radiosity"),
  ["radiosity:field"] = methods("field", radiosity, "radiosity", {
    field_of({ quantity = "indirekt" }, "did you mean 'indirect'"),
    field_of({ quantity = "lights" }, "field: quantity = 'lights' is light that no surface meets: scene:field"), field_of({ rays = 100 },
      "rays must be 'auto' or an integer from 192 to 49152"),
    field_of({ rays = "many" }, "rays must be 'auto'"), field_of({ rays = nan }, "rays must be"), field_of({ tolerance = 0 },
      "tolerance must be"),
    long(nil, field_of({ tolerance = 1e-6 }, "field: tolerance 1e%-06: the gathered light is known to")) or -- traces the most
      field_of({ tolerance = nan }, "tolerance must be"),
    field_of({ contrast = -1 }, "contrast must be"), field_of({ contrast = nan }, "contrast must be"),
    field_of({ derivatives = "cell" }, "did you mean 'cells'"), field_of({ remember = 1 }, "remember must be"),
    field_of({ seed = -1 }, "seed must be"), field_of({ ray = 192 }, "did you mean 'rays'"),
    { call = function(ylm)
      local t = links(ylm)
      return t:radiosity(t:radiosity(), { bounces = 0 }):field { quantity = "all" }
    end, says = "quantity = 'all' is for lights that rays can be sent to: this radiosity was lit by another light field" },
    { call = function(ylm) return ylm.light_field(21, radiosity(ylm), { 0, 0, 0 }) end, says = "lmax must be 0 .. 20 for gathered light" },
    { call = function(ylm)
      local grid = ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 1, tolerance = 1e-6 }
      return ylm.bake(grid, field(ylm))
    end, says = "bake: tolerance 1e%-06: the gathered light is known to" },
  }),
  ["gather:noise"] = methods("noise", field, "gathered field", {
    { call = function(ylm) return field(ylm):noise { points = { { 0, 0 } } } end, says = "noise" },
    { call = function(ylm) return field(ylm):noise { lmax = 21 } end, says = "lmax must be" },
    { call = function(ylm) return field(ylm):noise { progress = function() return false end } end, says = "cancelled" },
  }),
  ["gather:validity"] = methods("validity", field, "gathered field", {
    { call = function(ylm) return field(ylm):validity { 0, 0 } end, says = "validity" },
    { call = function(ylm) return field(ylm):validity({ 0, 0, 0 }, { thread = 1 }) end, says = "did you mean 'threads'" },
  }),
  ["gather:close"] = methods("close", field, "gathered field"),
  ["radiosity:save"] = methods("save", radiosity, "radiosity", {
    { call = function(ylm) return radiosity(ylm):save "x.obj" end, says = "a file name that ends in .ply expected, got 'x.obj'" },
    { call = function(ylm) return radiosity(ylm):save "no such folder/a.ply" end, says = "no such folder" },
  }),
  ["radiosity:lightmap"] = methods("lightmap", radiosity, "radiosity", (function()
    local out = {
      { call = function(ylm) return links(ylm, { geometry = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } },
        triangles = { { 1, 2, 3 } } } }):radiosity():lightmap { mesh = 1 } end, says = "mesh 1 has no texture coordinates" },
    }
    for _, case in ipairs { { {}, "field 'mesh' is missing" }, { { mesh = 0 }, "mesh must be" },
      { { mesh = 2 }, "mesh = 2: the scene has 1 pieces of geometry" }, { { mesh = 1, size = { 0, 4 } }, "size must be { "
        .. "width, height }" },
      { { mesh = 1, part = "al" }, "did you mean 'all'" }, { { mesh = 1, rays = 5 }, "rays must be" },
      { { mesh = 1, light_samples = 0 }, "light_samples must be" }, { { mesh = 1, gutter = -1 }, "gutter must be" },
      { { mesh = 1, side = "both" }, "side must be" },
      { { mesh = 1, size = { 4, 4 }, progress = function() return false end }, "cancelled" } } do
      out[#out + 1] = { call = function(ylm) return radiosity(ylm):lightmap(case[1]) end, says = case[2] }
    end
    return out
  end)()),
  ["radiosity:close"] = methods("close", radiosity, "radiosity"),
}
