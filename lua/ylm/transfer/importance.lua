--- Derivatives by the lamp: radiosity:importance, and the methods of what it returns.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local lamps = require "ylm.transfer.lamps"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local show = require "ylm.show"

local methods = {}

require "ylm.describe".object "importance" {
  about = "How much light on each element is worth to a weighted sum of illuminances (radiosity:importance).",
  fields = {
    { "value", "number", "the weighted sum itself" },
    { "radiosity", "radiosity", "of which light" },
    { "link_reads", "integer", "links that were read for it" },
  },
  methods = methods,
}

local metatable = {
  __index = function(i, key)
    local m = core.owned(i, "made")
    if key == "value" or key == "radiosity" or key == "link_reads" then return m[key] end
    return methods[key]
  end,
  __newindex = function(_, key)
    return check.fail("importance: cannot set %s: an importance does not change", check.describe(key))
  end,
  __tostring = function(i)
    return ("ylm.importance of %q: worth %.6g"):format(core.owned(i, "made").of.scene.name or "?", core.owned(i, "made").value)
  end,
}

--- Weights as double [n][3], by irradiance of each channel.
local function weights_of(what, given, n)
  local w = core.type(given) == "ylm.array" and given or type(given) == "table" and array.array(given, "double")
  local shape = w and core.array_info(w)
  if not shape or shape[1] ~= n or #shape > 2 or #shape == 2 and shape[2] ~= 3 then
    return check.fail("importance: %s must be [%d] numbers, or [%d][3], got %s", what, n, n, check.describe(given))
  end
  if #shape == 1 then w = w:reshape { n, 1 } * array.array({ core.luminance }, "double") end
  return array.array(w, "double")
end

--- Weights of the places behind receivers: each of a cylinder's has its part.
local function unfolded(w, m)
  if m.fold == 1 then return w end
  local rows = {}
  for i, row in ipairs(w:totable()) do
    for k = 1, m.fold do rows[(i - 1) * m.fold + k] = { row[1] / m.fold, row[2] / m.fold, row[3] / m.fold } end
  end
  return array.array(rows, "double")
end

--- The links of a radiosity backwards, made once; or nil, message, code.
local function transposed(of)
  local links = of.of
  if not links.transpose then
    local made, message, code = check.result("importance", of.lib.transpose_create(of.links))
    if not made then return nil, message, code end
    links.transpose = made
  end
  return links.transpose
end

--- Receivers with their weights as C takes them, and the weighted sum of their irradiance; nil, message, code.
local function read_terms(lit, of, terms)
  local list, value = {}, 0
  for i, term in ipairs(terms) do
    local r = type(term) == "table" and term[1] or nil
    if core.type(r) ~= "ylm.receivers" then
      return check.fail("importance: term %d must be { receivers, weights = [n] }, got %s", i, check.describe(term))
    end
    local m = objects.open_receivers("importance", r)
    if m.links ~= of.links then return check.fail("importance: receivers %d are of other links than the radiosity", i) end
    local w = weights_of(("weights of term %d"):format(i), term.weights, m.count)
    local E, message, code = objects.receivers.irradiance(r, lit)
    if not E then return nil, message, code end
    value = value + (E * w):sum()
    list[i] = { receivers = r, made = m, weights = unfolded(w, m) }
  end
  return list, value
end

local room = [[
local scene = ylm.scene "a room and a lamp" {
  geometry = { ylm.box { scale = 4, material = ylm.matte { albedo = 0.5 } } },
  lights = ylm.photometric_light { photometry = ylm.photometry { cosine = 1, lumens = 3000 }, at = { 0.4, 1.5, 0 } },
}
local t = scene:links { spacing = 1, rays = 64 }
local desk = t:receivers { plane = { at = { 0, -1, 0 }, size = { 3, 3 } } }
local lit = t:radiosity(scene.lights, { derivatives = true })
local mean = lit:importance { { desk, weights = desk.weights } }
]]

