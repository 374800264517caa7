--- Functions that the examples share: options, tables, searches, slopes. Loaded with dofile, no part of ylm.

local common = {}

--- "usage: lua SCRIPT [--out out] [--quick] ...": the options by name, with what they are by default.
local function usage(defaults)
  local words = {}
  for name, default in pairs(defaults) do
    local value = default == "" and "TEXT" or tostring(default)
    words[#words + 1] = default == false and ("[--%s]"):format(name) or ("[--%s %s]"):format(name, value)
  end
  table.sort(words)
  return ("usage: %s %s"):format(arg[0], table.concat(words, " "))
end

--- Makes a folder, parents included; stops where nothing can be written there: before the work, not after it.
local function folder(path)
  os.execute("mkdir -p '" .. path:gsub("'", "'\\''") .. "'")
  local name = path .. "/.writable"
  local file, message = io.open(name, "w")
  if not file then error(message, 0) end
  file:close()
  os.remove(name)
  return path .. "/"
end

--- Ends the script with its usage where "--help" or "-h" is among the words.
local function help(defaults)
  for _, word in ipairs(arg) do
    if word == "--help" or word == "-h" then
      print(usage(defaults))
      os.exit(0)
    end
  end
end

--- Reads "--name value" and "--flag" into a copy of `defaults`; stops with the usage where a name is unknown.
-- A default of false makes a flag; the type of the default is the type of the value ("" for text). `out` is a folder: it
-- is made, and its name ends in a slash. A script that writes no file takes --out, too, and says that it has no use for it.
function common.options(defaults)
  help(defaults)
  local options = {}
  for name, value in pairs(defaults) do options[name] = value end
  local i = 1
  while arg[i] do
    local name = arg[i]:match "^%-%-([%w_]+)$"
    local default = defaults[name or ""]
    local value = arg[i + 1]
    if name == "out" and value and default == nil then
      print "--out: this script prints its results, and writes no file"
      default = ""
    end
    if default == nil then error(("unknown option '%s'\n%s"):format(arg[i], usage(defaults)), 0) end
    if default == false then options[name], i = true, i + 1
    else
      if type(default) == "number" then value = tonumber(value) end
      if value == nil then error(("--%s needs a value\n%s"):format(name, usage(defaults)), 0) end
      options[name], i = value, i + 2
    end
  end
  if options.out then options.out = folder(options.out) end
  return options
end

--- Saves a picture and says so; where it cannot be drawn (no VTK), says why and goes on.
function common.save(picture, path, options)
  local ok, message = picture:save(path, options)
  print(ok and "wrote " .. path or "no picture: " .. tostring(message))
end

--- Lamps on a spiral (Vogel 1979) over a floor, in all colours: places and radiances of n. Places are `spacing` sqrt(i) from
-- the middle, at one of three heights; a channel of a radiance is at most `swing` from `grey`.
function common.spiral(n, spacing, height, step, grey, swing)
  local at, radiance = {}, {}
  for i = 1, n do
    local angle, r, hue = i * 2.39996, spacing * math.sqrt(i), 2 * math.pi * 0.618 * i
    at[i] = { r * math.cos(angle), height + step * (i % 3), r * math.sin(angle) }
    radiance[i] = { grey + swing * math.cos(hue), grey + swing * math.cos(hue - 2.1), grey + swing * math.cos(hue - 4.2) }
  end
  return at, radiance
end

--- A printer of rows: columns are { title, format } in order; nil cells print as "-".
function common.table(columns)
  local widths, titles = {}, {}
  for i, column in ipairs(columns) do
    widths[i] = math.max(#column[1], tonumber(column[2]:match "(%d+)") or 0)
    titles[i] = (column[2]:find "%-" and "%-" or "%") .. widths[i] .. "s"
    titles[i] = titles[i]:format(column[1])
  end
  print(table.concat(titles, "  "))
  return function(row)
    local cells = {}
    for i, column in ipairs(columns) do
      local value = row[i]
      local text = value == nil and "-" or column[2]:format(value)
      local left = column[2]:find "%-" and "%-" or "%"
      cells[i] = (left .. widths[i] .. "s"):format(text)
    end
    print((table.concat(cells, "  "):gsub("%s+$", "")))
    io.stdout:flush()
  end
end

--- The integer in lo .. hi whose f(n), a growing function, is nearest to `wanted`.
function common.nearest(lo, hi, wanted, f)
  local known = {}
  local function at(n)
    known[n] = known[n] or f(n)
    return known[n]
  end
  while hi - lo > 1 do
    local middle = math.floor((lo + hi) / 2)
    if at(middle) < wanted then lo = middle else hi = middle end
  end
  return math.abs(at(lo) - wanted) < math.abs(at(hi) - wanted) and lo or hi
end

--- Least-squares slope of log y over log x.
function common.slope(x, y)
  local n, sx, sy, sxx, sxy = 0, 0, 0, 0, 0
  for i = 1, #x do
    if x[i] > 0 and y[i] > 0 then
      local u, v = math.log(x[i]), math.log(y[i])
      n, sx, sy, sxx, sxy = n + 1, sx + u, sy + v, sxx + u * u, sxy + u * v
    end
  end
  return (n * sxy - sx * sy) / (n * sxx - sx * sx)
end

--- 12345678 as "12,345,678".
function common.thousands(n)
  local text = ("%.0f"):format(n)
  repeat
    local k
    text, k = text:gsub("^(%d+)(%d%d%d)", "%1,%2")
  until k == 0
  return text
end

--- Luminance (Rec. 709) of pixels [h][w][3], as an array [h][w].
function common.luminance(pixels) return (pixels * { 0.2126, 0.7152, 0.0722 }):sum(3) end

--- Pixels where geometry alone is seen, as an array [h][w] of 0 and 1: what errors are taken over.
function common.surface_mask(_, image)
  return (image:layer "coverage":greater(0.999) * image:layer "emitter":less(1e-6))[{ {}, {}, 1 }]
end

--- Errors of a picture beside paths with their variance, at pixels that surfaces fill, of these where the mask
-- keep(positions [h][w][3]) is 1 (nil or false: all): root mean square over that of the truth, less its noise; and the 95 %
-- quantile of the relative errors of pixels above a tenth of the mean; in percent.
function common.errors(image, truth, keep)
  local mask = image:layer "coverage"[{ {}, {}, 1 }]:greater(0.999)
  if keep then mask = mask * keep(image:layer "position") end
  local a, b, v = image:layer "radiance":select(mask), truth:layer "radiance":select(mask), truth:layer "variance":select(mask)
  local d, n = ((a - b) ^ 2):sum(2), (b ^ 2):sum(2)
  local norm, relative = n:sqrt(), (d / n):sqrt()
  local lit = relative:select(norm:greater(0.1 * norm:mean())):totable()
  table.sort(lit)
  return 100 * math.sqrt(math.max(0, d:sum() - v:sum()) / n:sum()), 100 * (lit[math.ceil(0.95 * #lit)] or 0)
end

--- A function that adds its fields to a copy of `shared`.
function common.adding_to(shared)
  return function(more)
    local o = {}
    for _, fields in ipairs { shared, more } do
      for name, value in pairs(fields) do o[name] = value end
    end
    return o
  end
end

--- Milliseconds of f by the clock, the best of `runs`; f returns seconds where it knows better.
function common.best(clock, runs, f)
  local least = math.huge
  for _ = 1, runs do
    local start = clock()
    local seconds = f() or clock() - start
    least = math.min(least, seconds)
  end
  return 1000 * least
end

--- The largest channel of a difference image at every pixel, as an array [h][w] fit for a logarithmic scale.
function common.error_values(difference) return difference:layer():max(3):clamp(1e-9) end

--- The cost of a light-point pair with the Hessian metric relative to one with a gradient (RGB, lmax 4): measured by
-- `make bench`, see docs/performance.md.
common.hessian_cost = 1.2

return common
