--- Colours of white light by its temperature, as linear Rec. 709 of luminance 1.

local vector = require "ylm.vector"

local colour = {}

-- Matching functions of the CIE 1931 observer (Wyman, Sloan & Shirley 2013, Eq. 4): factor, peak in nm, widths below and
-- above, 1/nm.
local lobes = {
  { { 1.056, 599.8, 0.0264, 0.0323 }, { 0.362, 442.0, 0.0624, 0.0374 }, { -0.065, 501.1, 0.0490, 0.0382 } },
  { { 0.821, 568.8, 0.0213, 0.0247 }, { 0.286, 530.9, 0.0613, 0.0322 } },
  { { 1.217, 437.0, 0.0845, 0.0278 }, { 0.681, 459.0, 0.0385, 0.0725 } },
}

local function matching(channel, wavelength)
  local sum = 0
  for _, l in ipairs(lobes[channel]) do
    local t = (wavelength - l[2]) * (wavelength < l[2] and l[3] or l[4])
    sum = sum + l[1] * math.exp(-t * t / 2)
  end
  return sum
end

--- XYZ of a black body, of any scale.
local function black_body(kelvin)
  local xyz = { 0, 0, 0 }
  for wavelength = 380, 780, 5 do
    local m = wavelength * 1e-9
    local planck = m ^ -5 / (math.exp(1.438776877e-2 / (m * kelvin)) - 1)
    for c = 1, 3 do xyz[c] = xyz[c] + planck * matching(c, wavelength) end
  end
  return xyz
end

--- XYZ of daylight (CIE 15, D illuminants), from 4000 K.
local function daylight(kelvin)
  local t = 1000 / kelvin
  local x = kelvin <= 7000 and 0.244063 + 0.09911 * t + 2.9678 * t ^ 2 - 4.6070 * t ^ 3
    or 0.237040 + 0.24748 * t + 1.9018 * t ^ 2 - 2.0064 * t ^ 3
  local y = -3 * x * x + 2.87 * x - 0.275
  return { x / y, 1, (1 - x - y) / y }
end

local to_rgb = { { 3.2404542, -1.5371385, -0.4985314 }, { -0.9692660, 1.8760108, 0.0415560 },
  { 0.0556434, -0.2040259, 1.0572252 } }

--- A colour scaled to luminance 1; nil where it has none.
function colour.of_luminance_one(rgb)
  local y = vector.luminance(rgb)
  if not (y > 0) then return nil end
  return { rgb[1] / y, rgb[2] / y, rgb[3] / y }
end

--- The colour of a temperature in kelvin; and whether a channel was negative, which is 0 then.
function colour.of_temperature(kelvin)
  local xyz, rgb, clipped = kelvin >= 4000 and daylight(kelvin) or black_body(kelvin), {}, false
  for c = 1, 3 do
    local x = 0
    for k = 1, 3 do x = x + to_rgb[c][k] * xyz[k] end
    if x < 0 then x, clipped = 0, true end
    rgb[c] = x
  end
  return colour.of_luminance_one(rgb), clipped
end

return colour
