--- Direct light of each light by itself, at elements or at receivers, with what derivatives need of it.
--
-- Lamps are looked at one by one in C. Of other lights, level and colour alone are known: their light by rays, twice, whose
-- difference tells its noise.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local lamps = require "ylm.transfer.lamps"
local tracing = require "ylm.trace"

local lamplight = {}
lamplight.__index = lamplight

local NOISE = 12 -- where the noise of the level stands in a row of 18 sums

--- Irradiance [n][3] by rays to the lights of a traced scene; nil, message, code.
local function by_rays(name, m, place, traced, samples, seed, o)
  if place then return check.result(name, m.lib.receivers_rays(place, traced.handle, samples, seed, o.threads, o.progress)) end
  local dark, message, code = check.result(name, m.lib.radiosity_create(m.links))
  if not dark then return nil, message, code end
  local lit
  lit, message, code = check.result(name, m.lib.radiosity_rays(dark, traced.handle, samples, false, seed, o.threads,
    o.progress))
  if not lit then return nil, message, code end
  return m.lib.radiosity_values(dark, "direct") * 1
end

--- A light's irradiance, and half the difference of two of its estimates; nil, message, code.
local function of_other(name, m, place, traced, l, o)
  local alone, message, code = tracing.relight(name, traced, l.light)
  if not alone then return nil, message, code end
  tracing.check_bodies(name, alone, "derivatives are for lights that rays see")
  local half = {}
  for i = 1, 2 do
    half[i], message, code = by_rays(name, m, place, alone, o.light_samples, (o.seed + i * 7919) % core.limits.seed, o)
    if not half[i] then return nil, message, code end
  end
  return { E = (half[1] + half[2]) * 0.5, noise = (half[1] - half[2]) * 0.5 }
end

--- The light of a list of lamps (lamps.list) at receivers, or at the elements of links: `m`: { lib, links }; nil, message, code.
function lamplight.create(name, m, place, traced, list, o)
  local rows, corners = lamps.rows(list)
  local handle, message, code = check.result(name, m.lib.lamplight_create(m.links, place, rows, corners,
    { light_samples = o.light_samples, rim = o.rim, seed = o.seed, bytes = o.bytes, threads = o.threads, progress = o.progress }))
  if not handle then return nil, message, code end
  local others = {}
  for k, l in ipairs(list) do
    if l.other then
      others[k], message, code = of_other(name, m, place, traced, l, o)
      if not others[k] then return nil, message, code end
    end
  end
  return setmetatable({ lib = m.lib, handle = handle, others = others, count = #list }, lamplight)
end

--- Irradiance [places][3] of all lights.
function lamplight:direct()
  local E = self.lib.lamplight_direct(self.handle)
  for k = 1, self.count do if self.others[k] then E = E + self.others[k].E end end
  return array.array(E, "float")
end

function lamplight:stats() return self.lib.lamplight_stats(self.handle) end

--- Sums of other light by weights [places][3]: a row as those of lamps.
local function weighed(of, weights)
  local row, by_channel = {}, core.array_totable((of.E * weights):sum(1))
  for q = 1, 18 do row[q] = by_channel[q] or 0 end
  local worth = (of.noise * weights):sum(2)
  row[NOISE] = math.sqrt((worth * worth):sum())
  return row
end

--- Sums of direct light and its derivatives by weights double [places][3]: a row of 18 numbers for each light; nil, message,
-- code.
function lamplight:weigh(name, weights, threads)
  local sums, message, code = check.result(name, self.lib.lamplight_weigh(self.handle, weights, threads))
  if not sums then return nil, message, code end
  local rows, out, next_row = core.array_totable(sums), {}, 1
  for k = 1, self.count do
    if self.others[k] then out[k] = weighed(self.others[k], weights)
    else out[k], next_row = rows[next_row], next_row + 1 end
  end
  return out
end

return lamplight
