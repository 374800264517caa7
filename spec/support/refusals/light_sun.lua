-- Refusals of suns: see spec/refusals_spec.lua.

local nan = 0 / 0

local function sun(t) return function(ylm) return ylm.sun_light(t) end end

return {
  sun_light = {
    { call = sun {}, says = "field 'direction' is missing" },
    { call = sun { direction = { 0, 0, 0 } }, says = "direction must be three numbers.*not all zero" },
    { call = sun { direction = { 0, nan, 0 } }, says = "direction must be three numbers" },
    { call = sun { direction = { 0, 1, 0 }, angle = 0 }, says = "angle must be a number >= 0.001" },
    { call = sun { direction = { 0, 1, 0 }, angle = 181 }, says = "angle must be a number .*<= 180" },
    { call = sun { direction = { 0, 1, 0 }, irradiance = "x" }, says = "irradiance must be a number or {r, g, b}" },
    { call = sun { direction = { 0, 1, 0 }, radiance = 1 }, says = "no field 'radiance'.*'irradiance'" },
  },
}
