-- Refusals of virtual lights, of scenes that emit them and views that sum them, and of spots: see spec/refusals_spec.lua.

local refused = require "spec.support.refused"
local ways = require "spec.support.ways"

local nan = 0 / 0

local function one(ylm) return ylm.virtual_lights { at = { { 0, 1, 0 } }, radius = 0.2, intensity = 1 } end

local function scene(ylm)
  return ylm.scene "refusing" {
    camera = ylm.camera { from = { 0, 3, 4 } },
    geometry = { ylm.quad { corner = { -1, 0, 1 }, u = { 2, 0, 0 }, v = { 0, 0, -2 } } },
    lights = { ylm.sphere_light { at = { 0, 1, 0 }, radius = 0.1 } },
  }
end

--- Cases { options, pattern } of a call(ylm, options).
local function cases(call, list, out)
  out = out or {}
  for _, case in ipairs(list) do
    out[#out + 1] = { call = function(ylm)
      return call(ylm, type(case[1]) == "function" and case[1](ylm) or case[1])
    end, says = case[2] }
  end
  return out
end

local emitted = cases(function(ylm, o) return scene(ylm):virtual_lights(o) end, {
  { 7, "a table of options expected, got 7" }, { { count = 0 }, "count must be an integer >= 1" },
  { { count = 1.5 }, "count must be" }, { { count = 2 ^ 40 }, "count must be" },
  { { count = 20, particles = 10 }, "particles %(10%) must be at least as many as count" },
  { { particles = nan }, "particles must be" }, { { bounces = 65 }, "bounces must be a number of reflections, 0 to 64" },
  { { bounces = -1 }, "bounces must be" }, { { radius = 0 }, "radius must be 'density', 'angle', 'footprint', 'neighbours', or" },
  { { radius = "footprint" }, "is of distribution = 'grid'" },
  { { degree = 9 }, "degree must be 'auto', or an integer" }, { { radius = "neighbours" }, "is of distribution = 'grid'" },
  { { distribution = "grid" }, "a grid is of spots alone, the scene has none" },
  { { distribution = "grid", bounces = 2 }, "has one bounce" }, { { scale = nan }, "scale must be a number > 0" },
  { { profile = "far" }, "profile must be one of 'gauss', 'cap', 'point'" }, { { seed = -1 }, "seed must be" },
  { { threads = 0 }, "threads must be" }, { { progress = 3 }, "progress must be" },
}, refused(function() return require "ylm.emit".of_scene {} end, "virtual_lights: a scene expected before the colon"))

local summed = cases(function(ylm, o)
  o.lights = o.lights or one(ylm)
  return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }):render(ways.virtual(o))
end, {
  { { lmax = 101 }, "lmax must be" }, { { method = "vsgl", groups = 0 }, "groups must be an integer >= 1" },
  { { method = "vsgl", groups = 2 }, "at most the 1 lights" },
  { { method = "vsl", zonal = true }, "zonal is of harmonics, which rival = 'vsl' has none of" },
  { { method = "vpl", lmax = 3 }, "lmax is of harmonics, which rival = 'vpl' has none of" },
  { { method = "vpl", limit = 0 }, "limit must be a number > 0" },
  { { method = "vpl", compensate = 4 }, "compensate needs lights that scene:virtual_lights made" },
  { { method = "vsl", samples = 0 }, "samples must be" }, { { method = "vsl", strategy = "brdf" }, "strategy must be one of" },
  { { window = 3 }, "window: { name, width } of sh.window expected" }, { { horizon = "soft" }, "horizon must be one of" },
  { { shadows = true }, "shadows must be one of 'none', 'centre'" },
  { function(ylm) return { lights = ylm.virtual_lights { at = { { 0, 1, 0 } }, radius = 0.2, intensity = 1e300 } } end,
    "the light at shading point 1 is beyond the range of float" },
}, cases(function(ylm, rival)
  return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }):render { by = "none", bounced = one(ylm), rival = rival }
