--- shaders/gen/probes.wgsl in a browser's WebGPU, by SwiftShader: what it reads at places.

local browser = require "spec.support.browser"
local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"

local page = {}

local SWITCHES = "--headless=new --use-angle=swiftshader --enable-unsafe-swiftshader --enable-unsafe-webgpu "
  .. "--use-webgpu-adapter=swiftshader --no-first-run --disable-extensions --disable-sync --disable-background-networking"

local MAIN = [[
@group(0) @binding(4) var<storage, read_write> rows: array<vec4f>; // place, normal, out
@compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
  rows[3u * id.x + 2u] = vec4f(ylm_irradiance(rows[3u * id.x].xyz, rows[3u * id.x + 1u].xyz), 1.0);
}
]]

local PAGE = [[<!doctype html><body><script>
%s
async function run() {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return 'NONE';
  const device = await adapter.requestDevice();
  const p = readProbes(Uint8Array.from(atob('%s'), c => c.charCodeAt(0)).buffer);
  const module = device.createShaderModule({ code: `%s` });
  const said = (await module.getCompilationInfo()).messages.map(m => m.lineNum + ': ' + m.message);
  if (said.length) return 'SAID ' + said.join('; ');
  const u = p.uniforms, numbers = new Float32Array(28);
  numbers.set([...u.ylm_low, u.ylm_top, ...u.ylm_scale, u.ylm_lmax, ...u.ylm_end, 0, ...u.ylm_ahead, 0, ...u.ylm_table, 0,
    ...u.ylm_texel, 0, ...u.ylm_volume, 0]);
  function buffer(data, usage) {
    const b = device.createBuffer({ size: data.byteLength, usage: usage | GPUBufferUsage.COPY_DST });
    device.queue.writeBuffer(b, 0, data);
    return b;
  }
  function texture(data, size, dimension, format, bytes) {
    const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
    const t = device.createTexture({ size, dimension, format, usage });
    device.queue.writeTexture({ texture: t }, data, { bytesPerRow: bytes * size[0], rowsPerImage: size[1] }, size);
    return t.createView();
  }
  const rows = new Float32Array(%s), usage = GPUBufferUsage;
  const work = buffer(rows, usage.STORAGE | usage.COPY_SRC), back = buffer(rows, usage.MAP_READ);
  const pipeline = await device.createComputePipelineAsync({ layout: 'auto', compute: { module, entryPoint: 'main' } });
  const entries = [{ buffer: buffer(numbers, usage.UNIFORM) },
    texture(p.tree.data, [p.tree.width, p.tree.height], '2d', 'rg32sint', 8),
    texture(p.atlas.data, p.atlas.size, '3d', 'rgba16float', 8),
    device.createSampler({ minFilter: 'linear', magFilter: 'linear' }),
    { buffer: work }].map((resource, binding) => ({ binding, resource }));
  const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
  pass.dispatchWorkgroups(rows.length / 12);
  pass.end();
  encoder.copyBufferToBuffer(work, 0, back, 0, rows.byteLength);
  device.queue.submit([encoder.finish()]);
  await back.mapAsync(GPUMapMode.READ);
  return Array.from(new Float32Array(back.getMappedRange())).join(' ');
}
</script></body>]]

--- The irradiance {{ red, green, blue }, ..} that the look-up reads of a file's text at rows of place and normal; or nil, why it
--- cannot be had here. An error of the program is raised.
function page.irradiance(folder, text, rows)
  local list = {}
  for i, r in ipairs(rows) do
    list[i] = ("%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,0,0,0,0"):format(r[1], r[2], r[3], r[4], r[5], r[6])
  end
  local name = folder:write("wgsl.html", PAGE:format(scratch.text "lua/ylm/page/viewer/probes.js", core.page_base64(text),
    scratch.text "shaders/gen/probes.wgsl" .. MAIN, "[" .. table.concat(list, ",") .. "]"))
  local window = browser.open { size = { 64, 64 }, limit = 60, switches = SWITCHES }
  window:visit(name)
  local said = window:eval "run().catch(e => 'SAID ' + e)"
  window:close()
  if said == "NONE" then return nil, "this browser has no WebGPU" end
  assert(not said:find "^SAID", said)
  local numbers, out = {}, {}
  for x in said:gmatch "%S+" do numbers[#numbers + 1] = tonumber(x) end
  for i = 1, #rows do out[i] = { numbers[12 * i - 3], numbers[12 * i - 2], numbers[12 * i - 1] } end
  return out
end

return page
