--- Lua sources whose control variables of loops, the first of each, are constant, as they are in Lua 5.5: a compiler of
--- Lua 5.4 then refuses what 5.5 refuses.
--
--     load(loops.constant "for i = 1, 3 do i = 2 end")  --> nil, attempt to assign to const variable 'i'

local loops = {}

--- Where the token at `at` ends and, of a word, the word; what stands between tokens belongs to the one before.
local function token(text, at)
  local open = text:match("^%-%-%[(=*)%[", at) or text:match("^%[(=*)%[", at)
  if open then return select(2, text:find("]" .. open .. "]", at, true)) end
  if text:find("^%-%-", at) then return (text:find("\n", at, true) or #text) end
  local quote = text:match("^[\"']", at)
  if quote then
    local last = at
    repeat last = text:find("[\\" .. quote .. "]", last + 1)
      local escape = text:sub(last, last) == "\\"
      if escape then last = last + 1 end
    until not escape
    return last
  end
  local _, last, word = text:find("^([%a_][%w_]*)", at)
  if word then return last, word end
  return text:find("^%d", at) and select(2, text:find("^[%w.]+", at)) or at
end

local opens = { ["function"] = true, ["if"] = true, ["do"] = true, ["repeat"] = true }
local closes = { ["end"] = true, ["until"] = true }

--- The source with `local NAME <const> = NAME` at the head of each loop; lines stay what they were.
function loops.constant(text)
  local out, at, done = {}, 1, 1
  local open = {} -- headers of loops that have not come to their `do`: first name, blocks that are open within
  while at <= #text do
    local last, word = token(text, at)
    local header = open[#open]
    if word == "for" then open[#open + 1] = { depth = 0 }
    elseif header and not header.over then
      if word == "in" then header.over = true
      elseif word then header.name = header.name or word
      elseif text:sub(at, at) == "=" then header.over = true end
    elseif header and word == "do" and header.depth == 0 then
      open[#open] = nil
      out[#out + 1] = text:sub(done, last)
      out[#out + 1] = (" local %s <const> = %s;"):format(header.name, header.name)
      done = last + 1
      if open[#open] then open[#open].depth = open[#open].depth + 1 end
    elseif header and opens[word] then header.depth = header.depth + 1
    elseif header and closes[word] then header.depth = header.depth - 1 end
    at = last + 1
  end
  out[#out + 1] = text:sub(done)
  return table.concat(out)
end

return loops
