-- Sums over lights on every Vulkan device: ns per light x point pair and the part of the device's measured
-- multiply-add and bandwidth peaks. Merged moments stand beside the papers' product rule with its loops forward and reversed.
--
--     make bench-vulkan
--
-- The task is Table 2 of Mezieres et al. 2022: 8^3 grid points, 648 spheres or as many triangles approximated by spheres
-- times a cosine, values and gradients, one channel, 5 to 9 bands (lmax 4 to 8); its milliseconds stand beside (RTX 2080,
-- GLSL). BENCH=quick takes the best of 3, not of 25.

local bench_lamps = require "spec.bench.lamps"
local moments = require "ylm.codegen.moments_glsl"
local product = require "ylm.codegen.product_glsl"
local ylm = require "ylm"

local LIGHTS, EDGE = 648, 8
local paper = { [4] = { 4.08, 2.22 }, [5] = { 5.98, 2.96 }, [6] = { 7.24, 3.77 }, [7] = { 12.73, 4.76 },
  [8] = { 22.26, 5.18 } } -- forward, reversed
local paper_flat = { [4] = 2.53, [5] = 3.39, [6] = 4.42, [7] = 5.35, [8] = 5.74 } -- "our approx.", reversed
local TIMES = os.getenv "BENCH" == "quick" and 3 or 25
local COSINE = 35 -- and for |cos gamma| with its gradient
local GEOMETRY = 40 -- operations per light before the generated ones: about, from shaders/moments.real.comp

--- Numbers in 0 .. 1, the same everywhere.
local state = 12345
local function random()
  state = state * 48271 % 2147483647
  return state / 2147483647
end

local at, radius, triangles, exact = {}, {}, {}, {}
for i = 1, LIGHTS do
  at[i], radius[i] = { 4 * random() - 2, 4 * random() - 2, 4 * random() - 2 }, 0.01 + 0.04 * random()
end
for i = 1, LIGHTS do
  local v = {}
  for k = 1, 3 do
    v[k] = { at[i][1] + 0.1 * random() - 0.05, at[i][2] + 0.1 * random() - 0.05, at[i][3] + 0.1 * random() - 0.05 }
  end
  triangles[i] = ylm.polygon_light { vertices = v, method = "sphere" }
  exact[i] = ylm.polygon_light { vertices = v }
end
local lamps = ylm.sphere_lights { at = at, radius = radius }
local points = ylm.zeros({ EDGE ^ 3, 3 }, "float")
for i = 0, EDGE ^ 3 - 1 do
  local k = { i % EDGE, math.floor(i / EDGE) % EDGE, math.floor(i / EDGE ^ 2) }
  for a = 1, 3 do points:set(i + 1, a, 2 * k[a] / (EDGE - 1) - 1) end
end

--- Seconds on the device of one evaluation, by stage: of the least of `times`; the first, which compiles, left out.
local function seconds(gpu, lights, lmax, o, times)
  local best
  for i = 0, times do
    if i == 1 then bench_lamps.wake(gpu) end
    local before = lights.stages
    ylm.light_field(lmax, lights, points, o)
    local sum, sums = 0, 0
    for stage, t in pairs(lights.stages) do
      if stage ~= "upload" and stage ~= "download" then
        local s = t.seconds - (before[stage] and before[stage].seconds or 0)
        sum, sums = sum + s, stage == "lights" and s or sums
      end
    end
    if i > 0 and (not best or sum < best[1]) then best = { sum, sums } end
  end
  return best[1], best[2]
end

--- The peaks of a device, the best of five, as times are the least of many; nil, message.
local function peaks(gpu)
  local flops, bytes = gpu:peak()
  for _ = 1, flops and 4 or 0 do
    local f, b = gpu:peak()
    flops, bytes = math.max(flops, f), math.max(bytes, b)
  end
  return flops, bytes
end

