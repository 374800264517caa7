-- Refusals of the path tracer: see spec/refusals_spec.lua.

local nan = 0 / 0

local function scene(ylm)
  return ylm.scene "refusing" {
    camera = ylm.camera { from = { 0, 3, 4 } },
    geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
    lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1 } },
  }
end

--- Cases of scene:NAME with options beside `base`.
local function cases(name, base, list)
  local out = {
    { call = function() return require "ylm.render"[name]({}, {}) end, says = name .. ": a scene expected" },
    { call = function(ylm) return scene(ylm)[name](scene(ylm), 7) end, says = "a table of options expected, got 7" },
  }
  for _, case in ipairs(list) do
    out[#out + 1] = { call = function(ylm)
      local o = {}
      for k, v in pairs(base) do o[k] = v end
      for k, v in pairs(type(case[1]) == "function" and case[1](ylm) or case[1]) do o[k] = v end
      return scene(ylm)[name](scene(ylm), o)
    end, says = case[2] }
  end
  return out
end

local estimates = {
  { { samples = 0 }, "samples must be an integer >= 1" }, { { samples = 1.5 }, "samples must be" },
  { { samples = 2 ^ 40 }, "samples must be" },
  { { bounces = { 3, 1 } }, "bounces must be a number of reflections after direct light" },
  { { bounces = -1 }, "bounces must be" }, { { bounces = "some" }, "bounces must be" }, { { bounces = nan }, "bounces must be" },
  { { reflections = { 3, 1 } }, "reflections must be { first, last }, first <= last" },
  { { reflections = 2 }, "reflections must be" }, { { reflections = { -1, 2 } }, "reflections must be" },
  { { reflections = { "all", 2 } }, "reflections must be" },
  { { bounces = 1, reflections = { 0, 1 } }, "bounces and reflections say the same" },
  { { strategy = "bidirectional" }, "strategy must be one of" }, { { tolerance = 0 }, "tolerance must be a number > 0" },
  { { time_limit = -1 }, "time_limit must be a number > 0" }, { { seed = -1 }, "seed must be" }, { { threads = 0 }, "threads must be" },
  { { progress = 5 }, "progress must be" }, { { sample = 4 }, "did you mean 'samples'" },
}

local function list(more)
  local all = {}
  for _, case in ipairs(estimates) do all[#all + 1] = case end
  for _, case in ipairs(more) do all[#all + 1] = case end
  return all
end

--- An image as pathtrace leaves it, but for what `change` does to it.
local function traced(change)
  return function(ylm)
    local image = scene(ylm):pathtrace { size = { 4, 2 }, samples = 32 }
    return { resume = change(ylm, image) or image, samples = 64 }
  end
end

return {
  ["scene:pathtrace"] = cases("pathtrace", { size = { 4, 2 }, samples = 32 }, list {
    { { size = { 0, 2 } }, "size must be" }, { { resume = 4 }, "resume must be a ylm.image" },
    { traced(function(ylm) return ylm.image { size = { 4, 2 } } end), "resume: the image has no layer radiance_rest" },
    { function(ylm) return { size = { 4, 3 }, resume = traced(function() end)(ylm).resume } end,
      "resume: an image of 4x3 expected, got 4x2" },
    { traced(function(_, image) image.metadata.seed = 2 end), "resume: the image's seed is '2', this is '1'" },
    { traced(function(_, image) image.metadata.camera = nil end), "resume: the image's camera is ''" },
    { traced(function(_, image) image.metadata.samples = "-5" end), "samples are '%-5', a multiple of 16 expected" },
    { function(ylm) return { bounces = 1, resume = traced(function() end)(ylm).resume } end,
      "resume: the image's reflections is '0 all', this is '0 2'" },
    { function(ylm) return { truth = ylm.image { size = { 4, 3 } } } end, "truth must be an image of 4x2" },
  }),
  ["scene:probe"] = cases("probe", { points = { { 0, 1, 0 } }, samples = 32 }, list {
    { { points = { { nan, 0, 0 } } }, "points: row 1 is not finite" }, { { points = 4 }, "points: a table of numbers" },
    { { points = { { 0, 0 } } }, "points: rows of 3 numbers" }, { { lmax = 21 }, "lmax must be" }, { { lmax = -1 }, "lmax must be" },
    { { normals = { { 0, 1, 0 }, { 1, 0, 0 } } }, "normals: one for each of 1 points expected, got 2" },
    { { normals = { { 0, 0, 0 } } }, "normal 1 is zero" }, { { normals = { { 0, nan, 0 } } }, "normal 1 is not finite" },
  }),
  ["scene:judge"] = {
    { call = function(ylm) return scene(ylm):judge("a.png") end, says = "a grid, light on surfaces, or a path ending in .ylmp" },
    { call = function(ylm) return scene(ylm):judge("a.npy", { quantity = "direct" }) end, says = "quantity must be one of" },
    { call = function(ylm) return scene(ylm):judge("a.npy", { places = 3 }) end, says = "places must be an integer" },
    { call = function(ylm) return scene(ylm):judge("a.npy", { sample = 3 }) end, says = "did you mean 'samples'" },
  },
}
