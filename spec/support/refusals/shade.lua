-- Refusals of cameras, materials and rendering: see spec/refusals_spec.lua.

local shapes = require "ylm"

local nan, inf = 0 / 0, 1 / 0

local function scene(ylm, fields)
  return ylm.scene "refusing" {
    camera = ylm.camera { from = { 0, 3, 4 } },
    geometry = fields and fields.geometry
      or { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
    lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1 } },
  }
end

local small = { size = { 4, 2 } }

local function with(more)
  local o = { size = { 4, 2 } }
  for k, v in pairs(more) do o[k] = v end
  return o
end

--- Cases of options that scene:NAME and a prepared view's NAME share.
local function options(name, cases)
  local out = {
    { call = function() return require "ylm.render"[name]({}, {}) end, says = name .. ": a scene expected" },
    { call = function(ylm) return scene(ylm)[name](scene(ylm), 7) end, says = "a table of options expected, got 7" },
    { call = function(ylm) return scene(ylm)[name](scene(ylm), with { sise = 1 }) end, says = "did you mean 'size'" },
    { call = function(ylm)
      local blind = ylm.scene "blind" { probes = ylm.uniform_grid { cells = 1 } }
      return blind[name](blind, { size = small.size, occupied = name == "bake" and "camera" or nil })
    end, says = "has no camera" },
  }
  local fields = {
    { { size = { 0, 2 } }, "size must be" }, { { size = { 4 } }, "size must be" },
    { { size = { 1e9, 2 } }, "size must be" },
    { { size = { 4.5, 2 } }, "size must be" }, { { size = { nan, 2 } }, "size must be" },
    { { seed = -1 }, "seed must be" }, { { share = -1 }, "share must be" }, { { share = nan }, "share must be" },
    { { threads = 0 }, "threads must be" }, { { progress = 5 }, "progress must be" },
  }
  for _, list in ipairs { fields, cases } do
    for _, f in ipairs(list) do
      out[#out + 1] = { call = function(ylm) return scene(ylm)[name](scene(ylm), with(f[1])) end, says = f[2] }
    end
  end
  return out
end

local view_cases = {
  { { samples = 0 }, "samples must be" }, { { samples = 1025 }, "samples must be" },
  { { samples = 1.5 }, "samples must be" },
  { { shading = "vertice" }, "did you mean 'vertices'" }, { { visibility = true }, "visibility must be" },
  { { transfer_samples = 0 }, "transfer_samples must be" }, { { transfer_samples = 1e9 }, "transfer_samples must be" },
  { { occlusion_distance = 0 }, "occlusion_distance must be" },
  { { occlusion_distance = nan }, "occlusion_distance must be" },
  { { lmax = -1 }, "lmax must be" }, { { lmax = 1e6 }, "lmax must be" },
  { { visibility = "transfr" }, "did you mean 'transfer'" },
}

local prepare_cases = {
  { { visibility = "rays", transfer_samples = 8 }, 'transfer_samples is for visibility = "transfer", visibility is "rays"' },
  { { visibility = "rays", occlusion_distance = 8 }, 'occlusion_distance is for visibility = "transfer"' },
}

local function joined(...)
  local out = {}
  for _, list in ipairs { ... } do for _, x in ipairs(list) do out[#out + 1] = x end end
  return out
end

local function prepared(ylm) return scene(ylm):prepare { size = { 4, 2 }, samples = 1, visibility = "transfer" } end

--- A call of a view that was prepared by rays.
local function by_rays(name, given, says)
  return { call = function(ylm)
    local view = scene(ylm):prepare { size = { 4, 2 }, samples = 1 }
    return view[name](view, given and given(ylm))
  end, says = says }
end

local function lamp(ylm) return ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1 } end

--- A grid of lights.
local function lights(ylm) return ylm.bake(ylm.uniform_grid { cells = 1, lmax = 1, bounds = { { -1, 0, -1 }, { 1, 1, 1 } } }, lamp(ylm)) end

local uniform, following = shapes.uniform_grid { cells = 1, lmax = 1 },
  shapes.uniform_grid { cells = 1, lmax = 1, dynamic = true }

local no_transfer = 'the view has no transfer vectors: prepare it with visibility = "transfer"'

--- Cases of method `name` of prepared views.
local function of_prepared(name, cases)
  local out = {
    { call = function(ylm) return prepared(ylm)[name]({}) end, says = name .. ": a prepared view expected" },
    { call = function(ylm)
      local view = prepared(ylm)
      view:close()
      return prepared(ylm)[name](view)
    end, says = name .. ": the prepared view has been closed" },
  }
  for _, f in ipairs(cases or {}) do
    out[#out + 1] = { call = function(ylm)
      local view = prepared(ylm)
      return view[name](view, f[1])
    end, says = f[2] }
  end
  return out
end

local layer_cases = {
  { { layers = 1 }, "layers must be" }, { { truth = 1 }, "truth must be a ylm.image" },
  { { threads = -1 }, "threads must be" },
  { { sise = 1 }, "no field 'sise'" }, { 7, "a table of options expected" },
}

return {
  true_error = {
    { call = function(ylm) return ylm.true_error() end, says = "an image expected, got false" },
    { call = function(ylm) return ylm.true_error(ylm.image { size = { 4, 2 } }, 5) end,
      says = "#2.*an image expected" },
    { call = function(ylm) return ylm.true_error(ylm.image { size = { 4, 2 } }, ylm.image { size = { 2, 4 } }) end,
      says = "an image of 4x2 expected, got 2x4" },
  },
  ["scene:live"] = {
    { call = function() return require "ylm.live".live({}, {}) end, says = "live: a scene expected" },
    { call = function(ylm) return scene(ylm):live(7) end, says = "a table of options expected, got 7" },
    { call = function(ylm) return scene(ylm):live { sise = 1 } end, says = "did you mean 'size'" },
    { call = function(ylm) return scene(ylm):live { hidden = true } end, says = "hidden needs events" },
    { call = function(ylm) return scene(ylm):live { events = 5 } end, says = "events: a file's name or a list of tables expected" },
    { call = function(ylm) return scene(ylm):live { events = { { 0, "prees", 1, 1, "left" } } } end,
      says = "did you mean 'press'" },
    { call = function(ylm) return scene(ylm):live { picture = "x.jpg", events = {} } end, says = "picture must end in .png" },
    { call = function(ylm) return scene(ylm):live { keep = true, hidden = true, events = {} } end, says = "keep is for windows" },
    { call = function(ylm) return ylm.scene "blind" {}:live { hidden = true, events = {} } end, says = "has no camera" },
    { call = function(ylm) return scene(ylm):live { size = { 0, 1 } } end, says = "size must be" },
    { call = function(ylm) return scene(ylm):live { budget = nan } end, says = "budget must be" },
    { call = function(ylm) return scene(ylm):live { refine = { "x" } } end, says = "refine must be" },
  },
  ["scene:prepare"] = options("prepare", joined(view_cases, prepare_cases)),
  ["scene:render"] = options("render", joined(view_cases, {
    { { visibility = "transfer" }, "field 'grid' is missing" }, { { grid = 5 }, "grid must be a grid" },
    { { visibility = "none" }, "field 'grid' is missing" }, { { light_samples = 0 }, "light_samples must be" },
    { { interpolation = "cubic" }, "interpolation" },
    { { interpolation = "linear" }, 'interpolation is for by = "grid" or bounced = a grid, and this picture is by = "rays"' },
    { { sums_tolerance = 0.1 }, 'sums_tolerance is for by = "grid" or by = "sum", and this picture is by = "rays"' },
    { { transfer_samples = 8 }, 'transfer_samples is for by = "grid" or by = "sum", and this picture is by = "rays"' },
    { { visibility = "rays", occlusion_distance = 8 }, 'occlusion_distance is for by = "grid" or by = "sum"' },
    { { by = "rays", grid = 5 }, 'grid is for by = "grid", and this picture is by = "rays"' },
    { { by = "rays", visibility = "transfer" }, "visibility must be one of 'rays', 'none'" },
    { { by = "grid", visibility = "rays" }, "without a grid bakes lights, which transfer vectors shade" },
    { { visibility = "transfer", light_samples = 4 }, "light_samples is for by = 'rays', and for glossy surfaces" },
    { { layers = 1 }, "layers must be" }, { { sums_tolerance = 0 }, "sums_tolerance must be a number >= 1e%-06" },
    { { by = "ray" }, "did you mean 'rays'" }, { { by = "paths", share = 1 }, 'share is for by = "rays"' },
    { { resume = true }, "resume must be" }, { { time_limit = 1 }, "time_limit is of pictures with a noise that is wanted: give noise too" },
    { { noise = 0 }, "noise must be" }, { { noise = 0.1, light_samples = 4 }, "light_samples is given" },
    { { guides = 1 }, "guides must be" },
    { { bounces = 0, rays = 8 }, "rays is for bounced = 'links' or bounced = a grid, and this picture is by = \"rays\"" },
    { { bounced = "link" }, "bounced must be 'links', 'virtual', what scene:links" },
    { { bounced = "links", virtual = {} }, "virtual is for bounced = 'virtual', and this picture is by = \"rays\", bounced = 'links'" },
    { { tolerance = 2 }, "tolerance must be a number >= 0.001 and <= 1" }, { { light_samples = 1e9 }, "light_samples must be" },
    { { by = "sum", dtype = "half" }, "dtype must be" }, { { by = "sum", visibility = "rays" }, "visibility must be one of 'transfer'" },
    { { by = "sum", lights = 7 }, "a light or a list of lights expected, got 7" },
    { { by = "sum", sums_tolerance = 2 }, "sums_tolerance must be a number >= 1e%-06 and <= 0.5, got 2" },
    { { by = "rays", shadows = 1 }, "no field 'shadows'" }, { { lmax = 4 }, 'lmax is for by = "grid" or by = "sum"' },
  })),
  ["scene:bake"] = joined(options("bake", {
    { { occupied = "camera", probes = uniform, quantity = "shadows" }, "quantity must be" },
    { { occupied = "camera", probes = uniform, bounces = 2 }, "bounces are of quantity = 'indirect' or 'all'" },
    { { occupied = "camera", probes = uniform, bounces = 2, quantity = "lights" }, "bounces are of quantity = 'indirect' or 'all'" },
    { { occupied = "camera", probes = uniform, bounces = 2, quantity = "direct" }, "bounces are of quantity = 'indirect' or 'all'" },
    { { occupied = "camera", probes = uniform, quantity = "indirect", bounces = 0 }, "quantity = 'indirect' would be dark" },
    { { occupied = "camera", probes = uniform, quantity = "direct", sums_tolerance = 0.1 },
      "sums_tolerance is for quantity = 'lights', this is \"direct\"" },
    { { occupied = "camera", probes = following, quantity = "all" }, "a dynamic grid follows lights" },
    { { sums_tolerance = -1 }, "sums_tolerance must be a number >= 1e%-06" },
    { { probes = 5 }, "probes must be" }, { { samples = 0 }, "samples must be" },
  }), {
    { call = function(ylm)
      return scene(ylm):bake { probes = ylm.uniform_grid { cells = 1 }, occupied = "camra" }
    end, says = "occupied must be" },
    { call = function(ylm)
      return ylm.scene "looking away" {
        camera = ylm.camera { from = { 0, 3, 4 }, at = { 0, 5, 9 } },
        geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
        lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1 } },
        probes = ylm.adaptive_grid { lmax = 1, depth = 1 },
      }:bake { occupied = "camera", size = small.size }
    end, says = "no shading points: the camera sees no geometry" },
    { call = function(ylm)
      return scene(ylm, { geometry = {} }):bake { probes = ylm.uniform_grid { cells = 1 }, size = { 4, 2 },
        occupied = "camera" }
    end, says = "the camera sees no geometry" },
    { call = function(ylm)
      return scene(ylm, { geometry = {} }):bake { probes = ylm.uniform_grid { cells = 1 } }
    end, says = "no geometry, so no surfaces" },
    { call = function(ylm)
      return scene(ylm):bake { probes = ylm.uniform_grid { cells = 1 }, size = { 4, 2 } }
    end, says = "size is about the camera's rays: give occupied = 'camera' too" },
    { call = function(ylm)
      return scene(ylm):bake { probes = ylm.uniform_grid { cells = 1 }, occupied = "camera", size = { 4, 2 },
        progress = function() return false end }
    end, says = "cancelled" },
  }),
  ["view:render"] = joined(of_prepared("render", joined(layer_cases, {
    { {}, "field 'grid' is missing" }, { { grid = {} }, "grid must be a grid" },
    { { interpolation = 1 }, "interpolation" }, { { light_samples = 4 }, "field 'grid' is missing" },
    { { by = "sum", dtype = 4 }, "dtype must be" }, { { by = "paths" }, "by must be one of" },
    { { by = "rays", light_samples = 0 }, "light_samples must be" }, { { by = "rays", seed = -1 }, "seed must be" },
    { { samples = 4 }, "samples is of scene:prepare, and the view has it already" },
    { { by = "none" }, "light that bounces alone, and nothing bounces" },
    { { by = "rays", rival = { "vpl" } }, 'rival is for bounced = \'virtual\', and this picture is by = "rays"' },
    { { bounced = "virtual", by = "none", rival = { "vpx" } }, "rival must be { 'vpl' | 'vsl' | 'vsgl', .. }, got 'vpx'" },
    { { by = "vectors" }, "field 'vectors' is missing" },
  })), {
    by_rays("render", function() return { by = "sum" } end, no_transfer),
    by_rays("render", function(ylm) return { grid = lights(ylm) } end,
      "a ylm.grid holds lights without their shadows, which transfer vectors shade, and the view has none: prepare it"),
    by_rays("render", function() return { download = false } end, 'download is for by = "grid"'),
    { call = function(ylm) return prepared(ylm):render { grid = lights(ylm), download = false } end, says = "download: name the device" },
    { call = function(ylm) return prepared(ylm):render { grid = lights(ylm), light_samples = 4 } end,
      says = "light_samples is for pictures by rays to the lamps, here is a grid" },
    { call = function(ylm) return scene(ylm):render { grid = lights(ylm), visibility = "rays" } end,
      says = "the grid holds lights without their shadows, which transfer vectors shade: name visibility" },
  }),
  ["view:radiance"] = of_prepared("radiance", {
    { { threads = -1 }, "threads must be" }, { { layers = false }, "no field 'layers'" }, { 7, "a table of options expected" },
    { {}, "field 'grid' is missing" }, { { grid = {} }, "grid must be a grid" },
    { { grid = lamp(require "ylm"), method = "cubic" }, "method must be" },
    { { grid = lamp(require "ylm"), camera = 5 }, "camera must be" },
    { { grid = lamp(require "ylm"), materials = {} }, "materials change in views that are prepared with relight" },
  }),
  ["view:points"] = of_prepared("points"),
  ["view:layer"] = {
    { call = function(ylm) return prepared(ylm).layer(5, "depth") end, says = "layer: a prepared view expected" },
    { call = function(ylm) return prepared(ylm):layer "radiance" end, says = "coverage, emitter, object expected, got 'radiance'" },
    { call = function(ylm) return prepared(ylm):layer() end, says = "got nil" },
  },
  ["view:hit"] = {
    { call = function(ylm) return prepared(ylm).hit(5, 1, 1) end, says = "hit: a prepared view expected" },
    { call = function(ylm) return prepared(ylm):hit() end, says = "a pixel's column from 1 to 4 expected, got" },
    { call = function(ylm) return prepared(ylm):hit(1, 3) end, says = "a pixel's row from 1 to 2 expected, got 3" },
    { call = function(ylm) return prepared(ylm):hit(nan, 1) end, says = "a pixel's column" },
  },
  ["view:lamp_at"] = {
    { call = function(ylm) return prepared(ylm).lamp_at(5, {}, 1, 1) end, says = "lamp_at: a prepared view expected" },
    { call = function(ylm) return prepared(ylm):lamp_at(nil, 1, 1) end, says = "sphere lights expected, got nil" },
    { call = function(ylm) return prepared(ylm):lamp_at({}, inf, 1) end, says = "a finite number expected" },
    { call = function(ylm) return prepared(ylm):lamp_at({}, 1, 1, -1) end, says = "pixels >= 0 expected, got %-1" },
  },
  ["view:transfer"] = joined(of_prepared("transfer"), { by_rays("transfer", nil, no_transfer) }),
  ["view:close"] = {
    { call = function(ylm) return prepared(ylm).close(5) end, says = "close: a prepared view expected" },
  },
  camera = {
    { call = function(ylm) return ylm.camera() end, says = "a table of named fields expected, got nil" },
    { call = function(ylm) return ylm.camera {} end, says = "field 'from' is missing" },
    { call = function(ylm) return ylm.camera { form = { 0, 0, 1 } } end, says = "did you mean 'from'" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, nan } } end, says = "from must be three numbers" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 0 } } end, says = "different points" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, up = { 0, 0, 0 } } end,
      says = "up must be three numbers" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, up = { 0, 0, 2 } } end,
      says = "up must not point along" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, fov = 180 } end,
      says = "fov must be a number > 0 and <= 179" },
    { call = function(ylm) return ylm.camera { from = { 0, 0, 1 }, fov = inf } end, says = "fov must be a number" },
  },
  matte = {
    { call = function(ylm) return ylm.matte { 0.5 } end, says = "fields are given by name" },
    { call = function(ylm) return ylm.matte { albdeo = 0.5 } end, says = "did you mean 'albedo'" },
    { call = function(ylm) return ylm.matte { albedo = -0.1 } end, says = "albedo must be" },
    { call = function(ylm) return ylm.matte { albedo = { 1, 1 } } end, says = "albedo must be" },
    { call = function(ylm) return ylm.matte { albedo = nan } end, says = "albedo must be" },
  },
}
