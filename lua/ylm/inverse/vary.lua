--- Numbers of lamps that a plan may change: where each stands in a list x, its bounds, and what derivatives say of it.

local check = require "ylm.check"
local form = require "ylm.form"
local pack = require "ylm.light.pack"
local vector = require "ylm.vector"

local vary = {}

local AXES = { x = 1, y = 2, z = 3 }
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

--- A level of brightness as a field of a light: dim, or radiance times it.
local function dimmed(light, dim)
  if form.kind(light) == "photometric_light" then return { dim = dim } end
  return { radiance = { light.radiance[1] * dim, light.radiance[2] * dim, light.radiance[3] * dim } }
end

local function dim_of(light) return form.kind(light) == "photometric_light" and light.dim or 1 end

local kinds = {}

--- Adds a number to a plan: { start, lower, upper, set(changes, x), slope(d, x) }; `lamps`: those that share it.
local function add(plan, lamps, number)
  number.lamps = lamps
  plan.numbers[#plan.numbers + 1] = number
end

function kinds.position(plan, entry, groups, lights, fail)
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
    for _, lamps in ipairs(groups) do
      for _, k in ipairs(lamps) do
        if lights[k].opening == "point" or lights[k].shape == "point" then
          return fail(("light %d is a point: give it an opening, the shadow of a point has no derivative"):format(k))
        end
      end
      local from = {}
      for _, k in ipairs(lamps) do from[k] = lights[k].at[a] end
      local first = from[lamps[1]]
      add(plan, lamps, { name = name, start = first, lower = lower, upper = upper, spread = upper > lower and APART or 0,
        set = function(c, k, x) c.at[a] = from[k] + x - first end,
        slope = function(d, k) return d.position[k][a] end })
    end
  end
end

function kinds.dim(plan, entry, groups, lights, fail)
  local range = entry.dim
  if type(range) ~= "table" or not (check.is_number(range[1]) and check.is_number(range[2]) and range[1] >= 0
    and range[1] <= range[2]) then
    return fail "dim must be { least, most }, from 0 on"
  end
  for _, lamps in ipairs(groups) do
    local start = dim_of(lights[lamps[1]])
    add(plan, lamps, { name = "dim", start = start, lower = range[1], upper = range[2], spread = 0, is_dim = true,
      set = function(c, _, x) c.dim = x end,
      slope = function(d, k)
        local radiance, sum = lights[k].radiance, 0
        if not radiance then return d.dim[k] end
        for c = 1, 3 do sum = sum + radiance[c] * d.colour[k][c] end
        return sum
      end })
  end
end

function kinds.direction(plan, entry, groups, lights, fail)
  local most = entry.direction
  if not (check.is_number(most) and most > 0 and most <= 80) then return fail "direction must be degrees above 0, 80 at most" end
  for _, lamps in ipairs(groups) do
    for _, k in ipairs(lamps) do
      if not lights[k].axis then return fail(("light %d shines the same in all directions"):format(k)) end
    end
    local lean = math.tan(math.rad(most))
    for i = 1, 2 do
      local ways = {}
      for _, k in ipairs(lamps) do ways[k] = select(i, vector.frame(lights[k].axis)) end
      add(plan, lamps, { name = "direction", start = 0, lower = -lean, upper = lean, spread = 0,
        set = function(c, k, x) for a = 1, 3 do c.lean[a] = c.lean[a] + x * ways[k][a] end end,
        slope = function(d, k, l)
          local w, along, sum = ways[k], 0, 0
          for a = 1, 3 do along = along + w[a] * l.axis[a] end
          for a = 1, 3 do sum = sum + d.direction[k][a] * (w[a] - along * l.axis[a]) / l.length end
          return sum
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
  { "together", "boolean", default = false, about = "one number for all of these lamps" },
}

--- The numbers of `list`, entries of vary, for these lights: { numbers, lights }.
function vary.plan(list, lights)
  local plan = { numbers = {}, lights = lights }
  if type(list) ~= "table" or #list == 0 then return check.fail "inverse_lighting: vary is empty: what may change?" end
  for i, given in ipairs(list) do
    local place = ("vary[%d]"):format(i)
    local function fail(message) return check.fail("inverse_lighting: %s: %s", place, message) end
    if type(given) ~= "table" then return fail(("a table expected, got %s"):format(check.describe(given))) end
    local entry = form.check(fields, given, fail)
    local lamps, groups = chosen(entry.lights, lights, place), {}
    if entry.together then groups[1] = lamps else for g, k in ipairs(lamps) do groups[g] = { k } end end
    local before = #plan.numbers
    for _, name in ipairs { "position", "dim", "direction" } do
      if entry[name] ~= nil then kinds[name](plan, entry, groups, lights, fail) end
    end
    if #plan.numbers == before then return fail "give one of position, dim and direction" end
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

--- The lights that numbers x stand for.
function vary.lights(plan, x)
  local changes, out = {}, {}
  for i, n in ipairs(plan.numbers) do
    for _, k in ipairs(n.lamps) do
      local l = plan.lights[k]
      changes[k] = changes[k] or { at = { l.at[1], l.at[2], l.at[3] }, lean = { 0, 0, 0 } }
      n.set(changes[k], k, x[i])
    end
  end
  for k, l in ipairs(plan.lights) do
    local c = changes[k]
    out[k] = l
    if c then
      local fresh = c.dim and dimmed(l, c.dim) or {}
      fresh.at = c.at
      if l.axis then
        fresh.to = {}
        for a = 1, 3 do fresh.to[a] = c.at[a] + l.axis[a] + c.lean[a] end
      end
      out[k] = pack.moved(l, fresh)
    end
  end
  return out
end

--- The gradient by the numbers, from derivatives by lamps as lists; `lights`: those of x.
function vary.gradient(plan, d, lights)
  local lean, g = {}, {}
  for k, l in ipairs(lights) do -- the direction before it was made of length 1
    local from = plan.lights[k].axis
    if from then
      local along = from[1] * l.axis[1] + from[2] * l.axis[2] + from[3] * l.axis[3]
      lean[k] = { axis = l.axis, length = 1 / math.max(along, 1e-6) }
    end
  end
  for i, n in ipairs(plan.numbers) do
    g[i] = 0
    for _, k in ipairs(n.lamps) do g[i] = g[i] + n.slope(d, k, lean[k]) end
  end
  return g
end

return vary
