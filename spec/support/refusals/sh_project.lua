-- Refusals of projection, zonal functions, skies and windows: see spec/refusals_spec.lua.

local nan = 0 / 0
local c = { 1, 2, 3, 4 }
local up = { 0, 0, 1 }

local function one() return 1 end

local function closed(ylm)
  local a = ylm.array(up)
  a:close()
  return a
end

return {
  ["sh.project"] = {
    { call = function(ylm) return ylm.sh.project(-1, one) end, says = "lmax must be an integer from 0" },
    { call = function(ylm) return ylm.sh.project(1e6, one) end, says = "lmax must be an integer from 0" },
    { call = function(ylm) return ylm.sh.project(2) end, says = "a function, an image or .* expected, got nil" },
    { call = function(ylm) return ylm.sh.project(2, "f") end, says = "a function, an image or .* expected, got 'f'" },
    { call = function(ylm) return ylm.sh.project(2, function() end) end,
      says = "must return a finite number.*returned nil" },
    { call = function(ylm) return ylm.sh.project(2, function() return nan end) end,
      says = "must return a finite number" },
    { call = function(ylm) return ylm.sh.project(2, function(x) if x > 0 then return 1 end return 1, 2, 3 end) end,
      says = "everywhere" },
    { call = function(ylm) return ylm.sh.project(2, one, { sampels = 3 }) end, says = "did you mean 'samples'" },
    { call = function(ylm) return ylm.sh.project(2, one, { samples = 0 }) end,
      says = "samples must be an integer >= 1" },
    { call = function(ylm) return ylm.sh.project(2, one, { method = "guess" }) end, says = "method must be one of" },
    { call = function(ylm) return ylm.sh.project(2, { directions = { up } }) end, says = "values: a table of numbers" },
    { call = function(ylm) return ylm.sh.project(2, { direction = { up } }) end, says = "got a field 'direction'" },
    { call = function(ylm) return ylm.sh.project(2, { directions = { up }, values = { 1, 2 } }) end,
      says = "for each of 1 directions" },
    { call = function(ylm) return ylm.sh.project(2, { directions = {}, values = {} }) end,
      says = "for each of 0 directions" },
    { call = function(ylm) return ylm.sh.project(2, { directions = { { 0, 0, 0 } }, values = { 1 } }) end,
      says = "direction 1 is zero" },
    { call = function(ylm) return ylm.sh.project(2, { directions = { up }, values = { nan } }) end,
      says = "not finite" },
    { call = function(ylm) return ylm.sh.project(2, { directions = { up }, values = { 1 }, weights = { 1, 2 } }) end,
      says = "weights: rows of 1 numbers expected" },
    { call = function(ylm) return ylm.sh.project(2, ylm.image { size = { 4, 5 } }, { mapping = "cube" }) end,
      says = "six times as high" },
    { call = function(ylm) return ylm.sh.project(2, ylm.image { size = { 5, 4 } }) end,
      says = "mapping 'latlong' is twice as wide as high, got 5x4" },
    { call = function(ylm) return ylm.sh.project(2, ylm.image { size = { 5, 4 } }, { mapping = "angular" }) end,
      says = "mapping 'angular' is as wide as high, got 5x4" },
    { call = function(ylm) return ylm.sh.project(2, one, { threads = 0 }) end, says = "threads must be an integer >= 1" },
    { call = function(ylm) return ylm.sh.project(2, one, { out = ylm.zeros { 4 } }) end,
      says = "out must be a double array of 9" },
    { call = function(ylm) return ylm.sh.project(2, one, { progress = function() error "from within" end }) end,
      says = "from within" },
    { call = function(ylm) return ylm.sh.project(2, ylm.image { size = { 4, 2 } }, { layer = "alpha" }) end,
      says = "no layer" },
  },
  ["sh.zonal"] = {
    { call = function(ylm) return ylm.sh.zonal(nil, up) end, says = "zonal coefficients: .*got nil" },
    { call = function(ylm) return ylm.sh.zonal({}, up) end, says = "a list of lmax%+1 zonal coefficients expected" },
    { call = function(ylm) return ylm.sh.zonal({ { 1 } }, up) end, says = "a list of lmax%+1 zonal" },
    { call = function(ylm) return ylm.sh.zonal({ nan }, up) end, says = "must be finite" },
    { call = function(ylm) return ylm.sh.zonal({ 1 }, { 0, 0, 0 }) end,
      says = "direction must be three numbers.*not all zero" },
  },
  ["sh.convolve"] = {
    { call = function(ylm) return ylm.sh.convolve({ 1, 2 }, { 1 }) end,
      says = "coefficients expected in the last axis, got 2" },
    { call = function(ylm) return ylm.sh.convolve(c, 3) end, says = "zonal coefficients: .*got 3" },
    { call = function(ylm) return ylm.sh.convolve(ylm.sh.convert(c, "n3d"), { 1 }) end, says = "convention 'n3d'" },
  },
  ["sh.cap"] = {
    { call = function(ylm) return ylm.sh.cap(-1, up, 1) end, says = "lmax must be an integer from 0" },
    { call = function(ylm) return ylm.sh.cap(2, { 0, 0, 0 }, 1) end, says = "direction must be" },
    { call = function(ylm) return ylm.sh.cap(2, closed(ylm), 1) end, says = "direction must be .*got a closed array" },
    { call = function(ylm) return ylm.sh.cap(2, up, -0.1) end,
      says = "angle must be a number >= 0 and <= pi, got %-0.1" },
    { call = function(ylm) return ylm.sh.cap(2, up, nan) end, says = "angle must be a number" },
    { call = function(ylm) return ylm.sh.cap(2, up) end, says = "angle must be a number .* got nil" },
  },
  ["sh.irradiance"] = {
    { call = function(ylm) return ylm.sh.irradiance({ 1, 2 }, up) end, says = "coefficients expected" },
    { call = function(ylm) return ylm.sh.irradiance(ylm.sh.convert(c, "ylm irradiance"), up) end,
      says = "'ylm irradiance'" },
    { call = function(ylm) return ylm.sh.irradiance(c, { 0, 0, 0 }) end, says = "irradiance: .*zero" },
    { call = function(ylm) return ylm.sh.irradiance(c) end, says = "bad argument #2 to 'irradiance' .*got nil" },
    { call = function(ylm) return ylm.sh.irradiance(c, up, { method = "exact" }) end, says = "method must be one of" },
  },
  ["sh.zonal_irradiance"] = {
    { call = function(ylm) return ylm.sh.zonal_irradiance({ 1, 2 }, 0) end,
      says = "three zonal coefficients or more expected, got 2" },
    { call = function(ylm) return ylm.sh.zonal_irradiance({ 1, 2, 3 }, 1.5) end,
      says = "a cosine from %-1 to 1 expected, got 1.5" },
    { call = function(ylm) return ylm.sh.zonal_irradiance({ 1, 2, 3 }) end, says = "a cosine" },
  },
  ["sh.sky"] = {
    { call = function(ylm) return ylm.sh.sky(-1) end, says = "lmax must be an integer from 0" },
    { call = function(ylm) return ylm.sh.sky(2, { kind = "cloudy" }) end, says = "kind must be one of" },
    { call = function(ylm) return ylm.sh.sky(2, { kind = "clear" }) end, says = "a clear sky needs sun" },
    { call = function(ylm) return ylm.sh.sky(2, { kind = "clear", sun = { 0, 0, -1 } }) end,
      says = "above the horizon" },
    { call = function(ylm) return ylm.sh.sky(2, { zenith = { 0, 0, 0 } }) end, says = "zenith must be" },
    { call = function(ylm) return ylm.sh.sky(2, { luminance = -1 }) end, says = "luminance must be a number >= 0" },
  },
  ["sh.window"] = {
    { call = function(ylm) return ylm.sh.window({ 1, 2 }, "hann") end, says = "coefficients expected" },
    { call = function(ylm) return ylm.sh.window(c) end, says = "one of 'hann'.* expected, got nil" },
    { call = function(ylm) return ylm.sh.window(c, "han") end, says = "did you mean 'hann'" },
    { call = function(ylm) return ylm.sh.window(c, "hann", 0) end, says = "a width > 0 expected, got 0" },
    { call = function(ylm) return ylm.sh.window(c, "hann", nan) end, says = "a width > 0 expected" },
  },
  ["sh.dering"] = {
    { call = function(ylm) return ylm.sh.dering({ 1, 2 }) end, says = "coefficients expected" },
    { call = function(ylm) return ylm.sh.dering(c, { window = "box" }) end, says = "window must be one of" },
    { call = function(ylm) return ylm.sh.dering(c, { minimum = nan }) end, says = "minimum must be a number" },
    { call = function(ylm) return ylm.sh.dering({ 1, nan, 1, 1 }) end, says = "not finite" },
  },
  ["sh.random"] = {
    { call = function(ylm) return ylm.sh.random(-1, 2) end, says = "rows must be an integer from 0" },
    { call = function(ylm) return ylm.sh.random(2, -1) end, says = "lmax must be an integer from 0" },
    { call = function(ylm) return ylm.sh.random(2, 2, { sead = 1 }) end, says = "did you mean 'seed'" },
    { call = function(ylm) return ylm.sh.random(2 ^ 40, 1000) end, says = "memory" },
  },
  ["sh.relative_error"] = {
    { call = function(ylm) return ylm.sh.relative_error({ { 1 } }, { { 1, 2 } }) end, says = "rows like those" },
    { call = function(ylm) return ylm.sh.relative_error({ 1 }, { 1 }) end, says = "rows like those" },
    { call = function(ylm) return ylm.sh.relative_error(nil, { 1 }) end, says = "got nil" },
  },
  ["sh.summary"] = {
    { call = function(ylm) return ylm.sh.summary(nil) end, says = "got nil" },
    { call = function(ylm) return ylm.sh.summary { 1, 2 } end, says = "coefficients expected" },
  },
}