local function bench(gpu)
  local flops, bytes = peaks(gpu)
  if not flops then return print(gpu.name .. ": " .. tostring(bytes)) end
  print(("%s (%s): %.1f Gflop/s, %.1f GB/s measured"):format(gpu.name, gpu.type, flops / 1e9, bytes / 1e9))
  if gpu.type == "cpu" then print "a driver in software: its figures say nothing of a GPU" end
  local pairs_ = LIGHTS * EDGE ^ 3
  --- The lights in the device's memory, by method.
  local function there(lights)
    local l = {}
    for _, method in ipairs { "merged", "forward", "reversed" } do l[method] = gpu:lights(lights, { method = method }) end
    return l
  end
  local chunk = gpu.type == "cpu" and 256 or 16 -- lights that a group sums: chunk_of in csrc/vulkan/light/lights.c
  --- Bytes of "lights": a light's numbers for each group of 64 points, `passes` times, and a chunk's sums for each point.
  local function moved(numbers, passes, kept)
    return 4 * (pairs_ / 64 * numbers * passes + math.ceil(LIGHTS / chunk) * EDGE ^ 3 * kept)
  end
  local function cell(lights, lmax, o, operations, bytes_moved)
    local all, sums = seconds(gpu, lights, lmax, o, TIMES)
    return ("%8.2f %5.2f %3.0f%% %3.0f%%"):format(all * 1e3, sums / pairs_ * 1e9,
      100 * (operations + GEOMETRY) * pairs_ / sums / flops, 100 * bytes_moved / sums / bytes)
  end
  local spheres, flat = there(lamps), there(triangles)
  print(("%d points x %d lights, float, values and gradients; ms of all stages, sums alone: ns a pair, %% of both peaks")
    :format(EDGE ^ 3, LIGHTS))
  print "spheres\nlmax |                 merged |                forward |               reversed | 2022 forw.  rev. (ms)"
  local o = { derivatives = 1, channels = "luminance" }
  for lmax = 4, 8 do
    local p = product.operations(lmax, 1)
    local n, kept = (lmax + 1) ^ 2, (lmax + 1) ^ 2 + (lmax + 2) ^ 2 - 1
    print(("%4d | %s | %s | %s | %10.2f %5.2f"):format(lmax,
      cell(spheres.merged, lmax, o, moments.operations(lmax, 3), moved(8, 1, kept)),
      cell(spheres.forward, lmax, o, p, moved(8, 1, 4 * n)), cell(spheres.reversed, lmax, o, p, moved(8, lmax + 1, 4 * n)),
      paper[lmax][1], paper[lmax][2]))
  end
  print("triangles as spheres x |cos gamma|\nlmax |                 merged |                forward |               reversed | "
    .. "2022  rev. (ms)")
  for lmax = 4, 8 do
    -- a sum of values becomes four, by multiply-adds; the product rule multiplies each part, and adds three products
    local n, p = (lmax + 1) ^ 2, product.operations(lmax, 1) + 10 * (lmax + 1) ^ 2 + COSINE
    print(("%4d | %s | %s | %s | %10.2f"):format(lmax,
      cell(flat.merged, lmax, o, moments.operations(lmax, 3) + 7 * n + (lmax + 2) ^ 2 - 1 + COSINE,
        moved(12, 1, 4 * n + (lmax + 2) ^ 2 - 1)),
      cell(flat.forward, lmax, o, p, moved(12, 1, 4 * n)), cell(flat.reversed, lmax, o, p, moved(12, lmax + 1, 4 * n)),
      paper_flat[lmax]))
  end
  local rims = gpu.limits.float64 and gpu:lights(exact)
  if rims then
    print "triangles, exact (in double, points and results in float)\nlmax |      ms, ns a pair | with the metric"
    local slow = gpu.type == "cpu" -- seconds each there
    for lmax = 4, slow and 4 or 8 do
      local times = slow and 1 or TIMES
      local all, sums = seconds(gpu, rims, lmax, o, times)
      local more, more_sums = seconds(gpu, rims, lmax, { derivatives = 1, channels = "luminance", metric = "luminance" }, times)
      print(("%4d | %8.2f %8.2f | %8.2f %8.2f"):format(lmax, all * 1e3, sums / pairs_ * 1e9, more * 1e3,
        more_sums / pairs_ * 1e9))
    end
    rims:close()
  end
  print "spheres: values, gradients and the metric, luminance (what a bake asks for)"
  for _, lmax in ipairs { 4, 8 } do
    print(("%4d | %s"):format(lmax, cell(spheres.merged, lmax,
      { derivatives = 1, channels = "luminance", metric = "luminance" }, moments.operations(lmax, 7),
      moved(8, 1, (lmax + 1) ^ 2 + (lmax + 2) ^ 2 - 1 + (lmax + 3) ^ 2 - 3))))
  end
  for _, lights in ipairs { spheres, flat } do for _, l in pairs(lights) do l:close() end end
end

local devices, message = ylm.vulkan.devices()
if not devices then
  print(message)
  os.exit(0)
end
for i, d in ipairs(devices) do
  if d.usable then
    local gpu = assert(ylm.vulkan.open { device = i })
    bench(gpu)
    gpu:close()
  end
end
