--- Command lines: options by name, the rest as a list, checked against a command's declaration.

local check = require "ylm.check"

local arguments = {}

local json = { "json", nil, nil, "results as JSON on stdout" }

--- Every command has these, and --json unless it says json = false: it has no results but text.
local common = {
  { "quiet", "-q", nil, "no progress bar, no messages but errors" },
  { "help", "-h", nil, "this text" },
}

--- All options of a command, in the order of its help: rows of { name, short form, kind of value, text }.
function arguments.declared(command)
  local list = {}
  for _, option in ipairs(command.options or {}) do list[#list + 1] = option end
  if command.json ~= false then list[#list + 1] = json end
  for _, option in ipairs(common) do list[#list + 1] = option end
  return list
end

--- Kinds of values but text: { how many numbers, what is between them, what is expected }.
local kinds = {
  N = { 1, ",", "a number" },
  WxH = { 2, "x", "a size such as 640x360" },
  ["A,B"] = { 2, ",", "two numbers such as 1e-4,1" },
  ["X,Y,Z"] = { 3, ",", "three numbers such as 0,1,0" },
}

--- The value that `text` stands for: text, a finite number or a list of them; nil, message where it is not `wanted`.
local function value_of(text, wanted)
  local kind = kinds[wanted]
  if not kind then return text end
  local numbers = {}
  for word in (text .. kind[2]):gmatch("(.-)" .. kind[2]) do
    local x = tonumber(word)
    if not x or not check.is_number(x) or (wanted == "WxH" and not word:find "^%d+$") then x = nil end
    numbers[#numbers + 1] = x or false
  end
  local good = #numbers == kind[1]
  for _, x in ipairs(numbers) do good = good and x end
  if not good then return nil, ("%s expected, got %s"):format(kind[3], check.describe(text)) end
  return #numbers == 1 and numbers[1] or numbers
end

--- An option as it is declared: names of Lua, --light_samples, mean the options of the same name with hyphens.
local function hyphened(word) return word:find "^%-%-" and word:gsub("_", "-") or word end

--- Parses `given`; nil, message where it does not fit. With command.rest = true everything after the
-- first file is left as it is, with command.raw = true all of it, and so is all behind an option with last = true.
function arguments.parse(command, given)
  if command.raw then
    for _, word in ipairs(given) do given.help = given.help or word == "--help" or word == "-h" end
    return given
  end
  local by_word, words = {}, {}
  for _, option in ipairs(arguments.declared(command)) do
    by_word["--" .. option[1]] = option
    words[#words + 1] = "--" .. option[1]
    if option[2] then by_word[option[2]] = option end
  end
  local out, i, only_files = {}, 1, false
  while i <= #given do
    local word = given[i]
    local name, attached = word:match("^(%-%-[^=]+)=(.*)$")
    local letter = by_word[word:match "^%-%a" or ""]
    if #word > 2 and letter and letter[3] then name, attached = word:sub(1, 2), word:sub(3) end -- -j1
    local option = by_word[hyphened(name or word)]
    if only_files or word == "-" or not word:find("^%-") or (command.rest and #out > 0) then out[#out + 1] = word
    elseif word == "--" then only_files = true
    elseif not option then
      local guess = check.guess(hyphened(name or word), words)
      return nil, ("no option %s%s"):format(check.short(name or word), guess and (" (did you mean %s?)"):format(guess) or "")
    elseif option[3] then
      local text = attached
      if not text then
        i = i + 1
        text = given[i]
      end
      if text == nil then return nil, ("%s: %s expected"):format(word, option[3]) end
      local value, message = value_of(text, option[3])
      if value == nil then return nil, ("%s: %s"):format(name or word, message) end
      out[option[1]] = value
      only_files = only_files or option.last
    elseif attached then return nil, ("%s takes no value"):format(name)
    else out[option[1]] = true end
    i = i + 1
  end
  if not out.help then
    local least, most = command.least or 0, command.most or command.least or 0
    if #out < least then return nil, "expected: " .. command.usage end
    if #out > most and not command.rest then return nil, "unexpected " .. check.describe(out[most + 1]) end
  end
  return out
end

--- How a command is used, in one line, and where its options are told.
function arguments.brief(name, command)
  if command.text then return command.text() end
  return ("usage: ylm %s %s\n       ylm help %s names its options\n"):format(name, command.usage, name)
end

--- How a command is used, with its options.
function arguments.usage(name, command)
  if command.text then return command.text() end
  local lines = { (("usage: ylm %s %s"):format(name, command.usage):gsub(" +$", "")), "", "  " .. command.summary, "" }
  for _, option in ipairs(arguments.declared(command)) do
    local word = (option[2] and option[2] .. ", " or "    ") .. "--" .. option[1]
    if option[3] then word = word .. " " .. option[3] end
    lines[#lines + 1] = ("  %-28s %s"):format(word, option[4])
  end
  if command.notes then lines[#lines + 1] = "\n" .. command.notes end
  for i, example in ipairs(command.examples or {}) do
    if i == 1 then lines[#lines + 1] = "\nexamples:\n" end
    lines[#lines + 1] = "  " .. example
  end
  return table.concat(lines, "\n") .. "\n"
end

return arguments
