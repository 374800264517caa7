--- Grids in bricks: ylm.bake with the option folder, ylm.load of such a folder, and the methods of what they return.

local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local form = require "ylm.form"
local progress = require "ylm.progress"
local grid_object = require "ylm.grid.object"
local small = require "ylm.grid.small"
local vtu = require "ylm.grid.vtu"
local show = require "ylm.show"

local sampling = grid_object.sampling

local set = {}

local methods = core.metatable "ylm.grid_set"

set.cache_option = { "cache", "memory", optional = true,
  about = "of a grid in bricks: memory of bricks that were used last, '256 MB' where it is left out" }

require "ylm.describe".object "grid_set" {
  about = "A grid in bricks, in a folder name.ylmd: bricks are read when points in them are sampled, and as many as the cache "
    .. "holds stay in memory. It has a light field, as a grid has: scene:render, scene:view and ylm.bake take it. The fields "
    .. "of its description can be read from it.",
  fields = {
    { "bounds", "table", "{ lowest, highest }, scene units" },
    { "lmax", "integer", "of the coefficients" },
    { "channels", "integer", "1 luminance, 3 rgb" },
    { "depth", "integer", "finest level; metric, continuous, tolerance or threshold likewise" },
    { "prints", "table", "as of a grid" },
    { "small", "table", "of a folder of few bytes: its report" },
    { "stats", "table", "sums over all bricks: points (evaluated; one on a face of bricks counts for each that has baked it), "
      .. "interpolated, cells, leaves, levels, pairs, ...; bricks, brick_level: how many, and the level that was asked for; "
      .. "file_bytes: of all files of bricks; held: bytes of bricks in memory, reads: files read so far" },
  },
}

--- The set, where it is one that can be used; raises in the name of the method otherwise.
local function open(s, name)
  local is_open = core.grid_set_is_open(s)
  if is_open == nil then
    return check.fail("%s: a grid in bricks expected before the colon, got %s", name, check.describe(s))
  end
  if not is_open and name ~= "close" then return check.fail("%s: the grid has been closed", name) end
  return s
end

--- Opens a folder; nil, message, code.
function set.open(path, cache)
  local s, message, code = check.result("load", core.grid_set_open((path:gsub("/+$", "")), cache or 0))
  if not s then return nil, message, code end
  core.own(s).path = path
  return s
end

--- The facts that a bake in bricks is told; nil: it is none. Raises where description and options do not fit.
function set.check_bake(description, o, given, jumps)
  if not o.folder then
    if description.bricks then
      return check.bad(3, "bake", "bricks: a grid in bricks is a folder: say which, folder = 'name.ylmd'")
    end
    for _, name in ipairs { "cache", "fresh", "brick_points", "brick_seconds", "time_limit" } do
      if o[name] then
        return check.bad(3, "bake", "%s is of a grid in bricks: give folder = 'name.ylmd', or leave it out", name)
      end
    end
    return nil
  end
  if not o.folder:lower():find "%.ylmd/*$" then
    return check.bad(3, "bake", "folder: a path name.ylmd expected, got %s", check.describe(o.folder))
  end
  if form.kind(description) ~= "adaptive_grid" then
    return check.bad(1, "bake", "a grid in bricks is an adaptive_grid; leave folder out, and save a uniform_grid")
  end
  if description.dynamic then
    return check.bad(1, "bake", "a grid that follows lights is not baked in bricks: leave folder out")
  end
  if description.depth < 3 then return check.bad(1, "bake", "a grid in bricks has a depth of at least 3") end
  if devices.of(o.device):name() then return check.bad(3, "bake", "device: bricks are baked by the processor") end
  if jumps or description.measure == "irradiance" then
    return check.bad(2, "bake", "light that jumps at surfaces has sides, and is not baked in bricks: leave folder out")
  end
  return { folder = (o.folder:gsub("/+$", "")), level = description.bricks or 0, fresh = o.fresh, points = o.brick_points or 0,
    brick_seconds = o.brick_seconds, seconds = o.time_limit,
    max_points = type(given) == "table" and given.max_points or 0 }
end

--- Bakes in bricks, and opens what was baked. Nil, message, code.
function set.bake(wanted, object, occupied, o, how)
  local most = how.max_points
  wanted.normals, wanted.walls, wanted.bricks, how.max_points = nil, nil, how, nil
  local ok, message, code = core.grid_bake_bricks(wanted, object, occupied, o.seed, o.threads or 0,
    most, progress.of(o.progress))
  if not ok and code == "EBUSY" then return nil, message, code end -- of another process: nothing is wrong here
  ok, message, code = check.result("bake", ok, message, code)
  if not ok then return nil, message, code end
  return check.result("bake", core.grid_set_open(how.folder, o.cache or 0))
end

local sample_options = {
  sampling.interpolation, sampling.derivatives, sampling.outside, sampling.dtype,
  form.threads,
  { "out", "any", optional = true, about = "an array, or a list of them, shaped and typed like the results, which they take" },
  form.progress,
}

describe "grid_set:sample" {
  about = "Interpolates coefficients at points, brick by brick: a call reads each brick that it needs once at most.",
  arguments = {
    { "points", "array|table", "[n][3] or one point, scene units" },
    { "options?", "table", "see the options" },
  },
  options = sample_options,
  returns = {
    { "c", "array", "[n][channels][(lmax+1)^2]" },
    { "dc", "array", "[n][channels][(lmax+1)^2][3], or nil" },
    { "report", "table", "outside: points outside of the bounds; unbaked: points in voxels without data of their own; seconds" },
  },
  errors = "raises on bad arguments; nil, message, code where a brick cannot be read; "
    .. "nil, 'cancelled', 'ECANCELLED' where progress returns false",
  example = [[
local lamp = ylm.sphere_light { at = { 0, 2, 0 }, radius = 0.1 }
local folder = os.tmpname() .. ".ylmd"
local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 1, depth = 3, bricks = 1,
  threshold = 0.05 }, lamp, { folder = folder }))