describe "radiosity:importance" {
  about = "The worth of light on each element to a weighted sum J of illuminances: one solution over the links read backwards, "
    .. "for all lamps. J may be any function: weights are then its derivatives by the illuminances.",
  arguments = {
    { "terms", "table", "a list of { receivers, weights = w }: w is [n], by illuminance, or [n][3], by the channels of "
      .. "irradiance; `elements` = weights of the elements' irradiance, optional" },
  },
  returns = { { "importance", "importance", "importance:derivatives(), importance:elements()" } },
  errors = "raises on weights of another number, and receivers of other links; nil, message, code: memory",
  example = room .. "assert(mean:elements().shape[1] == t.stats.elements)",
  source = "Smits, Arvo & Salesin 1992",
}
function objects.radiosity.importance(lit, terms)
  local of = objects.open_radiosity("importance", lit)
  if type(terms) ~= "table" then return check.bad(1, "importance", "a list of terms expected, got %s", check.describe(terms)) end
  for key in pairs(terms) do
    if type(key) ~= "number" and key ~= "elements" then
      return check.fail("importance: no such term: %s", check.describe(key))
    end
  end
  if #terms == 0 and terms.elements == nil then
    return check.fail "importance: nothing is weighed: give { receivers, weights = } or elements ="
  end
  local list, value, code = read_terms(lit, of, terms)
  if not list then return nil, value, code end
  local n, leaving, falling = of.elements, array.zeros({ of.elements, 3 }, "double"), nil
  if terms.elements ~= nil then
    falling = weights_of("elements", terms.elements, n)
    value = value + (of.lib.radiosity_values(lit, "irradiance") * falling):sum()
  end
  for _, term in ipairs(list) do leaving = leaving + of.lib.receivers_scatter(term.receivers, term.weights) end
  local back, message
  back, message, code = transposed(of)
  if not back then return nil, message, code end
  local found
  found, message, code = check.result("importance", of.lib.transpose_importance(back, lit, leaving, falling, of.options.threads))
  if not found then return nil, message, code end
  local reads = of.stats.bounces * of.of.stats.elements * of.of.stats.links
  for _, term in ipairs(list) do reads = reads + term.made.count * term.made.fold * term.made.options.rays end
  local out = setmetatable({}, metatable)
  core.own(out).made = { radiosity = lit, of = of, from = of.from, terms = list, leaving = leaving, lambda = found, value = value,
    transpose = back, link_reads = reads }
  return out
end

local function made_of(name, i)
  local m = type(i) == "table" and core.owned(i, "made")
  return m and m.lambda and m or check.fail("%s: an importance expected before the colon, got %s", name, check.describe(i))
end

describe "importance:elements" {
  about = "The worth of a unit of direct irradiance on each element, all its bounces included.",
  arguments = {},
  returns = { { "worth", "array", "double [n][3], by channel: J per W m^-2, or per lx in channels" } },
  errors = "raises on what is no importance",
  example = room .. "assert(mean:elements():min() >= 0)",
}
function methods.elements(i) return made_of("elements", i).lambda * 1 end

-- Derivatives ---------------------------------------------------------------------------------------------------

local NUMBERS = { scale = 0, place = 3, turn = 6, size = 9, noise = 11 }

--- Sums over elements and receivers, squares of noise added; or nil, message, code.
local function weigh(m, threads)
  local total, why, failed = m.from.lamplight:weigh("derivatives", m.lambda, threads)
  if not total then return nil, why, failed end
  for k = 1, #total do for q = NUMBERS.noise + 1, #total[k] do total[k][q] = total[k][q] ^ 2 end end
  for _, term in ipairs(m.terms) do
    local at, message, code = objects.lamplight_at("derivatives", term.receivers, m.radiosity)
    if not at then return nil, message, code end
    local more
    more, message, code = at:weigh("derivatives", term.weights, threads)
    if not more then return nil, message, code end
    for k = 1, #total do
      for q = 1, #total[k] do
        total[k][q] = total[k][q] + (q > NUMBERS.noise and more[k][q] ^ 2 or more[k][q])
      end
    end
  end
  return total
end

local function three(row, at) return { row[at + 1], row[at + 2], row[at + 3] } end

--- One lamp's derivatives from its row of sums.
local function of_lamp(l, row)
  local power, turn = three(row, NUMBERS.scale), three(row, NUMBERS.turn)
  local d = { position = three(row, NUMBERS.place) }
  d.direction, d.turn = lamps.by_direction(l, turn)
  local full = 0
  for c = 1, 3 do full = full + power[c] * l.full[c] end
  d.dim, d.lumens = full, l.flux ~= 0 and full / l.flux or 0
  local by_channels = l.by_channels or l.by_colour
  for c = 1, 3 do power[c + 3], power[c] = power[c] * by_channels, power[c] * l.by_colour end
  d.colour, d.channels = three(power, 0), three(power, 3)
  local size = { row[NUMBERS.size + 1], row[NUMBERS.size + 2] }
  d.radius = (l.shape == "disk" or l.shape == "sphere") and size[1] or 0
  d.size = l.shape == "rectangle" and { size[1] / 2, size[2] / 2 } or { 0, 0 }
  d.factor = l.by_factor and l.by_factor * size[1] or l.half[1] * size[1] + l.half[2] * size[2]
  local at = NUMBERS.noise
  d.noise_dim = l.dim ~= 0 and math.sqrt(row[at + 1]) / math.abs(l.dim) or 0
  d.noise_lumens = l.flux ~= 0 and d.noise_dim / math.abs(l.flux) or 0
  d.noise_position = { math.sqrt(row[at + 2]), math.sqrt(row[at + 3]), math.sqrt(row[at + 4]) }
  d.noise_turn = { math.sqrt(row[at + 5]), math.sqrt(row[at + 6]), math.sqrt(row[at + 7]) }
  return d
