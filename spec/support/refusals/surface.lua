-- Refusals of light on surfaces: see spec/refusals_spec.lua.

local nan = 0 / 0

local function scene(ylm)
  return ylm.scene "refusing" { geometry = ylm.box { scale = 2, material = ylm.matte { albedo = 0.5 } },
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 } }
end

local made, shut -- one serves all cases that leave it open, one those of a closed one

local function fresh(ylm)
  local s = scene(ylm)
  return s:surface_grid { tolerance = 1, corners = 16, judge = "field", links = s:links { spacing = 1, rays = 16 }, rays = 16 }
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

-- Lightmaps --------------------------------------------------------------------------------------

local picture, gone -- as above

--- A lightmap of that many texels.
local function fresh_map(ylm, texels)
  local s = scene(ylm)
  return s:lightmap { texels = texels or 256, links = s:links { spacing = 1, rays = 16 }, rays = 4 }
end

local function map(ylm)
  picture = picture or fresh_map(ylm)
  return picture
end

local function map_given(o, says)
  return { call = function(ylm) return scene(ylm):lightmap(o) end, says = says }
end

--- Cases of a method of lightmaps, before those of `list`.
local function of_map(name, list)
  local out = { { call = function(ylm) return map(ylm)[name]({}) end, says = name .. ": a lightmap expected before the colon" } }
  if name ~= "close" then
    out[2] = { call = function(ylm)
      if not gone then
        gone = fresh_map(ylm)
        gone:close()
      end
      return gone[name](gone)
    end, says = name .. ": the lightmap has been closed" }
  end
  for _, case in ipairs(list or {}) do out[#out + 1] = case end
  return out
end

return {
  ["scene:lightmap"] = {
    map_given(7, "a table of options expected, got 7"), map_given({ tolerance = 0 }, "tolerance must be"),
    map_given({ texels = 15 }, "texels must be"), map_given({ bytes = 20 }, "bytes must be at least 96"),
    map_given({ bytes = "1MB", texels = 100 }, "texels or bytes, not both"), map_given({ quantity = "lights" }, "quantity must be"),
    map_given({ rays = 6 }, "rays must be"), map_given({ light_samples = 0 }, "light_samples must be"),
    map_given({ texel = 100 }, "did you mean 'texels'"), map_given({ seed = nan }, "seed must be"),
    map_given({ gutter = -1 }, "gutter must be"), map_given({ quantity = "indirect", bounces = 0 }, "would be dark"),
    { call = function(ylm) return fresh_map(ylm, 16) end, says = "6 charts with gutters of 1 do not fit into 16 texels" },
    { call = function(ylm) return scene(ylm).lightmap({}) end, says = "lightmap: a scene expected before the colon" },
    { call = function(ylm) return ylm.scene "empty" {}:lightmap() end, says = "has no geometry, so no surfaces" },
  },
  ["lightmap:irradiance"] = of_map("irradiance", {
    { call = function(ylm) map(ylm):irradiance() end, says = "points" },
    { call = function(ylm) map(ylm):irradiance({ { 0, -1, 0 } }, { { 0, 1, 0 }, { 0, 1, 0 } }) end, says = "1 normals expected" },
    { call = function(ylm) return map(ylm):irradiance({ { 0, 0, 0 } }, { { 0, 1, 0 } }) end, says = "lies on no surface" },
  }),
  ["lightmap:image"] = of_map "image",
  ["lightmap:pieces"] = of_map "pieces",
  ["lightmap:save"] = of_map("save", {
    { call = function(ylm) return map(ylm):save "x.bmp" end, says = "ends in .glb, .gltf, .obj, .exr" },
    { call = function(ylm) return map(ylm):save() end, says = "expected, got nil" },
    { call = function(ylm) return map(ylm):save("x.png", { lit = true }) end, says = "lit is of .glb and .gltf files, not of .png" },
    { call = function(ylm) return map(ylm):save("x.glb", { embed = true, picture = "exr" }) end,
      says = "embed wants picture = 'png'" },
    { call = function(ylm)
      local s = scene(ylm)
      return s:lightmap({ texels = 256, links = s:links { spacing = 1, rays = 16 }, rays = 4, directional = true }):save "x.png"
    end, says = "directional wants picture = 'exr'" },
    { call = function(ylm) return map(ylm):save("x.html", { limit = 1000 }) end, says = "the limit is 0.0 MB" },
    { call = function(ylm) return map(ylm):save("x.glb", { picture = "hdr" }) end, says = "picture must be" },
    { call = function(ylm) return map(ylm):save "/nonexistent/x.glb" end, says = "No such file" },
  }),
  ["lightmap:close"] = of_map "close",
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
