--- shaders/gen/probes.*: the look-up of '.ylmp' for fragment shaders, in GLSL (ES 3.00), HLSL and WGSL.
--
-- One text is written in lines of a small language, which are: `fn TYPE NAME(TYPE A, ..) {`, `let TYPE NAME = X`,
-- `var TYPE NAME = X`, `NAME = X`, `if X {`, `while X {`, `return X`, `}`. Types are float, uint, vec3, uvec2, uvec3; all3(x) is
-- a vec3 of equal parts. Each language has its own words for these, and its own functions word, atlas, byte and signed.

local lookup = [[
// The leaf at p, in roots: { split or level and first brick, planes }.
fn uvec2 ylm_leaf(vec3 p) {
  var float n = U.top
  var vec3 c = clamp(floor(p * n), all3(0.0), U.roots * n - all3(1.0))
  var uvec2 e = ylm_word(uint(c.x) + uint(U.roots.x * n) * (uint(c.y) + uint(U.roots.y * n) * uint(c.z)))
  while e.x >= 0x80000000u {
    n = n * 2.0
    c = clamp(floor(p * n), all3(0.0), U.roots * n - all3(1.0))
    e = ylm_word((e.x & 0x7fffffffu) + (uint(c.x) & 1u) + 2u * (uint(c.y) & 1u) + 4u * (uint(c.z) & 1u))
  }
  return e
}
// Irradiance at x of a surface with unit normal m.
fn vec3 ylm_irradiance(vec3 x, vec3 m) {
  let vec3 p = (x - U.low) * U.scale
  var uvec2 e = ylm_leaf(p)
  var float n = exp2(float((e.x >> 26u) & 31u))
  let vec3 q = p + m * U.scale * (0.1875 / n * dot(abs(m), all3(1.0) / U.scale))
  if any3(floor(q * n), floor(p * n)) {
    e = ylm_leaf(q)
    n = exp2(float((e.x >> 26u) & 31u))
  }
  if e.y == 0xffffffffu {
    return all3(0.0)
  }
  let vec3 low = clamp(floor(q * n), all3(0.0), U.roots * n - all3(1.0))
  var uint brick = e.x & 0x3ffffffu
  if (e.y & 7u) > 0u {
    var uint side = 0u
    var uint k = 0u
    while k < (e.y & 7u) {
      let uvec2 w = ylm_word((e.y >> 3u) + 1u + k)
      let vec3 plane = vec3(ylm_byte(w.x << 24u), ylm_byte(w.x << 16u), ylm_byte(w.x << 8u))
      if dot(plane, q * n - low) / 127.0 >= ylm_signed(w.y) / 8192.0 {
        side = side | (1u << k)
      }
      k = k + 1u
    }
    let uvec2 part = ylm_word(e.y >> 3u)
    brick = brick + ((choose(side < 8u, part.x, part.y) >> (4u * (side & 7u))) & 15u)
  }
  let vec3 t = clamp(p * n - low, all3(0.0), all3(1.0))
  let uvec3 size = uvec3(U.bricks)
  let vec3 corner = vec3(float(brick % size.x), float((brick / size.x) % size.y), float(brick / (size.x * size.y)))
  let vec3 at = corner + all3(0.25) + 0.5 * t
  let vec4 a = ylm_atlas(at, 0.0)
  let vec4 b = ylm_atlas(at, 1.0)
  let vec4 c = ylm_atlas(at, 2.0)
  var vec3 sum = a.xyz + vec3(a.w, b.xy) * m.y + vec3(b.zw, c.x) * m.z + c.yzw * m.x
  if U.lmax > 1.0 {
    let vec4 d = ylm_atlas(at, 3.0)
    let vec4 f = ylm_atlas(at, 4.0)
    let vec4 g = ylm_atlas(at, 5.0)
    let vec4 h = ylm_atlas(at, 6.0)
    sum = sum + d.xyz * (m.x * m.y) + vec3(d.w, f.xy) * (m.y * m.z)
    sum = sum + vec3(f.zw, g.x) * (3.0 * m.z * m.z - 1.0) + g.yzw * (m.x * m.z) + h.xyz * (m.x * m.x - m.y * m.y)
  }
  return max(sum, all3(0.0))
}
]]

