-- ylm sh: environments with closed forms, conventions by their own formulas, code that evaluates to the same numbers.

local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"
local ylm = require "ylm"

local pi = math.pi
local directions = { { 0.36, 0.48, 0.8 }, { -0.6, 0, 0.8 }, { 0.48, -0.64, -0.6 }, { 0, 1, 0 }, { 0, 0, -1 } }

local function dot(a, b)
  local sum = 0
  for i = 1, #a do sum = sum + a[i] * b[i] end
  return sum
end

local function legendre(l, x) return l == 0 and 1 or l == 1 and x or (3 * x * x - 1) / 2 end

-- Three environments, one a channel: a constant, a lobe, two suns; { direction, weight of P_0, of P_1, of P_2 } of degrees to 2.
local lobe, sun_a, sun_b = { 0.48, 0.6, 0.64 }, { 0.8, 0.6, 0 }, { -0.36, 0.48, -0.8 }

--- exp(k (cos - 1)) in Legendre polynomials: (2l+1)/2 times its integrals.
local function sun(direction, k, scale)
  local all = (1 - math.exp(-2 * k)) / k
  local mean = 1 / math.tanh(k) - 1 / k
  return { direction, scale * all / 2, scale * all * 3 / 2 * mean, scale * all * 5 / 2 * (1 - 3 * mean / k) }
end
math.tanh = math.tanh or function(x) return (1 - math.exp(-2 * x)) / (1 + math.exp(-2 * x)) end -- luacheck: ignore

local parts = {
  { { { 0, 0, 1 }, 0.7, 0, 0 } },
  { { lobe, 1, 0.8, 0.5 } },
  { sun(sun_a, 60, 40), sun(sun_b, 200, 100) },
}

--- The closed form of degrees to 2 at v, each degree times its factor.
local function closed(channel, v, factor)
  local sum = 0
  for _, p in ipairs(parts[channel]) do
    for l = 0, 2 do sum = sum + (factor and factor[l + 1] or 1) * p[l + 2] * legendre(l, dot(p[1], v)) end
  end
  return sum
end

local function environment(path, size, mapping, up)
  local image = ylm.image { size = size }
  local d = image:directions { mapping = mapping, up = up }
  local e = math.exp(1)
  local function cosine(v) return (d * v):sum(2) end
  local x = cosine(lobe)
  local values = ylm.stack({ 0.7 + 0 * x, 1 + 0.8 * x + 0.25 * (3 * x ^ 2 - 1),
    40 * e ^ (60 * (cosine(sun_a) - 1)) + 100 * e ^ (200 * (cosine(sun_b) - 1)) }, 2)
  image:layer()[{}] = values:reshape { size[2], size[1], 3 }
  assert(image:save(path))
end