end, {
  { { "mc" }, "rival must be { 'vpl' | 'vsl' | 'vsgl', .. }, got 'mc'" }, { { "vsl", clamp = "none" }, "clamp is for 'vpl', this is 'vsl'" },
  { { "vpl", groups = 1 }, "groups is for 'vsgl', this is 'vpl'" }, { { "vsl", lmax = 4 }, "no field 'lmax'" },
}))

local lights = cases(function(ylm, o) return ylm.virtual_lights(o) end, {
  { { radius = 1, intensity = 1 }, "field 'at' is missing" },
  { { at = { { 0, 0, 0 } }, radius = 1 }, "give one of intensity and emission" },
  { { at = { { 0, 0, 0 } }, intensity = 1 }, "field 'radius' is missing" },
  { { at = { { 0, 0, 0 } }, intensity = 1, radius = 0 }, "light 1" },
  { { at = { { 0, 0, 0 } }, intensity = 1, radius = 1, normal = { { 2, 0, 0 } } }, "light 1" },
  { { at = { { 0, 0, nan } }, intensity = 1, radius = 1 }, "light 1: its place is not finite" },
  { { at = { { 0, 0, 0 } }, emission = { { { 1, 2 }, { 1, 2 }, { 1, 2 } } }, radius = 1 }, "emission must be" },
  { { at = { { 0, 0, 0 } }, intensity = 1, radius = 1, shift = 2 }, "light 1" },
})

local spots = cases(function(ylm, o) return ylm.spot_light(o) end, {
  { { at = { 0, 0, 0 } }, "field 'to' is missing" }, { { at = { 0, 0, 0 }, to = { 0, 0, 0 } }, "at and to are the same" },
  { { at = { 0, 0, nan }, to = { 0, 0, 1 } }, "at must be three numbers" },
  { { at = { 0, 0, 0 }, to = { 0, 0, 1 }, angle = 0 }, "angle must be a number > 0" },
  { { at = { 0, 0, 0 }, to = { 0, 0, 1 }, angle = 361 }, "angle must be" },
  { { at = { 0, 0, 0 }, to = { 0, 0, 1 }, blend = -0.1 }, "blend must be a number >= 0" },
  { { at = { 0, 0, 0 }, to = { 0, 0, 1 }, intensity = nan }, "intensity must be" },
  { { at = { 0, 2 ^ 60, 0 }, to = { 0, 0, 1 } }, "it is beyond 1e" },
  { { at = { 0, 0, 0 }, to = { 0, 0, 1 }, intensity = 1e21 }, "it is of an intensity beyond 1e%+20" },
})

return {
  virtual_lights = lights, spot_light = spots, ["scene:virtual_lights"] = emitted, ["view:render"] = summed,
  ["virtual_lights:arrays"] = refused(function(ylm) return one(ylm).arrays {} end,
    "arrays: virtual lights expected before the colon"),
  ["virtual_lights:irradiance"] = refused(function(ylm) return one(ylm).irradiance {} end, "virtual lights expected",
    function(ylm) return one(ylm):irradiance({ { 0, 0, 0 } }, { { 0, 0, 1 } }) end, "near"),
  ["virtual_lights:near_field"] = refused(function(ylm) return one(ylm).near_field {} end, "virtual lights expected",
    function(ylm) return one(ylm):near_field(2, { { 0, 0, 0 } }) end, "near"),
  ["virtual_lights:visible"] = refused(function(ylm) return one(ylm).visible {} end, "virtual lights expected",
    function(ylm) return one(ylm):visible(3) end, "a scene expected, got 3",
    function(ylm) return select(2, one(ylm):split { core = 1 }):visible(scene(ylm)) end, "near parts are summed"),
  ["visible:close"] = refused(function(ylm) return one(ylm):visible(scene(ylm)).close {} end, "a field of visible lights expected"),
  ["virtual_lights:split"] = refused(function(ylm) return one(ylm):split { core = "far" } end, "core",
    function(ylm) return one(ylm):split { core = 0.1 } end, "core", function(ylm) return one(ylm):split { core = 0 } end, "core"),
}