local languages = {
  glsl = {
    types = {},
    prelude = [[
uniform highp usampler2D ylm_tree;
uniform highp sampler3D ylm_bricks_atlas;
uniform vec3 ylm_low, ylm_scale, ylm_roots, ylm_bricks;
uniform float ylm_top, ylm_lmax;
uvec2 ylm_word(uint i) { return texelFetch(ylm_tree, ivec2(i & 1023u, i >> 10u), 0).rg; }
vec4 ylm_atlas(vec3 at, float k) {
  float volumes = ylm_lmax > 1.0 ? 7.0 : 3.0;
  vec3 size = ylm_bricks * vec3(1.0, 1.0, volumes);
  return textureLod(ylm_bricks_atlas, (at + vec3(0.0, 0.0, k * ylm_bricks.z)) / size, 0.0);
}
float ylm_byte(uint x) { return float(int(x) >> 24); }
float ylm_signed(uint x) { return float(int(x)); }
]],
    fields = "ylm_", all3 = "vec3(%1)", any3 = "any(notEqual(%1, %2))", choose = "(%1 ? %2 : %3)",
    declare = "%s %s = %s;", argument = "%s %s", fn = "%s %s(%s) {" },
  hlsl = {
    types = { vec3 = "float3", vec4 = "float4", uvec2 = "uint2", uvec3 = "uint3" },
    prelude = [[
Texture2D<uint2> ylm_tree;
Texture3D<float4> ylm_bricks_atlas;
SamplerState ylm_linear;
cbuffer ylm_probes {
  float3 ylm_low; float ylm_top; float3 ylm_scale; float ylm_lmax; float3 ylm_roots; float3 ylm_bricks;
};
uint2 ylm_word(uint i) { return ylm_tree.Load(int3(int(i & 1023u), int(i >> 10u), 0)); }
float4 ylm_atlas(float3 at, float k) {
  float volumes = ylm_lmax > 1.0 ? 7.0 : 3.0;
  float3 size = ylm_bricks * float3(1.0, 1.0, volumes);
  return ylm_bricks_atlas.SampleLevel(ylm_linear, (at + float3(0.0, 0.0, k * ylm_bricks.z)) / size, 0.0);
}
float ylm_byte(uint x) { return float(asint(x) >> 24); }
float ylm_signed(uint x) { return float(asint(x)); }
]],
    fields = "ylm_", all3 = "float3(%1, %1, %1)", any3 = "any(%1 != %2)", choose = "(%1 ? %2 : %3)",
    declare = "%s %s = %s;", argument = "%s %s", fn = "%s %s(%s) {" },
  wgsl = {
    types = { float = "f32", uint = "u32", vec3 = "vec3f", vec4 = "vec4f", uvec2 = "vec2u", uvec3 = "vec3u" },
    prelude = [[
struct ylm_Probes { low: vec3f, top: f32, scale: vec3f, lmax: f32, roots: vec3f, bricks: vec3f };
@group(0) @binding(0) var<uniform> ylm: ylm_Probes;
@group(0) @binding(1) var ylm_tree: texture_2d<u32>;
@group(0) @binding(2) var ylm_bricks_atlas: texture_3d<f32>;
@group(0) @binding(3) var ylm_linear: sampler;
fn ylm_word(i: u32) -> vec2u { return textureLoad(ylm_tree, vec2u(i & 1023u, i >> 10u), 0).rg; }
fn ylm_atlas(at: vec3f, k: f32) -> vec4f {
  let size = ylm.bricks * vec3f(1.0, 1.0, select(3.0, 7.0, ylm.lmax > 1.0));
  return textureSampleLevel(ylm_bricks_atlas, ylm_linear, (at + vec3f(0.0, 0.0, k * ylm.bricks.z)) / size, 0.0);
}
fn ylm_byte(x: u32) -> f32 { return f32(bitcast<i32>(x) >> 24u); }
fn ylm_signed(x: u32) -> f32 { return f32(bitcast<i32>(x)); }
]],
    fields = "ylm.", all3 = "vec3f(%1)", any3 = "any(%1 != %2)", choose = "select(%3, %2, %1)",
    argument = "%2$s: %1$s", fn = "fn %2$s(%3$s) -> %1$s {" },
}

