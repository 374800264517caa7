--- One live window at work: events in, pictures out. lua/ylm/live/init.lua opens it and says where events come from.

local actions = require "ylm.live.actions"
local check = require "ylm.check"
local core = require "ylm.c.core"
local follow = require "ylm.live.follow"
local lamps = require "ylm.live.lamps"
local layout = require "ylm.live.layout"
local light = require "ylm.light"
local noises = require "ylm.render.noise"
local overlays = require "ylm.live.overlays"
local panel = require "ylm.live.panel"
local picture = require "ylm.picture"
local refine = require "ylm.live.refine"
local save = require "ylm.live.save"
local states = require "ylm.live.state"

local session = {}
local methods = {}

local TRUE_ERROR = 100 -- times the true error that is shown
local FAST = 0.25      -- seconds that a bake may take to follow a slider that is dragged

local methods_of_light = { "grid", "reference", "rays", "path" }

--- The settings that a scene and options begin with.
local function settings_of(s, o)
  local p = s.probes or {}
  local method = "grid"
  for _, name in ipairs(o.refine) do
    for _, m in ipairs(methods_of_light) do if name == m then method = m end end
  end
  local function within(name, x) return math.max(actions.knobs[name].least, math.min(actions.knobs[name].largest, x)) end
  return { tolerance = within("tolerance", o.tolerance or math.max(p.tolerance or 0, 0.05)),
    own = not o.tolerance and s.probes ~= nil and not p.tolerance,
    depth = within("depth", o.depth or p.depth or 6), lmax = within("lmax", p.lmax or 4),
    exposure = within("exposure", o.exposure), tone = o.tone, method = method, levels = false, lobes = false,
    gradients = false, errors = false, truth = false, panel = o.panel }
end

local function plain_camera(c)
  return { from = { c.from[1], c.from[2], c.from[3] }, at = { c.at[1], c.at[2], c.at[3] }, up = { c.up[1], c.up[2], c.up[3] },
    fov = c.fov }
end

--- A session of scene `s` in `window`; o: options of scene:live.
function session.new(s, window, o)
  local rows, others = lamps.of(s)
  local f = follow.new(s, rows, others, o)
  local me = setmetatable({ scene = s, window = window, o = o, follow = f, frame = 0, frames = 0, latency = {}, saved = {},
    seconds = {}, scale = 1, warnings = {}, ahead = {} }, { __index = methods })
  local first = {}
  for i, row in ipairs(rows) do first[i] = row end
  local cameras = { plain_camera(s.camera) }
  for i, c in ipairs(s.cameras or {}) do cameras[i] = plain_camera(c) end
  cameras[1] = cameras[1] or plain_camera(s.camera)
  local settings = settings_of(s, o)
  local start = {}
  for k, v in pairs(settings) do start[k] = v end
  me.state = states.new { scene = s, size = { o.size[1], o.size[2] }, camera = cameras[1], cameras = cameras, lamps = rows,
    first_lamps = first, others = #others, settings = settings, first = start, tones = core.choices "tone",
    methods = methods_of_light, diagonal = f.diagonal, near = 1e-3 * f.diagonal, middle = cameras[1].at,
    surface_at = function(x, y) return me:surface_at(x, y) end,
    lamp_at = function(x, y, reach) return me:lamp_at(x, y, reach) end }
  me.refine = refine.new(f, o)
  return me
end

-- Under the pointer --------------------------------------------------------------------------

--- The view that the picture was made of, and how much smaller it is.
local function seen(me)
  local shown = me.shown
  if not shown or not shown.view or shown.view.camera ~= me.state.camera then return nil end
  local w, h = me.state:picture_size()
  return shown.view, shown.view.size[1] / w, shown.view.size[2] / h
end

function methods.surface_at(me, x, y)
  local v, kx, ky = seen(me)
  if not v then return nil end
  local column, row = math.floor(x * kx) + 1, math.floor(y * ky) + 1
  if column < 1 or row < 1 or column > v.size[1] or row > v.size[2] then return nil end
  return v.view:hit(column, row)
end

function methods.lamp_at(me, x, y, reach)
  local v, kx, ky = seen(me)
  if not v then return nil end
  me.follow:lights(me.state.lamps)
  return (v.view:lamp_at(me.follow.spheres, (x + 0.5) * kx, (y + 0.5) * ky, reach * kx))
end

-- Words --------------------------------------------------------------------------------------

