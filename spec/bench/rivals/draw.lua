-- Charts and pictures of `make bench BENCH=rivals`, from its folder.
--
--     build/ylm run spec/bench/rivals/draw.lua [folder] [where pictures go]
--
-- rivals_bytes.png and rivals_seconds.png: error over bytes and over processor seconds, a mark for each row. rivals_1.png and
-- rivals_2.png: light of half of the scenes each by paths, three.js, EEVEE and .ylmp, where the scene's camera looks, with
-- errors at the truth's places. Lamps and the sky are white. Scenes without rows are left out.

local ylm = require "ylm"

local unpack = table.unpack or unpack -- luacheck: ignore
local folder, out = arg[1] or "out/rivals", arg[2] or arg[1] or "out/rivals"
local KINDS = { "three.js", "EEVEE", "ylm, fitted", "ylm, bricks", "ylm's grid", "Radiance", "Cycles", "POV-Ray", "ylm, paths" }
local SAYS = { ["ylm, fitted"] = "ylm, fitted lattice", ["ylm, bricks"] = "ylm, .ylmp", ["ylm, paths"] = "ylm, paths at places" }
local MARKS = { "square", "diamond", "plus", "circle", "cross", "square", "diamond", "plus", "circle" }
local COLUMNS = { "paths", "three.js", "EEVEE", "ylm, .ylmp" }
local KIND = { ["ylm, .ylmp"] = "ylm, bricks" }
local GREY = 0.3                      -- of the mean irradiance that the camera sees
local ENLARGED, CAPTION, GAP = 2, 22, 6 -- pixels a pixel; rows for words; between pictures
local PAPER, INK = { 0.7, 0.7, 0.7 }, { 0, 0, 0 }
local W, H = unpack(require "spec.bench.rivals.seen".size)

local function slug(name) return (name:gsub("[^%w]+", "_")) end

local function rows_of(scene)
  local rows, file = {}, io.open(folder .. "/" .. scene .. ".tsv")
  for line in file and file:lines() or function() end do
    local row = {}
    for word in (line .. "\t"):gmatch "([^\t]*)\t" do row[#row + 1] = word end
    rows[#rows + 1] = { kind = row[2], rms = tonumber(row[3]), bytes = tonumber(row[6]), seconds = tonumber(row[7]),
      pictured = row[8] == "1" }
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

--- Irradiance [n][3] that a camera sees as a picture; white where lamps or the sky are.
local function picture_of(E, mean)
  local one, at = assert(ylm.image { size = { W, H } }), 0
  local layer = one:layer()
  for _, e in ipairs(E:totable()) do
    local x, y = at % W + 1, math.floor(at / W) + 1
    for c = 1, 3 do layer:set(y, x, c, e[1] == -1 and 1 or math.max(0, e[c]) * GREY / mean) end
    at = at + 1
  end
  return assert(one:resize { ENLARGED * W, ENLARGED * H })
end

--- The error of a scene's row whose light is drawn, as words.
local function error_of(scene, kind)
  for _, row in ipairs(rows_of(scene)) do
    if row.kind == kind and row.pictured then return (" %.3g %%"):format(100 * row.rms) end
  end
  return ""
end

local function sheet(name, scenes)
  local w, h = ENLARGED * W + GAP, ENLARGED * H + CAPTION + GAP
  local picture = assert(ylm.image { size = { #COLUMNS * w - GAP, #scenes * h - GAP } })
  picture:fill(1, 1, #COLUMNS * w - GAP, #scenes * h - GAP, PAPER)
  for i, scene in ipairs(scenes) do
    local mean
    for k, column in ipairs(COLUMNS) do
      local E = ylm.load(("%s/%s.seen.%s.npy"):format(folder, scene, slug(column)))
      local x, y = (k - 1) * w + 1, (i - 1) * h + 1
      if E then
        mean = mean or E:clamp(0):mean()
        picture:paste(picture_of(E, mean), x, y + CAPTION)
      end
      local says = k == 1 and scene .. ": paths" or column .. (E and error_of(scene, KIND[column] or column) or ": not run")
      picture:text(x + 2, y + 3, says, { colour = INK, scale = ENLARGED })
    end
  end
  assert(picture:save(out .. "/" .. name))
end

chart("rivals_bytes.png", "bytes", "Probes that answer anywhere: error over bytes", "bytes", "bottom right",
  { ["three.js"] = true, EEVEE = true, ["ylm, fitted"] = true, ["ylm, bricks"] = true, ["ylm's grid"] = true })
chart("rivals_seconds.png", "seconds", "Error over processor seconds", "processor seconds", "bottom right",
  { ["three.js"] = true, EEVEE = true, ["ylm's grid"] = true, Radiance = true, Cycles = true, ["POV-Ray"] = true,
    ["ylm, paths"] = true })
local names = {}
for _, entry in ipairs(require "spec.bench.rivals.scenes") do
  if rows_of(entry.name)[1] then names[#names + 1] = entry.name end
end
local half = math.ceil(#names / 2)
sheet("rivals_1.png", { unpack(names, 1, half) })
sheet("rivals_2.png", { unpack(names, half + 1) })
