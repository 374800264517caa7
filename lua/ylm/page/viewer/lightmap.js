'use strict';
/* The viewer of a lightmap's page: surfaces that read their light from one picture, drawn by WebGL 2. */
(async function () {
  const $ = id => document.getElementById(id), root = document.documentElement;
  const meta = JSON.parse($('meta').textContent);
  const MODES = [['light', 'l', 'light'], ['white', 'w', 'light on white'], ['charts', 'c', 'charts'],
    ['density', 'd', 'texels'], ['error', 'e', 'error']];
  const state = { mode: 0, exposure: meta.exposure, camera: meta.camera.slice() };

  function fail(message) {
    root.dataset.state = 'failed';
    root.dataset.why = message;
    $('note').textContent = message;
  }

  /* ---- data -------------------------------------------------------------- */

  const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array };

  function bytesOfBase64(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return bytes;
  }

  const inflated = async bytes => new Uint8Array(await new Response(
    new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'))).arrayBuffer());

  async function readSections() {
    const blob = bytesOfBase64($('data').textContent.trim()), out = {};
    let at = 0;
    for (const s of meta.sections) {
      let planes = blob.subarray(at, at += s.bytes);
      if (s.coding.includes('zlib')) planes = await inflated(planes);
      const size = TYPES[s.type].BYTES_PER_ELEMENT, n = planes.length / size, bytes = new Uint8Array(planes.length);
      for (let b = 0; b < size; b++) for (let i = 0; i < n; i++) bytes[i * size + b] = planes[b * n + i];
      out[s.name] = new TYPES[s.type](bytes.buffer);
    }
    return out;
  }

  /* The chart of each vertex, by the texel in the middle of a triangle of it. */
  function chartsOf(s) {
    const out = new Uint32Array(s.uvs.length / 2), [w, h] = meta.size;
    for (let t = 0; t < s.triangles.length; t += 3) {
      let x = 0, y = 0;
      for (let k = 0; k < 3; k++) {
        x += s.uvs[2 * s.triangles[t + k]] / 3;
        y += s.uvs[2 * s.triangles[t + k] + 1] / 3;
      }
      const i = Math.min(w - 1, Math.floor(x * w)), j = Math.min(h - 1, Math.floor((1 - y) * h));
      for (let k = 0; k < 3; k++) out[s.triangles[t + k]] = s.charts[j * w + i];
    }
    return out;
  }

  /* ---- shaders ----------------------------------------------------------- */

  const VERTEX = `#version 300 es
    in vec3 position; in vec2 uv; in vec3 albedo; in vec2 chart; in float number;
    uniform mat4 matrix;
    centroid out vec2 at; out vec3 rho; flat out vec3 facts; /* no look-up leaves its chart */
    void main() { at = vec2(uv.x, 1.0 - uv.y); rho = albedo; facts = vec3(chart, number); gl_Position = matrix * vec4(position, 1); }`;
  const FRAGMENT = `#version 300 es
    precision highp float; precision highp sampler2D;
    centroid in vec2 at; in vec3 rho; flat in vec3 facts;
    uniform sampler2D light; uniform int mode; uniform float scale; uniform vec2 range;
    out vec4 colour;
    vec3 curve(vec3 x) {
      x = clamp(x, 0.0, 1.0);
      return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
    }
    vec3 viridis(float t) {
      vec3 a = vec3(0.2777, 0.0054, 0.3341), b = vec3(0.1051, 1.4046, 1.3846), c = vec3(-0.3309, 0.2148, 0.0951);
      vec3 d = vec3(-4.6342, -5.7991, -19.3324), e = vec3(6.2283, 14.1799, 56.6906), f = vec3(4.7764, -13.7451, -65.3530);
      return clamp(a + t * (b + t * (c + t * (d + t * (e + t * (f + t * vec3(-5.4355, 4.6459, 26.3124)))))), 0.0, 1.0);
    }
    void main() {
      vec3 E = texture(light, at).rgb;
      if (mode < 2) { colour = vec4(curve(E * (mode == 0 ? rho : vec3(1.0)) * scale / 3.14159265), 1); return; }
      vec2 texel = at * vec2(textureSize(light, 0));
      float grid = mod(floor(texel.x) + floor(texel.y), 2.0), fine = length(fwidth(texel));
      float shade = (0.55 + 0.45 * clamp(curve(vec3(dot(E, vec3(LUMINANCE_R, LUMINANCE_G, LUMINANCE_B)) * scale / 6.0)).x, 0.0, 1.0))
        * (1.0 - 0.18 * grid * (1.0 - smoothstep(0.5, 1.2, fine)));
      if (mode == 2) {
        float hue = fract(facts.z * 0.618033988749895);
        colour = vec4((0.15 + 0.65 * (0.5 + 0.5 * cos(6.2831853 * (hue + vec3(1, 2, 3) / 3.0)))) * shade * 1.2, 1);
        return;
      }
      float x = mode == 3 ? facts.y : facts.x;
      colour = vec4(viridis(clamp(log(max(x, 1e-20) / range.x) / log(range.y / range.x), 0.0, 1.0)) * shade, 1);
    }`;
  /* Numbers of a .png become irradiance: range (a rgb)^2. */
  const FULL = `#version 300 es
    void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0, 1); }`;
  const DECODE = `#version 300 es
    precision highp float; uniform sampler2D light; uniform float scale; out vec4 colour;
    void main() {
      vec4 x = texelFetch(light, ivec2(gl_FragCoord.xy), 0);
      vec3 y = x.a * x.rgb;
      colour = vec4(scale * y * y, 1);
    }`;

  function program(gl, vertex, fragment, names) {
    const p = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const s = gl.createShader(kind);
      gl.shaderSource(s, source);
      gl.compileShader(s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
      gl.attachShader(p, s);
    }
    names.forEach((name, i) => gl.bindAttribLocation(p, i, name));
    gl.linkProgram(p);
    return p;
  }

  function texture(gl, filter) {
    const t = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, t);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, filter], [gl.TEXTURE_MAG_FILTER, filter],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
    return t;
  }

  /* The picture as a texture of half floats. */
  async function lightOf(gl, png) {
    const image = await createImageBitmap(new Blob([png], { type: 'image/png' }),
      { premultiplyAlpha: 'none', colorSpaceConversion: 'none' });
    const [w, h] = meta.size, raw = texture(gl, gl.NEAREST);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
    const out = texture(gl, gl.LINEAR), frame = gl.createFramebuffer(), p = program(gl, FULL, DECODE, []);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA16F, w, h);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, out, 0);
    gl.viewport(0, 0, w, h);
    gl.bindTexture(gl.TEXTURE_2D, raw);
    gl.useProgram(p);
    gl.uniform1f(gl.getUniformLocation(p, 'scale'), meta.range);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteTexture(raw);
    gl.bindTexture(gl.TEXTURE_2D, out);
    return out;
  }

  /* ---- the camera -------------------------------------------------------- */

  const minus = (a, b) => a.map((x, i) => x - b[i]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = a => a.map(x => x / (Math.hypot(...a) || 1));

  function frameOf(c) {
    const z = unit(minus(c.slice(0, 3), c.slice(3, 6))), x = unit(cross(c.slice(6, 9), z));
    return [x, cross(z, x), z];
  }

  /* Column by column. */
  function matrixOf(aspect) {
    const c = state.camera, [x, y, z] = frameOf(c), f = 1 / Math.tan(c[9] * Math.PI / 360), from = c.slice(0, 3);
    const near = 0.002 * meta.extent, far = 4 * meta.extent + Math.hypot(...minus(from, c.slice(3, 6)));
    const a = (far + near) / (near - far), b = 2 * far * near / (near - far), m = [];
    for (let k = 0; k < 3; k++) m.push(f / aspect * x[k], f * y[k], a * z[k], -z[k]);
    return m.concat(-f / aspect * dot(x, from), -f * dot(y, from), -a * dot(z, from) + b, dot(z, from));
  }

  function turn(dx, dy) {
    const c = state.camera, [x, , z] = frameOf(c), up = c.slice(6, 9), distance = Math.hypot(...minus(c.slice(0, 3), c.slice(3, 6)));
    const spin = (v, axis, angle) => {
      const k = dot(axis, v) * (1 - Math.cos(angle)), w = cross(axis, v);
      return v.map((e, i) => e * Math.cos(angle) + w[i] * Math.sin(angle) + axis[i] * k);
    };
    const tilted = spin(z, x, -dy);
    const next = spin(Math.abs(dot(unit(tilted), up)) < 0.98 ? tilted : z, up, -dx);
    for (let k = 0; k < 3; k++) c[k] = c[3 + k] + distance * next[k];
  }

  function shift(dx, dy) {
    const c = state.camera, [x, y] = frameOf(c);
    const step = 2 * Math.tan(c[9] * Math.PI / 360) * Math.hypot(...minus(c.slice(0, 3), c.slice(3, 6)));
    for (let k = 0; k < 3; k++) {
      const d = step * (y[k] * dy - x[k] * dx);
      c[k] += d;
      c[3 + k] += d;
    }
  }

  function nearer(factor) {
    const c = state.camera;
    for (let k = 0; k < 3; k++) c[k] = c[3 + k] + factor * (c[k] - c[3 + k]);
  }

  /* ---- drawing ----------------------------------------------------------- */

  const canvas = $('canvas');
  let draw = () => {}, asked = false;
  function change() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  }

  function legend() {
    const of = { density: ['texels a scene unit', meta.density], error: ['error of charts, relative', meta.errors] }[MODES[state.mode][0]];
    $('legend').hidden = !of;
    if (!of) return;
    const ramp = [];
    for (let i = 0; i < 9; i++) ramp.push(`rgb(${meta.palette[Math.round(i / 8 * (meta.palette.length - 1))].map(x => Math.round(255 * x))})`);
    $('legend').innerHTML = `<div></div><div class="ramp" style="background:linear-gradient(to right,${ramp})"></div>
      <div class="ends"><span>${of[1][0].toPrecision(2)}</span><span>${of[1][1].toPrecision(2)}</span></div>`;
    $('legend').firstChild.textContent = of[0];
  }

  function show() {
    [...$('bar').children].forEach((b, i) => b.classList.toggle('on', i === state.mode));
    legend();
    $('note').textContent = `${meta.words}  ·  exposure ${state.exposure.toFixed(1)} (+ -)`;
    change();
  }

  function obey() {
    const words = new URLSearchParams(location.hash.slice(1)), mode = MODES.findIndex(m => m[0] === words.get('mode'));
    if (mode >= 0) state.mode = mode;
    if (words.has('ev')) state.exposure = Number(words.get('ev'));
    for (const [name, at] of [['from', 0], ['at', 3]])
      if (words.has(name)) words.get(name).split(',').forEach((x, k) => { state.camera[at + k] = Number(x) - meta.lowest[k]; });
    if (words.has('fov')) state.camera[9] = Number(words.get('fov'));
    document.body.classList.toggle('bare', words.has('bare'));
    show();
  }

  function listen() {
    const pointers = new Map();
    canvas.addEventListener('pointerdown', e => {
      canvas.setPointerCapture(e.pointerId);
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
    });
    canvas.addEventListener('pointermove', e => {
      const before = pointers.get(e.pointerId);
      if (!before) return;
      const dx = (e.clientX - before[0]) / canvas.clientHeight, dy = (e.clientY - before[1]) / canvas.clientHeight;
      if (e.buttons & 2 || pointers.size > 1) shift(dx / pointers.size, dy / pointers.size);
      else turn(4 * dx, 4 * dy);
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
      change();
    });
    for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, e => pointers.delete(e.pointerId));
    canvas.addEventListener('contextmenu', e => e.preventDefault());
    canvas.addEventListener('wheel', e => {
      e.preventDefault();
      nearer(Math.exp(0.001 * e.deltaY));
      change();
    }, { passive: false });
    addEventListener('keydown', e => {
      const mode = MODES.findIndex(m => m[1] === e.key);
      if (mode >= 0) state.mode = mode;
      else if (e.key === '+' || e.key === '=') state.exposure += 0.5;
      else if (e.key === '-') state.exposure -= 0.5;
      else if (e.key === 'Home') state.camera = meta.camera.slice();
      else return;
      show();
    });
    addEventListener('resize', change);
    addEventListener('hashchange', obey);
    MODES.forEach((m, i) => {
      const b = document.createElement('button');
      b.textContent = `${m[2]} ${m[1]}`;
      b.onclick = () => { state.mode = i; show(); };
      $('bar').append(b);
    });
  }

  async function start() {
    const gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!gl || !gl.getExtension('EXT_color_buffer_float') && !gl.getExtension('EXT_color_buffer_half_float'))
      throw new Error('this browser has no WebGL 2 with pictures of half floats');
    const s = await readSections(), names = ['position', 'uv', 'albedo', 'chart', 'number'], charts = chartsOf(s);
    const facts = new Float32Array(2 * charts.length), numbers = new Float32Array(charts);
    charts.forEach((chart, i) => { if (chart) facts.set([s.errors[chart - 1], s.densities[chart - 1]], 2 * i); });
    await lightOf(gl, s.picture);
    const p = program(gl, VERTEX, FRAGMENT, names), of = name => gl.getUniformLocation(p, name);
    if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
    [[s.positions, 3, gl.FLOAT], [s.uvs, 2, gl.FLOAT], [s.albedo, 3, gl.UNSIGNED_SHORT], [facts, 2, gl.FLOAT], [numbers, 1, gl.FLOAT]]
      .forEach(([array, size, type], i) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
        gl.enableVertexAttribArray(i);
        gl.vertexAttribPointer(i, size, type, type !== gl.FLOAT, 0, 0);
      });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, s.triangles, gl.STATIC_DRAW);
    gl.useProgram(p);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    draw = () => {
      const w = canvas.clientWidth * devicePixelRatio, h = canvas.clientHeight * devicePixelRatio;
      if (canvas.width !== w || canvas.height !== h) canvas.width = w, canvas.height = h;
      gl.viewport(0, 0, w, h);
      gl.clearColor(...meta.background, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix4fv(of('matrix'), false, matrixOf(w / h));
      gl.uniform1i(of('mode'), state.mode);
      gl.uniform1f(of('scale'), 2 ** state.exposure);
      gl.uniform2fv(of('range'), state.mode === 3 ? meta.density : meta.errors);
      gl.drawElements(gl.TRIANGLES, s.triangles.length, gl.UNSIGNED_INT, 0);
      root.dataset.state = 'ready';
    };
    canvas.style.visibility = 'visible';
    $('note').className = '';
    listen();
    obey();
  }

  start().catch(e => fail(String(e.message || e)));
})();
