--- Files of probes as their engines read them: { reader, grids: { lattice, probes } }, of ylm.grid.engine.

local array = require "ylm.array"
local bytes = require "ylm.array.bytes"
local check = require "ylm.check"
local core = require "ylm.c.core"
local engine = require "ylm.grid.engine"
local sh = require "ylm.sh"

local read = {}

local MOST_CELLS, MOST_BYTES = 4096, 2 ^ 30
local KTX2_HEADER = 104 -- bytes, with the index of one level

local function bad(path, message, ...) return nil, path .. ": " .. message:format(...), "EFORMAT" end

--- The text of a file; or nil, message, code.
local function text_of(path)
  local file, message = io.open(path, "rb")
  if not file then return nil, tostring(message), "EIO" end
  local size = file:seek "end"
  if not size or size > MOST_BYTES then
    file:close()
    return bad(path, "no file of probes: it is %s", size and "too large" or "no file")
  end
  file:seek "set"
  local text = file:read "*a"
  file:close()
  if not text then return nil, path .. " cannot be read", "EIO" end
  return text
end

local function is_finite(x) return x and x == x and math.abs(x) < math.huge end

local function all_finite(a) return is_finite((a * 0):sum()) end

--- A lattice whose numbers make sense; else nil.
local function lattice_of(lo, hi, cells)
  for a = 1, 3 do
    local n = cells[a]
    if not (is_finite(lo[a]) and is_finite(hi[a]) and lo[a] < hi[a]) then return nil end
    if not (n and n >= 2 and n <= MOST_CELLS and n == math.floor(n)) then return nil end
  end
  return { lo = lo, hi = hi, cells = cells }
end

--- Three numbers that follow a name in JSON.
local function triple(text, name)
  local x, y, z = text:match('"' .. name .. '"%s*:%s*%[%s*([^,%s]+)%s*,%s*([^,%s]+)%s*,%s*([^%]%s]+)%s*%]')
  return { tonumber(x), tonumber(y), tonumber(z) }
end

--- One of three.js' grids; or nil, message, code.
local function three_grid(path, text)
  local lattice = lattice_of(triple(text, "min"), triple(text, "max"), triple(text, "resolution"))
  if not lattice then return bad(path, "min, max and resolution of a grid of probes expected") end
  local nx, ny, nz = lattice.cells[1], lattice.cells[2], lattice.cells[3]
  local data = core.page_unbase64(text:match '"data"%s*:%s*"([^"]*)"' or "")
  local size = 8 * nx * ny * 7 * (nz + 2)
  if not data or #data ~= size then
    return bad(path, "data: %d bytes in base64 expected, of %d x %d x %d probes", size, nx, ny, nz)
  end
  local slices = array.array(bytes.frombytes(data, { 7, nz + 2, ny, nx, 4 }, "float16"), "float")
  if not all_finite(slices) then return bad(path, "a number of its probes is not finite") end
  local numbers = array.zeros({ nz, ny, nx, 28 }, "float")
  for volume = 0, 6 do
    numbers[{ {}, {}, {}, { 4 * volume + 1, 4 * volume + 4 } }] = slices[{ volume + 1, { 2, nz + 1 } }]
  end
  local c = array.array(numbers[{ {}, {}, {}, { 1, 27 } }], "float"):reshape { nx * ny * nz, 9, 3 }
  return { lattice = lattice, probes = array.array(sh.convert(c, "ylm", { from = "three.js" }), "float") }
end

