--- Turns outputs (nodes with names) into statements of C, GLSL or JavaScript; "shader" is GLSL for shaders/*.real.comp, whose
-- element type is `real` and whose outputs go where macros say; "essl" is the GLSL of WebGL 2.
--
-- A node that is used more than once gets a temporary, in the order in which outputs need it; what
-- is used once is written where it is used, unless the line grows too long.

local expression = require "ylm.codegen.expression"

local emit = {}

local LONGEST = 72 -- characters of an expression before it is cut into temporaries

local languages = {
  c = {
    temporary = "const YLM_T %s = %s;",
    constant = function(text) return "YLM_K(" .. text .. ")" end,
    pure = function(text) return "YLM_SET(" .. text .. ")" end,
    sqrt = "YLM_SQRT(%s)",
  },
  glsl = {
    temporary = "float %s = %s;",
    constant = function(text) return text end,
    pure = function(text) return text end,
    sqrt = "sqrt(%s)",
  },
  essl = {
    temporary = "float %s = %s;",
    constant = function(text) return text end,
    pure = function(text) return text end,
    sqrt = "sqrt(%s)",
  },
  js = {
    temporary = "const %s = %s;",
    constant = function(text) return text end,
    pure = function(text) return text end,
    sqrt = "Math.sqrt(%s)",
  },
  -- C for any element type F made of floats.
  element = {
    temporary = "const F %s = %s;",
    constant = function(text) return text .. "f" end,
    pure = function(text) return "zero + " .. text .. "f" end,
    sqrt = "sqrtf(%s)",
  },
  -- C for lanes: vectors vreal of elements real.
  lanes = {
    temporary = "const vreal %s = %s;",
    scalar = "const real %s = %s;",
    constant = function(text) return "(real)" .. text end,
    pure = function(text) return "sh_set((real)" .. text .. ")" end,
    sqrt = "YLM_SQRT(%s)",
  },
  double = {
    temporary = "const double %s = %s;",
    constant = function(text) return text end,
    pure = function(text) return text end,
    sqrt = "sqrt(%s)",
  },
  -- GLSL of either precision: real and REAL(constant) are macros (shaders/ylm.glsl).
  shader = {
    temporary = "real %s = %s;",
    constant = function(text) return "REAL(" .. text .. "lf)" end,
    pure = function(text) return "REAL(" .. text .. "lf)" end,
    sqrt = "sqrt(%s)",
  },
}

--- A constant with enough digits to read back, and always a decimal point or an exponent.
local function number(x)
  local text = ("%.17g"):format(x)
  if ("%.15g"):format(x) + 0 == x then text = ("%.15g"):format(x) end
  if not text:find("[%.e]") then text = text .. ".0" end
  return text
end

local precedence = { ["+"] = 1, ["-"] = 1, ["*"] = 2, ["/"] = 2, negate = 3 }

--- The statements, one a line, that compute `outputs` ({ array, index, node }, or { form, node } where form is the
-- statement with %s for the expression).
-- before(output), where given, returns a line that precedes an output's statements, or nil. how: { whole = true } without
-- temporaries, { exact = true } with every sum in the order of the nodes: a + (b + c) keeps its parentheses, { early = nodes }
-- that are computed first: of two products that are added up, compilers fuse the one they meet first with the sum.
function emit.statements(outputs, language, before, how)
  local style, whole, exact = assert(languages[language]), how and how.whole, how and how.exact
  local roots = {}
  for i, out in ipairs(outputs) do roots[i] = out.node end
  local uses, names, lines, count = expression.uses(roots), {}, {}, 0
  local text_of

  local function name_it(n, text)
    count = count + 1
    names[n] = "t" .. count
    lines[#lines + 1] = (n.scalar and style.scalar or style.temporary):format(names[n], text)
    return names[n]
  end

  --- The text of an operand inside an operation of precedence `outer`; `right`: it stands at the right.
  local function operand(n, outer, right)
    local text, inner = text_of(n)
    if inner and (inner < outer or (right and inner == outer)) then text = "(" .. text .. ")" end
    return text
  end

  --- The text of a node, and its precedence where it is an operation written in place.
  function text_of(n)
    if names[n] then return names[n] end
    if n.op == "variable" then return n.name end
    if n.op == "constant" then
      if n.value < 0 then return "-" .. style.constant(number(-n.value)), 3 end
      return style.constant(number(n.value))
    end
    local text, inner
    if n.op == "sqrt" then text = style.sqrt:format((text_of(n.a)))
    elseif n.op == "negate" then
      inner = 3
      text = "-" .. operand(n.a, 3, true)
    else
      inner = precedence[n.op]
      local a = operand(n.a, inner)
      text = a .. " " .. n.op .. " " .. operand(n.b, inner, exact or n.op ~= "+")
    end
    if not whole and (uses[n] > 1 or #text > LONGEST) then return name_it(n, text) end
    return text, inner
  end

  for _, n in ipairs(how and how.early or {}) do
    local text = text_of(n)
    if not names[n] then name_it(n, text) end
  end
  for _, out in ipairs(outputs) do
    local text
    lines[#lines + 1] = before and before(out)
    if out.node.op == "constant" then
      text = style.pure(number(out.node.value))
    else
      text = text_of(out.node)
    end
    lines[#lines + 1] = out.form and out.form:format(text) or ("%s[%d] = %s;"):format(out.array, out.index, text)
  end
  return lines
end

--- A node as one expression.
function emit.expression(node, language)
  return emit.statements({ { node = node, form = "%s" } }, language, nil, { whole = true, exact = true })[1]
end

return emit
