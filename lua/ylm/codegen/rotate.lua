--- Emits csrc/sh/gen/rotate_low.h, one vector rotated by straight-line code, degrees 0 .. 6, and rotate_each_low.h,
-- the same degrees of rows that have rotations of their own.
--
-- M = Z(a+pi) J Z(b+pi) J Z(c), J the quarter turn about x (csrc/sh/rotate/rotate.h). J comes from the
-- recurrence of Ivanic & Ruedenberg 1996 with its corrections and is snapped to the algebraic numbers
-- that its entries are: sign * sqrt(N / (4^l * 3465)) for l <= 6.

local rotate = {}

local LMAX = 6

--- The matrix of `r` (3x3, r[row][column]) for degree l from those of degrees 1 and l-1; [m][n].
local function next_degree(l, r1, before)
  local function delta(a, b) return a == b and 1 or 0 end
  local function P(i, a, b)
    if b == l then return r1[i][1] * before[a][l - 1] - r1[i][-1] * before[a][-l + 1] end
    if b == -l then return r1[i][1] * before[a][-l + 1] + r1[i][-1] * before[a][l - 1] end
    return r1[i][0] * before[a][b]
  end
  local M = {}
  for m = -l, l do
    M[m] = {}
    for n = -l, l do
      local d = math.abs(n) == l and 2 * l * (2 * l - 1) or (l + n) * (l - n)
      local am = math.abs(m)
      local u = math.sqrt((l + m) * (l - m) / d)
      local v = 0.5 * math.sqrt((1 + delta(m, 0)) * (l + am - 1) * (l + am) / d) * (1 - 2 * delta(m, 0))
      local w = -0.5 * math.sqrt((l - am - 1) * (l - am) / d) * (1 - delta(m, 0))
      local sum = 0
      if u ~= 0 then sum = sum + u * P(0, m, n) end
      if v ~= 0 then
        if m == 0 then sum = sum + v * (P(1, 1, n) + P(-1, -1, n))
        elseif m > 0 then
          sum = sum + v * (P(1, m - 1, n) * math.sqrt(1 + delta(m, 1))
            - (m == 1 and 0 or P(-1, -m + 1, n)))
        else
          sum = sum + v * ((m == -1 and 0 or P(1, m + 1, n))
            + P(-1, -m - 1, n) * math.sqrt(1 + delta(m, -1)))
        end
      end
      if w ~= 0 then
        if m > 0 then sum = sum + w * (P(1, m + 1, n) + P(-1, -m - 1, n))
        else sum = sum + w * (P(1, m - 1, n) - P(-1, -m + 1, n)) end
      end
      M[m][n] = sum
    end
  end
  return M
end

--- J for degrees 0 .. lmax: the turn by +90 degrees about x (y to z).
local function quarter_turns(lmax)
  local r = { { 1, 0, 0 }, { 0, 0, -1 }, { 0, 1, 0 } }
  local axis = { [-1] = 2, [0] = 3, [1] = 1 }       -- y z x
  local sign = { [-1] = -1, [0] = 1, [1] = -1 }     -- of the basis with the Condon-Shortley phase
  local J = { [0] = { [0] = { [0] = 1 } }, { [-1] = {}, [0] = {}, [1] = {} } }
  for m = -1, 1 do
    for n = -1, 1 do J[1][m][n] = sign[m] * sign[n] * r[axis[m]][axis[n]] end
  end
  for l = 2, lmax do J[l] = next_degree(l, J[1], J[l - 1]) end
  for l = 1, lmax do
    for m = -l, l do
      for n = -l, l do
        local v = J[l][m][n]
        local scaled = v * v * 4 ^ l * 3465
        local whole = math.floor(scaled + 0.5)
        assert(math.abs(scaled - whole) < 1e-5, "not the number that was expected")
        local s = math.sqrt(whole / (4 ^ l * 3465))
        J[l][m][n] = v < 0 and -s or s
      end
    end
  end
  return J
end

local function var(prefix, m)
  return m < 0 and prefix .. "n" .. -m or prefix .. m
end

--- Statements that turn variables `from` into `to` about z by angle `which`.
local function z_turn(emit, l, from, to, which, kind)
  kind = kind or "real"
  emit("%s %s = %s;", kind, var(to, 0), from(0))
  for m = 1, l do
    emit("%s %s = c%s%d * %s - s%s%d * %s;", kind, var(to, m), which, m, from(m), which, m, from(-m))
    emit("%s %s = s%s%d * %s + c%s%d * %s;", kind, var(to, -m), which, m, from(m), which, m, from(-m))
  end
  return 6 * l
end