--- The text of a call's arguments, at its outermost commas.
local function arguments_of(text)
  local list, depth, from = {}, 0, 1
  for i = 1, #text do
    local c = text:sub(i, i)
    if c == "(" then depth = depth + 1 elseif c == ")" then depth = depth - 1 end
    if c == "," and depth == 0 then list[#list + 1], from = text:sub(from, i - 1), i + 1 end
  end
  list[#list + 1] = text:sub(from)
  for i, x in ipairs(list) do list[i] = x:match "^%s*(.-)%s*$" end
  return list
end

--- An expression in a language's words.
local function expression(language, text)
  for _, name in ipairs { "all3", "any3", "choose" } do
    text = text:gsub(name .. "(%b())", function(call)
      local list = arguments_of(call:sub(2, -2))
      return (language[name]:gsub("%%(%d)", function(k) return list[tonumber(k)] end))
    end)
  end
  text = text:gsub("U%.", language.fields)
  return (text:gsub("%f[%w_]([%a][%w]*)%f[%W]", language.types))
end

local function typed(language, word) return language.types[word] or word end

--- Fills "%1$s" and "%s" of a form.
local function fill(form, ...)
  local list, next_one = { ... }, 0
  form = form:gsub("%%(%d)%$s", function(k) return list[tonumber(k)] end)
  return (form:gsub("%%s", function()
    next_one = next_one + 1
    return list[next_one]
  end))
end

local function statement(language, line)
  local indent, text = line:match "^(%s*)(.*)$"
  if text == "}" or text:find "^//" then return line end
  local kind, name, list = text:match "^fn (%S+) (%S-)%((.-)%) {$"
  if kind then
    local arguments = {}
    for of, word in list:gmatch "(%w+) (%w+)" do
      arguments[#arguments + 1] = fill(language.argument, typed(language, of), word)
    end
    return fill(language.fn, typed(language, kind), name, table.concat(arguments, ", "))
  end
  local word, condition = text:match "^(%l+) (.*) {$"
  if word then return ("%s%s (%s) {"):format(indent, word, expression(language, condition)) end
  local how, of, variable, x = text:match "^(%l%l%l) (%w+) (%w+) = (.*)$"
  if how and language.declare then
    return indent .. fill(language.declare, typed(language, of), variable, expression(language, x))
  end
  if how then return ("%s%s %s: %s = %s;"):format(indent, how, variable, typed(language, of), expression(language, x)) end
  return indent .. expression(language, text) .. ";"
end

--- The look-up in "glsl", "hlsl" or "wgsl".
local function text(name)
  local language, lines = languages[name], {}
  lines[1] = "// GENERATED by lua/ylm/codegen (make gen); do not edit. The look-up of .ylmp: docs/engines.md."
  for line in language.prelude:gmatch "[^\n]+" do lines[#lines + 1] = line end
  for line in lookup:gmatch "[^\n]+" do lines[#lines + 1] = statement(language, line) end
  return table.concat(lines, "\n") .. "\n"
end

local READER = "lua/ylm/page/viewer/probes.js"

--- The reader of pages as a module of JavaScript.
local function reader()
  local file = assert(io.open(READER, "rb"))
  local source = file:read "*a"
  file:close()
  return "// GENERATED by lua/ylm/codegen (make gen) from " .. READER .. "; do not edit.\n"
    .. source:gsub("\nfunction readProbes", "\nexport function readProbes")
end

--- The text of a target: a language; "js", the GLSL as a module of JavaScript; "lua", as a module of Lua; "reader".
return function(name)
  if name == "js" then return "export default /* glsl */`\n" .. text "glsl" .. "`;\n" end
  if name == "lua" then return "return [==[\n" .. text "glsl" .. "]==]\n" end
  if name == "reader" then return reader() end
  return text(name)
end