local function three(path, text)
  local grids = {}
  for one in text:gmatch '"LightProbeGrid".-"data"%s*:%s*"[^"]*"' do
    local grid, message, code = three_grid(path, one)
    if not grid then return nil, message, code end
    grids[#grids + 1] = grid
  end
  if not grids[1] then return bad(path, "no LightProbeGrid is in it") end
  return { reader = engine.coefficients(2, 0.5), grids = grids, boxed = true }
end

local function integer(text, at, count)
  local x = 0
  for i = count, 1, -1 do x = x * 256 + (text:byte(at + i) or 0) end
  return x
end

--- Six numbers of text.
local function six(text)
  local list = {}
  for word in (text or ""):gmatch "[^,]+" do list[#list + 1] = tonumber(word) end
  return { list[1], list[2], list[3] }, { list[4], list[5], list[6] }
end

local function cubes(path, text, o)
  if text:sub(1, 12) ~= "\171KTX 20\187\r\n\26\n" or #text < KTX2_HEADER or integer(text, 12, 4) ~= 97 then
    return bad(path, "a KTX 2 file of halves, red green blue alpha, expected")
  end
  local lo, hi = six(text:match "ylm%.bounds%z([^%z]+)%z")
  if o.bounds then lo, hi = o.bounds[1], o.bounds[2] end
  local w, h, d = integer(text, 20, 4), integer(text, 24, 4), integer(text, 28, 4)
  local lattice = lattice_of(lo, hi, { w, h / 2, d / 3 })
  if not lattice then return bad(path, "an irradiance volume expected: w x 2 h x 3 d texels, and ylm.bounds or bounds") end
  local at, size = integer(text, 80, 8), integer(text, 88, 8)
  if size ~= 8 * w * h * d or at + size > #text then return bad(path, "%d bytes of texels expected", 8 * w * h * d) end
  local n = lattice.cells
  local texels = array.array(bytes.frombytes(text:sub(at + 1, at + size), { 3, n[3], 2, n[2], n[1], 4 }, "float16"), "float")
  local probes = array.zeros({ n[3], n[2], n[1], 3, 6 }, "float")
  for axis = 1, 3 do
    for side = 0, 1 do
      for c = 1, 3 do probes[{ {}, {}, {}, c, axis + 3 * side }] = texels[{ axis, {}, side + 1, {}, {}, c }] end
    end
  end
  return { reader = engine.cube, grids = { { lattice = lattice, probes = probes:reshape { n[1] * n[2] * n[3], 3, 6 } } } }
end

local function coefficients(path, _, o)
  local a, message, code = check.result("judge", core.array_read(path))
  if not a then return nil, message, code end
  local shape = a.shape
  local lmax = #shape == 5 and math.floor(math.sqrt(shape[5]) + 0.5) - 1 or -1
  if lmax < 0 or (lmax + 1) ^ 2 ~= shape[5] or lmax > 20 or shape[4] ~= 1 and shape[4] ~= 3 then
    return bad(path, "[nz][ny][nx][1 or 3][(lmax+1)^2] expected")
  end
  local lattice = o.bounds and lattice_of(o.bounds[1], o.bounds[2], { shape[3], shape[2], shape[1] })
  if not lattice then return bad(path, "bounds, the box of its cells, are wanted; of these 2 to 4096 along each axis") end
  return { reader = engine.coefficients(lmax, o.offset or 0),
    grids = { { lattice = lattice, probes = array.array(a, "float"):reshape { #a * shape[2] * shape[3], shape[4], shape[5] } } } }
end

--- Probes of ylm: { bricks }.
local function bricks(path, text)
  local file, message, code = check.result("judge", core.probes_decode(text, path))
  if not file then return nil, message, code end
  return { bricks = file, grids = {} }
end

local kinds = { { "%.ylmp$", bricks }, { "%.three%.json$", three }, { "%.ktx2$", cubes }, { "%.npy$", coefficients } }

--- Is it the name of such a file?
function read.is_name(path)
  for _, kind in ipairs(kinds) do if path:lower():find(kind[1]) then return true end end
  return false
end

--- The probes of a file, with `bytes`; o: { bounds, offset } of those that do not say them. Or nil, message, code.
function read.file(path, o)
  local text, message, code = text_of(path)
  if not text then return nil, message, code end
  for _, kind in ipairs(kinds) do
    if path:lower():find(kind[1]) then
      local probes
      probes, message, code = kind[2](path, text, o)
      if not probes then return nil, message, code end
      for _, grid in ipairs(probes.grids) do
        if not all_finite(grid.probes) then return bad(path, "a number of its probes is not finite") end
      end
      probes.bytes = #text
      return probes
    end
  end
end

return read
