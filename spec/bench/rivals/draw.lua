-- Charts and pictures of `make bench BENCH=rivals`, from its folder.
--
--     build/ylm run spec/bench/rivals/draw.lua [folder] [where pictures go]
--
-- rivals_bytes.png and rivals_seconds.png: error over bytes and over processor seconds, a mark for each scene. rivals.png:
-- light of the ten scenes by paths, three.js, EEVEE and .ylmp, where the scene's camera looks.

local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore
local folder, out = arg[1] or "out/rivals", arg[2] or arg[1] or "out/rivals"
local KINDS = { "three.js", "EEVEE", "ylm, fitted", "ylm, bricks", "ylm's grid", "Radiance", "Cycles", "POV-Ray", "ylm, paths" }
local SAYS = { ["ylm, fitted"] = "ylm, fitted lattice", ["ylm, bricks"] = "ylm, .ylmp", ["ylm, paths"] = "ylm, paths at places" }
local MARKS = { "square", "diamond", "plus", "circle", "cross", "square", "diamond", "plus", "circle" }
local COLUMNS = { "paths", "three.js", "EEVEE", "ylm, .ylmp" }
local GREY = 0.3             -- of the mean irradiance that the camera sees
local PAIRS, CAPTION = 2, 14 -- scenes beside each other; rows for words

local function slug(name) return (name:gsub("[^%w]+", "_")) end

local function rows_of(scene)
  local rows, file = {}, io.open(folder .. "/" .. scene .. ".tsv")
  for line in file and file:lines() or function() end do
    local row = {}
    for word in (line .. "\t"):gmatch "([^\t]*)\t" do row[#row + 1] = word end
    rows[#rows + 1] = { kind = row[2], rms = tonumber(row[3]), bytes = tonumber(row[6]), seconds = tonumber(row[7]) }
  end
  if file then file:close() end
  return rows
end

local function chart(name, field, title, label, legend, kinds)
  local series = {}
  for k, kind in ipairs(KINDS) do
    local x, y = {}, {}
    for _, entry in ipairs(require "spec.bench.rivals.scenes") do
      for _, row in ipairs(rows_of(entry.name)) do
        if row.kind == kind and kinds[kind] and row[field] then x[#x + 1], y[#y + 1] = row[field], 100 * row.rms end
      end
    end
    if #x > 0 then
      series[#series + 1] = { x = x, y = y, label = SAYS[kind] or kind, width = 0, marker = MARKS[k], marker_size = 9 }
    end
  end
  local drawn = ylm.plot { title = title, series = series, x_label = label, y_label = "rms error over the mean (%)", log = true,
    legend = legend, size = { 800, 520 } }
  assert(drawn:save(out .. "/" .. name))
end

local function sheet()
  local scenes = require "spec.bench.rivals.scenes"
  local picture, w, h
  for i, entry in ipairs(scenes) do
    local mean
    for k, column in ipairs(COLUMNS) do
      local E = ylm.load(("%s/%s.seen.%s.npy"):format(folder, entry.name, slug(column)))
      if not picture and E then
        w, h = unpack(require "spec.bench.rivals.seen".size)
        picture = assert(ylm.image { size = { PAIRS * #COLUMNS * w, math.ceil(#scenes / PAIRS) * (h + CAPTION) } })
      end
      local x, y = ((i - 1) % PAIRS * #COLUMNS + k - 1) * w + 1, math.floor((i - 1) / PAIRS) * (h + CAPTION) + 1
      if E then
        local light = E:clamp(0)
        mean = mean or light:mean()
        local one = assert(ylm.image { size = { w, h } })
        one:layer()[{}] = (light * (GREY / mean)):reshape { h, w, 3 }
        picture:paste(one, x, y + CAPTION)
      end
      if picture then
        local says = k == 1 and entry.name .. ": paths" or column .. (E and "" or ": none")
        picture:text(x + 2, y + 4, says, { colour = { 1, 1, 1 } })
      end
    end
  end
  if picture then assert(picture:save(out .. "/rivals.png")) end
end

chart("rivals_bytes.png", "bytes", "Probes that answer anywhere: error over bytes, ten scenes", "bytes", "bottom right",
  { ["three.js"] = true, EEVEE = true, ["ylm, fitted"] = true, ["ylm, bricks"] = true, ["ylm's grid"] = true })
chart("rivals_seconds.png", "seconds", "Error over processor seconds, ten scenes", "processor seconds", "top left",
  { ["three.js"] = true, EEVEE = true, ["ylm's grid"] = true, Radiance = true, Cycles = true, ["POV-Ray"] = true,
    ["ylm, paths"] = true })
sheet()
