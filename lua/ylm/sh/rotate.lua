--- ylm.sh.rotate and ylm.sh.rotation.

local args = require "ylm.sh.args"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local memory = require "ylm.memory"
local progress = require "ylm.progress"

local rotate = {}

local methods = core.metatable "ylm.sh_rotation"

-- Plans are immutable and depend on lmax alone; kept while the state lives.
local plans = {}
local sizes = { 6, 15, 31, 63, core.limits.sh_rotate_lmax }

--- A plan of degree lmax or more; nil, message, code where memory runs out.
local function plan(lmax)
  for _, size in ipairs(sizes) do
    if size >= lmax then
      if not plans[size] then
        local p, message, code = core.sh_rotator(size)
        if not p then return nil, message, code end
        plans[size] = p
      end
      return plans[size]
    end
  end
end

--- n finite numbers from a table or a small array, flattened; nil if there are none such.
local function numbers(value, n)
  value = check.plain(value)
  if type(value) ~= "table" then return nil end
  local flat = {}
  for _, x in ipairs(value) do
    if type(x) == "table" then
      for _, y in ipairs(x) do flat[#flat + 1] = y end
    else flat[#flat + 1] = x end
  end
  if #flat ~= n then return nil end
  for i = 1, n do if not check.is_number(flat[i]) then return nil end end
  return flat
end

local wanted = "3x3 rotation, {axis =, angle =}, {quaternion = {w, x, y, z}} or {zyz = {a, b, c}} expected, got %s"

--- A rotation argument as nine numbers, row by row.
local function matrix_of(n, name, value)
  local kind, flat
  if type(value) == "table" and not form.kind(value) and value[1] == nil then
    local given = {}
    for key in pairs(value) do given[#given + 1] = tostring(key) end
    table.sort(given)
    local keys = table.concat(given, " ")
    if keys == "angle axis" and check.is_number(value.angle) then
      kind, flat = "axis", numbers(value.axis, 3)
      if flat then flat[4] = value.angle end
    elseif keys == "quaternion" then kind, flat = "quaternion", numbers(value.quaternion, 4)
    elseif keys == "zyz" then kind, flat = "zyz", numbers(value.zyz, 3)
    else
      local guess
      for _, key in ipairs(given) do guess = guess or check.guess(key, { "axis", "angle", "quaternion", "zyz" }) end
      return check.bad(n, name, wanted .. "%s", keys == "" and "an empty table" or "{" .. check.short(keys) .. "}",
        guess and (" (did you mean '%s'?)"):format(guess) or "")
    end
    if not flat then return check.bad(n, name, "finite numbers expected in {%s}", keys) end
  else
    kind, flat = "matrix", numbers(value, 9)
    if not flat then return check.bad(n, name, wanted, check.describe(value)) end
  end
  local r, message = core.sh_rotation_matrix(kind, flat)
  if not r then return check.bad(n, name, "%s", message) end
  return r
end

local rotation_options = {
  { "dtype", "choice", of = core.choices "dtype", default = "double", about = "of the arrays it will be applied to" },
}

describe "sh.rotation" {
  about = "A rotation of coefficients up to lmax, built once and applied to many: its blocks, one matrix per degree.",
  arguments = {
    { "lmax", "integer", "highest degree, from 0 to 128" },
    { "r", "table|array", "3x3 matrix that turns vectors, {axis = {x, y, z}, angle =}, {quaternion = {w, x, y, z}} "
      .. "or {zyz = {a, b, c}} for Rz(a) Ry(b) Rz(c); radians" },
    { "options?", "table", "see the options" },
  },
  options = rotation_options,
  returns = { { "rotation", "sh_rotation", "for sh.rotate; rotation.lmax, .dtype, .matrix, rotation:block(l)" } },
  errors = "raises where r is no rotation",
  example = [[
local quarter = ylm.sh.rotation(2, { axis = { 0, 0, 1 }, angle = math.pi / 2 })
local c = ylm.sh.rotate({ 0, 0, 0, 1, 0, 0, 0, 0, 0 }, quarter)   -- -x becomes -y
assert(c[2] == 1 and c[4] == 0)]],
  source = "Ivanic & Ruedenberg 1996, 1998; Pinchon & Hoggan 2007",
}
function rotate.rotation(lmax, r, options)
  check.integer(1, "rotation", "lmax", lmax, 0, core.limits.sh_rotate_lmax)
  options = form.options(3, "rotation", rotation_options, options)
  local matrix = matrix_of(2, "rotation", r)
  local p, message, code = plan(lmax)
  if not p then return nil, message, code end
  local object
  object, message, code = check.result("rotation", core.sh_rotation(p, matrix, lmax, options.dtype))
  if not object then return nil, message, code end
  core.own(object).about = { lmax = lmax, dtype = options.dtype,
    matrix = { { matrix[1], matrix[2], matrix[3] }, { matrix[4], matrix[5], matrix[6] },
      { matrix[7], matrix[8], matrix[9] } } }
  return object
end

--- The arguments that a rotation object was made from.
local function about_of(r) return core.owned(r, "about") end

methods.__index = function(r, key)
  local about = about_of(r)
  return about and about[key] or rawget(methods, key)
end

methods.__tostring = function(r)
  local about = about_of(r)
  return ("ylm.sh_rotation lmax %d %s"):format(about.lmax, about.dtype)
end

describe "sh_rotation:block" {
  about = "The matrix of one degree: coefficients of degree l are multiplied by it from the left.",
  arguments = { { "l", "integer", "degree, up to the rotation's lmax" } },
  returns = { { "M", "array", "[2l+1][2l+1], m = -l first" } },
  errors = "raises where l is out of range",
  example = [[
local r = ylm.sh.rotation(3, { axis = { 0, 0, 1 }, angle = 0 })
assert(r:block(1):get(2, 2) == 1 and r:block(1):get(1, 2) == 0)]],
}
function methods.block(r, l)
  if core.type(r) ~= "ylm.sh_rotation" then
    return check.fail("block: a rotation expected before the colon, got %s", check.describe(r))
  end
  check.integer(1, "block", "l", l, 0, about_of(r).lmax)
  local out = assert(core.array_zeros({ 2 * l + 1, 2 * l + 1 }, "double"))
  assert(core.sh_rotation_block(r, l, out))
  return out
end

local rotate_options = {
  { "method", "choice", shelf = "comparison", of = { "fast", "reference" }, default = "fast",
    about = "reference: the recurrence of Ivanic & Ruedenberg, slow; it is 1e-14 off at degree 64, 1e-8 at 128" },
  form.threads, { "out", "array", optional = true, about = "the array to be written and returned; may be c" },
  args.progress,
}

--- The reference: blocks of the recurrence times each row.
local function by_reference(matrix, lmax, a, dtype, rows)
  local n = lmax + 1
  local blocks = assert(core.array_zeros({ n * (2 * n - 1) * (2 * n + 1) / 3 }, "double"))
  assert(core.sh_rotation_reference(matrix, lmax, blocks))
  local M, count = core.array_totable(blocks), n * n
  local c = core.array_totable(core.array_reshape(a, { rows, count }))
  local out = {}
  for i = 1, rows do
    local at, row = 0, {}
    for l = 0, lmax do
      local w = 2 * l + 1
      for q = 1, w do
        local sum = 0
        for m = 1, w do sum = sum + M[at + (q - 1) * w + m] * c[i][l * l + m] end
        row[l * l + q] = sum
      end
      at = at + w * w
    end
    out[i] = row
  end
  local result = assert(core.array_zeros({ rows, count }, dtype))
  core.array_fill(result, out)
  return result
end

--- Are these frames, [n][3][3], and not one matrix?
local function are_frames(x)
  if core.type(x) ~= "ylm.array" then return type(x) == "table" and type(x[1]) == "table" and type(x[1][1]) == "table" end
  local shape = core.array_info(x)
  return #shape == 3
end

--- The array of frames of argument 2 for coefficients whose first axis they follow.
local function frames_of(value, shape, lmax, dtype)
  local frames = array.rows(2, "rotate", "rotations", value, 3, dtype)
  local extents = core.array_info(frames)
  if #extents ~= 3 or extents[2] ~= 3 then
    return check.bad(2, "rotate", "rotations [n][3][3] expected, got %s", check.describe(frames))
  end
  if #shape < 2 or extents[1] ~= shape[1] then
    return check.bad(2, "rotate", "as many rotations as there are rows along the first axis of the coefficients expected: %d "
      .. "rotations, %d rows", extents[1], #shape < 2 and 1 or shape[1])
  end
  local most = core.limits.sh_rotate_each_lmax
  if lmax > most then return check.bad(1, "rotate", "lmax up to %d expected with a rotation for each row, got %d", most, lmax) end
  return frames
end

describe "sh.rotate" {
  shelf = "everyday",
  about = "Turns functions given by coefficients: the result at s is the argument at R^-1 s.\n"
    .. "Identity, quarter and half turns about the axes and their products are exact.",
  arguments = {
    { "c", "array|table", "[..][(lmax+1)^2], lmax up to 128" },
    { "rotation", "table|array|sh_rotation",
      "as for sh.rotation, or an object made by it, which is fastest for batches; or [n][3][3], one for each row along the "
      .. "first axis of c, lmax up to 60: columns are the axes of a frame, orthonormal to 1e-3" },
    { "options?", "table", "see the options" },
  },
  options = rotate_options,
  returns = { { "c", "array", "of the same shape, type and convention" } },
  errors = "raises where the rotation is none (its determinant is -1, say), or smaller than c, "
    .. "on coefficients of another system",
  example = [[
local up = { 0, 0, 1, 0 }                                             -- z
local c = ylm.sh.rotate(up, { axis = { 1, 0, 0 }, angle = math.pi / 2 }) -- z becomes -y
assert(c[2] == 1 and c[3] == 0)]],
  source = "Ivanic & Ruedenberg 1996, 1998; Pinchon & Hoggan 2007; Green 2003, appendix",
}
function rotate.rotate(c, rotation, options)
  options = form.options(3, "rotate", rotate_options, options)
  local a, lmax, shape, dtype, rows, convention, small = args.coefficients(1, "rotate", c, core.limits.sh_rotate_lmax)
  local object = core.type(rotation) == "ylm.sh_rotation" and rotation
  local frames = are_frames(rotation) and frames_of(rotation, shape, lmax, dtype)
  local matrix, p, out, message, code
  if object then
    local about = about_of(object)
    if about.lmax < lmax then
      return check.bad(2, "rotate", "rotation up to lmax %d, coefficients up to %d", about.lmax, lmax)
    end
    if about.dtype ~= dtype then
      matrix = {}
      for i = 1, 9 do matrix[i] = about.matrix[math.floor((i - 1) / 3) + 1][(i - 1) % 3 + 1] end
      object = nil
    end
  elseif not frames then matrix = matrix_of(2, "rotate", rotation) end
  if frames and options.method == "reference" then
    return check.fail "rotate: method 'reference' takes one rotation"
  elseif options.method == "reference" then
    if options.out then return check.fail("rotate: method 'reference' makes a new array, it takes no out") end
    if object then matrix = numbers(about_of(object).matrix, 9) end
    local result = core.array_reshape(by_reference(matrix, lmax, a, dtype, rows), shape)
    core.array_set_convention(result, convention)
    return args.held("rotate", result, small)
  end
  out, message, code = args.result("rotate", options.out, shape, dtype, convention, options.out ~= c and { a } or {})
  if not out then return nil, message, code end
  local ok
  if object then
    ok, message, code = core.sh_rotation_apply(object, lmax, a, out, options.threads, progress.of(options.progress))
  else
    p, message, code = plan(lmax)
    if not p then return nil, message, code end
    if frames then
      ok, message, code = core.sh_rotate_each(p, frames, lmax, a, out, options.threads, progress.of(options.progress))
    else ok, message, code = core.sh_rotate(p, matrix, lmax, a, out, options.threads, progress.of(options.progress)) end
  end
  if not ok then return check.result("rotate", nil, message, code) end
  return args.held("rotate", out, small)
end

memory.publish(methods)

return rotate