local function quarter(emit, l, J, from, to, kind)
  local operations = 0
  for m = -l, l do
    local terms = {}
    for n = -l, l do
      local v = J[l][m][n]
      if v ~= 0 then
        local name = var(from, n)
        if v == 1 then terms[#terms + 1] = " + " .. name
        elseif v == -1 then terms[#terms + 1] = " - " .. name
        else terms[#terms + 1] = (" %s (real)%.17g * %s"):format(v < 0 and "-" or "+", math.abs(v), name) end
        operations = operations + 2
      end
    end
    emit("%s %s = %s;", kind or "real", var(to, m), (table.concat(terms):gsub("^ %+ ", ""):gsub("^ %- ", "-")))
  end
  return operations
end

local function one(lmax, J)
  local lines, operations = {}, 0
  local function emit(format, ...) lines[#lines + 1] = "  " .. format:format(...) end
  emit("const real ca1 = cs[0], sa1 = cs[1], cb1 = cs[2], sb1 = cs[3], cc1 = cs[4], sc1 = cs[5];")
  if lmax == 0 then emit("(void)ca1, (void)sa1, (void)cb1, (void)sb1, (void)cc1, (void)sc1;") end
  for m = 2, lmax do
    local a = math.floor(m / 2)
    local b = m - a
    for _, w in ipairs { "a", "b", "c" } do
      emit("const real c%s%d = c%s%d * c%s%d - s%s%d * s%s%d, s%s%d = c%s%d * s%s%d + s%s%d * c%s%d;",
        w, m, w, a, w, b, w, a, w, b, w, m, w, a, w, b, w, a, w, b)
      operations = operations + 6
    end
  end
  emit("g[0] = f[0];")
  for l = 1, lmax do
    local at = l * (l + 1)
    emit("{")
    operations = operations + z_turn(emit, l, function(m) return ("f[%d]"):format(at + m) end, "x", "c")
    operations = operations + quarter(emit, l, J, "x", "y")
    operations = operations + z_turn(emit, l, function(m) return var("y", m) end, "z", "b")
    operations = operations + quarter(emit, l, J, "z", "w")
    emit("g[%d] = w0;", at)
    for m = 1, l do
      emit("g[%d] = ca%d * %s - sa%d * %s;", at + m, m, var("w", m), m, var("w", -m))
      emit("g[%d] = sa%d * %s + ca%d * %s;", at - m, m, var("w", m), m, var("w", -m))
    end
    operations = operations + 6 * l
    emit("}")
  end
  return table.concat(lines, "\n"), operations
end

--- Degree l of rows in lanes; `halves`: rows hold m >= 0 alone, in h.
local function each(l, J, halves)
  local lines = {}
  local function emit(format, ...) lines[#lines + 1] = "  " .. format:format(...) end
  for i, which in ipairs { "a", "b", "c" } do
    for m = 1, l do
      emit("const vreal c%s%d = vreal_load(a->c[%d][%d] + k), s%s%d = vreal_load(a->s[%d][%d] + k);", which, m, i - 1, m,
        which, m, i - 1, m)
    end
  end
  if halves then
    emit("vreal x0 = vreal_load(h + k);")
    for m = 1, l do
      emit("const vreal h%d = vreal_load(h + %d * TILE + k);", m, m)
      emit("vreal x%d = cc%d * h%d, xn%d = sc%d * h%d;", m, m, m, m, m, m)
    end
  else
    for m = -l, l do emit("const vreal %s = vreal_load(x + %d * TILE + k);", var("f", m), l + m) end
    z_turn(emit, l, function(m) return var("f", m) end, "x", "c", "vreal")
  end
  quarter(emit, l, J, "x", "y", "vreal")
  z_turn(emit, l, function(m) return var("y", m) end, "z", "b", "vreal")
  quarter(emit, l, J, "z", "w", "vreal")
  z_turn(emit, l, function(m) return var("w", m) end, "g", "a", "vreal")
  for m = -l, l do emit("vreal_store(x + %d * TILE + k, %s);", l + m, var("g", m)) end
  return ("static void each_low%s%d(const each_angles *a, %sreal *x) {\n  for (int k = 0; k < TILE; k += LANES) {\n%s\n  }\n}\n")
    :format(halves and "_half" or "", l, halves and "const real *h, " or "", table.concat(lines, "\n"))
end

--- The text of the file about rows with rotations of their own.
local function each_text()
  local J, out = quarter_turns(LMAX), {}
  for l = 1, LMAX do
    out[#out + 1] = each(l, J, false)
    out[#out + 1] = each(l, J, true)
  end
  local function list(name, arguments)
    local names = {}
    for l = 1, LMAX do names[l] = name .. l end
    return ("static void (*const %s[EACH_STRAIGHT + 1])(%s) = {\n  0, %s};\n"):format(name, arguments, table.concat(names, ", "))
  end
  return ("/* GENERATED by lua/ylm/codegen/rotate.lua; do not edit. Degrees of rows that have rotations of their own, for\n"
    .. "   rotate/rotate_each.h: x [2l+1][TILE] is turned in place, or made of h [l+1][TILE], whose m are >= 0. */\n\n"
    .. '#include "../rotate/rotate_angles.h"\n\n#define EACH_STRAIGHT %d\n\n'):format(LMAX) .. table.concat(out, "\n") .. "\n"
    .. list("each_low", "const each_angles *, real *") .. list("each_low_half", "const each_angles *, const real *, real *")
end

--- The text of a generated file: about one vector, or with "each" about rows.
function rotate.text(which)
  if which == "each" then return each_text() end
  local J = quarter_turns(LMAX)
  local out = {}
  for lmax = 0, LMAX do
    local body, operations = one(lmax, J)
    out[#out + 1] = ("/* lmax %d: %d operations */\nstatic void rotate_low%d(const real *restrict cs, const real *restrict f, "
      .. "real *restrict g) {\n%s\n}\n"):format(lmax, operations, lmax, body)
  end
  local names = {}
  for lmax = 0, LMAX do names[#names + 1] = ("rotate_low%d"):format(lmax) end
  return ("/* GENERATED by lua/ylm/codegen/rotate.lua; do not edit. Rotation of one vector, included by\n"
    .. "   rotate/rotate_one.h for the unit's element type. cs: cosine and sine of a+pi, b+pi, c. */\n\n"
    .. "#define ROTATE_LOW %d\n\n")
    :format(LMAX) .. table.concat(out, "\n")
    .. ("\nstatic void (*const rotate_low[ROTATE_LOW + 1])(const real *restrict, const real *restrict, real *restrict) = {"
    .. "\n  %s};\n")
    :format(table.concat(names, ", "))
end

return rotate
