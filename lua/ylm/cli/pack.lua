--- ylm pack big.ylmd -o big.ylm; ylm pack grid.ylm -o small.ylm --tolerance 0.01; ylm pack big.ylmd -o small.ylmd --bytes 2GB

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local PART = 2 ^ 20 -- bytes

--- Writes one file to stdout; of a grid in bricks by way of a file that is removed.
local function write_out(grid, is_set, o)
  if not is_set then
    io.stdout:write((status.need(require "ylm.grid.small".encode("pack", grid, o))))
    return
  end
  local name = os.tmpname()
  local path = name .. ".ylm"
  local ok, message, code = grid:save(path, o)
  local file = ok and io.open(path, "rb")
  for part in function() return file and file:read(PART) end do io.stdout:write(part) end
  if file then file:close() end
  os.remove(path)
  os.remove(name)
  status.need(ok, message, code)
end

return {
  summary = "a grid, or a folder of bricks, as one file, of few bytes where they are asked for, or a folder of few bytes",
  usage = "GRID.ylmd|GRID.ylm -o GRID.ylm|GRID.ylmd",
  least = 1, most = 1,
  options = {
    { "output", "-o", "FILE", "the file (.ylm), or - for stdout, brick by brick; of few bytes, the grid has to fit into "
      .. "memory twice. Or a folder of few bytes (.ylmd), brick by brick" },
    { "tolerance", nil, "N", "few bytes: interpolation and rounding err by this at most, in all, at 99 % of the places" },
    { "bytes", nil, "SIZE", "few bytes: at most so many (2MB, 500kB), with the least error" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "pack: -o FILE says where the file goes") end
    local to_stdout = given.output == "-"
    local to_folder = given.output:lower():find "%.ylmd/*$"
    if not to_stdout and not to_folder then status.need_output("pack", given.output, "ylm", "ylmd") end
    local few = status.few_bytes("pack", given)
    local grid = status.need(ylm.load(given[1]))
    local is_set = require "ylm.form".kind(grid) == "ylm.grid_set"
    local words = "a grid (name.ylm) or one in bricks (a folder name.ylmd)"
    if not is_set then grid = status.need_kind("ylm.grid", words, given[1], grid) end
    if to_folder and not (is_set and few) then
      status.stop(status.usage, "pack: a folder (.ylmd) is written of one, with --tolerance or --bytes: give a name of one file")
    end
    if not is_set and not few then
      status.stop(status.usage, "pack: %s is one file already: --tolerance or --bytes make it a small one", given[1])
    end
    local o = { tolerance = few and few.tolerance, bytes = few and few.bytes, threads = given.threads,
      progress = report.progress(given) }
    if to_stdout then
      if given.json then status.stop(status.usage, "pack: stdout has the file: give it a name, or leave --json out") end
      return write_out(grid, is_set, o)
    end
    local _, small = status.need(grid:save(given.output, o))
    local stats = grid.stats
    local results = { bricks = is_set and stats.bricks or nil, points = stats.points }
    if small then for name, value in pairs(small) do results[name] = value end end
    report.print(given, results, small and { "bytes", "error", "points" } or { "bricks", "points" })
  end,
}
