--- Numbers of lamps that a plan may change: where each stands in a list x, its bounds, and what derivatives say of it.

local changed = require "ylm.inverse.changed"
local check = require "ylm.check"
local colours = require "ylm.photometry.colour"
local core = require "ylm.c.core"
local form = require "ylm.form"
local vector = require "ylm.vector"

local vary = {}

local AXES = { x = 1, y = 2, z = 3 }
local CHANNELS = { "red", "green", "blue" }
local CHANNEL_OF = { red = "red", green = "green", blue = "blue" }
local TURN, KELVIN = 57.3, 2000 -- degrees and kelvin that one step of a search is: numbers are of one size
local APART = 0.01 -- scene units: starts of lamps differ by as much, so that equal ones part

-- Which lamps -----------------------------------------------------------------------------------------------------

--- The numbers of the lamps that `which` names: a name, the beginning of names, a number, a list of these, nil: all.
local function chosen(which, lights, place)
  local set = {}
  local function take(one)
    if check.is_integer(one) and lights[one] then
      set[one] = true
      return
    end
    local found = false
    for k, l in ipairs(lights) do
      if type(one) == "string" and l.name and l.name:sub(1, #one) == one then set[k], found = true, true end
    end
    if not found then
      local first
      for _, l in ipairs(lights) do first = first or l.name end
      return check.fail("inverse_lighting: %s: no light has the name or number %s; there are %d, %s", place, check.describe(one),
        #lights, first and ("the first name is '%s'"):format(first) or "without names")
    end
  end
  if which == nil then for k = 1, #lights do set[k] = true end
  elseif type(which) == "table" then for _, one in ipairs(which) do take(one) end
  else take(which) end
  local list = {}
  for k = 1, #lights do if set[k] then list[#list + 1] = k end end
  return list
end

-- Kinds of numbers ------------------------------------------------------------------------------------------------

local kinds = {}

--- Adds a number to a plan: { start, lower, upper, set(change, k, x), slope(d, k, x, change) }; `lamps`: those that share it.
-- A level has shares[k], the part of its lamp's light at the start that 1 of it is: light is proportional to it.
local function add(plan, lamps, number)
  number.lamps, number.spread = lamps, number.spread or 0
  plan.numbers[#plan.numbers + 1] = number
end

--- Raises where `what` of one of the lamps does not vary.
local function check_kinds(what, plan, groups, fail)
  for _, group in ipairs(groups) do
    for _, k in ipairs(group) do
      local why = changed.why_not(what, plan.lamps[k])
      if why then return fail(("light %d %s"):format(k, why)) end
    end
  end
end

--- { least, most } of an entry; fails with what is wanted.
local function range_of(entry, name, least, most, fail)
  local range = entry[name]
  if type(range) ~= "table" or not (check.is_number(range[1]) and check.is_number(range[2]) and range[1] >= least
    and range[2] <= most and range[1] <= range[2]) then
    return fail(most < math.huge and ("%s must be { least, most }, from %g to %g"):format(name, least, most)
      or ("%s must be { least, most }, from %g on"):format(name, least))
  end
  return range[1], range[2]
end

function kinds.position(plan, entry, groups, fail)
  if type(entry.position) ~= "table" or #entry.position == 0 then return fail "position must be a list of 'x', 'y', 'z'" end
  local box = entry.within
  if type(box) ~= "table" or type(box[1]) ~= "table" or type(box[2]) ~= "table" then
    return fail "position wants within = { { x, y, z }, { x, y, z } }, two corners of a box"
  end
  for _, name in ipairs(entry.position) do
    local a = AXES[name] or fail(("position: 'x', 'y' or 'z' expected, got %s"):format(check.describe(name)))
    local lower, upper = box[1][a], box[2][a]
    if not (check.is_number(lower) and check.is_number(upper) and lower <= upper) then
      return fail(("within holds no place along %s"):format(name))
    end
    for _, group in ipairs(groups) do
      local first = plan.lamps[group[1]].at[a]
      add(plan, group, { name = name, start = first, lower = lower, upper = upper, spread = upper > lower and APART or 0,
        set = function(c, k, x) c.at[a] = plan.lamps[k].at[a] + x - first end,
        slope = function(d, k) return d.position[k][a] end })
    end
  end
end

--- The factor of a light's radiance by its size: lumens are held.
local function held(light, c) return light.radiance and (c.factor or 1) ^ -2 or 1 end

function kinds.dim(plan, entry, groups, fail)
  local least, most = range_of(entry, "dim", 0, math.huge, fail)
  for _, group in ipairs(groups) do
    local shares, lower = {}, least
    for _, k in ipairs(group) do
      shares[k] = 1
      lower = math.max(lower, math.min(most, changed.least_level(plan.lamps[k])))
    end
    add(plan, group, { name = "dim", start = changed.level(plan.lights[group[1]]), lower = lower, upper = most, shares = shares,
      set = function(c, _, x) c.dim = x end,
      slope = function(d, k, x, c)
        local channels, sum = changed.channels(plan.lights[k]), 0
        if plan.lights[k].dim then return d.dim[k] end
        for i = 1, 3 do sum = sum + (channels and channels[i] or 1 / x) * d.channels[k][i] end
        return sum * held(plan.lights[k], c)
      end })
  end
end

function kinds.colour(plan, entry, groups, fail)
  if entry.dim or entry.temperature then return fail "colour holds the level too: give it without dim and temperature" end
  local least, most = range_of(entry, "colour", 0, math.huge, fail)
  for _, group in ipairs(groups) do
    local channels = changed.channels(plan.lights[group[1]])
    for i = 1, 3 do
      local shares = {}
      for _, k in ipairs(group) do
        local l = plan.lights[k]
        shares[k] = core.luminance[i] / (l.dim and 1 or math.max(vector.luminance(changed.channels(l)), 1e-300))
      end
      add(plan, group, { name = CHANNELS[i], start = channels[i], lower = least, upper = most, shares = shares,
        set = function(c, _, x)
          c.channels = c.channels or {}
          c.channels[i] = x
        end,
        slope = function(d, k, _, c) return d.channels[k][i] * held(plan.lights[k], c) end })
    end
  end
end

--- The slope of a colour's channels by the temperature, 1/K.
local function by_kelvin(x)
  local h = 1
  local a, b, slope = colours.of_temperature(x - h), colours.of_temperature(x + h), {}
  for c = 1, 3 do slope[c] = (b[c] - a[c]) / (2 * h) end
  return slope
end

function kinds.temperature(plan, entry, groups, fail)
  local least, most = range_of(entry, "temperature", 1001, 24999, fail)
  for _, group in ipairs(groups) do
    for _, k in ipairs(group) do
      if form.kind(plan.lights[k]) ~= "photometric_light" then
        return fail(("light %d is no photometric light, and has no temperature"):format(k))
      end
    end
    local now = plan.lights[group[1]].temperature or 4000
    add(plan, group, { name = "temperature", scale = KELVIN, start = now / KELVIN, lower = least / KELVIN, upper = most / KELVIN,
      set = function(c, _, x) c.temperature = x * KELVIN end,
      slope = function(d, k, x)
        local slope, sum = by_kelvin(x * KELVIN), 0
        for c = 1, 3 do sum = sum + KELVIN * slope[c] * d.colour[k][c] end
        return sum
      end })
  end
end

function kinds.turn(plan, entry, groups, fail)
  local least, most = range_of(entry, "turn", -360, 360, fail)
  for _, group in ipairs(groups) do
    for _, k in ipairs(group) do
      if not plan.lights[k].turn then return fail(("light %d has no turn: only photometric lights have one"):format(k)) end
    end
    add(plan, group, { name = "turn", scale = TURN, start = plan.lights[group[1]].turn / TURN, lower = least / TURN,
      upper = most / TURN,
      set = function(c, _, x) c.turn = x * TURN end,
      slope = function(d, k) return TURN * d.turn[k] end })
  end
end

function kinds.size(plan, entry, groups, fail)
  local least, most = range_of(entry, "size", 1e-3, 1e3, fail)
  for _, group in ipairs(groups) do
    add(plan, group, { name = "size", start = 1, lower = least, upper = most,
      set = function(c, _, x) c.factor = x end,
      slope = function(d, k, x) return d.factor[k] / x end })
  end
end

function kinds.direction(plan, entry, groups, fail)
  local most = entry.direction
  if not (check.is_number(most) and most > 0 and most <= 80) then return fail "direction must be degrees above 0, 80 at most" end
  for _, group in ipairs(groups) do
    local lean = math.tan(math.rad(most))
    for i = 1, 2 do
      local ways = {}
      for _, k in ipairs(group) do ways[k] = select(i, vector.frame(plan.lamps[k].axis)) end
      add(plan, group, { name = "direction", start = 0, lower = -lean, upper = lean,
        set = function(c, k, x)
          c.lean = c.lean or { 0, 0, 0 }
          for a = 1, 3 do c.lean[a] = c.lean[a] + x * ways[k][a] end
        end,
        slope = function(d, k, _, c)
          local w, from, sum, by = ways[k], plan.lamps[k].axis, 0, {}
          local along, length = vector.dot(w, c.axis), 1 / math.max(vector.dot(from, c.axis), 1e-6)
          for a = 1, 3 do
            by[a] = (w[a] - along * c.axis[a]) / length
            sum = sum + d.direction[k][a] * by[a]
          end
          if form.kind(plan.lights[k]) ~= "polygon_light" then return sum end
          local turn = vector.dot(by, vector.cross(from, c.axis)) / (1 + vector.dot(from, c.axis)) -- about its normal
          return sum + math.deg(turn) * d.turn[k]
        end })
    end
  end
end

local fields = {
  { "lights", "any", optional = true, about = "a name, the beginning of names, a number, a list; default: all" },
  { "position", "any", optional = true, about = "a list of 'x', 'y', 'z'; wants `within`" },
  { "within", "any", optional = true, about = "{ { x, y, z }, { x, y, z } }: two corners of a box" },
  { "dim", "any", optional = true, about = "{ least, most }: of radiance, where a light has no dim" },
  { "direction", "number", optional = true, unit = "degrees", about = "how far lamps may lean from where they look now" },
  { "turn", "any", optional = true, unit = "degrees", about = "{ least, most } of photometric lights" },
  { "colour", "any", optional = true,
    about = "{ least, most } of each channel of dim times colour, of radiance, irradiance or intensity: the level too" },
  { "temperature", "any", optional = true, unit = "K", about = "{ least, most } of photometric lights" },
  { "size", "any", optional = true, about = "{ least, most }: a factor of the opening as it is now; lumens are held" },
  { "together", "boolean", default = false, about = "one number for all of these lamps" },
}

local NAMES = { "position", "dim", "direction", "turn", "colour", "temperature", "size" }

--- Raises where two numbers mean the same of one lamp.
local function check_once(plan, fail)
  local seen = {}
  for _, n in ipairs(plan.numbers) do
    for _, k in ipairs(n.lamps) do
      local level = n.shares and (CHANNEL_OF[n.name] or "dim") or n.name
      local key = n.name == "direction" and "" or k .. level
      if seen[key] and key ~= "" then return fail(("%s of light %d varies twice"):format(n.name, k)) end
      if n.shares then
        local other = n.name == "dim" and "colour" or "dim"
        if seen[k .. "is " .. other] then return fail(("light %d varies by dim and by colour: give one"):format(k)) end
        seen[k .. "is " .. (n.name == "dim" and "dim" or "colour")] = true
      end
      seen[key] = true
    end
  end
end

--- The numbers of `list`, entries of vary, for these lights: { numbers, lights, lamps }.
function vary.plan(list, lights)
  local plan = { numbers = {}, lights = lights, lamps = changed.lamps(lights) }
  if type(list) ~= "table" or #list == 0 then return check.fail "inverse_lighting: vary is empty: what may change?" end
  for i, given in ipairs(list) do
    local place = ("vary[%d]"):format(i)
    local function fail(message) return check.fail("inverse_lighting: %s: %s", place, message) end
    if type(given) ~= "table" then return fail(("a table expected, got %s"):format(check.describe(given))) end
    local entry = form.check(fields, given, fail)
    local lamps, groups = chosen(entry.lights, lights, place), {}
    if entry.together then groups[1] = lamps else for g, k in ipairs(lamps) do groups[g] = { k } end end
    local before = #plan.numbers
    for _, name in ipairs(NAMES) do
      if entry[name] ~= nil then
        if name ~= "turn" and name ~= "temperature" then check_kinds(name, plan, groups, fail) end
        kinds[name](plan, entry, groups, fail)
      end
    end
    if #plan.numbers == before then return fail("give one of " .. table.concat(NAMES, ", ")) end
    check_once(plan, fail)
  end
  return plan
end

--- The numbers as lists: where they start, their bounds. `moved(i)`: what is added to the start of number i, in parts of its
-- range.
function vary.starts(plan, moved)
  local x, lower, upper = {}, {}, {}
  for i, n in ipairs(plan.numbers) do
    lower[i], upper[i] = n.lower, n.upper
    local more = moved and n.spread > 0 and moved(i) * (n.upper - n.lower) or 0
    x[i] = math.max(n.lower, math.min(n.upper, n.start + more + n.spread * ((i * 0.6180339887498949) % 1 - 0.5)))
  end
  return x, lower, upper
end

--- Changes that numbers x make, by lamp; nil of those that stay.
local function changes_of(plan, x)
  local changes = {}
  for i, n in ipairs(plan.numbers) do
    for _, k in ipairs(n.lamps) do
      changes[k] = changes[k] or changed.none(plan.lamps[k])
      n.set(changes[k], k, x[i])
    end
  end
  for _, c in pairs(changes) do
    if c.lean then c.axis = vector.unit { c.axis[1] + c.lean[1], c.axis[2] + c.lean[2], c.axis[3] + c.lean[3] } end
  end
  return changes
end

--- The lights that numbers x stand for.
function vary.lights(plan, x)
  local changes, out = changes_of(plan, x), {}
  for k, l in ipairs(plan.lights) do out[k] = changes[k] and changed.light(plan.lamps[k], changes[k]) or l end
  return out
end

--- The gradient by the numbers at x, from derivatives by lamps as lists.
function vary.gradient(plan, d, x)
  local changes, g = changes_of(plan, x), {}
  for i, n in ipairs(plan.numbers) do
    g[i] = 0
    for _, k in ipairs(n.lamps) do g[i] = g[i] + n.slope(d, k, x[i], changes[k]) end
  end
  return g
end

--- How much too near lamps whose place varies are to one another, squares of the part of `apart` that lacks; adds its gradient.
function vary.crowd(plan, x, apart, gradient)
  local changes, value, moving, d = changes_of(plan, x), 0, {}, { position = {} }
  for _, n in ipairs(plan.numbers) do
    for _, k in ipairs(AXES[n.name] and n.lamps or {}) do moving[k], d.position[k] = true, { 0, 0, 0 } end
  end
  for k, own in ipairs(plan.lamps) do
    for other = 1, k - 1 do
      local a, b = (changes[k] or own).at, (changes[other] or plan.lamps[other]).at
      if a and b and (moving[k] or moving[other]) then
        local way = { a[1] - b[1], a[2] - b[2], a[3] - b[3] }
        local far = math.max(vector.length(way), 1e-9)
        local lacks = 1 - far / apart
        if lacks > 0 then
          value = value + lacks * lacks
          for c = 1, 3 do
            local by = -2 * lacks / apart * way[c] / far
            if moving[k] then d.position[k][c] = d.position[k][c] + by end
            if moving[other] then d.position[other][c] = d.position[other][c] - by end
          end
        end
      end
    end
  end
  for i, n in ipairs(plan.numbers) do
    for _, k in ipairs(AXES[n.name] and n.lamps or {}) do gradient[i] = gradient[i] + n.slope(d, k) end
  end
  return value
end

return vary
