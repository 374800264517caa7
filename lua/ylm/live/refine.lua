--- Work of a live window while nothing moves: finer pictures, in steps, each of which an event may break off.
--
-- A step is begun where what it makes is missing. refine:step(...) does one and returns its name and true, or nil where there is
-- nothing left; a step that is broken off returns its name and false.

local refine = {}
local methods = {}

local MOST_PAIRS = 2e9   -- lamps times points of a reference
local PATHS = 32         -- paths of a pixel in a pass

--- o: steps (a list of "view", "grid", "smooth"), paths: where passes end.
function refine.new(follow, o)
  local wanted = {}
  for _, name in ipairs(o.refine) do wanted[name] = true end
  return setmetatable({ follow = follow, o = o, wanted = wanted, done = {}, cancelled = 0 }, { __index = methods })
end

--- Begins anew after what `changed` says.
function methods.reset(r, changed)
  local done = r.done
  if changed.views or changed.size or changed.camera then
    r.done = { elements = done.elements }
    return
  end
  if changed.lamps or changed.grid then
    done.grid, done.shown, done.reference = nil, nil, nil
    if changed.lamps then done.rays, done.path = nil, nil end
    if changed.views then done.view, done.smooth = nil, nil end
  end
end

--- The work left for state `s`: the first step that is wanted and not done; nil.
function methods.next(r, s)
  local done, method = r.done, s.settings.method
  local function missing(name) return r.wanted[name] and not done[name] end
  if not done.view then return "view" end
  if missing "grid" then return "grid" end
  if missing "smooth" then return "smooth" end
  if not done.shown then return "shown" end
  if (method == "reference" or s.settings.truth and method == "grid" or r.wanted.reference) and not done.reference then
    return "reference"
  end
  if method == "rays" and not done.rays then return done.elements and "rays" or "elements" end
  if method == "path" and not done.path then return "path" end
end

local steps = {}

function steps.view(r, s, progress)
  local w, h = s:picture_size()
  return r.follow:prepare(s.camera, w, h, s.scale or 1, 1, s.settings, progress)
end

function steps.smooth(r, s, progress)
  local w, h = s:picture_size()
  return r.follow:prepare(s.camera, w, h, s.scale or 1, 2, s.settings, progress)
end

function steps.grid(r, s, progress)
  local tolerance = s.settings.tolerance ~= s.first.tolerance and s.settings.tolerance or nil
  return r.follow:bake_fine(s.lamps, s.settings, tolerance, progress)
end

local function view_of(r, s) return select(2, r.follow:view_of(s.camera, s.scale)) end

--- Makes r.picture, the one by the grid.
function steps.shown(r, s, progress)
  local v = select(2, r.follow:view_of(s.camera, s.scale or 1))
  if not v then return true end
  local picture, message, code = r.follow:picture(v, s.lamps, false, progress)
  if not picture then return nil, message, code end
  picture.view, r.picture = v, picture
  return true
end

--- The relative error and the PSNR of the picture by the grid, noted in its reference: true, or nil, message, code.
local function compare(mine, truth, progress)
  local metrics, message, code = mine.image:compare(truth.image, { progress = progress })
  if not metrics then
    if code == "ECANCELLED" or code == "ENOMEM" then return nil, message, code end
    return true
  end
  local mean = truth.image:layer("radiance"):abs():mean()
  truth.of, truth.relative, truth.psnr = mine.image, metrics.rmse / math.max(mean, 1e-300), metrics.psnr
  return true
end

function steps.reference(r, s, progress)
  local v = view_of(r, s)
  if r.follow:pairs(v, s.lamps) > MOST_PAIRS then
    r.follow.reference_picture = nil
    s.note = "a reference of so many lamps takes too long"
    return true
  end
  local picture, message, code = r.follow:reference(v, s.lamps, progress)
  if not picture then return nil, message, code end
  local mine = r.picture
  if mine and mine.size[1] == picture.size[1] and mine.size[2] == picture.size[2] then
    local ok
    ok, message, code = compare(mine, picture, progress)
    if not ok then return nil, message, code end
  end
  r.follow.reference_picture = picture
  return true
end

function steps.elements(r, _, progress) return r.follow:cut(progress) end

function steps.rays(r, s, progress, so_far) return r.follow:cast(view_of(r, s), s.lamps, progress, so_far) end

function steps.path(r, s, progress)
  local ok, message, code = r.follow:trace(view_of(r, s), s.lamps, PATHS, progress)
  if not ok then return nil, message, code end
  return r.follow.paths.samples >= r.o.paths and true or "more"
end

--- Does one step; `waiting()`: there is an event; so_far(): there is a picture by rays, of a pilot. Returns its name and whether
-- it was done, and a message where it failed.
function methods.step(r, s, waiting, so_far)
  local name = r:next(s)
  if not name then return nil end
  local progress = { function(...) return not waiting(...) end, every = 0.02 }
  local ok, message, code = steps[name](r, s, progress, so_far)
  if not ok then
    if code == "ECANCELLED" then
      r.cancelled = r.cancelled + 1
      return name, false
    end
    r.done[name] = true -- it would fail again
    return name, true, message
  end
  if ok ~= "more" then r.done[name] = true end
  if name == "view" or name == "grid" or name == "smooth" then r.done.shown = nil end
  if name == "smooth" or name == "view" then r.done.reference = nil end
  return name, true
end

return refine
