--- ylm.sh.eval and ylm.sh.reconstruct: basis functions, and functions that coefficients stand for, at points.

local args = require "ylm.sh.args"
local array = require "ylm.array"
local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local devices = require "ylm.device"
local form = require "ylm.form"
local outputs = require "ylm.outputs"

local eval = {}

local eval_options = {
  { "derivatives", "integer", min = 0, max = 2, default = 0, about = "1: also gradients, 2: also Hessians" },
  { "solid", "boolean", default = false, about = "solid harmonics |v|^l Y; points may then be zero" },
  { "dtype", "choice", of = core.choices "dtype", optional = true,
    about = "of the results; default: that of the points, double for tables" },
  { "method", "choice", shelf = "comparison", of = core.choices "sh_method", default = "solid",
    about = "the others are kept for comparison, in libylm_rival; they may be singular at the poles" },
  { "kernel", "choice", of = core.choices "isa", optional = true,
    about = "the kernel set; default: the one in ylm.info().kernel" },
  form.threads,
  { "device", "gpu", optional = true,
    about = "a gpu of ylm.vulkan.open that computes instead; float to lmax 128, the method is solid" },
  { "out", "any", optional = true,
    about = "an array for the values, or a list of arrays {Y, dY, ddY}, to be written and returned" },
  { "progress", "progress", optional = true },
}

--- The shape of the results of order k (0 values, 1 gradients, 2 Hessians).
local function shape_of(single, n, count, k)
  local shape = single and { count } or { n, count }
  if k > 0 then shape[#shape + 1] = k == 1 and 3 or 6 end
  return shape
end

--- Arrays for the results of orders 0 .. derivatives; nil, message, code where memory runs out.
local function results(options, single, n, count, dtype, points)
  local shapes, arrays = {}, {}
  for k = 0, options.derivatives do shapes[k + 1] = shape_of(single, n, count, k) end
  local given = { outputs.of(3, "eval", options.out, dtype, shapes, points) }
  for k, shape in ipairs(shapes) do
    arrays[k] = given[k]
    if not arrays[k] then
      local message, code
      arrays[k], message, code = check.result("eval", core.array_zeros(shape, dtype))
      if not arrays[k] then return nil, message, code end
    end
  end
  return arrays
end

--- The element type of a points argument.
local function dtype_of(points, asked)
  if asked then return asked end
  return array.type_of(points, "double")
end

describe "sh.eval" {
  shelf = "everyday",
  about = "Evaluates every basis function of degree <= lmax at points, with derivatives.\n"
    .. "Y is taken at v/|v|, its derivatives are those of Y(v/|v|) with respect to v; exact at the poles too.",
  arguments = {
    { "lmax", "integer", "highest degree, from 0 to 1000" },
    { "points", "array|table", "[n][3], or one {x, y, z}; any length but 0" },
    { "options?", "table", "see the options" },
  },
  options = eval_options,
  returns = {
    { "Y", "array", "[n][(lmax+1)^2]" },
    { "dY", "array", "[n][(lmax+1)^2][3], with derivatives = 1 or 2" },
    { "ddY", "array", "[n][(lmax+1)^2][6]: xx xy xz yy yz zz, with derivatives = 2" },
  },
  errors = "raises on zero and non-finite points, naming the row, and where results are not representable; "
    .. "nil, message, code where memory runs out, progress cancels, a device fails or libylm_rival is missing",
  example = [[
local Y, dY = ylm.sh.eval(4, { { 0, 0, 1 }, { 1, 2, 3 } }, { derivatives = 1 })
assert(#Y == 2 and Y.shape[2] == 25 and dY.shape[3] == 3)]],
  source = "Iwasaki & Dobashi 2025, Eqs. 10-17; docs/math.md",
}
function eval.eval(lmax, points, options)
  check.integer(1, "eval", "lmax", lmax, 0, core.limits.sh_lmax)
  options = form.options(3, "eval", eval_options, options)
  local dtype = dtype_of(points, options.dtype)
  local p, single = array.points(2, "eval", points, dtype)
  local n, count = core.array_info(p)[1], (lmax + 1) * (lmax + 1)
  local out, message, code = results(options, single, n, count, dtype, p)
  if not out then return nil, message, code end
  local ok
  ok, message, code = devices.of(options.device):harmonics(lmax, p, out, options)
  if not ok then return nil, message, code end
  return out[1], out[2], out[3]
end

local reconstruct_options = { form.threads, args.out, args.progress }

describe "sh.reconstruct" {
  shelf = "everyday",
  about = "The functions that coefficients stand for, at points: sum over k of c_k Y_k(v/|v|).",
  arguments = {
    { "c", "array|table", "[..][(lmax+1)^2], in ylm's own convention" },
    { "points", "array|table", "[m][3], or one {x, y, z}; any length but 0" },
    { "options?", "table", "see the options" },
  },
  options = reconstruct_options,
  returns = { { "f", "array|number", "[..][m]; one point: [..]; one row of c and one point: a number" } },
  errors = "raises where the number of coefficients is no square, on zero and non-finite points, on mixed conventions",
  example = [[
local f = ylm.sh.reconstruct({ 0, 0, 1, 0 }, { { 0, 0, 1 }, { 0, 0, -2 } })
assert(math.abs(f[1] - math.sqrt(3 / (4 * math.pi))) < 1e-15 and f[2] == -f[1])]],
  source = "Green 2003, Eq. 9",
}
function eval.reconstruct(c, points, options)
  return args.reconstruct("reconstruct", c, points, form.options(3, "reconstruct", reconstruct_options, options))
end

return eval
