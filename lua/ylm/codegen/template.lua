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

return template
