--- Text from files as a terminal may show it: nothing to obey, nothing that hides or turns letters around.

local text = {}

--- The length of the UTF-8 sequence at byte i; nil where there is none, or one that stands for no letter: a control
-- character (U+0080 to U+009F), a line separator, a mark that changes the direction of writing.
local function sequence(s, i)
  local a, b, c, d = s:byte(i, i + 3)
  local function follows(x, lo, hi) return x and x >= (lo or 0x80) and x <= (hi or 0xbf) end
  if a >= 0xc2 and a <= 0xdf then return follows(b, a == 0xc2 and 0xa0) and 2 end
  if a >= 0xe0 and a <= 0xef then
    if not (follows(b, a == 0xe0 and 0xa0, a == 0xed and 0x9f) and follows(c)) then return nil end
    local turns = a == 0xe2 and (b == 0x80 and (c == 0x8e or c == 0x8f or c >= 0xa8 and c <= 0xae)
      or b == 0x81 and c >= 0xa6 and c <= 0xa9)
    return not turns and 3
  end
  if a < 0xf0 or a > 0xf4 then return nil end
  return follows(b, a == 0xf0 and 0x90, a == 0xf4 and 0x8f) and follows(c) and follows(d) and 4
end

local function replaced(run)
  local out, i = {}, 1
  while i <= #run do
    local n = run:byte(i) >= 0x80 and sequence(run, i)
    out[#out + 1] = n and run:sub(i, i + n - 1) or "?"
    i = i + (n or 1)
  end
  return table.concat(out)
end

--- The text with a question mark for each byte of what is no letter.
function text.shown(s) return (s:gsub("[%c\127-\255]+", replaced)) end

return text
