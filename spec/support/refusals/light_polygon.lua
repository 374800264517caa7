-- Refusals of polygon, disk and textured lights: see spec/refusals_spec.lua.

local nan = 0 / 0
local triangle = { { 0, 1, 0 }, { 1, 1, 0 }, { 0, 1, 1 } }

local function polygon(fields)
  return function(ylm)
    local t = { vertices = triangle }
    for k, v in pairs(fields) do t[k] = v end
    return ylm.polygon_light(t)
  end
end

local function disk(fields)
  return function(ylm)
    local t = { at = { 0, 0, 0 }, normal = { 0, 0, 1 } }
    for k, v in pairs(fields) do t[k] = v end
    return ylm.disk_light(t)
  end
end

local function texture(fields)
  return function(ylm)
    local t = { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 },
      image = ylm.image { size = { 2, 2 }, layers = { { "radiance", 3 } } } }
    for k, v in pairs(fields) do t[k] = v end
    return ylm.textured_light(t)
  end
end

return {
  polygon_light = {
    { call = function(ylm) return ylm.polygon_light {} end, says = "field 'vertices' is missing" },
    { call = polygon { vertexes = 1 }, says = "did you mean 'vertices'" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 1, 0, 0 } } }, says = "vertices must be three or more points" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, nan, 0 } } },
      says = "vertices must be three or more" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 } } }, says = "it has no area" },
    { call = polygon { vertices = { { 1, 1, 1 }, { 1, 1, 1 }, { 1, 1, 1 } } }, says = "it has no area" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0.2 }, { 0, 1, 0 } } },
      says = "it is not planar" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 2, 0, 0 }, { 0.5, 0.5, 0 }, { 0, 2, 0 } } },
      says = "it is not convex" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 1e16, 0, 0 }, { 0, 1, 0 } } }, says = "beyond" },
    { call = polygon { vertices = { { 3, 0, 0 }, { -2.4, 1.8, 0 }, { 0.9, -2.9, 0 }, { 0.9, 2.9, 0 }, { -2.4, -1.8, 0 } } },
      says = "it crosses itself" },
    { call = polygon { vertices = { { 0, 0, 0 }, { 1, 1, 0 }, { 1, 0, 0 }, { 0, 1, 0 } } }, says = "no area" },
    { call = polygon { radiance = "x" }, says = "radiance must be a number or" },
    { call = polygon { method = "fast" }, says = "method must be one of" },
    { call = polygon { horizon = { 0, 0, 0 } }, says = "horizon must be three numbers.*not all zero" },
    { call = polygon { horizon = { 0, 0, 1 }, method = "sphere" }, says = "only exact polygons are cut" },
  },
  disk_light = {
    { call = function(ylm) return ylm.disk_light {} end, says = "field 'at' is missing" },
    { call = disk { normal = { 0, 0, 0 } }, says = "normal must be" },
    { call = disk { radius = 0 }, says = "radius must be a number > 0" },
    { call = disk { radius = -1 }, says = "radius must be a number > 0" },
    { call = disk { sides = 8 }, says = "no field 'sides'" },
    { call = disk { radius = 1e16 }, says = "radius must be a number > 0" },
    { call = disk { at = { 0, nan, 0 } }, says = "at must be" },
    { call = disk { horizon = { 0, 0, 1 }, method = "sphere" }, says = "only exact polygons are cut" },
    { call = disk { radiance = nan }, says = "radiance must be" },
  },
  textured_light = {
    { call = function(ylm) return ylm.textured_light {} end, says = "field 'corner' is missing" },
    { call = texture { image = 3 }, says = "image must be a ylm.image or rows of texels, got 3" },
    { call = texture { image = {} }, says = "image must be a ylm.image or rows" },
    { call = texture { image = { 1, 2 } }, says = "image must be a ylm.image or rows" },
    { call = texture { image = { { 1, 2 }, { 3 } } }, says = "2 rows of 2 numbers each expected, element %d does not fit" },
    { call = texture { image = { { 1, { 2, 3, 4 } } } }, says = "1 rows of 2 numbers each expected" },
    { call = texture { image = { { { 1, 2 } } } }, says = "texels are numbers or {r, g, b}, got 2 numbers" },
    { call = texture { image = { { 1, nan } } }, says = "image must be finite" },
    { call = texture { image = { { 1, "x" } } }, says = "element 2 does not fit" },
    { call = texture { file = "x.png" }, says = "give image or file, not both" },
    { call = function(ylm)
      return ylm.textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }
    end, says = "field 'image' is missing" },
    { call = function(ylm)
      return ylm.textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, file = "" }
    end, says = "file must be a file name" },
    { call = texture { method = "sphere" }, says = "method must be one of 'exact', 'spheres'.*did you mean 'spheres'" },
    { call = texture { horizon = { 0, 0, 0 } }, says = "horizon must be three numbers.*not all zero" },
    { call = texture { horizon = { 0, 0, 1 }, method = "spheres", image = { { 1 } } }, says = "only exact polygons are cut" },
    { call = texture { corner = { 0, 1e16, 0 } }, says = "corner is too far out" },
    { call = texture { u = { 1e-160, 0, 0 } }, says = "u must be from 1e%-15 to 1e15 long" },
    { call = texture { v = { 1, 1e-9, 0 } }, says = "u and v must not be parallel" },
    { call = texture { v = { 2, 0, 0 } }, says = "u and v must not be parallel" },
    { call = texture { tolerance = -1 }, says = "tolerance must be a number >= 0" },
    { call = texture { u = { 0, 0, 0 } }, says = "u must be" },
  },
}
