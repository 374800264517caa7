--- Output of commands: tables as "name value" lines or as JSON, and progress on a terminal.

local json = require "ylm.json"
local noises = require "ylm.render.noise"
local progress = require "ylm.progress"

local report = {}

local function number(x)
  if x ~= x or x == math.huge or x == -math.huge then return "null" end
  if x == math.floor(x) and math.abs(x) < 1e15 then return ("%d"):format(x) end
  return ("%.17g"):format(x)
end

--- JSON of numbers, strings, booleans, lists and tables with string keys (sorted); NaN is null.
function report.json(x) return json.write(x, number, json.quoted) end

local function in_words(x)
  if type(x) == "number" then
    return x == math.floor(x) and math.abs(x) < 1e15 and ("%d"):format(x) or ("%.6g"):format(x)
  end
  if type(x) ~= "table" then return tostring(x) end
  local out, names = {}, {}
  for i = 1, #x do out[i] = in_words(x[i]) end
  for name in pairs(x) do if type(name) == "string" then names[#names + 1] = name end end
  table.sort(names)
  for _, name in ipairs(names) do out[#out + 1] = name .. " " .. in_words(x[name]) end
  return table.concat(out, #names > 0 and ", " or " ")
end

--- The names of `results`: those of `first` in their order, the others sorted; warnings stand on stderr.
function report.names(results, first)
  local names, rest, seen = {}, {}, { warning = true, warnings = true }
  for _, name in ipairs(first) do names[#names + 1], seen[name] = name, true end
  for name in pairs(results) do if not seen[name] then rest[#rest + 1] = name end end
  table.sort(rest)
  for _, name in ipairs(rest) do names[#names + 1] = name end
  return names
end

--- Prints the table `results`, in the order of `order` where it is given.
function report.print(given, results, order)
  if given.silent then return end -- another process prints them
  if given.json then
    io.stdout:write(report.json(results), "\n")
    return
  end
  order = order or report.names(results, {})
  local width = 0
  for _, name in ipairs(order) do width = math.max(width, #name) end
  for _, name in ipairs(order) do
    if results[name] ~= nil then
      io.stdout:write((("%-" .. width .. "s  %s"):format(name, in_words(results[name])):gsub("%s+$", "")), "\n")
    end
  end
end

--- A message on stderr, unless --quiet.
function report.say(given, message, ...)
  if not given.quiet then io.stderr:write(message:format(...), "\n") end
end

--- Says which noise the picture with the report `facts` has, and how long it took.
function report.say_noise(given, facts)
  local before = facts.noise_before
  local note = before and (", %.0f %% before it was filtered"):format(100 * before)
    or given.denoise == "oidn" and " before Open Image Denoise" or ""
  local shared = facts.elements_noise
  if shared and shared > noises.SHARED * (given.noise or noises.WANTED) then
    note = note .. (", %.1f %% more of elements"):format(100 * shared)
  end
  report.say(given, "ylm: noise is %.1f %% of the light around a pixel%s, %.0f s%s", 100 * facts.noise, note, facts.seconds.total,
    facts.ended == "cancelled" and "; interrupted: this is the picture so far" or "")
end

--- The option `progress` of a command: a bar, or lines where stderr is no terminal; false where --quiet or --json was given,
-- or YLM_PROGRESS=no stands in the environment.
function report.progress(given)
  return not given.quiet and not given.json and progress.is_wanted()
end

return report
