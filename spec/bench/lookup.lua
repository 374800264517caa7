-- Work of the look-up of '.ylmp' in shaders beside that of three.js' LightProbeGrid: SPIR-V's instructions, and fetches.
--
--     make bench BENCH=lookup         build/ylm run spec/bench/lookup.lua
--
-- glslc -O compiles a shader that does nothing else; reads of its inputs count as well, on both sides.
-- three.js' text is that of npm's three in YLM_NODE_MODULES, with its test of whether a place lies in the grid.

local scratch = require "spec.support.scratch"

local HEAD = "#version 310 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler3D;\n"
local TAIL = "\nin vec3 x; in vec3 n; out vec4 o;\nvoid main() { %s }\n"
local folder = scratch.new()

--- Instructions within functions of a fragment shader's text, and how many of these fetch.
local function count(text)
  folder:write("a.frag", HEAD .. text)
  local out = scratch.capture(("glslc --target-env=opengl -fauto-bind-uniforms -fauto-map-locations -O -S -o - %s/a.frag 2>&1")
    :format(scratch.quote(folder.path)))
  local n, fetches, inside = 0, 0, false
  for line in out:gmatch "[^\n]+" do
    local op = line:match "Op%u%w+"
    inside = inside or op == "OpFunction"
    if inside and op and op ~= "OpLabel" and not op:find "^OpFunction" then
      n = n + 1
      if op:find "^OpImage%u" and op ~= "OpImageQuerySize" then fetches = fetches + 1 end
    end
  end
  assert(n > 0, out)
  return n, fetches
end

local function say(name, text, main)
  local n, fetches = count(text .. TAIL:format(main))
  print(("| %s | %d | %d |"):format(name, n, fetches))
end

if not scratch.shell "command -v glslc >/dev/null 2>&1" then
  print "not here: glslc"
  return
end
print "| look-up | instructions of SPIR-V | fetches |\n| --- | --- | --- |"
local modules = os.getenv "YLM_NODE_MODULES"
if modules then
  local chunk = scratch.text(modules .. "/three/src/renderers/shaders/ShaderChunk/lightprobes_pars_fragment.glsl.js")
  local grid = "probesMin[0], probesMax[0], probesResolution[0], x, n)"
  say("three.js", "#define NUM_LIGHT_PROBE_GRIDS 1\n" .. assert(chunk:match "`(.*)`"), ("o = vec4(0.0); "
    .. "if (isInsideLightProbeGrid(x, n, probesMin[0], probesMax[0], probesResolution[0])) "
    .. "o = vec4(getLightProbeGridIrradiance(probesSH[0], %s, 1.0);"):format(grid))
else print "| three.js | not here: YLM_NODE_MODULES | |" end
local own = scratch.text "shaders/gen/probes.glsl"
for degree = 1, 2 do
  local text = own:gsub("uniform float ylm_top, ylm_lmax;",
    ("uniform float ylm_top;\nconst float ylm_lmax = %d.0;"):format(degree))
  local main = "o = vec4(ylm_irradiance(x, n), 1.0);"
  say(("ylm, degree %d, all branches"):format(degree), text, main)
  text = text:gsub("if %(any%b()%)", "if (false)")
  say(("ylm, degree %d, without a second leaf"):format(degree), text, main)
  say(("ylm, degree %d, without that, planes and cells below the table"):format(degree),
    text:gsub("if %(e%.y > 0%)", "if (false)"):gsub("while %(e%.x < 0%)", "while (false)"), main)
end
folder:remove()