local function thousands(n)
  local text, k = ("%d"):format(n), 1
  while k > 0 do text, k = text:gsub("^(-?%d+)(%d%d%d)", "%1,%2") end
  return text
end

--- Methods, in words.
local shown_words = { grid = "grid, transfer vectors", reference = "no grid, transfer vectors", rays = "rays to the lamps",
  path = "paths, all bounces" }

--- Adds lines about the noise of a picture by rays or paths, of which rays have `wanted`.
local function add_noise(add, shown, wanted)
  local text = ("%.0f %s"):format(shown.samples, shown.method == "rays" and "rays" or "paths")
  if shown.noise and shown.noise >= 0 then text = ("%s, noise %.1f %%"):format(text, 100 * shown.noise) end
  add(text)
  if shown.method ~= "rays" then return end
  local before = shown.report.noise_before
  if before then add(("%.0f %% before it was filtered"):format(100 * before), "dim") end
  if wanted and shown.noise > noises.SLACK * wanted then add(("%.1f %% is wanted"):format(100 * wanted), "warn") end
end

--- Lines of numbers for the panel.
local function lines_of(me)
  local s, out, shown = me.state, {}, me.shown
  local function add(text, kind) out[#out + 1] = { text, kind } end
  if me.follow.empty or shown and shown.view and shown.view.view.stats.hits == 0 then add("the camera sees no geometry",
    "warn") end
  if shown then
    local text = shown_words[shown.method]
    if shown.bounces and shown.bounces ~= 0 then text = ("rays, %s bounces"):format(shown.bounces) end
    add("light: " .. text, "bold")
    if shown.samples then add_noise(add, shown, me.o.noise) end
    local grid = shown.grid
    if grid then
      local st = grid.stats
      local update = st.update
      local now = update or st
      add(("probes %s"):format(thousands(grid.stats.points)))
      if now.error and now.error == now.error then
        add(("error %.2g%s"):format(now.error, now.met == false and ", tolerance missed" or ""),
          now.met == false and "warn" or nil)
      end
      if update and update.points then add(("updated %s, added %s"):format(thousands(update.points), thousands(update.added
        or 0)), "dim") end
    end
    if shown.psnr then add(("true error %.2g, PSNR %.1f dB"):format(shown.relative, shown.psnr)) end
    if shown.view then add(("%d x %d, %s points"):format(shown.size[1], shown.size[2],
      thousands(shown.view.view.stats.points)), "dim") end
  end
  if s.lamps[1] then add(("%s lamps%s"):format(thousands(#s.lamps), s.others > 0 and (", %d others stay"):format(s.others)
    or ""), "dim")
  elseif s.others > 0 then add(("%d lights stay"):format(s.others), "dim")
  else add("no lights: n makes one", "warn") end
  if me.timing then add(me.timing, "dim") end
  local lamp = s.chosen and s.lamps[s.chosen]
  if lamp then
    local at, c = lamp.at, lamp.radiance
    add(("lamp %d"):format(s.chosen), "bold")
    add(("at %.3g %.3g %.3g"):format(at[1], at[2], at[3]))
    add(("radius %.3g, radiance %.3g %.3g %.3g"):format(lamp.radius, c[1], c[2], c[3]))
  end
  if me.picked_text then for _, line in ipairs(me.picked_text) do add(line[1], line[2]) end end
  if me.note then add(me.note, "warn") end
  return out
end

-- Showing ------------------------------------------------------------------------------------

--- Colours that are shown instead of light: an array [h][w][3] for the curve srgb; nil: light is shown.
local function colours_of(me)
  local s, shown = me.state, me.shown
  if s.settings.errors and shown.grid then
    if shown.errors == nil then
      local p = me.follow:picture(shown.view, s.lamps, true)
      local names = p and select(2, p.image:layers()) or {}
      shown.errors = names.error and p.image:colours({ layer = "error", map = "magma", range = { 1e-3, 1 }, log = true })
        :layer "radiance" or false
    end
    return shown.errors or nil
  end
  if s.settings.truth then
    local truth = s.settings.method == "grid" and me.follow.reference_picture or shown.method ~= "grid" and shown or nil
    local mine = me.grid_picture
    if not truth or not mine or truth.size[1] ~= mine.size[1] or truth.size[2] ~= mine.size[2] then return nil end
    if mine.truth ~= truth.image then
      mine.truth, mine.differs = truth.image, (mine.image:layer "radiance" - truth.image:layer "radiance"):abs() * TRUE_ERROR
    end
    return mine.differs
  end
end

--- Puts shapes into the picture where what they show has changed.
local function overlay(me, force)
  local s = me.state
  local near, far = me.follow:range(s.camera, s.near)
  local grid = me.shown and me.shown.grid or me.follow.fine or me.follow.grid
  local kind = overlays.wanted(s)
  local slow = s.settings.levels or s.settings.lobes or s.settings.gradients or s.picked
  local stale = force or kind ~= me.overlay_kind or (kind ~= "" and (me.overlay_grid ~= grid or me.overlay_lamps ~= s.lamps
    or me.overlay_camera ~= s.camera or me.moved))
  if not stale then return true end
  if slow and s.drag and not me.o.events and me.frame % 5 ~= 0 and kind == me.overlay_kind and not force then return true end
  local scene, message, code = overlays.build(s, grid, near)
  if not scene and message then return nil, message, code end
  me.overlay_kind, me.overlay_grid, me.overlay_camera, me.moved = kind, grid, s.camera, false
  local w, h = s:picture_size()
  me.overlay_size = { w, h }
  return check.result("live", me.window:overlay(scene, near, far))
end

local function passed(first, message, code)
  if message then return nil, message, code end
  return first == nil and true or first
end

--- Draws the window: me.shown, shapes, panel. true, or nil, message, code.
function methods.present(me)
  local s, shown = me.state, me.shown
  local start = core.seconds()
  local w, h = s:picture_size()
  local ok, message, code
  me.unseen = false
  if shown then
    local colours = colours_of(me)
    local values = colours or shown.image:layer "radiance"
    ok, message, code = passed(me.window:tone(colours and "srgb" or s.settings.tone, colours and 0 or s.settings.exposure))
    if not ok then return nil, message, code end
    ok, message, code = passed(me.window:picture(values, shown.depth, 0, 0, w, h))
    if not ok then return nil, message, code end
    ok, message = overlay(me)
    if not ok and message then me.note = message end
  end
  if s.help then
    ok, message, code = passed(me.window:panel(panel.help(s), 0, 0))
  elseif s:has_panel() then
    local canvas, left = panel.draw(s, me.scene.name or "scene", lines_of(me))
    ok, message, code = passed(me.window:panel(canvas, left, 0))
  else ok, message, code = passed(me.window:panel(nil, 0, 0)) end
  if not ok then return nil, message, code end
  ok, message, code = passed(me.window:show())
  me.follow.seconds.present = core.seconds() - start
  me.frames = me.frames + 1
  return ok, message, code
end

--- Makes the picture by the grid of the best view at `scale`; me.shown is then what the method shows. true, or nil, message,
-- code.
local function make_picture(me, scale)
  local s, f = me.state, me.follow
  local _, v = f:view_of(s.camera, scale)
  if not v then return true end
  local p, message, code = f:picture(v, s.lamps)
  if not p then return nil, message, code end
  p.view = v
  me.grid_picture = p
  me.shown = p
  return true
end

--- Shows the picture of the method at rest, as far as there is one.
local function pick_method(me)
  local s, f = me.state, me.follow
  local method = s.settings.method
  local p = method == "rays" and f.rays or method == "path" and f.paths or method == "reference" and f.reference_picture or nil
  if p and p.image and me.grid_picture and p.size[1] == me.grid_picture.size[1] and p.size[2] == me.grid_picture.size[2] then
    p.view, p.grid = me.grid_picture.view, me.grid_picture.grid
    me.shown = p
  else me.shown = me.grid_picture or me.shown end
  local truth = f.reference_picture
  if truth and me.shown and me.shown == me.grid_picture and truth.of == me.shown.image then
    me.shown.relative, me.shown.psnr = truth.relative, truth.psnr
  end
end

-- Events -------------------------------------------------------------------------------------

--- Is there an event that work is broken off for? A pointer that passes over the window is none, and is forgotten.
function methods.waiting(me)
  local ahead = me.ahead
  if me.state.closed or #ahead > 0 then return true end
  if me.window:waiting() == false then return false end
  local events = me.window:poll(0)
  for _, event in ipairs(events or {}) do
    if event.kind ~= "move" or me.state.drag then ahead[#ahead + 1] = event end
  end
  return not events or #ahead > 0
end

--- Events that came while work was done, and those of the next `wait` seconds at most: a list, or nil, message, code.
function methods.poll(me, wait)
  local events = me.ahead
  local more, message, code = me.window:poll(#events > 0 and 0 or wait)
  if not more then return nil, message, code end
  me.ahead = {}
  for _, event in ipairs(more) do events[#events + 1] = event end
  return events
end

--- Text about the picked point, printed and kept for the panel.
local function pick(me)
  local s, f = me.state, me.follow
  local hit = s.picked
  local p = hit.position
  local grid = f.fine or f.grid
  local lines = { { ("picked %.4g %.4g %.4g"):format(p[1], p[2], p[3]), "bold" } }
  if grid and not f.empty then
    local cell = grid:locate(p)
    if cell then
      local error = cell.error or 0 / 0
      lines[#lines + 1] = { ("level %d, size %.3g%s"):format(cell.level, cell.size[1], cell.outside and ", outside" or "") }
      lines[#lines + 1] = { ("cell's error %.3g, residual %s"):format(error, cell.residual and ("%.3g"):format(cell.residual)
        or "-") }
    end
    local at = { p }
    local mine = grid:sample(at)
    local exact = light.light_field(grid.lmax, f:lights(s.lamps), at)
    if mine and exact then
      local a, b = core.array_totable(mine)[1], core.array_totable(exact)[1]
      local difference, norm = 0, 0
      local function flat(x, out)
        if type(x) == "table" then for i = 1, #x do flat(x[i], out) end else out[#out + 1] = x end
        return out
      end
      a, b = flat(a, {}), flat(b, {})
      for i = 1, math.min(#a, #b) do
        difference, norm = difference + (a[i] - b[i]) ^ 2, norm + b[i] ^ 2
      end
      lines[#lines + 1] = { ("L00 %.4g, exact %.4g"):format(a[1], b[1]) }
      lines[#lines + 1] = { ("true error %.3g"):format(math.sqrt(difference / math.max(norm, 1e-300))) }
    end
  end
  me.picked_text = lines
  if not me.o.quiet then
    local words = {}
    for i, line in ipairs(lines) do words[i] = line[1] end
    print(table.concat(words, "; "))
  end
end

--- Saves what is shown; the panel says where.
function methods.save(me)
  local s = me.state
  local shown = me.shown
  local layered = shown and shown.method == "grid" and me.follow:picture(shown.view, s.lamps, true)
  local names, note = save.all(s, me.o.save, function(path) return me:save_png(path) end, layered and layered.image
    or shown and shown.image)
  if not names then
    me.note = "not saved: " .. tostring(note)
    return
  end
  for _, name in ipairs(names) do me.saved[#me.saved + 1] = name end
  me.note = note and ("saved %s; no scene: %s"):format(names[1], note) or "saved " .. table.concat(names, ", ")
end

--- Writes the window as it is shown.
function methods.save_png(me, path)
  local vtk, message, code = picture.vtk()
  if not vtk then return nil, message, code end
  local w, h = me.window:size()
  local canvas = assert(core.canvas(w, h, { 0, 0, 0 }))
  local ok
  ok, message, code = passed(me.window:read(canvas))
  if not ok then return nil, message, code end
  return check.result("live", vtk.save_png(path, canvas))
end

local function autosave(me)
  if not me.o.save or me.o.events then return end
  local path = me.o.save .. "-autosave.lua"
  if me.autosave_failed then return end
  local ok, message = save.scene(me.state, path)
  if not ok then me.autosave_failed, me.note = true, "not saved by itself: " .. message end
end

local function smooth(old, new) return old and old + (new - old) / 4 or new end

--- The scale of pictures while something moves, from how long the last ones took.
local function adapt(me, seconds)
  local budget = me.o.budget
  if me.fixed or budget == math.huge then return end
  me.cost = smooth(me.cost, seconds)
  if me.cost > 1.2 * budget and me.scale < 4 then
    me.costs = me.costs or {}
    me.costs[me.scale] = me.cost
    me.scale, me.cost = me.scale * 2, nil
  elseif me.cost < 0.5 * budget and me.scale > 1 and ((me.costs or {})[me.scale / 2] or 0) < 1.2 * budget then
    me.scale, me.cost = me.scale / 2, nil
  end
end

--- Brings lamps into grid and picture.
local function follow_lamps(me, changed)
  local s, f = me.state, me.follow
  if changed.grid then f:drop_grid() end
  local start = core.seconds()
  local ok, message, code = f:update(s.lamps, s.settings)
  if not ok then
    me.note = ("%s%s"):format(message, code == "ELIMIT" and ": coarser tolerance or less depth" or "")
    if not (f.grid or f.fine) then return true end
  end
  f:drop_rays()
  f.reference_picture = nil
  local w, h = s:picture_size()
  local scale = changed.held and me.scale or 1
  local have = f.views[scale]
  if scale > 1 and not (have and have.camera == s.camera) then
    ok, message, code = f:prepare(s.camera, w, h, scale, 0, s.settings)
    if not ok then return nil, message, code end
  end
  ok, message, code = make_picture(me, scale)
  if not ok then return nil, message, code end
  if changed.held then adapt(me, core.seconds() - start + (f.seconds.present or 0)) end
  return true
end

--- A new camera, size or lmax: another view, quickly.
local function look_anew(me, changed)
  local s, f = me.state, me.follow
  if changed.views or changed.size then f:drop_views() end
  f:drop_rays()
  f.reference_picture = nil
  local w, h = s:picture_size()
  local scale = me.fixed or math.max(me.scale, 2)
  local ok, message, code = f:prepare(s.camera, w, h, scale, me.fixed and 1 or 0, s.settings)
  if not ok then return nil, message, code end
  return make_picture(me, scale)
end

--- Does what a list of events asks for, and shows it. `now`: seconds. true, or nil, message, code.
function methods.handle(me, events, now)
  local s, f = me.state, me.follow
  local changed = s:take(events, now)
  me.frame = me.frame + 1
  if changed.lamps or changed.grid or changed.camera then me.note, me.moved = nil, true end
  s.scale = me.fixed
  if changed.grid and changed.held and not changed.lamps and (f.baked or 0) > FAST then changed.grid, me.owed = nil, true end
  if me.owed and not changed.held then changed.grid, me.owed = true, nil end
  me.refine:reset(changed)
  local ok, message, code = true, nil, nil
  if changed.picked then pick(me) elseif not s.picked then me.picked_text = nil end
  if changed.views or changed.camera or changed.size then ok, message, code = look_anew(me, changed) end
  if ok and (changed.lamps or changed.grid) then ok, message, code = follow_lamps(me, changed) end
  if not ok then
    me.note = message
    if code == "ENOMEM" or code == "EDEVICE" then return nil, message, code end
  end
  if changed.method then pick_method(me) end
  if changed.released or changed.undone then autosave(me) end
  if changed.save then
    ok, message, code = me:present() -- what is saved is what is shown
    if not ok then return nil, message, code end
    me:save()
  end
  me.changed = changed
  if next(changed) or me.unseen then return me:present() end
  return true
end

--- Shows what has been refined, unless an event waits: that is answered first. True, or nil, message, code.
local function show_more(me, waiting)
  me.unseen = true
  if waiting() then return true end
  return me:present()
end

--- One step of refinement: its name and whether it was done, nil where there is nothing left; or false, message, code.
-- after(): a picture has been shown within the step.
function methods.rest(me, waiting, after)
  local s = me.state
  s.scale = me.fixed
  local name, done, message = me.refine:step(s, waiting, function()
    pick_method(me)
    if show_more(me, waiting) and not me.unseen and after then after(me) end
  end)
  if not name then return nil end
  if message then me.note = message end
  if done then
    if name == "shown" and me.refine.picture then me.grid_picture, me.shown = me.refine.picture, me.refine.picture end
    pick_method(me)
    if name ~= "grid" and name ~= "smooth" and name ~= "view" and name ~= "elements" then
      local ok, why, code = show_more(me, waiting)
      if not ok then return false, why, code end
    end
  end
  return name, done
end

--- The first picture: true, or nil, message, code.
function methods.begin(me)
  local s, f = me.state, me.follow
  local w, h = s:picture_size()
  s.scale = me.fixed
  local ok, message, code = f:prepare(s.camera, w, h, me.fixed or 1, me.fixed and 1 or 0, s.settings)
  if not ok then return nil, message, code end
  ok, message = f:update(s.lamps, s.settings)
  if not ok then me.note = message end
  ok, message, code = make_picture(me, me.fixed or 1)
  if not ok then return nil, message, code end
  return me:present()
end

--- Layout's width, for who makes pictures of windows.
session.PANEL = layout.WIDTH

return session
