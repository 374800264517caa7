-- scene:live by replays in hidden windows: what events do, what is shown, undo, saving, refusals.

local long = require "spec.support.long"
local random_events = require "spec.fuzz.live"
local scratch = require "spec.support.scratch"
local views = require "spec.support.views"

if not views.vtk "scene:live" then return end

local bindings = require "ylm.live.bindings"
local core = require "ylm.c.core"
local actions = require "ylm.live.actions"
local replay = require "ylm.live.replay"
local sessions = require "ylm.live.session"
local space = require "ylm.live.space"
local states = require "ylm.live.state"
local undo = require "ylm.live.undo"
local ylm = require "ylm"
local vtk = require "ylm.c.vtk"

local function scene(more)
  local fields = {
    camera = ylm.camera { from = { 0, 1.4, 3.2 }, at = { 0, 0.4, 0 }, fov = 45 },
    geometry = {
      ylm.quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 8,
        material = ylm.matte { albedo = { 0.7, 0.6, 0.5 } } },
      ylm.sphere { at = { 0.5, 0.4, -0.5 }, radius = 0.4, divide = 24 },
    },
    lights = {
      ylm.sphere_light { at = { -0.5, 0.5, 0.3 }, radius = 0.08, radiance = { 30, 24, 15 } },
      ylm.sphere_lights { at = { { 0.9, 0.6, 0.6 }, { 0.2, 1, -1 } }, radius = { 0.06, 0.05 }, radiance = 20 },
    },
    probes = ylm.adaptive_grid { lmax = 3, depth = 4, tolerance = 0.03 },
  }
  for k, v in pairs(more or {}) do fields[k] = v end
  return ylm.scene "live" (fields)
end

local SIZE = { 96, 72 }

--- Plays events in a hidden window.
local function play(s, events, more)
  local o = { size = SIZE, hidden = true, quiet = true, events = events, samples = 2, transfer_samples = 16,
    refine = { "view", "grid", "smooth" }, save = "unused/live" }
  for k, v in pairs(more or {}) do o[k] = v end
  return s:live(o)
end

--- The pixels of a .png file, [h][w][3] of 0 to 1.
local function pixels(path)
  return assert(ylm.load(path, { raw = true })):layer "radiance"
end

local function bytes(path)
  local file = assert(io.open(path, "rb"))
  local text = file:read "*a"
  file:close()
  return text
end

--- Where a lamp is seen in the window.
local function seen(s, i, size)
  local c, at = s.camera, i == 1 and { -0.5, 0.5, 0.3 } or { 0.9, 0.6, 0.6 }
  local f = space.frame({ from = c.from, at = c.at, up = c.up, fov = c.fov }, (size or SIZE)[1], (size or SIZE)[2])
  local x, y = space.project(f, at)
  return math.floor(x + 0.5), math.floor(y + 0.5)
end

local function drag(s, dx, dy, modifier)
  local x, y = seen(s, 1)
  return { { 0, "press", x, y, "left" }, { 1, "move", x + dx / 2, y + dy / 2, [modifier or 1] = modifier and true or 1 },
    { 2, "move", x + dx, y + dy, [modifier or 1] = modifier and true or 2 },
    { 3, "release", x + dx, y + dy, "left", [modifier or 1] = modifier and true or 3 } }
end

local function state_of(more)
  local rows = {}
  for i = 1, 5 do rows[i] = { at = { 0.2 * i, 0.4, -0.1 * i }, radius = 0.1, radiance = { i, 2, 3 }, number = i } end
  local camera = { from = { 0, 1, 4 }, at = { 0, 0.5, 0 }, up = { 0, 1, 0 }, fov = 45 }
  local settings = { tolerance = 0.05, depth = 6, lmax = 4, exposure = 0, tone = "srgb", method = "grid", levels = false,
    lobes = false, gradients = false, errors = false, truth = false, panel = true }
  local s = { size = { 640, 480 }, camera = camera, cameras = { camera }, lamps = rows, settings = settings,
    tones = core.choices "tone", methods = { "grid", "rays" }, diagonal = 4, near = 0.004, middle = { 0, 0.5, 0 },
    surface_at = function() return { position = { 0, 0, 0 }, normal = { 0, 1, 0 }, object = 1, depth = 4 } end,
    lamp_at = function(x) return x < 200 and 1 or nil end }
  for k, v in pairs(more or {}) do s[k] = v end
  return states.new(s)
end

local function key(name, shift, control) return { kind = "key", key = name, x = 0, y = 0, shift = shift, control = control } end

