--- Expressions with shared subexpressions: what the generator computes with.
--
-- A graph hands out nodes; equal expressions are the same node, so whatever is built twice is
-- computed once. Constants fold, signs move outwards (so that c*x and -c*x share), x*1 and x+0 vanish.
--
--     local g = expression.graph()
--     local x, y = g.variable "x", g.variable "y"
--     local e = 2 * x * y + x * y

local expression = {}

local node = {}
node.__index = node

--- Is this node the constant `value` (any constant where value is nil)?
local function is_constant(a, value)
  return a.op == "constant" and (value == nil or a.value == value)
end

--- Gives a graph its products, quotients and roots; make and binary intern nodes.
local function add_products(g, make, binary)
  function g.multiply(a, b)
    if is_constant(a) and is_constant(b) then return g.constant(a.value * b.value) end
    if is_constant(b) then a, b = b, a end
    if is_constant(a) then
      if a.value == 0 then return a end
      if a.value == 1 then return b end
      if a.value < 0 then return g.negate(g.multiply(g.constant(-a.value), b)) end
      if b.op == "*" and is_constant(b.a) then return g.multiply(g.constant(a.value * b.a.value), b.b) end
      if b.op == "*" and is_constant(b.b) then return g.multiply(g.constant(a.value * b.b.value), b.a) end
    end
    if a.op == "negate" then return g.negate(g.multiply(a.a, b)) end
    if b.op == "negate" then return g.negate(g.multiply(a, b.a)) end
    return binary("*", a, b, true)
  end

  function g.divide(a, b) return binary("/", a, b) end
  function g.sqrt(a) return make("sqrt " .. a.id, "sqrt", a) end
end

--- A new, empty graph.
function expression.graph()
  local g, nodes, by_key = {}, {}, {}

  local function make(key, op, a, b)
    local n = by_key[key]
    if not n then
      n = setmetatable({ graph = g, id = #nodes + 1, op = op, a = a, b = b }, node)
      n.scalar = op == "constant" or (a and a.scalar and (not b or b.scalar)) or false
      nodes[n.id] = n
      by_key[key] = n
    end
    return n
  end

  function g.constant(value)
    if value == 0 then value = 0 end -- no negative zero
    local n = make(("constant %.17g"):format(value), "constant")
    n.value = value
    return n
  end

  --- scalar: the same number for all lanes of a vector; what follows from such numbers alone is one too (node.scalar).
  function g.variable(name, scalar)
    local n = make("variable " .. name, "variable")
    n.name, n.scalar = name, scalar or false
    return n
  end

  local function binary(op, a, b, commutes)
    if commutes and b.id < a.id then a, b = b, a end
    return make(op .. a.id .. " " .. b.id, op, a, b)
  end

  function g.negate(a)
    if is_constant(a) then return g.constant(-a.value) end
    if a.op == "negate" then return a.a end
    if a.op == "-" then return binary("-", a.b, a.a) end
    return make("negate " .. a.id, "negate", a)
  end

  function g.add(a, b)
    if is_constant(a) and is_constant(b) then return g.constant(a.value + b.value) end
    if is_constant(a, 0) then return b end
    if is_constant(b, 0) then return a end
    if a.op == "negate" and b.op == "negate" then return g.negate(g.add(a.a, b.a)) end
    if b.op == "negate" then return g.subtract(a, b.a) end
    if a.op == "negate" then return g.subtract(b, a.a) end
    return binary("+", a, b, true)
  end

  function g.subtract(a, b)
    if a == b then return g.constant(0) end
    if is_constant(b) then
      if is_constant(a) then return g.constant(a.value - b.value) end
      if b.value == 0 then return a end
      if b.value < 0 then return g.add(a, g.constant(-b.value)) end
    end
    if is_constant(a, 0) then return g.negate(b) end
    if b.op == "negate" then return g.add(a, b.a) end
    if a.op == "negate" then return g.negate(g.add(a.a, b)) end
    return binary("-", a, b)
  end

  add_products(g, make, binary)
  return g
end

--- Both operands as nodes: numbers become constants.
local function operands(a, b)
  local g = type(a) == "table" and a.graph or b.graph
  return g, type(a) == "table" and a or g.constant(a), type(b) == "table" and b or g.constant(b)
end

function node.__add(a, b) local g, p, q = operands(a, b) return g.add(p, q) end
function node.__sub(a, b) local g, p, q = operands(a, b) return g.subtract(p, q) end
function node.__mul(a, b) local g, p, q = operands(a, b) return g.multiply(p, q) end
function node.__div(a, b) local g, p, q = operands(a, b) return g.divide(p, q) end
function node.__unm(a) return a.graph.negate(a) end

--- Calls visit(node) once for each node that `roots` (a list) need, operands first.
function expression.walk(roots, visit)
  local seen = {}
  local function go(n)
    if seen[n] then return end
    seen[n] = true
    if n.a then go(n.a) end
    if n.b then go(n.b) end
    visit(n)
  end
  for _, root in ipairs(roots) do go(root) end
end

--- Operations that computing `roots` takes: { adds =, muls =, divs =, sqrts =, total = }.
-- A change of sign is free: it is folded into the operation that follows.
function expression.count(roots)
  local kinds = { ["+"] = "adds", ["-"] = "adds", ["*"] = "muls", ["/"] = "divs", sqrt = "sqrts" }
  local c = { adds = 0, muls = 0, divs = 0, sqrts = 0, total = 0 }
  expression.walk(roots, function(n)
    local kind = kinds[n.op]
    if kind then
      c[kind] = c[kind] + 1
      c.total = c.total + 1
    end
  end)
  return c
end

--- How often each node is used by others or as a root: a table by node.
function expression.uses(roots)
  local uses = {}
  local function use(n) uses[n] = (uses[n] or 0) + 1 end
  for _, root in ipairs(roots) do use(root) end
  expression.walk(roots, function(n)
    if n.a then use(n.a) end
    if n.b then use(n.b) end
  end)
  return uses
end

return expression