local c = grid:sample({ { 0, 0, 0 }, { 0.5, 0, 0.25 } })
assert(#c == 2 and grid.stats.bricks > 0)
os.execute("rm -r " .. folder)]],
}
function methods.sample(s, points, given)
  open(s, "sample")
  local o = form.options(2, "sample", sample_options, given)
  local p, single = array.points(1, "sample", points)
  local f = core.grid_set_look(s)
  local shape = { p.shape[1], f.channels, (f.lmax + 1) ^ 2 }
  return devices.of(nil):sample(s, p, o, { shape, o.derivatives > 0 and { shape[1], shape[2], shape[3], 3 } or nil }, single)
end

local save_options = { small.options[1], small.options[2], small.options[3],
  { "team", "object", of = "team", optional = true, about = ".pvtu: ylm.team(), whose processes share the files; all call" },
  vtu.options[1], form.threads, form.progress,
}

describe "grid_set:save" {
  about = "Writes all bricks as one file, .ylm, with one brick in memory at a time; the grid has to fit into memory when that "
    .. "file is loaded. With tolerance, bytes or step the file has few bytes, and the grid has to fit into memory twice. A path "
    .. "name.ylmd is another folder of few bytes, whose bricks are written and read one by one. Or writes the voxels for "
    .. "ParaView: NAME.pvtu, and NAME-K-of-N.vtu beside it: a file for each process, with a piece for each brick of its range; "
    .. "more where a file would have more than 64 bricks. One brick is in memory then; points on faces between bricks are in "
    .. "both.",
  arguments = { { "path", "string", "ends in .ylm, .ylmd or .pvtu" }, { "options?", "table", "see the options" } },
  options = save_options,
  returns = { { "ok", "boolean", "true; or nil, message, 'EIO', 'ENOMEM' or what reading a brick says" },
    { "report", "table", "of few bytes, as of grid:save; of a folder without sections" } },
  errors = "raises on a path that ends in something else, and on a folder of a bake; nil, 'cancelled', 'ECANCELLED' where "
    .. "progress returns false",
  example = [[
local folder = os.tmpname() .. ".ylmd"
local grid = assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 1, depth = 3, threshold = 0.5 },
  ylm.sphere_light { at = { 0, 2, 0 } }, { folder = folder }))
assert(grid:save(folder .. "/grid.pvtu"))
assert(grid:save(folder .. "/all.ylm"))
assert(ylm.load(folder .. "/all.ylm").depth == 3)
os.execute("rm -r " .. folder)]],
}
function methods.save(s, path, given)
  open(s, "save")
  local ending = type(path) == "string" and not path:find "%z" and path:lower():match "%.(%w+)/*$"
  if ending ~= "ylm" and ending ~= "ylmd" and ending ~= "pvtu" then
    return check.bad(1, "save", "a path ending in .ylm, .ylmd or .pvtu expected, got %s", check.describe(path))
  end
  local o = form.options(2, "save", save_options, given)
  if ending == "ylmd" then
    if not small.is_asked(2, "save", o) then
      return check.bad(2, "save", "a folder is written in few bytes: tolerance, bytes or step expected")
    end
    return small.save_set("save", s, path, o)
  end
  if ending == "pvtu" then return require "ylm.grid.pvtu".save(s, path, o.team and o.team.handle or core.team_alone(), o) end
  if not small.is_asked(2, "save", o) then
    return check.result("save", core.grid_set_write(s, path, o.threads or 0, progress.of(o.progress)))
  end
  local g, message, code = check.result("save", core.grid_set_pack(s, o.threads or 0, progress.of(o.progress)))
  if not g then return nil, message, code end
  local ok
  ok, message, code = small.save("save", g, path, o)
  core.grid_close(g)
  if not ok then return nil, message, code end
  return true, message
end

describe "grid_set:close" {
  about = "Frees the memory now rather than at the next collection. The folder stays.",
  arguments = {},
  returns = {},
  errors = "raises on what is not a grid in bricks",
  example = [[
local folder = os.tmpname() .. ".ylmd"
assert(ylm.bake(ylm.adaptive_grid { bounds = { { -1, -1, -1 }, { 1, 1, 1 } }, lmax = 1, depth = 3, threshold = 0.5 },
  ylm.sphere_light { at = { 0, 2, 0 } }, { folder = folder })):close()
os.execute("rm -r " .. folder)]],
}
function methods.close(s)
  open(s, "close")
  check.result("close", core.grid_set_close(s))
end

methods.__index = function(s, key)
  local method = rawget(methods, key)
  if method ~= nil or type(key) ~= "string" then return method end
  open(s, key)
  local f, stats = core.grid_set_look(s)
  if key == "stats" then return show.report(stats) end
  if key == "small" then return core.grid_set_small(s) end
  return f[key]
end

methods.__newindex = function(_, key)
  return check.fail("grid: cannot set %s: a grid in bricks does not change", check.describe(key))
end

methods.__tostring = function(s)
  if not core.grid_set_is_open(s) then return "ylm.grid_set (closed)" end
  local f, stats = core.grid_set_look(s)
  return ("ylm.grid_set lmax %d %s, %d bricks, %d points"):format(f.lmax, f.channels == 3 and "rgb" or "luminance",
    stats.bricks, stats.points)
end

return set