describe("scene:live, events", function()
  it("keep a dragged lamp under the pointer, in three planes and by five cameras", function()
    local cameras = { { from = { 0, 1, 4 }, at = { 0, 0.5, 0 }, up = { 0, 1, 0 }, fov = 45 },
      { from = { 3, 3, 3 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 30 },
      { from = { -2, 0.6, 1 }, at = { 0, 0.5, 0 }, up = { 0, 1, 0 }, fov = 70 },
      { from = { 0, 5, 0.5 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 45 },
      { from = { 1, -4, 2 }, at = { 0, 0, 0 }, up = { 0, 0, 1 }, fov = 45 } }
    for _, camera in ipairs(cameras) do
      local f = space.frame(camera, 640, 480)
      local p = { 0.3, 0.4, 0.2 }
      local x, y, z = space.project(f, p)
      for _, to in ipairs { { x + 30, y + 11 }, { x - 17, y + 25.5 } } do
        for _, way in ipairs { "facing", "across" } do
          local q = space.dragged(f, way, p, camera.up, to[1], to[2])
          local qx, qy, qz = space.project(f, q)
          assert(math.abs(qx - to[1]) < 0.5 and math.abs(qy - to[2]) < 0.5)
          if way == "facing" then assert(math.abs(qz - z) < 1e-9)
          else assert(math.abs(space.dot(space.minus(q, p), camera.up)) < 1e-9) end
        end
      end
      -- Along a line the pointer has to stay on the line's picture.
      local ux, uy = space.project(f, space.plus(p, camera.up, 0.1))
      local q = space.dragged(f, "along", p, camera.up, ux, uy)
      local qx, qy = space.project(f, q)
      assert(math.abs(qx - ux) < 0.5 and math.abs(qy - uy) < 0.5)
      assert(math.abs(q[1] - p[1] - (q[2] - p[2]) * camera.up[1]) < 1e-9)
    end
  end)

  it("turn and shift the camera about what it looks at", function()
    local c = { from = { 0, 1, 4 }, at = { 0, 0.5, 0 }, up = { 0, 1, 0 }, fov = 45 }
    local turned = space.turned(c, 37, -20, 480)
    local function distance(a) return math.sqrt(space.dot(space.minus(a.from, a.at), space.minus(a.from, a.at))) end
    assert(math.abs(distance(turned) - distance(c)) < 1e-12)
    local over = space.turned(c, 0, 1e5, 480)
    assert(over.from[2] < 0.5 + distance(c) and over.from[2] > 0.5 + 0.99 * distance(c))
    local shifted = space.shifted(c, 50, 20, 640, 480)
    local x, y = space.project(space.frame(shifted, 640, 480), c.at)
    assert(math.abs(x - 370) < 1e-6 and math.abs(y - 260) < 1e-6)
    assert(math.abs(distance(space.nearer(c, 1, 0.001, 100)) - 0.9 * distance(c)) < 1e-12)
    assert.equal(0.5, distance(space.nearer(c, 1000, 0.5, 100)))
  end)

  it("do what the list of keys says, every one", function()
    local function lamp(s) return s.lamps[s.chosen or 1] end
    local checks = {
      finer = function(s) return s.settings.tolerance < 0.05 end, coarser = function(s) return s.settings.tolerance > 0.05 end,
      deeper = function(s) return s.settings.depth == 7 end, shallower = function(s) return s.settings.depth == 5 end,
      brighter = function(s) return s.settings.exposure > 0.3 end, darker = function(s) return s.settings.exposure < -0.3 end,
      tone = function(s) return s.settings.tone ~= "srgb" end, method = function(s) return s.settings.method == "rays" end,
      next_lamp = function(s) return s.chosen == 3 end,
      nudge = function(s)
        local f = space.frame(s.camera, s:picture_size())
        local x, y = space.project(f, lamp(s).at)
        local x0, y0 = space.project(f, { 0.4, 0.4, -0.2 })
        return math.abs(math.abs(x - x0) + math.abs(y - y0) - 4) < 1e-6
      end,
      push = function(s) return math.abs(lamp(s).at[1] / 0.4 - 1) > 0.005 end,
      resize_lamp = function(s) return math.abs(math.abs(math.log(lamp(s).radius / 0.1)) - math.log(1.1)) < 1e-9 end,
      dim_lamp = function(s) return math.abs(math.abs(math.log(lamp(s).radiance[2] / 2)) - math.log(1.1)) < 1e-9 end,
      new_lamp = function(s) return #s.lamps == 6 and s.chosen == 6 end, delete_lamp = function(s) return #s.lamps == 4 end,
      levels = function(s) return s.settings.levels end, lobes = function(s) return s.settings.lobes end,
      gradients = function(s) return s.settings.gradients end, errors = function(s) return s.settings.errors end,
      truth = function(s) return s.settings.truth end, panel = function(s) return not s.settings.panel end,
      help = function(s) return s.help end, close = function(s) return s.closed end,
      save = function(_, changed) return changed.save end, undo = function(s) return s.settings.depth == 6 end,
      redo = function(s) return s.settings.depth == 7 end, home = function(s) return s.camera == s.cameras[1] end,
      camera = function(s) return s.camera == s.cameras[1] end,
    }
    for _, row in ipairs(bindings.keys) do
      local check = checks[row[2]]
      assert(check and actions[row[2]], row[2])
      for k, name in ipairs(row[1]) do
        local s = state_of()
        s.chosen = 2
        if row[2] == "undo" or row[2] == "redo" then s:take({ key "d" }, 5) end
        if row[2] == "redo" then s:take({ key("z", false, true) }, 8) end
        if row[2] == "home" then s:take({ { kind = "wheel", x = 300, y = 300, notches = 3 } }, 5) end
        if row[2] ~= "camera" or k == 1 then
          local changed = s:take({ key(name, false, row.control) }, 10)
          assert(check(s, changed), row[2] .. " by " .. name)
        end
      end
    end
    local s = state_of()
    s:take { key("Tab", true) }
    assert.equal(5, s.chosen)
  end)

  it("are all in docs/live.md and in the help of the tool", function()
    local page = bytes "docs/live.md"
    local help = require "ylm.cli.live".notes
    for _, line in ipairs(bindings.lines()) do
      assert(page:find(line[2], 1, true), line[2])
      assert(help:find(line[2], 1, true) and help:find(line[1], 1, true), line[2])
    end
  end)

  it("drag sliders, click on switches, turn and shift, and choose lamps", function()
    local layout = require "ylm.live.layout"
    local s = state_of()
    for _, item in ipairs((layout.items(s))) do
      local x, y = item.x + item.w / 4, item.y + item.h / 2
      local changed = s:take { { kind = "press", x = x, y = y, button = "left" } }
      if item.knob then
        assert(math.abs(layout.part(item.knob, s.settings[item.knob.name]) - 0.25) < 0.06, item.knob.name)
        s:take { { kind = "move", x = item.x + 2 * item.w, y = y } }
        assert.equal(item.knob.largest, s.settings[item.knob.name])
      else assert(next(changed) or item.action == "undo", item.action) end
      s:take { { kind = "release", x = x, y = y, button = "left" } }
      s.help = false
    end
    local b = state_of()
    b:take { { kind = "press", x = 100, y = 200, button = "left" } }
    assert.equal(1, b.chosen)
    local before = b.lamps[1].at
    b:take { { kind = "move", x = 130, y = 200 }, { kind = "wheel", x = 130, y = 200, notches = 2 },
      { kind = "release", x = 130, y = 200, button = "left" } }
    assert(b.lamps[1].at ~= before and b.drag == nil)
    local camera = b.camera
    b:take { { kind = "press", x = 300, y = 200, button = "left" }, { kind = "move", x = 340, y = 210 },
      { kind = "release", x = 340, y = 210, button = "left" } }
    assert(b.camera ~= camera and b.picked == nil)
    b:take({ { kind = "press", x = 300, y = 200, button = "left" }, { kind = "release", x = 300, y = 200, button = "left" } }, 20)
    assert(b.picked)
    local at = b.camera.at
    b:take({ { kind = "press", x = 300, y = 200, button = "left" }, { kind = "release", x = 300, y = 200, button = "left" } },
      20.2)
    assert(b.camera.at ~= at and b.camera.at[2] == 0, "a double click looks there")
  end)

  it("are undone one by one, and done again, to the bit", function()
    local random = scratch.random and scratch.random(7) or nil
    local seed = 12345
    local function pick(n)
      seed = (seed * 16807) % 2147483647
      return random and random(n) or seed % n + 1
    end
    local s = state_of()
    local function picture()
      local out = { s.camera.from[1], s.camera.from[2], s.camera.from[3], s.camera.at[1], s.camera.fov }
      for _, name in ipairs { "tolerance", "depth", "lmax", "exposure", "tone", "method", "levels", "errors", "panel" } do
        out[#out + 1] = tostring(s.settings[name])
      end
      for _, row in ipairs(s.lamps) do
        for a = 1, 3 do out[#out + 1] = ("%.17g"):format(row.at[a]) end
        out[#out + 1] = ("%.17g %.17g"):format(row.radius, row.radiance[2])
      end
      return table.concat(out, " ")
    end
    local names = { "t", "T", "d", "D", "plus", "minus", "o", "m", "Left", "Up", "Page_Up", "bracketleft", "comma", "n", "Delete",
      "l", "v", "p" }
    local stack, now = { picture() }, 0
    for i = 1, 50 do
      now = now + 5
      if i % 4 == 0 then
        local x, y = pick(400), pick(480)
        s:take({ { kind = "press", x = x, y = y, button = "left" } }, now)
        for _ = 1, 3 do s:take({ { kind = "move", x = pick(400), y = pick(480) } }, now) end
        s:take({ { kind = "release", x = pick(400), y = pick(480), button = "left" } }, now)
      else
        s.chosen = s.chosen or (#s.lamps > 0 and pick(#s.lamps)) or nil
        s:take({ key(names[pick(#names)]) }, now)
      end
      if picture() ~= stack[#stack] then stack[#stack + 1] = picture() end
    end
    assert(#stack > 30, #stack)
    for i = #stack - 1, 1, -1 do
      s:take({ key("z", false, true) }, 1000 + i)
      assert.equal(stack[i], picture(), "undo " .. i)
    end
    assert.equal(nil, undo.step(s.history, s))
    for i = 2, #stack do
      s:take({ key("Z", true, true) }, 2000 + i)
      assert.equal(stack[i], picture(), "redo " .. i)
    end
  end)

  it("of one key within a second are undone together", function()
    local s = state_of()
    for i = 1, 4 do s:take({ key "t" }, i * 0.2) end
    s:take({ key("z", false, true) }, 9)
    assert.equal(0.05, s.settings.tolerance)
  end)

  it("keep lamps where they may be, whatever the pointer does", function()
    local s = state_of()
    s:take { { kind = "press", x = 100, y = 200, button = "left" } }
    for _, to in ipairs { { 1e6, -1e6 }, { -5000, 240 }, { 0, 0 }, { 204, 240 } } do
      for _, modifier in ipairs { "shift", "control", "none" } do
        s:take { { kind = "move", x = to[1], y = to[2], [modifier] = true } }
        s:take { { kind = "wheel", x = 0, y = 0, notches = -20 } }
        s:take { { kind = "wheel", x = 0, y = 0, notches = 20 } }
        local p = s.lamps[1].at
        local away = math.sqrt((p[1]) ^ 2 + (p[2] - 0.5) ^ 2 + p[3] ^ 2)
        assert(away <= 16.1, away)
        local _, _, z = space.project(space.frame(s.camera, s:picture_size()), p)
        assert(z and z >= 0.004)
      end
    end
  end)
end)

describe("scene:live, replays", function()
  local folder
  before_each(function() folder = scratch.new() end)
  after_each(function() folder:remove() end)

  --- A picture of light as it is shown, by a fresh view, a fresh grid.
  local function fresh(s, tone, exposure, size)
    local stage = ylm.scene "stage" { camera = s.camera, geometry = s.geometry }
    local view = assert(stage:prepare { size = size or SIZE, samples = 2, transfer_samples = 16, visibility = "transfer",
      lmax = 3 })
    local grid = assert(s:bake { quantity = "lights" })
    local image = assert(view:render { grid = grid, lamps = s.lights, layers = false })
    return core.canvas_pixels(core.canvas_image(image, nil, tone, exposure)), image
  end

  it("end in the picture of a fresh view and a fresh grid, for every tone curve", function()
    local s, events = scene(), drag(scene(), 18, -9)
    events[5] = { 4, "rest" }
    local edited = assert(play(s, events))
    assert(math.abs(edited.lights[1].at[1] + 0.5) > 0.1)
    local tones, shown = core.choices "tone", { { 0, "rest" } }
    for i = 1, #tones do
      shown[#shown + 1] = { i, "picture", ("%s/%d.png"):format(folder.path, i) }
      for _, name in ipairs { "o", "plus" } do shown[#shown + 1] = { i, "key", name } end
    end
    edited = assert(play(edited, shown, { exposure = -1 }))
    local _, image = fresh(edited, "srgb", 0)
    for i, tone in ipairs(tones) do
      local wanted = core.canvas_pixels(core.canvas_image(image, nil, tone, -1 + (i - 1) / 3))
      local found = pixels(("%s/%d.png"):format(folder.path, i))
      assert((found - wanted):abs():max() <= 1.01 / 255, tone)
    end
  end)

  it("stay within the tolerance while a lamp is dragged", function()
    local s = scene()
    local worst, n = 0, 0
    local stage = ylm.scene "stage" { camera = s.camera, geometry = s.geometry }
    local view = assert(stage:prepare { size = SIZE, samples = 1, transfer_samples = 16, visibility = "transfer", lmax = 3 })
    assert(play(s, drag(s, 20, 8), { on_frame = function(state)
      local lamps = {}
      for i, row in ipairs(state.lamps) do lamps[i] = ylm.sphere_light { at = row.at, radius = row.radius,
        radiance = row.radiance } end
      local packed = ylm.sphere_lights { at = { state.lamps[1].at, state.lamps[2].at, state.lamps[3].at },
        radius = { lamps[1].radius, lamps[2].radius, lamps[3].radius },
        radiance = { lamps[1].radiance, lamps[2].radiance, lamps[3].radiance } }
      local truth = view:render { grid = packed.lights, lamps = lamps, layers = false }
      local m = state.image:compare(truth)
      worst, n = math.max(worst, m.rmse / truth:layer("radiance"):mean()), n + 1
    end }))
    assert(n >= 4 and worst < 0.1, worst) -- the tolerance is of coefficients, 99 % of them
  end)

  it("bake the scene's own probes where these have no tolerance, as pages do", function()
    local probes, points = ylm.adaptive_grid { lmax = 2, depth = 4, threshold = 0.5, metric = "absolute" }, nil
    local s = scene { probes = probes }
    assert(s:live { size = { 64, 48 }, hidden = true, events = { { 1, "close" } },
      on_frame = function(state) points = points or state.grid.stats.points end })
    assert.equal(s:bake({ quantity = "lights" }).stats.points, points)
  end)

  it("bake what ylm.bake bakes when the tolerance is another", function()
    local s, points = scene(), {}
    assert(play(s, { { 0, "key", "T" }, { 1, "rest" }, { 2, "key", "t" }, { 3, "key", "t" }, { 4, "key", "t" }, { 5, "rest" } },
      { tolerance = 0.1, on_frame = function(state)
        points[#points + 1] = { state.settings.tolerance, state.grid.stats.points, state.grid.dynamic }
      end }))
    local last = points[#points]
    local grid = s:bake { quantity = "lights", probes = ylm.adaptive_grid { lmax = 3, depth = 4, tolerance = last[1] } }
    assert.equal(grid.stats.points, last[2])
    assert(last[2] > points[2][2])
  end)

  it("hide shapes behind what is nearer: a segment through a sphere", function()
    local window = assert(vtk.live(64, 64, "depth", true))
    local rgb, depth = ylm.zeros({ 64, 64, 3 }, "float"), ylm.zeros({ 64, 64 }, "float")
    for y = 1, 64 do
      for x = 1, 64 do depth:set(y, x, (x - 32.5) ^ 2 + (y - 32.5) ^ 2 < 200 and 4 or math.huge) end
    end
    window:tone("srgb", 0)
    window:picture(rgb, depth, 0, 0, 64, 64)
    local function count(from, to)
      local shape, place = core.shape(2), vtk.scene()
      local a = ylm.array({ from }, "double")
      local b = ylm.array({ { to[1] - from[1], to[2] - from[2], to[3] - from[3] } }, "double")
      core.shape_edges(shape, ylm.array({ { 1, 1, 1, 1 } }, "double"), a, b)
      vtk.scene_shape(place, shape, { ambient = 1, diffuse = 0, specular = 0, line_width = 1, opacity = 1 })
      vtk.scene_camera(place, { 0, 0, 4 }, { 0, 0, 0 }, { 0, 1, 0 }, 45)
      window:overlay(place, 0.1, 100)
      window:show()
      local canvas = core.canvas(64, 64, { 0, 0, 0 })
      window:read(canvas)
      local p, n = core.canvas_pixels(canvas), 0
      for y = 1, 64 do for x = 1, 64 do if p:get(y, x, 2) > 0.2 then n = n + 1 end end end
      return n
    end
    -- Boxes without depth: a line across the disc, which lies at z = 0.
    local before, behind = count({ -1, 0.01, 0.5 }, { 1, 0.01, 0.5 }), count({ -1, 0.01, -0.5 }, { 1, 0.01, -0.5 })
    assert(before >= 38 and behind < before - 20, before .. " " .. behind)
    local through = count({ -0.5, 0.01, -1 }, { 0.5, 0.01, 1 })
    assert(through > 5 and through < 40, through)
    window:overlay(nil, 0.1, 100)
    window:close()
    window:close()
    assert.is_false(pcall(window.show, window))
  end)

  it("are the same bytes again, with one thread and two, and as they were recorded", function()
    local s, texts = scene(), {}
    local events = drag(s, 18, -9)
    for k, name in ipairs { "l", "b", "g", "v", "p" } do events[#events + 1] = { 4 + k, "key", name } end
    events[#events + 1] = { 20, "rest" }
    local size = { 420, 72 }
    local x, y = seen(s, 1, { 420 - 232, 72 })
    events[1], events[4] = { 0, "press", x, y, "left" }, { 3, "release", x + 18, y - 9, "left" }
    events[2], events[3] = { 1, "move", x + 9, y - 4 }, { 2, "move", x + 18, y - 9 }
    for i, threads in ipairs { 1, 2, 2 } do
      local path, record = ("%s/%d.png"):format(folder.path, i), ("%s/%d.events"):format(folder.path, i)
      assert(play(s, i == 3 and folder.path .. "/2.events" or events, { size = size, threads = threads, picture = path,
        record = record }))
      texts[i] = bytes(path) .. bytes(record)
    end
    assert(texts[1] == texts[2] and texts[2] == texts[3])
  end)

  it("save a scene that loads, and pictures of it; nothing is overwritten", function()
    local file = folder:write("room.lua", [[
return scene "room" {
  camera = camera { from = { 0, 1.4, 3.2 }, at = { 0, 0.4, 0 } },
  geometry = { quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 }, divide = 8 } },
  lights = { sphere_light { at = { -0.5, 0.5, 0.3 }, radius = 0.08, radiance = 30 },
    sphere_lights { at = { { 0.9, 0.6, 0.6 }, { 0.2, 1, -1 } }, radius = 0.06, radiance = 20 } },
  probes = adaptive_grid { lmax = 3, depth = 4, tolerance = 0.03 },
}]])
    local s = assert(ylm.load(file))
    local edited, report = play(s, { { 0, "key", "Tab" }, { 1, "key", "Right" }, { 2, "key", "Tab" }, { 3, "key", "Delete" },
      { 4, "key", "n" }, { 4, "rest" }, { 5, "key", "s" }, { 50, "key", "s" }, { 51, "key", "d" }, { 52, "wheel", 50, 30, 2 },
      { 53, "key", "s" } }, { save = folder.path .. "/room" })
    assert(edited, report)
    assert.equal(9, #report.saved)
    local first = assert(ylm.load(folder.path .. "/room-1.lua"))
    assert(bytes(folder.path .. "/room-1.lua"):find "like     = \"room.lua\"")
    assert.equal(bytes(folder.path .. "/room-1.png"), bytes(folder.path .. "/room-2.png"))
    local picture = assert(ylm.load(folder.path .. "/room-1.exr"))
    local _, again = fresh(first, "srgb", 0)
    assert((picture:layer "radiance" - again:layer "radiance"):abs():max() <= 1e-2 * again:layer("radiance"):max())
    local last = assert(ylm.load(folder.path .. "/room-3.lua"))
    assert.equal(7 - 2, last.probes.depth)
    for a = 1, 3 do
      assert.equal(edited.camera.from[a], last.camera.from[a])
      assert.equal(edited.lights[1].at[a], last.lights[1].at[a])
    end
  end)

  it("save into another folder with a copy of the scene's file, which is made of no others", function()
    local text = [[
return scene "room" {
  camera = camera { from = { 0, 1.4, 3.2 }, at = { 0, 0.4, 0 } },
  geometry = { quad { corner = { -2, 0, 2 }, u = { 4, 0, 0 }, v = { 0, 0, -4 } } },
  lights = { sphere_light { at = { -0.5, 0.5, 0.3 }, radius = 0.08, radiance = 30 } },
  probes = adaptive_grid { lmax = 1, depth = 2, tolerance = 0.1 },
}]]
    local other, notes, events = scratch.new(), {}, { { 0, "key", "Tab" }, { 1, "key", "Right" }, { 2, "key", "s" } }
    local function saved(file)
      local edited, report = play(assert(ylm.load(file)), events, { size = { 32, 24 }, samples = 1, transfer_samples = 4,
        save = other.path .. "/mine", on_frame = function(state) notes[#notes + 1] = state.note end })
      return assert(edited, report), report
    end
    local edited, report = saved(folder:write("room.lua", text))
    assert.same({ "mine-1.lua", "mine-scene.lua", "mine-1.png", "mine-1.exr" }, (function()
      local names = {}
      for i, name in ipairs(report.saved) do names[i] = name:match "[^/]*$" end
      return names
    end)())
    assert.equal(text, bytes(other.path .. "/mine-scene.lua"))
    assert.equal(edited.lights[1].at[1], assert(ylm.load(other.path .. "/mine-1.lua")).lights[1].at[1])
    saved(folder:write("other.lua", (text:gsub("room", "other"))))
    assert(bytes(other.path .. "/mine-2.lua"):find('like     = "mine-scene-2.lua"', 1, true))
    saved(folder:write("like.lua", 'return scene "like" { like = "room.lua" }'))
    assert(notes[#notes]:find("is made of other files there: save beside it", 1, true), notes[#notes])
    other:remove()
  end)

  it("print what grid:locate and the lights' own coefficients say of a point", function()
    local s, printed, old = scene(), nil, print
    _G.print = function(text) printed = text end -- luacheck: ignore
    local good, message = pcall(play, s, { { 0, "press", 48, 60, "left" }, { 0, "release", 48, 60, "left" } }, { quiet = false })
    _G.print = old -- luacheck: ignore
    assert(good, message)
    assert(printed and printed:find "^picked " and printed:find "level %d" and printed:find "exact"
      and printed:find "true error", printed)
    local p = {}
    for number in printed:match("picked (%S+ %S+ %S+);"):gmatch "%S+" do p[#p + 1] = tonumber(number) end
    local exact = ylm.light_field(3, s.lights, { p }, { dtype = "double" })
    assert(math.abs(tonumber(printed:match "exact ([%d.e+-]+)") / exact:get(1, 1, 1) - 1) < 0.01)
  end)

  it("refine by rays, references and paths, and show true errors", function()
    local s, seen_methods = scene(), {}
    assert(play(s, { { 0, "key", "m" }, { 0, "rest" }, { 1, "key", "e" }, { 1, "rest" }, { 2, "key", "m" }, { 2, "rest" },
      { 3, "key", "m" }, { 3, "rest" } }, { light_samples = 32, paths = 32, refine = { "view" }, on_frame = function(state)
        if state.method then seen_methods[state.method] = state end
      end }))
    for _, name in ipairs { "grid", "reference", "rays", "path" } do assert(seen_methods[name], name) end
    for _, name in ipairs { "rays", "path" } do -- say the noise that is left
      local noise = seen_methods[name].noise
      assert(noise and noise > 0 and noise < 0.5, ("%s: %s"):format(name, noise))
    end
  end)

  it("are refined by rays to the picture of scene:render, of which the pilot's is shown before", function()
    local lamps = ylm.sphere_lights { at = { { 0.9, 0.6, 0.6 }, { 0.2, 1, -1 } }, radius = { 0.06, 0.05 }, radiance = 20 }
    local s, shown, last = scene { lights = { lamps } }, {}, nil
    local _, report = play(s, { { 0, "rest" } }, { refine = { "view", "rays" }, noise = 0.005, on_frame = function(state)
      if state.method == "rays" and state.noise ~= last then
        shown[#shown + 1], last = state.image:layer("radiance"):bytes(), state.noise
      end
    end })
    local alone, facts = s:render { size = SIZE, samples = 2, noise = 0.005, layers = false }
    local bits = alone:layer("radiance"):bytes()
    assert.equal(2, #shown)                             -- the pilot's, and that with rays where noise is
    assert(shown[2] == bits and shown[1] ~= bits)
    assert.equal(facts.noise, report.picture.noise)
    assert.equal("all", report.picture.bounces)
  end)

  it("go on while a pointer passes over the window, and keep what it does behind that", function()
    local queue = {}
    local window = { waiting = function() return #queue > 0 end, poll = function()
      local events = queue
      queue = {}
      return events
    end }
    local o = { size = SIZE, exposure = 0, tone = "srgb", panel = false, refine = {}, samples = 1, transfer_samples = 4 }
    local me = sessions.new(scene(), window, o)
    queue = { { kind = "move", x = 3, y = 4 }, { kind = "move", x = 5, y = 4 } }
    assert(not me:waiting() and #queue == 0)
    queue = { { kind = "move", x = 3, y = 4 }, key "h" }
    assert(me:waiting() and me:waiting())
    queue = { key "q" }
    local events = me:poll(7)
    assert(#events == 2 and events[1].key == "h" and events[2].key == "q" and not me:waiting())
    me.state.drag = { kind = "lamp", lamp = 1 }
    queue = { { kind = "move", x = 3, y = 4 } }
    assert(me:waiting() and #me:poll(0) == 1)
  end)

  it("are refined to the same picture, wherever events break a step off", function()
    local o = { size = SIZE, quiet = true, samples = 1, transfer_samples = 4, light_samples = 16, paths = 32, exposure = 0,
      tone = "srgb", budget = 0.05, panel = false, events = {}, refine = { "grid", "smooth", "reference" } }
    --- The pixels at the end, and how many steps were broken off, where `waiting` says when there is an event.
    local function refined(waiting)
      local window = assert(vtk.live(SIZE[1], SIZE[2], "refined", true))
      local me = sessions.new(scene(), window, o)
      me.fixed = 1
      assert(me:begin())
      repeat
        local name, why = me:rest(waiting)
        assert(name ~= false, why)
      until not name
      assert(me:present())
      local canvas = core.canvas(SIZE[1], SIZE[2], { 0, 0, 0 })
      window:read(canvas)
      window:close()
      return core.canvas_pixels(canvas), me.refine.cancelled
    end
    local whole = refined(function() return false end)
    local looks, until_next, apart = 0, 0, 0
    local pixels_found, cancelled = refined(function()
      looks = looks + 1
      if looks < until_next or apart > 12 then return false end
      apart = apart + 1
      until_next = looks + 1 + apart
      return true
    end)
    assert(cancelled > 3, cancelled)
    assert.equal(0, (pixels_found - whole):abs():max())
  end)

  it("tell on_frame, which may close the window, and pass its errors on", function()
    local n = 0
    local _, report = play(scene(), { { 0, "key", "l" }, { 1, "key", "l" }, { 2, "key", "l" } }, { on_frame = function(state)
      n = n + 1
      assert(state.grid and #state.lamps == 3 and state.image)
      return n < 2
    end })
    assert.equal(2, report.frames)
    local good, message = pcall(play, scene(), { { 0, "key", "l" } }, { on_frame = function() error "mine" end })
    assert(not good and message:find "live_spec.lua:%d+: mine")
    local nested
    assert(play(scene(), { { 0, "key", "l" } }, { on_frame = function()
      nested = nested or { pcall(play, scene(), { { 0, "close" } }) }
    end }))
    assert(not nested[1] and tostring(nested[2]):find "one live window at a time", nested[2])
    assert(play(scene(), { { 0, "close" } }), "the window before was closed")
  end)

  it("survive random events: places outside, presses without release, windows of one pixel, keys in any order", function()
    local n = long(120, 10000)
    assert.equal(n, random_events(n, 20261123, long(100, 300)).events)
  end)

  it("leave less than a megabyte a window", function()
    local s, n, first, last = scene { probes = ylm.adaptive_grid { lmax = 1, depth = 2, tolerance = 0.1 } }, long(4, 22), nil, nil
    for i = 1, n do
      assert(play(s, { { 0, "key", "l" } }, { size = { 64, 48 }, samples = 1, transfer_samples = 4, refine = { "view" } }))
      collectgarbage()
      collectgarbage()
      last = tonumber(bytes("/proc/self/status"):match "VmRSS:%s+(%d+)")
      if i == 2 then first = last end
    end
    assert(last - first <= 1024 * (n - 2), last - first .. " kB")
  end)

  it("run without geometry, without lamps, without probes, with flat lamps, with probes in bricks", function()
    local flat = ylm.polygon_light { vertices = { { -1, 2, 0 }, { 1, 2, 0 }, { 0, 2, 1 } }, radiance = 2 }
    local rows = { scene { geometry = {} }, scene { lights = {} }, scene { lights = { flat } }, scene { lights = { flat,
      ylm.sphere_light { at = { 0, 1, 0 } } } } }
    rows[5] = ylm.scene "none" { camera = scene().camera, geometry = scene().geometry, lights = scene().lights }
    rows[6] = scene { probes = ylm.adaptive_grid { lmax = 1, depth = 3, tolerance = 0.5, bricks = 1 } }
    for i, s in ipairs(rows) do
      local edited, message = play(s, { { 0, "key", "n" }, { 1, "key", "Left" }, { 2, "key", "l" }, { 3, "rest" } })
      assert(edited, i .. ": " .. tostring(message))
    end
  end)
end)

describe("scene:live refuses", function()
  it("files of events, by line", function()
    local head = "ylm events 1 640 480\n"
    for text, says in pairs {
      [""] = "no 'ylm events 1 WIDTH HEIGHT'", ["events 1 3 3"] = "x:1: a file of events begins with",
      ["ylm events 2 3 3"] = "x:1: version 1 of events is known, got '2'", ["ylm events 1 0 3"] = "from 1 to 8192",
      [head .. "# note\n0 pres 1 2 left"] = "x:3: no event 'pres' (did you mean 'press'?)",
      [head .. "0 press 1"] = "x:2: press: its y is missing", [head .. "0 press 1 a left"] = "press: y must be a number, got 'a'",
      [head .. "0 press 1 nan left"] = "y must be a number", [head .. "0 press 1 1e30 left"] = "y must be a number",
      [head .. "0 press 1 2 centre"] = "a button is left, middle or right, got 'centre'",
      [head .. "0 move 1 2 alt"] = "'shift' or 'control' expected, got 'alt'", [head
        .. "x move 1 2"] = "a frame's number expected",
      [head .. "5 move 1 2\n4 move 1 2"] = "x:3: frame 4 comes after frame 5", [head
        .. "0"] = "an event expected behind the frame",
      [head .. "0 scale 3"] = "scale: 1, 2 or 4 expected", [head .. "0 resize 0 4"] = "sides are 1 to 8192",
    } do
      local events, message = replay.parse(text, "x")
      assert(events == nil and message:find(says, 1, true), tostring(message))
    end
    local events, size = replay.parse(head:gsub("\n", "\r\n") .. "0 press -5 900 left shift # beyond the window\r\n", "x")
    assert(events[1].x == -5 and events[1].shift and size[1] == 640)
    local line = replay.line(3, assert(replay.check { { 3, "move", 10.5, -2, shift = true } })[1])
    assert.equal("3 move 10.5 -2 shift", line)
    assert.equal(10.5, assert(replay.parse(head .. line, "x"))[1].x)
  end)

  it("options and scenes, by name", function()
    local function says(text, ...)
      local results = { pcall(play, ...) }
      local message = tostring(results[1] and results[3] or results[2])
      assert((not results[1] or results[2] == nil) and message:find(text, 1, true), message)
    end
    local close = { { 0, "close" } }
    says("live: hidden needs events: nobody could close it", scene(), nil)
    says('live: scene "live" has no camera', ylm.scene "live" {}, close)
    says("keep is for windows that are seen", scene(), close, { keep = true })
    says("picture must end in .png", scene(), close, { picture = "a.exr" })
    says("size must be", scene(), close, { size = { 0, 5 } })
    says("a window of 9000 x 5 pixels", scene(), close, { size = { 9000, 5 } })
    says("tolerance must be", scene(), close, { tolerance = 2 })
    says("noise chooses counts of rays, and light_samples is given", scene(), close, { noise = 0.1, light_samples = 4 })
    says("budget must be a number > 0", scene(), close, { budget = 0 })
    says('"view", "grid", "smooth"', scene(), close, { refine = { "all" } })
    says("events[1]: no event 'pres' (did you mean 'press'?)", scene(), { { 0, "pres", 1, 1, "left" } })
    says("events: a file's name or a list", scene(), 7)
    says("no such.events", scene(), "no such.events")
    says("a scene expected before the colon", scene(), close, { on_frame = function() require("ylm.live").live({}, {}) end })
    local _, message, code = play(scene(), { { 0, "picture", "no such folder/x.png" } })
    assert(code == "EIO", message)
    local kept = play(scene(), { { 0, "key", "s" }, { 1, "close" } }, { save = "no such folder/x" })
    assert(kept, "a folder that cannot be written to closes no window")
  end)

  it("to open a window without a display, in words", function()
    local lua = os.getenv "YLM_LUA" or "lua5.4"
    local folder = scratch.new()
    local path = folder:write("open.lua", [[
local ylm = require "ylm"
local s = ylm.scene "x" { camera = ylm.camera { from = { 0, 1, 4 } } }
print(s:live { events = { { 0, "close" } } })]])
    local text = scratch.capture("env -u DISPLAY " .. lua .. " " .. scratch.quote(path))
    folder:remove()
    assert(text:find "^nil%s+no display to open a window on.*EMISSING", text)
  end)
end)
