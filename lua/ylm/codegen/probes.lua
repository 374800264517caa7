--- shaders/gen/probes.*: the look-up of '.ylmp' for fragment shaders, in GLSL (ES 3.00), HLSL and WGSL.
--
-- One text is written in lines of a small language, which are: `fn TYPE NAME(TYPE A, ..) {`, `let TYPE NAME = X`,
-- `var TYPE NAME = X`, `NAME = X`, `if X {`, `while X {`, `return X`, `}`. Types are float, int, vec3, ivec2, ivec3; all3(x) is
-- a vec3 of equal parts. Each language has its own words for these, and its own functions word, atlas, float and plane.

local lookup = [[
// The leaf at p, in roots: { edges a root as the exponent of a float, and the brick; planes }; or, below 0, eight children.
fn ivec2 ylm_leaf(vec3 p) {
  var float n = U.top
  var ivec2 e = ylm_word(int(dot(floor(p * n), U.table)))
  while e.x < 0 {
    e = ylm_word((e.x & 0x7fffffff) + int(dot(step(all3(0.5), fract(p * n)), vec3(1.0, 2.0, 4.0))))
    n = 2.0 * n
  }
  return e
}
// Irradiance at x of a surface with unit normal m.
fn vec3 ylm_irradiance(vec3 x, vec3 m) {
  let vec3 p = clamp((x - U.low) * U.scale, all3(0.0), U.end)
  var ivec2 e = ylm_leaf(p)
  var float n = ylm_float(e.x & 0x7f800000)
  let vec3 ahead = p + dot(abs(m), U.ahead) / n * (m * U.scale)
  let vec3 q = clamp(ahead, all3(0.0), U.end)
  if any3(floor(q * n), floor(p * n)) {
    e = ylm_leaf(q)
    n = ylm_float(e.x & 0x7f800000)
  }
  let vec3 low = floor(q * n)
  var int brick = e.x
  if e.y > 0 {
    let vec4 f = vec4(ahead * n - low, -1.0)
    let int sides = e.y >> 3
    var int k = e.y & 7
    var float side = 0.0
    while k > 0 {
      side = 2.0 * side + step(0.0, dot(ylm_plane(ylm_word(sides - k)), f))
      k = k - 1
    }
    brick = ylm_word(sides + int(side)).x
  }
  let vec3 corner = vec3(ivec3(brick, brick >> 7, brick >> 14) & ivec3(127, 127, 511))
  var vec3 at = (corner + all3(0.25) + 0.5 * clamp(p * n - low, all3(0.0), all3(1.0))) * U.texel
  let vec4 a = vec4(1.0, m.yzx)
  let float red = dot(a, ylm_atlas(at))
  at = at + U.volume
  let float green = dot(a, ylm_atlas(at))
  at = at + U.volume
  var vec3 sum = vec3(red, green, dot(a, ylm_atlas(at)))
  if U.lmax > 1.0 {
    let vec4 b = m.xyxz * m.yzzz
    at = at + U.volume
    let float redder = dot(b, ylm_atlas(at))
    at = at + U.volume
    let float greener = dot(b, ylm_atlas(at))
    at = at + U.volume
    sum = sum + vec3(redder, greener, dot(b, ylm_atlas(at)))
    sum = sum + (m.x + m.y) * (m.x - m.y) * ylm_atlas(at + U.volume).xyz
  }
  return max(sum, all3(0.0))
}
]]

local languages = {
  glsl = {
    types = {},
    prelude = [[
uniform highp isampler2D ylm_tree;
uniform highp sampler3D ylm_bricks;
uniform vec3 ylm_low, ylm_scale, ylm_end, ylm_ahead, ylm_table, ylm_texel, ylm_volume;
uniform float ylm_top, ylm_lmax;
ivec2 ylm_word(int i) { return texelFetch(ylm_tree, ivec2(i & 1023, i >> 10), 0).rg; }
vec4 ylm_atlas(vec3 at) { return textureLod(ylm_bricks, at, 0.0); }
vec4 ylm_plane(ivec2 w) { return vec4(unpackSnorm2x16(uint(w.x)), unpackSnorm2x16(uint(w.y))); }
float ylm_float(int x) { return intBitsToFloat(x); }
]],
    fields = "ylm_", all3 = "vec3(%1)", any3 = "any(notEqual(%1, %2))",
    declare = "%s %s = %s;", argument = "%s %s", fn = "%s %s(%s) {" },
  hlsl = {
    types = { vec3 = "float3", vec4 = "float4", ivec2 = "int2", ivec3 = "int3", fract = "frac" },
    prelude = [[
Texture2D<int2> ylm_tree;
Texture3D<float4> ylm_bricks;
SamplerState ylm_linear;
cbuffer ylm_probes {
  float3 ylm_low; float ylm_top; float3 ylm_scale; float ylm_lmax; float3 ylm_end; float3 ylm_ahead; float3 ylm_table;
  float3 ylm_texel; float3 ylm_volume;
};
int2 ylm_word(int i) { return ylm_tree.Load(int3(i & 1023, i >> 10, 0)); }
float4 ylm_atlas(float3 at) { return ylm_bricks.SampleLevel(ylm_linear, at, 0.0); }
float4 ylm_plane(int2 w) { return float4(int4(w.x << 16, w.x, w.y << 16, w.y) >> 16) / 32767.0; }
float ylm_float(int x) { return asfloat(x); }
]],
    fields = "ylm_", all3 = "float3(%1, %1, %1)", any3 = "any(%1 != %2)",
    declare = "%s %s = %s;", argument = "%s %s", fn = "%s %s(%s) {" },
  wgsl = {
    types = { float = "f32", int = "i32", vec3 = "vec3f", vec4 = "vec4f", ivec2 = "vec2i", ivec3 = "vec3i" },
    prelude = [[
struct ylm_Probes {
  low: vec3f, top: f32, scale: vec3f, lmax: f32, end: vec3f, ahead: vec3f, table: vec3f, texel: vec3f, volume: vec3f,
};
@group(0) @binding(0) var<uniform> ylm: ylm_Probes;
@group(0) @binding(1) var ylm_tree: texture_2d<i32>;
@group(0) @binding(2) var ylm_bricks: texture_3d<f32>;
@group(0) @binding(3) var ylm_linear: sampler;
fn ylm_word(i: i32) -> vec2i { return textureLoad(ylm_tree, vec2i(i & 1023, i >> 10u), 0).rg; }
fn ylm_atlas(at: vec3f) -> vec4f { return textureSampleLevel(ylm_bricks, ylm_linear, at, 0.0); }
fn ylm_plane(w: vec2i) -> vec4f { return vec4f(unpack2x16snorm(u32(w.x)), unpack2x16snorm(u32(w.y))); }
fn ylm_float(x: i32) -> f32 { return bitcast<f32>(x); }
]],
    fields = "ylm.", unsigned = "u", all3 = "vec3f(%1)", any3 = "any(%1 != %2)",
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
  for _, name in ipairs { "all3", "any3" } do
    text = text:gsub(name .. "(%b())", function(call)
      local list = arguments_of(call:sub(2, -2))
      return (language[name]:gsub("%%(%d)", function(k) return list[tonumber(k)] end))
    end)
  end
  text = text:gsub("U%.", language.fields)
  text = text:gsub("(>> %d+)", "%1" .. (language.unsigned or ""))
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