--- The functions of a convention in the order of its numbers, by formulas of its own source; f = sum of number times function.
local function functions(v)
  local x, y, z = v[1], v[2], v[3]
  local s = math.sqrt
  local splats = { 0.28209479177387814, -0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x,
    1.0925484305920792 * x * y, -1.0925484305920792 * y * z, 0.31539156525252005 * (2 * z * z - x * x - y * y),
    -1.0925484305920792 * x * z, 0.5462742152960396 * (x * x - y * y) }
  local component = { 1, s(3) * x, s(3) * y, s(3) * z, s(15) * x * z, s(15) * x * y, s(5) * (y * y - (x * x + z * z) / 2),
    s(15) * y * z, s(15) / 2 * (z * z - x * x) }
  local e3nn, norm = {}, {}
  for i, f in ipairs(component) do
    e3nn[i], norm[i] = f / s(4 * pi), f / s(i == 1 and 1 or i < 5 and 3 or 5)
  end
  -- scipy's Y(l, m) to degree 2, with phase; dipy: sqrt 2 Re Y(l, |m|) for m < 0, sqrt 2 Im Y(l, m) for m > 0
  local y22, y21, y20 = s(15 / (32 * pi)), -s(15 / (8 * pi)), s(5 / (16 * pi)) * (3 * z * z - 1)
  local dipy = { s(1 / (4 * pi)), s(2) * y22 * (x * x - y * y), s(2) * y21 * x * z, y20, s(2) * y21 * y * z,
    s(2) * y22 * 2 * x * y }
  -- AmbiX: signals of N3D and SN3D (ACN), whose sum with the same functions over 4 pi, times 2l+1 of SN3D, is the field
  local n3d = { 1, s(3) * y, s(3) * z, s(3) * x, s(15) * x * y, s(15) * y * z, s(5) / 2 * (3 * z * z - 1), s(15) * x * z,
    s(15) / 2 * (x * x - y * y) }
  local sn3d = { 1, y, z, x, s(3) * x * y, s(3) * y * z, (3 * z * z - 1) / 2, s(3) * x * z, s(3) / 2 * (x * x - y * y) }
  for i = 1, 9 do
    n3d[i], sn3d[i] = n3d[i] / (4 * pi), sn3d[i] * (i == 1 and 1 or i < 5 and 3 or 5) / (4 * pi)
  end
  -- scipy: real part of the sum of a(l, m) sph_harm(l, m), m from -l to l; pairs of the functions' real and -imaginary parts
  local y11 = -s(3 / (8 * pi))
  local function pair(c, re, im) return c * re, -c * im end
  local scipy, i = { s(1 / (4 * pi)), 0 }, 3
  for _, f in ipairs { { -y11, x, -y }, { s(3 / (4 * pi)) * z, 1, 0 }, { y11, x, y }, { y22, x * x - y * y, -2 * x * y },
    { -y21 * z, x, -y }, { y20, 1, 0 }, { y21 * z, x, y }, { y22, x * x - y * y, 2 * x * y } } do
    scipy[i], scipy[i + 1] = pair(f[1], f[2], f[3])
    i = i + 2
  end
  return {
    n3d = n3d, sn3d = sn3d, scipy = scipy,
    unity = { x, y, z, 1, x * y, y * z, z * z, z * x, x * x - y * y },  -- ShadeSH9 of UnityCG.cginc
    ["3dgs"] = splats, ylm = splats, e3nn = e3nn, ["e3nn-component"] = component, ["e3nn-norm"] = norm, dipy = dipy,
    mrtrix = { dipy[1], dipy[6], dipy[5], dipy[4], dipy[3], dipy[2] },
    filament = { 1, y, z, x, y * x, y * z, 3 * z * z - 1, z * x, x * x - y * y },
    ["three.js"] = { 0.282095, 0.488603 * y, 0.488603 * z, 0.488603 * x, 1.092548 * x * y, 1.092548 * y * z,
      0.315392 * (3 * z * z - 1), 1.092548 * x * z, 0.546274 * (x * x - y * y) },
    plain = { 0.28209479177387814, -splats[2], splats[3], -splats[4], splats[5], -splats[6], splats[7], -splats[8], splats[9] },
  }
end

local channels_last = { ["3dgs"] = true, filament = true, ["three.js"] = true }
local quantity = { filament = { 1, 2 / 3, 1 / 4 }, unity = { 1, 2 / 3, 1 / 4 }, dipy = { 1, 0, 1 }, mrtrix = { 1, 0, 1 } }

