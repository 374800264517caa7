--- Ticks of axes and scalar bars: where they stand and what they say, in one format for all of an axis.

local ticks = {}

local raised = { ["-"] = "⁻", ["0"] = "⁰", ["1"] = "¹", ["2"] = "²", ["3"] = "³", ["4"] = "⁴", ["5"] = "⁵",
  ["6"] = "⁶", ["7"] = "⁷", ["8"] = "⁸", ["9"] = "⁹" }

local function log10(x) return math.log(x) / math.log(10) end

--- 10 to the power of an integer, as text: "10⁻³".
function ticks.power(exponent)
  return "10" .. (("%d"):format(exponent):gsub(".", raised))
end

--- x with that many digits behind the point, with a real minus sign.
local function fixed(x, digits)
  return ((("%%.%df"):format(digits):format(x == 0 and 0 or x)):gsub("^%-", "−"))
end

--- Multiples of step: all plain, or all with one power of ten where they are large or small.
local function linear_labels(first, last, step)
  local largest = math.max(math.abs(first), math.abs(last)) * step
  local digits, exponent = math.floor(log10(step) + 1e-9), 0
  if largest >= 1e5 or digits < (largest < 0.01 and -4 or -7) then exponent = math.floor(log10(largest) + 1e-9) end
  local labels = {}
  for i = first, last do
    local text = fixed(i * step / 10 ^ exponent, math.max(0, exponent - digits))
    if exponent ~= 0 then text = i == 0 and "0" or text .. "·" .. ticks.power(exponent) end
    labels[#labels + 1] = text
  end
  return labels
end

local function linear(lo, hi, most, whole)
  local step = 10 ^ math.floor(log10((hi - lo) / most))
  if whole and step < 1 then step = 1 end
  for _, factor in ipairs { 1, 2, 5, 10 } do
    if (hi - lo) / (step * factor) <= most then
      step = step * factor
      break
    end
  end
  local places, first, last = {}, math.ceil(lo / step - 1e-9), math.floor(hi / step + 1e-9)
  for i = first, last do places[#places + 1] = i * step end
  return places, linear_labels(first, last, step)
end

--- Multiples m of powers of ten from lo to hi: { m, exponent, value }, m from 1 to 9.
local function multiples(lo, hi)
  local list = {}
  for e = math.floor(log10(lo) - 1e-9), math.ceil(log10(hi) + 1e-9) do
    for m = 1, 9 do
      local x = m * 10 ^ e
      if x >= lo * (1 - 1e-9) and x <= hi * (1 + 1e-9) then list[#list + 1] = { m, e, x } end
    end
  end
  return list
end

--- Less than two powers of ten: 1, 2 and 5 times them, or all their multiples, in one format; nil where these are too few.
local function narrow(list, lo, hi, most)
  for _, labelled in ipairs { { true, true, [5] = true }, { true, true, true, true, true, true, true, true, true } } do
    local places, labels, count = {}, {}, 0
    local plain = lo >= 1e-3 and hi < 1e5
    for i, t in ipairs(list) do
      places[i], labels[i] = t[3], ""
      if labelled[t[1]] then
        count = count + 1
        labels[i] = plain and fixed(t[3], math.max(0, -t[2])) or t[1] .. "·" .. ticks.power(t[2])
      end
    end
    if count >= 2 then return places, labels end
  end
  return linear(lo, hi, most)
end

--- Powers of ten, with ticks without labels between them.
local function logarithmic(lo, hi, most)
  local list, powers = multiples(lo, hi), {}
  for _, t in ipairs(list) do if t[1] == 1 then powers[#powers + 1] = t[2] end end
  if #powers < 2 then return narrow(list, lo, hi, most) end
  local each = math.max(1, math.ceil((#powers - 1) / most))
  local places, labels = {}, {}
  for _, t in ipairs(list) do
    if t[1] == 1 or #powers <= 13 then
      places[#places + 1] = t[3]
      labels[#labels + 1] = t[1] == 1 and (t[2] - powers[1]) % each == 0 and ticks.power(t[2]) or ""
    end
  end
  return places, labels
end

--- Ticks from lo to hi, about `most` of them labelled: positions, labels ("" for minor ones).
-- `whole`: none between integers.
function ticks.of(lo, hi, log, most, whole)
  if lo >= hi then return { lo }, { (("%.4g"):format(lo):gsub("^%-", "−")) } end
  return (log and logarithmic or linear)(lo, hi, most or 6, whole)
end

return ticks
