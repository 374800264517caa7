-- Refusals of ylm's lights: see spec/refusals_spec.lua.

local function lamp(ylm) return ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1, radiance = 1 } end
local nan, inf = 0 / 0, 1 / 0

return {
  sphere_light = {
    { call = function(ylm) return ylm.sphere_light() end, says = "a table of named fields expected, got nil" },
    { call = function(ylm) return ylm.sphere_light(7) end, says = "a table of named fields expected, got 7" },
    { call = function(ylm) return ylm.sphere_light {} end, says = "field 'at' is missing" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 0 }, raduis = 1 } end,
      says = "did you mean 'radius'" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0 } } end, says = "at must be three numbers" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, nan } } end, says = "at must be three numbers" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 1e16 } } end, says = "too far out" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 0 }, radius = -1 } end,
      says = "radius must be a number >= 0" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 0 }, radius = inf } end,
      says = "radius must be a number" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 0 }, radius = "1" } end,
      says = "radius must be a number" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 0 }, radiance = { 1, 2 } } end,
      says = "radiance must be a number or" },
    { call = function(ylm) return ylm.sphere_light { at = { 0, 0, 0 }, radiance = inf } end,
      says = "radiance must be a number or" },
  },
  sphere_lights = {
    { call = function(ylm) return ylm.sphere_lights {} end, says = "field 'at' is missing" },
    { call = function(ylm) return ylm.sphere_lights { at = {}, radius = { 1, 2 } } end,
      says = "one for each of the 0 lights, got an array of 2" },
    { call = function(ylm) return ylm.sphere_lights { at = ylm.zeros({ 0, 2 }, "double") } end,
      says = "at must be %[n%]%[3%] numbers" },
    { call = function(ylm) return ylm.sphere_lights { at = "x" } end, says = "at must be %[n%]%[3%] numbers, got 'x'" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 }, { 1, 2 } } } end,
      says = "element 4 does not fit" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, nan } } } end,
      says = "light 1: its centre is not finite" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 1e20 } } } end,
      says = "light 1: its centre is beyond" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 }, { 1, 1, 1 } }, radius = { 1, -1 } } end,
      says = "light 2: its radius" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 } }, radius = { 1e20 } } end,
      says = "light 1: its radius" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 } }, radius = { 1, 2 } } end,
      says = "one for each of the 1 lights" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 } }, radiance = { 1, 2 } } end,
      says = "one for each of the 1 lights" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 } }, radiance = { { 1, inf, 0 } } } end,
      says = "light 1: its radiance is not finite" },
    { call = function(ylm) return ylm.sphere_lights { at = { { 0, 0, 0 } }, colour = 1 } end,
      says = "no field 'colour'" },
    { call = function(ylm)
      local a = ylm.zeros { 1, 3 }
      a:close()
      return ylm.sphere_lights { at = a }
    end, says = "closed" },
  },
  light_field = {
    { call = function(ylm)
        local grid = ylm.bake(ylm.uniform_grid { bounds = { { 0, 0, 0 }, { 1, 1, 1 } }, cells = 1, lmax = 1 }, lamp(ylm))
        grid:close()
        return ylm.light_field(1, grid, { 0, 0, 0 })
      end, says = "#2 to 'light_field'.*the grid has been closed" },
    { call = function(ylm) return ylm.light_field(-1, lamp(ylm), { 0, 0, 0 }) end,
      says = "#1.*lmax must be an integer from 0 to 100" },
    { call = function(ylm) return ylm.light_field(1e6, lamp(ylm), { 0, 0, 0 }) end, says = "#1.*lmax" },
    { call = function(ylm) return ylm.light_field(0.5, lamp(ylm), { 0, 0, 0 }) end, says = "#1.*lmax" },
    { call = function(ylm) return ylm.light_field("4", lamp(ylm), { 0, 0, 0 }) end, says = "#1.*lmax" },
    { call = function(ylm) return ylm.light_field(1, lamp(ylm), { { 0, 0, 0 }, { 1e300, 0, 0 } }) end,
      says = "#3.*points: row 2 is more than a float holds, 3.4e38" },
    { call = function(ylm) return ylm.light_field(4, nil, { 0, 0, 0 }) end, says = "#2.*a light or a list" },
    { call = function(ylm) return ylm.light_field(4, { lamp(ylm), 3 }, { 0, 0, 0 }) end,
      says = "#2.*a light or a list" },
    { call = function(ylm)
      local loop = {}
      loop[1] = loop
      return ylm.light_field(4, loop, { 0, 0, 0 })
    end, says = "#2.*nest more than 32 deep; does a list hold itself%?" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm)) end, says = "#3.*points" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0 }) end, says = "rows of 3 numbers" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { { 0, 0, nan } }) end, says = "row 1 is not finite" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { { 0, 0, 0 }, { 0, 0, 1e16 } }) end,
      says = "point 2 is beyond" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { derivatives = 3 }) end,
      says = "derivatives must be" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { channels = "rbg" }) end,
      says = "did you mean 'rgb'" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { derivative = 1 }) end,
      says = "did you mean 'derivatives'" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { dtype = "half" }) end,
      says = "dtype must be" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { tolerance = 0 }) end,
      says = "tolerance must be a number >= 1e%-06 and <= 0.5, got 0" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { tolerance = -0.01 }) end,
      says = "tolerance must be a number >= 1e%-06 and <= 0.5" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { tolerance = nan }) end,
      says = "tolerance must be a number >= 1e%-06 and <= 0.5" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { tolerance = 1 }) end,
      says = "tolerance must be a number >= 1e%-06 and <= 0.5, got 1" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { sums_tolerance = 1e-2 }) end,
      says = "no field 'sums_tolerance'" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { threads = 0 }) end,
      says = "threads must be" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { 0, 0, 0 }, { out = 1 }) end,
      says = "out must be an array" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { { 0, 0, 0 } }, { out = ylm.zeros { 2, 3, 25 } }) end,
      says = "out%[1%] must be a float array of 1x3x25, got a double array of 2x3x25" },
    { call = function(ylm)
        return ylm.light_field(4, lamp(ylm), { { 0, 0, 0 } }, { derivatives = 1, out = { gradient = ylm.zeros { 1 } } })
      end, says = "out takes 2 arrays %(see derivatives%), got an entry 'gradient'" },
    { call = function(ylm)
        local a = ylm.zeros({ 1, 3, 4, 3 }, "float")
        return ylm.light_field(1, lamp(ylm), { { 0, 0, 0 } }, { derivatives = 1, out = { a[1]:reshape { 1, 3, 12 }, a } })
      end, says = "out%[1%] must be a float array of 1x3x4" },
    { call = function(ylm)
        local a = ylm.zeros({ 3, 3, 4, 3 }, "float")
        return ylm.light_field(1, lamp(ylm), ylm.zeros({ 3, 3 }, "float"),
          { derivatives = 1, out = { a[1]:reshape { 3, 3, 4 }, a } })
      end, says = "out%[2%] shares memory with out%[1%]" },
    { call = function(ylm) -- points of another type are copied, and yet nobody means to lose them
        local points = ylm.zeros({ 4, 3 }, "double")
        return ylm.light_field(0, lamp(ylm), points,
          { dtype = "double", channels = "rgb", out = points:reshape { 4, 3, 1 } })
      end, says = "out%[1%] shares memory with the points" },
    { call = function(ylm) return ylm.light_field(4, lamp(ylm), { { 0, 0, 0 } }, { progress = 1 }) end,
      says = "progress must be" },
  },
}