--- Coefficients of channel k in the shape of `system`, as a list.
local function channel(c, system, k)
  if channels_last[system] then return c[{ {}, k }]:totable() end
  if system == "scipy" then return c[k]:reshape({ 18 }):totable() end
  if system == "unity" then -- SHA and SHB of the channel, then its part of SHC
    local list = c[k]:totable()
    for _, x in ipairs(c[3 + k]:totable()) do list[#list + 1] = x end
    list[9] = c:get(7, k)
    return list
  end
  return c[k]:totable()
end

describe("ylm sh", function()
  local folder, run
  setup(function()
    folder = scratch.new()
    run = tool.runner(folder)
    environment(folder.path .. "/latlong.exr", { 512, 256 }, "latlong", "y")
    environment(folder.path .. "/cube.exr", { 128, 768 }, "cube", "y")
    environment(folder.path .. "/small.exr", { 64, 32 }, "latlong", "y")
  end)
  teardown(function() folder:remove() end)

  --- Standard output of a good run.
  local function good(words)
    local out, code, err = run("sh " .. words)
    assert.equal(0, code, words .. ": " .. out .. err)
    return out, err
  end

  it("agrees with closed forms to 1e-3 in every convention, of latlong and cube", function()
    for _, name in ipairs { "latlong", "cube" } do
      good(("%s/%s.exr --format npy -o %s/%s.npy -q"):format(folder.path, name, folder.path, name))
      local c = assert(ylm.load(folder.path .. "/" .. name .. ".npy"))
      for system in pairs(functions(directions[1])) do
        local there = ylm.sh.convert(c, system)
        for _, v in ipairs(directions) do
          local basis = functions(v)[system]
          for k = 1, 3 do
            local wanted, largest = closed(k, v, quantity[system]), closed(k, parts[k][1][1], quantity[system])
            assert.is_near(wanted, dot(channel(there, system, k), basis), 1e-3 * math.abs(largest))
          end
        end
        local back = ylm.sh.convert(there, "ylm")
        local even = quantity[system] and quantity[system][2] == 0
        assert(even or core.array_distance(back, c) < 1e-6, system)
      end
    end
  end)

  it("agrees with three.js' LightProbeGenerator: cubes that it renders, and cubes of images, whose x it mirrors", function()
    local modules = os.getenv "YLM_NODE_MODULES" -- a folder with npm's `three`
    if not modules or not scratch.shell "command -v node >/dev/null 2>&1" then
      pending "YLM_NODE_MODULES with three, and node, are wanted"
    end
    local image = ylm.image { size = { 48, 288 } } -- bytes over 255, which canvases hold
    local d = image:directions { mapping = "cube", up = "y" }
    local levels = ylm.array((d * lobe):sum(2):clamp(0, 1) * 200 + 40, "float")
    for i = 1, #levels do levels[i] = math.floor(levels[i]) end
    image:layer()[{}] = ylm.stack({ levels, 255 - levels, 0 * levels + 20 }, 2):reshape { 288, 48, 3 } / 255
    assert(image:save(folder.path .. "/bytes.exr"))
    for _, name in ipairs { "cube", "bytes" } do
      folder:write(name .. ".floats", ylm.load(("%s/%s.exr"):format(folder.path, name)):layer():bytes())
    end
    folder:write("probe.mjs", ([[
import fs from 'fs';
import { FloatType, NoColorSpace, WebGLCoordinateSystem } from 'file://MODULES/three/build/three.module.js';
import { LightProbeGenerator } from 'file://MODULES/three/examples/jsm/lights/LightProbeGenerator.js';
const faces = name => {
  const bytes = fs.readFileSync( name + '.floats' ), all = new Float32Array( bytes.buffer, bytes.byteOffset, bytes.length / 4 );
  const width = Math.sqrt( all.length / 18 ), face = k => {
    const rgba = new Float32Array( 4 * width * width );
    for ( let i = 0; i < rgba.length; i ++ ) rgba[ i ] = i % 4 == 3 ? 1 : all[ 3 * ( k * width * width + ( i >> 2 ) ) + i % 4 ];
    return rgba;
  };
  return { width, face };
};
const show = probe => console.log( probe.sh.coefficients.map( v => v.x + ' ' + v.y + ' ' + v.z ).join( ' ' ) );
const cube = faces( 'cube' );
show( await LightProbeGenerator.fromCubeRenderTarget( { isWebGLRenderer: true, coordinateSystem: WebGLCoordinateSystem,
  readRenderTargetPixelsAsync: async ( target, x, y, w, h, data, k ) => data.set( cube.face( k ) ) },
  { width: cube.width, texture: { type: FloatType, colorSpace: NoColorSpace } } ) );
const bytes = faces( 'bytes' );
globalThis.document = { createElement: () => ( { getContext: () => {
  let data;
  return { drawImage: image => { data = Uint8ClampedArray.from( image.rgba, v => Math.round( 255 * v ) ); },
    getImageData: () => ( { data, width: bytes.width } ) };
} } ) };
show( LightProbeGenerator.fromCubeTexture( { colorSpace: NoColorSpace,
  image: [ 0, 1, 2, 3, 4, 5 ].map( k => ( { width: bytes.width, height: bytes.width, rgba: bytes.face( k ) } ) ) } ) );
]]):gsub("MODULES", (modules:gsub("%%", "%%%%"))))
    local out, code = scratch.capture("cd " .. scratch.quote(folder.path) .. " && node probe.mjs 2>&1")
    assert.equal(0, code, out)
    for line in out:gmatch "[^\n]+" do
      local name, axes = "cube", ""
      if out:sub(1, #line) ~= line then name, axes = "bytes", " -x,y,z" end
      good(("%s/%s.exr --as 'three.js%s' --format npy -q -o %s/three.npy"):format(folder.path, name, axes, folder.path))
      local ours, theirs = ylm.load(folder.path .. "/three.npy"):reshape { 27 }, {}
      for x in line:gmatch "%S+" do theirs[#theirs + 1] = tonumber(x) end
      assert.equal(27, #theirs, out)
      local largest = ours:abs():max()
      for i = 1, 27 do assert.is_near(theirs[i], ours[i], 2e-3 * largest) end
    end
  end)

  it("says the convention, the axes and the odd degrees that are left out", function()
    local text = good(folder.path .. "/small.exr --as dipy")
    assert.truthy(text:find("latlong, y up", 1, true) and text:find("convention dipy, radiance, lmax 2", 1, true), text)
    assert.truthy(text:find "odd degrees are left out: 0%.%d+ of the L2 norm", text)
    assert.equal(4 + 5, select(2, text:gsub("\n", "\n")))
    text = good(folder.path .. "/cube.exr --as unity")
    assert.truthy(text:find("cube, y up", 1, true) and text:find("convention unity, irradiance/pi", 1, true), text)
    assert.truthy(text:find "\nSHAr +%S+ +%S+ +%S+ +%S+\n")
    assert.truthy(good(folder.path .. "/small.exr --as lovr"):find("convention filament", 1, true))
    local json = good(folder.path .. "/small.exr --as 'plain x,z,-y' --irradiance --json")
    assert.truthy(json:find('"convention":"plain irradiance x,z,-y"', 1, true), json)
  end)

  --- The expressions of a function in GLSL as one of Lua.
  local function function_of(glsl)
    local list, body = glsl:match "vec3%[9%]%((.-)%);", glsl:match "{\n(.-)\n}"
    local text = "local n = ... local sh, k = {}, 0\n" .. list:gsub("vec3(%b())", function(numbers)
      return ("sh[k], k = A {%s}, k + 1"):format(numbers:sub(2, -2))
    end):gsub("\n *", " "):gsub(", sh", " sh") .. "\n" .. body:gsub("float ", "local "):gsub(";", "")
    return assert((loadstring or load)("local A = require 'ylm'.array " .. text))
  end

  it("emits code that evaluates to the same numbers: Lua, C, GLSL", function()
    local c = ylm.sh.project(2, ylm.load(folder.path .. "/small.exr"), { up = "y" })
    local programs, wanted, shaders, shaded = {}, {}, {}, {}
    for i, system in ipairs { "three.js", "filament", "3dgs", "e3nn-norm", "dipy", "sn3d" } do
      local there, known = ylm.sh.convert(c, system), functions(directions[1])[system] ~= nil
      local words = ("%s/small.exr --as %s --format "):format(folder.path, system)
      local lua = system ~= "dipy" and assert((loadstring or load)(good(words .. "lua")))().evaluate
      local glsl = i < 4 and good(words .. "glsl")
      if i == 2 or i == 5 then
        programs[#programs + 1] = good(words .. "c"):gsub("sh_evaluate", "f" .. i):gsub("%f[%w]sh%f[%W]", "sh_" .. i)
      end
      for _, v in ipairs(directions) do
        local sums = {}
        for k = 1, 3 do
          sums[k] = known and dot(channel(there, system, k), functions(v)[system]) or ylm.sh.reconstruct(c[k], v)
        end
        local rgb = lua and { lua(v[1], v[2], v[3]) } or sums
        for k = 1, 3 do assert.is_near(sums[k], rgb[k], 3e-5 * math.abs(sums[k]) + 3e-5) end
        if i == 2 or i == 5 then wanted[#wanted + 1] = sums end
        if glsl then -- its expressions are Lua's too
          shaded[#shaded + 1] = { v, sums }
          local f = function_of(glsl)
          local value = f { x = v[1], y = v[2], z = v[3] }
          for k = 1, 3 do assert.is_near(sums[k], value[k], 3e-5 * math.abs(sums[k]) + 3e-5) end
        end
      end
      if glsl then shaders[i] = glsl:gsub("sh_evaluate", "f" .. i):gsub("%f[%w]sh%f[%W]", "sh_" .. i) end
    end
    local lines = { "#include <stdio.h>", programs[1], programs[2], "int main(void) { float o[3];" }
    for _, name in ipairs { "f2", "f5" } do
      for _, v in ipairs(directions) do
        lines[#lines + 1] = ('{ const float n[3] = {%g, %g, %g}; %s(n, o); printf("%%.9g %%.9g %%.9g\\n", o[0], o[1], o[2]); }')
          :format(v[1], v[2], v[3], name)
      end
    end
    folder:write("e.c", table.concat(lines, "\n") .. "\nreturn 0; }\n")
    local out, code = scratch.capture(("${CC:-cc} -std=c11 -Wall -Wextra -Werror -o %s/e %s/e.c && %s/e"):format(folder.path,
      folder.path, folder.path))
    assert.equal(0, code, out)
    local function agree(list)
      local i = 0
      for r, g, b in out:gmatch "(%S+) (%S+) (%S+)" do
        i = i + 1
        for k, x in ipairs { r, g, b } do assert.is_near(list[i][k], tonumber(x), 3e-5 * math.abs(list[i][k]) + 3e-5) end
      end
      assert.equal(#list, i)
    end
    agree(wanted)
    if not scratch.shell "command -v glslc >/dev/null" then pending "glslc is not installed" end
    local words, sums = {}, {} -- the rows of system k are those that shader k evaluates
    for i, row in ipairs(shaded) do
      words[i], sums[i] = ("%.9g %.9g %.9g"):format(row[1][1], row[1][2], row[1][3]), row[2]
    end
    folder:write("e.comp", "#version 450\n" .. table.concat(shaders) .. ([[
layout(binding = 0) buffer B { vec4 o[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  o[i].xyz = i < %d ? f1(o[i].xyz) : i < %d ? f2(o[i].xyz) : f3(o[i].xyz);
}
]]):format(#directions, 2 * #directions))
    out, code = scratch.capture(("glslc %s/e.comp -o %s/e.spv"):format(folder.path, folder.path))
    assert.equal(0, code, out)
    out, code = scratch.capture(("${CC:-cc} -std=gnu11 -Wall -Wextra -Werror spec/support/compute.c -o %s/compute -lvulkan")
      :format(folder.path))
    if code ~= 0 then pending("a program for Vulkan is not built: " .. out) end
    out, code = scratch.capture(("%s/compute %s/e.spv %s"):format(folder.path, folder.path, table.concat(words, " ")))
    if code == 77 then pending "there is no device for Vulkan" end
    assert.equal(0, code, out)
    agree(sums)
  end)

  it("takes the ringing of a sun away, and says what that costs", function()
    local image = ylm.image { size = { 64, 32 } }
    local layer = image:layer()
    layer[{}] = 0.1
    layer[{ { 9, 10 }, { 20, 21 } }] = 1e4
    assert(image:save(folder.path .. "/sun.hdr"))
    local words = folder.path .. "/sun.hdr --irradiance --format npy -q -o " .. folder.path
    good(words .. "/rings.npy")
    local _, err = good((words:gsub(" %-q", "")) .. "/smooth.npy --dering")
    local rings, smooth = ylm.load(folder.path .. "/rings.npy"), ylm.load(folder.path .. "/smooth.npy")
    assert.equal("ylm irradiance", smooth.convention)
    local some = {}
    for i = 1, 10000 do -- a spiral
      local z, phi = 1 - (2 * i - 1) / 10000, 2.399963229728653 * i
      some[i] = { math.sqrt(1 - z * z) * math.cos(phi), math.sqrt(1 - z * z) * math.sin(phi), z }
    end
    assert(ylm.sh.reconstruct(rings, some):min() < -0.1)
    assert(ylm.sh.reconstruct(smooth, some):min() >= -1e-6)
    local cost = ylm.sh.relative_error(smooth:reshape { 1, 27 }, rings:reshape { 1, 27 })[1]
    assert(cost > 0.01 and cost < 0.5)
    assert.is_near(cost, tonumber(err:match "L2 error ([%d.e-]+)"), 1e-3 * cost)
  end)

  it("refuses by name", function()
    local path = folder.path .. "/latlong.exr"
    for words, says in pairs {
      [path .. " --as filamnt"] = "did you mean 'filament'?",
      [path .. " --as 'plain x,x,y'"] = "'x,x,y' is no convention",
      [path .. " --format glsk"] = "--format is one of text, json, glsl, c, lua, npy, got 'glsk' (did you mean 'glsl'?)",
      [path .. " --up x"] = "--up is one of y, z, got 'x'",
      [path .. " --mapping latlng"] = "did you mean 'latlong'?",
      [path .. " --lmax 3 --as unity"] = "--as unity holds lmax 2, got --lmax 3",
      [path .. " --lmax 3 --as dipy"] = "--as dipy holds even degrees: --lmax 2 or 4, got 3",
      [path .. " --lmax 2.5"] = "--lmax is a whole number",
      [path .. " --as scipy --format c"] = "--format c is not written for 'scipy'",
      [path .. " --format npy"] = "--format npy needs -o FILE.npy",
      [path .. " --derring"] = "no option --derring (did you mean --dering?)",
    } do
      local out, code, err = run("sh " .. words)
      assert.equal(2, code, words .. out)
      assert.truthy(err:find(says, 1, true), words .. ": " .. err)
    end
    local _, code, err = run(("sh %s --mapping cube"):format(path))
    assert.equal(1, code)
    assert.truthy(err:find("512x256 pixels; latlong is twice as wide as high", 1, true), err)
    _, code, err = run("sh " .. folder.path .. "/nothing.hdr")
    assert.equal(1, code)
    assert.truthy(err:find("nothing.hdr", 1, true), err)
    local image = ylm.image { size = { 4, 2 } }
    image:layer()[{}] = 0 / 0
    assert(image:save(folder.path .. "/nan.exr"))
    _, code, err = run("sh " .. folder.path .. "/nan.exr")
    assert.equal(1, code)
    assert.truthy(err:find("nan.exr: pixel (1, 1) is not finite", 1, true), err)
  end)
end)
