--- Formulas as text with words that a language fills in: for what needs masks or statements, which nodes have not.
--
-- #x is a constant; `real` and `mask` are types of numbers and of conditions; WORD(..) is a function or an operation.

local template = {}

--- The text in a language { real =, mask =, constant = "..%s..", words = { WORD = name } }.
function template.fill(text, language)
  local function constant(x) return (language.constant:format(x)) end
  text = text:gsub("%f[%w_]real%f[^%w_]", language.real):gsub("%f[%w_]mask%f[^%w_]", language.mask)
  text = text:gsub("%f[%u](%u+)%f[^%w_]", function(word) return language.words[word] end)
  return (text:gsub("#([%d%.]+e%-?%d+)", constant):gsub("#([%d%.]+)", constant))
end

--- Joins words into the lines of a macro, of at most 98 columns; all but the last end in a backslash. `head` begins the first.
function template.macro(out, head, words)
  local line = head
  for _, word in ipairs(words) do
    if #line + #word + 1 > 96 then
      out[#out + 1] = line .. " \\"
      line = "   "
    end
    line = line .. " " .. word
  end
  out[#out + 1] = line
end

return template