end

--- A list of derivatives of lamps as arrays, by name.
local function columns(list, names)
  local out = {}
  for _, name in ipairs(names) do
    local rows = {}
    for k, d in ipairs(list) do rows[k] = d[name] end
    out[name] = array.array(rows, "double")
  end
  return out
end

local function by_mesh(of, albedo)
  local mesh = core.array_totable((select(5, of.lib.transfer_elements(of.links))))
  local rows, out = albedo:totable(), {}
  for k = 1, #of.scene.geometry do out[k] = { 0, 0, 0 } end
  for i, row in ipairs(rows) do for c = 1, 3 do out[mesh[i]][c] = out[mesh[i]][c] + row[c] end end
  return array.array(out, "double")
end

--- Sentences about derivatives that are left out; nil: none are.
local function notes_of(from)
  local notes, points = {}, 0
  for k, l in ipairs(from.lamps) do
    if not lamps.has_rim(l) then points = points + 1 end
    if l.other then
      notes[#notes + 1] = ("light %d, %s, has derivatives by level and colour alone"):format(k, l.kind)
    end
  end
  if points > 0 then
    notes[#notes + 1] = ("%d lamps are points: derivatives by their place hold their shadows"):format(points)
  end
  if from.lamplight:stats().again then
    notes[#notes + 1] = "records of lamps are more than bytes: their rays were traced twice"
  end
  return #notes > 0 and notes or nil
end

local options = {
  { "albedo", "boolean", default = false,
    about = "derivatives by the albedo of elements and of meshes too: one more read of the links" },
  form.threads,
}

describe "importance:derivatives" {
  about = "Derivatives of the weighted sum by every light, with shadows and all bounces: no ray is traced. Shadows count as the "
    .. "rim of each lamp sees them (rim of links:radiosity); rim = 0 holds them. Skies, images and sets of lights have "
    .. "derivatives by level and colour alone; points hold their shadows.",
  arguments = { { "options?", "table", "" } },
  options = options,
  returns = { { "d", "table", "arrays in the order of the lights: position [lamps][3], per scene unit; direction [lamps][3], by "
    .. "the direction of length 1 that a lamp looks in, of suns that towards them; turn [lamps], per degree; lumens [lamps], per "
    .. "lm, or W of light, 0 of suns and skies; dim [lamps]; colour [lamps][3], by channels of a colour of luminance 1, or of "
    .. "radiance, irradiance, intensity; channels [lamps][3], as colour, of photometric lamps by channels of dim times colour; "
    .. "radius [lamps]; size [lamps][2], by the sides of rectangles; factor [lamps], by a factor of the size of the opening: "
    .. "lumens held; noise: { position, turn (about x, y, z, per radian), lumens, dim }, standard errors by halves of the rays; "
    .. "with albedo = true albedo [elements][3] and mesh_albedo [meshes][3]; notes" } },
  errors = "raises where the radiosity is without derivatives = true, or was lit anew since; nil, message, code: memory",
  example = room .. [[
local d = mean:derivatives { albedo = true }
assert(math.abs(d.lumens:get(1) * 3000 / mean.value - 1) < 1e-3) -- light is proportional to its lumens
assert(d.position:get(1, 1) < 0) -- nearer to the middle of the room is brighter]],
  source = "docs/math.md \"Derivatives by the lamp\"",
}
function methods.derivatives(i, given)
  local m = made_of("derivatives", i)
  local o = form.options(1, "derivatives", options, given)
  if not m.from.lamps then
    return check.fail "derivatives: the radiosity keeps no light lamp by lamp: links:radiosity(lights, { derivatives = true })"
  end
  if m.of.from ~= m.from or m.of.closed then
    return check.fail "derivatives: the radiosity has been lit anew: take its importance again"
  end
  local total, message, code = weigh(m, o.threads)
  if not total then return nil, message, code end
  local list = {}
  for k, l in ipairs(m.from.lamps) do list[k] = of_lamp(l, total[k]) end
  local d = columns(list, { "position", "direction", "turn", "lumens", "dim", "colour", "channels", "radius", "size", "factor" })
  local noise = columns(list, { "noise_position", "noise_turn", "noise_lumens", "noise_dim" })
  d.noise = { position = noise.noise_position, turn = noise.noise_turn, lumens = noise.noise_lumens, dim = noise.noise_dim }
  d.notes = notes_of(m.from)
  if o.albedo then
    d.albedo, message, code = check.result("derivatives", m.of.lib.transpose_albedo(m.transpose, m.radiosity, m.leaving, m.lambda,
      o.threads))
    if not d.albedo then return nil, message, code end
    d.mesh_albedo = by_mesh(m.of, d.albedo)
  end
  return show.report(d)
end

memory.publish(methods)

return methods
