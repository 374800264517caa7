-- Refusals of elements, links and radiosity: see spec/refusals_spec.lua.

local nan, inf = 0 / 0, 1 / 0

local function scene(ylm, fields)
  return ylm.scene "refusing" {
    geometry = fields and fields.geometry or { ylm.box { scale = 2,
      material = ylm.matte { albedo = fields and fields.albedo or 0.5 } } },
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 },
  }
end

local function transfer(ylm, fields) return scene(ylm, fields):transfer { spacing = 4, links = 4 } end
local function radiosity(ylm) return transfer(ylm):radiosity() end

--- Cases of method `name` of what `make` makes, called `what` in messages, before those of `list`.
local function methods(name, make, what, list)
  local out = {
    { call = function(ylm) return make(ylm)[name]({}) end, says = name .. ": a " .. what .. " expected before the colon" },
  }
  if name ~= "close" then
    out[2] = { call = function(ylm)
      local object = make(ylm)
      object:close()
      return object[name](object)
    end, says = name .. ": the " .. what .. " has been closed" }
  end
  for _, case in ipairs(list or {}) do out[#out + 1] = case end
  return out
end

local function field(ylm) return radiosity(ylm):field { rays = 192 } end

local function field_of(o, says)
  return { call = function(ylm) return radiosity(ylm):field(o) end, says = says }
end

local function form_cases(wrap)
  local out = {}
  for _, case in ipairs {
    { { spacing = 0 }, "spacing must be a number > 0" }, { { spacing = -1 }, "spacing must be" },
    { { spacing = nan }, "spacing must be" }, { { spacing = inf }, "spacing must be" }, { { links = 3 }, "links must be a "
      .. "multiple of 4" },
    { { links = 6 }, "links must be" }, { { links = 0 }, "links must be" }, { { links = 4100 }, "links must be" },
    { { links = nan }, "links must be" }, { { lmax = -1 }, "lmax must be" }, { { lmax = 21 }, "lmax must be" },
    { { sides = "frnt" }, "did you mean 'front'" }, { { max_elements = 0 }, "max_elements must be" },
    { { seed = -1 }, "seed must be" }, { { spaceing = 1 }, "did you mean 'spacing'" },
  } do out[#out + 1] = { call = function(ylm) return wrap(ylm, case[1]) end, says = case[2] } end
  return out
end

local of_scene = form_cases(function(ylm, o) return scene(ylm):transfer(o) end)
for _, case in ipairs {
  { call = function(ylm) return scene(ylm).transfer({}) end, says = "transfer: a scene expected before the colon" },
  { call = function(ylm) return scene(ylm):transfer(7) end, says = "a table of options expected, got 7" },
  { call = function(ylm) return scene(ylm):transfer { spacing = 1e-6 } end,
    says = "spacing = 1e%-06 would make 9.6e%+13 elements; spacing 0.01 makes 9.6e%+05 %(at most max_elements = 1048576%)" },
  { call = function(ylm) return scene(ylm):transfer { max_elements = 11 } end,
    says = "max_elements = 11 is less than the sides of the scene's triangles, 12" },
  { call = function(ylm) return scene(ylm):transfer { file = "none.transfer" } end, says = "none.transfer" },
  { call = function(ylm) return scene(ylm):transfer { file = "spec/once.lua" } end, says = "spec/once.lua: this is no transfer" },
  { call = function(ylm) return scene(ylm):transfer { file = "none.transfer", spacing = 1 } end,
    says = "spacing is the file's: leave out file, or spacing" },
  { call = function(ylm) return scene(ylm):transfer { inside = { { 0, 0 } } } end, says = "transfer" },
  { call = function(ylm) return scene(ylm):transfer { threads = 0 } end, says = "threads must be" },
  { call = function(ylm) return scene(ylm):transfer { progress = 5 } end, says = "progress must be" },
  { call = function(ylm) return scene(ylm):transfer { progress = function() return false end } end, says = "cancelled" },
} do of_scene[#of_scene + 1] = case end

local function lit_by(o, says)
  return { call = function(ylm) return transfer(ylm):radiosity(nil, o) end, says = says }
end

return {
  transfer = form_cases(function(ylm, o) return ylm.transfer(o) end),
  ["scene:transfer"] = of_scene,
  ["transfer:elements"] = methods("elements", transfer, "transfer"),
  ["transfer:links"] = methods("links", transfer, "transfer"),
  ["transfer:save"] = methods("save", transfer, "transfer", {
    { call = function(ylm) return transfer(ylm):save(5) end, says = "the name of a file expected, got 5" },
    { call = function(ylm) return transfer(ylm):save "no such folder/a.transfer" end, says = "no such folder" },
  }),
  ["transfer:close"] = methods("close", transfer, "transfer"),
  ["transfer:radiosity"] = methods("radiosity", transfer, "transfer", {
    lit_by({ direct = "ray" }, "did you mean 'rays'"), lit_by({ light_samples = 0 }, "light_samples must be"),
    lit_by({ bounces = -1 }, "bounces must be a number of reflections after direct light"), lit_by({ bounces = 1.5 },
      "bounces must be"),
    lit_by({ residual = 0 }, "residual must be"), lit_by({ residual = nan }, "residual must be"), lit_by({ closure = 1 },
      "closure must be"),
    lit_by({ progress = function() return false end }, "cancelled"),
    { call = function(ylm) return transfer(ylm):radiosity(5) end, says = "a light or a list of lights expected, got 5" },
    { call = function(ylm)
      local t = transfer(ylm)
      local grid = ylm.bake(ylm.uniform_grid { cells = 1, lmax = 4, bounds = { { -1, -1, -1 }, { 1, 1, 1 } } }, t.scene.lights)
      return t:radiosity(grid, { direct = "rays" })
    end, says = "direct = 'rays' is for lights; a ylm.grid has coefficients alone: direct = 'field'" },
    { call = function(ylm) return transfer(ylm, { albedo = 1 }):radiosity() end,
      says = "bounces = 'all' does not converge: each bounce keeps [%d.]+ of the light before %(the mean albedo is 1, and 0 %% of "
        .. "the links" },
    { call = function(ylm)
      local t = transfer(ylm)
      return t:radiosity(t:radiosity())
    end, says = 'a ylm.radiosity holds light that has bounced %(quantity "indirect"%): give lights or a grid of parts' },
    { call = function(ylm)
      local t = transfer(ylm)
      t.scene.geometry[2] = ylm.box {}
      return t:radiosity()
    end, says = "radiosity: the geometry of scene \"refusing\" has changed since its transfer was made" },
  }),
  ["radiosity:update"] = methods("update", radiosity, "radiosity", {
    { call = function(ylm) return radiosity(ylm):update "dark" end, says = "a light or a list of lights expected" },
  }),
  ["radiosity:irradiance"] = methods("irradiance", radiosity, "radiosity", {
    { call = function(ylm) return radiosity(ylm):irradiance "indirect" end, says = "'all' or 'direct' expected, got 'indirect'" },
  }),
  ["radiosity:leaving"] = methods("leaving", radiosity, "radiosity"),
  ["radiosity:elements"] = methods("elements", radiosity, "radiosity"),
  ["radiosity:field"] = methods("field", radiosity, "radiosity", {
    field_of({ quantity = "indirekt" }, "did you mean 'indirect'"), field_of({ rays = 100 },
      "rays must be 'auto' or an integer from 192 to 49152"),
    field_of({ rays = "many" }, "rays must be 'auto'"), field_of({ rays = nan }, "rays must be"), field_of({ tolerance = 0 },
      "tolerance must be"),
    field_of({ tolerance = 1e-6 }, "field: tolerance 1e%-06: the gathered light is known to"),
    field_of({ contrast = -1 }, "contrast must be"), field_of({ contrast = nan }, "contrast must be"),
    field_of({ derivatives = "cell" }, "did you mean 'cells'"), field_of({ remember = 1 }, "remember must be"),
    field_of({ seed = -1 }, "seed must be"), field_of({ ray = 192 }, "did you mean 'rays'"),
    { call = function(ylm)
      local t = transfer(ylm)
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
      { call = function(ylm) return transfer(ylm, { geometry = ylm.mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } },
        triangles = { { 1, 2, 3 } } } }):radiosity():lightmap { mesh = 1 } end, says = "mesh 1 has no texture coordinates" },
    }
    for _, case in ipairs { { {}, "field 'mesh' is missing" }, { { mesh = 0 }, "mesh must be" },
      { { mesh = 2 }, "mesh = 2: the scene has 1 pieces of geometry" }, { { mesh = 1, size = { 0, 4 } }, "size must be { "
        .. "width, height }" },
      { { mesh = 1, part = "al" }, "did you mean 'all'" }, { { mesh = 1, links = 5 }, "links must be" },
      { { mesh = 1, light_samples = 0 }, "light_samples must be" }, { { mesh = 1, gutter = -1 }, "gutter must be" },
      { { mesh = 1, side = "both" }, "side must be" },
      { { mesh = 1, size = { 4, 4 }, progress = function() return false end }, "cancelled" } } do
      out[#out + 1] = { call = function(ylm) return radiosity(ylm):lightmap(case[1]) end, says = case[2] }
    end
    return out
  end)()),
  ["radiosity:close"] = methods("close", radiosity, "radiosity"),
}
