-- Refusals of light on surfaces: see spec/refusals_spec.lua.

local nan = 0 / 0

local function scene(ylm)
  return ylm.scene "refusing" { geometry = ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 } }
end

local made, shut -- one serves all cases that leave it open, one those of a closed one

local function fresh(ylm)
  local s = scene(ylm)
  return s:surface_grid { tolerance = 1, judge = "field", links = s:links { spacing = 1, rays = 16 }, rays = 16 }
end

local function light(ylm)
  made = made or fresh(ylm)
  return made
end

local function given(o, says)
  return { call = function(ylm) return scene(ylm):surface_grid(o) end, says = says }
end

local function closed(name)
  return { call = function(ylm)
    if not shut then
      shut = fresh(ylm)
      shut:close()
    end
    return shut[name](shut)
  end, says = name .. ": the surface grid has been closed" }
end

local function stray(name)
  return { call = function(ylm) return light(ylm)[name]({}) end, says = name .. ": a surface grid expected before the colon" }
end

return {
  ["scene:surface_grid"] = {
    given(7, "a table of options expected, got 7"), given({ tolerance = 0 }, "tolerance must be"),
    given({ tolerance = nan }, "tolerance must be"), given({ quantity = "lights" }, "quantity must be"),
    given({ quantity = "indirekt" }, "did you mean 'indirect'"), given({ corners = 3 }, "corners must be"),
    given({ rays = 6 }, "rays must be"), given({ light_samples = 0 }, "light_samples must be"),
    given({ judge = "path" }, "did you mean 'paths'"), given({ bounces = 2, quantity = "direct" }, "leave bounces out"),
    given({ bounces = 0 }, "would be dark"), given({ seed = -1 }, "seed must be"),
    given({ file = "none.surfaces" }, "none.surfaces"),
    given({ file = "spec/once.lua" }, "spec/once.lua: this is no light on surfaces"),
    given({ file = "none.surfaces", tolerance = 1 }, "tolerance is the file's: leave it out beside file"),
    given({ threads = 0 }, "threads must be"), given({ progress = function() return false end }, "cancelled"),
    { call = function(ylm) return scene(ylm).surface_grid {} end, says = "surface_grid: a scene expected" },
    { call = function(ylm) return scene(ylm):surface_grid { links = scene(ylm):links { spacing = 2, rays = 4 } } end,
      says = "this is another" },
    { call = function(ylm) return ylm.scene "empty" {}:surface_grid() end, says = "has no geometry, so no surfaces" },
  },
  ["surface_grid:irradiance"] = { stray "irradiance", closed "irradiance",
    { call = function(ylm) return light(ylm):irradiance({ { 0, 0 } }, { { 0, 1, 0 } }) end, says = "irradiance" },
    { call = function(ylm) return light(ylm):irradiance({ { 0, -1, 0 } }, { { 0, 1, 0 }, { 0, 1, 0 } }) end,
      says = "1 normals expected, one a point, got 2" },
    { call = function(ylm) return light(ylm):irradiance({ { 0, 0, 0 } }, { { 0, 1, 0 } }) end,
      says = "point 1 lies on no surface of the scene" },
  },
  ["surface_grid:update"] = { stray "update", closed "update",
    { call = function(ylm) return light(ylm):update(7) end, says = "bad argument #1 to 'update'" },
    { call = function(ylm) return light(ylm):update(nil, { octree = "keep" }) end, says = "no field 'octree'" },
    { call = function(ylm) return light(ylm):update(nil, { threads = 0 }) end, says = "threads must be" },
    { call = function(ylm) return light(ylm):update(nil, { progress = function() return false end }) end, says = "cancelled" },
  },
  ["surface_grid:rectangles"] = { stray "rectangles", closed "rectangles" },
  ["surface_grid:save"] = { stray "save", closed "save",
    { call = function(ylm) return light(ylm):save(5) end, says = "the name of a file expected, got 5" },
    { call = function(ylm) return light(ylm):save "no such folder/a.surfaces" end, says = "no such folder" },
  },
  ["surface_grid:close"] = { stray "close" },
}
