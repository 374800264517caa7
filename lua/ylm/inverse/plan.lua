--- Plans, as scene:inverse_lighting returns them: lamps, their scene, pictures and files of them.

local array = require "ylm.array"
local changed = require "ylm.inverse.changed"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local figures = require "ylm.figure"
local form = require "ylm.form"
local memory = require "ylm.memory"
local objects = require "ylm.transfer.object"
local plot = require "ylm.plot"
local scenes = require "ylm.scene"
local targets = require "ylm.inverse.targets"
local vary = require "ylm.inverse.vary"
local written = require "ylm.inverse.written"

local plans, methods = {}, {}

local LEAST_CURVE = 240 -- pixels: narrower ones have no room for their words

require "ylm.describe".object "plan" {
  about = "Lamps that were found for light that is asked for (scene:inverse_lighting).",
  fields = {
    { "lights", "table", "as they are now, in the order of the scene's" },
    { "scene", "scene", "the scene with these lights" },
    { "trace", "table", "a list by evaluation of { value, targets = { { mean, least, most, uniformity }, ... } }" },
    { "report", "table", "as scene:inverse_lighting returns it" },
  },
  methods = methods,
}

local metatable = {
  __index = function(p, key)
    local m = core.owned(p, "made")
    if key == "lights" or key == "scene" or key == "trace" or key == "report" then return m[key] end
    return methods[key]
  end,
  __newindex = function(_, key) return check.fail("plan: cannot set %s: a plan does not change", check.describe(key)) end,
  __tostring = function(p)
    local m = core.owned(p, "made")
    return ("ylm.plan of %q: %d lights, %s"):format(m.scene.name, #m.lights, m.report.met and "met" or "not met")
  end,
}

--- The plan of a search.
function plans.create(work, best, trace, report)
  local lights = vary.lights(work.plan, best.x)
  local s = work.scene
  local scene = scenes.scene(s.name) { camera = s.camera, geometry = s.geometry, lights = lights, background = not s.sky_is_seen
    and s.background or nil }
  local p = setmetatable({}, metatable)
  core.own(p).made = { lights = lights, scene = scene, before = s, trace = trace, report = report, targets = work.targets,
    first = work.first, last = best.F }
  return p
end

local function open(name, p)
  local m = type(p) == "table" and core.owned(p, "made")
  return m and m.trace and m or check.fail("%s: a plan expected before the colon, got %s", name, check.describe(p))
end

-- Pictures --------------------------------------------------------------------------------------------------------

--- How large a map is, in pixels; pixels of a scene unit, or of a texel of a lightmap.
local function window(t, width)
  local size = t.plane and t.plane.size or t.receivers.size
  local pixels = width / size[1]
  return { pixels = pixels, width = width, height = math.max(2, math.floor(size[2] * pixels + 0.5)) }
end

--- A map whose places in bodies, 0, have the mean of their neighbours.
local function filled(map)
  local rows = map:totable()
  for _ = 1, math.max(#rows, #rows[1]) do
    local fresh, left = {}, false
    for r, row in ipairs(rows) do
      for c, v in ipairs(row) do
        local sum, n = 0, 0
        for _, at in ipairs(v > 0 and {} or { { r - 1, c }, { r + 1, c }, { r, c - 1 }, { r, c + 1 } }) do
          local near = rows[at[1]] and rows[at[1]][at[2]] or 0
          if near > 0 then sum, n = sum + near, n + 1 end
        end
        if n > 0 then fresh[#fresh + 1] = { r, c, sum / n } elseif not (v > 0) then left = true end
      end
    end
    for _, f in ipairs(fresh) do rows[f[1]][f[2]] = f[3] end
    if #fresh == 0 or not left then break end
  end
  return rows
end

--- A map as pixels with isolux lines, dark where the light passes a multiple of `step`, and lamps as dots.
local function drawn(t, map, lights, width, step, least)
  local w = window(t, width)
  local rows, pixels = filled(map), {}
  for y = 1, w.height do
    pixels[y] = {}
    for x = 1, w.width do
      pixels[y][x] = targets.between(rows, (x - 0.5) / w.width * #rows[1] + 0.5, (y - 0.5) / w.height * #rows + 0.5)
    end
  end
  local out = {}
  for y = 1, w.height do
    out[y] = {}
    for x = 1, w.width do
      local here = math.floor(pixels[y][x] / step)
      local right, below = pixels[y][x + 1] or pixels[y][x], (pixels[y + 1] or pixels[y])[x]
      local line = here ~= math.floor(right / step) or here ~= math.floor(below / step)
      out[y][x] = line and least or pixels[y][x]
    end
  end
  local normal = t.plane and (t.plane.normal or { 0, 1, 0 }) or { 0, 0, 0 }
  for _, at in ipairs(normal[2] > 0.9 and changed.places(lights) or {}) do -- seen from above
    local cx = (at[1] - t.plane.at[1]) * w.pixels + w.width / 2
    local cy = (at[3] - t.plane.at[3]) * w.pixels + w.height / 2
    for y = math.max(1, math.floor(cy - 4)), math.min(w.height, math.ceil(cy + 4)) do
      for x = math.max(1, math.floor(cx - 4)), math.min(w.width, math.ceil(cx + 4)) do
        local far = math.sqrt((x - cx) ^ 2 + (y - cy) ^ 2)
        if far < 2.6 then out[y][x] = math.huge elseif far < 4 then out[y][x] = least end
      end
    end
  end
  return out
end

--- Round steps of isolux lines: about eight up to the largest.
local function step_of(most)
  local raw = most / 8
  local unit = 10 ^ math.floor(math.log(raw) / math.log(10))
  for _, k in ipairs { 1, 2, 5 } do if raw <= k * unit then return k * unit end end
  return 10 * unit
end

local function words(f)
  return ("mean %.0f lx, least %.0f, U0 %.2f"):format(f.mean, f.least, f.uniformity)
end

--- Maps of one target before and after; nil: it is no plane, and no lightmap.
local function maps(m, i, o)
  local t = m.targets[i]
  if not t.receivers.size then return nil end
  local most = 0
  local first, last = targets.luminances(t, m.first[i]), targets.luminances(t, m.last[i])
  for _, F in ipairs { first, last } do for _, v in ipairs(F) do most = math.max(most, v) end end
  local step = step_of(most)
  local range = { 0, math.ceil(most / step) * step }
  local function item(F, lights, caption)
    local rows = drawn(t, objects.as_map(t.receivers, array.array(F, "double")), lights, o.width, step, 0)
    for _, row in ipairs(rows) do for x, v in ipairs(row) do row[x] = math.min(v, range[2]) end end
    return { values = array.array(rows, "float"), range = range, map = "viridis", caption = caption }
  end
  local report = m.report.targets[i]
  local row = { item(first, m.before.lights, "before: " .. words(report.before)) }
  if t.wanted or t.shape then
    local F, scale = targets.luminances(t, t.wanted or t.shape), 1
    if t.shape then
      local sum, mean = 0, 0
      for r = 1, t.count do sum, mean = sum + t.areas[r] * F[r], mean + t.areas[r] * last[r] end
      scale = mean / sum
    end
    local scaled = {}
    for r = 1, t.count do scaled[r] = F[r] * scale end
    row[#row + 1] = item(scaled, {}, "wanted")
  end
  row[#row + 1] = item(last, m.lights, ("after: %s%s, by %s"):format(words(report), report.rms and (", rms %.2f"):format(
    report.rms) or "", report.judged))
  return row, range, step
end

--- Curves of the search.
local function curves(m, o)
  local x, value, mean, last, rms = {}, {}, {}, {}, m.trace[1] and m.trace[1].targets[1].rms
  for k, entry in ipairs(m.trace) do
    x[k], value[k] = k, math.max(entry.value, 1e-12)
    mean[k], last[k] = entry.targets[1].mean, rms and entry.targets[1].rms or entry.targets[1].uniformity
  end
  if #x < 2 then return nil end
  local width = math.max(o.width, LEAST_CURVE)
  local function curve(y, label, log)
    return { image = plot.plot { x = x, y = y, size = { width, math.floor(width * 0.55) }, y_log = log,
      x_label = "evaluation", y_label = label, background = "dark" } }
  end
  return { curve(value, "what is left to be asked for", true), curve(mean, "mean, lx"),
    curve(last, rms and "rms, of what is wanted" or "U0") }
end

local figure_options = {
  { "width", "integer", min = 64, max = 4096, default = 420, unit = "pixels", about = "of a map" },
}

local planned = [[
local lamp = ylm.photometry { cosine = 1, lumens = 3000 }
local room = ylm.scene "a room" {
  geometry = { ylm.box { scale = 4, material = ylm.matte { albedo = 0.5 } } },
  lights = { ylm.photometric_light { photometry = lamp, at = { -1, 1.8, 0 } } },
}
local plan = room:inverse_lighting { vary = { { dim = { 0, 2 } } },
  targets = { { plane = { at = { 0, -1, 0 }, size = { 3, 3 } }, mean = { least = 300 } } }, judge = 0 }
]]

describe "plan:figure" {
  about = "Maps of each plane and lightmap before and after, as the links see them, with isolux lines and lamps as dots, and "
    .. "curves of the search.",
  arguments = { { "options?", "table", "" } },
  options = figure_options,
  returns = { { "figure", "figure", "figure:save 'plan.png'" } },
  errors = "raises where no target is a plane or a lightmap",
  example = planned .. "assert(tostring(plan:figure { width = 64 }):find 'figure')",
}
function methods.figure(p, given)
  local m = open("figure", p)
  local o = form.options(1, "figure", figure_options, given)
  local rows, bar, steps = {}, nil, nil
  for i = 1, #m.targets do
    local row, range, step = maps(m, i, o)
    if row then
      rows[#rows + 1], bar, steps = row, bar or range, steps or step
    end
  end
  if #rows == 0 then return check.fail "figure: no target is a plane or a lightmap" end
  rows[#rows + 1] = curves(m, o)
  local r = m.report
  local verdict = not targets.have_limits(m.targets) and "" or r.met and "; what is asked for is met"
    or "; not all that is asked for is met"
  return figures.figure { title = m.scene.name, rows = rows,
    bar = { range = bar, map = "viridis", label = "illuminance, lx" },
    caption = ("%d evaluations; %.0f lm, %.0f before; isolux lines every %g lx%s"):format(r.evaluations, r.lumens,
      r.lumens_before, steps, verdict) }
end

-- Files -----------------------------------------------------------------------------------------------------------

describe "plan:save" {
  about = "Writes the planned scene as a scene file, with its surfaces as .glb and its photometries as .ies beside it.",
  arguments = { { "path", "string", "ends in .lua" } },
  returns = { { "ok", "boolean", "true" }, { "files", "string[]", "what was written" } },
  errors = "raises on another ending; nil, message, code where a file cannot be written",
  example = planned .. [[
local name = os.tmpname()
local ok, files = plan:save(name .. ".lua")
assert(ok and #assert(ylm.load(name .. ".lua")).lights == 1)
for _, file in ipairs(files) do os.remove(file) end
os.remove(name)]],
}
function methods.save(p, path)
  local m = open("save", p)
  if type(path) ~= "string" or path:find "%z" or not path:lower():find "[^/]%.lua$" then
    return check.bad(1, "save", "a file name that ends in .lua expected, got %s", check.describe(path))
  end
  return written.save(m.scene, path)
end

memory.publish(methods)

return plans
